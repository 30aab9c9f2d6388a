/* SPDX-License-Identifier: Apache-2.0 */
#include "pick.h"
#include "elements.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define NAMES_SHOWN 256 /* for "did you mean" */

/* A whole word of digits below limit, or -1. */
static int64_t index_of(const char *text, uint32_t limit) {
    uint64_t value = 0;
    if (!*text)
        return -1;
    for (; *text; text++) {
        if (*text < '0' || *text > '9' || value > UINT32_MAX)
            return -1;
        value = 10 * value + (uint64_t)(*text - '0');
    }
    return value < limit ? (int64_t)value : -1;
}

static int no_texture(const cmd_input *input, const char *text, uint32_t count) {
    const char *names[NAMES_SHOWN];
    size_t known = 0;
    for (uint32_t i = 0; i < count && known < NAMES_SHOWN; i++) {
        zt_texture_info info;
        if (zt_get_texture(input->file, i, &info) == ZT_OK && info.name[0])
            names[known++] = info.name;
    }
    const char *near = cmd_nearest(text, names, known);
    cmd_error("%s: there is no texture '%s'", input->name, text);
    if (near)
        cmd_hint("Did you mean '%s'?", near);
    else
        cmd_hint("The file has %u, from 0 on: 'ztex inspect' lists them.", (unsigned)count);
    return CMD_USAGE;
}

int pick_texture(const cmd_input *input, const char *text, uint32_t *texture) {
    zt_file_info info;
    zt_get_file(input->file, &info);
    *texture = 0;
    if (!text)
        return CMD_OK;
    /* A name comes first: it may consist of digits. */
    *texture = zt_find_texture(input->file, text);
    if (*texture != ZT_NONE)
        return CMD_OK;
    int64_t index = index_of(text, info.texture_count);
    if (index < 0)
        return no_texture(input, text, info.texture_count);
    *texture = (uint32_t)index;
    return CMD_OK;
}

int pick_layer(const cmd_input *input, uint32_t texture, const char *text, uint32_t *layer) {
    zt_texture_info info;
    zt_layer_info row;
    *layer = 0;
    if (!text)
        return CMD_OK;
    if (zt_get_texture(input->file, texture, &info) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "%s: there is no texture %u", input->name, (unsigned)texture);
    int64_t index = index_of(text, info.layer_count);
    if (index >= 0) {
        *layer = (uint32_t)index;
        return CMD_OK;
    }
    int semantic = text[0] >= '0' && text[0] <= '9' ? -1 : cmd_semantic_number(text);
    for (uint32_t i = 0; semantic >= 0 && i < info.layer_count; i++) {
        if (zt_get_layer(input->file, texture, i, &row) != ZT_OK || row.semantic != (uint32_t)semantic)
            continue;
        *layer = i;
        return CMD_OK;
    }
    cmd_error("%s: texture %u has no layer '%s'", input->name, (unsigned)texture, text);
    cmd_hint("'ztex inspect' lists the layers of each texture.");
    return CMD_USAGE;
}

#define TEXELS_MOST 16384 /* a side, of an image that stands for umbrellas */

static uint32_t texels_of(uint32_t cells, double side) {
    double texels = floor(cells * side + 0.5);
    return texels < 1 ? 1 : texels > TEXELS_MOST ? TEXELS_MOST : (uint32_t)texels;
}

static int describe_umbrellas(const zt_file *file, uint32_t texture, zt_image_info *out) {
    zt_umbrella_info info;
    element_scale scale;
    if (zt_get_umbrellas(file, texture, &info) != ZT_OK)
        return -1;
    element_scale_of(file, &info, &scale);
    /* Texels are as wide as high, as cells are. */
    double longer = info.grid_x > info.grid_y ? info.grid_x : info.grid_y;
    double side = fmin(fmax(fmax(scale.across[1], scale.down[1]), 1), TEXELS_MOST / longer);
    int opaque = info.background_kind == ZT_BACKGROUND_COLOUR && info.background[3] >= 1.0f;
    *out = (zt_image_info){.format = 43, /* R8G8B8A8_SRGB */
                           .width = texels_of(info.grid_x, side),
                           .height = texels_of(info.grid_y, side),
                           .depth = 1,
                           .layers = 1,
                           .levels = 1,
                           .alpha_mode = opaque ? ZT_ALPHA_NONE : ZT_ALPHA_PREMULTIPLIED,
                           .primaries = 1,
                           .transfer = ZT_TRANSFER_SRGB};
    return 0;
}

int pick_image_of(const zt_file *file, uint32_t texture, uint32_t layer, uint32_t *number, uint32_t *semantic,
                  zt_image_info *out) {
    zt_layer_info row;
    if (zt_get_layer(file, texture, layer, &row) != ZT_OK)
        return -1;
    *semantic = row.semantic;
    if (number)
        *number = row.image;
    if (row.image == ZT_NONE)
        return describe_umbrellas(file, texture, out);
    return zt_get_image(file, row.image, out) == ZT_OK ? 0 : -1;
}

int pick_numbers(const char *text, double *numbers, size_t count, const char **end) {
    for (size_t i = 0; i < count; i++) {
        char *rest;
        numbers[i] = strtod(text, &rest);
        if (rest == text || !isfinite(numbers[i]))
            return -1;
        if (i + 1 < count && *rest++ != ',')
            return -1;
        text = rest;
    }
    if (end)
        *end = text;
    return end || !*text ? 0 : -1;
}

int pick_integers(const char *text, uint32_t *numbers, size_t count) {
    double values[4];
    if (count > 4 || pick_numbers(text, values, count, NULL))
        return -1;
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= 0.0 && values[i] <= UINT32_MAX) || floor(values[i]) < values[i])
            return -1;
        numbers[i] = (uint32_t)values[i];
    }
    return 0;
}

int pick_is_linear(const char *path) {
    const char *dot = strrchr(path, '.');
    const char *word = dot ? dot + 1 : path;
    return strcasecmp(word, "exr") == 0 || strcasecmp(word, "sxr") == 0 || strcasecmp(word, "hdr") == 0 ||
           strcasecmp(word, "rgbe") == 0;
}

int pick_is_colour(uint32_t semantic) {
    return semantic == ZT_SEMANTIC_UNSPECIFIED || semantic == ZT_SEMANTIC_BASE_COLOUR ||
           semantic == ZT_SEMANTIC_EMISSIVE;
}

size_t pick_texts(const zt_file *file, img_text texts[PICK_TEXTS]) {
    static const char *const pairs[PICK_TEXTS][2] = {
        {"zt.author", "Artist"}, {"zt.copyright", "Copyright"}, {"zt.title", "ImageDescription"}};
    uint32_t count;
    size_t found = 0;
    if (zt_load_metadata(file, &count, NULL) != ZT_OK)
        return 0;
    for (size_t i = 0; i < PICK_TEXTS; i++) {
        const char *value = zt_find_metadata(file, pairs[i][0]);
        if (value)
            texts[found++] = (img_text){pairs[i][1], value};
    }
    return found;
}
