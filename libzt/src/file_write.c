/* SPDX-License-Identifier: Apache-2.0 */
/* The calls of zt_write.h but those for textures with payloads. */
#include "file_write.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base_hash.h"
#include "file_check.h"
#include "file_open.h"

enum { DEFAULT_EFFORT = 5, DEFAULT_SPOOL = 64 << 20, MOST_WORKERS = 256, SLOTS_PER_WORKER = 2 };

/* ---- small things -------------------------------------------------------------------------------- */

zt_result zt__writer_begin(zt_writer *writer, zt_diag *diag) {
    zt__begin(diag);
    if (!writer)
        return zt__bad_argument(diag, "the writer is NULL");
    if (writer->dead)
        return zt__bad_argument(diag, "the writer has finished or failed: only closing it is left");
    return ZT_OK;
}

zt_result zt__writer_end(zt_writer *writer, zt_result result) {
    if (result != ZT_OK && result != ZT_BAD_ARGUMENT)
        writer->dead = true;
    return result;
}

zt__sink zt__write_sink(zt_diag *diag) {
    zt__sink sink = {.diag = diag};
    return sink;
}

zt_result zt__write_verdict(zt_diag *diag, zt_result result) {
    if (result != ZT_CORRUPT && result != ZT_UNSUPPORTED)
        return result;
    if (diag) {
        diag->result = ZT_BAD_ARGUMENT;
        diag->offset = ZT__NO_OFFSET;
    }
    return ZT_BAD_ARGUMENT;
}

zt_result zt__grow(zt__memory *memory, void **array, uint32_t *capacity, uint32_t count, size_t size, zt_diag *diag) {
    void *block;
    if (count < *capacity)
        return ZT_OK;
    uint64_t more = *capacity == 0 ? 8 : 2 * (uint64_t)*capacity;
    if (more > UINT32_MAX)
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "too many");
    ZT_TRY(zt__alloc(memory, more, size, diag, &block));
    if (count > 0)
        memcpy(block, *array, count * size);
    zt__free(memory, *array, *capacity, size);
    *array = block;
    *capacity = (uint32_t)more;
    return ZT_OK;
}

zt_result zt__copy_text(zt__memory *memory, const char *text, zt_diag *diag, char **out) {
    void *block;
    size_t size = strlen(text) + 1;
    *out = NULL;
    ZT_TRY(zt__alloc_raw(memory, size, 1, diag, &block));
    *out = block;
    memcpy(*out, text, size);
    return ZT_OK;
}

/* ---- opening --------------------------------------------------------------------------------------- */

static zt_result check_options(const zt_writer_options *options, zt_diag *diag) {
    if (!options)
        return ZT_OK;
    const zt_allocator *a = options->allocator;
    const zt_parallel *p = options->parallel;
    if (options->size != 0 && options->size != sizeof *options)
        return zt__bad_argument(diag, "options->size is not that of this library");
    if (a && (!a->alloc || !a->free))
        return zt__bad_argument(diag, "the allocator lacks a function");
    if (p && (!p->run || p->workers < 1 || p->workers > MOST_WORKERS))
        return zt__bad_argument(diag, "parallel has no function, or its workers are not 1 to 256");
    if (options->effort < 0 || options->effort > 9)
        return zt__bad_argument(diag, "effort is not 0 to 9");
    if (options->flags & ~(uint32_t)ZT_WRITE_NO_FSYNC)
        return zt__bad_argument(diag, "unknown flags");
    return ZT_OK;
}

static zt_result make_workers(zt_writer *w, zt_diag *diag) {
    void *block;
    w->worker_count = zt__workers(w->parallel_or_null);
    ZT_TRY(zt__alloc(&w->memory, w->worker_count, sizeof *w->encoders, diag, &block));
    w->encoders = block;
    ZT_TRY(zt__alloc(&w->memory, w->worker_count, sizeof *w->tile_buffers, diag, &block));
    w->tile_buffers = block;
    uint32_t slots = w->worker_count > 1 ? SLOTS_PER_WORKER * w->worker_count : 1;
    ZT_TRY(zt__alloc(&w->memory, slots, sizeof *w->slots, diag, &block));
    w->slots = block;
    w->slot_count = slots;
    for (unsigned i = 0; i < w->worker_count; i++)
        ZT_TRY(zt__encoder_init(&w->encoders[i], &w->memory, zt__level_of_effort((uint32_t)w->options.effort),
                                w->options.raw_only != 0, diag));
    return ZT_OK;
}

static const char *temporary_folder(void) {
    const char *folder = getenv("TMPDIR");
    return folder && *folder ? folder : "/tmp";
}

static zt_result open_target(zt_writer *w, const char *path, const zt_sink *sink, zt_diag *diag) {
    struct stat status;
    if (sink) {
        w->sink = *sink;
        w->to_sink = true;
        return zt__copy_text(&w->memory, temporary_folder(), diag, &w->folder);
    }
    ZT_TRY(zt__copy_text(&w->memory, path, diag, &w->path));
    ZT_TRY(zt__folder_of(&w->memory, path, diag, &w->folder));
    if (access(w->folder, W_OK | X_OK) != 0)
        return zt__io_failed(diag, "access to the folder", w->folder, errno);
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        return zt__io_failed(diag, "writing to", path, EISDIR);
    return ZT_OK;
}

static zt_result open_writer(const char *path, const zt_sink *sink, const zt_writer_options *options, zt_diag *diag,
                             zt_writer **out) {
    zt_limits limits = {0};
    void *block;
    ZT_TRY(check_options(options, diag));
    if (options && options->limits)
        limits = *options->limits;
    zt__limits_fill(&limits);
    zt__memory memory;
    zt__memory_init(&memory, options ? options->allocator : NULL, limits.memory);
    ZT_TRY(zt__alloc(&memory, 1, sizeof(zt_writer), diag, &block));
    zt_writer *w = block;
    zt__memory_init(&w->memory, options ? options->allocator : NULL, limits.memory);
    w->limits = limits;
    if (options)
        w->options = *options;
    if (w->options.effort == 0)
        w->options.effort = DEFAULT_EFFORT;
    if (w->options.spool_memory == 0)
        w->options.spool_memory = DEFAULT_SPOOL;
    if (w->options.parallel) {
        w->parallel = *w->options.parallel;
        w->parallel_or_null = &w->parallel;
    }
    w->spool.fd = -1;
    zt_result r = open_target(w, path, sink, diag);
    if (r == ZT_OK)
        r = make_workers(w, diag);
    if (r != ZT_OK) {
        zt_writer_close(w);
        return r;
    }
    zt__spool_init(&w->spool, &w->memory, w->folder, w->options.spool_memory);
    *out = w;
    return ZT_OK;
}

zt_result zt_writer_open_path(const char *path, const zt_writer_options *options, zt_diag *diag, zt_writer **out) {
    zt__begin(diag);
    if (out)
        *out = NULL;
    if (!path || !*path || !out)
        return zt__bad_argument(diag, "the path or out is NULL or empty");
    return open_writer(path, NULL, options, diag, out);
}

zt_result zt_writer_open_sink(const zt_sink *sink, const zt_writer_options *options, zt_diag *diag, zt_writer **out) {
    zt__begin(diag);
    if (out)
        *out = NULL;
    if (!sink || !sink->write || !out)
        return zt__bad_argument(diag, "the sink, its function, or out is NULL");
    return open_writer(NULL, sink, options, diag, out);
}

/* ---- closing --------------------------------------------------------------------------------------- */

static void free_texture(zt_writer *w, zt__write_texture *t) {
    zt__free_text(&w->memory, t->name);
    zt__free(&w->memory, t->layers, t->entry.layer_count, sizeof *t->layers);
    if (t->payload)
        w->hooks->free(w, t->entry.kind, t->payload);
}

void zt__write_chunk_free(zt_writer *w, zt__write_chunk *chunk) {
    zt__free(&w->memory, chunk->bytes, chunk->capacity, 1);
    chunk->bytes = NULL;
}

static void free_workers(zt_writer *w) {
    for (uint32_t i = 0; w->slots && i < w->slot_count; i++)
        zt__free(&w->memory, w->slots[i].coded, zt__encode_bound((size_t)w->slots[i].room), 1);
    for (unsigned i = 0; w->tile_buffers && i < w->worker_count; i++)
        zt__free(&w->memory, w->tile_buffers[i].bytes, w->tile_buffers[i].room, 1);
    for (unsigned i = 0; w->encoders && i < w->worker_count; i++)
        zt__encoder_free(&w->encoders[i]);
    zt__free(&w->memory, w->slots, w->slot_count, sizeof *w->slots);
    zt__free(&w->memory, w->tile_buffers, w->worker_count, sizeof *w->tile_buffers);
    zt__free(&w->memory, w->encoders, w->worker_count, sizeof *w->encoders);
}

void zt_writer_close(zt_writer *w) {
    if (!w)
        return;
    for (uint32_t i = 0; i < w->image_count; i++)
        zt__write_image_free(w, w->images[i]);
    for (uint32_t i = 0; i < w->texture_count; i++)
        free_texture(w, &w->textures[i]);
    for (uint32_t i = 0; i < w->pair_count; i++) {
        zt__free_text(&w->memory, w->pairs[i].key);
        zt__free_text(&w->memory, w->pairs[i].value);
    }
    for (uint32_t i = 0; i < w->chunk_count; i++)
        zt__write_chunk_free(w, &w->chunks[i]);
    zt__free(&w->memory, w->images, w->image_capacity, sizeof *w->images);
    zt__free(&w->memory, w->textures, w->texture_capacity, sizeof *w->textures);
    zt__free(&w->memory, w->pairs, w->pair_capacity, sizeof *w->pairs);
    zt__free(&w->memory, w->chunks, w->chunk_capacity, sizeof *w->chunks);
    free_workers(w);
    zt__spool_free(&w->spool);
    zt__free_text(&w->memory, w->path);
    zt__free_text(&w->memory, w->folder);
    zt__memory memory;
    zt__memory_init(&memory, &w->memory.allocator, 0);
    zt__free(&memory, w, 1, sizeof *w);
}

/* ---- textures --------------------------------------------------------------------------------------- */

static zt_result check_layers(const zt_writer *w, zt_kind kind, const zt_layer_desc *layers, uint32_t count,
                              zt_diag *diag) {
    for (uint32_t i = 0; i < count; i++) {
        if (layers[i].semantic > UINT16_MAX)
            return zt__bad_argument(diag, "a semantic is above 65535");
        if (kind != ZT_KIND_IMAGE)
            continue;
        if (layers[i].image >= w->image_count)
            return zt__fail(diag, ZT_BAD_ARGUMENT, 6106, ZT__NO_OFFSET, "layer %u names image %u of %u", (unsigned)i,
                            (unsigned)layers[i].image, (unsigned)w->image_count);
        const zt__image_record *a = &w->images[layers[0].image]->record;
        const zt__image_record *b = &w->images[layers[i].image]->record;
        if (a->width != b->width || a->height != b->height || a->depth != b->depth || a->layers != b->layers ||
            a->layer_kind != b->layer_kind)
            return zt__fail(diag, ZT_BAD_ARGUMENT, 6109, ZT__NO_OFFSET,
                            "the image of layer %u has another size than that of layer 0", (unsigned)i);
    }
    return ZT_OK;
}

static zt_result check_name(const zt_writer *w, const char *name, uint64_t hash, zt_diag *diag) {
    for (uint32_t i = 0; *name && i < w->texture_count; i++) {
        if (w->textures[i].name_hash == hash && strcmp(w->textures[i].name, name) == 0)
            return zt__fail(diag, ZT_BAD_ARGUMENT, 6108, ZT__NO_OFFSET, "texture %u has this name already",
                            (unsigned)i);
    }
    return ZT_OK;
}

static zt_result fill_texture(zt_writer *w, const char *name, zt_kind kind, const zt_layer_desc *layers,
                              zt__write_texture *t, zt_diag *diag) {
    void *block;
    ZT_TRY(zt__copy_text(&w->memory, name, diag, &t->name));
    zt_result r = zt__alloc(&w->memory, t->entry.layer_count, sizeof *t->layers, diag, &block);
    if (r != ZT_OK) {
        zt__free_text(&w->memory, t->name);
        return r;
    }
    t->layers = block;
    for (uint32_t i = 0; i < t->entry.layer_count; i++) {
        t->layers[i].semantic = (uint16_t)layers[i].semantic;
        t->layers[i].image = kind == ZT_KIND_IMAGE ? layers[i].image : ZT_NONE;
    }
    return ZT_OK;
}

zt_result zt__write_texture_add(zt_writer *w, const zt_texture_desc *desc, zt_kind kind, const zt_layer_desc *layers,
                                uint32_t layer_count, void *payload, zt_diag *diag, uint32_t *texture) {
    const char *name = desc->name ? desc->name : "";
    size_t name_size = strlen(name);
    zt__write_texture t = {.payload = payload, .name_hash = zt__hash(name, name_size)};
    t.entry.kind = (uint8_t)kind;
    t.entry.wrap_u = zt__byte_of((unsigned)desc->wrap_u);
    t.entry.wrap_v = zt__byte_of((unsigned)desc->wrap_v);
    t.entry.wrap_w = zt__byte_of((unsigned)desc->wrap_w);
    t.entry.layer_count = layer_count;
    t.entry.name_size = name_size < UINT32_MAX ? (uint32_t)name_size : UINT32_MAX;
    zt__sink sink = zt__write_sink(diag);
    zt__enter(&sink, "texture %u", (unsigned)w->texture_count);
    ZT_TRY(zt__write_verdict(diag, zt__check_texture(&sink, &t.entry, name, ZT__NO_OFFSET)));
    ZT_TRY(check_name(w, name, t.name_hash, diag));
    ZT_TRY(check_layers(w, kind, layers, layer_count, diag));
    if (w->texture_count >= w->limits.textures)
        return zt__fail(diag, ZT_LIMIT, 0, ZT__NO_OFFSET, "more textures than zt_limits.textures");
    void *array = w->textures;
    ZT_TRY(zt__grow(&w->memory, &array, &w->texture_capacity, w->texture_count, sizeof t, diag));
    w->textures = array;
    ZT_TRY(fill_texture(w, name, kind, layers, &t, diag));
    if (texture)
        *texture = w->texture_count;
    w->textures[w->texture_count++] = t;
    return ZT_OK;
}

zt_result zt_writer_add_texture(zt_writer *writer, const zt_texture_desc *desc, zt_diag *diag, uint32_t *texture) {
    if (texture)
        *texture = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!desc || (desc->layer_count > 0 && !desc->layers))
        return zt__bad_argument(diag, "desc or its layers are NULL");
    zt_layer_desc single = {ZT_SEMANTIC_BASE_COLOUR, desc->image};
    const zt_layer_desc *layers = desc->layer_count > 0 ? desc->layers : &single;
    uint32_t count = desc->layer_count > 0 ? desc->layer_count : 1;
    return zt__writer_end(writer,
                          zt__write_texture_add(writer, desc, ZT_KIND_IMAGE, layers, count, NULL, diag, texture));
}

/* ---- metadata ------------------------------------------------------------------------------------------ */

static void remove_pair(zt_writer *w, uint32_t i) {
    zt__free_text(&w->memory, w->pairs[i].key);
    zt__free_text(&w->memory, w->pairs[i].value);
    w->pair_count--;
    memmove(w->pairs + i, w->pairs + i + 1, (w->pair_count - i) * sizeof *w->pairs);
}

static zt_result insert_pair(zt_writer *w, uint32_t i, const char *key, const char *value, zt_diag *diag) {
    zt__write_pair pair;
    void *array = w->pairs;
    ZT_TRY(zt__grow(&w->memory, &array, &w->pair_capacity, w->pair_count, sizeof pair, diag));
    w->pairs = array;
    ZT_TRY(zt__copy_text(&w->memory, key, diag, &pair.key));
    zt_result r = zt__copy_text(&w->memory, value, diag, &pair.value);
    if (r != ZT_OK) {
        zt__free_text(&w->memory, pair.key);
        return r;
    }
    memmove(w->pairs + i + 1, w->pairs + i, (w->pair_count - i) * sizeof pair);
    w->pairs[i] = pair;
    w->pair_count++;
    return ZT_OK;
}

/* The first pair whose key is not below: strcmp compares as unsigned bytes. */
static uint32_t pair_at(const zt_writer *w, const char *key) {
    uint32_t low = 0, high = w->pair_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (strcmp(w->pairs[middle].key, key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static zt_result set_metadata(zt_writer *w, const char *key, const char *value, zt_diag *diag) {
    zt__sink sink = zt__write_sink(diag);
    zt__enter(&sink, "META");
    ZT_TRY(zt__write_verdict(diag, zt__check_metadata_key(&sink, key, strlen(key), ZT__NO_OFFSET)));
    if (value && strlen(value) > UINT32_MAX)
        return zt__bad_argument(diag, "the value is longer than 2^32 - 1 bytes");
    if (value)
        ZT_TRY(zt__write_verdict(diag, zt__check_metadata_value(&sink, value, strlen(value), ZT__NO_OFFSET)));
    uint32_t i = pair_at(w, key);
    bool there = i < w->pair_count && strcmp(w->pairs[i].key, key) == 0;
    if (!value) {
        if (there)
            remove_pair(w, i);
        return ZT_OK;
    }
    if (!there)
        return insert_pair(w, i, key, value, diag);
    char *copy;
    ZT_TRY(zt__copy_text(&w->memory, value, diag, &copy));
    zt__free_text(&w->memory, w->pairs[i].value);
    w->pairs[i].value = copy;
    return ZT_OK;
}

zt_result zt_writer_set_metadata(zt_writer *writer, const char *key, const char *value, zt_diag *diag) {
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!key)
        return zt__bad_argument(diag, "the key is NULL");
    return zt__writer_end(writer, set_metadata(writer, key, value, diag));
}

/* ---- other chunks --------------------------------------------------------------------------------------- */

static bool type_ok(const char *type) {
    for (int i = 0; i < 4; i++) {
        bool good = (type[i] >= 'A' && type[i] <= 'Z') || (type[i] >= '0' && type[i] <= '9');
        if (!good)
            return false;
    }
    return type[4] == 0;
}

static zt_result check_chunk(const zt_writer *w, const char *type, uint8_t flags, size_t size, zt_diag *diag) {
    if (!type_ok(type))
        return zt__fail(diag, ZT_BAD_ARGUMENT, 3004, ZT__NO_OFFSET, "a chunk type has four characters, A-Z and 0-9");
    if (flags & ~ZT__FLAG_SAFE_TO_COPY)
        return zt__fail(diag, ZT_BAD_ARGUMENT, (flags & ZT__FLAG_CRITICAL) ? 3012 : 3005, ZT__NO_OFFSET,
                        "the flags 0x%02X are not 0 or safe-to-copy", (unsigned)flags);
    if (size == 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 3003, ZT__NO_OFFSET, "a chunk has no bytes");
    uint32_t code = zt__load32((const uint8_t *)type);
    if (zt__find_chunk_type(code))
        return zt__bad_argument(diag, "libzt writes chunks of this type itself");
    for (uint32_t i = 0; i < w->chunk_count; i++)
        if (w->chunks[i].entry.type == code)
            return zt__fail(diag, ZT_BAD_ARGUMENT, 3011, ZT__NO_OFFSET, "there is a chunk %s already", type);
    return ZT_OK;
}

static zt_result add_chunk(zt_writer *w, const char *type, uint16_t version, uint8_t flags, const void *data,
                           size_t size, zt_diag *diag) {
    ZT_TRY(check_chunk(w, type, flags, size, diag));
    void *array = w->chunks;
    ZT_TRY(zt__grow(&w->memory, &array, &w->chunk_capacity, w->chunk_count, sizeof *w->chunks, diag));
    w->chunks = array;
    zt__write_chunk chunk;
    ZT_TRY(zt__write_chunk_of(w, zt__load32((const uint8_t *)type), version, flags, data, size, diag, &chunk));
    w->chunks[w->chunk_count++] = chunk;
    return ZT_OK;
}

zt_result zt_writer_add_chunk(zt_writer *writer, const char *type, uint16_t version, uint8_t flags, const void *data,
                              size_t size, zt_diag *diag) {
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!type || (!data && size > 0))
        return zt__bad_argument(diag, "the type or the data are NULL");
    return zt__writer_end(writer, add_chunk(writer, type, version, flags, data, size, diag));
}

static zt_result copy_chunk(zt_writer *w, const zt_file *file, uint32_t index, const zt_chunk_info *info,
                            zt_diag *diag) {
    void *block;
    ZT_TRY(zt__alloc_raw(&w->memory, info->decoded_size, 1, diag, &block));
    zt_result r = zt_read_chunk(file, index, block, (size_t)info->decoded_size, diag);
    if (r == ZT_OK)
        r = add_chunk(w, info->type, info->version, info->flags, block, (size_t)info->decoded_size, diag);
    zt__free(&w->memory, block, info->decoded_size, 1);
    return r;
}

static zt_result copy_metadata(zt_writer *w, const zt_file *file, zt_diag *diag) {
    uint32_t count;
    ZT_TRY(zt_load_metadata(file, &count, diag));
    for (uint32_t i = 0; i < count; i++) {
        const char *key, *value;
        ZT_TRY(zt_get_metadata(file, i, &key, &value));
        ZT_TRY(set_metadata(w, key, value, diag));
    }
    return ZT_OK;
}

static zt_result copy_rest(zt_writer *w, const zt_file *file, zt_diag *diag, uint32_t *dropped) {
    zt_file_info info;
    zt_chunk_info chunk;
    zt_get_file(file, &info);
    ZT_TRY(copy_metadata(w, file, diag));
    for (uint32_t i = 0; i < info.chunk_count; i++) {
        ZT_TRY(zt_get_chunk(file, i, &chunk));
        const zt__chunk_type *known = zt__find_chunk_type(zt__load32((const uint8_t *)chunk.type));
        bool skipped = known && chunk.version != known->version; /* R3008 */
        if (known && !skipped)
            continue;
        if (skipped || !(chunk.flags & ZT__FLAG_SAFE_TO_COPY))
            *dropped += 1;
        else
            ZT_TRY(copy_chunk(w, file, i, &chunk, diag));
    }
    return ZT_OK;
}

zt_result zt_writer_copy_rest(zt_writer *writer, const zt_file *file, zt_diag *diag, uint32_t *dropped) {
    uint32_t count = 0;
    if (dropped)
        *dropped = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    if (!file)
        return zt__bad_argument(diag, "the file is NULL");
    zt_result r = copy_rest(writer, file, diag, &count);
    if (dropped && r == ZT_OK)
        *dropped = count;
    return zt__writer_end(writer, r);
}

/* ---- the end ------------------------------------------------------------------------------------------------ */

zt_result zt_writer_finish(zt_writer *writer, zt_diag *diag) {
    ZT_TRY(zt__writer_begin(writer, diag));
    writer->dead = true;
    return zt__write_file(writer, diag);
}
