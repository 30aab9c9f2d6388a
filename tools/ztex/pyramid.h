/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures that are folders of tiles: Deep Zoom (NAME.dzi with NAME_files), Zoomify (ImageProperties.xml) and static
 * folders of the IIIF Image API (info.json). Behind image_io.h such a picture is like any other; only a row of its
 * tiles is in memory at once.
 *
 * Descriptors may be hostile: file names are made of checked numbers and words out of a list, sizes have limits.
 * `error` has IMG_ERROR bytes. Level 0 is the finest; level k is as large as the finest divided by 2^k, rounded up, or
 * at some folders of Zoomify down.
 */
#ifndef ZTEX_PYRAMID_H
#define ZTEX_PYRAMID_H

#include "image_io.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PYRAMID_PATH 4096
#define PYRAMID_SIDE (UINT32_C(1) << 30) /* texels */
#define PYRAMID_TILE (UINT32_C(1) << 16)

typedef struct pyramid pyramid;

int pyramid_is(const char *path); /* by its name */
pyramid *pyramid_open(const char *path, char *error);
void pyramid_close(pyramid *p); /* NULL is allowed */
/* As the first tile says, but with the size of the finest level in full_width and full_height. */
const img_info *pyramid_info(const pyramid *p);
uint32_t pyramid_levels(const pyramid *p);
void pyramid_size(const pyramid *p, uint32_t level, uint32_t *width, uint32_t *height);
uint32_t pyramid_tile_height(const pyramid *p);
/* All rows of texels of one row of tiles, tight, in the type of pyramid_info. 0, or -1 with error. */
int pyramid_read(pyramid *p, uint32_t level, uint32_t tile_row, void *dst, char *error);

/* ---- between the files ------------------------------------------------------------------------------------- */

typedef enum pyramid_kind { PYRAMID_DZI = 0, PYRAMID_IIIF = 1, PYRAMID_ZOOMIFY = 2 } pyramid_kind;

typedef struct pyramid_plan {
    pyramid_kind kind;
    uint32_t width, height, tile_width, tile_height, overlap;
    uint32_t levels;
    int round_down; /* sizes of levels */
    char extension[8];
    char folder[PYRAMID_PATH]; /* of the tiles, with its slash */
    size_t shown;              /* where in folder what messages show begins: beside the descriptor */
    unsigned naming;           /* IIIF: how the folder writes regions and sizes */
} pyramid_plan;

/* A tile of a level: what it shows without overlap. */
typedef struct pyramid_tile {
    uint32_t level, column, row;
    uint32_t x, y, width, height;
} pyramid_tile;

uint32_t pyramid_reduce(const pyramid_plan *plan, uint32_t size, uint32_t level);
/* The whole file, with a NUL behind it, malloc'd; NULL with error. */
char *pyramid_read_text(const char *path, size_t *size, char *error);
/* The extension of a kind of picture that tiles may be, in small letters, or NULL. */
const char *pyramid_find_extension(const char *word);
int pyramid_check_size(const pyramid_plan *plan, char *error);
/* path: PYRAMID_PATH bytes. 0, or -1: too long. */
int pyramid_tile_path(const pyramid_plan *plan, const pyramid_tile *tile, char *path);
/* Takes the descriptor's own folder for that of the tiles. */
int pyramid_take_folder(const char *path, pyramid_plan *plan, char *error);
/* Tries extensions, and namings below the given number, until the file of the tile is there. */
int pyramid_find_tile(pyramid_plan *plan, const pyramid_tile *tile, unsigned namings, char *error);

/* Called for each element, depth 0 being the outermost; pairs are names and values of attributes, and a NULL. Returns
 * NULL, or what is wrong. */
typedef const char *pyramid_visit(void *user, unsigned depth, const char *name, const char **pairs);
int pyramid_parse_xml(const char *text, size_t size, pyramid_visit *visit, void *user, char *error);
uint32_t pyramid_whole(const char *text); /* UINT32_MAX: no whole number, or too large */

int pyramid_plan_dzi(const char *path, pyramid_plan *plan, char *error);
int pyramid_plan_iiif(const char *path, pyramid_plan *plan, char *error);
int pyramid_plan_zoomify(const char *path, pyramid_plan *plan, char *error);
/* The path behind the folder. */
void pyramid_name_dzi(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size);
void pyramid_name_iiif(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size);
void pyramid_name_zoomify(const pyramid_plan *plan, const pyramid_tile *tile, char *name, size_t size);

#ifdef __cplusplus
}
#endif

#endif
