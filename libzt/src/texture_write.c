/* SPDX-License-Identifier: Apache-2.0 */
/* Writing textures whose payload the file layer knows nothing of. */
#include "file_write.h"
#include "zipmap_payload.h"

static zt_result encode_payload(zt_writer *w, zt__encoder *encoder, const void *payload, zt_diag *diag, uint8_t **bytes,
                                uint64_t *capacity, size_t *size) {
    (void)w;
    /* The option raw_only is for tiles. */
    zt__encoder any = *encoder;
    any.raw_only = false;
    return zt__encode_zipmap(&any, payload, diag, bytes, capacity, size);
}

static void free_payload(zt_writer *w, void *payload) {
    zt__zipmap *zipmap = payload;
    if (zipmap)
        zt__free(&w->memory, zipmap, 1, zipmap->block_size);
}

static const zt__write_hooks hooks = {encode_payload, free_payload};

static const zt__image_record *image_of(const void *user, uint32_t image) {
    const zt_writer *w = user;
    return image < w->image_count ? &w->images[image]->record : NULL;
}

static uint32_t texture_layers(const void *user, uint32_t texture) {
    const zt_writer *w = user;
    return texture < w->texture_count ? w->textures[texture].entry.layer_count : 0;
}

static void fill_patches(zt__zipmap *zipmap, const zt_patch_desc *patches) {
    for (uint32_t i = 0; i < zipmap->patch_count; i++) {
        const zt_patch_desc *p = &patches[i];
        zipmap->parents[i] = p->parent;
        zipmap->source_kinds[i] = p->shows_texture ? 1 : 0;
        zipmap->masks[i] = p->mask;
        for (uint32_t k = 0; k < zipmap->layer_count; k++)
            zipmap->sources[(size_t)k * zipmap->patch_count + i] = p->sources[p->shows_texture ? 0 : k];
        memcpy(zipmap->matrices[i], p->matrix, sizeof p->matrix);
        /* Entries that came out as negative zero mean zero (R8109). */
        for (int k = 0; k < 9; k++)
            zipmap->matrices[i][k] += 0.0;
    }
}

static zt_result check_patches(zt_writer *w, zt__zipmap *zipmap, zt_diag *diag) {
    zt__sink sink = zt__write_sink(diag);
    zt__zipmap_scope scope = {.texture = w->texture_count,
                              .layer_count = zipmap->layer_count,
                              .image_count = w->image_count,
                              .image_of = image_of,
                              .texture_layers = texture_layers,
                              .user = w};
    zt__enter(&sink, "texture %u", (unsigned)w->texture_count);
    return zt__write_verdict(diag, zt__check_zipmap(&sink, zipmap, &scope, ZT__NO_OFFSET));
}

static zt_result check_arguments(const zt_writer *w, const zt_texture_desc *desc, const zt_patch_desc *patches,
                                 uint32_t count, zt_diag *diag) {
    if (!desc || !patches || (desc->layer_count > 0 && !desc->layers))
        return zt__bad_argument(diag, "desc, its layers, or the patches are NULL");
    if (count == 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 8101, ZT__NO_OFFSET, "a zipmap has a root at least");
    if (desc->layer_count > 32)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 6105, ZT__NO_OFFSET, "a texture has 1 to 32 layers");
    if (count > w->limits.patches)
        return zt__fail(diag, ZT_LIMIT, 0, ZT__NO_OFFSET, "more patches than zt_limits.patches");
    for (uint32_t i = 0; i < count; i++)
        if (!patches[i].sources)
            return zt__bad_argument(diag, "the sources of a patch are NULL");
    return ZT_OK;
}

static zt_result add_zipmap(zt_writer *w, const zt_texture_desc *desc, const zt_patch_desc *patches, uint32_t count,
                            zt_diag *diag, uint32_t *texture) {
    zt__zipmap *zipmap;
    zt_layer_desc single = {ZT_SEMANTIC_BASE_COLOUR, 0};
    const zt_layer_desc *layers = desc->layer_count > 0 ? desc->layers : &single;
    uint32_t layer_count = desc->layer_count > 0 ? desc->layer_count : 1;
    w->hooks = &hooks;
    ZT_TRY(zt__zipmap_new(&w->memory, count, layer_count, diag, &zipmap));
    fill_patches(zipmap, patches);
    zt_result r = check_patches(w, zipmap, diag);
    if (r == ZT_OK)
        r = zt__write_texture_add(w, desc, ZT_KIND_ZIPMAP, layers, layer_count, zipmap, diag, texture);
    if (r != ZT_OK)
        free_payload(w, zipmap);
    return r;
}

zt_result zt_writer_add_zipmap(zt_writer *writer, const zt_texture_desc *desc, const zt_patch_desc *patches,
                               uint32_t patch_count, zt_diag *diag, uint32_t *texture) {
    if (texture)
        *texture = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    ZT_TRY(check_arguments(writer, desc, patches, patch_count, diag));
    return zt__writer_end(writer, add_zipmap(writer, desc, patches, patch_count, diag, texture));
}
