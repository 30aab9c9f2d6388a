/* SPDX-License-Identifier: Apache-2.0 */
/* Drawings as pictures and as paths. */
#include "drawing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

int drawing_is_one(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && (strcasecmp(dot, ".svg") == 0 || strcasecmp(dot, ".svgz") == 0);
}

const vector_module *drawing_module(void) {
    char error[MODULE_ERROR];
    const vector_module *module = module_load(VECTOR_MODULE_FILE, VECTOR_MODULE_SYMBOL, error);
    if (module && module->size == sizeof *module)
        return module;
    cmd_error(module ? "%s is of another version" : "%s", module ? VECTOR_MODULE_FILE : error);
    return NULL;
}

int drawing_open(const cmd_args *args, const char *path, int edges, const vector_module **module, vector_drawing **out,
                 char *error) {
    void *data = NULL;
    size_t size = 0;
    *out = NULL;
    *module = drawing_module();
    if (!*module)
        return CMD_IO;
    int status = cmd_read_all(args, path, 0, &data, &size);
    if (status == CMD_OK && (*module)->drawing_open(data, size, edges, out, error))
        status = CMD_INVALID;
    free(data);
    return status;
}

/* Premultiplied and coded, into straight linear light. */
static void take_pixels(const uint8_t *rgba, size_t count, float *to) {
    for (size_t i = 0; i < 4 * count; i++) {
        float alpha = (float)rgba[i | 3] / 255.0f, value = (float)rgba[i] / 255.0f;
        if (i % 4 == 3)
            to[i] = alpha;
        else
            to[i] = alpha > 0.0f ? zt_transfer_decode(ZT_TRANSFER_SRGB, fminf(value / alpha, 1.0f)) : 0.0f;
    }
}

static int render(const vector_module *module, const vector_drawing *drawing, uint32_t longer, author_picture *out,
                  char *error) {
    double w, h;
    author_run run = {0};
    module->drawing_size(drawing, &w, &h);
    uint32_t width = (uint32_t)fmax(1, w < h ? longer * w / h : longer);
    uint32_t height = (uint32_t)fmax(1, w < h ? longer : longer * h / w);
    uint8_t *rgba = malloc((size_t)width * height * 4);
    if (!rgba || author_picture_create(&run, width, height, 4, out) != AUTHOR_OK) {
        free(rgba);
        return cmd_fail(CMD_INTERNAL, "out of memory");
    }
    int bad = module->drawing_render(drawing, width, height, rgba, error);
    if (!bad)
        take_pixels(rgba, (size_t)width * height, out->texels);
    else
        author_picture_release(out);
    free(rgba);
    return bad ? CMD_INVALID : CMD_OK;
}

int drawing_picture(const cmd_args *args, const char *path, uint32_t longer, author_picture *out, char *error) {
    const vector_module *module;
    vector_drawing *drawing;
    *out = (author_picture){0};
    int status = drawing_open(args, path, 0, &module, &drawing, error);
    if (status != CMD_OK)
        return status;
    status = render(module, drawing, longer, out, error);
    module->drawing_close(drawing);
    return status;
}

int drawing_first_path(const cmd_args *args, const char *path, double tolerance, double **points, size_t *count,
                       char *error) {
    const vector_module *module;
    vector_drawing *drawing;
    vector_paths paths = {0};
    *points = NULL;
    *count = 0;
    int status = drawing_open(args, path, 1, &module, &drawing, error);
    if (status != CMD_OK)
        return status;
    int bad = module->drawing_paths(drawing, tolerance, &paths, error);
    module->drawing_close(drawing);
    if (bad)
        return CMD_INVALID;
    size_t size = paths.count > 0 ? paths.paths[0].count : 0;
    double *copy = malloc((2 * size + 1) * sizeof *copy);
    if (copy && size > 0)
        memcpy(copy, paths.paths[0].points, 2 * size * sizeof *copy);
    free(paths.points);
    free(paths.paths);
    if (!copy)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    *points = copy;
    *count = size;
    return CMD_OK;
}
