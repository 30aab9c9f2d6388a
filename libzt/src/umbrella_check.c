/* SPDX-License-Identifier: Apache-2.0 */
/* Rules 8301 to 8315: umbrellas as loader, validator and writer want them (spec/umbrella.md section 2). */
#include "umbrella_payload.h"

enum {
    MOST_GRID = 8192,
    MOST_BASES = 65536,
    MOST_UMBRELLAS = 1 << 24,
    MOST_ASPECT = 1 << 24,
    MOST_BITS = 16,
    FEWEST_VERTICES = 3,
    MOST_VERTICES = 4096,
    FARTHEST = 1 << 30, /* of centres, similarities and explicit vertices */
    MOST_SHIFT = 8,
    HIGHEST = 65535
};

typedef struct checking {
    zt__sink *sink;
    const zt__umbrellas *u;
    const zt__payload_scope *scope;
    uint64_t offset;
} checking;

/* A writer's findings have no place in a file. */
static uint64_t place(uint64_t offset, uint64_t field) {
    return offset == ZT__NO_OFFSET ? offset : offset + field;
}

/* The sink, with the path at what is broken: called when it is. */
static zt__sink *at_chunk(const checking *c) {
    zt__enter(c->sink, "UMBR/texture %u", c->scope->texture);
    return c->sink;
}

static zt__sink *at_base(const checking *c, uint32_t base) {
    zt__enter(c->sink, "UMBR/texture %u/base %u", c->scope->texture, base);
    return c->sink;
}

static zt__sink *at_umbrella(const checking *c, uint32_t level, uint32_t umbrella) {
    zt__enter(c->sink, "UMBR/texture %u/level %u/umbrella %u", c->scope->texture, level, umbrella);
    return c->sink;
}

static zt__sink *at_cell(const checking *c, uint32_t level, uint32_t x, uint32_t y) {
    zt__enter(c->sink, "UMBR/texture %u/level %u/cell %u,%u", c->scope->texture, level, x, y);
    return c->sink;
}

/* ---- the header: 8301 to 8303 -------------------------------------------------------------------- */

/* A grid of these ranges has 2^26 cells and a third of that in its levels: below 2^27. */
static zt_result check_ranges(zt__sink *sink, const zt__umbrella_header *h, uint64_t offset) {
    ZT_RULE(sink, 8301, h->grid_x >= 1 && h->grid_x <= MOST_GRID && h->grid_y >= 1 && h->grid_y <= MOST_GRID, offset,
            "a grid of %u x %u cells: each edge has 1 to %u", h->grid_x, h->grid_y, MOST_GRID);
    uint32_t levels = 1 + zt__log2(zt__max32(h->grid_x, h->grid_y));
    ZT_RULE(sink, 8301, h->level_count >= 1 && h->level_count <= levels, place(offset, 8),
            "%u levels: a grid of %u x %u cells has 1 to %u", h->level_count, h->grid_x, h->grid_y, levels);
    ZT_RULE(sink, 8301, h->base_count <= MOST_BASES, place(offset, 12), "%u bases: the most are %u", h->base_count,
            MOST_BASES);
    ZT_RULE(sink, 8301, h->umbrella_count <= MOST_UMBRELLAS, place(offset, 16), "%u umbrellas: the most are %u",
            h->umbrella_count, MOST_UMBRELLAS);
    return ZT_OK;
}

/* Finite, not negative, no negative zero: of the bits, so that no sign is lost on the way. */
static bool is_plain(float f) {
    return zt__bits_of_float(f) < UINT32_C(0x7F800000);
}

static zt_result check_numbers(zt__sink *sink, const zt__umbrella_header *h, uint64_t offset) {
    static const char *const channels[4] = {"red", "green", "blue", "alpha"};
    for (uint32_t k = 0; k < 4; k++) {
        ZT_RULE(sink, 8303, is_plain(h->background[k]), place(offset, 52 + 4 * k),
                "the background's %s is not finite, or negative", channels[k]);
        ZT_RULE(sink, 8303, is_plain(h->mean[k]), place(offset, 68 + 4 * k), "the mean's %s is not finite, or negative",
                channels[k]);
    }
    ZT_RULE(sink, 8303, is_plain(h->prism_height), place(offset, 84), "the prism's height is not finite, or negative");
    ZT_RULE(sink, 8303, is_plain(h->taper_start) && is_plain(h->taper_end), place(offset, 88),
            "the taper's ends are not finite, or negative");
    ZT_RULE(sink, 8303, h->taper_start < h->taper_end && h->taper_end <= 0.125F, place(offset, 88),
            "the taper goes from %g to %g: it must rise, and end at 1/8 of a cell for a pixel", (double)h->taper_start,
            (double)h->taper_end);
    return ZT_OK;
}

zt_result zt__check_umbrella_header(zt__sink *sink, const zt__umbrella_header *h, const zt__payload_scope *scope,
                                    uint64_t offset) {
    ZT_RULE(sink, 8301, h->reserved0[0] == 0 && h->reserved0[1] == 0, place(offset, 46), "a reserved byte is not zero");
    ZT_RULE(sink, 8301, h->reserved1 == 0, place(offset, 100), "a reserved field is not zero");
    ZT_RULE(sink, 8301, h->layer_count == 1 && scope->layer_count == 1, place(offset, 96),
            "%u layers, the texture has %u: umbrellas have one", h->layer_count, scope->layer_count);
    ZT_TRY(check_ranges(sink, h, offset));
    ZT_RULE(sink, 8302, h->colour_mode <= ZT_UMBRELLA_INVERSE_DISTANCE, place(offset, 44), "colour mode %u",
            h->colour_mode);
    ZT_RULE(sink, 8302, h->background_kind <= ZT_BACKGROUND_TEXTURE, place(offset, 45), "background kind %u",
            h->background_kind);
    return check_numbers(sink, h, offset);
}

/* ---- order and sums: 8304, 8309, 8311 ------------------------------------------------------------ */

/* The sums have 64 bits. What they add up has 32 bits, times 17 at most, 2^24 times at most. */
static zt_result check_sum(const checking *c, uint64_t sum, uint32_t count, const char *of) {
    ZT_RULE(at_chunk(c), 8304, sum == count, c->offset, "the header has %u %s, the planes %llu", count, of,
            (unsigned long long)sum);
    return ZT_OK;
}

static zt_result link_levels(const checking *c) {
    uint64_t sum = 0;
    for (uint32_t l = 0; l < c->u->header.level_count; l++) {
        zt_umbrella_level *level = &c->u->levels[l];
        ZT_RULE(at_chunk(c), 8304, level->bits <= MOST_BITS, c->offset,
                "level %u has vertices with %u bits: the most are %u", l, level->bits, MOST_BITS);
        level->first_umbrella = (uint32_t)sum;
        sum += level->umbrella_count;
    }
    return check_sum(c, sum, c->u->header.umbrella_count, "umbrellas");
}

static zt_result link_bases(const checking *c) {
    const zt__umbrella_header *h = &c->u->header;
    uint64_t vertices = 0, morphs = 0, colours = 0;
    for (uint32_t i = 0; i < h->base_count; i++) {
        zt_umbrella_base *b = &c->u->bases[i];
        ZT_RULE(at_base(c, i), 8306, b->first_morph == 0 || b->first_morph == ZT_NONE, c->offset,
                "base %u: base_morph is %u, it must be 0 or 1", i, b->first_morph + 1);
        b->first_vertex = (uint32_t)vertices;
        b->first_colour = (uint32_t)colours;
        vertices += b->vertex_count;
        colours += (uint64_t)b->variant_count * (1U + b->vertex_count);
        if (b->first_morph != ZT_NONE) {
            b->first_morph = (uint32_t)morphs;
            morphs += b->vertex_count;
        }
    }
    ZT_TRY(check_sum(c, vertices, h->base_vertex_count, "vertices of bases"));
    ZT_TRY(check_sum(c, morphs, h->morph_vertex_count, "vertices of morphs"));
    return check_sum(c, colours, h->variant_colour_count, "colours of variants");
}

static zt_result check_form(const checking *c, uint32_t level, uint32_t i, const zt_umbrella *m) {
    ZT_RULE(at_umbrella(c, level, i), 8309, m->form <= ZT_UMBRELLA_COLOURED, c->offset,
            "umbrella %u of level %u has the form %u: there are 0 to 2", i, level, m->form);
    ZT_RULE(at_umbrella(c, level, i), 8309, m->mirrored <= (m->form == ZT_UMBRELLA_PARAMETRIC), c->offset,
            "umbrella %u of level %u is mirrored by %u: form 0 may be, by 1", i, level, m->mirrored);
    ZT_RULE(at_umbrella(c, level, i), 8309, level == 0 || m->form == ZT_UMBRELLA_COLOURED, c->offset,
            "umbrella %u of level %u has the form %u: above level 0 there is form 2 only", i, level, m->form);
    return ZT_OK;
}

/* A base that is not there is left to rule 8310. */
static zt_result check_vertex_count(const checking *c, uint32_t level, uint32_t i, const zt_umbrella *m) {
    if (m->form == ZT_UMBRELLA_COLOURED) {
        ZT_RULE(at_umbrella(c, level, i), 8311, m->vertex_count >= FEWEST_VERTICES && m->vertex_count <= MOST_VERTICES,
                c->offset, "umbrella %u of level %u has %u vertices: %u to %u are allowed", i, level, m->vertex_count,
                FEWEST_VERTICES, MOST_VERTICES);
        return ZT_OK;
    }
    bool explicit_form = m->form == ZT_UMBRELLA_EXPLICIT;
    if (explicit_form && m->base >= c->u->header.base_count)
        return ZT_OK;
    uint32_t wanted = explicit_form ? c->u->bases[m->base].vertex_count : 0;
    ZT_RULE(at_umbrella(c, level, i), 8311, m->vertex_count == wanted, c->offset,
            "umbrella %u of level %u has %u vertices, it must have %u as %s", i, level, m->vertex_count, wanted,
            explicit_form ? "its base" : "any of form 0");
    return ZT_OK;
}

/* The elements of explicit_colours: what they have room for is explained where it is allocated. */
static zt_result check_colours(const checking *c, uint64_t colours, uint32_t owners) {
    uint32_t vertices = c->u->header.explicit_vertex_count;
    ZT_RULE(at_chunk(c), 8304, owners <= vertices && colours <= UINT32_MAX, c->offset,
            "%u vertices of %u umbrellas: too few, or more than a plane of colours can have", vertices, owners);
    return ZT_OK;
}

static zt_result link_forms(const checking *c, uint32_t *colour_count) {
    uint64_t vertices = 0;
    uint32_t owners = 0;
    for (uint32_t l = 0; l < c->u->header.level_count; l++) {
        const zt_umbrella_level *level = &c->u->levels[l];
        for (uint32_t i = 0; i < level->umbrella_count; i++) {
            zt_umbrella *m = &c->u->umbrellas[level->first_umbrella + i];
            ZT_TRY(check_form(c, l, i, m));
            ZT_TRY(check_vertex_count(c, l, i, m));
            bool owner = zt__has_vertices(m);
            m->first_vertex = owner ? (uint32_t)vertices : 0;
            m->first_colour = owner ? (uint32_t)(vertices + owners) : 0;
            vertices += owner ? m->vertex_count : 0;
            owners += owner;
        }
    }
    ZT_TRY(check_sum(c, vertices, c->u->header.explicit_vertex_count, "vertices of forms 1 and 2"));
    ZT_TRY(check_colours(c, vertices + owners, owners));
    *colour_count = (uint32_t)(vertices + owners);
    return ZT_OK;
}

zt_result zt__link_umbrellas(zt__sink *sink, zt__umbrellas *u, const zt__payload_scope *scope, uint64_t offset) {
    const checking c = {sink, u, scope, offset};
    ZT_TRY(link_levels(&c));
    ZT_TRY(link_bases(&c));
    return link_forms(&c, &u->view.explicit_colour_count);
}

zt_result zt__link_lists(zt__sink *sink, zt__umbrellas *u, const zt__payload_scope *scope, uint64_t offset) {
    const checking c = {sink, u, scope, offset};
    uint32_t longest = 0;
    uint64_t sum = 0;
    u->list_starts[0] = 0;
    for (uint32_t i = 1; i <= u->view.cell_count; i++) {
        longest = zt__max32(longest, u->list_starts[i]);
        sum += u->list_starts[i];
        u->list_starts[i] = (uint32_t)sum;
    }
    ZT_TRY(check_sum(&c, sum, u->header.entry_count, "entries of lists"));
    ZT_RULE(at_chunk(&c), 8304, longest == u->header.longest_list, place(offset, 40),
            "the longest list has %u entries, not %u", longest, u->header.longest_list);
    return ZT_OK;
}

/* ---- pictures: 8305 ------------------------------------------------------------------------------- */

/* What is wrong with a picture, or NULL. */
static const char *source_fault(const zt__payload_scope *scope, bool texture, uint32_t source) {
    if (texture)
        return source < scope->texture ? NULL : "does not come before the umbrellas";
    if (source >= scope->image_count)
        return "is not there";
    const zt__image_record *r = scope->image_of(scope->user, source);
    bool single = r->depth == 1 && r->layers == 1 && r->layer_kind != ZT_LAYERS_CUBE;
    return single ? NULL : "is a volume, a cube map, or has several array layers";
}

static zt_result check_background(const checking *c) {
    const zt__umbrella_header *h = &c->u->header;
    if (h->background_kind == ZT_BACKGROUND_COLOUR) {
        ZT_RULE(at_chunk(c), 8305, h->background_source == ZT_NONE, place(c->offset, 48),
                "the background is a colour, and source %u besides", h->background_source);
        return ZT_OK;
    }
    bool texture = h->background_kind == ZT_BACKGROUND_TEXTURE;
    const char *fault = source_fault(c->scope, texture, h->background_source);
    ZT_RULE(at_chunk(c), 8305, !fault, place(c->offset, 48), "the background: %s %u %s", texture ? "texture" : "image",
            h->background_source, fault);
    return ZT_OK;
}

/* ---- bases: 8305 to 8308 --------------------------------------------------------------------------- */

/* A vertex less the centre. At most 2^30 either way, so that a product of two has 2^60 and a sum of four products 2^62;
 * in bases 2^16. */
typedef struct vector {
    int64_t x, y;
} vector;

static int64_t cross(vector a, vector b) {
    return a.x * b.y - a.y * b.x;
}

/* The vertices of a base, its morph or an umbrella: of texels or offsets one is NULL. */
typedef struct contour {
    const zt_umbrella_texel *texels;
    const zt_umbrella_offset *offsets;
    zt_umbrella_texel centre; /* for texels */
    uint32_t count;
} contour;

static vector vertex_of(const contour *c, uint32_t i) {
    vector v;
    if (c->texels) {
        v.x = (int64_t)c->texels[i].x - c->centre.x;
        v.y = (int64_t)c->texels[i].y - c->centre.y;
    } else {
        v.x = c->offsets[i].x;
        v.y = c->offsets[i].y;
    }
    return v;
}

/* The first vertex whose sector has no positive area, or count. *turns: how often the contour goes around. */
static uint32_t find_fold(const contour *c, uint32_t *turns) {
    vector a = vertex_of(c, 0);
    *turns = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        vector b = vertex_of(c, i + 1 < c->count ? i + 1 : 0);
        if (cross(a, b) <= 0)
            return i;
        *turns += a.y < 0 && b.y >= 0;
        a = b;
    }
    return c->count;
}

/* 8307, and the same for 8308 and 8312. sink has been entered when it is broken. */
static zt_result report_fold(const checking *c, uint32_t rule, const char *what, uint32_t i, const contour *shape,
                             uint32_t fold, uint32_t turns) {
    if (fold == shape->count)
        return zt__report(c->sink, rule, c->offset, "%s %u: its vertices go around the centre %u times, not once", what,
                          i, turns);
    return zt__report(
        c->sink, rule, c->offset,
        "%s %u is not star-shaped: from vertex %u to the next one its contour does not go clockwise around "
        "the centre; move the centre or that vertex",
        what, i, fold);
}

/* No mixture of the two positions folds. */
static uint32_t find_mixed_fold(const contour *d, const contour *e) {
    vector d0 = vertex_of(d, 0), e0 = vertex_of(e, 0);
    for (uint32_t i = 0; i < d->count; i++) {
        uint32_t next = i + 1 < d->count ? i + 1 : 0;
        vector d1 = vertex_of(d, next), e1 = vertex_of(e, next);
        if (cross(d0, e1) + cross(e0, d1) < 0)
            return i;
        d0 = d1;
        e0 = e1;
    }
    return d->count;
}

static zt_result check_base_shape(const checking *c, uint32_t i) {
    const zt_umbrella_base *b = &c->u->bases[i];
    const contour d = {c->u->base_vertices + b->first_vertex, NULL, b->centre, b->vertex_count};
    uint32_t turns;
    uint32_t fold = find_fold(&d, &turns);
    if (fold < d.count || turns != 1) {
        at_base(c, i);
        ZT_TRY(report_fold(c, 8307, "base", i, &d, fold, turns));
    }
    if (b->first_morph == ZT_NONE)
        return ZT_OK;
    const contour e = {c->u->morph_vertices + b->first_morph, NULL, b->centre, b->vertex_count};
    fold = find_fold(&e, &turns);
    if (fold < e.count || turns != 1) {
        at_base(c, i);
        ZT_TRY(report_fold(c, 8308, "the morph of base", i, &e, fold, turns));
    }
    fold = find_mixed_fold(&d, &e);
    ZT_RULE(at_base(c, i), 8308, fold == d.count, c->offset,
            "base %u: between the two positions of vertex %u and the next one its sector folds; the positions are too "
            "far apart",
            i, fold);
    return ZT_OK;
}

static zt_result check_base(const checking *c, uint32_t i) {
    const zt_umbrella_base *b = &c->u->bases[i];
    ZT_RULE(at_base(c, i), 8305, b->shows_texture <= 1, c->offset, "base %u: its source has the kind %u", i,
            b->shows_texture);
    const char *fault = source_fault(c->scope, b->shows_texture == 1, b->source);
    ZT_RULE(at_base(c, i), 8305, !fault, c->offset, "base %u: %s %u %s", i, b->shows_texture ? "texture" : "image",
            b->source, fault);
    ZT_RULE(at_base(c, i), 8306, b->aspect >= 1 && b->aspect <= MOST_ASPECT, c->offset,
            "base %u: the aspect is %u: 1 to %u are allowed", i, b->aspect, MOST_ASPECT);
    ZT_RULE(at_base(c, i), 8306, b->ellipsoid <= ZT_ELLIPSOID_CONCAVE, c->offset, "base %u: ellipsoid %u", i,
            b->ellipsoid);
    ZT_RULE(at_base(c, i), 8306, b->ellipsoid != ZT_ELLIPSOID_FLAT || (b->height == 0 && b->curvature == 0), c->offset,
            "base %u is flat, and has the height %u and curvature %u", i, b->height, b->curvature);
    bool counted = b->vertex_count >= FEWEST_VERTICES && b->vertex_count <= MOST_VERTICES;
    ZT_RULE(at_base(c, i), 8306, counted, c->offset, "base %u has %u vertices: %u to %u are allowed", i,
            b->vertex_count, FEWEST_VERTICES, MOST_VERTICES);
    return counted ? check_base_shape(c, i) : ZT_OK;
}

/* ---- umbrellas: 8310, 8312 to 8314 ------------------------------------------------------------------ */

/* The umbrella that is being checked. */
typedef struct subject {
    const zt_umbrella *m;
    uint32_t level, i; /* number within the level */
} subject;

static zt__sink *at(const checking *c, const subject *s) {
    return at_umbrella(c, s->level, s->i);
}

/* NULL: form 2, and behind a finding. */
static const zt_umbrella_base *base_of(const checking *c, const zt_umbrella *m) {
    bool there = m->form != ZT_UMBRELLA_COLOURED && m->base < c->u->header.base_count;
    return there ? &c->u->bases[m->base] : NULL;
}

static zt_result check_unused(const checking *c, const subject *s) {
    const zt_umbrella *m = s->m;
    ZT_RULE(at(c, s), 8310, m->form == ZT_UMBRELLA_PARAMETRIC || (m->a == 0 && m->b == 0 && m->morph == 0), c->offset,
            "umbrella %u of level %u: a, b and morph must be 0 but for form 0", s->i, s->level);
    ZT_RULE(at(c, s), 8310,
            m->form == ZT_UMBRELLA_PARAMETRIC || (m->variant_0 == 0 && m->variant_1 == 0 && m->variant_weight == 0),
            c->offset, "umbrella %u of level %u: variants must be 0 but for form 0", s->i, s->level);
    ZT_RULE(at(c, s), 8310, m->form != ZT_UMBRELLA_COLOURED || (m->base == 0 && m->strength == 0), c->offset,
            "umbrella %u of level %u: base and strength must be 0 for form 2", s->i, s->level);
    return ZT_OK;
}

static zt_result check_parameters(const checking *c, const subject *s) {
    const zt_umbrella *m = s->m;
    const zt_umbrella_base *b = base_of(c, m);
    ZT_TRY(check_unused(c, s));
    ZT_RULE(at(c, s), 8310, b || m->form == ZT_UMBRELLA_COLOURED, c->offset, "umbrella %u of level %u: base %u of %u",
            s->i, s->level, m->base, c->u->header.base_count);
    if (!b || m->form != ZT_UMBRELLA_PARAMETRIC)
        return ZT_OK;
    uint32_t variants = zt__max32(b->variant_count, 1);
    ZT_RULE(at(c, s), 8310, m->variant_0 < variants && m->variant_1 < variants, c->offset,
            "umbrella %u of level %u: variants %u and %u of %u", s->i, s->level, m->variant_0, m->variant_1,
            b->variant_count);
    ZT_RULE(at(c, s), 8310, m->a != 0 || m->b != 0, c->offset, "umbrella %u of level %u has no size: a and b are 0",
            s->i, s->level);
    ZT_RULE(at(c, s), 8310, m->morph == 0 || b->first_morph != ZT_NONE, c->offset,
            "umbrella %u of level %u: a morph weight, and its base %u has no morph", s->i, s->level, m->base);
    return ZT_OK;
}

static bool is_near(int32_t v) {
    return v >= -FARTHEST && v <= FARTHEST;
}

/* The first explicit vertex that is too far off, or vertex_count. */
static uint32_t find_far(const contour *shape) {
    uint32_t i = 0;
    while (i < shape->count && is_near(shape->offsets[i].x) && is_near(shape->offsets[i].y))
        i++;
    return i;
}

static zt_result check_shape(const checking *c, const subject *s) {
    const contour shape = {NULL, c->u->explicit_vertices + s->m->first_vertex, {0, 0}, s->m->vertex_count};
    uint32_t turns;
    if (!zt__has_vertices(s->m) || shape.count < FEWEST_VERTICES)
        return ZT_OK;
    uint32_t far = find_far(&shape);
    if (far < shape.count)
        return zt__report(at(c, s), 8312, c->offset,
                          "umbrella %u of level %u: vertex %u is more than 2^30 away from the centre", s->i, s->level,
                          far);
    uint32_t fold = find_fold(&shape, &turns);
    if (fold == shape.count && turns == 1)
        return ZT_OK;
    at(c, s);
    return report_fold(c, 8312, "umbrella", s->i, &shape, fold, turns);
}

static bool is_inside(int32_t v, bool repeat, uint32_t cells) {
    return repeat ? v >= 0 && v < (int64_t)cells * 65536 : is_near(v);
}

static zt_result check_place(const checking *c, const subject *s) {
    const zt_umbrella *m = s->m;
    const zt_umbrella_level *level = &c->u->levels[s->level];
    bool inside = is_inside(m->x, c->u->repeat_x, level->width) && is_inside(m->y, c->u->repeat_y, level->height);
    ZT_RULE(
        at(c, s), 8313, inside, c->offset,
        "umbrella %u of level %u: the centre %d, %d is out of range; where a texture repeats it must lie in the grid",
        s->i, s->level, m->x, m->y);
    ZT_RULE(at(c, s), 8313, is_near(m->a) && is_near(m->b), c->offset,
            "umbrella %u of level %u: a and b of %d, %d are out of range", s->i, s->level, m->a, m->b);
    return ZT_OK;
}

static zt_result check_ellipsoid(const checking *c, const subject *s) {
    const zt_umbrella *m = s->m;
    const zt_umbrella_base *b = base_of(c, m);
    bool of_base = m->ellipsoid == ZT_ELLIPSOID_OF_BASE;
    bool known = m->ellipsoid <= ZT_ELLIPSOID_OF_BASE && !(of_base && m->form == ZT_UMBRELLA_COLOURED);
    bool curved = m->ellipsoid == ZT_ELLIPSOID_CONVEX || m->ellipsoid == ZT_ELLIPSOID_CONCAVE;
    uint32_t height = of_base && b ? b->height : m->height;
    ZT_RULE(at(c, s), 8314, known, c->offset, "umbrella %u of level %u has the ellipsoid %u", s->i, s->level,
            m->ellipsoid);
    ZT_RULE(at(c, s), 8314, !known || curved || (m->height == 0 && m->curvature == 0), c->offset,
            "umbrella %u of level %u has a height or curvature and no ellipsoid of its own for them", s->i, s->level);
    ZT_RULE(at(c, s), 8314, m->lift + height <= HIGHEST, c->offset,
            "umbrella %u of level %u leaves the prism: lift %u and height %u are more than %u", s->i, s->level, m->lift,
            height, HIGHEST);
    return ZT_OK;
}

static zt_result check_level(const checking *c, uint32_t level) {
    const zt_umbrella_level *l = &c->u->levels[level];
    for (uint32_t i = 0; i < l->umbrella_count; i++) {
        const subject s = {&c->u->umbrellas[l->first_umbrella + i], level, i};
        ZT_TRY(check_parameters(c, &s));
        ZT_TRY(check_shape(c, &s));
        ZT_TRY(check_place(c, &s));
        ZT_TRY(check_ellipsoid(c, &s));
    }
    return ZT_OK;
}

/* ---- lists: 8315 ----------------------------------------------------------------------------------------- */

/* Shifts that the texture's wrap modes allow: one bit each. */
static uint32_t allowed_shifts(const zt__umbrellas *u) {
    uint32_t shifts = 0;
    for (uint32_t shift = 0; shift <= MOST_SHIFT; shift++) {
        if ((u->repeat_x || shift % 3 == 1) && (u->repeat_y || shift / 3 == 1))
            shifts |= 1U << shift;
    }
    return shifts;
}

/* What is wrong with an entry behind another one (ZT_NONE: it is the first), or NULL. */
static const char *entry_fault(uint32_t before, uint32_t entry, uint32_t umbrellas, uint32_t shifts) {
    uint32_t shift = entry >> ZT_UMBRELLA_SHIFT, umbrella = entry & ZT_UMBRELLA_ENTRY;
    uint32_t last = before & ZT_UMBRELLA_ENTRY, last_shift = before >> ZT_UMBRELLA_SHIFT;
    if (umbrella >= umbrellas)
        return "there is no such umbrella in the level";
    if (shift > MOST_SHIFT || !(shifts >> shift & 1))
        return "there is no such shift, or the texture does not repeat that way";
    if (before != ZT_NONE && (umbrella < last || (umbrella == last && shift <= last_shift)))
        return "umbrellas and shifts must ascend";
    return NULL;
}

/* One finding for a list. */
static zt_result check_list(const checking *c, uint32_t level, uint32_t x, uint32_t y, uint32_t shifts) {
    const zt_umbrella_level *l = &c->u->levels[level];
    const uint32_t *starts = c->u->list_starts + l->first_cell + (size_t)y * l->width + x;
    uint32_t before = ZT_NONE;
    for (uint32_t i = starts[0]; i < starts[1]; i++) {
        uint32_t entry = c->u->entries[i];
        const char *fault = entry_fault(before, entry, l->umbrella_count, shifts);
        if (fault)
            return zt__report(at_cell(c, level, x, y), 8315, c->offset,
                              "cell %u, %u of level %u: entry %u of its list is umbrella %u with shift %u: %s", x, y,
                              level, i - starts[0], entry & ZT_UMBRELLA_ENTRY, entry >> ZT_UMBRELLA_SHIFT, fault);
        before = entry;
    }
    return ZT_OK;
}

static zt_result check_lists(const checking *c, uint32_t level) {
    const zt_umbrella_level *l = &c->u->levels[level];
    uint32_t shifts = allowed_shifts(c->u);
    for (uint32_t y = 0; y < l->height; y++) {
        for (uint32_t x = 0; x < l->width; x++)
            ZT_TRY(check_list(c, level, x, y, shifts));
    }
    return ZT_OK;
}

zt_result zt__check_umbrellas(zt__sink *sink, const zt__umbrellas *umbrellas, const zt__payload_scope *scope,
                              uint64_t offset) {
    const checking c = {sink, umbrellas, scope, offset};
    ZT_TRY(check_background(&c));
    for (uint32_t i = 0; i < umbrellas->header.base_count; i++)
        ZT_TRY(check_base(&c, i));
    for (uint32_t l = 0; l < umbrellas->header.level_count; l++) {
        ZT_TRY(check_level(&c, l));
        ZT_TRY(check_lists(&c, l));
    }
    return ZT_OK;
}
