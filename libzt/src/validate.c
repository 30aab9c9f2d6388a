/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The validator: the walk of zt_open_... with a sink that goes on, then everything that opening leaves alone: metadata,
 * chunks of unknown types, all texels, the borders of patches.
 */
#include <string.h>

#include "base_hash.h"
#include "base_parallel.h"
#include "file_check.h"
#include "texture.h"

typedef struct validation {
    zt_file *file;
    zt__sink sink;
    const zt_check_options *options;
    uint64_t done, total; /* bytes of tiles, for progress */
    uint64_t limits_seen; /* findings of limits that next_part knows of */
} validation;

/* Results that say something about this part of the file, and not about the check: the check goes on with the next
 * part. */
static bool is_verdict(zt_result result) {
    return result == ZT_CORRUPT || result == ZT_UNSUPPORTED || result == ZT_TRUNCATED || result == ZT_LIMIT ||
           result == ZT_NOT_ZTEX;
}

/* Takes note of a part's result: ZT_OK to go on with the next part. */
static zt_result next_part(validation *v, zt_result result) {
    if (result == ZT_OK)
        return ZT_OK;
    if (!is_verdict(result))
        return result;
    v->sink.summary->complete = 0;
    if (result == ZT_LIMIT && v->sink.summary->limits == v->limits_seen) {
        /* The memory budget ended before a check could say so. */
        result = zt__report(&v->sink, 1010, ZT__NO_OFFSET, "more memory is needed than the limit (zt_limits.memory)");
    }
    v->limits_seen = v->sink.summary->limits;
    return result == ZT_CANCELLED ? result : ZT_OK;
}

static zt_result progress(validation *v, uint64_t bytes) {
    v->done += bytes;
    if (!v->options->progress || v->total == 0)
        return ZT_OK;
    double share = (double)v->done / (double)v->total;
    return v->options->progress(v->options->user, share < 1 ? share : 1) ? ZT_CANCELLED : ZT_OK;
}

/* ---- chunks ---- */

/* A chunk of a type that is not known: its head, hashes and padding. */
static zt_result check_unknown_chunk(validation *v, uint32_t chunk) {
    zt__decoder decoder;
    void *bytes;
    zt__memory *memory = &v->file->memory;
    uint64_t size = v->file->entries[chunk].decoded_size;
    zt__enter_chunk(&v->sink, v->file, chunk);
    ZT_TRY(zt__alloc_raw(memory, size, 1, v->sink.diag, &bytes));
    zt__decoder_init(&decoder, memory);
    zt_result result = zt__read_chunk(v->file, &v->sink, &decoder, chunk, bytes);
    zt__decoder_free(&decoder);
    zt__free(memory, bytes, size, 1);
    return result;
}

/* TEXL: head, padding, and the hash of its stored bytes, read in pieces. */
static zt_result check_texels_chunk(validation *v, uint32_t chunk) {
    enum { PIECE = 1 << 20 };
    const zt__entry *e = &v->file->entries[chunk];
    uint8_t head[ZT__HEAD_SIZE], padding[16];
    zt__hasher hasher;
    void *piece;
    uint64_t at = e->offset + ZT__HEAD_SIZE, end = at + e->stored_size;
    zt__enter_chunk(&v->sink, v->file, chunk);
    ZT_TRY(zt__read(&v->file->io, e->offset, head, sizeof head, v->sink.diag));
    ZT_TRY(zt__check_head(&v->sink, v->file, chunk, head));
    ZT_TRY(zt__read(&v->file->io, end, padding, (size_t)(zt__align16(end) - end), v->sink.diag));
    ZT_TRY(zt__check_chunk_padding(&v->sink, v->file, chunk, padding, (size_t)(zt__align16(end) - end)));
    ZT_TRY(zt__alloc_raw(&v->file->memory, PIECE, 1, v->sink.diag, &piece));
    zt__hash_begin(&hasher);
    zt_result result = ZT_OK;
    while (at < end && result == ZT_OK) {
        size_t size = end - at < PIECE ? (size_t)(end - at) : PIECE;
        result = zt__read(&v->file->io, at, piece, size, v->sink.diag);
        zt__hash_more(&hasher, piece, size);
        at += size;
        if (result == ZT_OK)
            result = progress(v, 0);
    }
    zt__free(&v->file->memory, piece, PIECE, 1);
    ZT_TRY(result);
    ZT_RULE(&v->sink, 4003, zt__hash_end(&hasher) == e->stored_hash, e->offset + ZT__HEAD_SIZE,
            "the hash of the stored bytes is wrong");
    return ZT_OK;
}

static zt_result check_chunks(validation *v) {
    for (uint32_t i = 0; i < v->file->chunk_count; i++) {
        const zt__entry *e = &v->file->entries[i];
        const zt__chunk_type *known = zt__find_chunk_type(e->type);
        zt_result result = ZT_OK;
        if (!known || (known->type == ZT__META && e->version != known->version)) {
            result = check_unknown_chunk(v, i);
        } else if (known->type == ZT__META) {
            zt__metadata *metadata = NULL;
            result = zt__read_metadata(v->file, &v->sink, &metadata);
            if (metadata)
                zt__free(&v->file->memory, metadata, 1, (size_t)metadata->block_size);
        } else if (known->type == ZT__TEXL) {
            result = check_texels_chunk(v, i);
        }
        ZT_TRY(next_part(v, result));
    }
    return ZT_OK;
}

/* ---- tiles ---- */

/* Tiles are decoded some at a time: each task remembers whether its tile is whole, and findings are reported afterwards
 * in order. */
enum { BATCH = 64 };

typedef struct tile_batch {
    const validation *v;
    uint32_t image, unit;
    uint64_t first;
    zt__decoder *decoders;
    bool failed[BATCH];
} tile_batch;

static zt_result read_one(const validation *v, zt__sink *sink, zt__decoder *decoder, uint32_t image, uint32_t unit,
                          uint64_t tile) {
    uint8_t *raw;
    size_t size = zt__unit_tile_size(&v->file->images[image], unit, tile);
    ZT_TRY(zt__decoder_raw(decoder, size, sink->diag, &raw));
    return zt__read_tile_into(v->file, sink, decoder, image, unit, tile, raw, 0);
}

static void tile_task(void *context, size_t index, unsigned worker) {
    tile_batch *batch = context;
    zt__sink quiet = {0};
    batch->failed[index] = read_one(batch->v, &quiet, &batch->decoders[worker], batch->image, batch->unit,
                                    batch->first + index) != ZT_OK;
}

static zt_result check_batch(validation *v, tile_batch *batch, size_t count) {
    uint64_t bytes = 0;
    zt__run(v->options->parallel, count, tile_task, batch);
    for (size_t i = 0; i < count; i++) {
        uint64_t tile = batch->first + i;
        bytes += zt__unit_tile_size(&v->file->images[batch->image], batch->unit, tile);
        if (!batch->failed[i])
            continue;
        zt__enter(&v->sink, "TEXL/image %u/unit %u/tile %llu", batch->image, batch->unit, (unsigned long long)tile);
        ZT_TRY(next_part(v, read_one(v, &v->sink, &batch->decoders[0], batch->image, batch->unit, tile)));
    }
    return progress(v, bytes);
}

static zt_result check_unit(validation *v, zt__decoder *decoders, uint32_t image, uint32_t unit) {
    const zt__tile_index *index;
    tile_batch batch = {0};
    zt__enter(&v->sink, "TEXL/image %u/unit %u", image, unit);
    ZT_TRY(zt__tile_index_of(v->file, &v->sink, image, unit, &index));
    batch.v = v;
    batch.image = image;
    batch.unit = unit;
    batch.decoders = decoders;
    for (uint64_t tile = 0; tile < index->count; tile += BATCH) {
        batch.first = tile;
        ZT_TRY(check_batch(v, &batch, index->count - tile < BATCH ? (size_t)(index->count - tile) : BATCH));
    }
    return ZT_OK;
}

static zt_result check_tiles(validation *v, zt__decoder *decoders) {
    for (uint32_t i = 0; i < v->file->image_count; i++) {
        const zt__image *image = &v->file->images[i];
        for (uint32_t k = 0; k < image->unit_count; k++)
            ZT_TRY(next_part(v, check_unit(v, decoders, i, k)));
    }
    return ZT_OK;
}

/* ---- borders of patches: R8112 ---- */

/* Finds a texel whose coverage is not zero among count texels that are stride bytes apart: its index, or count.
 * Coverage zero: all bytes of the channel zero (for floats also the sign alone: -0 covers nothing). */
static uint32_t find_covered(const zt_format_info *format, const uint8_t *texels, size_t stride, uint32_t count) {
    uint32_t channel_bytes = format->channel_bits / 8u, from = (format->channels - 1u) * channel_bytes;
    for (uint32_t i = 0; i < count; i++) {
        const uint8_t *channel = texels + (size_t)i * stride + from;
        for (uint32_t b = 0; b < channel_bytes; b++) {
            uint8_t bits = format->is_float && b == channel_bytes - 1 ? channel[b] & 0x7F : channel[b];
            if (bits)
                return i;
        }
    }
    return count;
}

/* A row or column of texels at first, stride bytes apart. */
static zt_result check_strip(validation *v, uint32_t image, const zt_region *strip, const uint8_t *first,
                             size_t stride) {
    uint32_t count = strip->width * strip->height;
    uint32_t covered = find_covered(v->file->images[image].format, first, stride, count);
    if (covered == count)
        return ZT_OK;
    zt__enter(&v->sink, "image %u/level %u/layer %u", image, strip->level, strip->layer);
    return zt__report(&v->sink, 8112, ZT__NO_OFFSET, "the coverage of the border texel %u, %u is not zero",
                      strip->x + covered % strip->width, strip->y + covered / strip->width);
}

static zt_result decode_strip(validation *v, uint32_t image, const zt_region *strip) {
    uint32_t bytes = v->file->images[image].format->block_bytes;
    uint64_t size = (uint64_t)strip->width * strip->height * bytes;
    void *texels;
    ZT_TRY(zt__alloc_raw(&v->file->memory, size, 1, v->sink.diag, &texels));
    zt_result result = zt_decode_region(v->file, image, strip, texels, (size_t)size, 0, 0, NULL, NULL);
    /* What cannot be decoded has been reported with the tiles. */
    result = result == ZT_OK ? check_strip(v, image, strip, texels, bytes) : ZT_OK;
    zt__free(&v->file->memory, texels, size, 1);
    return result;
}

/* The four borders of one layer of a level, which is decoded at texels, or NULL: they are decoded each. */
static zt_result check_layer_border(validation *v, uint32_t image, uint32_t level, uint32_t layer,
                                    const zt_level_info *info, const uint8_t *texels) {
    size_t pixel = v->file->images[image].format->block_bytes, row = (size_t)info->row_size;
    const zt_region strips[4] = {{level, layer, 0, 0, 0, info->width, 1, 1},
                                 {level, layer, 0, info->height - 1, 0, info->width, 1, 1},
                                 {level, layer, 0, 0, 0, 1, info->height, 1},
                                 {level, layer, info->width - 1, 0, 0, 1, info->height, 1}};
    for (int i = 0; i < 4; i++) {
        if (texels)
            ZT_TRY(check_strip(v, image, &strips[i], texels + strips[i].y * row + strips[i].x * pixel,
                               i < 2 ? pixel : row));
        else
            ZT_TRY(decode_strip(v, image, &strips[i]));
    }
    return ZT_OK;
}

static zt_result check_level_border(validation *v, uint32_t image, uint32_t level, const uint8_t *texels) {
    zt_level_info info;
    zt__level_geometry(&v->file->images[image].record, level, &info);
    for (uint32_t layer = 0; layer < v->file->images[image].record.layers; layer++)
        ZT_TRY(check_layer_border(v, image, level, layer, &info,
                                  texels ? texels + (size_t)(layer * info.layer_size) : NULL));
    return ZT_OK;
}

/* The tail is decoded once: for each of its layers anew, a small file could keep a machine busy. */
static zt_result check_tail_border(validation *v, uint32_t image) {
    const zt__image *im = &v->file->images[image];
    uint64_t size = zt__tail_size(&im->record, im->tail_level);
    void *texels;
    ZT_TRY(zt__alloc_raw(&v->file->memory, size, 1, v->sink.diag, &texels));
    bool whole = zt_decode_tile(v->file, image, im->tail_level, 0, texels, (size_t)size, NULL) == ZT_OK;
    zt_result result = ZT_OK;
    for (uint32_t level = im->tail_level; whole && level < im->record.levels && result == ZT_OK; level++)
        result = check_level_border(v, image, level, (const uint8_t *)texels + zt__tail_offset(&im->record, level));
    zt__free(&v->file->memory, texels, size, 1);
    return result;
}

static zt_result check_border(validation *v, uint32_t image) {
    const zt__image *im = &v->file->images[image];
    if (!im->format || !im->format->is_plain || im->format->channel_bits == 0)
        return ZT_OK;
    for (uint32_t level = 0; level < im->tail_level; level++)
        ZT_TRY(check_level_border(v, image, level, NULL));
    return im->tail_level < im->record.levels ? check_tail_border(v, image) : ZT_OK;
}

/* The image whose alpha, or only channel, is a patch's coverage; ZT_NONE: a texture, or none (R8107 has said so). */
static uint32_t coverage_image(const validation *v, const zt__zipmap *zipmap, uint32_t patch) {
    if (zipmap->masks[patch] != ZT_NONE)
        return zipmap->masks[patch];
    if (zipmap->source_kinds[patch] != 0)
        return ZT_NONE;
    uint32_t image = zipmap->sources[patch];
    return v->file->images[image].record.alpha_mode == ZT_ALPHA_NONE ? ZT_NONE : image;
}

static zt_result check_borders(validation *v) {
    void *block;
    zt_result result = ZT_OK;
    ZT_TRY(zt__alloc(&v->file->memory, v->file->image_count, 1, v->sink.diag, &block));
    uint8_t *seen = block; /* images that many patches show are looked at once */
    for (uint32_t t = 0; t < v->file->texture_count && result == ZT_OK; t++) {
        const zt__zipmap *zipmap = zt__zipmap_of(v->file, t);
        for (uint32_t i = 1; zipmap && i < zipmap->patch_count && result == ZT_OK; i++) {
            uint32_t image = coverage_image(v, zipmap, i);
            if (image == ZT_NONE || seen[image])
                continue;
            seen[image] = 1;
            result = check_border(v, image);
        }
    }
    zt__free(&v->file->memory, block, v->file->image_count, 1);
    return result;
}

/* ---- the check ---- */

static zt_result check_texels(validation *v) {
    unsigned workers = zt__workers(v->options->parallel);
    void *block;
    for (uint32_t i = 0; i < v->file->image_count; i++) {
        zt_level_info info;
        for (uint32_t k = 0; k < v->file->images[i].record.levels; k++) {
            zt__level_geometry(&v->file->images[i].record, k, &info);
            v->total += info.level_size;
        }
    }
    ZT_TRY(zt__alloc(&v->file->memory, workers, sizeof(zt__decoder), v->sink.diag, &block));
    zt__decoder *decoders = block;
    for (unsigned i = 0; i < workers; i++)
        zt__decoder_init(&decoders[i], &v->file->memory);
    zt_result result = check_tiles(v, decoders);
    for (unsigned i = 0; i < workers; i++)
        zt__decoder_free(&decoders[i]);
    zt__free(&v->file->memory, block, workers, sizeof(zt__decoder));
    return result == ZT_OK ? check_borders(v) : result;
}

static zt_result run_check(validation *v) {
    bool usable;
    zt_result result = zt__walk(v->file, &v->sink, &zt__texture_hooks, &usable);
    ZT_TRY(next_part(v, result));
    if ((v->options->flags & ZT_CHECK_STRUCTURE) || !usable)
        return ZT_OK;
    ZT_TRY(check_chunks(v));
    return check_texels(v);
}

static zt_result check_file(zt_file *file, const zt_check_options *options, zt_diag *diag, zt_check_summary *out) {
    validation v = {0};
    zt_diag own = {0};
    v.file = file;
    v.options = options;
    v.sink.check = options;
    v.sink.summary = out;
    v.sink.diag = diag ? diag : &own;
    out->complete = 1;
    zt_result result = run_check(&v);
    if (result == ZT_CANCELLED)
        zt__fail(diag, ZT_CANCELLED, 0, ZT__NO_OFFSET, "the check was cancelled");
    if (result == ZT_OK)
        zt__begin(diag); /* what stopped one part has been reported as a finding */
    return result;
}

static zt_result check_source(const zt__source *source, const zt_check_options *options, zt_diag *diag,
                              zt_check_summary *out) {
    zt_check_options filled = {0};
    zt_open_options open = {0};
    zt_file *file;
    zt__begin(diag);
    if (!out)
        return zt__bad_argument(diag, "out is NULL");
    memset(out, 0, sizeof *out);
    if (options && options->size != 0 && options->size != sizeof *options)
        return zt__bad_argument(diag, "zt_check_options.size is not sizeof(zt_check_options)");
    if (options)
        filled = *options;
    open.allocator = filled.allocator;
    open.limits = filled.limits;
    ZT_TRY(zt__file_new(&open, source, diag, &file));
    zt_result result = check_file(file, &filled, diag, out);
    zt__file_free(file, &zt__texture_hooks);
    return result;
}

zt_result zt_check_memory(const void *data, size_t size, const zt_check_options *options, zt_diag *diag,
                          zt_check_summary *out) {
    const zt__source source = {.kind = ZT__FROM_MEMORY, .data = data, .size = size};
    return check_source(&source, options, diag, out);
}

zt_result zt_check_path(const char *path, const zt_check_options *options, zt_diag *diag, zt_check_summary *out) {
    const zt__source source = {.kind = ZT__FROM_PATH, .path = path};
    return check_source(&source, options, diag, out);
}

zt_result zt_check_io(const zt_io *io, const zt_check_options *options, zt_diag *diag, zt_check_summary *out) {
    const zt__source source = {.kind = ZT__FROM_IO, .io = io};
    return check_source(&source, options, diag, out);
}
