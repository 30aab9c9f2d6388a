/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of ./dev bench silmap that must be quick; bench_silmap.py has the question, the inputs and the tables.
 *
 *   silmap_shape    outlines: which side a place is on, and the picture of them
 *   silmap_sdf      the distance field of an outline
 *   silmap_msdf     its distance field of three channels
 *   silmap_truth    what every place of an input looks like: outline, drawing or photograph
 *   silmap_method   the contestants, each as a .ztex file that is looked up through libzt
 *   silmap_score    how far a picture is from the truth
 *   silmap_main     one input at one size, as JSON
 *
 * The unit square has its origin at the top left. Colours are linear light.
 */
#ifndef SILMAP_BENCH_H
#define SILMAP_BENCH_H

#include <stddef.h>
#include <stdint.h>
#include <author_silmap.h>
#include <zt/zt.h>

void *bench_alloc(size_t count, size_t size); /* zeroed; ends the program when there is no memory */
void bench_fail(const char *what, const char *why);

/* ---- silmap_shape.c ------------------------------------------------------------------------------------- */

/* A straight piece of an outline. The inside is on its left as seen when y points up, that is where cross(direction,
 * place - start) < 0. */
typedef struct piece {
    double x0, y0, x1, y1;
    uint32_t contour;
    int corner; /* the outline has a corner at (x0, y0) */
} piece;

typedef struct shape {
    piece *pieces; /* contour after contour */
    size_t count;
    uint32_t contour_count;
    int even_odd;
} shape;

/* Text: "nonzero" or "evenodd", then lines M x y, L x y, Q and C with their control points, Z. */
shape shape_load(const char *path);
void shape_release(shape *s);
/* Whether the places (x0 + i dx, y), i below count, are inside. */
void shape_row(const shape *s, double y, double x0, double dx, size_t count, uint8_t *inside);
int shape_inside(const shape *s, double x, double y);

/* pixels x pixels of a square part of the unit square. */
typedef struct window {
    double x, y, size;
    size_t pixels;
} window;

void shape_coverage(const shape *s, const window *w, float *out);

/* ---- silmap_sdf.c, silmap_msdf.c ------------------------------------------------------------------------ */

#define SDF_RANGE 4.0  /* texels to each side */
#define MSDF_RANGE 2.0 /* texels to each side: 4 texels in all, as usual */

/* grid x grid texels, one channel; 128 is the outline, more is inside. */
void sdf_make(const shape *s, size_t grid, uint8_t *out);
/* Three channels. */
void msdf_make(const shape *s, size_t grid, uint8_t *out);
/* Calls near(context, piece, texel, x, y) for each piece and each texel whose centre (x, y) is at most reach away. */
typedef void (*shape_near)(void *context, size_t piece, size_t texel, double x, double y);
void shape_visit(const shape *s, size_t grid, double reach, shape_near near, void *context);
uint8_t sdf_code(double distance, double range);

/* ---- silmap_truth.c ------------------------------------------------------------------------------------- */

typedef enum truth_kind { TRUTH_OUTLINE, TRUTH_DRAWING, TRUTH_PHOTO } truth_kind;

typedef struct truth {
    truth_kind kind;
    uint32_t channels;
    shape outline;
    void *drawing;             /* RsvgHandle */
    double crop[4];            /* of the drawing's page: left, top, width, height as shares */
    author_picture photograph; /* at full resolution */
} truth;

/* The crop: left, top and width of a square, as shares of the page of a drawing. */
truth truth_load(const char *kind, const char *path, const double crop[3]);
void truth_release(truth *t);
/* Largest pixels of a window of that size that the input has. */
size_t truth_limit(const truth *t, double size);
/* Linear light, channels interleaved. */
void truth_render(const truth *t, const window *w, float *out);
/* Puts the outline or drawing there in the unit square; it is enlarged, so nothing comes in from outside. */
void truth_place(truth *t, const author_silmap_place *place);
/* What the fit gets; its texels are not those that are judged. */
author_picture truth_picture(const truth *t, uint32_t cells);

/* ---- silmap_method.c ------------------------------------------------------------------------------------ */

typedef enum method_kind {
    METHOD_BILINEAR,
    METHOD_SDF,
    METHOD_MSDF,
    METHOD_SILMAP,
    METHOD_UNCUT,
    METHOD_KINDS
} method_kind;

typedef struct method {
    method_kind kind;
    uint32_t grid, channels; /* channels: of its lookups */
    uint8_t *bytes;
    size_t file_size;
    size_t memory;     /* texels and cells, one level */
    size_t cells_size; /* of chunk SLMP in the file */
    zt_file *file;
    zt_sampler *sampler;
    double seconds; /* of lookups */
    double lookups;
} method;

extern const char *const method_names[METHOD_KINDS];
/* METHOD_SILMAP and METHOD_UNCUT (a silmap's samples without cuts, the best ones) want the fitted silmap. */
method method_make(method_kind kind, const truth *t, uint32_t grid, int effort, const author_silmap_result *silmap);
void method_release(method *m);
void method_render(method *m, const window *w, float *out);
/* Which side of the outline the method shows at the places of a row. */
void method_row(method *m, double y, double x0, double dx, size_t count, uint8_t *inside);

/* ---- silmap_score.c ------------------------------------------------------------------------------------- */

typedef struct score {
    double squares, values; /* of errors as displayed */
    double ssim, windows;
} score;

/* Both linear; what is compared is sRGB-coded. */
void score_add(score *s, const float *shown, const float *wanted, const window *w, uint32_t channels);
double score_psnr(const score *s);
double score_ssim(const score *s);

#endif
