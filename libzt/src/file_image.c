/* SPDX-License-Identifier: Apache-2.0 */
/* Images of a file that is being written: declaring them, and filling them. */
#include "base_hash.h"
#include "file_check.h"
#include "file_write.h"

enum { DEFAULT_EDGE = 256, DEFAULT_BLOCK_EDGE = 64 };

/* ---- declaring ----------------------------------------------------------------------------------------- */

static uint8_t byte_of(uint32_t v) {
    return (uint8_t)(v < 255 ? v : 255);
}

static uint32_t all_levels(const zt__image_record *r) {
    return 1 + zt__log2(zt__max32(zt__max32(r->width, r->height), zt__max32(r->depth, 1)));
}

void zt_describe_image(const zt_image_info *info, zt_image_desc *out) {
    *out = (zt_image_desc){.format = info->format,
                           .width = info->width,
                           .height = info->height,
                           .depth = info->depth,
                           .layers = info->layers,
                           .levels = info->levels,
                           .tile_edge = info->tile_edge,
                           .alpha_mode = (zt_alpha)info->alpha_mode,
                           .layer_kind = (zt_layer_kind)info->layer_kind,
                           .primaries = info->primaries,
                           .transfer = info->transfer,
                           .given_levels = 1};
    if (!zt_find_format(info->format)) {
        out->block_width = info->block_width;
        out->block_height = info->block_height;
        out->block_bytes = info->block_bytes;
    }
}

static zt_result tile_log2_of(const zt_image_desc *d, const zt__image_record *r, uint8_t *out, zt_diag *diag) {
    bool blocks = r->block_width > 1 || r->block_height > 1;
    uint32_t edge = d->tile_edge;
    if (edge == 0)
        edge = blocks ? DEFAULT_BLOCK_EDGE : DEFAULT_EDGE;
    if (edge < 16 || edge > 65536 || (edge & (edge - 1)) != 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 6004, ZT__NO_OFFSET,
                        "the tile edge %u is not a power of two from 16 to 65536", (unsigned)edge);
    *out = (uint8_t)zt__log2(edge);
    return ZT_OK;
}

static zt_result fill_record(const zt_image_desc *d, const zt_format_info *format, zt__image_record *r, zt_diag *diag) {
    r->format = d->format;
    r->width = d->width;
    r->height = d->height;
    r->depth = d->depth ? d->depth : 1;
    r->layers = d->layers ? d->layers : 1;
    r->block_width = d->block_width;
    r->block_height = d->block_height;
    r->block_bytes = d->block_bytes;
    if (format && !d->block_width && !d->block_height && !d->block_bytes) {
        r->block_width = format->block_width;
        r->block_height = format->block_height;
        r->block_bytes = format->block_bytes;
    }
    r->alpha_mode = byte_of((uint32_t)d->alpha_mode);
    r->layer_kind = byte_of((uint32_t)d->layer_kind);
    r->primaries = d->primaries ? d->primaries : 1;
    r->transfer = d->transfer;
    if (r->transfer == 0)
        r->transfer = format && format->is_srgb ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
    r->full_range = 1;
    r->levels = byte_of(d->levels ? d->levels : all_levels(r));
    return tile_log2_of(d, r, &r->tile_log2, diag);
}

static zt_result check_mips(const zt__write_image *image, zt_diag *diag) {
    const zt_image_desc *d = &image->desc;
    const zt_format_info *f = image->format;
    if (d->mip_filter > ZT_MIP_BOX || d->wrap_u > ZT_WRAP_BORDER || d->wrap_v > ZT_WRAP_BORDER ||
        d->wrap_w > ZT_WRAP_BORDER)
        return zt__bad_argument(diag, "mip_filter or a wrap mode is not a number of its enum");
    if (d->given_levels || image->record.levels == 1)
        return ZT_OK;
    if (!f || !f->is_plain)
        return zt__bad_argument(diag, "levels cannot be made of this format: set given_levels");
    if (d->is_normal && f->channels < 2)
        return zt__bad_argument(diag, "a normal map has two channels at least");
    if (!d->is_normal && !zt_transfer_known(image->record.transfer))
        return zt__fail(diag, ZT_BAD_ARGUMENT, 0, ZT__NO_OFFSET,
                        "levels cannot be made with transfer %u: set given_levels", (unsigned)image->record.transfer);
    return ZT_OK;
}

static zt_result find_cover(zt__write_image *image, zt_diag *diag) {
    const zt_format_info *f = image->format;
    if (!image->desc.zero_border)
        return ZT_OK;
    if (!f || !f->is_plain || (!f->has_alpha && f->channels != 1))
        return zt__bad_argument(diag, "a zero border wants a plain format with alpha or one channel");
    image->cover_size = f->block_bytes;
    if (f->has_alpha && image->record.alpha_mode != ZT_ALPHA_PREMULTIPLIED) {
        image->cover_size = f->block_bytes / 4U;
        image->cover_at = 3 * image->cover_size;
    }
    return ZT_OK;
}

static zt_result make_units(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    void *block;
    image->unit_count = zt__unit_count(&image->record);
    ZT_TRY(zt__alloc(&w->memory, image->unit_count, sizeof *image->units, diag, &block));
    image->units = block;
    for (uint32_t i = 0; i < image->unit_count; i++) {
        zt__write_unit *u = &image->units[i];
        u->tile_count = i < image->tail_level ? image->levels[i].info.tile_count : 1;
        ZT_TRY(zt__alloc(&w->memory, u->tile_count, sizeof *u->records, diag, &block));
        u->records = block;
        ZT_TRY(zt__alloc(&w->memory, u->tile_count, sizeof *u->places, diag, &block));
        u->places = block;
    }
    return ZT_OK;
}

static zt_result make_levels(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    void *block;
    const zt__image_record *r = &image->record;
    ZT_TRY(zt__alloc(&w->memory, r->levels, sizeof *image->levels, diag, &block));
    image->levels = block;
    image->tail_level = zt__tail_level(r);
    image->tail_row_count = 0;
    for (uint32_t i = 0; i < r->levels; i++) {
        zt__write_level *l = &image->levels[i];
        zt__level_geometry(r, i, &l->info);
        l->row_count = (uint64_t)l->info.blocks_y * l->info.depth * r->layers;
        if (i >= image->tail_level)
            image->tail_row_count += l->row_count;
    }
    if (image->tail_level < r->levels)
        image->tail_size = zt__tail_size(r, image->tail_level);
    return ZT_OK;
}

zt_result zt__write_geometry(zt_writer *w, zt__write_image *image, zt_diag *diag) {
    ZT_TRY(make_levels(w, image, diag));
    return make_units(w, image, diag);
}

void zt__write_unit_free(zt_writer *w, zt__write_unit *u) {
    zt__free(&w->memory, u->records, u->tile_count, sizeof *u->records);
    zt__free(&w->memory, u->places, u->tile_count, sizeof *u->places);
    u->records = NULL;
    u->places = NULL;
}

void zt__write_geometry_free(zt_writer *w, zt__write_image *image) {
    for (uint32_t i = 0; image->units && i < image->unit_count; i++)
        zt__write_unit_free(w, &image->units[i]);
    zt__free(&w->memory, image->units, image->unit_count, sizeof *image->units);
    zt__free(&w->memory, image->levels, image->record.levels, sizeof *image->levels);
    image->units = NULL;
    image->levels = NULL;
}

static zt_result fill_image(zt_writer *w, const zt_image_desc *desc, zt__write_image *image, zt_diag *diag) {
    zt__sink sink = zt__write_sink(diag);
    image->desc = *desc;
    image->format = zt_find_format(desc->format);
    ZT_TRY(fill_record(desc, image->format, &image->record, diag));
    zt__enter(&sink, "image %u", (unsigned)w->image_count);
    zt_result r = zt__check_image(&sink, &w->limits, &image->record, ZT__NO_OFFSET);
    ZT_TRY(zt__write_verdict(diag, r));
    ZT_TRY(check_mips(image, diag));
    ZT_TRY(find_cover(image, diag));
    if (w->image_count >= w->limits.images)
        return zt__fail(diag, ZT_LIMIT, 0, ZT__NO_OFFSET, "more images than zt_limits.images");
    ZT_TRY(zt__write_geometry(w, image, diag));
    image->chooses_edge = zt__write_chooses_edge(w, image);
    return ZT_OK;
}

static zt_result add_image(zt_writer *w, const zt_image_desc *desc, zt_diag *diag, uint32_t *out) {
    void *block, *array = w->images;
    ZT_TRY(zt__grow(&w->memory, &array, &w->image_capacity, w->image_count, sizeof *w->images, diag));
    w->images = array;
    ZT_TRY(zt__alloc(&w->memory, 1, sizeof(zt__write_image), diag, &block));
    zt__write_image *image = block;
    zt_result r = fill_image(w, desc, image, diag);
    if (r != ZT_OK) {
        zt__write_image_free(w, image);
        return r;
    }
    *out = w->image_count;
    w->images[w->image_count++] = image;
    return ZT_OK;
}

void zt__write_image_free(zt_writer *w, zt__write_image *image) {
    zt__write_rows_free(w, image);
    zt__write_held_free(w, image);
    zt__write_geometry_free(w, image);
    zt__free(&w->memory, image, 1, sizeof *image);
}

zt_result zt_writer_add_image(zt_writer *writer, const zt_image_desc *desc, zt_diag *diag, uint32_t *image) {
    if (image)
        *image = ZT_NONE;
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!desc || !image)
        return zt__bad_argument(diag, "desc or image is NULL");
    zt_result r = add_image(writer, desc, diag, image);
    /* A refused declaration leaves nothing behind, also when a limit is the reason. */
    return r == ZT_LIMIT ? r : zt__writer_end(writer, r);
}

/* ---- filling ---------------------------------------------------------------------------------------------- */

static zt_result check_rows(const zt_writer *w, uint32_t image, uint32_t level, const void *rows, uint32_t count,
                            size_t pitch, zt_diag *diag) {
    if (image >= w->image_count || level >= w->images[image]->record.levels)
        return zt__bad_argument(diag, "there is no such image or level");
    const zt__write_image *i = w->images[image];
    const zt__write_level *l = &i->levels[level];
    if (level > 0 && !i->desc.given_levels)
        return zt__bad_argument(diag, "the levels of this image are made from level 0");
    uint32_t unit = zt__unit_of_level(level, i->tail_level);
    if (l->mode == ZT__WRITE_STORED || (l->mode == ZT__WRITE_UNTOUCHED && i->units[unit].tiles_done > 0))
        return zt__bad_argument(diag, "this level has got stored tiles, so it takes no rows");
    if (!rows && count > 0)
        return zt__bad_argument(diag, "the rows are NULL");
    if (count > l->row_count - l->rows_done)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 0, ZT__NO_OFFSET, "%u rows are too many: the level has %llu left",
                        (unsigned)count, (unsigned long long)(l->row_count - l->rows_done));
    if (pitch != 0 && pitch < l->info.row_size)
        return zt__bad_argument(diag, "the row pitch is less than a row");
    return ZT_OK;
}

static zt_result put_rows(zt_writer *writer, uint32_t image, uint32_t level, const void *rows, uint32_t count,
                          size_t pitch, zt_diag *diag) {
    ZT_TRY(zt__writer_begin(writer, diag));
    ZT_TRY(check_rows(writer, image, level, rows, count, pitch, diag));
    zt__write_image *i = writer->images[image];
    size_t step = pitch ? pitch : (size_t)i->levels[level].info.row_size;
    return zt__writer_end(writer, zt__write_rows(writer, i, level, rows, count, step, diag));
}

zt_result zt_writer_put_rows(zt_writer *writer, uint32_t image, const void *rows, uint32_t row_count, size_t row_pitch,
                             zt_diag *diag) {
    return put_rows(writer, image, 0, rows, row_count, row_pitch, diag);
}

zt_result zt_writer_put_level_rows(zt_writer *writer, uint32_t image, uint32_t level, const void *rows,
                                   uint32_t row_count, size_t row_pitch, zt_diag *diag) {
    return put_rows(writer, image, level, rows, row_count, row_pitch, diag);
}

/* *size: decoded bytes of the tile. */
static zt_result check_stored(const zt_writer *w, uint32_t image, uint32_t level, uint64_t tile, uint32_t *size,
                              zt_diag *diag) {
    if (image >= w->image_count)
        return zt__bad_argument(diag, "there is no such image");
    const zt__write_image *i = w->images[image];
    const zt__image_record *r = &i->record;
    if (!i->desc.given_levels || i->cover_size > 0)
        return zt__bad_argument(diag, "stored tiles want given_levels and no zero border");
    if (level >= r->levels || level > i->tail_level)
        return zt__bad_argument(diag, "there is no such level, or it is not the tail's first");
    const zt__write_unit *u = &i->units[level];
    if (tile >= u->tile_count)
        return zt__bad_argument(diag, "there is no such tile");
    uint64_t rows = level == i->tail_level ? i->tail_rows_done : i->levels[level].rows_done;
    if (rows > 0)
        return zt__bad_argument(diag, "this level has got rows, so it takes no stored tiles");
    if (u->records[tile].stored_size != 0)
        return zt__bad_argument(diag, "this tile is there already");
    *size = (uint32_t)i->tail_size;
    if (level < i->tail_level) {
        zt__tile_box box;
        zt__tile_geometry(r, &i->levels[level].info, tile, &box);
        *size = box.size;
    }
    return ZT_OK;
}

static zt_result put_tile(zt_writer *w, uint32_t image, uint32_t level, uint64_t tile, const zt__tile_record *record,
                          const void *data, zt_diag *diag) {
    uint32_t size = 0;
    zt__sink sink = zt__write_sink(diag);
    ZT_TRY(check_stored(w, image, level, tile, &size, diag));
    const zt__tile_box any = {0};
    zt__tile_form form = zt__tile_form_of(&w->images[image]->record, &any);
    bool tail = level >= w->images[image]->tail_level;
    ZT_TRY(zt__write_verdict(diag, zt__check_tile(&sink, record, size, tail ? NULL : &form, ZT__NO_OFFSET)));
    if (record->codec == ZT__CODEC_ZSTD || record->codec == ZT__CODEC_FIELDS)
        ZT_TRY(zt__write_verdict(diag, zt__check_frame(&sink, data, record->stored_size, size, ZT__NO_OFFSET)));
    if (record->codec == ZT__CODEC_RAW && zt__hash(data, size) != record->hash)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 5203, ZT__NO_OFFSET, "a raw tile does not have the hash given for it");
    zt__write_image *i = w->images[image];
    if (level < i->tail_level)
        i->levels[level].mode = ZT__WRITE_STORED;
    return zt__write_tile(w, i, level, tile, record, data, diag);
}

zt_result zt_writer_put_stored_tile(zt_writer *writer, uint32_t image, uint32_t level, uint64_t tile, uint8_t codec,
                                    uint64_t hash, const void *data, size_t size, zt_diag *diag) {
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!data || size == 0 || size > UINT32_MAX)
        return zt__bad_argument(diag, "a stored tile has 1 to 2^32 - 1 bytes");
    zt__tile_record record = {.stored_size = (uint32_t)size, .codec = codec, .hash = hash};
    return zt__writer_end(writer, put_tile(writer, image, level, tile, &record, data, diag));
}
