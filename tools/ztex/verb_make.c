/* SPDX-License-Identifier: Apache-2.0 */
/* ztex make: pictures, or a scene that names them, into a texture file. */
#include "make_args.h"

#include <stdlib.h>
#include <string.h>

static const cmd_option options[] = {
    WRITE_OPTION_OUTPUT,
    MAKE_OPTION_NAME,
    MAKE_OPTION_FORMAT,
    {.name = "semantic",
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .fallback = "base_colour",
     .choices = "unspecified|base_colour|normal|displacement|roughness|metalness|occlusion|"
                "emissive|opacity|specular|occlusion_roughness_metalness",
     .help = "What the texels mean. Those that are no colours are kept as they are, linear."},
    {.name = "layer",
     .metavar = "SEMANTIC=FILE",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Another layer of the same texture: --layer normal=brick_n.png."},
    MAKE_OPTION_WRAP("repeat", ""),
    MAKE_OPTION_LEVELS,
    MAKE_OPTION_MIP_FILTER,
    {.name = "alpha",
     .metavar = "MODE",
     .kind = CMD_CHOICE,
     .choices = "none|straight|premultiplied",
     .help = "How alpha is stored; none drops it. Default: as in the picture."},
    {.name = "transfer",
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .choices = "srgb|linear|bt709|gamma22|gamma28|pq",
     .help = "How the picture's colours are coded, by name or CICP number, when the picture does "
             "not say or says it wrongly."},
    {.name = "primaries",
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .choices = "bt709|p3-d65|p3-dci|bt2020|xyz",
     .help = "Colour primaries of the picture, by name or CICP number. Default: what the picture "
             "says, else bt709."},
    {.name = "keep-orientation",
     .help = "Keep the rows as they are stored. By default pictures are turned upright as their "
             "EXIF orientation says."},
    {.name = "array", .help = "Several pictures are the layers of an array."},
    {.name = "cube", .help = "Six pictures are the faces +X -X +Y -Y +Z -Z of a cube."},
    {.name = "frames",
     .help = "Several pictures, or the subimages of one, are the frames of an animation. A name "
             "with %d or %04d stands for frames numbered from 0 or 1."},
    {.name = "volume", .help = "Several pictures are the slices of a volume."},
    MAKE_OPTION_META,
    MAKE_OPTION_LICENSE,
    MAKE_OPTION_WRITER,
    MAKE_OPTION_TILE_EDGE,
    MAKE_OPTION_EFFORT,
    WRITE_OPTION_RAW,
    WRITE_OPTION_NO_FSYNC,
    {0}};

static const cmd_example examples[] = {
    {"ztex make brick.png -o brick.ztex", "A texture with all mip levels."},
    {"ztex make brick.png --layer normal=brick_n.png --layer roughness=brick_r.png -o brick.ztex",
     "A material: three layers of one texture."},
    {"ztex make sky_{px,nx,py,ny,pz,nz}.exr --cube --wrap clamp -o sky.ztex", "A cube map."},
    {"ztex make 'walk_%03d.png' --frames -o walk.ztex", "An animation of numbered frames."},
    {"ztex make scene.json -o wall.ztex", "A zipmap, or a file with several textures."},
    {"convert brick.tif png:- | ztex make - -o - > brick.ztex", "In a pipe."},
    {0}};

static const char text[] =
    "From a picture it makes a texture of kind image, with mip levels, for any format that "
    "OpenImageIO reads, and from Deep Zoom pictures (NAME.dzi) and folders of Zoomify "
    "(ImageProperties.xml) and of the IIIF Image API (info.json). Several pictures become array layers, cube faces, "
    "frames or slices "
    "(--array, --cube, --frames, --volume), and --layer adds layers such as normals.\n"
    "\n"
    "From a scene, a JSON file, it makes zipmaps and files with several textures. A zipmap has a "
    "root image and patches that show parts of it more closely:\n"
    "\n"
    "  {\"textures\": [{\"name\": \"wall\", \"patches\": [\n"
    "      {\"image\": {\"file\": \"wall.jpg\", \"resize\": [1024, 1024]}},\n"
    "      {\"image\": {\"file\": \"wall.jpg\", \"crop\": [3000, 1000, 800, 600]},\n"
    "       \"at_crop\": true},\n"
    "      {\"name\": \"poster\", \"image\": \"poster.png\", \"ramp\": 4,\n"
    "       \"corners\": [[0.1, 0.2], [0.3, 0.19], [0.31, 0.5], [0.1, 0.48]]},\n"
    "      {\"image\": \"stamp.png\", \"parent\": \"poster\", \"mask\": \"stamp_mask.png\",\n"
    "       \"offset\": [0.7, 0.1], \"scale\": [0.1, 0.1]}]}]}\n"
    "\n"
    "File names are relative to the scene file. A patch lies in its parent ('parent': index or "
    "name of an earlier patch, default the root), given as exactly one of: 'offset' and 'scale' "
    "(its corner and size in the parent's coordinates), 'corners' (where its corners (0,0) (1,0) "
    "(1,1) (0,1) are in the parent's coordinates), 'rect_pixels' (x, y, width, height in texels of "
    "the parent), 'matrix' (nine numbers, the parent's coordinates to the patch's), 'matrix_root' "
    "(the root's coordinates to the patch's), or 'at_crop': true (where its crop was). Its edge "
    "fades out over 'ramp' texels (default 8), or as the grey picture 'mask' says. 'layers' "
    "instead of 'image' gives base colour, normal and so on: {\"base_colour\": ..., \"normal\": "
    "...}. An image is a file name or an object: file or files with 'as' (array, cube, frames, "
    "volume), subimage, crop, resize, format, alpha, transfer, primaries, levels, tile_edge, "
    "mip_filter, keep_orientation. The options of the command line are defaults for all images of "
    "the scene. docs/scene.md describes every member.";

/* ---- the command line as a scene ---------------------------------------------------------------------- */

static int named_number(const cmd_args *args, const char *name, int (*number_of)(const char *), int *out) {
    const char *word = cmd_text(args, name);
    *out = word ? number_of(word) : MAKE_UNSET;
    if (word && *out < 0)
        return cmd_usage(args, "--%s: there is no '%s'", name, word);
    return CMD_OK;
}

static int read_defaults(const cmd_args *args, make_options *o) {
    const char *format = cmd_text(args, "format");
    *o = (make_options){.alpha = cmd_choice(args, "alpha"),
                        .mip_filter = cmd_given(args, "mip-filter") ? cmd_choice(args, "mip-filter") : MAKE_UNSET,
                        .levels = (int)cmd_integer(args, "levels"),
                        .keep_orientation = cmd_given(args, "keep-orientation") > 0};
    if (format)
        o->format = zt_find_format_name(format)->format;
    int status = write_read_tile_edge(args, &o->tile_edge);
    if (status == CMD_OK)
        status = named_number(args, "transfer", cmd_transfer_number, &o->transfer);
    return status == CMD_OK ? named_number(args, "primaries", cmd_primaries_number, &o->primaries) : status;
}

static int main_image(const cmd_args *args, make_scene *scene, const char *const *paths, make_image *image) {
    static const char *const kinds[] = {"array", "cube", "frames", "volume"};
    size_t count = args->operand_count;
    int given = 0;
    make_file *files = make_alloc(scene, count, sizeof *files);
    if (!files)
        return CMD_INTERNAL;
    for (size_t i = 0; i < count; i++)
        files[i].path = paths[i];
    *image = (make_image){.files = files, .file_count = count, .options = scene->defaults, .pointer = ""};
    for (int i = 0; i < 4; i++) {
        if (!cmd_given(args, kinds[i]))
            continue;
        image->layer_kind = i == 3 ? 0 : i;
        image->volume = i == 3;
        given++;
    }
    if (given > 1)
        return cmd_usage(args, "only one of --array, --cube, --frames, --volume");
    if (given == 0 && count > 1)
        return cmd_usage(args, "several pictures: say --array, --cube, --frames or --volume, or "
                               "--layer SEMANTIC=FILE for layers of a material");
    image->all_subimages = given && count == 1;
    return given && count == 1 ? make_number_files(scene, image) : CMD_OK;
}

static int other_layers(const cmd_args *args, make_scene *scene, make_texture *texture) {
    int count = cmd_given(args, "layer");
    for (int i = 0; i < count; i++) {
        const char *path;
        uint32_t semantic;
        int status = make_read_layer(args, cmd_text_at(args, "layer", (size_t)i), texture->layer_count, &semantic,
                                     &path);
        if (status != CMD_OK)
            return status;
        make_image *image = make_alloc(scene, 1, sizeof *image);
        make_file *file = make_alloc(scene, 1, sizeof *file);
        if (!image || !file)
            return CMD_INTERNAL;
        file->path = path;
        *image = (make_image){.files = file, .file_count = 1, .options = scene->defaults, .pointer = ""};
        /* --format and --transfer are about the main picture. */
        image->options.format = 0;
        image->options.transfer = MAKE_UNSET;
        texture->semantics[texture->layer_count] = semantic;
        texture->images[texture->layer_count++] = image;
    }
    return CMD_OK;
}

static int scene_of_pictures(const cmd_args *args, make_scene *scene, const char *const *paths) {
    make_texture *texture = make_alloc(scene, 1, sizeof *texture);
    make_image *image = make_alloc(scene, 1, sizeof *image);
    int semantic = cmd_semantic_number(cmd_text(args, "semantic"));
    int wrap = cmd_choice(args, "wrap");
    if (!texture || !image)
        return CMD_INTERNAL;
    if (semantic < 0)
        return cmd_usage(args, "--semantic: there is no '%s'", cmd_text(args, "semantic"));
    int status = main_image(args, scene, paths, image);
    if (status != CMD_OK)
        return status;
    *texture = (make_texture){.name = make_texture_name(args, scene, image->files[0].path),
                              .wrap = {(uint8_t)wrap, (uint8_t)wrap, (uint8_t)wrap},
                              .layer_count = 1,
                              .semantics = {(uint32_t)semantic},
                              .images = {image},
                              .pointer = ""};
    scene->textures = texture;
    scene->texture_count = 1;
    status = other_layers(args, scene, texture);
    return status == CMD_OK ? make_copy_authorship(scene, image->files[0].path) : status;
}

/* ---- a scene file --------------------------------------------------------------------------------------- */

static int refuse_picture_options(const cmd_args *args) {
    static const char *const names[] = {"name", "semantic", "layer", "wrap", "array", "cube", "frames", "volume"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (cmd_given(args, names[i]))
            return cmd_usage(args, "--%s is for pictures: the scene file says it itself", names[i]);
    if (args->operand_count > 1)
        return cmd_usage(args, "one scene file at a time");
    return CMD_OK;
}

static int scene_of_text(const cmd_args *args, make_scene *scene, const char *path, const char *json, size_t size) {
    const char *slash = strrchr(path, '/');
    int status = refuse_picture_options(args);
    if (status != CMD_OK)
        return status;
    scene->name = cmd_input_name(path);
    scene->folder = slash ? make_string(scene, "%.*s", (int)(slash - path + 1), path) : "";
    status = scene->folder ? make_add_metadata(args, scene) : CMD_INTERNAL;
    return status == CMD_OK ? make_scene_parse(scene, json, size) : status;
}

/* ---- standard input ---------------------------------------------------------------------------------------- */

/* Pictures are read by name, so one from a pipe goes through a temporary file. */
static int picture_file_of(const void *data, size_t size, char **temporary) {
    const char *set = getenv("TMPDIR");
    char path[1024];
    snprintf(path, sizeof path, "%s/picture", set && *set ? set : "/tmp");
    *temporary = cmd_temporary(path);
    if (!*temporary)
        return CMD_IO;
    FILE *stream = fopen(*temporary, "wb");
    int good = stream && fwrite(data, 1, size, stream) == size;
    if (stream)
        good = fclose(stream) == 0 && good;
    return good ? CMD_OK : cmd_fail(CMD_IO, "%s: cannot be written", *temporary);
}

static int is_scene_text(const char *data, size_t size) {
    size_t i = 0;
    while (i < size && strchr(" \t\r\n", data[i]) && data[i])
        i++;
    return i < size && data[i] == '{';
}

/* info.json is what the IIIF Image API calls the descriptor of a picture. */
static int is_scene_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return cmd_ends_with(path, ".json") && strcmp(slash ? slash + 1 : path, "info.json") != 0;
}

/* Builds the scene from whatever the operand is. *data and *temporary are released by the caller. */
static int read_operands(const cmd_args *args, make_scene *scene, void **data, char **temporary) {
    const char *path = args->operands[0];
    size_t size = 0;
    int from_stream = strcmp(path, "-") == 0;
    if (from_stream || is_scene_name(path)) {
        int status = cmd_read_all(args, path, 0, data, &size);
        if (status != CMD_OK)
            return status;
        if (!from_stream || is_scene_text(*data, size))
            return scene_of_text(args, scene, path, *data, size);
        status = picture_file_of(*data, size, temporary);
        if (status != CMD_OK)
            return status;
        if (args->operand_count > 1)
            return cmd_usage(args, "standard input holds one picture");
    }
    const char *one[1] = {*temporary};
    int status = scene_of_pictures(args, scene, from_stream ? one : args->operands);
    return status == CMD_OK ? make_add_metadata(args, scene) : status;
}

static int run(cmd_args *args) {
    const char *output = cmd_text(args, "output");
    make_scene scene = {.folder = ""};
    void *data = NULL;
    char *temporary = NULL;
    if (!output)
        return cmd_usage(args, "-o FILE is missing: where shall the texture go?");
    int status = cmd_check_output(output, args->operands, args->operand_count);
    if (status == CMD_OK)
        status = read_defaults(args, &scene.defaults);
    if (status == CMD_OK)
        status = read_operands(args, &scene, &data, &temporary);
    if (status == CMD_OK)
        status = make_file_of(args, &scene, output, NULL);
    make_scene_release(&scene);
    cmd_temporary_drop(temporary);
    free(data);
    return status;
}

const cmd_verb verb_make = {
    .name = "make",
    .summary = "Make a texture file from pictures or a scene",
    .synopsis = "[OPTION]... PICTURE... -o OUT.ztex\n[OPTION]... SCENE.json -o OUT.ztex",
    .text = text,
    .options = options,
    .examples = examples,
    .operand = CMD_FILE,
    .min_operands = 1,
    .max_operands = 0,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
