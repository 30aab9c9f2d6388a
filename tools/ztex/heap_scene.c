/* SPDX-License-Identifier: Apache-2.0 */
/* What was found in a heap of photographs, as a scene: patches with their parents and matrices, ready to be edited by
 * hand. */
#include "heap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BEFORE_EDGE 1024 /* pixels: enough to see a seam by */
#define FADING \
    3.0 /* texels of the parent: what it shows at the very edge of the patch is blurred with what is outside */

typedef struct scene_job {
    const heap *heap;
    heap_purpose purpose;
    const char *folder; /* absolute, with its slash; "": names stay as they are */
    int failed;         /* CMD_OK, or what stopped it; the message is printed */
} scene_job;

/* From the scene's folder to the file: relative where the file lies below it, absolute elsewhere. */
static json_t *file_name(scene_job *job, const char *path) {
    if (job->folder[0] == '\0')
        return cmd_json_text(path);
    char *whole = realpath(path, NULL);
    if (!whole) {
        job->failed = cmd_fail(CMD_IO, "%s: its folder is not there any more", path);
        return NULL;
    }
    size_t length = strlen(job->folder);
    json_t *name = cmd_json_text(strncmp(whole, job->folder, length) == 0 ? whole + length : whole);
    free(whole);
    return name;
}

/* The file's name, or with --max-size an object that makes it smaller. */
static json_t *image_of(scene_job *job, const char *path) {
    char error[IMG_ERROR];
    uint64_t most = job->purpose == HEAP_BEFORE ? BEFORE_EDGE : cmd_integer(job->heap->args, "max-size");
    json_t *name = file_name(job, path);
    if (most == 0 || !name)
        return name;
    img_reader *reader = img_open(path, NULL, error);
    if (!reader) {
        job->failed = cmd_fail(CMD_IO, "%s: %s", path, error);
        json_decref(name);
        return NULL;
    }
    double width = img_get_info(reader)->width, height = img_get_info(reader)->height;
    img_close(reader);
    double scale = (double)most / (width > height ? width : height);
    if (scale >= 1.0)
        return name;
    int w = (int)(width * scale + 0.5), h = (int)(height * scale + 0.5);
    return json_pack("{so s[ii]}", "file", name, "resize", w < 1 ? 1 : w, h < 1 ? 1 : h);
}

static void add_images(scene_job *job, size_t index, json_t *patch) {
    const heap *h = job->heap;
    json_t *base = image_of(job, h->photos[index].path);
    if (h->layer_count == 0 || job->purpose != HEAP_RESULT) {
        json_object_set_new(patch, "image", base);
        return;
    }
    json_t *layers = json_object();
    json_object_set_new(layers, cmd_semantic_name(ZT_SEMANTIC_BASE_COLOUR), base);
    for (size_t i = 0; i < h->layer_count; i++)
        json_object_set_new(layers, h->layers[i].semantic, image_of(job, h->layers[i].paths[index]));
    json_object_set_new(patch, "layers", layers);
}

/* How a patch is fitted into its parent. */
static void add_fit(const scene_job *job, double ratio, json_t *patch) {
    const cmd_args *args = job->heap->args;
    if (job->purpose != HEAP_BEFORE)
        json_object_set_new(patch, "colour", json_string(cmd_text(args, "colour")));
    if (job->purpose != HEAP_RESULT) {
        json_object_set_new(patch, "mask", json_string("none"));
        json_object_set_new(patch, "ramp", json_integer(1));
        return;
    }
    json_object_set_new(patch, "mask", json_string(cmd_text(args, "mask")));
    uint64_t ramp = cmd_given(args, "ramp") ? cmd_integer(args, "ramp") : (uint64_t)fmin(ceil(FADING * ratio), 65536.0);
    if (ramp > MAKE_RAMP || cmd_given(args, "ramp"))
        json_object_set_new(patch, "ramp", cmd_json_u64(ramp));
    if (cmd_given(args, "tau"))
        json_object_set_new(patch, "tau", json_real(cmd_real(args, "tau")));
    if (cmd_given(args, "normals"))
        json_object_set_new(patch, "normals", json_string(cmd_text(args, "normals")));
    if (cmd_given(args, "prune"))
        json_object_set_new(patch, "prune", json_true());
    if (cmd_given(args, "bake-affine"))
        json_object_set_new(patch, "bake_affine", json_true());
}

static json_t *patch_of(scene_job *job, size_t index) {
    const heap *h = job->heap;
    const author_placing *p = &h->found.placings[index];
    json_t *patch = json_pack("{so}", "name", cmd_json_text(h->photos[index].name));
    add_images(job, index, patch);
    if (p->state == AUTHOR_ROOT)
        return patch;
    json_t *matrix = json_array();
    for (int i = 0; i < 9; i++)
        json_array_append_new(matrix, json_real(p->matrix[i]));
    json_object_set_new(patch, "parent", cmd_json_text(h->photos[p->parent].name));
    json_object_set_new(patch, "matrix", matrix);
    add_fit(job, p->ratio, patch);
    return patch;
}

static json_t *texture_of(scene_job *job, uint32_t group) {
    const heap *h = job->heap;
    const char *name = cmd_text(h->args, "name");
    uint32_t root = h->found.roots[group];
    json_t *patches = json_array();
    for (size_t i = 0; job->failed == CMD_OK && i < h->found.order_count; i++) {
        uint32_t index = h->found.order[i];
        if (h->found.placings[index].group == group)
            json_array_append_new(patches, patch_of(job, index));
    }
    return json_pack("{so ss so}", "name", cmd_json_text(name ? name : h->photos[root].name), "wrap",
                     cmd_text(h->args, "wrap"), "patches", patches);
}

static json_t *defaults_of(const heap *h) {
    const cmd_args *args = h->args;
    json_t *defaults = json_object();
    if (cmd_given(args, "format"))
        json_object_set_new(defaults, "format", json_string(cmd_text(args, "format")));
    if (cmd_given(args, "mip-filter"))
        json_object_set_new(defaults, "mip_filter", json_string(cmd_text(args, "mip-filter")));
    if (cmd_given(args, "tile-edge"))
        json_object_set_new(defaults, "tile_edge", cmd_json_u64(cmd_integer(args, "tile-edge")));
    if (cmd_integer(args, "levels") > 0)
        json_object_set_new(defaults, "levels", cmd_json_u64(cmd_integer(args, "levels")));
    return defaults;
}

static json_t *metadata_of(const heap *h) {
    json_t *metadata = json_object();
    for (size_t i = 0; i < h->memory.metadata_count; i++)
        json_object_set_new(metadata, h->memory.metadata[i].key, cmd_json_text(h->memory.metadata[i].value));
    return metadata;
}

int heap_scene(const heap *h, heap_purpose purpose, const char *folder, json_t **out) {
    scene_job job = {.heap = h, .purpose = purpose, .folder = folder};
    json_t *textures = json_array();
    for (uint32_t group = 0; job.failed == CMD_OK && group < h->found.group_count; group++)
        json_array_append_new(textures, texture_of(&job, group));
    *out = json_pack("{ss so so so}", "comment", "Written by ztex make zipmap; ztex make makes it again.", "metadata",
                     metadata_of(h), "defaults", defaults_of(h), "textures", textures);
    if (job.failed == CMD_OK && !*out)
        job.failed = cmd_fail(CMD_INTERNAL, "out of memory");
    if (job.failed != CMD_OK) {
        json_decref(*out);
        *out = NULL;
    }
    return job.failed;
}
