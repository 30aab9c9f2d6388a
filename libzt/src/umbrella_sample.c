/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups in umbrellas in 2-D, in the order of spec/umbrella.md section 4. */
#include "umbrella_sample.h"

#include <math.h>

/* ---- shadows (step 5) ----------------------------------------------------------------------------------- */

static uint32_t cell_at(double v, uint32_t cells) {
    return v < cells ? (uint32_t)v : cells - 1;
}

zt__umbrella_shade zt__umbrella_shade_of(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level, double x,
                                         double y, const zt__pixel *pixel) {
    const zt_umbrella_info *info = &lookup->view->umbrellas->view;
    zt__umbrella_shade shade = {.pixel = *pixel, .light = 1};
    if (!lookup->light)
        return shade;
    double s = x / level->width + lookup->light->x / info->grid_x;
    double t = y / level->height + lookup->light->y / info->grid_y;
    bool inside = zt__wrap_unit(&s, lookup->wraps[0]);
    if (!zt__wrap_unit(&t, lookup->wraps[1]) || !inside)
        return shade;
    shade.x = s * level->width;
    shade.y = t * level->height;
    shade.left = zt__umbrella_list(info, level, cell_at(shade.x, level->width), cell_at(shade.y, level->height),
                                   &shade.list);
    return shade;
}

static void darken(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level, zt__umbrella_shade *shade) {
    zt__sector sector;
    uint32_t entry = shade->list[--shade->left];
    shade->light *= 1 - lookup->light->darkness *
                            zt__umbrella_entry(lookup->view, level, entry, shade->x, shade->y, &shade->pixel, &sector);
}

double zt__umbrella_light_at(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level,
                             zt__umbrella_shade *shade, uint32_t entry) {
    while (shade->left > 0 && (shade->list[shade->left - 1] & ZT_UMBRELLA_ENTRY) > (entry & ZT_UMBRELLA_ENTRY))
        darken(lookup, level, shade);
    return shade->light;
}

double zt__umbrella_light_below(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level,
                                zt__umbrella_shade *shade) {
    while (shade->left > 0)
        darken(lookup, level, shade);
    return shade->light;
}

/* ---- the background (step 4) ---------------------------------------------------------------------------- */

zt_result zt__umbrella_background(const zt__umbrella_lookup *lookup, const zt_point *point, float rgba[4]) {
    const zt__umbrella_view *view = lookup->view;
    const zt_umbrella_info *info = &view->umbrellas->view;
    zt_point inside = *point;
    switch (info->background_kind) {
    case ZT_BACKGROUND_IMAGE:
        return zt__sample_image_at(lookup->call, view->background, lookup->wraps, point, rgba);
    case ZT_BACKGROUND_TEXTURE:
        zt__wrap_unit(&inside.u, lookup->wraps[0]);
        zt__wrap_unit(&inside.v, lookup->wraps[1]);
        return lookup->show->show(lookup->show->user, view->background, &inside, (zt__colours){rgba, NULL});
    default:
        for (int c = 0; c < 4; c++)
            rgba[c] = info->background[c];
        return ZT_OK;
    }
}

/* ---- a level (step 3) ----------------------------------------------------------------------------------- */

/* A lookup in one or two levels, which share the background. */
typedef struct blending {
    const zt__umbrella_lookup *lookup;
    const zt_point *point;
    double s, t; /* its coordinates in 0 to 1 */
    bool has_background;
    float background[4];
} blending;

static void add(double sum[4], double weight, double light, const double rgba[4]) {
    for (int c = 0; c < 3; c++)
        sum[c] += weight * light * rgba[c];
    sum[3] += weight * rgba[3];
}

static zt_result add_background(blending *b, double weight, double light, double sum[4]) {
    double rgba[4];
    if (!b->has_background)
        ZT_TRY(zt__umbrella_background(b->lookup, b->point, b->background));
    b->has_background = true;
    for (int c = 0; c < 4; c++)
        rgba[c] = (double)b->background[c];
    add(sum, weight, light, rgba);
    return ZT_OK;
}

static zt_result add_level(blending *b, uint32_t number, double share, double sum[4]) {
    const zt__umbrella_lookup *l = b->lookup;
    const zt_umbrella_info *info = &l->view->umbrellas->view;
    const zt_umbrella_level *level = &info->levels[number];
    const zt_point *p = b->point;
    double x = b->s * level->width, y = b->t * level->height, rest = share;
    zt__pixel picture = zt__pixel_of(p->du_dx * level->width, p->dv_dx * level->height, p->du_dy * level->width,
                                     p->dv_dy * level->height);
    zt__pixel pixel = l->call->look.filter == ZT_FILTER_TRILINEAR ? picture : zt__pixel_of(0, 0, 0, 0);
    zt__umbrella_shade shade = zt__umbrella_shade_of(l, level, x, y, &pixel);
    const uint32_t *list;
    uint32_t n = zt__umbrella_list(info, level, cell_at(x, level->width), cell_at(y, level->height), &list);
    while (n-- > 0) {
        zt__sector sector;
        double rgba[4];
        double coverage = zt__umbrella_entry(l->view, level, list[n], x, y, &pixel, &sector);
        if (!(coverage > 0))
            continue;
        ZT_TRY(zt__umbrella_colour(l, level->first_umbrella + (list[n] & ZT_UMBRELLA_ENTRY), &sector, &picture, rgba));
        if (rgba[3] == 0)
            continue;
        add(sum, rest * coverage, zt__umbrella_light_at(l, level, &shade, list[n]), rgba);
        rest *= 1 - coverage * rgba[3];
        if (rest < 0x1p-16 * share)
            return ZT_OK;
    }
    return add_background(b, rest, zt__umbrella_light_below(l, level, &shade), sum);
}

/* ---- the lookup ------------------------------------------------------------------------------------------- */

/* L (step 2). */
static double level_of_detail(const zt_umbrella_info *info, const zt_point *p) {
    double xx = p->du_dx * info->grid_x, yx = p->dv_dx * info->grid_y;
    double xy = p->du_dy * info->grid_x, yy = p->dv_dy * info->grid_y;
    double along_x = xx * xx + yx * yx, along_y = xy * xy + yy * yy;
    double length2 = along_x > along_y ? along_x : along_y;
    if (!(64 * length2 > 1))
        return 0;
    double l = 0.5 * log2(64 * length2);
    return l < info->level_count ? l : info->level_count;
}

/* The last level is the mean. */
static zt_result add_any_level(blending *b, uint32_t number, double share, double sum[4]) {
    const zt_umbrella_info *info = &b->lookup->view->umbrellas->view;
    if (!(share > 0))
        return ZT_OK;
    if (number < info->level_count)
        return add_level(b, number, share, sum);
    for (int c = 0; c < 4; c++)
        sum[c] += share * (double)info->mean[c];
    return ZT_OK;
}

zt_result zt__sample_umbrellas(const zt__umbrella_lookup *lookup, const zt_point *point, float rgba[4]) {
    blending b = {.lookup = lookup, .point = point, .s = point->u, .t = point->v};
    double sum[4] = {0, 0, 0, 0};
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0.0f;
    bool inside = zt__wrap_unit(&b.s, lookup->wraps[0]);
    inside = zt__wrap_unit(&b.t, lookup->wraps[1]) && inside;
    if (!inside)
        return ZT_OK;
    double detail = level_of_detail(&lookup->view->umbrellas->view, point);
    if (lookup->call->look.filter != ZT_FILTER_TRILINEAR)
        detail = floor(detail + 0.5);
    double whole = floor(detail), fraction = detail - whole;
    ZT_TRY(add_any_level(&b, (uint32_t)whole, 1 - fraction, sum));
    ZT_TRY(add_any_level(&b, (uint32_t)whole + 1, fraction, sum));
    for (int c = 0; c < 4; c++)
        rgba[c] = (float)sum[c];
    return ZT_OK;
}
