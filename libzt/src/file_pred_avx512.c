/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops for AVX-512 as Ice Lake and Zen 4 have it (file_pred.h). Texels are restored as with AVX2. */
#include "file_pred_job.h"

#if (defined(__x86_64__) || defined(__i386__)) && (defined(__GNUC__) || defined(__clang__))

#include <immintrin.h>

#define AVX512 __attribute__((target("avx2,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi,avx512vnni")))

/* Rows have margins: this reads and writes up to 63 bytes behind the width. */
AVX512 static void select_avx512(const uint8_t *above, const uint8_t *beside, const uint8_t *high, uint8_t *acts,
                                 uint32_t width) {
    const __m512i most = _mm512_set1_epi8(high ? ZT__PRED_ACTS - 2 : ZT__PRED_ACTS - 1);
    for (uint32_t x = 0; x < width; x += 64) {
        __m512i act = _mm512_avg_epu8(_mm512_loadu_si512(above + x - 1), _mm512_loadu_si512(above + x + 1));
        act = _mm512_avg_epu8(act, _mm512_loadu_si512(above + x));
        if (beside)
            act = _mm512_avg_epu8(act, _mm512_loadu_si512(beside + x));
        act = _mm512_min_epu8(act, most);
        if (high) {
            __m512i h = _mm512_loadu_si512(high + x);
            act = _mm512_mask_mov_epi8(act, _mm512_test_epi8_mask(h, h), _mm512_set1_epi8(ZT__PRED_ACTS - 1));
        }
        _mm512_storeu_si512(acts + x, act);
    }
}

AVX512 static void measure_avx512(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width) {
    if (high) {
        zt__pred_measure_avx2(high, low, out, width);
        return;
    }
    for (uint32_t x = 0; x < width; x += 64)
        _mm512_storeu_si512(out + x, _mm512_abs_epi8(_mm512_loadu_si512(low + x)));
}

/* One sample of 16 lanes. first: first slots of their tables. Returns the table entries. Lanes of a step wait for the
 * words that those before them want, so the count of words is what has to be known early. */
AVX512 static inline __m512i step16(const uint32_t *tables, __m512i *states, __m512i first, const uint8_t **next) {
    /* (state & mask) | first */
    __m512i slot = _mm512_ternarylogic_epi32(*states, _mm512_set1_epi32(ZT__PRED_SLOTS - 1), first, 0xEA);
    __mmask16 all = 0xFFFF;
    __asm__("" : "+Yk"(all)); /* compilers that know it gather into a register of other things, and wait for those */
    __m512i entry = _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), all, slot, tables, 4);
    __m512i f = _mm512_and_si512(entry, _mm512_set1_epi32(ZT__PRED_FREQUENCY));
    __m512i offset = _mm512_srli_epi32(entry, ZT__PRED_OFFSET_AT), count = _mm512_srli_epi32(*states, ZT__PRED_BITS);
    /* A product of 16 bits takes half the time, and with a larger count no word is wanted. */
    __mmask16 few = _mm512_cmple_epu32_mask(count, _mm512_set1_epi32(INT16_MAX));
    __mmask16 need = _mm512_mask_cmplt_epu32_mask(few, _mm512_dpwssd_epi32(offset, f, count),
                                                  _mm512_set1_epi32(ZT__PRED_LOW));
    __m512i state = _mm512_add_epi32(_mm512_mullo_epi32(f, count), offset);
    __m512i words = _mm512_cvtepu16_epi32(_mm256_loadu_si256((const void *)*next));
    state = _mm512_mask_slli_epi32(state, need, state, 16);
    *states = _mm512_or_si512(state, _mm512_maskz_expand_epi32(need, words));
    *next += 2 * (size_t)(uint32_t)__builtin_popcount(need);
    return entry;
}

/* First slots of the tables of step k of four: byte 16 k + i of the tables, times 8, becomes byte 1 of number i. */
AVX512 static inline __m512i first_slots(__m512i tables, int k) {
    const __m512i spread = _mm512_setr_epi32(0, 0x100, 0x200, 0x300, 0x400, 0x500, 0x600, 0x700, 0x800, 0x900, 0xA00,
                                             0xB00, 0xC00, 0xD00, 0xE00, 0xF00);
    return _mm512_maskz_permutexvar_epi8(UINT64_C(0x2222222222222222),
                                         _mm512_add_epi32(spread, _mm512_set1_epi32(k << 12)), tables);
}

/* The symbols of 4 x 16 entries as bytes, in order. */
AVX512 static inline __m512i symbols_of(__m512i a, __m512i b, __m512i c, __m512i d) {
    static const uint8_t in_order[64] = {0, 1, 8,  9,  16, 17, 24, 25, 32, 33, 40, 41, 48, 49, 56, 57,
                                         2, 3, 10, 11, 18, 19, 26, 27, 34, 35, 42, 43, 50, 51, 58, 59,
                                         4, 5, 12, 13, 20, 21, 28, 29, 36, 37, 44, 45, 52, 53, 60, 61,
                                         6, 7, 14, 15, 22, 23, 30, 31, 38, 39, 46, 47, 54, 55, 62, 63};
    /* Bits of a pair of entries where their symbols begin, for each byte that may become one of them. */
    const __m512i pair = _mm512_set1_epi16((32 + ZT__PRED_SYMBOL_AT) << 8 | ZT__PRED_SYMBOL_AT);
    __m512i v = _mm512_maskz_multishift_epi64_epi8(UINT64_C(0x0303030303030303), pair, a);
    v = _mm512_mask_multishift_epi64_epi8(v, UINT64_C(0x0C0C0C0C0C0C0C0C), pair, b);
    v = _mm512_mask_multishift_epi64_epi8(v, UINT64_C(0x3030303030303030), pair, c);
    v = _mm512_mask_multishift_epi64_epi8(v, UINT64_C(0xC0C0C0C0C0C0C0C0), pair, d);
    return _mm512_permutexvar_epi8(_mm512_loadu_si512(in_order), v);
}

/* As many samples of all 64 lanes as words are there for. Returns where it ends. No array of states, which compilers
 * would write to memory at each step. */
AVX512 static uint32_t symbols64(zt__pred_job *job, __m128i numbers, uint8_t *out, uint32_t x, uint32_t to) {
    const __m512i eights = _mm512_broadcast_i32x4(_mm_slli_epi16(numbers, 3));
    const uint8_t *next = job->next, *acts = job->acts;
    const uint32_t *slots = job->tables;
    uint32_t *states = job->states;
    __m512i s0 = _mm512_loadu_si512(states), s1 = _mm512_loadu_si512(states + 16);
    __m512i s2 = _mm512_loadu_si512(states + 32), s3 = _mm512_loadu_si512(states + 48);
    for (; to - x >= 64 && job->end - next >= 2 * ZT__PRED_REACH; x += 64) {
        __m512i tables = _mm512_shuffle_epi8(eights, _mm512_loadu_si512(acts + x));
        __m512i a = step16(slots, &s0, first_slots(tables, 0), &next);
        __m512i b = step16(slots, &s1, first_slots(tables, 1), &next);
        __m512i c = step16(slots, &s2, first_slots(tables, 2), &next);
        __m512i d = step16(slots, &s3, first_slots(tables, 3), &next);
        _mm512_storeu_si512(out + x, symbols_of(a, b, c, d));
    }
    _mm512_storeu_si512(states, s0);
    _mm512_storeu_si512(states + 16, s1);
    _mm512_storeu_si512(states + 32, s2);
    _mm512_storeu_si512(states + 48, s3);
    job->next = next;
    return x;
}

AVX512 static void symbols_avx512(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from,
                                  uint32_t to) {
    const __m128i numbers = _mm_loadu_si128((const void *)map->numbers);
    uint32_t mask = job->lanes - 1, x = job->lanes == 64 ? symbols64(job, numbers, out, from, to) : from;
    const uint8_t *next = job->next, *acts = job->acts;
    for (; to - x >= 16; x += 16) {
        next = zt__pred_words(job, next);
        if (!next)
            return;
        __m512i states = _mm512_loadu_si512(job->states + (x & mask));
        __m128i tables = _mm_shuffle_epi8(numbers, _mm_loadu_si128((const void *)(acts + x)));
        __m512i entry = step16(job->tables, &states, _mm512_slli_epi32(_mm512_cvtepu8_epi32(tables), ZT__PRED_BITS),
                               &next);
        _mm_storeu_si128((void *)(out + x), _mm512_cvtepi32_epi8(_mm512_srli_epi32(entry, ZT__PRED_SYMBOL_AT)));
        _mm512_storeu_si512(job->states + (x & mask), states);
    }
    job->next = next;
    if (next > job->end)
        zt__pred_words(job, next);
    else if (x < to)
        zt__pred_symbols_c(job, map, out, x, to);
}

const zt__pred_kernel *zt__pred_kernel_avx512(void) {
    static const zt__pred_kernel kernel = {"avx512",       select_avx512,         symbols_avx512,
                                           measure_avx512, zt__pred_restore_avx2, zt__pred_add_slopes_avx2};
    bool ok = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
              __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vbmi") &&
              __builtin_cpu_supports("avx512vnni") && zt__pred_kernel_avx2() != NULL;
    return ok ? &kernel : NULL;
}

#else

const zt__pred_kernel *zt__pred_kernel_avx512(void) {
    return NULL;
}

#endif
