/* SPDX-License-Identifier: Apache-2.0 */
/* What the verbs `make ...` make of the options that they share. */
#include "make_args.h"

#include <string.h>

int make_add_metadata(const cmd_args *args, make_scene *scene) {
    size_t count = (size_t)cmd_given(args, "meta");
    make_pair *pairs = make_alloc(scene, count + 8, sizeof *pairs);
    if (!pairs)
        return CMD_INTERNAL;
    size_t at = scene->metadata_count;
    if (at > 0)
        memcpy(pairs, scene->metadata, at * sizeof *pairs);
    for (size_t i = 0; i < count; i++) {
        const char *word = cmd_text_at(args, "meta", i);
        const char *equals = strchr(word, '=');
        if (!equals || equals == word)
            return cmd_usage(args, "--meta: '%s' is not KEY=VALUE", word);
        pairs[at].key = make_string(scene, "%.*s", (int)(equals - word), word);
        pairs[at].value = equals + 1;
        if (!pairs[at++].key)
            return CMD_INTERNAL;
    }
    if (cmd_text(args, "license"))
        pairs[at++] = (make_pair){"zt.license", cmd_text(args, "license")};
    if (cmd_given(args, "writer")) {
        char *writer = make_string(scene, "ztex %s", zt_version_string());
        pairs[at++] = (make_pair){"zt.writer", writer ? writer : ""};
    }
    scene->metadata = pairs;
    scene->metadata_count = at;
    return CMD_OK;
}

int make_copy_authorship(make_scene *scene, const char *path) {
    char error[IMG_ERROR];
    img_open_options keep = {.keep_orientation = 1};
    img_reader *reader = img_open(path, &keep, error);
    if (!reader)
        return CMD_OK; /* the message comes when the picture is read */
    const img_info *info = img_get_info(reader);
    const char *values[2] = {info->copyright, info->artist};
    static const char *const keys[2] = {"zt.copyright", "zt.author"};
    make_pair *pairs = make_alloc(scene, 2, sizeof *pairs);
    for (int i = 0; pairs && i < 2; i++) {
        json_t *valid = json_string(values[i]);
        if (valid && values[i][0])
            pairs[scene->metadata_count++] = (make_pair){keys[i], make_string(scene, "%s", values[i])};
        json_decref(valid);
    }
    scene->metadata = pairs;
    img_close(reader);
    return pairs ? CMD_OK : CMD_INTERNAL;
}

int make_read_layer(const cmd_args *args, const char *word, uint32_t count, uint32_t *semantic, const char **path) {
    const char *equals = strchr(word, '=');
    char name[64];
    snprintf(name, sizeof name, "%.*s", equals ? (int)(equals - word) : 0, word);
    int number = cmd_semantic_number(name);
    if (!equals || number < 0 || equals[1] == '\0')
        return cmd_usage(args, "--layer: '%s' is not SEMANTIC=FILE, such as normal=brick_n.png", word);
    if (count == MAKE_LAYERS)
        return cmd_usage(args, "--layer: a texture has at most %d layers", MAKE_LAYERS);
    *semantic = (uint32_t)number;
    *path = equals + 1;
    return CMD_OK;
}

const char *make_texture_name(const cmd_args *args, make_scene *scene, const char *path) {
    const char *given = cmd_text(args, "name");
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    if (given)
        return given;
    if (args->operand_count > 0 && strcmp(args->operands[0], "-") == 0)
        return "";
    size_t length = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    if (slash && (strcmp(base, "info.json") == 0 || strcmp(base, "ImageProperties.xml") == 0)) {
        /* pictures of IIIF and Zoomify have their folder's name */
        for (length = 0, base = slash; base > path && base[-1] != '/'; base--)
            length++;
    }
    char *name = make_string(scene, "%.*s", (int)(length < 255 ? length : 255), base);
    /* A name that the format does not allow is no reason to refuse the picture. */
    json_t *valid = name ? json_string(name) : NULL;
    json_decref(valid);
    return valid ? name : "";
}
