/* SPDX-License-Identifier: Apache-2.0 */
#include "file_geometry.h"

#include <string.h>

static uint32_t level_edge(uint32_t edge, uint32_t level) {
    return zt__max32(1, edge >> level);
}

void zt__level_geometry(const zt__image_record *image, uint32_t level, zt_level_info *out) {
    memset(out, 0, sizeof *out);
    out->width = level_edge(image->width, level);
    out->height = level_edge(image->height, level);
    out->depth = level_edge(image->depth, level);
    out->blocks_x = (uint32_t)zt__ceil_div(out->width, image->block_width);
    out->blocks_y = (uint32_t)zt__ceil_div(out->height, image->block_height);
    out->row_size = (uint64_t)out->blocks_x * image->block_bytes;
    out->slice_size = out->row_size * out->blocks_y;
    out->layer_size = out->slice_size * out->depth;
    out->level_size = out->layer_size * image->layers;
    if (level >= zt__tail_level(image)) {
        out->tiles_x = out->tiles_y = 1;
        out->tile_count = 1;
        return;
    }
    uint64_t edge = UINT64_C(1) << image->tile_log2;
    out->tiles_x = (uint32_t)zt__ceil_div(out->blocks_x, edge);
    out->tiles_y = (uint32_t)zt__ceil_div(out->blocks_y, edge);
    out->tile_count = (uint64_t)out->tiles_x * out->tiles_y * out->depth * image->layers;
}

/* Bytes of one level, all layers and slices, as far as the tail cares: at most 64 texels a side, at most 2^16 layers,
 * so no overflow. */
static uint64_t small_level_size(const zt__image_record *image, uint32_t level) {
    uint64_t blocks_x = zt__ceil_div(level_edge(image->width, level), image->block_width);
    uint64_t blocks_y = zt__ceil_div(level_edge(image->height, level), image->block_height);
    return blocks_x * blocks_y * image->block_bytes * level_edge(image->depth, level) * image->layers;
}

uint32_t zt__tail_level(const zt__image_record *image) {
    uint32_t tail = image->levels;
    uint64_t sum = 0;
    while (tail > 0) {
        uint32_t level = tail - 1;
        uint32_t edge = zt__max32(zt__max32(level_edge(image->width, level), level_edge(image->height, level)),
                                  level_edge(image->depth, level));
        if (edge > ZT__TAIL_EDGE)
            break;
        sum += small_level_size(image, level);
        if (sum > ZT__TAIL_BYTES)
            break;
        tail = level;
    }
    return tail;
}

uint32_t zt__unit_count(const zt__image_record *image) {
    uint32_t tail = zt__tail_level(image);
    return tail + (tail < image->levels);
}

uint64_t zt__tail_offset(const zt__image_record *image, uint32_t level) {
    uint64_t offset = 0;
    for (uint32_t k = image->levels - 1u; k > level; k--)
        offset += small_level_size(image, k);
    return offset;
}

uint64_t zt__tail_size(const zt__image_record *image, uint32_t tail_level) {
    return zt__tail_offset(image, tail_level) + small_level_size(image, tail_level);
}

void zt__tile_geometry(const zt__image_record *image, const zt_level_info *level, uint64_t tile, zt__tile_box *out) {
    uint64_t per_slice = (uint64_t)level->tiles_x * level->tiles_y;
    uint64_t slice = tile / per_slice;
    uint32_t in_slice = (uint32_t)(tile % per_slice);
    uint32_t edge = UINT32_C(1) << image->tile_log2;
    out->layer = (uint32_t)(slice / level->depth);
    out->z = (uint32_t)(slice % level->depth);
    out->x = in_slice % level->tiles_x * edge;
    out->y = in_slice / level->tiles_x * edge;
    out->width = zt__min32(edge, level->blocks_x - out->x);
    out->height = zt__min32(edge, level->blocks_y - out->y);
    out->size = out->width * out->height * image->block_bytes;
}

zt__tile_form zt__tile_form_of(const zt__image_record *image, const zt__tile_box *box) {
    const zt_format_info *format = zt_find_format(image->format);
    zt__tile_form form = {.fields = zt__find_fields(image->format)};
    if (format && format->is_plain && (format->channel_bits == 8 || format->channel_bits == 16))
        form.shape = (zt__pred_shape){box->width, box->height, format->channels, format->channel_bits / 8U};
    return form;
}

uint32_t zt__unit_rank(const zt__image_record *image, uint32_t unit, uint32_t tail_level) {
    if (unit >= tail_level)
        return 0;
    uint32_t edge = zt__max32(zt__max32(level_edge(image->width, unit), level_edge(image->height, unit)),
                              level_edge(image->depth, unit));
    return 1 + zt__log2(edge);
}

uint32_t zt__unit_of_rank(const zt__image_record *image, uint32_t rank, uint32_t tail_level) {
    if (rank == 0)
        return tail_level < image->levels ? tail_level : ZT_NONE;
    /* floor(log2) of the largest edge falls by one from each level to the next. */
    uint32_t top = 1 + zt__log2(zt__max32(zt__max32(image->width, image->height), image->depth));
    uint32_t unit = top - rank;
    return rank <= top && unit < tail_level ? unit : ZT_NONE;
}
