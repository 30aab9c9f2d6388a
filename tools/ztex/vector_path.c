/* SPDX-License-Identifier: Apache-2.0 */
/* Curves into chains of straight segments. */
#include "vector_module.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MOST_POINTS ((size_t)1 << 26)
#define MOST_PIECES 256 /* of a curve */

static void *grown(void *array, size_t size, size_t count, size_t *room) {
    if (count < *room)
        return array;
    size_t more = *room ? 2 * *room : 64;
    void *larger = more > MOST_POINTS ? NULL : realloc(array, more * size);
    if (larger)
        *room = more;
    return larger;
}

static int grow_bends(vector_pen *pen) {
    unsigned char *bends = pen->keep_bends ? realloc(pen->bends, pen->point_room) : NULL;
    if (bends)
        pen->bends = bends;
    return bends || !pen->keep_bends ? 0 : -1;
}

static void put(vector_pen *pen, double x, double y, int bends) {
    const double *m = pen->matrix;
    double to[2] = {m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]};
    size_t room = pen->point_room;
    double *points = pen->failed ? NULL
                                 : grown(pen->paths.points, 2 * sizeof *points, pen->point_count, &pen->point_room);
    if (points)
        pen->paths.points = points;
    if (!points || !isfinite(to[0]) || !isfinite(to[1]) || (pen->point_room > room && grow_bends(pen)) ||
        (pen->most_points && pen->point_count >= pen->most_points)) {
        pen->failed = 1;
        return;
    }
    if (pen->keep_bends)
        pen->bends[pen->point_count] = (unsigned char)bends;
    points[2 * pen->point_count] = to[0];
    points[2 * pen->point_count + 1] = to[1];
    pen->point_count++;
    pen->paths.paths[pen->paths.count - 1].count++;
    pen->x = x;
    pen->y = y;
}

/* A place without a line is no path. */
void vector_pen_settle(vector_pen *pen) {
    vector_paths *all = &pen->paths;
    if (all->count > 0 && all->paths[all->count - 1].count < 2)
        pen->point_count -= all->paths[--all->count].count;
}

void vector_pen_move(vector_pen *pen, double x, double y) {
    vector_paths *all = &pen->paths;
    author_path *paths = pen->failed ? NULL : grown(all->paths, sizeof *paths, all->count, &pen->path_room);
    if (!paths) {
        pen->failed = 1;
        return;
    }
    all->paths = paths;
    vector_pen_settle(pen);
    paths[all->count++] = (author_path){0};
    put(pen, x, y, 0);
}

void vector_pen_line(vector_pen *pen, double x, double y) {
    if (pen->paths.count == 0)
        pen->failed = 1;
    if (!pen->failed)
        put(pen, x, y, 0);
}

/* So many pieces that each is off by at most the tolerance: the error of a piece of a cubic is at most its second
 * difference times 3/4 of the step's square. */
static int pieces_of(const vector_pen *pen, const double c[6]) {
    const double *m = pen->matrix;
    double scale = fmax(hypot(m[0], m[1]), hypot(m[2], m[3]));
    double first = hypot(pen->x - 2 * c[0] + c[2], pen->y - 2 * c[1] + c[3]);
    double second = hypot(c[0] - 2 * c[2] + c[4], c[1] - 2 * c[3] + c[5]);
    double count = ceil(sqrt(0.75 * fmax(first, second) * scale / pen->tolerance));
    return count >= 1 && count <= MOST_PIECES ? (int)count : count < 1 ? 1 : MOST_PIECES;
}

void vector_pen_curve(vector_pen *pen, const double c[6]) {
    double x = pen->x, y = pen->y;
    if (pen->paths.count == 0)
        pen->failed = 1;
    int count = pieces_of(pen, c);
    for (int i = 1; i <= count && !pen->failed; i++) {
        double t = (double)i / count, s = 1 - t;
        double w0 = s * s * s, w1 = 3 * s * s * t, w2 = 3 * s * t * t, w3 = t * t * t;
        put(pen, w0 * x + w1 * c[0] + w2 * c[2] + w3 * c[4], w0 * y + w1 * c[1] + w2 * c[3] + w3 * c[5], i < count);
    }
}

void vector_pen_close(vector_pen *pen) {
    if (pen->paths.count > 0)
        pen->paths.paths[pen->paths.count - 1].closed = 1;
}

void vector_pen_release(vector_pen *pen) {
    free(pen->paths.paths);
    free(pen->paths.points);
    free(pen->bends);
    *pen = (vector_pen){0};
}

void vector_shapes_release(vector_shapes *shapes) {
    free(shapes->paths.paths);
    free(shapes->paths.points);
    free(shapes->shapes);
    *shapes = (vector_shapes){0};
}

int vector_pen_finish(vector_pen *pen, vector_paths *out, char *error) {
    vector_paths *all = &pen->paths;
    *out = (vector_paths){0};
    if (pen->failed) {
        snprintf(error, VECTOR_ERROR, "its lines have too many points, or points that are nowhere");
        vector_pen_release(pen);
        return -1;
    }
    vector_pen_settle(pen);
    const double *at = all->points;
    for (size_t i = 0; i < all->count; i++) {
        all->paths[i].points = at;
        at += 2 * all->paths[i].count;
    }
    *out = *all;
    return 0;
}
