/* SPDX-License-Identifier: Apache-2.0 */
/* What an input looks like at every place, as exactly as can be had. */
#include <librsvg/rsvg.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "silmap_bench.h"

enum {
    FINER = 4,           /* drawings are rendered so many times finer in each direction, then averaged */
    STRIP = 512,         /* pixels of a part that is rendered at a time */
    OUTLINE_TEXELS = 16, /* of a cell, for the fit */
    DRAWING_TEXELS = 12,
    LARGE_TEXELS = 8,
    LARGE_CELLS = 256
};

/* ---- loading -------------------------------------------------------------------------------------------- */

/* A PPM of 8 bits. */
static author_picture load_photograph(const char *path) {
    author_picture picture = {.channels = 3};
    FILE *file = fopen(path, "rb");
    if (!file || fscanf(file, "P6 %u %u 255", &picture.width, &picture.height) != 2 || fgetc(file) == EOF ||
        picture.width != picture.height || picture.width > 8192)
        bench_fail(path, "is not a square PPM of 8 bits");
    size_t count = (size_t)picture.width * picture.height * 3;
    uint8_t *bytes = bench_alloc(count, 1);
    picture.texels = bench_alloc(count, sizeof *picture.texels);
    if (fread(bytes, 1, count, file) != count)
        bench_fail(path, "is too short");
    fclose(file);
    for (size_t i = 0; i < count; i++)
        picture.texels[i] = zt_transfer_decode(ZT_TRANSFER_SRGB, (float)bytes[i] / 255);
    free(bytes);
    return picture;
}

/* Width of the page by its height. */
static double page_ratio(void *drawing) {
    gdouble width = 1, height = 1;
    gboolean has_width, has_height, has_box;
    RsvgLength a, b;
    RsvgRectangle box;
    if (rsvg_handle_get_intrinsic_size_in_pixels(drawing, &width, &height) && width > 0 && height > 0)
        return width / height;
    rsvg_handle_get_intrinsic_dimensions(drawing, &has_width, &a, &has_height, &b, &has_box, &box);
    return has_box && box.height > 0 ? box.width / box.height : 1;
}

truth truth_load(const char *kind, const char *path, const double crop[3]) {
    truth t = {.kind = TRUTH_PHOTO, .channels = 3};
    memcpy(t.crop, crop, 3 * sizeof *crop);
    if (strcmp(kind, "outline") == 0) {
        t.kind = TRUTH_OUTLINE;
        t.channels = 1;
        t.outline = shape_load(path);
    } else if (strcmp(kind, "drawing") == 0) {
        t.kind = TRUTH_DRAWING;
        t.drawing = rsvg_handle_new_from_file(path, NULL);
        if (!t.drawing)
            bench_fail(path, "is not an SVG");
        t.crop[3] = t.crop[2] * page_ratio(t.drawing);
    } else
        t.photograph = load_photograph(path);
    return t;
}

void truth_release(truth *t) {
    shape_release(&t->outline);
    if (t->drawing)
        g_object_unref(t->drawing);
    free(t->photograph.texels);
    *t = (truth){0};
}

void truth_place(truth *t, const author_silmap_place *place) {
    for (size_t i = 0; i < t->outline.count; i++) {
        piece *p = &t->outline.pieces[i];
        p->x0 = place->x + place->width * p->x0;
        p->x1 = place->x + place->width * p->x1;
        p->y0 = place->y + place->height * p->y0;
        p->y1 = place->y + place->height * p->y1;
    }
    /* A part of the page that is smaller by as much. */
    t->crop[0] -= place->x / place->width * t->crop[2];
    t->crop[1] -= place->y / place->height * t->crop[3];
    t->crop[2] /= place->width;
    t->crop[3] /= place->height;
}

size_t truth_limit(const truth *t, double size) {
    return t->kind == TRUTH_PHOTO ? (size_t)(t->photograph.width * size + 0.5) : SIZE_MAX;
}

/* ---- drawings ------------------------------------------------------------------------------------------- */

/* Renders the square at (x, y) of the unit square into a surface of pixels x pixels. */
static cairo_surface_t *draw(const truth *t, double x, double y, double size, int pixels) {
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, pixels, pixels);
    cairo_t *cr = cairo_create(surface);
    double scale = pixels / size;
    /* The page is stretched so that its crop is the unit square. */
    double page[2] = {scale / t->crop[2], scale / t->crop[3]};
    RsvgRectangle viewport = {-(x + t->crop[0] / t->crop[2]) * scale, -(y + t->crop[1] / t->crop[3]) * scale, page[0],
                              page[1]};
    cairo_set_source_rgb(cr, 1, 1, 1);
    cairo_paint(cr);
    if (!rsvg_handle_render_document(t->drawing, cr, &viewport, NULL))
        bench_fail("drawing", "cannot be rendered");
    cairo_destroy(cr);
    cairo_surface_flush(surface);
    return surface;
}

/* Sets pixels x pixels of out. */
static void average(cairo_surface_t *surface, const float curve[256], size_t pixels, float *out, size_t pitch) {
    const unsigned char *bytes = cairo_image_surface_get_data(surface);
    size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    for (size_t y = 0; y < pixels * FINER; y++) {
        float *row = out + y / FINER * pitch;
        if (y % FINER == 0)
            memset(row, 0, pixels * 3 * sizeof *row);
        for (size_t x = 0; x < pixels * FINER; x++) {
            uint32_t colour;
            memcpy(&colour, bytes + y * stride + 4 * x, 4);
            for (size_t i = 0; i < 3; i++)
                row[x / FINER * 3 + i] += curve[colour >> (16 - 8 * i) & 255] / (FINER * FINER);
        }
    }
}

/* coded: mixed as displayed, and not in linear light. */
static void render_drawing(const truth *t, const window *w, int coded, float *out) {
    float curve[256];
    double pixel = w->size / (double)w->pixels;
    size_t pitch = w->pixels * 3, part = w->pixels < STRIP ? w->pixels : STRIP, strips = (w->pixels + part - 1) / part;
    for (int i = 0; i < 256; i++)
        curve[i] = coded ? (float)i / 255 : zt_transfer_decode(ZT_TRANSFER_SRGB, (float)i / 255);
    for (size_t strip = 0; strip < strips * strips; strip++) {
        /* The last ones overlap those before them. */
        size_t x = strip % strips * part, y = strip / strips * part;
        x = x + part > w->pixels ? w->pixels - part : x;
        y = y + part > w->pixels ? w->pixels - part : y;
        cairo_surface_t *surface = draw(t, w->x + (double)x * pixel, w->y + (double)y * pixel, (double)part * pixel,
                                        (int)part * FINER);
        average(surface, curve, part, out + y * pitch + 3 * x, pitch);
        cairo_surface_destroy(surface);
    }
}

/* ---- photographs ---------------------------------------------------------------------------------------- */

/* The mean of the texels below a pixel, those at its sides by their share. */
static void average_texels(const author_picture *from, double x0, double y0, double size, float *to) {
    size_t edge = from->width, x1 = (size_t)ceil(x0 + size - 1e-9), y1 = (size_t)ceil(y0 + size - 1e-9);
    double sum[3] = {0};
    for (size_t y = (size_t)(y0 + 1e-9); y < y1 && y < edge; y++) {
        double tall = fmin(y0 + size, (double)y + 1) - fmax(y0, (double)y);
        for (size_t x = (size_t)(x0 + 1e-9); x < x1 && x < edge; x++) {
            double share = tall * (fmin(x0 + size, (double)x + 1) - fmax(x0, (double)x)) / (size * size);
            for (size_t i = 0; i < 3; i++)
                sum[i] += share * (double)from->texels[(y * edge + x) * 3 + i];
        }
    }
    for (int i = 0; i < 3; i++)
        to[i] = (float)sum[i];
}

static void render_photograph(const truth *t, const window *w, float *out) {
    double edge = t->photograph.width, step = edge * w->size / (double)w->pixels;
    for (size_t i = 0; i < w->pixels * w->pixels; i++)
        average_texels(&t->photograph, w->x * edge + (double)(i % w->pixels) * step,
                       w->y * edge + (double)(i / w->pixels) * step, step, out + 3 * i);
}

/* ---- both ----------------------------------------------------------------------------------------------- */

void truth_render(const truth *t, const window *w, float *out) {
    if (t->kind == TRUTH_OUTLINE)
        shape_coverage(&t->outline, w, out);
    else if (t->kind == TRUTH_DRAWING)
        render_drawing(t, w, 0, out);
    else
        render_photograph(t, w, out);
}

author_picture truth_picture(const truth *t, uint32_t cells) {
    size_t pixels = cells * (cells >= LARGE_CELLS       ? LARGE_TEXELS
                             : t->kind == TRUTH_OUTLINE ? OUTLINE_TEXELS
                                                        : DRAWING_TEXELS);
    if (t->kind == TRUTH_PHOTO)
        pixels = t->photograph.width / 2;
    author_picture picture = {(uint32_t)pixels, (uint32_t)pixels, t->channels, NULL};
    picture.texels = bench_alloc(pixels * pixels * t->channels, sizeof *picture.texels);
    window whole = {0, 0, 1, pixels};
    if (t->kind != TRUTH_DRAWING) {
        truth_render(t, &whole, picture.texels);
        return picture;
    }
    /* As cairo draws it for ztex. */
    render_drawing(t, &whole, 1, picture.texels);
    for (size_t i = 0; i < pixels * pixels * 3; i++)
        picture.texels[i] = zt_transfer_decode(ZT_TRANSFER_SRGB, picture.texels[i]);
    return picture;
}
