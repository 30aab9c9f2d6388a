/* SPDX-License-Identifier: Apache-2.0 */
/* Texels of a damaged file: intact tiles are copied as they are stored, lost ones are filled from other levels. */
#include "base_hash.h"
#include "recover.h"

/* ---- filling ---- */

/* One direction: where the texels first .. first + count of a level lie in another one, which has `edge` texels. */
static uint32_t to_source(uint32_t texel, uint32_t level, uint32_t source, uint32_t edge) {
    if (source >= level)
        return zt__min32(texel >> (source - level), edge - 1);
    uint32_t shift = level - source;
    uint64_t at = ((uint64_t)texel << shift) + (UINT32_C(1) << shift) / 2;
    return at < edge ? (uint32_t)at : edge - 1;
}

/* Fills a box of one slice with the nearest texels of another level. False when those cannot be read; for want of
 * memory, r->no_memory too. */
static bool fill_box(zt__recovery *r, uint32_t image, uint32_t level, const zt__tile_box *box, uint32_t source,
                     uint8_t *dst) {
    zt_level_info from, info;
    void *block;
    uint32_t bytes = r->file->images[image].record.block_bytes;
    const zt__image_record *record = &r->file->images[image].record;
    zt__level_geometry(record, source, &from);
    zt__level_geometry(record, level, &info);
    uint32_t x0 = to_source(box->x, level, source, from.width), y0 = to_source(box->y, level, source, from.height);
    zt_region region = {
        .level = source,
        .layer = box->layer,
        .x = x0,
        .y = y0,
        .z = to_source(box->z, level, source, from.depth),
        .width = to_source(box->x + box->width - 1, level, source, from.width) - x0 + 1,
        .height = to_source(box->y + box->height - 1, level, source, from.height) - y0 + 1,
        .depth = 1,
    };
    uint64_t row = (uint64_t)region.width * bytes, size = row * region.height;
    zt_result result = zt__alloc_raw(&r->memory, size, 1, NULL, &block);
    const uint8_t *texels = block;
    if (result == ZT_OK)
        result = zt_decode_region(r->file, image, &region, block, (size_t)size, 0, 0, NULL, NULL);
    bool ok = result == ZT_OK;
    r->no_memory |= result == ZT_NO_MEMORY;
    for (uint32_t y = 0; ok && y < box->height; y++) {
        const uint8_t *line = texels + (to_source(box->y + y, level, source, from.height) - y0) * row;
        for (uint32_t x = 0; x < box->width; x++, dst += bytes) {
            uint32_t at = to_source(box->x + x, level, source, from.width) - x0;
            memcpy(dst, line + (size_t)at * bytes, bytes);
        }
    }
    zt__free(&r->memory, block, size, 1);
    return ok;
}

/* From the nearest coarser level that can be read there, else from the nearest finer one. */
static zt_fill fill_from_levels(zt__recovery *r, uint32_t image, uint32_t level, const zt__tile_box *box,
                                uint8_t *dst) {
    const zt__image *im = &r->file->images[image];
    for (uint32_t k = level + 1; k < im->record.levels && level < im->tail_level; k++) {
        if (fill_box(r, image, level, box, k, dst))
            return ZT_FILL_COARSER;
    }
    for (uint32_t k = zt__min32(level, im->tail_level); k-- > 0;) {
        if (fill_box(r, image, level, box, k, dst))
            return ZT_FILL_FINER;
    }
    return ZT_FILL_ZERO;
}

static zt_fill fill_tail(zt__recovery *r, uint32_t image, uint8_t *dst) {
    const zt__image *im = &r->file->images[image];
    zt_fill worst = ZT_FILL_FINER;
    for (uint32_t level = im->tail_level; level < im->record.levels; level++) {
        zt_level_info info;
        zt__level_geometry(&im->record, level, &info);
        uint64_t slices = (uint64_t)im->record.layers * info.depth, at = zt__tail_offset(&im->record, level);
        for (uint64_t i = 0; i < slices; i++, at += info.slice_size) {
            zt__tile_box box = {
                (uint32_t)(i / info.depth), (uint32_t)(i % info.depth), 0, 0, info.blocks_x, info.blocks_y, 0};
            if (fill_from_levels(r, image, level, &box, dst + at) == ZT_FILL_ZERO)
                worst = ZT_FILL_ZERO;
        }
    }
    return worst;
}

/* dst has come zeroed. */
static zt_fill fill_tile(zt__recovery *r, uint32_t image, uint32_t unit, uint64_t tile, uint8_t *dst) {
    const zt__image *im = &r->file->images[image];
    zt_level_info info;
    zt__tile_box box;
    /* Blocks cannot be resized here, and made-up coverage would hide what lies beneath. */
    if (!im->format || !im->format->is_plain || r->coverage[image])
        return ZT_FILL_ZERO;
    if (unit >= im->tail_level)
        return fill_tail(r, image, dst);
    zt__level_geometry(&im->record, unit, &info);
    zt__tile_geometry(&im->record, &info, tile, &box);
    return fill_from_levels(r, image, unit, &box, dst);
}

/* ---- tiles ---- */

static zt_result put_coded(zt__recovery *r, uint32_t image, uint32_t unit, uint64_t tile, const uint8_t *raw,
                           uint32_t size) {
    zt__encoder encoder;
    void *block = NULL;
    uint8_t codec;
    size_t bound = zt__encode_bound(size), stored_size;
    ZT_TRY(zt__encoder_init(&encoder, &r->memory, 9, false, r->diag));
    zt_result result = zt__alloc_raw(&r->memory, bound, 1, r->diag, &block);
    if (result == ZT_OK)
        result = zt__encode_stored(&encoder, raw, size, block, bound, &codec, &stored_size, r->diag);
    if (result == ZT_OK)
        result = zt_writer_put_stored_tile(r->writer, image, unit, tile, codec, zt__hash(raw, size), block, stored_size,
                                           r->diag);
    zt__free(&r->memory, block, bound, 1);
    zt__encoder_free(&encoder);
    return result;
}

static zt_result replace_tile(zt__recovery *r, uint32_t image, uint32_t unit, uint64_t tile) {
    void *block;
    uint32_t size = zt__unit_tile_size(&r->file->images[image], unit, tile);
    ZT_TRY(zt__alloc(&r->memory, size, 1, r->diag, &block));
    zt_loss loss = {image, unit, tile, fill_tile(r, image, unit, tile, block)};
    /* A poorer filling than the file allows would depend on how much memory there was. */
    zt_result result = r->no_memory ? zt__fail(r->diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "no memory for other levels")
                                    : put_coded(r, image, unit, tile, block, size);
    zt__free(&r->memory, block, size, 1);
    r->report->tiles_replaced++;
    if (result == ZT_OK && r->options->loss && r->options->loss(r->options->user, &loss))
        return zt__fail(r->diag, ZT_CANCELLED, 0, ZT__NO_OFFSET, "cancelled");
    return result;
}

/* Is the tile in the damaged file? What decodes to the right hash is; a codec that is not known cannot be asked, and
 * counts when its bytes are there. */
static zt_result is_intact(zt__recovery *r, uint32_t image, uint32_t unit, uint64_t tile, bool *intact) {
    uint8_t *raw;
    zt_diag diag;
    zt_tile_info info;
    zt__sink sink = {.diag = &diag};
    uint32_t size = zt__unit_tile_size(&r->file->images[image], unit, tile);
    zt__begin(&diag);
    ZT_TRY(zt__decoder_raw(&r->decoder, size, r->diag, &raw));
    zt_result result = zt__read_tile_into(r->file, &sink, &r->decoder, image, unit, tile, raw, 0);
    *intact = result == ZT_OK;
    if (result == ZT_UNSUPPORTED && zt_get_tile(r->file, image, unit, tile, &info, NULL) == ZT_OK) {
        const zt__piece *texels = &r->pieces[r->texels_piece];
        *intact = zt__range_ok(info.offset - texels->at + texels->source, info.stored_size, r->damaged->size);
    }
    if (result == ZT_IO || result == ZT_AGAIN || result == ZT_NO_MEMORY || result == ZT_LIMIT || result == ZT_INTERNAL)
        return zt__fail(r->diag, result, diag.rule, diag.offset, "%s", diag.text);
    return ZT_OK;
}

static zt_result copy_tile(zt__recovery *r, uint32_t image, uint32_t unit, uint64_t tile) {
    zt_tile_info info;
    void *block;
    ZT_TRY(zt_get_tile(r->file, image, unit, tile, &info, r->diag));
    ZT_TRY(zt__alloc_raw(&r->memory, info.stored_size, 1, r->diag, &block));
    zt_result result = zt_read_tile(r->file, image, unit, tile, block, info.stored_size, r->diag);
    if (result == ZT_OK)
        result = zt_writer_put_stored_tile(r->writer, image, unit, tile, info.codec, info.hash, block, info.stored_size,
                                           r->diag);
    zt__free(&r->memory, block, info.stored_size, 1);
    r->report->tiles_copied++;
    return result;
}

static zt_result save_unit(zt__recovery *r, uint32_t image, uint32_t unit) {
    const zt__unit *u = &r->file->units[r->file->images[image].first_unit + unit];
    for (uint64_t tile = 0; tile < u->tile_count; tile++) {
        bool intact;
        ZT_TRY(is_intact(r, image, unit, tile, &intact));
        ZT_TRY(intact ? copy_tile(r, image, unit, tile) : replace_tile(r, image, unit, tile));
        r->done++;
        if (r->options->progress && r->options->progress(r->options->user, (double)r->done / (double)r->report->tiles))
            return zt__fail(r->diag, ZT_CANCELLED, 0, ZT__NO_OFFSET, "cancelled");
    }
    return ZT_OK;
}

zt_result zt__recover_image(zt__recovery *r, uint32_t image) {
    zt_image_info info;
    zt_image_desc desc;
    uint32_t index;
    ZT_TRY(zt_get_image(r->file, image, &info));
    zt_describe_image(&info, &desc);
    ZT_TRY(zt_writer_add_image(r->writer, &desc, r->diag, &index));
    if (index != image)
        return zt__bad_argument(r->diag, "the writer is not fresh");
    for (uint32_t unit = r->file->images[image].unit_count; unit-- > 0;)
        ZT_TRY(save_unit(r, image, unit));
    return ZT_OK;
}
