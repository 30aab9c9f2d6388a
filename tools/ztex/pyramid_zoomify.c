/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Zoomify: ImageProperties.xml, and TileGroupN/LEVEL-COLUMN-ROW.jpg beside it, level 0 being one tile. A group has 256
 * tiles, counted from the coarsest level on. Programs do not agree on how odd sizes are halved; the number of all tiles
 * and the coarsest one tell.
 */
#include "pyramid.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GROUP = 256, NO_TOTAL = UINT32_MAX };

typedef struct properties {
    pyramid_plan *plan;
    uint32_t total; /* of tiles */
} properties;

static const char *read_element(void *user, unsigned depth, const char *name, const char **pairs) {
    properties *p = user;
    if (depth == 0 && strcmp(name, "IMAGE_PROPERTIES") != 0)
        return "no Zoomify descriptor: it begins with something else than IMAGE_PROPERTIES";
    for (; depth == 0 && pairs[0]; pairs += 2) {
        if (strcmp(pairs[0], "WIDTH") == 0)
            p->plan->width = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "HEIGHT") == 0)
            p->plan->height = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "TILESIZE") == 0)
            p->plan->tile_width = p->plan->tile_height = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "NUMTILES") == 0)
            p->total = pyramid_whole(pairs[1]);
    }
    return NULL;
}

/* ---- levels ------------------------------------------------------------------------------------------------- */

static uint64_t columns_of(const pyramid_plan *plan, uint32_t level) {
    uint32_t width = pyramid_reduce(plan, plan->width, level);
    return (width + (uint64_t)plan->tile_width - 1) / plan->tile_width;
}

static uint64_t tiles_of(const pyramid_plan *plan, uint32_t level) {
    uint32_t height = pyramid_reduce(plan, plan->height, level);
    return columns_of(plan, level) * ((height + (uint64_t)plan->tile_height - 1) / plan->tile_height);
}

/* Tiles of the levels that are coarser. */
static uint64_t tiles_before(const pyramid_plan *plan, uint32_t level) {
    uint64_t sum = 0;
    while (++level < plan->levels)
        sum += tiles_of(plan, level);
    return sum;
}

/* Levels down to the first that is one tile. Returns how many tiles they have. */
static uint64_t count_levels(pyramid_plan *plan, int round_down) {
    plan->round_down = round_down;
    for (plan->levels = 1; tiles_of(plan, plan->levels - 1) > 1;)
        plan->levels++;
    return tiles_before(plan, 0) + tiles_of(plan, 0);
}

/* Whether the coarsest level has the size that it should have. */
static int fits_coarsest(const pyramid_plan *plan) {
    char path[PYRAMID_PATH], error[IMG_ERROR];
    const pyramid_tile tile = {.level = plan->levels - 1};
    const img_open_options options = {.keep_orientation = 1};
    img_reader *reader = pyramid_tile_path(plan, &tile, path) == 0 ? img_open(path, &options, error) : NULL;
    int fits = reader && img_get_info(reader)->width == pyramid_reduce(plan, plan->width, tile.level) &&
               img_get_info(reader)->height == pyramid_reduce(plan, plan->height, tile.level);
    img_close(reader);
    return fits;
}

static int find_levels(pyramid_plan *plan, uint32_t total, char *error) {
    uint64_t down = count_levels(plan, 1);
    if ((total == NO_TOTAL || total == down) && fits_coarsest(plan))
        return 0;
    uint64_t up = count_levels(plan, 0);
    if (total == NO_TOTAL || total == up)
        return 0;
    count_levels(plan, 1);
    if (total == down)
        return 0;
    snprintf(error, IMG_ERROR, "it counts %u tiles, but a picture of %u x %u in tiles of %u has %llu", (unsigned)total,
             (unsigned)plan->width, (unsigned)plan->height, (unsigned)plan->tile_width, (unsigned long long)up);
    return -1;
}

/* ---- for pyramid.c ------------------------------------------------------------------------------------------ */

static int read_plan(const char *path, pyramid_plan *plan, uint32_t *total, char *error) {
    properties p = {.plan = plan, .total = NO_TOTAL};
    size_t size;
    char *text = pyramid_read_text(path, &size, error);
    int status = text ? pyramid_parse_xml(text, size, read_element, &p, error) : -1;
    free(text);
    *total = p.total;
    if (status == 0)
        status = pyramid_check_size(plan, error);
    return status == 0 ? pyramid_take_folder(path, plan, error) : status;
}

int pyramid_plan_zoomify(const char *path, pyramid_plan *plan, char *error) {
    uint32_t total;
    if (read_plan(path, plan, &total, error))
        return -1;
    /* The extension is nowhere written; the coarsest tile is always in the first group. */
    count_levels(plan, 0);
    const pyramid_tile coarsest = {.level = plan->levels - 1};
    return pyramid_find_tile(plan, &coarsest, 1, error) ? -1 : find_levels(plan, total, error);
}

void pyramid_name_zoomify(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size) {
    uint64_t number = tiles_before(plan, tile->level) + tile->row * columns_of(plan, tile->level) + tile->column;
    snprintf(name, size, "TileGroup%llu/%u-%u-%u.%s", (unsigned long long)(number / GROUP),
             (unsigned)(plan->levels - 1 - tile->level), (unsigned)tile->column, (unsigned)tile->row, plan->extension);
}
