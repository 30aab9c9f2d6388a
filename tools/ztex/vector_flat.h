/* SPDX-License-Identifier: Apache-2.0 */
/* Between the files that take paths out of drawings: what cairo's SVG writer has written (vector_svg.c), and strokes
 * (vector_stroke.c). */
#ifndef ZTEX_VECTOR_FLAT_H
#define ZTEX_VECTOR_FLAT_H

#include "vector_module.h"

typedef enum vector_join { VECTOR_JOIN_MITER, VECTOR_JOIN_ROUND, VECTOR_JOIN_BEVEL } vector_join;
typedef enum vector_cap { VECTOR_CAP_BUTT, VECTOR_CAP_ROUND, VECTOR_CAP_SQUARE } vector_cap;

#define VECTOR_DASHES 64

typedef struct vector_stroke {
    double width, miter_limit; /* width above 0 */
    vector_join join;
    vector_cap cap;
    double dashes[VECTOR_DASHES]; /* if there are any, their sum is above 0 */
    size_t dash_count;
    double dash_offset;
} vector_stroke;

/* The outline of all lines, in the coordinates before out's matrix, to be filled where it winds at all. lines: with
 * bends, and no matrix. */
void vector_stroke_outline(const vector_stroke *style, const vector_pen *lines, vector_pen *out);

/* Every path that is drawn. unit: of the writer's units in those of the pen. 0, or -1: it is not what the writer
 * writes. */
int vector_svg_paths(const char *text, const double unit[2], vector_pen *pen);
/* The same as shapes, strokes as outlines. 0, VECTOR_NOT_FLAT with the reason in error, or -1 with what went wrong. */
int vector_svg_shapes(const char *text, const double unit[2], double tolerance, vector_shapes *out, char *error);

#endif
