/* SPDX-License-Identifier: Apache-2.0 */
/* Laying out a file: everything is known by now, so it is written once, from front to back. */

#include "base_hash.h"
#include "file_check.h"
#include "file_write.h"

enum {
    PIECE = 1 << 20,
    RANKS = 24,               /* of units: zt__unit_rank */
    MOST_COMPRESSED = 1 << 30 /* R3003 */
};

static const uint8_t zeros[16];

/* What is laid out. */
typedef struct layout {
    zt_writer *writer;
    zt__write_chunk *chunks; /* the last is TEXL, whose bytes are in the spool */
    uint32_t chunk_count, chunk_capacity;
    uint8_t *piece;
    uint64_t texels; /* bytes of TEXL */
    uint64_t done;   /* bytes of TEXL gone by, in both passes */
    zt_diag *diag;
} layout;

/* ---- chunks in memory --------------------------------------------------------------------------------- */

static zt_result compress_chunk(zt_writer *w, const void *data, size_t size, zt_diag *diag, zt__write_chunk *chunk) {
    void *block;
    uint64_t bound = zt__encode_bound(size);
    size_t frame = 0;
    ZT_TRY(zt__alloc_raw(&w->memory, bound, 1, diag, &block));
    zt_result r = zt__encode_frame(&w->encoders[0], data, size, block, (size_t)bound, &frame, diag);
    if (r != ZT_OK || frame == 0) {
        zt__free(&w->memory, block, bound, 1);
        return r;
    }
    chunk->bytes = block;
    chunk->capacity = bound;
    chunk->entry.codec = ZT__CODEC_ZSTD;
    chunk->entry.stored_size = frame;
    return ZT_OK;
}

zt_result zt__write_chunk_of(zt_writer *w, uint32_t type, uint16_t version, uint8_t flags, const void *data,
                             size_t size, zt_diag *diag, zt__write_chunk *out) {
    const zt__chunk_type *known = zt__find_chunk_type(type);
    zt__write_chunk empty = {0};
    void *block;
    *out = empty;
    out->entry.type = type;
    out->entry.version = version;
    out->entry.flags = flags;
    out->entry.decoded_size = size;
    out->entry.decoded_hash = zt__hash(data, size);
    if ((!known || known->compressible) && size <= MOST_COMPRESSED)
        ZT_TRY(compress_chunk(w, data, size, diag, out));
    if (!out->bytes) {
        ZT_TRY(zt__alloc_raw(&w->memory, size, 1, diag, &block));
        memcpy(block, data, size);
        out->bytes = block;
        out->capacity = size;
        out->entry.stored_size = size;
    }
    out->entry.stored_hash = zt__hash(out->bytes, (size_t)out->entry.stored_size);
    return ZT_OK;
}

/* Makes a chunk of a block of bytes, and frees the block. */
static zt_result append_block(layout *l, uint32_t type, uint8_t *bytes, uint64_t capacity, size_t size) {
    zt_writer *w = l->writer;
    const zt__chunk_type *known = zt__find_chunk_type(type);
    void *array = l->chunks;
    zt__write_chunk chunk = {0};
    zt_result r = zt__write_chunk_of(w, type, known->version, known->flags, bytes, size, l->diag, &chunk);
    zt__free(&w->memory, bytes, capacity, 1);
    if (r == ZT_OK)
        r = zt__grow(&w->memory, &array, &l->chunk_capacity, l->chunk_count, sizeof chunk, l->diag);
    if (r != ZT_OK) {
        zt__write_chunk_free(w, &chunk);
        return r;
    }
    l->chunks = array;
    l->chunks[l->chunk_count++] = chunk;
    return ZT_OK;
}

static zt_result alloc_bytes(layout *l, uint64_t size, uint8_t **out) {
    void *block;
    *out = NULL;
    ZT_TRY(zt__alloc(&l->writer->memory, size, 1, l->diag, &block));
    *out = block;
    return ZT_OK;
}

/* ---- TEXS ------------------------------------------------------------------------------------------------ */

static zt_result add_texs(layout *l) {
    zt_writer *w = l->writer;
    uint64_t layers = 0, names = 0;
    uint8_t *bytes;
    for (uint32_t i = 0; i < w->texture_count; i++) {
        layers += w->textures[i].entry.layer_count;
        names += w->textures[i].entry.name_size;
    }
    uint64_t size = 16 + ZT__TEXTURE_ENTRY_SIZE * (uint64_t)w->texture_count + ZT__LAYER_ENTRY_SIZE * layers + names;
    ZT_TRY(alloc_bytes(l, size, &bytes));
    zt__coder c = zt__writing(bytes);
    uint32_t header[4] = {w->texture_count, (uint32_t)layers, (uint32_t)names, 0};
    for (int i = 0; i < 4; i++)
        zt__code_u32(&c, &header[i]);
    for (uint32_t i = 0; i < w->texture_count; i++)
        zt__code_texture(&c, &w->textures[i].entry);
    for (uint32_t i = 0; i < w->texture_count; i++)
        for (uint32_t k = 0; k < w->textures[i].entry.layer_count; k++)
            zt__code_layer(&c, &w->textures[i].layers[k]);
    for (uint32_t i = 0; i < w->texture_count; i++) {
        memcpy(c.out, w->textures[i].name, w->textures[i].entry.name_size);
        c.out += w->textures[i].entry.name_size;
    }
    return append_block(l, ZT__TEXS, bytes, size, (size_t)size);
}

/* ---- IMAG ------------------------------------------------------------------------------------------------- */

static void code_index(const zt__write_unit *u, uint64_t from, uint64_t count, uint8_t *out) {
    zt__coder c = zt__writing(out);
    for (uint64_t i = from; i < from + count; i++) {
        zt__tile_record record = u->records[i];
        zt__code_tile(&c, &record);
    }
}

/* Size and hash of a unit. */
static void measure_unit(const layout *l, zt__write_unit *u) {
    zt__hasher hasher;
    const uint64_t most = PIECE / ZT__TILE_RECORD_SIZE;
    zt__hash_begin(&hasher);
    u->record.size = 0;
    for (uint64_t from = 0; from < u->tile_count; from += most) {
        uint64_t n = u->tile_count - from < most ? u->tile_count - from : most;
        code_index(u, from, n, l->piece);
        zt__hash_more(&hasher, l->piece, (size_t)n * ZT__TILE_RECORD_SIZE);
        for (uint64_t i = from; i < from + n; i++)
            u->record.size += ZT__TILE_RECORD_SIZE + u->records[i].stored_size;
    }
    u->record.index_hash = zt__hash_end(&hasher);
}

typedef zt_result visit_unit(void *user, zt__write_unit *u);

static zt_result visit_rank(const zt_writer *w, uint32_t rank, visit_unit *visit, void *user) {
    for (uint32_t i = 0; i < w->image_count; i++) {
        zt__write_image *image = w->images[i];
        for (uint32_t k = 0; k < image->unit_count; k++) {
            if (zt__unit_rank(&image->record, k, image->tail_level) == rank)
                ZT_TRY(visit(user, &image->units[k]));
        }
    }
    return ZT_OK;
}

/* All units in the order of TEXL. */
static zt_result visit_units(const zt_writer *w, visit_unit *visit, void *user) {
    for (uint32_t rank = 0; rank < RANKS; rank++)
        ZT_TRY(visit_rank(w, rank, visit, user));
    return ZT_OK;
}

static zt_result place_unit(void *user, zt__write_unit *u) {
    layout *l = user;
    measure_unit(l, u);
    u->record.offset = l->texels;
    l->texels += u->record.size;
    return ZT_OK;
}

static zt_result add_imag(layout *l) {
    zt_writer *w = l->writer;
    uint64_t units = 0, zero = 0;
    uint8_t *bytes;
    for (uint32_t i = 0; i < w->image_count; i++)
        units += w->images[i]->unit_count;
    ZT_TRY(visit_units(w, place_unit, l));
    uint64_t size = 16 + ZT__IMAGE_RECORD_SIZE * (uint64_t)w->image_count + ZT__UNIT_RECORD_SIZE * units;
    ZT_TRY(alloc_bytes(l, size, &bytes));
    zt__coder c = zt__writing(bytes);
    uint32_t unit_total = (uint32_t)units;
    zt__code_u32(&c, &w->image_count);
    zt__code_u32(&c, &unit_total);
    zt__code_u64(&c, &zero);
    for (uint32_t i = 0; i < w->image_count; i++)
        zt__code_image(&c, &w->images[i]->record);
    for (uint32_t i = 0; i < w->image_count; i++)
        for (uint32_t k = 0; k < w->images[i]->unit_count; k++)
            zt__code_unit(&c, &w->images[i]->units[k].record);
    return append_block(l, ZT__IMAG, bytes, size, (size_t)size);
}

/* ---- payloads, META, others -------------------------------------------------------------------------------------- */

static zt_result add_payloads_of(layout *l, const zt__chunk_type *type) {
    zt_writer *w = l->writer;
    for (uint32_t i = 0; i < w->texture_count; i++) {
        const zt__write_texture *t = &w->textures[i];
        uint8_t *bytes;
        uint64_t capacity;
        size_t size;
        if (t->entry.kind != type->kind)
            continue;
        ZT_TRY(w->hooks->encode(&w->encoders[0], type->kind, t->payload, l->diag, &bytes, &capacity, &size));
        ZT_TRY(append_block(l, type->type, bytes, capacity, size));
    }
    return ZT_OK;
}

/* The table of chunk types has them in the order of the file. */
static zt_result add_payloads(layout *l) {
    for (uint32_t i = 0; zt__get_chunk_type(i); i++) {
        if (zt__get_chunk_type(i)->kind != ZT_KIND_IMAGE)
            ZT_TRY(add_payloads_of(l, zt__get_chunk_type(i)));
    }
    return ZT_OK;
}

static zt_result add_meta(layout *l) {
    zt_writer *w = l->writer;
    uint64_t size = 8;
    uint8_t *bytes;
    if (w->pair_count == 0)
        return ZT_OK;
    for (uint32_t i = 0; i < w->pair_count; i++)
        size += 8 + strlen(w->pairs[i].key) + strlen(w->pairs[i].value);
    ZT_TRY(alloc_bytes(l, size, &bytes));
    zt__coder c = zt__writing(bytes);
    uint32_t zero = 0;
    zt__code_u32(&c, &w->pair_count);
    zt__code_u32(&c, &zero);
    for (uint32_t i = 0; i < w->pair_count; i++) {
        uint32_t key = (uint32_t)strlen(w->pairs[i].key);
        uint32_t value = (uint32_t)strlen(w->pairs[i].value);
        zt__code_u32(&c, &key);
        zt__code_u32(&c, &value);
    }
    for (uint32_t i = 0; i < w->pair_count; i++) {
        size_t key = strlen(w->pairs[i].key), value = strlen(w->pairs[i].value);
        memcpy(c.out, w->pairs[i].key, key);
        memcpy(c.out + key, w->pairs[i].value, value);
        c.out += key + value;
    }
    return append_block(l, ZT__META, bytes, size, (size_t)size);
}

static bool type_below(const zt__write_chunk *a, const zt__write_chunk *b) {
    uint8_t x[4], y[4];
    zt__store32(x, a->entry.type);
    zt__store32(y, b->entry.type);
    return memcmp(x, y, 4) < 0;
}

/* Moves the chunks of unknown types over, by type. There are few. */
static zt_result add_unknown(layout *l) {
    zt_writer *w = l->writer;
    while (w->chunk_count > 0) {
        uint32_t least = 0;
        void *array = l->chunks;
        for (uint32_t i = 1; i < w->chunk_count; i++)
            least = type_below(&w->chunks[i], &w->chunks[least]) ? i : least;
        ZT_TRY(zt__grow(&w->memory, &array, &l->chunk_capacity, l->chunk_count, sizeof *l->chunks, l->diag));
        l->chunks = array;
        l->chunks[l->chunk_count++] = w->chunks[least];
        w->chunks[least] = w->chunks[--w->chunk_count];
    }
    return ZT_OK;
}

/* ---- TEXL ---------------------------------------------------------------------------------------------------------
 */

typedef zt_result take_bytes(void *user, const void *data, size_t size, zt_diag *diag);

typedef struct texel_pass {
    layout *l;
    take_bytes *take;
    void *user;
} texel_pass;

static zt_result pass_on(const texel_pass *p, size_t size) {
    layout *l = p->l;
    const zt_writer_options *o = &l->writer->options;
    ZT_TRY(p->take(p->user, l->piece, size, l->diag));
    l->done += size;
    double share = (double)l->done / (2.0 * (double)l->texels);
    if (o->progress && o->progress(o->user, share < 1.0 ? share : 1.0) != 0)
        return zt__fail(l->diag, ZT_CANCELLED, 0, ZT__NO_OFFSET, "the progress callback said stop");
    return ZT_OK;
}

static zt_result pass_index(const texel_pass *p, const zt__write_unit *u) {
    const uint64_t most = PIECE / ZT__TILE_RECORD_SIZE;
    for (uint64_t from = 0; from < u->tile_count; from += most) {
        uint64_t n = u->tile_count - from < most ? u->tile_count - from : most;
        code_index(u, from, n, p->l->piece);
        ZT_TRY(pass_on(p, (size_t)n * ZT__TILE_RECORD_SIZE));
    }
    return ZT_OK;
}

static zt_result pass_run(const texel_pass *p, uint64_t place, uint64_t size) {
    while (size > 0) {
        size_t n = size < PIECE ? (size_t)size : PIECE;
        ZT_TRY(zt__spool_read(&p->l->writer->spool, place, p->l->piece, n, p->l->diag));
        ZT_TRY(pass_on(p, n));
        place += n;
        size -= n;
    }
    return ZT_OK;
}

/* Tiles that follow each other in the spool are read together. */
static zt_result pass_tiles(const texel_pass *p, const zt__write_unit *u) {
    uint64_t place = u->places[0], size = 0;
    for (uint64_t i = 0; i < u->tile_count; i++) {
        if (u->places[i] != place + size) {
            ZT_TRY(pass_run(p, place, size));
            place = u->places[i];
            size = 0;
        }
        size += u->records[i].stored_size;
    }
    return pass_run(p, place, size);
}

static zt_result pass_unit(void *user, zt__write_unit *u) {
    const texel_pass *p = user;
    ZT_TRY(pass_index(p, u));
    return pass_tiles(p, u);
}

/* The bytes of TEXL in their order. */
static zt_result pass_texels(texel_pass *p) {
    return visit_units(p->l->writer, pass_unit, p);
}

static zt_result take_hash(void *user, const void *data, size_t size, zt_diag *diag) {
    (void)diag;
    zt__hash_more(user, data, size);
    return ZT_OK;
}

static zt_result add_texl(layout *l) {
    void *array = l->chunks;
    zt__hasher hasher;
    zt__hash_begin(&hasher);
    texel_pass pass = {l, take_hash, &hasher};
    ZT_TRY(pass_texels(&pass));
    zt__write_chunk chunk = {0};
    ZT_TRY(zt__grow(&l->writer->memory, &array, &l->chunk_capacity, l->chunk_count, sizeof chunk, l->diag));
    l->chunks = array;
    const zt__chunk_type *known = zt__find_chunk_type(ZT__TEXL);
    chunk.entry.type = ZT__TEXL;
    chunk.entry.version = known->version;
    chunk.entry.flags = known->flags;
    chunk.entry.stored_size = l->texels;
    chunk.entry.decoded_size = l->texels;
    chunk.entry.stored_hash = zt__hash_end(&hasher);
    chunk.entry.decoded_hash = chunk.entry.stored_hash;
    l->chunks[l->chunk_count++] = chunk;
    return ZT_OK;
}

/* ---- the front ------------------------------------------------------------------------------------------------------
 */

/* What a reader would refuse in a directory is refused here. */
static zt_result check_front(layout *l, const zt__preamble *p, const zt__entry *entries) {
    zt__sink sink = zt__write_sink(l->diag);
    uint64_t offset = zt__align16(ZT__PREAMBLE_SIZE + (uint64_t)p->directory_size);
    ZT_TRY(zt__check_preamble(&sink, &l->writer->limits, p));
    for (uint32_t i = 0; i < l->chunk_count; i++) {
        ZT_TRY(zt__check_entry(&sink, &entries[i], i, offset));
        offset = zt__align16(offset + ZT__HEAD_SIZE + entries[i].stored_size);
    }
    return zt__check_directory(&sink, entries, l->chunk_count);
}

static zt_result code_front(layout *l, uint8_t *bytes, uint64_t size, zt__entry *entries) {
    zt__preamble p = {.major = 1, .chunk_count = l->chunk_count};
    uint64_t offset = size;
    memcpy(p.magic, zt__magic, sizeof p.magic);
    p.directory_size = l->chunk_count * ZT__ENTRY_SIZE;
    for (uint32_t i = 0; i < l->chunk_count; i++) {
        l->chunks[i].entry.offset = offset;
        entries[i] = l->chunks[i].entry;
        offset = zt__align16(offset + ZT__HEAD_SIZE + entries[i].stored_size);
    }
    p.file_size = offset;
    ZT_TRY(zt__write_verdict(l->diag, check_front(l, &p, entries)));
    zt__coder c = zt__writing(bytes + ZT__PREAMBLE_SIZE);
    for (uint32_t i = 0; i < l->chunk_count; i++)
        zt__code_entry(&c, &entries[i]);
    c = zt__writing(bytes);
    zt__code_preamble(&c, &p);
    zt__hasher hasher;
    zt__hash_begin(&hasher);
    zt__hash_more(&hasher, bytes, 56);
    zt__hash_more(&hasher, bytes + ZT__PREAMBLE_SIZE, p.directory_size);
    p.directory_hash = zt__hash_end(&hasher);
    c = zt__writing(bytes);
    zt__code_preamble(&c, &p);
    return ZT_OK;
}

static zt_result put_front(layout *l, zt__output *out) {
    void *entries;
    uint8_t *bytes;
    uint64_t count = l->chunk_count;
    uint64_t size = zt__align16(ZT__PREAMBLE_SIZE + count * ZT__ENTRY_SIZE);
    ZT_TRY(alloc_bytes(l, size, &bytes));
    zt_result r = zt__alloc(&l->writer->memory, count, sizeof(zt__entry), l->diag, &entries);
    if (r == ZT_OK)
        r = code_front(l, bytes, size, entries);
    if (r == ZT_OK)
        r = zt__output_put(out, bytes, (size_t)size, l->diag);
    zt__free(&l->writer->memory, entries, count, sizeof(zt__entry));
    zt__free(&l->writer->memory, bytes, size, 1);
    return r;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static zt_result take_output(void *user, const void *data, size_t size, zt_diag *diag) {
    return zt__output_put(user, data, size, diag);
}

static zt_result put_chunk(layout *l, zt__output *out, uint32_t index) {
    const zt__write_chunk *chunk = &l->chunks[index];
    zt__head head = {.index = index, .entry = chunk->entry};
    uint8_t bytes[ZT__HEAD_SIZE];
    memcpy(head.magic, zt__head_magic, sizeof head.magic);
    zt__coder c = zt__writing(bytes);
    zt__code_head(&c, &head);
    ZT_TRY(zt__output_put(out, bytes, sizeof bytes, l->diag));
    uint64_t size = chunk->entry.stored_size;
    if (chunk->bytes) {
        ZT_TRY(zt__output_put(out, chunk->bytes, (size_t)size, l->diag));
    } else {
        texel_pass pass = {l, take_output, out};
        ZT_TRY(pass_texels(&pass));
    }
    return zt__output_put(out, zeros, (size_t)(zt__align16(size) - size), l->diag);
}

static zt_result put_file(layout *l) {
    zt_writer *w = l->writer;
    zt__output out;
    bool wait = !(w->options.flags & ZT_WRITE_NO_FSYNC);
    zt_result r = zt__output_open(&out, &w->memory, w->to_sink ? &w->sink : NULL, w->path, w->folder, wait, l->diag);
    if (r == ZT_OK)
        r = put_front(l, &out);
    for (uint32_t i = 0; r == ZT_OK && i < l->chunk_count; i++)
        r = put_chunk(l, &out, i);
    if (r == ZT_OK)
        r = zt__output_finish(&out, l->diag);
    zt__output_close(&out);
    return r;
}

static zt_result make_chunks(layout *l) {
    ZT_TRY(add_texs(l));
    ZT_TRY(add_imag(l));
    ZT_TRY(add_payloads(l));
    ZT_TRY(add_meta(l));
    ZT_TRY(add_unknown(l));
    return add_texl(l);
}

static zt_result check_full(const zt_writer *w, zt_diag *diag) {
    if (w->image_count == 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 6001, ZT__NO_OFFSET, "the file has no image");
    if (w->texture_count == 0)
        return zt__fail(diag, ZT_BAD_ARGUMENT, 6102, ZT__NO_OFFSET, "the file has no texture");
    for (uint32_t i = 0; i < w->image_count; i++) {
        for (uint32_t k = 0; k < w->images[i]->unit_count; k++) {
            const zt__write_unit *u = &w->images[i]->units[k];
            if (u->tiles_done != u->tile_count)
                return zt__fail(diag, ZT_BAD_ARGUMENT, 0, ZT__NO_OFFSET,
                                "image %u is not full: unit %u has %llu tiles of %llu", (unsigned)i, (unsigned)k,
                                (unsigned long long)u->tiles_done, (unsigned long long)u->tile_count);
        }
    }
    return ZT_OK;
}

zt_result zt__write_file(zt_writer *w, zt_diag *diag) {
    layout l = {.writer = w, .diag = diag};
    ZT_TRY(check_full(w, diag));
    ZT_TRY(alloc_bytes(&l, PIECE, &l.piece));
    zt_result r = make_chunks(&l);
    if (r == ZT_OK)
        r = put_file(&l);
    for (uint32_t i = 0; i < l.chunk_count; i++)
        zt__write_chunk_free(w, &l.chunks[i]);
    zt__free(&w->memory, l.chunks, l.chunk_capacity, sizeof *l.chunks);
    zt__free(&w->memory, l.piece, PIECE, 1);
    return r;
}
