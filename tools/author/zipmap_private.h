/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the registration share. */
#ifndef ZTEX_ZIPMAP_PRIVATE_H
#define ZTEX_ZIPMAP_PRIVATE_H

#include <stdbool.h>

#include "author_zipmap.h"

/* ---- homographies (zipmap_plane.c): 3 x 3 by rows ---------------------------------------------------------- */

typedef struct plane {
    double m[9];
} plane;

plane plane_identity(void);
plane plane_scale(double x, double y);
plane plane_multiply(const plane *a, const plane *b); /* a after b */
bool plane_inverse(const plane *a, plane *out);       /* false: singular or not finite */
/* Scaled so that w is 1 where the result is (1/2, 1/2); no negative zeros. False: no such place. */
bool plane_normalise(plane *a);
/* False where w is not positive. */
bool plane_apply(const plane *a, double x, double y, double *u, double *v);
/* Square root of the determinant of the derivative at (x, y); 0 where w or the determinant is not positive. */
double plane_magnification(const plane *a, double x, double y);
/* Whether coarse coordinates to fine ones can be a photograph of a plane: all corners in front, no mirror, and no
 * corner magnified very differently from another. size: width and height of both pictures. */
bool plane_plausible(const plane *a, const uint32_t coarse[2], const uint32_t fine[2]);
/* The pixels of fine on a length of one pixel of coarse, at the centre of fine. */
double plane_ratio(const plane *a, const uint32_t coarse[2], const uint32_t fine[2]);
/* Share of the fine picture's area inside the coarse one. */
double plane_contained(const plane *a);
/* Solves the symmetric positive definite n x n system in place (x: right side, then solution); a is destroyed. */
bool plane_solve(double *a, double *x, size_t n);

/* ---- brightness (zipmap_luma.c) ---------------------------------------------------------------------------- */

enum { LUMA_LEVELS = 12 };

/* Square roots of linear light: noise is about as strong in the dark as in the light, and exposure is still a
 * factor. */
typedef struct luma_level {
    uint32_t width, height;
    float *texels;
} luma_level;

/* A pyramid of the three channels, packed; level 0 is the finest. */
typedef struct luma {
    struct {
        uint32_t width, height;
        uint32_t *texels;
    } level[LUMA_LEVELS];
    uint32_t count;
} luma;

author_result luma_level_create(author_run *run, uint32_t width, uint32_t height, luma_level *out); /* zeroed */
author_result luma_create(author_run *run, const author_picture *picture, luma *out);
void luma_release(luma *pyramid);
/* Brightness is the root of the weighted sum of red, green and blue light. */
extern const float LUMA_GREY[3];
/* The box (left, top, right, bottom in texels) of a level. clipped: what a clipped channel counts, which may be NaN. */
author_result luma_crop(author_run *run, const luma *pyramid, const float weights[3], float clipped, uint32_t level,
                        const uint32_t box[4], luma_level *out);
/* All of the picture at another, not larger size: area averages of light. */
author_result luma_shrink(author_run *run, const luma *pyramid, const float weights[3], float clipped, uint32_t width,
                          uint32_t height, luma_level *out);
/* What each texel differs from the mean of its surroundings by, about 2 reach texels far. Only those that are inside
 * count; 0 outside. out has the size of level. */
author_result luma_detail(author_run *run, const luma_level *level, const uint8_t *inside, uint32_t reach,
                          luma_level *out);
/* Light averaged with that of the neighbours, by 1 2 1 across and down, `passes` times. */
void luma_soften(luma_level *level, unsigned passes);
/* Cubic (Catmull and Rom) at (x, y), texel centres at halves; the edge goes on outside. */
float luma_sample(const luma_level *level, double x, double y);
author_result luma_bytes(author_run *run, const luma_level *level, uint8_t **out);

/* ---- two pictures at one resolution (zipmap_view.c) --------------------------------------------------------- */

typedef struct view {
    luma_level coarse; /* the part of a level that fine covers */
    luma_level fine;   /* all of it, low-passed; texels are NULL where the matrix puts it outside */
    uint32_t box[4];   /* the part: left, top, right, bottom in texels of the level */
    uint32_t size[2];  /* width and height of the whole level */
} view;

/* left, top, right, bottom of what fine covers of coarse, in coarse's coordinates. False: nothing. */
bool view_footprint(const plane *matrix, double box[4]);
/* The finest level on which the box has at most `texels` texels. */
uint32_t view_level(const luma *light, const double box[4], size_t texels);
author_result view_open(author_run *run, const luma *coarse, const luma *fine, const float weights[2][3], float clipped,
                        uint32_t level, const plane *matrix, view *out);
/* The fine picture averaged over a texel of the coarse part. False where a part of it is outside or clipped. */
bool view_average(const view *v, const plane *matrix, size_t x, size_t y, float *out);
/* Weights of the coarse and the fine picture's channels that make equal colours equal when the white balance
 * differs. */
author_result view_balance(author_run *run, const luma *coarse, const luma *fine, const plane *matrix,
                           float weights[2][3]);
void view_release(view *v);

/* ---- steps of a refinement (zipmap_motion.c) ---------------------------------------------------------------- */

enum { MOTION = 8, MOST_UNKNOWNS = 38, RESIDUAL_BINS = 2048 };

/* How often residuals are how large. */
typedef struct residuals {
    uint32_t bins[RESIDUAL_BINS];
    size_t count;
} residuals;

void residuals_add(residuals *all, double value);
/* Standard deviation, from the median, which a third of wrong residuals does not move far. */
double residuals_deviation(const residuals *all);

/* How brightness at a place of the footprint's box (-1 to 1) changes with the motion; gradient: of the warped picture,
 * a texel. */
void motion_row(const view *v, const double place[2], const double gradient[2], double row[MOTION]);
/* The motion, then the matrix. */
void motion_apply(const view *v, const double d[MOTION], plane *matrix);
/* How far a corner moves at most, in texels of the coarse picture. */
double motion_travel(const view *v, const double d[MOTION]);
/* Expected error of the footprint's corners, in texels of the coarse picture, where residuals have a deviation of 1.
 * normal: lower triangle of the normal equations, the motion first. */
double motion_spread(const view *v, const double *normal, size_t unknowns);

/* ---- one pair (zipmap_pair.c, zipmap_refine.c, zipmap_polish.c, zipmap_unique.c) ---------------------------- */

typedef struct photo {
    uint32_t pixels[2]; /* width and height of the photograph; level 0 of light may be smaller */
    luma light;
    author_features *features;
    uint32_t feature_size[2]; /* of the picture that they were found in */
    size_t feature_count;
} photo;

/* A pair under test: coarse coordinates to fine coordinates, both in [0, 1] x [0, 1]. */
typedef struct edge {
    uint32_t coarse, fine;
    author_reason reason; /* AUTHOR_REASON_NONE: holds */
    bool compared;        /* place and correlation come from the pictures themselves */
    uint32_t matches, inliers;
    plane matrix;
    double ratio, contained;
    double correlation, local_correlation, residual, distortion;
    double spread; /* expected error of a corner, in pixels of fine */
} edge;

/* Where a pair may lie: those that hold first, and of these that with the most inliers. At least one. */
enum { PAIR_PLACES = 3 };
typedef struct pair_places {
    edge edges[PAIR_PLACES];
    size_t count;
} pair_places;

/* Features, and the homographies that many of them follow. Which of the two is the finer one is found, too. */
author_result pair_match(author_run *run, const author_vision *vision, const photo *photos, const edge *e,
                         pair_places *out);
/* Matches again, both pictures at the coarse one's resolution, each feature near where the matrix puts it. */
author_result pair_match_again(author_run *run, const author_vision *vision, const photo *photos, edge *e);

typedef struct refine_result {
    bool converged;
    plane matrix;
    double correlation, residual, distortion, spread;
    double local_correlation; /* of detail: about the means of blocks */
    double error;             /* standard deviation of the difference of brightness */
} refine_result;

/* Moves the matrix until brightness agrees best. texels: of the coarse picture that are compared, at most. */
author_result refine_plane(author_run *run, const photo *coarse, const photo *fine, const plane *start, size_t texels,
                           refine_result *out);
author_result pair_refine(author_run *run, const photo *photos, const author_register_options *options, size_t texels,
                          edge *e);
/* Solves for place and light together, from a place that is nearly right; without a result the edge stays as it is. */
author_result pair_polish(author_run *run, const photo *photos, size_t texels, edge *e);
/* Whether fine would fit as well elsewhere in coarse. */
author_result pair_unique(author_run *run, const photo *photos, edge *e);

/* ---- all pairs (zipmap_graph.c) ---------------------------------------------------------------------------- */

typedef struct edge_list {
    edge *edges;
    size_t count, room;
} edge_list;

/* Room for one more edge; NULL without memory. */
edge *edge_append(author_run *run, edge_list *list);

/* Pairs that may hold, by coarse, then fine (which of the two is which is not known yet): for each picture the `wanted`
 * best candidates. memory: bytes that it may take, about (zipmap_select.c). */
author_result select_pairs(author_run *run, const author_vision *vision, const photo *photos, size_t count,
                           uint32_t wanted, uint64_t memory, edge_list *out);

/* Edges that follow from others by way of third pictures and would give a picture a finer parent; not tested yet. */
author_result graph_propose(author_run *run, const photo *photos, size_t count, const edge_list *list,
                            const author_register_options *options, edge_list *out);
/* Parents, groups, order and reasons out of the edges. Fills all of out but the matrices and measures of placings. */
author_result graph_choose(author_run *run, const author_photos *named, const photo *photos, const edge_list *list,
                           const author_register_options *options, author_registration *out);

#endif
