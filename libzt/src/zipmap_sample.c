/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lookups in zipmaps: equation (1) of Eisemann and Magnor 2010 in the order of spec/zipmap.md section 3, from the
 * front, so that it ends where nothing behind shows.
 */
#include "zipmap_sample.h"

#include <math.h>

static const uint8_t clamped[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};

typedef struct blending {
    zt__sample_call *call;
    const zt__zipmap_view *view;
    const zt__show_texture *show;
    zt__colours out;
    float rest; /* T: what the patches so far let through */
} blending;

static inline void add(float *sum, float weight, const float rgba[4]) {
    for (int c = 0; c < 4; c++)
        sum[c] += weight * rgba[c];
}

/* The coordinate of the patch and its derivatives, by the Jacobian of its homography. False: the patch is not there. */
static bool project(const double m[9], double u, double v, const zt_point *root, zt_point *p) {
    double w = m[6] * u + m[7] * v + m[8];
    if (!(w > 0.0))
        return false;
    double x = (m[0] * u + m[1] * v + m[2]) / w;
    double y = (m[3] * u + m[4] * v + m[5]) / w;
    if (!(x >= 0.0 && x <= 1.0 && y >= 0.0 && y <= 1.0))
        return false;
    double j00 = (m[0] - x * m[6]) / w;
    double j01 = (m[1] - x * m[7]) / w;
    double j10 = (m[3] - y * m[6]) / w;
    double j11 = (m[4] - y * m[7]) / w;
    *p = (zt_point){
        .u = x,
        .v = y,
        .du_dx = j00 * root->du_dx + j01 * root->dv_dx,
        .dv_dx = j10 * root->du_dx + j11 * root->dv_dx,
        .du_dy = j00 * root->du_dy + j01 * root->dv_dy,
        .dv_dy = j10 * root->du_dy + j11 * root->dv_dy,
        .array_layer = root->array_layer,
    };
    return true;
}

/* f: 1 while the pyramid has levels, 0 one level behind its end. */
static float fade_of(const zt__sample_image *image, double lambda) {
    double f = (double)image->levels - lambda;
    if (!(f > 0.0)) /* NaN too */
        return 0.0f;
    return f < 1.0 ? (float)f : 1.0f;
}

static zt_result add_images(blending *b, const zt__patch_sources *s, const zt_point *p) {
    zt__sample_call *call = b->call;
    bool masked = s->mask != ZT_NONE;
    uint32_t slot = masked ? s->mask : s->base;
    const zt__sample_image *image = &call->set->images[slot];
    zt__footprint footprint = zt__footprint_of(image, &call->look, p);
    float rgba[4];
    float f = fade_of(image, footprint.lambda);
    if (f == 0.0f)
        return ZT_OK;
    ZT_TRY(zt__sample_footprint(call, slot, clamped, p, &footprint, rgba));
    float coverage = masked ? rgba[0] : rgba[3];
    float a = f * coverage;
    if (masked && a == 0.0f)
        return ZT_OK;
    if (b->out.base && masked)
        ZT_TRY(zt__sample_image_at(call, s->base, clamped, p, rgba));
    if (b->out.base)
        add(b->out.base, b->rest * (masked ? a : f), rgba);
    if (b->out.layer && a != 0.0f) {
        ZT_TRY(zt__sample_image_at(call, s->layer, clamped, p, rgba));
        add(b->out.layer, b->rest * a, rgba);
    }
    b->rest *= 1.0f - a;
    return ZT_OK;
}

static zt_result add_texture(blending *b, const zt__patch_sources *s, const zt_point *p) {
    float base[4];
    float layer[4];
    float mask[4] = {1.0f, 0.0f, 0.0f, 1.0f};
    zt__colours shown = {base, b->out.layer ? layer : NULL};
    if (s->mask != ZT_NONE)
        ZT_TRY(zt__sample_image_at(b->call, s->mask, clamped, p, mask));
    if (mask[0] == 0.0f)
        return ZT_OK;
    ZT_TRY(b->show->show(b->show->user, s->texture, p, shown));
    float a = base[3] * mask[0];
    if (b->out.base)
        add(b->out.base, b->rest * mask[0], base);
    if (b->out.layer)
        add(b->out.layer, b->rest * a, layer);
    b->rest *= 1.0f - a;
    return ZT_OK;
}

static zt_result add_patches(blending *b, double u, double v, const zt_point *root) {
    const uint32_t *list;
    uint32_t count = zt__patches_at(b->view->grid, u, v, &list);
    for (uint32_t k = 0; k < count && b->rest >= 0x1p-16f; k++) {
        const zt__patch_sources *s = &b->view->sources[list[k]];
        zt_point p;
        if (!project(b->view->zipmap->composed[list[k]], u, v, root, &p))
            continue;
        ZT_TRY(s->texture != ZT_NONE ? add_texture(b, s, &p) : add_images(b, s, &p));
    }
    return ZT_OK;
}

zt_result zt__sample_zipmap(zt__sample_call *call, const zt__zipmap_view *view, const uint8_t wraps[3],
                            const zt_point *point, const zt__show_texture *show, zt__colours out) {
    blending b = {call, view, show, out, 1.0f};
    const zt__patch_sources *root = &view->sources[0];
    double u = point->u;
    double v = point->v;
    float rgba[4];
    for (int c = 0; c < 4; c++) {
        if (out.base)
            out.base[c] = 0.0f;
        if (out.layer)
            out.layer[c] = 0.0f;
    }
    bool inside = zt__wrap_unit(&u, wraps[0]);
    inside = zt__wrap_unit(&v, wraps[1]) && inside;
    if (view->grid && inside)
        ZT_TRY(add_patches(&b, u, v, point));
    if (b.rest < 0x1p-16f)
        return ZT_OK;
    if (out.base) {
        ZT_TRY(zt__sample_image_at(call, root->base, wraps, point, rgba));
        add(out.base, b.rest, rgba);
    }
    if (out.layer) {
        ZT_TRY(zt__sample_image_at(call, root->layer, wraps, point, rgba));
        add(out.layer, b.rest, rgba);
    }
    return ZT_OK;
}
