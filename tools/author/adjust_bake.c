/* SPDX-License-Identifier: Apache-2.0 */
/* An affine frame around a picture that a homography places, for readers and data that know offset, turn and scale
 * only. */
#include "adjust.h"

#include <math.h>

#define MOST_TEXELS 4.0 /* of the picture's */
#define MARGIN 1        /* texels around: the border of a patch is empty */

static const double places[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};

/* The box of the picture's corners, in the frame of its centre: into low and high. */
static int find_box(const double linear[9], const double back[9], double low[2], double high[2]) {
    for (int i = 0; i < 4; i++) {
        double parent[2], at[2];
        if (adjust_apply(back, places[i][0], places[i][1], parent) || adjust_apply(linear, parent[0], parent[1], at))
            return -1;
        for (int k = 0; k < 2; k++) {
            low[k] = i == 0 ? at[k] : fmin(low[k], at[k]);
            high[k] = i == 0 ? at[k] : fmax(high[k], at[k]);
        }
    }
    return 0;
}

/* Texels of the picture along one unit of the frame's x and y, where they lie closest. */
static int find_density(const double frame[9], double width, double height, double density[2]) {
    density[0] = density[1] = 0.0;
    double back[9], at[2], j[4];
    if (adjust_invert(frame, back))
        return -1;
    for (int i = 0; i < 5; i++) {
        if (adjust_apply(frame, places[i][0], places[i][1], at))
            return -1;
        adjust_jacobian(back, at[0], at[1], j);
        density[0] = fmax(density[0], adjust_length(j[0] * width, j[2] * height));
        density[1] = fmax(density[1], adjust_length(j[1] * width, j[3] * height));
    }
    return 0;
}

/* The affine map that the homography is at the picture's centre. */
static int linearise(const double matrix[9], const double back[9], double linear[9]) {
    double centre[2], j[4];
    if (adjust_apply(back, 0.5, 0.5, centre))
        return -1;
    adjust_jacobian(matrix, centre[0], centre[1], j);
    const double affine[9] = {j[0], j[1], 0.5 - j[0] * centre[0] - j[1] * centre[1],
                              j[2], j[3], 0.5 - j[2] * centre[0] - j[3] * centre[1],
                              0,    0,    1};
    for (int i = 0; i < 9; i++)
        linear[i] = affine[i];
    return 0;
}

author_result author_bake(author_run *run, const double matrix[9], uint32_t width, uint32_t height,
                          author_baking *out) {
    double back[9], linear[9], low[2], high[2], density[2];
    *out = (author_baking){0};
    if (adjust_invert(matrix, back) || linearise(matrix, back, linear) || find_box(linear, back, low, high))
        return author_fail(run, AUTHOR_BAD_INPUT, "the placement reaches its horizon: it has no affine frame");
    const double fit[9] = {1.0 / (high[0] - low[0]),
                           0,
                           -low[0] / (high[0] - low[0]),
                           0,
                           1.0 / (high[1] - low[1]),
                           -low[1] / (high[1] - low[1]),
                           0,
                           0,
                           1};
    adjust_multiply(fit, linear, out->matrix);
    adjust_multiply(out->matrix, back, out->frame);
    if (find_density(out->frame, width, height, density))
        return author_fail(run, AUTHOR_BAD_INPUT, "the placement reaches its horizon: it has no affine frame");
    double many = density[0] * density[1] / ((double)width * height);
    double fewer = many > MOST_TEXELS ? sqrt(MOST_TEXELS / many) : 1.0;
    double w = ceil(density[0] * fewer), h = ceil(density[1] * fewer);
    if (!(w < 1 << 20) || !(h < 1 << 20))
        return author_fail(run, AUTHOR_BAD_INPUT, "the picture would become %.0f x %.0f texels in an affine frame", w,
                           h);
    /* The texels of the margin widen the frame. */
    double gx = w / (w + 2 * MARGIN), gy = h / (h + 2 * MARGIN);
    const double grow[9] = {gx, 0, (1.0 - gx) / 2.0, 0, gy, (1.0 - gy) / 2.0, 0, 0, 1};
    adjust_multiply(grow, out->matrix, linear);
    for (int i = 0; i < 9; i++)
        out->matrix[i] = linear[i];
    adjust_multiply(out->matrix, back, out->frame);
    out->width = (uint32_t)w + 2 * MARGIN;
    out->height = (uint32_t)h + 2 * MARGIN;
    return AUTHOR_OK;
}
