/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops in plain C (file_pred.h): the reference of the vector paths. No branch depends on a sample. */
#include "file_pred_job.h"

#include <string.h>

#include "base_bytes.h"

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

/* Decodes one sample. Returns the state, which wants a word when it is below ZT__PRED_LOW. */
static inline uint32_t step(const uint32_t *table, uint32_t state, uint8_t *out) {
    uint32_t e = table[state & (ZT__PRED_SLOTS - 1)];
    *out = (uint8_t)(e >> ZT__PRED_SYMBOL_AT);
    return (e & ZT__PRED_FREQUENCY) * (state >> ZT__PRED_BITS) + (e >> ZT__PRED_OFFSET_AT);
}

/* The same with the word. */
static inline const uint8_t *step_word(const uint32_t *table, uint32_t *state, uint8_t *out, const uint8_t *next) {
    uint32_t v = step(table, *state, out), more = v << 16 | zt__load16(next);
    uint32_t need = 0 - (uint32_t)(v < ZT__PRED_LOW); /* a mask: compilers make a branch of a choice */
    *state = v ^ ((v ^ more) & need);
    return next + (need & 2);
}

/* Whatever is left of the words. */
static void symbols_at_end(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to) {
    const uint32_t *const *tables = map->tables;
    for (uint32_t x = from; x < to; x++) {
        uint32_t *state = job->states + (x & (job->lanes - 1));
        if (job->next != job->end) {
            job->next = step_word(tables[job->acts[x]], state, out + x, job->next);
            continue;
        }
        uint32_t v = step(tables[job->acts[x]], *state, out + x);
        job->exhausted |= v < ZT__PRED_LOW;
        *state = v < ZT__PRED_LOW ? ZT__PRED_LOW : v;
    }
}

void zt__pred_symbols_c(zt__pred_job *job, const zt__pred_map *map, uint8_t *restrict out, uint32_t from, uint32_t to) {
    const uint8_t *next = job->next, *end = job->end;
    const uint32_t *const *tables = map->tables;
    uint32_t *restrict states = job->states, lanes = job->lanes;
    for (; to - from >= lanes && (size_t)(end - next) >= 2 * (size_t)lanes; from += lanes) {
        const uint8_t *restrict acts = job->acts + from;
        for (uint32_t i = 0; i < lanes; i++) /* from is lane 0: a multiple of 64 in the first place */
            next = step_word(tables[acts[i]], states + i, out + from + i, next);
    }
    job->next = next;
    symbols_at_end(job, map, out, from, to);
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

/* Bit lengths of low and of high bytes. */
#define ROW16(n) n, n, n, n, n, n, n, n, n, n, n, n, n, n, n, n
#define LENGTHS(add, none)                                                                                            \
    none, add + 1, add + 2, add + 2, add + 3, add + 3, add + 3, add + 3, add + 4, add + 4, add + 4, add + 4, add + 4, \
        add + 4, add + 4, add + 4, ROW16(add + 5), ROW16(add + 6), ROW16(add + 6), ROW16(add + 7), ROW16(add + 7),    \
        ROW16(add + 7), ROW16(add + 7), ROW16(add + 8), ROW16(add + 8), ROW16(add + 8), ROW16(add + 8),               \
        ROW16(add + 8), ROW16(add + 8), ROW16(add + 8), ROW16(add + 8)
static const uint8_t low_lengths[256] = {LENGTHS(0, 0)}, high_lengths[256] = {LENGTHS(8, 0)};

void zt__pred_measure_c(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width) {
    for (uint32_t x = 0; !high && x < width; x++)
        out[x] = (uint8_t)(low[x] < 128 ? low[x] : 256 - low[x]);
    for (uint32_t x = 0; high && x < width; x++) {
        uint8_t l = low_lengths[low[x]], h = high_lengths[high[x]];
        out[x] = h > l ? h : l;
    }
}

/* Texels are restored in a field of steps. Row i of the strip is LAG columns behind the row above it: its column x is
 * in slot i + 1 of step x + LAG x i, and that of the row above the strip in slot 0 of step x - LAG. So what a texel is
 * predicted from is in the steps before: to the left one step, above two, above to the left three. All slots of a step
 * can be restored at once, and compilers make vectors of that. */
enum { LAG = 2, SLOTS = ZT__PRED_STRIP + 1, BEFORE = LAG + 1, BEHIND = LAG * (ZT__PRED_STRIP - 1) };

/* Where column 0 of row i begins, in texels; the next one is SLOTS behind. Row -1 is the one above the strip. */
static inline size_t place_of(int32_t i) {
    return (size_t)((BEFORE + LAG * i) * SLOTS + i + 1);
}

/* Residuals in the field become values. n: numbers in a texel, a constant where this is inlined. */
#define RESTORE(name, type)                                                                      \
    static inline void name(type *field, uint32_t n, uint32_t width) {                           \
        const size_t step = (size_t)SLOTS * n;                                                   \
        type *at = field + BEFORE * step;                                                        \
        for (uint32_t x = 0; x < width + BEHIND; x++, at += step) {                              \
            type *slots = at + n;                                                                \
            const type *lefts = slots - step, *aboves = at - 2 * step, *corners = at - 3 * step; \
            for (uint32_t i = 0; i < ZT__PRED_STRIP * n; i++) {                                  \
                type left = lefts[i], above = aboves[i], corner = corners[i];                    \
                type least = left < above ? left : above, most = left < above ? above : left;    \
                corner = corner < least ? least : corner;                                        \
                corner = corner > most ? most : corner;                                          \
                slots[i] = (type)(slots[i] + left + above - corner);                             \
            }                                                                                    \
        }                                                                                        \
    }
RESTORE(restore_steps8, uint8_t)
RESTORE(restore_steps16, uint16_t)

/* The last row of a strip becomes the one above the next, and left of all rows there are zeros. */
static inline void next_strip(uint8_t *field, size_t texel_bytes, uint32_t width) {
    const size_t step = SLOTS * texel_bytes;
    uint8_t *above = field + place_of(-1) * texel_bytes;
    const uint8_t *last = field + place_of(ZT__PRED_STRIP - 1) * texel_bytes;
    for (uint32_t x = 0; x < width; x++, above += step, last += step)
        memcpy(above, last, texel_bytes);
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

static inline void restore8(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch, uint32_t n) {
    uint8_t *field = job->texels;
    uint32_t width = job->shape.width, channels = job->shape.channels;
    const uint8_t green = job->colour ? 255 : 0;
    next_strip(field, n, width);
    const uint8_t *row[4], *same[4];
    uint8_t *slot = field + place_of(0) * n;
    channel_rows(job, 0, row, same);
    /* Step by step. A row is read from its margin on, where zeros are. */
    for (uint32_t x = 0; x < width + BEHIND; x++, slot += n) {
        size_t from = x;
        for (uint32_t i = 0; i < ZT__PRED_STRIP; i++, slot += n, from += job->pitch - LAG) {
            for (uint32_t c = 0; n < 4 && c < n; c++)
                slot[c] = row[c][from];
            if (n == 4)
                zt__store32(slot, row[0][from] | (uint32_t)row[1][from] << 8 | (uint32_t)row[2][from] << 16 |
                                      (uint32_t)row[3][from] << 24);
        }
    }
    restore_steps8(field, n, width);
    for (uint32_t i = 0; i < rows; i++) {
        const uint8_t *at = field + place_of((int32_t)i) * n;
        uint8_t *to = dst + i * dst_pitch;
        for (uint32_t x = 0; x < width; x++, at += (size_t)SLOTS * n, to += channels) {
            uint32_t v = n == 4 ? zt__load32(at) : 0, g = v >> 8 & green;
            uint32_t even = (v & 0xFF00FF) + (g | g << 16);
            v = (v & 0xFF00FF00) | (even & 0xFF00FF);
            for (uint32_t c = 0; n < 4 && c < n; c++)
                to[c] = at[c];
            if (n == 4 && channels == 4)
                zt__store32(to, v);
            for (uint32_t c = 0; n == 4 && channels == 3 && c < 3; c++)
                to[c] = (uint8_t)(v >> 8 * c);
        }
    }
}

static inline void restore16(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch, uint32_t n) {
    void *texels = job->texels; /* aligned for any number */
    uint16_t *field = texels;
    uint32_t width = job->shape.width, channels = job->shape.channels;
    const uint16_t green = job->colour ? 0xFFFF : 0;
    next_strip(texels, 2 * n, width);
    for (uint32_t i = 0; i < rows; i++) {
        const uint8_t *highs[4], *lows[4];
        channel_rows(job, i, highs, lows);
        for (uint32_t c = 0; c < n; c++) {
            uint16_t *at = field + place_of((int32_t)i) * n + c;
            for (uint32_t x = 0; x < width; x++, at += (size_t)SLOTS * n) {
                uint32_t z = (uint32_t)highs[c][x] << 8 | lows[c][x];
                *at = (uint16_t)((z >> 1) ^ (0 - (z & 1)));
            }
        }
    }
    restore_steps16(field, n, width);
    for (uint32_t i = 0; i < rows; i++) {
        const uint16_t *at = field + place_of((int32_t)i) * n;
        uint8_t *to = dst + i * dst_pitch;
        for (uint32_t x = 0; x < width; x++, at += (size_t)SLOTS * n, to += 2 * (size_t)channels)
            for (uint32_t c = 0; c < channels; c++) {
                uint16_t more = n == 4 && (c == 0 || c == 2) ? at[n == 4 ? 1 : 0] & green : 0;
                zt__store16(to + 2 * (size_t)c, (uint16_t)(at[c] + more));
            }
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
