/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A .ztex file taken apart leniently, to be changed and sealed again: sizes, offsets, heads and hashes are computed
 * anew, so that a change is judged by the rule that it breaks and not by a checksum in front of it.
 */
#ifndef ZT_FUZZ_SEAL_H
#define ZT_FUZZ_SEAL_H

#include <stdbool.h>

#include "support.h"

enum { FUZZ_CHUNKS = 48, FUZZ_EDITS = 8, FUZZ_DECODED = 1 << 20 };

/* Offsets of fields (spec/ztex.md). */
enum {
    PREAMBLE_SIZE = 64,
    ENTRY_SIZE = 48,
    HEAD_SIZE = 64,
    ENTRY_CODEC = 7,
    ENTRY_OFFSET = 8,
    ENTRY_STORED_SIZE = 16,
    ENTRY_DECODED_SIZE = 24,
    ENTRY_STORED_HASH = 32,
    ENTRY_DECODED_HASH = 40,
    IMAGE_RECORD_SIZE = 32,
    UNIT_RECORD_SIZE = 24,
    TILE_RECORD_SIZE = 16,
    PLANE_HEADER_SIZE = 32
};

/* Steps of sealing, as bits; a step that is skipped leaves what was there. */
enum {
    SEAL_TILES = 1,
    SEAL_INDICES = 2,
    SEAL_PLANES = 4,
    SEAL_SIZES = 8,
    SEAL_HASHES = 16,
    SEAL_OFFSETS = 32,
    SEAL_HEADS = 64,
    SEAL_DIRECTORY = 128,
    SEAL_STEPS = 8
};

typedef struct fuzz_chunk {
    uint8_t entry[ENTRY_SIZE];
    uint8_t *body; /* stored bytes, in a block of fuzz_file.capacity */
    size_t size;
} fuzz_chunk;

/* A change to what sealing computes: made behind that step and before the hashes over it. */
typedef enum fuzz_place { PLACE_PREAMBLE, PLACE_ENTRY, PLACE_HEAD, PLACE_ANYWHERE } fuzz_place;

typedef struct fuzz_edit {
    fuzz_place place;
    uint32_t chunk; /* entry, head */
    size_t at;      /* in the structure; anywhere: in the file, modulo its size */
    uint8_t size;   /* 1, 2, 4 or 8 */
    uint64_t value;
} fuzz_edit;

typedef struct fuzz_file {
    uint8_t preamble[PREAMBLE_SIZE];
    uint32_t count;
    fuzz_chunk chunks[FUZZ_CHUNKS];
    size_t capacity; /* of each body */
    uint32_t edit_count;
    fuzz_edit edits[FUZZ_EDITS];
} fuzz_file;

/* False when there are no entries to be found. Bodies get room for capacity bytes. */
bool fuzz_parse(fuzz_file *file, const uint8_t *data, size_t size, size_t capacity);
void fuzz_release(fuzz_file *file);

/* Seals all but the steps in skip and writes the file. Returns its size, or 0: more than max_size. */
size_t fuzz_seal(fuzz_file *file, unsigned skip, uint8_t *out, size_t max_size);

/* First chunk of a type ("IMAG"), or NULL. */
fuzz_chunk *fuzz_find(fuzz_file *file, const char *type);

/* Decodes a frame of at most FUZZ_DECODED bytes. Returns its size, or 0. */
size_t fuzz_unzstd(const uint8_t *src, size_t size, uint8_t *dst);

/* Changes a chunk from raw to zstd or back; nothing when that cannot be. */
void fuzz_recode(fuzz_file *file, fuzz_chunk *chunk);

/* A unit's tiles are found without geometry: records follow each other until they and the tiles fill the unit. */
typedef struct fuzz_unit {
    uint8_t *record;     /* in IMAG */
    size_t at, size;     /* in TEXL */
    uint32_t tile_count; /* 0: not a unit that fits */
} fuzz_unit;

uint32_t fuzz_unit_count(fuzz_file *file);
bool fuzz_unit_of(fuzz_file *file, uint32_t index, fuzz_unit *out);

/* Where the planes of a payload chunk begin, behind its header; 0: it has none. */
size_t fuzz_planes_at(const fuzz_chunk *chunk);

/* Planes of a payload chunk: header at *at; false behind the last. */
bool fuzz_next_plane(const fuzz_chunk *chunk, size_t *at, size_t *stored_size);

/* Decoded bytes of the plane whose header is at p, stored_size bytes behind it; 0: it cannot be decoded. */
size_t fuzz_decode_plane(const uint8_t *p, size_t stored_size, uint8_t *dst);

#endif
