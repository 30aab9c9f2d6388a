/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: umbrellas come back from encoding and decoding as they were, limits hold before anything is allocated, and
 * chunks that were damaged, or changed and sealed again at random, are refused or are sound. Payloads come from files
 * of strangers. An argument: the number of random changes.
 */
#include "umbrella_payload.h"

#include "umbrella_chunk.h"

static void check_identity(zt__memory *memory) {
    static const zt_background_kind below[] = {ZT_BACKGROUND_COLOUR, ZT_BACKGROUND_IMAGE, ZT_BACKGROUND_TEXTURE};
    for (uint32_t n = 0; n < 60; n++) {
        heap_setup t = {.grid_x = 1 + n % 9,
                        .grid_y = 1 + n % 5,
                        .level_count = 1,
                        .base_count = n % (HEAP_BASES + 1),
                        .umbrella_count = n % 7 * 9,
                        .repeat_x = n & 1,
                        .repeat_y = n & 2,
                        .texture = n & 4 ? 1 : ZT_NONE};
        t.below = below[t.texture == ZT_NONE ? n % 2 : n % 3];
        while (t.level_count <= zt__log2(zt__max32(t.grid_x, t.grid_y)) && n % 10 >= t.level_count)
            t.level_count++;
        heap *h = heap_make(&t, 100 + n);
        zt__umbrellas *u = umbrellas_of(memory, h, &t), *back = NULL;
        zt_diag diag = {0};
        zt_check_summary summary = {0};
        zt_check_options options = {0};
        zt__sink sink = {.diag = &diag}, validating = {.check = &options, .summary = &summary};
        CHECK(heap_equal(&u->view, &h->info));
        chunk c = encode(memory, u);
        CHECK(decode(memory, &t, c, &sink, &back) == ZT_OK);
        CHECK(back && heap_equal(&back->view, &h->info));
        if (!back)
            fprintf(stderr, "%u: rule %u: %s\n", n, diag.rule, diag.text);
        if (back)
            release(memory, back);
        CHECK(decode(memory, &t, c, &validating, NULL) == ZT_OK && summary.errors == 0 && summary.warnings == 0);
        free(c.bytes);
        release(memory, u);
        heap_free(h);
    }
}

/* ---- damage --------------------------------------------------------------------------------- */

/* Every shorter chunk, a longer one, and damaged ones: refused, never anything worse. */
static void check_damage(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 5);
    uint64_t seed = 21;
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag}, quiet = {0};
    for (size_t n = 0; n < c.size; n += 1 + n / 400) {
        chunk cut = {malloc(n + 1), n};
        memcpy(cut.bytes, c.bytes, n);
        cut.bytes = realloc(cut.bytes, n ? n : 1);
        diag = (zt_diag){0};
        CHECK(decode(memory, &standard, cut, &sink, NULL) == ZT_CORRUPT);
        CHECK(n >= ZT__UMBRELLA_HEADER_SIZE || diag.rule == 8301);
        free(cut.bytes);
    }
    chunk copy = {calloc(1, c.size + 1), c.size + 1};
    memcpy(copy.bytes, c.bytes, c.size);
    diag = (zt_diag){0};
    CHECK(decode(memory, &standard, copy, &sink, NULL) == ZT_CORRUPT && diag.rule == 5106);
    copy.size = c.size;
    for (int n = 0; n < 3000; n++) {
        uint32_t at = test_below(&seed, (uint32_t)c.size);
        memcpy(copy.bytes, c.bytes, c.size);
        copy.bytes[at] ^= (uint8_t)(1 + test_below(&seed, 255));
        zt_result result = decode(memory, &standard, copy, &quiet, NULL);
        CHECK(result == ZT_CORRUPT || result == ZT_LIMIT || (result == ZT_OK && at < ZT__UMBRELLA_HEADER_SIZE));
    }
    free(copy.bytes);
    free(c.bytes);
}

/* Planes of one value, which stores nothing, as many as the header says. */
static chunk promise(const uint8_t *header, const opened *o) {
    chunk c = {calloc(1, ZT__UMBRELLA_HEADER_SIZE + PLANES * ZT__PLANE_HEADER_SIZE), ZT__UMBRELLA_HEADER_SIZE};
    memcpy(c.bytes, header, c.size);
    for (uint32_t p = 0; p < PLANES; p++) {
        zt__plane_header plane = {.element_size = (uint8_t)o->edges[p], .packing = 2, .count = o->counts[p]};
        zt__coder writing = zt__writing(c.bytes + c.size);
        zt__code_plane(&writing, &plane);
        c.size += ZT__PLANE_HEADER_SIZE;
    }
    return c;
}

/* A chunk of 1512 bytes may promise gigabytes: they are refused before any of it is there, counts that differ first. */
static void check_promises(void) {
    static const struct {
        uint32_t offset, value, first, last;
    } promises[] = {{0, 8192, P_LIST_SIZE, P_LIST_SIZE},        {16, 1 << 24, P_FORM, P_VERTICES},
                    {20, UINT32_MAX, P_VERTEX_X, P_VERTEX_Y},   {24, UINT32_MAX, P_MORPH_X, P_MORPH_Y},
                    {28, UINT32_MAX, P_VARIANT_R, P_VARIANT_B}, {32, UINT32_MAX, P_EXPLICIT_X, P_EXPLICIT_B},
                    {36, UINT32_MAX, P_ENTRY, P_SHIFT}};
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 24);
    chunk c = make_chunk(&memory, &standard, 3);
    opened o = open_chunk(&memory, c);
    for (size_t i = 0; i < sizeof promises / sizeof *promises; i++) {
        opened big = o;
        zt_diag diag = {0};
        zt__sink sink = {.diag = &diag};
        uint32_t count = promises[i].value;
        zt__store32(big.header + promises[i].offset, count);
        if (i == 0) {
            zt__store32(big.header + 4, count);
            count = 8192 * 8192 + 4096 * 4096 + 2048 * 2048;
        }
        chunk kept = promise(big.header, &big);
        CHECK(decode(&memory, &standard, kept, &sink, NULL) == ZT_CORRUPT && diag.rule == 5102);
        for (uint32_t p = promises[i].first; p <= promises[i].last; p++)
            big.counts[p] = count;
        chunk promised = promise(big.header, &big);
        diag = (zt_diag){0};
        CHECK(decode(&memory, &standard, promised, &sink, NULL) == ZT_LIMIT && diag.rule == 1010);
        free(kept.bytes);
        free(promised.bytes);
    }
    close_chunk(&o);
    free(c.bytes);
    CHECK(memory.used == 0);
}

/* ---- random changes --------------------------------------------------------------------------- */

static uint32_t value_for(uint64_t *seed, uint32_t old) {
    static const uint32_t special[] = {0,          1,          2,          3,          127,        128,
                                       255,        4096,       4097,       65535,      65536,      0x3FFFFFFF,
                                       0x40000000, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xBFFFFFFF, 0xC0000000,
                                       0xC0000001, 0xFFFFFFFF, 1 << 24};
    switch (test_below(seed, 6)) {
    case 0:
        return old + 1;
    case 1:
        return old - 1;
    case 2:
        return old ^ UINT32_C(1) << test_below(seed, 32);
    case 3:
        return (uint32_t)(test_random(seed) >> 32);
    case 4:
        return test_below(seed, 20);
    default:
        return special[test_below(seed, sizeof special / sizeof *special)];
    }
}

static void change(opened *o, uint64_t *seed) {
    uint32_t p = test_below(seed, PLANES + 4);
    if (p >= PLANES) {
        uint8_t *field = o->header + 4 * test_below(seed, ZT__UMBRELLA_HEADER_SIZE / 4);
        zt__store32(field, value_for(seed, zt__load32(field)));
        return;
    }
    if (o->counts[p] == 0)
        return;
    uint32_t i = test_below(seed, o->counts[p]);
    set_element(o, p, i, value_for(seed, element(o, p, i)));
    if (test_below(seed, 8) == 0) { /* another one, so that sums may stay */
        uint32_t k = test_below(seed, o->counts[p]);
        set_element(o, p, k, value_for(seed, element(o, p, k)));
    }
    if (test_below(seed, 40) == 0)
        o->counts[p] -= 1;
}

/* What was taken is written again as the same bytes of planes; loader and validator agree. */
static void check_taken(zt__memory *memory, const heap_setup *t, chunk c, uint64_t *taken) {
    zt_check_summary summary = {0};
    zt_check_options options = {0};
    zt__sink quiet = {0}, validating = {.check = &options, .summary = &summary};
    zt__umbrellas *u = NULL, *again = NULL;
    zt_result result = decode(memory, t, c, &quiet, &u);
    CHECK(result == ZT_OK || result == ZT_CORRUPT || result == ZT_LIMIT);
    zt_result checked = decode(memory, t, c, &validating, NULL);
    CHECK((result == ZT_OK) == (checked == ZT_OK && summary.errors == 0));
    if (!u)
        return;
    (*taken)++;
    chunk second = encode(memory, u);
    CHECK(decode(memory, t, second, &quiet, &again) == ZT_OK);
    CHECK(again && heap_equal(&again->view, &u->view));
    if (again)
        release(memory, again);
    release(memory, u);
    free(second.bytes);
}

static void check_changes(uint64_t count) {
    zt__memory memory;
    uint64_t seed = 77, taken = 0;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 22); /* promises are refused early */
    for (uint64_t n = 0; n < count; n++) {
        static chunk c;
        heap_setup t = standard;
        t.repeat_y = n / 64 % 2;
        t.umbrella_count = (uint32_t)(n / 64 % 20);
        if (n % 64 == 0) {
            free(c.bytes);
            c = make_chunk(&memory, &t, 1000 + n);
        }
        opened o = open_chunk(&memory, c);
        for (uint32_t k = 1 + test_below(&seed, 2); k > 0; k--)
            change(&o, &seed);
        chunk changed = seal(&memory, &o);
        check_taken(&memory, &t, changed, &taken);
        free(changed.bytes);
        close_chunk(&o);
        if (n + 1 == count)
            free(c.bytes);
    }
    CHECK(memory.used == 0);
    printf("%llu changed chunks, %llu of them sound\n", (unsigned long long)count, (unsigned long long)taken);
    CHECK(taken > count / 50 && taken < count);
}

int main(int argc, char **argv) {
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    check_identity(&memory);
    check_damage(&memory);
    check_promises();
    check_changes(argc > 1 ? strtoull(argv[1], NULL, 10) : 3000);
    CHECK(memory.used == 0);
    return test_end();
}
