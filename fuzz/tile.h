/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Inputs of fuzz_tile: what is said about a tile, then its stored bytes in codec 2 or 4 (spec/ztex.md sections 6.4 and
 * 6.5). tile_make... write tiles that keep to the specification and that no encoder would make; tile_mutate changes one
 * field of one.
 */
#ifndef ZT_FUZZ_TILE_H
#define ZT_FUZZ_TILE_H

#include <stdbool.h>

#include "support.h"

enum {
    TILE_HEAD = 6,      /* bytes of an input before the stored bytes */
    TILE_WIDTH = 320,   /* most columns */
    TILE_HEIGHT = 40,   /* most rows */
    TILE_TEXELS = 2048, /* most of a tile that tile_make makes */
    TILE_INPUT = 1 << 16,
    TILE_PLANES = 8,
    TILE_TABLES = 8,
    TILE_SLOTS = 2048,
    TILE_FIELD_FORMATS = 5 /* BC1, BC3, BC4, BC5, BC7 */
};

/* An input taken apart. */
typedef struct tile {
    uint32_t width, height;
    uint32_t channels, channel_bytes;
    uint32_t fields;          /* codec 4 of the format fields - 1, width and height in blocks; 0: codec 2 */
    uint32_t gap;             /* bytes between two rows of texels */
    bool stored_low, dst_low; /* at the beginning of their memory, else at its end */
    const uint8_t *stored;
    size_t size;
} tile;

/* Bytes of the fields of each format, 0 behind the last one. */
extern const uint32_t tile_fields[TILE_FIELD_FORMATS][4];

/* Bytes of a texel, or of a block. */
static inline uint32_t tile_texel_bytes(const tile *t) {
    const uint32_t *f = tile_fields[t->fields ? t->fields - 1 : 0];
    return t->fields ? f[0] + f[1] + f[2] + f[3] : t->channels * t->channel_bytes;
}

static inline bool tile_has_frame(const tile *t) {
    return t->fields || (t->size > 0 && (t->stored[0] & 16) != 0);
}

/* False: there is not even a head. Any head is right. */
bool tile_parse(tile *t, const uint8_t *data, size_t size);
void tile_store_head(const tile *t, uint8_t *out);

/* A valid tile as an input of at most TILE_INPUT bytes, and its texels without gaps (TILE_TEXELS x 8 bytes of room).
 * Returns the size of the input. tile_make: of codec 2 without a frame; the others: with one, and of codec 4. */
size_t tile_make(fuzz_random *random, uint8_t *input, uint8_t *texels);
size_t tile_make_frame(fuzz_random *random, uint8_t *input, uint8_t *texels);
size_t tile_make_fields(fuzz_random *random, uint8_t *input, uint8_t *texels);

/* Changes an input a little. Returns the new size, at most max_size; size is at least TILE_HEAD. */
size_t tile_mutate(fuzz_random *random, uint8_t *input, size_t size, size_t max_size);

#endif
