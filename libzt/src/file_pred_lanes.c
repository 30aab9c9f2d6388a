/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops for SSE4.1 and NEON (file_pred.h): samples of four lanes at a time, whose table entries come one
 * by one. One source with vectors of the compiler for both; only two instructions have to be named. Texels are restored
 * as in file_pred_vector.c, which is as fast there as with intrinsics. */
#include "file_pred_job.h"

#include <string.h>

#include "base_bytes.h"

#if defined(__has_builtin) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#if __has_builtin(__builtin_shufflevector)
#if defined(__SSE2__) /* what file_pred_vector.c has, too */
#define LANES_SSE41 1
#elif defined(__aarch64__)
#define LANES_NEON 1
#endif
#endif
#endif

#if defined(LANES_SSE41) || defined(LANES_NEON)

typedef uint8_t bytes16 __attribute__((vector_size(16)));
typedef uint16_t halves8 __attribute__((vector_size(16)));
typedef uint32_t words4 __attribute__((vector_size(16)));
typedef uint64_t longs2 __attribute__((vector_size(16)));

/* look_up: bytes of a table of 16, 0 where the index has its highest bit. bits_of: bit i is set where number i is all
 * ones and not where it is zero. */
#ifdef LANES_SSE41

#include <smmintrin.h>

#define TARGET __attribute__((target("sse4.1")))

TARGET static inline bytes16 look_up(bytes16 table, bytes16 at) {
    return (bytes16)_mm_shuffle_epi8((__m128i)table, (__m128i)at);
}

TARGET static inline uint32_t bits_of(words4 v) {
    return (uint32_t)_mm_movemask_ps((__m128)v);
}

#else

#include <arm_neon.h>

#define TARGET

static inline bytes16 look_up(bytes16 table, bytes16 at) {
    return (bytes16)vqtbl1q_u8((uint8x16_t)table, (uint8x16_t)at);
}

static inline uint32_t bits_of(words4 v) {
    return vaddvq_u32((uint32x4_t)(v & (words4){1, 2, 4, 8}));
}

#endif

/* Rows have margins: this reads and writes up to 15 bytes behind the width. */
TARGET static void measure_lanes(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width) {
    const bytes16 lengths = {0, 1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4};
    if (!high) {
        zt__pred_measure_c(high, low, out, width);
        return;
    }
    for (uint32_t x = 0; x < width; x += 16) {
        bytes16 l, h, length, n[3];
        memcpy(&l, low + x, sizeof l);
        memcpy(&h, high + x, sizeof h);
        length = look_up(lengths, l & 15);
        n[0] = look_up(lengths, l >> 4);
        n[1] = look_up(lengths, h & 15);
        n[2] = look_up(lengths, h >> 4);
        for (int i = 0; i < 3; i++) { /* a length other than 0 outdoes those of all nibbles below */
            bytes16 some = (bytes16)(n[i] != 0);
            length = (length & ~some) | ((n[i] + (uint8_t)(4 * i + 4)) & some);
        }
        memcpy(out + x, &length, sizeof length);
    }
}

/* For each set of lanes that want a word: bytes of the next 4 words, each to its 32-bit lane; 128 gives a zero. */
#define BIT(m, i) ((m) >> (i)&1)
#define LOWER(m, i) (BIT(m, 0) * ((i) > 0) + BIT(m, 1) * ((i) > 1) + BIT(m, 2) * ((i) > 2))
#define WORD(m, i) BIT(m, i) ? 2 * LOWER(m, i) : 128, BIT(m, i) ? 2 * LOWER(m, i) + 1 : 128, 128, 128
#define SPREAD(m) \
    { WORD(m, 0), WORD(m, 1), WORD(m, 2), WORD(m, 3) }
#define SPREAD4(m) SPREAD(m), SPREAD((m) + 1), SPREAD((m) + 2), SPREAD((m) + 3)
static const bytes16 spread[16] = {SPREAD4(0), SPREAD4(4), SPREAD4(8), SPREAD4(12)};
/* Bytes of those words. */
static const uint8_t used[16] = {0, 2, 2, 4, 2, 4, 4, 6, 2, 4, 4, 6, 4, 6, 6, 8};

/* One sample of 4 lanes. Reads 8 bytes of words. Returns the table entries from the symbols on. */
TARGET static inline words4 step4(const uint32_t *const *tables, const uint8_t *acts, uint32_t *states,
                                  const uint8_t **next) {
    words4 state, entry;
    memcpy(&state, states, sizeof state);
    for (uint32_t i = 0; i < 4; i++)
        entry[i] = tables[acts[i]][states[i] & (ZT__PRED_SLOTS - 1)];
    state = (entry & ZT__PRED_FREQUENCY) * (state >> ZT__PRED_BITS) + (entry >> ZT__PRED_OFFSET_AT);
    words4 need = (words4)(state < ZT__PRED_LOW);
    uint32_t lanes = bits_of(need);
    words4 words = (words4)look_up((bytes16)(longs2){zt__load64(*next), 0}, spread[lanes]);
    state = (state & ~need) | (state << 16 & need) | words;
    memcpy(states, &state, sizeof state);
    *next += used[lanes];
    return entry >> ZT__PRED_SYMBOL_AT;
}

/* The even ones of 16-bit numbers, and of bytes. */
TARGET static inline halves8 even_halves(words4 a, words4 b) {
    return __builtin_shufflevector((halves8)a, (halves8)b, 0, 2, 4, 6, 8, 10, 12, 14);
}

TARGET static inline bytes16 even_bytes(halves8 a, halves8 b) {
    return __builtin_shufflevector((bytes16)a, (bytes16)b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
}

TARGET static void symbols_lanes(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to) {
    const uint8_t *next = job->next;
    const uint32_t *const *tables = map->tables;
    uint32_t mask = job->lanes - 1, x = from;
    for (; to - x >= 16; x += 16) {
        if (job->end - next < ZT__PRED_REACH && !zt__pred_words_left(job, &next))
            return;
        const uint8_t *acts = job->acts + x;
        uint32_t *states = job->states + (x & mask);
        words4 a = step4(tables, acts, states, &next), b = step4(tables, acts + 4, states + 4, &next);
        words4 c = step4(tables, acts + 8, states + 8, &next), d = step4(tables, acts + 12, states + 12, &next);
        bytes16 symbols = even_bytes(even_halves(a, b), even_halves(c, d));
        memcpy(out + x, &symbols, sizeof symbols);
    }
    job->next = next;
    if (next > job->end)
        zt__pred_words_left(job, &next);
    else if (x < to)
        zt__pred_symbols_c(job, map, out, x, to);
}

#endif

const zt__pred_kernel *zt__pred_kernel_sse41(void) {
#ifdef LANES_SSE41
    static const zt__pred_kernel kernel = {"sse41",       zt__pred_select_c,       symbols_lanes,
                                           measure_lanes, zt__pred_restore_vector, NULL};
    if (__builtin_cpu_supports("sse4.1"))
        return &kernel;
#endif
    return NULL;
}

const zt__pred_kernel *zt__pred_kernel_neon(void) {
#ifdef LANES_NEON
    static const zt__pred_kernel kernel = {"neon",        zt__pred_select_c,       symbols_lanes,
                                           measure_lanes, zt__pred_restore_vector, NULL};
    return &kernel;
#else
    return NULL;
#endif
}
