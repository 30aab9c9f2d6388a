/* SPDX-License-Identifier: Apache-2.0 */
/* Opening and closing files, and what is in a texture. */
#include "texture.h"

static zt_result open_with(zt_file *file, zt_diag *diag, zt_file **out) {
    zt__sink sink = {0};
    bool usable;
    sink.diag = diag;
    zt_result result = zt__walk(file, &sink, &zt__texture_hooks, &usable);
    if (result != ZT_OK) {
        zt__file_free(file, &zt__texture_hooks);
        return result;
    }
    *out = file;
    return ZT_OK;
}

/* The common beginning: *out is NULL from here on, *file is empty. */
static zt_result begin(const zt_open_options *options, zt_diag *diag, zt_file **out, zt_file **file) {
    zt__begin(diag);
    if (!out)
        return zt__bad_argument(diag, "out is NULL");
    *out = NULL;
    return zt__file_new(options, diag, file);
}

zt_result zt_open_memory(const void *data, size_t size, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    zt_file *file;
    ZT_TRY(begin(options, diag, out, &file));
    if (!data && size > 0) {
        zt__file_free(file, &zt__texture_hooks);
        return zt__bad_argument(diag, "data is NULL");
    }
    file->memory_io.data = data;
    file->memory_io.size = size;
    file->io = zt__io_of_memory(&file->memory_io);
    return open_with(file, diag, out);
}

zt_result zt_open_path(const char *path, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    zt_file *file;
    ZT_TRY(begin(options, diag, out, &file));
    zt_result result = path ? zt__path_io_open(&file->path_io, path, diag, &file->io)
                            : zt__bad_argument(diag, "path is NULL");
    if (result != ZT_OK) {
        zt__file_free(file, &zt__texture_hooks);
        return result;
    }
    return open_with(file, diag, out);
}

zt_result zt_open_io(const zt_io *io, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    zt_file *file;
    ZT_TRY(begin(options, diag, out, &file));
    if (!io || !io->read_at) {
        zt__file_free(file, &zt__texture_hooks);
        return zt__bad_argument(diag, "io or its read_at is NULL");
    }
    file->io = *io;
    return open_with(file, diag, out);
}

void zt_close(zt_file *file) {
    zt__file_free(file, &zt__texture_hooks);
}

zt_result zt_get_texture(const zt_file *file, uint32_t texture, zt_texture_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!file || texture >= file->texture_count)
        return ZT_BAD_ARGUMENT;
    const zt__texture *t = &file->textures[texture];
    const zt__zipmap *zipmap = zt__zipmap_of(file, texture);
    out->name = t->name;
    out->kind = (zt_kind)t->entry.kind;
    out->wrap_u = (zt_wrap)t->entry.wrap_u;
    out->wrap_v = (zt_wrap)t->entry.wrap_v;
    out->wrap_w = (zt_wrap)t->entry.wrap_w;
    out->layer_count = t->entry.layer_count;
    out->patch_count = zipmap ? zipmap->patch_count : 0;
    return ZT_OK;
}

zt_result zt_get_layer(const zt_file *file, uint32_t texture, uint32_t layer, zt_layer_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    if (!file || texture >= file->texture_count || layer >= file->textures[texture].entry.layer_count)
        return ZT_BAD_ARGUMENT;
    const zt__layer_entry *entry = &file->layers[file->textures[texture].first_layer + layer];
    out->semantic = entry->semantic;
    out->image = zt__zipmap_of(file, texture) ? zt_get_patch_image(file, texture, 0, layer) : entry->image;
    return ZT_OK;
}
