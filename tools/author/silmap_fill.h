/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Flat drawings: which colour is at a place, out of shapes that are painted one over the other. The lines of all shapes
 * are the edges of a silmap_truth; the mark of each is twice the number of its shape, plus one where the line goes
 * down. A scan line that crosses them knows at each place which shapes it is inside of.
 */
#ifndef ZTEX_SILMAP_FILL_H
#define ZTEX_SILMAP_FILL_H

#include "silmap_fit.h"

/* Colours as displayed, multiplied by their opacity: what drawing programs mix. */
typedef struct silmap_paint {
    float value[SILMAP_CHANNELS];
    float keep; /* of what is below */
} silmap_paint;

struct silmap_fills {
    const author_silmap_shape *shapes;
    size_t count;
    size_t most_edges; /* in a band */
    uint32_t channels;
    uint32_t coded;      /* channels below this are colours */
    int alpha;           /* number of that channel, -1: none */
    silmap_paint *paint; /* of each shape */
};

/* Sets truth->fills and the edges, for truth->picture. Errors: AUTHOR_BAD_INPUT for shapes that cannot be. */
author_result silmap_fills_create(author_run *run, const author_silmap_input *input, int plain, silmap_truth *truth);
void silmap_fills_release(struct silmap_fills *fills);

typedef struct silmap_crossing {
    double x;
    const silmap_edge *edge;
} silmap_crossing;

/* Places of a row that have one colour: up to number `end`. */
typedef struct silmap_run {
    size_t end;
    uint32_t key;
} silmap_run;

/* A scan line, from left to right. */
typedef struct silmap_sweep {
    const silmap_truth *truth;
    silmap_crossing *list;
    size_t count;
    silmap_run *runs;           /* of the last row */
    int32_t *winding;           /* of each shape */
    uint64_t *inside, *summary; /* bits: painted shapes; words of inside that are not 0 */
} silmap_sweep;

author_result silmap_sweep_create(const silmap_truth *truth, silmap_sweep *out);
void silmap_sweep_release(silmap_sweep *sweep);
/* Begins a line: the crossings in their order. */
void silmap_sweep_line(silmap_sweep *sweep, double y);
/* Goes beyond crossing i. */
void silmap_sweep_cross(silmap_sweep *sweep, size_t i);
/* The colour where the line is now. */
void silmap_sweep_value(const silmap_sweep *sweep, float value[SILMAP_CHANNELS]);
void silmap_sweep_end(silmap_sweep *sweep);

static inline double silmap_edge_x(const silmap_edge *edge, double y) {
    return edge->x0 + (edge->x1 - edge->x0) * ((y - edge->y0) / (edge->y1 - edge->y0));
}

/* 8 bits a channel. */
uint32_t silmap_fills_key(const float value[SILMAP_CHANNELS]);
/* The places (x0 + i dx, y) as runs, which it counts; the last one ends at count, which is above 0. */
size_t silmap_fills_runs(silmap_sweep *sweep, double y, double x0, double dx, size_t count);
/* As pictures have it: straight, in linear light. */
void silmap_fills_texel(const struct silmap_fills *fills, const float value[SILMAP_CHANNELS], float *texel);

/* silmap_truth.c: sorts truth->edges into bands of y, as many as the picture has rows, or fewer where many edges are
 * long. */
author_result silmap_edges_sort(author_run *run, silmap_truth *truth);
/* The band of a place. */
uint32_t silmap_edges_band(const silmap_truth *truth, double y);

#endif
