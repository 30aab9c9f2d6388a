/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes that follow from an image record (spec/ztex.md sections 8.1 to 8.3): levels, tiles, the mip tail, the order of
 * units. */
#ifndef ZT_FILE_GEOMETRY_H
#define ZT_FILE_GEOMETRY_H

#include <stdbool.h>

#include "base_bytes.h"
#include "file_fields.h"
#include "file_pred.h"
#include "zt/zt.h"

enum {
    ZT__MAX_LEVELS = 21, /* 1 + log2(2^20) */
    ZT__TAIL_EDGE = 64,
    ZT__TAIL_BYTES = 262144
};

/* An image record as in the file. */
typedef struct zt__image_record {
    uint32_t format, width, height, depth, layers;
    uint8_t levels, tile_log2, block_width, block_height, block_bytes;
    uint8_t alpha_mode, layer_kind, primaries, transfer, matrix, full_range, reserved;
} zt__image_record;

/* All of these expect a record that zt__check_image has passed. */

/* Everything of zt_level_info but the unit's place. */
void zt__level_geometry(const zt__image_record *image, uint32_t level, zt_level_info *out);

/* First level of the mip tail, or image->levels. */
uint32_t zt__tail_level(const zt__image_record *image);

/* Units of an image: levels before the tail, plus one if there is a tail. */
uint32_t zt__unit_count(const zt__image_record *image);

/* The unit that a level is in. */
static inline uint32_t zt__unit_of_level(uint32_t level, uint32_t tail_level) {
    return level < tail_level ? level : tail_level;
}

/* Decoded bytes of the whole tail; and the place of one of its levels in it. */
uint64_t zt__tail_size(const zt__image_record *image, uint32_t tail_level);
uint64_t zt__tail_offset(const zt__image_record *image, uint32_t level);

/* A tile: its box in blocks of its slice, and where the slice is. */
typedef struct zt__tile_box {
    uint32_t layer, z;
    uint32_t x, y, width, height; /* blocks */
    uint32_t size;                /* decoded bytes */
} zt__tile_box;

void zt__tile_geometry(const zt__image_record *image, const zt_level_info *level, uint64_t tile, zt__tile_box *out);

/* What a tile of a level is to the codecs that only such tiles may have. */
typedef struct zt__tile_form {
    zt__pred_shape shape;     /* to codec 2; channels is 0 where that is not allowed (R5301) */
    const zt__fields *fields; /* to codec 4; NULL where that is not allowed (R5401) */
} zt__tile_form;

zt__tile_form zt__tile_form_of(const zt__image_record *image, const zt__tile_box *box);

/* Sort key of a unit in TEXL: tails first (0), else 1 + floor(log2(largest edge of the level)). Equal keys: by image.
 */
uint32_t zt__unit_rank(const zt__image_record *image, uint32_t unit, uint32_t tail_level);

/* The reverse for one image, which has at most one unit of each rank: the unit, or ZT_NONE. rank 0 to ZT__MAX_LEVELS.
 */
uint32_t zt__unit_of_rank(const zt__image_record *image, uint32_t rank, uint32_t tail_level);

#endif
