/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A level of rectangles. Where elements are as small as pixels there is nothing left of their shapes, and rectangles
 * are what needs the fewest entries in the lists for the most colours: with 2 x 2 in a cell and 12 vertices each, 52
 * colours for 64 pixels.
 */
#include <stdlib.h>

#include "umbrella_level.h"

#define GROWN 0.015625 /* cells: between neighbours there shall be no gap */

/* Evenly along the sides, the corners among them; clockwise from the upper left one. */
static uint32_t rectangle(author_xy half, uint32_t most_vertices, double scale, zt_umbrella_offset *out) {
    uint32_t steps = most_vertices / 4, count = 0;
    for (uint32_t i = 0; i < 4 * steps; i++) {
        double along = 2.0 * (i % steps) / steps - 1;
        uint32_t side = i / steps;
        double x = side == 0 ? along : side == 1 ? 1 : side == 2 ? -along : -1;
        double y = side == 0 ? -1 : side == 1 ? along : side == 2 ? 1 : -along;
        out[count++] = (zt_umbrella_offset){(int32_t)umb_round(x * half.x * scale),
                                            (int32_t)umb_round(y * half.y * scale)};
    }
    return count;
}

author_result umb_tile_level(author_run *run, const umb_grid *grid, uint32_t columns, uint32_t rows,
                             uint32_t most_vertices, uint32_t bits, umb_candidate *out) {
    uint32_t wide = grid->width * columns, count = wide * grid->height * rows, vertices = most_vertices / 4 * 4;
    author_xy half = {0.5 / columns + GROWN, 0.5 / rows + GROWN};
    *out = (umb_candidate){.level = {.width = grid->width, .height = grid->height, .bits = bits}};
    out->umbrellas = author_alloc(run, count, sizeof *out->umbrellas);
    out->vertices = author_alloc(run, (size_t)count * vertices, sizeof *out->vertices);
    if (!out->umbrellas || !out->vertices) {
        umb_candidate_release(out);
        return AUTHOR_NO_MEMORY;
    }
    for (uint32_t i = 0; i < count; i++) {
        out->umbrellas[i] = (zt_umbrella){.x = (int32_t)umb_round((i % wide + 0.5) / columns * 65536),
                                          .y = (int32_t)umb_round((i / wide + 0.5) / rows * 65536),
                                          .first_vertex = out->vertex_count,
                                          .first_colour = out->colour_count,
                                          .vertex_count = (uint16_t)vertices,
                                          .form = ZT_UMBRELLA_COLOURED};
        out->vertex_count += rectangle(half, vertices, (double)(UINT32_C(1) << bits),
                                       out->vertices + out->vertex_count);
        out->colour_count += vertices + 1;
    }
    out->level.umbrella_count = count;
    return AUTHOR_OK;
}
