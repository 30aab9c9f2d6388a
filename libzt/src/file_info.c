/* SPDX-License-Identifier: Apache-2.0 */
/* Getters: what is in an opened file. */
#include "file_open.h"

#define STRING2(x) #x
#define STRING(x) STRING2(x)

const char *zt_version_string(void) {
    return STRING(ZT_VERSION_MAJOR) "." STRING(ZT_VERSION_MINOR) "." STRING(ZT_VERSION_PATCH);
}

void zt_get_file(const zt_file *file, zt_file_info *out) {
    if (!out)
        return;
    memset(out, 0, sizeof *out);
    if (!file)
        return;
    out->major = file->preamble.major;
    out->minor = file->preamble.minor;
    out->file_size = file->preamble.file_size;
    out->chunk_count = file->chunk_count;
    out->texture_count = file->texture_count;
    out->image_count = file->image_count;
}

void zt__chunk_info_of(const zt__entry *e, zt_chunk_info *out) {
    memset(out, 0, sizeof *out);
    for (int i = 0; i < 4; i++)
        out->type[i] = (char)(e->type >> 8 * i & 0xff);
    out->version = e->version;
    out->flags = e->flags;
    out->codec = e->codec;
    out->offset = e->offset;
    out->stored_size = e->stored_size;
    out->decoded_size = e->decoded_size;
    out->stored_hash = e->stored_hash;
    out->decoded_hash = e->decoded_hash;
}

zt_result zt_get_chunk(const zt_file *file, uint32_t chunk, zt_chunk_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!file || chunk >= file->chunk_count)
        return ZT_BAD_ARGUMENT;
    zt__chunk_info_of(&file->entries[chunk], out);
    return ZT_OK;
}

zt_result zt_read_chunk(const zt_file *file, uint32_t chunk, void *dst, size_t dst_size, zt_diag *diag) {
    zt__sink sink = {0};
    zt__decoder decoder;
    zt__begin(diag);
    if (!file || !dst || chunk >= file->chunk_count)
        return zt__bad_argument(diag, "there is no such chunk");
    if (file->entries[chunk].type == ZT__TEXL)
        return zt__bad_argument(diag, "TEXL is read by tiles");
    if (dst_size != file->entries[chunk].decoded_size)
        return zt__bad_argument(diag, "dst_size is not the chunk's decoded size");
    sink.diag = diag;
    zt__enter_chunk(&sink, file, chunk);
    zt__decoder_init(&decoder, zt__memory_of(file));
    zt_result result = zt__read_chunk(file, &sink, &decoder, chunk, dst);
    zt__decoder_free(&decoder);
    return result;
}

uint32_t zt_find_texture(const zt_file *file, const char *name) {
    for (uint32_t i = 0; file && name && i < file->texture_count; i++) {
        if (strcmp(file->textures[i].name, name) == 0)
            return i;
    }
    return ZT_NONE;
}

zt_result zt_get_image(const zt_file *file, uint32_t image, zt_image_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!file || image >= file->image_count)
        return ZT_BAD_ARGUMENT;
    const zt__image_record *r = &file->images[image].record;
    out->format = r->format;
    out->width = r->width;
    out->height = r->height;
    out->depth = r->depth;
    out->layers = r->layers;
    out->levels = r->levels;
    out->tile_edge = UINT32_C(1) << r->tile_log2;
    out->block_width = r->block_width;
    out->block_height = r->block_height;
    out->block_bytes = r->block_bytes;
    out->alpha_mode = r->alpha_mode;
    out->layer_kind = r->layer_kind;
    out->primaries = r->primaries;
    out->transfer = r->transfer;
    out->matrix = r->matrix;
    out->full_range = r->full_range;
    out->tail_level = file->images[image].tail_level;
    return ZT_OK;
}

zt_result zt_get_level(const zt_file *file, uint32_t image, uint32_t level, zt_level_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!file || image >= file->image_count || level >= file->images[image].record.levels)
        return ZT_BAD_ARGUMENT;
    const zt__image *im = &file->images[image];
    const zt__unit *unit = &file->units[im->first_unit + zt__unit_of_level(level, im->tail_level)];
    zt__level_geometry(&im->record, level, out);
    out->unit_offset = file->texels_offset + unit->record.offset;
    out->unit_size = unit->record.size;
    return ZT_OK;
}

zt_result zt_level_state(const zt_file *file, uint32_t image, uint32_t level) {
    zt_level_info info;
    if (zt_get_level(file, image, level, &info) != ZT_OK)
        return ZT_BAD_ARGUMENT;
    return zt__range_ok(info.unit_offset, info.unit_size, file->io.size) ? ZT_OK : ZT_TRUNCATED;
}

zt_result zt_load_metadata(const zt_file *file, uint32_t *count, zt_diag *diag) {
    zt__sink sink = {0};
    zt__begin(diag);
    if (count)
        *count = 0;
    if (!file || !count)
        return zt__bad_argument(diag, "an argument is NULL");
    _Atomic(zt__metadata *) *slot = &((zt_file *)(uintptr_t)file)->metadata;
    zt__metadata *metadata = atomic_load_explicit(slot, memory_order_acquire), *fresh = NULL;
    if (!metadata) {
        sink.diag = diag;
        ZT_TRY(zt__read_metadata(file, &sink, &fresh));
        if (!fresh)
            return ZT_OK;
        if (atomic_compare_exchange_strong(slot, &metadata, fresh))
            metadata = fresh;
        else
            zt__free(zt__memory_of(file), fresh, 1, (size_t)fresh->block_size);
    }
    *count = metadata->count;
    return ZT_OK;
}

static const zt__metadata *metadata_of(const zt_file *file) {
    return file ? atomic_load_explicit(&((zt_file *)(uintptr_t)file)->metadata, memory_order_acquire) : NULL;
}

zt_result zt_get_metadata(const zt_file *file, uint32_t index, const char **key, const char **value) {
    const zt__metadata *metadata = metadata_of(file);
    bool there = metadata && index < metadata->count;
    if (key)
        *key = there ? metadata->keys[index] : NULL;
    if (value)
        *value = there ? metadata->values[index] : NULL;
    return there && key && value ? ZT_OK : ZT_BAD_ARGUMENT;
}

const char *zt_find_metadata(const zt_file *file, const char *key) {
    const zt__metadata *metadata = metadata_of(file);
    for (uint32_t i = 0; metadata && key && i < metadata->count; i++) {
        if (strcmp(metadata->keys[i], key) == 0)
            return metadata->values[i];
    }
    return NULL;
}
