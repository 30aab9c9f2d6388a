/* SPDX-License-Identifier: Apache-2.0 */
/* Deep Zoom: NAME.dzi is a piece of XML, NAME_files/LEVEL/COLUMN_ROW.FORMAT are the tiles, the last level the
 * finest. */
#include "pyramid.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *read_image(pyramid_plan *plan, const char **pairs) {
    for (; pairs[0]; pairs += 2) {
        if (strcmp(pairs[0], "TileSize") == 0)
            plan->tile_width = plan->tile_height = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "Overlap") == 0)
            plan->overlap = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "Format") == 0) {
            if (!pyramid_find_extension(pairs[1]))
                return "its Format is no kind of picture that is known for tiles";
            snprintf(plan->extension, sizeof plan->extension, "%s", pairs[1]); /* as written: JPG stays */
        }
    }
    return NULL;
}

static const char *read_element(void *user, unsigned depth, const char *name, const char **pairs) {
    pyramid_plan *plan = user;
    if (depth == 0 && strcmp(name, "Image") == 0)
        return read_image(plan, pairs);
    if (depth == 0)
        return strcmp(name, "Collection") == 0 ? "a Deep Zoom collection: give one of its pictures"
                                               : "no Deep Zoom descriptor: it begins with something else than Image";
    for (; depth == 1 && strcmp(name, "Size") == 0 && pairs[0]; pairs += 2) {
        if (strcmp(pairs[0], "Width") == 0)
            plan->width = pyramid_whole(pairs[1]);
        else if (strcmp(pairs[0], "Height") == 0)
            plan->height = pyramid_whole(pairs[1]);
    }
    return NULL;
}

static int parse(const char *text, size_t size, pyramid_plan *plan, char *error) {
    if (pyramid_parse_xml(text, size, read_element, plan, error))
        return -1;
    if (!plan->extension[0]) {
        snprintf(error, IMG_ERROR, "the descriptor has no Format");
        return -1;
    }
    return pyramid_check_size(plan, error);
}

int pyramid_plan_dzi(const char *path, pyramid_plan *plan, char *error) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    size_t size;
    char *text = pyramid_read_text(path, &size, error);
    if (!text)
        return -1;
    int status = parse(text, size, plan, error);
    free(text);
    if (status)
        return status;
    plan->shown = slash ? (size_t)(slash + 1 - path) : 0;
    int length = snprintf(plan->folder, sizeof plan->folder, "%.*s_files/", (int)(dot - path), path);
    if (length < 0 || (size_t)length >= sizeof plan->folder) {
        snprintf(error, IMG_ERROR, "the path is too long");
        return -1;
    }
    uint32_t most = plan->width > plan->height ? plan->width : plan->height;
    for (plan->levels = 1; pyramid_reduce(plan, most, plan->levels - 1) > 1;)
        plan->levels++;
    return 0;
}

void pyramid_name_dzi(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size) {
    snprintf(name, size, "%u/%u_%u.%s", (unsigned)(plan->levels - 1 - tile->level), (unsigned)tile->column,
             (unsigned)tile->row, plan->extension);
}
