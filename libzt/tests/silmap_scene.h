/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of silmaps share: a file with one silmap, and what is in it. */
#ifndef ZT_TESTS_SILMAP_SCENE_H
#define ZT_TESTS_SILMAP_SCENE_H

#include <assert.h>
#include <stdbool.h>

#include "test.h"
#include "write_sink.h"
#include "zt/zt.h"

enum { SCENE_LAYERS = 2, R8 = 9, RGB8 = 23, RGBA8_SRGB = 43, RG16 = 77, RGBA16F = 97 };

typedef struct scene_setup {
    uint32_t format; /* of layer 0; layer 1 is RGB8, a normal */
    zt_alpha alpha;
    uint32_t cells_x, cells_y, frames, cell_layers;
    zt_wrap wrap_u, wrap_v;
    zt_silmap_filter filter;
    uint32_t layer_count;
    bool minified, uncut; /* uncut: no arm is */
} scene_setup;

/* Texture 0 is the silmap; textures 1 on are of kind image and show the minified images with the same wrap modes. */
typedef struct scene {
    scene_setup setup;
    uint32_t samples_x, samples_y;
    uint8_t *cells;
    float *samples[SCENE_LAYERS]; /* premultiplied linear, frame after frame */
    uint32_t images[SCENE_LAYERS], minified[SCENE_LAYERS];
    memory_sink bytes;
} scene;

static inline uint32_t scene_format(const scene *s, uint32_t layer) {
    return layer == 0 ? s->setup.format : (uint32_t)RGB8;
}

static inline zt_image_desc scene_image(const scene *s, uint32_t layer, uint32_t width, uint32_t height) {
    zt_image_desc desc = {.format = scene_format(s, layer),
                          .width = width,
                          .height = height,
                          .layers = s->setup.frames,
                          .tile_edge = 16,
                          .alpha_mode = layer == 0 ? s->setup.alpha : ZT_ALPHA_NONE,
                          .layer_kind = s->setup.frames > 1 ? ZT_LAYERS_FRAMES : ZT_LAYERS_ARRAY};
    return desc;
}

/* Random texels of an image; `linear` (may be NULL) gets what a lookup makes of them. */
static inline uint32_t scene_put(zt_writer *w, const zt_image_desc *desc, uint64_t *seed, float *linear) {
    const zt_format_info *format = zt_find_format(desc->format);
    size_t count = (size_t)desc->width * desc->height * desc->layers;
    float *values = malloc(count * 4 * sizeof *values);
    uint8_t *texels = malloc(count * format->block_bytes);
    uint32_t image;
    zt_diag diag;
    assert(values && texels);
    for (size_t i = 0; i < count * 4; i++)
        values[i] = (float)(format->is_float ? test_uniform(seed, -1, 3) : test_uniform(seed, 0, 1));
    zt_pack_texels(desc->format, values, count, texels);
    zt_unpack_texels(desc->format, texels, count, values);
    for (size_t i = 0; i < count && linear; i++) {
        for (int c = 0; c < 4; c++) {
            float v = values[4 * i + (size_t)c];
            v = c < 3 ? zt_transfer_decode(format->is_srgb ? 13 : 8, v) : v;
            linear[4 * i + (size_t)c] = c < 3 && desc->alpha_mode == ZT_ALPHA_STRAIGHT ? v * values[4 * i + 3] : v;
        }
    }
    must(zt_writer_add_image(w, desc, &diag, &image), &diag);
    must(zt_writer_put_rows(w, image, texels, desc->height * desc->layers, 0, &diag), &diag);
    free(values);
    free(texels);
    return image;
}

static inline void scene_cells(scene *s, uint64_t *seed) {
    const scene_setup *t = &s->setup;
    size_t layer_size = (size_t)t->cells_x * t->cells_y, count = layer_size * t->cell_layers;
    s->cells = malloc(count);
    assert(s->cells);
    for (size_t i = 0; i < count; i++) {
        s->cells[i] = (uint8_t)(test_random(seed) >> 40);
        if (t->uncut)
            s->cells[i] &= (uint8_t) ~(ZT_SILMAP_WEST | ZT_SILMAP_NORTH);
        if (t->wrap_u != ZT_WRAP_REPEAT && i % t->cells_x == 0)
            s->cells[i] &= (uint8_t)~ZT_SILMAP_WEST;
        if (t->wrap_v != ZT_WRAP_REPEAT && i % layer_size < t->cells_x)
            s->cells[i] &= (uint8_t)~ZT_SILMAP_NORTH;
    }
}

static inline uint8_t scene_cell(const scene *s, uint32_t layer, long x, long y) {
    const scene_setup *t = &s->setup;
    long w = (long)t->cells_x, h = (long)t->cells_y;
    if ((t->wrap_u != ZT_WRAP_REPEAT && (x < 0 || x >= w)) || (t->wrap_v != ZT_WRAP_REPEAT && (y < 0 || y >= h)))
        return ZT_SILMAP_DEFAULT;
    return s->cells[((size_t)layer * t->cells_y + (size_t)((y + h) % h)) * t->cells_x + (size_t)((x + w) % w)];
}

/* The cells as the writer will write them: those without a cut arm are the default. */
static inline void scene_tidy(scene *s) {
    const scene_setup *t = &s->setup;
    for (uint32_t layer = 0; layer < t->cell_layers; layer++) {
        for (long i = 0; i < (long)t->cells_x * (long)t->cells_y; i++) {
            long x = i % (long)t->cells_x, y = i / (long)t->cells_x;
            unsigned cut = (scene_cell(s, layer, x, y) & (ZT_SILMAP_WEST | ZT_SILMAP_NORTH)) |
                           (scene_cell(s, layer, x + 1, y) & ZT_SILMAP_WEST) |
                           (scene_cell(s, layer, x, y + 1) & ZT_SILMAP_NORTH);
            if (!cut)
                s->cells[(size_t)layer * t->cells_x * t->cells_y + (size_t)i] = ZT_SILMAP_DEFAULT;
        }
    }
}

static inline void scene_images(scene *s, zt_writer *w, uint64_t *seed) {
    for (uint32_t l = 0; l < s->setup.layer_count; l++) {
        zt_image_desc desc = scene_image(s, l, s->samples_x, s->samples_y);
        desc.levels = 1;
        s->samples[l] = malloc((size_t)s->samples_x * s->samples_y * s->setup.frames * 4 * sizeof(float));
        s->images[l] = scene_put(w, &desc, seed, s->samples[l]);
        s->minified[l] = ZT_NONE;
        desc = scene_image(s, l, s->setup.cells_x, s->setup.cells_y);
        if (s->setup.minified)
            s->minified[l] = scene_put(w, &desc, seed, NULL);
    }
}

static inline zt_silmap_desc scene_silmap(const scene *s) {
    zt_silmap_desc desc = {.cells_x = s->setup.cells_x,
                           .cells_y = s->setup.cells_y,
                           .cell_layers = s->setup.cell_layers,
                           .filter = s->setup.filter,
                           .cells = s->cells,
                           .samples = s->images,
                           .minified = s->minified};
    return desc;
}

static inline zt_texture_desc scene_texture(const scene *s, const zt_layer_desc layers[SCENE_LAYERS]) {
    zt_texture_desc desc = {
        .wrap_u = s->setup.wrap_u, .wrap_v = s->setup.wrap_v, .layers = layers, .layer_count = s->setup.layer_count};
    return desc;
}

static const zt_layer_desc scene_layers[SCENE_LAYERS] = {{ZT_SEMANTIC_BASE_COLOUR, 0}, {ZT_SEMANTIC_NORMAL, 0}};

/* Adds the scene's images and textures to a writer; nothing is finished. */
static inline void scene_fill(scene *s, zt_writer *w, uint64_t *seed) {
    const scene_setup *t = &s->setup;
    zt_diag diag;
    s->samples_x = t->cells_x + (t->wrap_u != ZT_WRAP_REPEAT);
    s->samples_y = t->cells_y + (t->wrap_v != ZT_WRAP_REPEAT);
    scene_cells(s, seed);
    scene_images(s, w, seed);
    zt_texture_desc texture = scene_texture(s, scene_layers);
    zt_silmap_desc silmap = scene_silmap(s);
    must(zt_writer_add_silmap(w, &texture, &silmap, &diag, NULL), &diag);
    scene_tidy(s);
    for (uint32_t l = 0; l < t->layer_count && t->minified; l++) {
        zt_layer_desc one = {ZT_SEMANTIC_UNSPECIFIED, s->minified[l]};
        texture.layers = &one;
        texture.layer_count = 1;
        must(zt_writer_add_texture(w, &texture, &diag, NULL), &diag);
    }
}

static inline scene scene_make(const scene_setup *setup, uint64_t seed) {
    scene s = {.setup = *setup};
    zt_sink sink = memory_sink_of(&s.bytes);
    zt_writer *w;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    scene_fill(&s, w, &seed);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return s;
}

static inline zt_file *scene_open(const scene *s) {
    return memory_sink_open(&s->bytes);
}

static inline void scene_free(scene *s) {
    free(s->cells);
    for (uint32_t l = 0; l < SCENE_LAYERS; l++)
        free(s->samples[l]);
    free(s->bytes.data);
}

#endif
