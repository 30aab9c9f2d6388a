/* SPDX-License-Identifier: Apache-2.0 */
/* A whole file as a folder: pictures that hold the texels exactly, and scene.json, which `ztex make` reads. */
#include "extract.h"
#include "pick.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define STEM 128
#define NAME_MOST 100    /* characters of a texture's name in a file name */
#define PNG_SIDE 1000000 /* libpng's limit */

typedef struct all_job {
    cmd_args *args;
    const cmd_input *input;
    const char *folder;
    json_t **images; /* the scene's description of each, once it has been written */
    json_t *textures;
    uint8_t *in_bases; /* of each image, 1: umbrellas show it */
    int lost;          /* 1: something has no place in a scene */
    uint32_t done, total;
    cmd_progress progress;
} all_job;

/* ---- names ---------------------------------------------------------------------------------------------- */

/* A texture's name as the beginning of file names, without a dot, so that what follows one never meets another
 * texture's. Names that cannot stay as they are get the texture's number, behind a dot. */
static void plain_name(char dst[STEM], const char *name, uint32_t index) {
    size_t at = 0;
    int same = *name != '\0';
    for (; *name && at < NAME_MOST; name++) {
        int fits = (*name >= 'a' && *name <= 'z') || (*name >= '0' && *name <= '9') || *name == '_' ||
                   (*name == '-' && at > 0);
        /* Some file systems do not tell capitals apart. */
        same &= fits;
        fits |= *name >= 'A' && *name <= 'Z';
        dst[at++] = (char)(fits ? *name : '_');
    }
    dst[at] = '\0';
    if (!same || *name)
        snprintf(dst + at, STEM - at, "%s.t%u", at ? "" : "texture", (unsigned)index);
}

/* The type of picture that holds these texels without any change. */
const char *extract_exact_type(const extract_part *part) {
    const zt_format_info *format = part->format;
    int premultiplied = part->info.alpha_mode == ZT_ALPHA_PREMULTIPLIED;
    if (!format->is_float)
        return premultiplied || part->info.width > PNG_SIDE || part->info.height > PNG_SIDE ? "tif" : "png";
    if (part->info.transfer == ZT_TRANSFER_LINEAR && (format->channels < 4 || premultiplied))
        return "exr";
    return "tif"; /* OpenEXR knows neither straight alpha nor a fourth channel of data */
}

/* ---- images --------------------------------------------------------------------------------------------- */

static int write_one(all_job *job, const extract_part *part, const char *name) {
    char *path = extract_path(job->folder, name);
    if (!path)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    int status = extract_refusal(part) ? extract_raw(job->args, part, path, &job->progress)
                                       : extract_picture(job->args, part, path, &job->progress);
    free(path);
    return status;
}

static json_t *describe(const extract_part *part, json_t *files, int several) {
    static const char *const kinds[] = {"array", "cube", "frames"};
    const zt_image_info *info = &part->info;
    uint32_t all = 1, most = info->width > info->height ? info->width : info->height;
    for (most = most > info->depth ? most : info->depth; most > 1; most /= 2)
        all++;
    json_t *image = json_object();
    if (several) {
        json_object_set(image, "files", files);
        json_object_set_new(image, "as", json_string(info->depth > 1 ? "volume" : kinds[info->layer_kind]));
    } else {
        json_object_set(image, "file", json_array_get(files, 0));
    }
    json_object_set_new(image, "format", json_string(part->format->name));
    json_object_set_new(image, "alpha", json_string(cmd_alpha_name(info->alpha_mode)));
    json_object_set_new(image, "transfer", json_integer(info->transfer));
    json_object_set_new(image, "primaries", json_integer(info->primaries));
    if (info->levels < all)
        json_object_set_new(image, "levels", json_integer(info->levels));
    json_object_set_new(image, "tile_edge", json_integer(info->tile_edge));
    return image;
}

/* Each slice of each layer has its file. What cannot be a picture is written as bytes and has no description. */
static int write_files(all_job *job, extract_part *part, const char *stem, json_t *files) {
    const char *type = extract_refusal(part) ? "bin" : extract_exact_type(part);
    uint32_t slices = part->info.depth, count = part->info.layers * slices;
    char name[400];
    int status = CMD_OK;
    for (uint32_t i = 0; status == CMD_OK && i < count; i++) {
        part->region.layer = i / slices;
        part->region.z = i % slices;
        if (count > 1)
            snprintf(name, sizeof name, "%s.%04u.%s", stem, (unsigned)i, type);
        else
            snprintf(name, sizeof name, "%s.%s", stem, type);
        status = write_one(job, part, name);
        json_array_append_new(files, json_string(name));
    }
    return status;
}

/* Writes an image, unless an earlier texture has shown it. */
static int write_image(all_job *job, uint32_t image, const char *stem) {
    extract_part part;
    if (job->images[image])
        return CMD_OK;
    int status = extract_part_of(job->input->file, job->input->name, image, 0, &part);
    if (status != CMD_OK)
        return status;
    json_t *files = json_array();
    cmd_progress_part(&job->progress, (double)job->done / job->total, (double)(job->done + 1) / job->total);
    job->done++;
    status = write_files(job, &part, stem, files);
    if (part.info.layers > 1 && part.info.depth > 1) {
        cmd_warn(job->args, "image %u has layers and slices: a scene cannot say that", (unsigned)image);
        job->images[image] = json_null();
    } else if (extract_refusal(&part)) {
        cmd_warn(job->args, "image %u is written as bytes only: %s", (unsigned)image, extract_refusal(&part));
        job->images[image] = json_null();
    } else {
        job->images[image] = describe(&part, files, json_array_size(files) > 1);
    }
    json_decref(files);
    return status;
}

/* ---- textures ------------------------------------------------------------------------------------------- */

static const char *semantic_name(uint32_t semantic, char number[16]) {
    const char *name = cmd_semantic_name(semantic);
    snprintf(number, 16, "%u", (unsigned)semantic);
    return name ? name : number;
}

/* The layers of a texture of kind image, or of one patch, into object: "layers". */
static int add_layers(all_job *job, json_t *object, uint32_t texture, uint32_t layer_count, const uint32_t *images,
                      const char *stem) {
    json_t *layers = json_object();
    int status = CMD_OK;
    for (uint32_t l = 0; status == CMD_OK && l < layer_count; l++) {
        zt_layer_info layer = {0};
        char name[400], number[16];
        zt_get_layer(job->input->file, texture, l, &layer);
        const char *semantic = semantic_name(layer.semantic, number);
        /* A scene knows layers by their meaning: one that comes twice has no place in it. */
        int twice = json_object_get(layers, semantic) != NULL;
        if (layer_count == 1)
            snprintf(name, sizeof name, "%s", stem);
        else
            snprintf(name, sizeof name, twice ? "%s.%s.%u" : "%s.%s", stem, semantic, (unsigned)l);
        status = write_image(job, images[l], name);
        if (status == CMD_OK)
            json_object_set(layers, semantic, twice ? json_null() : job->images[images[l]]);
    }
    json_object_set_new(object, "layers", layers);
    return status;
}

static json_t *matrix_of(const double matrix[9]) {
    json_t *list = json_array();
    for (int i = 0; i < 9; i++)
        json_array_append_new(list, json_real(matrix[i]));
    return list;
}

/* Is a texture of this name in the scene? */
static int is_told(const all_job *job, const char *name) {
    json_t *texture;
    size_t i;
    json_array_foreach(job->textures, i, texture) {
        if (name[0] && strcmp(json_string_value(json_object_get(texture, "name")), name) == 0)
            return 1;
    }
    return 0;
}

static int has_normals(const all_job *job, uint32_t texture, const zt_texture_info *info) {
    zt_layer_info layer = {0};
    for (uint32_t l = 0; l < info->layer_count; l++)
        if (zt_get_layer(job->input->file, texture, l, &layer) == ZT_OK && layer.semantic == ZT_SEMANTIC_NORMAL)
            return 1;
    return 0;
}

/* Only which pictures it is: how masks are stored is not a scene's business. */
static json_t *mask_of(json_t *image) {
    json_t *file = json_object_get(image, "file"), *files = json_object_get(image, "files");
    if (files)
        return json_pack("{sO sO}", "files", files, "as", json_object_get(image, "as"));
    return file ? json_incref(file) : json_null();
}

static int add_patch(all_job *job, json_t *list, uint32_t texture, const zt_texture_info *info, uint32_t patch,
                     const char *stem) {
    char name[400];
    zt_patch_info placed;
    uint32_t images[32];
    json_t *object = json_object();
    json_array_append_new(list, object);
    if (zt_get_patch(job->input->file, texture, patch, &placed) != ZT_OK || info->layer_count > 32)
        return cmd_fail(CMD_INTERNAL, "%s: patch %u cannot be read", job->input->name, (unsigned)patch);
    snprintf(name, sizeof name, patch ? "%s.p%03u" : "%s.root", stem, (unsigned)patch);
    if (patch > 0) {
        json_object_set_new(object, "parent", json_integer(placed.parent));
        json_object_set_new(object, "matrix", matrix_of(placed.matrix));
        json_object_set_new(object, "ramp", json_integer(1));
        /* They have been turned when they were stored. */
        if (has_normals(job, texture, info))
            json_object_set_new(object, "normals", json_string("keep"));
    }
    if (placed.texture != ZT_NONE) {
        zt_texture_info shown = {0};
        zt_get_texture(job->input->file, placed.texture, &shown);
        json_object_set_new(object, "texture", is_told(job, shown.name) ? cmd_json_text(shown.name) : json_null());
    }
    int status = CMD_OK;
    for (uint32_t l = 0; l < info->layer_count; l++)
        images[l] = zt_get_patch_image(job->input->file, texture, patch, l);
    if (placed.texture == ZT_NONE)
        status = add_layers(job, object, texture, info->layer_count, images, name);
    if (status != CMD_OK || placed.mask == ZT_NONE)
        return status;
    strncat(name, ".mask", sizeof name - strlen(name) - 1);
    status = write_image(job, placed.mask, name);
    if (status == CMD_OK) {
        json_object_set_new(object, "mask", mask_of(job->images[placed.mask]));
        if (placed.texture == ZT_NONE)
            json_object_set_new(object, "separate_mask", json_true());
    }
    return status;
}

/* Is there a null, something that a scene cannot say, in it? */
static int has_null(const json_t *value) {
    const char *key;
    json_t *item;
    size_t i;
    if (json_is_null(value))
        return 1;
    json_array_foreach(value, i, item) if (has_null(item)) return 1;
    json_object_foreach((json_t *)(uintptr_t)value, key, item) if (has_null(item)) return 1;
    return 0;
}

static json_t *wraps_of(const zt_texture_info *info) {
    json_t *wrap = json_array();
    json_array_append_new(wrap, json_string(cmd_wrap_name(info->wrap_u)));
    json_array_append_new(wrap, json_string(cmd_wrap_name(info->wrap_v)));
    json_array_append_new(wrap, json_string(cmd_wrap_name(info->wrap_w)));
    return wrap;
}

/* A scene says of what a silmap is made, not what its cells are: those are written to be looked at. */
static int write_silmap(all_job *job, uint32_t texture, uint32_t layer_count, const char *stem) {
    char name[STEM + 32];
    cmd_output output = {0};
    int status = CMD_OK;
    for (uint32_t l = 0; l < layer_count && status == CMD_OK; l++) {
        uint32_t image = zt_get_silmap_minified(job->input->file, texture, l);
        snprintf(name, sizeof name, "%s.minified.%u", stem, (unsigned)l);
        if (image != ZT_NONE)
            status = write_image(job, image, name);
    }
    snprintf(name, sizeof name, "%s.cells.svg", stem);
    char *path = extract_path(job->folder, name);
    if (!path)
        status = cmd_fail(CMD_INTERNAL, "out of memory");
    if (status == CMD_OK)
        status = cmd_output_open(&output, path, 0);
    if (status == CMD_OK)
        status = extract_cells(job->input->file, job->input->name, texture, 0, 0, output.stream);
    status = cmd_output_end(&output, status);
    free(path);
    return status;
}

/* Nor of what umbrellas are made, only what they are: their bases, with a null, and a drawing of the arrangement. */
static int write_umbrellas(all_job *job, uint32_t texture, json_t *object, const char *stem) {
    char name[STEM + 32];
    zt_umbrella_info info = {0};
    zt_get_umbrellas(job->input->file, texture, &info);
    for (uint32_t i = 0; i < info.base_count; i++)
        if (!info.bases[i].shows_texture)
            job->in_bases[info.bases[i].source] = 1;
    snprintf(name, sizeof name, "%s.bases", stem);
    char *bases = extract_path(job->folder, name);
    snprintf(name, sizeof name, "%s.svg", stem);
    char *drawing = extract_path(job->folder, name);
    int status = bases && drawing ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    if (status == CMD_OK)
        status = extract_bases(job->args, job->input, texture, bases, &job->progress);
    if (status == CMD_OK)
        status = extract_arrangement(job->input, texture, 0, drawing);
    json_object_set_new(object, "umbrellas", json_null());
    free(bases);
    free(drawing);
    return status;
}

static int add_texture(all_job *job, uint32_t texture) {
    char stem[STEM];
    zt_texture_info info = {0};
    uint32_t images[32];
    int status = CMD_OK;
    zt_get_texture(job->input->file, texture, &info);
    plain_name(stem, info.name, texture);
    json_t *object = json_object();
    json_object_set_new(object, "name", cmd_json_text(info.name));
    json_object_set_new(object, "kind", json_string(cmd_kind_name(info.kind)));
    json_object_set_new(object, "wrap", wraps_of(&info));
    json_t *patches = info.kind == ZT_KIND_ZIPMAP ? json_array() : NULL;
    for (uint32_t p = 0; patches && status == CMD_OK && p < info.patch_count; p++)
        status = add_patch(job, patches, texture, &info, p, stem);
    for (uint32_t l = 0; l < info.layer_count && l < 32; l++) {
        zt_layer_info layer = {0};
        zt_get_layer(job->input->file, texture, l, &layer);
        images[l] = layer.image;
    }
    if (patches)
        json_object_set_new(object, "patches", patches);
    else if (info.kind == ZT_KIND_UMBRELLA)
        status = write_umbrellas(job, texture, object, stem);
    else
        status = add_layers(job, object, texture, info.layer_count, images, stem);
    if (status == CMD_OK && info.kind == ZT_KIND_SILMAP) {
        status = write_silmap(job, texture, info.layer_count, stem);
        json_object_set_new(object, "silmap", json_null());
    }
    if (status == CMD_OK && has_null(object)) {
        cmd_warn(job->args, "texture %u '%s' is not in scene.json: a scene cannot say what it has", (unsigned)texture,
                 info.name);
        job->lost = 1;
        json_decref(object);
        return CMD_OK;
    }
    json_array_append_new(job->textures, object);
    return status;
}

static uint32_t count_left_out(const all_job *job) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < job->total; i++)
        count += !job->images[i] && !job->in_bases[i];
    return count;
}

/* ---- the rest --------------------------------------------------------------------------------------------- */

static int add_metadata(const all_job *job, json_t *scene) {
    uint32_t count = 0;
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_load_metadata(job->input->file, &count, &diag);
    if (result != ZT_OK)
        return cmd_fail_result(job->input->name, result, &diag);
    json_t *pairs = json_object();
    for (uint32_t i = 0; i < count; i++) {
        const char *key, *value;
        if (zt_get_metadata(job->input->file, i, &key, &value) == ZT_OK)
            json_object_set_new(pairs, key, cmd_json_text(value));
    }
    if (count > 0)
        json_object_set(scene, "metadata", pairs);
    json_decref(pairs);
    return CMD_OK;
}

static int write_scene(const all_job *job, const json_t *scene) {
    char *path = extract_path(job->folder, "scene.json");
    int status = path ? cmd_json_write(path, scene) : cmd_fail(CMD_INTERNAL, "out of memory");
    free(path);
    return status;
}

int extract_all(cmd_args *args, const cmd_input *input, const char *folder) {
    zt_file_info info;
    zt_get_file(input->file, &info);
    all_job job = {.args = args, .input = input, .folder = folder, .total = info.image_count};
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return cmd_fail(CMD_IO, "%s: %s", folder, strerror(errno));
    job.images = calloc(info.image_count, sizeof *job.images);
    job.in_bases = calloc(info.image_count, sizeof *job.in_bases);
    if (!job.images || !job.in_bases) {
        free(job.images);
        free(job.in_bases);
        return cmd_fail(CMD_INTERNAL, "out of memory");
    }
    json_t *scene = json_object();
    job.textures = json_array();
    cmd_progress_begin(&job.progress, args, "extracting");
    int status = add_metadata(&job, scene);
    for (uint32_t t = 0; status == CMD_OK && t < info.texture_count; t++)
        status = add_texture(&job, t);
    cmd_progress_end(&job.progress);
    uint32_t left = count_left_out(&job);
    if (left > 0 && status == CMD_OK)
        cmd_note(args, "%u images that no texture shows are left out", (unsigned)left);
    json_object_set_new(scene, "textures", job.textures);
    if (status == CMD_OK)
        status = write_scene(&job, scene);
    for (uint32_t i = 0; i < info.image_count; i++)
        json_decref(job.images[i]);
    free(job.images);
    free(job.in_bases);
    json_decref(scene);
    return status == CMD_OK && job.lost ? CMD_UNSUPPORTED : status;
}
