/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex convert`: verb_convert.c reads the wishes and copies textures and the rest; convert_plan.c says
 * what becomes of each image; convert_image.c does it.
 */
#ifndef ZTEX_CONVERT_H
#define ZTEX_CONVERT_H

#include "command.h"

/* What textures say about an image. */
typedef struct convert_use {
    int used;
    int is_mask;
    int is_samples; /* of a silmap: one level, and no more */
    int covers;     /* the coverage of a patch: zero on its border */
    uint32_t semantic;
    uint8_t wrap[3];
} convert_use;

typedef struct convert_job {
    cmd_args *args;
    cmd_input input;
    zt_writer *writer;
    cmd_progress progress;
    /* Wishes; 0, NULL or -1: as it is. */
    int recode; /* tiles are compressed anew */
    uint32_t tile_edge;
    const zt_format_info *format;
    int semantic; /* that format is for; -1: all colours */
    int transfer;
    uint32_t levels;
    int all_levels, rebuild;
    uint8_t mip_filter;
    int strip, strip_patches;
    /* Of each texture: is it kept, and its number in the output. */
    zt_file_info file;
    uint8_t *keep;
    uint32_t *textures;
    convert_use *uses; /* of each image */
    uint32_t *images;  /* number in the output */
    uint64_t bytes_done, bytes_total;
    uint64_t tiles_copied; /* as they were stored */
    uint32_t reformatted;
} convert_job;

/* convert_plan.c: fills in uses from the textures that are kept. A cmd_status. */
int convert_find_uses(convert_job *job);

typedef struct convert_plan {
    zt_image_info from;
    zt_image_desc to;
    int stored;   /* 1: tiles are copied bit for bit */
    int reformat; /* 1: by way of floats */
} convert_plan;

int convert_plan_image(convert_job *job, uint32_t image, convert_plan *plan);

/* convert_image.c: adds the image to the writer and fills it. */
int convert_copy_image(convert_job *job, uint32_t image);
/* Bytes of texels that will be read, for the progress. */
uint64_t convert_image_size(const convert_job *job, uint32_t image);

#endif
