/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of the silmap fit (author_silmap.h), in the order in which they work:
 *
 *   silmap_grid    cells, samples, sides and who is next to whom
 *   silmap_truth   which region is at a place of the original: given labels, paths, shapes, or flat art that is found
 *   silmap_fill    flat drawings: which colour is at a place
 *   silmap_draw    their picture
 *   silmap_block   what the original has in one cell
 *   silmap_area    exact area of what a cell shows wrongly, as a sum over the lines between the points
 *   silmap_points  points and sample labels that make that area small
 *   silmap_edges   for photographs, edges found in the picture: which sides they cross, and where in the cell
 *   silmap_model   the picture that the silmap shows, texel by texel, and its error
 *   silmap_colour  the samples
 *   silmap_polish  for photographs, points that the picture itself decides about
 *   silmap_fit     all together
 *   silmap_axis    before it all: where the edges along an axis lie best
 *   silmap_hint    where a drawing best lies in its texture
 */
#ifndef ZTEX_AUTHOR_SILMAP_FIT_H
#define ZTEX_AUTHOR_SILMAP_FIT_H

#include <math.h>

#include "author_silmap.h"

#define SILMAP_CHANNELS 4
#define SILMAP_POSITIONS 64 /* of a point in its cell */
#define SILMAP_CURVE 4096

/* ---- silmap_grid.c ----------------------------------------------------------------------------------------------- */

typedef struct silmap_grid {
    uint32_t w, h;   /* cells */
    uint32_t sw, sh; /* samples */
    int repeat_x, repeat_y;
    uint8_t *cells; /* w x h bytes as in the chunk */
} silmap_grid;

enum { SILMAP_W = 0, SILMAP_N = 1, SILMAP_E = 2, SILMAP_S = 3 };

author_result silmap_grid_create(author_run *run, const author_silmap_input *input, uint32_t w, uint32_t h,
                                 silmap_grid *out);
void silmap_grid_release(silmap_grid *grid);
/* The cell next to cell c (an index); SIZE_MAX: there is none. */
size_t silmap_next(const silmap_grid *grid, size_t c, int arm);
/* The sample at corner k (ZT_SILMAP_00 ...) of cell c. */
size_t silmap_corner(const silmap_grid *grid, size_t c, int k);
/* The cell of which sample s is corner k; SIZE_MAX: there is none. */
size_t silmap_cell_of(const silmap_grid *grid, size_t s, int k);
zt_silmap_cell silmap_look(const silmap_grid *grid, size_t c);
/* Bit arm of the result: that arm of cell c is cut. */
unsigned silmap_cuts(const silmap_grid *grid, size_t c);
void silmap_set_cut(silmap_grid *grid, size_t c, int arm, int cut);
/* Cells that are not cut become ZT_SILMAP_DEFAULT; returns how many are cut. */
size_t silmap_normalise(silmap_grid *grid);
/* The point in place of a missing neighbour's: the cell's own, mirrored in its north or south side (vertical) or its
 * east or west one. */
static inline unsigned silmap_mirrored(unsigned point, int vertical) {
    return point ^ (vertical ? ZT_SILMAP_Y : ZT_SILMAP_X);
}
static inline double silmap_coordinate(unsigned position) {
    return (position + 0.5) / 8;
}

/* Work on places that lie next to each other must not go on at the same time. silmap_class numbers the coordinate i of
 * n so that equal numbers are at least `apart` from each other, also around the end; below silmap_classes. */
uint32_t silmap_class(uint32_t i, uint32_t n, uint32_t apart);
#define SILMAP_CLASSES(apart) (2 * (apart)-1)

/* Those of the count given indices into a grid of width x height whose class is number `class` of
 * SILMAP_CLASSES(apart)^2. Returns how many. */
size_t silmap_select(const size_t *from, size_t count, uint32_t width, uint32_t height, uint32_t apart, uint32_t class,
                     size_t *to);

/* Like author_for, over a list of indices (NULL: 0 to count - 1). For loops that are many and short: threads meet once.
 * Visits may fail for want of memory alone. */
typedef author_result (*silmap_visit)(void *context, size_t index, unsigned worker);
author_result silmap_each(author_run *run, const char *stage, const size_t *list, size_t count, silmap_visit visit,
                          void *context);

/* ---- silmap_truth.c ---------------------------------------------------------------------------------------------- */

typedef struct silmap_region {
    float colour[SILMAP_CHANNELS]; /* mean, premultiplied linear */
    float coded[SILMAP_CHANNELS];  /* mean, as displayed */
    int flat;                      /* one colour up to the rounding of 8 bits */
    double texels;
} silmap_region;

/* Colours as displayed: the sRGB curve on colour channels, nothing on alpha and on values that are no colours. */
typedef struct silmap_curve {
    uint32_t colours; /* channels below this are colours */
    int alpha;        /* number of the alpha channel, -1: none */
    float table[SILMAP_CURVE + 2];
} silmap_curve;

void silmap_curve_set(silmap_curve *curve, uint32_t channels, int plain);

#define SILMAP_LINEAR_END 0.0031308f

/* By the square root, along which the curve is nearly straight. */
static inline float silmap_code(const silmap_curve *curve, uint32_t channel, float linear) {
    if (channel >= curve->colours)
        return linear;
    if (!(linear > SILMAP_LINEAR_END))
        return linear * 12.92f;
    if (linear > 1)
        return 1.055f * powf(linear, 1 / 2.4f) - 0.055f;
    float at = sqrtf(linear) * SILMAP_CURVE;
    int i = (int)at;
    return curve->table[i] + (curve->table[i + 1] - curve->table[i]) * (at - (float)i);
}

/* How much that changes with the value; coded is silmap_code of it. */
static inline float silmap_slope(const silmap_curve *curve, uint32_t channel, float linear, float coded) {
    if (channel >= curve->colours)
        return 1;
    return linear > SILMAP_LINEAR_END ? (coded + 0.055f) / (2.4f * linear) : 12.92f;
}

/* A texel premultiplied. */
void silmap_texel(const author_picture *picture, const silmap_curve *curve, size_t index, float out[SILMAP_CHANNELS]);

typedef struct silmap_edge { /* a segment of a path, y0 < y1 */
    double x0, y0, x1, y1;
    uint64_t mark; /* added to the label where it is crossed from left to right */
} silmap_edge;

typedef struct silmap_truth {
    const author_picture *picture;
    const silmap_curve *curve;
    uint32_t *labels; /* of each texel of the picture; NULL: paths */
    int resolve;      /* texels between two regions are mixtures of them */
    silmap_region *regions;
    uint32_t region_count;
    /* paths */
    silmap_edge *edges;
    size_t edge_count;
    size_t *row_first; /* rows + 1, into row_edges */
    uint32_t *row_edges;
    uint32_t rows;
    uint64_t *marks; /* sorted: the sum of marks of each region that has a texel; of shapes: its colour */
    uint32_t *mark_region;
    size_t mark_count;
    struct silmap_fills *fills; /* silmap_fill.h; NULL: the paths are no shapes */
} silmap_truth;

/* *found 0: the picture has no regions. */
author_result silmap_truth_create(author_run *run, const author_silmap_input *input, const silmap_curve *curve,
                                  silmap_truth *out, int *found);
void silmap_truth_release(silmap_truth *truth);
/* Regions at (x0 + i dx, y) for i below count, in coordinates of the unit square. x is increasing. */
void silmap_truth_row(const silmap_truth *truth, double y, double x0, double dx, size_t count, uint32_t *out);
/* Region of a texel, and whether it is inside of it altogether. */
uint32_t silmap_truth_texel(const silmap_truth *truth, size_t index, int *pure);
/* Whether a box lies in one region, as far as that can be seen from its texels and those around them. 0 for paths. */
int silmap_truth_plain(const silmap_truth *truth, double x0, double y0, double x1, double y1, uint32_t *region);

#define SILMAP_MIXED UINT32_C(0x80000000) /* in labels: the texel is not inside of its region altogether */

/* silmap_flat.c: regions of one colour or of slow gradients, bordered by texels that mix them. Sets truth->labels,
 * regions and resolve; *found 0 if the picture is no such drawing. */
author_result silmap_flat_find(author_run *run, silmap_truth *truth, int *found);
uint32_t silmap_flat_at(const silmap_truth *truth, double x, double y);

/* ---- silmap_block.c, silmap_area.c ------------------------------------------------------------------------------- */

#define SILMAP_LOCAL 16 /* regions of a cell that are told apart */

/* What the original has in one cell. */
typedef struct silmap_block {
    uint32_t regions[SILMAP_LOCAL];
    double shares[SILMAP_LOCAL]; /* of the cell's area */
    uint32_t count;              /* of regions, 2 or more */
    int thin;                    /* a feature is thinner than the cell */
    uint8_t middle;              /* a position on the border between regions, or the default */
    const double *table;         /* of two regions: where the second is; see silmap_table_fill */
    const uint8_t *places;       /* of more: see there */
    double memory[];
} silmap_block;

size_t silmap_table_size(uint32_t edge); /* doubles */
/* A table of a function E in a cell of edge x edge squares: for each column the pairs (E, G) at the edge + 1 borders of
 * squares, then the sums of E at the bottom over the columns. E is the integral from the top of the values that the
 * places have, G that of E. places are edge * finer in a column, column after column, and index values. In squares. */
void silmap_table_fill(const uint8_t *places, uint32_t edge, uint32_t finer, const double *values, double *table);
/* NULL: no memory. */
silmap_block *silmap_block_create(const uint32_t *regions, uint32_t count, const uint8_t *places, uint32_t edge,
                                  uint32_t finer);

typedef struct silmap_labels {
    const silmap_truth *truth;
    author_silmap_place place; /* of the original in the texture */
    silmap_grid *grid;
    uint32_t edge;         /* squares along a cell */
    uint32_t finer;        /* places along a square, of one region each */
    uint32_t *sample;      /* region of each sample */
    uint32_t *uniform;     /* region of each cell that has but one */
    silmap_block **blocks; /* NULL: uniform */
    size_t *active;        /* cells that can be wrong */
    size_t active_count;
} silmap_labels;

/* The half of a line that lies in one cell: how much worse it is there to show the region on one of its sides than that
 * on the other. */
typedef struct silmap_half {
    int used;
    double level, rise;  /* level + rise times the share of the second region */
    const double *table; /* of that share; NULL: none */
} silmap_half;

/* A line between the points of two cells, or the half of one that leads out of the texture. */
typedef struct silmap_line {
    int vertical; /* from the upper cell to the lower, and not from the left to the right */
    int used;     /* 0: the same region on both sides */
    silmap_half first, second;
} silmap_line;

double silmap_weight(const silmap_labels *labels, uint32_t shown, uint32_t wanted);
/* The line between cell c and the one at its east (vertical 0) or south (1). memory: 2 tables. first or second may be
 * SIZE_MAX. */
void silmap_line_set(const silmap_labels *labels, size_t first, size_t second, int vertical, double *memory,
                     silmap_line *out);
/* What it adds to the area for these two positions, 0 to 63. In cells. */
double silmap_line_cost(const silmap_line *line, uint32_t edge, unsigned first, unsigned second);
/* What a cell costs if all of it shows the region of its corner 11; the lines' costs are relative to that. */
double silmap_base_cost(const silmap_labels *labels, size_t c);

/* ---- silmap_points.c --------------------------------------------------------------------------------------------- */

/* place: where the original's unit square lies in that of the texture. hasty: not as finely as could be. */
author_result silmap_labels_create(author_run *run, const silmap_truth *truth, const author_silmap_place *place,
                                   int hasty, silmap_grid *grid, silmap_labels *out);
void silmap_labels_release(silmap_labels *labels);
/* Points and sample labels; then the cuts. hasty: one round of them. */
author_result silmap_points_fit(author_run *run, silmap_labels *labels, int hasty);
/* silmap_chain.c: all points of a chain of cells at once; only of chains in which something has moved: moved of a cell
 * is at least since. */
author_result silmap_chains_fit(author_run *run, silmap_labels *labels, const uint32_t *moved, uint32_t since);
/* Share of the area that shows another region, at places that the fit has not seen; weighted: times how far their
 * colours are apart. And the defects of the cells, unless NULL. */
author_result silmap_labels_judge(author_run *run, const silmap_labels *labels, zt_silmap_filter filter, int weighted,
                                  double *disagreement, uint8_t *defects);

/* ---- silmap_edges.c ---------------------------------------------------------------------------------------------- */

/* Sets cuts and points from edges in the picture (unless paths_only) and from paths. */
author_result silmap_edges_find(author_run *run, const author_silmap_input *input, const author_silmap_options *options,
                                const silmap_curve *curve, silmap_grid *grid);

/* ---- silmap_model.c ---------------------------------------------------------------------------------------------- */

typedef struct silmap_model {
    const author_picture *picture;
    const silmap_curve *curve;
    const silmap_grid *grid;
    zt_silmap_filter filter;
    float *samples;                                    /* premultiplied linear, channels of the picture */
    float low[SILMAP_CHANNELS], high[SILMAP_CHANNELS]; /* the picture's range, which samples keep to */
    /* What the silmap is compared with: the picture as displayed, averaged down while a cell has more than some texels;
     * NULL: the picture itself */
    const float *target;
    uint32_t width, height; /* of the target, or of the picture */
} silmap_model;

/* A target for a grid; *out NULL if the picture has few texels for each cell already. free() it. */
author_result silmap_target_create(author_run *run, const author_picture *picture, const silmap_curve *curve,
                                   const silmap_grid *grid, float **out, uint32_t *width, uint32_t *height);
/* The range of the picture's premultiplied values. */
void silmap_range(const author_picture *picture, const silmap_curve *curve, float low[SILMAP_CHANNELS],
                  float high[SILMAP_CHANNELS]);
/* The same model, compared with the picture itself. */
silmap_model silmap_full(const silmap_model *model);
/* A texel of the target as displayed. */
void silmap_wanted(const silmap_model *model, size_t index, float out[SILMAP_CHANNELS]);

/* Where a texel is looked at: crossed x crossed places where a line passes through it, plain x plain elsewhere. */
typedef struct silmap_pattern {
    int crossed, plain;
} silmap_pattern;

/* The sum of squared errors, as displayed, over the texels of each cell. */
author_result silmap_errors(author_run *run, const silmap_model *model, silmap_pattern pattern, double *errors);
double silmap_sum(const double *errors, size_t count);
double silmap_psnr(const author_picture *picture, double sum);
/* Texels of a cell: those with their centre in it. */
typedef struct silmap_span {
    uint32_t x0, x1, y0, y1;
} silmap_span;
silmap_span silmap_texels(const silmap_model *model, size_t c);
/* A cell prepared for its texels. */
typedef struct silmap_view {
    const silmap_model *model;
    zt_silmap_shape shape;
    silmap_span span;
    double left, top, sx,
        sy; /* texel (x, y) has its corner at (x sx - left, y sy - top) of the cell, and the extent (sx, sy) */
    const float *corners[4]; /* samples */
} silmap_view;
silmap_view silmap_view_of(const silmap_model *model, size_t c);
/* The parts of a texel: returns how many, and for each the weights of the corners of the cell. */
#define SILMAP_PARTS 25
typedef struct silmap_parts {
    int count;
    double weights[SILMAP_PARTS][4];
    unsigned limited[SILMAP_PARTS]; /* what zt_silmap_shape_weights returned */
} silmap_parts;
void silmap_split(const silmap_view *view, uint32_t x, uint32_t y, silmap_pattern pattern, silmap_parts *out);
/* Value of one part, between the limits that its filter has. */
float silmap_limited(const silmap_parts *parts, int part, const float *const corners[4], uint32_t channel, float value);
static inline float silmap_value(const silmap_parts *parts, int part, const float *const corners[4], uint32_t channel) {
    const double *w = parts->weights[part];
    float sum = (float)w[0] * corners[0][channel] + (float)w[1] * corners[1][channel] +
                (float)w[2] * corners[2][channel] + (float)w[3] * corners[3][channel];
    return parts->limited[part] ? silmap_limited(parts, part, corners, channel, sum) : sum;
}

/* The squared error of a texel's channel; shown: the sum over its parts, as displayed. */
static inline double silmap_squared(float shown, int parts, float wanted) {
    double d = (double)(shown / (float)parts - wanted);
    return d * d;
}
double silmap_cell_error(const silmap_view *view, silmap_pattern pattern);

/* ---- silmap_polish.c --------------------------------------------------------------------------------------------- */

/* Moves points of cut cells where that lowers the error of the picture. */
author_result silmap_points_polish(author_run *run, const silmap_model *model, silmap_grid *grid, int sweeps);

/* ---- silmap_colour.c --------------------------------------------------------------------------------------------- */

/* Means over the deformed cells; labels may be NULL. */
author_result silmap_colour_means(author_run *run, const silmap_model *model, const silmap_labels *labels);
/* Least squares under the filter; fixed (one for each sample) may be NULL. errors: of each cell, before and after. Kept
 * only if it lowers them. */
author_result silmap_colour_solve(author_run *run, silmap_model *model, const uint8_t *fixed, int rounds,
                                  double *errors);
/* Mixtures of flat regions in few levels, for they cost more bytes than they are worth: samples that are not fixed. */
void silmap_colour_round(const silmap_model *model, const silmap_labels *labels, const uint8_t *fixed);

/* ---- silmap_axis.c ----------------------------------------------------------------------------------------------- */

#define SILMAP_REACH 0.5 /* cells that a side of a drawing may go out for hinting */
#define SILMAP_SPOTS 6

typedef struct silmap_spot {
    double out[2]; /* cells that the first side and the last go out */
    double cost;   /* of the edges along the axis */
} silmap_spot;

/* Where edges along an axis (0: those whose x is one) lie well; *before: what they cost where they are. All of these
 * are some way apart. */
author_result silmap_axis_spots(author_run *run, const author_picture *picture, const silmap_curve *curve,
                                uint32_t cells, int axis, double *before, silmap_spot out[SILMAP_SPOTS]);

#endif
