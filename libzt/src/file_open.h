/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An opened file. zt__walk is the only reader of the container: zt_open_... and zt_check_... both call it, with
 * different sinks.
 */
#ifndef ZT_FILE_OPEN_H
#define ZT_FILE_OPEN_H

#include <stdatomic.h>

#include "base_diag.h"
#include "base_io.h"
#include "base_memory.h"
#include "file_codec.h"
#include "file_layout.h"

/* A level's tile index, read on first touch and published once. */
typedef struct zt__tile_index {
    uint64_t count;
    uint64_t block_size;      /* bytes of the one block that all of this is in */
    uint64_t *offsets;        /* count + 1 running sums from the unit's first tile; in the same block as records */
    zt__tile_record *records; /* count */
} zt__tile_index;

typedef struct zt__unit {
    zt__unit_record record;
    uint64_t tile_count;
    _Atomic(zt__tile_index *) index; /* NULL: not read yet */
} zt__unit;

typedef struct zt__image {
    zt__image_record record;
    const zt_format_info *format; /* NULL: not in the registry */
    uint32_t tail_level;
    uint32_t first_unit; /* in zt_file.units; units of an image: levels before the tail, then the tail */
    uint32_t unit_count;
} zt__image;

typedef struct zt__texture {
    zt__texture_entry entry;
    const char *name;       /* NUL-terminated, in zt_file.names */
    uint32_t first_layer;   /* in zt_file.layers */
    uint32_t payload_chunk; /* directory index; ZT_NONE for images */
    void *payload;          /* zt__zipmap, zt__silmap or zt__umbrellas, made by texture.c; see zt__texture_hooks */
} zt__texture;

typedef struct zt__metadata {
    uint32_t count;
    uint64_t block_size;         /* bytes of the one block that all of this is in */
    const char **keys, **values; /* NUL-terminated */
} zt__metadata;

struct zt_file {
    zt__memory memory;
    zt_io io;
    zt__memory_io memory_io;
    zt__path_io path_io; /* fd -1: not a path */
    zt_limits limits;    /* defaults filled in */
    uint32_t flags;      /* ZT_OPEN_... */
    zt__preamble preamble;
    uint32_t chunk_count;
    zt__entry *entries;
    uint32_t image_count;
    zt__image *images;
    uint32_t unit_count;
    zt__unit *units;
    uint64_t texels_offset; /* of TEXL's stored bytes in the file */
    uint64_t texels_size;
    uint32_t texture_count, layer_count;
    zt__texture *textures;
    zt__layer_entry *layers;
    char *names;
    uint64_t names_size;
    _Atomic(zt__metadata *) metadata; /* NULL: not loaded */
};

/* Fills zero fields with the defaults of zt.h. */
void zt__limits_fill(zt_limits *limits);

/* What a payload may refer to, in a file that is read or written. */
typedef struct zt__payload_scope {
    uint32_t texture, layer_count; /* of its texture: own index, and layers */
    uint8_t wrap_u, wrap_v;
    uint32_t image_count;
    const zt__image_record *(*image_of)(const void *user, uint32_t image); /* NULL: out of range */
    uint32_t (*texture_layers)(const void *user, uint32_t texture);        /* layer count of an earlier texture */
    const void *user;
} zt__payload_scope;

/* The layers above the file that open textures' payloads; file_open knows nothing of what they are. */
typedef struct zt__payload_hooks {
    /* Decodes the payload chunk (its bytes, raw) of textures[texture]; sets textures[texture].payload. */
    zt_result (*open)(zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t texture, const uint8_t *data,
                      size_t size, uint64_t offset);
    void (*close)(zt_file *file, uint32_t texture);
} zt__payload_hooks;

/* Where the bytes of a file come from. */
typedef enum zt__source_kind { ZT__FROM_MEMORY = 0, ZT__FROM_PATH = 1, ZT__FROM_IO = 2 } zt__source_kind;

typedef struct zt__source {
    zt__source_kind kind;
    const void *data; /* of size bytes, which must stay */
    size_t size;
    const char *path;
    const zt_io *io; /* copied */
} zt__source;

/* Allocates an empty file with allocator and limits, that reads from source. */
zt_result zt__file_new(const zt_open_options *options, const zt__source *source, zt_diag *diag, zt_file **out);

/* What a directory entry says, in public. */
void zt__chunk_info_of(const zt__entry *entry, zt_chunk_info *out);

/* file may be NULL; hooks may be NULL before the walk. */
void zt__file_free(zt_file *file, const zt__payload_hooks *hooks);

/* Reads and checks preamble, directory, structure chunks. In the validator it goes on where it can; *usable says
 * whether images may be decoded. */
zt_result zt__walk(zt_file *file, zt__sink *sink, const zt__payload_hooks *hooks, bool *usable);

/* What an opened file loads on first touch is counted in its budget, which is therefore not const. The one place that
 * says so. */
static inline zt__memory *zt__memory_of(const zt_file *file) {
    return &((zt_file *)(uintptr_t)file)->memory;
}

/* TEXS, and the payloads of its textures through the hooks (rules 6101 to 6110). */
zt_result zt__read_textures(zt_file *file, zt__sink *sink, zt__decoder *decoder, const zt__payload_hooks *hooks);

/* Sets the path to the chunk's type. */
void zt__enter_chunk(zt__sink *sink, const zt_file *file, uint32_t chunk);

/* Rules 4001 and 4002 for the 64 bytes of a head; 4005 for the padding behind a chunk. */
zt_result zt__check_head(zt__sink *sink, const zt_file *file, uint32_t chunk, const uint8_t *bytes);
zt_result zt__check_chunk_padding(zt__sink *sink, const zt_file *file, uint32_t chunk, const uint8_t *padding,
                                  size_t size);

/* Place in the file of decoded byte i of a chunk; for compressed chunks, that of the stored bytes. */
static inline uint64_t zt__place(const zt__entry *e, uint64_t i) {
    return e->offset + ZT__HEAD_SIZE + (e->codec == ZT__CODEC_RAW ? i : 0);
}

/* Reads a chunk whole: head and padding (rules 4001, 4002, 4005), stored hash (4003), decoding (4004). dst has
 * entry->decoded_size bytes. */
zt_result zt__read_chunk(const zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t chunk, void *dst);

/* META, decoded and checked; the caller frees with zt__free(&file->memory, m, 1, m->block_size). */
zt_result zt__read_metadata(const zt_file *file, zt__sink *sink, zt__metadata **out);

/* The tile index of a unit, read and checked (5201, 5202, 5204, 5205) on first touch. */
zt_result zt__tile_index_of(const zt_file *file, zt__sink *sink, uint32_t image, uint32_t unit,
                            const zt__tile_index **out);

/* Reads and decodes one tile of a unit into rows of dst that begin pitch bytes apart (0: tight): rules 5001 to 5004,
 * 5203, 5302 to 5312. dst has room for the tile as the geometry gives it. */
zt_result zt__read_tile_into(const zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t image, uint32_t unit,
                             uint64_t tile, void *dst, size_t pitch);

/* Decoded size of a tile of a unit. */
uint32_t zt__unit_tile_size(const zt__image *image, uint32_t unit, uint64_t tile);

#endif
