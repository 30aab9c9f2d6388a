/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of the umbrellas' payload share: coding a chunk without a file around it, and taking it apart plane by
 * plane. umbrella_payload.h comes before. */
#ifndef ZT_TESTS_UMBRELLA_CHUNK_H
#define ZT_TESTS_UMBRELLA_CHUNK_H

#include <stdlib.h>
#include <string.h>

#include "umbrella_heap.h"

enum { IMAGES = 4, OWN_TEXTURE = 2, PLANES = 44, OFFSET = 1000 };

/* Planes in the order of the specification. */
enum {
    P_LEVEL_UMBRELLAS,
    P_LEVEL_BITS,
    P_BASE_KIND,
    P_BASE_SOURCE,
    P_BASE_ASPECT,
    P_BASE_VERTICES,
    P_BASE_MORPH,
    P_BASE_VARIANTS,
    P_BASE_X,
    P_BASE_Y,
    P_BASE_ELLIPSOID,
    P_BASE_HEIGHT,
    P_BASE_CURVATURE,
    P_VERTEX_X,
    P_VERTEX_Y,
    P_MORPH_X,
    P_MORPH_Y,
    P_VARIANT_R,
    P_VARIANT_G,
    P_VARIANT_B,
    P_FORM,
    P_BASE,
    P_X,
    P_Y,
    P_A,
    P_B,
    P_MORPH,
    P_VARIANT_0,
    P_VARIANT_1,
    P_VARIANT_WEIGHT,
    P_STRENGTH,
    P_ELLIPSOID,
    P_HEIGHT,
    P_CURVATURE,
    P_LIFT,
    P_VERTICES,
    P_EXPLICIT_X,
    P_EXPLICIT_Y,
    P_EXPLICIT_R,
    P_EXPLICIT_G,
    P_EXPLICIT_B,
    P_LIST_SIZE,
    P_ENTRY,
    P_SHIFT
};

static const zt__image_record images[IMAGES] = {
    {.format = 43, .width = 40, .height = 30, .depth = 1, .layers = 1, .levels = 6, .alpha_mode = 1},
    {.format = 43, .width = 40, .height = 30, .depth = 2, .layers = 1, .levels = 1},
    {.format = 43, .width = 40, .height = 30, .depth = 1, .layers = 2, .levels = 1},
    {.format = 43, .width = 40, .height = 40, .depth = 1, .layers = 6, .levels = 1, .layer_kind = ZT_LAYERS_CUBE},
};

static const heap_setup standard = {.grid_x = 7,
                                    .grid_y = 5,
                                    .level_count = 3,
                                    .base_count = 3,
                                    .umbrella_count = 17,
                                    .repeat_x = true,
                                    .image = 0,
                                    .texture = 1,
                                    .below = ZT_BACKGROUND_IMAGE};

static const zt__image_record *image_of(const void *user, uint32_t image) {
    (void)user;
    return image < IMAGES ? &images[image] : NULL;
}

static inline zt__payload_scope scope_of(const heap_setup *t) {
    zt__payload_scope s = {.texture = OWN_TEXTURE,
                           .layer_count = 1,
                           .wrap_u = t->repeat_x ? ZT_WRAP_REPEAT : ZT_WRAP_CLAMP,
                           .wrap_v = t->repeat_y ? ZT_WRAP_REPEAT : ZT_WRAP_BORDER,
                           .image_count = IMAGES,
                           .image_of = image_of};
    return s;
}

static inline void release(zt__memory *memory, zt__umbrellas *u) {
    zt__free(memory, u, 1, (size_t)u->block_size);
}

static inline zt__umbrella_header header_of(const zt_umbrella_info *n) {
    zt__umbrella_header h = {.grid_x = n->grid_x,
                             .grid_y = n->grid_y,
                             .level_count = n->level_count,
                             .base_count = n->base_count,
                             .umbrella_count = n->umbrella_count,
                             .base_vertex_count = n->base_vertex_count,
                             .morph_vertex_count = n->morph_vertex_count,
                             .variant_colour_count = n->variant_colour_count,
                             .explicit_vertex_count = n->explicit_vertex_count,
                             .entry_count = n->entry_count,
                             .longest_list = n->longest_list,
                             .colour_mode = (uint8_t)n->colour_mode,
                             .background_kind = (uint8_t)n->background_kind,
                             .background_source = n->background_source,
                             .prism_height = n->prism_height,
                             .taper_start = n->taper_start,
                             .taper_end = n->taper_end,
                             .layer_count = 1};
    memcpy(h.background, n->background, sizeof h.background);
    memcpy(h.mean, n->mean, sizeof h.mean);
    return h;
}

/* As the writer makes them, without a check. */
static inline zt__umbrellas *umbrellas_of(zt__memory *memory, const heap *h, const heap_setup *t) {
    const zt_umbrella_info *n = &h->info;
    zt__umbrella_header header = header_of(n);
    zt__payload_scope scope = scope_of(t);
    zt__umbrellas *u;
    zt__sink sink = {0};
    CHECK(zt__umbrellas_new(memory, &header, &scope, NULL, &u) == ZT_OK);
    memcpy(u->levels, h->levels, n->level_count * sizeof *u->levels);
    memcpy(u->bases, h->bases, n->base_count * sizeof *u->bases);
    for (uint32_t i = 0; i < n->base_count; i++)
        u->bases[i].first_morph = h->bases[i].first_morph == ZT_NONE ? ZT_NONE : 0;
    memcpy(u->base_vertices, h->base_vertices, n->base_vertex_count * sizeof *u->base_vertices);
    memcpy(u->morph_vertices, h->morph_vertices, n->morph_vertex_count * sizeof *u->morph_vertices);
    memcpy(u->variant_colours, h->variant_colours, n->variant_colour_count * sizeof *u->variant_colours);
    memcpy(u->umbrellas, h->umbrellas, n->umbrella_count * sizeof *u->umbrellas);
    CHECK(zt__link_umbrellas(&sink, u, &scope, 0) == ZT_OK);
    memcpy(u->explicit_vertices, h->explicit_vertices, n->explicit_vertex_count * sizeof *u->explicit_vertices);
    memcpy(u->explicit_colours, h->explicit_colours, n->explicit_colour_count * sizeof *u->explicit_colours);
    for (uint32_t i = 0; i < n->cell_count; i++)
        u->list_starts[i + 1] = h->list_starts[i + 1] - h->list_starts[i];
    memcpy(u->entries, h->entries, n->entry_count * sizeof *u->entries);
    CHECK(zt__link_lists(&sink, u, &scope, 0) == ZT_OK);
    return u;
}

/* ---- coding --------------------------------------------------------------------------------- */

typedef struct chunk {
    uint8_t *bytes;
    size_t size;
} chunk;

static inline chunk encode(zt__memory *memory, const zt__umbrellas *u) {
    zt__encoder encoder;
    uint8_t *bytes;
    uint64_t capacity;
    chunk c = {NULL, 0};
    CHECK(zt__encoder_init(&encoder, memory, 3, false, NULL) == ZT_OK);
    CHECK(zt__encode_umbrellas(&encoder, u, NULL, &bytes, &capacity, &c.size) == ZT_OK);
    zt__encoder_free(&encoder);
    c.bytes = malloc(c.size); /* exact, so that a sanitizer sees a read behind the end */
    memcpy(c.bytes, bytes, c.size);
    zt__free(memory, bytes, capacity, 1);
    return c;
}

static inline zt_result decode(zt__memory *memory, const heap_setup *t, chunk c, zt__sink *sink, zt__umbrellas **out) {
    zt__decoder decoder;
    zt__umbrellas *u;
    zt__payload_scope scope = scope_of(t);
    uint64_t used = memory->used;
    const zt_limits limits = {.listed_umbrellas = UINT32_MAX};
    zt__decoder_init(&decoder, memory);
    zt_result result = zt__decode_umbrellas(sink, memory, &decoder, &limits, c.bytes, c.size, &scope, OFFSET, &u);
    zt__decoder_free(&decoder);
    CHECK((result == ZT_OK) == (u != NULL));
    if (out)
        *out = u;
    else if (u)
        release(memory, u);
    CHECK((out && u) || memory->used == used);
    return result;
}

static inline chunk make_chunk(zt__memory *memory, const heap_setup *t, uint64_t seed) {
    heap *h = heap_make(t, seed);
    zt__umbrellas *u = umbrellas_of(memory, h, t);
    chunk c = encode(memory, u);
    release(memory, u);
    heap_free(h);
    return c;
}

/* ---- changing sealed bytes --------------------------------------------------------------------- */

/* The planes of a chunk, decoded: each as its elements in the machine's order. */
typedef struct opened {
    uint8_t header[ZT__UMBRELLA_HEADER_SIZE];
    uint32_t edges[PLANES], counts[PLANES];
    void *elements[PLANES];
} opened;

static inline opened open_chunk(zt__memory *memory, chunk c) {
    opened o;
    zt__decoder decoder;
    zt__sink sink = {0};
    zt__cursor in = zt__cursor_of(c.bytes, c.size);
    memcpy(o.header, zt__take(&in, sizeof o.header), sizeof o.header);
    zt__decoder_init(&decoder, memory);
    for (uint32_t p = 0; p < PLANES; p++) {
        o.edges[p] = c.bytes[in.at];
        o.counts[p] = zt__load32(c.bytes + in.at + 16);
        o.elements[p] = calloc(o.counts[p] + 1, o.edges[p]);
        CHECK(zt__decode_plane(&sink, &decoder, &in, 0, o.edges[p], o.counts[p], o.elements[p]) == ZT_OK);
    }
    CHECK(zt__left(&in) == 0);
    zt__decoder_free(&decoder);
    return o;
}

static inline void close_chunk(opened *o) {
    for (uint32_t p = 0; p < PLANES; p++)
        free(o->elements[p]);
}

/* Hashes and all; raw planes, which is quick. */
static inline chunk seal(zt__memory *memory, const opened *o) {
    zt__encoder encoder;
    chunk c = {malloc(1 << 20), sizeof o->header};
    CHECK(zt__encoder_init(&encoder, memory, 1, true, NULL) == ZT_OK);
    memcpy(c.bytes, o->header, sizeof o->header);
    for (uint32_t p = 0; p < PLANES; p++) {
        size_t used = 0;
        void *scratch = malloc(2 * (size_t)o->edges[p] * o->counts[p] + 1);
        CHECK(zt__encode_plane(&encoder, o->edges[p], o->counts[p], o->elements[p], scratch, c.bytes + c.size,
                               (1 << 20) - c.size, &used, NULL) == ZT_OK);
        c.size += used;
        free(scratch);
    }
    zt__encoder_free(&encoder);
    c.bytes = realloc(c.bytes, c.size);
    return c;
}

static inline uint32_t element(const opened *o, uint32_t plane, uint32_t i) {
    const void *e = o->elements[plane];
    return o->edges[plane] == 1   ? ((const uint8_t *)e)[i]
           : o->edges[plane] == 2 ? ((const uint16_t *)e)[i]
                                  : ((const uint32_t *)e)[i];
}

static inline void set_element(opened *o, uint32_t plane, uint32_t i, uint32_t v) {
    void *e = o->elements[plane];
    if (o->edges[plane] == 1)
        ((uint8_t *)e)[i] = (uint8_t)v;
    else if (o->edges[plane] == 2)
        ((uint16_t *)e)[i] = (uint16_t)v;
    else
        ((uint32_t *)e)[i] = v;
}

#endif
