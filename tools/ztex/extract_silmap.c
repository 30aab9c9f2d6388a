/* SPDX-License-Identifier: Apache-2.0 */
/* The cells of a silmap as SVG, to be looked at: what is stored, not what a lookup makes of it. */
#include "extract.h"
#include "pick.h"

#include <stdlib.h>
#include <string.h>

#define UNIT 16 /* of the drawing, for a cell */

typedef struct sketch {
    zt_silmap_info info;
    const uint8_t *cells;   /* of the array layer */
    uint32_t width, height; /* samples */
    int colour;
    float *samples; /* sRGB-coded, straight alpha */
    FILE *stream;
} sketch;

/* ---- samples ------------------------------------------------------------------------------------------------ */

static void show_colours(const sketch *s, const zt_image_info *image) {
    for (size_t i = 0; i < (size_t)s->width * s->height; i++) {
        float *rgba = s->samples + 4 * i, alpha = rgba[3];
        float undo = image->alpha_mode == ZT_ALPHA_PREMULTIPLIED ? (alpha > 0.0f ? 1.0f / alpha : 0.0f) : 1.0f;
        for (int c = 0; c < 3; c++) {
            float value = s->colour ? zt_transfer_decode(image->transfer, rgba[c]) * undo : rgba[c];
            value = s->colour ? zt_transfer_encode(ZT_TRANSFER_SRGB, value) : value;
            rgba[c] = value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f;
        }
        rgba[3] = image->alpha_mode == ZT_ALPHA_NONE ? 1.0f : alpha > 0.0f ? (alpha < 1.0f ? alpha : 1.0f) : 0.0f;
    }
}

static int read_samples(sketch *s, const extract_part *part) {
    size_t count = (size_t)s->width * s->height, row = (size_t)s->width * part->info.block_bytes;
    zt_decode_options how = {.size = sizeof how};
    zt_diag diag = {.offset = UINT64_MAX};
    if (extract_refusal(part))
        return cmd_fail(CMD_UNSUPPORTED, "%s: the samples cannot be shown: %s", part->name, extract_refusal(part));
    unsigned char *bytes = malloc(row * s->height);
    s->samples = malloc(count * 4 * sizeof *s->samples);
    if (!bytes || !s->samples) {
        free(bytes);
        return cmd_fail(CMD_INTERNAL, "%s: out of memory", part->name);
    }
    zt_result result = zt_decode_region(part->file, part->image, &part->region, bytes, row * s->height, 0, 0, &how,
                                        &diag);
    if (result == ZT_OK)
        result = zt_unpack_texels(part->info.format, bytes, count, s->samples);
    free(bytes);
    if (result != ZT_OK)
        return cmd_fail_result(part->name, result, &diag);
    for (size_t i = 0; part->format->channels == 1 && i < count; i++)
        s->samples[4 * i + 1] = s->samples[4 * i + 2] = s->samples[4 * i];
    show_colours(s, &part->info);
    return CMD_OK;
}

/* ---- cells -------------------------------------------------------------------------------------------------- */

/* A cell in the drawing's coordinates: its point, and those that its arms lead to: north, east, south, west. */
typedef struct drawn_cell {
    double p[2], ends[4][2];
    unsigned cut; /* set of ZT_SILMAP_CUT_... */
} drawn_cell;

static drawn_cell cell_of(const sketch *s, uint32_t x, uint32_t y) {
    zt_silmap_cell bytes;
    zt_silmap_shape c;
    zt_silmap_cell_at(s->cells, s->info.cells_x, s->info.cells_y, s->width == s->info.cells_x,
                      s->height == s->info.cells_y, x, y, &bytes);
    zt_silmap_shape_of(&bytes, &c);
    drawn_cell out = {{c.px, c.py}, {{c.nx, c.ny}, {c.ex, c.ey}, {c.sx, c.sy}, {c.wx, c.wy}}, c.cut};
    for (int axis = 0; axis < 2; axis++) {
        double at = axis ? y : x;
        out.p[axis] = UNIT * (out.p[axis] + at);
        for (int k = 0; k < 4; k++)
            out.ends[k][axis] = UNIT * (out.ends[k][axis] + at);
    }
    return out;
}

/* Where the arm between the points of two neighbours meets the side between them: across in x, or down in y. */
static void crossing_of(const double a[2], const double b[2], int axis, double at, double out[2]) {
    double t = (at - a[axis]) / (b[axis] - a[axis]);
    out[axis] = at;
    out[!axis] = a[!axis] + t * (b[!axis] - a[!axis]);
}

static void put_fill(const sketch *s, const float rgba[4]) {
    fprintf(s->stream, "fill=\"#%02x%02x%02x\"", (unsigned)(rgba[0] * 255.0f + 0.5f),
            (unsigned)(rgba[1] * 255.0f + 0.5f), (unsigned)(rgba[2] * 255.0f + 0.5f));
    if (rgba[3] < 1.0f)
        fprintf(s->stream, " fill-opacity=\"%.3f\"", (double)rgba[3]);
}

static void put_quadrants(const sketch *s, uint32_t x, uint32_t y) {
    double w[2], n[2], e[2], d[2];
    const float *colours[4];
    for (uint32_t k = 0; k < 4; k++)
        colours[k] = s->samples + 4 * ((size_t)((y + (k >> 1)) % s->height) * s->width + (x + (k & 1)) % s->width);
    int same = 1;
    for (int k = 1; k < 4; k++)
        same &= memcmp(colours[0], colours[k], 4 * sizeof(float)) == 0;
    if (same) {
        fprintf(s->stream, "<path d=\"M%u %uh%dv%dh-%dz\" ", (unsigned)x * UNIT, (unsigned)y * UNIT, UNIT, UNIT, UNIT);
        put_fill(s, colours[0]);
        fputs("/>\n", s->stream);
        return;
    }
    drawn_cell c = cell_of(s, x, y);
    const double *p = c.p;
    crossing_of(c.ends[3], p, 0, UNIT * (double)x, w);
    crossing_of(c.ends[0], p, 1, UNIT * (double)y, n);
    crossing_of(p, c.ends[1], 0, UNIT * (double)(x + 1), e);
    crossing_of(p, c.ends[2], 1, UNIT * (double)(y + 1), d);
    for (int k = 0; k < 4; k++) {
        const double *side = k & 1 ? e : w, *top = k >> 1 ? d : n;
        fprintf(s->stream, "<path d=\"M%u %uL%.4g %.4g %.4g %.4g %.4g %.4gz\" ",
                (unsigned)(x + (unsigned)(k & 1)) * UNIT, (unsigned)(y + (unsigned)(k >> 1)) * UNIT, top[0], top[1],
                p[0], p[1], side[0], side[1]);
        put_fill(s, colours[k]);
        fputs("/>\n", s->stream);
    }
}

/* The west and the north arm of a cell, and those that leave the texture, if they are cut as wanted. */
static void put_arms(const sketch *s, uint32_t x, uint32_t y, int cut) {
    drawn_cell c = cell_of(s, x, y);
    unsigned wanted = ZT_SILMAP_CUT_NORTH | ZT_SILMAP_CUT_WEST;
    wanted |= x + 1 == s->info.cells_x ? (unsigned)ZT_SILMAP_CUT_EAST : 0u;
    wanted |= y + 1 == s->info.cells_y ? (unsigned)ZT_SILMAP_CUT_SOUTH : 0u;
    wanted &= cut ? c.cut : ~c.cut;
    for (int k = 0; k < 4; k++)
        if (wanted >> k & 1)
            fprintf(s->stream, "M%.5g %.5gL%.5g %.5g\n", c.p[0], c.p[1], c.ends[k][0], c.ends[k][1]);
}

static void put_lines(const sketch *s, int cut, const char *style) {
    fputs("<path fill=\"none\" d=\"", s->stream);
    for (uint32_t y = 0; y < s->info.cells_y; y++)
        for (uint32_t x = 0; x < s->info.cells_x; x++)
            put_arms(s, x, y, cut);
    fprintf(s->stream, "\" %s/>\n", style);
}

/* Only where an arm is cut do points mean anything. */
static void put_points(const sketch *s) {
    fputs("<path fill=\"none\" stroke-linecap=\"round\" stroke-width=\"2.4\" stroke=\"#000\" d=\"", s->stream);
    for (uint32_t y = 0; y < s->info.cells_y; y++) {
        for (uint32_t x = 0; x < s->info.cells_x; x++) {
            drawn_cell c = cell_of(s, x, y);
            if (c.cut)
                fprintf(s->stream, "M%.5g %.5gh0\n", c.p[0], c.p[1]);
        }
    }
    fputs("\"/>\n", s->stream);
}

static void put_drawing(const sketch *s) {
    unsigned width = (unsigned)s->info.cells_x * UNIT, height = (unsigned)s->info.cells_y * UNIT;
    fprintf(s->stream,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%u\" height=\"%u\" viewBox=\"0 0 %u %u\">\n"
            "<title>%u x %u cells</title>\n<g stroke-width=\"0\" shape-rendering=\"crispEdges\">\n",
            width, height, width, height, (unsigned)s->info.cells_x, (unsigned)s->info.cells_y);
    for (uint32_t y = 0; y < s->info.cells_y && !cmd_interrupted(); y++)
        for (uint32_t x = 0; x < s->info.cells_x; x++)
            put_quadrants(s, x, y);
    fputs("</g>\n", s->stream);
    put_lines(s, 0, "stroke=\"#888\" stroke-opacity=\"0.35\" stroke-width=\"0.3\"");
    put_lines(s, 1, "stroke=\"#fff\" stroke-width=\"2.2\" stroke-linecap=\"round\"");
    put_lines(s, 1, "stroke=\"#000\" stroke-width=\"1.2\" stroke-linecap=\"round\"");
    put_points(s);
    fputs("</svg>\n", s->stream);
}

int extract_cells(const zt_file *file, const char *name, uint32_t texture, uint32_t layer, uint32_t array_layer,
                  FILE *stream) {
    sketch s = {.stream = stream};
    zt_layer_info row;
    extract_part part;
    if (zt_get_silmap(file, texture, &s.info) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: texture %u is no silmap: it has no cells", name, (unsigned)texture);
    if (zt_get_layer(file, texture, layer, &row) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: texture %u has no layer %u", name, (unsigned)texture, (unsigned)layer);
    int status = extract_part_of(file, name, row.image, 0, &part);
    if (status != CMD_OK)
        return status;
    if (array_layer >= part.info.layers)
        return cmd_fail(CMD_USAGE, "%s: there are %u array layers, from 0 on", name, (unsigned)part.info.layers);
    part.region.layer = array_layer;
    s.width = part.info.width;
    s.height = part.info.height;
    s.colour = part.is_colour && zt_transfer_known(part.info.transfer);
    s.cells = s.info.cells;
    if (s.info.cell_layers > 1)
        s.cells += (size_t)array_layer * s.info.cells_x * s.info.cells_y;
    status = read_samples(&s, &part);
    if (status == CMD_OK)
        put_drawing(&s);
    free(s.samples);
    return status == CMD_OK && cmd_interrupted() ? cmd_cancelled() : status;
}
