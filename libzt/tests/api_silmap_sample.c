/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a lookup in a silmap is what spec/silmap.md section 6 says, for every format, wrap mode, filter and frame:
 * a slow reference made from zt_silmap_weights agrees. And what a picture shows of it: edges slide smoothly under a
 * pixel, a small pixel sees what a point sees, and nothing pops while the picture shrinks.
 */
#include <math.h>

#include "silmap_scene.h"

enum { POINTS = 400, STEPS = 3000 };

/* ---- the reference ---- */

typedef struct colour {
    double c[4];
} colour;

static double clamp(double v, double low, double high) {
    return fmin(fmax(v, low), high);
}

static uint32_t wrap_cell(long i, uint32_t n) {
    long m = i % (long)n;
    return (uint32_t)(m < 0 ? m + (long)n : m);
}

static zt_silmap_cell cell_of(const scene *s, uint32_t frame, long x, long y) {
    const scene_setup *t = &s->setup;
    size_t layer = frame < t->cell_layers ? frame : t->cell_layers - 1;
    zt_silmap_cell cell;
    zt_silmap_cell_at(s->cells + layer * t->cells_x * t->cells_y, t->cells_x, t->cells_y, t->wrap_u == ZT_WRAP_REPEAT,
                      t->wrap_v == ZT_WRAP_REPEAT, wrap_cell(x, t->cells_x), wrap_cell(y, t->cells_y), &cell);
    return cell;
}

static const float *sample_at(const scene *s, uint32_t layer, uint32_t frame, long x, long y) {
    return s->samples[layer] + 4 * (((size_t)frame * s->samples_y + wrap_cell(y, s->samples_y)) * s->samples_x +
                                    wrap_cell(x, s->samples_x));
}

/* The formula of a quadrant of a cell. */
static colour quadrant_colour(const scene *s, zt_silmap_filter filter, uint32_t layer, uint32_t frame, long i, long j,
                              const zt_silmap_cell *cell, int quadrant, double x, double y) {
    double w[4];
    colour out;
    unsigned set = zt_silmap_weights(filter, cell, quadrant, x, y, w);
    for (int c = 0; c < 4; c++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        out.c[c] = 0;
        for (int k = 0; k < 4; k++) {
            double v = (double)sample_at(s, layer, frame, i + (k & 1), j + (k >> 1))[c];
            out.c[c] += w[k] * v;
            if (set >> k & 1) {
                low = fmin(low, v);
                high = fmax(high, v);
            }
        }
        if (set)
            out.c[c] = clamp(out.c[c], low, high);
    }
    return out;
}

typedef struct vec {
    double x, y;
} vec;

/* Distance of p to the right of the way from a to b, over what the box reaches that way; y points down. */
static double side_of(vec a, vec b, vec p, double bx, double by) {
    double length = hypot(b.x - a.x, b.y - a.y);
    vec normal = {(b.y - a.y) / length, -(b.x - a.x) / length};
    double distance = (p.x - a.x) * normal.x + (p.y - a.y) * normal.y;
    double reach = bx * fabs(normal.x) + by * fabs(normal.y);
    return reach > 0 ? distance / reach : distance >= 0 ? HUGE_VAL : -HUGE_VAL;
}

static double half_plane(double d, double e, bool convex) {
    return clamp((1 + (convex ? fmin(d, e) : fmax(d, e))) / 2, 0, 1);
}

static vec point_of(uint8_t cell, double dx, double dy) {
    vec v = {((cell & 7) + 0.5) / 8 + dx, ((cell >> 3 & 7) + 0.5) / 8 + dy};
    return v;
}

static colour part_colour(const scene *s, zt_silmap_filter filter, uint32_t layer, uint32_t frame, long i, long j,
                          vec at, double bx, double by) {
    zt_silmap_cell cell = cell_of(s, frame, i, j);
    vec p = point_of(cell.own, 0, 0), w = point_of(cell.west, -1, 0), n = point_of(cell.north, 0, -1);
    vec e = point_of(cell.east, 1, 0), b = point_of(cell.south, 0, 1);
    double right, below;
    if (bx == 0 && by == 0) {
        int q = zt_silmap_quadrant(&cell, at.x, at.y);
        right = q & 1;
        below = q >> 1;
    } else {
        right = half_plane(side_of(n, p, at, bx, by), side_of(p, b, at, bx, by),
                           (p.x - n.x) * (b.y - p.y) - (p.y - n.y) * (b.x - p.x) <= 0);
        below = half_plane(side_of(p, w, at, bx, by), side_of(e, p, at, bx, by),
                           (p.x - w.x) * (e.y - p.y) - (p.y - w.y) * (e.x - p.x) >= 0);
    }
    colour sum = {{0}};
    for (int q = 0; q < 4; q++) {
        double share = (q & 1 ? right : 1 - right) * (q & 2 ? below : 1 - below);
        colour c = quadrant_colour(s, filter, layer, frame, i, j, &cell, q, at.x, at.y);
        for (int k = 0; k < 4; k++)
            sum.c[k] += share * c.c[k];
    }
    return sum;
}

static bool wrap(double *u, zt_wrap how) {
    if (how == ZT_WRAP_REPEAT)
        *u -= floor(*u);
    if (how == ZT_WRAP_MIRROR)
        *u = fabs(*u - 2 * floor((*u + 1) / 2));
    if (how == ZT_WRAP_CLAMP)
        *u = clamp(*u, 0, 1);
    return *u >= 0 && *u <= 1;
}

typedef struct lookup {
    const scene *s;
    zt_filter filter;
    uint32_t layer;
    bool clamped; /* as a patch shows it */
} lookup;

static zt_wrap wrap_of(const lookup *l, bool vertical) {
    return l->clamped ? ZT_WRAP_CLAMP : vertical ? l->s->setup.wrap_v : l->s->setup.wrap_u;
}

/* Every cell that the box can touch has its part of the box. */
static colour box_colour(const lookup *l, double x, double y, double ax, double ay, uint32_t frame) {
    const scene_setup *t = &l->s->setup;
    zt_silmap_filter filter = l->filter == ZT_FILTER_NEAREST ? ZT_SILMAP_NEAREST : t->filter;
    double x0 = x - ax, x1 = x + ax, y0 = y - ay, y1 = y + ay, area = 0;
    colour sum = {{0}};
    if (wrap_of(l, false) != ZT_WRAP_REPEAT) {
        x0 = fmax(x0, 0);
        x1 = fmin(x1, t->cells_x);
    }
    if (wrap_of(l, true) != ZT_WRAP_REPEAT) {
        y0 = fmax(y0, 0);
        y1 = fmin(y1, t->cells_y);
    }
    if (ax == 0 && ay == 0) {
        long i = (long)fmin(floor(x), t->cells_x - 1.0), j = (long)fmin(floor(y), t->cells_y - 1.0);
        vec at = {x - (double)i, y - (double)j};
        return part_colour(l->s, filter, l->layer, frame, i, j, at, 0, 0);
    }
    for (long j = (long)floor(y0); j <= (long)floor(y1); j++) {
        for (long i = (long)floor(x0); i <= (long)floor(x1); i++) {
            double left = fmax(x0 - (double)i, 0), right = fmin(x1 - (double)i, 1);
            double top = fmax(y0 - (double)j, 0), bottom = fmin(y1 - (double)j, 1);
            if (!(right > left) || !(bottom > top))
                continue;
            vec at = {(left + right) / 2, (top + bottom) / 2};
            double part = (right - left) * (bottom - top);
            colour c = part_colour(l->s, filter, l->layer, frame, i, j, at, (right - left) / 2, (bottom - top) / 2);
            for (int k = 0; k < 4; k++)
                sum.c[k] += part * c.c[k];
            area += part;
        }
    }
    for (int k = 0; k < 4; k++)
        sum.c[k] /= area;
    return sum;
}

/* minified: what a lookup in the minified image gives there. */
static colour reference(const lookup *l, const zt_point *p, const float minified[4]) {
    const scene_setup *t = &l->s->setup;
    double u = p->u, v = p->v, w = 0, ax = 0, ay = 0;
    colour out = {{0}};
    uint32_t frame = p->array_layer < t->frames ? p->array_layer : t->frames - 1;
    if (!wrap(&u, wrap_of(l, false)) || !wrap(&v, wrap_of(l, true)))
        return out;
    double rho = fmax(hypot(p->du_dx * t->cells_x, p->dv_dx * t->cells_y),
                      hypot(p->du_dy * t->cells_x, p->dv_dy * t->cells_y));
    double lambda = log2(rho);
    if (l->filter == ZT_FILTER_TRILINEAR) {
        w = clamp(lambda + 1, 0, 1);
        ax = fmin((fabs(p->du_dx) + fabs(p->du_dy)) * t->cells_x / 2, 0.5);
        ay = fmin((fabs(p->dv_dx) + fabs(p->dv_dy)) * t->cells_y / 2, 0.5);
    } else {
        w = lambda > -0.5;
    }
    if (!t->minified)
        w = 0;
    if (w < 1)
        out = box_colour(l, u * t->cells_x, v * t->cells_y, ax, ay, frame);
    for (int c = 0; c < 4; c++)
        out.c[c] = (1 - w) * out.c[c] + w * (double)minified[c];
    return out;
}

/* ---- agreement ---- */

static zt_point random_point(const scene_setup *t, uint64_t *seed) {
    zt_point p = {.u = test_uniform(seed, -1.3, 2.3), .v = test_uniform(seed, -1.3, 2.3)};
    if (test_below(seed, 3) == 0) /* on a side, or a corner */
        p.u = (double)test_below(seed, t->cells_x + 1) / t->cells_x;
    if (test_below(seed, 3) == 0)
        p.v = (double)test_below(seed, t->cells_y + 1) / t->cells_y;
    double scale = ldexp(1, -(int)test_below(seed, 8));
    p.array_layer = test_below(seed, t->frames + 2);
    if (test_below(seed, 4) == 0)
        return p;
    p.du_dx = scale * test_uniform(seed, -1, 1) / t->cells_x;
    p.dv_dx = scale * test_uniform(seed, -1, 1) / t->cells_y;
    p.du_dy = scale * test_uniform(seed, -1, 1) / t->cells_x;
    p.dv_dy = scale * test_uniform(seed, -1, 1) / t->cells_y;
    return p;
}

static zt_sampler *open_sampler(const zt_file *file, uint32_t texture, zt_filter filter, uint32_t layer) {
    zt_sampler_options options = {.filter = filter, .layer = layer};
    zt_sampler *sampler;
    zt_diag diag;
    must(zt_sampler_open(file, texture, &options, &diag, &sampler), &diag);
    return sampler;
}

static void compare(const scene_setup *setup, zt_filter filter, uint32_t layer, uint64_t seed) {
    static zt_point points[POINTS];
    static float got[4 * POINTS], minified[4 * POINTS];
    scene s = scene_make(setup, seed);
    zt_file *file = scene_open(&s);
    zt_diag diag;
    lookup l = {.s = &s, .filter = filter, .layer = layer};
    for (int i = 0; i < POINTS; i++)
        points[i] = random_point(setup, &seed);
    zt_sampler *sampler = open_sampler(file, 0, filter, layer);
    must(zt_sample(sampler, points, POINTS, got, &diag), &diag);
    zt_sampler *alone = setup->minified ? open_sampler(file, 1 + layer, filter, 0) : NULL;
    if (alone)
        must(zt_sample(alone, points, POINTS, minified, &diag), &diag);
    for (int i = 0; i < POINTS; i++) {
        float once[4];
        colour want = reference(&l, &points[i], minified + 4 * i);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)got[4 * i + c] - want.c[c]) < 4e-6);
        /* Many points at once are as many calls. */
        must(zt_sample(sampler, &points[i], 1, once, &diag), &diag);
        CHECK(memcmp(once, got + 4 * i, sizeof once) == 0);
    }
    zt_sampler_close(alone);
    zt_sampler_close(sampler);
    zt_close(file);
    scene_free(&s);
}

static void check_agreement(void) {
    static const uint32_t formats[] = {RGBA8_SRGB, R8, RG16, RGBA16F, RGB8};
    static const uint32_t sizes[][2] = {{5, 7}, {1, 1}, {20, 3}, {1, 40}};
    static const zt_wrap wraps[][2] = {{ZT_WRAP_REPEAT, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_CLAMP, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_MIRROR, ZT_WRAP_BORDER},
                                       {ZT_WRAP_REPEAT, ZT_WRAP_CLAMP},
                                       {ZT_WRAP_BORDER, ZT_WRAP_MIRROR}};
    uint64_t seed = 0x5EED;
    for (uint32_t n = 0; n < 180; n++) {
        uint32_t size = n % 4;
        scene_setup t = {.format = formats[n % 5],
                         .cells_x = sizes[size][0],
                         .cells_y = sizes[size][1],
                         .frames = n % 7 == 0 ? 3 : 1,
                         .cell_layers = n % 14 == 0 ? 3 : 1,
                         .wrap_u = wraps[n / 5 % 5][0],
                         .wrap_v = wraps[n / 5 % 5][1],
                         .filter = (zt_silmap_filter)(n / 3 % 3),
                         .layer_count = 1 + n % 2,
                         .minified = n % 3 != 1};
        if (t.format == RGBA8_SRGB || t.format == RGBA16F)
            t.alpha = (zt_alpha)(n % 3);
        compare(&t, (zt_filter)(n / 2 % 3), t.layer_count - 1, seed + n);
    }
}

/* ---- what a picture shows ---- */

static const scene_setup plain = {.format = RGBA8_SRGB,
                                  .alpha = ZT_ALPHA_STRAIGHT,
                                  .cells_x = 8,
                                  .cells_y = 8,
                                  .frames = 1,
                                  .cell_layers = 1,
                                  .wrap_u = ZT_WRAP_REPEAT,
                                  .wrap_v = ZT_WRAP_CLAMP,
                                  .layer_count = 1,
                                  .minified = true};

static double distance(const float *a, const float *b) {
    double most = 0;
    for (int c = 0; c < 4; c++)
        most = fmax(most, fabs((double)a[c] - (double)b[c]));
    return most;
}

static zt_point box_at(double u, double v, double edge) {
    zt_point p = {.u = u, .v = v, .du_dx = edge / plain.cells_x, .dv_dy = edge / plain.cells_y};
    return p;
}

/* The box goes over sides of cells and over arms: a step moves the value by no more than the share of the box that it
 * moves. */
static void check_sliding(const zt_sampler *sampler, uint64_t *seed) {
    static zt_point points[STEPS];
    static float out[4 * STEPS];
    zt_diag diag;
    const double edges[] = {0.02, 0.1, 0.3, 0.9};
    for (int k = 0; k < 4; k++) {
        double u = test_uniform(seed, 0, 1), v = test_uniform(seed, 0.05, 0.2);
        double du = test_uniform(seed, 0.2, 0.7), dv = test_uniform(seed, 0.2, 0.7);
        double step = hypot(du * plain.cells_x, dv * plain.cells_y) / STEPS;
        for (int i = 0; i < STEPS; i++)
            points[i] = box_at(u + du * i / STEPS, v + dv * i / STEPS, edges[k]);
        must(zt_sample(sampler, points, STEPS, out, &diag), &diag);
        /* Four: a box leaves a cell and crosses two arms at once, and the values inside change as well. */
        for (int i = 1; i < STEPS; i++)
            CHECK(distance(out + 4 * i, out + 4 * i - 4) < 4 * step * (1 / edges[k] + 2));
    }
}

/* Smaller boxes come closer to the point, wherever the point is off the arms. */
static void check_vanishing(const zt_sampler *sampler, uint64_t *seed) {
    zt_diag diag;
    for (int n = 0; n < 500; n++) {
        double u = test_uniform(seed, 0, 1), v = test_uniform(seed, 0, 1);
        zt_point p[2] = {box_at(u, v, 1e-7), box_at(u, v, 0)};
        float out[8];
        must(zt_sample(sampler, p, 2, out, &diag), &diag);
        CHECK(distance(out, out + 4) < 1e-5);
    }
}

/* From magnified to far away in small steps, also where levels begin. */
static void check_no_pop(const zt_sampler *sampler, uint64_t *seed) {
    static zt_point points[STEPS];
    static float out[4 * STEPS];
    zt_diag diag;
    for (int n = 0; n < 8; n++) {
        double u = test_uniform(seed, 0, 1), v = test_uniform(seed, 0.1, 0.9);
        for (int i = 0; i < STEPS; i++)
            points[i] = box_at(u, v, exp2(-4 + 8.0 * i / STEPS));
        must(zt_sample(sampler, points, STEPS, out, &diag), &diag);
        for (int i = 1; i < STEPS; i++)
            CHECK(distance(out + 4 * i, out + 4 * i - 4) < 0.02);
    }
}

static void check_picture(zt_silmap_filter filter) {
    scene_setup setup = plain;
    setup.filter = filter;
    uint64_t seed = 77;
    scene s = scene_make(&setup, seed);
    zt_file *file = scene_open(&s);
    zt_sampler *sampler = open_sampler(file, 0, ZT_FILTER_TRILINEAR, 0);
    check_sliding(sampler, &seed);
    check_vanishing(sampler, &seed);
    check_no_pop(sampler, &seed);
    zt_sampler_close(sampler);
    zt_close(file);
    scene_free(&s);
}

/* Without cut arms a magnified silmap is a bilinear lookup in its samples, whatever the points. */
static void check_uncut(void) {
    scene_setup setup = plain;
    setup.uncut = true;
    uint64_t seed = 5;
    scene s = scene_make(&setup, seed);
    zt_file *file = scene_open(&s);
    zt_sampler *sampler = open_sampler(file, 0, ZT_FILTER_BILINEAR, 0);
    zt_diag diag;
    for (int n = 0; n < 1000; n++) {
        zt_point p = {.u = test_uniform(&seed, 0, 1), .v = test_uniform(&seed, 0, 1)};
        double x = p.u * setup.cells_x, y = p.v * setup.cells_y, fx = x - floor(x), fy = y - floor(y);
        long i = (long)floor(x), j = (long)floor(y);
        float out[4];
        must(zt_sample(sampler, &p, 1, out, &diag), &diag);
        for (int c = 0; c < 4; c++) {
            double top = (1 - fx) * (double)sample_at(&s, 0, 0, i, j)[c] +
                         fx * (double)sample_at(&s, 0, 0, i + 1, j)[c];
            double low = (1 - fx) * (double)sample_at(&s, 0, 0, i, j + 1)[c] +
                         fx * (double)sample_at(&s, 0, 0, i + 1, j + 1)[c];
            CHECK(fabs((double)out[c] - ((1 - fy) * top + fy * low)) < 1e-6);
        }
    }
    zt_sampler_close(sampler);
    zt_close(file);
    scene_free(&s);
}

/* A patch over the whole root shows the silmap: as itself, but clamped. */
static void check_shown(void) {
    scene_setup setup = plain;
    setup.minified = false;
    setup.alpha = ZT_ALPHA_STRAIGHT;
    scene s = {.setup = setup};
    zt_sink sink = memory_sink_of(&s.bytes);
    zt_writer *w;
    zt_diag diag;
    uint64_t seed = 9;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    scene_fill(&s, w, &seed);
    uint32_t silmap = 0;
    zt_patch_desc patches[2] = {
        {.sources = s.images, .mask = ZT_NONE, .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
        {.shows_texture = 1, .sources = &silmap, .mask = ZT_NONE, .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1}}};
    zt_texture_desc desc = {.name = "shows", .wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP};
    must(zt_writer_add_zipmap(w, &desc, patches, 2, &diag, NULL), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    zt_file *file = scene_open(&s);
    zt_sampler *shown = open_sampler(file, 1, ZT_FILTER_TRILINEAR, 0);
    zt_sampler_options alone = {.first_patch_only = 1};
    zt_sampler *root;
    must(zt_sampler_open(file, 1, &alone, &diag, &root), &diag);
    lookup l = {.s = &s, .clamped = true};
    const float none[4] = {0};
    for (int n = 0; n < 2000; n++) {
        float out[4], below[4];
        zt_point p = box_at(n % 2 ? n / 2 % 2 : test_uniform(&seed, 0, 1), test_uniform(&seed, 0, 1), n % 5 * 0.2);
        colour want = reference(&l, &p, none);
        must(zt_sample(shown, &p, 1, out, &diag), &diag);
        must(zt_sample(root, &p, 1, below, &diag), &diag);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)out[c] - (want.c[c] + (1 - want.c[3]) * (double)below[c])) < 4e-6);
    }
    zt_sampler_close(root);
    zt_sampler_close(shown);
    zt_close(file);
    scene_free(&s);
}

int main(void) {
    check_agreement();
    for (int f = 0; f < 2; f++)
        check_picture((zt_silmap_filter)(f * 2)); /* sen2004 has jumps of its own */
    check_uncut();
    check_shown();
    return test_end();
}
