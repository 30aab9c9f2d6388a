/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a picture whose place in its parent is known to a patch that lies in it without a seam: colours, mask,
 * placement, and what may be left out beneath it (Eisemann and Magnor, section 4).
 *
 * Matrices are row-major 3 x 3, homogeneous, and map the coordinates of one picture, [0, 1] x [0, 1] from edge to edge,
 * to those of another. Pictures are in linear light.
 */
#ifndef ZTEX_AUTHOR_ADJUST_H
#define ZTEX_AUTHOR_ADJUST_H

#include "author.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- resampling ------------------------------------------------------------------------------------------ */

/* What `from` looks like in the frame of a picture of width x height that `matrix` maps it to: cubic (Catmull-Rom)
 * where it is enlarged, averaged over the texel where it is reduced; beyond its edges its edge texels go on. inside
 * (width x height, or NULL) says of each texel whether its centre lies in `from`. Errors: AUTHOR_BAD_INPUT (the matrix
 * has no inverse), AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_warp(author_run *run, const author_picture *from, const double matrix[9], uint32_t width,
                          uint32_t height, author_picture *out, uint8_t *inside);

/* ---- colours ----------------------------------------------------------------------------------------------- */

/* A picture beneath the patch, and the matrix from its coordinates to the patch's. Channels as the patch's; alpha is
 * not looked at. */
typedef struct author_ground {
    const author_picture *picture;
    double matrix[9];
} author_ground;

typedef enum author_colour {
    AUTHOR_COLOUR_GAIN = 1,   /* one gain and one offset a channel */
    AUTHOR_COLOUR_POISSON = 2 /* a smooth gain, then the Poisson equation for what is left */
} author_colour;

/* Steps are of sRGB-coded values, 1 being full range, between the patch and what is beneath it, both low-passed to the
 * resolution of what is beneath: along the edge of the patch, and the difference of the means over the patch. */
typedef struct author_seam {
    double median, worst, mean;
} author_seam;

typedef struct author_adjustment {
    double covered;            /* share of the patch beneath which there is something; 0: nothing was changed */
    double gain[3], offset[3]; /* of each channel; the gain at the centre of the patch */
    author_seam before, after;
} author_adjustment;

/* Gives `patch` the colours of what lies beneath: the first of `grounds` that holds a point says what is there. Where
 * none does, as where a patch hangs over the edge of everything, the correction goes on from the nearest places of the
 * edge that are known. A fourth (second) channel, alpha, stays, and says how much a texel counts. adjustment may be
 * NULL. Errors: AUTHOR_BAD_INPUT (channels differ, a matrix without an inverse), AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_adjust_colour(author_run *run, author_picture *patch, const author_ground *grounds, size_t count,
                                   author_colour colour, author_adjustment *adjustment);

/* Fills each plane of width x height with the harmonic function that has its border: the discrete Laplace equation,
 * solved by multigrid to 1e-5 of the border's range. Errors: AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_harmonic(author_run *run, float *const *planes, size_t count, uint32_t width, uint32_t height);

/* ---- the mask ------------------------------------------------------------------------------------------------ */

typedef struct author_mask_options {
    double tau;    /* path cost, in full ranges of a channel, from which on the patch is opaque; 0: 0.05 to 0.5 by the
                      picture */
    uint32_t ramp; /* texels over which coverage rises from the edge at least; 0: 1 */
} author_mask_options;

#define AUTHOR_TAU_MOST 4.0

/* The gradient density mask: how much the picture changes on the way from its edge to a texel, over the path on which
 * it changes least, divided by tau (equations 2 and 3). Exactly 0 on the border, at most 1. One channel. tau: the one
 * that was used; may be NULL. Errors: AUTHOR_BAD_INPUT (tau above AUTHOR_TAU_MOST or negative, 2^32 texels),
 * AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_gradient_mask(author_run *run, const author_picture *picture, const author_mask_options *options,
                                   author_picture *mask, double *tau);

/* 0 on the border, 1 from `ramp` texels on inwards. A ramp longer than half the picture ends in its middle. */
float author_ramp(uint32_t width, uint32_t height, uint32_t ramp, uint32_t x, uint32_t y);

/* ---- affine placement ---------------------------------------------------------------------------------------- */

typedef struct author_baking {
    uint32_t width, height; /* of the baked picture */
    double matrix[9];       /* affine: the parent's coordinates to those of the baked picture */
    double frame[9];        /* the coordinates of the picture to those of the baked one */
} author_baking;

/* The parallelogram, turned and sheared as the picture's centre is, that surrounds a picture of width x height placed
 * by `matrix` (the parent's coordinates to its own); large enough that no detail is lost where the picture is densest,
 * up to four times its texels. Errors: AUTHOR_BAD_INPUT (no inverse; the picture reaches the horizon). */
author_result author_bake(author_run *run, const double matrix[9], uint32_t width, uint32_t height, author_baking *out);

/* ---- what is hidden ------------------------------------------------------------------------------------------ */

/* How deep each texel of a picture lies beneath opaque patches: texels to the nearest one that shows. */
typedef struct author_depth {
    uint32_t width, height;
    uint32_t *texels;
} author_depth;

author_result author_depth_create(author_run *run, uint32_t width, uint32_t height, author_depth *out);
void author_depth_release(author_depth *depth);
/* One more patch: its coverage (one channel, as stored) and the matrix from the picture's coordinates to its own.
 * Errors: AUTHOR_BAD_INPUT (no inverse), AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_depth_cover(author_run *run, author_depth *depth, const author_picture *coverage,
                                 const double matrix[9]);
/* Takes out of the picture the detail that no level shows: the deeper, the coarser what stays. At AUTHOR_PRUNE_MARGIN x
 * 2^j texels detail finer than 2^(j+1) texels may go, because where level j of the picture is looked up, the patch
 * above still covers to within that distance of its edge (docs/design.md has the account). Alpha stays. Errors:
 * AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_prune(author_run *run, author_picture *picture, const author_depth *depth);
#define AUTHOR_PRUNE_MARGIN 24

#ifdef __cplusplus
}
#endif

#endif
