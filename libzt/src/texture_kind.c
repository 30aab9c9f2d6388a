/* SPDX-License-Identifier: Apache-2.0 */
/* The kinds of textures that have payloads, as one table. */
#include "texture.h"

/* ---- zipmaps ---------------------------------------------------------------------------------------- */

static zt_result decode_zipmap(zt__sink *sink, zt_file *file, zt__decoder *decoder, const uint8_t *data, size_t size,
                               const zt__payload_scope *scope, uint64_t offset, void **payload) {
    zt__zipmap *zipmap;
    zt_result result = zt__decode_zipmap(sink, &file->memory, decoder, &file->limits, data, size, scope, offset,
                                         &zipmap);
    *payload = zipmap;
    return result;
}

static zt_result encode_zipmap(zt__encoder *encoder, const void *payload, zt_diag *diag, uint8_t **bytes,
                               uint64_t *capacity, size_t *size) {
    return zt__encode_zipmap(encoder, payload, diag, bytes, capacity, size);
}

static uint64_t zipmap_block_size(const void *payload) {
    const zt__zipmap *zipmap = payload;
    return zipmap->block_size;
}

static uint32_t zipmap_image(const void *payload, uint32_t layer) {
    const zt__zipmap *z = payload;
    return z->source_kinds[0] == 0 ? z->sources[(size_t)layer * z->patch_count] : ZT_NONE;
}

static void visit_patch(const zt__zipmap *z, uint32_t patch, const zt__visitor *v) {
    if (z->masks[patch] != ZT_NONE)
        v->image(v->user, z->masks[patch]);
    if (z->source_kinds[patch] != 0) {
        v->texture(v->user, z->sources[patch]);
        return;
    }
    for (uint32_t k = 0; k < z->layer_count; k++)
        v->image(v->user, z->sources[(size_t)k * z->patch_count + patch]);
}

static void visit_zipmap(const void *payload, uint32_t patch, const zt__visitor *v) {
    const zt__zipmap *z = payload;
    if (patch != ZT_NONE)
        visit_patch(z, patch, v);
    for (uint32_t i = 0; i < z->patch_count && patch == ZT_NONE; i++)
        visit_patch(z, i, v);
}

/* ---- silmaps ---------------------------------------------------------------------------------------- */

static zt_result decode_silmap(zt__sink *sink, zt_file *file, zt__decoder *decoder, const uint8_t *data, size_t size,
                               const zt__payload_scope *scope, uint64_t offset, void **payload) {
    zt__silmap *silmap;
    zt_result result = zt__decode_silmap(sink, &file->memory, decoder, data, size, scope, offset, &silmap);
    *payload = silmap;
    return result;
}

static zt_result encode_silmap(zt__encoder *encoder, const void *payload, zt_diag *diag, uint8_t **bytes,
                               uint64_t *capacity, size_t *size) {
    return zt__encode_silmap(encoder, payload, diag, bytes, capacity, size);
}

static uint64_t silmap_block_size(const void *payload) {
    const zt__silmap *silmap = payload;
    return silmap->block_size;
}

static uint32_t silmap_image(const void *payload, uint32_t layer) {
    const zt__silmap *silmap = payload;
    return silmap->samples[layer];
}

static void visit_silmap(const void *payload, uint32_t patch, const zt__visitor *v) {
    const zt__silmap *s = payload;
    (void)patch;
    for (uint32_t k = 0; k < s->header.layer_count; k++) {
        v->image(v->user, s->samples[k]);
        if (s->minified[k] != ZT_NONE)
            v->image(v->user, s->minified[k]);
    }
}

/* ---- umbrellas -------------------------------------------------------------------------------------- */

static zt_result decode_umbrellas(zt__sink *sink, zt_file *file, zt__decoder *decoder, const uint8_t *data, size_t size,
                                  const zt__payload_scope *scope, uint64_t offset, void **payload) {
    zt__umbrellas *umbrellas;
    zt_result result = zt__decode_umbrellas(sink, &file->memory, decoder, &file->limits, data, size, scope, offset,
                                            &umbrellas);
    *payload = umbrellas;
    return result;
}

static zt_result encode_umbrellas(zt__encoder *encoder, const void *payload, zt_diag *diag, uint8_t **bytes,
                                  uint64_t *capacity, size_t *size) {
    return zt__encode_umbrellas(encoder, payload, diag, bytes, capacity, size);
}

static uint64_t umbrellas_block_size(const void *payload) {
    const zt__umbrellas *umbrellas = payload;
    return umbrellas->block_size;
}

/* No single image is the layer. */
static uint32_t umbrellas_image(const void *payload, uint32_t layer) {
    (void)payload;
    (void)layer;
    return ZT_NONE;
}

static void visit_umbrellas(const void *payload, uint32_t patch, const zt__visitor *v) {
    const zt__umbrellas *u = payload;
    (void)patch;
    for (uint32_t i = 0; i < u->header.base_count; i++)
        (u->bases[i].shows_texture ? v->texture : v->image)(v->user, u->bases[i].source);
    if (u->header.background_kind != ZT_BACKGROUND_COLOUR)
        (u->header.background_kind == ZT_BACKGROUND_TEXTURE ? v->texture : v->image)(v->user,
                                                                                     u->header.background_source);
}

/* ---- the table ---------------------------------------------------------------------------------------- */

const zt__kind *zt__kind_of(uint8_t kind) {
    static const zt__kind zipmap = {decode_zipmap, encode_zipmap, zipmap_block_size, zipmap_image, visit_zipmap};
    static const zt__kind silmap = {decode_silmap, encode_silmap, silmap_block_size, silmap_image, visit_silmap};
    static const zt__kind umbrellas = {decode_umbrellas, encode_umbrellas, umbrellas_block_size, umbrellas_image,
                                       visit_umbrellas};
    switch (kind) {
    case ZT_KIND_ZIPMAP:
        return &zipmap;
    case ZT_KIND_SILMAP:
        return &silmap;
    case ZT_KIND_UMBRELLA:
        return &umbrellas;
    default:
        return NULL;
    }
}

void zt__visit_texture(const zt_file *file, uint32_t texture, uint32_t patch, const zt__visitor *visitor) {
    const zt__texture *t = &file->textures[texture];
    if (t->payload) {
        zt__kind_of(t->entry.kind)->visit(t->payload, patch, visitor);
        return;
    }
    for (uint32_t k = 0; k < t->entry.layer_count; k++)
        visitor->image(visitor->user, file->layers[t->first_layer + k].image);
}
