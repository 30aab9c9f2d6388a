/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex extract`: one slice of one level of an image becomes a picture or plain bytes (extract_rows.c), or all
 * of a file becomes a folder with a scene for `ztex make` (extract_all.c), or the cells of a silmap a drawing (extract_silmap.c).
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

/* Writes a picture; its type is that of the path's extension. Values stay as they are where the type can hold them; else colours
 * are converted by way of linear light. progress may be NULL. */
int extract_picture(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress);

/* The region's bytes, tight, rows of blocks from the top down, slice after slice. "-": standard output. */
int extract_raw(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress);

/* extract_silmap.c: the cells of a silmap as a drawing: points, arms (those that are cut thick) and the samples' colours. */
int extract_cells(const zt_file *file, const char *name, uint32_t texture, uint32_t layer, uint32_t array_layer,
                  FILE *stream);

/* extract_dzi.c: the texture as a Deep Zoom pyramid: the descriptor at path, and a folder of tiles beside it. */
int extract_dzi(cmd_args *args, const cmd_input *input, const char *path);

/* Everything, into a folder that is made if it is not there. */
int extract_all(cmd_args *args, const cmd_input *input, const char *folder);

#endif
