/* SPDX-License-Identifier: Apache-2.0 */
/* zt_recover: textures and what else there is beside texels. */
#include "recover.h"

#include <stdio.h>

/* ---- textures ---- */

/* What becomes of each texture of the laid-out file, and which images the kept ones show. */
typedef struct plan {
    uint32_t *places; /* index in the new file, or ZT_NONE: lost */
    uint8_t *shown;   /* one byte an image */
    uint32_t kept;
    bool shows_lost; /* the texture that is_lost looks at shows one that is lost */
} plan;

static void skip_image(void *user, uint32_t image) {
    (void)user;
    (void)image;
}

static void skip_texture(void *user, uint32_t texture) {
    (void)user;
    (void)texture;
}

static void look_for_lost(void *user, uint32_t texture) {
    plan *p = user;
    p->shows_lost |= p->places[texture] == ZT_NONE;
}

static bool is_lost(const zt__recovery *r, plan *p, uint32_t texture) {
    const zt__visitor visitor = {p, skip_image, look_for_lost};
    if (!zt__is_readable(r->file, texture))
        return true;
    p->shows_lost = false;
    zt__visit_texture(r->file, texture, ZT_NONE, &visitor);
    return p->shows_lost;
}

static void mark_image(void *user, uint32_t image) {
    const plan *p = user;
    p->shown[image] = 1;
}

static void mark_shown(const zt__recovery *r, plan *p, uint32_t texture) {
    const zt__visitor visitor = {p, mark_image, skip_texture};
    zt__visit_texture(r->file, texture, ZT_NONE, &visitor);
}

/* Coverage of kept patches: the mask, or the image of the first layer; of bases: their images, if they have alpha. */
static void mark_coverage(zt__recovery *r, uint32_t texture) {
    const zt__umbrellas *u = zt__umbrellas_of(r->file, texture);
    for (uint32_t i = 0; u && i < u->header.base_count; i++) {
        uint32_t source = u->bases[i].source;
        if (!u->bases[i].shows_texture && r->file->images[source].record.alpha_mode != ZT_ALPHA_NONE)
            r->coverage[source] = 1;
    }
    const zt__zipmap *z = zt__zipmap_of(r->file, texture);
    for (uint32_t i = 1; z && i < z->patch_count; i++) {
        if (z->masks[i] != ZT_NONE)
            r->coverage[z->masks[i]] = 1;
        else if (!z->source_kinds[i])
            r->coverage[z->sources[i]] = 1;
    }
}

/* all_lost: TEXS could not be read. */
static void make_plan(zt__recovery *r, bool all_lost, plan *p) {
    for (uint32_t t = 0; t < r->file->texture_count && !all_lost; t++) {
        p->places[t] = is_lost(r, p, t) ? ZT_NONE : p->kept++;
        if (p->places[t] == ZT_NONE)
            continue;
        mark_shown(r, p, t);
        mark_coverage(r, t);
    }
    r->report->textures_kept = p->kept;
    r->report->textures_lost = all_lost ? 0 : r->file->texture_count - p->kept;
}

static zt_result add_zipmap(zt__recovery *r, const plan *p, const zt__zipmap *z, const zt_texture_desc *desc) {
    void *block;
    zt__memory *m = &r->memory;
    uint64_t sources_size = (uint64_t)z->patch_count * z->layer_count;
    ZT_TRY(zt__alloc(m, z->patch_count, sizeof(zt_patch_desc), r->diag, &block));
    zt_patch_desc *patches = block;
    zt_result result = zt__alloc(m, sources_size, sizeof(uint32_t), r->diag, &block);
    uint32_t *sources = block;
    for (uint32_t i = 0; result == ZT_OK && i < z->patch_count; i++) {
        for (uint32_t k = 0; k < z->layer_count; k++) {
            uint32_t source = z->sources[(size_t)k * z->patch_count + i];
            sources[(size_t)i * z->layer_count + k] = z->source_kinds[i] ? p->places[source] : source;
        }
        patches[i] = (zt_patch_desc){.parent = z->parents[i],
                                     .shows_texture = z->source_kinds[i],
                                     .sources = sources + (size_t)i * z->layer_count,
                                     .mask = z->masks[i]};
        memcpy(patches[i].matrix, z->matrices[i], sizeof patches[i].matrix);
    }
    if (result == ZT_OK)
        result = zt_writer_add_zipmap(r->writer, desc, patches, z->patch_count, r->diag, NULL);
    zt__free(m, sources, sources_size, sizeof(uint32_t));
    zt__free(m, patches, z->patch_count, sizeof(zt_patch_desc));
    return result;
}

static zt_result add_silmap(zt__recovery *r, const zt__silmap *s, const zt_texture_desc *desc) {
    const zt_silmap_desc silmap = {.cells_x = s->header.cells_x,
                                   .cells_y = s->header.cells_y,
                                   .cell_layers = s->header.cell_layers,
                                   .filter = (zt_silmap_filter)s->header.filter,
                                   .cells = s->cells,
                                   .samples = s->samples,
                                   .minified = s->minified};
    return zt_writer_add_silmap(r->writer, desc, &silmap, r->diag, NULL);
}

static zt_result add_umbrellas(zt__recovery *r, const plan *p, const zt__umbrellas *u, const zt_texture_desc *desc) {
    void *block;
    zt_umbrella_info info = u->view;
    ZT_TRY(zt__alloc_raw(&r->memory, info.base_count, sizeof *info.bases, r->diag, &block));
    zt_umbrella_base *bases = block;
    for (uint32_t i = 0; i < info.base_count; i++) {
        bases[i] = info.bases[i];
        bases[i].source = bases[i].shows_texture ? p->places[bases[i].source] : bases[i].source;
    }
    info.bases = bases;
    if (info.background_kind == ZT_BACKGROUND_TEXTURE)
        info.background_source = p->places[info.background_source];
    zt_result result = zt_writer_add_umbrellas(r->writer, desc, &info, r->diag, NULL);
    zt__free(&r->memory, block, info.base_count, sizeof *info.bases);
    return result;
}

static zt_result add_texture(zt__recovery *r, const plan *p, uint32_t texture, const zt_texture_desc *desc) {
    switch (r->file->textures[texture].entry.kind) {
    case ZT_KIND_ZIPMAP:
        return add_zipmap(r, p, zt__zipmap_of(r->file, texture), desc);
    case ZT_KIND_SILMAP:
        return add_silmap(r, zt__silmap_of(r->file, texture), desc);
    case ZT_KIND_UMBRELLA:
        return add_umbrellas(r, p, zt__umbrellas_of(r->file, texture), desc);
    default:
        return zt_writer_add_texture(r->writer, desc, r->diag, NULL);
    }
}

static zt_result add_kept(zt__recovery *r, const plan *p, uint32_t texture) {
    const zt__texture *t = &r->file->textures[texture];
    void *block;
    ZT_TRY(zt__alloc(&r->memory, t->entry.layer_count, sizeof(zt_layer_desc), r->diag, &block));
    zt_layer_desc *layers = block;
    for (uint32_t k = 0; k < t->entry.layer_count; k++) {
        const zt__layer_entry *layer = &r->file->layers[t->first_layer + k];
        layers[k] = (zt_layer_desc){layer->semantic, layer->image};
    }
    zt_texture_desc desc = {.name = t->name,
                            .wrap_u = (zt_wrap)t->entry.wrap_u,
                            .wrap_v = (zt_wrap)t->entry.wrap_v,
                            .wrap_w = (zt_wrap)t->entry.wrap_w,
                            .layers = layers,
                            .layer_count = t->entry.layer_count};
    zt_result result = add_texture(r, p, texture, &desc);
    zt__free(&r->memory, block, t->entry.layer_count, sizeof(zt_layer_desc));
    return result;
}

/* An image that no texture shows any more gets one, so that it can be asked for. A file that was recovered before may
 * have the name already. */
static zt_result add_rebuilt(zt__recovery *r, uint32_t image) {
    char name[48];
    zt_layer_desc layer = {ZT_SEMANTIC_UNSPECIFIED, image};
    zt_texture_desc desc = {.name = name, .layers = &layer, .layer_count = 1};
    snprintf(name, sizeof name, "recovered %u", (unsigned)image);
    for (uint32_t again = 2; zt_find_texture(r->file, name) != ZT_NONE; again++)
        snprintf(name, sizeof name, "recovered %u (%u)", (unsigned)image, (unsigned)again);
    r->report->textures_rebuilt++;
    return zt_writer_add_texture(r->writer, &desc, r->diag, NULL);
}

static zt_result save_textures(zt__recovery *r, bool all_lost, const plan *p) {
    for (uint32_t t = 0; t < r->file->texture_count && !all_lost; t++) {
        if (p->places[t] != ZT_NONE)
            ZT_TRY(add_kept(r, p, t));
    }
    for (uint32_t i = 0; i < r->file->image_count; i++) {
        if (!p->shown[i] && (all_lost || r->report->textures_lost > 0))
            ZT_TRY(add_rebuilt(r, i));
    }
    return ZT_OK;
}

/* ---- the rest ---- */

static zt_result save_metadata(zt__recovery *r) {
    uint32_t count;
    const char *key, *value;
    /* A chunk that is whole, but breaks the rules of metadata, stays behind. */
    zt_diag diag;
    zt_result result = zt_load_metadata(r->file, &count, &diag);
    if (result == ZT_NO_MEMORY)
        return zt__fail(r->diag, result, 0, ZT__NO_OFFSET, "%s", diag.text);
    if (result != ZT_OK)
        return ZT_OK;
    for (uint32_t i = 0; i < count; i++) {
        zt_get_metadata(r->file, i, &key, &value);
        ZT_TRY(zt_writer_set_metadata(r->writer, key, value, r->diag));
    }
    r->report->metadata_pairs = count;
    return ZT_OK;
}

static zt_result save_chunk(zt__recovery *r, uint32_t chunk) {
    zt_chunk_info info;
    void *block;
    zt_get_chunk(r->file, chunk, &info);
    ZT_TRY(zt__alloc_raw(&r->memory, info.decoded_size, 1, r->diag, &block));
    zt_result result = zt_read_chunk(r->file, chunk, block, (size_t)info.decoded_size, r->diag);
    if (result == ZT_OK)
        result = zt_writer_add_chunk(r->writer, info.type, info.version, info.flags, block, (size_t)info.decoded_size,
                                     r->diag);
    zt__free(&r->memory, block, info.decoded_size, 1);
    r->report->chunks_kept++;
    return result;
}

static zt_result save_rest(zt__recovery *r) {
    ZT_TRY(save_metadata(r));
    for (uint32_t i = 0; i < r->file->chunk_count; i++) {
        const zt__entry *e = &r->file->entries[i];
        const zt__chunk_type *known = zt__find_chunk_type(e->type);
        if (known && known->version == e->version)
            continue;
        if (known || !(e->flags & ZT__FLAG_SAFE_TO_COPY))
            r->report->chunks_dropped++;
        else
            ZT_TRY(save_chunk(r, i));
    }
    return ZT_OK;
}

/* ---- the whole ---- */

static zt_result save(zt__recovery *r, bool all_lost, plan *p) {
    for (uint32_t i = 0; i < r->file->unit_count; i++)
        r->report->tiles += r->file->units[i].tile_count;
    make_plan(r, all_lost, p);
    for (uint32_t i = 0; i < r->file->image_count; i++)
        ZT_TRY(zt__recover_image(r, i));
    ZT_TRY(save_textures(r, all_lost, p));
    return save_rest(r);
}

static void judge(zt__recovery *r, bool all_lost) {
    zt_recover_report *report = r->report;
    for (uint32_t i = 0; i < r->found_count; i++)
        report->chunks_intact += r->found[i].intact && r->found[i].entry.type != ZT__TEXL;
    report->chunks_intact += report->tiles_replaced == 0;
    if (report->chunks_expected < report->chunks_intact)
        report->chunks_expected = report->chunks_intact;
    report->complete = !all_lost && report->textures_lost == 0 && report->tiles_replaced == 0 &&
                       report->chunks_dropped == 0 && report->chunks_intact == report->chunks_expected;
}

static zt_result run(zt__recovery *r) {
    bool usable, textures_ok = false, all_lost = false;
    void *block;
    plan p = {0};
    ZT_TRY(zt__recover_find(r));
    if (!zt__recover_chunk(r, ZT__IMAG))
        return zt__fail(r->diag, ZT_CORRUPT, 0, ZT__NO_OFFSET,
                        "no intact IMAG chunk was found: without it nothing says what the texels are");
    if (zt__recover_chunk(r, ZT__TEXS))
        ZT_TRY(zt__recover_open(r, false, &usable, &textures_ok));
    if (!textures_ok) {
        zt__recover_close(r);
        ZT_TRY(zt__recover_open(r, true, &usable, &textures_ok));
        all_lost = true;
    }
    ZT_TRY(zt__recover_place_texels(r));
    uint32_t images = r->file->image_count, textures = r->file->texture_count;
    zt_result result = zt__alloc(&r->memory, images, 2, r->diag, &block);
    r->coverage = block;
    if (result == ZT_OK)
        result = zt__alloc(&r->memory, textures, sizeof *p.places, r->diag, &block);
    if (result == ZT_OK) {
        p.places = block;
        p.shown = r->coverage + images;
        result = save(r, all_lost, &p);
    }
    if (result == ZT_OK)
        judge(r, all_lost);
    zt__free(&r->memory, p.places, textures, sizeof *p.places);
    zt__free(&r->memory, r->coverage, images, 2);
    return result;
}

static void begin(zt__recovery *r, const zt_allocator *allocator, const zt_limits *limits) {
    if (limits)
        r->limits = *limits;
    zt__limits_fill(&r->limits);
    zt__memory_init(&r->memory, allocator, r->limits.memory);
    zt__decoder_init(&r->decoder, &r->memory);
}

static void end(zt__recovery *r) {
    zt__recover_close(r);
    zt__decoder_free(&r->decoder);
    zt__free(&r->memory, r->found, r->found_capacity, sizeof *r->found);
}

zt_result zt_recover(const zt_io *io, zt_writer *writer, const zt_recover_options *options, zt_diag *diag,
                     zt_recover_report *out) {
    static const zt_recover_options none = {0};
    zt__recovery r = {
        .damaged = io, .writer = writer, .options = options ? options : &none, .report = out, .diag = diag};
    zt__begin(diag);
    if (!io || !io->read_at || !writer || !out)
        return zt__bad_argument(diag, "an argument is NULL");
    if (r.options->size != 0 && r.options->size != sizeof *options)
        return zt__bad_argument(diag, "zt_recover_options.size is not sizeof(zt_recover_options)");
    memset(out, 0, sizeof *out);
    begin(&r, r.options->allocator, r.options->limits);
    zt_result result = run(&r);
    end(&r);
    if (result != ZT_OK)
        memset(out, 0, sizeof *out);
    return result;
}

zt_result zt_find_chunks(const zt_io *io, const zt_limits *limits, void *user,
                         int (*found)(void *user, const zt_chunk_info *chunk, int intact), zt_diag *diag) {
    zt_recover_report report = {0};
    zt__recovery r = {.damaged = io, .report = &report, .diag = diag};
    zt_chunk_info info;
    zt__begin(diag);
    if (!io || !io->read_at || !found)
        return zt__bad_argument(diag, "an argument is NULL");
    begin(&r, NULL, limits);
    zt_result result = zt__recover_find(&r);
    for (uint32_t i = 0; result == ZT_OK && i < r.found_count; i++) {
        zt__chunk_info_of(&r.found[i].entry, &info);
        if (found(user, &info, r.found[i].intact))
            result = zt__fail(diag, ZT_CANCELLED, 0, ZT__NO_OFFSET, "cancelled");
    }
    end(&r);
    return result;
}
