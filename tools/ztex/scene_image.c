/* SPDX-License-Identifier: Apache-2.0 */
/* Reading a scene: texts, numbers and descriptions of images, each with its place in the file for messages. */
#include "scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct make_block {
    struct make_block *next;
    max_align_t bytes[];
};

void *make_alloc(make_scene *scene, size_t count, size_t size) {
    size_t bytes = count * size;
    struct make_block *block = NULL;
    if (size == 0 || count <= (SIZE_MAX - sizeof *block) / size)
        block = calloc(1, sizeof *block + bytes);
    if (!block) {
        cmd_error("out of memory");
        return NULL;
    }
    block->next = scene->blocks;
    scene->blocks = block;
    return block->bytes;
}

char *make_string(make_scene *scene, const char *format, ...) {
    va_list list;
    va_start(list, format);
    int length = vsnprintf(NULL, 0, format, list);
    va_end(list);
    char *text = length < 0 ? NULL : make_alloc(scene, (size_t)length + 1, 1);
    if (!text)
        return NULL;
    va_start(list, format);
    vsnprintf(text, (size_t)length + 1, format, list);
    va_end(list);
    return text;
}

void make_scene_release(make_scene *scene) {
    while (scene->blocks) {
        struct make_block *next = scene->blocks->next;
        free(scene->blocks);
        scene->blocks = next;
    }
}

int make_complain(const make_scene *scene, const char *pointer, const char *format, ...) {
    char text[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    if (!scene->name)
        return cmd_fail(CMD_USAGE, "%s", text);
    return cmd_fail(CMD_USAGE, "%s: %s: %s", scene->name, pointer[0] ? pointer : "/", text);
}

/* ---- values ---------------------------------------------------------------------------------------------- */

static const char *type_name(const json_t *value) {
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "a list";
    case JSON_STRING:
        return "a text";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    default:
        return json_is_null(value) ? "null" : "true or false";
    }
}

int scene_wrong_type(const make_scene *scene, const char *pointer, const json_t *value, const char *wanted) {
    return make_complain(scene, pointer, "%s is wanted here, not %s", wanted, type_name(value));
}

int scene_check_keys(make_scene *scene, const json_t *object, const char *pointer, const char *const *known) {
    size_t count = 0;
    void *iterator = json_object_iter((json_t *)(uintptr_t)object);
    while (known[count])
        count++;
    for (; iterator; iterator = json_object_iter_next((json_t *)(uintptr_t)object, iterator)) {
        const char *key = json_object_iter_key(iterator);
        size_t i = 0;
        while (i < count && strcmp(key, known[i]) != 0)
            i++;
        if (i < count)
            continue;
        const char *near = cmd_nearest(key, known, count);
        return make_complain(scene, pointer, "there is no member '%s'%s%s%s", key, near ? ": did you mean '" : "",
                             near ? near : "", near ? "'?" : "");
    }
    return CMD_OK;
}

int scene_text(make_scene *scene, const json_t *value, const char *pointer, const char **out) {
    *out = NULL;
    if (!json_is_string(value))
        return scene_wrong_type(scene, pointer, value, "a text");
    if (strlen(json_string_value(value)) != json_string_length(value))
        return make_complain(scene, pointer, "the text contains a zero character");
    *out = make_string(scene, "%s", json_string_value(value));
    return *out ? CMD_OK : CMD_INTERNAL;
}

int scene_whole(make_scene *scene, const json_t *value, const char *pointer, uint32_t min, uint32_t max,
                uint32_t *out) {
    *out = 0;
    if (!json_is_integer(value))
        return scene_wrong_type(scene, pointer, value, "a whole number");
    json_int_t number = json_integer_value(value);
    if (number < (json_int_t)min || number > (json_int_t)max)
        return make_complain(scene, pointer, "%lld is not from %u to %u", (long long)number, (unsigned)min,
                             (unsigned)max);
    *out = (uint32_t)number;
    return CMD_OK;
}

int scene_wholes(make_scene *scene, const json_t *value, const char *pointer, size_t count, uint32_t max,
                 uint32_t *out) {
    if (!json_is_array(value) || json_array_size(value) != count)
        return make_complain(scene, pointer, "a list of %u whole numbers is wanted here", (unsigned)count);
    for (size_t i = 0; i < count; i++) {
        const char *at = make_string(scene, "%s/%u", pointer, (unsigned)i);
        int status = at ? scene_whole(scene, json_array_get(value, i), at, 0, max, &out[i]) : CMD_INTERNAL;
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

int scene_reals(make_scene *scene, const json_t *value, const char *pointer, size_t count, double *out) {
    if (!json_is_array(value) || json_array_size(value) != count)
        return make_complain(scene, pointer, "a list of %u numbers is wanted here", (unsigned)count);
    for (size_t i = 0; i < count; i++) {
        const json_t *item = json_array_get(value, i);
        if (!json_is_number(item) || !isfinite(json_number_value(item)))
            return make_complain(scene, pointer, "item %u is not a number", (unsigned)i);
        out[i] = json_number_value(item);
    }
    return CMD_OK;
}

int scene_flag(make_scene *scene, const json_t *value, const char *pointer, int *out) {
    if (!json_is_boolean(value))
        return scene_wrong_type(scene, pointer, value, "true or false");
    *out = json_is_true(value);
    return CMD_OK;
}

int scene_word(make_scene *scene, const json_t *value, const char *pointer, const char *choices, int *out) {
    const char *word;
    char list[256];
    int status = scene_text(scene, value, pointer, &word);
    if (status != CMD_OK)
        return status;
    *out = cmd_choice_index(choices, word);
    if (*out >= 0)
        return CMD_OK;
    cmd_choice_list(choices, list, sizeof list);
    return make_complain(scene, pointer, "there is no '%s': one of %s", word, list);
}

int scene_earlier(make_scene *scene, const json_t *value, const char *pointer, const make_texture *texture,
                  uint32_t *out) {
    const char *text;
    int status = scene_text(scene, value, pointer, &text);
    if (status != CMD_OK)
        return status;
    for (uint32_t t = 0; &scene->textures[t] < texture; t++)
        if (strcmp(scene->textures[t].name, text) == 0) {
            *out = t;
            return CMD_OK;
        }
    return make_complain(scene, pointer, "no earlier texture is named '%s'", text);
}

/* ---- members of an object ---------------------------------------------------------------------------------- */

int scene_member(make_scene *scene, const json_t *object, const char *pointer, const char *name, const json_t **value,
                 const char **at) {
    *value = json_object_get(object, name);
    *at = make_string(scene, "%s/%s", pointer, name);
    return *at ? CMD_OK : CMD_INTERNAL;
}

int scene_member_word(make_scene *scene, const json_t *object, const char *pointer, const char *name,
                      const char *choices, int *out) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, name, &value, &at);
    return status == CMD_OK && value ? scene_word(scene, value, at, choices, out) : status;
}

int scene_member_flag(make_scene *scene, const json_t *object, const char *pointer, const char *name, int *out) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, name, &value, &at);
    return status == CMD_OK && value ? scene_flag(scene, value, at, out) : status;
}

/* ---- options of images ------------------------------------------------------------------------------------ */

static const char *const option_keys[] = {"format",    "alpha",      "transfer",         "primaries", "levels",
                                          "tile_edge", "mip_filter", "keep_orientation", NULL};

static int option_number(make_scene *scene, const json_t *value, const char *pointer,
                         int (*number_of)(const char *name), int *out) {
    const char *text;
    uint32_t number;
    if (json_is_integer(value)) {
        int status = scene_whole(scene, value, pointer, 0, 255, &number);
        *out = (int)number;
        return status;
    }
    int status = scene_text(scene, value, pointer, &text);
    if (status != CMD_OK)
        return status;
    *out = number_of(text);
    if (*out < 0)
        return make_complain(scene, pointer, "there is no '%s': see 'ztex make --help'", text);
    return CMD_OK;
}

static int option_levels(make_scene *scene, const json_t *value, const char *pointer, int *out) {
    uint32_t number = 0;
    int all = json_is_string(value) && strcmp(json_string_value(value), "all") == 0;
    int status = all ? CMD_OK : scene_whole(scene, value, pointer, 1, 32, &number);
    *out = (int)number;
    return status;
}

static int option_format(make_scene *scene, const json_t *value, const char *pointer, uint32_t *out) {
    const char *text;
    int status = scene_text(scene, value, pointer, &text);
    if (status != CMD_OK)
        return status;
    const zt_format_info *format = zt_find_format_name(text);
    if (!format)
        return make_complain(scene, pointer, "there is no format '%s': see 'ztex help formats'", text);
    *out = format->format;
    return CMD_OK;
}

static int option_edge(make_scene *scene, const json_t *value, const char *pointer, int *out) {
    uint32_t number;
    int status = scene_whole(scene, value, pointer, 16, 65536, &number);
    if (status == CMD_OK && (number & (number - 1)) != 0)
        return make_complain(scene, pointer, "%u is not a power of two", (unsigned)number);
    *out = (int)number;
    return status;
}

int scene_options(make_scene *scene, const json_t *object, const char *pointer, make_options *o) {
    int status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && option_keys[i]; i++) {
        const json_t *value = json_object_get(object, option_keys[i]);
        const char *at = value ? make_string(scene, "%s/%s", pointer, option_keys[i]) : NULL;
        if (!value)
            continue;
        if (!at)
            return CMD_INTERNAL;
        switch (i) {
        case 0:
            status = option_format(scene, value, at, &o->format);
            break;
        case 1:
            status = scene_word(scene, value, at, "none|straight|premultiplied", &o->alpha);
            break;
        case 2:
            status = option_number(scene, value, at, cmd_transfer_number, &o->transfer);
            break;
        case 3:
            status = option_number(scene, value, at, cmd_primaries_number, &o->primaries);
            break;
        case 4:
            status = option_levels(scene, value, at, &o->levels);
            break;
        case 5:
            status = option_edge(scene, value, at, &o->tile_edge);
            break;
        case 6:
            status = scene_word(scene, value, at, "kaiser|mitchell|triangle|box", &o->mip_filter);
            break;
        default:
            status = scene_flag(scene, value, at, &o->keep_orientation);
            break;
        }
    }
    return status;
}

int scene_defaults(make_scene *scene, const json_t *object, const char *pointer, make_options *o) {
    const json_t *value = json_object_get(object, "defaults");
    if (!value)
        return CMD_OK;
    const char *at = make_string(scene, "%s/defaults", pointer);
    if (!at)
        return CMD_INTERNAL;
    if (!json_is_object(value))
        return scene_wrong_type(scene, at, value, "an object");
    int status = scene_check_keys(scene, value, at, option_keys);
    return status == CMD_OK ? scene_options(scene, value, at, o) : status;
}

/* ---- images ------------------------------------------------------------------------------------------------- */

static int image_file(make_scene *scene, const json_t *value, const char *pointer, make_file *file) {
    const char *text;
    int status = scene_text(scene, value, pointer, &text);
    if (status != CMD_OK)
        return status;
    if (text[0] == '\0')
        return make_complain(scene, pointer, "the file name is empty");
    file->path = text[0] == '/' ? text : make_string(scene, "%s%s", scene->folder, text);
    return file->path ? CMD_OK : CMD_INTERNAL;
}

static int image_files(make_scene *scene, const json_t *list, const char *pointer, make_image *image) {
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count == 0)
        return make_complain(scene, pointer, "a list of file names is wanted here");
    make_file *files = make_alloc(scene, count, sizeof *files);
    if (!files)
        return CMD_INTERNAL;
    for (size_t i = 0; i < count; i++) {
        const char *at = make_string(scene, "%s/%u", pointer, (unsigned)i);
        int status = at ? image_file(scene, json_array_get(list, i), at, &files[i]) : CMD_INTERNAL;
        if (status != CMD_OK)
            return status;
    }
    image->files = files;
    image->file_count = count;
    return CMD_OK;
}

/* "walk_%03d.png" with a number in it, or NULL when the name has no such place. */
static char *numbered(make_scene *scene, const char *pattern, unsigned number) {
    const char *percent = strrchr(pattern, '%');
    if (!percent || strchr(percent, '/'))
        return NULL;
    const char *end = percent + 1;
    int width = 0;
    if (*end == '0' && end[1] >= '1' && end[1] <= '9') {
        width = end[1] - '0';
        end += 2;
    }
    if (*end != 'd')
        return NULL;
    return make_string(scene, "%.*s%0*u%s", (int)(percent - pattern), pattern, width, number, end + 1);
}

int make_number_files(make_scene *scene, make_image *image) {
    const char *pattern = image->files[0].path;
    unsigned first = 0, count = 0;
    const char *name = numbered(scene, pattern, 0);
    if (!name)
        return CMD_OK;
    first = access(name, F_OK) != 0;
    while ((name = numbered(scene, pattern, first + count)) != NULL && access(name, F_OK) == 0)
        count++;
    if (count == 0)
        return make_complain(scene, image->pointer, "%s: there is no file with number 0 or 1", pattern);
    make_file *files = make_alloc(scene, count, sizeof *files);
    for (unsigned i = 0; files && i < count; i++)
        files[i].path = numbered(scene, pattern, first + i);
    image->files = files;
    image->file_count = count;
    image->all_subimages = 0;
    return files ? CMD_OK : CMD_INTERNAL;
}

/* "as": what several pictures are, or the subimages of one. */
static int image_kind(make_scene *scene, const json_t *object, const char *pointer, make_image *image) {
    int kind;
    const json_t *value = json_object_get(object, "as");
    if (!value && image->file_count > 1)
        return make_complain(scene, pointer, "several files need the member 'as': array, cube, frames or volume");
    if (!value)
        return CMD_OK;
    const char *at = make_string(scene, "%s/as", pointer);
    int status = at ? scene_word(scene, value, at, "array|cube|frames|volume", &kind) : CMD_INTERNAL;
    if (status != CMD_OK)
        return status;
    image->volume = kind == 3;
    image->layer_kind = kind == 3 ? 0 : kind;
    image->all_subimages = image->file_count == 1;
    return image->all_subimages ? make_number_files(scene, image) : CMD_OK;
}

static int image_crop(make_scene *scene, const json_t *object, const char *pointer, make_image *image) {
    const json_t *crop = json_object_get(object, "crop");
    const json_t *size = json_object_get(object, "resize");
    uint32_t n[4] = {0};
    int status = CMD_OK;
    if (crop) {
        const char *at = make_string(scene, "%s/crop", pointer);
        status = at ? scene_wholes(scene, crop, at, 4, 1u << 20, n) : CMD_INTERNAL;
        if (status == CMD_OK && (n[2] == 0 || n[3] == 0))
            return make_complain(scene, at, "the rectangle is empty: x, y, width, height");
        image->crop = (img_rect){n[0], n[1], n[2], n[3]};
    }
    if (size && status == CMD_OK) {
        const char *at = make_string(scene, "%s/resize", pointer);
        status = at ? scene_wholes(scene, size, at, 2, 1u << 20, n) : CMD_INTERNAL;
        if (status == CMD_OK && (n[0] == 0 || n[1] == 0))
            return make_complain(scene, at, "the size is empty: width, height");
        image->resize_width = n[0];
        image->resize_height = n[1];
    }
    return status;
}

static int image_object(make_scene *scene, const json_t *object, const char *pointer, make_image *image) {
    static const char *const known[] = {"file",   "files",     "as",         "subimage",         "crop",
                                        "resize", "format",    "alpha",      "transfer",         "primaries",
                                        "levels", "tile_edge", "mip_filter", "keep_orientation", NULL};
    const json_t *file = json_object_get(object, "file");
    const json_t *files = json_object_get(object, "files");
    const json_t *subimage = json_object_get(object, "subimage");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status != CMD_OK)
        return status;
    if (!file == !files)
        return make_complain(scene, pointer, "an image has either 'file' or 'files'");
    const char *at = make_string(scene, "%s/%s", pointer, file ? "file" : "files");
    make_file *one = make_alloc(scene, 1, sizeof *one);
    if (!at || !one)
        return CMD_INTERNAL;
    image->files = one;
    image->file_count = 1;
    status = file ? image_file(scene, file, at, one) : image_files(scene, files, at, image);
    at = make_string(scene, "%s/subimage", pointer);
    if (status == CMD_OK && file && subimage)
        status = at ? scene_whole(scene, subimage, at, 0, 65535, &one->subimage) : CMD_INTERNAL;
    if (status == CMD_OK)
        status = image_kind(scene, object, pointer, image);
    if (status == CMD_OK)
        status = image_crop(scene, object, pointer, image);
    return status == CMD_OK ? scene_options(scene, object, pointer, &image->options) : status;
}

int scene_image(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                const make_image **out) {
    make_image *image = make_alloc(scene, 1, sizeof *image);
    make_file *file = make_alloc(scene, 1, sizeof *file);
    if (!image || !file)
        return CMD_INTERNAL;
    image->pointer = pointer;
    image->options = *defaults;
    *out = image;
    if (json_is_object(value))
        return image_object(scene, value, pointer, image);
    if (!json_is_string(value))
        return scene_wrong_type(scene, pointer, value, "a file name or an object with 'file'");
    image->files = file;
    image->file_count = 1;
    return image_file(scene, value, pointer, file);
}

int scene_layer(make_scene *scene, const json_t *value, const char *pointer, const char *name,
                const make_options *defaults, make_texture *texture, const make_image **images) {
    const char *at = make_string(scene, "%s/%s", pointer, name);
    int semantic = cmd_semantic_number(name);
    uint32_t layer = texture->layer_count;
    if (!at)
        return CMD_INTERNAL;
    if (semantic < 0)
        return make_complain(scene, at, "there is no semantic '%s': see 'ztex make --help'", name);
    if (layer == MAKE_LAYERS)
        return make_complain(scene, at, "a texture has at most %d layers", MAKE_LAYERS);
    int status = scene_image(scene, value, at, defaults, &images[layer]);
    texture->semantics[layer] = (uint32_t)semantic;
    texture->layer_count = layer + (status == CMD_OK);
    return status;
}
