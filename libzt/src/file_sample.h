/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Looking up images (spec/ztex.md section 12): a set of images whose tiles are decoded when a lookup first touches
 * them. A set may be used by any number of threads at once: a tile is published once, and never changes.
 */
#ifndef ZT_FILE_SAMPLE_H
#define ZT_FILE_SAMPLE_H

#include "file_geometry.h"
#include "file_open.h"

/* Decoded bytes of a tile, NULL until somebody has decoded it. */
typedef struct zt__tile_slot {
    _Atomic(uint8_t *) bytes;
} zt__tile_slot;

/* The tiles of a unit; the array itself comes with the first touch. */
typedef struct zt__tile_store {
    uint64_t count;
    _Atomic(zt__tile_slot *) slots;
} zt__tile_store;

/* Where the texels of a level are. The tail is one tile that all of its levels share. */
typedef struct zt__sample_level {
    uint32_t width, height, depth;
    uint32_t unit;
    uint32_t shift; /* log2 of the tile edge; 31 in the tail */
    uint32_t tiles_x;
    uint64_t slice_tiles; /* from one slice to the next: tiles; 0 in the tail */
    uint64_t slice_bytes; /* and bytes in the tile; 0 outside the tail */
    uint64_t tail_offset;
} zt__sample_level;

typedef struct zt__sample_image {
    uint32_t image;
    const zt_format_info *format;
    uint8_t transfer, levels;
    bool premultiply;   /* straight alpha */
    const float *table; /* 8-bit formats: value of each code in the first three channels; else NULL */
    double size[3];     /* of level 0; depth 0 for 2-D images: dw is left out */
    uint32_t layers;
    zt__sample_level *level; /* levels */
    zt__tile_store *units;
} zt__sample_image;

typedef struct zt__image_set {
    const zt_file *file;
    uint32_t count;
    uint64_t block_size;
    _Atomic uint64_t tile_bytes;
    zt__sample_image *images;
} zt__image_set;

/* How the caller wants images looked up. */
typedef struct zt__look {
    zt_filter filter;
    uint32_t max_anisotropy; /* at least 1 */
} zt__look;

/* One call of zt_sample: scratch of its own. */
typedef struct zt__sample_call {
    zt__image_set *set;
    zt__look look;
    zt__decoder decoder;
    zt_diag *diag;
} zt__sample_call;

/* What a lookup covers. */
typedef struct zt__footprint {
    double lambda; /* not clamped; -infinity where the derivatives are zero */
    uint32_t probes;
    double step[3]; /* the longer derivative, along which the probes lie */
} zt__footprint;

/* Looks up layer 0 (base) and the other layer that is wanted; either may be NULL. */
typedef struct zt__colours {
    float *base, *layer;
} zt__colours;

/* How a texture that another one shows is looked up, clamped: one kind does not know the others. */
typedef struct zt__show_texture {
    void *user;
    zt_result (*show)(void *user, uint32_t texture, const zt_point *point, zt__colours out);
} zt__show_texture;

/* Brings a coordinate into [0, 1] by a zt_wrap; false: it is outside of a border. */
bool zt__wrap_unit(double *u, uint8_t wrap);

/* indices: count image numbers, each once, in range. ZT_UNSUPPORTED: one cannot be sampled. */
zt_result zt__image_set_open(const zt_file *file, const uint32_t *indices, uint32_t count, zt_diag *diag,
                             zt__image_set **out);
void zt__image_set_close(zt__image_set *set); /* NULL is allowed */

zt__footprint zt__footprint_of(const zt__sample_image *image, const zt__look *look, const zt_point *point);

/* wraps: zt_wrap in u, v, w. rgba: premultiplied linear light. Coordinates may be any doubles. */
zt_result zt__sample_footprint(zt__sample_call *call, uint32_t slot, const uint8_t wraps[3], const zt_point *point,
                               const zt__footprint *footprint, float rgba[4]);

/* One texel of level 0: x and y are in range, layer is clamped. */
zt_result zt__fetch_texel(zt__sample_call *call, uint32_t slot, uint32_t x, uint32_t y, uint32_t layer, float rgba[4]);

/* zt__footprint_of and zt__sample_footprint in one. */
zt_result zt__sample_image_at(zt__sample_call *call, uint32_t slot, const uint8_t wraps[3], const zt_point *point,
                              float rgba[4]);

#endif
