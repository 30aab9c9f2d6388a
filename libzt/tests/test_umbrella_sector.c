/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: for every star polygon that the format allows, also with vertices at its limits and with any weight of a
 * morph, the search finds the sector that a loop over all finds, the point is where its barycentric coordinates say, no
 * point that has coverage is taken for far away, and the public call, which prepares nothing, gives the same numbers. A
 * wrong sector is a hole in a leaf.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "umbrella_geometry.h"

enum { POLYGONS = 12000, QUERIES = 24, MOST_CORNERS = 300 };

/* A texture of one umbrella. */
typedef struct single {
    zt__umbrellas umbrellas;
    zt_umbrella_level level;
    zt_umbrella umbrella;
    zt_umbrella_base base;
    zt_umbrella_texel texels[MOST_CORNERS], moved[MOST_CORNERS];
    zt_umbrella_offset offsets[MOST_CORNERS];
} single;

static int64_t cross(zt_umbrella_offset a, zt_umbrella_offset b) {
    return (int64_t)a.x * b.y - (int64_t)a.y * b.x;
}

/* R8307 and R8312. */
static bool is_star(const zt_umbrella_offset *v, uint32_t count) {
    uint32_t rounds = 0;
    for (uint32_t i = 0; i < count; i++) {
        zt_umbrella_offset a = v[i], b = v[(i + 1) % count];
        if (cross(a, b) <= 0)
            return false;
        rounds += a.y < 0 && b.y >= 0;
    }
    return rounds == 1;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Some with directions anywhere, some with most of them close together, some beginning anywhere on the way round. */
static uint32_t random_star(zt_umbrella_offset *out, double size, uint32_t most, uint64_t *seed) {
    double angles[MOST_CORNERS];
    for (;;) {
        uint32_t count = 3 + test_below(seed, test_below(seed, 2) ? 6 : most - 2);
        uint32_t turn = test_below(seed, count);
        double narrow = test_below(seed, 3) == 0 ? 0.02 : 6.283185307179586;
        for (uint32_t i = 0; i < count; i++)
            angles[i] = test_uniform(seed, 0, i < 4 ? 6.283185307179586 : narrow);
        qsort(angles, count, sizeof *angles, ascending);
        for (uint32_t i = 0; i < count; i++) {
            double r = size * test_uniform(seed, 0.2, 1);
            out[(i + turn) % count].x = (int32_t)lrint(r * cos(angles[i]));
            out[(i + turn) % count].y = (int32_t)lrint(r * sin(angles[i]));
        }
        if (is_star(out, count))
            return count;
    }
}

/* By every sector, with the same products. */
static uint32_t slow_sector(const zt__contour *c, double x, double y, uint32_t *times) {
    uint32_t found = 0;
    *times = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        zt_umbrella_offset a = zt__contour_vertex(c, i), b = zt__contour_vertex(c, (i + 1U) % c->count);
        if ((double)a.x * y - (double)a.y * x >= 0 && (double)b.x * y - (double)b.y * x < 0) {
            found = i;
            ++*times;
        }
    }
    return found;
}

static void check_query(const single *s, const zt__umbrella_scene *scene, double x, double y, double reach) {
    const zt__placed *p = &scene->placed[0];
    zt__contour c = zt__contour_of(&s->umbrellas.view, &s->umbrella);
    const double step[4] = {reach, -reach / 3, reach / 4, reach / 2};
    zt__pixel pixel = zt__pixel_of(step[0], step[1], step[2], step[3]);
    zt__sector sector = {0};
    uint32_t times;
    double coverage = zt__umbrella_coverage(&s->umbrellas, scene, 0, x, y, &pixel, &sector);
    double ux = p->units[0] * x + p->units[1] * y, uy = p->units[2] * x + p->units[3] * y;
    uint32_t i = slow_sector(&c, ux, uy, &times);
    zt_umbrella_sector same;
    zt_umbrella_sector_at(&s->umbrellas.view, &s->level, &s->umbrella, x, y, step, &same);
    zt_umbrella_offset a = zt__contour_vertex(&c, i), b = zt__contour_vertex(&c, (i + 1U) % c.count);
    double ex = (double)b.x - (double)a.x, ey = (double)b.y - (double)a.y;
    double inside = ex * (uy - a.y) - ey * (ux - a.x);
    if (ux == 0 && uy == 0) {
        CHECK(coverage == 1 && sector.i == 0);
        CHECK(same.coverage == 1 && same.i == 0 && same.g == 0 && same.k == 0);
        return;
    }
    CHECK(coverage >= 0 && coverage <= 1);
    if (times != 1) { /* products of more than 53 bits: a sector next to it will do */
        CHECK(fabs(ux) + fabs(uy) > 0x1p24);
        CHECK(coverage == 0 || (isfinite(sector.g / sector.area) && isfinite(sector.k / sector.area)));
        return;
    }
    CHECK(same.coverage == coverage);
    if (reach == 0)
        CHECK(coverage == (inside >= 0 ? 1 : 0));
    else
        CHECK(inside >= 0 ? coverage >= 0.5 : coverage <= 0.5);
    if (coverage == 0)
        return;
    CHECK(same.i == i && same.j == sector.j && same.g == sector.g / sector.area && same.k == sector.k / sector.area);
    CHECK(sector.i == i && sector.j == (i + 1U) % c.count);
    CHECK(sector.area >= 1 && sector.g > 0 && sector.k >= 0);
    double g = sector.g / sector.area, k = sector.k / sector.area, size = fabs(ux) + fabs(uy);
    /* Where an edge is seen under next to no angle, digits are lost. */
    double lost = 1e-15 * size * (hypot(a.x, a.y) * hypot(b.x, b.y) / sector.area);
    CHECK(fabs(g * a.x + k * b.x - ux) <= 1e-12 * size + lost && fabs(g * a.y + k * b.y - uy) <= 1e-12 * size + lost);
}

/* The buckets alone leave only sectors next to the right one; else the search would have to be put right vertex by
 * vertex. */
static void check_buckets(const single *s, const zt__umbrella_scene *scene, double x, double y) {
    const zt__placed *p = &scene->placed[0];
    zt__contour c = zt__contour_of(&s->umbrellas.view, &s->umbrella);
    double ux = p->units[0] * x + p->units[1] * y, uy = p->units[2] * x + p->units[3] * y;
    const zt__bucket *buckets = scene->buckets + p->buckets;
    const zt__bucket *b = &buckets[1 + zt__bucket_of(ux, uy, zt__bucket_count(c.count))];
    uint32_t times;
    int32_t n = (int32_t)slow_sector(&c, ux, uy, &times) + 1 -
                buckets[0].least; /* vertices before it, from the first on */
    bool found = false;
    for (int32_t turn = -2; turn <= 2; turn++)
        found = found || (n + turn * c.count >= b->least && n + turn * c.count <= b->most);
    CHECK(found && b->most - b->least <= c.count);
}

static void query(const single *s, const zt__umbrella_scene *scene, uint64_t *seed) {
    const zt__placed *p = &scene->placed[0];
    zt__contour c = zt__contour_of(&s->umbrellas.view, &s->umbrella);
    const double *m = p->units;
    double determinant = m[0] * m[3] - m[1] * m[2];
    for (int n = 0; n < QUERIES; n++) {
        zt_umbrella_offset v = zt__contour_vertex(&c, test_below(seed, c.count));
        double x = test_uniform(seed, -1.2, 1.2) * p->radius, y = test_uniform(seed, -1.2, 1.2) * p->radius;
        if (n % 4 == 1) { /* at a vertex, or on the way to it, or next to that */
            double part = n % 8 == 1 ? 1 : test_uniform(seed, 0.1, 1.1);
            x = part * (m[3] * v.x - m[1] * v.y) / determinant;
            y = part * (m[0] * v.y - m[2] * v.x) / determinant;
            x = n % 8 == 5 ? nextafter(x, test_uniform(seed, -1, 1) * p->radius) : x;
        }
        if (n % 4 == 2)
            *(test_below(seed, 2) ? &x : &y) = 0;
        if (n % 4 == 0)
            check_buckets(s, scene, x, y);
        if (n == 3)
            x = y = 0;
        check_query(s, scene, x, y, n % 3 == 0 ? 0 : p->radius * ldexp(1, -(int)test_below(seed, 10)));
    }
}

static void check_scene(single *s, int rounds, uint64_t *seed) {
    zt_umbrella_info *n = &s->umbrellas.view;
    zt__umbrella_scene *scene;
    zt__memory memory;
    *n = (zt_umbrella_info){.level_count = 1,
                            .base_count = 1,
                            .umbrella_count = 1,
                            .levels = &s->level,
                            .bases = &s->base,
                            .base_vertices = s->texels,
                            .morph_vertices = s->moved,
                            .umbrellas = &s->umbrella,
                            .explicit_vertices = s->offsets};
    zt__memory_init(&memory, NULL, UINT64_MAX);
    CHECK(zt__umbrella_scene_open(&memory, &s->umbrellas, NULL, &scene) == ZT_OK);
    CHECK(zt__umbrella_radius(&s->umbrellas, scene, 0) <= scene->placed[0].radius * (1 + 1e-12));
    for (int i = 0; i < rounds; i++)
        query(s, scene, seed);
    zt__umbrella_scene_close(&memory, scene);
    CHECK(memory.used == 0);
}

/* Stored in 16 bits around a centre in the middle. */
static void set_texels(zt_umbrella_texel *out, const zt_umbrella_offset *v, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        out[i] = (zt_umbrella_texel){(uint16_t)(32767 + v[i].x), (uint16_t)(32767 + v[i].y)};
}

/* R8308 for the mixtures. */
static bool is_morph(const zt_umbrella_offset *d, const zt_umbrella_offset *e, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t j = (i + 1) % count;
        if (cross(d[i], e[j]) + cross(e[i], d[j]) < 0)
            return false;
    }
    return is_star(e, count);
}

/* The second contour is any other, where one that is a morph is found; else the first one, turned by up to nearly a
 * quarter, with other radii if that is a morph. */
static void set_base(single *s, uint64_t *seed) {
    static zt_umbrella_offset v[MOST_CORNERS], moved[MOST_CORNERS];
    uint32_t count = random_star(v, 32000, MOST_CORNERS, seed);
    set_texels(s->texels, v, count);
    bool found = false;
    for (int tries = 0; tries < 40 && !found && count < 8; tries++)
        found = random_star(moved, 32000, 8, seed) == count && is_morph(v, moved, count);
    for (int tries = 0; tries < 20 && !found; tries++) {
        double turn = test_uniform(seed, -1.5, 1.5), spread = tries < 10 ? 0.5 : 0;
        for (uint32_t i = 0; i < count; i++) {
            double scale = 1 - spread * test_uniform(seed, 0, 1);
            moved[i].x = (int32_t)lrint(scale * (v[i].x * cos(turn) - v[i].y * sin(turn)));
            moved[i].y = (int32_t)lrint(scale * (v[i].x * sin(turn) + v[i].y * cos(turn)));
        }
        found = is_morph(v, moved, count);
    }
    set_texels(s->moved, moved, count);
    s->base = (zt_umbrella_base){.aspect = test_below(seed, 2) ? 65536 : 1 + test_below(seed, 1 << 20),
                                 .first_morph = found ? 0 : ZT_NONE,
                                 .vertex_count = (uint16_t)count,
                                 .centre = {32767, 32767}};
    s->umbrella = (zt_umbrella){.a = (int32_t)test_below(seed, 200000) - 100000,
                                .b = (int32_t)test_below(seed, 200000) | 1,
                                .mirrored = (uint8_t)test_below(seed, 2),
                                .morph = (uint8_t)(found ? test_below(seed, 256) : 0)};
}

static void set_explicit(single *s, uint64_t *seed) {
    /* From next to nothing to the largest that rule 8312 allows. */
    double size = ldexp(1, 3 + (int)test_below(seed, 28)) - 1;
    uint32_t most = size < 1000 ? 8 : MOST_CORNERS;
    s->umbrella = (zt_umbrella){.form = ZT_UMBRELLA_COLOURED};
    s->umbrella.vertex_count = (uint16_t)random_star(s->offsets, size, most, seed);
    s->level.bits = test_below(seed, 17);
}

/* Vertices whose products differ in the last of 61 bits. */
static void set_sliver(single *s) {
    static const zt_umbrella_offset v[] = {
        {(1 << 30) - 1, (1 << 30) - 2}, {1 << 30, (1 << 30) - 1}, {-(1 << 30), 1 << 30}, {-1, -(1 << 30)}};
    CHECK(is_star(v, 4));
    memcpy(s->offsets, v, sizeof v);
    s->umbrella = (zt_umbrella){.form = ZT_UMBRELLA_COLOURED, .vertex_count = 4};
}

/* Vertices exactly where one bucket ends and the next begins: points of a diamond. Rounding puts a point on the way to
 * one into either. */
static void set_sides(single *s) {
    enum { SIDE = 8 };
    for (int32_t i = 0; i < 4 * SIDE; i++) {
        int32_t k = i % SIDE, x = SIDE - k, y = k;
        for (int32_t quarter = 0; quarter < i / SIDE; quarter++) {
            int32_t t = x;
            x = -y;
            y = t;
        }
        s->offsets[i] = (zt_umbrella_offset){1000 * x, 1000 * y};
    }
    CHECK(is_star(s->offsets, 4 * SIDE));
    s->umbrella = (zt_umbrella){.form = ZT_UMBRELLA_COLOURED, .vertex_count = 4 * SIDE};
}

int main(void) {
    single *s = calloc(1, sizeof *s);
    uint64_t seed = 0x5EED;
    if (!s)
        return 1;
    s->level = (zt_umbrella_level){.width = 1, .height = 1, .umbrella_count = 1};
    s->base.vertex_count = 3;
    for (uint32_t n = 0; n < POLYGONS; n++) {
        memset(s->texels, 0, sizeof s->texels);
        if (n % 2)
            set_explicit(s, &seed);
        else
            set_base(s, &seed);
        if (n % 1000 == 999)
            set_sliver(s);
        if (n % 1000 == 499)
            set_sides(s);
        s->umbrellas.view.base_count = 1;
        check_scene(s, n % 1000 == 499 ? 500 : 1, &seed);
    }
    free(s);
    return test_end();
}
