/* SPDX-License-Identifier: Apache-2.0 */
/* Opening and closing files, and what is in a texture. */
#include "texture.h"

static zt_result open_source(const zt__source *source, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    zt__sink sink = {0};
    zt_file *file;
    bool usable;
    zt__begin(diag);
    if (!out)
        return zt__bad_argument(diag, "out is NULL");
    *out = NULL;
    ZT_TRY(zt__file_new(options, source, diag, &file));
    sink.diag = diag;
    zt_result result = zt__walk(file, &sink, &zt__texture_hooks, &usable);
    if (result != ZT_OK) {
        zt__file_free(file, &zt__texture_hooks);
        return result;
    }
    *out = file;
    return ZT_OK;
}

zt_result zt_open_memory(const void *data, size_t size, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    const zt__source source = {.kind = ZT__FROM_MEMORY, .data = data, .size = size};
    return open_source(&source, options, diag, out);
}

zt_result zt_open_path(const char *path, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    const zt__source source = {.kind = ZT__FROM_PATH, .path = path};
    return open_source(&source, options, diag, out);
}

zt_result zt_open_io(const zt_io *io, const zt_open_options *options, zt_diag *diag, zt_file **out) {
    const zt__source source = {.kind = ZT__FROM_IO, .io = io};
    return open_source(&source, options, diag, out);
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
    const zt__texture *t = &file->textures[texture];
    const zt__layer_entry *entry = &file->layers[t->first_layer + layer];
    out->semantic = entry->semantic;
    out->image = t->payload ? zt__kind_of(t->entry.kind)->layer_image(t->payload, layer) : entry->image;
    return ZT_OK;
}
