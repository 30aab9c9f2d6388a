/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writing .ztex files. What holds everywhere in zt.h holds here; a zt_writer is used by one thread at a time.
 *
 *     zt_writer *writer;
 *     uint32_t image;
 *     zt_writer_open_path("brick.ztex", NULL, &diag, &writer);
 *     zt_image_desc desc = {.format = 43, .width = w, .height = h}; // R8G8B8A8_SRGB, all mip levels made here
 *     zt_writer_add_image(writer, &desc, &diag, &image);
 *     zt_writer_put_rows(writer, image, pixels, h, 4 * w, &diag);
 *     zt_writer_add_texture(writer, &(zt_texture_desc){.name = "brick", .image = image}, &diag, NULL);
 *     zt_writer_finish(writer, &diag);
 *     zt_writer_close(writer);
 *
 * Texels stream: a writer holds a few rows and tiles of each image that is being written, never a whole level (but
 * see tile_edge).
 * Compressed tiles go to a spool (memory first, then a temporary file beside the output), from which the file is laid
 * out, coarse levels first, when everything is there. A path appears whole or not at all. The same calls give the same
 * bytes, whatever the number of threads and the order in which images are filled.
 *
 * ZT_BAD_ARGUMENT changes nothing (but zt_writer_finish always ends the writing): mend the call and go on. After any
 * other failure, other than ZT_LIMIT from zt_writer_add_image, the writer only takes zt_writer_close.
 */
#ifndef ZT_ZT_WRITE_H
#define ZT_ZT_WRITE_H

#include <zt/zt.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct zt_writer zt_writer;

/* Where a file goes when it does not go to a path: called with consecutive pieces from the first byte to the last. */
typedef struct zt_sink {
    void *user;
    /* ZT_OK, or ZT_IO, ZT_CANCELLED ..., which ends the writing with that result. */
    zt_result (*write)(void *user, const void *data, size_t size);
} zt_sink;

enum {
    ZT_WRITE_NO_FSYNC = 1 /* do not wait for the disk: for temporary files and bulk jobs */
};

typedef struct zt_writer_options {
    size_t size;                   /* sizeof(zt_writer_options), or 0 */
    const zt_allocator *allocator; /* NULL: malloc */
    const zt_parallel *parallel;   /* NULL: in the calling thread. Copied; its user must live as long as the writer */
    const zt_limits *limits;       /* memory applies to the writer's buffers; NULL: defaults. Copied */
    int effort;                    /* of compression: 1 (fast) to 9 (small), below; 0: the default, 5 */
    int raw_only;                  /* 1: store tiles raw */
    uint64_t spool_memory; /* bytes of compressed tiles held in memory before a temporary file is used; 0: 64 MiB */
    uint32_t flags;        /* ZT_WRITE_... */
    void *user;
    int (*progress)(void *user, double done); /* during zt_writer_finish, 0 to 1; not 0: ZT_CANCELLED. May be NULL */
} zt_writer_options;

/* Efforts, each slower and on the whole smaller than the one before; docs/efforts.md has figures. All use the predicted
 * codec where the format allows it.
 *     1     its simplest choice of tables; zstd only where the format has no predicted codec, or it gains nothing
 *     2     zstd also where a quick look promises something
 *     3, 4  a better choice of tables; higher levels of zstd
 *     5     where a tile repeats itself, also zstd over predicted residuals, in six forms
 *     6     a high level of zstd
 *     7, 8  all tables compared with each other; the six forms everywhere; higher levels of zstd, more of them tried
 *     9     both colour transforms tried; the tile edge chosen (zt_image_desc) */

/* Errors: ZT_BAD_ARGUMENT, ZT_NO_MEMORY, ZT_IO (the folder cannot be written to). The file at path is not touched
 * before zt_writer_finish replaces it. */
ZT_API zt_result zt_writer_open_path(const char *path, const zt_writer_options *options, zt_diag *diag,
                                     zt_writer **out);
ZT_API zt_result zt_writer_open_sink(const zt_sink *sink, const zt_writer_options *options, zt_diag *diag,
                                     zt_writer **out);

/* Releases everything. Before zt_writer_finish has succeeded it leaves no trace: no temporary file, and what was at
 * path is as it was. NULL is allowed. */
ZT_API void zt_writer_close(zt_writer *writer);

/* ---- images ---- */

typedef enum zt_mip_filter {
    ZT_MIP_KAISER = 0,   /* Kaiser-windowed sinc, 3 texels of the smaller level to each side, alpha 4: sharp */
    ZT_MIP_MITCHELL = 1, /* Mitchell-Netravali cubic, B = C = 1/3 */
    ZT_MIP_TRIANGLE = 2,
    ZT_MIP_BOX = 3
} zt_mip_filter;

typedef struct zt_image_desc {
    uint32_t format;               /* VkFormat number, required */
    uint32_t width, height, depth; /* depth 0: 1 */
    uint32_t layers;               /* 0: 1 */
    uint32_t levels;               /* 0: all down to 1 x 1 x 1 */
    uint32_t tile_edge;            /* in texel blocks: a power of two from 16 to 65536; 0: the usual one, or chosen */
    zt_alpha alpha_mode;
    zt_layer_kind layer_kind;
    uint8_t primaries, transfer; /* CICP; 0: 1 and what the format implies (13 for SRGB formats, else 8) */
    uint8_t block_width, block_height, block_bytes; /* for a format that libzt does not know; else 0 */
    /* How levels above 0 come about: */
    uint8_t given_levels; /* 1: the caller puts every level itself; 0: libzt makes them from level 0 (plain formats) */
    uint8_t mip_filter;   /* zt_mip_filter */
    uint8_t wrap_u, wrap_v, wrap_w; /* zt_wrap at the edges, as in the texture. Border: zeros outside */
    uint8_t is_normal;              /* 1: vectors 2 t - 1 (UNORM) or t (float): renormalised after filtering */
    /* 1: coverage is made zero on the border texels of every level (children of zipmaps): the alpha channel, or the
     * channel of one-channel images */
    uint8_t zero_border;
} zt_image_desc;

/* That of an image like this one, each level of which will be given: for copies. */
ZT_API void zt_describe_image(const zt_image_info *info, zt_image_desc *out);

/* The usual tile edge is 256, for block formats 64. With tile_edge 0 and effort 9 libzt tries that, twice that and one
 * tile of the whole level, and keeps what makes level 0 smallest: so that a region of it may then mean decoding all of
 * it. For that it holds level 0, with all layers and slices. It does so only where this takes at most 16 MiB and at
 * most 1/64 of zt_limits.memory, the levels are not given, and tiles are not stored raw. */

/* How levels are made. Each comes from the unrounded values of the one before, in linear light and premultiplied, so
 * that colour of texels without coverage counts nothing; where coverage is zero, colour is zero, too. Odd sizes are
 * filtered with their true phase. Results are at least 0 where no texel under the filter is negative. Float texels that
 * are NaN count as 0, those above 2^96 as 2^96. Layers do not touch each other; slices of volumes do.
 * With zero_border a level is made from the level before as it was without its border made zero, level 0 excepted.
 * A constant image has the same constant in all levels (up to what premultiplying float texels rounds). */

/* Declares an image. Errors: ZT_BAD_ARGUMENT with diag.rule, when a rule of section 8 of ztex.md would be broken or
 * levels cannot be made (block and unknown formats need given_levels); ZT_NO_MEMORY; ZT_LIMIT. */
ZT_API zt_result zt_writer_add_image(zt_writer *writer, const zt_image_desc *desc, zt_diag *diag, uint32_t *image);

/* Rows of texel blocks of level 0, from the top down, layer after layer, in a layer slice after slice: each call
 * continues where the last one for this image ended. row_count counts rows of blocks and may cross slices and layers.
 * row_pitch 0: tight. Several images may be filled in turns. Errors: ZT_BAD_ARGUMENT (too many rows, image done),
 * ZT_NO_MEMORY, ZT_LIMIT, ZT_IO. */
ZT_API zt_result zt_writer_put_rows(zt_writer *writer, uint32_t image, const void *rows, uint32_t row_count,
                                    size_t row_pitch, zt_diag *diag);

/* Rows of a given level (given_levels): levels may come in any order, each from its first row to its last. */
ZT_API zt_result zt_writer_put_level_rows(zt_writer *writer, uint32_t image, uint32_t level, const void *rows,
                                          uint32_t row_count, size_t row_pitch, zt_diag *diag);

/* A tile as it is stored elsewhere (zt_read_tile), not coded anew: its codec, stored bytes and hash of the decoded
 * bytes. With given_levels and no zero border; geometry (zt_get_tile), raw tiles' hash and zstd's framing are checked,
 * the texels are not looked at. Tiles of a level may come in any order; level is that of the unit (for the tail its
 * first level, tile 0). A level takes rows or stored tiles, not both. */
ZT_API zt_result zt_writer_put_stored_tile(zt_writer *writer, uint32_t image, uint32_t level, uint64_t tile,
                                           uint8_t codec, uint64_t hash, const void *data, size_t size, zt_diag *diag);

/* ---- textures ---- */

typedef struct zt_layer_desc {
    uint32_t semantic; /* zt_semantic */
    uint32_t image;    /* kind image; ignored for other kinds */
} zt_layer_desc;

typedef struct zt_texture_desc {
    const char *name; /* UTF-8; NULL: empty */
    zt_wrap wrap_u, wrap_v, wrap_w;
    const zt_layer_desc *layers; /* NULL with layer_count 0: one layer of base colour whose image is `image` */
    uint32_t layer_count;
    uint32_t image;
} zt_texture_desc;

/* A texture of kind image. *texture (may be NULL) gets its index. Errors: ZT_BAD_ARGUMENT with diag.rule; ZT_NO_MEMORY.
 */
ZT_API zt_result zt_writer_add_texture(zt_writer *writer, const zt_texture_desc *desc, zt_diag *diag,
                                       uint32_t *texture);

typedef struct zt_patch_desc {
    uint32_t parent;         /* below the patch's own index; 0 for the root */
    uint32_t shows_texture;  /* not 0: sources[0] is an earlier texture; 0: images */
    const uint32_t *sources; /* one image for each layer */
    uint32_t mask;           /* image or ZT_NONE */
    double matrix[9];        /* parent coordinates to the patch's; identity for the root. -0 is written as 0 */
} zt_patch_desc;

/* A zipmap: desc->layers gives the semantics, patches[0] is the root. Everything is copied. Coverage images should have
 * been declared with zero_border: texels are not looked at here, so rule 8112 is the caller's. Errors as
 * zt_writer_add_texture. */
ZT_API zt_result zt_writer_add_zipmap(zt_writer *writer, const zt_texture_desc *desc, const zt_patch_desc *patches,
                                      uint32_t patch_count, zt_diag *diag, uint32_t *texture);

typedef struct zt_silmap_desc {
    uint32_t cells_x, cells_y;
    uint32_t cell_layers; /* 0: 1 */
    zt_silmap_filter filter;
    const uint8_t *cells; /* as in zt_silmap_info */
    const uint32_t *
        samples; /* one image for each layer: (cells_x + 1) x (cells_y + 1) texels, one less in a repeating direction */
    const uint32_t *minified; /* one for each layer or ZT_NONE: cells_x x cells_y texels; NULL: none */
} zt_silmap_desc;

/* A silmap: desc->layers gives the semantics. Everything is copied. Cells without a cut arm are written as
 * ZT_SILMAP_DEFAULT, whatever their point. Errors as zt_writer_add_texture. */
ZT_API zt_result zt_writer_add_silmap(zt_writer *writer, const zt_texture_desc *desc, const zt_silmap_desc *silmap,
                                      zt_diag *diag, uint32_t *texture);

/* Umbrellas: desc->layers gives the one semantic. Everything is copied from info but what follows from the rest, which
 * may hold anything:
 * - of levels width, height, first_umbrella and first_cell; of bases and umbrellas first_vertex, first_colour and,
 *   unless it is ZT_NONE, first_morph; arrays are in the order of what owns them, without gaps;
 * - explicit_colour_count (explicit_vertex_count and one for each umbrella with vertices), cell_count, longest_list.
 * list_starts begins with 0; lists are sorted (R8315). There are at most 2^30 - 1 explicit vertices and entries.
 * Errors as zt_writer_add_texture. */
ZT_API zt_result zt_writer_add_umbrellas(zt_writer *writer, const zt_texture_desc *desc, const zt_umbrella_info *info,
                                         zt_diag *diag, uint32_t *texture);

/* Texels for level 0 of a minified image (silmap.md section 7): cells_x x cells_y x 4 floats out of the samples, four
 * floats each, both premultiplied linear light. One layer of cells. samples_x and samples_y are cells_x and cells_y, or
 * one more (not repeating). Errors: ZT_BAD_ARGUMENT. */
ZT_API zt_result zt_minify_silmap(const uint8_t *cells, uint32_t cells_x, uint32_t cells_y, const float *samples,
                                  uint32_t samples_x, uint32_t samples_y, float *out);

/* ---- the rest ---- */

/* Sets or, with value NULL, removes a pair. Errors: ZT_BAD_ARGUMENT with diag.rule (7002, 7004), ZT_NO_MEMORY. */
ZT_API zt_result zt_writer_set_metadata(zt_writer *writer, const char *key, const char *value, zt_diag *diag);

/* A chunk of a type that libzt does not know: type has four characters, flags as in the directory (ztex.md section 4;
 * not critical). */
ZT_API zt_result zt_writer_add_chunk(zt_writer *writer, const char *type, uint16_t version, uint8_t flags,
                                     const void *data, size_t size, zt_diag *diag);

/* Copies all metadata and all unknown safe-to-copy chunks of a file; *dropped (may be NULL) gets the number of unknown
 * chunks that are not safe to copy and stay behind. */
ZT_API zt_result zt_writer_copy_rest(zt_writer *writer, const zt_file *file, zt_diag *diag, uint32_t *dropped);

/* Lays the file out and, for a path, puts it in place (fsync, rename, fsync of the folder). Every image must be full.
 * After success only zt_writer_close is allowed; after an error too. Errors: ZT_BAD_ARGUMENT (nothing in it, an image
 * is not full), ZT_NO_MEMORY, ZT_IO, ZT_CANCELLED. */
ZT_API zt_result zt_writer_finish(zt_writer *writer, zt_diag *diag);

/* ---- recovering ---- */

typedef enum zt_fill {
    ZT_FILL_COARSER = 0, /* nearest texels of a coarser level: the picture is there, blurred */
    ZT_FILL_FINER = 1,   /* nearest texels of a finer level */
    ZT_FILL_ZERO = 2     /* nothing was left: zero bytes */
} zt_fill;

/* A tile that could not be saved. */
typedef struct zt_loss {
    uint32_t image, level; /* level: the first one of the tail for tiles of the tail */
    uint64_t tile;
    zt_fill fill; /* what is in its place now; a tail that is filled in part by zeros counts as ZT_FILL_ZERO */
} zt_loss;

typedef struct zt_recover_report {
    int directory_intact;
    uint32_t chunks_expected; /* as far as the directory, or else the heads that were found, tell */
    uint32_t chunks_intact;   /* TEXL: when all of its tiles are */
    uint64_t tiles, tiles_copied, tiles_replaced;
    uint32_t textures_kept;
    uint32_t textures_lost; /* they, or their patches, could not be read. Unknown, hence 0, when TEXS is lost:
                               textures_kept is 0 then */
    uint32_t
        textures_rebuilt;    /* textures "recovered N" that were added, one for each image that no kept texture shows */
    uint32_t metadata_pairs; /* kept */
    uint32_t chunks_kept;    /* chunks of unknown types, kept */
    uint32_t chunks_dropped; /* intact, but not safe to copy */
    int complete;            /* 1: nothing was lost */
} zt_recover_report;

typedef struct zt_recover_options {
    size_t size;                   /* sizeof(zt_recover_options), or 0 */
    const zt_allocator *allocator; /* NULL: malloc */
    const zt_limits *limits;       /* NULL: defaults */
    void *user;
    int (*loss)(void *user, const zt_loss *loss); /* for each lost tile; not 0: ZT_CANCELLED. May be NULL */
    int (*progress)(void *user, double done);     /* 0 to 1; not 0: ZT_CANCELLED. May be NULL */
} zt_recover_options;

/* The chunks that can be found in a damaged file, in the order of a right one, as zt_recover would find them: for each,
 * found is called with its entry and whether it is intact (TEXL: whether its entry has right values; its bytes are not
 * looked at). A result other than 0 of found ends the search with ZT_CANCELLED. limits and diag may be NULL. Errors:
 * ZT_BAD_ARGUMENT, ZT_NO_MEMORY, ZT_IO, ZT_AGAIN, ZT_LIMIT, ZT_CANCELLED. */
ZT_API zt_result zt_find_chunks(const zt_io *io, const zt_limits *limits, void *user,
                                int (*found)(void *user, const zt_chunk_info *chunk, int intact), zt_diag *diag);

/* Puts what is intact of a damaged or truncated file into a writer, which must be fresh; finishing it is the caller's.
 * Chunks are found by the directory or, when its hash is wrong, by their heads, and trusted when their hashes are
 * right; TEXL is trusted tile by tile. Tiles that are intact, or of a codec that libzt does not know, are copied as
 * they are stored. Lost ones are filled as zt_fill says; where they are the coverage of patches, with zeros:
 * transparent. Errors: ZT_CORRUPT (no intact IMAG chunk: there is nothing to build on), ZT_BAD_ARGUMENT, ZT_NO_MEMORY,
 * ZT_IO, ZT_AGAIN, ZT_LIMIT, ZT_CANCELLED. options and diag may be NULL. */
ZT_API zt_result zt_recover(const zt_io *io, zt_writer *writer, const zt_recover_options *options, zt_diag *diag,
                            zt_recover_report *out);

#ifdef __cplusplus
}
#endif

#endif
