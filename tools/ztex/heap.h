/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex make zipmap`: photographs are opened (heap_photos.c), registered by the authoring library, and
 * become a scene (heap_scene.c), the same JSON that people write by hand. What makes scenes into files makes this one
 * too.
 */
#ifndef ZTEX_HEAP_H
#define ZTEX_HEAP_H

#include <author_zipmap.h>

#include "make.h"

typedef struct heap_photo {
    const char *path;       /* as on the command line */
    const char *name;       /* of its patch: the file's without folder and extension, made unique */
    uint32_t width, height; /* upright */
} heap_photo;

/* A map that goes with the photographs, of --layer. */
typedef struct heap_layer {
    const char *semantic;
    const char *const *paths; /* for each photograph; NULL for those that are not placed */
} heap_layer;

typedef struct heap {
    cmd_args *args;
    make_scene memory; /* owns texts and tables, and the metadata of the command line */
    heap_photo *photos;
    size_t count;
    heap_layer layers[MAKE_LAYERS];
    size_t layer_count;
    author_registration found;
} heap;

/* heap_photos.c */
/* Opens every photograph for its size and gives it a name. */
int heap_open_photos(heap *h);
/* Who is a zoom into whom: fills h->found. Prints its messages. */
int heap_register(heap *h);
/* Finds the files of each --layer for all photographs that have a place. */
int heap_find_layers(heap *h);

/* heap_scene.c */
/* What the scene is for. */
typedef enum heap_purpose {
    HEAP_RESULT = 0, /* the file that was asked for */
    HEAP_BEFORE = 1, /* the same pictures as they are, small, for the report */
    HEAP_PLAIN = 2   /* as in the result, but opaque */
} heap_purpose;
/* File names are relative to folder, which is absolute and ends with a slash; "": they stay as on the command line. */
int heap_scene(const heap *h, heap_purpose purpose, const char *folder, json_t **out);

/* verb_make_zipmap.c: the scene into a file. how: its user and progress are filled in. */
int heap_store(cmd_args *args, const json_t *scene, const char *output, zt_writer_options *how, const char *label);

#endif
