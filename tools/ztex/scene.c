/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a scene file: textures, layers, patches. docs/scene.md describes it, scene.schema.json is its schema. */
#include "scene.h"

#include <author_adjust.h>
#include <stdlib.h>
#include <string.h>

/* ---- layers ------------------------------------------------------------------------------------------ */

static int read_layers(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                       make_texture *texture, const make_image **images) {
    const char *key;
    json_t *value;
    texture->layer_count = 0;
    if (!json_is_object(object) || json_object_size(object) == 0)
        return make_complain(scene, pointer,
                             "an object is wanted here: a semantic, such as base_colour, and its "
                             "image for each layer");
    json_object_foreach((json_t *)(uintptr_t)object, key, value) {
        int status = scene_layer(scene, value, pointer, key, defaults, texture, images);
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

/* "image" (one layer of base colour, or what "semantic" says) or "layers". */
static int read_sources(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                        make_texture *texture, const make_image **images) {
    const json_t *image = json_object_get(object, "image");
    const json_t *layers = json_object_get(object, "layers");
    const char *at = make_string(scene, "%s/%s", pointer, image ? "image" : "layers");
    if (!at)
        return CMD_INTERNAL;
    if (!image == !layers)
        return make_complain(scene, pointer, "either 'image' or 'layers' is wanted here");
    if (layers)
        return read_layers(scene, layers, at, defaults, texture, images);
    texture->layer_count = 1;
    texture->semantics[0] = ZT_SEMANTIC_BASE_COLOUR;
    return scene_image(scene, image, at, defaults, &images[0]);
}

static int read_semantic(make_scene *scene, const json_t *object, const char *pointer, make_texture *texture) {
    const json_t *value = json_object_get(object, "semantic");
    const char *text;
    if (!value)
        return CMD_OK;
    const char *at = make_string(scene, "%s/semantic", pointer);
    int status = at ? scene_text(scene, value, at, &text) : CMD_INTERNAL;
    if (status != CMD_OK)
        return status;
    int number = cmd_semantic_number(text);
    if (number < 0)
        return make_complain(scene, at, "there is no semantic '%s'", text);
    if (json_object_get(object, "layers"))
        return make_complain(scene, at, "with 'layers' their names are the semantics");
    texture->semantics[0] = (uint32_t)number;
    return CMD_OK;
}

/* ---- patches ------------------------------------------------------------------------------------------ */

static int read_corners(make_scene *scene, const json_t *value, const char *pointer, double *out) {
    if (!json_is_array(value) || json_array_size(value) != 4)
        return make_complain(scene, pointer, "four corners [u, v] are wanted here");
    for (size_t i = 0; i < 4; i++) {
        const char *at = make_string(scene, "%s/%u", pointer, (unsigned)i);
        int status = at ? scene_reals(scene, json_array_get(value, i), at, 2, out + 2 * i) : CMD_INTERNAL;
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

static int read_offset(make_scene *scene, const json_t *object, const char *pointer, make_patch *patch) {
    const json_t *scale = json_object_get(object, "scale");
    const char *at = make_string(scene, "%s/offset", pointer);
    const char *scale_at = make_string(scene, "%s/scale", pointer);
    if (!at || !scale_at)
        return CMD_INTERNAL;
    if (!scale)
        return make_complain(scene, pointer,
                             "'offset' needs 'scale' beside it: the patch's width "
                             "and height in the parent");
    int status = scene_reals(scene, json_object_get(object, "offset"), at, 2, patch->numbers);
    return status == CMD_OK ? scene_reals(scene, scale, scale_at, 2, patch->numbers + 2) : status;
}

static int read_place(make_scene *scene, const json_t *object, const char *pointer, make_patch *patch) {
    static const char *const ways[] = {"offset", "corners", "rect_pixels", "matrix", "matrix_root", "at_crop"};
    int found = -1, crop = 0;
    for (int i = 0; i < 6; i++) {
        if (!json_object_get(object, ways[i]))
            continue;
        if (found >= 0)
            return make_complain(scene, pointer, "both '%s' and '%s' say where the patch lies", ways[found], ways[i]);
        found = i;
    }
    if (found < 0)
        return make_complain(scene, pointer,
                             "nothing says where the patch lies: 'offset' and 'scale', 'corners', "
                             "'rect_pixels', 'matrix', 'matrix_root' or 'at_crop'");
    if (found > 0 && json_object_get(object, "scale"))
        return make_complain(scene, pointer, "'scale' belongs to 'offset'");
    const json_t *value = json_object_get(object, ways[found]);
    const char *at = make_string(scene, "%s/%s", pointer, ways[found]);
    if (!at)
        return CMD_INTERNAL;
    patch->place = (make_place)(found + 1);
    if (found == 0)
        return read_offset(scene, object, pointer, patch);
    if (found == 1)
        return read_corners(scene, value, at, patch->numbers);
    if (found < 5)
        return scene_reals(scene, value, at, found == 2 ? 4 : 9, patch->numbers);
    int status = scene_flag(scene, value, at, &crop);
    if (status == CMD_OK && !crop)
        return make_complain(scene, at, "leave it out, or say true");
    return status;
}

/* An index, or the name of an earlier patch. Without it: the root. */
static int read_parent(make_scene *scene, const json_t *object, const char *pointer, const make_texture *texture,
                       uint32_t self, make_patch *patch) {
    const json_t *value = json_object_get(object, "parent");
    const char *text;
    if (!value)
        return CMD_OK;
    const char *at = make_string(scene, "%s/parent", pointer);
    if (!at)
        return CMD_INTERNAL;
    if (json_is_integer(value))
        return scene_whole(scene, value, at, 0, self - 1, &patch->parent);
    int status = scene_text(scene, value, at, &text);
    if (status != CMD_OK)
        return status;
    for (uint32_t i = 0; i < self; i++)
        if (texture->patches[i].name && strcmp(texture->patches[i].name, text) == 0) {
            patch->parent = i;
            return CMD_OK;
        }
    return make_complain(scene, at, "no earlier patch is named '%s'", text);
}

/* A painted mask has its own soft edge, and "none" has none. */
static int read_mask(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                     make_patch *patch) {
    const json_t *mask = json_object_get(object, "mask");
    const json_t *ramp = json_object_get(object, "ramp");
    const char *word = json_is_string(mask) ? json_string_value(mask) : "";
    const char *at = make_string(scene, "%s/mask", pointer), *ramp_at = make_string(scene, "%s/ramp", pointer);
    int status = CMD_OK;
    if (!at || !ramp_at)
        return CMD_INTERNAL;
    patch->auto_mask = strcmp(word, "auto") == 0;
    patch->ramp = mask && !patch->auto_mask ? 1 : MAKE_RAMP;
    if (mask && !patch->auto_mask && strcmp(word, "none") != 0) {
        make_options plain = *defaults;
        plain.format = 0;
        status = scene_image(scene, mask, at, &plain, &patch->mask);
    }
    if (ramp && status == CMD_OK)
        status = scene_whole(scene, ramp, ramp_at, 1, 65536, &patch->ramp);
    return status;
}

static int read_tau(make_scene *scene, const json_t *object, const char *pointer, make_patch *patch) {
    const json_t *tau = json_object_get(object, "tau");
    const char *at = make_string(scene, "%s/tau", pointer);
    if (!tau)
        return CMD_OK;
    if (!at)
        return CMD_INTERNAL;
    if (!json_is_number(tau))
        return scene_wrong_type(scene, at, tau, "a number");
    if (!patch->auto_mask)
        return make_complain(scene, at, "'tau' belongs to the mask \"auto\"");
    patch->tau = json_number_value(tau);
    if (!(patch->tau > 0.0 && patch->tau <= AUTHOR_TAU_MOST))
        return make_complain(scene, at, "%g is not above 0 and at most %g", patch->tau, AUTHOR_TAU_MOST);
    return CMD_OK;
}

/* A patch that shows a texture has no picture that could be worked on. */
static int check_shown(make_scene *scene, const char *pointer, const make_patch *patch) {
    static const char *const names[] = {"colour", "prune", "bake_affine"};
    const int given[] = {patch->colour != COLOUR_NONE, patch->prune, patch->bake_affine};
    for (int i = 0; i < 3; i++) {
        const char *at = make_string(scene, "%s/%s", pointer, names[i]);
        if (!at)
            return CMD_INTERNAL;
        if (given[i])
            return make_complain(scene, at, "a patch that shows a texture has no picture of its own to change");
    }
    const char *at = make_string(scene, "%s/mask", pointer);
    if (!at || !patch->auto_mask)
        return at ? CMD_OK : CMD_INTERNAL;
    return make_complain(scene, at, "the mask \"auto\" is made of a picture, and this patch shows a texture");
}

/* What is done to the pictures of a patch behind the root. */
static int read_treatment(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                          make_patch *patch) {
    int colour = COLOUR_NONE, normals = NORMALS_Y_UP;
    int status = read_mask(scene, object, pointer, defaults, patch);
    if (status == CMD_OK)
        status = read_tau(scene, object, pointer, patch);
    if (status == CMD_OK)
        status = scene_member_word(scene, object, pointer, "colour", "none|gain|poisson", &colour);
    if (status == CMD_OK)
        status = scene_member_word(scene, object, pointer, "normals", "y_up|y_down|keep", &normals);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "separate_mask", &patch->separate_mask);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "prune", &patch->prune);
    if (status == CMD_OK)
        status = scene_member_flag(scene, object, pointer, "bake_affine", &patch->bake_affine);
    patch->colour = (make_colour)colour;
    patch->normals = (make_normals)normals;
    return status == CMD_OK && patch->texture != ZT_NONE ? check_shown(scene, pointer, patch) : status;
}

/* A patch that shows an earlier texture of the file, by name. */
static int read_shown(make_scene *scene, const json_t *value, const char *pointer, const make_texture *texture,
                      make_patch *patch) {
    const char *at = make_string(scene, "%s/texture", pointer);
    int status = at ? scene_earlier(scene, value, at, texture, &patch->texture) : CMD_INTERNAL;
    if (status == CMD_OK && scene->textures[patch->texture].layer_count != texture->layer_count)
        return make_complain(scene, at, "'%s' has another number of layers", json_string_value(value));
    return status;
}

/* The images of a patch behind the root, in the order of the root's layers. */
static int read_patch_images(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                             const make_texture *texture, make_patch *patch) {
    make_texture own = {0};
    const make_image *images[MAKE_LAYERS];
    int status = read_sources(scene, object, pointer, defaults, &own, images);
    if (status != CMD_OK)
        return status;
    if (json_object_get(object, "image") && texture->layer_count == 1)
        own.semantics[0] = texture->semantics[0];
    for (uint32_t i = 0; i < texture->layer_count; i++) {
        uint32_t k = 0;
        while (k < own.layer_count && own.semantics[k] != texture->semantics[i])
            k++;
        if (k == own.layer_count)
            return make_complain(scene, pointer, "the layer %s, which the root has, is missing",
                                 cmd_semantic_name(texture->semantics[i]));
        patch->images[i] = images[k];
    }
    if (own.layer_count != texture->layer_count)
        return make_complain(scene, pointer, "more layers than the root has");
    return CMD_OK;
}

static int read_root(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                     make_texture *texture, make_patch *patch) {
    static const char *const known[] = {"name", "image", "layers", "semantic", "prune", NULL};
    int status = scene_check_keys(scene, object, pointer, known);
    if (status != CMD_OK) {
        cmd_hint("The first patch is the root: it covers everything, so it has no place and no "
                 "mask.");
        return status;
    }
    status = scene_member_flag(scene, object, pointer, "prune", &patch->prune);
    if (status == CMD_OK)
        status = read_sources(scene, object, pointer, defaults, texture, patch->images);
    return status == CMD_OK ? read_semantic(scene, object, pointer, texture) : status;
}

static int read_child(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                      make_texture *texture, uint32_t index) {
    static const char *const known[] = {
        "name",          "image",       "layers", "texture",     "parent",      "offset",  "scale",
        "corners",       "rect_pixels", "matrix", "matrix_root", "at_crop",     "mask",    "ramp",
        "separate_mask", "colour",      "tau",    "prune",       "bake_affine", "normals", NULL};
    make_patch *patch = &texture->patches[index];
    const json_t *shown = json_object_get(object, "texture");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status == CMD_OK && shown)
        status = read_shown(scene, shown, pointer, texture, patch);
    else if (status == CMD_OK)
        status = read_patch_images(scene, object, pointer, defaults, texture, patch);
    if (status == CMD_OK)
        status = read_parent(scene, object, pointer, texture, index, patch);
    if (status == CMD_OK)
        status = read_place(scene, object, pointer, patch);
    return status == CMD_OK ? read_treatment(scene, object, pointer, defaults, patch) : status;
}

static int read_patch(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                      make_texture *texture, uint32_t index) {
    make_patch *patch = &texture->patches[index];
    const json_t *name = json_object_get(object, "name");
    patch->pointer = pointer;
    patch->texture = ZT_NONE;
    if (!json_is_object(object))
        return scene_wrong_type(scene, pointer, object, "an object");
    if (name) {
        int status = scene_text(scene, name, pointer, &patch->name);
        if (status != CMD_OK)
            return status;
    }
    return index == 0 ? read_root(scene, object, pointer, defaults, texture, patch)
                      : read_child(scene, object, pointer, defaults, texture, index);
}

static int read_patches(make_scene *scene, const json_t *list, const char *pointer, const make_options *defaults,
                        make_texture *texture) {
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count == 0 || count > 1u << 24)
        return make_complain(scene, pointer, "a list of patches is wanted here, the root first");
    texture->is_zipmap = 1;
    texture->patch_count = (uint32_t)count;
    texture->patches = make_alloc(scene, count, sizeof *texture->patches);
    if (!texture->patches)
        return CMD_INTERNAL;
    for (uint32_t i = 0; i < texture->patch_count; i++) {
        const char *at = make_string(scene, "%s/%u", pointer, (unsigned)i);
        int status = at ? read_patch(scene, json_array_get(list, i), at, defaults, texture, i) : CMD_INTERNAL;
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

/* ---- textures ---------------------------------------------------------------------------------------------- */

static int read_wrap(make_scene *scene, const json_t *object, const char *pointer, make_texture *texture) {
    const json_t *value = json_object_get(object, "wrap");
    size_t count = json_array_size(value);
    if (!value)
        return CMD_OK;
    const char *at = make_string(scene, "%s/wrap", pointer);
    if (!at)
        return CMD_INTERNAL;
    if (!json_is_string(value) && (count < 2 || count > 3))
        return make_complain(scene, at, "a mode, or a list of two or three modes is wanted here");
    for (size_t i = 0; i < 3; i++) {
        const json_t *item = count ? json_array_get(value, i < count ? i : count - 1) : value;
        int wrap, status = scene_word(scene, item, at, "repeat|mirror|clamp|border", &wrap);
        if (status != CMD_OK)
            return status;
        texture->wrap[i] = (uint8_t)wrap;
    }
    return CMD_OK;
}

/* What a texture is follows from its members; 'kind' is for readers. NULL: it is not there. */
static int check_kind(make_scene *scene, const json_t *object, const char *pointer, const char *kind) {
    int patches = json_object_get(object, "patches") != NULL, silmap = json_object_get(object, "silmap") != NULL;
    int umbrellas = json_object_get(object, "umbrellas") != NULL;
    const char *found = patches ? "zipmap" : silmap ? "silmap" : umbrellas ? "umbrellas" : "image";
    const char *at = make_string(scene, "%s/kind", pointer);
    if (!at)
        return CMD_INTERNAL;
    int others = patches || json_object_get(object, "image") || json_object_get(object, "layers");
    if ((silmap || umbrellas) && (others || silmap == umbrellas))
        return make_complain(scene, pointer,
                             "'%s' says what the texture is made of: no 'image', 'layers' or 'patches' beside it",
                             found);
    if (!kind || strcmp(kind, found) == 0)
        return CMD_OK;
    return make_complain(scene, at, "%s",
                         patches     ? "a texture with 'patches' is a zipmap"
                         : silmap    ? "a texture with 'silmap' is a silmap"
                         : umbrellas ? "a texture with 'umbrellas' is of this kind"
                                     : "'image', or 'zipmap' together with 'patches'");
}

static int read_texture(make_scene *scene, const json_t *object, const char *pointer, make_texture *texture) {
    static const char *const known[] = {"name",     "kind",    "wrap",   "defaults",  "image", "layers",
                                        "semantic", "patches", "silmap", "umbrellas", NULL};
    const json_t *name = json_object_get(object, "name");
    const json_t *kind = json_object_get(object, "kind");
    const json_t *patches = json_object_get(object, "patches");
    const json_t *silmap = json_object_get(object, "silmap");
    const json_t *umbrellas = json_object_get(object, "umbrellas");
    const char *at = make_string(scene, "%s/%s", pointer, silmap ? "silmap" : umbrellas ? "umbrellas" : "patches");
    const char *name_at = make_string(scene, "%s/name", pointer);
    const char *kind_at = make_string(scene, "%s/kind", pointer);
    const char *text = NULL;
    make_options defaults = scene->defaults;
    texture->pointer = pointer;
    texture->name = "";
    if (!at || !name_at || !kind_at)
        return CMD_INTERNAL;
    if (!json_is_object(object))
        return scene_wrong_type(scene, pointer, object, "an object");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status == CMD_OK && name)
        status = scene_text(scene, name, name_at, &texture->name);
    if (status == CMD_OK && kind)
        status = scene_text(scene, kind, kind_at, &text);
    if (status == CMD_OK)
        status = read_wrap(scene, object, pointer, texture);
    if (status == CMD_OK)
        status = scene_defaults(scene, object, pointer, &defaults);
    if (status != CMD_OK)
        return status;
    status = check_kind(scene, object, pointer, text);
    if (status != CMD_OK)
        return status;
    if (patches)
        return read_patches(scene, patches, at, &defaults, texture);
    if (umbrellas)
        status = scene_umbrellas(scene, umbrellas, at, &defaults, texture);
    if (umbrellas)
        return status == CMD_OK ? read_semantic(scene, object, pointer, texture) : status;
    if (silmap && !json_object_get(object, "wrap"))
        memset(texture->wrap, ZT_WRAP_CLAMP, sizeof texture->wrap);
    status = silmap ? scene_silmap(scene, silmap, at, &defaults, texture)
                    : read_sources(scene, object, pointer, &defaults, texture, texture->images);
    return status == CMD_OK ? read_semantic(scene, object, pointer, texture) : status;
}

static int read_textures(make_scene *scene, const json_t *root) {
    const json_t *list = json_object_get(root, "textures");
    size_t count = json_array_size(list);
    if (!list)
        return make_complain(scene, "", "the member 'textures' is missing");
    if (!json_is_array(list) || count == 0 || count > 65536)
        return make_complain(scene, "/textures", "a list of textures is wanted here");
    scene->textures = make_alloc(scene, count, sizeof *scene->textures);
    if (!scene->textures)
        return CMD_INTERNAL;
    for (size_t i = 0; i < count; i++) {
        const char *at = make_string(scene, "/textures/%u", (unsigned)i);
        make_texture *texture = &scene->textures[i];
        int status = at ? read_texture(scene, json_array_get(list, i), at, texture) : CMD_INTERNAL;
        if (status != CMD_OK)
            return status;
        scene->texture_count++;
    }
    return CMD_OK;
}

static int read_metadata(make_scene *scene, const json_t *root) {
    const json_t *object = json_object_get(root, "metadata");
    const char *key;
    json_t *value;
    if (!object)
        return CMD_OK;
    if (!json_is_object(object))
        return scene_wrong_type(scene, "/metadata", object, "an object");
    size_t count = json_object_size(object);
    make_pair *pairs = make_alloc(scene, count + scene->metadata_count + 1, sizeof *pairs);
    if (!pairs)
        return CMD_INTERNAL;
    size_t at = 0;
    json_object_foreach((json_t *)(uintptr_t)object, key, value) {
        const char *pointer = make_string(scene, "/metadata/%s", key);
        pairs[at].key = make_string(scene, "%s", key);
        if (!pointer || !pairs[at].key)
            return CMD_INTERNAL;
        int status = scene_text(scene, value, pointer, &pairs[at].value);
        if (status != CMD_OK)
            return status;
        at++;
    }
    /* The command line comes last, so it wins. */
    if (scene->metadata_count)
        memcpy(pairs + at, scene->metadata, scene->metadata_count * sizeof *pairs);
    scene->metadata = pairs;
    scene->metadata_count += count;
    return CMD_OK;
}

int make_scene_parse(make_scene *scene, const char *text, size_t size) {
    static const char *const known[] = {"$schema", "comment", "metadata", "defaults", "textures", NULL};
    json_error_t error;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &error);
    if (!root) {
        cmd_error("%s: line %d, column %d: %s", scene->name, error.line, error.column, error.text);
        return CMD_USAGE;
    }
    int status = json_is_object(root) ? scene_check_keys(scene, root, "", known)
                                      : scene_wrong_type(scene, "", root, "an object");
    if (status == CMD_OK)
        status = scene_defaults(scene, root, "", &scene->defaults);
    if (status == CMD_OK)
        status = read_metadata(scene, root);
    if (status == CMD_OK)
        status = read_textures(scene, root);
    json_decref(root);
    return status;
}
