/* SPDX-License-Identifier: Apache-2.0 */
/* Random places of elements. */
#ifndef ZTEX_UMBRELLA_SCATTER_H
#define ZTEX_UMBRELLA_SCATTER_H

#include "umbrella_private.h"

/* Where they may lie, in cells. */
typedef struct umb_field {
    double x, y, width, height;
    int repeat_x, repeat_y;
} umb_field;

/* Count points, none closer to another than can be at that number: darts, with a distance that shrinks where none finds
 * room. */
author_result umb_scatter_discs(author_run *run, const umb_field *field, size_t count, author_random *random,
                                author_xy *points);
/* columns x rows points. jitter is 0 to 1 of a step; row_shift moves every second row by steps. */
void umb_scatter_lattice(const umb_field *field, uint32_t columns, uint32_t rows, double jitter, double row_shift,
                         author_random *random, author_xy *points);

#endif
