/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads what cairo's SVG writer has written, and no other SVG: groups that do nothing but clip, paths and rectangles
 * with their colours, and above them definitions. Numbers are absolute, names are the writer's own.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "vector_flat.h"

#define MOST_SHAPES ((size_t)1 << 18)
#define MOST_SHAPE_POINTS ((size_t)1 << 22)
#define DEEPEST 60 /* groups within each other */

typedef struct element {
    const char *begin, *end; /* of the tag: "<" and ">" */
} element;

/* ---- text ----------------------------------------------------------------------------------------------- */

static const char *find(const char *at, const char *end, const char *word) {
    size_t size = strlen(word);
    for (; at && (size_t)(end - at) >= size; at++) {
        at = memchr(at, word[0], (size_t)(end - at) - size + 1);
        if (!at || memcmp(at, word, size) == 0)
            return at;
    }
    return NULL;
}

static int read_numbers(const char **at, double *out, int count) {
    for (int i = 0; i < count; i++) {
        char *end;
        *at += strspn(*at, " ,%");
        out[i] = g_ascii_strtod(*at, &end);
        if (end == *at)
            return -1;
        *at = end;
    }
    return 0;
}

static int is_tag(const element *e, const char *name) {
    size_t size = strlen(name);
    return strncmp(e->begin + 1, name, size) == 0 && strchr(" />", e->begin[1 + size]);
}

/* What follows ` name="`, or NULL. */
static const char *attribute(const element *e, const char *name) {
    char word[32];
    snprintf(word, sizeof word, " %s=\"", name);
    const char *at = find(e->begin, e->end, word);
    return at ? at + strlen(word) : NULL;
}

/* The same, or what follows `name:` in the style. */
static const char *property(const element *e, const char *name) {
    char word[32];
    const char *at = attribute(e, name), *style = at ? NULL : attribute(e, "style");
    const char *end = style ? style + strcspn(style, "\"") : NULL;
    snprintf(word, sizeof word, "%s:", name);
    for (style = find(style, end, word); style; style = find(style + 1, end, word))
        if (strchr("\"; ", style[-1]))
            return style + strlen(word);
    return at;
}

static int is_word(const char *at, const char *word) {
    return at && strncmp(at, word, strlen(word)) == 0;
}

static double number(const element *e, const char *name, double usual) {
    const char *at = property(e, name);
    return at ? g_ascii_strtod(at, NULL) : usual;
}

static int next_element(const char **at, element *e) {
    e->begin = strchr(*at, '<');
    e->end = e->begin ? strchr(e->begin, '>') : NULL;
    *at = e->end;
    return e->end != NULL;
}

/* ---- paths ---------------------------------------------------------------------------------------------- */

/* The words of a d attribute: M, L, C and Z alone. */
static int read_path(const char *at, vector_pen *pen) {
    double n[6], begin[2] = {0, 0};
    int open = 0;
    for (; *at && *at != '"';) {
        char word = *at++;
        int count = word == 'M' || word == 'L' ? 2 : word == 'C' ? 6 : 0;
        if (count > 0 && read_numbers(&at, n, count))
            return -1;
        if (word == 'M')
            memcpy(begin, n, sizeof begin);
        else if (count > 0 && !open)
            vector_pen_move(pen, begin[0], begin[1]);
        if (word == 'L')
            vector_pen_line(pen, n[0], n[1]);
        else if (word == 'C')
            vector_pen_curve(pen, n);
        else if (word == 'Z' && open)
            vector_pen_close(pen);
        else if (word != 'M' && word != 'Z' && word != ' ')
            return -1;
        open = count > 0 ? word != 'M' : word == 'Z' ? 0 : open;
    }
    return 0;
}

static int read_matrix(const element *e, const double unit[2], double matrix[6]) {
    double m[6] = {1, 0, 0, 1, 0, 0};
    const char *at = attribute(e, "transform");
    if (at && (strncmp(at, "matrix(", 7) != 0 || (at += 7, read_numbers(&at, m, 6))))
        return -1;
    for (int i = 0; i < 6; i++)
        matrix[i] = m[i] * unit[i % 2];
    return 0;
}

/* A path, or a rectangle. */
static int read_geometry(const element *e, vector_pen *pen) {
    const char *d = attribute(e, "d");
    if (d)
        return read_path(d, pen);
    double x = number(e, "x", 0), y = number(e, "y", 0), w = number(e, "width", 0), h = number(e, "height", 0);
    vector_pen_move(pen, x, y);
    vector_pen_line(pen, x + w, y);
    vector_pen_line(pen, x + w, y + h);
    vector_pen_line(pen, x, y + h);
    vector_pen_close(pen);
    return 0;
}

/* What is in <defs> are clips and patterns, nothing that is drawn. */
int vector_svg_paths(const char *text, const double unit[2], vector_pen *pen) {
    element e;
    for (const char *at = text; next_element(&at, &e);) {
        if (is_tag(&e, "defs") && !(at = strstr(at, "</defs>")))
            break;
        if (is_tag(&e, "path") && (read_matrix(&e, unit, pen->matrix) || read_geometry(&e, pen)))
            return -1;
    }
    return 0;
}

/* ---- shapes --------------------------------------------------------------------------------------------- */

typedef struct reader {
    const char *text, *defined; /* defined: where the last definition was found */
    const double *unit;
    vector_pen pen;
    author_silmap_shape *shapes;
    size_t count, room;
    uint32_t within[DEEPEST + 1];
    int depth;
    const char *reason; /* why it is not flat */
} reader;

static int not_flat(reader *r, const char *reason) {
    r->reason = reason;
    return VECTOR_NOT_FLAT;
}

/* What the pen has drawn since it had `first` paths. */
static int add_shape(reader *r, size_t first, author_silmap_shape shape) {
    vector_pen_settle(&r->pen);
    if (r->pen.failed || r->count >= MOST_SHAPES)
        return not_flat(r, "it has too many lines");
    if (r->count == r->room) {
        size_t room = r->room ? 2 * r->room : 64;
        author_silmap_shape *shapes = realloc(r->shapes, room * sizeof *shapes);
        if (!shapes)
            return not_flat(r, "it has too many lines");
        r->shapes = shapes;
        r->room = room;
    }
    shape.first = first;
    shape.count = r->pen.paths.count - first;
    shape.within = r->within[r->depth];
    r->shapes[r->count++] = shape;
    return 0;
}

static int read_colour(reader *r, const element *e, const char *name, author_silmap_shape *out) {
    const char *at = property(e, name);
    double rgb[3];
    char opacity[32];
    if (is_word(at, "url(#linear") || is_word(at, "url(#radial"))
        return not_flat(r, "it has a gradient");
    if (is_word(at, "url("))
        return not_flat(r, "it has a pattern");
    if (!is_word(at, "rgb(") || (at += 4, read_numbers(&at, rgb, 3)))
        return -1;
    snprintf(opacity, sizeof opacity, "%s-opacity", name);
    /* Of 100, written with six digits: all are of 8 bits. */
    for (int i = 0; i < 3; i++)
        out->colour[i] = (float)(floor(fmin(fmax(rgb[i], 0), 100) * 2.55 + 0.5) / 255);
    out->opacity = (float)fmin(fmax(number(e, opacity, 1), 0), 1);
    return 0;
}

static int read_fill(reader *r, const element *e) {
    author_silmap_shape shape = {.even_odd = is_word(property(e, "fill-rule"), "evenodd")};
    size_t first = r->pen.paths.count;
    int status = read_colour(r, e, "fill", &shape);
    if (status)
        return status;
    if (read_matrix(e, r->unit, r->pen.matrix) || read_geometry(e, &r->pen))
        return -1;
    return add_shape(r, first, shape);
}

static int read_style(const element *e, vector_stroke *style) {
    const char *join = property(e, "stroke-linejoin"), *cap = property(e, "stroke-linecap");
    const char *dashes = property(e, "stroke-dasharray");
    double sum = 0;
    *style = (vector_stroke){.width = number(e, "stroke-width", 1), .miter_limit = number(e, "stroke-miterlimit", 4)};
    style->join = is_word(join, "round") ? VECTOR_JOIN_ROUND : is_word(join, "bevel") ? VECTOR_JOIN_BEVEL : 0;
    style->cap = is_word(cap, "round") ? VECTOR_CAP_ROUND : is_word(cap, "square") ? VECTOR_CAP_SQUARE : 0;
    style->dash_offset = number(e, "stroke-dashoffset", 0);
    while (dashes && !is_word(dashes, "none") && !strchr("\";", *dashes)) {
        double *dash = &style->dashes[style->dash_count];
        if (++style->dash_count > VECTOR_DASHES || read_numbers(&dashes, dash, 1) || !(*dash >= 0))
            return -1;
        sum += *dash;
    }
    if (!(sum > 0))
        style->dash_count = 0;
    return isfinite(style->width) && isfinite(sum) && isfinite(style->dash_offset) ? 0 : -1;
}

static int read_stroke(reader *r, const element *e) {
    author_silmap_shape shape = {0};
    vector_stroke style;
    vector_pen *pen = &r->pen;
    size_t first = pen->paths.count;
    int status = read_colour(r, e, "stroke", &shape);
    if (status)
        return status;
    if (read_style(e, &style) || read_matrix(e, r->unit, pen->matrix))
        return -1;
    double scale = fmax(hypot(pen->matrix[0], pen->matrix[1]), hypot(pen->matrix[2], pen->matrix[3]));
    if (!(style.width > 0) || !(scale > 0))
        return 0;
    vector_pen lines = {.matrix = {1, 0, 0, 1, 0, 0},
                        .tolerance = pen->tolerance / scale,
                        .keep_bends = 1,
                        .most_points = pen->most_points};
    status = read_geometry(e, &lines);
    vector_pen_settle(&lines);
    pen->failed |= lines.failed;
    if (!pen->failed && !status)
        vector_stroke_outline(&style, &lines, pen);
    vector_pen_release(&lines);
    return status ? status : add_shape(r, first, shape);
}

static int read_drawn(reader *r, const element *e) {
    int status = 0;
    if (property(e, "fill") && !is_word(property(e, "fill"), "none"))
        status = read_fill(r, e);
    if (!status && property(e, "stroke") && !is_word(property(e, "stroke"), "none"))
        status = read_stroke(r, e);
    return status;
}

/* Definitions come in the order in which they are used. */
static const char *find_clip(reader *r, const char *name) {
    char word[64];
    snprintf(word, sizeof word, "<clipPath id=\"%.*s\"", (int)strcspn(name, ")\""), name);
    const char *at = strstr(r->defined, word);
    at = at ? at : strstr(r->text, word);
    if (at)
        r->defined = at;
    return at;
}

static int read_clip(reader *r, const element *group, const char *name) {
    const char *at = find_clip(r, name);
    author_silmap_shape shape = {.bounds = 1, .even_odd = is_word(property(group, "clip-rule"), "evenodd")};
    size_t first = r->pen.paths.count;
    element e;
    if (!at || !next_element(&at, &e))
        return -1;
    while (next_element(&at, &e) && !is_tag(&e, "/clipPath")) {
        shape.even_odd |= is_word(property(&e, "clip-rule"), "evenodd");
        if ((!is_tag(&e, "path") && !is_tag(&e, "rect")) || read_matrix(&e, r->unit, r->pen.matrix) ||
            read_geometry(&e, &r->pen))
            return -1;
    }
    int status = add_shape(r, first, shape);
    if (!status)
        r->within[r->depth] = (uint32_t)r->count;
    return status;
}

static int open_group(reader *r, const element *e) {
    const char *clip = attribute(e, "clip-path");
    if (attribute(e, "mask") || attribute(e, "filter") || attribute(e, "opacity") || attribute(e, "style"))
        return not_flat(r, "it has a group that is seen through, a mask or a filter");
    if (r->depth == DEEPEST)
        return not_flat(r, "its groups are too deep within each other");
    r->depth++;
    r->within[r->depth] = r->within[r->depth - 1];
    return clip ? read_clip(r, e, clip + strlen("url(#")) : 0;
}

static int read_one(reader *r, const element *e) {
    if (is_tag(e, "path") || is_tag(e, "rect"))
        return read_drawn(r, e);
    if (is_tag(e, "g"))
        return open_group(r, e);
    if (is_tag(e, "/g"))
        return r->depth-- > 0 ? 0 : -1;
    if (is_tag(e, "use"))
        return not_flat(r, "it has a group that is seen through, a mask or a filter");
    if (is_tag(e, "image"))
        return not_flat(r, "it has a picture in it, or a filter");
    return is_tag(e, "svg") || is_tag(e, "/svg") || is_tag(e, "?xml") ? 0 : -1;
}

static int read_all(reader *r) {
    element e;
    int status = 0;
    for (const char *at = r->text; !status && next_element(&at, &e);) {
        if (!is_tag(&e, "defs"))
            status = read_one(r, &e);
        else if (!(at = strstr(at, "</defs>")))
            return -1;
        else
            at += strlen("</defs>");
    }
    return status;
}

int vector_svg_shapes(const char *text, const double unit[2], double tolerance, vector_shapes *out, char *error) {
    reader r = {
        .text = text, .defined = text, .unit = unit, .pen = {.tolerance = tolerance, .most_points = MOST_SHAPE_POINTS}};
    *out = (vector_shapes){0};
    int status = read_all(&r);
    if (!status && r.count == 0)
        status = not_flat(&r, "it has nothing in it");
    if (!status)
        status = vector_pen_finish(&r.pen, &out->paths, error);
    else {
        vector_pen_release(&r.pen);
        snprintf(error, VECTOR_ERROR, "%s", status == VECTOR_NOT_FLAT ? r.reason : "its lines cannot be read");
    }
    out->shapes = r.shapes;
    out->count = r.count;
    if (status)
        vector_shapes_release(out);
    return status;
}
