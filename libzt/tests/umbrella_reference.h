/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups in umbrellas as spec/umbrella.md says them, without haste: what libzt is compared with. */
#ifndef ZT_TESTS_UMBRELLA_REFERENCE_H
#define ZT_TESTS_UMBRELLA_REFERENCE_H

#include "umbrella_stage.h"

typedef struct vec {
    double x, y;
} vec;

typedef struct reference {
    zt_umbrella_info info; /* as the file gives it */
    zt_sampler *pictures[STAGE_UMBRELLAS];
    zt_filter filter;
    zt_wrap wrap_u, wrap_v;
    bool clamp;
    vec light;
    double darkness;
} reference;

/* Derivatives: for one step in x, and one in y. */
typedef struct pixel {
    vec dx, dy;
} pixel;

/* A vector of the base, or of the level for umbrellas without. */
typedef struct star {
    uint32_t count;
    vec *d;         /* vertices less the centre */
    double turn[4]; /* from cells into that space */
} star;

static inline double clamped_to(double v, double low, double high) {
    return fmin(fmax(v, low), high);
}

static inline double cross2(vec a, vec b) {
    return a.x * b.y - a.y * b.x;
}

static inline bool wrap_to(double *u, zt_wrap how) {
    if (how == ZT_WRAP_REPEAT)
        *u -= floor(*u);
    if (how == ZT_WRAP_MIRROR)
        *u = fabs(*u - 2 * floor((*u + 1) / 2));
    if (how == ZT_WRAP_CLAMP)
        *u = clamped_to(*u, 0, 1);
    return *u >= 0 && *u <= 1;
}

static inline vec turned(const double m[4], vec v) {
    vec out = {m[0] * v.x + m[1] * v.y, m[2] * v.x + m[3] * v.y};
    return out;
}

/* In widths of the picture. */
static inline vec base_vertex(const zt_umbrella_base *b, const zt_umbrella_texel *t) {
    vec out = {(t->x - b->centre.x) / 65535.0, (t->y - b->centre.y) / 65535.0 * (b->aspect / 65536.0)};
    return out;
}

static inline star star_of(const zt_umbrella_info *n, uint32_t bits, const zt_umbrella *u) {
    star s = {.count = u->vertex_count, .turn = {1, 0, 0, 1}};
    const zt_umbrella_base *b = u->form == ZT_UMBRELLA_PARAMETRIC ? &n->bases[u->base] : NULL;
    if (b)
        s.count = b->vertex_count;
    s.d = stage_array(s.count, sizeof *s.d);
    for (uint32_t i = 0; i < s.count; i++) {
        if (!b) {
            const zt_umbrella_offset *v = &n->explicit_vertices[u->first_vertex + i];
            s.d[i] = (vec){ldexp(v->x, -(int)bits), ldexp(v->y, -(int)bits)};
            continue;
        }
        vec d = base_vertex(b, &n->base_vertices[b->first_vertex + i]), e = d;
        if (b->first_morph != ZT_NONE)
            e = base_vertex(b, &n->morph_vertices[b->first_morph + i]);
        s.d[i] = (vec){d.x + u->morph / 255.0 * (e.x - d.x), d.y + u->morph / 255.0 * (e.y - d.y)};
    }
    if (b) {
        double p = u->a / 65536.0, q = u->b / 65536.0, square = p * p + q * q;
        double sign = u->mirrored ? -1 : 1;
        double m[4] = {sign * p / square, sign * q / square, -q / square, p / square};
        memcpy(s.turn, m, sizeof m);
    }
    return s;
}

/* Step 1. */
static inline uint32_t sector_of(const star *s, vec q) {
    uint32_t found = 0, times = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        if (cross2(s->d[i], q) >= 0 && cross2(s->d[(i + 1) % s->count], q) < 0) {
            found = i;
            times++;
        }
    }
    CHECK(times == 1 || (q.x == 0 && q.y == 0));
    return found;
}

/* Step 2. */
static inline double covered(vec a, vec b, vec q, const pixel *p) {
    vec along = {b.x - a.x, b.y - a.y};
    double length = hypot(along.x, along.y);
    vec n = {-along.y / length, along.x / length};
    double distance = n.x * (q.x - a.x) + n.y * (q.y - a.y);
    double reach = (fabs(n.x * p->dx.x + n.y * p->dx.y) + fabs(n.x * p->dy.x + n.y * p->dy.y)) / 2;
    if (reach == 0)
        return distance >= 0;
    if (distance < 0)
        distance = fmin(distance, fmax(hypot(a.x, a.y), hypot(b.x, b.y)) - hypot(q.x, q.y));
    return clamped_to((1 + distance / reach) / 2, 0, 1);
}

static inline double channel_of(const zt_umbrella_colour *c, int channel, bool is_signed) {
    uint8_t code = channel == 0 ? c->r : channel == 1 ? c->g : c->b;
    if (!is_signed)
        return (code / 255.0) * (code / 255.0);
    double q = code < 128 ? code : code - 256;
    q = fmax(q, -127);
    return q * fabs(q) / (127.0 * 127.0);
}

/* The colour offset of the centre (0) or a vertex (1 + i). */
static inline double offset_of(const zt_umbrella_info *n, const zt_umbrella *u, uint32_t i, int channel) {
    if (u->form != ZT_UMBRELLA_PARAMETRIC)
        return channel_of(&n->explicit_colours[u->first_colour + i], channel, u->form == ZT_UMBRELLA_EXPLICIT);
    const zt_umbrella_base *b = &n->bases[u->base];
    if (b->variant_count == 0)
        return 0;
    uint32_t size = 1 + b->vertex_count;
    double w = u->variant_weight / 255.0;
    const zt_umbrella_colour *c = n->variant_colours + b->first_colour + i;
    return (1 - w) * channel_of(c + u->variant_0 * size, channel, true) +
           w * channel_of(c + u->variant_1 * size, channel, true);
}

static inline double mean_offset(const zt_umbrella_info *n, const zt_umbrella *u, const star *s, vec q, uint32_t i,
                                 double g, double k, int channel) {
    uint32_t j = (i + 1) % s->count;
    double sum = 0, weights = 0;
    if (n->colour_mode == ZT_UMBRELLA_BARYCENTRIC)
        return (1 - g - k) * offset_of(n, u, 0, channel) + g * offset_of(n, u, 1 + i, channel) +
               k * offset_of(n, u, 1 + j, channel);
    for (uint32_t v = 0; v <= s->count; v++) {
        double distance = v == 0 ? hypot(q.x, q.y) : hypot(q.x - s->d[v - 1].x, q.y - s->d[v - 1].y);
        if (distance == 0)
            return offset_of(n, u, v, channel);
        sum += offset_of(n, u, v, channel) / distance;
        weights += 1 / distance;
    }
    return sum / weights;
}

static inline void look(zt_sampler *sampler, const zt_point *p, double rgba[4]) {
    float out[4];
    zt_diag diag;
    must(zt_sample(sampler, p, 1, out, &diag), &diag);
    for (int c = 0; c < 4; c++)
        rgba[c] = (double)out[c];
}

/* Step 4: the base's vertices in the picture are the first ones. */
static inline void picture_at(const reference *r, const zt_umbrella *u, const star *s, const pixel *p, uint32_t i,
                              double g, double k, double rgba[4]) {
    const zt_umbrella_base *b = &r->info.bases[u->base];
    const zt_umbrella_texel *t = r->info.base_vertices + b->first_vertex;
    uint32_t j = (i + 1) % s->count;
    double area = cross2(s->d[i], s->d[j]);
    vec c = {b->centre.x / 65535.0, b->centre.y / 65535.0};
    vec a = {t[i].x / 65535.0 - c.x, t[i].y / 65535.0 - c.y}, e = {t[j].x / 65535.0 - c.x, t[j].y / 65535.0 - c.y};
    vec steps[2] = {turned(s->turn, p->dx), turned(s->turn, p->dy)}, d[2];
    for (int n = 0; n < 2; n++) {
        double dg = cross2(steps[n], s->d[j]) / area, dk = cross2(s->d[i], steps[n]) / area;
        d[n] = (vec){dg * a.x + dk * e.x, dg * a.y + dk * e.y};
    }
    zt_point point = {.u = c.x + g * a.x + k * e.x,
                      .v = c.y + g * a.y + k * e.y,
                      .du_dx = d[0].x,
                      .dv_dx = d[0].y,
                      .du_dy = d[1].x,
                      .dv_dy = d[1].y};
    look(r->pictures[u->base], &point, rgba);
}

/* Section 3 for Q in cells; `edge` is the pixel of step 2. rgba may be NULL. Returns the coverage. */
static inline double reference_umbrella(const reference *r, uint32_t bits, uint32_t number, vec q, const pixel *edge,
                                        const pixel *picture, double rgba[4]) {
    const zt_umbrella_info *n = &r->info;
    const zt_umbrella *u = &n->umbrellas[number];
    star s = star_of(n, bits, u);
    pixel own = {turned(s.turn, edge->dx), turned(s.turn, edge->dy)};
    q = turned(s.turn, q);
    uint32_t i = sector_of(&s, q), j = (i + 1) % s.count;
    double coverage = covered(s.d[i], s.d[j], q, &own), area = cross2(s.d[i], s.d[j]);
    double g = cross2(q, s.d[j]) / area, k = cross2(s.d[i], q) / area;
    if (rgba && coverage > 0) {
        double f = u->form == ZT_UMBRELLA_COLOURED ? 1 : u->strength / 255.0;
        rgba[0] = rgba[1] = rgba[2] = 0;
        rgba[3] = 1;
        if (u->form != ZT_UMBRELLA_COLOURED)
            picture_at(r, u, &s, picture, i, g, k, rgba);
        for (int c = 0; c < 3; c++)
            rgba[c] = clamped_to(rgba[c] + rgba[3] * f * mean_offset(n, u, &s, q, i, g, k, c), 0, rgba[3]);
    }
    free(s.d);
    return coverage;
}

static inline vec less_centre(const reference *r, const zt_umbrella_level *l, uint32_t entry, vec p) {
    const zt_umbrella *u = &r->info.umbrellas[l->first_umbrella + (entry & ZT_UMBRELLA_ENTRY)];
    int shift = (int)(entry >> ZT_UMBRELLA_SHIFT);
    vec q = {p.x - u->x / 65536.0 - (shift % 3 - 1) * (double)l->width,
             p.y - u->y / 65536.0 - (shift / 3 - 1) * (double)l->height};
    return q;
}

static inline uint32_t reference_list(const reference *r, const zt_umbrella_level *l, vec p, const uint32_t **out) {
    uint32_t x = (uint32_t)fmin(floor(p.x), l->width - 1.0), y = (uint32_t)fmin(floor(p.y), l->height - 1.0);
    const uint32_t *starts = r->info.list_starts + l->first_cell + (size_t)y * l->width + x;
    *out = r->info.entries + starts[0];
    return starts[1] - starts[0];
}

/* Section 4, step 5: S for an entry's number; -1: the background. */
static inline double reference_light(const reference *r, const zt_umbrella_level *l, vec p, const pixel *edge,
                                     long number) {
    vec s = {p.x / l->width + r->light.x / r->info.grid_x, p.y / l->height + r->light.y / r->info.grid_y};
    const uint32_t *list;
    double light = 1;
    if (r->darkness == 0 || !wrap_to(&s.x, r->wrap_u) || !wrap_to(&s.y, r->wrap_v))
        return 1;
    vec moved = {s.x * l->width, s.y * l->height};
    uint32_t count = reference_list(r, l, moved, &list);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t n = list[i] & ZT_UMBRELLA_ENTRY;
        if ((long)n > number)
            light *= 1 - r->darkness * reference_umbrella(r, l->bits, l->first_umbrella + n,
                                                          less_centre(r, l, list[i], moved), edge, edge, NULL);
    }
    return light;
}

static inline void reference_background(const reference *r, const zt_point *p, double rgba[4]) {
    if (r->info.background_kind == ZT_BACKGROUND_IMAGE) {
        look(r->pictures[r->clamp ? STAGE_CLAMPED : STAGE_BELOW], p, rgba);
        return;
    }
    if (r->info.background_kind == ZT_BACKGROUND_TEXTURE) {
        zt_point at = *p;
        wrap_to(&at.u, r->wrap_u);
        wrap_to(&at.v, r->wrap_v);
        look(r->pictures[STAGE_CLAMPED], &at, rgba);
        return;
    }
    for (int c = 0; c < 4; c++)
        rgba[c] = (double)r->info.background[c];
}

static inline void reference_level(const reference *r, uint32_t number, vec s, const zt_point *p, double out[4]) {
    if (number == r->info.level_count) {
        for (int c = 0; c < 4; c++)
            out[c] = (double)r->info.mean[c];
        return;
    }
    const zt_umbrella_level *l = &r->info.levels[number];
    vec at = {s.x * l->width, s.y * l->height};
    pixel picture = {{p->du_dx * l->width, p->dv_dx * l->height}, {p->du_dy * l->width, p->dv_dy * l->height}};
    pixel edge = {{0, 0}, {0, 0}};
    const uint32_t *list;
    uint32_t count = reference_list(r, l, at, &list);
    double rest = 1, rgba[4];
    if (r->filter == ZT_FILTER_TRILINEAR)
        edge = picture;
    memset(out, 0, 4 * sizeof *out);
    while (count-- > 0 && rest >= 0x1p-16) {
        uint32_t n = list[count] & ZT_UMBRELLA_ENTRY;
        double coverage = reference_umbrella(r, l->bits, l->first_umbrella + n, less_centre(r, l, list[count], at),
                                             &edge, &picture, rgba);
        if (coverage == 0)
            continue;
        double light = reference_light(r, l, at, &edge, (long)n);
        for (int c = 0; c < 4; c++)
            out[c] += rest * (c < 3 ? light : 1) * coverage * rgba[c];
        rest *= 1 - coverage * rgba[3];
    }
    if (rest < 0x1p-16)
        return;
    reference_background(r, p, rgba);
    double light = reference_light(r, l, at, &edge, -1);
    for (int c = 0; c < 4; c++)
        out[c] += rest * (c < 3 ? light : 1) * rgba[c];
}

/* Section 4. */
static inline void reference_lookup(const reference *r, const zt_point *p, double out[4]) {
    const zt_umbrella_info *n = &r->info;
    vec s = {p->u, p->v};
    double lower[4], upper[4];
    memset(out, 0, 4 * sizeof *out);
    if (!wrap_to(&s.x, r->wrap_u) || !wrap_to(&s.y, r->wrap_v))
        return;
    double rho = fmax(hypot(p->du_dx * n->grid_x, p->dv_dx * n->grid_y),
                      hypot(p->du_dy * n->grid_x, p->dv_dy * n->grid_y));
    double detail = clamped_to(log2(8 * rho), 0, n->level_count);
    if (r->filter != ZT_FILTER_TRILINEAR)
        detail = floor(detail + 0.5);
    uint32_t whole = (uint32_t)detail;
    reference_level(r, whole, s, p, lower);
    reference_level(r, whole < n->level_count ? whole + 1 : whole, s, p, upper);
    for (int c = 0; c < 4; c++)
        out[c] = lower[c] + (detail - whole) * (upper[c] - lower[c]);
}

/* options as for the sampler of the umbrellas; clamp: as a patch shows them. */
static inline reference reference_open(const zt_file *file, const stage_setup *t, const zt_sampler_options *o,
                                       bool clamp) {
    reference r = {.filter = o->filter,
                   .wrap_u = clamp ? ZT_WRAP_CLAMP : t->wrap_u,
                   .wrap_v = clamp ? ZT_WRAP_CLAMP : t->wrap_v,
                   .clamp = clamp,
                   .light = {o->light_x, o->light_y},
                   .darkness = clamp ? 0 : o->shadow};
    zt_sampler_options plain = {.filter = o->filter, .max_anisotropy = o->max_anisotropy};
    CHECK(zt_get_umbrellas(file, STAGE_UMBRELLAS, &r.info) == ZT_OK);
    for (uint32_t i = 0; i < STAGE_UMBRELLAS; i++)
        r.pictures[i] = stage_sampler(file, i, &plain);
    return r;
}

static inline void reference_close(reference *r) {
    for (uint32_t i = 0; i < STAGE_UMBRELLAS; i++)
        zt_sampler_close(r->pictures[i]);
}

#endif
