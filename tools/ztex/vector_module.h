/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drawings and fonts are a module of the command, loaded when the first one is wanted: librsvg and what it brings take
 * longer to load than most verbs take to run. Data come as memory; nothing else is read, neither files nor a network. A
 * drawing's texts are set in the fonts of the machine.
 *
 * The functions return 0, or -1 with one line in error (VECTOR_ERROR bytes), without the file's name. Handles are for
 * one thread each.
 */
#ifndef ZTEX_VECTOR_MODULE_H
#define ZTEX_VECTOR_MODULE_H

#include <stddef.h>
#include <stdint.h>

#include <author_silmap.h>

#define VECTOR_ERROR 256
#define VECTOR_SIDE 32000 /* pixels that a picture may have along a side */

/* Polygons and chains in coordinates of the unit square; release: free(points), free(paths). */
typedef struct vector_paths {
    author_path *paths;
    size_t count;
    double *points; /* of all paths, one behind the other */
} vector_paths;

/* What is painted, in its order; colours are sRGB-coded red, green and blue. Release: free() of points, paths and
 * shapes. */
typedef struct vector_shapes {
    vector_paths paths;
    author_silmap_shape *shapes;
    size_t count;
} vector_shapes;

#define VECTOR_NOT_FLAT 1

typedef struct vector_drawing vector_drawing; /* SVG */
typedef struct vector_text vector_text;       /* glyphs of a font beside each other */

typedef struct vector_module {
    size_t size; /* sizeof(vector_module) */

    /* edges: what is drawn counts as edges alone: no opacity, filters, clips, masks, markers and dashes. */
    int (*drawing_open)(const void *data, size_t size, int edges, vector_drawing **out, char *error);
    /* Its natural size; only the ratio counts. */
    void (*drawing_size)(const vector_drawing *drawing, double *width, double *height);
    /* Where its page lies in the pictures and paths to come; at first it fills them. */
    void (*drawing_place)(vector_drawing *drawing, const author_silmap_place *place);
    /* Into width x height pixels, premultiplied and sRGB-coded, four bytes r, g, b, a each. */
    int (*drawing_render)(const vector_drawing *drawing, uint32_t width, uint32_t height, uint8_t *rgba, char *error);
    /* Every path that is drawn, filled or stroked: its own line, not the outline of the stroke. Curves become chains
     * that are off by at most tolerance (of the unit square). */
    int (*drawing_paths)(const vector_drawing *drawing, double tolerance, vector_paths *out, char *error);
    /* The drawing as areas of one colour each, strokes and all; tolerance as above. It has been drawn from them and
     * looks the same. Also VECTOR_NOT_FLAT: that cannot be done, and error says what is in the way, as in "it has a
     * gradient". */
    int (*drawing_shapes)(const vector_drawing *drawing, double tolerance, vector_shapes *out, char *error);
    void (*drawing_close)(vector_drawing *drawing); /* NULL is allowed */

    /* Outlines of the characters, Unicode, from left to right with the font's kerning. The font must have them all. */
    int (*text_open)(const void *font, size_t size, const uint32_t *characters, size_t count, vector_text **out,
                     char *error);
    /* Of the box around the ink. */
    void (*text_size)(const vector_text *text, double *width, double *height);
    /* Of a picture in which the ink's box lies at place; what they wind at all is ink. */
    int (*text_paths)(const vector_text *text, const author_silmap_place *place, double tolerance, vector_paths *out,
                      char *error);
    void (*text_close)(vector_text *text); /* NULL is allowed */
} vector_module;

#define VECTOR_MODULE_FILE "ztex-vector.so"
#define VECTOR_MODULE_SYMBOL "ztex_vector_module"

/* vector_path.c, for the two halves of the module: paths as they come, curve by curve. A failure (no memory, too many
 * points, a number that is not finite) is remembered. */
typedef struct vector_pen {
    vector_paths paths;
    size_t path_room, point_count, point_room;
    double tolerance;
    double matrix[6];     /* x' = m0 x + m2 y + m4, y' = m1 x + m3 y + m5 */
    double x, y;          /* where the pen is, before the matrix */
    size_t most_points;   /* 0: as many as memory should hold */
    int keep_bends;       /* bends is wanted */
    unsigned char *bends; /* of each point: inside of a curve */
    int failed;
} vector_pen;

void vector_pen_move(vector_pen *pen, double x, double y);
void vector_pen_line(vector_pen *pen, double x, double y);
void vector_pen_curve(vector_pen *pen, const double control[6]); /* cubic */
void vector_pen_close(vector_pen *pen);                          /* the current path is a polygon */
/* Forgets the last path if it is but a point. */
void vector_pen_settle(vector_pen *pen);
void vector_pen_release(vector_pen *pen);
void vector_shapes_release(vector_shapes *shapes);
/* Hands out what was drawn; paths of one point are left out. 0, or -1 when the pen failed. */
int vector_pen_finish(vector_pen *pen, vector_paths *out, char *error);

#endif
