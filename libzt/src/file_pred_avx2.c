/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops for AVX2 (file_pred.h). Whatever is left of a row goes to the loops in plain C. */
#include "file_pred_job.h"

#if (defined(__x86_64__) || defined(__i386__)) && (defined(__GNUC__) || defined(__clang__))

#include <immintrin.h>
#include <string.h>

#include "base_bytes.h"

#define AVX2 __attribute__((target("avx2,popcnt")))

AVX2 static inline __m256i load(const void *p) {
    return _mm256_loadu_si256(p);
}

AVX2 static inline void store(void *p, __m256i v) {
    _mm256_storeu_si256(p, v);
}

AVX2 static inline __m128i load_half(const void *p) {
    return _mm_loadu_si128(p);
}

/* Rows have margins: this reads and writes up to 31 bytes behind the width. */
AVX2 static void select_avx2(const uint8_t *above, const uint8_t *beside, const uint8_t *high, uint8_t *acts,
                             uint32_t width) {
    const __m256i most = _mm256_set1_epi8(high ? ZT__PRED_ACTS - 2 : ZT__PRED_ACTS - 1);
    const __m256i last = _mm256_set1_epi8(ZT__PRED_ACTS - 1);
    for (const uint8_t *end = above + width; above < end; above += 32, acts += 32) {
        __m256i act = _mm256_avg_epu8(load(above - 1), load(above + 1));
        act = _mm256_avg_epu8(act, load(above));
        if (beside) {
            act = _mm256_avg_epu8(act, load(beside));
            beside += 32;
        }
        act = _mm256_min_epu8(act, most);
        if (high) {
            __m256i zero = _mm256_cmpeq_epi8(load(high), _mm256_setzero_si256());
            act = _mm256_or_si256(act, _mm256_andnot_si256(zero, last));
            high += 32;
        }
        store(acts, act);
    }
}

AVX2 void zt__pred_measure_avx2(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width) {
    const __m256i lengths = _mm256_setr_epi8(0, 1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 0, 1, 2, 2, 3, 3, 3, 3, 4,
                                             4, 4, 4, 4, 4, 4, 4);
    const __m256i four = _mm256_set1_epi8(4), nibble = _mm256_set1_epi8(15), none = _mm256_setzero_si256();
    for (uint32_t x = 0; x < width; x += 32) {
        __m256i l = load(low + x);
        if (!high) {
            store(out + x, _mm256_abs_epi8(l));
            continue;
        }
        /* Per nibble; a length other than 0 outdoes all of the nibbles below. */
        __m256i n[4], h = load(high + x), length;
        n[0] = _mm256_shuffle_epi8(lengths, _mm256_and_si256(l, nibble));
        n[1] = _mm256_shuffle_epi8(lengths, _mm256_and_si256(_mm256_srli_epi16(l, 4), nibble));
        n[2] = _mm256_shuffle_epi8(lengths, _mm256_and_si256(h, nibble));
        n[3] = _mm256_shuffle_epi8(lengths, _mm256_and_si256(_mm256_srli_epi16(h, 4), nibble));
        length = n[0];
        __m256i base = none;
        for (int i = 1; i < 4; i++) {
            base = _mm256_add_epi8(base, four);
            length = _mm256_max_epu8(length,
                                     _mm256_andnot_si256(_mm256_cmpeq_epi8(n[i], none), _mm256_add_epi8(n[i], base)));
        }
        store(out + x, length);
    }
}

/* For each set of lanes that want a word: bytes of the next 8 words, each to its 32-bit lane; 128 gives a zero. */
#define BIT(m, i) ((m) >> (i)&1)
#define LOWER4(m, i) (BIT(m, 0) * ((i) > 0) + BIT(m, 1) * ((i) > 1) + BIT(m, 2) * ((i) > 2) + BIT(m, 3) * ((i) > 3))
#define LOWER(m, i) (LOWER4(m, i) + BIT(m, 4) * ((i) > 4) + BIT(m, 5) * ((i) > 5) + BIT(m, 6) * ((i) > 6))
#define WORD(m, i) BIT(m, i) ? 2 * LOWER(m, i) : 128, BIT(m, i) ? 2 * LOWER(m, i) + 1 : 128, 128, 128
#define SPREAD(m) \
    { WORD(m, 0), WORD(m, 1), WORD(m, 2), WORD(m, 3), WORD(m, 4), WORD(m, 5), WORD(m, 6), WORD(m, 7) }
#define SPREAD4(m) SPREAD(m), SPREAD((m) + 1), SPREAD((m) + 2), SPREAD((m) + 3)
#define SPREAD16(m) SPREAD4(m), SPREAD4((m) + 4), SPREAD4((m) + 8), SPREAD4((m) + 12)
#define SPREAD64(m) SPREAD16(m), SPREAD16((m) + 16), SPREAD16((m) + 32), SPREAD16((m) + 48)
static const uint8_t spread[256][32] = {SPREAD64(0), SPREAD64(64), SPREAD64(128), SPREAD64(192)};

/* Bytes 0 to 7 (half 0) or 8 to 15 of both halves, times 256, as 8 numbers: tables times 8 become first slots. */
AVX2 static inline __m256i widen(__m256i numbers, int half) {
    const __m256i order = _mm256_setr_epi8(-128, 0, -128, -128, -128, 1, -128, -128, -128, 2, -128, -128, -128, 3, -128,
                                           -128, -128, 4, -128, -128, -128, 5, -128, -128, -128, 6, -128, -128, -128, 7,
                                           -128, -128);
    return _mm256_shuffle_epi8(numbers, half ? _mm256_add_epi8(order, _mm256_set1_epi8(8)) : order);
}

/* One sample of 8 lanes. first: first slots of their tables. Returns the table entries. */
AVX2 static inline __m256i step8(const uint32_t *tables, uint32_t *states, __m256i first, const uint8_t **next) {
    __m256i state = load(states);
    const void *base = tables;
    __m256i slot = _mm256_and_si256(state, _mm256_set1_epi32(ZT__PRED_SLOTS - 1));
    __m256i entry = _mm256_i32gather_epi32(base, _mm256_or_si256(slot, first), 4);
    __m256i f = _mm256_and_si256(entry, _mm256_set1_epi32(ZT__PRED_FREQUENCY));
    state = _mm256_mullo_epi32(f, _mm256_srli_epi32(state, ZT__PRED_BITS));
    state = _mm256_add_epi32(state, _mm256_srli_epi32(entry, ZT__PRED_OFFSET_AT));
    __m256i need = _mm256_cmpgt_epi32(_mm256_set1_epi32(ZT__PRED_LOW), state);
    uint32_t lanes = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(need));
    __m256i words = _mm256_shuffle_epi8(_mm256_broadcastsi128_si256(load_half(*next)), load(spread[lanes]));
    state = _mm256_sllv_epi32(state, _mm256_and_si256(need, _mm256_set1_epi32(16)));
    store(states, _mm256_or_si256(state, words));
    *next += 2 * (size_t)(uint32_t)__builtin_popcount(lanes);
    return entry;
}

/* The symbols of 8 entries as numbers. */
AVX2 static inline __m256i symbols8(__m256i entry) {
    return _mm256_and_si256(_mm256_srli_epi32(entry, ZT__PRED_SYMBOL_AT), _mm256_set1_epi32(255));
}

/* Those of 4 x 8 entries as bytes, in order. */
AVX2 static inline __m256i symbols_of(__m256i a, __m256i b, __m256i c, __m256i d) {
    __m256i ab = _mm256_packus_epi32(symbols8(a), symbols8(b)), cd = _mm256_packus_epi32(symbols8(c), symbols8(d));
    return _mm256_permutevar8x32_epi32(_mm256_packus_epi16(ab, cd), _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
}

AVX2 static void symbols_avx2(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to) {
    const uint8_t *next = job->next, *acts = job->acts;
    const uint32_t *base = job->tables;
    uint32_t *states = job->states, mask = job->lanes - 1, x = from;
    const __m256i numbers = _mm256_slli_epi16(_mm256_broadcastsi128_si256(load_half(map->numbers)), 3);
    /* No call in this loop: the vectors would not stay in their registers. */
    for (; mask >= 31 && to - x >= 32 && job->end - next >= ZT__PRED_REACH; x += 32) {
        uint32_t *s = states + (x & mask);
        __m256i low = _mm256_shuffle_epi8(numbers, _mm256_broadcastsi128_si256(load_half(acts + x)));
        __m256i high = _mm256_shuffle_epi8(numbers, _mm256_broadcastsi128_si256(load_half(acts + x + 16)));
        __m256i a = step8(base, s, widen(low, 0), &next);
        __m256i b = step8(base, s + 8, widen(low, 1), &next);
        __m256i c = step8(base, s + 16, widen(high, 0), &next);
        __m256i d = step8(base, s + 24, widen(high, 1), &next);
        store(out + x, symbols_of(a, b, c, d));
    }
    for (; to - x >= 8; x += 8) {
        next = zt__pred_words(job, next);
        if (!next)
            return;
        __m128i act = _mm_loadl_epi64((const void *)(acts + x));
        __m256i first = _mm256_shuffle_epi8(numbers, _mm256_broadcastsi128_si256(act));
        __m256i entry = step8(base, states + (x & mask), widen(first, 0), &next);
        _mm_storel_epi64((void *)(out + x), _mm256_castsi256_si128(symbols_of(entry, entry, entry, entry)));
    }
    job->next = next;
    if (next > job->end)
        zt__pred_words(job, next);
    else if (x < to)
        zt__pred_symbols_c(job, map, out, x, to);
}

/* In a wave, row i is LAG columns behind the row above it: then what is above a texel is known a step early, and a step
 * waits for its left neighbour alone. */
enum { LAG = 2, WAVE = (ZT__PRED_STRIP - 1) * LAG };

/* Of 8 x 8 numbers whose rows i and i + 4 share registers: r[i] holds the first halves, r[i + 4] the second ones. Makes
 * columns. */
AVX2 static inline void transpose8(__m256i r[8]) {
    for (int i = 0; i < 8; i += 4) {
        __m256i a = _mm256_unpacklo_epi32(r[i], r[i + 1]), b = _mm256_unpacklo_epi32(r[i + 2], r[i + 3]);
        __m256i c = _mm256_unpackhi_epi32(r[i], r[i + 1]), d = _mm256_unpackhi_epi32(r[i + 2], r[i + 3]);
        r[i] = _mm256_unpacklo_epi64(a, b);
        r[i + 1] = _mm256_unpackhi_epi64(a, b);
        r[i + 2] = _mm256_unpacklo_epi64(c, d);
        r[i + 3] = _mm256_unpackhi_epi64(c, d);
    }
}

AVX2 static inline void transpose4(__m256i r[4]) {
    __m256i a = _mm256_unpacklo_epi64(r[0], r[1]), b = _mm256_unpackhi_epi64(r[0], r[1]);
    __m256i c = _mm256_unpacklo_epi64(r[2], r[3]), d = _mm256_unpackhi_epi64(r[2], r[3]);
    r[0] = _mm256_permute2x128_si256(a, c, 0x20);
    r[1] = _mm256_permute2x128_si256(b, d, 0x20);
    r[2] = _mm256_permute2x128_si256(a, c, 0x31);
    r[3] = _mm256_permute2x128_si256(b, d, 0x31);
}

/* A strip of 4-byte texels. */
typedef struct strip {
    uint8_t *texels; /* 8 rows, first of residuals */
    size_t pitch;
    const uint8_t *top; /* the row above */
    uint32_t width;
    __m256i green; /* for a shuffle: bytes that are added when a texel is finished */
    /* Steps of the wave from `from` to `to` - 1 finish texels and put them straight into rows at dst. */
    uint32_t from, to;
    uint8_t *dst;
    size_t dst_pitch;
} strip;

AVX2 static inline __m256i add_green(__m256i texels, __m256i green) {
    return _mm256_add_epi8(texels, _mm256_shuffle_epi8(texels, green));
}

/* One step of a wave for 8 columns of residuals, which become values: left is the values of the column before. */
AVX2 static inline void restore_columns(__m256i r[8], const uint8_t *top, __m256i *left, __m256i *above,
                                        __m256i *corner) {
    const __m256i down = _mm256_setr_epi32(7, 0, 1, 2, 3, 4, 5, 6);
    transpose8(r);
    for (uint32_t i = 0; i < 8; i++) {
        __m256i up = _mm256_blend_epi32(*above, load(top + (size_t)i * 4), 1);
        *above = _mm256_permutevar8x32_epi32(*left, down);
        __m256i sum = _mm256_add_epi8(_mm256_add_epi8(up, r[i]), *left);
        __m256i least = _mm256_min_epu8(*left, up), most = _mm256_max_epu8(*left, up);
        *left = _mm256_sub_epi8(sum, _mm256_min_epu8(_mm256_max_epu8(*corner, least), most));
        *corner = up;
        r[i] = *left;
    }
}

/* The 8 texels of row i and those of row i + 4, as transpose8 leaves them. */
AVX2 static inline void store_rows(uint8_t *row, uint8_t *lower, __m256i first, __m256i second) {
    _mm_storeu_si128((void *)row, _mm256_castsi256_si128(first));
    _mm_storeu_si128((void *)(row + 16), _mm256_castsi256_si128(second));
    _mm_storeu_si128((void *)lower, _mm256_extracti128_si256(first, 1));
    _mm_storeu_si128((void *)(lower + 16), _mm256_extracti128_si256(second, 1));
}

/* Residuals of 8 rows of 4-byte texels become values: row i is lane i, and a step goes one column on. Left of a row all
 * stays zero. */
AVX2 static void wave8(const strip *s) {
    const __m256i green = s->green;
    __m256i left = _mm256_setzero_si256(), corner = left, above = left;
    for (uint32_t x = 0; x < s->width + WAVE; x += 8) {
        __m256i r[8];
        uint8_t *from = s->texels + (size_t)x * 4, *to = s->dst + (size_t)x * 4;
        size_t pitch = s->pitch - 4 * LAG, dst_pitch = s->dst_pitch - 4 * LAG;
        for (uint32_t i = 0; i < 4; i++) {
            const uint8_t *row = from + i * pitch, *lower = row + 4 * pitch;
            r[i] = _mm256_inserti128_si256(_mm256_castsi128_si256(load_half(row)), load_half(lower), 1);
            r[i + 4] = _mm256_inserti128_si256(_mm256_castsi128_si256(load_half(row + 16)), load_half(lower + 16), 1);
        }
        restore_columns(r, s->top + (size_t)x * 4, &left, &above, &corner);
        transpose8(r);
        if (x < s->from || x >= s->to) {
            for (uint32_t i = 0; i < 4; i++)
                store_rows(from + i * pitch, from + (i + 4) * pitch, r[i], r[i + 4]);
            continue;
        }
        /* above the next strip */
        _mm_storeu_si128((void *)(from + 7 * pitch), _mm256_extracti128_si256(r[3], 1));
        _mm_storeu_si128((void *)(from + 7 * pitch + 16), _mm256_extracti128_si256(r[7], 1));
        for (uint32_t i = 0; i < 4; i++)
            store_rows(to + i * dst_pitch, to + (i + 4) * dst_pitch, add_green(r[i], green),
                       add_green(r[i + 4], green));
    }
}

/* 8 rows of 8 bytes, r[i] in the low half. */
AVX2 static inline void transpose_bytes(__m128i r[8]) {
    __m128i a[4], b[4], c[4];
    for (int i = 0; i < 4; i++)
        a[i] = _mm_unpacklo_epi8(r[2 * i], r[2 * i + 1]);
    for (int i = 0; i < 4; i += 2) {
        b[i] = _mm_unpacklo_epi16(a[i], a[i + 1]);
        b[i + 1] = _mm_unpackhi_epi16(a[i], a[i + 1]);
    }
    for (int i = 0; i < 2; i++) {
        c[2 * i] = _mm_unpacklo_epi32(b[i], b[i + 2]);
        c[2 * i + 1] = _mm_unpackhi_epi32(b[i], b[i + 2]);
    }
    for (int i = 0; i < 4; i++) {
        r[2 * i] = c[i];
        r[2 * i + 1] = _mm_unpackhi_epi64(c[i], c[i]);
    }
}

/* The same for the one byte plane of a tile with one channel. */
AVX2 static void wave1(uint8_t *texels, size_t pitch, const uint8_t *top, uint32_t width) {
    __m128i left = _mm_setzero_si128(), corner = left, above = left;
    for (uint32_t x = 0; x < width + WAVE; x += 8) {
        __m128i r[8];
        uint8_t *at[8];
        for (uint32_t i = 0; i < 8; i++) {
            at[i] = texels + i * pitch + x - (size_t)i * LAG;
            r[i] = _mm_loadl_epi64((const void *)at[i]);
        }
        transpose_bytes(r);
        for (uint32_t i = 0; i < 8; i++) {
            __m128i up = _mm_or_si128(above, _mm_cvtsi32_si128(top[x + i]));
            above = _mm_slli_si128(left, 1);
            __m128i sum = _mm_add_epi8(_mm_add_epi8(left, r[i]), up);
            __m128i least = _mm_min_epu8(left, up), most = _mm_max_epu8(left, up);
            left = _mm_sub_epi8(sum, _mm_min_epu8(_mm_max_epu8(corner, least), most));
            corner = up;
            r[i] = left;
        }
        transpose_bytes(r);
        for (int i = 0; i < 8; i++)
            _mm_storel_epi64((void *)at[i], r[i]);
    }
}

/* The same for 8-byte texels: the upper 4 rows in one register, the lower 4 in another. */
AVX2 static void wave16(uint8_t *texels, size_t pitch, const uint8_t *top, uint32_t width) {
    __m256i left[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()}, corner[2] = {left[0], left[0]};
    __m256i above[2] = {left[0], left[0]};
    for (uint32_t x = 0; x < width + WAVE; x += 4) {
        __m256i r[8], up[2];
        uint8_t *at[8];
        for (uint32_t i = 0; i < 8; i++) {
            at[i] = texels + i * pitch + (size_t)x * 8 - (size_t)i * (8 * LAG);
            r[i] = load(at[i]);
        }
        transpose4(r);
        transpose4(r + 4);
        for (uint32_t i = 0; i < 4; i++) {
            __m256i first = _mm256_castsi128_si256(_mm_loadl_epi64((const void *)(top + (size_t)(x + i) * 8)));
            up[0] = _mm256_blend_epi32(above[0], first, 3);
            up[1] = above[1];
            above[0] = _mm256_permute4x64_epi64(left[0], 0x90);
            above[1] = _mm256_blend_epi32(_mm256_permute4x64_epi64(left[1], 0x90),
                                          _mm256_permute4x64_epi64(left[0], 0xFF), 3);
            for (int h = 0; h < 2; h++) {
                __m256i sum = _mm256_add_epi16(_mm256_add_epi16(left[h], r[i + 4 * (uint32_t)h]), up[h]);
                __m256i least = _mm256_min_epu16(left[h], up[h]), most = _mm256_max_epu16(left[h], up[h]);
                left[h] = _mm256_sub_epi16(sum, _mm256_min_epu16(_mm256_max_epu16(corner[h], least), most));
                corner[h] = up[h];
                r[i + 4 * (uint32_t)h] = left[h];
            }
        }
        transpose4(r);
        transpose4(r + 4);
        for (int i = 0; i < 8; i++)
            store(at[i], r[i]);
    }
}

/* Rows of the bytes of R, G, B, A, those that the tile does not have being zero; of 2-byte channels the high bytes. */
static void channel_rows(const zt__pred_job *job, uint32_t row, const uint8_t *rows[4], const uint8_t *lows[4]) {
    uint32_t bytes = job->shape.channel_bytes;
    for (uint32_t c = 0; c < 4; c++)
        rows[c] = lows[c] = job->none;
    for (uint32_t j = 0; j < job->shape.channels; j++) {
        uint32_t c = zt__pred_channel(job->shape.channels, j);
        rows[c] = job->residuals[j * bytes] + row * job->pitch;
        lows[c] = job->residuals[(j + 1) * bytes - 1] + row * job->pitch;
    }
}

/* A row of residuals as texels of 4 channels. */
AVX2 static void interleave8(const zt__pred_job *job, uint32_t row, uint8_t *texels) {
    const uint8_t *rows[4], *lows[4];
    channel_rows(job, row, rows, lows);
    for (uint32_t x = 0; x < job->shape.width; x += 32) {
        __m256i r = load(rows[0] + x), g = load(rows[1] + x), b = load(rows[2] + x), a = load(rows[3] + x);
        __m256i rg[2] = {_mm256_unpacklo_epi8(r, g), _mm256_unpackhi_epi8(r, g)};
        __m256i ba[2] = {_mm256_unpacklo_epi8(b, a), _mm256_unpackhi_epi8(b, a)};
        __m256i t[4];
        for (int i = 0; i < 2; i++) {
            t[2 * i] = _mm256_unpacklo_epi16(rg[i], ba[i]);
            t[2 * i + 1] = _mm256_unpackhi_epi16(rg[i], ba[i]);
        }
        uint8_t *at = texels + (size_t)x * 4;
        store(at, _mm256_permute2x128_si256(t[0], t[1], 0x20));
        store(at + 32, _mm256_permute2x128_si256(t[2], t[3], 0x20));
        store(at + 64, _mm256_permute2x128_si256(t[0], t[1], 0x31));
        store(at + 96, _mm256_permute2x128_si256(t[2], t[3], 0x31));
    }
}

/* 16 residuals from their two bytes. */
AVX2 static inline __m256i join(const uint8_t *high, const uint8_t *low) {
    __m256i z = _mm256_or_si256(_mm256_slli_epi16(_mm256_cvtepu8_epi16(load_half(high)), 8),
                                _mm256_cvtepu8_epi16(load_half(low)));
    __m256i sign = _mm256_sub_epi16(_mm256_setzero_si256(), _mm256_and_si256(z, _mm256_set1_epi16(1)));
    return _mm256_xor_si256(_mm256_srli_epi16(z, 1), sign);
}

AVX2 static void interleave16(const zt__pred_job *job, uint32_t row, uint8_t *texels) {
    const uint8_t *highs[4], *lows[4];
    channel_rows(job, row, highs, lows);
    for (uint32_t x = 0; x < job->shape.width; x += 16) {
        __m256i r = join(highs[0] + x, lows[0] + x), g = join(highs[1] + x, lows[1] + x);
        __m256i b = join(highs[2] + x, lows[2] + x), a = join(highs[3] + x, lows[3] + x);
        __m256i rg[2] = {_mm256_unpacklo_epi16(r, g), _mm256_unpackhi_epi16(r, g)};
        __m256i ba[2] = {_mm256_unpacklo_epi16(b, a), _mm256_unpackhi_epi16(b, a)};
        __m256i t[4];
        for (int i = 0; i < 2; i++) {
            t[2 * i] = _mm256_unpacklo_epi32(rg[i], ba[i]);
            t[2 * i + 1] = _mm256_unpackhi_epi32(rg[i], ba[i]);
        }
        uint8_t *at = texels + (size_t)x * 8;
        store(at, _mm256_permute2x128_si256(t[0], t[1], 0x20));
        store(at + 32, _mm256_permute2x128_si256(t[2], t[3], 0x20));
        store(at + 64, _mm256_permute2x128_si256(t[0], t[1], 0x31));
        store(at + 96, _mm256_permute2x128_si256(t[2], t[3], 0x31));
    }
}

/* A row of texels of 4 bytes to 2 to 4 bytes, with green added where colours are to be restored. */
AVX2 static void finish8(const zt__pred_job *job, __m256i green, const uint8_t *texels, uint8_t *dst) {
    uint32_t n = job->shape.channels, width = job->shape.width, x = 0;
    const __m256i pack3 = _mm256_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -128, -128, -128, -128, 0, 1, 2, 4,
                                           5, 6, 8, 9, 10, 12, 13, 14, -128, -128, -128, -128);
    const __m256i pack2 = _mm256_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 0, 1, 4, 5, 8, 9, 12, 13, 0, 1, 4, 5, 8, 9, 12, 13,
                                           0, 1, 4, 5, 8, 9, 12, 13);
    for (; width - x >= 8; x += 8) {
        __m256i v = add_green(load(texels + (size_t)x * 4), green);
        uint8_t *at = dst + (size_t)x * n;
        if (n == 4) {
            store(at, v);
        } else if (n == 3) {
            if (width - x < 10) /* the second half writes 4 bytes too many */
                break;
            v = _mm256_shuffle_epi8(v, pack3);
            _mm_storeu_si128((void *)at, _mm256_castsi256_si128(v));
            _mm_storeu_si128((void *)(at + 12), _mm256_extracti128_si256(v, 1));
        } else {
            v = _mm256_permute4x64_epi64(_mm256_shuffle_epi8(v, pack2), 0x08);
            _mm_storeu_si128((void *)at, _mm256_castsi256_si128(v));
        }
    }
    for (; x < width; x++) {
        const uint8_t *v = texels + (size_t)x * 4;
        for (uint32_t c = 0; c < n; c++)
            dst[(size_t)x * n + c] = (uint8_t)(v[c] + (job->colour && (c == 0 || c == 2) ? v[1] : 0));
    }
}

/* Columns x to end - 1, at least 8, of a row of texels of 4 channels. */
AVX2 static void finish_columns(const strip *s, uint32_t row, uint32_t x, uint32_t end) {
    const uint8_t *from = s->texels + row * s->pitch;
    uint8_t *to = s->dst + row * s->dst_pitch;
    for (; x < end; x += 8) {
        size_t at = 4 * (size_t)(end - x < 8 ? end - 8 : x);
        store(to + at, add_green(load(from + at), s->green));
    }
}

AVX2 static void finish16(const zt__pred_job *job, const uint8_t *texels, uint8_t *dst) {
    uint32_t n = job->shape.channels, width = job->shape.width, x = 0;
    const int8_t none = job->colour ? 0 : -128;
    const __m256i green = _mm256_or_si256(_mm256_setr_epi8(2, 3, -128, -128, 2, 3, -128, -128, 10, 11, -128, -128, 10,
                                                           11, -128, -128, 2, 3, -128, -128, 2, 3, -128, -128, 10, 11,
                                                           -128, -128, 10, 11, -128, -128),
                                          _mm256_set1_epi8(none));
    for (; n == 4 && width - x >= 4; x += 4) {
        __m256i v = load(texels + (size_t)x * 8);
        store(dst + (size_t)x * 8, _mm256_add_epi16(v, _mm256_shuffle_epi8(v, green)));
    }
    for (; x < width; x++)
        for (uint32_t c = 0; c < n; c++) {
            const uint8_t *v = texels + (size_t)x * 8;
            uint32_t more = job->colour && (c == 0 || c == 2) ? zt__load16(v + 2) : 0;
            zt__store16(dst + 2 * ((size_t)x * n + c), (uint16_t)(zt__load16(v + 2 * c) + more));
        }
}

/* A strip with fewer than 8 rows is restored as one of 8, the rest being whatever was there. */
AVX2 static void restore8(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    const int8_t none = job->colour ? 0 : -128;
    const __m256i green = _mm256_setr_epi8(1, -128, 1, -128, 5, -128, 5, -128, 9, -128, 9, -128, 13, -128, 13, -128, 1,
                                           -128, 1, -128, 5, -128, 5, -128, 9, -128, 9, -128, 13, -128, 13, -128);
    strip s = {job->texels, job->texel_pitch, job->top, job->shape.width, green, 0, 0, dst, dst_pitch};
    s.green = _mm256_or_si256(green, _mm256_set1_epi8(none));
    bool straight = job->shape.channels == 4 && rows == ZT__PRED_STRIP && s.width >= 64;
    if (straight) { /* 8 columns at each end of each row are left, so that no vector goes beyond them */
        s.from = (WAVE + 8 + 7) & ~7u;
        s.to = (s.width - 8) & ~7u;
    }
    for (uint32_t i = 0; i < rows; i++)
        interleave8(job, i, s.texels + i * s.pitch);
    wave8(&s);
    for (uint32_t i = 0; i < rows; i++) {
        if (straight) {
            finish_columns(&s, i, 0, s.from - LAG * i);
            finish_columns(&s, i, s.to - LAG * i, s.width);
        } else {
            finish8(job, s.green, s.texels + i * s.pitch, dst + i * dst_pitch);
        }
    }
    memcpy(job->top, s.texels + (ZT__PRED_STRIP - 1) * s.pitch, (size_t)s.width * 4);
}

static void restore_one(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    size_t width = job->shape.width;
    for (uint32_t i = 0; i < rows; i++)
        memcpy(job->texels + i * job->texel_pitch, job->residuals[0] + i * job->pitch, width);
    wave1(job->texels, job->texel_pitch, job->top, job->shape.width);
    for (uint32_t i = 0; i < rows; i++)
        memcpy(dst + i * dst_pitch, job->texels + i * job->texel_pitch, width);
    memcpy(job->top, job->texels + (ZT__PRED_STRIP - 1) * job->texel_pitch, width);
}

AVX2 void zt__pred_restore_avx2(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    if (job->planes == 1) {
        restore_one(job, rows, dst, dst_pitch);
        return;
    }
    if (job->shape.channel_bytes == 1) {
        restore8(job, rows, dst, dst_pitch);
        return;
    }
    for (uint32_t i = 0; i < rows; i++)
        interleave16(job, i, job->texels + i * job->texel_pitch);
    wave16(job->texels, job->texel_pitch, job->top, job->shape.width);
    for (uint32_t i = 0; i < rows; i++)
        finish16(job, job->texels + i * job->texel_pitch, dst + i * dst_pitch);
    memcpy(job->top, job->texels + (ZT__PRED_STRIP - 1) * job->texel_pitch, (size_t)job->shape.width * 8);
}

/* What comes to the third byte of 8 texels of 4 bytes. A float holds s exactly, and the root of a whole number that is
 * no square is further from the next whole number than a float errs: what is cut off is right in every rounding
 * mode. */
AVX2 static inline __m256i slopes8(__m256i texels) {
    const __m256i order = _mm256_setr_epi8(0, -128, 1, -128, 4, -128, 5, -128, 8, -128, 9, -128, 12, -128, 13, -128, 0,
                                           -128, 1, -128, 4, -128, 5, -128, 8, -128, 9, -128, 12, -128, 13, -128);
    __m256i xy = _mm256_slli_epi16(_mm256_shuffle_epi8(texels, order), 1);
    xy = _mm256_sub_epi16(xy, _mm256_set1_epi16(255));
    __m256i s = _mm256_sub_epi32(_mm256_set1_epi32(255 * 255), _mm256_madd_epi16(xy, xy));
    s = _mm256_max_epi32(s, _mm256_setzero_si256());
    __m256i root = _mm256_cvttps_epi32(_mm256_sqrt_ps(_mm256_cvtepi32_ps(s)));
    return _mm256_slli_epi32(_mm256_srli_epi32(_mm256_add_epi32(root, _mm256_set1_epi32(256)), 1), 16);
}

/* 8 texels of 4 bytes; or of 3, of 28 bytes that may be read. */
AVX2 static inline void add_slopes8(uint8_t *texels, uint32_t channels) {
    const __m256i pack3 = _mm256_setr_epi8(-128, -128, 2, -128, -128, 6, -128, -128, 10, -128, -128, 14, -128, -128,
                                           -128, -128, -128, -128, 2, -128, -128, 6, -128, -128, 10, -128, -128, 14,
                                           -128, -128, -128, -128);
    const __m256i spread3 = _mm256_setr_epi8(0, 1, 2, -128, 3, 4, 5, -128, 6, 7, 8, -128, 9, 10, 11, -128, 0, 1, 2,
                                             -128, 3, 4, 5, -128, 6, 7, 8, -128, 9, 10, 11, -128);
    if (channels == 4) {
        __m256i v = load(texels);
        store(texels, _mm256_add_epi8(v, slopes8(v)));
        return;
    }
    __m256i v = _mm256_inserti128_si256(_mm256_castsi128_si256(load_half(texels)), load_half(texels + 12), 1);
    v = _mm256_add_epi8(v, _mm256_shuffle_epi8(slopes8(_mm256_shuffle_epi8(v, spread3)), pack3));
    for (int i = 0; i < 2; i++) { /* no byte that the next step loads: that would have to wait */
        __m128i half = i ? _mm256_extracti128_si256(v, 1) : _mm256_castsi256_si128(v);
        _mm_storel_epi64((void *)(texels + 12 * i), half);
        _mm_storeu_si32(texels + 12 * i + 8, _mm_unpackhi_epi64(half, half));
    }
}

AVX2 void zt__pred_add_slopes_avx2(uint8_t *texels, uint32_t channels, uint32_t width) {
    uint8_t rest[32] = {0};
    uint32_t x = 0, n = channels == 3 ? 10 : 8; /* as many have the bytes that are read */
    for (; width - x >= n; x += 8, texels += 8 * (size_t)channels)
        add_slopes8(texels, channels);
    while (x < width) {
        uint32_t some = width - x < 8 ? width - x : 8;
        memcpy(rest, texels, (size_t)some * channels);
        add_slopes8(rest, channels);
        memcpy(texels, rest, (size_t)some * channels);
        x += some;
        texels += (size_t)some * channels;
    }
}

const zt__pred_kernel *zt__pred_kernel_avx2(void) {
    static const zt__pred_kernel kernel = {
        "avx2", select_avx2, symbols_avx2, zt__pred_measure_avx2, zt__pred_restore_avx2, zt__pred_add_slopes_avx2};
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt") ? &kernel : NULL;
}

#else

const zt__pred_kernel *zt__pred_kernel_avx2(void) {
    return NULL;
}

#endif
