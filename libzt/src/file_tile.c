/* SPDX-License-Identifier: Apache-2.0 */
/* Tile indices, and decoding of tiles and regions (spec/ztex.md sections 6.3 and 8.2). */
#include "base_hash.h"
#include "base_parallel.h"
#include "file_check.h"
#include "file_open.h"

/* A tile as rows of bytes: a tail is one row. */
typedef struct tile_rows {
    zt__tile_form form; /* R5301 and R5401 have passed */
    size_t row_size, row_count;
} tile_rows;

static tile_rows rows_of(const zt__image *image, uint32_t unit, uint64_t tile) {
    tile_rows rows = {.row_count = 1};
    zt_level_info level;
    zt__tile_box box;
    if (unit >= image->tail_level) {
        rows.row_size = (size_t)zt__tail_size(&image->record, image->tail_level);
        return rows;
    }
    zt__level_geometry(&image->record, unit, &level);
    zt__tile_geometry(&image->record, &level, tile, &box);
    rows.form = zt__tile_form_of(&image->record, &box);
    rows.row_size = (size_t)box.width * image->record.block_bytes;
    rows.row_count = box.height;
    return rows;
}

uint32_t zt__unit_tile_size(const zt__image *image, uint32_t unit, uint64_t tile) {
    tile_rows rows = rows_of(image, unit, tile);
    return (uint32_t)(rows.row_size * rows.row_count); /* R6004: at most 2^30 */
}

/* ---- the index ---- */

static zt_result check_index(zt__sink *sink, const zt__image *image, uint32_t unit_index, const zt__unit *unit,
                             zt__tile_index *index, uint64_t at) {
    zt_level_info level;
    zt__tile_box box = {0};
    uint64_t sum = 0;
    bool tail = unit_index >= image->tail_level;
    zt__level_geometry(&image->record, unit_index, &level);
    const zt__tile_form form = zt__tile_form_of(&image->record, &box); /* of any tile: only what is allowed */
    for (uint64_t i = 0; i < index->count; i++) {
        if (tail)
            box.size = (uint32_t)zt__tail_size(&image->record, image->tail_level);
        else
            zt__tile_geometry(&image->record, &level, i, &box);
        ZT_TRY(zt__check_tile(sink, &index->records[i], box.size, tail ? NULL : &form, at + i * ZT__TILE_RECORD_SIZE));
        index->offsets[i] = sum;
        sum += index->records[i].stored_size;
    }
    index->offsets[index->count] = sum;
    ZT_RULE(sink, 5205, sum == unit->record.size - index->count * ZT__TILE_RECORD_SIZE, at,
            "the tiles have %llu bytes, the unit has room for %llu", (unsigned long long)sum,
            (unsigned long long)(unit->record.size - index->count * ZT__TILE_RECORD_SIZE));
    return ZT_OK;
}

static zt_result fill_index(const zt_file *file, zt__sink *sink, uint32_t image_index, uint32_t unit_index,
                            const uint8_t *bytes, zt__tile_index *index) {
    const zt__image *image = &file->images[image_index];
    const zt__unit *unit = &file->units[image->first_unit + unit_index];
    uint64_t at = file->texels_offset + unit->record.offset;
    size_t size = (size_t)(index->count * ZT__TILE_RECORD_SIZE);
    zt__cursor in = zt__cursor_of(bytes, size);
    zt__coder coder = zt__reading(&in);
    ZT_RULE(sink, 5204, zt__hash(bytes, size) == unit->record.index_hash, at, "the hash of the tile index is wrong");
    for (uint64_t i = 0; i < index->count; i++)
        zt__code_tile(&coder, &index->records[i]);
    return check_index(sink, image, unit_index, unit, index, at);
}

static zt_result load_index(const zt_file *file, zt__sink *sink, uint32_t image, uint32_t unit_index,
                            zt__tile_index **out) {
    const zt__unit *unit = &file->units[file->images[image].first_unit + unit_index];
    zt__memory *memory = zt__memory_of(file);
    uint64_t count = unit->tile_count, bytes_size = count * ZT__TILE_RECORD_SIZE;
    uint64_t size = sizeof(zt__tile_index) + (count + 1) * sizeof(uint64_t) + count * sizeof(zt__tile_record);
    uint64_t at = file->texels_offset + unit->record.offset;
    void *block, *bytes;
    ZT_RULE(sink, 2006, zt__range_ok(at, bytes_size, file->io.size), file->io.size,
            "the tile index at %llu is not in the file", (unsigned long long)at);
    ZT_TRY(zt__alloc_raw(memory, size, 1, sink->diag, &block));
    zt__tile_index *index = block;
    index->count = count;
    index->block_size = size;
    index->offsets = (uint64_t *)(index + 1);
    index->records = (zt__tile_record *)(index->offsets + count + 1);
    zt_result result = zt__alloc_raw(memory, bytes_size, 1, sink->diag, &bytes);
    if (result == ZT_OK)
        result = zt__read(&file->io, at, bytes, (size_t)bytes_size, sink->diag);
    if (result == ZT_OK)
        result = fill_index(file, sink, image, unit_index, bytes, index);
    zt__free(memory, bytes, bytes_size, 1);
    if (result != ZT_OK) {
        zt__free(memory, block, 1, (size_t)size);
        return result;
    }
    *out = index;
    return ZT_OK;
}

zt_result zt__tile_index_of(const zt_file *file, zt__sink *sink, uint32_t image, uint32_t unit,
                            const zt__tile_index **out) {
    zt__unit *u = &file->units[file->images[image].first_unit + unit];
    zt__tile_index *index = atomic_load_explicit(&u->index, memory_order_acquire), *fresh = NULL;
    if (!index) {
        ZT_TRY(load_index(file, sink, image, unit, &fresh));
        if (atomic_compare_exchange_strong(&u->index, &index, fresh))
            index = fresh;
        else /* another thread was first: its index is the same */
            zt__free(zt__memory_of(file), fresh, 1, (size_t)fresh->block_size);
    }
    *out = index;
    return ZT_OK;
}

/* ---- one tile ---- */

/* Place of a tile's stored bytes in the file. */
static uint64_t tile_place(const zt_file *file, uint32_t image, uint32_t unit, const zt__tile_index *index,
                           uint64_t tile) {
    const zt__unit *u = &file->units[file->images[image].first_unit + unit];
    return file->texels_offset + u->record.offset + index->count * ZT__TILE_RECORD_SIZE + index->offsets[tile];
}

static zt_result read_stored(const zt_file *file, zt__sink *sink, uint64_t at, void *dst, size_t size) {
    ZT_RULE(sink, 2006, zt__range_ok(at, size, file->io.size), file->io.size, "the tile at %llu is not in the file",
            (unsigned long long)at);
    return zt__read(&file->io, at, dst, size, sink->diag);
}

/* The stored bytes of a tile: where they lie, when the file is in memory, else read into the decoder's buffer. */
static zt_result stored_bytes(const zt_file *file, zt__sink *sink, zt__decoder *decoder, uint64_t at, size_t size,
                              const uint8_t **out) {
    uint8_t *buffer;
    *out = zt__bytes_in_memory(&file->io, at, size);
    if (*out)
        return ZT_OK;
    ZT_TRY(zt__decoder_stored(decoder, size, sink->diag, &buffer));
    ZT_TRY(read_stored(file, sink, at, buffer, size));
    *out = buffer;
    return ZT_OK;
}

static zt_result decode_tile(const zt_file *file, zt__sink *sink, zt__decoder *decoder, const zt__tile_record *record,
                             const tile_rows *rows, uint64_t at, uint8_t *dst, size_t pitch) {
    const uint8_t *stored;
    uint8_t *tight = dst;
    size_t size = rows->row_size * rows->row_count;
    ZT_TRY(stored_bytes(file, sink, decoder, at, record->stored_size, &stored));
    if (record->codec == ZT__CODEC_PRED)
        return zt__decode_pred(sink, decoder, &rows->form.shape, stored, record->stored_size, dst, pitch, record->hash,
                               at);
    if (record->codec == ZT__CODEC_FIELDS)
        return zt__decode_fields(sink, decoder, rows->form.fields, rows->row_size, rows->row_count, stored,
                                 record->stored_size, dst, pitch, record->hash, at);
    if (pitch != rows->row_size)
        ZT_TRY(zt__decoder_raw(decoder, size, sink->diag, &tight));
    ZT_TRY(zt__decode_stored(sink, decoder, record->codec, stored, record->stored_size, tight, size, record->hash, 5203,
                             at));
    for (size_t y = 0; tight != dst && y < rows->row_count; y++)
        memcpy(dst + y * pitch, tight + y * rows->row_size, rows->row_size);
    return ZT_OK;
}

zt_result zt__read_tile_into(const zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t image, uint32_t unit,
                             uint64_t tile, void *dst, size_t pitch) {
    const zt__tile_index *index;
    ZT_TRY(zt__tile_index_of(file, sink, image, unit, &index));
    const zt__tile_record *record = &index->records[tile];
    uint64_t at = tile_place(file, image, unit, index, tile);
    if (record->codec > ZT__CODEC_PRED && record->codec != ZT__CODEC_FIELDS) {
        if (sink->check)
            ZT_TRY(zt__report(sink, 5201, at, "tile codec %u is not known", record->codec));
        return zt__fail(sink->diag, ZT_UNSUPPORTED, 5201, at, "tile codec %u is not known", record->codec);
    }
    tile_rows rows = rows_of(&file->images[image], unit, tile);
    return decode_tile(file, sink, decoder, record, &rows, at, dst, pitch ? pitch : rows.row_size);
}

/* ---- regions ---- */

/* What all tasks of one region share. Sizes are in blocks, tiles are counted within the region. */
typedef struct region_job {
    const zt_file *file;
    uint32_t image, unit;
    zt_region region;
    zt_level_info level;
    uint32_t x, y, width, height; /* the region in blocks */
    uint32_t tile_x, tile_y;      /* first tile */
    uint32_t tiles_x, tiles_y;    /* tiles that it touches, in a slice */
    uint8_t *dst;
    size_t row_pitch, slice_pitch;
    zt__decoder *decoders;   /* one for each worker */
    uint64_t first_task;     /* those before it are done */
    _Atomic uint64_t failed; /* lowest index of a task that failed, or UINT64_MAX */
} region_job;

/* Copies what a decoded tile and the region share. */
static void copy_blocks(const region_job *job, const zt__tile_box *box, const uint8_t *src, size_t src_pitch,
                        uint8_t *slice) {
    uint32_t bytes = job->file->images[job->image].record.block_bytes;
    uint32_t x0 = zt__max32(box->x, job->x), x1 = zt__min32(box->x + box->width, job->x + job->width);
    uint32_t y0 = zt__max32(box->y, job->y), y1 = zt__min32(box->y + box->height, job->y + job->height);
    for (uint32_t y = y0; y < y1; y++) {
        const uint8_t *from = src + (size_t)(y - box->y) * src_pitch + (size_t)(x0 - box->x) * bytes;
        uint8_t *to = slice + (size_t)(y - job->y) * job->row_pitch + (size_t)(x0 - job->x) * bytes;
        memcpy(to, from, (size_t)(x1 - x0) * bytes);
    }
}

/* All of the tile is wanted: it is decoded in its place. */
static bool goes_straight(const region_job *job, const zt__tile_box *box) {
    return box->x >= job->x && box->x + box->width <= job->x + job->width && box->y >= job->y &&
           box->y + box->height <= job->y + job->height;
}

static zt_result decode_one(region_job *job, size_t index, zt__decoder *decoder, zt__sink *sink) {
    const zt__image *image = &job->file->images[job->image];
    uint64_t per_slice = (uint64_t)job->tiles_x * job->tiles_y;
    uint32_t z = (uint32_t)(index / per_slice), in_slice = (uint32_t)(index % per_slice);
    uint64_t slice = (uint64_t)job->region.layer * job->level.depth + job->region.z + z;
    uint64_t tile = (slice * job->level.tiles_y + job->tile_y + in_slice / job->tiles_x) * job->level.tiles_x +
                    job->tile_x + in_slice % job->tiles_x;
    uint8_t *out = job->dst + (size_t)z * job->slice_pitch, *raw;
    zt__tile_box box;
    zt__tile_geometry(&image->record, &job->level, tile, &box);
    zt__enter(sink, "image %u/level %u/tile %llu", job->image, job->unit, (unsigned long long)tile);
    uint32_t bytes = image->record.block_bytes;
    if (goes_straight(job, &box)) {
        out += (size_t)(box.y - job->y) * job->row_pitch + (size_t)(box.x - job->x) * bytes;
        return zt__read_tile_into(job->file, sink, decoder, job->image, job->unit, tile, out, job->row_pitch);
    }
    ZT_TRY(zt__decoder_raw(decoder, box.size, sink->diag, &raw));
    ZT_TRY(zt__read_tile_into(job->file, sink, decoder, job->image, job->unit, tile, raw, 0));
    copy_blocks(job, &box, raw, (size_t)box.width * bytes, out);
    return ZT_OK;
}

static void decode_task(void *context, size_t i, unsigned worker) {
    region_job *job = context;
    zt__sink sink = {0};
    uint64_t index = job->first_task + i;
    if (index > atomic_load_explicit(&job->failed, memory_order_relaxed))
        return;
    if (decode_one(job, (size_t)index, &job->decoders[worker], &sink) == ZT_OK)
        return;
    uint64_t lowest = atomic_load(&job->failed);
    while (index < lowest && !atomic_compare_exchange_weak(&job->failed, &lowest, index))
        ;
}

/* A task that fails is done once more, alone: so the same error is told whatever the number of threads. When it then
 * succeeds, because its bytes have come in between, those behind it follow. */
static zt_result run_tasks(region_job *job, const zt_parallel *parallel, uint64_t count, zt_diag *diag) {
    for (;;) {
        zt__sink sink = {0};
        atomic_store(&job->failed, UINT64_MAX);
        zt__run(parallel, (size_t)(count - job->first_task), decode_task, job);
        uint64_t failed = atomic_load(&job->failed);
        if (failed == UINT64_MAX)
            return ZT_OK;
        sink.diag = diag;
        ZT_TRY(decode_one(job, (size_t)failed, &job->decoders[0], &sink));
        job->first_task = failed + 1;
    }
}

/* Takes the memory that tiles of codecs 2 and 4 will want. When there is none, the task that misses it will say so. */
static void prepare_decoder(const region_job *job, zt__decoder *decoder) {
    const zt__image *image = &job->file->images[job->image];
    tile_rows rows = rows_of(image, job->unit, 0); /* none is larger */
    if (rows.form.shape.channels > 0)
        zt__decoder_reserve(decoder, zt__pred_scratch_size(&rows.form.shape));
    else if (rows.form.fields)
        zt__decoder_reserve(decoder, rows.row_size * rows.row_count);
}

static zt_result run_region(region_job *job, const zt_parallel *parallel, zt_diag *diag) {
    unsigned workers = zt__workers(parallel);
    uint64_t count = (uint64_t)job->tiles_x * job->tiles_y * job->region.depth;
    zt__memory *memory = zt__memory_of(job->file);
    void *block;
    ZT_TRY(zt__alloc(memory, workers, sizeof *job->decoders, diag, &block));
    job->decoders = block;
    for (unsigned i = 0; i < workers; i++)
        zt__decoder_init(&job->decoders[i], memory);
    /* In this thread, since the system's allocator gives other threads fresh pages for each run. */
    for (unsigned i = 1; i < workers && i < count; i++)
        prepare_decoder(job, &job->decoders[i]);
    atomic_init(&job->failed, UINT64_MAX);
    zt_result result = run_tasks(job, parallel, count, diag);
    for (unsigned i = 0; i < workers; i++)
        zt__decoder_free(&job->decoders[i]);
    zt__free(memory, block, workers, sizeof *job->decoders);
    return result;
}

/* The tail is decoded whole; the region is cut from its level. */
static zt_result run_tail(region_job *job, zt_diag *diag) {
    const zt__image *image = &job->file->images[job->image];
    zt__decoder decoder;
    zt__sink sink = {0};
    uint8_t *raw;
    size_t size = (size_t)zt__tail_size(&image->record, image->tail_level);
    zt__tile_box box = {job->region.layer, 0, 0, 0, job->level.blocks_x, job->level.blocks_y, 0};
    sink.diag = diag;
    zt__enter(&sink, "image %u/tail", job->image);
    zt__decoder_init(&decoder, zt__memory_of(job->file));
    zt_result result = zt__decoder_raw(&decoder, size, diag, &raw);
    if (result == ZT_OK)
        result = zt__read_tile_into(job->file, &sink, &decoder, job->image, job->unit, 0, raw, 0);
    for (uint32_t z = 0; result == ZT_OK && z < job->region.depth; z++) {
        uint64_t at = zt__tail_offset(&image->record, job->region.level) + job->region.layer * job->level.layer_size +
                      (job->region.z + z) * job->level.slice_size;
        copy_blocks(job, &box, raw + at, (size_t)job->level.row_size, job->dst + (size_t)z * job->slice_pitch);
    }
    zt__decoder_free(&decoder);
    return result;
}

/* One direction of a region: texels to blocks. False when it leaves the level, is empty, or cuts a block. */
static bool to_blocks(uint32_t first, uint32_t count, uint32_t edge, uint32_t block, uint32_t *first_block,
                      uint32_t *block_count) {
    if (count == 0 || first >= edge || count > edge - first)
        return false;
    uint32_t end = first + count;
    if (first % block != 0 || (end % block != 0 && end != edge))
        return false;
    *first_block = first / block;
    *block_count = (uint32_t)zt__ceil_div(end, block) - *first_block;
    return true;
}

/* Fills in default pitches and checks that everything lies inside dst. */
static zt_result check_destination(region_job *job, size_t dst_size, zt_diag *diag) {
    uint64_t row = (uint64_t)job->width * job->file->images[job->image].record.block_bytes, slice, last, need;
    if (job->row_pitch == 0)
        job->row_pitch = (size_t)row;
    if (job->row_pitch < row)
        return zt__bad_argument(diag, "row_pitch is less than a row of the region");
    if (!zt__mul64(job->row_pitch, job->height, &slice) || slice > SIZE_MAX)
        return zt__bad_argument(diag, "row_pitch is too large");
    if (job->slice_pitch == 0)
        job->slice_pitch = (size_t)slice;
    if (job->region.depth > 1 && job->slice_pitch < slice)
        return zt__bad_argument(diag, "slice_pitch is less than a slice of the region");
    if (!zt__mul64(job->slice_pitch, job->region.depth - 1u, &last) ||
        !zt__add64(last, slice - job->row_pitch + row, &need) || need > dst_size)
        return zt__bad_argument(diag, "dst_size is too small for the region");
    return ZT_OK;
}

zt_result zt_decode_region(const zt_file *file, uint32_t image, const zt_region *region, void *dst, size_t dst_size,
                           size_t row_pitch, size_t slice_pitch, const zt_decode_options *options, zt_diag *diag) {
    region_job job = {0};
    zt__begin(diag);
    if (!file || !region || !dst)
        return zt__bad_argument(diag, "an argument is NULL");
    if (options && options->size != 0 && options->size != sizeof *options)
        return zt__bad_argument(diag, "zt_decode_options.size is not sizeof(zt_decode_options)");
    if (image >= file->image_count)
        return zt__bad_argument(diag, "there is no such image");
    const zt__image *im = &file->images[image];
    if (region->level >= im->record.levels || region->layer >= im->record.layers)
        return zt__bad_argument(diag, "there is no such level or layer");
    zt__level_geometry(&im->record, region->level, &job.level);
    if (!to_blocks(region->x, region->width, job.level.width, im->record.block_width, &job.x, &job.width) ||
        !to_blocks(region->y, region->height, job.level.height, im->record.block_height, &job.y, &job.height) ||
        region->depth == 0 || region->z >= job.level.depth || region->depth > job.level.depth - region->z)
        return zt__bad_argument(diag, "the region is empty, leaves the level, or cuts a texel block");
    job.file = file;
    job.image = image;
    job.unit = zt__unit_of_level(region->level, im->tail_level);
    job.region = *region;
    job.dst = dst;
    job.row_pitch = row_pitch;
    job.slice_pitch = slice_pitch;
    ZT_TRY(check_destination(&job, dst_size, diag));
    if (region->level >= im->tail_level)
        return run_tail(&job, diag);
    job.tile_x = job.x >> im->record.tile_log2;
    job.tile_y = job.y >> im->record.tile_log2;
    job.tiles_x = ((job.x + job.width - 1) >> im->record.tile_log2) - job.tile_x + 1;
    job.tiles_y = ((job.y + job.height - 1) >> im->record.tile_log2) - job.tile_y + 1;
    return run_region(&job, options ? options->parallel : NULL, diag);
}

zt_result zt_decode_level(const zt_file *file, uint32_t image, uint32_t level, uint32_t layer, void *dst,
                          size_t dst_size, size_t row_pitch, const zt_decode_options *options, zt_diag *diag) {
    zt_level_info info;
    zt_region region = {0};
    zt__begin(diag);
    if (!file || zt_get_level(file, image, level, &info) != ZT_OK)
        return zt__bad_argument(diag, "there is no such image or level");
    region.level = level;
    region.layer = layer;
    region.width = info.width;
    region.height = info.height;
    region.depth = info.depth;
    return zt_decode_region(file, image, &region, dst, dst_size, row_pitch, 0, options, diag);
}

/* The common part of the calls by tile. */
static zt_result find_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, const void *out,
                           zt_diag *diag, uint32_t *unit) {
    zt__begin(diag);
    if (!file || !out)
        return zt__bad_argument(diag, "an argument is NULL");
    if (image >= file->image_count || level >= file->images[image].record.levels)
        return zt__bad_argument(diag, "there is no such image or level");
    *unit = zt__unit_of_level(level, file->images[image].tail_level);
    if (tile >= file->units[file->images[image].first_unit + *unit].tile_count)
        return zt__bad_argument(diag, "there is no such tile");
    return ZT_OK;
}

zt_result zt_get_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, zt_tile_info *out,
                      zt_diag *diag) {
    uint32_t unit = 0;
    const zt__tile_index *index;
    zt__sink sink = {0};
    if (out)
        memset(out, 0, sizeof *out);
    ZT_TRY(find_tile(file, image, level, tile, out, diag, &unit));
    sink.diag = diag;
    zt__enter(&sink, "image %u/unit %u", image, unit);
    ZT_TRY(zt__tile_index_of(file, &sink, image, unit, &index));
    out->offset = tile_place(file, image, unit, index, tile);
    out->stored_size = index->records[tile].stored_size;
    out->decoded_size = zt__unit_tile_size(&file->images[image], unit, tile);
    out->hash = index->records[tile].hash;
    out->codec = index->records[tile].codec;
    return ZT_OK;
}

zt_result zt_decode_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, void *dst, size_t dst_size,
                         zt_diag *diag) {
    uint32_t unit = 0;
    zt__sink sink = {0};
    zt__decoder decoder;
    ZT_TRY(find_tile(file, image, level, tile, dst, diag, &unit));
    uint32_t size = zt__unit_tile_size(&file->images[image], unit, tile);
    if (dst_size < size)
        return zt__bad_argument(diag, "dst_size is less than the decoded size of the tile");
    sink.diag = diag;
    zt__enter(&sink, "image %u/unit %u/tile %llu", image, unit, (unsigned long long)tile);
    zt__decoder_init(&decoder, zt__memory_of(file));
    zt_result result = zt__read_tile_into(file, &sink, &decoder, image, unit, tile, dst, 0);
    zt__decoder_free(&decoder);
    return result;
}

zt_result zt_read_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, void *dst, size_t dst_size,
                       zt_diag *diag) {
    zt_tile_info info;
    zt__sink sink = {0};
    if (!dst) {
        zt__begin(diag);
        return zt__bad_argument(diag, "dst is NULL");
    }
    ZT_TRY(zt_get_tile(file, image, level, tile, &info, diag));
    if (dst_size < info.stored_size)
        return zt__bad_argument(diag, "dst_size is less than the stored size of the tile");
    sink.diag = diag;
    return read_stored(file, &sink, info.offset, dst, info.stored_size);
}
