/* SPDX-License-Identifier: Apache-2.0 */
/* The report of `ztex make silmap`: figures, and where the picture could not be held. silmap_report.schema.json
 * describes the JSON. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "extract.h"
#include "render.h"
#include "report_parts.h"
#include "silmap.h"

#define SHOWN 640       /* pixels along the longer side of a picture on the page */
#define DRAWN_CELLS 160 /* along a side: with more cells their drawing would be larger than the page is worth */
#define ERROR_GAIN 4.0f /* of the error map: a quarter of the full range is white */
#define LISTED 10000    /* cells in the JSON */

typedef struct telling {
    cmd_args *args;
    const silmap_made *made;
    const char *input, *output;
    zt_file *file;
} telling;

/* ---- JSON --------------------------------------------------------------------------------------------------- */

static json_t *decibel(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *cell_json(const author_silmap_result *r, size_t c) {
    json_t *object = json_object();
    json_object_set_new(object, "x", json_integer((json_int_t)(c % r->cells_x)));
    json_object_set_new(object, "y", json_integer((json_int_t)(c / r->cells_x)));
    json_object_set_new(object, "thin", json_boolean(r->defects[c] & AUTHOR_SILMAP_THIN));
    json_object_set_new(object, "junction", json_boolean(r->defects[c] & AUTHOR_SILMAP_JUNCTION));
    json_object_set_new(object, "error", json_real((double)r->error[c]));
    return object;
}

/* null: nobody asked for hinting. */
static json_t *hint_json(const silmap_trial *trial) {
    static const char *const places[] = {"plain", "hinted"};
    json_t *object = trial->wanted ? json_object() : json_null();
    if (!trial->wanted)
        return object;
    json_object_set_new(object, "kept", json_string(places[trial->kept]));
    for (int i = 0; i < 2; i++) {
        json_t *figures = i <= trial->moved ? json_object() : json_null();
        if (i <= trial->moved) {
            json_object_set_new(figures, "psnr", decibel(trial->psnr[i]));
            json_object_set_new(figures, "disagreement", json_real(trial->disagreement[i]));
        }
        json_object_set_new(object, places[i], figures);
    }
    return object;
}

static int put_json(const telling *report, FILE *stream) {
    const author_silmap_result *r = &report->made->result;
    json_t *object = json_object(), *cells = json_array();
    json_object_set_new(object, "report", json_string("make silmap"));
    json_object_set_new(object, "input", cmd_json_text(report->input));
    json_object_set_new(object, "output", cmd_json_text(report->output));
    json_object_set_new(object, "cells", json_pack("[ii]", (int)r->cells_x, (int)r->cells_y));
    json_object_set_new(object, "fitted_to", json_pack("[ii]", (int)report->made->width, (int)report->made->height));
    const author_silmap_place *place = &report->made->place;
    json_object_set_new(object, "place", json_pack("[ffff]", place->x, place->y, place->width, place->height));
    json_object_set_new(object, "edges_from", json_string(report->made->exact ? "paths" : "texels"));
    json_object_set_new(object, "not_flat",
                        report->made->not_flat[0] ? json_string(report->made->not_flat) : json_null());
    json_object_set_new(object, "hint", hint_json(&report->made->trial));
    json_object_set_new(object, "psnr", decibel(r->psnr));
    json_object_set_new(object, "bilinear_psnr", decibel(r->bilinear_psnr));
    json_object_set_new(object, "box_psnr", decibel(r->box_psnr));
    json_object_set_new(object, "disagreement", json_real(r->disagreement));
    json_object_set_new(object, "cut_cells", cmd_json_u64(r->cut_cells));
    json_object_set_new(object, "thin_cells", cmd_json_u64(r->thin_cells));
    json_object_set_new(object, "junction_cells", cmd_json_u64(r->junction_cells));
    for (size_t c = 0; c < (size_t)r->cells_x * r->cells_y && json_array_size(cells) < LISTED; c++)
        if (r->defects[c])
            json_array_append_new(cells, cell_json(r, c));
    json_object_set_new(object, "not_held", cells);
    int status = cmd_json_print(stream, object);
    json_decref(object);
    return status;
}

/* ---- pictures ------------------------------------------------------------------------------------------------ */

/* Grey for the error; red for what is thinner than a cell, blue for a junction. */
static void paint_cell(const author_silmap_result *r, size_t c, float rgb[3]) {
    float grey = fminf(r->error[c] * ERROR_GAIN, 1.0f);
    rgb[0] = rgb[1] = rgb[2] = grey;
    if (!r->defects[c])
        return;
    rgb[0] = rgb[1] = rgb[2] = 0.3f * grey;
    rgb[r->defects[c] & AUTHOR_SILMAP_THIN ? 0 : 2] = 0.5f + grey / 2;
}

static char *error_map(const telling *report) {
    const author_silmap_result *r = &report->made->result;
    uint32_t longer = r->cells_x > r->cells_y ? r->cells_x : r->cells_y, scale = longer < SHOWN ? SHOWN / longer : 1;
    size_t width = (size_t)r->cells_x * scale, height = (size_t)r->cells_y * scale;
    float *rgb = calloc(width * height, 3 * sizeof *rgb);
    if (!rgb) {
        cmd_error("out of memory");
        return NULL;
    }
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++)
            paint_cell(r, y / scale * r->cells_x + x / scale, rgb + 3 * (y * width + x));
    char *picture = report_picture(report->args, report->output, "png", rgb, (uint32_t)width, (uint32_t)height);
    free(rgb);
    return picture;
}

/* What is transparent shows a grey. */
static char *shown(const telling *report, int is_colour) {
    const silmap_made *made = report->made;
    double scale = SHOWN / (double)(made->width > made->height ? made->width : made->height);
    render_style style = {.width = (uint32_t)fmax(1, made->width * scale),
                          .height = (uint32_t)fmax(1, made->height * scale),
                          .supersample = 1,
                          .gain = 1.0f,
                          .background = is_colour ? BACKGROUND_PLAIN : BACKGROUND_NONE,
                          .plain = {0.2f, 0.2f, 0.2f},
                          .transfer = is_colour ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR};
    render_view view = {0, 0, 1, 1};
    zt_sampler_options how = {.size = sizeof how, .filter = ZT_FILTER_TRILINEAR};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_sampler *sampler = NULL;
    size_t count = (size_t)style.width * style.height;
    float *rgba = malloc(count * 4 * sizeof *rgba);
    char *picture = NULL;
    zt_result result = rgba ? zt_sampler_open(report->file, 0, &how, &diag, &sampler) : ZT_NO_MEMORY;
    if (result == ZT_OK)
        result = render_rows(sampler, &style, &view, 0, style.height, rgba, 4 * (size_t)style.width,
                             cmd_parallel(report->args), &diag);
    if (result == ZT_OK) {
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 3; c++)
                rgba[3 * i + c] = rgba[4 * i + (made->result.samples.channels == 1 ? 0 : c)];
        picture = report_picture(report->args, report->output, "png", rgba, style.width, style.height);
    } else
        cmd_fail_result(report->output, result, &diag);
    zt_sampler_close(sampler);
    free(rgba);
    return picture;
}

/* ---- the page ------------------------------------------------------------------------------------------------ */

static void put_row(FILE *stream, const char *name, int digits, const char *unit, double value) {
    fprintf(stream, "<tr><td>%s</td><td class=\"n\">", name);
    if (isfinite(value))
        fprintf(stream, "%.*f%s", digits, value, unit);
    else
        fputs("exact", stream);
    fputs("</td></tr>\n", stream);
}

static void put_trial(const silmap_trial *trial, FILE *stream) {
    if (!trial->wanted)
        return;
    fprintf(stream, "<tr><td>place</td><td class=\"n\">%s</td></tr>\n",
            trial->kept    ? "hinted"
            : trial->moved ? "as drawn: hinted it would be worse"
                           : "as drawn: hinting finds no better one");
    if (!trial->moved)
        return;
    put_row(stream, trial->kept ? "PSNR where it was drawn" : "PSNR if hinted", 2, " dB", trial->psnr[!trial->kept]);
    put_row(stream, "and area that shows another region", 3, " %", 100 * trial->disagreement[!trial->kept]);
}

static void put_figures(const telling *report, FILE *stream) {
    const author_silmap_result *r = &report->made->result;
    double cells = (double)r->cells_x * r->cells_y;
    fputs("<table>\n", stream);
    fprintf(stream, "<tr><td>cells</td><td class=\"n\">%u x %u</td></tr>\n", (unsigned)r->cells_x,
            (unsigned)r->cells_y);
    fprintf(stream, "<tr><td>fitted to</td><td class=\"n\">%u x %u texels</td></tr>\n", (unsigned)report->made->width,
            (unsigned)report->made->height);
    fprintf(stream, "<tr><td>edges</td><td class=\"n\">%s</td></tr>\n",
            report->made->exact ? "exact, from paths" : "as in these texels");
    if (report->made->not_flat[0])
        fprintf(stream, "<tr><td>drawn supersampled, since</td><td class=\"n\">%s</td></tr>\n", report->made->not_flat);
    put_row(stream, "PSNR of the silmap", 2, " dB", r->psnr);
    put_row(stream, "of a bilinear texture of the same grid, texels by least squares", 2, " dB", r->bilinear_psnr);
    put_row(stream, "of one whose texels are means, as usual", 2, " dB", r->box_psnr);
    put_row(stream, "area that shows another region than the original", 3, " %", 100 * r->disagreement);
    put_trial(&report->made->trial, stream);
    put_row(stream, "cells with an edge", 0, "", (double)r->cut_cells);
    put_row(stream, "that is, of all cells", 1, " %", 100 * (double)r->cut_cells / cells);
    put_row(stream, "cells with a feature thinner than themselves", 0, "", (double)r->thin_cells);
    put_row(stream, "cells with a junction of more regions than corners tell apart", 0, "", (double)r->junction_cells);
    fputs("</table>\n", stream);
}

static int put_cells(const telling *report, FILE *stream) {
    const author_silmap_result *r = &report->made->result;
    if (r->cells_x > DRAWN_CELLS || r->cells_y > DRAWN_CELLS)
        return CMD_OK;
    fputs("<h2>The cells</h2>\n<p class=\"note\">Points and arms: those that are cut are thick. Quadrants have the "
          "colours of their samples. <code>ztex extract --cells</code> writes this drawing.</p>\n",
          stream);
    return extract_cells(report->file, report->output, 0, 0, 0, stream);
}

static int put_page(const telling *report, FILE *stream) {
    zt_layer_info layer = {0};
    zt_get_layer(report->file, 0, 0, &layer);
    fputs(report_head, stream);
    fputs("<style>svg { max-width: 100%; height: auto }</style>\n<title>", stream);
    report_put(stream, report->output);
    fputs("</title>\n<h1>", stream);
    report_put(stream, report->output);
    fputs("</h1>\n<p>Made of ", stream);
    report_put(stream, report->input);
    fputs(".</p>\n", stream);
    put_figures(report, stream);
    fputs("<h2>What it shows, and what it could not hold</h2>\n<div class=\"strip\">\n", stream);
    int status = report_put_picture(stream, shown(report, make_is_colour(layer.semantic)), "the silmap");
    if (status == CMD_OK)
        status = report_put_picture(stream, error_map(report),
                                    "error of each cell, white is a quarter of the full range; red: something is "
                                    "thinner than the cell, blue: a junction");
    fputs(
        "</div>\n<p class=\"note\">Red cells want a finer grid or a simpler drawing: of two edges that cross one side "
        "of a cell only their difference is left. A finer grid for a part of the picture is a patch of a zipmap that "
        "shows another silmap.</p>\n",
        stream);
    if (status == CMD_OK)
        status = put_cells(report, stream);
    fputs("</html>\n", stream);
    return status;
}

int silmap_write_report(cmd_args *args, const silmap_made *made, const char *input, const char *output,
                        const char *path) {
    telling report = {.args = args, .made = made, .input = input, .output = output};
    cmd_input file;
    cmd_output to = {0};
    int json = cmd_ends_with(path, ".json");
    int status = cmd_open(args, output, 0, &file);
    if (status != CMD_OK)
        return status;
    report.file = file.file;
    status = cmd_output_open(&to, path, 0);
    if (status == CMD_OK)
        status = json ? put_json(&report, to.stream) : put_page(&report, to.stream);
    status = cmd_output_end(&to, status);
    cmd_close(&file);
    return status;
}
