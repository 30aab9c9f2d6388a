/* SPDX-License-Identifier: Apache-2.0 */
#include "seal.h"

#include <xxhash.h>
#include <zstd.h>

static uint8_t scratch[2][FUZZ_DECODED]; /* decoded bytes; planes need two steps */

static size_t align16(size_t v) {
    return (v + 15) & ~(size_t)15;
}

/* ---- taking apart ---- */

static size_t body_at(const uint8_t *entry, size_t expected, size_t size) {
    uint64_t offset = fuzz_load64(entry + ENTRY_OFFSET);
    size_t at = offset < size ? (size_t)offset : expected;
    return at + HEAD_SIZE < size ? at + HEAD_SIZE : size;
}

bool fuzz_parse(fuzz_file *file, const uint8_t *data, size_t size, size_t capacity) {
    enum { ROOM = 4096 }; /* for growth; more would only cost time */
    memset(file, 0, sizeof *file);
    if (size < PREAMBLE_SIZE + ENTRY_SIZE)
        return false;
    memcpy(file->preamble, data, PREAMBLE_SIZE);
    file->capacity = capacity < size + ROOM ? capacity : size + ROOM;
    capacity = file->capacity;
    uint32_t count = fuzz_load32(data + 28);
    size_t room = (size - PREAMBLE_SIZE) / ENTRY_SIZE, expected = align16(PREAMBLE_SIZE + (size_t)count * ENTRY_SIZE);
    if (count == 0 || count > room || count > FUZZ_CHUNKS)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        fuzz_chunk *chunk = &file->chunks[i];
        memcpy(chunk->entry, data + PREAMBLE_SIZE + (size_t)i * ENTRY_SIZE, ENTRY_SIZE);
        uint64_t stored = fuzz_load64(chunk->entry + ENTRY_STORED_SIZE);
        size_t at = body_at(chunk->entry, expected, size);
        chunk->size = stored < size - at ? (size_t)stored : size - at;
        chunk->size = chunk->size < capacity ? chunk->size : capacity;
        chunk->body = fuzz_malloc(capacity);
        memcpy(chunk->body, data + at, chunk->size);
        expected = align16(at + chunk->size);
    }
    file->count = count;
    return true;
}

void fuzz_release(fuzz_file *file) {
    for (uint32_t i = 0; i < file->count; i++)
        free(file->chunks[i].body);
    file->count = 0;
}

fuzz_chunk *fuzz_find(fuzz_file *file, const char *type) {
    for (uint32_t i = 0; i < file->count; i++) {
        if (memcmp(file->chunks[i].entry, type, 4) == 0)
            return &file->chunks[i];
    }
    return NULL;
}

/* ---- codecs ---- */

size_t fuzz_unzstd(const uint8_t *src, size_t size, uint8_t *dst) {
    unsigned long long content = ZSTD_getFrameContentSize(src, size);
    if (content == 0 || content > FUZZ_DECODED)
        return 0;
    size_t got = ZSTD_decompress(dst, FUZZ_DECODED, src, size);
    return ZSTD_isError(got) ? 0 : got;
}

void fuzz_recode(fuzz_file *file, fuzz_chunk *chunk) {
    if (chunk->entry[ENTRY_CODEC] == 1) {
        size_t size = fuzz_unzstd(chunk->body, chunk->size, scratch[0]);
        if (size == 0 || size > file->capacity)
            return;
        memcpy(chunk->body, scratch[0], size);
        chunk->size = size;
        chunk->entry[ENTRY_CODEC] = 0;
        return;
    }
    size_t size = ZSTD_compress(scratch[0], FUZZ_DECODED, chunk->body, chunk->size, 1);
    if (ZSTD_isError(size) || size >= chunk->size)
        return;
    memcpy(chunk->body, scratch[0], size);
    chunk->size = size;
    chunk->entry[ENTRY_CODEC] = 1;
}

/* ---- units and tiles ---- */

uint32_t fuzz_unit_count(fuzz_file *file) {
    const fuzz_chunk *imag = fuzz_find(file, "IMAG");
    if (!imag || imag->entry[ENTRY_CODEC] != 0 || imag->size < 16)
        return 0;
    uint64_t images = (uint64_t)fuzz_load32(imag->body) * IMAGE_RECORD_SIZE, units = fuzz_load32(imag->body + 4);
    if (images > imag->size - 16)
        return 0;
    uint64_t room = (imag->size - 16 - images) / UNIT_RECORD_SIZE;
    return (uint32_t)(units < room ? units : room);
}

static uint32_t count_tiles(const uint8_t *unit, size_t size) {
    uint64_t sum = 0;
    for (uint32_t n = 1; (uint64_t)n * TILE_RECORD_SIZE + sum < size; n++) {
        sum += fuzz_load32(unit + (size_t)(n - 1) * TILE_RECORD_SIZE);
        if ((uint64_t)n * TILE_RECORD_SIZE + sum == size)
            return n;
    }
    return 0;
}

bool fuzz_unit_of(fuzz_file *file, uint32_t index, fuzz_unit *out) {
    const fuzz_chunk *imag = fuzz_find(file, "IMAG"), *texl = fuzz_find(file, "TEXL");
    memset(out, 0, sizeof *out);
    if (!texl || index >= fuzz_unit_count(file))
        return false;
    out->record = imag->body + 16 + (size_t)fuzz_load32(imag->body) * IMAGE_RECORD_SIZE +
                  (size_t)index * UNIT_RECORD_SIZE;
    uint64_t at = fuzz_load64(out->record), size = fuzz_load64(out->record + 8);
    if (at > texl->size || size > texl->size - at)
        return false;
    out->at = (size_t)at;
    out->size = (size_t)size;
    out->tile_count = count_tiles(texl->body + at, (size_t)size);
    return out->tile_count > 0;
}

static uint64_t hash_of_decoded(uint8_t codec, const uint8_t *stored, size_t size, uint64_t otherwise) {
    if (codec == 0)
        return XXH3_64bits(stored, size);
    size_t decoded = codec == 1 ? fuzz_unzstd(stored, size, scratch[0]) : 0;
    return decoded > 0 ? XXH3_64bits(scratch[0], decoded) : otherwise;
}

static void seal_units(fuzz_file *file, unsigned skip) {
    fuzz_unit unit;
    uint32_t count = fuzz_unit_count(file);
    for (uint32_t i = 0; i < count; i++) {
        if (!fuzz_unit_of(file, i, &unit))
            continue;
        uint8_t *index = fuzz_find(file, "TEXL")->body + unit.at;
        const uint8_t *stored = index + (size_t)unit.tile_count * TILE_RECORD_SIZE;
        for (uint32_t t = 0; t < unit.tile_count && !(skip & SEAL_TILES); t++) {
            uint8_t *record = index + (size_t)t * TILE_RECORD_SIZE;
            size_t size = fuzz_load32(record);
            fuzz_store(record + 8, hash_of_decoded(record[4], stored, size, fuzz_load64(record + 8)), 8);
            stored += size;
        }
        if (!(skip & SEAL_INDICES))
            fuzz_store(unit.record + 16, XXH3_64bits(index, (size_t)unit.tile_count * TILE_RECORD_SIZE), 8);
    }
}

/* ---- planes ---- */

size_t fuzz_planes_at(const fuzz_chunk *chunk) {
    if (memcmp(chunk->entry, "ZPMP", 4) == 0)
        return 16;
    if (memcmp(chunk->entry, "UMBR", 4) == 0)
        return 104;
    return memcmp(chunk->entry, "SLMP", 4) == 0 ? 24 : 0;
}

bool fuzz_next_plane(const fuzz_chunk *chunk, size_t *at, size_t *stored_size) {
    if (*at > chunk->size || chunk->size - *at < PLANE_HEADER_SIZE)
        return false;
    uint64_t left = chunk->size - *at - PLANE_HEADER_SIZE, stored = fuzz_load32(chunk->body + *at + 20);
    *stored_size = (size_t)(stored < left ? stored : left);
    return true;
}

static uint64_t element_bits(const uint8_t *packed, size_t size, uint64_t first, uint32_t count) {
    uint64_t value = 0;
    for (uint32_t b = 0; b < count; b++) {
        uint64_t bit = first + b;
        if (bit / 8 < size)
            value |= (uint64_t)(packed[bit / 8] >> bit % 8 & 1) << b;
    }
    return value;
}

size_t fuzz_decode_plane(const uint8_t *p, size_t stored_size, uint8_t *dst) {
    const uint8_t *packed = p + PLANE_HEADER_SIZE;
    uint32_t edge = p[0], predictor = p[1], packing = p[2], count = fuzz_load32(p + 16);
    uint64_t last = 0, before = 0, size = (uint64_t)edge * count;
    if ((edge != 1 && edge != 2 && edge != 4 && edge != 8) || size == 0 || size > FUZZ_DECODED)
        return 0;
    if (p[3] == 1) {
        stored_size = fuzz_unzstd(packed, stored_size, scratch[1]);
        packed = scratch[1];
    }
    if (packing != 2 && stored_size != size)
        return 0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t e = 0;
        for (uint32_t b = 0; b < edge && packing != 2; b++)
            e |= (uint64_t)packed[packing == 1 ? (size_t)b * count + i : (size_t)i * edge + b] << 8 * b;
        if (packing == 2)
            e = fuzz_load64(p + 8) + element_bits(packed, stored_size, (uint64_t)i * p[4], p[4] <= 64 ? p[4] : 64);
        if (predictor != 0)
            e = ((e >> 1) ^ (0 - (e & 1))) + (predictor == 1 ? last : 2 * last - before);
        before = last;
        last = e;
        fuzz_store(dst + (size_t)i * edge, e, edge);
    }
    return (size_t)size;
}

static void seal_planes(const fuzz_chunk *chunk) {
    size_t stored, at = fuzz_planes_at(chunk);
    while (at > 0 && fuzz_next_plane(chunk, &at, &stored)) {
        size_t size = fuzz_decode_plane(chunk->body + at, stored, scratch[0]);
        if (size > 0)
            fuzz_store(chunk->body + at + 24, XXH3_64bits(scratch[0], size), 8);
        at += PLANE_HEADER_SIZE + stored;
    }
}

/* ---- chunks and directory ---- */

static void seal_chunk(fuzz_chunk *chunk, size_t offset, unsigned skip) {
    size_t decoded = chunk->size;
    const uint8_t *bytes = chunk->body;
    if (chunk->entry[ENTRY_CODEC] == 1) {
        decoded = fuzz_unzstd(chunk->body, chunk->size, scratch[0]);
        bytes = scratch[0];
    }
    if (!(skip & SEAL_SIZES)) {
        fuzz_store(chunk->entry + ENTRY_STORED_SIZE, chunk->size, 8);
        if (decoded > 0)
            fuzz_store(chunk->entry + ENTRY_DECODED_SIZE, decoded, 8);
    }
    if (!(skip & SEAL_HASHES)) {
        fuzz_store(chunk->entry + ENTRY_STORED_HASH, XXH3_64bits(chunk->body, chunk->size), 8);
        if (decoded > 0)
            fuzz_store(chunk->entry + ENTRY_DECODED_HASH, XXH3_64bits(bytes, decoded), 8);
    }
    if (!(skip & SEAL_OFFSETS))
        fuzz_store(chunk->entry + ENTRY_OFFSET, offset, 8);
}

static void apply_edits(fuzz_file *file, fuzz_place place, uint8_t *out, size_t size) {
    for (uint32_t i = 0; i < file->edit_count; i++) {
        const fuzz_edit *edit = &file->edits[i];
        if (edit->place != place || size < 8)
            continue;
        if (place == PLACE_PREAMBLE)
            fuzz_store(file->preamble + edit->at, edit->value, edit->size);
        else if (place == PLACE_ENTRY && edit->chunk < file->count)
            fuzz_store(file->chunks[edit->chunk].entry + edit->at, edit->value, edit->size);
        else if (place == PLACE_ANYWHERE)
            fuzz_store(out + edit->at % (size - 7), edit->value, edit->size);
    }
}

static void write_head(fuzz_file *file, uint32_t index, uint8_t *head) {
    static const uint8_t magic[8] = {0xAB, 0x5A, 0x54, 0x63, 0x68, 0x6B, 0xBB, 0x0A};
    memcpy(head, magic, sizeof magic);
    fuzz_store(head + 8, index, 4);
    memcpy(head + 16, file->chunks[index].entry, ENTRY_SIZE);
    for (uint32_t i = 0; i < file->edit_count; i++) {
        const fuzz_edit *edit = &file->edits[i];
        if (edit->place == PLACE_HEAD && edit->chunk == index)
            fuzz_store(head + edit->at, edit->value, edit->size);
    }
}

static void seal_preamble(fuzz_file *file, size_t size, unsigned skip) {
    static const uint8_t magic[10] = {0xAB, 0x5A, 0x54, 0x45, 0x58, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A};
    if (skip & SEAL_SIZES)
        return;
    memcpy(file->preamble, magic, sizeof magic);
    fuzz_store(file->preamble + 16, size, 8);
    fuzz_store(file->preamble + 24, (uint64_t)file->count * ENTRY_SIZE, 4);
    fuzz_store(file->preamble + 28, file->count, 4);
}

size_t fuzz_seal(fuzz_file *file, unsigned skip, uint8_t *out, size_t max_size) {
    enum { COVERED = 56 };
    static uint8_t hashed[COVERED + FUZZ_CHUNKS * ENTRY_SIZE];
    size_t at = align16(PREAMBLE_SIZE + (size_t)file->count * ENTRY_SIZE);
    seal_units(file, skip);
    for (uint32_t i = 0; i < file->count; i++) {
        if (!(skip & SEAL_PLANES))
            seal_planes(&file->chunks[i]);
        seal_chunk(&file->chunks[i], at, skip);
        at = align16(at + HEAD_SIZE + file->chunks[i].size);
    }
    if (at > max_size)
        return 0;
    seal_preamble(file, at, skip);
    memset(out, 0, at);
    apply_edits(file, PLACE_PREAMBLE, out, at);
    apply_edits(file, PLACE_ENTRY, out, at);
    memcpy(hashed, file->preamble, COVERED);
    for (uint32_t i = 0; i < file->count; i++)
        memcpy(hashed + COVERED + (size_t)i * ENTRY_SIZE, file->chunks[i].entry, ENTRY_SIZE);
    if (!(skip & SEAL_DIRECTORY))
        fuzz_store(file->preamble + COVERED, XXH3_64bits(hashed, COVERED + (size_t)file->count * ENTRY_SIZE), 8);
    memcpy(out, file->preamble, PREAMBLE_SIZE);
    memcpy(out + PREAMBLE_SIZE, hashed + COVERED, (size_t)file->count * ENTRY_SIZE);
    size_t place = align16(PREAMBLE_SIZE + (size_t)file->count * ENTRY_SIZE);
    for (uint32_t i = 0; i < file->count; i++) {
        if (!(skip & SEAL_HEADS))
            write_head(file, i, out + place);
        memcpy(out + place + HEAD_SIZE, file->chunks[i].body, file->chunks[i].size);
        place = align16(place + HEAD_SIZE + file->chunks[i].size);
    }
    apply_edits(file, PLACE_ANYWHERE, out, at);
    return at;
}
