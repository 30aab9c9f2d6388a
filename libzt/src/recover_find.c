/* SPDX-License-Identifier: Apache-2.0 */
/* Looking for the chunks of a damaged file. */
#include "base_hash.h"
#include "file_check.h"
#include "recover.h"

/* ---- judging what was found ---- */

/* The bytes of TEXL, which the units of a decoded IMAG chunk sum up to: its own head may be lost. 0: not an IMAG. */
static uint64_t sum_of_units(const uint8_t *bytes, uint64_t size) {
    zt__cursor in = zt__cursor_of(bytes, (size_t)size);
    uint32_t images = zt__take32(&in), units = zt__take32(&in);
    uint64_t sum = 0, records = 16 + (uint64_t)images * ZT__IMAGE_RECORD_SIZE;
    if (in.bad || records + (uint64_t)units * ZT__UNIT_RECORD_SIZE != size)
        return 0;
    in.at = (size_t)records;
    for (uint32_t i = 0; i < units; i++) {
        zt__unit_record unit;
        zt__coder coder = zt__reading(&in);
        zt__code_unit(&coder, &unit);
        if (!zt__add64(sum, unit.size, &sum) || sum >= UINT64_C(1) << 53)
            return 0;
    }
    return sum;
}

/* Takes size bytes of work from the budget: entries that all name the same large range must not cost a reading each. */
static bool afford(zt__recovery *r, uint64_t size) {
    if (size > r->work)
        return false;
    r->work -= size;
    return true;
}

static bool is_sane(const zt__entry *e) {
    zt__sink quiet = {0};
    return zt__check_entry(&quiet, e, 0, e->offset) == ZT_OK && e->offset % 16 == 0;
}

/* Memory for a chunk. What is over the limit cannot be judged, and counts as lost: *room is false. */
static zt_result make_room(zt__recovery *r, const zt__entry *e, uint8_t **stored, uint8_t **raw, bool *room) {
    zt_diag diag;
    zt__begin(&diag);
    zt_result result = zt__decoder_stored(&r->decoder, e->stored_size, &diag, stored);
    if (result == ZT_OK)
        result = zt__decoder_raw(&r->decoder, e->decoded_size, &diag, raw);
    *room = result == ZT_OK;
    return result == ZT_NO_MEMORY ? zt__fail(r->diag, result, 0, ZT__NO_OFFSET, "%s", diag.text) : ZT_OK;
}

/* ZT_OK with *intact, or an error of the io, or no memory. */
static zt_result judge(zt__recovery *r, const zt__entry *e, bool *intact) {
    zt_diag diag;
    zt__sink quiet = {.diag = &diag};
    uint8_t *stored, *raw;
    bool room;
    *intact = false;
    zt__begin(&diag);
    if (!is_sane(e))
        return ZT_OK;
    *intact = e->type == ZT__TEXL && e->offset < r->damaged->size;
    if (e->type == ZT__TEXL || !zt__range_ok(e->offset, ZT__HEAD_SIZE, r->damaged->size) ||
        !zt__range_ok(e->offset + ZT__HEAD_SIZE, e->stored_size, r->damaged->size) ||
        !afford(r, e->stored_size + e->decoded_size))
        return ZT_OK;
    ZT_TRY(make_room(r, e, &stored, &raw, &room));
    if (!room)
        return ZT_OK;
    zt_result result = zt__read(r->damaged, e->offset + ZT__HEAD_SIZE, stored, (size_t)e->stored_size, &diag);
    if (result != ZT_OK)
        return zt__fail(r->diag, result, 0, diag.offset, "%s", diag.text);
    if (zt__hash(stored, (size_t)e->stored_size) != e->stored_hash)
        return ZT_OK;
    result = zt__decode_stored(&quiet, &r->decoder, e->codec, stored, (size_t)e->stored_size, raw,
                               (size_t)e->decoded_size, e->decoded_hash, 4004, 0);
    if (result == ZT_NO_MEMORY)
        return zt__fail(r->diag, result, 0, ZT__NO_OFFSET, "%s", diag.text);
    *intact = result == ZT_OK;
    if (*intact && e->type == ZT__IMAG && r->texels_size == 0) {
        r->texels_size = sum_of_units(raw, e->decoded_size);
        *intact = r->texels_size > 0;
    }
    return ZT_OK;
}

static zt_result add(zt__recovery *r, const zt__entry *e, uint32_t index) {
    bool intact;
    zt__found *slot = NULL;
    for (uint32_t i = 0; i < r->found_count; i++) {
        if (r->found[i].entry.offset == e->offset)
            slot = &r->found[i];
    }
    if (slot && slot->intact)
        return ZT_OK;
    if (!slot && r->found_count == r->found_capacity)
        return ZT_OK;
    ZT_TRY(judge(r, e, &intact));
    /* Without a directory only what is right can be believed to be a chunk at all. */
    if (!intact && !r->report->directory_intact)
        return ZT_OK;
    if (!slot)
        slot = &r->found[r->found_count++];
    slot->entry = *e;
    slot->index = index;
    slot->sane = is_sane(e);
    slot->intact = intact;
    return ZT_OK;
}

/* ---- directory and heads ---- */

/* Each entry on its own: what is right in a damaged directory serves. */
static zt_result add_directory(zt__recovery *r, const uint8_t *entries, uint32_t count) {
    zt__cursor in = zt__cursor_of(entries, (size_t)count * ZT__ENTRY_SIZE);
    zt__coder coder = zt__reading(&in);
    for (uint32_t i = 0; i < count; i++) {
        zt__entry entry;
        zt__code_entry(&coder, &entry);
        ZT_TRY(add(r, &entry, i));
    }
    return ZT_OK;
}

static zt_result read_directory(zt__recovery *r) {
    enum { COVERED = 56 };
    zt__sink quiet = {0};
    zt__preamble p;
    void *block;
    if (r->damaged->size < ZT__PREAMBLE_SIZE)
        return ZT_OK;
    uint64_t most = (r->damaged->size - ZT__PREAMBLE_SIZE) / ZT__ENTRY_SIZE;
    uint64_t size = ZT__PREAMBLE_SIZE +
                    (uint64_t)ZT__ENTRY_SIZE * (most < r->found_capacity ? most : r->found_capacity);
    ZT_TRY(zt__alloc_raw(&r->memory, size, 1, r->diag, &block));
    uint8_t *bytes = block;
    zt_result result = zt__read(r->damaged, 0, bytes, (size_t)size, r->diag);
    if (result == ZT_OK) {
        zt__cursor in = zt__cursor_of(bytes, ZT__PREAMBLE_SIZE);
        zt__coder coder = zt__reading(&in);
        zt__code_preamble(&coder, &p);
        bool fits = p.chunk_count >= 3 && ZT__PREAMBLE_SIZE + (uint64_t)p.chunk_count * ZT__ENTRY_SIZE <= size;
        uint32_t count = fits ? p.chunk_count : (uint32_t)((size - ZT__PREAMBLE_SIZE) / ZT__ENTRY_SIZE);
        memmove(bytes + COVERED, bytes + ZT__PREAMBLE_SIZE, (size_t)size - ZT__PREAMBLE_SIZE);
        r->report->directory_intact = fits && zt__check_preamble(&quiet, &r->limits, &p) == ZT_OK &&
                                      zt__hash(bytes, COVERED + (size_t)count * ZT__ENTRY_SIZE) == p.directory_hash;
        if (fits && p.directory_size == p.chunk_count * (uint32_t)ZT__ENTRY_SIZE)
            r->report->chunks_expected = p.chunk_count;
        result = add_directory(r, bytes + COVERED, count);
    }
    zt__free(&r->memory, block, size, 1);
    return result;
}

/* A head says where it is, which a chunk inside a chunk cannot say rightly. */
static zt_result look_at_head(zt__recovery *r, const uint8_t *bytes, uint64_t offset) {
    zt__head head;
    zt__cursor in = zt__cursor_of(bytes, ZT__HEAD_SIZE);
    zt__coder coder = zt__reading(&in);
    zt__code_head(&coder, &head);
    return head.entry.offset == offset ? add(r, &head.entry, head.index) : ZT_OK;
}

static zt_result scan(zt__recovery *r) {
    enum { STEP = 1 << 18 };
    void *block;
    zt_result result = ZT_OK;
    ZT_TRY(zt__alloc_raw(&r->memory, STEP + ZT__HEAD_SIZE, 1, r->diag, &block));
    uint8_t *bytes = block;
    for (uint64_t at = 0; result == ZT_OK && at + ZT__HEAD_SIZE <= r->damaged->size; at += STEP) {
        uint64_t left = r->damaged->size - at;
        size_t size = left < STEP + ZT__HEAD_SIZE ? (size_t)left : STEP + ZT__HEAD_SIZE;
        result = zt__read(r->damaged, at, bytes, size, r->diag);
        for (size_t i = 0; result == ZT_OK && i < STEP && i + ZT__HEAD_SIZE <= size; i += 16) {
            if (memcmp(bytes + i, zt__head_magic, sizeof zt__head_magic) == 0)
                result = look_at_head(r, bytes + i, at + i);
        }
    }
    zt__free(&r->memory, block, STEP + ZT__HEAD_SIZE, 1);
    return result;
}

/* ---- order ---- */

static uint32_t rank_of(const zt__found *f) {
    const zt__chunk_type *known = zt__find_chunk_type(f->entry.type);
    return known ? known->rank : ZT__RANK_UNKNOWN;
}

static bool before(const zt__found *a, const zt__found *b) {
    uint32_t rank_a = rank_of(a), rank_b = rank_of(b);
    if (rank_a != rank_b)
        return rank_a < rank_b;
    for (int i = 0; i < 32; i += 8) { /* by the bytes of the file */
        uint32_t x = a->entry.type >> i & 0xff, y = b->entry.type >> i & 0xff;
        if (x != y)
            return x < y;
    }
    return a->entry.offset < b->entry.offset;
}

/* In the order of the file (R3009). There are a handful, or what an attacker made, which limits bound. */
static void sort(zt__recovery *r) {
    for (uint32_t i = 1; i < r->found_count; i++) {
        zt__found moved = r->found[i];
        uint32_t k = i;
        for (; k > 0 && before(&moved, &r->found[k - 1]); k--)
            r->found[k] = r->found[k - 1];
        r->found[k] = moved;
    }
}

zt_result zt__recover_find(zt__recovery *r) {
    void *block;
    uint32_t highest = 0;
    enum { MOST = 65535 };
    r->found_capacity = zt__min32(r->limits.chunks, MOST);
    ZT_TRY(zt__alloc(&r->memory, r->found_capacity, sizeof *r->found, r->diag, &block));
    r->found = block;
    const uint64_t huge = UINT64_C(1) << 53; /* so that the sum does not overflow */
    r->work = 8 * (r->damaged->size < huge ? r->damaged->size : huge) +
              4 * (r->limits.memory < huge ? r->limits.memory : huge);
    ZT_TRY(read_directory(r));
    if (!r->report->directory_intact)
        ZT_TRY(scan(r));
    sort(r);
    for (uint32_t i = 0; i < r->found_count; i++)
        highest = zt__max32(highest, r->found[i].index);
    if (r->report->chunks_expected == 0 && highest < MOST)
        r->report->chunks_expected = zt__max32(r->found_count, highest + 1);
    return ZT_OK;
}

const zt__found *zt__recover_chunk(const zt__recovery *r, uint32_t type) {
    for (uint32_t i = 0; i < r->found_count; i++) {
        if (r->found[i].entry.type == type && r->found[i].intact)
            return &r->found[i];
    }
    return NULL;
}
