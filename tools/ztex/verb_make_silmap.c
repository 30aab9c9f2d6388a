/* SPDX-License-Identifier: Apache-2.0 */
/* ztex make silmap: a drawing, a picture or glyphs into a silmap. */
#include <stdlib.h>
#include <string.h>

#include "make_args.h"
#include "silmap.h"

static const cmd_option options[] = {
    WRITE_OPTION_OUTPUT,
    {.name = "cells",
     .letter = 'c',
     .metavar = "N|WxH",
     .kind = CMD_TEXT,
     .help = "Cells along the longer side, or along both. With --quality the most that are tried. Default: 64, or "
             "what --quality needs."},
    {.name = "quality",
     .metavar = "DB",
     .kind = CMD_REAL,
     .help = "Search for the fewest cells whose silmap comes as close to the original as this PSNR."},
    {.name = "edges",
     .metavar = "SVG",
     .kind = CMD_FILE,
     .help = "A drawing over the picture, as from Inkscape: the lines of its paths are edges. The colours are the "
             "picture's."},
    {.name = "edges-only", .help = "With --edges: nothing else is an edge."},
    {.name = "hint",
     .help = "A drawing or glyphs may lie where it suits the cells: edges along the axes become exact where that is "
             "possible, and nothing moves by more than half a cell. Both places are tried, and the better one is kept; "
             "--verbose and --report say which, and where it lies."},
    {.name = "font",
     .metavar = "FILE",
     .kind = CMD_FILE,
     .help = "Instead of a picture: glyphs of this font, as a mask. See --glyph and --text."},
    {.name = "glyph", .metavar = "CHAR", .kind = CMD_TEXT, .help = "With --font: one character, itself or as U+0041."},
    {.name = "text", .metavar = "TEXT", .kind = CMD_TEXT, .help = "With --font: several characters in a line."},
    {.name = "mask",
     .letter = 'm',
     .metavar = "OF",
     .kind = CMD_CHOICE,
     .choices = "alpha|brightness",
     .help = "Make one channel, a mask or a control for a shader, of the picture's alpha or of its brightness as it is "
             "coded."},
    {.name = "filter",
     .metavar = "FILTER",
     .kind = CMD_CHOICE,
     .choices = "continuous|sen2004|nearest",
     .fallback = "continuous",
     .help = "How the colours of a cell's corners are mixed."},
    MAKE_OPTION_NAME,
    {.name = "semantic",
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .choices = "unspecified|base_colour|normal|displacement|roughness|metalness|occlusion|emissive|opacity|specular",
     .help = "What the texels mean. Default: base_colour, of masks and glyphs opacity."},
    {.name = "layer",
     .metavar = "SEMANTIC=FILE",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Another layer in the same cells, such as --layer normal=sign_n.png."},
    MAKE_OPTION_WRAP("clamp", " With repeat its sides meet."),
    {.name = "no-minified",
     .help = "Leave out the small images for lookups from afar: as small as can be, but it glitters there."},
    {.name = "report",
     .metavar = "FILE",
     .kind = CMD_FILE,
     .help = "Write what could not be held, as .html with pictures or as .json."},
    MAKE_OPTION_FORMAT,
    {.name = "alpha",
     .metavar = "MODE",
     .kind = CMD_CHOICE,
     .choices = "none|straight|premultiplied",
     .help = "How alpha is stored; none drops it. Default: straight where something is transparent."},
    MAKE_OPTION_LEVELS,
    MAKE_OPTION_MIP_FILTER,
    MAKE_OPTION_META,
    MAKE_OPTION_LICENSE,
    MAKE_OPTION_WRITER,
    MAKE_OPTION_TILE_EDGE,
    MAKE_OPTION_EFFORT,
    WRITE_OPTION_RAW,
    WRITE_OPTION_NO_FSYNC,
    {0}};

static const cmd_example examples[] = {
    {"ztex make silmap sign.svg --cells 96 -o sign.ztex", "A drawing whose edges stay sharp."},
    {"ztex make silmap sign.svg --quality 32 --report sign.html -o sign.ztex",
     "As few cells as 32 dB need, and a page that shows what they could not hold."},
    {"ztex make silmap sign.svg --cells 96 --hint -o sign.ztex",
     "The same, moved by less than half a cell so that its upright and level edges are held best."},
    {"ztex make silmap leaf.png --mask alpha --cells 64 -o leaf.ztex", "The cut-out of a billboard."},
    {"ztex make silmap wall.jpg --edges wall.svg --edges-only -o wall.ztex", "A photograph with edges drawn by hand."},
    {"ztex make silmap --font DejaVuSans.ttf --glyph '&' --cells 16 -o and.ztex", "A glyph."},
    {0}};

static const char text[] =
    "A silmap is a coarse grid of colours that remembers, in one byte a cell, where an edge runs through it. So edges "
    "stay sharp at every magnification. It suits signs, logos, letters, maps, flat art, cut-outs, and masks that "
    "switch "
    "between materials; of a photograph it holds what has clear edges and is otherwise like any texture.\n"
    "\n"
    "INPUT is a drawing (.svg), or a picture of any format that OpenImageIO reads. A picture should have 8 to 16 "
    "texels a cell. With --font it is glyphs. Edges of drawings and pictures are found by themselves, where flat "
    "colours meet or where the picture says; --edges adds those that an artist draws.\n"
    "\n"
    "A cell holds one edge, a corner or a junction; what is thinner than a cell is lost, and --report says where. A "
    "first word 'silmap' always means this verb: a picture of this name is './silmap'.";

/* ---- the command line ---------------------------------------------------------------------------------------- */

/* UTF-8 of a character that is given as hexadecimal digits; NULL: it is none. */
static const char *character(make_scene *scene, const char *digits) {
    unsigned long code = 0;
    size_t length = strspn(digits, "0123456789abcdefABCDEF");
    char *end = NULL;
    if (length > 0 && length <= 6 && digits[length] == '\0')
        code = strtoul(digits, &end, 16);
    if (code == 0 || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF))
        return NULL;
    if (code < 0x80)
        return make_string(scene, "%c", (int)code);
    int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    char bytes[5] = {0};
    bytes[0] = (char)(0xFF00u >> (more + 1) | code >> 6 * more);
    for (int i = 1; i <= more; i++)
        bytes[i] = (char)(0x80u | (code >> 6 * (more - i) & 0x3Fu));
    return make_string(scene, "%s", bytes);
}

static int read_glyphs(const cmd_args *args, make_scene *scene, make_silmap *silmap) {
    const char *glyph = cmd_text(args, "glyph"), *words = cmd_text(args, "text");
    uint32_t code = 0;
    if (!cmd_given(args, "font"))
        return glyph || words ? cmd_usage(args, "--glyph and --text need --font FILE") : CMD_OK;
    if (!glyph == !words)
        return cmd_usage(args, "--font needs --glyph CHAR or --text TEXT");
    if (cmd_given(args, "edges") || cmd_given(args, "mask"))
        return cmd_usage(args, "glyphs have edges of their own and are a mask: --edges and --mask are for pictures");
    silmap->text = words;
    silmap->mask = SILMAP_ALPHA;
    if (words)
        return words[0] ? CMD_OK : cmd_usage(args, "--text: there is no character in it");
    if ((glyph[0] == 'U' || glyph[0] == 'u') && glyph[1] == '+') {
        silmap->text = character(scene, glyph + 2);
        return silmap->text ? CMD_OK : cmd_usage(args, "--glyph: '%s' is not a character such as U+0041", glyph);
    }
    size_t length = cmd_utf8(glyph, &code);
    silmap->text = glyph;
    if (length == 0 || glyph[0] == '\0' || glyph[length] != '\0')
        return cmd_usage(args, "--glyph: one character is wanted; several are --text");
    return CMD_OK;
}

static int read_wishes(const cmd_args *args, make_scene *scene, make_silmap *silmap) {
    const char *cells = cmd_text(args, "cells");
    int mask = cmd_choice(args, "mask");
    silmap->filter = (zt_silmap_filter)cmd_choice(args, "filter");
    silmap->mask = mask < 0 ? SILMAP_COLOURS : (silmap_mask)(mask + 1);
    silmap->edges = cmd_text(args, "edges");
    silmap->edges_only = cmd_given(args, "edges-only") > 0;
    silmap->hint = cmd_given(args, "hint") > 0;
    silmap->no_minified = cmd_given(args, "no-minified") > 0;
    silmap->quality = cmd_real(args, "quality");
    if (cells && silmap_parse_cells(cells, silmap))
        return cmd_usage(args, "--cells: '%s' is not a number of cells, 1 to %u, or two as in 96x64", cells,
                         (unsigned)SILMAP_CELLS_MOST);
    if (cmd_given(args, "quality") && !(silmap->quality > 0 && silmap->quality < 1000))
        return cmd_usage(args, "--quality: dB above 0 are wanted, such as 30");
    if (silmap->edges_only && !silmap->edges)
        return cmd_usage(args, "--edges-only goes with --edges");
    return read_glyphs(args, scene, silmap);
}

static make_image *image_of(make_scene *scene, const char *path) {
    make_image *image = make_alloc(scene, 1, sizeof *image);
    make_file *file = make_alloc(scene, 1, sizeof *file);
    if (!image || !file)
        return NULL;
    file->path = path;
    *image = (make_image){.files = file, .file_count = 1, .options = scene->defaults, .pointer = ""};
    return image;
}

static int add_layers(const cmd_args *args, make_scene *scene, make_texture *texture) {
    int count = cmd_given(args, "layer");
    for (int i = 0; i < count; i++) {
        const char *word = cmd_text_at(args, "layer", (size_t)i), *path;
        uint32_t semantic;
        int status = make_read_layer(args, word, texture->layer_count, &semantic, &path);
        if (status != CMD_OK)
            return status;
        texture->semantics[texture->layer_count] = semantic;
        texture->images[texture->layer_count] = image_of(scene, path);
        if (!texture->images[texture->layer_count++])
            return CMD_INTERNAL;
    }
    return CMD_OK;
}

static int read_defaults(const cmd_args *args, make_options *o) {
    *o = (make_options){.alpha = cmd_choice(args, "alpha"),
                        .transfer = MAKE_UNSET,
                        .primaries = MAKE_UNSET,
                        .mip_filter = cmd_choice(args, "mip-filter"),
                        .levels = (int)cmd_integer(args, "levels")};
    return write_read_tile_edge(args, &o->tile_edge);
}

/* The scene of one texture that the command line describes. */
static int describe(const cmd_args *args, make_scene *scene, make_silmap *silmap, const char *path) {
    make_texture *texture = make_alloc(scene, 1, sizeof *texture);
    const char *format = cmd_text(args, "format");
    const char *usual = silmap->mask == SILMAP_COLOURS ? "base_colour" : "opacity";
    const char *semantic = cmd_text(args, "semantic") ? cmd_text(args, "semantic") : usual;
    uint8_t wrap = (uint8_t)cmd_choice(args, "wrap");
    if (!texture)
        return CMD_INTERNAL;
    make_image *image = image_of(scene, path);
    if (!image)
        return CMD_INTERNAL;
    if (cmd_semantic_number(semantic) < 0)
        return cmd_usage(args, "--semantic: there is no '%s'", semantic);
    image->options.format = format ? zt_find_format_name(format)->format : 0;
    *texture = (make_texture){.name = make_texture_name(args, scene, path),
                              .wrap = {wrap, wrap, wrap},
                              .layer_count = 1,
                              .semantics = {(uint32_t)cmd_semantic_number(semantic)},
                              .images = {image},
                              .silmap = silmap,
                              .pointer = ""};
    scene->textures = texture;
    scene->texture_count = 1;
    int status = add_layers(args, scene, texture);
    return status == CMD_OK ? make_add_metadata(args, scene) : status;
}

/* ---- running -------------------------------------------------------------------------------------------------- */

static int run(cmd_args *args) {
    const char *output = cmd_text(args, "output"), *report = cmd_text(args, "report"), *font = cmd_text(args, "font");
    const char *input = font ? font : args->operand_count ? args->operands[0] : NULL;
    silmap_made made = {0};
    make_silmap silmap = {.made = report ? &made : NULL};
    make_scene scene = {.folder = ""};
    if (!output)
        return cmd_usage(args, "-o FILE is missing: where shall the texture go?");
    if (!input || (font && args->operand_count))
        return cmd_usage(args,
                         font ? "either a picture or --font, not both" : "which drawing or picture? Or --font FILE");
    if (strcmp(input, "-") == 0)
        return cmd_usage(args, "a silmap is made of files with names: their extension says what they are");
    if (report && strcmp(output, "-") == 0)
        return cmd_usage(args, "--report looks at the file that was made: give it a name with -o");
    int status = read_defaults(args, &scene.defaults);
    if (status == CMD_OK)
        status = read_wishes(args, &scene, &silmap);
    if (status == CMD_OK)
        status = describe(args, &scene, &silmap, input);
    if (status == CMD_OK)
        status = make_file_of(args, &scene, output, report);
    if (status == CMD_OK && report)
        status = silmap_write_report(args, &made, input, output, report);
    author_silmap_release(&made.result);
    make_scene_release(&scene);
    return status;
}

const cmd_verb verb_make_silmap = {
    .name = "make silmap",
    .summary = "Make a silmap, whose edges stay sharp, from a drawing, a picture or glyphs",
    .synopsis = "[OPTION]... INPUT -o OUT.ztex\n[OPTION]... --font FILE --glyph CHAR -o OUT.ztex",
    .text = text,
    .options = options,
    .examples = examples,
    .operand = CMD_FILE,
    .min_operands = 0,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
