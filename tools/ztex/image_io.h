/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures in and out, in C. image_io.cpp behind it is the only place that sees OpenImageIO.
 *
 * Every function that can fail takes a buffer `error` (IMG_ERROR bytes) that gets one line of text, without the path.
 * Rows are interleaved, top down, tight unless a pitch says otherwise. Alpha is never multiplied into the colours on
 * the way: img_info.alpha says what the texels are. Integer texels are always straight; half and float ones may be
 * premultiplied (OpenEXR). Nothing here prints. Readers and writers are for one thread each.
 */
#ifndef ZTEX_IMAGE_IO_H
#define ZTEX_IMAGE_IO_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define IMG_ERROR 256
#define IMG_CHANNELS 64 /* pictures with more are refused */
#define IMG_NAME 32

typedef enum img_type { IMG_NATIVE = 0, IMG_U8 = 1, IMG_U16 = 2, IMG_HALF = 3, IMG_FLOAT = 4 } img_type;

/* The numbers are those of zt_alpha. */
typedef enum img_alpha { IMG_ALPHA_NONE = 0, IMG_ALPHA_STRAIGHT = 1, IMG_ALPHA_PREMULTIPLIED = 2 } img_alpha;

/* Bytes of a value: 1, 2, 2, 4; IMG_NATIVE: 0. */
static inline size_t img_type_size(img_type type) {
    return type == IMG_U8 ? 1 : type == IMG_U16 || type == IMG_HALF ? 2 : type == IMG_FLOAT ? 4 : 0;
}

typedef struct img_rect {
    uint32_t x, y, width, height; /* width 0: everything */
} img_rect;

/* ---- reading --------------------------------------------------------------------------------------------- */

typedef struct img_open_options {
    uint32_t subimage, level;             /* part of the file, MIP level in it */
    int keep_orientation;                 /* 1: rows as stored; 0: turned upright by the EXIF orientation */
    img_rect crop;                        /* of the upright picture */
    uint32_t resize_width, resize_height; /* 0: not resized. After the crop */
    int resize_data;                      /* 1: values are not colours: resize them as they are, not in linear light */
    /* What may be allocated; 0: 2^30. Whole pictures are held for resizing and for orientations 3 to 8. */
    uint64_t memory;
} img_open_options;

typedef struct img_info {
    uint32_t width, height, depth;    /* of what is read: upright, cropped, resized */
    uint32_t full_width, full_height; /* upright picture before crop and resize */
    uint32_t channels;
    img_type type;      /* nearest of the four that holds the file's values; double and 32-bit integers become float */
    char type_name[16]; /* as in the file: "uint8", "half", ... */
    char format[16];    /* "png", "openexr", ... */
    char channel_names[IMG_CHANNELS][IMG_NAME]; /* "R", "G", "B", "A", "Y", ... */
    int alpha_channel;                          /* -1: none */
    img_alpha alpha;
    char colour_space[IMG_NAME]; /* as OpenImageIO calls it: "sRGB", "Linear", ...; empty: unknown */
    uint8_t transfer, primaries; /* CICP numbers where known, else 0 */
    char icc[64];                /* description of an embedded profile ("unnamed" if it has none); empty: no profile */
    uint32_t orientation;        /* EXIF, 1 to 8, of the file */
    uint32_t subimages, levels;  /* subimages in the file, MIP levels of this one */
    char copyright[256], artist[256], description[256]; /* UTF-8, may be cut; empty: none */
} img_info;

typedef struct img_reader img_reader;

/* options may be NULL. Returns NULL on failure. Files are never fetched from a network or searched for in a path
 * list. */
img_reader *img_open(const char *path, const img_open_options *options, char *error);
const img_info *img_get_info(const img_reader *reader); /* lives until img_close */

/* Reads rows y to y + count of slice z, converted to type (IMG_NATIVE: img_info.type), pitch bytes apart (0: tight).
 * channels: how many of the first channels (0: all). Rows in ascending order are cheap; going back may start the file
 * over. Integers are scaled to their full range and clamped. Returns 0, or -1 with error. */
int img_read_rows(img_reader *reader, uint32_t z, uint32_t y, uint32_t count, uint32_t channels, img_type type,
                  void *dst, size_t pitch, char *error);
void img_close(img_reader *reader); /* NULL is allowed */

/* ---- writing --------------------------------------------------------------------------------------------- */

typedef struct img_text {
    const char *name;  /* OpenImageIO's name: "Copyright", "Artist", "ImageDescription", ... */
    const char *value; /* UTF-8 */
} img_text;

typedef struct img_create_options {
    uint32_t width, height, channels;
    img_type type; /* of the file; IMG_NATIVE is not allowed. A format that lacks it: see img_writer_type */
    const char *const *channel_names; /* channels of them; NULL: "Y" / "Y","A" / "R","G","B"(,"A") */
    img_alpha alpha; /* of the last channel as handed in. STRAIGHT stays straight where the format knows it */
    uint8_t transfer, primaries; /* CICP; 0: not said */
    const char *format;          /* "png", "exr": instead of the path's extension; NULL: by extension */
    int quality;                 /* 1 to 100 for JPEG and WebP; 0: 95 */
    const char *compression;     /* OpenImageIO's name; NULL: the format's default */
    const img_text *texts;       /* metadata */
    size_t text_count;
} img_create_options;

typedef struct img_writer img_writer;

/* Opens a temporary file beside path; for "-" (format needed) one that img_finish copies to standard output. What was
 * at path stays until img_finish. Refuses, with a text that says what would do, a format that cannot hold the channels
 * or the alpha. */
img_writer *img_create(const char *path, const img_create_options *options, char *error);
img_type img_writer_type(const img_writer *writer); /* what the file really gets: JPEG has only IMG_U8 */

/* The next count rows, of the given type, converted to the file's. Returns 0, or -1 with error. */
int img_write_rows(img_writer *writer, uint32_t count, img_type type, const void *src, size_t pitch, char *error);

/* Closes, puts the file in place and frees the writer, also on failure. Every row must be there. 0, or -1 with error:
 * no trace. */
int img_finish(img_writer *writer, char *error);
void img_discard(img_writer *writer); /* leaves no trace and frees. NULL is allowed */

/* Both in one: all rows from memory. */
int img_write(const char *path, const img_create_options *options, img_type type, const void *src, size_t pitch,
              char *error);

/* Is this a name that img_create knows ("png", ".exr", "picture.tif")? The i-th extension that can be written, NULL
 * behind the last. */
int img_can_write(const char *name);
const char *img_extension(uint32_t i);

/* Called with the name of each temporary file when it appears and when it is gone, so that a signal can remove it. */
void img_set_temporary_hooks(int (*added)(const char *name), void (*gone)(const char *name));

#ifdef __cplusplus
}
#endif

#endif
