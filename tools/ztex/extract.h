/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex extract`: one slice of one level of an image becomes a picture or plain bytes (extract_rows.c),
 * or all of a file becomes a folder with a scene for `ztex make` (extract_all.c), or the cells of a silmap a drawing
 * (extract_silmap.c), or umbrellas their bases and their arrangement (extract_umbrella.c, extract_model.c).
 */
#ifndef ZTEX_EXTRACT_H
#define ZTEX_EXTRACT_H

#include "command.h"
#include "image_io.h"

typedef struct extract_part {
    const zt_file *file;
    const char *name; /* of the file, for messages */
    uint32_t image;
    zt_image_info info;
    const zt_format_info *format; /* NULL: not in the registry */
    int is_colour;
    zt_region region; /* depth 1 for pictures */
    int quality;      /* of lossy pictures; 0: the usual one */
} extract_part;

/* Fills in everything for the whole of slice 0 of a level of array layer 0. Prints the message on failure. */
int extract_part_of(const zt_file *file, const char *name, uint32_t image, uint32_t level, extract_part *part);

/* Why there can be no picture of it, or NULL. */
const char *extract_refusal(const extract_part *part);

/* Writes a picture; its type is that of the path's extension. Values stay as they are where the type can hold them;
 * else colours are converted by way of linear light. progress may be NULL. */
int extract_picture(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress);

/* The region's bytes, tight, rows of blocks from the top down, slice after slice. "-": standard output. */
int extract_raw(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress);

/* FOLDER/NAME, malloc'd; NULL: no memory. */
char *extract_path(const char *folder, const char *name);

/* The type of picture that holds these texels without any change. extract_refusal has been asked. */
const char *extract_exact_type(const extract_part *part);

/* extract_umbrella.c: each base's picture, and bases.json with their contours, into a folder that is made if it is not
 * there. */
int extract_bases(cmd_args *args, const cmd_input *input, uint32_t texture, const char *folder, cmd_progress *progress);

/* A level of the arrangement as a drawing: the polygons in their mean colours, the grid and the lengths of its
 * lists. */
int extract_arrangement(const cmd_input *input, uint32_t texture, uint32_t level, const char *path);

/* extract_model.c: the same as glTF, fans of triangles with their heights and pictures: path, and .bin and pictures
 * beside it. */
int extract_model(cmd_args *args, const cmd_input *input, uint32_t texture, uint32_t level, const char *path);

/* extract_silmap.c: the cells of a silmap as a drawing: points, arms (those that are cut thick) and the samples'
 * colours. */
int extract_cells(const zt_file *file, const char *name, uint32_t texture, uint32_t layer, uint32_t array_layer,
                  FILE *stream);

/* extract_dzi.c: the texture as a Deep Zoom pyramid: the descriptor at path, and a folder of tiles beside it. */
int extract_dzi(cmd_args *args, const cmd_input *input, const char *path);

/* Everything, into a folder that is made if it is not there. */
int extract_all(cmd_args *args, const cmd_input *input, const char *folder);

#endif
