/* SPDX-License-Identifier: Apache-2.0 */
/* Outlines as straight pieces, so short that they stand for the curves. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "silmap_bench.h"

enum {
    STEPS = 24,    /* pieces of a curve */
    SUB_ROWS = 16, /* of a pixel */
    MAX_CROSSINGS = 4096
};

static const double corner_sine = 0.14; /* about 8 degrees */

typedef struct vec {
    double x, y;
} vec;

void *bench_alloc(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        bench_fail("memory", "there is none");
    return memory;
}

void bench_fail(const char *what, const char *why) {
    fprintf(stderr, "bench_silmap: %s: %s\n", what, why);
    exit(1);
}

/* ---- reading -------------------------------------------------------------------------------------------- */

typedef struct reader {
    shape *out;
    size_t capacity;
    vec first, now;
    vec start_tangent, end_tangent; /* of the contour's first and of the latest segment */
    size_t contour_first;
} reader;

static vec minus(vec a, vec b) {
    return (vec){a.x - b.x, a.y - b.y};
}

static vec mix(vec a, vec b, double t) {
    return (vec){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
}

static int is_zero(vec a) {
    return !(hypot(a.x, a.y) > 1e-12);
}

static int is_corner(vec in, vec out) {
    double length = hypot(in.x, in.y) * hypot(out.x, out.y);
    return in.x * out.x + in.y * out.y <= 0 || fabs(in.x * out.y - in.y * out.x) > corner_sine * length;
}

static void add_piece(reader *r, vec to, int corner) {
    shape *s = r->out;
    if (s->count == r->capacity) {
        r->capacity = r->capacity ? 2 * r->capacity : 1024;
        s->pieces = realloc(s->pieces, r->capacity * sizeof *s->pieces);
        if (!s->pieces)
            bench_fail("outline", "no memory");
    }
    s->pieces[s->count++] = (piece){r->now.x, r->now.y, to.x, to.y, s->contour_count, corner};
    r->now = to;
}

static vec curve_at(const vec *p, int degree, double t) {
    vec q[4];
    memcpy(q, p, sizeof q);
    for (int n = degree; n > 0; n--)
        for (int i = 0; i < n; i++)
            q[i] = mix(q[i], q[i + 1], t);
    return q[0];
}

/* A segment of degree 1 to 3 from r->now; p[0] is set here. */
static void add_segment(reader *r, vec p[4], int degree) {
    p[0] = r->now;
    int a = 1, b = degree - 1;
    while (a < degree && is_zero(minus(p[a], p[0])))
        a++;
    while (b > 0 && is_zero(minus(p[b], p[degree])))
        b--;
    vec out = minus(p[a], p[0]), end = minus(p[degree], p[b]);
    if (is_zero(out))
        return;
    int corner = r->out->count > r->contour_first && is_corner(r->end_tangent, out);
    if (r->out->count == r->contour_first)
        r->start_tangent = out;
    int steps = degree == 1 ? 1 : STEPS;
    for (int i = 1; i <= steps; i++)
        add_piece(r, i == steps ? p[degree] : curve_at(p, degree, (double)i / steps), i == 1 && corner);
    r->end_tangent = end;
}

static void close_contour(reader *r) {
    shape *s = r->out;
    if (s->count == r->contour_first)
        return;
    vec back[4] = {{0}, r->first};
    add_segment(r, back, 1);
    s->pieces[r->contour_first].corner = is_corner(r->end_tangent, r->start_tangent);
    s->contour_count++;
    r->contour_first = s->count;
}

static void read_line(reader *r, char command, const double n[6]) {
    vec p[4] = {{0}, {n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}};
    switch (command) {
    case 'M':
        close_contour(r);
        r->first = r->now = p[1];
        break;
    case 'L':
        add_segment(r, p, 1);
        break;
    case 'Q':
        add_segment(r, p, 2);
        break;
    case 'C':
        add_segment(r, p, 3);
        break;
    default:
        close_contour(r);
    }
}

static int piece_side(const piece *p, double x, double y) {
    return (p->x1 - p->x0) * (y - p->y0) - (p->y1 - p->y0) * (x - p->x0) < 0;
}

static void turn(piece *pieces, size_t count) {
    int *corners = bench_alloc(count, sizeof *corners); /* at the end of each piece */
    for (size_t i = 0; i < count; i++)
        corners[i] = pieces[(i + 1) % count].corner;
    for (size_t i = 0; i < count / 2; i++) {
        piece swap = pieces[i];
        pieces[i] = pieces[count - 1 - i];
        pieces[count - 1 - i] = swap;
    }
    for (size_t i = 0; i < count; i++) {
        piece *p = &pieces[i];
        *p = (piece){p->x1, p->y1, p->x0, p->y0, p->contour, corners[count - 1 - i]};
    }
    free(corners);
}

/* Contours that have the inside on their right are turned round. */
static void orient(shape *s) {
    for (size_t first = 0, end; first < s->count; first = end) {
        size_t longest = first;
        for (end = first; end < s->count && s->pieces[end].contour == s->pieces[first].contour; end++) {
            const piece *p = &s->pieces[end], *l = &s->pieces[longest];
            if (hypot(p->x1 - p->x0, p->y1 - p->y0) > hypot(l->x1 - l->x0, l->y1 - l->y0))
                longest = end;
        }
        const piece *l = &s->pieces[longest];
        double x = (l->x0 + l->x1) / 2 + (l->y1 - l->y0) * 1e-4, y = (l->y0 + l->y1) / 2 - (l->x1 - l->x0) * 1e-4;
        if (piece_side(l, x, y) != shape_inside(s, x, y))
            turn(s->pieces + first, end - first);
    }
}

shape shape_load(const char *path) {
    shape s = {0};
    reader r = {.out = &s};
    char line[512], command = 0;
    FILE *file = fopen(path, "r");
    if (!file || !fgets(line, sizeof line, file))
        bench_fail(path, "cannot be read");
    s.even_odd = strncmp(line, "evenodd", 7) == 0;
    while (fgets(line, sizeof line, file)) {
        double n[6] = {0};
        if (sscanf(line, "%c %lf %lf %lf %lf %lf %lf", &command, &n[0], &n[1], &n[2], &n[3], &n[4], &n[5]) > 0)
            read_line(&r, command, n);
    }
    close_contour(&r);
    fclose(file);
    orient(&s);
    return s;
}

void shape_release(shape *s) {
    free(s->pieces);
    *s = (shape){0};
}

/* ---- inside --------------------------------------------------------------------------------------------- */

typedef struct crossing {
    double x;
    int turn;
} crossing;

static int compare_crossings(const void *a, const void *b) {
    double x = ((const crossing *)a)->x, y = ((const crossing *)b)->x;
    return (x > y) - (x < y);
}

static size_t find_crossings(const shape *s, double y, crossing out[MAX_CROSSINGS]) {
    size_t count = 0;
    for (size_t i = 0; i < s->count; i++) {
        const piece *p = &s->pieces[i];
        if ((p->y0 <= y) == (p->y1 <= y))
            continue;
        if (count == MAX_CROSSINGS)
            bench_fail("outline", "too many crossings in a row");
        out[count++] = (crossing){p->x0 + (p->x1 - p->x0) * ((y - p->y0) / (p->y1 - p->y0)), p->y1 > p->y0 ? 1 : -1};
    }
    qsort(out, count, sizeof *out, compare_crossings);
    return count;
}

static int is_inside(const shape *s, int winding) {
    return s->even_odd ? winding & 1 : winding != 0;
}

void shape_row(const shape *s, double y, double x0, double dx, size_t count, uint8_t *inside) {
    crossing crossings[MAX_CROSSINGS];
    size_t n = find_crossings(s, y, crossings), k = 0;
    int winding = 0;
    for (size_t i = 0; i < count; i++) {
        while (k < n && crossings[k].x <= x0 + (double)i * dx)
            winding += crossings[k++].turn;
        inside[i] = (uint8_t)is_inside(s, winding);
    }
}

int shape_inside(const shape *s, double x, double y) {
    uint8_t inside;
    shape_row(s, y, x, 1, 1, &inside);
    return inside;
}

/* Adds the span from a to b, in pixels. */
static void add_span(double a, double b, size_t pixels, float *row) {
    a = a < 0 ? 0 : a;
    b = b > (double)pixels ? (double)pixels : b;
    if (!(a < b))
        return;
    size_t first = (size_t)a, last = (size_t)b;
    if (first == last) {
        row[first] += (float)((b - a) / SUB_ROWS);
        return;
    }
    row[first] += (float)(((double)first + 1 - a) / SUB_ROWS);
    for (size_t x = first + 1; x < last; x++)
        row[x] += 1.0F / SUB_ROWS;
    if (last < pixels)
        row[last] += (float)((b - (double)last) / SUB_ROWS);
}

void shape_coverage(const shape *s, const window *w, float *out) {
    crossing crossings[MAX_CROSSINGS];
    double pixel = w->size / (double)w->pixels;
    memset(out, 0, w->pixels * w->pixels * sizeof *out);
    for (size_t row = 0; row < w->pixels * SUB_ROWS; row++) {
        size_t n = find_crossings(s, w->y + ((double)row + 0.5) * pixel / SUB_ROWS, crossings);
        int winding = 0;
        for (size_t k = 0; k + 1 < n; k++) {
            winding += crossings[k].turn;
            if (is_inside(s, winding))
                add_span((crossings[k].x - w->x) / pixel, (crossings[k + 1].x - w->x) / pixel, w->pixels,
                         out + row / SUB_ROWS * w->pixels);
        }
    }
}

/* ---- near an outline ------------------------------------------------------------------------------------ */

static size_t clamp_texel(double at, size_t grid) {
    return at <= 0 ? 0 : at >= (double)grid ? grid : (size_t)at;
}

void shape_visit(const shape *s, size_t grid, double reach, shape_near near, void *context) {
    double n = (double)grid;
    for (size_t i = 0; i < s->count; i++) {
        const piece *p = &s->pieces[i];
        size_t x0 = clamp_texel((fmin(p->x0, p->x1) - reach) * n, grid),
               y0 = clamp_texel((fmin(p->y0, p->y1) - reach) * n, grid);
        size_t x1 = clamp_texel((fmax(p->x0, p->x1) + reach) * n + 1, grid),
               y1 = clamp_texel((fmax(p->y0, p->y1) + reach) * n + 1, grid);
        for (size_t y = y0; y < y1; y++)
            for (size_t x = x0; x < x1; x++)
                near(context, i, y * grid + x, ((double)x + 0.5) / n, ((double)y + 0.5) / n);
    }
}
