/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libzt: reading and sampling .ztex texture files. Writing is in zt_write.h, checking in zt_check.h.
 *
 * A complete program, which the tests compile and run:
 *
 *     #include <stdio.h>
 *     #include <zt/zt.h>
 *
 *     int main(int argc, char **argv)
 *     {
 *         zt_diag diag = {0};
 *         zt_file *file = NULL;
 *         if (argc != 2)
 *             return 1;
 *         if (zt_open_path(argv[1], NULL, &diag, &file) != ZT_OK) {
 *             fprintf(stderr, "%s: %s\n", argv[1], diag.text);
 *             return 1;
 *         }
 *         zt_image_info image;
 *         zt_get_image(file, 0, &image);
 *         printf("%u x %u texels, %u levels\n", image.width, image.height, image.levels);
 *
 *         zt_sampler *sampler = NULL;
 *         if (zt_sampler_open(file, 0, NULL, &diag, &sampler) == ZT_OK) {
 *             zt_point middle = {.u = 0.5, .v = 0.5};
 *             float rgba[4];
 *             if (zt_sample(sampler, &middle, 1, rgba, &diag) == ZT_OK)
 *                 printf("in the middle %.3f %.3f %.3f\n", rgba[0], rgba[1], rgba[2]);
 *             zt_sampler_close(sampler);
 *         }
 *         zt_close(file);
 *         return 0;
 *     }
 *
 * What holds everywhere:
 * - Threads. A zt_file and a zt_sampler do not change after they are opened (what they load on first touch is published
 *   atomically): any number of threads may use one at once. Closing comes after the last use. There is no global state.
 * - Results. Every function that can fail returns a zt_result, which says what to do now. A zt_diag of the caller's,
 *   which may be NULL, says what was wrong and where: the call clears it and the first error wins.
 * - Out-parameters are set to NULL or zero on failure.
 * - Pointers. Arguments are not NULL unless their note says so. Strings that are returned belong to the file and live
 *   until zt_close(). Memory that the caller hands in stays the caller's.
 * - Option and info structs. All-zero options, or NULL, mean the defaults.
 * - Units. Sizes and pitches count bytes, dimensions texels, indices from 0. Texture coordinates run from 0 to 1, u to
 *   the right, v down, (0, 0) being the outer corner of the first texel. Matrices are row-major. Texels are
 *   little-endian on every machine.
 * - Untrusted files. Every function may be given any bytes. zt_limits apply before memory is allocated.
 * Rule numbers, chunks and fields are those of spec/ztex.md, zipmap.md, silmap.md and umbrella.md.
 */
#ifndef ZT_ZT_H
#define ZT_ZT_H

#include <stddef.h>
#include <stdint.h>

#define ZT_VERSION_MAJOR 0
#define ZT_VERSION_MINOR 1
#define ZT_VERSION_PATCH 0

#ifndef ZT_API
#if defined(_WIN32) && defined(ZT_SHARED) && defined(ZT_BUILDING)
#define ZT_API __declspec(dllexport)
#elif defined(_WIN32) && defined(ZT_SHARED)
#define ZT_API __declspec(dllimport)
#elif defined(__GNUC__)
#define ZT_API __attribute__((visibility("default")))
#else
#define ZT_API
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* "0.1.0": the version of the library that runs, which may differ from the macros above. */
ZT_API const char *zt_version_string(void);

/* ---- results and diagnostics ---- */

typedef enum zt_result {
    ZT_OK = 0,
    ZT_AGAIN = 1,        /* the io has not got these bytes yet: fetch diag.offset, diag.size, then call again */
    ZT_BAD_ARGUMENT = 2, /* the call is wrong: mend the program */
    ZT_NO_MEMORY = 3,    /* the allocator said no */
    ZT_IO = 4,           /* reading or writing failed: diag.text has the system's reason */
    ZT_NOT_ZTEX = 5,     /* another kind of file */
    ZT_CORRUPT = 6,      /* the file breaks a rule of the format: diag.rule */
    ZT_TRUNCATED = 7,    /* the file ends too early: get the rest, or open with ZT_OPEN_BEST_EFFORT */
    ZT_UNSUPPORTED = 8,  /* valid, or of a later version, but not for this library: diag.text names what */
    ZT_LIMIT = 9,        /* over one of the caller's zt_limits: diag.text names which */
    ZT_CANCELLED = 10,   /* a callback of the caller's asked to stop */
    ZT_INTERNAL = 11     /* a bug in libzt: please report it */
} zt_result;

/* "corrupt file" and the like, in English, without a final stop. Never NULL. */
ZT_API const char *zt_result_text(zt_result result);

typedef struct zt_diag {
    zt_result result;
    uint32_t rule;   /* number in the specification's margin, or in the band of limits (1001 to 1999); 0: none */
    uint64_t offset; /* of the first wrong byte in the file; UINT64_MAX when there is none */
    uint64_t size;   /* ZT_AGAIN: how many bytes from offset are wanted */
    char path[64];   /* where, for people: "IMAG/image 3/unit 0", empty when unknown */
    char text[256];  /* one sentence: what is wrong. Printable ASCII, always NUL-terminated */
} zt_diag;

/* ---- what the caller may provide ---- */

typedef struct zt_allocator {
    void *user;
    void *(*alloc)(void *user, size_t size);          /* size > 0; aligned like malloc; NULL: no memory */
    void (*free)(void *user, void *ptr, size_t size); /* ptr is not NULL; size as in alloc */
} zt_allocator;

/* Random access reading. Called from any thread that uses the file, also several at once. */
typedef struct zt_io {
    void *user;
    /* Fills dst with size bytes from offset. ZT_OK: all of them. ZT_AGAIN: not here yet. ZT_IO: failed. Never short. */
    zt_result (*read_at)(void *user, uint64_t offset, void *dst, size_t size);
    uint64_t size; /* of the file, in bytes */
} zt_io;

/* Ceilings; 0 means the default named beside each. There is no "unlimited": give a large number. */
typedef struct zt_limits {
    uint64_t file_size;        /* 2^40 */
    uint64_t memory;           /* bytes allocated at once for one file, its samplers and their calls; 2^30 */
    uint64_t metadata;         /* decoded bytes of META; 2^24 */
    uint32_t chunks;           /* 65535 */
    uint32_t textures;         /* 65536 */
    uint32_t images;           /* 2^20 */
    uint32_t dimension;        /* width, height and depth; 2^20 */
    uint32_t layers;           /* array layers of an image; 2^16 */
    uint32_t patches;          /* of one zipmap; 2^20 */
    uint32_t tile_size;        /* decoded bytes of a tile or a mip tail; 2^26 */
    uint32_t texture_depth;    /* textures shown by patches of textures; 8 */
    uint32_t shown_textures;   /* such textures looked up for one point; 4096 */
    uint32_t listed_umbrellas; /* in one cell of umbrellas; 4096 */
} zt_limits;

/* Runs task(context, i, worker) for every i below count, in any order and on any thread, and returns when all are done.
 * worker < workers; two tasks that run at the same time have different workers. */
typedef struct zt_parallel {
    void *user;
    void (*run)(void *user, size_t count, void (*task)(void *context, size_t index, unsigned worker), void *context);
    unsigned workers; /* 1 to 256 */
} zt_parallel;

/* A ready-made pool of POSIX threads. thread_count 0: as many as the machine has processors.
 * Errors: ZT_BAD_ARGUMENT (more than 256), ZT_NO_MEMORY (no memory or no threads). */
typedef struct zt_threads zt_threads;
ZT_API zt_result zt_threads_open(unsigned thread_count, zt_threads **out);
ZT_API zt_parallel zt_threads_parallel(zt_threads *threads); /* valid until zt_threads_close */
ZT_API void zt_threads_close(zt_threads *threads);           /* NULL is allowed */

/* ---- opening ---- */

typedef struct zt_file zt_file;

enum {
    ZT_OPEN_BEST_EFFORT = 1 /* accept a file whose end is missing: see zt_level_state */
};

typedef struct zt_open_options {
    size_t size;                   /* sizeof(zt_open_options), or 0 */
    const zt_allocator *allocator; /* NULL: malloc. The allocator's functions must live as long as the file */
    const zt_limits *limits;       /* NULL: defaults. Copied */
    uint32_t flags;                /* ZT_OPEN_... */
} zt_open_options;

/* Opens a file: checks preamble, directory, textures, images and patches (not the texels). options and diag may be
 * NULL. Errors: all but ZT_CANCELLED. *out is NULL on failure. zt_open_memory does not copy: data must stay until
 * zt_close. zt_open_path reads with pread, never maps. zt_open_io copies *io; io->user must live until zt_close. After
 * ZT_AGAIN provide the bytes and open anew. */
ZT_API zt_result zt_open_memory(const void *data, size_t size, const zt_open_options *options, zt_diag *diag,
                                zt_file **out);
ZT_API zt_result zt_open_path(const char *path, const zt_open_options *options, zt_diag *diag, zt_file **out);
ZT_API zt_result zt_open_io(const zt_io *io, const zt_open_options *options, zt_diag *diag, zt_file **out);
ZT_API void zt_close(zt_file *file); /* NULL is allowed */

/* ---- what is in the file ---- */

typedef struct zt_file_info {
    uint16_t major, minor;
    uint64_t file_size; /* as the preamble says */
    uint32_t chunk_count, texture_count, image_count;
} zt_file_info;

ZT_API void zt_get_file(const zt_file *file, zt_file_info *out);

typedef struct zt_chunk_info {
    char type[5]; /* NUL-terminated */
    uint16_t version;
    uint8_t flags, codec;
    uint64_t offset; /* of the head in the file; the stored bytes begin 64 behind it */
    uint64_t stored_size, decoded_size, stored_hash, decoded_hash;
} zt_chunk_info;

/* Errors of all zt_get_... functions with an index: ZT_BAD_ARGUMENT when it is out of range. */
ZT_API zt_result zt_get_chunk(const zt_file *file, uint32_t chunk, zt_chunk_info *out);

/* Reads and decodes any chunk but TEXL; dst_size must be its decoded_size. Checks its hashes. For chunks of types that
 * libzt does not know. Errors: ZT_BAD_ARGUMENT, ZT_LIMIT (memory), reading and decoding errors. */
ZT_API zt_result zt_read_chunk(const zt_file *file, uint32_t chunk, void *dst, size_t dst_size, zt_diag *diag);

typedef enum zt_kind { ZT_KIND_IMAGE = 0, ZT_KIND_ZIPMAP = 1, ZT_KIND_SILMAP = 2, ZT_KIND_UMBRELLA = 3 } zt_kind;

typedef enum zt_wrap { ZT_WRAP_REPEAT = 0, ZT_WRAP_MIRROR = 1, ZT_WRAP_CLAMP = 2, ZT_WRAP_BORDER = 3 } zt_wrap;

typedef enum zt_alpha { ZT_ALPHA_NONE = 0, ZT_ALPHA_STRAIGHT = 1, ZT_ALPHA_PREMULTIPLIED = 2 } zt_alpha;

typedef enum zt_layer_kind { ZT_LAYERS_ARRAY = 0, ZT_LAYERS_CUBE = 1, ZT_LAYERS_FRAMES = 2 } zt_layer_kind;

/* spec/registry.md, "Semantics of layers"; other numbers may occur. */
typedef enum zt_semantic {
    ZT_SEMANTIC_UNSPECIFIED = 0,
    ZT_SEMANTIC_BASE_COLOUR = 1,
    ZT_SEMANTIC_NORMAL = 2,
    ZT_SEMANTIC_DISPLACEMENT = 3,
    ZT_SEMANTIC_ROUGHNESS = 4,
    ZT_SEMANTIC_METALNESS = 5,
    ZT_SEMANTIC_OCCLUSION = 6,
    ZT_SEMANTIC_EMISSIVE = 7,
    ZT_SEMANTIC_OPACITY = 8,
    ZT_SEMANTIC_SPECULAR = 9,
    ZT_SEMANTIC_OCCLUSION_ROUGHNESS_METALNESS = 10
} zt_semantic;

#define ZT_NONE UINT32_C(0xFFFFFFFF) /* no image, no mask */

typedef struct zt_texture_info {
    const char *name; /* UTF-8, NUL-terminated, may be empty; lives until zt_close */
    zt_kind kind;
    zt_wrap wrap_u, wrap_v, wrap_w;
    uint32_t layer_count;
    uint32_t patch_count; /* kind zipmap; else 0 */
} zt_texture_info;

ZT_API zt_result zt_get_texture(const zt_file *file, uint32_t texture, zt_texture_info *out);

/* Index of the texture with this name, or ZT_NONE. */
ZT_API uint32_t zt_find_texture(const zt_file *file, const char *name);

typedef struct zt_layer_info {
    uint32_t semantic; /* zt_semantic, or another number */
    uint32_t image;    /* kind image: its image; zipmap: the root's; silmap: the sample image; umbrellas: ZT_NONE */
} zt_layer_info;

ZT_API zt_result zt_get_layer(const zt_file *file, uint32_t texture, uint32_t layer, zt_layer_info *out);

typedef struct zt_image_info {
    uint32_t format; /* VkFormat number */
    uint32_t width, height, depth;
    uint32_t layers, levels;
    uint32_t tile_edge; /* in texel blocks */
    uint8_t block_width, block_height, block_bytes;
    uint8_t alpha_mode;                              /* zt_alpha */
    uint8_t layer_kind;                              /* zt_layer_kind */
    uint8_t primaries, transfer, matrix, full_range; /* CICP */
    uint32_t tail_level;                             /* first level of the mip tail; levels when there is none */
} zt_image_info;

ZT_API zt_result zt_get_image(const zt_file *file, uint32_t image, zt_image_info *out);

typedef struct zt_level_info {
    uint32_t width, height, depth;               /* texels */
    uint32_t blocks_x, blocks_y;                 /* texel blocks of a slice */
    uint32_t tiles_x, tiles_y;                   /* tiles of a slice; 1 and 1 in the tail */
    uint64_t tile_count;                         /* of all slices and layers; 1 in the tail */
    uint64_t row_size;                           /* bytes of a tight row of blocks */
    uint64_t slice_size, layer_size, level_size; /* bytes, tight; level_size covers all layers */
    uint64_t unit_offset, unit_size; /* in the file, index and stored tiles; the levels of the tail share a unit */
} zt_level_info;

ZT_API zt_result zt_get_level(const zt_file *file, uint32_t image, uint32_t level, zt_level_info *out);

typedef struct zt_tile_info {
    uint64_t offset; /* of the stored bytes in the file */
    uint32_t stored_size;
    uint32_t decoded_size;
    uint64_t hash; /* XXH3-64 of the decoded bytes */
    uint8_t codec;
} zt_tile_info;

/* Reads the level's tile index if it has not been read yet. Errors: ZT_BAD_ARGUMENT; reading errors; ZT_CORRUPT. */
ZT_API zt_result zt_get_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, zt_tile_info *out,
                             zt_diag *diag);

/* ZT_OK when all bytes of the level are in the file, ZT_TRUNCATED when some are missing (ZT_OPEN_BEST_EFFORT), or
 * ZT_BAD_ARGUMENT. */
ZT_API zt_result zt_level_state(const zt_file *file, uint32_t image, uint32_t level);

typedef struct zt_patch_info {
    uint32_t parent;
    uint32_t texture;      /* index of the texture that the patch shows, or ZT_NONE: it shows images */
    uint32_t mask;         /* image index or ZT_NONE */
    double matrix[9];      /* parent coordinates to the patch's, homogeneous, row-major */
    double root_matrix[9]; /* root coordinates to the patch's: the product along the parents */
} zt_patch_info;

/* Patches of a zipmap (zipmap.md section 2). Errors: ZT_BAD_ARGUMENT (also for other kinds). */
ZT_API zt_result zt_get_patch(const zt_file *file, uint32_t texture, uint32_t patch, zt_patch_info *out);

/* The image that a patch shows in a layer, or ZT_NONE (out of range, or the patch shows a texture). */
ZT_API uint32_t zt_get_patch_image(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t layer);

/* silmap.md section 5 */
typedef enum zt_silmap_filter {
    ZT_SILMAP_CONTINUOUS = 0,
    ZT_SILMAP_SEN2004 = 1,
    ZT_SILMAP_NEAREST = 2
} zt_silmap_filter;

typedef struct zt_silmap_info {
    uint32_t cells_x, cells_y;
    uint32_t cell_layers; /* 1, or the array layers of the sample images */
    zt_silmap_filter filter;
    /* cells_x x cells_y x cell_layers bytes, row by row from the top, layer after layer: what a GPU texture of format
     * R8_UINT wants. Lives until zt_close. */
    const uint8_t *cells;
} zt_silmap_info;

/* Errors: ZT_BAD_ARGUMENT (also for other kinds). */
ZT_API zt_result zt_get_silmap(const zt_file *file, uint32_t texture, zt_silmap_info *out);

/* The minified image of a silmap's layer, or ZT_NONE (out of range, another kind, or there is none). zt_get_layer gives
 * the sample image. */
ZT_API uint32_t zt_get_silmap_minified(const zt_file *file, uint32_t texture, uint32_t layer);

/* A cell byte: the point is ((x + 1/2) / 8, (y + 1/2) / 8) */
#define ZT_SILMAP_DEFAULT UINT8_C(0x24) /* the centre, nothing cut */
#define ZT_SILMAP_X UINT8_C(0x07)
#define ZT_SILMAP_Y UINT8_C(0x38) /* shifted left by 3 */
#define ZT_SILMAP_WEST UINT8_C(0x40)
#define ZT_SILMAP_NORTH UINT8_C(0x80)

/* A cell and its neighbours' bytes. */
typedef struct zt_silmap_cell {
    uint8_t own, west, north, east, south;
} zt_silmap_cell;

/* Cell (x, y), in range, of a layer of cells_x x cells_y bytes. Where the texture does not repeat, the bytes of the
 * neighbours that are missing, and the cell's own bits for them, are what silmap.md section 3 says. */
ZT_API void zt_silmap_cell_at(const uint8_t *cells, uint32_t cells_x, uint32_t cells_y, int repeat_x, int repeat_y,
                              uint32_t x, uint32_t y, zt_silmap_cell *out);

/* Quadrants and corners: */
enum { ZT_SILMAP_00 = 0, ZT_SILMAP_10 = 1, ZT_SILMAP_01 = 2, ZT_SILMAP_11 = 3 };

/* The quadrant of a point of the cell, x and y 0 to 1 (silmap.md section 4). */
ZT_API int zt_silmap_quadrant(const zt_silmap_cell *cell, double x, double y);

/* The weights of the four corners at a point for a quadrant, usually its own (section 5). They sum to 1. For
 * ZT_SILMAP_SEN2004 they may be below 0 or above 1: then the caller brings each channel into the range of the corners
 * in the set that is returned (bit k: corner k); 0 when there is nothing to do. Not finite or outside of 0 to 1:
 * undefined weights, nothing worse. */
ZT_API unsigned zt_silmap_weights(zt_silmap_filter filter, const zt_silmap_cell *cell, int quadrant, double x, double y,
                                  double weights[4]);

/* A cell prepared for many questions: its point and its neighbours', in its own coordinates, and which of its arms are
 * cut. The answers are those of the two functions above. */
enum { ZT_SILMAP_CUT_NORTH = 1, ZT_SILMAP_CUT_EAST = 2, ZT_SILMAP_CUT_SOUTH = 4, ZT_SILMAP_CUT_WEST = 8 };
typedef struct zt_silmap_shape {
    double px, py, wx, wy, nx, ny, ex, ey, sx, sy;
    unsigned cut; /* set of ZT_SILMAP_CUT_... */
} zt_silmap_shape;
ZT_API void zt_silmap_shape_of(const zt_silmap_cell *cell, zt_silmap_shape *out);
ZT_API int zt_silmap_shape_quadrant(const zt_silmap_shape *shape, double x, double y);
ZT_API unsigned zt_silmap_shape_weights(zt_silmap_filter filter, const zt_silmap_shape *shape, int quadrant, double x,
                                        double y, double weights[4]);

/* The areas of the four quadrants (section 7); they sum to 1. */
ZT_API void zt_silmap_areas(const zt_silmap_cell *cell, double areas[4]);

/* Umbrellas (umbrella.md). The structs hold the file's own integers, exact, in 4-byte words: each array can be a
 * storage buffer of a GPU as it is. */

typedef enum zt_umbrella_colour_mode {
    ZT_UMBRELLA_BARYCENTRIC = 0,
    ZT_UMBRELLA_INVERSE_DISTANCE = 1 /* equation 1 of the paper: over all vertices */
} zt_umbrella_colour_mode;

typedef enum zt_umbrella_form {
    ZT_UMBRELLA_PARAMETRIC = 0, /* a base, placed by a similarity */
    ZT_UMBRELLA_EXPLICIT = 1,   /* a base; position and colour offset of each vertex of its own */
    ZT_UMBRELLA_COLOURED = 2    /* no base: positions and colours. Coarser levels have no others */
} zt_umbrella_form;

typedef enum zt_umbrella_ellipsoid {
    ZT_ELLIPSOID_FLAT = 0,
    ZT_ELLIPSOID_CONVEX = 1,
    ZT_ELLIPSOID_CONCAVE = 2,
    ZT_ELLIPSOID_OF_BASE = 3 /* of umbrellas only */
} zt_umbrella_ellipsoid;

typedef enum zt_background_kind {
    ZT_BACKGROUND_COLOUR = 0,
    ZT_BACKGROUND_IMAGE = 1,
    ZT_BACKGROUND_TEXTURE = 2
} zt_background_kind;

/* A place in a picture, in 1/65535 of its width and height. */
typedef struct zt_umbrella_texel {
    uint16_t x, y;
} zt_umbrella_texel;

/* A vertex less its centre, in 2^-bits of a cell (zt_umbrella_level). */
typedef struct zt_umbrella_offset {
    int32_t x, y;
} zt_umbrella_offset;

/* A colour offset, each channel the i8 q of q |q| / 127^2 as its two's complement; form 2: a colour, each channel the
 * u8 q of (q / 255)^2. */
typedef struct zt_umbrella_colour {
    uint8_t r, g, b, reserved;
} zt_umbrella_colour;

typedef struct zt_umbrella_base { /* 40 bytes */
    uint32_t shows_texture;       /* 0: source is an image; 1: an earlier texture */
    uint32_t source;
    uint32_t aspect;       /* height of the picture in 1/65536 of its width */
    uint32_t first_vertex; /* in base_vertices */
    uint32_t first_morph;  /* in morph_vertices, or ZT_NONE */
    uint32_t first_colour; /* in variant_colours: variant_count x (1 + vertex_count), the centre first */
    uint16_t vertex_count;
    uint8_t variant_count, ellipsoid;
    zt_umbrella_texel centre;
    uint16_t height, curvature; /* height in 1/65535 of the prism's; curvature (value + 1) / 65536 */
    uint32_t reserved;
} zt_umbrella_base;

typedef struct zt_umbrella { /* 48 bytes */
    int32_t x, y;            /* centre, in 1/65536 of a cell of its level */
    int32_t a, b;            /* parametric: the similarity, in 1/65536 of a cell for the width of the picture */
    uint32_t first_vertex;   /* explicit and coloured: in explicit_vertices */
    uint32_t first_colour;   /* and in explicit_colours: 1 + vertex_count, the centre first */
    uint16_t vertex_count;   /* explicit and coloured; parametric: 0 */
    uint16_t base;           /* coloured: 0 */
    uint8_t form;            /* zt_umbrella_form */
    uint8_t mirrored, ellipsoid, morph;
    uint8_t variant_0, variant_1, variant_weight, strength; /* weights in 1/255 */
    uint16_t height, curvature; /* as of the base, unless ellipsoid is ZT_ELLIPSOID_OF_BASE */
    uint16_t lift, reserved;    /* in 1/65535 of the prism's height */
} zt_umbrella;

typedef struct zt_umbrella_level {
    uint32_t width, height; /* cells */
    uint32_t first_umbrella, umbrella_count;
    uint32_t first_cell; /* in list_starts; rows from the top */
    uint32_t bits;       /* explicit vertices are in 2^-bits of a cell */
} zt_umbrella_level;

/* An entry of a cell's list: the umbrella's number within its level, and how the whole grid is shifted: (sx + 1) + 3
 * (sy + 1). */
#define ZT_UMBRELLA_ENTRY UINT32_C(0x00FFFFFF)
#define ZT_UMBRELLA_SHIFT 24 /* bits to the right */

/* All arrays live until zt_close. */
typedef struct zt_umbrella_info {
    uint32_t grid_x, grid_y, level_count; /* cells of level 0 */
    uint32_t base_count, umbrella_count, base_vertex_count, morph_vertex_count, variant_colour_count;
    uint32_t explicit_vertex_count, explicit_colour_count, cell_count, entry_count, longest_list;
    zt_umbrella_colour_mode colour_mode;
    zt_background_kind background_kind;
    uint32_t background_source;                 /* image or texture, or ZT_NONE */
    float background[4], mean[4];               /* premultiplied linear light */
    float prism_height, taper_start, taper_end; /* in cells of level 0 */
    const zt_umbrella_level *levels;            /* level_count */
    const zt_umbrella_base *bases;              /* base_count */
    const zt_umbrella_texel *base_vertices;     /* base_vertex_count */
    const zt_umbrella_texel *morph_vertices;    /* morph_vertex_count */
    const zt_umbrella_colour *variant_colours;  /* variant_colour_count */
    const zt_umbrella *umbrellas; /* umbrella_count, level after level; in a level from the lowest to the highest */
    const zt_umbrella_offset *explicit_vertices; /* explicit_vertex_count */
    const zt_umbrella_colour *explicit_colours;  /* explicit_colour_count */
    const uint32_t *list_starts;                 /* cell_count + 1: where a cell's list begins in entries */
    const uint32_t *entries;                     /* entry_count */
} zt_umbrella_info;

/* Errors: ZT_BAD_ARGUMENT (also for other kinds). */
ZT_API zt_result zt_get_umbrellas(const zt_file *file, uint32_t texture, zt_umbrella_info *out);

/* A point in an umbrella. */
typedef struct zt_umbrella_sector {
    uint32_t i, j;   /* the vertices of its sector; form 0: numbers among those of the base */
    double g, k;     /* its barycentric coordinates for them; 1 - g - k for the centre */
    double coverage; /* 0 to 1 */
} zt_umbrella_sector;

/* Sector, coverage and barycentric coordinates (umbrella.md section 3, steps 1 to 3) of the point (x, y) less the
 * umbrella's centre. pixel: the derivatives of x and y for one step to the right in the target, then for one step down.
 * All in cells of the level, and finite. Of info only bases and vertices are looked at; they and the umbrella keep the
 * rules, as those of files do. */
ZT_API void zt_umbrella_sector_at(const zt_umbrella_info *info, const zt_umbrella_level *level,
                                  const zt_umbrella *umbrella, double x, double y, const double pixel[4],
                                  zt_umbrella_sector *out);

/* Metadata. zt_load_metadata reads the META chunk on first use (any thread) and gives the number of pairs; 0 without
 * META. Keys are sorted by bytes. Key and value are UTF-8 and NUL-terminated. */
ZT_API zt_result zt_load_metadata(const zt_file *file, uint32_t *count, zt_diag *diag);
ZT_API zt_result zt_get_metadata(const zt_file *file, uint32_t index, const char **key, const char **value);
/* Value of a key, or NULL when it is not there or the metadata have not been loaded. */
ZT_API const char *zt_find_metadata(const zt_file *file, const char *key);

/* ---- formats ---- */

typedef struct zt_format_info {
    uint32_t format;
    const char *name; /* "R8G8B8A8_SRGB" */
    uint8_t block_width, block_height, block_bytes;
    uint8_t channels;     /* 1 to 4 */
    uint8_t has_alpha;    /* 1: the fourth channel can be coverage */
    uint8_t is_srgb;      /* 1: the first three channels are sRGB-coded */
    uint8_t is_plain;     /* 1: uncompressed: can be sampled and mipmapped */
    uint8_t channel_bits; /* plain formats: 8, 16 or 32; 0 for others and for E5B9G9R9 */
    uint8_t is_float;     /* half, float, E5B9G9R9, BC6H */
} zt_format_info;

/* NULL for a number that is not in the registry. */
ZT_API const zt_format_info *zt_find_format(uint32_t format);
/* By name, with or without "VK_FORMAT_"; NULL when unknown. */
ZT_API const zt_format_info *zt_find_format_name(const char *name);
/* The i-th format in ascending order of numbers, NULL behind the last. */
ZT_API const zt_format_info *zt_get_format(uint32_t i);

/* Conversion of rows of texels between a plain format's bytes and four floats a texel, as stored (not linearised, alpha
 * as it is; missing channels 0, missing fourth 1). Packing clamps to the format's range and rounds to nearest, ties to
 * even; NaN becomes 0 for UNORM. Errors: ZT_BAD_ARGUMENT (NULL), ZT_UNSUPPORTED (not plain). */
ZT_API zt_result zt_unpack_texels(uint32_t format, const void *src, size_t count, float *rgba);
ZT_API zt_result zt_pack_texels(uint32_t format, const float *rgba, size_t count, void *dst);

/* Transfers that have a name here; registry.md has all. */
typedef enum zt_transfer {
    ZT_TRANSFER_UNSPECIFIED = 2,
    ZT_TRANSFER_LINEAR = 8,
    ZT_TRANSFER_SRGB = 13,
    ZT_TRANSFER_PQ = 16
} zt_transfer;

/* CICP transfer (registry.md): coded value to linear light and back, mirrored for negative values. 1 when the number is
 * known. The results are the same on every machine: no libm decides them. */
ZT_API int zt_transfer_known(uint32_t transfer);
ZT_API float zt_transfer_decode(uint32_t transfer, float value);
ZT_API float zt_transfer_encode(uint32_t transfer, float value);

/* ---- decoding ---- */

/* A box of texels in one level of one image. x, y, width, height must be multiples of the block size, or end at the
 * level's edge. */
typedef struct zt_region {
    uint32_t level, layer;
    uint32_t x, y, z;
    uint32_t width, height, depth;
} zt_region;

typedef struct zt_decode_options {
    size_t size;                 /* sizeof(zt_decode_options), or 0 */
    const zt_parallel *parallel; /* NULL: in the calling thread */
} zt_decode_options;

/* Decodes a region into the caller's memory: rows of blocks row_pitch apart, slices slice_pitch apart. Only the tiles
 * that it touches are read. row_pitch 0: tight; slice_pitch 0: row_pitch times the rows of blocks. Nothing is written
 * outside dst + dst_size; when an error is returned, the region's bytes are undefined. Errors: ZT_BAD_ARGUMENT (region
 * outside the level, dst too small, pitch too small), ZT_AGAIN, ZT_NO_MEMORY, ZT_IO, ZT_CORRUPT, ZT_TRUNCATED,
 * ZT_UNSUPPORTED (tile codec), ZT_LIMIT. */
ZT_API zt_result zt_decode_region(const zt_file *file, uint32_t image, const zt_region *region, void *dst,
                                  size_t dst_size, size_t row_pitch, size_t slice_pitch,
                                  const zt_decode_options *options, zt_diag *diag);

/* One layer of a level, tight slices after each other with row_pitch (0: tight). Errors as zt_decode_region.
 * In the mip tail each call decodes all of it: whoever wants many layers or levels of it calls zt_decode_tile once. */
ZT_API zt_result zt_decode_level(const zt_file *file, uint32_t image, uint32_t level, uint32_t layer, void *dst,
                                 size_t dst_size, size_t row_pitch, const zt_decode_options *options, zt_diag *diag);

/* One tile (in the tail: the whole tail) as its decoded bytes; dst_size must be at least its decoded_size. Errors as
 * zt_decode_region. */
ZT_API zt_result zt_decode_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, void *dst,
                                size_t dst_size, zt_diag *diag);

/* The stored bytes of a tile, not decoded; dst_size must be at least its stored_size. For copying without coding anew.
 */
ZT_API zt_result zt_read_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile, void *dst,
                              size_t dst_size, zt_diag *diag);

/* ---- which bytes a request needs ---- */

typedef struct zt_extent {
    uint64_t offset, size; /* in the file */
} zt_extent;

typedef struct zt_request {
    uint32_t texture;              /* ZT_NONE: by image */
    uint32_t patch;                /* of a zipmap; ZT_NONE: all patches */
    uint32_t image;                /* when texture is ZT_NONE */
    uint32_t min_level, max_level; /* of each image; clamped to what it has */
    const zt_region
        *region; /* NULL: whole levels. Only with texture == ZT_NONE; its level replaces min_level and max_level */
} zt_request;

/* The byte ranges that decoding the request reads, in ascending order, touching ranges joined. Writes at most capacity
 * of them (extents may be NULL with capacity 0) and sets *count to their number. Whole levels need no reading; a region
 * needs the level's tile index: when the io answers ZT_AGAIN, the one extent is that index, and the result is ZT_AGAIN.
 * Errors: ZT_BAD_ARGUMENT, ZT_AGAIN, ZT_NO_MEMORY, ZT_IO, ZT_CORRUPT, ZT_TRUNCATED. */
ZT_API zt_result zt_query_extents(const zt_file *file, const zt_request *request, zt_extent *extents, size_t capacity,
                                  size_t *count, zt_diag *diag);

/* ---- sampling ---- */

typedef enum zt_filter { ZT_FILTER_TRILINEAR = 0, ZT_FILTER_BILINEAR = 1, ZT_FILTER_NEAREST = 2 } zt_filter;

/* A texture ready for lookups: the reference implementation of ztex.md section 12, zipmap.md section 3, silmap.md
 * section 6 and umbrella.md sections 4 and 5. Tiles are decoded when a lookup first touches them and kept until the
 * sampler is closed, within zt_limits.memory. */
typedef struct zt_sampler zt_sampler;

typedef struct zt_sampler_options {
    size_t size; /* sizeof(zt_sampler_options), or 0 */
    zt_filter filter;
    uint32_t max_anisotropy;   /* 0 and 1: isotropic; at most 16; with ZT_FILTER_TRILINEAR only */
    uint32_t layer;            /* layer of the texture: base colour, normal ... (zt_get_layer) */
    uint32_t first_patch_only; /* 1: the root alone */
    /* Umbrellas (umbrella.md section 4, step 5): a displacement towards the light, in cells of level 0, and how dark
     * shadows are: 0 (none) to 1. Where patches or bases show umbrellas there are no shadows. */
    double light_x, light_y, shadow;
} zt_sampler_options;

/* The file must stay open until zt_sampler_close. Errors: ZT_BAD_ARGUMENT, ZT_NO_MEMORY, ZT_LIMIT, ZT_UNSUPPORTED (an
 * image that it would look up is of a block format, or has an unknown transfer). */
ZT_API zt_result zt_sampler_open(const zt_file *file, uint32_t texture, const zt_sampler_options *options,
                                 zt_diag *diag, zt_sampler **out);
ZT_API void zt_sampler_close(zt_sampler *sampler); /* NULL is allowed */

typedef struct zt_point {
    double u, v, w; /* w: volumes; else ignored */
    double du_dx, dv_dx,
        dw_dx; /* change of the coordinates for one step to the right in the target; all zero: magnified */
    double du_dy, dv_dy, dw_dy; /* and for one step down */
    uint32_t array_layer;       /* layer, cube face or frame; clamped */
} zt_point;

/* Looks up count points: out gets four floats each, premultiplied linear light (layers that are not colour: values as
 * stored, weighted by coverage). Coordinates that are not finite give zeros. Errors: ZT_BAD_ARGUMENT; those of
 * zt_decode_region. On an error out is undefined. */
ZT_API zt_result zt_sample(const zt_sampler *sampler, const zt_point *points, size_t count, float *out, zt_diag *diag);

/* A ray through the prism over umbrellas (umbrella.md section 5): texture coordinates and height, in cells of level 0,
 * where it enters and where it leaves, and the footprints of a pixel there, in cells of level 0. It leaves on the
 * ground if z1 is 0. Texture coordinates may leave the unit square. */
typedef struct zt_ray {
    double u0, v0, z0;
    double u1, v1, z1;
    double footprint0, footprint1;
} zt_ray;

typedef enum zt_hit_kind {
    ZT_HIT_NOTHING = 0,   /* the ray leaves the prism through a side or the roof */
    ZT_HIT_FLAT = 1,      /* a lookup in 2-D on the ground, where heights have been tapered away */
    ZT_HIT_UMBRELLA = 2,  /* an umbrella in 3-D */
    ZT_HIT_BACKGROUND = 3 /* the ground between the umbrellas */
} zt_hit_kind;

typedef struct zt_hit {
    float rgba[4];   /* premultiplied linear light; zeros for nothing. Not shaded, but for shadows */
    float normal[3]; /* (x, y, z) of the prism, turned towards the eye; (0, 0, 1) but for umbrellas */
    float t;         /* where along the ray, 0 to 1; of the unbent ray */
    zt_hit_kind kind;
    uint32_t umbrella; /* number within level 0, or ZT_NONE */
} zt_hit;

/* Traces count rays; pictures are looked up trilinearly whatever the sampler's filter. What is not an umbrella has t
 * = 1. A ray that is not finite, or that has not ended after 2^22 cells and entries of lists, hits nothing. Errors:
 * ZT_BAD_ARGUMENT (also for textures of other kinds); those of zt_sample. */
ZT_API zt_result zt_sample_rays(const zt_sampler *sampler, const zt_ray *rays, size_t count, zt_hit *out,
                                zt_diag *diag);

/* What a sampler holds, for tuning: bytes of decoded tiles, cells of the patch grid, entries of all its lists, longest
 * list. */
typedef struct zt_sampler_info {
    uint64_t tile_bytes;
    uint32_t grid_width, grid_height;
    uint64_t grid_entries;
    uint32_t longest_list;
} zt_sampler_info;

ZT_API void zt_get_sampler(const zt_sampler *sampler, zt_sampler_info *out);

#ifdef __cplusplus
}
#endif

#endif
