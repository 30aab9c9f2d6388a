/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas to be looked at: their bases with contours, and the arrangement as SVG. */
#include "elements.h"
#include "extract.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define UNIT 64        /* of the drawing, for a cell */
#define NUMBERED 65536 /* cells at most, whose lists' lengths are written into them */

static int get_umbrellas(const cmd_input *input, uint32_t texture, zt_umbrella_info *info) {
    if (zt_get_umbrellas(input->file, texture, info) == ZT_OK)
        return CMD_OK;
    return cmd_fail(CMD_USAGE, "%s: texture %u has no umbrellas", input->name, (unsigned)texture);
}

/* ---- bases -------------------------------------------------------------------------------------------------- */

static json_t *place_json(zt_umbrella_texel at) {
    json_t *pair = json_array();
    json_array_append_new(pair, json_real(at.x / 65535.0));
    json_array_append_new(pair, json_real(at.y / 65535.0));
    return pair;
}

static json_t *contour_json(const zt_umbrella_texel *vertices, uint32_t count) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; i++)
        json_array_append_new(list, place_json(vertices[i]));
    return list;
}

/* A variant's offsets, linear light, the centre first. */
static json_t *variant_json(const zt_umbrella_colour *colours, uint32_t count) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const uint8_t stored[3] = {colours[i].r, colours[i].g, colours[i].b};
        json_t *rgb = json_array();
        for (int c = 0; c < 3; c++)
            json_array_append_new(rgb, json_real((double)element_offset(stored[c])));
        json_array_append_new(list, rgb);
    }
    return list;
}

static json_t *base_json(const zt_umbrella_info *info, uint32_t index, const char *file) {
    const zt_umbrella_base *b = &info->bases[index];
    json_t *object = json_object(), *variants = json_array();
    if (file)
        json_object_set_new(object, "file", json_string(file));
    else
        json_object_set_new(object, "texture", json_integer((json_int_t)b->source));
    json_object_set_new(object, "centre", place_json(b->centre));
    json_object_set_new(object, "vertices", contour_json(info->base_vertices + b->first_vertex, b->vertex_count));
    if (b->first_morph != ZT_NONE)
        json_object_set_new(object, "morph", contour_json(info->morph_vertices + b->first_morph, b->vertex_count));
    for (uint32_t i = 0; i < b->variant_count; i++)
        json_array_append_new(variants,
                              variant_json(info->variant_colours + b->first_colour + (size_t)i * (1u + b->vertex_count),
                                           1u + b->vertex_count));
    json_object_set_new(object, "variants", variants);
    return object;
}

static int write_picture(cmd_args *args, const cmd_input *input, uint32_t image, const char *folder, uint32_t index,
                         char name[64], cmd_progress *progress) {
    extract_part part;
    int status = extract_part_of(input->file, input->name, image, 0, &part);
    if (status != CMD_OK)
        return status;
    const char *refusal = extract_refusal(&part);
    snprintf(name, 64, "base_%03u.%s", (unsigned)index, refusal ? "bin" : extract_exact_type(&part));
    char *path = extract_path(folder, name);
    if (!path)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    status = refusal ? extract_raw(args, &part, path, progress) : extract_picture(args, &part, path, progress);
    free(path);
    return status;
}

static int write_contours(const json_t *root, const char *folder) {
    char *path = extract_path(folder, "bases.json");
    int status = path ? cmd_json_write(path, root) : cmd_fail(CMD_INTERNAL, "out of memory");
    free(path);
    return status;
}

int extract_bases(cmd_args *args, const cmd_input *input, uint32_t texture, const char *folder,
                  cmd_progress *progress) {
    zt_umbrella_info info;
    int status = get_umbrellas(input, texture, &info);
    if (status != CMD_OK)
        return status;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return cmd_fail(CMD_IO, "%s: %s", folder, strerror(errno));
    json_t *root = json_object(), *bases = json_array();
    for (uint32_t i = 0; status == CMD_OK && i < info.base_count; i++) {
        char name[64];
        int shows = info.bases[i].shows_texture != 0;
        if (!shows)
            status = write_picture(args, input, info.bases[i].source, folder, i, name, progress);
        json_array_append_new(bases, base_json(&info, i, shows ? NULL : name));
    }
    json_object_set_new(root, "bases", bases);
    if (status == CMD_OK)
        status = write_contours(root, folder);
    json_decref(root);
    return status;
}

/* ---- the drawing -------------------------------------------------------------------------------------------- */

typedef struct sketch {
    const zt_umbrella_info *info;
    uint32_t level;
    int repeats[2];
    float (*means)[3]; /* of the bases */
    element *e;
    FILE *stream;
} sketch;

static unsigned coded(float value) {
    float v = zt_transfer_encode(ZT_TRANSFER_SRGB, value);
    return (unsigned)((v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f) * 255.0f + 0.5f);
}

static void put_colour(FILE *stream, const float rgb[3]) {
    fprintf(stream, "\"#%02x%02x%02x\"", coded(rgb[0]), coded(rgb[1]), coded(rgb[2]));
}

static void put_polygon(const sketch *s, double x, double y) {
    float rgb[3];
    memcpy(rgb, s->e->colours[0], sizeof rgb);
    for (int c = 0; c < 3 && s->e->base; c++)
        rgb[c] += s->means[s->e->base - s->info->bases][c];
    fputs("<path d=\"", s->stream);
    for (uint32_t i = 0; i < s->e->count; i++)
        fprintf(s->stream, "%c%.5g %.5g", i ? 'L' : 'M', UNIT * (x + s->e->points[i][0]),
                UNIT * (y + s->e->points[i][1]));
    fputs("z\" fill=", s->stream);
    put_colour(s->stream, rgb);
    fprintf(s->stream, "/><circle cx=\"%.5g\" cy=\"%.5g\" r=\"1.2\"/>\n", UNIT * x, UNIT * y);
}

/* Where the texture repeats, also what reaches in from beyond its sides. */
static void put_element(const sketch *s, uint32_t index) {
    const zt_umbrella_level *l = &s->info->levels[s->level];
    double box[4], sides[2] = {l->width, l->height};
    element_of(s->info, s->level, index, s->e);
    element_box(s->e, box);
    for (int sy = -s->repeats[1]; sy <= s->repeats[1]; sy++) {
        for (int sx = -s->repeats[0]; sx <= s->repeats[0]; sx++) {
            double by[2] = {sx * sides[0], sy * sides[1]};
            if (box[0] + by[0] < sides[0] && box[2] + by[0] > 0 && box[1] + by[1] < sides[1] && box[3] + by[1] > 0)
                put_polygon(s, s->e->x + by[0], s->e->y + by[1]);
        }
    }
}

static void put_grid(const sketch *s) {
    const zt_umbrella_level *l = &s->info->levels[s->level];
    const uint32_t *starts = s->info->list_starts + l->first_cell;
    unsigned width = l->width * UNIT, height = l->height * UNIT;
    fputs("<path fill=\"none\" stroke=\"#fff\" stroke-opacity=\"0.7\" stroke-width=\"0.8\" d=\"", s->stream);
    for (uint32_t x = 0; x <= l->width; x++)
        fprintf(s->stream, "M%u 0v%u", (unsigned)x * UNIT, height);
    for (uint32_t y = 0; y <= l->height; y++)
        fprintf(s->stream, "M0 %uh%u", (unsigned)y * UNIT, width);
    fputs("\"/>\n", s->stream);
    if (l->width * l->height > NUMBERED)
        return;
    fputs("<g font-family=\"sans-serif\" font-size=\"9\" fill=\"#fff\">\n", s->stream);
    for (uint32_t i = 0; i < l->width * l->height; i++)
        fprintf(s->stream, "<text x=\"%u\" y=\"%u\">%u</text>\n", (unsigned)(i % l->width) * UNIT + 3,
                (unsigned)(i / l->width) * UNIT + 10, (unsigned)(starts[i + 1] - starts[i]));
    fputs("</g>\n", s->stream);
}

static void put_drawing(const sketch *s) {
    const zt_umbrella_level *l = &s->info->levels[s->level];
    unsigned width = l->width * UNIT, height = l->height * UNIT;
    float ground[3] = {s->info->background[0], s->info->background[1], s->info->background[2]};
    fprintf(s->stream,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%u\" height=\"%u\" viewBox=\"0 0 %u %u\">\n"
            "<title>level %u: %u umbrellas, %u x %u cells with the lengths of their lists</title>\n"
            "<rect width=\"%u\" height=\"%u\" fill=",
            width, height, width, height, (unsigned)s->level, (unsigned)l->umbrella_count, (unsigned)l->width,
            (unsigned)l->height, width, height);
    put_colour(s->stream, ground);
    fputs("/>\n<g stroke=\"#000\" stroke-width=\"0.6\">\n", s->stream);
    for (uint32_t i = 0; i < l->umbrella_count && !cmd_interrupted(); i++)
        put_element(s, i);
    fputs("</g>\n", s->stream);
    put_grid(s);
    fputs("</svg>\n", s->stream);
}

int extract_arrangement(const cmd_input *input, uint32_t texture, uint32_t level, const char *path) {
    zt_umbrella_info info;
    zt_texture_info about;
    cmd_output output = {0};
    zt_diag diag = {.offset = UINT64_MAX};
    int status = get_umbrellas(input, texture, &info);
    if (status != CMD_OK)
        return status;
    if (level >= info.level_count)
        return cmd_fail(CMD_USAGE, "%s: there are %u levels, from 0 on", input->name, (unsigned)info.level_count);
    zt_get_texture(input->file, texture, &about);
    sketch s = {.info = &info, .level = level};
    s.repeats[0] = about.wrap_u == ZT_WRAP_REPEAT;
    s.repeats[1] = about.wrap_v == ZT_WRAP_REPEAT;
    s.e = malloc(sizeof *s.e);
    s.means = calloc(info.base_count + (size_t)1, sizeof *s.means);
    zt_result result = s.e && s.means ? ZT_OK : ZT_NO_MEMORY;
    for (uint32_t i = 0; result == ZT_OK && i < info.base_count; i++)
        result = element_mean(input->file, &info.bases[i], s.means[i], &diag);
    status = result == ZT_OK ? cmd_output_open(&output, path, 0) : cmd_fail_result(input->name, result, &diag);
    s.stream = output.stream;
    if (status == CMD_OK)
        put_drawing(&s);
    free(s.e);
    free(s.means);
    if (status == CMD_OK && cmd_interrupted())
        status = cmd_cancelled();
    return cmd_output_end(&output, status);
}
