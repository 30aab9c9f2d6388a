/* SPDX-License-Identifier: Apache-2.0 */
/* TEXS and META (spec/ztex.md sections 7 and 9). */
#include <string.h>

#include "file_check.h"
#include "file_open.h"

typedef struct counts {
    uint32_t textures, layers, name_bytes, reserved;
} counts;

static zt_result read_counts(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in, counts *c) {
    zt__coder coder = zt__reading(in);
    zt__code_u32(&coder, &c->textures);
    zt__code_u32(&coder, &c->layers);
    zt__code_u32(&coder, &c->name_bytes);
    zt__code_u32(&coder, &c->reserved);
    uint64_t need = 16 + (uint64_t)c->textures * ZT__TEXTURE_ENTRY_SIZE + (uint64_t)c->layers * ZT__LAYER_ENTRY_SIZE +
                    c->name_bytes;
    ZT_RULE(sink, 6101, !in->bad && need == e->decoded_size, zt__place(e, 0),
            "%u textures, %u layers and %u bytes of names do not make %llu bytes", c->textures, c->layers,
            c->name_bytes, (unsigned long long)e->decoded_size);
    ZT_RULE(sink, 6104, c->reserved == 0, zt__place(e, 12), "a reserved field is not zero");
    ZT_RULE(sink, 6102, c->textures >= 1, zt__place(e, 0), "there are no textures");
    ZT_RULE(sink, 1003, c->textures <= file->limits.textures, zt__place(e, 0),
            "%u textures: the limit is %u (zt_limits.textures)", c->textures, file->limits.textures);
    return ZT_OK;
}

static zt_result allocate(zt_file *file, zt__sink *sink, const counts *c) {
    void *block;
    ZT_TRY(zt__alloc(&file->memory, c->textures, sizeof *file->textures, sink->diag, &block));
    file->textures = block;
    file->texture_count = c->textures;
    ZT_TRY(zt__alloc(&file->memory, c->layers, sizeof *file->layers, sink->diag, &block));
    file->layers = block;
    file->layer_count = c->layers;
    file->names_size = (uint64_t)c->name_bytes + c->textures;
    ZT_TRY(zt__alloc(&file->memory, file->names_size, 1, sink->diag, &block));
    file->names = block;
    return ZT_OK;
}

/* The sums of R6101; the entries have been read. */
static zt_result check_sums(zt_file *file, zt__sink *sink, const zt__entry *e, const counts *c) {
    uint64_t layers = 0, name_bytes = 0;
    for (uint32_t i = 0; i < c->textures; i++) {
        file->textures[i].first_layer = (uint32_t)layers;
        layers += file->textures[i].entry.layer_count;
        name_bytes += file->textures[i].entry.name_size;
        ZT_RULE(sink, 6101, layers <= c->layers && name_bytes <= c->name_bytes, zt__place(e, 4),
                "the textures have more layers or longer names than the header says");
    }
    ZT_RULE(sink, 6101, layers == c->layers && name_bytes == c->name_bytes, zt__place(e, 4),
            "the textures have fewer layers or shorter names than the header says");
    return ZT_OK;
}

static zt_result read_layers(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    const zt__image_record *first = NULL;
    for (uint32_t k = 0; k < t->entry.layer_count; k++) {
        zt__layer_entry *layer = &file->layers[t->first_layer + k];
        uint64_t at = zt__place(e, in->at);
        zt__coder coder = zt__reading(in);
        zt__code_layer(&coder, layer);
        ZT_RULE(sink, 6104, layer->reserved == 0, at + 2, "a reserved field is not zero");
        if (t->entry.kind != ZT_KIND_IMAGE) {
            ZT_RULE(sink, 6106, layer->image == ZT_NONE, at + 4, "layer %u names image %u, which its payload must do",
                    k, layer->image);
            continue;
        }
        ZT_RULE(sink, 6106, layer->image < file->image_count, at + 4, "layer %u has image %u of %u", k, layer->image,
                file->image_count);
        const zt__image_record *r = &file->images[layer->image].record;
        first = first ? first : r;
        ZT_RULE(sink, 6109,
                r->width == first->width && r->height == first->height && r->depth == first->depth &&
                    r->layers == first->layers && r->layer_kind == first->layer_kind,
                at + 4, "layer %u has another size than layer 0", k);
    }
    return ZT_OK;
}

static zt_result read_entries(zt_file *file, zt__sink *sink, const zt__entry *e, zt__cursor *in, const counts *c) {
    zt__coder coder = zt__reading(in);
    for (uint32_t i = 0; i < c->textures; i++)
        zt__code_texture(&coder, &file->textures[i].entry);
    ZT_TRY(check_sums(file, sink, e, c));
    const char *name = (const char *)in->data + (in->size - c->name_bytes);
    char *out = file->names;
    for (uint32_t i = 0; i < c->textures; i++) {
        zt__texture *t = &file->textures[i];
        zt__enter(sink, "TEXS/texture %u", i);
        ZT_TRY(zt__check_texture(sink, &t->entry, name, zt__place(e, 16 + (uint64_t)i * ZT__TEXTURE_ENTRY_SIZE)));
        memcpy(out, name, t->entry.name_size);
        t->name = out;
        t->payload_chunk = ZT_NONE;
        out += t->entry.name_size + 1; /* the block came zeroed */
        name += t->entry.name_size;
        ZT_TRY(read_layers(file, sink, e, in, i));
    }
    return ZT_OK;
}

/* ---- R6108: names differ ---- */

static void sift_down(const char **names, uint32_t root, uint32_t count) {
    for (;;) {
        uint32_t child = 2 * root + 1;
        if (child >= count)
            return;
        if (child + 1 < count && strcmp(names[child], names[child + 1]) < 0)
            child++;
        if (strcmp(names[root], names[child]) >= 0)
            return;
        const char *swap = names[root];
        names[root] = names[child];
        names[child] = swap;
        root = child;
    }
}

/* Heap sort: no allocation of its own, and no bad case. At most 2^31 names. */
static void sort_names(const char **names, uint32_t count) {
    for (uint32_t i = count / 2; i-- > 0;)
        sift_down(names, i, count);
    for (uint32_t end = count; end-- > 1;) {
        const char *swap = names[0];
        names[0] = names[end];
        names[end] = swap;
        sift_down(names, 0, end);
    }
}

static zt_result check_names_differ(zt_file *file, zt__sink *sink, const zt__entry *e) {
    void *block;
    zt_result result = ZT_OK;
    zt__enter(sink, "TEXS");
    ZT_TRY(zt__alloc(&file->memory, file->texture_count, sizeof(char *), sink->diag, &block));
    const char **names = block;
    for (uint32_t i = 0; i < file->texture_count; i++)
        names[i] = file->textures[i].name;
    sort_names(names, file->texture_count);
    for (uint32_t i = 1; i < file->texture_count && result == ZT_OK; i++) {
        if (names[i][0] && strcmp(names[i - 1], names[i]) == 0)
            result = zt__report(sink, 6108, zt__place(e, 0), "two textures are called %s", names[i]);
    }
    zt__free(&file->memory, block, file->texture_count, sizeof(char *));
    return result;
}

/* ---- payloads ---- */

/* R6110: the n-th texture of a kind owns the n-th chunk of its type. */
static zt_result assign_payloads_of(zt_file *file, zt__sink *sink, const zt__entry *e, const zt__chunk_type *type) {
    uint32_t chunk = 0, textures = 0, chunks = 0;
    for (uint32_t i = 0; i < file->chunk_count; i++)
        chunks += file->entries[i].type == type->type;
    for (uint32_t i = 0; i < file->texture_count; i++) {
        if (file->textures[i].entry.kind != type->kind)
            continue;
        textures++;
        while (chunk < file->chunk_count && file->entries[chunk].type != type->type)
            chunk++;
        if (chunk < file->chunk_count)
            file->textures[i].payload_chunk = chunk++;
    }
    ZT_RULE(sink, 6110, textures == chunks, zt__place(e, 0), "%u textures of kind %u and %u chunks for them", textures,
            type->kind, chunks);
    return ZT_OK;
}

static zt_result assign_payloads(zt_file *file, zt__sink *sink, const zt__entry *e) {
    for (uint32_t i = 0; zt__get_chunk_type(i); i++) {
        if (zt__get_chunk_type(i)->kind != ZT_KIND_IMAGE)
            ZT_TRY(assign_payloads_of(file, sink, e, zt__get_chunk_type(i)));
    }
    return ZT_OK;
}

static zt_result open_payload(zt_file *file, zt__sink *sink, zt__decoder *decoder, const zt__payload_hooks *hooks,
                              uint32_t texture) {
    uint32_t chunk = file->textures[texture].payload_chunk;
    const zt__entry *e = &file->entries[chunk];
    void *bytes;
    uint8_t type[4];
    zt__store32(type, e->type);
    zt__enter(sink, "%.4s/texture %u", (const char *)type, texture);
    ZT_TRY(zt__alloc_raw(&file->memory, e->decoded_size, 1, sink->diag, &bytes));
    zt_result result = zt__read_chunk(file, sink, decoder, chunk, bytes);
    if (result == ZT_OK)
        result = hooks->open(file, sink, decoder, texture, bytes, (size_t)e->decoded_size, zt__place(e, 0));
    zt__free(&file->memory, bytes, e->decoded_size, 1);
    return result;
}

/* The validator goes on with the next payload when one cannot be read. */
static bool only_this_payload(const zt__sink *sink, zt_result result) {
    return sink->check && (result == ZT_CORRUPT || result == ZT_UNSUPPORTED || result == ZT_TRUNCATED);
}

zt_result zt__read_textures(zt_file *file, zt__sink *sink, zt__decoder *decoder, const zt__payload_hooks *hooks) {
    counts c = {0};
    uint8_t *bytes;
    uint32_t chunk = 0;
    zt_result result = ZT_OK;
    while (file->entries[chunk].type != ZT__TEXS)
        chunk++;
    const zt__entry *e = &file->entries[chunk];
    zt__enter(sink, "TEXS");
    ZT_TRY(zt__decoder_raw(decoder, e->decoded_size, sink->diag, &bytes));
    ZT_TRY(zt__read_chunk(file, sink, decoder, chunk, bytes));
    zt__cursor in = zt__cursor_of(bytes, (size_t)e->decoded_size);
    ZT_TRY(read_counts(file, sink, e, &in, &c));
    ZT_TRY(allocate(file, sink, &c));
    ZT_TRY(read_entries(file, sink, e, &in, &c));
    ZT_TRY(check_names_differ(file, sink, e));
    ZT_TRY(assign_payloads(file, sink, e));
    for (uint32_t i = 0; i < file->texture_count; i++) {
        if (file->textures[i].payload_chunk == ZT_NONE)
            continue;
        zt_result one = open_payload(file, sink, decoder, hooks, i);
        if (one != ZT_OK && !only_this_payload(sink, one))
            return one;
        result = result == ZT_OK ? one : result;
    }
    return result;
}

/* ---- META ---- */

/* Sizes of R7001: *text_bytes gets the sum of all key and value sizes. */
static zt_result check_meta_size(zt__sink *sink, const zt__entry *e, const uint8_t *bytes, uint32_t *pairs,
                                 uint64_t *text_bytes) {
    zt__cursor in = zt__cursor_of(bytes, (size_t)e->decoded_size);
    uint32_t reserved;
    *text_bytes = 0;
    *pairs = zt__take32(&in);
    reserved = zt__take32(&in);
    bool right = !in.bad && *pairs >= 1 && *pairs <= zt__left(&in) / 8;
    for (uint32_t i = 0; right && i < *pairs; i++) {
        *text_bytes += zt__take32(&in);
        *text_bytes += zt__take32(&in);
    }
    ZT_RULE(sink, 7001, right && *text_bytes == zt__left(&in), zt__place(e, 0), "%u pairs do not make %llu bytes",
            *pairs, (unsigned long long)e->decoded_size);
    ZT_RULE(sink, 7001, reserved == 0, zt__place(e, 4), "a reserved field is not zero");
    return ZT_OK;
}

static zt_result fill_meta(zt__sink *sink, const zt__entry *e, const uint8_t *bytes, zt__metadata *m, char *text) {
    uint64_t at = 8 + (uint64_t)m->count * 8;
    uint32_t last_size = 0;
    for (uint32_t i = 0; i < m->count; i++) {
        const uint8_t *sizes = bytes + 8 + (size_t)i * 8;
        uint32_t key_size = zt__load32(sizes), value_size = zt__load32(sizes + 4);
        const char *key = (const char *)bytes + at, *value = key + key_size;
        zt__enter(sink, "META/pair %u", i);
        ZT_TRY(zt__check_metadata_key(sink, key, key_size, zt__place(e, at)));
        ZT_TRY(zt__check_metadata_value(sink, value, value_size, zt__place(e, at + key_size)));
        if (i > 0) {
            int order = memcmp(m->keys[i - 1], key, zt__min32(last_size, key_size));
            ZT_RULE(sink, 7003, order < 0 || (order == 0 && last_size < key_size), zt__place(e, at),
                    "the key is not behind the one before it");
        }
        m->keys[i] = text;
        memcpy(text, key, key_size);
        text += key_size + 1;
        m->values[i] = text;
        memcpy(text, value, value_size);
        text += value_size + 1;
        at += (uint64_t)key_size + value_size;
        last_size = key_size;
    }
    return ZT_OK;
}

static zt_result parse_meta(const zt_file *file, zt__sink *sink, const zt__entry *e, const uint8_t *bytes,
                            zt__metadata **out) {
    uint32_t pairs;
    uint64_t text_bytes;
    void *block;
    zt__memory *memory = zt__memory_of(file);
    ZT_TRY(check_meta_size(sink, e, bytes, &pairs, &text_bytes));
    uint64_t size = sizeof(zt__metadata) + (uint64_t)pairs * (2 * sizeof(char *) + 2) + text_bytes;
    ZT_TRY(zt__alloc(memory, size, 1, sink->diag, &block));
    zt__metadata *m = block;
    m->count = pairs;
    m->block_size = size;
    m->keys = (const char **)(m + 1);
    m->values = m->keys + pairs;
    zt_result result = fill_meta(sink, e, bytes, m, (char *)(m->values + pairs));
    if (result != ZT_OK) {
        zt__free(memory, block, 1, (size_t)size);
        return result;
    }
    *out = m;
    return ZT_OK;
}

zt_result zt__read_metadata(const zt_file *file, zt__sink *sink, zt__metadata **out) {
    uint32_t chunk = 0;
    uint8_t *bytes;
    zt__decoder decoder;
    *out = NULL;
    while (chunk < file->chunk_count && file->entries[chunk].type != ZT__META)
        chunk++;
    /* Another version of META is skipped: spec/ztex.md section 11. */
    if (chunk == file->chunk_count || file->entries[chunk].version != zt__find_chunk_type(ZT__META)->version)
        return ZT_OK;
    const zt__entry *e = &file->entries[chunk];
    zt__enter(sink, "META");
    if (e->decoded_size > file->limits.metadata) {
        ZT_TRY(zt__report(sink, 1009, e->offset, "%llu bytes of metadata: the limit is %llu (zt_limits.metadata)",
                          (unsigned long long)e->decoded_size, (unsigned long long)file->limits.metadata));
        return ZT_OK;
    }
    zt__decoder_init(&decoder, zt__memory_of(file));
    zt_result result = zt__decoder_raw(&decoder, e->decoded_size, sink->diag, &bytes);
    if (result == ZT_OK)
        result = zt__read_chunk(file, sink, &decoder, chunk, bytes);
    if (result == ZT_OK)
        result = parse_meta(file, sink, e, bytes, out);
    zt__decoder_free(&decoder);
    return result;
}
