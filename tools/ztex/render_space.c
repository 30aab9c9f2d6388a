/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A texture in perspective: umbrellas in three dimensions, by rays through the prism over the ground, shaded by their
 * normals; everything else flat on the ground.
 */
#include "render.h"

#include <math.h>
#include <string.h>

#define STEEPEST 0.0625 /* sine below which a footprint does not grow further: rays that graze the ground */

const char *render_scene_open(const render_style *style, const render_view *view, render_scene *out) {
    const render_space *space = style->space;
    double width = fabs(view->u1 - view->u0);
    double aspect = fabs(view->v1 - view->v0) * space->aspect / width;
    camera_pose pose = camera_default(aspect);
    *out = (render_scene){.space = space, .view = view, .style = style};
    if (space->posed & CAMERA_EYE)
        memcpy(pose.eye, space->pose.eye, sizeof pose.eye);
    if (space->posed & CAMERA_TARGET)
        memcpy(pose.target, space->pose.target, sizeof pose.target);
    if (space->posed & CAMERA_UP)
        memcpy(pose.up, space->pose.up, sizeof pose.up);
    if (space->posed & CAMERA_FOV)
        pose.fov = space->pose.fov;
    out->size[0] = 1;
    out->size[1] = aspect;
    out->size[2] = space->height / (space->cells_x * width);
    return camera_open(&pose, style->width, style->height, &out->eye);
}

/* ---- on the ground ------------------------------------------------------------------------------------------ */

/* 0, or -1: there is no ground. */
static int point_on_ground(const render_scene *s, const double place[2], double step, zt_point *out) {
    double direction[3], at[6];
    double du = s->view->u1 - s->view->u0, dv = (s->view->v1 - s->view->v0) / s->size[1];
    camera_direction(&s->eye, place[0], place[1], direction);
    if (camera_ground(&s->eye, direction, at) || at[0] < 0 || at[0] > 1 || at[1] < 0 || at[1] > s->size[1])
        return -1;
    *out = (zt_point){.u = s->view->u0 + du * at[0],
                      .v = s->view->v0 + dv * at[1],
                      .w = s->style->w,
                      .du_dx = du * at[2] * step,
                      .dv_dx = dv * at[3] * step,
                      .du_dy = du * at[4] * step,
                      .dv_dy = dv * at[5] * step,
                      .array_layer = s->style->array_layer};
    return 0;
}

static zt_result sample_ground(const render_scene *s, const zt_sampler *sampler, const double (*places)[2],
                               size_t count, double step, float *out, zt_diag *diag) {
    zt_point points[RENDER_BATCH];
    float texels[4 * RENDER_BATCH];
    size_t from[RENDER_BATCH], found = 0;
    for (size_t i = 0; i < count; i++)
        if (point_on_ground(s, places[i], step, &points[found]) == 0)
            from[found++] = i;
    if (found == 0)
        return ZT_OK;
    zt_result result = zt_sample(sampler, points, found, texels, diag);
    for (size_t i = 0; result == ZT_OK && i < found; i++)
        memcpy(out + 4 * from[i], texels + 4 * i, 4 * sizeof *out);
    return result;
}

/* ---- in the prism ------------------------------------------------------------------------------------------- */

/* 0, or -1: the ray misses the prism. */
static int ray_in_prism(const render_scene *s, const double place[2], double step, zt_ray *out) {
    double direction[3], range[2], at[2][3];
    int leaves;
    camera_direction(&s->eye, place[0], place[1], direction);
    if (camera_clip(&s->eye, direction, s->size, range, &leaves))
        return -1;
    double du = s->view->u1 - s->view->u0, dv = (s->view->v1 - s->view->v0) / s->size[1];
    double cells = s->space->cells_x * fabs(du);
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++)
            at[i][c] = s->eye.eye[c] + range[i] * direction[c];
    /* On the ground a pixel is long and narrow: a square of its area. */
    double slope = fabs(direction[2]) /
                   sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    double pixel = step * cells / sqrt(fmax(slope, STEEPEST));
    pixel *= sqrt(s->eye.right[0] * s->eye.right[0] + s->eye.right[1] * s->eye.right[1] +
                  s->eye.right[2] * s->eye.right[2]);
    *out = (zt_ray){.u0 = s->view->u0 + du * at[0][0],
                    .v0 = s->view->v0 + dv * at[0][1],
                    .z0 = fmax(at[0][2], 0) * cells,
                    .u1 = s->view->u0 + du * at[1][0],
                    .v1 = s->view->v0 + dv * at[1][1],
                    .z1 = leaves ? 0 : fmax(at[1][2] * cells, 1e-9),
                    .footprint0 = range[0] * pixel,
                    .footprint1 = range[1] * pixel};
    return 0;
}

/* Light on a surface, 1 on the ground: so that what is drawn flat far away is as bright as the elements near by. */
static float shade_of(const render_space *space, const float normal[3]) {
    double facing = 0, ambient = (double)space->ambient;
    for (int c = 0; c < 3; c++)
        facing += space->light[c] * (double)normal[c];
    double ground = ambient + (1 - ambient) * space->light[2];
    return (float)((ambient + (1 - ambient) * fmax(facing, 0)) / ground);
}

static zt_result sample_prism(const render_scene *s, const zt_sampler *sampler, const double (*places)[2], size_t count,
                              double step, float *out, zt_diag *diag) {
    zt_ray rays[RENDER_BATCH];
    zt_hit hits[RENDER_BATCH];
    size_t from[RENDER_BATCH], found = 0;
    for (size_t i = 0; i < count; i++)
        if (ray_in_prism(s, places[i], step, &rays[found]) == 0)
            from[found++] = i;
    if (found == 0)
        return ZT_OK;
    zt_result result = zt_sample_rays(sampler, rays, found, hits, diag);
    for (size_t i = 0; result == ZT_OK && i < found; i++) {
        float *rgba = out + 4 * from[i];
        float shade = hits[i].kind == ZT_HIT_UMBRELLA ? shade_of(s->space, hits[i].normal) : 1.0f;
        memcpy(rgba, hits[i].rgba, sizeof hits[i].rgba);
        for (int c = 0; c < 3; c++)
            rgba[c] *= shade;
    }
    return result;
}

zt_result render_scene_sample(const render_scene *scene, const zt_sampler *sampler, const double (*places)[2],
                              size_t count, double step, float *out, zt_diag *diag) {
    memset(out, 0, count * 4 * sizeof *out);
    return scene->size[2] > 0 ? sample_prism(scene, sampler, places, count, step, out, diag)
                              : sample_ground(scene, sampler, places, count, step, out, diag);
}
