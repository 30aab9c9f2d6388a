/* SPDX-License-Identifier: Apache-2.0 */
/* The payload of silmaps: rules 8201 to 8207, decoding and encoding (spec/silmap.md section 2). */
#include "silmap_payload.h"

enum { HEADER_SIZE = 24, RESERVED = 7, MOST_CELLS = 1 << 20, MOST_LAYERS = 1 << 16 };

/* ---- memory ------------------------------------------------------------------------------------ */

static uint64_t cells_in(const zt__silmap_header *h) {
    return (uint64_t)h->cells_x * h->cells_y * h->cell_layers;
}

zt_result zt__silmap_new(zt__memory *memory, const zt__silmap_header *header, const zt__payload_scope *scope,
                         zt_diag *diag, zt__silmap **out) {
    uint64_t samples = zt__align16(sizeof(zt__silmap));
    uint64_t minified = samples + (uint64_t)header->layer_count * 4;
    uint64_t cells = zt__align16(minified + (uint64_t)header->layer_count * 4);
    uint64_t size = cells + cells_in(header); /* below 2^33: R8201 */
    size_t bytes;
    void *block;
    *out = NULL;
    if (!zt__to_size(size, &bytes))
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "the silmap is too large");
    ZT_TRY(zt__alloc_raw(memory, 1, bytes, diag, &block));
    char *base = block;
    zt__silmap *s = block;
    *s = (zt__silmap){.header = *header,
                      .repeat_x = scope->wrap_u == ZT_WRAP_REPEAT,
                      .repeat_y = scope->wrap_v == ZT_WRAP_REPEAT,
                      .cell_count = cells_in(header),
                      .block_size = size,
                      .samples = (uint32_t *)(void *)(base + samples),
                      .minified = (uint32_t *)(void *)(base + minified),
                      .cells = (uint8_t *)(base + cells)};
    *out = s;
    return ZT_OK;
}

/* ---- rules on images ----------------------------------------------------------------------------- */

zt_result zt__check_silmap_header(zt__sink *sink, const zt__silmap_header *h, const zt__payload_scope *scope,
                                  uint64_t offset) {
    ZT_RULE(sink, 8201, h->layer_count == scope->layer_count, offset, "%u layers, the texture has %u", h->layer_count,
            scope->layer_count);
    ZT_RULE(sink, 8201, h->cells_x >= 1 && h->cells_x <= MOST_CELLS && h->cells_y >= 1 && h->cells_y <= MOST_CELLS,
            offset, "%u x %u cells", h->cells_x, h->cells_y);
    ZT_RULE(sink, 8201, h->cell_layers >= 1 && h->cell_layers <= MOST_LAYERS, offset, "%u layers of cells",
            h->cell_layers);
    ZT_RULE(sink, 8201, cells_in(h) <= UINT32_MAX, offset, "%u x %u cells in %u layers are too many", h->cells_x,
            h->cells_y, h->cell_layers);
    ZT_RULE(sink, 8202, h->filter <= ZT_SILMAP_NEAREST, offset, "filter %u", h->filter);
    return ZT_OK;
}

static const zt__image_record *record_of(const zt__payload_scope *scope, uint32_t image) {
    return image < scope->image_count ? scope->image_of(scope->user, image) : NULL;
}

/* 8203 and 8204. */
static zt_result check_samples(zt__sink *sink, const zt__silmap *s, const zt__payload_scope *scope, uint64_t offset) {
    uint32_t width = s->header.cells_x + (s->repeat_x ? 0 : 1);
    uint32_t height = s->header.cells_y + (s->repeat_y ? 0 : 1);
    const zt__image_record *first = record_of(scope, s->samples[0]);
    for (uint32_t l = 0; l < s->header.layer_count; l++) {
        const zt__image_record *r = record_of(scope, s->samples[l]);
        if (!r)
            return zt__report(sink, 8203, offset, "layer %u: image %u of %u has the samples", l, s->samples[l],
                              scope->image_count);
        ZT_RULE(sink, 8203, r->levels == 1 && r->depth == 1 && r->layer_kind != ZT_LAYERS_CUBE, offset,
                "layer %u: the samples have several levels, or are a volume or cube map", l);
        ZT_RULE(sink, 8203, r->width == width && r->height == height, offset,
                "layer %u: %u x %u samples, there must be %u x %u for %u x %u cells", l, r->width, r->height, width,
                height, s->header.cells_x, s->header.cells_y);
        ZT_RULE(sink, 8204, r->layers == first->layers, offset, "layer %u: %u array layers of samples, layer 0 has %u",
                l, r->layers, first->layers);
    }
    ZT_RULE(sink, 8204, s->header.cell_layers == 1 || s->header.cell_layers == first->layers, offset,
            "%u layers of cells for %u of samples", s->header.cell_layers, first->layers);
    return ZT_OK;
}

/* 8205. */
static zt_result check_minified(zt__sink *sink, const zt__silmap *s, const zt__payload_scope *scope, uint64_t offset) {
    for (uint32_t l = 0; l < s->header.layer_count; l++) {
        if (s->minified[l] == ZT_NONE)
            continue;
        const zt__image_record *m = record_of(scope, s->minified[l]);
        const zt__image_record *r = record_of(scope, s->samples[l]);
        if (!m)
            return zt__report(sink, 8205, offset, "layer %u: image %u of %u is the minified one", l, s->minified[l],
                              scope->image_count);
        ZT_RULE(sink, 8205, m->width == s->header.cells_x && m->height == s->header.cells_y && m->depth == 1, offset,
                "layer %u: a minified image of %u x %u x %u texels for %u x %u cells", l, m->width, m->height, m->depth,
                s->header.cells_x, s->header.cells_y);
        ZT_RULE(sink, 8205,
                m->format == r->format && m->alpha_mode == r->alpha_mode && m->primaries == r->primaries &&
                    m->transfer == r->transfer && m->layers == r->layers && m->layer_kind == r->layer_kind,
                offset, "layer %u: the minified image has another format, colour or layers than the samples", l);
    }
    return ZT_OK;
}

/* ---- rules on cells -------------------------------------------------------------------------------- */

/* The first cell whose arm leaves the texture and is cut; cell_count: none. */
static uint64_t find_leaving(const zt__silmap *s) {
    uint32_t width = s->header.cells_x;
    uint64_t layer_size = (uint64_t)width * s->header.cells_y;
    for (uint64_t i = 0; i < s->cell_count && !s->repeat_x; i += width) {
        if (s->cells[i] & ZT_SILMAP_WEST)
            return i;
    }
    for (uint64_t i = 0; i < s->cell_count && !s->repeat_y; i += layer_size) {
        for (uint32_t x = 0; x < width; x++) {
            if (s->cells[i + x] & ZT_SILMAP_NORTH)
                return i + x;
        }
    }
    return s->cell_count;
}

typedef struct cell_place {
    uint32_t x, y, layer;
} cell_place;

static cell_place place_of(const zt__silmap *s, uint64_t index) {
    uint64_t layer_size = (uint64_t)s->header.cells_x * s->header.cells_y;
    cell_place p = {(uint32_t)(index % s->header.cells_x), (uint32_t)(index % layer_size / s->header.cells_x),
                    (uint32_t)(index / layer_size)};
    return p;
}

/* 8206: said once, of the first such cell. */
static zt_result check_edges(zt__sink *sink, const zt__silmap *s, uint64_t offset) {
    uint64_t index = find_leaving(s);
    cell_place p = place_of(s, index);
    ZT_RULE(sink, 8206, index == s->cell_count, offset,
            "an arm of cell %u, %u of layer %u is cut and leaves the texture", p.x, p.y, p.layer);
    return ZT_OK;
}

/* Visits the cells that hold a point although none of their arms is cut; the visitor may change them. */
typedef void visit_cell(void *user, uint8_t *cell, uint64_t index);

static void visit_idle_row(const zt__silmap *s, uint64_t first, const uint8_t *below, visit_cell *visit, void *user) {
    uint32_t width = s->header.cells_x;
    uint8_t *row = s->cells + first;
    for (uint32_t x = 0; x < width; x++) {
        uint8_t east = x + 1 < width ? row[x + 1] : s->repeat_x ? row[0] : 0;
        uint8_t south = below ? below[x] : 0;
        if (row[x] != ZT_SILMAP_DEFAULT && !(row[x] & (ZT_SILMAP_WEST | ZT_SILMAP_NORTH)) && !(east & ZT_SILMAP_WEST) &&
            !(south & ZT_SILMAP_NORTH))
            visit(user, &row[x], first + x);
    }
}

static void visit_idle(const zt__silmap *s, visit_cell *visit, void *user) {
    uint32_t width = s->header.cells_x, height = s->header.cells_y;
    for (uint64_t first = 0, y = 0; first < s->cell_count; first += width, y = y + 1 < height ? y + 1 : 0) {
        const uint8_t *row = s->cells + first;
        const uint8_t *top = row - y * width;
        visit_idle_row(s, first, y + 1 < height ? row + width : s->repeat_y ? top : NULL, visit, user);
    }
}

typedef struct idle_cells {
    uint64_t count, first;
} idle_cells;

static void count_cell(void *user, uint8_t *cell, uint64_t index) {
    idle_cells *idle = user;
    (void)cell;
    if (idle->count++ == 0)
        idle->first = index;
}

static void tidy_cell(void *user, uint8_t *cell, uint64_t index) {
    (void)user;
    (void)index;
    *cell = ZT_SILMAP_DEFAULT;
}

void zt__tidy_silmap(zt__silmap *silmap) {
    visit_idle(silmap, tidy_cell, NULL);
}

/* 8207: one finding however many they are; a loader does not look, since it goes on in any case. */
static zt_result check_points(zt__sink *sink, const zt__silmap *s, uint64_t offset) {
    idle_cells idle = {0, 0};
    if (!sink->check)
        return ZT_OK;
    visit_idle(s, count_cell, &idle);
    cell_place p = place_of(s, idle.first);
    ZT_RULE(sink, 8207, idle.count == 0, offset,
            "%llu cells without a cut arm have another point than the default; the first is %u, %u of layer %u",
            (unsigned long long)idle.count, p.x, p.y, p.layer);
    return ZT_OK;
}

zt_result zt__check_silmap(zt__sink *sink, const zt__silmap *silmap, const zt__payload_scope *scope, uint64_t offset) {
    ZT_TRY(check_samples(sink, silmap, scope, offset));
    ZT_TRY(check_minified(sink, silmap, scope, offset));
    ZT_TRY(check_edges(sink, silmap, offset));
    return check_points(sink, silmap, offset);
}

/* ---- decoding ------------------------------------------------------------------------------------ */

static zt_result read_header(zt__sink *sink, zt__cursor *in, const zt__payload_scope *scope, uint64_t offset,
                             zt__silmap_header *h) {
    bool reserved_ok = true;
    zt__coder coder = zt__reading(in);
    zt__code_u32(&coder, &h->cells_x);
    zt__code_u32(&coder, &h->cells_y);
    zt__code_u32(&coder, &h->cell_layers);
    zt__code_u32(&coder, &h->layer_count);
    h->filter = zt__take8(in);
    for (int i = 0; i < RESERVED; i++)
        reserved_ok = zt__take8(in) == 0 && reserved_ok;
    ZT_RULE(sink, 8201, !in->bad, offset, "the chunk is smaller than its header");
    ZT_RULE(sink, 8201, reserved_ok, offset + 17, "a reserved byte is not zero");
    return zt__check_silmap_header(sink, h, scope, offset);
}

static zt_result read_planes(zt__sink *sink, zt__decoder *decoder, zt__cursor *in, uint64_t offset, zt__silmap *s) {
    ZT_TRY(zt__decode_plane(sink, decoder, in, offset, 1, (uint32_t)s->cell_count, s->cells));
    ZT_TRY(zt__decode_plane(sink, decoder, in, offset, 4, s->header.layer_count, s->samples));
    ZT_TRY(zt__decode_plane(sink, decoder, in, offset, 4, s->header.layer_count, s->minified));
    ZT_RULE(sink, 5106, zt__left(in) == 0, offset + in->at, "%zu bytes behind the last plane", zt__left(in));
    return ZT_OK;
}

zt_result zt__decode_silmap(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const uint8_t *data, size_t size,
                            const zt__payload_scope *scope, uint64_t offset, zt__silmap **out) {
    zt__cursor in = zt__cursor_of(data, size);
    zt__silmap_header header = {0};
    zt__silmap *s;
    *out = NULL;
    zt__enter(sink, "SLMP/texture %u", scope->texture);
    ZT_TRY(read_header(sink, &in, scope, offset, &header));
    ZT_TRY(zt__silmap_new(memory, &header, scope, sink->diag, &s));
    zt_result result = read_planes(sink, decoder, &in, offset, s);
    if (result == ZT_OK)
        result = zt__check_silmap(sink, s, scope, offset);
    if (result != ZT_OK) {
        zt__free(memory, s, 1, (size_t)s->block_size);
        return result;
    }
    *out = s;
    return ZT_OK;
}

/* ---- encoding ------------------------------------------------------------------------------------- */

static zt_result write_planes(zt__plane_writer *w, const zt__silmap *s) {
    zt__silmap_header h = s->header;
    zt__coder coder = zt__writing(w->out);
    zt__code_u32(&coder, &h.cells_x);
    zt__code_u32(&coder, &h.cells_y);
    zt__code_u32(&coder, &h.cell_layers);
    zt__code_u32(&coder, &h.layer_count);
    *coder.out = h.filter;
    memset(coder.out + 1, 0, RESERVED);
    ZT_TRY(zt__planes_put(w, 1, (uint32_t)s->cell_count, s->cells));
    ZT_TRY(zt__planes_put(w, 4, h.layer_count, s->samples));
    return zt__planes_put(w, 4, h.layer_count, s->minified);
}

zt_result zt__encode_silmap(zt__encoder *encoder, const zt__silmap *silmap, zt_diag *diag, uint8_t **out,
                            uint64_t *out_capacity, size_t *out_size) {
    zt__plane_writer w;
    uint64_t layer_bytes = (uint64_t)silmap->header.layer_count * 4;
    uint64_t largest = silmap->cell_count > layer_bytes ? silmap->cell_count : layer_bytes;
    uint64_t capacity = HEADER_SIZE + (uint64_t)zt__plane_bound(1, (uint32_t)silmap->cell_count) +
                        2 * (uint64_t)zt__plane_bound(4, silmap->header.layer_count);
    zt_result result = zt__planes_begin(&w, encoder, HEADER_SIZE, capacity, largest, diag);
    if (result == ZT_OK)
        result = write_planes(&w, silmap);
    return zt__planes_end(&w, result, out, out_capacity, out_size);
}
