/* SPDX-License-Identifier: Apache-2.0 */
/* Glyphs of a font, by FreeType, as one outline. */
#include "vector_module.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include "vector_halves.h"

#define MOST_CHARACTERS 1024

struct vector_text {
    FT_Library library;
    FT_Face face;
    FT_Outline outline; /* in the font's units, y up */
    FT_Pos room;
    FT_Vector low, high; /* box of the ink */
};

static int fail(char *error, const char *text) {
    snprintf(error, VECTOR_ERROR, "%s", text);
    return -1;
}

void vector_text_close(vector_text *text) {
    if (!text)
        return;
    free(text->outline.points);
    free(text->outline.tags);
    free(text->outline.contours);
    FT_Done_Face(text->face);
    FT_Done_FreeType(text->library);
    free(text);
}

/* Appends the glyph's outline, moved by x. */
static int append(vector_text *text, const FT_Outline *glyph, FT_Pos x) {
    FT_Outline *all = &text->outline;
    size_t points = (size_t)all->n_points + (size_t)glyph->n_points;
    size_t contours = (size_t)all->n_contours + (size_t)glyph->n_contours;
    if (points > 32767 || contours > 32767)
        return -1;
    FT_Vector *vectors = realloc(all->points, (points + 1) * sizeof *vectors);
    all->points = vectors ? vectors : all->points;
    char *tags = realloc(all->tags, points + 1);
    all->tags = tags ? tags : all->tags;
    short *ends = realloc(all->contours, (contours + 1) * sizeof *ends);
    all->contours = ends ? ends : all->contours;
    if (!vectors || !tags || !ends)
        return -1;
    for (int i = 0; i < glyph->n_points; i++) {
        vectors[all->n_points + i] = (FT_Vector){glyph->points[i].x + x, glyph->points[i].y};
        tags[all->n_points + i] = glyph->tags[i];
    }
    for (int i = 0; i < glyph->n_contours; i++)
        ends[all->n_contours + i] = (short)(glyph->contours[i] + all->n_points);
    all->n_points = (short)points;
    all->n_contours = (short)contours;
    all->flags |= glyph->flags & FT_OUTLINE_EVEN_ODD_FILL;
    return 0;
}

static int set_glyphs(vector_text *text, const uint32_t *characters, size_t count, char *error) {
    FT_Face face = text->face;
    FT_Pos x = 0;
    FT_UInt before = 0;
    for (size_t i = 0; i < count; i++) {
        FT_UInt glyph = FT_Get_Char_Index(face, characters[i]);
        FT_Vector kern = {0, 0};
        if (glyph == 0) {
            snprintf(error, VECTOR_ERROR, "the font has no glyph for U+%04X", (unsigned)characters[i]);
            return -1;
        }
        if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_SCALE | FT_LOAD_NO_BITMAP) != 0 ||
            face->glyph->format != FT_GLYPH_FORMAT_OUTLINE) {
            snprintf(error, VECTOR_ERROR, "the glyph for U+%04X is no outline", (unsigned)characters[i]);
            return -1;
        }
        if (before && FT_HAS_KERNING(face) && FT_Get_Kerning(face, before, glyph, FT_KERNING_UNSCALED, &kern) == 0)
            x += kern.x;
        if (labs(x) > (long)1 << 24 || append(text, &face->glyph->outline, x))
            return fail(error, "the text is too long");
        x += face->glyph->advance.x;
        before = glyph;
    }
    return 0;
}

static int measure(vector_text *text, char *error) {
    FT_BBox box;
    FT_Outline_Get_CBox(&text->outline, &box);
    text->low = (FT_Vector){box.xMin, box.yMin};
    text->high = (FT_Vector){box.xMax, box.yMax};
    if (text->outline.n_points == 0 || box.xMin >= box.xMax || box.yMin >= box.yMax)
        return fail(error, "the text has no ink");
    return 0;
}

int vector_text_open(const void *font, size_t size, const uint32_t *characters, size_t count, vector_text **out,
                     char *error) {
    vector_text *text = calloc(1, sizeof *text);
    *out = NULL;
    if (!text)
        return fail(error, "out of memory");
    int bad = 0;
    if (FT_Init_FreeType(&text->library) != 0)
        bad = fail(error, "FreeType cannot start");
    else if (size > 0x7FFFFFFF || FT_New_Memory_Face(text->library, font, (FT_Long)size, 0, &text->face) != 0)
        bad = fail(error, "it is not a font that FreeType reads");
    else if (!FT_IS_SCALABLE(text->face))
        bad = fail(error, "the font has no outlines");
    else if (count == 0 || count > MOST_CHARACTERS)
        bad = fail(error, "1 to 1024 characters are wanted");
    if (!bad)
        bad = set_glyphs(text, characters, count, error) || measure(text, error);
    if (bad) {
        vector_text_close(text);
        return -1;
    }
    *out = text;
    return 0;
}

void vector_text_size(const vector_text *text, double *width, double *height) {
    *width = (double)(text->high.x - text->low.x);
    *height = (double)(text->high.y - text->low.y);
}

/* ---- paths ------------------------------------------------------------------------------------------------- */

static int move_to(const FT_Vector *to, void *user) {
    vector_pen_move(user, (double)to->x, (double)to->y);
    vector_pen_close(user);
    return 0;
}

static int line_to(const FT_Vector *to, void *user) {
    vector_pen_line(user, (double)to->x, (double)to->y);
    return 0;
}

static int conic_to(const FT_Vector *control, const FT_Vector *to, void *user) {
    vector_pen *pen = user;
    double x = (double)control->x, y = (double)control->y, ex = (double)to->x, ey = (double)to->y;
    double cubic[6] = {pen->x + (x - pen->x) * 2 / 3,
                       pen->y + (y - pen->y) * 2 / 3,
                       ex + (x - ex) * 2 / 3,
                       ey + (y - ey) * 2 / 3,
                       ex,
                       ey};
    vector_pen_curve(pen, cubic);
    return 0;
}

static int cubic_to(const FT_Vector *a, const FT_Vector *b, const FT_Vector *to, void *user) {
    double cubic[6] = {(double)a->x, (double)a->y, (double)b->x, (double)b->y, (double)to->x, (double)to->y};
    vector_pen_curve(user, cubic);
    return 0;
}

int vector_text_paths(const vector_text *text, const author_silmap_place *place, double tolerance, vector_paths *out,
                      char *error) {
    static const FT_Outline_Funcs walk = {
        .move_to = move_to, .line_to = line_to, .conic_to = conic_to, .cubic_to = cubic_to};
    double width, height;
    vector_text_size(text, &width, &height);
    double sx = place->width / width, sy = place->height / height, bottom = place->y + place->height;
    vector_pen pen = {
        .tolerance = tolerance,
        .matrix = {sx, 0, 0, -sy, place->x - sx * (double)text->low.x, bottom + sy * (double)text->low.y}};
    FT_Outline copy = text->outline;
    if (FT_Outline_Decompose(&copy, &walk, &pen) != 0)
        pen.failed = 1;
    return vector_pen_finish(&pen, out, error);
}
