/* SPDX-License-Identifier: Apache-2.0 */
/* The bytes of umbrellas: one table of planes, which decoder and encoder both walk (spec/umbrella.md section 2). */
#include "umbrella_payload.h"

/* ---- the header ---------------------------------------------------------------------------------- */

static void code_float(zt__coder *coder, float *f) {
    uint32_t bits = zt__bits_of_float(*f);
    zt__code_u32(coder, &bits);
    *f = zt__float_of_bits(bits);
}

static void code_header(zt__coder *coder, zt__umbrella_header *h) {
    zt__code_u32(coder, &h->grid_x);
    zt__code_u32(coder, &h->grid_y);
    zt__code_u32(coder, &h->level_count);
    zt__code_u32(coder, &h->base_count);
    zt__code_u32(coder, &h->umbrella_count);
    zt__code_u32(coder, &h->base_vertex_count);
    zt__code_u32(coder, &h->morph_vertex_count);
    zt__code_u32(coder, &h->variant_colour_count);
    zt__code_u32(coder, &h->explicit_vertex_count);
    zt__code_u32(coder, &h->entry_count);
    zt__code_u32(coder, &h->longest_list);
    zt__code_u8(coder, &h->colour_mode);
    zt__code_u8(coder, &h->background_kind);
    zt__code_u8(coder, &h->reserved0[0]);
    zt__code_u8(coder, &h->reserved0[1]);
    zt__code_u32(coder, &h->background_source);
    for (int k = 0; k < 4; k++)
        code_float(coder, &h->background[k]);
    for (int k = 0; k < 4; k++)
        code_float(coder, &h->mean[k]);
    code_float(coder, &h->prism_height);
    code_float(coder, &h->taper_start);
    code_float(coder, &h->taper_end);
    zt__code_u32(coder, &h->layer_count);
    zt__code_u32(coder, &h->reserved1);
}

/* ---- the planes ------------------------------------------------------------------------------------ */

typedef enum array_name {
    LEVELS,
    BASES,
    BASE_VERTICES,
    MORPH_VERTICES,
    VARIANTS,
    UMBRELLAS,
    EXPLICIT,
    COLOURS,
    SIZES, /* list_starts behind the first, while lists are sizes */
    ENTRIES
} array_name;

typedef enum step {
    PLAIN,
    SIGNED,  /* the sign bit is turned: values are stored plus half their range */
    MORPH,   /* first_morph: 0 for ZT_NONE, else first_morph + 1 (read: 0, and more where the byte is wrong) */
    FORM,    /* mirrored in bit 2 */
    OFFSETS, /* SIGNED for umbrellas of form 1, PLAIN for form 2 */
    SIZE,    /* written from starts, read as it is */
    ENTRY,   /* with SHIFT behind it */
    SHIFT
} step;

/* A plane: which field of which array it is, and how many bytes in the file and in memory. */
typedef struct plane {
    array_name array;
    uint32_t element, field;
    size_t at;
    step step;
} plane;

#define FIELD(type, name) sizeof(((const type *)0)->name), offsetof(type, name)

static const plane planes[] = {
    {LEVELS, 4, FIELD(zt_umbrella_level, umbrella_count), PLAIN},
    {LEVELS, 1, FIELD(zt_umbrella_level, bits), PLAIN},
    {BASES, 1, FIELD(zt_umbrella_base, shows_texture), PLAIN},
    {BASES, 4, FIELD(zt_umbrella_base, source), PLAIN},
    {BASES, 4, FIELD(zt_umbrella_base, aspect), PLAIN},
    {BASES, 2, FIELD(zt_umbrella_base, vertex_count), PLAIN},
    {BASES, 1, FIELD(zt_umbrella_base, first_morph), MORPH},
    {BASES, 1, FIELD(zt_umbrella_base, variant_count), PLAIN},
    {BASES, 2, FIELD(zt_umbrella_base, centre.x), PLAIN},
    {BASES, 2, FIELD(zt_umbrella_base, centre.y), PLAIN},
    {BASES, 1, FIELD(zt_umbrella_base, ellipsoid), PLAIN},
    {BASES, 2, FIELD(zt_umbrella_base, height), PLAIN},
    {BASES, 2, FIELD(zt_umbrella_base, curvature), PLAIN},
    {BASE_VERTICES, 2, FIELD(zt_umbrella_texel, x), PLAIN},
    {BASE_VERTICES, 2, FIELD(zt_umbrella_texel, y), PLAIN},
    {MORPH_VERTICES, 2, FIELD(zt_umbrella_texel, x), PLAIN},
    {MORPH_VERTICES, 2, FIELD(zt_umbrella_texel, y), PLAIN},
    {VARIANTS, 1, FIELD(zt_umbrella_colour, r), SIGNED},
    {VARIANTS, 1, FIELD(zt_umbrella_colour, g), SIGNED},
    {VARIANTS, 1, FIELD(zt_umbrella_colour, b), SIGNED},
    {UMBRELLAS, 1, FIELD(zt_umbrella, form), FORM},
    {UMBRELLAS, 2, FIELD(zt_umbrella, base), PLAIN},
    {UMBRELLAS, 4, FIELD(zt_umbrella, x), SIGNED},
    {UMBRELLAS, 4, FIELD(zt_umbrella, y), SIGNED},
    {UMBRELLAS, 4, FIELD(zt_umbrella, a), SIGNED},
    {UMBRELLAS, 4, FIELD(zt_umbrella, b), SIGNED},
    {UMBRELLAS, 1, FIELD(zt_umbrella, morph), PLAIN},
    {UMBRELLAS, 1, FIELD(zt_umbrella, variant_0), PLAIN},
    {UMBRELLAS, 1, FIELD(zt_umbrella, variant_1), PLAIN},
    {UMBRELLAS, 1, FIELD(zt_umbrella, variant_weight), PLAIN},
    {UMBRELLAS, 1, FIELD(zt_umbrella, strength), PLAIN},
    {UMBRELLAS, 1, FIELD(zt_umbrella, ellipsoid), PLAIN},
    {UMBRELLAS, 2, FIELD(zt_umbrella, height), PLAIN},
    {UMBRELLAS, 2, FIELD(zt_umbrella, curvature), PLAIN},
    {UMBRELLAS, 2, FIELD(zt_umbrella, lift), PLAIN},
    {UMBRELLAS, 2, FIELD(zt_umbrella, vertex_count), PLAIN},
    /* zt__link_umbrellas comes here: it gives the number of colours. */
    {EXPLICIT, 4, FIELD(zt_umbrella_offset, x), SIGNED},
    {EXPLICIT, 4, FIELD(zt_umbrella_offset, y), SIGNED},
    {COLOURS, 1, FIELD(zt_umbrella_colour, r), OFFSETS},
    {COLOURS, 1, FIELD(zt_umbrella_colour, g), OFFSETS},
    {COLOURS, 1, FIELD(zt_umbrella_colour, b), OFFSETS},
    {SIZES, 4, 4, sizeof(uint32_t), SIZE},
    {ENTRIES, 4, 4, 0, ENTRY},
    {ENTRIES, 1, 4, 0, SHIFT},
};

enum { PLANE_COUNT = sizeof planes / sizeof planes[0], COUNT_IN_HEADER = 16 };

typedef struct array {
    void *first;
    size_t stride;
    uint32_t count;
} array;

static array array_of(const zt__umbrellas *u, array_name name) {
    const zt__umbrella_header *h = &u->header;
    switch (name) {
    case LEVELS:
        return (array){u->levels, sizeof *u->levels, h->level_count};
    case BASES:
        return (array){u->bases, sizeof *u->bases, h->base_count};
    case BASE_VERTICES:
        return (array){u->base_vertices, sizeof *u->base_vertices, h->base_vertex_count};
    case MORPH_VERTICES:
        return (array){u->morph_vertices, sizeof *u->morph_vertices, h->morph_vertex_count};
    case VARIANTS:
        return (array){u->variant_colours, sizeof *u->variant_colours, h->variant_colour_count};
    case UMBRELLAS:
        return (array){u->umbrellas, sizeof *u->umbrellas, h->umbrella_count};
    case EXPLICIT:
        return (array){u->explicit_vertices, sizeof *u->explicit_vertices, h->explicit_vertex_count};
    case COLOURS:
        return (array){u->explicit_colours, sizeof *u->explicit_colours, u->view.explicit_colour_count};
    case SIZES:
        return (array){u->list_starts, sizeof *u->list_starts, u->view.cell_count};
    default:
        return (array){u->entries, sizeof *u->entries, h->entry_count};
    }
}

/* Elements of a plane, from or to the table's fields: 1, 2 or 4 bytes of the machine's order. */
static uint32_t load(const void *p, uint32_t size) {
    uint8_t one;
    uint16_t two;
    uint32_t four;
    switch (size) {
    case 1:
        memcpy(&one, p, 1);
        return one;
    case 2:
        memcpy(&two, p, 2);
        return two;
    default:
        memcpy(&four, p, 4);
        return four;
    }
}

static void store(void *p, uint32_t size, uint32_t v) {
    uint8_t one = (uint8_t)v;
    uint16_t two = (uint16_t)v;
    switch (size) {
    case 1:
        memcpy(p, &one, 1);
        break;
    case 2:
        memcpy(p, &two, 2);
        break;
    default:
        memcpy(p, &v, 4);
        break;
    }
}

/* Turns the sign bits of the colours of form 1, in a column of bytes. */
static void turn_offsets(const zt__umbrellas *u, uint8_t *column) {
    for (uint32_t i = 0; i < u->header.umbrella_count; i++) {
        const zt_umbrella *m = &u->umbrellas[i];
        if (m->form != ZT_UMBRELLA_EXPLICIT)
            continue;
        for (uint32_t k = 0; k <= m->vertex_count; k++)
            column[m->first_colour + k] ^= 0x80;
    }
}

/* ---- decoding ------------------------------------------------------------------------------------ */

static uint32_t sign_of(const plane *p) {
    return p->step == SIGNED ? UINT32_C(1) << (8 * p->element - 1) : 0;
}

/* A plane whose elements are those of its array: it needs no column. */
static bool is_direct(const plane *p, const array *a) {
    return p->element == a->stride;
}

/* A column of elements to the fields of an array. */
static void scatter(const zt__umbrellas *u, const plane *p, const array *a, const void *column) {
    uint8_t *to = (uint8_t *)a->first + p->at;
    const uint8_t *from = column;
    uint32_t sign = sign_of(p), less = p->step == MORPH;
    for (uint32_t i = 0; i < a->count; i++, to += a->stride, from += p->element)
        store(to, p->field, (load(from, p->element) ^ sign) - less);
    for (uint32_t i = 0; i < a->count && p->step == FORM; i++) {
        u->umbrellas[i].mirrored = u->umbrellas[i].form >> 2;
        u->umbrellas[i].form &= 3;
    }
}

/* The shifts join the numbers of umbrellas. 8315 for numbers that leave them no room. */
static zt_result add_shifts(zt__sink *sink, const zt__umbrellas *u, const uint8_t *column, uint64_t offset) {
    for (uint32_t i = 0; i < u->header.entry_count; i++) {
        uint32_t umbrella = u->entries[i];
        u->entries[i] = (umbrella & ZT_UMBRELLA_ENTRY) | (uint32_t)column[i] << ZT_UMBRELLA_SHIFT;
        ZT_RULE(sink, 8315, umbrella <= ZT_UMBRELLA_ENTRY, offset,
                "entry %u of all lists is umbrella %u: no level has so many", i, umbrella);
    }
    return ZT_OK;
}

/* What reading has at hand; column has the bytes of the largest plane that is not direct. */
typedef struct reading {
    zt__sink *sink;
    zt__decoder *decoder;
    zt__cursor in;
    const zt__payload_scope *scope;
    uint64_t offset;
    void *column;
    uint64_t column_size;
} reading;

static zt_result read_plane(reading *r, const zt__umbrellas *u, const plane *p) {
    array a = array_of(u, p->array);
    bool direct = is_direct(p, &a);
    void *to = direct ? (uint8_t *)a.first + p->at : r->column;
    ZT_TRY(zt__decode_plane(r->sink, r->decoder, &r->in, r->offset, p->element, a.count, to));
    if (direct)
        return ZT_OK;
    if (p->step == SHIFT)
        return add_shifts(r->sink, u, r->column, r->offset);
    if (p->step == OFFSETS)
        turn_offsets(u, r->column);
    scatter(u, p, &a, r->column);
    return ZT_OK;
}

/* Counts that the planes do not have, before memory is asked for. How many colours there are is known later. */
static zt_result check_counts(const reading *r, const zt__umbrella_header *h) {
    zt__umbrellas sizes = {.header = *h};
    zt__cursor in = r->in;
    sizes.view.cell_count = zt__count_cells(h);
    for (int i = 0; i < PLANE_COUNT; i++) {
        uint32_t count = array_of(&sizes, planes[i].array).count;
        if (planes[i].array == COLOURS && zt__left(&in) >= ZT__PLANE_HEADER_SIZE)
            count = zt__load32(in.data + in.at + COUNT_IN_HEADER);
        ZT_TRY(zt__skip_plane(r->sink, &in, r->offset, planes[i].element, count));
    }
    return ZT_OK;
}

/* The lists come last and are the largest: what is wrong with the rest is found before. */
static zt_result read_planes(reading *r, zt__umbrellas *u) {
    for (int i = 0; i < PLANE_COUNT; i++) {
        if (planes[i].array == EXPLICIT && planes[i - 1].array != EXPLICIT)
            ZT_TRY(zt__link_umbrellas(r->sink, u, r->scope, r->offset));
        ZT_TRY(read_plane(r, u, &planes[i]));
    }
    ZT_RULE(r->sink, 5106, zt__left(&r->in) == 0, r->offset + r->in.at, "%zu bytes behind the last plane",
            zt__left(&r->in));
    ZT_TRY(zt__link_lists(r->sink, u, r->scope, r->offset));
    return zt__check_umbrellas(r->sink, u, r->scope, r->offset);
}

/* Elements of all planes but the colours, of which there are at most half as many bytes as explicit_x has. */
static uint64_t largest_column(const zt__umbrellas *u) {
    uint64_t largest = 0;
    for (int i = 0; i < PLANE_COUNT; i++) {
        array a = array_of(u, planes[i].array);
        uint64_t size = (uint64_t)a.count * planes[i].element;
        if (!is_direct(&planes[i], &a) && size > largest)
            largest = size;
    }
    return largest;
}

static zt_result read_all(reading *r, zt__memory *memory, const zt__umbrella_header *h, zt__umbrellas **out) {
    zt__umbrellas *u;
    ZT_TRY(zt__umbrellas_new(memory, h, r->scope, r->sink->diag, &u));
    r->column_size = largest_column(u);
    zt_result result = zt__alloc_raw(memory, r->column_size, 1, r->sink->diag, &r->column);
    if (result == ZT_OK)
        result = read_planes(r, u);
    zt__free(memory, r->column, r->column_size, 1);
    if (result != ZT_OK) {
        zt__free(memory, u, 1, (size_t)u->block_size);
        return result;
    }
    *out = u;
    return ZT_OK;
}

zt_result zt__decode_umbrellas(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const zt_limits *limits,
                               const uint8_t *data, size_t size, const zt__payload_scope *scope, uint64_t offset,
                               zt__umbrellas **out) {
    reading r = {.sink = sink, .decoder = decoder, .in = zt__cursor_of(data, size), .scope = scope, .offset = offset};
    zt__umbrella_header header = {0};
    zt__coder coder = zt__reading(&r.in);
    *out = NULL;
    zt__enter(sink, "UMBR/texture %u", scope->texture);
    code_header(&coder, &header);
    ZT_RULE(sink, 8301, !r.in.bad, offset, "the chunk has %zu bytes, less than its header", size);
    ZT_TRY(zt__check_umbrella_header(sink, &header, scope, offset));
    ZT_TRY(check_counts(&r, &header));
    ZT_TRY(read_all(&r, memory, &header, out));
    if (header.longest_list <= limits->listed_umbrellas)
        return ZT_OK;
    zt__free(memory, *out, 1, (size_t)(*out)->block_size);
    *out = NULL;
    return zt__report(sink, 1013, offset + 40, "a cell lists %u umbrellas, the limit is %u", header.longest_list,
                      limits->listed_umbrellas);
}

/* ---- encoding ------------------------------------------------------------------------------------- */

static uint32_t element_of(const zt__umbrellas *u, const plane *p, const array *a, uint32_t i) {
    const uint32_t *starts = u->list_starts;
    uint32_t v = load((const uint8_t *)a->first + (size_t)i * a->stride + p->at, p->field);
    switch (p->step) {
    case MORPH:
        return v != ZT_NONE;
    case FORM:
        return v | (uint32_t)u->umbrellas[i].mirrored << 2;
    case SIZE:
        return starts[i + 1] - starts[i];
    case ENTRY:
        return v & ZT_UMBRELLA_ENTRY;
    case SHIFT:
        return v >> ZT_UMBRELLA_SHIFT;
    default:
        return v ^ sign_of(p);
    }
}

static zt_result write_plane(zt__plane_writer *w, const zt__umbrellas *u, const plane *p, void *column) {
    array a = array_of(u, p->array);
    uint8_t *to = column;
    for (uint32_t i = 0; i < a.count; i++, to += p->element)
        store(to, p->element, element_of(u, p, &a, i));
    if (p->step == OFFSETS)
        turn_offsets(u, column);
    return zt__planes_put(w, p->element, a.count, column);
}

static zt_result write_planes(zt__plane_writer *w, const zt__umbrellas *u, void *column) {
    zt__umbrella_header h = u->header;
    zt__coder coder = zt__writing(w->out);
    code_header(&coder, &h);
    for (int i = 0; i < PLANE_COUNT; i++)
        ZT_TRY(write_plane(w, u, &planes[i], column));
    return ZT_OK;
}

zt_result zt__encode_umbrellas(zt__encoder *encoder, const zt__umbrellas *u, zt_diag *diag, uint8_t **out,
                               uint64_t *out_capacity, size_t *out_size) {
    zt__plane_writer w;
    void *column;
    uint64_t largest = 0, capacity = ZT__UMBRELLA_HEADER_SIZE;
    for (int i = 0; i < PLANE_COUNT; i++) {
        uint32_t count = array_of(u, planes[i].array).count;
        uint64_t size = (uint64_t)count * planes[i].element;
        largest = size > largest ? size : largest;
        capacity += zt__plane_bound(planes[i].element, count);
    }
    zt_result result = zt__planes_begin(&w, encoder, ZT__UMBRELLA_HEADER_SIZE, capacity, largest, diag);
    zt_result column_result = zt__alloc_raw(encoder->memory, largest, 1, diag, &column);
    if (result == ZT_OK)
        result = column_result == ZT_OK ? write_planes(&w, u, column) : column_result;
    zt__free(encoder->memory, column, largest, 1);
    return zt__planes_end(&w, result, out, out_capacity, out_size);
}
