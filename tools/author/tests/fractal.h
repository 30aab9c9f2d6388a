/* SPDX-License-Identifier: Apache-2.0 */
/* A world with detail on every scale, and photographs of it from known places: the ground truth of registration. */
#ifndef ZTEX_FRACTAL_H
#define ZTEX_FRACTAL_H

#include "zipmap_private.h"

/* A photograph: its coordinates in [0, 1] x [0, 1] to those of the world; pixels; exposure, darkening of the corners,
 * noise. */
typedef struct fractal_view {
    plane to_world;
    uint32_t width, height;
    double exposure, vignetting, noise;
    uint64_t world; /* which one */
} fractal_view;

/* The view whose centre looks at (x, y), `across` of the world wide, turned, with a slant of the plane. */
fractal_view fractal_look(uint32_t width, uint32_t height, double x, double y, double across, double degrees,
                          double slant);
author_result fractal_photograph(author_run *run, const fractal_view *shot, author_picture *out);
/* Coordinates of one view to those of the other. */
plane fractal_between(const fractal_view *from, const fractal_view *to);
/* The largest error of a corner of fine, in its pixels. */
double fractal_error(const plane *matrix, const fractal_view *coarse, const fractal_view *fine);

#endif
