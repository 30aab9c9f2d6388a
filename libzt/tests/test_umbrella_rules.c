/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: each of rules 8301 to 8315 is found by loader and validator when it alone is broken in otherwise sound
 * bytes, and the validator goes on to the next base, umbrella and list. A lookup believes what the rules say.
 */
#include "umbrella_payload.h"

#include "umbrella_chunk.h"

/* ---- rules ---------------------------------------------------------------------------------- */

typedef struct breakage {
    uint32_t rule;
    uint32_t plane; /* HEADER + offset: of the header */
    uint32_t element, value;
} breakage;

enum { HEADER = 1000 };

/* Bits of floats. */
#define NEGATIVE_ZERO UINT32_C(0x80000000)
#define NOT_A_NUMBER UINT32_C(0x7FC00000)
#define INFINITE UINT32_C(0x7F800000)

/* Umbrella 0 has form 0, 1 form 1, 2 form 2, 3 form 0 mirrored, all of base 0; 4 to 7 the same of base 1. Of level 1,
 * the first is 17. */
static const breakage breakages[] = {
    {0, HEADER + 0, 0, 7},
    {8301, HEADER + 0, 0, 0},
    {8301, HEADER + 0, 0, 8193},
    {8301, HEADER + 4, 0, 0},
    {8301, HEADER + 4, 0, UINT32_MAX},
    {8301, HEADER + 8, 0, 0},
    {8301, HEADER + 8, 0, 4},
    {8301, HEADER + 12, 0, 65537},
    {8301, HEADER + 16, 0, (1 << 24) + 1},
    {8301, HEADER + 44, 0, 0x00010000},
    {8301, HEADER + 44, 0, 0x01000000},
    {8301, HEADER + 96, 0, 0},
    {8301, HEADER + 96, 0, 2},
    {8301, HEADER + 100, 0, 1},
    {8302, HEADER + 44, 0, 0x0102},
    {8302, HEADER + 44, 0, 0x0301},
    {8303, HEADER + 52, 0, NEGATIVE_ZERO},
    {8303, HEADER + 64, 0, NOT_A_NUMBER},
    {8303, HEADER + 68, 0, 0xBF800000},
    {8303, HEADER + 80, 0, INFINITE},
    {8303, HEADER + 84, 0, INFINITE},
    {8303, HEADER + 84, 0, NEGATIVE_ZERO},
    {8303, HEADER + 88, 0, 0x3E000000}, /* 1/8, the end */
    {8303, HEADER + 88, 0, NEGATIVE_ZERO},
    {8303, HEADER + 92, 0, 0x3E000001},
    {8303, HEADER + 92, 0, NOT_A_NUMBER},
    {8304, HEADER + 40, 0, 1000},
    {8304, P_LEVEL_UMBRELLAS, 0, 16},
    {8304, P_LEVEL_UMBRELLAS, 1, UINT32_MAX},
    {8304, P_LEVEL_BITS, 1, 17},
    {8304, P_LEVEL_BITS, 2, 255},
    {8304, P_BASE_VERTICES, 1, 65535},
    {8304, P_BASE_MORPH, 0, 0},
    {8304, P_BASE_MORPH, 1, 1},
    {8304, P_BASE_VARIANTS, 0, 3},
    {8304, P_BASE_VARIANTS, 1, 255},
    {8304, P_VERTICES, 2, 4096},
    {8304, P_LIST_SIZE, 3, 1000},
    {8304, P_LIST_SIZE, 41, UINT32_MAX},
    {8305, P_BASE_KIND, 0, 2},
    {8305, P_BASE_KIND, 2, 255},
    {8305, P_BASE_SOURCE, 0, 1},
    {8305, P_BASE_SOURCE, 0, 2},
    {8305, P_BASE_SOURCE, 0, 3},
    {8305, P_BASE_SOURCE, 2, IMAGES},
    {8305, P_BASE_SOURCE, 2, UINT32_MAX},
    {8305, P_BASE_SOURCE, 1, OWN_TEXTURE},
    {8305, P_BASE_SOURCE, 1, UINT32_MAX},
    {8305, HEADER + 44, 0, 0x0001}, /* a colour with a source */
    {8305, HEADER + 48, 0, 1},
    {8305, HEADER + 48, 0, 2},
    {8305, HEADER + 48, 0, 3},
    {8305, HEADER + 48, 0, ZT_NONE},
    {8306, P_BASE_ASPECT, 1, 0},
    {8306, P_BASE_ASPECT, 0, (1 << 24) + 1},
    {8306, P_BASE_MORPH, 0, 2},
    {8306, P_BASE_MORPH, 0, 255},
    {8306, P_BASE_ELLIPSOID, 0, 3},
    {8306, P_BASE_ELLIPSOID, 0, 0},
    {8306, P_BASE_HEIGHT, 1, 1},
    {8306, P_BASE_CURVATURE, 1, 1},
    {8307, P_VERTEX_X, 0, 0},
    {8307, P_BASE_Y, 1, 0},
    {8308, P_MORPH_X, 0, 0},
    {8308, P_MORPH_Y, 1, 0},
    {8309, P_FORM, 0, 3},
    {8309, P_FORM, 0, 8},
    {8309, P_FORM, 3, 12},
    {8309, P_FORM, 1, 5},
    {8309, P_FORM, 2, 6},
    {8309, P_FORM, 17, 1},
    {8309, P_FORM, 24, 0},
    {8310, P_BASE, 0, 3},
    {8310, P_BASE, 1, 65535},
    {8310, P_BASE, 2, 1},
    {8310, P_A, 1, 0x80000001},
    {8310, P_B, 2, 0},
    {8310, P_MORPH, 1, 1},
    {8310, P_MORPH, 4, 1}, /* its base has no morph */
    {8310, P_VARIANT_0, 0, 2},
    {8310, P_VARIANT_1, 4, 1},
    {8310, P_VARIANT_0, 2, 1},
    {8310, P_VARIANT_WEIGHT, 5, 1},
    {8310, P_STRENGTH, 2, 1},
    {8311, P_VERTICES, 0, 3},
    {8311, P_VERTICES, 1, 11},
    {8311, P_VERTICES, 2, 2},
    {8311, P_VERTICES, 2, 0},
    {8311, P_VERTICES, 17, 4097},
    {8312, P_EXPLICIT_X, 0, 0},
    {8312, P_EXPLICIT_X, 0, UINT32_MAX},
    {8312, P_EXPLICIT_Y, 1, 0xC0000001},
    {8312, P_EXPLICIT_X, 2, 0x3FFFFFFF},
    {8313, P_X, 0, 0x7FFFFFFF}, /* -1 where it repeats */
    {8313, P_X, 1, 0x80000000u + 7 * 65536},
    {8313, P_X, 17, 0x80000000u + 3 * 65536},
    {8313, P_Y, 0, 0xC0000001},
    {8313, P_Y, 2, 0x3FFFFFFF},
    {8313, P_A, 0, 0xC0000001},
    {8313, P_B, 3, 0},
    {8314, P_ELLIPSOID, 0, 4},
    {8314, P_ELLIPSOID, 2, 3},
    {8314, P_HEIGHT, 0, 1},
    {8314, P_CURVATURE, 3, 1},
    {8314, P_LIFT, 0, 65535},
    {8315, P_ENTRY, 0, 17},
    {8315, P_ENTRY, 0, 1 << 24},
    {8315, P_ENTRY, 1, UINT32_MAX},
    {8315, P_SHIFT, 0, 9},
    {8315, P_SHIFT, 0, 255},
    {8315, P_SHIFT, 0, 0}, /* down, where it does not repeat */
    {8315, P_SHIFT, 0, 7},
};

static void apply(opened *o, const breakage *b) {
    if (b->plane >= HEADER) {
        zt__store32(o->header + (b->plane - HEADER), b->value);
        return;
    }
    CHECK(b->element < o->counts[b->plane]);
    set_element(o, b->plane, b->element, b->value);
}

static uint32_t expected_rule;
static uint32_t found_expected, found_others;

static int on_finding(void *user, const zt_finding *finding) {
    (void)user;
    found_expected += finding->rule == expected_rule;
    found_others += finding->rule != expected_rule;
    return 0;
}

/* Loader and validator say the same; what it says is a sentence with a place. */
static void expect(zt__memory *memory, const opened *o, uint32_t rule, size_t row) {
    zt_diag diag = {0};
    zt_check_summary summary = {0};
    zt_check_options options = {.finding = on_finding};
    zt__sink loading = {.diag = &diag}, validating = {.diag = NULL, .check = &options, .summary = &summary};
    chunk c = seal(memory, o);
    zt_result result = decode(memory, &standard, c, &loading, NULL);
    CHECK(result == (rule ? ZT_CORRUPT : ZT_OK) && diag.rule == rule);
    CHECK(rule == 0 || (diag.offset >= OFFSET && diag.offset < OFFSET + sizeof o->header && diag.text[0]));
    if (diag.rule != rule)
        fprintf(stderr, "row %zu: rule %u is expected, it is %u: %s\n", row, rule, diag.rule, diag.text);
    expected_rule = rule;
    found_expected = found_others = 0;
    (void)decode(memory, &standard, c, &validating, NULL);
    CHECK((found_expected > 0) == (rule != 0));
    free(c.bytes);
}

static void check_rules(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 3);
    for (size_t i = 0; i < sizeof breakages / sizeof *breakages; i++) {
        opened o = open_chunk(memory, c);
        apply(&o, &breakages[i]);
        expect(memory, &o, breakages[i].rule, i);
        close_chunk(&o);
    }
    free(c.bytes);
}

/* Counts of the header that no sum gives, while the planes have as many elements. */
static void check_counts(zt__memory *memory) {
    static const struct {
        uint32_t offset, first, last; /* the planes that get one element more */
    } rows[] = {{16, P_FORM, P_VERTICES},       {20, P_VERTEX_X, P_VERTEX_Y},     {24, P_MORPH_X, P_MORPH_Y},
                {28, P_VARIANT_R, P_VARIANT_B}, {32, P_EXPLICIT_X, P_EXPLICIT_B}, {36, P_ENTRY, P_SHIFT}};
    chunk c = make_chunk(memory, &standard, 3);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        opened o = open_chunk(memory, c);
        uint8_t *count = o.header + rows[i].offset;
        zt__store32(count, zt__load32(count) + 1);
        for (uint32_t p = rows[i].first; p <= rows[i].last; p++) /* there is room for one */
            o.counts[p]++;
        expect(memory, &o, 8304, 1000 + i);
        close_chunk(&o);
    }
    free(c.bytes);
}

/* Explicit umbrellas of a base that is not there, without vertices: their colours have no room. */
static void check_no_vertices(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 3);
    opened o = open_chunk(memory, c);
    for (uint32_t i = 0; i < o.counts[P_FORM]; i++) {
        set_element(&o, P_FORM, i, i < 17 ? ZT_UMBRELLA_EXPLICIT : ZT_UMBRELLA_COLOURED);
        set_element(&o, P_BASE, i, 99);
        set_element(&o, P_VERTICES, i, i < 17 ? 0 : 3);
    }
    o.counts[P_EXPLICIT_X] = o.counts[P_EXPLICIT_Y] = 3 * (o.counts[P_FORM] - 17);
    zt__store32(o.header + 32, o.counts[P_EXPLICIT_X]);
    for (uint32_t p = P_EXPLICIT_R; p <= P_EXPLICIT_B; p++)
        o.counts[p] = o.counts[P_EXPLICIT_X] + o.counts[P_FORM];
    expect(memory, &o, 8310, 1500);
    set_element(&o, P_LEVEL_UMBRELLAS, 0, o.counts[P_FORM]);
    set_element(&o, P_LEVEL_UMBRELLAS, 1, 0);
    set_element(&o, P_LEVEL_UMBRELLAS, 2, 0);
    for (uint32_t i = 17; i < o.counts[P_FORM]; i++) {
        set_element(&o, P_FORM, i, ZT_UMBRELLA_EXPLICIT);
        set_element(&o, P_VERTICES, i, 0);
    }
    o.counts[P_EXPLICIT_X] = o.counts[P_EXPLICIT_Y] = 0;
    zt__store32(o.header + 32, 0);
    expect(memory, &o, 8304, 1501);
    close_chunk(&o);
    free(c.bytes);
}

/* The last of all entries, behind which nothing ascends. */
static void check_last_entry(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 3);
    opened o = open_chunk(memory, c);
    CHECK(element(&o, P_LIST_SIZE, o.counts[P_LIST_SIZE] - 1) > 0);
    set_element(&o, P_ENTRY, o.counts[P_ENTRY] - 1, element(&o, P_LEVEL_UMBRELLAS, 2));
    expect(memory, &o, 8315, 1600);
    close_chunk(&o);
    free(c.bytes);
}

/* A similarity of nothing, and a morph that is its base turned round: a star, and half-way to it is a point. */
static void check_pairs(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 3);
    opened o = open_chunk(memory, c);
    set_element(&o, P_A, 0, UINT32_C(1) << 31);
    set_element(&o, P_B, 0, UINT32_C(1) << 31);
    expect(memory, &o, 8310, 1700);
    close_chunk(&o);
    o = open_chunk(memory, c);
    for (uint32_t k = 0; k < element(&o, P_BASE_VERTICES, 0); k++) {
        set_element(&o, P_MORPH_X, k, 2 * element(&o, P_BASE_X, 0) - element(&o, P_VERTEX_X, k));
        set_element(&o, P_MORPH_Y, k, 2 * element(&o, P_BASE_Y, 0) - element(&o, P_VERTEX_Y, k));
    }
    expect(memory, &o, 8308, 1701);
    close_chunk(&o);
    free(c.bytes);
}

/* Lists must ascend strictly: by umbrella, then by shift. */
static void check_order(zt__memory *memory) {
    chunk c = make_chunk(memory, &standard, 3);
    for (uint32_t row = 0; row < 3; row++) {
        opened o = open_chunk(memory, c);
        uint32_t cell = 0, first = 0;
        for (; element(&o, P_LIST_SIZE, cell) < 2; cell++)
            first += element(&o, P_LIST_SIZE, cell);
        uint32_t entry = element(&o, P_ENTRY, first + 1);
        set_element(&o, P_ENTRY, first, row == 2 ? entry + 1 : entry);
        set_element(&o, P_SHIFT, first, row == 0 ? element(&o, P_SHIFT, first + 1) : 5);
        set_element(&o, P_SHIFT, first + 1, row == 0 ? element(&o, P_SHIFT, first + 1) : 4);
        expect(memory, &o, 8315, 2000 + row);
        close_chunk(&o);
    }
    free(c.bytes);
}

/* Once around: a star that goes around twice has good sectors and is none. */
static const int32_t twice[5][2] = {{10000, 0}, {-8090, 5880}, {3090, -9510}, {3090, 9510}, {-8090, -5880}};

/* The first with five vertices. */
static void check_turns_of(zt__memory *memory, uint32_t rule) {
    heap_setup t = standard;
    uint64_t seed = 8;
    heap *h = heap_make(&t, seed);
    while (h->bases[0].vertex_count != 5) {
        heap_free(h);
        h = heap_make(&t, ++seed);
    }
    zt__umbrellas *u = umbrellas_of(memory, h, &t);
    zt_umbrella_texel *texels = rule == 8307 ? u->base_vertices : u->morph_vertices;
    for (uint32_t k = 0; k < 5; k++) {
        if (rule == 8312) /* umbrella 1 is explicit and of base 0 */
            u->explicit_vertices[k] = (zt_umbrella_offset){twice[k][0], twice[k][1]};
        else
            texels[k] = heap_texel(&u->bases[0], (zt_umbrella_offset){twice[k][0], twice[k][1]});
    }
    chunk c = encode(memory, u);
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag};
    CHECK(decode(memory, &t, c, &sink, NULL) == ZT_CORRUPT && diag.rule == rule && strstr(diag.text, "2 times"));
    free(c.bytes);
    release(memory, u);
    heap_free(h);
}

/* A validator tells of each base, umbrella and list that is wrong. */
static void check_all_found(zt__memory *memory) {
    zt_check_summary summary = {0};
    zt_check_options options = {.finding = on_finding};
    zt__sink sink = {.check = &options, .summary = &summary};
    chunk c = make_chunk(memory, &standard, 3);
    opened o = open_chunk(memory, c);
    set_element(&o, P_BASE_ASPECT, 0, 0);
    set_element(&o, P_BASE_ASPECT, 1, 0);
    set_element(&o, P_LIFT, 0, 65535);
    set_element(&o, P_Y, 5, 0);
    set_element(&o, P_Y, 20, 0);
    set_element(&o, P_SHIFT, o.counts[P_SHIFT] - 1, 9);
    chunk changed = seal(memory, &o);
    expected_rule = found_expected = found_others = 0;
    CHECK(decode(memory, &standard, changed, &sink, NULL) == ZT_OK);
    CHECK(summary.errors == 6 && found_others == 6);
    free(changed.bytes);
    close_chunk(&o);
    free(c.bytes);
}

int main(void) {
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    check_rules(&memory);
    check_counts(&memory);
    check_no_vertices(&memory);
    check_last_entry(&memory);
    check_pairs(&memory);
    check_order(&memory);
    for (uint32_t rule = 8307; rule <= 8312; rule += rule == 8308 ? 4 : 1)
        check_turns_of(&memory, rule);
    check_all_found(&memory);
    CHECK(memory.used == 0);
    return test_end();
}
