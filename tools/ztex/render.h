/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex render`: views, that is rectangles of texture coordinates (view.c), become rows of texels
 * (render_rows.c), which go into pictures, one a view or all on one sheet (verb_render.c). With --3d a view is the
 * ground that a camera (camera.c) sees in perspective (render_space.c).
 */
#ifndef ZTEX_RENDER_H
#define ZTEX_RENDER_H

#include "camera.h"
#include "command.h"
#include "image_io.h"

typedef struct render_view {
    double u0, v0, u1, v1; /* of the outer corners of the picture; may be outside 0 to 1 and may run backwards */
} render_view;

/* "u0,v0,u1,v1"; *end as in pick_numbers. 0, or -1. */
int render_view_parse(const char *text, render_view *view, const char **end);
/* "u0,v0,u1,v1;u0,v0,u1,v1" */
int render_path_parse(const char *text, render_view path[2]);
/* The view at t, 0 to 1, of a zoom: each step magnifies by the same factor, and what is in the last view moves
 * straight. */
render_view render_path_at(const render_view path[2], double t);

/* "WxH", "W", "Wx", "xH"; the missing one is 0. 0, or -1. */
int render_size_parse(const char *text, uint32_t *width, uint32_t *height);
/* Fills in what is 0: pixels as wide as high on a texture of texture_width x texture_height, at most longest a side. */
void render_size_complete(const render_view *view, uint32_t texture_width, uint32_t texture_height, uint32_t longest,
                          uint32_t *width, uint32_t *height);

typedef enum render_background {
    BACKGROUND_NONE = 0, /* alpha stays, or what is behind is black */
    BACKGROUND_PLAIN = 1,
    BACKGROUND_CHECKER = 2
} render_background;

/* What --3d asks for. */
typedef struct render_space {
    camera_pose pose;
    int posed;       /* set of CAMERA_...: what was given; the rest follows the view */
    double light[3]; /* towards the light, length 1, z up and above 0 */
    float ambient;   /* share of the light that comes from everywhere */
    /* Of the texture: cells of level 0 along u, and height of the prism in cells; 0: it is flat. */
    double cells_x, height;
    double aspect; /* height of the unit square, in its widths */
} render_space;

typedef struct render_style {
    uint32_t width, height; /* of a view */
    uint32_t supersample;   /* 1: one lookup a pixel */
    uint32_t array_layer;
    double w;
    render_background background;
    float plain[3];            /* linear */
    float gain;                /* on linear colours */
    uint32_t transfer;         /* CICP, of the result: 8 keeps linear light */
    int straight;              /* 1: the fourth channel of the result is straight alpha, 0: premultiplied */
    const render_space *space; /* NULL: the picture is the view itself */
} render_style;

/* space_args.c: what the command line says of --3d, and of light, which lookups in two dimensions know too. image: that
 * of the layer. */
int render_space_read(const cmd_args *args, const zt_file *file, uint32_t texture, const zt_image_info *image,
                      render_space *space);
int render_light_read(const cmd_args *args, zt_sampler_options *how, render_space *space);

/* A view as a camera sees it. */
typedef struct render_scene {
    const render_space *space;
    const render_view *view;
    const render_style *style;
    camera eye;
    double size[3]; /* of the ground and the prism over it, in widths of the view */
} render_scene;

/* NULL, or what is wrong. */
const char *render_scene_open(const render_style *style, const render_view *view, render_scene *out);

/* Lookups at places of the picture, in pixels: four floats each, premultiplied linear light; zeros where there is
 * nothing. step: pixels from one to the next. */
zt_result render_scene_sample(const render_scene *scene, const zt_sampler *sampler, const double (*places)[2],
                              size_t count, double step, float *out, zt_diag *diag);
#define RENDER_BATCH 256 /* places at once, at most */

/* Rows y to y + count of a view: four floats a pixel into rgba, rows pitch floats apart. */
zt_result render_rows(const zt_sampler *sampler, const render_style *style, const render_view *view, uint32_t y,
                      uint32_t count, float *rgba, size_t pitch, const zt_parallel *parallel, zt_diag *diag);

#endif
