/* SPDX-License-Identifier: Apache-2.0 */
#include "mutate.h"

#include <zstd.h>

typedef struct mutation {
    fuzz_file file;
    fuzz_random random;
} mutation;

static uint8_t bytes[FUZZ_DECODED]; /* a tile or plane while it is changed */

static uint32_t below(mutation *m, size_t count) {
    return fuzz_below(&m->random, (uint32_t)count);
}

/* ---- values ---- */

static const uint64_t special[] = {0,
                                   1,
                                   2,
                                   15,
                                   16,
                                   17,
                                   48,
                                   64,
                                   0x7F,
                                   0x80,
                                   0xFF,
                                   0x7FFF,
                                   0xFFFF,
                                   0x10000,
                                   1 << 18,
                                   (1 << 20) - 1,
                                   1 << 20,
                                   (1 << 20) + 1,
                                   0x7FFFFFFF,
                                   0x80000000,
                                   0xFFFFFFFE,
                                   0xFFFFFFFF,
                                   UINT64_C(1) << 32,
                                   (UINT64_C(1) << 53) - 1,
                                   UINT64_C(1) << 53,
                                   UINT64_MAX >> 1,
                                   UINT64_MAX - 63,
                                   UINT64_MAX,
                                   UINT64_C(0x3FF0000000000000),  /* 1.0 */
                                   UINT64_C(0x3FF0000000000001),  /* and the next */
                                   UINT64_C(0xBFF0000000000000),  /* -1.0 */
                                   UINT64_C(0x8000000000000000),  /* -0.0 */
                                   UINT64_C(0x7FF0000000000000),  /* infinity */
                                   UINT64_C(0x7FF8000000000000),  /* not a number */
                                   UINT64_C(0x7FEFFFFFFFFFFFFF),  /* the largest */
                                   UINT64_C(0x0010000000000000),  /* the smallest that is normal */
                                   UINT64_C(0x0000000000000001)}; /* the smallest */

/* A value for a field of size bytes that holds p now. */
static uint64_t value_for(mutation *m, const uint8_t *p, size_t size) {
    uint64_t old = 0;
    for (size_t i = size; i-- > 0;)
        old = old << 8 | p[i];
    switch (below(m, 8)) {
    case 0:
        return old + 1;
    case 1:
        return old - 1;
    case 2:
        return old * 2;
    case 3:
        return old ^ UINT64_C(1) << below(m, 8 * size);
    case 4:
        return below(m, 40);
    case 5:
        return fuzz_next(&m->random);
    default:
        return special[below(m, sizeof special / sizeof *special)];
    }
}

/* ---- fields that sealing computes ---- */

typedef struct field {
    uint8_t at, size;
} field;

static void add_edit(mutation *m, fuzz_place place, uint32_t chunk, size_t at, uint8_t size, uint64_t value) {
    if (m->file.edit_count == FUZZ_EDITS)
        return;
    fuzz_edit edit = {place, chunk, at, size, value};
    m->file.edits[m->file.edit_count++] = edit;
}

static void edit_preamble(mutation *m) {
    static const field fields[] = {{0, 1},  {5, 1},  {9, 1},  {10, 2}, {12, 2}, {14, 2},
                                   {16, 8}, {24, 4}, {28, 4}, {32, 8}, {40, 8}, {48, 8}};
    const field *f = &fields[below(m, sizeof fields / sizeof *fields)];
    add_edit(m, PLACE_PREAMBLE, 0, f->at, f->size, value_for(m, m->file.preamble + f->at, f->size));
}

static void edit_entry(mutation *m) {
    static const field fields[] = {{0, 4}, {0, 1}, {4, 2}, {6, 1}, {7, 1}, {8, 8}, {16, 8}, {24, 8}, {32, 8}, {40, 8}};
    const field *f = &fields[below(m, sizeof fields / sizeof *fields)];
    uint32_t chunk = below(m, m->file.count);
    add_edit(m, PLACE_ENTRY, chunk, f->at, f->size, value_for(m, m->file.chunks[chunk].entry + f->at, f->size));
}

static void edit_head(mutation *m) {
    uint8_t zero[8] = {0};
    add_edit(m, PLACE_HEAD, below(m, m->file.count), below(m, HEAD_SIZE), 1, value_for(m, zero, 1));
}

static void edit_anywhere(mutation *m) {
    uint8_t zero[8] = {0};
    add_edit(m, PLACE_ANYWHERE, 0, (size_t)fuzz_next(&m->random), (uint8_t)(1u << below(m, 4)), value_for(m, zero, 8));
}

/* ---- chunks ---- */

/* TEXL is the last to be looked at and has changes of its own. */
static fuzz_chunk *pick_chunk(mutation *m) {
    uint32_t count = m->file.count > 1 && below(m, 8) ? m->file.count - 1 : m->file.count;
    return &m->file.chunks[below(m, count)];
}

static void edit_payload_field(mutation *m) {
    fuzz_chunk *chunk = pick_chunk(m);
    size_t size = (size_t)1 << below(m, 4);
    if (chunk->entry[ENTRY_CODEC] == 1 && below(m, 4))
        fuzz_recode(&m->file, chunk);
    if (chunk->size < size)
        return;
    uint8_t *p = chunk->body + below(m, (chunk->size - size) / size + 1) * size;
    fuzz_store(p, value_for(m, p, size), size);
}

static void edit_payload_bytes(mutation *m) {
    fuzz_chunk *chunk = pick_chunk(m);
    if (chunk->size > 0)
        chunk->size = LLVMFuzzerMutate(chunk->body, chunk->size, m->file.capacity);
}

/* Array elements put in or cut out, with the count in front of them or without. */
static void resize_payload(mutation *m) {
    static const uint8_t sizes[] = {1, 4, 8, 16, 24, 32};
    fuzz_chunk *chunk = pick_chunk(m);
    size_t size = sizes[below(m, sizeof sizes)];
    if (chunk->size < size + 16)
        return;
    size_t at = below(m, (chunk->size - size) / 4 + 1) * (size_t)4;
    bool grow = below(m, 2);
    if (grow && chunk->size + size <= m->file.capacity) {
        memmove(chunk->body + at + size, chunk->body + at, chunk->size - at);
        chunk->size += size;
    } else if (!grow) {
        memmove(chunk->body + at, chunk->body + at + size, chunk->size - at - size);
        chunk->size -= size;
    }
    uint8_t *count = chunk->body + 4 * (size_t)below(m, 3);
    if (below(m, 2))
        fuzz_store(count, fuzz_load32(count) + (grow ? 1u : UINT32_MAX), 4);
}

static void splice_payload(mutation *m) {
    fuzz_chunk *from = pick_chunk(m), *to = below(m, 2) ? from : pick_chunk(m);
    if (from->size < 4 || to->size < 4)
        return;
    size_t source = below(m, from->size / 4) * (size_t)4, target = below(m, to->size / 4) * (size_t)4;
    size_t size = 1 + below(m, 64);
    size = size < from->size - source ? size : from->size - source;
    size = size < to->size - target ? size : to->size - target;
    memmove(to->body + target, from->body + source, size);
}

static void recode_chunk(mutation *m) {
    fuzz_recode(&m->file, pick_chunk(m));
}

static void drop_chunk(mutation *m) {
    uint32_t chunk = below(m, m->file.count);
    if (m->file.count < 2)
        return;
    free(m->file.chunks[chunk].body);
    m->file.count--;
    memmove(&m->file.chunks[chunk], &m->file.chunks[chunk + 1], (m->file.count - chunk) * sizeof(fuzz_chunk));
}

static void insert_chunk(mutation *m, uint32_t place, const fuzz_chunk *chunk) {
    fuzz_chunk copy = *chunk;
    if (m->file.count == FUZZ_CHUNKS || chunk->size > m->file.capacity)
        return;
    copy.body = fuzz_malloc(m->file.capacity);
    memcpy(copy.body, chunk->body, chunk->size);
    memmove(&m->file.chunks[place + 1], &m->file.chunks[place], (m->file.count - place) * sizeof(fuzz_chunk));
    m->file.chunks[place] = copy;
    m->file.count++;
}

static void duplicate_chunk(mutation *m) {
    uint32_t chunk = below(m, m->file.count), place = below(m, 4) ? chunk : below(m, m->file.count + 1);
    uint32_t count = m->file.count;
    insert_chunk(m, place, &m->file.chunks[chunk]);
    if (m->file.count > count && below(m, 2))
        m->file.chunks[place].entry[below(m, 4)] = (uint8_t)('A' + below(m, 26)); /* a type that is not known */
}

static void swap_chunks(mutation *m) {
    uint32_t a = below(m, m->file.count), b = below(m, m->file.count);
    fuzz_chunk swap = m->file.chunks[a];
    m->file.chunks[a] = m->file.chunks[b];
    m->file.chunks[b] = swap;
}

/* ---- tiles ---- */

typedef struct tile {
    fuzz_unit unit;
    fuzz_chunk *texl;
    uint8_t *record;
    size_t at, size; /* stored bytes, in TEXL */
} tile;

static bool pick_tile(mutation *m, tile *t) {
    fuzz_chunk *imag = fuzz_find(&m->file, "IMAG");
    if (imag && imag->entry[ENTRY_CODEC] == 1)
        fuzz_recode(&m->file, imag);
    if (!fuzz_unit_of(&m->file, below(m, fuzz_unit_count(&m->file)), &t->unit))
        return false;
    t->texl = fuzz_find(&m->file, "TEXL");
    uint32_t index = below(m, t->unit.tile_count);
    uint8_t *records = t->texl->body + t->unit.at;
    t->record = records + (size_t)index * TILE_RECORD_SIZE;
    t->size = fuzz_load32(t->record);
    t->at = t->unit.at + (size_t)t->unit.tile_count * TILE_RECORD_SIZE;
    for (uint32_t i = 0; i < index; i++)
        t->at += fuzz_load32(records + (size_t)i * TILE_RECORD_SIZE);
    return true;
}

/* New stored bytes of any size: the record, the unit and the units behind it follow. */
static void replace_tile(mutation *m, const tile *t, uint8_t codec, const uint8_t *stored, size_t size) {
    fuzz_chunk *texl = t->texl;
    if (size == 0 || texl->size - t->size + size > m->file.capacity)
        return;
    memmove(texl->body + t->at + size, texl->body + t->at + t->size, texl->size - t->at - t->size);
    memcpy(texl->body + t->at, stored, size);
    texl->size = texl->size - t->size + size;
    fuzz_store(t->record, size, 4);
    t->record[4] = codec;
    uint64_t unit_at = t->unit.at;
    fuzz_store(t->unit.record + 8, t->unit.size - t->size + size, 8);
    uint32_t count = fuzz_unit_count(&m->file);
    fuzz_chunk *imag = fuzz_find(&m->file, "IMAG");
    uint8_t *first = imag->body + 16 + (size_t)fuzz_load32(imag->body) * IMAGE_RECORD_SIZE;
    for (uint32_t i = 0; i < count; i++) {
        uint8_t *other = first + (size_t)i * UNIT_RECORD_SIZE;
        uint64_t at = fuzz_load64(other);
        if (at > unit_at)
            fuzz_store(other, at - t->size + size, 8);
    }
}

static void edit_tile_record(mutation *m) {
    static const field fields[] = {{0, 4}, {4, 1}, {5, 1}, {8, 8}};
    tile t;
    if (!pick_tile(m, &t))
        return;
    const field *f = &fields[below(m, sizeof fields / sizeof *fields)];
    fuzz_store(t.record + f->at, value_for(m, t.record + f->at, f->size), f->size);
}

static void edit_tile_bytes(mutation *m) {
    tile t;
    if (!pick_tile(m, &t) || t.size + 64 > sizeof bytes)
        return;
    memcpy(bytes, t.texl->body + t.at, t.size);
    size_t size = LLVMFuzzerMutate(bytes, t.size, below(m, 2) ? t.size : t.size + 64);
    replace_tile(m, &t, t.record[4], bytes, size);
}

static void recode_tile(mutation *m) {
    tile t;
    if (!pick_tile(m, &t))
        return;
    const uint8_t *stored = t.texl->body + t.at;
    if (t.record[4] == 1) {
        replace_tile(m, &t, 0, bytes, fuzz_unzstd(stored, t.size, bytes));
        return;
    }
    size_t size = ZSTD_compress(bytes, sizeof bytes, stored, t.size, 1);
    if (!ZSTD_isError(size) && size < t.size)
        replace_tile(m, &t, 1, bytes, size);
}

/* ---- planes of payloads ---- */

/* Types with planes, and how many of them are counted off. */
static const struct {
    char type[5];
    uint32_t planes;
} payloads[] = {{"ZPMP", 14}, {"SLMP", 14}, {"UMBR", 44}};

static bool pick_plane(mutation *m, fuzz_chunk **chunk, size_t *at, size_t *stored) {
    enum { TYPES = sizeof payloads / sizeof *payloads };
    uint32_t type = below(m, TYPES);
    *chunk = NULL;
    for (uint32_t k = 0; k < TYPES && !*chunk; k++) {
        type = (type + 1) % TYPES;
        *chunk = fuzz_find(&m->file, payloads[type].type);
    }
    if (!*chunk)
        return false;
    *at = fuzz_planes_at(*chunk);
    for (uint32_t skip = below(m, payloads[type].planes); fuzz_next_plane(*chunk, at, stored); skip--) {
        if (skip == 0)
            return true;
        *at += PLANE_HEADER_SIZE + *stored;
    }
    return false;
}

static void edit_plane_header(mutation *m) {
    static const field fields[] = {{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 1}, {5, 1}, {8, 8}, {16, 4}, {20, 4}};
    fuzz_chunk *chunk;
    size_t at, stored;
    if (!pick_plane(m, &chunk, &at, &stored))
        return;
    const field *f = &fields[below(m, sizeof fields / sizeof *fields)];
    uint8_t *p = chunk->body + at + f->at;
    fuzz_store(p, value_for(m, p, f->size), f->size);
}

/* One element: the plane becomes raw elements. */
static void edit_plane_element(mutation *m) {
    fuzz_chunk *chunk;
    size_t at, stored;
    if (!pick_plane(m, &chunk, &at, &stored))
        return;
    uint8_t *header = chunk->body + at;
    size_t size = fuzz_decode_plane(header, stored, bytes), edge = header[0];
    size_t whole = chunk->size - stored + size;
    if (size == 0 || whole > m->file.capacity)
        return;
    uint8_t *element = bytes + below(m, size / edge) * edge;
    fuzz_store(element, value_for(m, element, edge), edge);
    memmove(header + PLANE_HEADER_SIZE + size, header + PLANE_HEADER_SIZE + stored,
            chunk->size - at - PLANE_HEADER_SIZE - stored);
    memcpy(header + PLANE_HEADER_SIZE, bytes, size);
    memset(header + 1, 0, 15);
    fuzz_store(header + 20, size, 4);
    chunk->size = whole;
}

/* ---- records of images and textures ---- */

static void edit_image(mutation *m) {
    static const field fields[] = {{0, 4},  {4, 4},  {8, 4},  {12, 4}, {16, 4}, {20, 1}, {21, 1}, {22, 1}, {23, 1},
                                   {24, 1}, {25, 1}, {26, 1}, {27, 1}, {28, 1}, {29, 1}, {30, 1}, {31, 1}};
    fuzz_chunk *imag = fuzz_find(&m->file, "IMAG");
    if (!imag || imag->size < 16 + IMAGE_RECORD_SIZE)
        return;
    if (imag->entry[ENTRY_CODEC] == 1)
        fuzz_recode(&m->file, imag);
    size_t room = (imag->size - 16) / IMAGE_RECORD_SIZE, images = fuzz_load32(imag->body);
    const field *f = &fields[below(m, sizeof fields / sizeof *fields)];
    uint8_t *p = imag->body + 16 + below(m, images < room ? images : room) * (size_t)IMAGE_RECORD_SIZE + f->at;
    fuzz_store(p, value_for(m, p, f->size), f->size);
}

static void edit_texture(mutation *m) {
    static const field entry[] = {{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 4}, {8, 4}, {12, 4}};
    static const field layer[] = {{0, 2}, {2, 2}, {4, 4}, {4, 4}};
    fuzz_chunk *texs = fuzz_find(&m->file, "TEXS");
    if (texs && texs->entry[ENTRY_CODEC] == 1)
        fuzz_recode(&m->file, texs);
    if (!texs || texs->size < 16)
        return;
    uint64_t textures = fuzz_load32(texs->body), layers = fuzz_load32(texs->body + 4);
    if (textures == 0 || layers == 0 || 16 + 16 * textures + 8 * layers > texs->size)
        return;
    bool in_layer = below(m, 2);
    const field *f = in_layer ? &layer[below(m, sizeof layer / sizeof *layer)]
                              : &entry[below(m, sizeof entry / sizeof *entry)];
    size_t at = in_layer ? 16 + 16 * (size_t)textures + 8 * (size_t)below(m, layers)
                         : 16 + 16 * (size_t)below(m, textures);
    uint8_t *p = texs->body + at + f->at;
    fuzz_store(p, value_for(m, p, f->size), f->size);
}

/* ---- all of it ---- */

typedef void change(mutation *m);

static change *const frame_changes[] = {edit_preamble, edit_entry,      edit_head,  edit_anywhere,
                                        drop_chunk,    duplicate_chunk, swap_chunks};

static change *const content_changes[] = {
    edit_payload_field, edit_payload_field, edit_payload_field, edit_payload_bytes, resize_payload,
    splice_payload,     recode_chunk,       edit_tile_record,   edit_tile_bytes,    edit_tile_bytes,
    recode_tile,        recode_tile,        edit_plane_header,  edit_plane_element, edit_plane_element,
    edit_plane_element, edit_texture,       edit_texture,       edit_image,         edit_image};

/* The frame is small and tested exhaustively elsewhere: most changes are to what it holds. */
static void change_something(mutation *m) {
    if (below(m, 12) == 0)
        frame_changes[below(m, sizeof frame_changes / sizeof *frame_changes)](m);
    else
        content_changes[below(m, sizeof content_changes / sizeof *content_changes)](m);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    mutation m;
    m.random.state = ((uint64_t)seed << 1 | 1) * UINT64_C(0x9E3779B97F4A7C15);
    if (below(&m, 16) == 0 || !fuzz_parse(&m.file, data, size, max_size))
        return LLVMFuzzerMutate(data, size, max_size);
    for (uint32_t n = below(&m, 4) ? 1 : 1 + below(&m, 4); n > 0; n--)
        change_something(&m);
    unsigned skip = below(&m, 16) == 0 ? 1u << below(&m, SEAL_STEPS) : 0;
    size_t sealed = fuzz_seal(&m.file, skip, data, max_size);
    fuzz_release(&m.file);
    return sealed > 0 ? sealed : LLVMFuzzerMutate(data, size, max_size);
}

/* Chunks of the second file in the places of those of the first, or beside them. */
size_t LLVMFuzzerCustomCrossOver(const uint8_t *data1, size_t size1, const uint8_t *data2, size_t size2, uint8_t *out,
                                 size_t max_size, unsigned seed) {
    mutation m;
    fuzz_file other;
    m.random.state = ((uint64_t)seed << 1 | 1) * UINT64_C(0x9E3779B97F4A7C15);
    if (!fuzz_parse(&m.file, data1, size1, max_size))
        return 0;
    if (!fuzz_parse(&other, data2, size2, max_size)) {
        fuzz_release(&m.file);
        return 0;
    }
    for (uint32_t i = 0; i < m.file.count; i++) {
        const fuzz_chunk *from = &other.chunks[below(&m, other.count)];
        fuzz_chunk *to = &m.file.chunks[i];
        if (memcmp(from->entry, to->entry, 4) != 0 || from->size > m.file.capacity || below(&m, 2))
            continue;
        memcpy(to->entry, from->entry, ENTRY_SIZE);
        memcpy(to->body, from->body, from->size);
        to->size = from->size;
    }
    if (below(&m, 4) == 0)
        insert_chunk(&m, below(&m, m.file.count + 1), &other.chunks[below(&m, other.count)]);
    size_t sealed = fuzz_seal(&m.file, 0, out, max_size);
    fuzz_release(&m.file);
    fuzz_release(&other);
    return sealed;
}
