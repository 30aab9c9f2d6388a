/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the tests of lookups in umbrellas share: a file with a texture of umbrellas whose lists are right, and what
 * stands in its way: pictures, a background, and textures that show the umbrellas.
 */
#ifndef ZT_TESTS_UMBRELLA_STAGE_H
#define ZT_TESTS_UMBRELLA_STAGE_H

#include <assert.h>
#include <math.h>
#include <stdbool.h>

#include "test.h"
#include "write_sink.h"
#include "zt/zt.h"

enum { STAGE_BASES = 3, STAGE_LEVELS = 4, STAGE_RGBA8_SRGB = 43 };

/* The file's textures: one for each base's picture, the background's image with the wrap modes of the umbrellas, and
 * clamped, the umbrellas. */
enum { STAGE_BELOW = STAGE_BASES, STAGE_CLAMPED, STAGE_UMBRELLAS };

typedef struct stage_setup {
    uint32_t grid_x, grid_y, levels;
    uint32_t umbrellas; /* of level 0; a quarter of them in each further level */
    uint32_t corners;
    zt_wrap wrap_u, wrap_v;
    zt_umbrella_colour_mode mode;
    zt_background_kind below;
    double size;    /* largest radius, in cells; 0: 0.8 */
    double spike;   /* smallest radius, as a share of the largest; 0: 0.3 */
    unsigned forms; /* bit f: form f of level 0; 0: all */
    double margin;  /* of lists around umbrellas, in cells; 0: 1 */
    bool solid;     /* with ellipsoids and lifts */
    bool prism;     /* with height, but all umbrellas lie on the ground */
    bool opaque;    /* pictures have no holes */
    bool textures;  /* bases show the textures of the pictures, not the images */
} stage_setup;

typedef struct stage {
    stage_setup setup;
    zt_umbrella_info info; /* as it is written; arrays are the stage's */
    uint32_t images[STAGE_BASES + 1];
    zt_umbrella_level levels[STAGE_LEVELS];
    zt_umbrella_base bases[STAGE_BASES];
    zt_umbrella_texel *texels, *moved;
    zt_umbrella_colour *variants, *colours;
    zt_umbrella *umbrellas;
    zt_umbrella_offset *offsets;
    double *radii; /* of the umbrellas, in cells */
    uint32_t *starts, *entries;
    size_t entry_room;
    memory_sink bytes;
} stage;

static inline void *stage_array(size_t count, size_t size) {
    void *p = calloc(count + 1, size);
    assert(p);
    return p;
}

static inline uint32_t stage_extent(uint32_t cells, uint32_t level) {
    return cells >> level > 1 ? cells >> level : 1;
}

/* ---- umbrellas ---- */

/* Corner i of a star: angles ascend by less than half a turn. `shake` moves it within its part of the circle. */
static inline zt_umbrella_offset stage_corner(uint32_t i, uint32_t count, double radius, double shake) {
    double angle = 6.283185307179586 * ((double)i + (count > 3 ? 0.4 : 0.2) * shake) / (double)count;
    zt_umbrella_offset v = {(int32_t)lrint(radius * cos(angle)), (int32_t)lrint(radius * sin(angle))};
    return v;
}

static inline double stage_radius(const stage_setup *t, uint64_t *seed) {
    return test_uniform(seed, t->spike > 0 ? t->spike : 0.3, 1);
}

static inline zt_umbrella_colour stage_colour(uint64_t *seed) {
    uint32_t v = (uint32_t)(test_random(seed) >> 32);
    zt_umbrella_colour c = {(uint8_t)v, (uint8_t)(v >> 8), (uint8_t)(v >> 16), 0};
    return c;
}

/* Base 0 has a morph; bases 0 and 1 have two variants; base 2 has neither. */
static inline void stage_add_base(stage *s, uint32_t i, uint64_t *seed) {
    const stage_setup *t = &s->setup;
    zt_umbrella_info *n = &s->info;
    zt_umbrella_base *b = &s->bases[i];
    *b = (zt_umbrella_base){.shows_texture = t->textures,
                            .source = t->textures ? i : s->images[i],
                            .aspect = i == 1 ? 100000 : 65536,
                            .first_morph = i == 0 ? 0 : ZT_NONE,
                            .vertex_count = (uint16_t)t->corners,
                            .variant_count = i < 2 ? 2 : 0,
                            .centre = {32000, 33000}};
    if (t->solid && i < 2) {
        b->ellipsoid = i == 0 ? ZT_ELLIPSOID_CONVEX : ZT_ELLIPSOID_CONCAVE;
        b->height = 25000;
        b->curvature = (uint16_t)(i == 0 ? 40000 : 9000);
    }
    for (uint32_t k = 0; k < t->corners; k++) {
        zt_umbrella_offset v[2];
        for (int m = 0; m < 2; m++)
            v[m] = stage_corner(k, t->corners, 30000 * stage_radius(t, seed), test_uniform(seed, -1, 1));
        s->texels[n->base_vertex_count++] = (zt_umbrella_texel){(uint16_t)(32000 + v[0].x), (uint16_t)(33000 + v[0].y)};
        if (i == 0)
            s->moved[n->morph_vertex_count++] = (zt_umbrella_texel){(uint16_t)(32000 + v[1].x),
                                                                    (uint16_t)(33000 + v[1].y)};
    }
    for (uint32_t k = 0; k < b->variant_count * (1 + t->corners); k++)
        s->variants[n->variant_colour_count++] = stage_colour(seed);
}

static inline void stage_give_height(const stage_setup *t, zt_umbrella *u, uint64_t *seed) {
    if (!t->solid)
        return;
    u->lift = (uint16_t)test_below(seed, 30000);
    u->ellipsoid = (uint8_t)test_below(seed, u->form == ZT_UMBRELLA_COLOURED ? 3 : 4);
    if (u->ellipsoid == ZT_ELLIPSOID_CONVEX || u->ellipsoid == ZT_ELLIPSOID_CONCAVE) {
        u->height = (uint16_t)test_below(seed, 35000);
        u->curvature = (uint16_t)test_below(seed, 65536);
    }
}

static inline void stage_add_umbrella(stage *s, uint32_t level, uint32_t i, uint64_t *seed) {
    const stage_setup *t = &s->setup;
    zt_umbrella_info *n = &s->info;
    zt_umbrella *u = &s->umbrellas[n->umbrella_count];
    const zt_umbrella_level *l = &s->levels[level];
    unsigned form = level > 0 ? 2 : i % 3;
    while (level == 0 && t->forms != 0 && !(t->forms >> form & 1))
        form = (form + 1) % 3;
    double size = (t->size > 0 ? t->size : 0.8) * test_uniform(seed, 0.5, 1);
    double turn = test_uniform(seed, 0, 6.283185307179586);
    *u = (zt_umbrella){.x = (int32_t)(test_below(seed, l->width << 16)),
                       .y = (int32_t)(test_below(seed, l->height << 16)),
                       .form = (uint8_t)form};
    if (form != ZT_UMBRELLA_COLOURED) {
        u->base = (uint16_t)(i / 3 % STAGE_BASES);
        u->strength = (uint8_t)test_below(seed, 256);
    }
    if (form == ZT_UMBRELLA_PARAMETRIC) {
        const zt_umbrella_base *b = &s->bases[u->base];
        /* A circle around any of the bases' vertices is at most 0.75 picture widths wide. */
        u->a = (int32_t)(65536 * size / 0.75 * cos(turn));
        u->b = (int32_t)(65536 * size / 0.75 * sin(turn)) | 1;
        u->morph = b->first_morph == 0 ? (uint8_t)test_below(seed, 256) : 0;
        u->variant_0 = (uint8_t)(b->variant_count > 0 ? test_below(seed, 2) : 0);
        u->variant_1 = (uint8_t)(b->variant_count > 0 ? test_below(seed, 2) : 0);
        u->variant_weight = (uint8_t)test_below(seed, 256);
        u->mirrored = i & 1;
    } else {
        u->vertex_count = (uint16_t)t->corners;
        u->first_vertex = n->explicit_vertex_count;
        u->first_colour = n->explicit_colour_count;
        for (uint32_t k = 0; k < t->corners; k++)
            s->offsets[n->explicit_vertex_count++] = stage_corner(k, t->corners, 4096 * size * stage_radius(t, seed),
                                                                  test_uniform(seed, -1, 1));
        for (uint32_t k = 0; k <= t->corners; k++)
            s->colours[n->explicit_colour_count++] = stage_colour(seed);
    }
    stage_give_height(t, u, seed);
    s->radii[n->umbrella_count++] = size;
}

/* ---- lists ---- */

/* In a cell: the circle around an umbrella, with room for the coverage of a pixel. */
static inline void stage_add_entry(stage *s, const zt_umbrella_level *l, uint32_t i, uint32_t x, uint32_t y,
                                   uint32_t shift) {
    const zt_umbrella *u = &s->umbrellas[l->first_umbrella + i];
    double cx = u->x / 65536.0 + ((int)(shift % 3) - 1) * (double)l->width;
    double cy = u->y / 65536.0 + ((int)(shift / 3) - 1) * (double)l->height;
    double dx = fmax(fmax(x - cx, cx - x - 1), 0), dy = fmax(fmax(y - cy, cy - y - 1), 0);
    if ((s->setup.wrap_u != ZT_WRAP_REPEAT && shift % 3 != 1) || (s->setup.wrap_v != ZT_WRAP_REPEAT && shift / 3 != 1))
        return;
    if (hypot(dx, dy) > s->radii[l->first_umbrella + i] + (s->setup.margin > 0 ? s->setup.margin : 1))
        return;
    if (s->info.entry_count == s->entry_room) {
        s->entry_room = 2 * s->entry_room + 1024;
        s->entries = realloc(s->entries, s->entry_room * sizeof *s->entries);
        assert(s->entries);
    }
    s->entries[s->info.entry_count++] = i | shift << ZT_UMBRELLA_SHIFT;
}

static inline void stage_add_level(stage *s, uint32_t level, uint64_t *seed) {
    const stage_setup *t = &s->setup;
    zt_umbrella_level *l = &s->levels[level];
    *l = (zt_umbrella_level){.width = stage_extent(t->grid_x, level),
                             .height = stage_extent(t->grid_y, level),
                             .first_umbrella = s->info.umbrella_count,
                             .umbrella_count = t->umbrellas >> 2 * level,
                             .bits = 12};
    for (uint32_t i = 0; i < l->umbrella_count; i++)
        stage_add_umbrella(s, level, i, seed);
    for (uint32_t c = 0; c < l->width * l->height; c++) {
        for (uint32_t i = 0; i < 9 * l->umbrella_count; i++)
            stage_add_entry(s, l, i / 9, c % l->width, c / l->width, i % 9);
        s->starts[++s->info.cell_count] = s->info.entry_count;
    }
}

/* ---- the file ---- */

static inline uint32_t stage_image(zt_writer *w, uint32_t edge, bool opaque, uint64_t *seed) {
    zt_image_desc desc = {.format = STAGE_RGBA8_SRGB,
                          .width = edge,
                          .height = edge,
                          .alpha_mode = ZT_ALPHA_STRAIGHT,
                          .tile_edge = 16,
                          .mip_filter = ZT_MIP_BOX};
    uint8_t *texels = stage_array((size_t)edge * edge, 4);
    uint32_t image;
    zt_diag diag;
    for (size_t i = 0; i < (size_t)edge * edge * 4; i++)
        texels[i] = opaque && i % 4 == 3 ? 255 : (uint8_t)(test_random(seed) >> 40);
    must(zt_writer_add_image(w, &desc, &diag, &image), &diag);
    must(zt_writer_put_rows(w, image, texels, edge, 0, &diag), &diag);
    free(texels);
    return image;
}

static inline void stage_texture(zt_writer *w, uint32_t image, zt_wrap wrap_u, zt_wrap wrap_v) {
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, image};
    zt_texture_desc desc = {.wrap_u = wrap_u, .wrap_v = wrap_v, .layers = &layer, .layer_count = 1};
    zt_diag diag;
    must(zt_writer_add_texture(w, &desc, &diag, NULL), &diag);
}

static inline void stage_allocate(stage *s) {
    const stage_setup *t = &s->setup;
    size_t umbrellas = 2 * t->umbrellas + STAGE_LEVELS, corners = t->corners + 1U;
    s->texels = stage_array(STAGE_BASES * corners, sizeof *s->texels);
    s->moved = stage_array(STAGE_BASES * corners, sizeof *s->moved);
    s->variants = stage_array(2 * STAGE_BASES * corners, sizeof *s->variants);
    s->umbrellas = stage_array(umbrellas, sizeof *s->umbrellas);
    s->offsets = stage_array(umbrellas * corners, sizeof *s->offsets);
    s->colours = stage_array(umbrellas * corners, sizeof *s->colours);
    s->radii = stage_array(umbrellas, sizeof *s->radii);
    s->starts = stage_array(2 * (size_t)t->grid_x * t->grid_y + STAGE_LEVELS, sizeof *s->starts);
}

static inline void stage_fill(stage *s, uint64_t *seed) {
    const stage_setup *t = &s->setup;
    zt_umbrella_info *n = &s->info;
    *n = (zt_umbrella_info){.grid_x = t->grid_x,
                            .grid_y = t->grid_y,
                            .level_count = t->levels,
                            .base_count = STAGE_BASES,
                            .colour_mode = t->mode,
                            .background_kind = t->below,
                            .background_source = ZT_NONE,
                            .prism_height = t->solid || t->prism ? 0.7F : 0,
                            .taper_start = 1 / 64.0F,
                            .taper_end = 1 / 10.0F};
    if (t->below != ZT_BACKGROUND_COLOUR)
        n->background_source = t->below == ZT_BACKGROUND_IMAGE ? s->images[STAGE_BELOW] : (uint32_t)STAGE_BELOW;
    for (int c = 0; c < 4; c++) {
        n->background[c] = (float)test_uniform(seed, 0, 1);
        n->mean[c] = (float)test_uniform(seed, 0, 1);
    }
    for (uint32_t i = 0; i < STAGE_BASES; i++)
        stage_add_base(s, i, seed);
    for (uint32_t l = 0; l < t->levels; l++)
        stage_add_level(s, l, seed);
    n->levels = s->levels;
    n->bases = s->bases;
    n->base_vertices = s->texels;
    n->morph_vertices = s->moved;
    n->variant_colours = s->variants;
    n->umbrellas = s->umbrellas;
    n->explicit_vertices = s->offsets;
    n->explicit_colours = s->colours;
    n->list_starts = s->starts;
    n->entries = s->entries;
}

/* Pictures, background and umbrellas; nothing is finished. */
static inline void stage_write(stage *s, zt_writer *w, uint64_t *seed) {
    const stage_setup *t = &s->setup;
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, 0};
    zt_texture_desc desc = {.wrap_u = t->wrap_u, .wrap_v = t->wrap_v, .layers = &layer, .layer_count = 1};
    zt_diag diag;
    for (uint32_t i = 0; i < STAGE_BASES; i++) {
        s->images[i] = stage_image(w, 24 + 4 * i, t->opaque, seed);
        stage_texture(w, s->images[i], ZT_WRAP_CLAMP, ZT_WRAP_CLAMP);
    }
    s->images[STAGE_BELOW] = stage_image(w, 32, false, seed);
    stage_texture(w, s->images[STAGE_BELOW], t->wrap_u, t->wrap_v);
    stage_texture(w, s->images[STAGE_BELOW], ZT_WRAP_CLAMP, ZT_WRAP_CLAMP);
    stage_allocate(s);
    stage_fill(s, seed);
    must(zt_writer_add_umbrellas(w, &desc, &s->info, &diag, NULL), &diag);
}

static inline stage stage_make(const stage_setup *setup, uint64_t seed) {
    stage s = {.setup = *setup};
    zt_sink sink = memory_sink_of(&s.bytes);
    zt_writer *w;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    stage_write(&s, w, &seed);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return s;
}

static inline zt_file *stage_open(const stage *s) {
    return memory_sink_open(&s->bytes);
}

static inline zt_sampler *stage_sampler(const zt_file *file, uint32_t texture, const zt_sampler_options *options) {
    zt_sampler *sampler;
    zt_diag diag;
    must(zt_sampler_open(file, texture, options, &diag, &sampler), &diag);
    return sampler;
}

static inline void stage_free(stage *s) {
    free(s->texels);
    free(s->moved);
    free(s->variants);
    free(s->umbrellas);
    free(s->offsets);
    free(s->colours);
    free(s->radii);
    free(s->starts);
    free(s->entries);
    free(s->bytes.data);
}

#endif
