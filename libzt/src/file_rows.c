/* SPDX-License-Identifier: Apache-2.0 */
/* From rows to coded tiles in the spool. */
#include "base_hash.h"
#include "file_write.h"

/* ---- buffers of the workers ------------------------------------------------------------------------ */

static zt_result make_slot(zt_writer *w, zt__write_slot *slot, uint64_t size, zt_diag *diag) {
    void *block;
    if (size <= slot->room)
        return ZT_OK;
    zt__free(&w->memory, slot->coded, zt__encode_bound((size_t)slot->room), 1);
    slot->coded = NULL;
    slot->room = 0;
    ZT_TRY(zt__alloc_raw(&w->memory, zt__encode_bound((size_t)size), 1, diag, &block));
    slot->coded = block;
    slot->room = size;
    return ZT_OK;
}

static zt_result make_buffer(zt_writer *w, zt__tile_buffer *buffer, uint64_t size, zt_diag *diag) {
    void *block;
    if (size <= buffer->room)
        return ZT_OK;
    zt__free(&w->memory, buffer->bytes, buffer->room, 1);
    buffer->bytes = NULL;
    buffer->room = 0;
    ZT_TRY(zt__alloc_raw(&w->memory, size, 1, diag, &block));
    buffer->bytes = block;
    buffer->room = size;
    return ZT_OK;
}

/* For tiles of a size, so many at a time. One tile alone is the first worker's: large ones take no more than that. */
static zt_result make_buffers(zt_writer *w, uint64_t size, uint32_t tiles, zt_diag *diag) {
    for (uint32_t i = 0; i < w->slot_count && i < tiles; i++)
        ZT_TRY(make_slot(w, &w->slots[i], size, diag));
    for (unsigned i = 0; i < (tiles > 1 ? w->worker_count : 1); i++)
        ZT_TRY(make_buffer(w, &w->tile_buffers[i], size, diag));
    return ZT_OK;
}

/* form: NULL for a mip tail. */
static void code_tile(zt_writer *w, zt__write_slot *slot, unsigned worker, const zt__tile_form *form,
                      const uint8_t *bytes, size_t size) {
    zt__tile_record empty = {0};
    slot->record = empty;
    slot->record.hash = zt__hash(bytes, size);
    slot->result = zt__encode_tile(&w->encoders[worker], (uint32_t)w->options.effort, form, bytes, size, slot->coded,
                                   zt__encode_bound((size_t)slot->room), &slot->record.codec, &slot->size, NULL);
    slot->record.stored_size = (uint32_t)slot->size;
}

static zt_result slot_failed(const zt__write_slot *slot, zt_diag *diag) {
    if (slot->result == ZT_OK)
        return ZT_OK;
    return zt__fail(diag, slot->result, 0, ZT__NO_OFFSET, "a tile could not be compressed: %s",
                    zt_result_text(slot->result));
}

zt_result zt__write_tile(zt_writer *w, zt__write_image *image, uint32_t unit, uint64_t tile,
                         const zt__tile_record *record, const void *stored, zt_diag *diag) {
    zt__write_unit *u = &image->units[unit];
    ZT_TRY(zt__spool_append(&w->spool, stored, record->stored_size, diag, &u->places[tile]));
    u->records[tile] = *record;
    u->tiles_done++;
    return ZT_OK;
}

/* ---- a row of tiles --------------------------------------------------------------------------------- */

typedef struct cut_task {
    zt_writer *writer;
    const zt__write_image *image;
    const zt__write_level *level;
    const uint8_t *band;
    uint32_t rows;    /* blocks */
    uint32_t first_x; /* tile of the first slot */
} cut_task;

static void cut_tile(void *context, size_t index, unsigned worker) {
    const cut_task *t = context;
    uint32_t edge = 1U << t->image->record.tile_log2, block = t->image->record.block_bytes;
    uint32_t x = (t->first_x + (uint32_t)index) * edge;
    size_t width = (size_t)zt__min32(edge, t->level->info.blocks_x - x) * block;
    uint8_t *tile = t->writer->tile_buffers[worker].bytes;
    for (uint32_t y = 0; y < t->rows; y++)
        memcpy(tile + y * width, t->band + y * t->level->info.row_size + (size_t)x * block, width);
    zt__tile_box box = {.width = (uint32_t)(width / block), .height = t->rows};
    zt__tile_form form = zt__tile_form_of(&t->image->record, &box);
    code_tile(t->writer, &t->writer->slots[index], worker, &form, tile, width * t->rows);
}

zt_result zt__write_band(zt_writer *w, zt__write_image *image, uint32_t level, const uint8_t *band, uint64_t slice,
                         uint32_t tile_y, zt_diag *diag) {
    const zt__write_level *l = &image->levels[level];
    uint32_t edge = 1U << image->record.tile_log2;
    cut_task task = {.writer = w, .image = image, .level = l, .band = band};
    task.rows = zt__min32(edge, l->info.blocks_y - tile_y * edge);
    uint64_t size = (uint64_t)zt__min32(edge, l->info.blocks_x) * task.rows;
    ZT_TRY(make_buffers(w, size * image->record.block_bytes, l->info.tiles_x, diag));
    uint64_t first = (slice * l->info.tiles_y + tile_y) * l->info.tiles_x;
    for (uint32_t x = 0; x < l->info.tiles_x; x += w->slot_count) {
        uint32_t n = zt__min32(w->slot_count, l->info.tiles_x - x);
        task.first_x = x;
        zt__run(w->parallel_or_null, n, cut_tile, &task);
        for (uint32_t i = 0; i < n; i++) {
            const zt__write_slot *slot = &w->slots[i];
            ZT_TRY(slot_failed(slot, diag));
            ZT_TRY(zt__write_tile(w, image, level, first + x + i, &slot->record, slot->coded, diag));
        }
    }
    return ZT_OK;
}

static zt_result code_tail(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    ZT_TRY(make_buffers(w, image->tail_size, 1, diag));
    zt__write_slot *slot = &w->slots[0];
    code_tile(w, slot, 0, NULL, image->tail, (size_t)image->tail_size);
    ZT_TRY(slot_failed(slot, diag));
    ZT_TRY(zt__write_tile(w, image, image->tail_level, 0, &slot->record, slot->coded, diag));
    zt__free(&w->memory, image->tail, image->tail_size, 1);
    image->tail = NULL;
    return ZT_OK;
}

/* ---- places for rows --------------------------------------------------------------------------------- */

static zt_result place_in_tail(zt_writer *w, zt__write_image *image, uint32_t level, uint64_t row, uint8_t **dst,
                               zt_diag *diag) {
    void *block;
    if (!image->tail) {
        ZT_TRY(zt__alloc(&w->memory, image->tail_size, 1, diag, &block));
        image->tail = block;
    }
    *dst = image->tail + zt__tail_offset(&image->record, level) + row * image->levels[level].info.row_size;
    return ZT_OK;
}

static zt__band *band_of(zt__write_level *l, uint32_t edge, uint32_t y) {
    return y < edge && l->first_row != 0 ? &l->first_band : &l->band;
}

/* Where rows y, y + 1, ... of a slice are assembled: *n of them, set lower when not all are together. */
static zt_result place_rows(zt_writer *w, zt__write_image *image, uint32_t level, uint64_t slice, uint32_t y,
                            uint32_t *n, uint8_t **dst, zt_diag *diag) {
    zt__write_level *l = &image->levels[level];
    void *block;
    *n = zt__min32(*n, l->info.blocks_y - y);
    if (level >= image->tail_level)
        return place_in_tail(w, image, level, slice * l->info.blocks_y + y, dst, diag);
    uint32_t edge = 1U << image->record.tile_log2;
    zt__band *band = band_of(l, edge, y);
    if (!band->bytes) {
        l->band_size = zt__min32(edge, l->info.blocks_y) * l->info.row_size;
        ZT_TRY(zt__alloc_raw(&w->memory, l->band_size, 1, diag, &block));
        band->bytes = block;
    }
    *n = zt__min32(*n, edge - y % edge);
    *dst = band->bytes + y % edge * l->info.row_size;
    return ZT_OK;
}

static void free_bands(zt_writer *w, zt__write_level *l) {
    zt__free(&w->memory, l->band.bytes, l->band_size, 1);
    zt__free(&w->memory, l->first_band.bytes, l->band_size, 1);
    l->band.bytes = NULL;
    l->first_band.bytes = NULL;
}

/* n rows have been written where place_rows said. */
static zt_result rows_placed(zt_writer *w, zt__write_image *image, uint32_t level, uint64_t slice, uint32_t y,
                             uint32_t n, zt_diag *diag) {
    zt__write_level *l = &image->levels[level];
    l->mode = ZT__WRITE_ROWS;
    l->rows_done += n;
    if (level >= image->tail_level) {
        image->tail_rows_done += n;
        return image->tail_rows_done == image->tail_row_count ? code_tail(w, image, diag) : ZT_OK;
    }
    uint32_t edge = 1U << image->record.tile_log2, tile_y = y / edge;
    zt__band *band = band_of(l, edge, y);
    band->rows += n;
    if (band->rows == zt__min32(edge, l->info.blocks_y - tile_y * edge)) {
        band->rows = 0;
        ZT_TRY(zt__write_band(w, image, level, band->bytes, slice, tile_y, diag));
    }
    if (l->rows_done == l->row_count)
        free_bands(w, l);
    return ZT_OK;
}

/* ---- the zero border ------------------------------------------------------------------------------------ */

static void clear_cover(const zt__write_image *image, uint8_t *texels, uint32_t count) {
    uint32_t size = image->record.block_bytes;
    for (uint32_t i = 0; i < count; i++)
        memset(texels + (size_t)i * size + image->cover_at, 0, image->cover_size);
}

static void clear_border(const zt__write_image *image, uint32_t level, uint32_t y, uint32_t n, uint8_t *rows) {
    const zt_level_info *info = &image->levels[level].info;
    if (image->cover_size == 0)
        return;
    for (uint32_t i = 0; i < n; i++) {
        uint8_t *row = rows + i * info->row_size;
        if (y + i == 0 || y + i == info->height - 1) {
            clear_cover(image, row, info->width);
            continue;
        }
        clear_cover(image, row, 1);
        clear_cover(image, row + (size_t)(info->width - 1) * image->record.block_bytes, 1);
    }
}

/* ---- mip levels -------------------------------------------------------------------------------------------- */

typedef struct mip_target {
    zt_writer *writer;
    zt__write_image *image;
} mip_target;

static uint64_t mip_slice(const zt__write_image *image, uint32_t level, uint32_t z) {
    return (uint64_t)image->layer * image->levels[level].info.depth + z;
}

static zt_result mip_place(void *user, uint32_t level, uint32_t z, uint32_t y, uint32_t *n, uint8_t **dst,
                           zt_diag *diag) {
    const mip_target *t = user;
    return place_rows(t->writer, t->image, level, mip_slice(t->image, level, z), y, n, dst, diag);
}

static zt_result mip_commit(void *user, uint32_t level, uint32_t z, uint32_t y, uint32_t n, zt_diag *diag) {
    const mip_target *t = user;
    uint8_t *rows;
    uint64_t slice = mip_slice(t->image, level, z);
    ZT_TRY(place_rows(t->writer, t->image, level, slice, y, &n, &rows, diag));
    clear_border(t->image, level, y, n, rows);
    return rows_placed(t->writer, t->image, level, slice, y, n, diag);
}

static zt_result make_mip(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    const zt_image_desc *d = &image->desc;
    void *block;
    zt__mip_desc desc = {.record = &image->record,
                         .format = image->format,
                         .filter = d->mip_filter,
                         .wrap_u = d->wrap_u,
                         .wrap_v = d->wrap_v,
                         .wrap_w = d->wrap_w,
                         .is_normal = d->is_normal != 0};
    ZT_TRY(zt__alloc(&w->memory, 1, sizeof(mip_target), diag, &block));
    mip_target *target = block;
    target->writer = w;
    target->image = image;
    zt__mip_sink sink = {target, mip_place, mip_commit};
    zt_result r = zt__mip_new(&w->memory, w->parallel_or_null, &desc, &sink, diag, &image->mip);
    if (r != ZT_OK) {
        zt__free(&w->memory, target, 1, sizeof *target);
        return r;
    }
    image->mip_target = target;
    for (uint32_t i = 0; i < image->record.levels; i++)
        image->levels[i].first_row = zt__mip_first_row(image->mip, i);
    return ZT_OK;
}

static void free_mip(zt_writer *w, zt__write_image *image) {
    zt__mip_free(image->mip);
    zt__free(&w->memory, image->mip_target, 1, sizeof(mip_target));
    image->mip = NULL;
    image->mip_target = NULL;
}

void zt__write_rows_free(zt_writer *w, zt__write_image *image) {
    free_mip(w, image);
    zt__free(&w->memory, image->tail, image->tail_size, 1);
    image->tail = NULL;
    for (uint32_t i = 0; image->levels && i < image->record.levels; i++)
        free_bands(w, &image->levels[i]);
}

/* ---- rows from the caller ------------------------------------------------------------------------------------ */

static void copy_rows(uint8_t *dst, size_t row_size, const uint8_t *src, size_t pitch, uint32_t n) {
    if (pitch == row_size) {
        memcpy(dst, src, row_size * n);
        return;
    }
    for (uint32_t i = 0; i < n; i++)
        memcpy(dst + i * row_size, src + i * pitch, row_size);
}

/* Some of the rows: *n, set lower. */
static zt_result write_some(zt_writer *w, zt__write_image *image, uint32_t level, const uint8_t *rows, size_t pitch,
                            uint32_t *n, zt_diag *diag) {
    zt__write_level *l = &image->levels[level];
    uint64_t slice = l->rows_done / l->info.blocks_y;
    uint32_t y = (uint32_t)(l->rows_done % l->info.blocks_y);
    size_t row_size = (size_t)l->info.row_size;
    uint8_t *dst;
    if (image->mip)
        *n = zt__min32(*n, ZT__MIP_BATCH);
    ZT_TRY(place_rows(w, image, level, slice, y, n, &dst, diag));
    copy_rows(dst, row_size, rows, pitch, *n);
    clear_border(image, level, y, *n, dst);
    if (image->mip) {
        image->layer = (uint32_t)(slice / l->info.depth);
        ZT_TRY(zt__mip_push(image->mip, dst, *n, row_size, diag));
    }
    return rows_placed(w, image, level, slice, y, *n, diag);
}

/* Rows of level 0 of an image whose tile edge is not known yet. */
static zt_result hold_rows(zt_writer *w, zt__write_image *image, const uint8_t *rows, uint32_t count, size_t pitch,
                           zt_diag *diag) {
    const zt_level_info *info = &image->levels[0].info;
    uint64_t first = image->levels[0].rows_done;
    uint8_t *dst;
    ZT_TRY(zt__write_hold(w, image, count, diag, &dst));
    copy_rows(dst, (size_t)info->row_size, rows, pitch, count);
    for (uint32_t i = 0; i < count; i++)
        clear_border(image, 0, (uint32_t)((first + i) % info->blocks_y), 1, dst + i * info->row_size);
    if (first + count < image->levels[0].row_count)
        return ZT_OK;
    image->chooses_edge = false;
    return zt__write_choose_edge(w, image, diag);
}

zt_result zt__write_coded_rows(zt_writer *w, zt__write_image *image, const uint8_t *rows, zt_diag *diag) {
    zt__write_level *l = &image->levels[0];
    l->mode = ZT__WRITE_ROWS;
    l->rows_done = l->row_count;
    if (image->record.levels == 1)
        return ZT_OK;
    ZT_TRY(make_mip(w, image, diag));
    for (uint64_t done = 0; done < l->row_count;) {
        uint32_t y = (uint32_t)(done % l->info.blocks_y), n = zt__min32(ZT__MIP_BATCH, l->info.blocks_y - y);
        image->layer = (uint32_t)(done / l->info.blocks_y / l->info.depth);
        ZT_TRY(zt__mip_push(image->mip, rows + done * l->info.row_size, n, (size_t)l->info.row_size, diag));
        done += n;
    }
    free_mip(w, image);
    return ZT_OK;
}

zt_result zt__write_rows(zt_writer *w, zt__write_image *image, uint32_t level, const uint8_t *rows, uint32_t count,
                         size_t pitch, zt_diag *diag) {
    zt__write_level *l = &image->levels[level];
    bool makes = !image->desc.given_levels && image->record.levels > 1;
    if (image->chooses_edge)
        return count > 0 ? hold_rows(w, image, rows, count, pitch, diag) : ZT_OK;
    if (makes && !image->mip)
        ZT_TRY(make_mip(w, image, diag));
    for (uint32_t done = 0; done < count;) {
        uint32_t n = count - done;
        ZT_TRY(write_some(w, image, level, rows + (size_t)done * pitch, pitch, &n, diag));
        done += n;
    }
    if (makes && l->rows_done == l->row_count)
        free_mip(w, image);
    return ZT_OK;
}
