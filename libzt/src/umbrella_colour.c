/* SPDX-License-Identifier: Apache-2.0 */
/* The colour of an umbrella at a point (spec/umbrella.md section 3, steps 4 and 5). */
#include <math.h>

#include "umbrella_sample.h"

static const uint8_t clamped[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};

/* ---- the picture (step 4) ----------------------------------------------------------------------------- */

/* What barycentric coordinates g and k stand for in the picture, less the centre. */
static void in_picture(const zt_umbrella_texel t[3], double g, double k, double out[2]) {
    out[0] = (g * (t[1].x - t[0].x) + k * (t[2].x - t[0].x)) / 65535;
    out[1] = (g * (t[1].y - t[0].y) + k * (t[2].y - t[0].y)) / 65535;
}

/* The same for a step in cells. */
static void step_in_picture(const zt__sector *s, const zt_umbrella_texel t[3], double dx, double dy, double out[2]) {
    const double *m = s->placed->units;
    double x = m[0] * dx + m[1] * dy, y = m[2] * dx + m[3] * dy;
    in_picture(t, (x * s->b.y - y * s->b.x) / s->area, (s->a.x * y - s->a.y * x) / s->area, out);
}

static zt_result look_at_picture(const zt__umbrella_lookup *l, uint32_t index, const zt__sector *s,
                                 const zt__pixel *pixel, float rgba[4]) {
    const zt_umbrella_info *info = &l->view->umbrellas->view;
    const zt_umbrella_base *base = &info->bases[index];
    const zt_umbrella_texel *vertices = info->base_vertices + base->first_vertex;
    const zt_umbrella_texel t[3] = {base->centre, vertices[s->i], vertices[s->j]};
    double at[2], dx[2], dy[2];
    in_picture(t, s->g / s->area, s->k / s->area, at);
    step_in_picture(s, t, pixel->d[0], pixel->d[1], dx);
    step_in_picture(s, t, pixel->d[2], pixel->d[3], dy);
    zt_point p = {.u = base->centre.x / 65535.0 + at[0],
                  .v = base->centre.y / 65535.0 + at[1],
                  .du_dx = dx[0],
                  .dv_dx = dx[1],
                  .du_dy = dy[0],
                  .dv_dy = dy[1],
                  .array_layer = l->array_layer};
    if (!base->shows_texture)
        return zt__sample_image_at(l->call, l->view->sources[index], clamped, &p, rgba);
    return l->show->show(l->show->user, l->view->sources[index], &p, (zt__colours){rgba, NULL});
}

/* ---- colour offsets (step 5) -------------------------------------------------------------------------- */

/* Colours of the centre and the vertices; those of two variants are mixed. */
typedef struct palette {
    const zt_umbrella_colour *colours[2];
    double weights[2]; /* for one unit of what is stored */
    int count;
    bool is_signed;
} palette;

/* Numbers that stand for q |q| / 127^2, or for (q / 255)^2, times that. */
static inline int decoded(const palette *p, uint8_t code) {
    if (!p->is_signed)
        return code * code;
    int q = code < 128 ? code : code - 256;
    q = q < -127 ? -127 : q;
    return q < 0 ? -q * q : q * q;
}

static void add_colour(const palette *p, uint32_t vertex, double weight, double sum[3]) {
    for (int i = 0; i < p->count; i++) {
        const zt_umbrella_colour *c = &p->colours[i][vertex];
        double w = weight * p->weights[i];
        sum[0] += w * decoded(p, c->r);
        sum[1] += w * decoded(p, c->g);
        sum[2] += w * decoded(p, c->b);
    }
}

static palette palette_of(const zt_umbrella_info *info, const zt_umbrella *u) {
    palette p = {.count = 1, .weights = {1 / (127.0 * 127), 0}, .is_signed = true};
    if (u->form != ZT_UMBRELLA_PARAMETRIC) {
        p.colours[0] = info->explicit_colours + u->first_colour;
        p.is_signed = u->form == ZT_UMBRELLA_EXPLICIT;
        if (!p.is_signed)
            p.weights[0] = 1 / (255.0 * 255);
        return p;
    }
    const zt_umbrella_base *base = &info->bases[u->base];
    if (base->variant_count == 0) {
        p.count = 0;
        return p;
    }
    const zt_umbrella_colour *variants = info->variant_colours + base->first_colour;
    size_t size = 1 + (size_t)base->vertex_count;
    p.colours[0] = variants + u->variant_0 * size;
    p.colours[1] = variants + u->variant_1 * size;
    if (u->variant_weight != 0 && u->variant_0 != u->variant_1) {
        p.count = 2;
        p.weights[1] = p.weights[0] * (u->variant_weight / 255.0);
        p.weights[0] *= 1 - u->variant_weight / 255.0;
    }
    return p;
}

/* Adds a vertex' colour, weighted by 1 / distance; a vertex at the point itself is all there is: true. */
static bool add_near(const palette *p, uint32_t vertex, double dx, double dy, double sum[3], double *weights) {
    double distance2 = dx * dx + dy * dy;
    if (!(distance2 > 0)) {
        sum[0] = sum[1] = sum[2] = 0;
        *weights = 1;
        add_colour(p, vertex, 1, sum);
        return true;
    }
    double weight = 1 / sqrt(distance2);
    add_colour(p, vertex, weight, sum);
    *weights += weight;
    return false;
}

static void inverse_distance(const palette *p, const zt__sector *s, double stretch, double sum[3]) {
    double y = s->y * stretch, weights = 0;
    bool found = add_near(p, 0, s->x, y, sum, &weights);
    for (uint32_t i = 0; i < s->contour.count && !found; i++) {
        zt_umbrella_offset v = zt__contour_vertex(&s->contour, i);
        found = add_near(p, 1 + i, v.x - s->x, v.y * stretch - y, sum, &weights);
    }
    for (int c = 0; c < 3; c++)
        sum[c] /= weights;
}

static void offset_at(const zt_umbrella_info *info, const zt_umbrella *u, const zt__sector *s, double sum[3]) {
    palette p = palette_of(info, u);
    sum[0] = sum[1] = sum[2] = 0;
    if (p.count == 0)
        return;
    if (info->colour_mode == ZT_UMBRELLA_INVERSE_DISTANCE) {
        bool parametric = u->form == ZT_UMBRELLA_PARAMETRIC;
        inverse_distance(&p, s, parametric ? info->bases[u->base].aspect / 65536.0 : 1, sum);
        return;
    }
    double g = s->g / s->area, k = s->k / s->area;
    add_colour(&p, 0, 1 - g - k, sum);
    add_colour(&p, 1 + s->i, g, sum);
    add_colour(&p, 1 + s->j, k, sum);
}

/* ---- both ----------------------------------------------------------------------------------------------- */

zt_result zt__umbrella_colour(const zt__umbrella_lookup *lookup, uint32_t umbrella, const zt__sector *sector,
                              const zt__pixel *pixel, double rgba[4]) {
    const zt_umbrella_info *info = &lookup->view->umbrellas->view;
    const zt_umbrella *u = &info->umbrellas[umbrella];
    bool coloured = u->form == ZT_UMBRELLA_COLOURED;
    float picture[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    double offset[3] = {0, 0, 0};
    double strength = coloured ? 1 : u->strength / 255.0;
    if (!coloured)
        ZT_TRY(look_at_picture(lookup, u->base, sector, pixel, picture));
    double alpha = (double)picture[3];
    if (strength > 0 && alpha > 0)
        offset_at(info, u, sector, offset);
    for (int c = 0; c < 3; c++) {
        double v = (double)picture[c] + alpha * strength * offset[c];
        v = v > 0 ? v : 0;
        rgba[c] = v < alpha ? v : alpha;
    }
    rgba[3] = alpha;
    return ZT_OK;
}
