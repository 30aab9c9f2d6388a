/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops in plain C (file_pred.h): the reference of the vector paths. No branch depends on a sample. */
#include "file_pred_job.h"

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
    *out = (uint8_t)e;
    return (e >> 8 & 0xFFF) * (state >> ZT__PRED_BITS) + (e >> 20);
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

/* left + up - corner, but between left and up. */
static inline int32_t median(int32_t left, int32_t up, int32_t corner) {
    int32_t least = left < up ? left : up, most = left < up ? up : left;
    int32_t p = left + up - corner;
    p = p < least ? least : p;
    return p > most ? most : p;
}

/* The residual of channel c, which is the j-th coded, at column x. */
static inline int32_t residual(const uint8_t *const *rows, uint32_t j, uint32_t x, uint32_t channel_bytes) {
    if (channel_bytes == 1)
        return rows[j][x];
    uint32_t z = (uint32_t)rows[2 * j][x] << 8 | rows[2 * j + 1][x];
    return (int32_t)((z >> 1) ^ (0 - (z & 1)));
}

static inline void put(uint8_t *dst, uint32_t c, uint32_t channel_bytes, int32_t v) {
    if (channel_bytes == 1)
        dst[c] = (uint8_t)v;
    else
        zt__store16(dst + 2 * c, (uint16_t)v);
}

/* A row of texels. lines: the values of each channel in the row above, which become this row's. The last two arguments
 * are constants where this is inlined. An alpha channel that is not coded is the same everywhere: it does not move. */
static inline void restore_row(const zt__pred_job *job, const uint8_t *const *rows, uint16_t *restrict line,
                               uint8_t *restrict dst, uint32_t channels, uint32_t moving, uint32_t channel_bytes) {
    const int32_t range = channel_bytes == 1 ? 0xFF : 0xFFFF, colour = 0 - (int32_t)job->colour;
    int32_t left[4] = {0}, corner[4] = {0};
    const uint8_t *still = job->first + (channels - 1) * channel_bytes;
    for (uint32_t x = 0; x < job->shape.width; x++) {
        for (uint32_t j = 0; j < moving; j++) {
            uint32_t c = zt__pred_channel(channels, j);
            int32_t up = line[c];
            left[c] = (median(left[c], up, corner[c]) + residual(rows, j, x, channel_bytes)) & range;
            corner[c] = up;
            line[c] = (uint16_t)left[c];
        }
        if (channels >= 3) {
            put(dst, 0, channel_bytes, left[0] + (left[1] & colour));
            put(dst, 1, channel_bytes, left[1]);
            put(dst, 2, channel_bytes, left[2] + (left[1] & colour));
        }
        for (uint32_t c = channels >= 3 ? 3 : 0; c < moving; c++)
            put(dst, c, channel_bytes, left[c]);
        for (uint32_t i = 0; moving < channels && i < channel_bytes; i++)
            dst[(channels - 1) * channel_bytes + i] = still[i];
        line += 4;
        dst += channels * channel_bytes;
    }
}
/* restore_row with constants. */
#define ROW(channels, moving, channel_bytes) restore_row(job, residuals, line, dst, channels, moving, channel_bytes)

void zt__pred_restore_c(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    uint32_t n = job->shape.channels, bytes = job->shape.channel_bytes;
    bool still = n == 4 && job->coded >> 3 * bytes == 0;
    void *texels = job->texels; /* room for more than one row of 16-bit values */
    uint16_t *line = texels;
    const uint8_t *residuals[ZT__PRED_PLANES];
    for (uint32_t k = 0; k < job->planes; k++)
        residuals[k] = job->residuals[k];
    for (uint32_t i = 0; i < rows; i++, dst += dst_pitch) {
        if (bytes == 1 && n == 4)
            still ? ROW(4, 3, 1) : ROW(4, 4, 1);
        else if (bytes == 1 && n == 3)
            ROW(3, 3, 1);
        else if (bytes == 1)
            n == 2 ? ROW(2, 2, 1) : ROW(1, 1, 1);
        else if (n == 4)
            still ? ROW(4, 3, 2) : ROW(4, 4, 2);
        else
            ROW(n, n, 2);
        for (uint32_t k = 0; k < job->planes; k++)
            residuals[k] += job->pitch;
    }
}

const zt__pred_kernel *zt__pred_kernel_c(void) {
    static const zt__pred_kernel kernel = {"c", zt__pred_select_c, zt__pred_symbols_c, zt__pred_measure_c,
                                           zt__pred_restore_c};
    return &kernel;
}
