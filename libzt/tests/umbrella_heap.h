/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of umbrellas share: a random heap of umbrellas with every form, valid by spec/umbrella.md section
 * 2. */
#ifndef ZT_TESTS_UMBRELLA_HEAP_H
#define ZT_TESTS_UMBRELLA_HEAP_H

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "test.h"
#include "zt/zt.h"

enum { HEAP_LEVELS = 14, HEAP_BASES = 4, HEAP_CORNERS = 10, HEAP_UMBRELLAS = 64 };

typedef struct heap_setup {
    uint32_t grid_x, grid_y, level_count;
    uint32_t base_count, umbrella_count; /* at most HEAP_...; umbrella_count is that of level 0 */
    bool repeat_x, repeat_y;
    uint32_t image;           /* of even bases */
    uint32_t texture;         /* of odd bases, or ZT_NONE: image */
    zt_background_kind below; /* image and texture as those of bases */
} heap_setup;

/* info is what a reader of the file gives. Base 0 has a morph, two variants and a convex ellipsoid; base 1 none of
 * them. The umbrellas of level 0 take turns with the forms 0, 1, 2 and 0 mirrored. */
typedef struct heap {
    zt_umbrella_info info;
    zt_umbrella_level levels[HEAP_LEVELS];
    zt_umbrella_base bases[HEAP_BASES];
    zt_umbrella_texel base_vertices[HEAP_BASES * HEAP_CORNERS], morph_vertices[HEAP_BASES * HEAP_CORNERS];
    zt_umbrella_colour variant_colours[HEAP_BASES * 3 * (1 + HEAP_CORNERS)];
    zt_umbrella umbrellas[2 * HEAP_UMBRELLAS];
    zt_umbrella_offset explicit_vertices[2 * HEAP_UMBRELLAS * HEAP_CORNERS];
    zt_umbrella_colour explicit_colours[2 * HEAP_UMBRELLAS * (1 + HEAP_CORNERS)];
    uint32_t *list_starts, *entries; /* of their own */
} heap;

static inline void heap_free(heap *h) {
    free(h->list_starts);
    free(h->entries);
    free(h);
}

static inline int32_t heap_between(uint64_t *seed, int32_t low, int32_t high) {
    return low + (int32_t)test_below(seed, (uint32_t)(high - low + 1));
}

static inline zt_umbrella_colour heap_colour(uint64_t *seed) {
    uint32_t v = (uint32_t)(test_random(seed) >> 32);
    zt_umbrella_colour c = {(uint8_t)v, (uint8_t)(v >> 8), (uint8_t)(v >> 16), 0};
    return c;
}

/* Corner i of a star of count corners: angles ascend by less than half a turn. */
static inline zt_umbrella_offset heap_corner(uint64_t *seed, uint32_t i, uint32_t count, double smallest,
                                             double largest, double turn) {
    double angle = 6.283185307179586 * ((double)i + turn) / (double)count;
    double radius = test_uniform(seed, smallest, largest);
    zt_umbrella_offset v = {(int32_t)lrint(radius * cos(angle)), (int32_t)lrint(radius * sin(angle))};
    return v;
}

/* ---- bases ---- */

static inline zt_umbrella_texel heap_texel(const zt_umbrella_base *b, zt_umbrella_offset v) {
    zt_umbrella_texel t = {(uint16_t)(b->centre.x + v.x), (uint16_t)(b->centre.y + v.y)};
    return t;
}

static inline void heap_add_base(heap *h, uint64_t *seed, const heap_setup *t, uint32_t i) {
    zt_umbrella_info *n = &h->info;
    zt_umbrella_base *b = &h->bases[i];
    bool rich = i % 2 == 0, shows_texture = !rich && t->texture != ZT_NONE;
    *b = (zt_umbrella_base){.shows_texture = shows_texture,
                            .source = shows_texture ? t->texture : t->image,
                            .aspect = (uint32_t)heap_between(seed, 1, 1 << 20),
                            .first_vertex = n->base_vertex_count,
                            .first_morph = rich ? n->morph_vertex_count : ZT_NONE,
                            .first_colour = n->variant_colour_count,
                            .vertex_count = (uint16_t)heap_between(seed, 3, HEAP_CORNERS),
                            .variant_count = rich ? 2 : 0,
                            .ellipsoid = rich ? ZT_ELLIPSOID_CONVEX : ZT_ELLIPSOID_FLAT,
                            .centre = {(uint16_t)heap_between(seed, 30000, 35000), 32000},
                            .height = rich ? 20000 : 0,
                            .curvature = rich ? (uint16_t)heap_between(seed, 0, 65535) : 0};
    for (uint32_t k = 0; k < b->vertex_count; k++) {
        double turn = test_uniform(seed, 0, 0.3);
        h->base_vertices[n->base_vertex_count++] = heap_texel(b,
                                                              heap_corner(seed, k, b->vertex_count, 5000, 28000, turn));
        if (rich)
            h->morph_vertices[n->morph_vertex_count++] = heap_texel(
                b, heap_corner(seed, k, b->vertex_count, 5000, 28000, turn));
    }
    for (uint32_t k = 0; k < b->variant_count * (1U + b->vertex_count); k++)
        h->variant_colours[n->variant_colour_count++] = heap_colour(seed);
}

/* ---- umbrellas ---- */

static inline void heap_add_corners(heap *h, uint64_t *seed, zt_umbrella *m, uint32_t count) {
    zt_umbrella_info *n = &h->info;
    m->vertex_count = (uint16_t)count;
    m->first_vertex = n->explicit_vertex_count;
    m->first_colour = n->explicit_colour_count;
    for (uint32_t k = 0; k < count; k++)
        h->explicit_vertices[n->explicit_vertex_count++] = heap_corner(seed, k, count, 60, 900,
                                                                       test_uniform(seed, 0, 0.3));
    for (uint32_t k = 0; k <= count; k++)
        h->explicit_colours[n->explicit_colour_count++] = heap_colour(seed);
}

static inline void heap_parametric(heap *h, uint64_t *seed, zt_umbrella *m) {
    const zt_umbrella_base *b = &h->bases[m->base];
    m->a = heap_between(seed, -70000, 70000);
    m->b = heap_between(seed, 1, 70000);
    m->morph = b->first_morph != ZT_NONE ? (uint8_t)heap_between(seed, 0, 255) : 0;
    m->variant_0 = b->variant_count > 0 ? (uint8_t)test_below(seed, b->variant_count) : 0;
    m->variant_1 = b->variant_count > 0 ? (uint8_t)test_below(seed, b->variant_count) : 0;
    m->variant_weight = (uint8_t)heap_between(seed, 0, 255);
}

static inline void heap_add_umbrella(heap *h, uint64_t *seed, const heap_setup *t, uint32_t level, uint32_t i) {
    zt_umbrella *m = &h->umbrellas[h->info.umbrella_count++];
    const zt_umbrella_level *l = &h->levels[level];
    *m = (zt_umbrella){.x = heap_between(seed, 0, (int32_t)l->width * 65536 - 1),
                       .y = heap_between(seed, 0, (int32_t)l->height * 65536 - 1),
                       .form = level > 0 || t->base_count == 0 ? ZT_UMBRELLA_COLOURED : (uint8_t)(i % 4 % 3),
                       .lift = (uint16_t)heap_between(seed, 0, 30000),
                       .ellipsoid = (uint8_t)test_below(seed, 3)};
    if (m->ellipsoid != ZT_ELLIPSOID_FLAT) {
        m->height = (uint16_t)heap_between(seed, 0, 35535);
        m->curvature = (uint16_t)heap_between(seed, 0, 65535);
    }
    if (!t->repeat_x)
        m->x -= 1 << 18;
    if (m->form != ZT_UMBRELLA_COLOURED) {
        m->base = (uint16_t)(i / 4 % t->base_count);
        m->strength = (uint8_t)heap_between(seed, 0, 255);
    }
    if (m->form == ZT_UMBRELLA_PARAMETRIC) {
        heap_parametric(h, seed, m);
        m->mirrored = i % 4 == 3;
        m->ellipsoid = ZT_ELLIPSOID_OF_BASE;
        m->height = m->curvature = 0;
    } else if (m->form == ZT_UMBRELLA_EXPLICIT) {
        heap_add_corners(h, seed, m, h->bases[m->base].vertex_count);
    } else {
        heap_add_corners(h, seed, m, (uint32_t)heap_between(seed, 3, HEAP_CORNERS));
    }
}

/* ---- lists ---- */

static inline void heap_add_list(heap *h, uint64_t *seed, const heap_setup *t, const zt_umbrella_level *l) {
    zt_umbrella_info *n = &h->info;
    uint32_t first = n->entry_count, chance = 1 + test_below(seed, 30);
    for (uint32_t i = 0; i < 9 * l->umbrella_count; i++) {
        uint32_t shift = i % 9;
        bool allowed = (t->repeat_x || shift % 3 == 1) && (t->repeat_y || shift / 3 == 1);
        if (allowed && test_below(seed, chance) == 0)
            h->entries[n->entry_count++] = i / 9 | shift << ZT_UMBRELLA_SHIFT;
    }
    n->longest_list = n->entry_count - first > n->longest_list ? n->entry_count - first : n->longest_list;
    h->list_starts[++n->cell_count] = n->entry_count;
}

static inline void heap_add_level(heap *h, uint64_t *seed, const heap_setup *t, uint32_t level) {
    zt_umbrella_info *n = &h->info;
    zt_umbrella_level *l = &h->levels[level];
    uint32_t width = t->grid_x >> level, height = t->grid_y >> level;
    *l = (zt_umbrella_level){.width = width > 1 ? width : 1,
                             .height = height > 1 ? height : 1,
                             .first_umbrella = n->umbrella_count,
                             .umbrella_count = t->umbrella_count >> level,
                             .first_cell = n->cell_count,
                             .bits = test_below(seed, 17)};
    for (uint32_t i = 0; i < l->umbrella_count; i++)
        heap_add_umbrella(h, seed, t, level, i);
    for (uint32_t i = 0; i < l->width * l->height; i++)
        heap_add_list(h, seed, t, l);
}

/* ---- all ---- */

static inline void heap_background(zt_umbrella_info *n, uint64_t *seed, const heap_setup *t) {
    n->background_kind = t->below;
    n->background_source = t->below == ZT_BACKGROUND_COLOUR  ? ZT_NONE
                           : t->below == ZT_BACKGROUND_IMAGE ? t->image
                                                             : t->texture;
    for (int k = 0; k < 4; k++) {
        n->background[k] = (float)test_uniform(seed, 0, 1);
        n->mean[k] = (float)test_uniform(seed, 0, 1);
    }
    n->prism_height = 0.75F;
    n->taper_start = 0.03125F;
    n->taper_end = 0.125F;
}

static inline heap *heap_make(const heap_setup *t, uint64_t seed) {
    heap *h = calloc(1, sizeof *h);
    size_t cells = (size_t)t->grid_x * t->grid_y * 2 + HEAP_LEVELS;
    assert(h && t->base_count <= HEAP_BASES && t->umbrella_count <= HEAP_UMBRELLAS);
    h->list_starts = calloc(cells + 1, sizeof *h->list_starts);
    h->entries = calloc(cells * 9 * (t->umbrella_count + 1), sizeof *h->entries);
    assert(h->list_starts && h->entries);
    zt_umbrella_info *n = &h->info;
    *n = (zt_umbrella_info){.grid_x = t->grid_x,
                            .grid_y = t->grid_y,
                            .level_count = t->level_count,
                            .base_count = t->base_count,
                            .colour_mode = ZT_UMBRELLA_INVERSE_DISTANCE,
                            .levels = h->levels,
                            .bases = h->bases,
                            .base_vertices = h->base_vertices,
                            .morph_vertices = h->morph_vertices,
                            .variant_colours = h->variant_colours,
                            .umbrellas = h->umbrellas,
                            .explicit_vertices = h->explicit_vertices,
                            .explicit_colours = h->explicit_colours,
                            .list_starts = h->list_starts,
                            .entries = h->entries};
    heap_background(n, &seed, t);
    for (uint32_t i = 0; i < t->base_count; i++)
        heap_add_base(h, &seed, t, i);
    for (uint32_t l = 0; l < t->level_count; l++)
        heap_add_level(h, &seed, t, l);
    return h;
}

/* ---- comparing ---- */

static inline bool heap_same(const void *a, const void *b, size_t size, uint32_t count, const char *what) {
    const uint8_t *x = a, *y = b;
    size_t i = 0;
    while (i < size * count && x[i] == y[i])
        i++;
    if (i < size * count)
        fprintf(stderr, "%s: element %zu differs at byte %zu\n", what, i / size, i % size);
    return i == size * count;
}

static inline bool heap_same_numbers(const zt_umbrella_info *a, const zt_umbrella_info *b) {
    return a->grid_x == b->grid_x && a->grid_y == b->grid_y && a->level_count == b->level_count &&
           a->base_count == b->base_count && a->umbrella_count == b->umbrella_count &&
           a->base_vertex_count == b->base_vertex_count && a->morph_vertex_count == b->morph_vertex_count &&
           a->variant_colour_count == b->variant_colour_count && a->explicit_vertex_count == b->explicit_vertex_count &&
           a->explicit_colour_count == b->explicit_colour_count && a->cell_count == b->cell_count &&
           a->entry_count == b->entry_count && a->longest_list == b->longest_list && a->colour_mode == b->colour_mode &&
           a->background_kind == b->background_kind && a->background_source == b->background_source;
}

/* Every field and every array. */
static inline bool heap_equal(const zt_umbrella_info *a, const zt_umbrella_info *b) {
    if (!heap_same_numbers(a, b)) {
        fprintf(stderr, "counts differ\n");
        return false;
    }
    bool same = heap_same(a->background, b->background, 16, 1, "background") &&
                heap_same(a->mean, b->mean, 16, 1, "mean");
    same &= heap_same(&a->prism_height, &b->prism_height, sizeof(float), 1, "prism_height");
    same &= heap_same(&a->taper_start, &b->taper_start, sizeof(float), 1, "taper_start");
    same &= heap_same(&a->taper_end, &b->taper_end, sizeof(float), 1, "taper_end");
    same &= heap_same(a->levels, b->levels, sizeof *a->levels, a->level_count, "levels");
    same &= heap_same(a->bases, b->bases, sizeof *a->bases, a->base_count, "bases");
    same &= heap_same(a->base_vertices, b->base_vertices, 4, a->base_vertex_count, "base_vertices");
    same &= heap_same(a->morph_vertices, b->morph_vertices, 4, a->morph_vertex_count, "morph_vertices");
    same &= heap_same(a->variant_colours, b->variant_colours, 4, a->variant_colour_count, "variant_colours");
    same &= heap_same(a->umbrellas, b->umbrellas, sizeof *a->umbrellas, a->umbrella_count, "umbrellas");
    same &= heap_same(a->explicit_vertices, b->explicit_vertices, 8, a->explicit_vertex_count, "explicit_vertices");
    same &= heap_same(a->explicit_colours, b->explicit_colours, 4, a->explicit_colour_count, "explicit_colours");
    same &= heap_same(a->list_starts, b->list_starts, 4, a->cell_count + 1, "list_starts");
    same &= heap_same(a->entries, b->entries, 4, a->entry_count, "entries");
    return same;
}

#endif
