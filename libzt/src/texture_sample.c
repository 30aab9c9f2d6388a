/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Samplers: the only place where a lookup meets every kind of texture. A sampler has a node for its texture and one for
 * each earlier texture that patches, bases or backgrounds show, directly or through others; all share one set of
 * images.
 */
#include <math.h>

#include "silmap_sample.h"
#include "texture.h"
#include "umbrella_sample.h"
#include "zipmap_sample.h"

enum {
    MAX_DEPTH = 64 /* of the recursion, whatever zt_limits.texture_depth says: the stack has an end */
};

static const uint8_t clamped[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};

typedef struct node {
    uint32_t texture;
    uint32_t base, layer;                  /* images and silmaps: places in the image set; ZT_NONE: not needed */
    zt__silmap_view base_view, layer_view; /* kind silmap: both with those places */
    const zt__silmap *silmap;              /* NULL: another kind */
    const zt__zipmap *zipmap;              /* NULL: another kind */
    zt__patch_grid *grid;                  /* NULL: the root alone */
    zt__patch_sources *sources;            /* source_count */
    uint32_t source_count;
    zt__umbrella_view umbrella_view; /* kind umbrellas */
} node;

struct zt_sampler {
    const zt_file *file;
    zt__look look;
    uint32_t layer;
    bool root_only;
    zt__umbrella_light light;
    uint8_t wraps[3];
    bool is_volume;
    uint32_t node_count;
    node *nodes; /* the texture itself is the first */
    zt__image_set *set;
};

/* ---- opening ------------------------------------------------------------------------------------ */

/* What opening needs for a while. */
typedef struct gathering {
    zt_sampler *sampler;
    const zt_file *file;
    zt__memory *memory;
    zt_diag *diag;
    uint32_t top;
    uint32_t *depths; /* of textures 0 to top; 0: not shown, 1: the sampler's own */
    uint32_t *nodes;  /* their nodes */
    uint32_t *slots;  /* place of each image in the set, or ZT_NONE */
    uint32_t *images; /* the set */
    uint32_t image_count;
} gathering;

static const zt__zipmap *shown_zipmap(const gathering *g, uint32_t texture) {
    const zt__zipmap *z = zt__zipmap_of(g->file, texture);
    return z && !(g->sampler->root_only && texture == g->top) ? z : NULL;
}

/* What a texture shows, while its depth is passed on. */
typedef struct marking {
    gathering *g;
    uint32_t depth;
    bool too_deep;
} marking;

static void mark_texture(void *user, uint32_t texture) {
    marking *m = user;
    uint32_t *shown = &m->g->depths[texture];
    *shown = zt__max32(*shown, m->depth);
    m->too_deep = m->depth - 1 > zt__min32(m->g->file->limits.texture_depth, MAX_DEPTH);
}

static void ignore_image(void *user, uint32_t image) {
    (void)user;
    (void)image;
}

/* Marks what a texture shows. It shows only earlier ones, so going down meets each after all that show it. */
static zt_result mark_shown(gathering *g, uint32_t texture) {
    marking m = {g, g->depths[texture] + 1, false};
    zt__visitor visitor = {&m, ignore_image, mark_texture};
    uint32_t most = zt__min32(g->file->limits.texture_depth, MAX_DEPTH);
    if (!zt__is_readable(g->file, texture))
        return zt__bad_argument(g->diag, "a texture that is shown could not be read");
    zt__visit_texture(g->file, texture, g->sampler->root_only && texture == g->top ? 0 : ZT_NONE, &visitor);
    if (m.too_deep)
        return zt__fail(g->diag, ZT_LIMIT, 1011, ZT__NO_OFFSET, "textures show textures deeper than %u, the limit",
                        most);
    return ZT_OK;
}

static zt_result find_nodes(gathering *g) {
    uint32_t count = 0;
    void *block;
    g->depths[g->top] = 1;
    for (uint32_t t = g->top + 1; t-- > 0;) {
        if (g->depths[t] == 0)
            continue;
        ZT_TRY(mark_shown(g, t));
        g->nodes[t] = count++;
    }
    ZT_TRY(zt__alloc(g->memory, count, sizeof(node), g->diag, &block));
    g->sampler->nodes = block;
    g->sampler->node_count = count;
    for (uint32_t t = 0; t <= g->top; t++) {
        if (g->depths[t] == 0)
            continue;
        node *n = &g->sampler->nodes[g->nodes[t]];
        n->texture = t;
        n->zipmap = zt__zipmap_of(g->file, t);
        n->silmap = zt__silmap_of(g->file, t);
        n->umbrella_view.umbrellas = zt__umbrellas_of(g->file, t);
    }
    return ZT_OK;
}

static uint32_t slot_of(gathering *g, uint32_t image) {
    if (g->slots[image] == ZT_NONE) {
        g->slots[image] = g->image_count;
        g->images[g->image_count++] = image;
    }
    return g->slots[image];
}

/* Only what a lookup will touch: the images of other layers may be of formats that cannot be sampled. */
static zt__patch_sources sources_of(gathering *g, const zt__zipmap *z, uint32_t i, bool base_wanted) {
    uint32_t layer = g->sampler->layer;
    bool shows_texture = z->source_kinds[i] == 1;
    bool masked = z->masks[i] != ZT_NONE;
    zt__patch_sources s = {ZT_NONE, ZT_NONE, ZT_NONE, ZT_NONE};
    if (masked)
        s.mask = slot_of(g, z->masks[i]);
    if (shows_texture)
        s.texture = g->nodes[z->sources[i]];
    if (!shows_texture && (base_wanted || (i > 0 && !masked)))
        s.base = slot_of(g, z->sources[i]);
    if (!shows_texture && layer > 0)
        s.layer = slot_of(g, z->sources[(size_t)layer * z->patch_count + i]);
    return s;
}

/* One layer of a texture that is not a zipmap: its image, for silmaps with all that goes with it. */
static uint32_t layer_slot(gathering *g, const node *n, uint32_t layer, zt__silmap_view *view) {
    const zt__texture *t = &g->file->textures[n->texture];
    if (!n->silmap)
        return slot_of(g, g->file->layers[t->first_layer + layer].image);
    uint32_t minified = n->silmap->minified[layer];
    view->silmap = n->silmap;
    view->samples = slot_of(g, n->silmap->samples[layer]);
    view->minified = minified == ZT_NONE ? ZT_NONE : slot_of(g, minified);
    return view->samples;
}

/* Umbrellas have one layer, and it is the first one of what they show. */
static zt_result fill_umbrellas(gathering *g, zt__umbrella_view *v) {
    const zt_umbrella_info *info = &v->umbrellas->view;
    void *block;
    ZT_TRY(zt__alloc_raw(g->memory, info->base_count, sizeof(uint32_t), g->diag, &block));
    v->sources = block;
    for (uint32_t i = 0; i < info->base_count; i++) {
        uint32_t source = info->bases[i].source;
        v->sources[i] = info->bases[i].shows_texture ? g->nodes[source] : slot_of(g, source);
    }
    v->background = ZT_NONE;
    if (info->background_kind == ZT_BACKGROUND_IMAGE)
        v->background = slot_of(g, info->background_source);
    if (info->background_kind == ZT_BACKGROUND_TEXTURE)
        v->background = g->nodes[info->background_source];
    return zt__umbrella_scene_open(g->memory, v->umbrellas, g->diag, &v->scene);
}

static zt_result fill_node(gathering *g, node *n) {
    uint32_t layer = g->sampler->layer;
    /* Behind a patch that shows it, a texture's first layer is also its coverage. */
    bool base_wanted = layer == 0 || n->texture != g->top;
    void *block;
    n->base = ZT_NONE;
    n->layer = ZT_NONE;
    if (n->umbrella_view.umbrellas)
        return fill_umbrellas(g, &n->umbrella_view);
    if (!n->zipmap) {
        if (base_wanted)
            n->base = layer_slot(g, n, 0, &n->base_view);
        if (layer > 0)
            n->layer = layer_slot(g, n, layer, &n->layer_view);
        return ZT_OK;
    }
    bool patches = shown_zipmap(g, n->texture) != NULL;
    uint32_t count = patches ? n->zipmap->patch_count : 1;
    ZT_TRY(zt__alloc_raw(g->memory, count, sizeof(zt__patch_sources), g->diag, &block));
    n->sources = block;
    n->source_count = count;
    for (uint32_t i = 0; i < count; i++)
        n->sources[i] = sources_of(g, n->zipmap, i, base_wanted);
    return patches && count > 1 ? zt__build_patch_grid(g->memory, n->zipmap, g->diag, &n->grid) : ZT_OK;
}

static zt_result gather(gathering *g) {
    for (uint32_t i = 0; i < g->file->image_count; i++)
        g->slots[i] = ZT_NONE;
    ZT_TRY(find_nodes(g));
    for (uint32_t i = 0; i < g->sampler->node_count; i++)
        ZT_TRY(fill_node(g, &g->sampler->nodes[i]));
    return zt__image_set_open(g->file, g->images, g->image_count, g->diag, &g->sampler->set);
}

static zt_result gather_with_scratch(zt_sampler *sampler, uint32_t texture, zt_diag *diag) {
    const zt_file *file = sampler->file;
    gathering g = {.sampler = sampler, .file = file, .memory = zt__memory_of(file), .diag = diag, .top = texture};
    uint64_t words = 2 * ((uint64_t)texture + 1) + 2 * (uint64_t)file->image_count;
    void *block;
    ZT_TRY(zt__alloc(g.memory, words, sizeof(uint32_t), diag, &block));
    g.depths = block;
    g.nodes = g.depths + texture + 1;
    g.slots = g.nodes + texture + 1;
    g.images = g.slots + file->image_count;
    zt_result result = gather(&g);
    zt__free(g.memory, block, words, sizeof(uint32_t));
    return result;
}

static zt_result check_look(const zt_sampler_options *o, zt_diag *diag) {
    if (o->filter != ZT_FILTER_TRILINEAR && o->filter != ZT_FILTER_BILINEAR && o->filter != ZT_FILTER_NEAREST)
        return zt__bad_argument(diag, "no such filter");
    if (o->max_anisotropy > 16)
        return zt__bad_argument(diag, "max_anisotropy is above 16");
    if (o->max_anisotropy > 1 && o->filter != ZT_FILTER_TRILINEAR)
        return zt__bad_argument(diag, "max_anisotropy goes with the trilinear filter only");
    if (!isfinite(o->light_x) || !isfinite(o->light_y))
        return zt__bad_argument(diag, "light_x and light_y are finite");
    if (!(o->shadow >= 0.0 && o->shadow <= 1.0))
        return zt__bad_argument(diag, "shadow is 0 to 1");
    return ZT_OK;
}

static zt_result check_options(const zt_file *file, uint32_t texture, const zt_sampler_options *o, zt_diag *diag) {
    if (!file || texture >= file->texture_count)
        return zt__bad_argument(diag, "no such texture");
    if (o->size != 0 && o->size != sizeof *o)
        return zt__bad_argument(diag, "zt_sampler_options.size is not sizeof(zt_sampler_options)");
    const zt__texture *t = &file->textures[texture];
    if (!zt__is_readable(file, texture))
        return zt__bad_argument(diag, "the texture could not be read");
    if (o->layer >= t->entry.layer_count)
        return zt__bad_argument(diag, "no such layer of the texture");
    return check_look(o, diag);
}

zt_result zt_sampler_open(const zt_file *file, uint32_t texture, const zt_sampler_options *options, zt_diag *diag,
                          zt_sampler **out) {
    static const zt_sampler_options defaults = {0};
    const zt_sampler_options *o = options ? options : &defaults;
    void *block;
    zt__begin(diag);
    if (!out)
        return zt__bad_argument(diag, "out is NULL");
    *out = NULL;
    ZT_TRY(check_options(file, texture, o, diag));
    ZT_TRY(zt__alloc(zt__memory_of(file), 1, sizeof(zt_sampler), diag, &block));
    const zt__texture *t = &file->textures[texture];
    zt_sampler *s = block;
    s->file = file;
    s->look = (zt__look){o->filter, zt__max32(o->max_anisotropy, 1)};
    s->layer = o->layer;
    s->root_only = o->first_patch_only != 0;
    s->light = (zt__umbrella_light){o->light_x, o->light_y, o->shadow};
    s->wraps[0] = t->entry.wrap_u;
    s->wraps[1] = t->entry.wrap_v;
    s->wraps[2] = t->entry.wrap_w;
    s->is_volume = t->entry.kind == ZT_KIND_IMAGE && file->images[file->layers[t->first_layer].image].record.depth > 1;
    zt_result result = gather_with_scratch(s, texture, diag);
    if (result != ZT_OK) {
        zt_sampler_close(s);
        return result;
    }
    *out = s;
    return ZT_OK;
}

void zt_sampler_close(zt_sampler *sampler) {
    if (!sampler)
        return;
    zt__memory *memory = zt__memory_of(sampler->file);
    for (uint32_t i = 0; i < sampler->node_count; i++) {
        node *n = &sampler->nodes[i];
        zt__free(memory, n->sources, n->source_count, sizeof(zt__patch_sources));
        zt__free_patch_grid(memory, n->grid);
        if (n->umbrella_view.umbrellas)
            zt__free(memory, n->umbrella_view.sources, n->umbrella_view.umbrellas->view.base_count, sizeof(uint32_t));
        zt__umbrella_scene_close(memory, n->umbrella_view.scene);
    }
    zt__free(memory, sampler->nodes, sampler->node_count, sizeof(node));
    zt__image_set_close(sampler->set);
    zt__free(memory, sampler, 1, sizeof(zt_sampler));
}

/* ---- looking up --------------------------------------------------------------------------------- */

typedef struct sampling {
    const zt_sampler *sampler;
    zt__sample_call call;
    zt__silmap_scratch silmaps;
    uint32_t shown; /* textures for the present point */
} sampling;

static zt_result show(void *user, uint32_t index, const zt_point *point, zt__colours out);

static zt_result sample_layer(sampling *s, const node *n, uint32_t slot, const zt__silmap_view *view,
                              const uint8_t wraps[3], const zt_point *point, float *out) {
    if (n->silmap)
        return zt__sample_silmap(&s->call, &s->silmaps, view, wraps, point, out);
    return zt__sample_image_at(&s->call, slot, wraps, point, out);
}

/* Shadows are those of the sampler's own texture alone. */
static zt__umbrella_lookup umbrella_lookup(sampling *s, uint32_t index, const uint8_t wraps[3], uint32_t array_layer,
                                           const zt__show_texture *shower) {
    const zt_sampler *sampler = s->sampler;
    return (zt__umbrella_lookup){.call = &s->call,
                                 .view = &sampler->nodes[index].umbrella_view,
                                 .show = shower,
                                 .light = index == 0 && sampler->light.darkness > 0 ? &sampler->light : NULL,
                                 .wraps = wraps,
                                 .array_layer = array_layer};
}

static zt_result sample_node(sampling *s, uint32_t index, const uint8_t wraps[3], const zt_point *point,
                             zt__colours out) {
    const node *n = &s->sampler->nodes[index];
    zt__show_texture shower = {s, show};
    if (n->zipmap) {
        zt__zipmap_view view = {n->zipmap, n->grid, n->sources};
        return zt__sample_zipmap(&s->call, &view, wraps, point, &shower, out);
    }
    if (n->umbrella_view.umbrellas) {
        zt__umbrella_lookup lookup = umbrella_lookup(s, index, wraps, point->array_layer, &shower);
        return zt__sample_umbrellas(&lookup, point, out.base);
    }
    if (out.base)
        ZT_TRY(sample_layer(s, n, n->base, &n->base_view, wraps, point, out.base));
    if (out.layer)
        ZT_TRY(sample_layer(s, n, n->layer, &n->layer_view, wraps, point, out.layer));
    return ZT_OK;
}

/* Recursion ends: a texture shows only earlier ones, and opening has bounded how deep. How many are shown for one point
 * grows as a power of the depth where patches overlap, so that is bounded as well. */
static zt_result show(void *user, uint32_t index, const zt_point *point, zt__colours out) {
    sampling *s = user;
    uint32_t most = s->sampler->file->limits.shown_textures;
    if (++s->shown > most)
        return zt__fail(s->call.diag, ZT_LIMIT, 1012, ZT__NO_OFFSET,
                        "a lookup shows more than %u textures, the limit (zt_limits.shown_textures)", most);
    return sample_node(s, index, clamped, point, out);
}

/* The third coordinate is for volumes alone and not looked at elsewhere. */
static bool make_finite(const zt_sampler *sampler, const zt_point *in, zt_point *out) {
    *out = *in;
    if (!sampler->is_volume)
        out->w = out->dw_dx = out->dw_dy = 0.0;
    const double all[9] = {out->u,     out->v,     out->w,     out->du_dx, out->dv_dx,
                           out->dw_dx, out->du_dy, out->dv_dy, out->dw_dy};
    for (int i = 0; i < 9; i++) {
        if (!isfinite(all[i]))
            return false;
    }
    return true;
}

zt_result zt_sample(const zt_sampler *sampler, const zt_point *points, size_t count, float *out, zt_diag *diag) {
    zt__begin(diag);
    if (!sampler || (count > 0 && (!points || !out)))
        return zt__bad_argument(diag, "sampler, points or out is NULL");
    sampling s = {.sampler = sampler, .call = {.set = sampler->set, .look = sampler->look, .diag = diag}};
    zt_result result = ZT_OK;
    zt__decoder_init(&s.call.decoder, zt__memory_of(sampler->file));
    for (size_t i = 0; i < count && result == ZT_OK; i++, out += 4) {
        zt_point point;
        if (!make_finite(sampler, &points[i], &point)) {
            out[0] = out[1] = out[2] = out[3] = 0.0f;
            continue;
        }
        s.shown = 0;
        zt__colours wanted = {sampler->layer == 0 ? out : NULL, sampler->layer > 0 ? out : NULL};
        result = sample_node(&s, 0, sampler->wraps, &point, wanted);
    }
    zt__decoder_free(&s.call.decoder);
    return result;
}

static bool is_finite_ray(const zt_ray *r) {
    return isfinite(r->u0) && isfinite(r->v0) && isfinite(r->z0) && isfinite(r->u1) && isfinite(r->v1) &&
           isfinite(r->z1) && isfinite(r->footprint0) && isfinite(r->footprint1);
}

zt_result zt_sample_rays(const zt_sampler *sampler, const zt_ray *rays, size_t count, zt_hit *out, zt_diag *diag) {
    zt__begin(diag);
    if (!sampler || (count > 0 && (!rays || !out)))
        return zt__bad_argument(diag, "sampler, rays or out is NULL");
    if (!sampler->nodes[0].umbrella_view.umbrellas)
        return zt__bad_argument(diag, "the sampler's texture has no umbrellas");
    sampling s = {.sampler = sampler, .call = {.set = sampler->set, .look = sampler->look, .diag = diag}};
    zt__show_texture shower = {&s, show};
    s.call.look.filter = ZT_FILTER_TRILINEAR; /* a ray has no other (umbrella.md section 6) */
    zt__umbrella_lookup lookup = umbrella_lookup(&s, 0, sampler->wraps, 0, &shower);
    zt_result result = ZT_OK;
    zt__decoder_init(&s.call.decoder, zt__memory_of(sampler->file));
    for (size_t i = 0; i < count && result == ZT_OK; i++) {
        s.shown = 0;
        if (is_finite_ray(&rays[i]))
            result = zt__sample_umbrella_ray(&lookup, &rays[i], &out[i]);
        else
            out[i] = zt__umbrella_miss;
    }
    zt__decoder_free(&s.call.decoder);
    return result;
}

void zt_get_sampler(const zt_sampler *sampler, zt_sampler_info *out) {
    if (!out)
        return;
    *out = (zt_sampler_info){0};
    if (!sampler)
        return;
    const zt__patch_grid *grid = sampler->nodes[0].grid;
    out->tile_bytes = atomic_load_explicit(&sampler->set->tile_bytes, memory_order_relaxed);
    if (!grid)
        return;
    out->grid_width = grid->top.width;
    out->grid_height = grid->top.height;
    out->grid_entries = grid->list_total;
    out->longest_list = grid->longest;
}
