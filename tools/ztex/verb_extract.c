/* SPDX-License-Identifier: Apache-2.0 */
/* ztex extract: what is in a texture file, as pictures, bytes or metadata. */
#include "extract.h"
#include "pick.h"

#include <string.h>

static const cmd_option options[] = {
    {.name = "output",
     .letter = 'o',
     .metavar = "OUT",
     .kind = CMD_FILE,
     .help = "The picture; its extension says the type: png holds 8 and 16 bits, exr half and float. With --raw and "
             "--key - is standard output."},
    {.name = "image",
     .letter = 'i',
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 0xFFFFFFFE,
     .help = "Image by its number. Default: that of --texture."},
    {.name = "texture", .letter = 't', .metavar = "NAME|INDEX", .kind = CMD_TEXT, .help = "Texture; default: 0."},
    {.name = "layer",
     .metavar = "SEMANTIC|INDEX",
     .kind = CMD_TEXT,
     .help = "Layer of the texture: base_colour, normal, ...; default: the first."},
    {.name = "patch",
     .letter = 'p',
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 0xFFFFFFFE,
     .help = "Patch of a zipmap; default: 0, the root."},
    {.name = "mask", .help = "The mask of the patch instead of its image."},
    {.name = "minified", .help = "The minified image of a silmap's layer instead of its samples."},
    {.name = "cells",
     .help =
         "The cells of a silmap as SVG, to be looked at: points, arms (those that are cut thick), and the colours of "
         "the samples."},
    {.name = "arrangement",
     .help = "A level of umbrellas: as SVG, to be looked at, the polygons in their mean colours and the grid with the "
             "lengths of its lists; as .gltf, with heights and pictures, which like a .bin file are put beside it."},
    {.name = "bases",
     .metavar = "FOLDER",
     .kind = CMD_FOLDER,
     .help = "The pictures of the bases of umbrellas, and bases.json: centre, vertices, second positions, and the "
             "colour offsets of the variants."},
    {.name = "base",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 65535,
     .help = "The picture of one base of umbrellas."},
    {.name = "level",
     .letter = 'l',
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 31,
     .help = "Mip level, or level of --arrangement; default: 0."},
    {.name = "array-layer",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 65535,
     .help = "Array layer, cube face or frame; default: 0."},
    {.name = "slice",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 16383,
     .help = "Slice of a volume; default: 0, with --raw all."},
    {.name = "region",
     .metavar = "X,Y,W,H",
     .kind = CMD_TEXT,
     .help = "Rectangle of texels of the level. For block formats it begins and ends between blocks."},
    {.name = "raw", .help = "The bytes of the texels as they are, rows without padding."},
    {.name = "all",
     .metavar = "FOLDER",
     .kind = CMD_FOLDER,
     .help = "Level 0 of every image as pictures that hold the texels exactly, and scene.json, from which 'ztex make' "
             "makes the same textures."},
    {.name = "dzi",
     .metavar = "OUT.dzi",
     .kind = CMD_FILE,
     .help =
         "The texture as a Deep Zoom pyramid for viewers such as OpenSeadragon: this file, and a folder OUT_files of "
         "tiles. A zipmap is rendered, as large as its finest patch wants."},
    {.name = "tile-size",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 16,
     .max = 8192,
     .fallback = "254",
     .help = "Of --dzi: texels a side, without overlap."},
    {.name = "overlap",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 64,
     .fallback = "1",
     .help = "Of --dzi: texels that tiles repeat of their neighbours."},
    {.name = "max-size",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 1u << 20,
     .fallback = "32768",
     .help = "Of --dzi: most texels a side of the whole."},
    {.name = "format",
     .metavar = "TYPE",
     .kind = CMD_CHOICE,
     .choices = "jpg|png",
     .help = "Of --dzi: type of the tiles; default: jpg, with alpha png."},
    {.name = "quality", .metavar = "Q", .kind = CMD_INTEGER, .min = 1, .max = 100, .fallback = "95", .help = "Of jpg."},
    {.name = "meta", .help = "Print the metadata as JSON."},
    {.name = "key", .metavar = "KEY", .kind = CMD_TEXT, .help = "Print the value of a metadata key."},
    {0}};

static const cmd_example examples[] = {
    {"ztex extract brick.ztex -o brick.png", "The first texture's picture."},
    {"ztex extract wall.ztex -t wall --patch 3 -o detail.png", "What a patch shows, its coverage as alpha."},
    {"ztex extract brick.ztex --layer normal --level 2 -o small.png", "A mip level of another layer."},
    {"ztex extract sign.ztex --cells -o cells.svg", "See the cells of a silmap."},
    {"ztex extract leaves.ztex --arrangement -o leaves.gltf", "Umbrellas as a model for other programs."},
    {"ztex extract wall.ztex --all wall", "Everything; 'ztex make wall/scene.json -o wall.ztex' makes it again."},
    {"ztex extract wall.ztex --dzi wall.dzi", "A picture to zoom into, for the web."},
    {"ztex extract wall.ztex --key zt.license", "Say under which licence the work is."},
    {0}};

static int print_metadata(const cmd_args *args, const cmd_input *input, const char *wanted) {
    uint32_t count = 0;
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_load_metadata(input->file, &count, &diag);
    if (result != ZT_OK)
        return cmd_fail_result(input->name, result, &diag);
    if (wanted) {
        const char *text = zt_find_metadata(input->file, wanted);
        if (!text)
            return cmd_fail(CMD_USAGE, "%s: there is no metadata key '%s'", input->name, wanted);
        /* Made safe for a terminal only where one may be: a pipe gets every byte. */
        if (cmd_given(args, "raw"))
            fputs(text, stdout);
        else
            cmd_print_safe(stdout, text);
        fputc('\n', stdout);
        return CMD_OK;
    }
    json_t *pairs = json_object();
    for (uint32_t i = 0; i < count; i++) {
        const char *key, *value;
        if (zt_get_metadata(input->file, i, &key, &value) == ZT_OK)
            json_object_set_new(pairs, key, cmd_json_text(value));
    }
    int status = cmd_json_print(stdout, pairs);
    json_decref(pairs);
    return status;
}

/* ---- which image ------------------------------------------------------------------------------------------ */

static int image_of_patch(const cmd_args *args, const cmd_input *input, uint32_t texture, uint32_t layer,
                          uint32_t *image) {
    uint32_t number = (uint32_t)cmd_integer(args, "patch");
    zt_patch_info patch;
    if (zt_get_patch(input->file, texture, number, &patch) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: texture %u has no patch %u", input->name, (unsigned)texture, (unsigned)number);
    if (cmd_given(args, "mask")) {
        *image = patch.mask;
        return patch.mask != ZT_NONE
                   ? CMD_OK
                   : cmd_fail(CMD_USAGE, "%s: patch %u has no mask: its coverage is the alpha of its image",
                              input->name, (unsigned)number);
    }
    if (patch.texture != ZT_NONE) {
        cmd_error("%s: patch %u shows the texture %u", input->name, (unsigned)number, (unsigned)patch.texture);
        cmd_hint("Extract that one with --texture %u.", (unsigned)patch.texture);
        return CMD_USAGE;
    }
    *image = zt_get_patch_image(input->file, texture, number, layer);
    return CMD_OK;
}

static int image_of_base(const cmd_args *args, const cmd_input *input, uint32_t texture, uint32_t *image) {
    uint32_t number = (uint32_t)cmd_integer(args, "base");
    zt_umbrella_info info;
    if (zt_get_umbrellas(input->file, texture, &info) != ZT_OK || number >= info.base_count)
        return cmd_fail(CMD_USAGE, "%s: texture %u has no base %u", input->name, (unsigned)texture, (unsigned)number);
    if (info.bases[number].shows_texture) {
        cmd_error("%s: base %u shows the texture %u", input->name, (unsigned)number,
                  (unsigned)info.bases[number].source);
        cmd_hint("Extract that one with --texture %u.", (unsigned)info.bases[number].source);
        return CMD_USAGE;
    }
    *image = info.bases[number].source;
    return CMD_OK;
}

/* What a layer without an image can give. */
static int no_image(const cmd_args *args, const cmd_input *input, uint32_t texture) {
    zt_umbrella_info info;
    if (cmd_given(args, "minified") || zt_get_umbrellas(input->file, texture, &info) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: texture %u has no %simage", input->name, (unsigned)texture,
                        cmd_given(args, "minified") ? "minified " : "");
    cmd_error("%s: texture %u is made of umbrellas: there is no image of it", input->name, (unsigned)texture);
    cmd_hint("--base N gives the picture of a base, --bases all of them, --arrangement what lies where.");
    return CMD_USAGE;
}

static int find_image(const cmd_args *args, const cmd_input *input, uint32_t *image) {
    static const char *const others[] = {"texture", "layer", "patch", "mask", "minified", "base"};
    uint32_t texture, layer;
    zt_layer_info row;
    if (cmd_given(args, "image")) {
        *image = (uint32_t)cmd_integer(args, "image");
        for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
            if (cmd_given(args, others[i]))
                return cmd_usage(args, "--image and --%s exclude each other", others[i]);
        return CMD_OK;
    }
    int status = pick_texture(input, cmd_text(args, "texture"), &texture);
    if (status == CMD_OK)
        status = pick_layer(input, texture, cmd_text(args, "layer"), &layer);
    if (status != CMD_OK)
        return status;
    if (cmd_given(args, "patch") || cmd_given(args, "mask"))
        return image_of_patch(args, input, texture, layer, image);
    if (cmd_given(args, "base"))
        return image_of_base(args, input, texture, image);
    if (zt_get_layer(input->file, texture, layer, &row) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "%s: the texture has no image", input->name);
    *image = cmd_given(args, "minified") ? zt_get_silmap_minified(input->file, texture, layer) : row.image;
    return *image == ZT_NONE ? no_image(args, input, texture) : CMD_OK;
}

static int read_part(const cmd_args *args, const cmd_input *input, extract_part *part) {
    uint32_t image = 0, n[4];
    zt_level_info size;
    int status = find_image(args, input, &image);
    if (status == CMD_OK)
        status = extract_part_of(input->file, input->name, image, (uint32_t)cmd_integer(args, "level"), part);
    if (status != CMD_OK)
        return status;
    zt_get_level(input->file, image, part->region.level, &size);
    part->quality = (int)cmd_integer(args, "quality");
    part->region.layer = (uint32_t)cmd_integer(args, "array-layer");
    part->region.z = (uint32_t)cmd_integer(args, "slice");
    if (part->region.layer >= part->info.layers)
        return cmd_usage(args, "--array-layer %u: there are %u, from 0 on", (unsigned)part->region.layer,
                         (unsigned)part->info.layers);
    if (part->region.z >= size.depth)
        return cmd_usage(args, "--slice %u: there are %u, from 0 on", (unsigned)part->region.z, (unsigned)size.depth);
    if (cmd_given(args, "raw") && !cmd_given(args, "slice"))
        part->region.depth = size.depth;
    const char *text = cmd_text(args, "region");
    if (!text)
        return CMD_OK;
    if (pick_integers(text, n, 4) || n[2] == 0 || n[3] == 0)
        return cmd_usage(args, "--region '%s': four whole numbers x,y,width,height are wanted", text);
    if ((uint64_t)n[0] + n[2] > size.width || (uint64_t)n[1] + n[3] > size.height)
        return cmd_usage(args, "--region '%s': the level has %u x %u texels", text, (unsigned)size.width,
                         (unsigned)size.height);
    part->region.x = n[0];
    part->region.y = n[1];
    part->region.width = n[2];
    part->region.height = n[3];
    return CMD_OK;
}

static int extract_one(cmd_args *args, const cmd_input *input, const char *path) {
    extract_part part;
    cmd_progress progress;
    int status = read_part(args, input, &part);
    if (status != CMD_OK)
        return status;
    cmd_progress_begin(&progress, args, "extracting");
    status = cmd_given(args, "raw") ? extract_raw(args, &part, path, &progress)
                                    : extract_picture(args, &part, path, &progress);
    cmd_progress_end(&progress);
    return status;
}

static int extract_drawing(const cmd_args *args, const cmd_input *input, const char *path) {
    static const char *const others[] = {"image", "patch", "mask", "minified", "level", "slice", "region", "raw"};
    uint32_t texture, layer;
    cmd_output output = {0};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        if (cmd_given(args, others[i]))
            return cmd_usage(args, "--cells and --%s exclude each other", others[i]);
    int status = pick_texture(input, cmd_text(args, "texture"), &texture);
    if (status == CMD_OK)
        status = pick_layer(input, texture, cmd_text(args, "layer"), &layer);
    if (status == CMD_OK)
        status = cmd_output_open(&output, path, 0);
    if (status == CMD_OK)
        status = extract_cells(input->file, input->name, texture, layer, (uint32_t)cmd_integer(args, "array-layer"),
                               output.stream);
    return cmd_output_end(&output, status);
}

/* The type of the output says the form. */
static int extract_umbrellas(cmd_args *args, const cmd_input *input, const char *path) {
    static const char *const others[] = {"image", "patch",  "mask", "minified", "base",
                                         "slice", "region", "raw",  "cells"};
    size_t length = strlen(path);
    uint32_t texture, level = (uint32_t)cmd_integer(args, "level");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        if (cmd_given(args, others[i]))
            return cmd_usage(args, "--arrangement and --%s exclude each other", others[i]);
    int status = pick_texture(input, cmd_text(args, "texture"), &texture);
    if (status != CMD_OK)
        return status;
    if (length > 5 && strcmp(path + length - 5, ".gltf") == 0)
        return extract_model(args, input, texture, level, path);
    if (strcmp(path, "-") == 0 || (length > 4 && strcmp(path + length - 4, ".svg") == 0))
        return extract_arrangement(input, texture, level, path);
    return cmd_usage(args, "--arrangement is written as .svg or .gltf");
}

static int extract_all_bases(cmd_args *args, const cmd_input *input, const char *folder) {
    cmd_progress progress;
    uint32_t texture;
    int status = pick_texture(input, cmd_text(args, "texture"), &texture);
    if (status != CMD_OK)
        return status;
    cmd_progress_begin(&progress, args, "extracting");
    status = extract_bases(args, input, texture, folder, &progress);
    cmd_progress_end(&progress);
    return status;
}

static int check_dzi(const cmd_args *args) {
    static const char *const others[] = {"image",  "patch", "mask",  "minified",    "level", "slice",
                                         "region", "raw",   "cells", "arrangement", "base"};
    static const char *const own[] = {"tile-size", "overlap", "max-size", "format"};
    int given = cmd_given(args, "dzi");
    for (size_t i = 0; given && i < sizeof others / sizeof others[0]; i++)
        if (cmd_given(args, others[i]))
            return cmd_usage(args, "--dzi and --%s exclude each other", others[i]);
    for (size_t i = 0; !given && i < sizeof own / sizeof own[0]; i++)
        if (cmd_given(args, own[i]))
            return cmd_usage(args, "--%s goes with --dzi", own[i]);
    return CMD_OK;
}

static int run(cmd_args *args) {
    const char *path = cmd_text(args, "output"), *folder = cmd_text(args, "all"), *key = cmd_text(args, "key");
    const char *pyramid = cmd_text(args, "dzi"), *bases = cmd_text(args, "bases");
    int prints = key || cmd_given(args, "meta");
    cmd_input input;
    if ((path != NULL) + (folder != NULL) + (pyramid != NULL) + (bases != NULL) + prints != 1)
        return cmd_usage(args, "one of --output, --all, --bases, --dzi, --meta and --key is wanted");
    if (cmd_given(args, "arrangement") && !path)
        return cmd_usage(args, "--arrangement needs --output: an SVG or glTF file");
    if (cmd_given(args, "cells") && !path)
        return cmd_usage(args, "--cells needs --output: an SVG file, or -");
    if (path && strcmp(path, "-") == 0 && !cmd_given(args, "raw") && !cmd_given(args, "cells") &&
        !cmd_given(args, "arrangement"))
        return cmd_usage(args, "a picture needs a name: its extension says the type. Bytes go out with --raw");
    int status = check_dzi(args);
    if (status == CMD_OK && (path || pyramid))
        status = cmd_check_output(path ? path : pyramid, args->operands, 1);
    if (status == CMD_OK)
        status = cmd_open(args, args->operands[0], 0, &input);
    if (status != CMD_OK)
        return status;
    if (prints)
        status = print_metadata(args, &input, key);
    else if (folder)
        status = extract_all(args, &input, folder);
    else if (pyramid)
        status = extract_dzi(args, &input, pyramid);
    else if (bases)
        status = extract_all_bases(args, &input, bases);
    else if (cmd_given(args, "arrangement"))
        status = extract_umbrellas(args, &input, path);
    else
        status = cmd_given(args, "cells") ? extract_drawing(args, &input, path) : extract_one(args, &input, path);
    cmd_close(&input);
    return status;
}

const cmd_verb verb_extract = {
    .name = "extract",
    .summary = "Get images, bytes or metadata out of a texture file",
    .synopsis = "[OPTION]... FILE -o OUT\nFILE --cells -o CELLS.svg\nFILE --arrangement -o OUT.svg|OUT.gltf\nFILE "
                "--bases FOLDER\nFILE --all FOLDER\nFILE --dzi OUT.dzi\nFILE "
                "--meta | --key KEY",
    .text =
        "Writes one slice of one level of an image as a picture. Integers go into png as they are, sRGB stays sRGB and "
        "straight alpha straight. Floats go into exr, with premultiplied alpha. Where the picture's type cannot hold "
        "the texels, colours are converted by way of linear light. Texels of block formats come out with --raw only.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 1,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
