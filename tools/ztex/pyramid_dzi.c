/* SPDX-License-Identifier: Apache-2.0 */
/* Deep Zoom: NAME.dzi is a piece of XML, NAME_files/LEVEL/COLUMN_ROW.FORMAT are the tiles, the last level the finest. */
#include "pyramid.h"

#include <expat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct descriptor {
    XML_Parser parser;
    pyramid_plan *plan;
    uint32_t tile_size;
    unsigned depth;
    const char *wrong;
} descriptor;

/* The name without the prefix of its namespace. */
static const char *plain(const char *name) {
    const char *colon = strrchr(name, ':');
    return colon ? colon + 1 : name;
}

static uint32_t whole(const char *text) {
    uint64_t value = 0;
    if (!*text)
        return UINT32_MAX;
    for (; *text; text++) {
        if (*text < '0' || *text > '9' || value > UINT32_MAX / 10 - 1)
            return UINT32_MAX;
        value = 10 * value + (uint64_t)(*text - '0');
    }
    return (uint32_t)value;
}

static void stop(descriptor *d, const char *wrong) {
    d->wrong = wrong;
    XML_StopParser(d->parser, XML_FALSE);
}

static void read_image(descriptor *d, const char **pairs) {
    for (; pairs[0]; pairs += 2) {
        if (strcmp(pairs[0], "TileSize") == 0)
            d->tile_size = whole(pairs[1]);
        else if (strcmp(pairs[0], "Overlap") == 0)
            d->plan->overlap = whole(pairs[1]);
        else if (strcmp(pairs[0], "Format") == 0) {
            if (!pyramid_find_extension(pairs[1])) {
                stop(d, "its Format is no kind of picture that is known for tiles");
                return;
            }
            snprintf(d->plan->extension, sizeof d->plan->extension, "%s", pairs[1]); /* as written: JPG stays */
        }
    }
}

static void XMLCALL begin_element(void *user, const char *name, const char **pairs) {
    descriptor *d = user;
    d->depth++;
    if (d->depth == 1 && strcmp(plain(name), "Image") == 0)
        read_image(d, pairs);
    else if (d->depth == 1)
        stop(d, strcmp(plain(name), "Collection") == 0
                    ? "a Deep Zoom collection: give one of its pictures"
                    : "no Deep Zoom descriptor: it begins with something else than Image");
    for (; d->depth == 2 && strcmp(plain(name), "Size") == 0 && pairs[0]; pairs += 2) {
        if (strcmp(pairs[0], "Width") == 0)
            d->plan->width = whole(pairs[1]);
        else if (strcmp(pairs[0], "Height") == 0)
            d->plan->height = whole(pairs[1]);
    }
}

static void XMLCALL end_element(void *user, const char *name) {
    (void)name;
    ((descriptor *)user)->depth--;
}

/* Entities could blow it up. */
static void XMLCALL begin_doctype(void *user, const char *name, const char *system, const char *public, int inside) {
    (void)name, (void)system, (void)public, (void)inside;
    stop(user, "a document type has no place in a descriptor");
}

static int parse(const char *text, size_t size, pyramid_plan *plan, char *error) {
    descriptor d = {.parser = XML_ParserCreate(NULL), .plan = plan};
    if (!d.parser) {
        snprintf(error, IMG_ERROR, "out of memory");
        return -1;
    }
    XML_SetUserData(d.parser, &d);
    XML_SetElementHandler(d.parser, begin_element, end_element);
    XML_SetStartDoctypeDeclHandler(d.parser, begin_doctype);
    int good = XML_Parse(d.parser, text, (int)size, 1) == XML_STATUS_OK;
    if (!good && d.wrong)
        snprintf(error, IMG_ERROR, "%s", d.wrong);
    else if (!good)
        snprintf(error, IMG_ERROR, "line %lu: %s", (unsigned long)XML_GetCurrentLineNumber(d.parser),
                 XML_ErrorString(XML_GetErrorCode(d.parser)));
    XML_ParserFree(d.parser);
    plan->tile_width = plan->tile_height = d.tile_size;
    if (good && !plan->extension[0]) {
        snprintf(error, IMG_ERROR, "the descriptor has no Format");
        return -1;
    }
    return good ? pyramid_check_size(plan, error) : -1;
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
    plan->kind = PYRAMID_DZI;
    plan->shown = slash ? (size_t)(slash + 1 - path) : 0;
    int length = snprintf(plan->folder, sizeof plan->folder, "%.*s_files/", (int)(dot - path), path);
    if (length < 0 || (size_t)length >= sizeof plan->folder) {
        snprintf(error, IMG_ERROR, "the path is too long");
        return -1;
    }
    uint32_t most = plan->width > plan->height ? plan->width : plan->height;
    for (plan->levels = 1; pyramid_reduce(most, plan->levels - 1) > 1;)
        plan->levels++;
    return 0;
}

void pyramid_name_dzi(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size) {
    snprintf(name, size, "%u/%u_%u.%s", (unsigned)(plan->levels - 1 - tile->level), (unsigned)tile->column,
             (unsigned)tile->row, plan->extension);
}
