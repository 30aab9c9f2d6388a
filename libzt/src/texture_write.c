/* SPDX-License-Identifier: Apache-2.0 */
/* Writing textures whose payload the file layer knows nothing of. */
#include "file_write.h"
#include "texture.h"

static zt_result encode_payload(zt__encoder *encoder, uint8_t kind, const void *payload, zt_diag *diag, uint8_t **bytes,
                                uint64_t *capacity, size_t *size) {
    /* The option raw_only is for tiles. */
    zt__encoder any = *encoder;
    any.raw_only = false;
    return zt__kind_of(kind)->encode(&any, payload, diag, bytes, capacity, size);
}

static void free_payload(zt_writer *w, uint8_t kind, void *payload) {
    if (payload)
        zt__free(&w->memory, payload, 1, (size_t)zt__kind_of(kind)->block_size(payload));
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

/* The scope of the texture that is being added. wraps out of range are found when it is. */
static zt__payload_scope scope_of(const zt_writer *w, const zt_texture_desc *desc, uint32_t layer_count) {
    zt__payload_scope scope = {.texture = w->texture_count,
                               .layer_count = layer_count,
                               .wrap_u = zt__byte_of((unsigned)desc->wrap_u),
                               .wrap_v = zt__byte_of((unsigned)desc->wrap_v),
                               .image_count = w->image_count,
                               .image_of = image_of,
                               .texture_layers = texture_layers,
                               .user = w};
    return scope;
}

/* What desc says of layers: one of base colour, or its own. */
static const zt_layer_desc *layers_of(const zt_texture_desc *desc, uint32_t *count) {
    static const zt_layer_desc single = {ZT_SEMANTIC_BASE_COLOUR, 0};
    *count = desc->layer_count > 0 ? desc->layer_count : 1;
    return desc->layer_count > 0 ? desc->layers : &single;
}

/* Appends the texture; the payload is freed when that fails. */
static zt_result add_texture(zt_writer *w, const zt_texture_desc *desc, zt_kind kind, void *payload, zt_diag *diag,
                             uint32_t *texture) {
    uint32_t layer_count;
    const zt_layer_desc *layers = layers_of(desc, &layer_count);
    w->hooks = &hooks;
    zt_result r = zt__write_texture_add(w, desc, kind, layers, layer_count, payload, diag, texture);
    if (r != ZT_OK)
        free_payload(w, (uint8_t)kind, payload);
    return r;
}

static zt_result check_desc(const zt_texture_desc *desc, zt_diag *diag) {
    if (!desc || (desc->layer_count > 0 && !desc->layers))
        return zt__bad_argument(diag, "desc or its layers are NULL");
    if (desc->layer_count > 32)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 6105, ZT__NO_OFFSET, "a texture has 1 to 32 layers");
    return ZT_OK;
}

/* ---- zipmaps ---------------------------------------------------------------------------------------- */

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

static zt_result check_patches(zt_writer *w, zt__zipmap *zipmap, const zt__payload_scope *scope, zt_diag *diag) {
    zt__sink sink = zt__write_sink(diag);
    zt__enter(&sink, "texture %u", (unsigned)w->texture_count);
    return zt__write_verdict(diag, zt__check_zipmap(&sink, zipmap, scope, ZT__NO_OFFSET));
}

static zt_result check_zipmap_arguments(const zt_writer *w, const zt_texture_desc *desc, const zt_patch_desc *patches,
                                        uint32_t count, zt_diag *diag) {
    ZT_TRY(check_desc(desc, diag));
    if (!patches)
        return zt__bad_argument(diag, "the patches are NULL");
    if (count == 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 8101, ZT__NO_OFFSET, "a zipmap has a root at least");
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
    uint32_t layer_count;
    layers_of(desc, &layer_count);
    zt__payload_scope scope = scope_of(w, desc, layer_count);
    ZT_TRY(zt__zipmap_new(&w->memory, count, layer_count, diag, &zipmap));
    fill_patches(zipmap, patches);
    zt_result r = check_patches(w, zipmap, &scope, diag);
    if (r != ZT_OK) {
        free_payload(w, ZT_KIND_ZIPMAP, zipmap);
        return r;
    }
    return add_texture(w, desc, ZT_KIND_ZIPMAP, zipmap, diag, texture);
}

zt_result zt_writer_add_zipmap(zt_writer *writer, const zt_texture_desc *desc, const zt_patch_desc *patches,
                               uint32_t patch_count, zt_diag *diag, uint32_t *texture) {
    if (texture)
        *texture = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    ZT_TRY(check_zipmap_arguments(writer, desc, patches, patch_count, diag));
    return zt__writer_end(writer, add_zipmap(writer, desc, patches, patch_count, diag, texture));
}

/* ---- silmaps ---------------------------------------------------------------------------------------- */

static void fill_silmap(zt__silmap *silmap, const zt_silmap_desc *desc) {
    memcpy(silmap->cells, desc->cells, (size_t)silmap->cell_count);
    for (uint32_t k = 0; k < silmap->header.layer_count; k++) {
        silmap->samples[k] = desc->samples[k];
        silmap->minified[k] = desc->minified ? desc->minified[k] : ZT_NONE;
    }
    zt__tidy_silmap(silmap);
}

static zt_result add_silmap(zt_writer *w, const zt_texture_desc *desc, const zt_silmap_desc *from, zt_diag *diag,
                            uint32_t *texture) {
    zt__silmap *silmap;
    zt__sink sink = zt__write_sink(diag);
    zt__silmap_header header = {.cells_x = from->cells_x,
                                .cells_y = from->cells_y,
                                .cell_layers = zt__max32(from->cell_layers, 1),
                                .filter = zt__byte_of((unsigned)from->filter)};
    layers_of(desc, &header.layer_count);
    zt__payload_scope scope = scope_of(w, desc, header.layer_count);
    zt__enter(&sink, "texture %u", (unsigned)w->texture_count);
    ZT_TRY(zt__write_verdict(diag, zt__check_silmap_header(&sink, &header, &scope, ZT__NO_OFFSET)));
    ZT_TRY(zt__silmap_new(&w->memory, &header, &scope, diag, &silmap));
    fill_silmap(silmap, from);
    zt_result r = zt__write_verdict(diag, zt__check_silmap(&sink, silmap, &scope, ZT__NO_OFFSET));
    if (r != ZT_OK) {
        free_payload(w, ZT_KIND_SILMAP, silmap);
        return r;
    }
    return add_texture(w, desc, ZT_KIND_SILMAP, silmap, diag, texture);
}

zt_result zt_writer_add_silmap(zt_writer *writer, const zt_texture_desc *desc, const zt_silmap_desc *silmap,
                               zt_diag *diag, uint32_t *texture) {
    if (texture)
        *texture = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    ZT_TRY(check_desc(desc, diag));
    if (!silmap || !silmap->cells || !silmap->samples)
        return zt__bad_argument(diag, "the silmap, its cells or its samples are NULL");
    return zt__writer_end(writer, add_silmap(writer, desc, silmap, diag, texture));
}

/* ---- umbrellas -------------------------------------------------------------------------------------- */

static zt_result check_umbrella_arguments(const zt_umbrella_info *info, zt_diag *diag) {
    if (!info || !info->levels || !info->list_starts)
        return zt__bad_argument(diag, "the umbrellas, their levels or list_starts are NULL");
    if ((info->base_count > 0 && !info->bases) || (info->umbrella_count > 0 && !info->umbrellas) ||
        (info->base_vertex_count > 0 && !info->base_vertices) ||
        (info->morph_vertex_count > 0 && !info->morph_vertices) ||
        (info->variant_colour_count > 0 && !info->variant_colours) ||
        (info->explicit_vertex_count > 0 && (!info->explicit_vertices || !info->explicit_colours)) ||
        (info->entry_count > 0 && !info->entries))
        return zt__bad_argument(diag, "an array of the umbrellas is NULL, and its count is not 0");
    /* A plane has less than 2^32 bytes. */
    if (info->explicit_vertex_count > UINT32_MAX / 4 || info->entry_count > UINT32_MAX / 4)
        return zt__bad_argument(diag, "more than 2^30 - 1 explicit vertices or entries of lists");
    return ZT_OK;
}

/* The negative zero means zero (R8303). */
static zt__umbrella_header umbrella_header(const zt_umbrella_info *info, uint32_t layer_count) {
    zt__umbrella_header h = {
        .grid_x = info->grid_x,
        .grid_y = info->grid_y,
        .level_count = info->level_count,
        .base_count = info->base_count,
        .umbrella_count = info->umbrella_count,
        .base_vertex_count = info->base_vertex_count,
        .morph_vertex_count = info->morph_vertex_count,
        .variant_colour_count = info->variant_colour_count,
        .explicit_vertex_count = info->explicit_vertex_count,
        .entry_count = info->entry_count,
        .colour_mode = zt__byte_of((unsigned)info->colour_mode),
        .background_kind = zt__byte_of((unsigned)info->background_kind),
        .background_source = info->background_source,
        .prism_height = info->prism_height + 0.0F,
        .taper_start = info->taper_start + 0.0F,
        .taper_end = info->taper_end + 0.0F,
        .layer_count = layer_count,
    };
    for (int k = 0; k < 4; k++) {
        h.background[k] = info->background[k] + 0.0F;
        h.mean[k] = info->mean[k] + 0.0F;
    }
    return h;
}

static void copy_array(void *to, const void *from, size_t size, uint64_t count) {
    if (count > 0)
        memcpy(to, from, (size_t)count * size);
}

/* What link needs; reserved fields become 0. */
static void fill_umbrellas(zt__umbrellas *u, const zt_umbrella_info *info) {
    const zt__umbrella_header *h = &u->header;
    for (uint32_t l = 0; l < h->level_count; l++) {
        u->levels[l].umbrella_count = info->levels[l].umbrella_count;
        u->levels[l].bits = info->levels[l].bits;
    }
    copy_array(u->bases, info->bases, sizeof *u->bases, h->base_count);
    for (uint32_t i = 0; i < h->base_count; i++) {
        u->bases[i].reserved = 0;
        u->bases[i].first_morph = info->bases[i].first_morph == ZT_NONE ? ZT_NONE : 0;
    }
    copy_array(u->umbrellas, info->umbrellas, sizeof *u->umbrellas, h->umbrella_count);
    for (uint32_t i = 0; i < h->umbrella_count; i++)
        u->umbrellas[i].reserved = 0;
    copy_array(u->base_vertices, info->base_vertices, sizeof *u->base_vertices, h->base_vertex_count);
    copy_array(u->morph_vertices, info->morph_vertices, sizeof *u->morph_vertices, h->morph_vertex_count);
    copy_array(u->variant_colours, info->variant_colours, sizeof *u->variant_colours, h->variant_colour_count);
    for (uint32_t i = 0; i < h->variant_colour_count; i++)
        u->variant_colours[i].reserved = 0;
}

/* Lists as sizes, which must not go back. They may come from anywhere: entries are read within entry_count. */
static zt_result fill_lists(zt__umbrellas *u, const zt_umbrella_info *info, zt_diag *diag) {
    const uint32_t *starts = info->list_starts;
    if (starts[0] != 0)
        return zt__bad_argument(diag, "list_starts does not begin with 0");
    for (uint32_t i = 0; i < u->view.cell_count; i++) {
        if (starts[i + 1] < starts[i])
            return zt__bad_argument(diag, "list_starts goes back");
        u->list_starts[i + 1] = starts[i + 1] - starts[i];
        u->header.longest_list = zt__max32(u->header.longest_list, u->list_starts[i + 1]);
    }
    u->view.longest_list = u->header.longest_list;
    copy_array(u->entries, info->entries, sizeof *u->entries, info->entry_count);
    return ZT_OK;
}

static zt_result make_umbrellas(zt__umbrellas *u, const zt_umbrella_info *info, const zt__payload_scope *scope,
                                zt__sink *sink, zt_diag *diag) {
    fill_umbrellas(u, info);
    ZT_TRY(fill_lists(u, info, diag));
    ZT_TRY(zt__link_umbrellas(sink, u, scope, ZT__NO_OFFSET));
    copy_array(u->explicit_vertices, info->explicit_vertices, sizeof *u->explicit_vertices,
               info->explicit_vertex_count);
    copy_array(u->explicit_colours, info->explicit_colours, sizeof *u->explicit_colours, u->view.explicit_colour_count);
    for (uint32_t i = 0; i < u->view.explicit_colour_count; i++)
        u->explicit_colours[i].reserved = 0;
    ZT_TRY(zt__link_lists(sink, u, scope, ZT__NO_OFFSET));
    return zt__check_umbrellas(sink, u, scope, ZT__NO_OFFSET);
}

static zt_result add_umbrellas(zt_writer *w, const zt_texture_desc *desc, const zt_umbrella_info *info, zt_diag *diag,
                               uint32_t *texture) {
    zt__umbrellas *u;
    uint32_t layer_count;
    zt__sink sink = zt__write_sink(diag);
    layers_of(desc, &layer_count);
    zt__payload_scope scope = scope_of(w, desc, layer_count);
    zt__umbrella_header header = umbrella_header(info, layer_count);
    zt__enter(&sink, "texture %u", (unsigned)w->texture_count);
    ZT_TRY(zt__write_verdict(diag, zt__check_umbrella_header(&sink, &header, &scope, ZT__NO_OFFSET)));
    ZT_TRY(zt__umbrellas_new(&w->memory, &header, &scope, diag, &u));
    zt_result r = zt__write_verdict(diag, make_umbrellas(u, info, &scope, &sink, diag));
    if (r != ZT_OK) {
        free_payload(w, ZT_KIND_UMBRELLA, u);
        return r;
    }
    return add_texture(w, desc, ZT_KIND_UMBRELLA, u, diag, texture);
}

zt_result zt_writer_add_umbrellas(zt_writer *writer, const zt_texture_desc *desc, const zt_umbrella_info *info,
                                  zt_diag *diag, uint32_t *texture) {
    if (texture)
        *texture = 0;
    ZT_TRY(zt__writer_begin(writer, diag));
    ZT_TRY(check_desc(desc, diag));
    ZT_TRY(check_umbrella_arguments(info, diag));
    return zt__writer_end(writer, add_umbrellas(writer, desc, info, diag, texture));
}
