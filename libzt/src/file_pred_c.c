/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops in plain C (file_pred.h): the reference of the vector paths. No branch depends on a sample. */
#include "file_pred_frame.h"

#include <string.h>

#include "base_bytes.h"

/* Vectors are made of loops; GCC unrolls short ones before it looks. */
#if defined(__clang__)
#define KEEP_LOOP _Pragma("clang loop unroll(disable)")
#elif defined(__GNUC__)
#define KEEP_LOOP _Pragma("GCC unroll 1")
#else
#define KEEP_LOOP
#endif

/* For functions that are fast where their counts are constants: clang would not make one of each count. */
#if defined(__GNUC__)
#define INLINED static inline __attribute__((always_inline))
#else
#define INLINED static inline
#endif

static inline uint8_t average(uint8_t a, uint8_t b) {
    return (uint8_t)((a + b + 1) >> 1);
}

void zt__pred_select_c(const uint8_t *above, const uint8_t *beside, const uint8_t *high, uint8_t *restrict acts,
                       uint32_t width) {
    const uint8_t *before = above - 1, *behind = above + 1;
    for (uint32_t x = 0; x < width; x++)
        acts[x] = average(average(before[x], behind[x]), above[x]);
    for (uint32_t x = 0; beside && x < width; x++)
        acts[x] = average(acts[x], beside[x]);
    uint8_t most = high ? ZT__PRED_ACTS - 2 : ZT__PRED_ACTS - 1;
    for (uint32_t x = 0; x < width; x++)
        acts[x] = acts[x] < most ? acts[x] : most;
    for (uint32_t x = 0; high && x < width; x++)
        acts[x] = high[x] ? ZT__PRED_ACTS - 1 : acts[x];
}

/* The state behind a sample, from the one before and its table entry. It wants a word when it is below
 * ZT__PRED_LOW. */
static inline uint32_t advance(uint32_t entry, uint32_t state) {
    return (entry & ZT__PRED_FREQUENCY) * (state >> ZT__PRED_BITS) + (entry >> ZT__PRED_OFFSET_AT);
}

enum { GROUP = 16 }; /* lanes that are decoded together: there are as many at least */

/* One sample of each lane of a group, in loops that compilers make vectors of, but for those that look something up.
 * Reads 2 x GROUP bytes of words. Returns where the next ones are. */
static inline const uint8_t *step_group(const uint32_t *const *tables, const uint8_t *restrict acts,
                                        uint32_t *restrict states, uint8_t *restrict out, const uint8_t *next) {
    uint32_t entries[GROUP];
    uint16_t words[GROUP];
    for (uint32_t i = 0; i < GROUP; i++)
        entries[i] = tables[acts[i]][states[i] & (ZT__PRED_SLOTS - 1)];
    KEEP_LOOP
    for (uint32_t i = 0; i < GROUP; i++)
        states[i] = advance(entries[i], states[i]);
    KEEP_LOOP
    for (uint32_t i = 0; i < GROUP; i++)
        out[i] = (uint8_t)(entries[i] >> ZT__PRED_SYMBOL_AT);
    for (uint32_t i = 0; i < GROUP; i++) { /* a sign, not a comparison: of those compilers make branches */
        words[i] = zt__load16(next);
        next += (states[i] - ZT__PRED_LOW) >> 31 << 1;
    }
    KEEP_LOOP
    for (uint32_t i = 0; i < GROUP; i++) {
        uint32_t v = states[i], more = v << 16 | words[i];
        states[i] = v < ZT__PRED_LOW ? more : v;
    }
    return next;
}

/* Ends of rows, and whatever is left of the words. */
static void symbols_at_end(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to) {
    for (uint32_t x = from; x < to; x++) {
        uint32_t *state = job->states + (x & (job->lanes - 1));
        uint32_t entry = map->tables[job->acts[x]][*state & (ZT__PRED_SLOTS - 1)], v = advance(entry, *state);
        bool wanted = v < ZT__PRED_LOW, there = job->next != job->end;
        out[x] = (uint8_t)(entry >> ZT__PRED_SYMBOL_AT);
        job->exhausted |= wanted && !there;
        *state = !wanted ? v : there ? v << 16 | zt__load16(job->next) : ZT__PRED_LOW;
        job->next += wanted && there ? 2 : 0;
    }
}

void zt__pred_symbols_c(zt__pred_job *job, const zt__pred_map *map, uint8_t *restrict out, uint32_t from, uint32_t to) {
    const uint8_t *next = job->next, *end = job->end;
    uint32_t x = from, mask = job->lanes - 1;
    for (; to - x >= GROUP && end - next >= 2 * GROUP; x += GROUP) /* x is the first lane of a group */
        next = step_group(map->tables, job->acts + x, job->states + (x & mask), out + x, next);
    job->next = next;
    symbols_at_end(job, map, out, x, to);
}

bool zt__pred_words_left(zt__pred_job *job, const uint8_t **next) {
    if (*next > job->end) {
        job->exhausted = true;
        job->next = job->end;
        return false;
    }
    if (job->end == job->tail_end)
        return true;
    size_t n = (size_t)(job->end - *next);
    memcpy(job->tail, *next, n);
    memset(job->tail + n, 0, 2 * ZT__PRED_REACH - n);
    *next = job->next = job->tail;
    job->end = job->tail_end = job->tail + n;
    return true;
}

static inline uint8_t bit_length(uint8_t v) {
    return (uint8_t)((v > 0) + (v > 1) + (v > 3) + (v > 7) + (v > 15) + (v > 31) + (v > 63) + (v > 127));
}

void zt__pred_measure_c(const uint8_t *high, const uint8_t *low, uint8_t *restrict out, uint32_t width) {
    for (uint32_t x = 0; !high && x < width; x++)
        out[x] = (uint8_t)(low[x] < 128 ? low[x] : 256 - low[x]);
    for (uint32_t x = 0; high && x < width; x++) {
        uint8_t upper = high[x], lower = low[x];
        out[x] = (uint8_t)(bit_length(upper ? upper : lower) + (upper ? 8 : 0));
    }
}

/* Texels are restored in a field of steps. Row i of the strip is LAG columns behind the row above it: its column x is
 * in slot i + 1 of step x + LAG x i, and that of the row above the strip in slot 0 of step x - LAG. So what a texel is
 * predicted from is in the steps before: to the left one step, above LAG, above to the left LAG + 1. All slots of a
 * step can be restored at once, and compilers make vectors of that. What is above was stored with other bounds than it
 * is loaded with, so it must have left the processor's store buffer: with fewer steps than 4 that is waited for. */
enum { LAG = 4, SLOTS = ZT__PRED_STRIP + 1, BEFORE = LAG + 1, BEHIND = LAG * (ZT__PRED_STRIP - 1) };

/* The field is in the scratch memory for rows of texels (zt__pred_scratch_size). */
_Static_assert((BEFORE + BEHIND) * SLOTS * 8 <= (ZT__PRED_STRIP + 1) * 5 * ZT__PRED_MARGIN - ZT__PRED_MARGIN,
               "a field of steps of 8-byte texels fits");

/* Where column 0 of row i begins, in texels; the next one is SLOTS behind. Row -1 is the one above the strip. */
static inline size_t place_of(uint32_t i) {
    return (BEFORE + (size_t)LAG * i) * SLOTS + i + 1;
}

/* Residuals in the field become values. n: numbers in a texel, a constant where this is inlined. */
#define RESTORE(name, type)                                                                                 \
    INLINED void name##_step(type *restrict slots, const type *restrict lefts, const type *restrict aboves, \
                             const type *restrict corners, uint32_t n) {                                    \
        KEEP_LOOP                                                                                           \
        for (uint32_t i = 0; i < ZT__PRED_STRIP * n; i++) {                                                 \
            type left = lefts[i], above = aboves[i], corner = corners[i];                                   \
            type least = left < above ? left : above, most = left < above ? above : left;                   \
            corner = corner < least ? least : corner;                                                       \
            corner = corner > most ? most : corner;                                                         \
            slots[i] = (type)(slots[i] + left + above - corner);                                            \
        }                                                                                                   \
    }                                                                                                       \
    INLINED void name(type *field, uint32_t n, uint32_t width) {                                            \
        const size_t step = (size_t)SLOTS * n;                                                              \
        type *at = field + BEFORE * step;                                                                   \
        for (uint32_t x = 0; x < width + BEHIND; x++, at += step)                                           \
            name##_step(at + n, at + n - step, at - LAG * step, at - (LAG + 1) * step, n);                  \
    }
RESTORE(restore_steps8, uint8_t)
RESTORE(restore_steps16, uint16_t)

/* Copies count texels, which are to_step and from_step bytes apart. size: of a texel, a constant where this is
 * inlined. */
INLINED void copy_texels(void *restrict to, size_t to_step, const void *restrict from, size_t from_step, size_t size,
                         uint32_t count) {
    uint8_t *out = to;
    const uint8_t *in = from;
    for (uint32_t x = 0; x < count; x++, out += to_step, in += from_step)
        memcpy(out, in, size);
}

/* The last row of a strip becomes the one above the next, and left of all rows there are zeros. */
INLINED void next_strip(uint8_t *field, size_t texel_bytes, uint32_t width) {
    const size_t step = SLOTS * texel_bytes;
    copy_texels(field + step, step, field + place_of(ZT__PRED_STRIP - 1) * texel_bytes, step, texel_bytes, width);
    for (size_t i = 0; i < BEFORE + BEHIND; i++) {
        bool first = i < BEFORE - LAG; /* no row has begun */
        memset(field + i * step + (first ? 0 : texel_bytes), 0, step - (first ? 0 : texel_bytes));
    }
}

/* The rows of residuals of each channel in memory; the high bytes of 2-byte channels. lows: the low ones. */
static void channel_rows(const zt__pred_job *job, uint32_t i, const uint8_t *highs[4], const uint8_t *lows[4]) {
    uint32_t bytes = job->shape.channel_bytes;
    for (uint32_t c = 0; c < 4; c++)
        highs[c] = lows[c] = job->none;
    for (uint32_t j = 0; j < job->shape.channels; j++) {
        uint32_t c = zt__pred_channel(job->shape.channels, j);
        highs[c] = job->residuals[j * bytes] + i * job->pitch;
        lows[c] = job->residuals[(j + 1) * bytes - 1] + i * job->pitch;
    }
}

/* Residuals go into the field by way of so many texels in a row, which vectors make. */
enum { PART = 64 };

INLINED void interleave8(const uint8_t *const rows[4], uint32_t from, uint32_t n, uint8_t *restrict out) {
    const uint8_t *a = rows[0] + from, *b = rows[1] + from, *c = rows[2] + from, *d = rows[3] + from;
    for (uint32_t x = 0; n == 2 && x < PART; x++) {
        out[2 * x] = a[x];
        out[2 * x + 1] = b[x];
    }
    for (uint32_t x = 0; n == 4 && x < PART; x++) {
        out[4 * x] = a[x];
        out[4 * x + 1] = b[x];
        out[4 * x + 2] = c[x];
        out[4 * x + 3] = d[x];
    }
}

static inline uint16_t number16(const uint8_t *const highs[4], const uint8_t *const lows[4], uint32_t c, uint32_t x) {
    uint16_t z = (uint16_t)(highs[c][x] << 8 | lows[c][x]);
    return (uint16_t)(z >> 1 ^ (0 - (z & 1)));
}

INLINED void interleave16(const uint8_t *const highs[4], const uint8_t *const lows[4], uint32_t from, uint32_t n,
                          uint16_t *restrict out) {
    for (uint32_t x = 0; x < PART; x++) {
        out[n * x] = number16(highs, lows, 0, from + x);
        if (n > 1)
            out[n * x + 1] = number16(highs, lows, 1, from + x);
        if (n > 2) {
            out[n * x + 2] = number16(highs, lows, 2, from + x);
            out[n * x + 3] = number16(highs, lows, 3, from + x);
        }
    }
}

/* Copies count texels of n numbers, which become little-endian. */
INLINED void put_numbers(uint8_t *restrict to, const uint16_t *restrict from, size_t from_step, size_t n,
                         uint32_t count) {
    for (uint32_t x = 0; x < count; x++, to += 2 * n, from += from_step)
        for (size_t i = 0; i < n; i++)
            zt__store16(to + 2 * i, from[i]);
}

/* n: channels in the field, a constant where this is inlined. A part may be read that is behind the width: rows have
 * margins. */
INLINED void restore8(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch, uint32_t n) {
    const uint32_t width = job->shape.width;
    const size_t step = (size_t)SLOTS * n;
    uint8_t part[4 * PART];
    next_strip(job->texels, n, width);
    for (uint32_t i = 0; i < ZT__PRED_STRIP; i++) {
        const uint8_t *row[4], *same[4];
        uint8_t *slot = job->texels + place_of(i) * n;
        channel_rows(job, i, row, same);
        for (uint32_t x = 0; n > 1 && x < width; x += PART) {
            interleave8(row, x, n, part);
            copy_texels(slot + x * step, step, part, n, n, zt__min32(PART, width - x));
        }
        if (n == 1)
            copy_texels(slot, step, row[0], 1, 1, width);
    }
    restore_steps8(job->texels, n, width);
    for (uint32_t i = 0; i < rows; i++, dst += dst_pitch) {
        const uint8_t *slot = job->texels + place_of(i) * n;
        if (job->shape.channels == 3)
            copy_texels(dst, 3, slot, step, 3, width);
        else
            copy_texels(dst, n, slot, step, n, width);
        if (job->colour)
            zt__pred_add_green(&job->shape, dst);
    }
}

INLINED void restore16(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch, uint32_t n) {
    const uint32_t width = job->shape.width;
    const size_t size = 2 * (size_t)n, step = (size_t)SLOTS * n;
    uint16_t part[4 * PART];
    void *texels = job->texels; /* aligned for any number */
    uint16_t *field = texels;
    next_strip(texels, size, width);
    for (uint32_t i = 0; i < ZT__PRED_STRIP; i++) {
        const uint8_t *highs[4], *lows[4];
        uint16_t *slot = field + place_of(i) * n;
        channel_rows(job, i, highs, lows);
        for (uint32_t x = 0; x < width; x += PART) {
            interleave16(highs, lows, x, n, part);
            copy_texels(slot + x * step, 2 * step, part, size, size, zt__min32(PART, width - x));
        }
    }
    restore_steps16(field, n, width);
    for (uint32_t i = 0; i < rows; i++, dst += dst_pitch) {
        const uint16_t *slot = field + place_of(i) * n;
        if (job->shape.channels == 3)
            put_numbers(dst, slot, step, 3, width);
        else
            put_numbers(dst, slot, step, n, width);
        if (job->colour)
            zt__pred_add_green(&job->shape, dst);
    }
}

void zt__pred_restore_c(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    bool wide = job->shape.channel_bytes == 2;
    switch (job->shape.channels) {
    case 1:
        wide ? restore16(job, rows, dst, dst_pitch, 1) : restore8(job, rows, dst, dst_pitch, 1);
        break;
    case 2:
        wide ? restore16(job, rows, dst, dst_pitch, 2) : restore8(job, rows, dst, dst_pitch, 2);
        break;
    default:
        wide ? restore16(job, rows, dst, dst_pitch, 4) : restore8(job, rows, dst, dst_pitch, 4);
    }
}

const zt__pred_kernel *zt__pred_kernel_c(void) {
    static const zt__pred_kernel kernel = {
        "c", zt__pred_select_c, zt__pred_symbols_c, zt__pred_measure_c, zt__pred_restore_c, NULL};
    return &kernel;
}
