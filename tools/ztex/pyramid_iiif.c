/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Static folders of the IIIF Image API, level 0, versions 1 to 3: info.json, and files
 * REGION/SIZE/ROTATION/QUALITY.FORMAT beside it. How a folder writes regions and sizes depends on the version and on
 * who made it; the first tile tells.
 */
#include "pyramid.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* naming = whole + 2 * size + 8 * quality */
enum { SIZES = 4, QUALITIES = 3, NAMINGS = 2 * SIZES * QUALITIES };

static const char *const qualities[QUALITIES] = {"default", "native", "color"};

static uint32_t number_of(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    json_int_t number = json_is_integer(value) ? json_integer_value(value) : 0;
    return number > 0 && number <= (json_int_t)PYRAMID_SIDE ? (uint32_t)number : 0;
}

/* How many of the scale factors 1, 2, 4 ... are there. */
static uint32_t count_levels(const json_t *factors) {
    uint32_t levels = 0;
    for (size_t i = 0; i <= json_array_size(factors) && levels < 31; i++) {
        size_t k = 0;
        while (k < json_array_size(factors) && json_integer_value(json_array_get(factors, k)) != (json_int_t)1
                                                                                                     << levels)
            k++;
        if (k == json_array_size(factors))
            break;
        levels++;
    }
    return levels;
}

/* Versions 2 and 3 list tiles; version 1 has one size for all. Without either the picture is one file. */
static int read_tiles(const json_t *root, pyramid_plan *plan, char *error) {
    const json_t *tiles = json_object_get(root, "tiles");
    const json_t *tile = json_is_array(tiles) && json_array_size(tiles) > 0 ? json_array_get(tiles, 0) : NULL;
    const json_t *factors = json_object_get(tile ? tile : root, tile ? "scaleFactors" : "scale_factors");
    plan->tile_width = number_of(tile ? tile : root, tile ? "width" : "tile_width");
    plan->tile_height = number_of(tile ? tile : root, tile ? "height" : "tile_height");
    if (plan->tile_width == 0 && !tile) {
        plan->tile_width = plan->width;
        plan->tile_height = plan->height;
        plan->levels = 1;
        return 0;
    }
    if (plan->tile_height == 0)
        plan->tile_height = plan->tile_width;
    plan->levels = count_levels(factors);
    if (plan->levels > 0)
        return 0;
    snprintf(error, IMG_ERROR, "no tiles of the full size: the scale factor 1 is not in the list");
    return -1;
}

static int read_root(const json_t *root, pyramid_plan *plan, char *error) {
    plan->width = number_of(root, "width");
    plan->height = number_of(root, "height");
    if (!json_is_object(root) || !plan->width || !plan->height) {
        snprintf(error, IMG_ERROR,
                 "no IIIF image: width and height are wanted (a scene must have another name than "
                 "info.json)");
        return -1;
    }
    return read_tiles(root, plan, error) ? -1 : pyramid_check_size(plan, error);
}

static int find_naming(pyramid_plan *plan, char *error) {
    const pyramid_tile first = {
        .width = plan->width < plan->tile_width ? plan->width : plan->tile_width,
        .height = plan->height < plan->tile_height ? plan->height : plan->tile_height,
    };
    /* It cannot tell how a level of one tile is written, unless it is one itself. */
    while (plan->levels > 1 && pyramid_reduce(plan, plan->width, plan->levels - 1) <= plan->tile_width &&
           pyramid_reduce(plan, plan->height, plan->levels - 1) <= plan->tile_height)
        plan->levels--;
    return pyramid_find_tile(plan, &first, NAMINGS, error);
}

int pyramid_plan_iiif(const char *path, pyramid_plan *plan, char *error) {
    size_t size;
    char *text = pyramid_read_text(path, &size, error);
    json_error_t trouble;
    if (!text)
        return -1;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &trouble);
    free(text);
    if (!root) {
        snprintf(error, IMG_ERROR, "line %d: %.160s", trouble.line, trouble.text);
        return -1;
    }
    int status = read_root(root, plan, error);
    json_decref(root);
    if (status || pyramid_take_folder(path, plan, error))
        return -1;
    return find_naming(plan, error);
}

void pyramid_name_iiif(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size) {
    unsigned way = plan->naming / 2 % SIZES;
    uint64_t scale = UINT64_C(1) << tile->level, x = tile->x * scale, y = tile->y * scale;
    uint64_t width = (uint64_t)tile->width * scale, height = (uint64_t)tile->height * scale;
    char region[64], wanted[32];
    if (width > plan->width - x)
        width = plan->width - x;
    if (height > plan->height - y)
        height = plan->height - y;
    int whole = width == plan->width && height == plan->height;
    snprintf(region, sizeof region, "%llu,%llu,%llu,%llu", (unsigned long long)x, (unsigned long long)y,
             (unsigned long long)width, (unsigned long long)height);
    if (whole && plan->naming % 2 == 0)
        snprintf(region, sizeof region, "full");
    /* Version 3 writes both numbers, version 2 the width alone, and each has a word for the full size. */
    if (way == 0 || (way > 1 && (!whole || tile->level > 0)))
        snprintf(wanted, sizeof wanted, "%u,%u", (unsigned)tile->width, (unsigned)tile->height);
    else if (way == 1)
        snprintf(wanted, sizeof wanted, "%u,", (unsigned)tile->width);
    else
        snprintf(wanted, sizeof wanted, "%s", way == 2 ? "max" : "full");
    snprintf(name, size, "%s/%s/0/%s.%s", region, wanted, qualities[plan->naming / 8 % QUALITIES], plan->extension);
}
