/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex make`: a scene, read from JSON (scene.c) or built from the command line (verb_make.c), is placed (place.c) and
 * stored (store.c, store_rows.c).
 */
#ifndef ZTEX_MAKE_H
#define ZTEX_MAKE_H

#include "command.h"
#include "image_io.h"

#define MAKE_LAYERS 32  /* of a texture, the format's limit */
#define MAKE_UNSET (-1) /* a wish that nobody uttered */
#define MAKE_RAMP 8     /* texels, when nobody says otherwise */

/* Wishes for an image. They come from the command line, then the scene's and the texture's defaults, then the image. */
typedef struct make_options {
    uint32_t format; /* 0: chosen by the picture */
    int alpha, transfer, primaries, mip_filter, tile_edge;
    int levels; /* 0: all */
    int keep_orientation;
} make_options;

typedef struct make_file {
    const char *path;
    uint32_t subimage;
} make_file;

/* Pictures that become one image of the texture file. */
typedef struct make_image {
    const make_file *files; /* one; several are array layers or, with volume, slices */
    size_t file_count;
    int layer_kind; /* zt_layer_kind */
    int volume, all_subimages;
    img_rect crop;
    uint32_t resize_width, resize_height;
    make_options options;
    const char *pointer; /* where in the scene; "" on the command line */
} make_image;

typedef enum make_place {
    PLACE_NONE = 0,
    PLACE_OFFSET = 1,      /* numbers: u, v, width, height in the parent's coordinates */
    PLACE_CORNERS = 2,     /* numbers: u0, v0, ... u3, v3 of (0,0) (1,0) (1,1) (0,1) */
    PLACE_PIXELS = 3,      /* numbers: x, y, width, height in texels of the parent's level 0 */
    PLACE_MATRIX = 4,      /* numbers: the matrix from the parent's coordinates to the patch's */
    PLACE_MATRIX_ROOT = 5, /* numbers: the matrix from the root's */
    PLACE_CROP = 6         /* where the crop of the patch's picture was in that picture, which the parent shows whole */
} make_place;

typedef struct make_patch {
    const char *name; /* NULL: none */
    uint32_t parent;
    uint32_t texture; /* index of the texture it shows, or ZT_NONE */
    const make_image *images[MAKE_LAYERS];
    const make_image *mask; /* NULL: none */
    uint32_t ramp;          /* texels; 1: only the border */
    int separate_mask;
    make_place place;
    double numbers[9];
    const char *pointer;
} make_patch;

typedef struct make_texture {
    const char *name;
    int is_zipmap;
    uint8_t wrap[3];
    uint32_t layer_count;
    uint32_t semantics[MAKE_LAYERS];
    const make_image *images[MAKE_LAYERS]; /* kind image */
    make_patch *patches;                   /* kind zipmap; the first is the root */
    uint32_t patch_count;
    const char *pointer;
} make_texture;

typedef struct make_pair {
    const char *key, *value;
} make_pair;

typedef struct make_scene {
    const char *name;   /* of the scene file for messages; NULL: the command line */
    const char *folder; /* that file names begin from, with its slash; "" for the current one */
    make_options defaults;
    make_texture *textures;
    uint32_t texture_count;
    make_pair *metadata;
    size_t metadata_count;
    struct make_block *blocks; /* all memory of the scene */
} make_scene;

/* Zeroed memory that lives as long as the scene. NULL: no memory, the message is printed. */
void *make_alloc(make_scene *scene, size_t count, size_t size);
char *make_string(make_scene *scene, const char *format, ...) CMD_PRINTF(2, 3);
void make_scene_release(make_scene *scene);

/* "SCENE: POINTER: text" as an error; on the command line "text". Returns CMD_USAGE. */
int make_complain(const make_scene *scene, const char *pointer, const char *format, ...) CMD_PRINTF(3, 4);

/* scene.c: fills the scene from the text of a scene file. name and defaults are set before. Prints its messages. */
int make_scene_parse(make_scene *scene, const char *text, size_t size);

/* place.c. Row-major 3 x 3 matrices. They return NULL or what is wrong. */
typedef struct make_parent {
    uint32_t width, height; /* texels of what the parent shows */
    double root_matrix[9];  /* root to parent */
} make_parent;
typedef struct make_crop {
    img_rect rect; /* width 0: there is none */
    uint32_t full_width, full_height;
} make_crop;
const char *make_place_matrix(const make_patch *patch, const make_parent *parent, const make_crop *crop,
                              double matrix[9]);
void make_matrix_multiply(const double a[9], const double b[9], double out[9]);
extern const double make_identity[9];

/* store_image.c: pictures into the writer. */
typedef enum make_role {
    ROLE_PLAIN = 0,   /* as it is */
    ROLE_COVERED = 1, /* its alpha is the coverage of a patch */
    ROLE_BARE = 2,    /* without alpha: the coverage is in a mask */
    ROLE_MASK = 3     /* the coverage alone, R8_UNORM */
} make_role;

typedef struct make_use {
    uint32_t semantic;
    uint8_t wrap[3];
    make_role role;
    uint32_t ramp;
    const make_image *mask;
} make_use;

typedef struct make_stored {
    char *key;      /* of the description, so that equal ones are stored once */
    uint32_t image; /* index in the writer */
    uint32_t width, height, depth, layers;
    uint32_t full_width, full_height; /* picture before crop and resize */
} make_stored;

typedef struct make_store {
    cmd_args *args;
    const make_scene *scene;
    zt_writer *writer;
    cmd_progress *progress;
    size_t done, total; /* images, for the progress */
    make_stored *stored;
    size_t stored_count, stored_capacity;
} make_store;

/* Stores an image, unless the same one is there. *out is valid until the next call. */
int make_store_image(make_store *store, const make_image *image, const make_use *use, make_stored *out);
/* Has the stored form of this image a coverage channel, that is: ROLE_COVERED, or does it want ROLE_BARE and ROLE_MASK? */
int make_wants_mask(make_store *store, const make_image *image, const make_use *use, int *mask);
void make_store_release(make_store *store);

/* store_rows.c: texels of one picture, in the texture's format. */
typedef struct make_rows {
    img_reader *reader, *mask;
    const img_info *info;
    const zt_format_info *format;
    uint32_t channels;  /* of the texture */
    int map[4];         /* channel of the picture for each, or -1: 0, -2: 1 */
    int source_alpha;   /* channel of the picture that is its coverage, or -1 */
    img_alpha alpha_in; /* NONE: the fourth channel is data */
    zt_alpha alpha_out;
    uint32_t transfer_in, transfer_out;
    make_role role;
    uint32_t ramp;
    int direct;  /* the picture's bytes are the texture's */
    float *rgba; /* scratch: a band of rows */
    float *source;
    float *coverage;
} make_rows;

/* Rows y to y + count of slice z into dst, tight. 0, or -1 with error (IMG_ERROR bytes). */
int make_rows_read(make_rows *rows, uint32_t z, uint32_t y, uint32_t count, void *dst, char *error);

/* store.c: everything into one file. */
int make_store_scene(cmd_args *args, const make_scene *scene, const char *output, const zt_writer_options *options,
                     cmd_progress *progress);

#endif
