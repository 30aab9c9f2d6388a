/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drawings, by librsvg and cairo. Paths are had by letting librsvg draw into cairo's SVG writer: what comes out are the
 * paths alone, in absolute coordinates, with rectangles, circles, references, groups and styles resolved. vector_svg.c
 * reads just that.
 */
#include "vector_module.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cairo-svg.h>
#include <librsvg/rsvg.h>

#include "vector_flat.h"
#include "vector_halves.h"

#define MOST_TEXT ((size_t)1 << 28) /* bytes that the SVG writer may give */
#define LONGER_SIDE 1000.0          /* units of the paths, of which cairo tells 256ths */
#define LETTERS_SIDE 200.0          /* the same for letters as large as a page of 1: more is too large for FreeType */
#define CHECKED_SIDE 512            /* pixels of the pictures that are compared */
#define CHECKED_STEP 32             /* of 255: more than two ways to smooth an edge are apart */
#define CHECKED_SHARE 0.0002        /* of the pixels may be off by more */

struct vector_drawing {
    RsvgHandle *handle;
    double width, height;
    author_silmap_place place;
    int letters; /* there may be some */
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

/* Compressed drawings are not looked into. */
static int may_have_letters(const char *data, size_t size) {
    if (size > 0 && data[0] == '\x1f')
        return 1;
    for (const char *at = data, *end = data + size; (at = memchr(at, 't', (size_t)(end - at))) != NULL; at++)
        if (end - at >= 4 && memcmp(at, "text", 4) == 0)
            return 1;
    return 0;
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
    drawing->letters = may_have_letters(data, size);
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

/* What librsvg draws, as cairo writes it. */
static int write_svg(const vector_drawing *drawing, const double size[2], text_sink *sink, char *error) {
    *sink = (text_sink){0};
    cairo_surface_t *surface = cairo_svg_surface_create_for_stream(take_text, sink, size[0], size[1]);
    int bad = draw(drawing, surface, size[0], size[1], error);
    cairo_surface_finish(surface);
    if (!bad && (cairo_surface_status(surface) != CAIRO_STATUS_SUCCESS || !sink->text))
        bad = fail(error, "its lines are too many");
    cairo_surface_destroy(surface);
    if (bad)
        free(sink->text);
    return bad;
}

/* At most. librsvg scales letters twice, so on a small page they soon are too large; and when that has happened once,
 * they stay broken. */
static void page_size(const vector_drawing *drawing, double longer, double size[2]) {
    double side = drawing->width > drawing->height ? drawing->width : drawing->height;
    if (drawing->letters)
        longer = fmin(longer, LETTERS_SIDE * sqrt(side));
    size[0] = longer * drawing->width / side;
    size[1] = longer * drawing->height / side;
}

int vector_drawing_paths(const vector_drawing *drawing, double tolerance, vector_paths *out, char *error) {
    double size[2];
    page_size(drawing, LONGER_SIDE, size);
    const double unit[2] = {1 / size[0], 1 / size[1]};
    text_sink sink;
    vector_pen pen = {.tolerance = tolerance};
    *out = (vector_paths){0};
    int bad = write_svg(drawing, size, &sink, error);
    if (bad)
        return bad;
    if (vector_svg_paths(sink.text, unit, &pen)) {
        vector_pen_release(&pen);
        bad = fail(error, "its lines cannot be read");
    } else
        bad = vector_pen_finish(&pen, out, error);
    free(sink.text);
    return bad;
}

/* ---- shapes ------------------------------------------------------------------------------------------------- */

static int read_shapes(const vector_drawing *drawing, double tolerance, vector_shapes *out, char *error) {
    double size[2];
    page_size(drawing, LONGER_SIDE, size);
    const double unit[2] = {1 / size[0], 1 / size[1]};
    text_sink sink;
    *out = (vector_shapes){0};
    int status = write_svg(drawing, size, &sink, error);
    if (status)
        return status;
    status = vector_svg_shapes(sink.text, unit, tolerance, out, error);
    free(sink.text);
    return status;
}

static void trace_shape(cairo_t *cairo, const vector_shapes *all, const author_silmap_shape *shape) {
    cairo_new_path(cairo);
    for (size_t p = shape->first; p < shape->first + shape->count; p++) {
        const author_path *path = &all->paths.paths[p];
        cairo_new_sub_path(cairo);
        for (size_t i = 0; i < path->count; i++)
            cairo_line_to(cairo, path->points[2 * i], path->points[2 * i + 1]);
        cairo_close_path(cairo);
    }
    cairo_set_fill_rule(cairo, shape->even_odd ? CAIRO_FILL_RULE_EVEN_ODD : CAIRO_FILL_RULE_WINDING);
}

static void paint_shape(cairo_t *cairo, const vector_shapes *all, const author_silmap_shape *shape) {
    const float *colour = shape->colour;
    if (shape->bounds)
        return;
    cairo_save(cairo);
    for (uint32_t w = shape->within; w; w = all->shapes[w - 1].within) {
        trace_shape(cairo, all, &all->shapes[w - 1]);
        cairo_clip(cairo);
    }
    trace_shape(cairo, all, shape);
    cairo_set_source_rgba(cairo, (double)colour[0], (double)colour[1], (double)colour[2], (double)shape->opacity);
    cairo_fill(cairo);
    cairo_restore(cairo);
}

static size_t count_different(cairo_surface_t *a, cairo_surface_t *b, int width, int height) {
    const unsigned char *p = cairo_image_surface_get_data(a), *q = cairo_image_surface_get_data(b);
    size_t stride = (size_t)cairo_image_surface_get_stride(a), count = 0;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            int most = 0;
            for (size_t i = (size_t)y * stride + 4 * (size_t)x, end = i + 4; i < end; i++)
                most = abs(p[i] - q[i]) > most ? abs(p[i] - q[i]) : most;
            count += most > CHECKED_STEP;
        }
    }
    return count;
}

/* Draws the shapes and the drawing, and compares the pictures. */
static int check_shapes(const vector_drawing *drawing, const vector_shapes *shapes, char *error) {
    double size[2];
    page_size(drawing, CHECKED_SIDE, size);
    int width = size[0] > 1 ? (int)size[0] : 1, height = size[1] > 1 ? (int)size[1] : 1;
    cairo_surface_t *own = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    cairo_surface_t *other = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    cairo_t *cairo = cairo_create(own);
    cairo_scale(cairo, width, height);
    for (size_t s = 0; s < shapes->count; s++)
        paint_shape(cairo, shapes, &shapes->shapes[s]);
    int status = cairo_status(cairo) != CAIRO_STATUS_SUCCESS ? fail(error, cairo_status_to_string(cairo_status(cairo)))
                                                             : draw(drawing, other, width, height, error);
    cairo_destroy(cairo);
    cairo_surface_flush(own);
    cairo_surface_flush(other);
    if (!status && (double)count_different(own, other, width, height) > CHECKED_SHARE * width * height) {
        fail(error, "what is drawn from its lines looks different");
        status = VECTOR_NOT_FLAT;
    }
    cairo_surface_destroy(own);
    cairo_surface_destroy(other);
    return status;
}

int vector_drawing_shapes(const vector_drawing *drawing, double tolerance, vector_shapes *out, char *error) {
    int status = read_shapes(drawing, tolerance, out, error);
    if (!status)
        status = check_shapes(drawing, out, error);
    if (status)
        vector_shapes_release(out);
    return status;
}
