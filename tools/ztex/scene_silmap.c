/* SPDX-License-Identifier: Apache-2.0 */
/* Silmaps in a scene: the member "silmap" of a texture. */
#include <string.h>

#include "scene.h"
#include "silmap.h"

/* A number of cells along the longer side, or [along x, along y]. */
static int read_cells(make_scene *scene, const json_t *object, const char *pointer, make_silmap *silmap) {
    const json_t *value = json_object_get(object, "cells");
    const char *at = make_string(scene, "%s/cells", pointer);
    uint32_t pair[2];
    if (!at || !value)
        return at ? CMD_OK : CMD_INTERNAL;
    if (!json_is_array(value))
        return scene_whole(scene, value, at, 1, SILMAP_CELLS_MOST, &silmap->longer);
    int status = scene_wholes(scene, value, at, 2, SILMAP_CELLS_MOST, pair);
    if (status == CMD_OK && (pair[0] == 0 || pair[1] == 0))
        return make_complain(scene, at, "no cells are too few");
    silmap->cells_x = status == CMD_OK ? pair[0] : 0;
    silmap->cells_y = status == CMD_OK ? pair[1] : 0;
    return status;
}

static int read_quality(make_scene *scene, const json_t *object, const char *pointer, make_silmap *silmap) {
    const json_t *value = json_object_get(object, "quality");
    const char *at = make_string(scene, "%s/quality", pointer);
    if (!at || !value)
        return at ? CMD_OK : CMD_INTERNAL;
    if (!json_is_number(value))
        return scene_wrong_type(scene, at, value, "a number");
    silmap->quality = json_number_value(value);
    if (!(silmap->quality > 0 && silmap->quality < 1000))
        return make_complain(scene, at, "%g is no number of dB above 0", silmap->quality);
    return CMD_OK;
}

/* The name of a file that is no picture, through what reads those of pictures. */
static int read_file(make_scene *scene, const json_t *object, const char *pointer, const char *name,
                     const make_options *defaults, const make_image **out) {
    const json_t *value = json_object_get(object, name);
    const char *at = make_string(scene, "%s/%s", pointer, name);
    if (!at || !value)
        return at ? CMD_OK : CMD_INTERNAL;
    return scene_image(scene, value, at, defaults, out);
}

/* "file" is what is fitted, or "font" and "text". */
static int read_source(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                       make_texture *texture, make_silmap *silmap) {
    const json_t *text = json_object_get(object, "text");
    const char *at = make_string(scene, "%s/text", pointer);
    const make_image *edges = NULL;
    int font = json_object_get(object, "font") != NULL;
    if (!at)
        return CMD_INTERNAL;
    if (font == (json_object_get(object, "file") != NULL))
        return make_complain(scene, pointer, "either 'file' or 'font' is wanted here");
    if (font != (text != NULL))
        return make_complain(scene, pointer, "'font' and 'text' go together");
    int status = read_file(scene, object, pointer, font ? "font" : "file", defaults, &texture->images[0]);
    if (status == CMD_OK && font)
        status = scene_text(scene, text, at, &silmap->text);
    if (status == CMD_OK && font && silmap->text[0] == '\0')
        return make_complain(scene, at, "there is no character in it");
    if (status == CMD_OK)
        status = read_file(scene, object, pointer, "edges", defaults, &edges);
    if (status == CMD_OK && (font ? texture->images[0]->file_count > 1 : edges && edges->file_count > 1))
        return make_complain(scene, pointer, "'font' and 'edges' are one file each; frames are those of 'file'");
    if (status == CMD_OK && edges && font)
        return make_complain(scene, pointer, "glyphs have edges of their own: 'edges' is for pictures");
    silmap->edges = edges ? edges->files[0].path : NULL;
    return status;
}

static int read_options(make_scene *scene, const json_t *object, const char *pointer, make_silmap *silmap) {
    int filter = 0, mask = silmap->text ? SILMAP_ALPHA - 1 : -1, minified = 1;
    int status = read_cells(scene, object, pointer, silmap);
    if (status == CMD_OK)
        status = read_quality(scene, object, pointer, silmap);
    if (status == CMD_OK)
        status = scene_member_word(scene, object, pointer, "filter", "continuous|sen2004|nearest", &filter);
    if (status == CMD_OK)
        status = scene_member_word(scene, object, pointer, "mask", "alpha|brightness", &mask);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "edges_only", &silmap->edges_only);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "hint", &silmap->hint);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "minified", &minified);
    silmap->filter = (zt_silmap_filter)filter;
    silmap->mask = (silmap_mask)(mask + 1);
    silmap->no_minified = !minified;
    if (status == CMD_OK && silmap->edges_only && !silmap->edges)
        return make_complain(scene, pointer, "'edges_only' goes with 'edges'");
    return status;
}

/* "layers" has those behind the first. */
static int read_layers(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                       make_texture *texture) {
    const json_t *layers = json_object_get(object, "layers");
    const char *key, *at = make_string(scene, "%s/layers", pointer);
    json_t *value;
    make_options plain = *defaults;
    plain.format = 0;
    if (!at || !layers)
        return at ? CMD_OK : CMD_INTERNAL;
    if (!json_is_object(layers))
        return scene_wrong_type(scene, at, layers, "an object");
    json_object_foreach((json_t *)(uintptr_t)layers, key, value) {
        int status = scene_layer(scene, value, at, key, &plain, texture, texture->images);
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

int scene_silmap(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                 make_texture *texture) {
    static const char *const known[] = {"file",    "font",   "text", "edges",    "edges_only", "hint", "cells",
                                        "quality", "filter", "mask", "minified", "layers",     NULL};
    make_silmap *silmap = make_alloc(scene, 1, sizeof *silmap);
    if (!silmap)
        return CMD_INTERNAL;
    if (!json_is_object(value))
        return scene_wrong_type(scene, pointer, value, "an object");
    int status = scene_check_keys(scene, value, pointer, known);
    if (status == CMD_OK)
        status = read_source(scene, value, pointer, defaults, texture, silmap);
    if (status == CMD_OK)
        status = read_options(scene, value, pointer, silmap);
    texture->silmap = silmap;
    texture->layer_count = 1;
    texture->semantics[0] = silmap->mask == SILMAP_COLOURS ? ZT_SEMANTIC_BASE_COLOUR : ZT_SEMANTIC_OPACITY;
    return status == CMD_OK ? read_layers(scene, value, pointer, defaults, texture) : status;
}
