/* SPDX-License-Identifier: Apache-2.0 */
/* A file that is being written. */
#ifndef ZT_FILE_WRITE_H
#define ZT_FILE_WRITE_H

#include "base_diag.h"
#include "base_memory.h"
#include "base_parallel.h"
#include "file_codec.h"
#include "file_layout.h"
#include "file_mip.h"
#include "file_output.h"
#include "file_spool.h"
#include "zt/zt_write.h"

/* A unit's tiles: all there when tiles_done == tile_count. A record with stored_size 0 is of a tile that is not. */
typedef struct zt__write_unit {
    uint64_t tile_count, tiles_done;
    zt__tile_record *records;
    uint64_t *places;       /* in the spool */
    zt__unit_record record; /* when the file is laid out */
} zt__write_unit;

typedef enum zt__write_mode { ZT__WRITE_UNTOUCHED = 0, ZT__WRITE_ROWS = 1, ZT__WRITE_STORED = 2 } zt__write_mode;

/* One row of tiles that is being filled. */
typedef struct zt__band {
    uint8_t *bytes;
    uint32_t rows; /* that it has got */
} zt__band;

typedef struct zt__write_level {
    zt_level_info info;
    zt__write_mode mode;
    uint64_t rows_done, row_count; /* rows of blocks in all slices and layers */
    uint32_t first_row; /* not 0: rows come in cyclic order (file_mip.h), and the first row of tiles is filled last */
    uint64_t band_size;
    zt__band band, first_band;
} zt__write_level;

typedef struct zt__write_image {
    zt__image_record record;
    const zt_format_info *format; /* NULL: unknown */
    zt_image_desc desc;
    uint32_t tail_level, unit_count;
    zt__write_unit *units;
    zt__write_level *levels;
    uint8_t *tail;
    uint64_t tail_size, tail_rows_done, tail_row_count;
    bool chooses_edge; /* once level 0 is there, in held */
    uint8_t *held;
    uint64_t held_size;
    uint32_t cover_at, cover_size; /* zero_border: bytes of a texel that are made zero; size 0: no zero border */
    zt__mip *mip;
    void *mip_target; /* user of its sink */
    uint32_t layer;   /* that the mip levels are being made of */
} zt__write_image;

typedef struct zt__write_texture {
    zt__texture_entry entry;
    char *name;
    zt__layer_entry *layers;
    uint64_t name_hash;
    void *payload; /* of the texture's kind */
} zt__write_texture;

typedef struct zt__write_pair {
    char *key, *value;
} zt__write_pair;

typedef struct zt__write_chunk {
    zt__entry entry;
    uint8_t *bytes; /* stored */
    uint64_t capacity;
} zt__write_chunk;

/* The layers above that know what payloads are. */
typedef struct zt__write_hooks {
    /* The payload chunk's bytes: *capacity allocated from the writer's memory, *size used. */
    zt_result (*encode)(zt__encoder *encoder, uint8_t kind, const void *payload, zt_diag *diag, uint8_t **bytes,
                        uint64_t *capacity, size_t *size);
    void (*free)(zt_writer *writer, uint8_t kind, void *payload);
} zt__write_hooks;

/* A coded tile on its way to the spool. */
typedef struct zt__write_slot {
    uint8_t *coded;
    uint64_t room; /* for texels: coded has zt__encode_bound of it */
    size_t size;
    zt__tile_record record;
    zt_result result;
} zt__write_slot;

/* The tile that a worker is at. */
typedef struct zt__tile_buffer {
    uint8_t *bytes;
    uint64_t room;
} zt__tile_buffer;

struct zt_writer {
    zt__memory memory;
    zt_limits limits;
    zt_parallel parallel;
    const zt_parallel *parallel_or_null;
    zt_writer_options options;
    bool dead; /* finished, or failed so that it cannot go on */
    zt_sink sink;
    bool to_sink;
    char *path, *folder;
    zt__spool spool;
    unsigned worker_count;
    zt__encoder *encoders; /* one a worker */
    zt__write_slot *slots;
    uint32_t slot_count;
    zt__tile_buffer *tile_buffers; /* one a worker */
    const zt__write_hooks *hooks;  /* set with the first payload */
    zt__write_image **images;
    uint32_t image_count, image_capacity;
    zt__write_texture *textures;
    uint32_t texture_count, texture_capacity;
    zt__write_pair *pairs;
    uint32_t pair_count, pair_capacity;
    zt__write_chunk *chunks; /* of unknown types */
    uint32_t chunk_count, chunk_capacity;
};

/* A public call begins: ZT_BAD_ARGUMENT when the writer is NULL or dead. */
zt_result zt__writer_begin(zt_writer *writer, zt_diag *diag);
/* It ends: any failure but a wrong argument leaves things half-done, and the writer is dead. */
zt_result zt__writer_end(zt_writer *writer, zt_result result);

/* A sink of the writer's checks, and what their result means for the caller: a broken rule is a wrong argument. */
zt__sink zt__write_sink(zt_diag *diag);
zt_result zt__write_verdict(zt_diag *diag, zt_result result);

/* Room for one more element. */
zt_result zt__grow(zt__memory *memory, void **array, uint32_t *capacity, uint32_t count, size_t size, zt_diag *diag);
zt_result zt__copy_text(zt__memory *memory, const char *text, zt_diag *diag, char **out);

/* An enumerator as its byte in the file; 255: too large for one. */
static inline uint8_t zt__byte_of(unsigned v) {
    return (uint8_t)(v < 255 ? v : 255);
}

/* Checks a texture, copies what it says and appends it; payload becomes the writer's on success. */
zt_result zt__write_texture_add(zt_writer *writer, const zt_texture_desc *desc, zt_kind kind,
                                const zt_layer_desc *layers, uint32_t layer_count, void *payload, zt_diag *diag,
                                uint32_t *texture);

/* file_image.c */
void zt__write_image_free(zt_writer *writer, zt__write_image *image);
/* Levels and units as the record says; and their end. */
zt_result zt__write_geometry(zt_writer *writer, zt__write_image *image, zt_diag *diag);
void zt__write_geometry_free(zt_writer *writer, zt__write_image *image);
void zt__write_unit_free(zt_writer *writer, zt__write_unit *unit);

/* file_edge.c: whether the image's tile edge is still to be chosen; the place of the next rows of level 0 until then;
 * choosing it when they are all there. */
bool zt__write_chooses_edge(const zt_writer *writer, const zt__write_image *image);
zt_result zt__write_hold(zt_writer *writer, zt__write_image *image, uint32_t count, zt_diag *diag, uint8_t **dst);
zt_result zt__write_choose_edge(zt_writer *writer, zt__write_image *image, zt_diag *diag);
void zt__write_held_free(zt_writer *writer, zt__write_image *image);

/* file_rows.c: rows of a level in their natural order; a tile that has been coded. */
zt_result zt__write_rows(zt_writer *writer, zt__write_image *image, uint32_t level, const uint8_t *rows, uint32_t count,
                         size_t pitch, zt_diag *diag);
zt_result zt__write_tile(zt_writer *writer, zt__write_image *image, uint32_t unit, uint64_t tile,
                         const zt__tile_record *record, const void *stored, zt_diag *diag);
/* One row of tiles out of whole rows. slice: number of the slice in the level, over all layers. */
zt_result zt__write_band(zt_writer *writer, zt__write_image *image, uint32_t level, const uint8_t *band, uint64_t slice,
                         uint32_t tile_y, zt_diag *diag);
/* All rows of level 0, whose tiles have been coded: makes the other levels of them. */
zt_result zt__write_coded_rows(zt_writer *writer, zt__write_image *image, const uint8_t *rows, zt_diag *diag);
/* Releases what an image needs only while it is filled. */
void zt__write_rows_free(zt_writer *writer, zt__write_image *image);

/* Bytes to the stored form of a chunk. */
zt_result zt__write_chunk_of(zt_writer *writer, uint32_t type, uint16_t version, uint8_t flags, const void *data,
                             size_t size, zt_diag *diag, zt__write_chunk *out);
void zt__write_chunk_free(zt_writer *writer, zt__write_chunk *chunk);

/* file_finish.c */
zt_result zt__write_file(zt_writer *writer, zt_diag *diag);

#endif
