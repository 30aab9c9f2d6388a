/* SPDX-License-Identifier: Apache-2.0 */
/* The payloads of textures are decoded when a file is opened, and listed. */
#include "texture.h"

static const zt__image_record *image_of(const void *user, uint32_t image) {
    const zt_file *file = user;
    return image < file->image_count ? &file->images[image].record : NULL;
}

static uint32_t texture_layers(const void *user, uint32_t texture) {
    const zt_file *file = user;
    return texture < file->texture_count ? file->textures[texture].entry.layer_count : 0;
}

static zt_result open_payload(zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t texture,
                              const uint8_t *data, size_t size, uint64_t offset) {
    zt__texture *t = &file->textures[texture];
    zt__payload_scope scope = {
        .texture = texture,
        .layer_count = t->entry.layer_count,
        .wrap_u = t->entry.wrap_u,
        .wrap_v = t->entry.wrap_v,
        .image_count = file->image_count,
        .image_of = image_of,
        .texture_layers = texture_layers,
        .user = file,
    };
    /* The payload is NULL behind a finding that a validator went on from. */
    return zt__kind_of(t->entry.kind)->decode(sink, file, decoder, data, size, &scope, offset, &t->payload);
}

static void close_payload(zt_file *file, uint32_t texture) {
    zt__texture *t = &file->textures[texture];
    if (t->payload)
        zt__free(&file->memory, t->payload, 1, (size_t)zt__kind_of(t->entry.kind)->block_size(t->payload));
    t->payload = NULL;
}

const zt__payload_hooks zt__texture_hooks = {open_payload, close_payload};

zt_result zt_get_patch(const zt_file *file, uint32_t texture, uint32_t patch, zt_patch_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    const zt__zipmap *z = file && texture < file->texture_count ? zt__zipmap_of(file, texture) : NULL;
    if (!z || patch >= z->patch_count)
        return ZT_BAD_ARGUMENT;
    out->parent = z->parents[patch];
    out->texture = z->source_kinds[patch] == 1 ? z->sources[patch] : ZT_NONE;
    out->mask = z->masks[patch];
    memcpy(out->matrix, z->matrices[patch], sizeof out->matrix);
    memcpy(out->root_matrix, z->composed[patch], sizeof out->root_matrix);
    return ZT_OK;
}

uint32_t zt_get_patch_image(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t layer) {
    const zt__zipmap *z = file && texture < file->texture_count ? zt__zipmap_of(file, texture) : NULL;
    if (!z || patch >= z->patch_count || layer >= z->layer_count || z->source_kinds[patch] != 0)
        return ZT_NONE;
    return z->sources[(size_t)layer * z->patch_count + patch];
}

zt_result zt_get_silmap(const zt_file *file, uint32_t texture, zt_silmap_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    const zt__silmap *s = file && texture < file->texture_count ? zt__silmap_of(file, texture) : NULL;
    if (!s)
        return ZT_BAD_ARGUMENT;
    out->cells_x = s->header.cells_x;
    out->cells_y = s->header.cells_y;
    out->cell_layers = s->header.cell_layers;
    out->filter = (zt_silmap_filter)s->header.filter;
    out->cells = s->cells;
    return ZT_OK;
}

uint32_t zt_get_silmap_minified(const zt_file *file, uint32_t texture, uint32_t layer) {
    const zt__silmap *s = file && texture < file->texture_count ? zt__silmap_of(file, texture) : NULL;
    return s && layer < s->header.layer_count ? s->minified[layer] : ZT_NONE;
}

zt_result zt_get_umbrellas(const zt_file *file, uint32_t texture, zt_umbrella_info *out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    memset(out, 0, sizeof *out);
    const zt__umbrellas *u = file && texture < file->texture_count ? zt__umbrellas_of(file, texture) : NULL;
    if (!u)
        return ZT_BAD_ARGUMENT;
    *out = u->view;
    return ZT_OK;
}
