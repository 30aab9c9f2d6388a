/* SPDX-License-Identifier: Apache-2.0 */
/* A heap of photographs: their sizes, their names, their texels for the registration, and the maps that go with
 * them. */
#include "heap.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "load_linear.h"
#include "make_author.h"
#include "module.h"

/* ---- names and sizes -------------------------------------------------------------------------------------- */

/* The name between folder and extension: where it begins, and its length. */
static const char *stem_of(const char *path, size_t *length) {
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    *length = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    return base;
}

static int is_taken(const heap *h, size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (strcmp(h->photos[i].name, name) == 0)
            return 1;
    return 0;
}

/* Photographs of two cameras may have one name; the later one gets a number. */
static const char *unique_name(heap *h, size_t index) {
    size_t length;
    const char *stem = stem_of(h->photos[index].path, &length);
    const char *name = make_string(&h->memory, "%.*s", (int)length, stem);
    for (unsigned number = 2; name && is_taken(h, index, name); number++)
        name = make_string(&h->memory, "%.*s-%u", (int)length, stem, number);
    return name;
}

int heap_open_photos(heap *h) {
    char error[IMG_ERROR];
    h->count = h->args->operand_count;
    h->photos = make_alloc(&h->memory, h->count, sizeof *h->photos);
    if (!h->photos)
        return CMD_INTERNAL;
    for (size_t i = 0; i < h->count; i++) {
        heap_photo *photo = &h->photos[i];
        photo->path = h->args->operands[i];
        if (strcmp(photo->path, "-") == 0)
            return cmd_usage(h->args, "photographs are files: standard input cannot be one");
        img_reader *reader = img_open(photo->path, NULL, error);
        if (!reader)
            return cmd_fail(CMD_IO, "%s: %s", photo->path, error);
        photo->width = img_get_info(reader)->width;
        photo->height = img_get_info(reader)->height;
        img_close(reader);
        photo->name = unique_name(h, i);
        if (!photo->name)
            return CMD_INTERNAL;
    }
    return CMD_OK;
}

/* ---- registration ------------------------------------------------------------------------------------------- */

static author_result load(void *user, size_t index, uint64_t max_texels, author_picture *out, char *error) {
    const heap *h = user;
    char text[IMG_ERROR];
    author_result result = load_linear(h->photos[index].path, max_texels, out, text);
    if (result != AUTHOR_OK)
        snprintf(error, AUTHOR_ERROR, "%s: %s", h->photos[index].path, text);
    return result;
}

int heap_register(heap *h) {
    char error[MODULE_ERROR];
    make_stages stages;
    author_run run = make_author_run(h->args, &stages);
    const author_vision *vision = module_load(AUTHOR_VISION_FILE, AUTHOR_VISION_SYMBOL, error);
    if (!vision)
        return cmd_fail(CMD_INTERNAL, "%s", error);
    author_photo *list = make_alloc(&h->memory, h->count, sizeof *list);
    if (!list)
        return CMD_INTERNAL;
    for (size_t i = 0; i < h->count; i++)
        list[i] = (author_photo){h->photos[i].path, h->photos[i].width, h->photos[i].height};
    author_photos photos = {.photos = list, .count = h->count, .load = load, .user = h};
    author_register_options options = {.size = sizeof options,
                                       .memory = cmd_limits(h->args)->memory,
                                       .candidates = (uint32_t)cmd_integer(h->args, "candidates")};
    author_result result = author_register(&run, vision, &photos, &options, &h->found);
    make_stages_end(&stages);
    return make_author_status(result, &run);
}

/* ---- maps that go with the photographs ---------------------------------------------------------------------- */

static int is_folder(const char *path) {
    struct stat facts;
    return stat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
}

/* The one file in folder that is called like the photograph, whatever its extension. */
static int find_in_folder(heap *h, const char *folder, const char *stem, size_t length, const char **out) {
    DIR *list = opendir(folder);
    const struct dirent *entry;
    int found = 0;
    *out = NULL;
    while (list && (entry = readdir(list)) != NULL) {
        size_t own;
        stem_of(entry->d_name, &own);
        if (own != length || strncmp(entry->d_name, stem, length) != 0)
            continue;
        *out = make_string(&h->memory, "%s/%s", folder, entry->d_name);
        found++;
    }
    if (list)
        closedir(list);
    if (found == 1)
        return *out ? CMD_OK : CMD_INTERNAL;
    return cmd_fail(CMD_IO, "%s: %s picture called %.*s is there", folder, found ? "more than one" : "no", (int)length,
                    stem);
}

/* '%' is the photograph's name; a pattern without a folder is beside the photograph. */
static int expand(heap *h, const char *pattern, const char *path, const char **out) {
    size_t length;
    const char *stem = stem_of(path, &length);
    const char *percent = strchr(pattern, '%');
    if (is_folder(pattern))
        return find_in_folder(h, pattern, stem, length, out);
    int beside = strchr(pattern, '/') ? 0 : (int)(stem - path);
    *out = make_string(&h->memory, "%.*s%.*s%.*s%s", beside, path, (int)(percent - pattern), pattern, (int)length, stem,
                       percent + 1);
    return *out ? CMD_OK : CMD_INTERNAL;
}

static int find_layer(heap *h, const char *word) {
    const char *equals = strchr(word, '=');
    char name[64];
    snprintf(name, sizeof name, "%.*s", equals ? (int)(equals - word) : 0, word);
    int semantic = cmd_semantic_number(name);
    const char *pattern = equals ? equals + 1 : "";
    if (!equals || semantic < 0 || semantic == ZT_SEMANTIC_BASE_COLOUR ||
        (!is_folder(pattern) && !strchr(pattern, '%')))
        return cmd_usage(h->args,
                         "--layer: '%s' is not SEMANTIC=PATTERN, such as normal=%%_normal.png, where %% is the "
                         "photograph's name, or SEMANTIC=FOLDER",
                         word);
    if (h->layer_count + 1 == MAKE_LAYERS)
        return cmd_usage(h->args, "--layer: a texture has at most %d layers", MAKE_LAYERS);
    const char **paths = make_alloc(&h->memory, h->count, sizeof *paths);
    int status = paths ? CMD_OK : CMD_INTERNAL;
    for (size_t i = 0; status == CMD_OK && i < h->count; i++)
        if (h->found.placings[i].state != AUTHOR_UNPLACED)
            status = expand(h, pattern, h->photos[i].path, &paths[i]);
    h->layers[h->layer_count++] = (heap_layer){cmd_semantic_name((uint32_t)semantic), paths};
    return status;
}

int heap_find_layers(heap *h) {
    int status = CMD_OK;
    for (int i = 0; status == CMD_OK && i < cmd_given(h->args, "layer"); i++)
        status = find_layer(h, cmd_text_at(h->args, "layer", (size_t)i));
    return status;
}
