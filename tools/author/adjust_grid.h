/* SPDX-License-Identifier: Apache-2.0 */
/* Patch and ground side by side, at the resolution of the ground. */
#ifndef ZTEX_ADJUST_GRID_H
#define ZTEX_ADJUST_GRID_H

#include "adjust.h"

#define ADJUST_MOST_CELLS 1024 /* a side: light changes slowly, and finer cells would follow errors of registration */

typedef struct author_planes {
    float *planes[3];
} author_planes;

/* Cells that divide the patch evenly, at least 3 x 3. */
typedef struct author_grid {
    uint32_t width, height, channels; /* colours: 1 or 3 */
    float *patch[3], *ground[3];      /* means of the cells, low-passed */
    float *change[3];                 /* of the ground from a cell to the next, the most of it around */
    float *clipped[3], *cut[3];       /* shares of patch and ground that are clipped, low-passed; 0 where not bounded */
    int bounded;                      /* the patch's values end at 1 */
    uint8_t *valid;                   /* 1: both are known */
    double covered;                   /* share of the cells that are valid */
} author_grid;

/* How far a value in linear light is one that a camera cut off: 0 to 1. */
static inline float adjust_clipping(float value) {
    return value < 0.92f ? 0.0f : value > 0.98f ? 1.0f : (value - 0.92f) / 0.06f;
}

author_result adjust_grid_create(author_run *run, const author_picture *patch, const author_ground *grounds,
                                 size_t count, author_grid *out);
void adjust_grid_release(author_grid *grid);

/* Zeroed planes of the size of the grid, one for each channel. */
author_result adjust_planes_create(author_run *run, const author_grid *grid, author_planes *out);
void adjust_planes_release(author_planes *planes);

#endif
