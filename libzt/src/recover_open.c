/* SPDX-License-Identifier: Apache-2.0 */
/* The file that is laid out anew from what was found, and its opening. */
#include "base_hash.h"
#include "recover.h"

/* One texture that shows image 0: what TEXS must at least be. */
static const uint8_t lone_texs[40] = {[0] = 1, [4] = 1, [20] = 1};

/* ---- the io ---- */

static zt_result read_piece(const zt__recovery *r, const zt__piece *piece, uint64_t from, uint8_t *dst, size_t size) {
    if (piece->memory) {
        memcpy(dst, piece->memory + from, size);
        return ZT_OK;
    }
    uint64_t at;
    size_t here = 0;
    if (zt__add64(piece->source, from, &at) && at < r->damaged->size)
        here = r->damaged->size - at < size ? (size_t)(r->damaged->size - at) : size;
    memset(dst + here, 0, size - here);
    return here ? r->damaged->read_at(r->damaged->user, at, dst, here) : ZT_OK;
}

/* The last piece that begins at or before offset. */
static uint32_t find_piece(const zt__recovery *r, uint64_t offset) {
    uint32_t low = 0, high = r->piece_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (r->pieces[middle].at <= offset)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static zt_result read_laid_out(void *user, uint64_t offset, void *dst, size_t size) {
    const zt__recovery *r = user;
    uint8_t *out = dst;
    for (uint32_t i = find_piece(r, offset); size > 0; i++) {
        const zt__piece *piece = &r->pieces[i];
        uint64_t from = offset - piece->at, left = piece->size - from;
        size_t part = left < size ? (size_t)left : size;
        ZT_TRY(read_piece(r, piece, from, out, part));
        out += part;
        offset += part;
        size -= part;
    }
    return ZT_OK;
}

/* ---- laying out ---- */

/* A chunk as it goes into the laid-out file. */
typedef struct choice {
    zt__entry entry;
    uint64_t source;
    const uint8_t *memory;
} choice;

/* A damaged payload keeps its place where the directory knows it, so that those behind it stay with their textures. */
static bool wanted(const zt__recovery *r, uint32_t i, const zt__found *last, bool lone_texture) {
    const zt__found *f = &r->found[i];
    uint32_t type = f->entry.type;
    const zt__chunk_type *known = zt__find_chunk_type(type);
    if (type == ZT__TEXL)
        return false;
    if (known && known->repeats)
        return f->sane && !lone_texture;
    if (!f->intact || (type == ZT__TEXS && lone_texture))
        return false;
    return !last || last->entry.type != type;
}

static zt__entry made_entry(uint32_t type, uint64_t size, uint64_t hash) {
    zt__entry e = {.type = type,
                   .version = 1,
                   .flags = ZT__FLAG_CRITICAL,
                   .codec = ZT__CODEC_RAW,
                   .stored_size = size,
                   .decoded_size = size,
                   .stored_hash = hash,
                   .decoded_hash = hash};
    return e;
}

static uint32_t choose(const zt__recovery *r, bool lone_texture, choice *choices) {
    uint32_t count = 0;
    const zt__found *last = NULL;
    if (lone_texture) {
        choices[count++] = (choice){made_entry(ZT__TEXS, sizeof lone_texs, zt__hash(lone_texs, sizeof lone_texs)), 0,
                                    lone_texs};
    }
    for (uint32_t i = 0; i < r->found_count; i++) {
        if (!wanted(r, i, last, lone_texture))
            continue;
        last = &r->found[i];
        choices[count++] = (choice){last->entry, last->entry.offset + ZT__HEAD_SIZE, NULL};
    }
    /* Where the texels are is found out later; nobody asks for their hash. */
    choices[count++] = (choice){made_entry(ZT__TEXL, r->texels_size, 0), r->damaged->size, NULL};
    return count;
}

static void add_piece(zt__recovery *r, const uint8_t *memory, uint64_t source, uint64_t size) {
    if (size == 0)
        return;
    r->pieces[r->piece_count++] = (zt__piece){r->laid_out_size, size, memory, source};
    r->laid_out_size += size;
}

/* Heads and padding are ours, and right. */
static void lay_chunk(zt__recovery *r, const choice *c, uint32_t index) {
    static const uint8_t zeros[16] = {0};
    uint8_t *at = r->scaffold + ZT__PREAMBLE_SIZE + (uint64_t)index * ZT__HEAD_SIZE;
    zt__head head = {.index = index, .entry = c->entry};
    zt__coder coder = zt__writing(at);
    memcpy(head.magic, zt__head_magic, sizeof head.magic);
    zt__code_head(&coder, &head);
    add_piece(r, at, 0, ZT__HEAD_SIZE);
    r->texels_piece = r->piece_count;
    add_piece(r, c->memory, c->source, c->entry.stored_size);
    add_piece(r, zeros, 0, zt__align16(c->entry.stored_size) - c->entry.stored_size);
}

/* The scaffold: preamble, the heads, then the directory with its padding, each where a piece points. */
static void lay_out(zt__recovery *r, choice *choices, uint32_t count) {
    uint64_t directory_size = (uint64_t)count * ZT__ENTRY_SIZE;
    uint8_t *directory = r->scaffold + ZT__PREAMBLE_SIZE + (uint64_t)count * ZT__HEAD_SIZE;
    zt__preamble p = {.major = 1, .directory_size = (uint32_t)directory_size, .chunk_count = count};
    uint64_t at = zt__align16(ZT__PREAMBLE_SIZE + directory_size);
    zt__coder coder = zt__writing(directory);
    for (uint32_t i = 0; i < count; i++) {
        choices[i].entry.offset = at;
        zt__code_entry(&coder, &choices[i].entry);
        at += ZT__HEAD_SIZE + zt__align16(choices[i].entry.stored_size);
    }
    memcpy(p.magic, zt__magic, sizeof p.magic);
    p.file_size = at;
    coder = zt__writing(r->scaffold);
    zt__code_preamble(&coder, &p);
    zt__hasher hasher;
    zt__hash_begin(&hasher);
    zt__hash_more(&hasher, r->scaffold, ZT__PREAMBLE_SIZE - sizeof p.directory_hash);
    zt__hash_more(&hasher, directory, (size_t)directory_size);
    p.directory_hash = zt__hash_end(&hasher);
    coder = zt__writing(r->scaffold);
    zt__code_preamble(&coder, &p);

    add_piece(r, r->scaffold, 0, ZT__PREAMBLE_SIZE);
    add_piece(r, directory, 0, zt__align16(directory_size));
    for (uint32_t i = 0; i < count; i++)
        lay_chunk(r, &choices[i], i);
}

static zt_result build(zt__recovery *r, bool lone_texture) {
    void *block;
    uint64_t most = (uint64_t)r->found_count + 2;
    ZT_TRY(zt__alloc(&r->memory, most, sizeof(choice), r->diag, &block));
    choice *choices = block;
    uint32_t count = choose(r, lone_texture, choices);
    r->scaffold_size = ZT__PREAMBLE_SIZE + (uint64_t)count * ZT__HEAD_SIZE +
                       zt__align16((uint64_t)count * ZT__ENTRY_SIZE);
    zt_result result = zt__alloc(&r->memory, r->scaffold_size, 1, r->diag, &block);
    r->scaffold = block;
    if (result == ZT_OK)
        result = zt__alloc(&r->memory, 2 + 3 * (uint64_t)r->found_count + 6, sizeof *r->pieces, r->diag, &block);
    if (result == ZT_OK) {
        r->pieces = block;
        lay_out(r, choices, count);
    }
    zt__free(&r->memory, choices, most, sizeof(choice));
    return result;
}

/* ---- opening ---- */

/* A payload counts when all of it is right, even where a validator would go on. */
static zt_result open_strictly(zt_file *file, zt__sink *sink, zt__decoder *decoder, uint32_t texture,
                               const uint8_t *data, size_t size, uint64_t offset) {
    zt_diag diag;
    zt__sink quiet = {.diag = &diag};
    zt__begin(&diag);
    zt_result result = zt__texture_hooks.open(file, &quiet, decoder, texture, data, size, offset);
    if (result == ZT_NO_MEMORY)
        return zt__fail(sink->diag, result, 0, ZT__NO_OFFSET, "%s", diag.text);
    return result == ZT_UNSUPPORTED ? ZT_CORRUPT : result;
}

typedef struct verdict {
    bool images_bad, textures_bad;
    zt_diag first;
} verdict;

static int take_finding(void *user, const zt_finding *finding) {
    verdict *v = user;
    if (finding->severity != ZT_SEVERITY_WARNING)
        zt__fail(&v->first, ZT_CORRUPT, finding->rule, ZT__NO_OFFSET, "%s", finding->text); /* the first one stays */
    /* Findings in payloads ("ZPMP/texture 3") leave the list of textures as it is. */
    if (finding->severity != ZT_SEVERITY_WARNING && strncmp(finding->path, "TEXS", 4) == 0)
        v->textures_bad = true;
    if (finding->severity != ZT_SEVERITY_WARNING && strncmp(finding->path, "IMAG", 4) == 0)
        v->images_bad = true;
    return 0;
}

void zt__recover_close(zt__recovery *r) {
    zt__file_free(r->file, &zt__texture_hooks);
    zt__free(&r->memory, r->pieces, 2 + 3 * (uint64_t)r->found_count + 6, sizeof *r->pieces);
    zt__free(&r->memory, r->scaffold, r->scaffold_size, 1);
    r->file = NULL;
    r->pieces = NULL;
    r->scaffold = NULL;
    r->piece_count = 0;
    r->laid_out_size = 0;
}

zt_result zt__recover_open(zt__recovery *r, bool lone_texture, bool *usable, bool *textures_ok) {
    zt_open_options options = {.limits = &r->limits, .allocator = &r->memory.allocator};
    zt__payload_hooks hooks = {open_strictly, zt__texture_hooks.close};
    zt_check_summary summary = {0};
    verdict v = {0};
    zt_check_options check = {.user = &v, .finding = take_finding};
    zt_diag diag;
    zt__begin(&diag);
    ZT_TRY(build(r, lone_texture));
    const zt_io io = {r, read_laid_out, r->laid_out_size};
    const zt__source source = {.kind = ZT__FROM_IO, .io = &io};
    ZT_TRY(zt__file_new(&options, &source, r->diag, &r->file));
    zt__sink sink = {.diag = &diag, .check = &check, .summary = &summary};
    zt_result result = zt__walk(r->file, &sink, &hooks, usable);
    *usable = *usable && !v.images_bad; /* a writer would refuse them */
    *textures_ok = *usable && !v.textures_bad && r->file->textures;
    bool broken = result == ZT_CORRUPT || result == ZT_UNSUPPORTED || result == ZT_TRUNCATED || result == ZT_OK;
    if (broken && *usable)
        return ZT_OK;
    if (broken)
        return zt__fail(r->diag, ZT_CORRUPT, v.first.rule, ZT__NO_OFFSET, "the IMAG chunk cannot be used: %s",
                        v.first.text);
    return zt__fail(r->diag, result, diag.result ? diag.rule : v.first.rule, ZT__NO_OFFSET, "%s",
                    diag.result ? diag.text : v.first.text);
}

/* ---- the texels ---- */

/* How many units have a right tile index, if the stored bytes of TEXL begin at source. */
static zt_result count_units(zt__recovery *r, uint64_t source, uint32_t *count) {
    uint8_t *bytes;
    zt__piece piece = {0, r->texels_size, NULL, source};
    *count = 0;
    for (uint32_t i = 0; i < r->file->unit_count; i++) {
        const zt__unit *unit = &r->file->units[i];
        uint64_t size = unit->tile_count * ZT__TILE_RECORD_SIZE;
        ZT_TRY(zt__decoder_stored(&r->decoder, size, r->diag, &bytes));
        zt_result result = read_piece(r, &piece, unit->record.offset, bytes, (size_t)size);
        if (result != ZT_OK)
            return zt__fail(r->diag, result, 0, source, "the tile indices could not be read");
        *count += zt__hash(bytes, (size_t)size) == unit->record.index_hash;
    }
    return ZT_OK;
}

static zt_result try_source(zt__recovery *r, uint64_t source, uint32_t *best) {
    uint32_t count;
    if (*best == r->file->unit_count)
        return ZT_OK;
    ZT_TRY(count_units(r, source, &count));
    if (count > *best) {
        *best = count;
        r->pieces[r->texels_piece].source = source;
    }
    return ZT_OK;
}

/* Where an entry says; else behind the chunk before, else so that the file ends with them. The tile indices decide. */
zt_result zt__recover_place_texels(zt__recovery *r) {
    enum { MOST = 8 }; /* entries that are tried: more are somebody's game */
    uint32_t best = 0, tried = 0;
    uint64_t behind = 0, whole = ZT__HEAD_SIZE + zt__align16(r->texels_size);
    for (uint32_t i = 0; i < r->found_count; i++) {
        const zt__entry *e = &r->found[i].entry;
        uint64_t end = e->offset + ZT__HEAD_SIZE + zt__align16(e->stored_size);
        if (e->type == ZT__TEXL && tried++ < MOST)
            ZT_TRY(try_source(r, e->offset + ZT__HEAD_SIZE, &best));
        if (e->type != ZT__TEXL && r->found[i].intact && end > behind)
            behind = end;
    }
    ZT_TRY(try_source(r, behind + ZT__HEAD_SIZE, &best));
    if (r->damaged->size >= whole)
        ZT_TRY(try_source(r, r->damaged->size - whole + ZT__HEAD_SIZE, &best));
    return ZT_OK;
}
