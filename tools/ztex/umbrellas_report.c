/* SPDX-License-Identifier: Apache-2.0 */
/* The report of `ztex make umbrellas`: figures, and each level beside what it stands for. umbrellas_report.schema.json
 * describes the JSON. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "make_author.h"
#include "report_parts.h"
#include "umbrellas.h"

#define SHOWN 480 /* pixels along the longer side of a level's picture, at least, by whole times */

/* ---- JSON -------------------------------------------------------------------------------------------------- */

static json_t *decibel(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *level_json(const umbrellas_made *made, uint32_t level) {
    const author_level_report *r = &made->levels[level - 1];
    json_t *object = json_pack("{si s[ii] si si si}", "level", (int)level, "cells", (int)r->width, (int)r->height,
                               "umbrellas", (int)r->umbrellas, "vertices", (int)r->vertices, "longest_list",
                               (int)r->longest);
    json_object_set_new(object, "psnr", decibel(r->psnr));
    json_object_set_new(object, "linear_psnr", decibel(r->linear_psnr));
    json_object_set_new(object, "between_psnr", decibel(r->between_psnr));
    json_object_set_new(object, "between_linear_psnr", decibel(r->between_linear_psnr));
    json_object_set_new(object, "mipmap_psnr", decibel(r->mipmap_psnr));
    json_object_set_new(object, "alpha_psnr", decibel(r->alpha_psnr));
    return object;
}

static int put_json(const umbrellas_made *made, const char *output, FILE *stream) {
    struct stat info;
    json_t *levels = json_array();
    json_t *root = json_pack("{ss so so}", "report", "make umbrellas", "output", cmd_json_text(output), "bytes",
                             stat(output, &info) == 0 ? cmd_json_u64((uint64_t)info.st_size) : json_null());
    json_object_set_new(root, "name", cmd_json_text(made->name));
    json_object_set_new(root, "cells", json_pack("[ii]", (int)made->grid_x, (int)made->grid_y));
    json_object_set_new(root, "bases", cmd_json_u64(made->bases));
    json_object_set_new(root, "umbrellas", cmd_json_u64(made->umbrellas));
    json_object_set_new(root, "entries", cmd_json_u64(made->entries));
    json_object_set_new(root, "longest_list", cmd_json_u64(made->longest));
    for (uint32_t l = 1; l < made->level_count; l++)
        json_array_append_new(levels, level_json(made, l));
    json_object_set_new(root, "levels", levels);
    int status = cmd_json_print(stream, root);
    json_decref(root);
    return status;
}

int umbrellas_print(const umbrellas_made *made, const char *output) {
    return put_json(made, output, stdout);
}

/* ---- what the file shows ----------------------------------------------------------------------------------- */

/* A level at all phases as it is looked up, and as it should be; measured into made. */
static int look_at_level(cmd_args *args, umbrellas_made *made, const zt_file *file, uint32_t level,
                         author_picture *shown, author_picture *wanted) {
    author_level_report *r = &made->levels[level - 1];
    uint32_t texture = zt_find_texture(file, made->name);
    double step[2];
    make_stages stages;
    author_run run = make_author_run(args, &stages);
    umbrellas_step(made->grid_x, made->grid_y, level, step);
    umbrellas_view view = {UMBRELLAS_PHASES * r->width, UMBRELLAS_PHASES * r->height, 1, step, 1};
    int status = umbrellas_look(&run, file, texture == ZT_NONE ? 0 : texture, &view, shown);
    *wanted = (author_picture){0};
    if (status == CMD_OK)
        status = make_author_status(
            author_umbrella_phases(&run, &made->truth, view.width, view.height, made->repeat, wanted), &run);
    if (status == CMD_OK) {
        author_phase_errors errors, mipmap;
        author_umbrella_compare(shown, wanted, &errors);
        author_umbrella_bilinear(wanted, made->repeat, &mipmap);
        author_umbrella_figures(&errors, &mipmap, r);
    }
    make_stages_end(&stages);
    return status;
}

int umbrellas_measure(cmd_args *args, umbrellas_made *made, const char *output) {
    cmd_input file;
    int status = cmd_open(args, output, 0, &file);
    for (uint32_t l = 1; status == CMD_OK && l < made->level_count; l++) {
        author_picture shown, wanted;
        status = look_at_level(args, made, file.file, l, &shown, &wanted);
        author_picture_release(&shown);
        author_picture_release(&wanted);
    }
    cmd_close(&file);
    return status;
}

/* ---- pictures ---------------------------------------------------------------------------------------------- */

/* The middles of pixels, of premultiplied linear light over a grey, each pixel times x times, into the page. */
static int put_picture(const cmd_args *args, const char *beside, const author_picture *picture, const char *caption,
                       FILE *stream) {
    uint32_t pixels[2] = {picture->width / 2, picture->height / 4};
    uint32_t longer = pixels[0] > pixels[1] ? pixels[0] : pixels[1];
    uint32_t scale = longer < SHOWN ? (SHOWN + longer - 1) / longer : 1, width = pixels[0] * scale;
    size_t count = (size_t)width * pixels[1] * scale;
    float *rgb = malloc(3 * count * sizeof *rgb);
    if (!rgb)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (size_t i = 0; i < count; i++) {
        size_t x = i % width / scale, y = i / width / scale;
        const float *from = picture->texels + 4 * ((2 * y + 1) * picture->width + 2 * x + 1);
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = zt_transfer_encode(ZT_TRANSFER_SRGB, from[c] + 0.2f * (1.0f - from[3]));
    }
    int status = report_put_picture(stream, report_picture(args, beside, "png", rgb, width, pixels[1] * scale),
                                    caption);
    free(rgb);
    return status;
}

static int put_level(cmd_args *args, umbrellas_made *made, const zt_file *file, uint32_t level, const char *output,
                     FILE *stream) {
    author_picture shown, wanted;
    int status = look_at_level(args, made, file, level, &shown, &wanted);
    const author_level_report *r = &made->levels[level - 1];
    fprintf(stream, "<h2>Level %u: %u x %u cells, %u umbrellas, %.2f dB</h2>\n<div class=\"strip\">\n", level, r->width,
            r->height, r->umbrellas, r->psnr);
    if (status == CMD_OK)
        status = put_picture(args, output, &shown, "as it is looked up", stream);
    if (status == CMD_OK)
        status = put_picture(args, output, &wanted, "level 0, averaged", stream);
    fputs("</div>\n", stream);
    author_picture_release(&shown);
    author_picture_release(&wanted);
    return status;
}

/* ---- the page ---------------------------------------------------------------------------------------------- */

static void put_number(FILE *stream, double value, const char *unit) {
    fprintf(stream, isfinite(value) ? "<td class=\"n\">%.2f%s</td>" : "<td class=\"n\">exact</td>", value, unit);
}

static void put_level_figures(const author_level_report *r, uint32_t level, FILE *stream) {
    const double psnr[] = {r->psnr,        r->linear_psnr, r->between_psnr, r->between_linear_psnr,
                           r->mipmap_psnr, r->alpha_psnr};
    fprintf(stream,
            "<tr><td class=\"n\">%u</td><td class=\"n\">%u x %u</td><td class=\"n\">%u</td><td class=\"n\">%u</td><td "
            "class=\"n\">%u</td>",
            level, r->width, r->height, r->umbrellas, r->vertices, r->longest);
    for (size_t i = 0; i < sizeof psnr / sizeof psnr[0]; i++)
        put_number(stream, psnr[i], " dB");
    fputs("</tr>\n", stream);
}

static void put_figures(const umbrellas_made *made, FILE *stream) {
    fputs("<table>\n<tr><th rowspan=\"2\">level</th><th rowspan=\"2\">cells</th><th rowspan=\"2\">umbrellas</th><th "
          "rowspan=\"2\">vertices</th><th rowspan=\"2\">longest list</th><th colspan=\"2\">PSNR, middles of "
          "pixels</th><th colspan=\"3\">shifted pixels</th><th rowspan=\"2\">alpha</th></tr>\n"
          "<tr><th>sRGB-coded</th><th>linear</th><th>sRGB-coded</th><th>linear</th><th>a mipmap's</th></tr>\n",
          stream);
    fprintf(stream,
            "<tr><td class=\"n\">0</td><td class=\"n\">%u x %u</td><td class=\"n\">%u</td><td class=\"n\">%u</td><td "
            "class=\"n\">%u</td><td colspan=\"6\"></td></tr>\n",
            made->grid_x, made->grid_y, made->umbrellas, made->vertices, made->longest);
    for (uint32_t l = 1; l < made->level_count; l++)
        put_level_figures(&made->levels[l - 1], l, stream);
    fputs(
        "</table>\n<p class=\"note\">Each level at 8 x 8 pixels a cell against level 0 averaged over the same pixels: "
        "premultiplied values, peak 1. Shifted by a quarter or half of a pixel, a mipmap of these averages is "
        "interpolated; sRGB-coded.</p>\n",
        stream);
}

static int put_page(cmd_args *args, umbrellas_made *made, const zt_file *file, const char *output, FILE *stream) {
    int status = CMD_OK;
    fputs(report_head, stream);
    fputs("<title>", stream);
    report_put(stream, output);
    fputs("</title>\n<h1>", stream);
    report_put(stream, output);
    fputs("</h1>\n", stream);
    put_figures(made, stream);
    for (uint32_t l = 1; status == CMD_OK && l < made->level_count; l++)
        status = put_level(args, made, file, l, output, stream);
    fputs("</html>\n", stream);
    return status;
}

int umbrellas_write_report(cmd_args *args, umbrellas_made *made, const char *output, const char *path) {
    cmd_input file;
    cmd_output to = {0};
    int json = cmd_ends_with(path, ".json");
    int status = cmd_open(args, output, 0, &file);
    if (status != CMD_OK)
        return status;
    status = cmd_output_open(&to, path, 0);
    if (status == CMD_OK)
        status = json ? put_json(made, output, to.stream) : put_page(args, made, file.file, output, to.stream);
    status = cmd_output_end(&to, status);
    cmd_close(&file);
    return status;
}
