/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inside of `ztex make`: a scene, read from JSON (scene.c) or built from the command line (verb_make.c), is placed
 * (place.c) and stored (store.c, store_image.c, store_rows.c). Patches whose pictures are worked on first, in memory,
 * pass through store_treat.c.
 */
#ifndef ZTEX_MAKE_H
#define ZTEX_MAKE_H

#include <author_adjust.h>

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

/* How a patch's colours follow those of what lies beneath it: author_adjust.h. */
typedef enum make_colour { COLOUR_NONE = 0, COLOUR_GAIN = 1, COLOUR_POISSON = 2 } make_colour;

/* What normals of a patch are: their y as in OpenGL or as in Direct3D, in the patch's own frame; or in the root's frame
 * already. */
typedef enum make_normals { NORMALS_Y_UP = 0, NORMALS_Y_DOWN = 1, NORMALS_KEEP = 2 } make_normals;

typedef struct make_patch {
    const char *name; /* NULL: none */
    uint32_t parent;
    uint32_t texture; /* index of the texture it shows, or ZT_NONE */
    const make_image *images[MAKE_LAYERS];
    const make_image *mask; /* NULL: none */
    uint32_t ramp;          /* texels; 1: only the border */
    int separate_mask;
    make_normals normals;
    make_colour colour; /* of the colour layers; not the root's */
    int auto_mask;      /* the gradient density mask of the first layer; mask is NULL then */
    double tau;         /* of auto_mask; 0: chosen by the picture */
    int prune;          /* texels that later patches hide may become anything that costs little; also the root's */
    int bake_affine;    /* a homography is resampled into an affine placement */
    make_place place;
    double numbers[9];
    const char *pointer;
} make_patch;

typedef struct make_silmap make_silmap;       /* silmap.h */
typedef struct make_umbrellas make_umbrellas; /* umbrellas.h */

typedef struct make_texture {
    const char *name;
    int is_zipmap;
    uint8_t wrap[3];
    uint32_t layer_count;
    uint32_t semantics[MAKE_LAYERS];
    const make_image *images[MAKE_LAYERS]; /* kinds image and silmap */
    const make_silmap *silmap;             /* kind silmap; else NULL */
    make_umbrellas *umbrellas;             /* kind umbrellas; else NULL */
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

/* scene_image.c: the one file of image may be a pattern, "walk_%03d.png": then its files are those numbered from 0 or 1
 * on. */
int make_number_files(make_scene *scene, make_image *image);

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
int make_matrix_invert(const double m[9], double out[9]); /* 0, or -1: there is no inverse */
extern const double make_identity[9];

/* store_image.c: pictures into the writer. */
typedef enum make_role {
    ROLE_PLAIN = 0,   /* as it is */
    ROLE_COVERED = 1, /* its alpha is the coverage of a patch */
    ROLE_BARE = 2,    /* without alpha: the coverage is in a mask */
    ROLE_MASK = 3     /* the coverage alone, R8_UNORM */
} make_role;

/* A picture that has been worked on, instead of the one in the file. */
typedef struct make_ready {
    author_picture
        picture; /* in linear light, or values as they are; the last channel is alpha where the file has it */
    author_picture coverage; /* one channel: alpha, mask and ramp together; no texels: the picture's alpha is */
} make_ready;

/* How the normals of a patch become the root's: store_turn.c. */
typedef struct make_turn {
    double to_patch[9]; /* from the coordinates of the picture as it is stored */
    double to_root[9];  /* from the coordinates of the patch's picture, in whose frame the normals are */
    double scale[4];    /* of the derivative's four numbers, from coordinates to texels */
    int y_down;
} make_turn;

typedef struct make_use {
    uint32_t semantic;
    uint8_t wrap[3];
    make_role role;
    uint32_t ramp;
    const make_image *mask;
    const make_ready *ready; /* NULL: as in the file. It has mask and ramp already */
    const make_turn *turn;   /* NULL: normals stay as they are */
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

/* What is in a picture, seen as a texture. */
typedef struct make_shape {
    int channels[4]; /* of colour or data, in order */
    int count;
    int alpha; /* channel of coverage; -1: none, or the values are data */
} make_shape;

int make_is_colour(uint32_t semantic);
/* 0, or -1: more channels than a texel has, and no R, G, B among them. */
int make_find_shape(const img_info *info, uint32_t semantic, make_shape *s);
uint32_t make_transfer_of(const make_image *image, const img_info *info, uint32_t semantic);
/* The format for texels of so many channels, 1 to 4; srgb: colours, which counts with IMG_U8. */
uint32_t make_usual_format(img_type type, int channels, int srgb);
/* NULL on failure, with error. resized 0: the header alone will do. */
img_reader *make_open_picture(const make_store *store, const make_image *image, size_t file, uint32_t semantic,
                              int resized, char *error);
/* The mask, at the size of the picture that it belongs to, which is layer number index. A mask of one file is that of
 * all layers. */
img_reader *make_open_mask(const make_store *store, const make_image *mask, size_t index, uint32_t width,
                           uint32_t height, char *error);
int make_fail_picture(const make_store *store, const make_image *image, const char *path, const char *error);

/* Stores an image, unless the same one is there. *out is valid until the next call. */
int make_store_image(make_store *store, const make_image *image, const make_use *use, make_stored *out);
/* Has the stored form of this image a coverage channel, that is: ROLE_COVERED, or does it want ROLE_BARE and
 * ROLE_MASK? */
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
    const make_ready *ready;
    const make_turn *turn;
    const float *table; /* of ready: linear light, by its root, to the texture's coding */
    int direct;         /* the picture's bytes are the texture's */
    float *rgba;        /* scratch: a band of rows */
    float *source;
    float *coverage;
} make_rows;

#define MAKE_TABLE 4096 /* steps of make_rows.table, which has one number more */

/* Rows y to y + count of slice z into dst, tight. 0, or -1 with error (IMG_ERROR bytes). */
int make_rows_read(make_rows *rows, uint32_t z, uint32_t y, uint32_t count, void *dst, char *error);

/* store_turn.c: rows y to y + count, four floats a texel. */
void make_turn_rows(const make_turn *t, const make_rows *rows, uint32_t y, uint32_t count, float *rgba);

/* What later textures and patches must know about an earlier texture: its texels. */
typedef struct make_size {
    uint32_t width, height;
} make_size;

/* store.c: everything into one file. What is known of a patch when it is stored; later patches may have it as their
 * parent. */
typedef struct make_placed {
    make_parent self;
    make_crop crop;
    uint32_t sources[MAKE_LAYERS];
    uint32_t mask;
    uint32_t frames; /* of the root: its array layers */
} make_placed;

/* The turn for a layer of a patch, or NULL: it is the root's, has no normals, or they are right as they are. frame:
 * from the patch's coordinates to those of the picture that is stored; NULL: it is the patch's. */
const make_turn *make_turn_for(const make_texture *texture, uint32_t index, uint32_t layer, const make_placed *all,
                               const double *frame, make_turn *room);

/* The first layer carries the coverage, in its alpha or in a mask image beside it. use: semantic, wrap and ready are
 * given. */
int make_store_coverage(make_store *store, const make_patch *patch, make_use *use, make_placed *p, make_stored *stored);

/* store_load.c: all of a picture in memory, in linear light, alpha (if it has one) as its last channel, not multiplied
 * in. */
int make_load_picture(make_store *store, const make_image *image, uint32_t semantic, author_picture *out,
                      img_info *info);

/* store_treat.c: patches whose pictures are worked on: make_patch.colour, auto_mask, prune, bake_affine. */
typedef struct make_treatment make_treatment;

/* *out is NULL when no patch of the texture is worked on. */
int make_treat_begin(make_store *store, const make_texture *texture, make_treatment **out);
int make_treats(const make_treatment *t, uint32_t index); /* t may be NULL */
/* Loads the patch's pictures and says how large it is, so that it can be placed. */
int make_treat_load(make_treatment *t, uint32_t index, make_stored *size);
/* Works on what has been loaded, and stores it, unless that has to wait for make_treat_finish. all: patches up to this
 * one are placed. */
int make_treat_patch(make_treatment *t, uint32_t index, make_placed *all);
/* What depends on all patches. patches: their matrices follow baked frames. */
int make_treat_finish(make_treatment *t, make_placed *all, zt_patch_desc *patches);
void make_treat_end(make_treatment *t); /* NULL is allowed */

/* store.c: a texture for the writer; layers is its memory. images: one for each layer, or NULL where a payload names
 * them. */
zt_texture_desc make_describe(const make_texture *texture, const uint32_t *images, zt_layer_desc layers[MAKE_LAYERS]);
/* The first count textures of the scene into the writer. sizes has room for all of the scene. */
int make_store_textures(make_store *store, uint32_t count, make_size *sizes);
/* "SCENE: POINTER: ..." of what the writer says; the exit code. */
int make_fail_writer(const make_scene *scene, const char *pointer, zt_result result, const zt_diag *diag);
/* Everything into one file. */
int make_store_scene(cmd_args *args, const make_scene *scene, const char *output, const zt_writer_options *options,
                     cmd_progress *progress);

#endif
