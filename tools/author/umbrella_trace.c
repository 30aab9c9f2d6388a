/* SPDX-License-Identifier: Apache-2.0 */
/* From a picture to the outline of what it shows: coverage by colour, marching squares. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_private.h"

#define LONGEST_SIDE 16384 /* of a picture whose outline is sought */

/* ---- coverage by colour ------------------------------------------------------------------------------------- */

static int by_value(const void *left, const void *right) {
    float a = *(const float *)left, b = *(const float *)right;
    return a < b ? -1 : a > b;
}

static size_t border_texel(const author_picture *p, size_t i) {
    size_t w = p->width, h = p->height;
    if (i < w)
        return i;
    if (i < 2 * w)
        return (h - 1) * w + (i - w);
    i -= 2 * w;
    return i < h ? i * w : (i - h) * w + w - 1;
}

static author_result border_colour(author_run *run, const author_picture *p, float key[3]) {
    size_t count = 2 * ((size_t)p->width + p->height);
    float *values = author_alloc(run, count, sizeof *values);
    if (!values)
        return AUTHOR_NO_MEMORY;
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++)
            values[i] = p->texels[border_texel(p, i) * p->channels + c];
        qsort(values, count, sizeof *values, by_value);
        key[c] = values[count / 2];
    }
    free(values);
    return AUTHOR_OK;
}

author_result author_umbrella_key(author_run *run, const author_picture *picture, const float *key, double tolerance,
                                  author_picture *coverage) {
    float own[3], coded[3];
    *coverage = (author_picture){0};
    if (picture->channels < 3)
        return author_fail(run, AUTHOR_BAD_INPUT, "a picture without colours cannot be cut out by colour");
    author_result result = key ? AUTHOR_OK : border_colour(run, picture, own);
    if (result == AUTHOR_OK)
        result = author_picture_create(run, picture->width, picture->height, 1, coverage);
    if (result != AUTHOR_OK)
        return result;
    for (int c = 0; c < 3; c++)
        coded[c] = zt_transfer_encode(ZT_TRANSFER_SRGB, (key ? key : own)[c]);
    size_t count = (size_t)picture->width * picture->height;
    for (size_t i = 0; i < count; i++) {
        double most = 0;
        for (size_t c = 0; c < 3; c++)
            most = fmax(most,
                        fabs((double)zt_transfer_encode(ZT_TRANSFER_SRGB, picture->texels[i * picture->channels + c]) -
                             (double)coded[c]));
        coverage->texels[i] = (float)fmin(most / tolerance, 1);
    }
    return AUTHOR_OK;
}

/* ---- marching squares --------------------------------------------------------------------------------------- */

/* Between the middles of texels; around the picture there is a frame of zeros. */
typedef struct tracing {
    const author_picture *coverage;
    double threshold;
    uint8_t *seen; /* crossings of horizontal lines, downwards */
    author_xy *points;
    size_t count, room;
} tracing;

static double value_at(const tracing *t, size_t x, size_t y) {
    const author_picture *p = t->coverage;
    if (x == 0 || y == 0 || x > p->width || y > p->height)
        return 0;
    return (double)p->texels[(y - 1) * p->width + (x - 1)];
}

static int inside(const tracing *t, size_t x, size_t y) {
    return value_at(t, x, y) >= t->threshold;
}

/* The side by which the line leaves the square that it entered by side `in`: 0 above, 1 right, 2 below, 3 left. */
static int way_out(const tracing *t, size_t x, size_t y, int in) {
    int tl = inside(t, x, y), tr = inside(t, x + 1, y), br = inside(t, x + 1, y + 1), bl = inside(t, x, y + 1);
    int crossed[4] = {tl != tr, tr != br, bl != br, tl != bl};
    if (crossed[0] && crossed[1] && crossed[2] && crossed[3]) {
        static const int falling[4] = {3, 2, 1, 0}, rising[4] = {1, 0, 3, 2};
        return tl ? falling[in] : rising[in];
    }
    for (int side = 0; side < 4; side++)
        if (side != in && crossed[side])
            return side;
    return in;
}

static double within(double value, double most) {
    return value < 0 ? 0 : value > most ? most : value;
}

static author_xy crossing(const tracing *t, size_t x, size_t y, int side) {
    size_t x0 = x + (side == 1), y0 = y + (side == 2);
    size_t x1 = side == 0 || side == 2 ? x0 + 1 : x0, y1 = side == 0 || side == 2 ? y0 : y0 + 1;
    double a = value_at(t, x0, y0), b = value_at(t, x1, y1), part = (t->threshold - a) / (b - a);
    double px = (double)x0 + part * (double)(x1 - x0) - 0.5, py = (double)y0 + part * (double)(y1 - y0) - 0.5;
    /* Beyond the middle of the last texel its value goes on to the picture's edge. */
    double w = t->coverage->width, h = t->coverage->height;
    px = px < 0.5 ? 0 : px > w - 0.5 ? w : px;
    py = py < 0.5 ? 0 : py > h - 0.5 ? h : py;
    return (author_xy){within(px, w), within(py, h)};
}

static int push(tracing *t, author_xy point) {
    if (t->count > 0 && t->points[t->count - 1].x == point.x && t->points[t->count - 1].y == point.y)
        return 0;
    if (t->count == t->room) {
        size_t room = t->room ? 2 * t->room : 256;
        author_xy *more = realloc(t->points, room * sizeof *more);
        if (!more)
            return -1;
        t->points = more;
        t->room = room;
    }
    t->points[t->count++] = point;
    return 0;
}

/* The loop that crosses the line above square (x, y) downwards. */
static int follow(tracing *t, size_t x, size_t y) {
    size_t from_x = x, from_y = y, line = (size_t)t->coverage->width + 1;
    int in = 0;
    t->count = 0;
    do {
        if (in == 0)
            t->seen[y * line + x] = 1;
        if (push(t, crossing(t, x, y, in)))
            return -1;
        int out = way_out(t, x, y, in);
        x = out == 1 ? x + 1 : out == 3 ? x - 1 : x;
        y = out == 2 ? y + 1 : out == 0 ? y - 1 : y;
        in = (out + 2) % 4;
    } while (x != from_x || y != from_y || in != 0);
    return 0;
}

static int keep_largest(tracing *t, author_outline *out, double *largest) {
    author_outline loop = {t->points, t->count};
    double area = t->count < 3 ? 0 : author_outline_area(&loop);
    if (area <= *largest)
        return 0;
    author_xy *points = malloc(t->count * sizeof *points);
    if (!points)
        return -1;
    memcpy(points, t->points, t->count * sizeof *points);
    free(out->points);
    *out = (author_outline){points, t->count};
    *largest = area;
    return 0;
}

static int trace_all(tracing *t, author_outline *out) {
    size_t w = t->coverage->width, h = t->coverage->height;
    double largest = 0;
    for (size_t y = 1; y <= h; y++)
        for (size_t x = 0; x <= w; x++) {
            if (t->seen[y * (w + 1) + x] || !inside(t, x, y) || inside(t, x + 1, y))
                continue;
            if (follow(t, x, y) || keep_largest(t, out, &largest))
                return -1;
        }
    return 0;
}

author_result author_umbrella_trace(author_run *run, const author_picture *coverage, double threshold,
                                    author_outline *out) {
    tracing t = {.coverage = coverage, .threshold = threshold};
    *out = (author_outline){0};
    if (coverage->width > LONGEST_SIDE || coverage->height > LONGEST_SIDE)
        return author_fail(run, AUTHOR_BAD_INPUT, "a picture of %u x %u is too large to be cut out: make it smaller",
                           coverage->width, coverage->height);
    t.seen = author_alloc(run, ((size_t)coverage->width + 1) * ((size_t)coverage->height + 1), 1);
    if (!t.seen)
        return AUTHOR_NO_MEMORY;
    author_result result = AUTHOR_OK;
    if (trace_all(&t, out))
        result = author_fail(run, AUTHOR_NO_MEMORY, "no memory for the outline");
    else if (out->count < 3)
        result = author_fail(run, AUTHOR_BAD_INPUT, "there is nothing to cut out: nowhere is the coverage %.3g or more",
                             threshold);
    if (result != AUTHOR_OK)
        author_outline_release(out);
    free(t.points);
    free(t.seen);
    return result;
}
