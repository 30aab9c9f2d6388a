/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The outline of a stroke: a rectangle for each segment, a wedge for each join and each cap, all wound the same way.
 * Where they lie over each other they wind more often, so what they wind at all is the stroke, without anything to be
 * cut.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vector_flat.h"

#define MOST_WEDGE 256              /* points of a round join or cap */
#define MOST_DASHES (1 << 20)       /* of a path */
#define STRAIGHT 1e-9               /* of the sine of a turn: no join */
#define HALF_TURN 3.141592653589793 /* M_PI is not in C11 */

typedef struct polyline {
    double *points;
    unsigned char *bends; /* the line only bends there: it is inside of a curve */
    size_t count, room;
} polyline;

typedef struct stroker {
    const vector_stroke *style;
    vector_pen *out;
    double radius, step; /* step: of a round outline, as an angle */
    polyline dash, first;
} stroker;

/* ---- pieces --------------------------------------------------------------------------------------------- */

static void put_polygon(const stroker *s, const double *points, size_t count) {
    double area = 0;
    for (size_t i = 0; i < count; i++) {
        const double *a = points + 2 * i, *b = points + 2 * ((i + 1) % count);
        area += (a[0] - points[0]) * (b[1] - points[1]) - (b[0] - points[0]) * (a[1] - points[1]);
    }
    for (size_t i = 0; i < count; i++) {
        const double *at = points + 2 * (area < 0 ? count - 1 - i : i);
        if (i == 0)
            vector_pen_move(s->out, at[0], at[1]);
        else
            vector_pen_line(s->out, at[0], at[1]);
    }
    vector_pen_close(s->out);
}

static void put_segment(const stroker *s, const double a[2], const double b[2], const double d[2]) {
    double nx = -d[1] * s->radius, ny = d[0] * s->radius;
    const double points[] = {a[0] + nx, a[1] + ny, a[0] - nx, a[1] - ny, b[0] - nx, b[1] - ny, b[0] + nx, b[1] + ny};
    put_polygon(s, points, 4);
}

/* From p + n, turned by an angle. */
static void put_wedge(const stroker *s, const double p[2], const double n[2], double angle) {
    double points[2 * (MOST_WEDGE + 2)] = {p[0], p[1]};
    double pieces = fmin(fmax(ceil(fabs(angle) / s->step), 1), MOST_WEDGE);
    size_t count = 1;
    for (int i = 0; i <= (int)pieces; i++, count++) {
        double turn = angle * i / pieces, c = cos(turn), sine = sin(turn);
        points[2 * count] = p[0] + c * n[0] - sine * n[1];
        points[2 * count + 1] = p[1] + sine * n[0] + c * n[1];
    }
    put_polygon(s, points, count);
}

/* Between segments of direction a and b. */
static void put_join(const stroker *s, const double p[2], const double a[2], const double b[2], int bends) {
    double sine = a[0] * b[1] - a[1] * b[0], cosine = a[0] * b[0] + a[1] * b[1];
    if (fabs(sine) < STRAIGHT && cosine > 0)
        return;
    /* On the outer side. */
    double side = sine > 0 ? -s->radius : s->radius;
    const double n[2] = {-a[1] * side, a[0] * side}, m[2] = {-b[1] * side, b[0] * side};
    vector_join join = bends ? VECTOR_JOIN_ROUND : s->style->join;
    double limit = s->style->miter_limit;
    if (join == VECTOR_JOIN_ROUND) {
        double angle = atan2(fabs(sine), cosine);
        put_wedge(s, p, n, sine > 0 ? angle : -angle);
    } else if (join == VECTOR_JOIN_MITER && limit * limit * (1 + cosine) >= 2) {
        double tip = 1 / (1 + cosine);
        const double points[] = {
            p[0],        p[1],       p[0] + n[0], p[1] + n[1], p[0] + (n[0] + m[0]) * tip, p[1] + (n[1] + m[1]) * tip,
            p[0] + m[0], p[1] + m[1]};
        put_polygon(s, points, 4);
    } else {
        const double points[] = {p[0], p[1], p[0] + n[0], p[1] + n[1], p[0] + m[0], p[1] + m[1]};
        put_polygon(s, points, 3);
    }
}

/* At an end that the line comes to in direction d. */
static void put_cap(const stroker *s, const double p[2], const double d[2]) {
    const double n[2] = {d[1] * s->radius, -d[0] * s->radius};
    const double end[2] = {p[0] + d[0] * s->radius, p[1] + d[1] * s->radius};
    if (s->style->cap == VECTOR_CAP_ROUND)
        put_wedge(s, p, n, HALF_TURN);
    else if (s->style->cap == VECTOR_CAP_SQUARE)
        put_segment(s, p, end, d);
}

static void direction(const double a[2], const double b[2], double d[2]) {
    double x = b[0] - a[0], y = b[1] - a[1], length = hypot(x, y);
    d[0] = x / length;
    d[1] = y / length;
}

/* ---- lines ---------------------------------------------------------------------------------------------- */

static void clear(polyline *line) {
    line->count = 0;
}

/* No memory is a failure of the pen. */
static void add(const stroker *s, polyline *line, const double at[2], int bends) {
    if (line->count > 0 && !memcmp(line->points + 2 * (line->count - 1), at, 2 * sizeof *at))
        return;
    if (line->count == line->room) {
        size_t room = line->room ? 2 * line->room : 64;
        double *points = realloc(line->points, room * 2 * sizeof *points);
        line->points = points ? points : line->points;
        unsigned char *all = points ? realloc(line->bends, room) : NULL;
        line->bends = all ? all : line->bends;
        line->room = all ? room : line->room;
        if (!all) {
            s->out->failed = 1;
            return;
        }
    }
    memcpy(line->points + 2 * line->count, at, 2 * sizeof *at);
    line->bends[line->count++] = (unsigned char)bends;
}

/* No two points that follow each other are equal. */
static void stroke_line(const stroker *s, const polyline *line, int closed) {
    const double *points = line->points;
    size_t n = line->count;
    double before[2] = {0, 0}, d[2], start[2] = {0, 0};
    if (n < 2) {
        const double right[2] = {s->radius, 0};
        if (n == 1 && s->style->cap == VECTOR_CAP_ROUND)
            put_wedge(s, points, right, 2 * HALF_TURN);
        return;
    }
    for (size_t i = 0; i + 1 < n + (closed ? 1 : 0); i++) {
        const double *a = points + 2 * i, *b = points + 2 * ((i + 1) % n);
        direction(a, b, d);
        put_segment(s, a, b, d);
        if (i > 0)
            put_join(s, a, before, d, line->bends[i]);
        else
            memcpy(start, d, sizeof start);
        memcpy(before, d, sizeof before);
    }
    if (closed) {
        put_join(s, points, d, start, line->bends[0]);
        return;
    }
    const double back[2] = {-start[0], -start[1]};
    put_cap(s, points, back);
    put_cap(s, points + 2 * (n - 1), d);
}

/* ---- dashes --------------------------------------------------------------------------------------------- */

typedef struct dashing {
    size_t number; /* of the dash or gap */
    double left;   /* of it */
    int on, pieces;
} dashing;

static dashing begin_dashes(const vector_stroke *style) {
    dashing at = {0, style->dashes[0], 1, 0};
    double total = 0;
    for (size_t i = 0; i < style->dash_count; i++)
        total += style->dashes[i];
    double offset = fmod(style->dash_offset, 2 * total);
    for (offset = offset < 0 ? offset + 2 * total : offset; offset >= at.left && offset > 0;) {
        offset -= at.left;
        at.number = (at.number + 1) % style->dash_count;
        at.left = style->dashes[at.number];
        at.on = !at.on;
    }
    at.left -= offset;
    return at;
}

/* The first one waits: of a closed line the last one may lead into it. */
static void end_dash(stroker *s, dashing *at) {
    if (at->pieces++ > 0)
        stroke_line(s, &s->dash, 0);
    else {
        polyline swap = s->first;
        s->first = s->dash;
        s->dash = swap;
    }
    clear(&s->dash);
}

static void walk_segment(stroker *s, const double a[2], const double b[2], int bends, dashing *at) {
    const vector_stroke *style = s->style;
    double length = hypot(b[0] - a[0], b[1] - a[1]), gone = 0;
    while (length - gone > at->left && at->pieces < MOST_DASHES && !s->out->failed) {
        gone += at->left;
        const double p[2] = {a[0] + (b[0] - a[0]) * (gone / length), a[1] + (b[1] - a[1]) * (gone / length)};
        add(s, &s->dash, p, 1);
        if (at->on)
            end_dash(s, at);
        at->on = !at->on;
        at->number = (at->number + 1) % style->dash_count;
        at->left = style->dashes[at->number];
        clear(&s->dash);
        if (at->on)
            add(s, &s->dash, p, 1);
    }
    at->left -= length - gone;
    if (at->on)
        add(s, &s->dash, b, bends);
}

static void dash_line(stroker *s, const polyline *line, int closed) {
    dashing at = begin_dashes(s->style);
    size_t n = line->count;
    int whole = at.on;
    clear(&s->dash);
    clear(&s->first);
    if (at.on && n > 0)
        add(s, &s->dash, line->points, line->bends[0]);
    for (size_t i = 0; i + 1 < n + (closed ? 1 : 0); i++)
        walk_segment(s, line->points + 2 * i, line->points + 2 * ((i + 1) % n), line->bends[(i + 1) % n], &at);
    if (at.pieces >= MOST_DASHES)
        s->out->failed = 1;
    if (closed && whole && at.on && at.pieces > 0) {
        for (size_t i = 0; i < s->first.count; i++)
            add(s, &s->dash, s->first.points + 2 * i, s->first.bends[i]);
        clear(&s->first);
    }
    if (closed && whole && at.on && at.pieces == 0)
        stroke_line(s, line, 1);
    else if (at.on)
        stroke_line(s, &s->dash, 0);
    if (at.pieces > 0 && s->first.count > 0)
        stroke_line(s, &s->first, 0);
}

/* ---- all together --------------------------------------------------------------------------------------- */

void vector_stroke_outline(const vector_stroke *style, const vector_pen *lines, vector_pen *out) {
    const double *m = out->matrix, *points = lines->paths.points;
    const unsigned char *bends = lines->bends;
    stroker s = {.style = style, .out = out, .radius = style->width / 2};
    double scale = fmax(hypot(m[0], m[1]), hypot(m[2], m[3])), off = out->tolerance / (s.radius * scale);
    polyline line = {0};
    s.step = off < 1 ? 2 * acos(1 - off) : HALF_TURN / 2;
    for (size_t p = 0; p < lines->paths.count && !out->failed; p++) {
        const author_path *path = &lines->paths.paths[p];
        clear(&line);
        for (size_t i = 0; i < path->count; i++)
            add(&s, &line, points + 2 * i, bends[i]);
        /* A closed one often ends where it began. */
        if (path->closed && line.count > 1 &&
            !memcmp(line.points, line.points + 2 * (line.count - 1), 2 * sizeof *line.points))
            line.count--;
        if (style->dash_count > 0)
            dash_line(&s, &line, path->closed && line.count > 1);
        else
            stroke_line(&s, &line, path->closed && line.count > 1);
        points += 2 * path->count;
        bends += path->count;
    }
    free(line.points);
    free(line.bends);
    free(s.dash.points);
    free(s.dash.bends);
    free(s.first.points);
    free(s.first.bends);
}
