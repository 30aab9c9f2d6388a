/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The report of `ztex make zipmap`: what was found (heap.h), what the file that was made shows along its seams
 * (heap_seams.c), and pictures of it (heap_look.c), as JSON (report_json.c) or as a page (report_html.c).
 */
#ifndef ZTEX_HEAP_REPORT_H
#define ZTEX_HEAP_REPORT_H

#include "heap.h"

/* Differences between a patch and its parent along the seam, of sRGB-coded values, full range being 255: between the
 * mean colours of both in squares of HEAP_LOWPASS texels of the parent through which the seam goes. A texel counts by
 * how much the patch covers there. */
#define HEAP_LOWPASS 8
typedef struct heap_steps {
    double median, high, worst; /* along the seam; high: 95 of 100 places are below */
    double sharp; /* the worst when only what is half transparent counts: where edges are not equally sharp in both */
    double mean;  /* of the means over the whole patch, the channel in which it is largest */
} heap_steps;

typedef struct heap_seam {
    uint32_t photo, texture, patch;
    size_t places; /* along the seam, where steps were measured; 0: the patch is too small to measure */
    heap_steps before, after;
    double opaque, partly; /* shares of the patch's texels */
} heap_seam;

typedef struct heap_report {
    const heap *heap;
    const char *output;
    zt_file *before, *plain,
        *after;       /* as the pictures are; with adjusted colours, but opaque; the file that was made */
    heap_seam *seams; /* one for each placed photograph, in the order of the file */
    size_t seam_count;
} heap_report;

/* heap_seams.c. Fills seams; the files are open. */
int heap_measure_seams(heap_report *report);
/* Root coordinates of the corner i of a patch, (0,0) (1,0) (1,1) (0,1). 0, or -1: its matrix has no inverse. */
int heap_patch_corner(const zt_file *file, uint32_t texture, uint32_t patch, int i, double *u, double *v);

/* heap_look.c: pictures as texts "data:image/jpeg;base64,...", malloc'd; NULL with a printed message. */
char *heap_look_photo(const heap_report *report, uint32_t photo);
char *heap_look_view(const heap_report *report, const zt_file *file, const heap_seam *seam);
char *heap_look_mask(const heap_report *report, const heap_seam *seam);

/* One level of an image in linear light, four floats a texel, never premultiplied. release: free(texels). */
typedef struct heap_flat {
    uint32_t width, height;
    float *texels;
} heap_flat;
int heap_flat_load(const zt_file *file, uint32_t image, uint32_t level, heap_flat *out);
/* The coverage of a patch at a level of its first image, in the fourth channel of out. */
int heap_flat_coverage(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t level, heap_flat *out);

/* report_json.c, report_html.c: onto the stream. */
int heap_report_json(const heap_report *report, FILE *stream);
int heap_report_html(const heap_report *report, FILE *stream);

/* All of it: makes the file of the pictures before adjustment, measures, writes to path. */
int heap_write_report(const heap *h, const char *output, const char *path);

#endif
