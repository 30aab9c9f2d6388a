/* SPDX-License-Identifier: Apache-2.0 */
/* Which part of a texture a picture shows, and how large the picture is. */
#include "pick.h"
#include "render.h"

#include <math.h>
#include <stdlib.h>

#define SIZE_MOST 1048576 /* pixels a side */

int render_view_parse(const char *text, render_view *view, const char **end) {
    double n[4];
    if (pick_numbers(text, n, 4, end) || !(fabs(n[2] - n[0]) > 0.0 && fabs(n[3] - n[1]) > 0.0))
        return -1;
    *view = (render_view){n[0], n[1], n[2], n[3]};
    return 0;
}

int render_path_parse(const char *text, render_view path[2]) {
    const char *rest;
    if (render_view_parse(text, &path[0], &rest) || *rest != ';' || render_view_parse(rest + 1, &path[1], NULL))
        return -1;
    /* A mirrored end has no path without passing through nothing. */
    const render_view *a = &path[0], *b = &path[1];
    return (a->u1 - a->u0) * (b->u1 - b->u0) > 0.0 && (a->v1 - a->v0) * (b->v1 - b->v0) > 0.0 ? 0 : -1;
}

/* One axis. Sizes follow a geometric series; the share of the way is that of the shrinking, so that both edges, and
 * with them every point of the last view, move in step with the magnification instead of running ahead of it. */
static void interpolate(double a0, double a1, double b0, double b1, double t, double *c0, double *c1) {
    double from = a1 - a0, to = b1 - b0;
    double share = t, ratio = to / from;
    if (fabs(ratio - 1.0) > 1e-9)
        share = (1.0 - pow(ratio, t)) / (1.0 - ratio);
    if (t >= 1.0)
        share = 1.0; /* exactly */
    *c0 = a0 * (1.0 - share) + b0 * share;
    *c1 = a1 * (1.0 - share) + b1 * share;
}

render_view render_path_at(const render_view path[2], double t) {
    render_view view;
    const render_view *a = &path[0], *b = &path[1];
    interpolate(a->u0, a->u1, b->u0, b->u1, t, &view.u0, &view.u1);
    interpolate(a->v0, a->v1, b->v0, b->v1, t, &view.v0, &view.v1);
    return view;
}

static int parse_side(const char **text, uint32_t *side) {
    char *end;
    if (**text < '0' || **text > '9')
        return 0;
    unsigned long value = strtoul(*text, &end, 10);
    *text = end;
    *side = (uint32_t)value;
    return value < 1 || value > SIZE_MOST ? -1 : 0;
}

int render_size_parse(const char *text, uint32_t *width, uint32_t *height) {
    *width = *height = 0;
    if (parse_side(&text, width))
        return -1;
    if (*text == 'x' || *text == 'X') {
        text++;
        if (parse_side(&text, height))
            return -1;
    }
    return *text || (*width == 0 && *height == 0) ? -1 : 0;
}

static uint32_t side_of(double pixels) {
    double whole = floor(pixels + 0.5);
    return whole < 1.0 ? 1 : whole > SIZE_MOST ? SIZE_MOST : (uint32_t)whole;
}

void render_size_complete(const render_view *view, uint32_t texture_width, uint32_t texture_height, uint32_t longest,
                          uint32_t *width, uint32_t *height) {
    double w = fabs(view->u1 - view->u0) * texture_width, h = fabs(view->v1 - view->v0) * texture_height;
    double most = w > h ? w : h;
    if (*width && *height)
        return;
    double scale = 1.0;
    if (*width)
        scale = *width / w;
    else if (*height)
        scale = *height / h;
    else if (most > longest)
        scale = longest / most;
    if (!*width)
        *width = side_of(w * scale);
    if (!*height)
        *height = side_of(h * scale);
}
