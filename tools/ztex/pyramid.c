/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles of a pyramid as rows of one picture. */
#include "pyramid.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define TEXT_MOST (UINT32_C(1) << 20) /* bytes of a descriptor */
#define TILE_BYTES (UINT64_C(1) << 30)

static const struct kind {
    const char *descriptor; /* its name, or a dot and its extension */
    const char *format;
    int (*make_plan)(const char *path, pyramid_plan *plan, char *error);
    void (*name_tile)(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size);
} kinds[] = {
    [PYRAMID_DZI] = {".dzi", "deepzoom", pyramid_plan_dzi, pyramid_name_dzi},
    [PYRAMID_IIIF] = {"info.json", "iiif", pyramid_plan_iiif, pyramid_name_iiif},
    [PYRAMID_ZOOMIFY] = {"ImageProperties.xml", "zoomify", pyramid_plan_zoomify, pyramid_name_zoomify},
};

struct pyramid {
    pyramid_plan plan;
    img_info info;
    size_t pixel;
    unsigned char *tile; /* room for the largest one with its overlap */
};

static int fail(char *error, const char *text) {
    snprintf(error, IMG_ERROR, "%s", text);
    return -1;
}

/* ---- for the kinds --------------------------------------------------------------------------------------- */

uint32_t pyramid_reduce(const pyramid_plan *plan, uint32_t size, uint32_t level) {
    uint64_t more = plan->round_down || level > 31 ? 0 : (UINT64_C(1) << level) - 1;
    uint64_t reduced = level > 31 ? 0 : (size + more) >> level;
    return reduced > 0 ? (uint32_t)reduced : 1;
}

char *pyramid_read_text(const char *path, size_t *size, char *error) {
    FILE *stream = fopen(path, "rb");
    char *text = stream ? malloc(TEXT_MOST + 1) : NULL;
    *size = 0;
    if (text)
        *size = fread(text, 1, TEXT_MOST + 1, stream);
    if (!text || ferror(stream) || *size > TEXT_MOST) {
        fail(error, !stream             ? strerror(errno)
                    : !text             ? "out of memory"
                    : *size > TEXT_MOST ? "too long for a descriptor"
                                        : "cannot be read");
        free(text);
        text = NULL;
    } else {
        text[*size] = '\0';
    }
    if (stream)
        fclose(stream);
    return text;
}

/* Descriptors are not in the list, so that no tile is a pyramid in its turn. */
const char *pyramid_find_extension(const char *word) {
    static const char *const known[] = {"jpg", "jpeg", "png", "webp", "tif", "tiff", "gif", "bmp", "jp2", "avif"};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (strcasecmp(word, known[i]) == 0)
            return known[i];
    return NULL;
}

int pyramid_check_size(const pyramid_plan *plan, char *error) {
    if (plan->width < 1 || plan->height < 1 || plan->width > PYRAMID_SIDE || plan->height > PYRAMID_SIDE)
        return fail(error, "the descriptor gives no usable width and height");
    if (plan->tile_width < 1 || plan->tile_height < 1 || plan->tile_width > PYRAMID_TILE ||
        plan->tile_height > PYRAMID_TILE)
        return fail(error, "the descriptor gives no usable size of tiles");
    if (plan->overlap > plan->tile_width || plan->overlap > plan->tile_height)
        return fail(error, "the overlap is larger than the tiles");
    return 0;
}

int pyramid_tile_path(const pyramid_plan *plan, const pyramid_tile *tile, char *path) {
    char name[256];
    kinds[plan->kind].name_tile(plan, tile, name, sizeof name);
    int length = snprintf(path, PYRAMID_PATH, "%s%s", plan->folder, name);
    return length > 0 && length < PYRAMID_PATH ? 0 : -1;
}

int pyramid_take_folder(const char *path, pyramid_plan *plan, char *error) {
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash + 1 - path) : 0;
    if (length >= sizeof plan->folder)
        return fail(error, "the path is too long");
    memcpy(plan->folder, path, length);
    plan->folder[length] = '\0';
    plan->shown = length;
    return 0;
}

int pyramid_find_tile(pyramid_plan *plan, const pyramid_tile *tile, unsigned namings, char *error) {
    static const char *const extensions[] = {"jpg", "png", "webp", "tif", "gif", "jp2"};
    char path[PYRAMID_PATH];
    struct stat status;
    for (unsigned i = 0; i < namings * sizeof extensions / sizeof extensions[0]; i++) {
        plan->naming = i % namings;
        snprintf(plan->extension, sizeof plan->extension, "%s", extensions[i / namings]);
        if (pyramid_tile_path(plan, tile, path) == 0 && stat(path, &status) == 0)
            return 0;
    }
    plan->naming = 0;
    snprintf(plan->extension, sizeof plan->extension, "jpg");
    if (pyramid_tile_path(plan, tile, path))
        return fail(error, "the names of the tiles are too long");
    snprintf(error, IMG_ERROR,
             "there is no first tile, such as %.120s: only folders with all tiles as files can be read, not servers",
             path + plan->shown);
    return -1;
}

/* ---- tiles ---------------------------------------------------------------------------------------------------- */

static pyramid_tile tile_at(const pyramid_plan *plan, uint32_t level, uint32_t column, uint32_t row) {
    uint32_t width = pyramid_reduce(plan, plan->width, level), height = pyramid_reduce(plan, plan->height, level);
    pyramid_tile t = {.level = level, .column = column, .row = row};
    t.x = column * plan->tile_width;
    t.y = row * plan->tile_height;
    t.width = width - t.x < plan->tile_width ? width - t.x : plan->tile_width;
    t.height = height - t.y < plan->tile_height ? height - t.y : plan->tile_height;
    return t;
}

static int fail_tile(const pyramid_plan *plan, const char *path, const char *text, char *error) {
    snprintf(error, IMG_ERROR, "tile %.90s: %.150s", path + plan->shown, text);
    return -1;
}

/* NULL with error. path: PYRAMID_PATH bytes, filled in. */
static img_reader *open_tile(const pyramid_plan *plan, const pyramid_tile *tile, char *path, char *error) {
    char text[IMG_ERROR];
    const img_open_options options = {.keep_orientation = 1};
    struct stat status;
    if (pyramid_tile_path(plan, tile, path)) {
        fail(error, "the names of the tiles are too long");
        return NULL;
    }
    if (stat(path, &status) != 0) {
        fail_tile(plan, path, errno == ENOENT ? "the file is missing" : strerror(errno), error);
        return NULL;
    }
    img_reader *reader = img_open(path, &options, text);
    if (!reader)
        fail_tile(plan, path, text, error);
    return reader;
}

static uint32_t overlap_before(const pyramid_plan *plan, uint32_t index) {
    return index > 0 ? plan->overlap : 0;
}

static uint32_t overlap_behind(const pyramid_plan *plan, uint64_t end, uint32_t size) {
    return size - end < plan->overlap ? (uint32_t)(size - end) : plan->overlap;
}

/* The tile with its overlap: how large the file has to be. */
static void stored_size(const pyramid_plan *plan, const pyramid_tile *t, uint32_t *width, uint32_t *height) {
    *width = overlap_before(plan, t->column) + t->width +
             overlap_behind(plan, (uint64_t)t->x + t->width, pyramid_reduce(plan, plan->width, t->level));
    *height = overlap_before(plan, t->row) + t->height +
              overlap_behind(plan, (uint64_t)t->y + t->height, pyramid_reduce(plan, plan->height, t->level));
}

static int check_tile(const pyramid *p, const pyramid_tile *tile, const img_info *info, const char *path, char *error) {
    char text[IMG_ERROR];
    uint32_t width, height;
    stored_size(&p->plan, tile, &width, &height);
    if (info->width != width || info->height != height || info->depth != 1)
        snprintf(text, sizeof text, "%u x %u pixels, where the descriptor wants %u x %u", (unsigned)info->width,
                 (unsigned)info->height, (unsigned)width, (unsigned)height);
    else if (info->channels != p->info.channels || info->alpha_channel != p->info.alpha_channel)
        snprintf(text, sizeof text, "%u channels, but the first tile has %u", (unsigned)info->channels,
                 (unsigned)p->info.channels);
    else
        return 0;
    return fail_tile(&p->plan, path, text, error);
}

/* What the tile shows, without overlap, into rows that are pitch bytes apart. */
static int copy_tile(pyramid *p, const pyramid_tile *tile, unsigned char *dst, size_t pitch, char *error) {
    char path[PYRAMID_PATH], text[IMG_ERROR];
    uint32_t left = overlap_before(&p->plan, tile->column), top = overlap_before(&p->plan, tile->row);
    img_reader *reader = open_tile(&p->plan, tile, path, error);
    if (!reader)
        return -1;
    const img_info *info = img_get_info(reader);
    size_t row = (size_t)info->width * p->pixel;
    int status = check_tile(p, tile, info, path, error);
    if (status == 0 && img_read_rows(reader, 0, 0, info->height, 0, p->info.type, p->tile, 0, text))
        status = fail_tile(&p->plan, path, text, error);
    for (uint32_t y = 0; status == 0 && y < tile->height; y++)
        memcpy(dst + y * pitch, p->tile + (top + y) * row + left * p->pixel, tile->width * p->pixel);
    img_close(reader);
    return status;
}

int pyramid_read(pyramid *p, uint32_t level, uint32_t tile_row, void *dst, char *error) {
    uint32_t width = pyramid_reduce(&p->plan, p->plan.width, level);
    unsigned char *to = dst;
    for (uint32_t x = 0, column = 0; x < width; column++) {
        pyramid_tile tile = tile_at(&p->plan, level, column, tile_row);
        if (copy_tile(p, &tile, to + x * p->pixel, width * p->pixel, error))
            return -1;
        x += tile.width;
    }
    return 0;
}

/* ---- opening ---------------------------------------------------------------------------------------------------- */

/* NULL: a picture of another kind. */
static const struct kind *find_kind(const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const char *wanted = kinds[i].descriptor;
        if (strcasecmp(wanted[0] == '.' && dot ? dot : name, wanted) == 0)
            return &kinds[i];
    }
    return NULL;
}

int pyramid_is(const char *path) {
    return find_kind(path) != NULL;
}

static int open_first(pyramid *p, char *error) {
    char path[PYRAMID_PATH];
    pyramid_tile first = tile_at(&p->plan, 0, 0, 0);
    img_reader *reader = open_tile(&p->plan, &first, path, error);
    if (!reader)
        return -1;
    p->info = *img_get_info(reader);
    int status = check_tile(p, &first, &p->info, path, error);
    img_close(reader);
    if (status)
        return status;
    p->pixel = p->info.channels * img_type_size(p->info.type);
    uint64_t width = (uint64_t)first.width + 2 * (uint64_t)p->plan.overlap;
    uint64_t height = (uint64_t)first.height + 2 * (uint64_t)p->plan.overlap;
    if (width * height > TILE_BYTES / p->pixel)
        return fail(error, "the tiles are too large to be held in memory");
    p->tile = malloc((size_t)(width * height) * p->pixel);
    if (!p->tile)
        return fail(error, "out of memory");
    p->info.full_width = p->plan.width;
    p->info.full_height = p->plan.height;
    p->info.orientation = 1;
    p->info.subimages = p->info.levels = 1;
    snprintf(p->info.format, sizeof p->info.format, "%s", kinds[p->plan.kind].format);
    return 0;
}

pyramid *pyramid_open(const char *path, char *error) {
    pyramid *p = calloc(1, sizeof *p);
    if (!p) {
        fail(error, "out of memory");
        return NULL;
    }
    const struct kind *kind = find_kind(path);
    p->plan.kind = (pyramid_kind)(kind - kinds);
    int status = kind->make_plan(path, &p->plan, error);
    if (status == 0)
        status = open_first(p, error);
    if (status == 0)
        return p;
    pyramid_close(p);
    return NULL;
}

void pyramid_close(pyramid *p) {
    if (!p)
        return;
    free(p->tile);
    free(p);
}

const img_info *pyramid_info(const pyramid *p) {
    return &p->info;
}

uint32_t pyramid_levels(const pyramid *p) {
    return p->plan.levels;
}

void pyramid_size(const pyramid *p, uint32_t level, uint32_t *width, uint32_t *height) {
    *width = pyramid_reduce(&p->plan, p->plan.width, level);
    *height = pyramid_reduce(&p->plan, p->plan.height, level);
}

uint32_t pyramid_tile_height(const pyramid *p) {
    return p->plan.tile_height;
}
