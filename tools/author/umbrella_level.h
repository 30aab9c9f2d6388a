/* SPDX-License-Identifier: Apache-2.0 */
/* Between the files that make coarser levels. Lengths are in cells of the level that is made. */
#ifndef ZTEX_UMBRELLA_LEVEL_H
#define ZTEX_UMBRELLA_LEVEL_H

#include "umbrella_private.h"

#define UMB_PIXELS 8  /* along a cell, where a level alone is looked up */
#define UMB_PHASES 16 /* texels of phases along a cell */

/* What is merged: umbrellas of the level before, the lowest first. */
typedef struct umb_sources {
    size_t count;
    author_xy *centres;
    uint32_t *first;   /* count + 1, in points */
    author_xy *points; /* less their centres */
} umb_sources;
void umb_sources_release(umb_sources *sources);

typedef struct umb_grid {
    uint32_t width, height;
    int repeat[2];
} umb_grid;

/* What is seen of each source, as places of samples, and the ground between them where it is wanted. */
typedef struct umb_regions {
    size_t count;
    double *depths;       /* the number of the source; -1 for the ground */
    author_xy *homes;     /* the mean of what is seen, within the grid */
    double (*colours)[3]; /* and its colour, sRGB-coded */
    size_t *first;        /* count + 1, in samples */
    author_xy *samples;   /* less their homes */
} umb_regions;
author_result umb_find_regions(author_run *run, const umb_sources *sources, const umb_grid *grid, int with_ground,
                               const author_picture *truth, umb_regions *out);
void umb_regions_release(umb_regions *regions);

typedef enum umb_style {
    UMB_FAIR = 0, /* star-shaped, of the same area in each direction */
    UMB_WRAP = 1, /* star-shaped, with all in it */
    UMB_HULL = 2, /* convex */
    UMB_AREA = 3  /* of the same area in each direction, gaps not counted: where the ground is seen */
} umb_style;

/* A level that may become one of the file. */
typedef struct umb_candidate {
    zt_umbrella_level level;
    uint32_t vertex_count, colour_count, longest;
    zt_umbrella *umbrellas;
    zt_umbrella_offset *vertices;
    zt_umbrella_colour *colours;
    uint32_t *starts, *entries;
    author_phase_errors errors;
} umb_candidate;
void umb_candidate_release(umb_candidate *candidate);
/* The candidate as the one level of a texture. */
zt_umbrella_info umb_candidate_view(const umb_candidate *candidate);

/* Regions into at most counts[cell] umbrellas for each cell: k-means on their homes. */
typedef struct umb_shaping {
    const umb_regions *regions;
    const umb_grid *grid;
    const uint32_t *counts;
    umb_style style;
    uint32_t most_vertices, bits;
    uint64_t seed, stream;
} umb_shaping;
author_result umb_shape_level(author_run *run, const umb_shaping *how, umb_candidate *out);

/* Not merged but new: columns x rows rectangles in each cell, which meet; so each list has (columns + 2) x (rows +
 * 2). */
author_result umb_tile_level(author_run *run, const umb_grid *grid, uint32_t columns, uint32_t rows,
                             uint32_t most_vertices, uint32_t bits, umb_candidate *out);

/* The colours by least squares, in steps of the file, and how good they are. truth and background: at all phases;
 * pixel: what one counts for in a lookup, in cells, which is less where a side has not been halved exactly. */
author_result umb_fit_level(author_run *run, umb_candidate *candidate, zt_umbrella_colour_mode mode, author_xy pixel,
                            const author_picture *truth, const author_picture *background);

#endif
