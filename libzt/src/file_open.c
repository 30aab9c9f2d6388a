/* SPDX-License-Identifier: Apache-2.0 */
#include "file_open.h"

#include "base_hash.h"
#include "file_check.h"

void zt__limits_fill(zt_limits *limits) {
#define DEFAULT(field, value) \
    if (limits->field == 0)   \
    limits->field = (value)
    DEFAULT(file_size, UINT64_C(1) << 40);
    DEFAULT(memory, UINT64_C(1) << 30);
    DEFAULT(metadata, UINT64_C(1) << 24);
    DEFAULT(chunks, 65535);
    DEFAULT(textures, 65536);
    DEFAULT(images, UINT32_C(1) << 20);
    DEFAULT(dimension, UINT32_C(1) << 20);
    DEFAULT(layers, UINT32_C(1) << 16);
    DEFAULT(patches, UINT32_C(1) << 20);
    DEFAULT(tile_size, UINT32_C(1) << 26);
    DEFAULT(texture_depth, 8);
    DEFAULT(shown_textures, 4096);
    DEFAULT(listed_umbrellas, 4096);
#undef DEFAULT
}

static zt_result attach(zt_file *file, const zt__source *source, zt_diag *diag) {
    switch (source->kind) {
    case ZT__FROM_MEMORY:
        if (!source->data && source->size > 0)
            return zt__bad_argument(diag, "data is NULL");
        file->memory_io.data = source->data;
        file->memory_io.size = source->size;
        file->io = zt__io_of_memory(&file->memory_io);
        return ZT_OK;
    case ZT__FROM_PATH:
        if (!source->path)
            return zt__bad_argument(diag, "path is NULL");
        return zt__path_io_open(&file->path_io, source->path, diag, &file->io);
    case ZT__FROM_IO:
        if (!source->io || !source->io->read_at)
            return zt__bad_argument(diag, "io or its read_at is NULL");
        file->io = *source->io;
        return ZT_OK;
    }
    return ZT_INTERNAL;
}

zt_result zt__file_new(const zt_open_options *options, const zt__source *source, zt_diag *diag, zt_file **out) {
    zt_limits limits = {0};
    zt__memory memory;
    void *block;
    *out = NULL;
    if (options && options->size != 0 && options->size != sizeof *options)
        return zt__bad_argument(diag, "zt_open_options.size is not sizeof(zt_open_options)");
    if (options && options->allocator && (!options->allocator->alloc || !options->allocator->free))
        return zt__bad_argument(diag, "the allocator lacks a function");
    if (options && options->limits)
        limits = *options->limits;
    zt__limits_fill(&limits);
    zt__memory_init(&memory, options ? options->allocator : NULL, limits.memory);
    ZT_TRY(zt__alloc(&memory, 1, sizeof(zt_file), diag, &block));
    zt_file *file = block;
    zt__memory_init(&file->memory, &memory.allocator, limits.memory);
    atomic_store(&file->memory.used, sizeof(zt_file));
    file->path_io.fd = -1;
    file->limits = limits;
    file->flags = options ? options->flags : 0;
    atomic_init(&file->metadata, NULL);
    zt_result result = attach(file, source, diag);
    if (result != ZT_OK) {
        zt__file_free(file, NULL);
        return result;
    }
    *out = file;
    return ZT_OK;
}

static void free_index(zt_file *file, zt__unit *unit) {
    zt__tile_index *index = atomic_load(&unit->index);
    if (index)
        zt__free(&file->memory, index, 1, (size_t)index->block_size);
}

void zt__file_free(zt_file *file, const zt__payload_hooks *hooks) {
    if (!file)
        return;
    for (uint32_t i = 0; file->textures && i < file->texture_count; i++) {
        if (file->textures[i].payload)
            hooks->close(file, i);
    }
    for (uint32_t i = 0; file->units && i < file->unit_count; i++)
        free_index(file, &file->units[i]);
    zt__metadata *metadata = atomic_load(&file->metadata);
    if (metadata)
        zt__free(&file->memory, metadata, 1, (size_t)metadata->block_size);
    zt__free(&file->memory, file->names, file->names_size, 1);
    zt__free(&file->memory, file->layers, file->layer_count, sizeof *file->layers);
    zt__free(&file->memory, file->textures, file->texture_count, sizeof *file->textures);
    zt__free(&file->memory, file->units, file->unit_count, sizeof *file->units);
    zt__free(&file->memory, file->images, file->image_count, sizeof *file->images);
    zt__free(&file->memory, file->entries, file->chunk_count, sizeof *file->entries);
    zt__path_io_close(&file->path_io);
    zt_allocator allocator = file->memory.allocator;
    allocator.free(allocator.user, file, sizeof *file);
}

/* Reads for the walk: bytes behind the end are rule 2006. */
static zt_result walk_read(const zt_file *file, zt__sink *sink, uint64_t offset, void *dst, size_t size) {
    ZT_RULE(sink, 2006, zt__range_ok(offset, size, file->io.size), file->io.size,
            "the file ends at byte %llu, %zu bytes from %llu are wanted", (unsigned long long)file->io.size, size,
            (unsigned long long)offset);
    return zt__read(&file->io, offset, dst, size, sink->diag);
}

/* ---- preamble and directory ---- */

static zt_result read_preamble(zt_file *file, zt__sink *sink) {
    uint8_t bytes[ZT__PREAMBLE_SIZE] = {0};
    zt__preamble *p = &file->preamble;
    size_t here = file->io.size < sizeof bytes ? (size_t)file->io.size : sizeof bytes;
    zt__enter(sink, "preamble");
    ZT_TRY(walk_read(file, sink, 0, bytes, here));
    /* What is not a .ztex file is named so, however short it is. */
    size_t magic = here < sizeof zt__magic ? here : sizeof zt__magic;
    if (here < sizeof bytes && here > 0 && memcmp(bytes, zt__magic, magic) == 0)
        ZT_TRY(zt__report(sink, 2006, here, "%zu bytes: a preamble has %d", here, ZT__PREAMBLE_SIZE));

    zt__cursor in = zt__cursor_of(bytes, sizeof bytes);
    zt__coder coder = zt__reading(&in);
    zt__code_preamble(&coder, p);
    ZT_TRY(zt__check_preamble(sink, &file->limits, p));
    if (!(file->flags & ZT_OPEN_BEST_EFFORT))
        ZT_RULE(sink, 2006, file->io.size >= p->file_size, 16, "the file has %llu bytes and says that it has %llu",
                (unsigned long long)file->io.size, (unsigned long long)p->file_size);
    ZT_RULE(sink, 1001, file->io.size <= file->limits.file_size && p->file_size <= file->limits.file_size, 16,
            "%llu bytes: the limit is %llu (zt_limits.file_size)", (unsigned long long)p->file_size,
            (unsigned long long)file->limits.file_size);
    ZT_RULE(sink, 2007, file->io.size <= p->file_size, p->file_size, "%llu bytes follow the file",
            (unsigned long long)(file->io.size - p->file_size));
    return ZT_OK;
}

/* R2009: the hash covers the preamble up to itself, and the directory. */
static zt_result read_directory(zt_file *file, zt__sink *sink, zt__decoder *decoder) {
    enum { COVERED = 56 };
    const zt__preamble *p = &file->preamble;
    uint8_t *bytes;
    void *block;
    zt__enter(sink, "directory");
    ZT_TRY(zt__decoder_stored(decoder, (uint64_t)ZT__PREAMBLE_SIZE + p->directory_size, sink->diag, &bytes));
    ZT_TRY(walk_read(file, sink, 0, bytes, ZT__PREAMBLE_SIZE));
    ZT_TRY(walk_read(file, sink, ZT__PREAMBLE_SIZE, bytes + COVERED, p->directory_size));
    ZT_RULE(sink, 2009, zt__hash(bytes, COVERED + p->directory_size) == p->directory_hash, COVERED,
            "the hash of preamble and directory is wrong");

    ZT_TRY(zt__alloc(&file->memory, p->chunk_count, sizeof *file->entries, sink->diag, &block));
    file->entries = block;
    file->chunk_count = p->chunk_count;
    zt__cursor in = zt__cursor_of(bytes + COVERED, p->directory_size);
    zt__coder coder = zt__reading(&in);
    for (uint32_t i = 0; i < file->chunk_count; i++)
        zt__code_entry(&coder, &file->entries[i]);
    return ZT_OK;
}

static zt_result check_entries(zt_file *file, zt__sink *sink) {
    uint64_t at = ZT__PREAMBLE_SIZE + (uint64_t)file->preamble.directory_size; /* a multiple of 16 */
    for (uint32_t i = 0; i < file->chunk_count; i++) {
        zt__enter(sink, "directory/entry %u", i);
        ZT_TRY(zt__check_entry(sink, &file->entries[i], i, at));
        at = zt__align16(at + ZT__HEAD_SIZE + file->entries[i].stored_size);
    }
    zt__enter(sink, "directory");
    ZT_RULE(sink, 3002, at == file->preamble.file_size, 16, "the last chunk ends at %llu, the file at %llu",
            (unsigned long long)at, (unsigned long long)file->preamble.file_size);
    return zt__check_directory(sink, file->entries, file->chunk_count);
}

/* ---- chunks ---- */

static uint32_t find_chunk(const zt_file *file, uint32_t type, uint32_t from) {
    for (uint32_t i = from; i < file->chunk_count; i++) {
        if (file->entries[i].type == type)
            return i;
    }
    return ZT_NONE;
}

void zt__enter_chunk(zt__sink *sink, const zt_file *file, uint32_t chunk) {
    uint32_t type = file->entries[chunk].type;
    zt__enter(sink, "%c%c%c%c", (int)(type & 0xff), (int)(type >> 8 & 0xff), (int)(type >> 16 & 0xff),
              (int)(type >> 24));
}

zt_result zt__check_head(zt__sink *sink, const zt_file *file, uint32_t chunk, const uint8_t *bytes) {
    const zt__entry *e = &file->entries[chunk];
    uint8_t entry[ZT__ENTRY_SIZE];
    zt__head head;
    zt__cursor in = zt__cursor_of(bytes, ZT__HEAD_SIZE);
    zt__coder coder = zt__reading(&in);
    zt__code_head(&coder, &head);
    ZT_RULE(sink, 4001,
            memcmp(head.magic, zt__head_magic, sizeof head.magic) == 0 && head.index == chunk && !head.reserved,
            e->offset, "the head of chunk %u is damaged", chunk);
    coder = zt__writing(entry);
    zt__entry copy = *e;
    zt__code_entry(&coder, &copy);
    ZT_RULE(sink, 4002, memcmp(entry, bytes + ZT__HEAD_SIZE - ZT__ENTRY_SIZE, sizeof entry) == 0, e->offset + 16,
            "the head of chunk %u does not repeat the directory's entry", chunk);
    return ZT_OK;
}

zt_result zt__check_chunk_padding(zt__sink *sink, const zt_file *file, uint32_t chunk, const uint8_t *padding,
                                  size_t size) {
    const zt__entry *e = &file->entries[chunk];
    for (size_t i = 0; i < size; i++)
        ZT_RULE(sink, 4005, padding[i] == 0, e->offset + ZT__HEAD_SIZE + e->stored_size + i,
                "padding behind chunk %u is not zero", chunk);
    return ZT_OK;
}

zt_result zt__read_chunk(const zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t chunk, void *dst) {
    const zt__entry *e = &file->entries[chunk];
    uint64_t whole = zt__align16(ZT__HEAD_SIZE + e->stored_size);
    uint64_t body_at = e->offset + ZT__HEAD_SIZE;
    uint8_t *bytes;
    ZT_RULE(sink, 2006, zt__range_ok(e->offset, whole, file->io.size), file->io.size, "chunk %u is not whole", chunk);
    ZT_TRY(zt__decoder_stored(decoder, whole, sink->diag, &bytes));
    ZT_TRY(walk_read(file, sink, e->offset, bytes, (size_t)whole));
    ZT_TRY(zt__check_head(sink, file, chunk, bytes));
    const uint8_t *body = bytes + ZT__HEAD_SIZE;
    size_t stored = (size_t)e->stored_size;
    ZT_TRY(zt__check_chunk_padding(sink, file, chunk, body + stored, (size_t)whole - ZT__HEAD_SIZE - stored));
    ZT_RULE(sink, 4003, zt__hash(body, stored) == e->stored_hash, body_at, "the hash of the stored bytes is wrong");
    return zt__decode_stored(sink, decoder, e->codec, body, stored, dst, (size_t)e->decoded_size, e->decoded_hash, 4004,
                             body_at);
}

/* Reads a structure chunk into the decoder's raw buffer. */
static zt_result load_chunk(zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t chunk, uint8_t **out) {
    zt__enter_chunk(sink, file, chunk);
    ZT_TRY(zt__decoder_raw(decoder, file->entries[chunk].decoded_size, sink->diag, out));
    return zt__read_chunk(file, sink, decoder, chunk, *out);
}

/* ---- IMAG ---- */

static zt_result check_image_counts(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in) {
    uint64_t reserved, need;
    zt__coder coder = zt__reading(in);
    zt__code_u32(&coder, &file->image_count);
    zt__code_u32(&coder, &file->unit_count);
    zt__code_u64(&coder, &reserved);
    need = 16 + (uint64_t)file->image_count * ZT__IMAGE_RECORD_SIZE + (uint64_t)file->unit_count * ZT__UNIT_RECORD_SIZE;
    bool right = !in->bad && file->image_count >= 1 && need == e->decoded_size;
    uint32_t images = file->image_count, units = file->unit_count;
    if (!right)
        file->image_count = file->unit_count = 0; /* nothing is allocated for them */
    ZT_RULE(sink, 6001, right, zt__place(e, 0), "%u images and %u units do not make %llu bytes", images, units,
            (unsigned long long)e->decoded_size);
    ZT_RULE(sink, 6001, reserved == 0, zt__place(e, 8), "a reserved field is not zero");
    if (images > file->limits.images) {
        file->image_count = file->unit_count = 0;
        return zt__report(sink, 1004, zt__place(e, 0), "%u images: the limit is %u (zt_limits.images)", images,
                          file->limits.images);
    }
    return ZT_OK;
}

static zt_result read_images(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in) {
    void *block;
    uint64_t units = 0;
    uint32_t image_count = file->image_count;
    file->image_count = 0;
    ZT_TRY(zt__alloc(&file->memory, image_count, sizeof *file->images, sink->diag, &block));
    file->images = block;
    file->image_count = image_count;
    for (uint32_t i = 0; i < image_count; i++) {
        zt__image *image = &file->images[i];
        uint64_t at = zt__place(e, in->at);
        zt__coder coder = zt__reading(in);
        zt__code_image(&coder, &image->record);
        zt__enter(sink, "IMAG/image %u", i);
        ZT_TRY(zt__check_image(sink, &file->limits, &image->record, at));
        image->format = zt_find_format(image->record.format);
        image->tail_level = zt__tail_level(&image->record);
        image->unit_count = zt__unit_count(&image->record);
        image->first_unit = (uint32_t)units;
        units += image->unit_count;
    }
    zt__enter(sink, "IMAG");
    ZT_RULE(sink, 6010, units == file->unit_count, zt__place(e, 4), "the images have %llu units, the header says %u",
            (unsigned long long)units, file->unit_count);
    return ZT_OK;
}

static uint64_t unit_tile_count(const zt__image *image, uint32_t unit) {
    zt_level_info level;
    zt__level_geometry(&image->record, unit, &level);
    return level.tile_count;
}

static zt_result read_units(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in) {
    void *block;
    uint32_t unit_count = file->unit_count;
    file->unit_count = 0;
    ZT_TRY(zt__alloc(&file->memory, unit_count, sizeof *file->units, sink->diag, &block));
    file->units = block;
    file->unit_count = unit_count;
    for (uint32_t i = 0; i < file->image_count; i++) {
        const zt__image *image = &file->images[i];
        for (uint32_t k = 0; k < image->unit_count; k++) {
            zt__unit *unit = &file->units[image->first_unit + k];
            uint64_t at = zt__place(e, in->at);
            zt__coder coder = zt__reading(in);
            zt__code_unit(&coder, &unit->record);
            atomic_init(&unit->index, NULL);
            unit->tile_count = unit_tile_count(image, k);
            zt__enter(sink, "IMAG/image %u/unit %u", i, k);
            ZT_RULE(sink, 6012, unit->record.size >= unit->tile_count * (ZT__TILE_RECORD_SIZE + 1), at + 8,
                    "%llu bytes for %llu tiles", (unsigned long long)unit->record.size,
                    (unsigned long long)unit->tile_count);
        }
    }
    return ZT_OK;
}

/* R6011 and R6013: the units fill TEXL in order, coarse before fine. */
static zt_result check_unit_places(zt_file *file, zt__sink *sink, const zt__entry *e) {
    uint64_t at = 0, first_record = 16 + (uint64_t)file->image_count * ZT__IMAGE_RECORD_SIZE;
    for (uint32_t rank = 0; rank <= ZT__MAX_LEVELS; rank++) {
        for (uint32_t i = 0; i < file->image_count; i++) {
            const zt__image *image = &file->images[i];
            uint32_t k = zt__unit_of_rank(&image->record, rank, image->tail_level);
            if (k == ZT_NONE)
                continue;
            const zt__unit *unit = &file->units[image->first_unit + k];
            zt__enter(sink, "IMAG/image %u/unit %u", i, k);
            ZT_RULE(sink, 6011, unit->record.offset == at,
                    zt__place(e, first_record + (uint64_t)(image->first_unit + k) * ZT__UNIT_RECORD_SIZE),
                    "the unit is said to be at %llu of TEXL and must be at %llu",
                    (unsigned long long)unit->record.offset, (unsigned long long)at);
            ZT_RULE(sink, 6013, unit->record.size <= file->texels_size - at, zt__place(e, 4),
                    "the units have more than the %llu bytes of TEXL", (unsigned long long)file->texels_size);
            at += unit->record.size;
        }
    }
    zt__enter(sink, "IMAG");
    ZT_RULE(sink, 6013, at == file->texels_size, zt__place(e, 4), "the units have %llu bytes, TEXL has %llu",
            (unsigned long long)at, (unsigned long long)file->texels_size);
    return ZT_OK;
}

static zt_result read_imag(zt_file *file, zt__sink *sink, zt__decoder *decoder) {
    uint8_t *bytes;
    uint32_t chunk = find_chunk(file, ZT__IMAG, 0);
    const zt__entry *e = &file->entries[chunk];
    ZT_TRY(load_chunk(file, sink, decoder, chunk, &bytes));
    zt__cursor in = zt__cursor_of(bytes, (size_t)e->decoded_size);
    ZT_TRY(check_image_counts(file, sink, e, &in));
    ZT_TRY(read_images(file, sink, e, &in));
    ZT_TRY(read_units(file, sink, e, &in));
    return check_unit_places(file, sink, e);
}

/* ---- the walk ---- */

zt_result zt__walk(zt_file *file, zt__sink *sink, const zt__payload_hooks *hooks, bool *usable) {
    zt__decoder decoder;
    zt_result result;
    *usable = false;
    zt__decoder_init(&decoder, &file->memory);
    result = read_preamble(file, sink);
    if (result == ZT_OK)
        result = read_directory(file, sink, &decoder);
    if (result == ZT_OK)
        result = check_entries(file, sink);
    if (result != ZT_OK)
        goto done;

    const zt__entry *texels = &file->entries[find_chunk(file, ZT__TEXL, 0)];
    file->texels_offset = texels->offset + ZT__HEAD_SIZE;
    file->texels_size = texels->stored_size;
    result = read_imag(file, sink, &decoder);
    if (result != ZT_OK)
        goto done;
    *usable = true;
    result = zt__read_textures(file, sink, &decoder, hooks);
done:
    zt__decoder_free(&decoder);
    return result;
}
