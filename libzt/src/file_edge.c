/* SPDX-License-Identifier: Apache-2.0 */
/* The tile edge that makes level 0 smallest, tried out when the highest effort is asked for and the caller names no
 * edge. Level 0 is held for that, so it must be small; every other image streams. */
#include "file_write.h"

/* One tile of the whole level takes the work memory of codec 2 and of zstd at its highest level, many times its
 * bytes. */
enum { MOST_HELD = 1 << 24, SHARE_OF_MEMORY = 64 };

static uint64_t level_bytes(const zt__write_image *image) {
    const zt__write_level *l = &image->levels[0];
    return l->info.row_size * l->row_count;
}

static uint32_t longest_side(const zt__write_image *image) {
    return zt__max32(image->levels[0].info.blocks_x, image->levels[0].info.blocks_y);
}

bool zt__write_chooses_edge(const zt_writer *w, const zt__write_image *image) {
    const zt_image_desc *d = &image->desc;
    uint64_t most = w->limits.memory / SHARE_OF_MEMORY;
    return d->tile_edge == 0 && !d->given_levels && w->options.effort == ZT__PRED_MAX_EFFORT && !w->options.raw_only &&
           image->tail_level > 0 && longest_side(image) > 1U << image->record.tile_log2 &&
           level_bytes(image) <= (most < MOST_HELD ? most : MOST_HELD);
}

/* Codes level 0 with the edge that the record says. *size: of its unit. */
static zt_result try_edge(zt_writer *w, zt__write_image *image, zt_diag *diag, uint64_t *size) {
    const zt_level_info *info = &image->levels[0].info;
    uint32_t edge = 1U << image->record.tile_log2;
    uint64_t slices = (uint64_t)info->depth * image->record.layers;
    for (uint64_t slice = 0; slice < slices; slice++) {
        const uint8_t *rows = image->held + slice * info->row_size * info->blocks_y;
        for (uint32_t y = 0; y < info->tiles_y; y++)
            ZT_TRY(zt__write_band(w, image, 0, rows + (uint64_t)y * edge * info->row_size, slice, y, diag));
    }
    *size = image->units[0].tile_count * ZT__TILE_RECORD_SIZE;
    for (uint64_t i = 0; i < image->units[0].tile_count; i++)
        *size += image->units[0].records[i].stored_size;
    return ZT_OK;
}

static zt_result set_edge(zt_writer *w, zt__write_image *image, uint32_t log2, zt_diag *diag) {
    zt__write_geometry_free(w, image);
    image->record.tile_log2 = (uint8_t)log2;
    return zt__write_geometry(w, image, diag);
}

/* The usual edge, twice that, and the least one that holds the level in one tile. */
static zt_result choose(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    uint32_t usual = image->record.tile_log2, whole = zt__log2(longest_side(image) - 1) + 1;
    const uint32_t logs[] = {usual, usual + 1, whole};
    zt__write_unit best = {0};
    uint32_t best_log2 = 0;
    uint64_t least = UINT64_MAX, size;
    zt_result r = ZT_OK;
    for (uint32_t i = 0; r == ZT_OK && i < sizeof logs / sizeof logs[0]; i++) {
        if (i > 0 && (logs[i] <= logs[i - 1] || logs[i] > whole))
            continue;
        r = set_edge(w, image, logs[i], diag);
        if (r == ZT_OK)
            r = try_edge(w, image, diag, &size);
        if (r != ZT_OK || size >= least)
            continue;
        zt__write_unit other = best;
        best = image->units[0];
        image->units[0] = other;
        best_log2 = logs[i];
        least = size;
    }
    if (r == ZT_OK)
        r = set_edge(w, image, best_log2, diag);
    if (r == ZT_OK) {
        zt__write_unit other = best;
        best = image->units[0];
        image->units[0] = other;
    }
    zt__write_unit_free(w, &best);
    return r;
}

zt_result zt__write_choose_edge(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    uint8_t *held = image->held;
    ZT_TRY(choose(w, image, diag));
    zt_result r = zt__write_coded_rows(w, image, held, diag);
    zt__write_held_free(w, image);
    return r;
}

zt_result zt__write_hold(zt_writer *w, zt__write_image *image, uint32_t count, zt_diag *diag, uint8_t **dst) {
    zt__write_level *l = &image->levels[0];
    void *block;
    if (!image->held) {
        image->held_size = level_bytes(image);
        ZT_TRY(zt__alloc_raw(&w->memory, image->held_size, 1, diag, &block));
        image->held = block;
    }
    *dst = image->held + l->rows_done * l->info.row_size;
    l->mode = ZT__WRITE_ROWS;
    l->rows_done += count;
    return ZT_OK;
}

void zt__write_held_free(zt_writer *w, zt__write_image *image) {
    zt__free(&w->memory, image->held, image->held_size, 1);
    image->held = NULL;
}
