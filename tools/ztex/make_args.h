/* SPDX-License-Identifier: Apache-2.0 */
/* Options that all verbs `make ...` have: rows for their tables, and what the words behind them become. */
#ifndef ZTEX_MAKE_ARGS_H
#define ZTEX_MAKE_ARGS_H

#include "make.h"
#include "write_args.h"

#define MAKE_OPTION_NAME                                                                    \
    {                                                                                       \
        .name = "name", .letter = 'n', .metavar = "NAME", .kind = CMD_TEXT,                 \
        .help = "Name of the texture. Default: the picture's without folder and extension." \
    }

#define MAKE_OPTION_FORMAT                                                                            \
    {                                                                                                 \
        .name = "format", .letter = 'f', .metavar = "FORMAT", .kind = CMD_FORMAT,                     \
        .help = "Texel format, such as R8G8B8A8_SRGB ('ztex help formats' lists them). Default: the " \
                "picture's own channels and depth; 8-bit colours become SRGB formats. Colours are "   \
                "converted where the format's coding differs."                                        \
    }

/* Of these modes MODE is the default. MORE: what the help says besides. */
#define MAKE_OPTION_WRAP(MODE, MORE)                                                                                   \
    {                                                                                                                  \
        .name = "wrap", .letter = 'w', .metavar = "MODE", .kind = CMD_CHOICE, .choices = "repeat|mirror|clamp|border", \
        .fallback = MODE, .help = "How the texture goes on beyond its edges." MORE                                     \
    }

#define MAKE_OPTION_LEVELS                                                                            \
    {                                                                                                 \
        .name = "levels", .metavar = "N", .kind = CMD_INTEGER, .min = 1, .max = 32, .choices = "all", \
        .fallback = "all", .help = "Mip levels, the first being the picture."                         \
    }

#define MAKE_OPTION_MIP_FILTER                                                                                      \
    {                                                                                                               \
        .name = "mip-filter", .metavar = "FILTER", .kind = CMD_CHOICE, .choices = "kaiser|mitchell|triangle|box",   \
        .fallback = "kaiser", .help = "Filter for the smaller levels. It works in linear light, weighted by alpha." \
    }

#define MAKE_OPTION_META                                                       \
    {                                                                          \
        .name = "meta", .metavar = "KEY=VALUE", .kind = CMD_TEXT, .repeat = 1, \
        .help = "Metadata, such as zt.title=Brick."                            \
    }

#define MAKE_OPTION_LICENSE                                                 \
    {                                                                       \
        .name = "license", .metavar = "SPDX", .kind = CMD_TEXT,             \
        .help = "Licence of the work, an SPDX expression: sets zt.license." \
    }

#define MAKE_OPTION_WRITER \
    { .name = "writer", .help = "Name this program in the metadata. Not by default: equal input gives equal bytes." }

#define MAKE_OPTION_TILE_EDGE                                                                                       \
    {                                                                                                               \
        .name = "tile-edge", .metavar = "N", .kind = CMD_INTEGER, .min = 16, .max = 65536,                          \
        .choices = "16|32|64|128|256|512|1024", .fallback = "256",                                                  \
        .help = "Edge of the tiles that are compressed and read one by one, a power of two. With --effort 9 it is " \
                "chosen where it is not given."                                                                     \
    }

#define MAKE_OPTION_EFFORT                                                                           \
    {                                                                                                \
        .name = "effort", .metavar = "N", .kind = CMD_INTEGER, .min = 1, .max = 9, .fallback = "5",  \
        .help = "Effort of the compression: 1 is fast, 9 is small, and tries other tile edges, too." \
    }

/* --meta, --license and --writer behind what scene->metadata has. */
int make_add_metadata(const cmd_args *args, make_scene *scene);
/* Who made the picture goes with it, into scene->metadata. Texts that are not UTF-8 stay behind. */
int make_copy_authorship(make_scene *scene, const char *path);
/* What --layer says, SEMANTIC=FILE, when the texture has count layers already. */
int make_read_layer(const cmd_args *args, const char *word, uint32_t count, uint32_t *semantic, const char **path);
/* --name, or the name of the picture at path without folder and extension; "" when the format does not allow it. */
const char *make_texture_name(const cmd_args *args, make_scene *scene, const char *path);
/* make_file.c: stores the scene. What it names are originals, which neither the output nor the report (NULL: there is
 * none) may replace. */
int make_file_of(cmd_args *args, const make_scene *scene, const char *output, const char *report);

#endif
