/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drawings, by librsvg and cairo. Paths are had by letting librsvg draw into cairo's SVG writer: what comes out are the paths alone, in
 * absolute coordinates, with rectangles, circles, references, groups and styles resolved. read_path reads just that.
 */
#include "vector_module.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cairo-svg.h>
#include <librsvg/rsvg.h>

#include "vector_halves.h"

#define MOST_TEXT ((size_t)1 << 28) /* bytes that the SVG writer may give */
#define LONGER_SIDE 1000.0          /* units of the paths: cairo writes six digits behind the point */

struct vector_drawing {
    RsvgHandle *handle;
    double width, height;
    author_silmap_place place;
};

/* Whatever would make librsvg draw into a picture first, or not the line itself, goes. */
static const char edges_style[] =
    "* { opacity: 1 !important; filter: none !important; mask: none !important; clip-path: none !important;"
    " mix-blend-mode: normal !important; isolation: auto !important; stroke-dasharray: none !important;"
    " marker-start: none !important; marker-mid: none !important; marker-end: none !important;"
    " stroke-opacity: 1 !important; fill-opacity: 1 !important } image { display: none !important }";

static int fail(char *error, const char *text) {
    snprintf(error, VECTOR_ERROR, "%s", text);
    return -1;
}

static int fail_glib(char *error, const char *what, GError *problem) {
    snprintf(error, VECTOR_ERROR, "%s: %.160s", what, problem ? problem->message : "no reason is given");
    error[strcspn(error, "\n")] = '\0';
    g_clear_error(&problem);
    return -1;
}

void vector_drawing_close(vector_drawing *drawing) {
    if (!drawing)
        return;
    g_clear_object(&drawing->handle);
    free(drawing);
}

static void find_size(vector_drawing *drawing) {
    gdouble width = 0, height = 0;
    gboolean has_width, has_height, has_box;
    RsvgLength w, h;
    RsvgRectangle box;
    if (!rsvg_handle_get_intrinsic_size_in_pixels(drawing->handle, &width, &height)) {
        rsvg_handle_get_intrinsic_dimensions(drawing->handle, &has_width, &w, &has_height, &h, &has_box, &box);
        width = has_box ? box.width : 1;
        height = has_box ? box.height : 1;
    }
    int good = width > 0 && height > 0 && width < 1e9 && height < 1e9;
    drawing->width = good ? width : 1;
    drawing->height = good ? height : 1;
}

int vector_drawing_open(const void *data, size_t size, int edges, vector_drawing **out, char *error) {
    vector_drawing *drawing = calloc(1, sizeof *drawing);
    GError *problem = NULL;
    *out = NULL;
    if (!drawing)
        return fail(error, "out of memory");
    drawing->place = (author_silmap_place){0, 0, 1, 1};
    drawing->handle = rsvg_handle_new_from_data(data, size, &problem);
    if (!drawing->handle) {
        vector_drawing_close(drawing);
        return fail_glib(error, "it is not a drawing that librsvg reads", problem);
    }
    rsvg_handle_set_dpi(drawing->handle, 96);
    if (edges &&
        !rsvg_handle_set_stylesheet(drawing->handle, (const guint8 *)edges_style, sizeof edges_style - 1, &problem)) {
        vector_drawing_close(drawing);
        return fail_glib(error, "its lines cannot be had", problem);
    }
    find_size(drawing);
    *out = drawing;
    return 0;
}

void vector_drawing_size(const vector_drawing *drawing, double *width, double *height) {
    *width = drawing->width;
    *height = drawing->height;
}

void vector_drawing_place(vector_drawing *drawing, const author_silmap_place *place) {
    drawing->place = *place;
}

/* ---- pixels ------------------------------------------------------------------------------------------------- */

/* The drawing at its place in the surface; where the ratio is not quite its own it is stretched. */
static int draw(const vector_drawing *drawing, cairo_surface_t *surface, double width, double height, char *error) {
    const author_silmap_place *place = &drawing->place;
    cairo_t *cairo = cairo_create(surface);
    GError *problem = NULL;
    RsvgRectangle box = {0, 0, drawing->width, drawing->height};
    int bad = 0;
    cairo_translate(cairo, place->x * width, place->y * height);
    cairo_scale(cairo, place->width * width / drawing->width, place->height * height / drawing->height);
    if (!rsvg_handle_render_document(drawing->handle, cairo, &box, &problem))
        bad = fail_glib(error, "librsvg cannot draw it", problem);
    else if (cairo_status(cairo) != CAIRO_STATUS_SUCCESS)
        bad = fail(error, cairo_status_to_string(cairo_status(cairo)));
    cairo_destroy(cairo);
    return bad;
}

static void take_pixels(cairo_surface_t *surface, uint32_t width, uint32_t height, uint8_t *rgba) {
    cairo_surface_flush(surface);
    const unsigned char *rows = cairo_image_surface_get_data(surface);
    size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++, rgba += 4) {
            uint32_t pixel;
            memcpy(&pixel, rows + y * stride + (size_t)x * 4, 4);
            rgba[0] = (uint8_t)(pixel >> 16);
            rgba[1] = (uint8_t)(pixel >> 8);
            rgba[2] = (uint8_t)pixel;
            rgba[3] = (uint8_t)(pixel >> 24);
        }
    }
}

int vector_drawing_render(const vector_drawing *drawing, uint32_t width, uint32_t height, uint8_t *rgba, char *error) {
    if (width == 0 || height == 0 || width > VECTOR_SIDE || height > VECTOR_SIDE)
        return fail(error, "the picture would be too large");
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, (int)width, (int)height);
    int bad = cairo_surface_status(surface) != CAIRO_STATUS_SUCCESS ? fail(error, "out of memory")
                                                                    : draw(drawing, surface, width, height, error);
    if (!bad)
        take_pixels(surface, width, height, rgba);
    cairo_surface_destroy(surface);
    return bad;
}

/* ---- paths ------------------------------------------------------------------------------------------------- */

typedef struct text_sink {
    char *text;
    size_t size, room;
} text_sink;

static cairo_status_t take_text(void *user, const unsigned char *data, unsigned length) {
    text_sink *sink = user;
    if (sink->size + length + 1 > sink->room) {
        size_t room = 2 * (sink->size + length + 1);
        char *text = room > MOST_TEXT ? NULL : realloc(sink->text, room);
        if (!text)
            return CAIRO_STATUS_NO_MEMORY;
        sink->text = text;
        sink->room = room;
    }
    memcpy(sink->text + sink->size, data, length);
    sink->size += length;
    sink->text[sink->size] = '\0';
    return CAIRO_STATUS_SUCCESS;
}

static int read_numbers(const char **at, double *out, int count) {
    for (int i = 0; i < count; i++) {
        char *end;
        *at += strspn(*at, " ,");
        out[i] = g_ascii_strtod(*at, &end);
        if (end == *at)
            return -1;
        *at = end;
    }
    return 0;
}

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

static const char *attribute(const char *element, const char *end, const char *name) {
    const char *at = strstr(element, name);
    return at && at < end ? at + strlen(name) : NULL;
}

static int read_element(const char *element, const char *end, const double unit[2], vector_pen *pen) {
    double m[6] = {1, 0, 0, 1, 0, 0};
    const char *d = attribute(element, end, " d=\""), *matrix = attribute(element, end, " transform=\"matrix(");
    if (!d || (matrix && read_numbers(&matrix, m, 6)))
        return -1;
    for (int i = 0; i < 6; i++)
        pen->matrix[i] = m[i] * unit[i % 2];
    return read_path(d, pen);
}

/* What is in <defs> are clips and patterns, nothing that is drawn. */
static int read_drawing(const char *text, const double unit[2], vector_pen *pen) {
    for (const char *at = text; (at = strchr(at, '<')) != NULL; at++) {
        const char *end = strchr(at, '>');
        if (strncmp(at, "<defs>", 6) == 0 && !(at = strstr(at, "</defs>")))
            break;
        if (end && strncmp(at, "<path ", 6) == 0 && read_element(at, end, unit, pen))
            return -1;
    }
    return 0;
}

int vector_drawing_paths(const vector_drawing *drawing, double tolerance, vector_paths *out, char *error) {
    double longer = drawing->width > drawing->height ? drawing->width : drawing->height;
    double size[2] = {LONGER_SIDE * drawing->width / longer, LONGER_SIDE * drawing->height / longer};
    double unit[2] = {1 / size[0], 1 / size[1]};
    text_sink sink = {0};
    vector_pen pen = {.tolerance = tolerance};
    *out = (vector_paths){0};
    cairo_surface_t *surface = cairo_svg_surface_create_for_stream(take_text, &sink, size[0], size[1]);
    int bad = draw(drawing, surface, size[0], size[1], error);
    cairo_surface_finish(surface);
    if (!bad && (cairo_surface_status(surface) != CAIRO_STATUS_SUCCESS || !sink.text))
        bad = fail(error, "its lines are too many");
    cairo_surface_destroy(surface);
    if (!bad && read_drawing(sink.text, unit, &pen)) {
        free(pen.paths.paths);
        free(pen.paths.points);
        bad = fail(error, "its lines cannot be read");
    } else if (!bad)
        bad = vector_pen_finish(&pen, out, error);
    free(sink.text);
    return bad;
}
