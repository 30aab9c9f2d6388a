/* SPDX-License-Identifier: Apache-2.0 */
/* Encoding of predicted tiles (file_pred.h). Everything that decides bytes is an integer. */
#include <string.h>

#include "base_bytes.h"
#include "file_pred_frame.h"
#include "file_pred_model.h"

enum { ALIGNMENT = 64, TRANSFORMS = 3 };

static const uint8_t transforms[TRANSFORMS] = {0, ZT__PRED_COLOUR, ZT__PRED_NORMAL};

/* One symbol for the coder: x becomes (x / f) << 11 | first slot + x % f, the division by multiplying. */
typedef struct symbol {
    uint32_t limit; /* states from this on give away 16 bits first */
    uint32_t reciprocal;
    uint16_t bias, complement;
    uint32_t shift;
} symbol;

typedef struct encoding {
    zt__pred_shape shape;
    uint32_t planes, coded, lanes, effort;
    uint32_t transform; /* ZT__PRED_COLOUR, ZT__PRED_NORMAL or 0 */
    bool zeros;
    uint8_t slopes[ZT__PRED_SLOPES];
    uint8_t first[ZT__PRED_PLANES];
    size_t pitch, plane_size;
    uint8_t *residuals[ZT__PRED_PLANES], *acts[ZT__PRED_PLANES]; /* rows without margins, zero up to the pitch */
    uint8_t *values[2][4]; /* rows of one channel with margins: the row above and this row */
    uint8_t *magnitudes[2][4], *row;
    uint8_t *blocks; /* for each block of each plane: 1 if not zero */
    uint32_t across, down;
    zt__pred_model *model;
    symbol *symbols; /* ZT__PRED_TABLES x 256, by symbol */
    uint8_t *words_end, *first_word;
    uint32_t states[ZT__PRED_LANES];
    const uint8_t *src;
    size_t src_pitch;
} encoding;

static size_t round64(size_t n) {
    return (n + 63) & ~(size_t)63;
}

static size_t line_size(const zt__pred_shape *shape) {
    return round64((size_t)shape->width * 2) + 2 * ZT__PRED_MARGIN;
}

static size_t block_count(const zt__pred_shape *shape) {
    return (size_t)((shape->width + ZT__PRED_BLOCK - 1) / ZT__PRED_BLOCK) *
           ((shape->height + ZT__PRED_STRIP - 1) / ZT__PRED_STRIP);
}

size_t zt__pred_work_size(const zt__pred_shape *shape) {
    size_t planes = (size_t)shape->channels * shape->channel_bytes;
    size_t samples = (size_t)shape->width * shape->height;
    return ALIGNMENT + round64(sizeof(zt__pred_model)) + round64(ZT__PRED_TABLES * 256 * sizeof(symbol)) +
           17 * line_size(shape) + planes * (2 * round64(shape->width) * shape->height + round64(block_count(shape))) +
           planes * samples * 2;
}

static uint8_t *take(uint8_t **at, size_t size) {
    uint8_t *p = *at;
    *at += size;
    return p;
}

static void place(encoding *e, void *work) {
    const zt__pred_shape *shape = &e->shape;
    uint8_t *at = (uint8_t *)work + (ALIGNMENT - (uintptr_t)work % ALIGNMENT) % ALIGNMENT;
    void *model = take(&at, round64(sizeof(zt__pred_model)));
    void *symbols = take(&at, round64(ZT__PRED_TABLES * 256 * sizeof(symbol)));
    e->model = model;
    e->symbols = symbols;
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 4; j++) {
            e->values[i][j] = take(&at, line_size(shape)) + ZT__PRED_MARGIN;
            e->magnitudes[i][j] = take(&at, line_size(shape)) + ZT__PRED_MARGIN;
        }
    e->row = take(&at, line_size(shape)) + ZT__PRED_MARGIN;
    e->pitch = round64(shape->width);
    e->plane_size = e->pitch * shape->height;
    e->across = (shape->width + ZT__PRED_BLOCK - 1) / ZT__PRED_BLOCK;
    e->down = (shape->height + ZT__PRED_STRIP - 1) / ZT__PRED_STRIP;
    for (uint32_t k = 0; k < e->planes; k++) {
        e->residuals[k] = take(&at, e->plane_size);
        e->acts[k] = take(&at, e->plane_size);
    }
    e->blocks = take(&at, e->planes * round64(block_count(shape)));
    e->words_end = at + (size_t)e->planes * shape->width * shape->height * 2;
}

/* The channels of a row in values[1], one array each. */
static void split_row(encoding *e, const uint8_t *src) {
    uint32_t n = e->shape.channels, w = e->shape.width;
    for (uint32_t c = 0; c < n; c++)
        if (e->shape.channel_bytes == 1) {
            uint8_t *v = e->values[1][c];
            for (uint32_t x = 0; x < w; x++)
                v[x] = src[x * n + c];
        } else {
            void *p = e->values[1][c];
            uint16_t *v = p;
            for (uint32_t x = 0; x < w; x++)
                v[x] = zt__load16(src + 2 * (size_t)(x * n + c));
        }
}

static void subtract_green(encoding *e) {
    for (uint32_t c = 0; c < 3; c += 2)
        if (e->shape.channel_bytes == 1) {
            uint8_t *v = e->values[1][c], *g = e->values[1][1];
            for (uint32_t x = 0; x < e->shape.width; x++)
                v[x] = (uint8_t)(v[x] - g[x]);
        } else {
            void *p = e->values[1][c], *q = e->values[1][1];
            uint16_t *v = p, *g = q;
            for (uint32_t x = 0; x < e->shape.width; x++)
                v[x] = (uint16_t)(v[x] - g[x]);
        }
}

/* values[1] becomes row y, one array for each channel, transformed. */
static void load_row(encoding *e, uint32_t y, uint32_t transform) {
    split_row(e, e->src + y * e->src_pitch);
    if (transform == ZT__PRED_COLOUR)
        subtract_green(e);
    uint8_t *const *v = e->values[1];
    for (uint32_t x = 0; transform == ZT__PRED_NORMAL && x < e->shape.width; x++)
        v[2][x] = (uint8_t)(v[2][x] - zt__pred_slope(e->slopes, v[0][x], v[1][x]));
}

static void predict8(const uint8_t *above, const uint8_t *row, uint8_t *residual, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        uint8_t a = *(row + x - 1), b = above[x], c = *(above + x - 1);
        uint8_t least = a < b ? a : b, most = a < b ? b : a;
        c = c < least ? least : c;
        c = c > most ? most : c;
        residual[x] = (uint8_t)(row[x] - a - b + c);
    }
}

static void predict16(const uint16_t *above, const uint16_t *row, uint8_t *high, uint8_t *low, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        uint16_t a = *(row + x - 1), b = above[x], c = *(above + x - 1);
        uint16_t least = a < b ? a : b, most = a < b ? b : a;
        c = c < least ? least : c;
        c = c > most ? most : c;
        uint16_t r = (uint16_t)(row[x] - a - b + c);
        uint16_t z = (uint16_t)(r << 1 ^ (0 - (r >> 15)));
        high[x] = (uint8_t)(z >> 8);
        low[x] = (uint8_t)z;
    }
}

/* Residuals of channel c of the row in values[1]; the plane's bytes in high (unless it is NULL) and low. */
static void predict(const encoding *e, uint32_t c, uint8_t *high, uint8_t *low) {
    if (e->shape.channel_bytes == 1) {
        predict8(e->values[0][c], e->values[1][c], low, e->shape.width);
        return;
    }
    const void *above = e->values[0][c], *row = e->values[1][c];
    predict16(above, row, high, low, e->shape.width);
}

static void swap_rows(uint8_t *rows[2][4]) {
    for (int c = 0; c < 4; c++) {
        uint8_t *t = rows[0][c];
        rows[0][c] = rows[1][c];
        rows[1][c] = t;
    }
}

static void clear_rows(encoding *e, uint8_t *rows[2][4]) {
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < 2; i++)
            memset(rows[i][c] - ZT__PRED_MARGIN, 0, line_size(&e->shape));
}

/* What the channels 0 and 2 of every step-th row cost with one table a plane. */
static uint64_t transform_cost(encoding *e, uint32_t transform, uint32_t step) {
    const uint32_t bytes = e->shape.channel_bytes;
    zt__pred_counts *counts = e->model->counts;
    uint8_t *high = e->row, *low = e->row + e->shape.width;
    uint64_t cost = 0;
    memset(counts, 0, 4 * sizeof *counts);
    clear_rows(e, e->values);
    for (uint32_t y = zt__min32(step - 1, e->shape.height - 1); y < e->shape.height; y += step) {
        if (y > 0) {
            load_row(e, y - 1, transform);
            swap_rows(e->values);
        }
        load_row(e, y, transform);
        for (uint32_t c = 0; c < 3; c += 2) {
            predict(e, c, high, low);
            for (uint32_t x = 0; x < e->shape.width; x++)
                counts[c].of[low[x]]++;
            for (uint32_t x = 0; bytes == 2 && x < e->shape.width; x++)
                counts[c + 1].of[high[x]]++;
        }
    }
    for (uint32_t i = 0; i < 4; i++)
        cost += zt__pred_cost(e->model, &counts[i]);
    return cost;
}

/* Fills the residuals and activities of all planes, and notes which planes and blocks are not zero. */
/* The first texel is its own prediction; its values are in the present row. */
static void take_first(encoding *e) {
    for (uint32_t c = 0; c < e->shape.channels; c++) {
        const void *value = e->values[1][c];
        const uint16_t *wide = value;
        if (e->shape.channel_bytes == 2)
            zt__store16(e->first + 2 * (size_t)c, *wide);
        else
            e->first[c] = e->values[1][c][0];
    }
}

/* Residuals, magnitudes and activities of row y of the j-th channel in the order of coding. */
static void transform_row(encoding *e, const zt__pred_kernel *kernel, uint32_t y, uint32_t j) {
    static const uint8_t reference[4] = {0, 0, 1, 0};
    uint32_t bytes = e->shape.channel_bytes, w = e->shape.width;
    uint8_t *high = bytes == 2 ? e->residuals[2 * j] + y * e->pitch : NULL;
    uint8_t *low = e->residuals[(j + 1) * bytes - 1] + y * e->pitch;
    predict(e, zt__pred_channel(e->shape.channels, j), high, low);
    memset(low + w, 0, e->pitch - w);
    if (high)
        memset(high + w, 0, e->pitch - w);
    if (y == 0)
        low[0] = 0;
    if (y == 0 && high)
        high[0] = 0;
    kernel->measure(high, low, e->magnitudes[1][j], w);
    const uint8_t *beside = j ? e->magnitudes[1][reference[j]] : NULL, *above = e->magnitudes[0][j];
    if (high)
        kernel->select(above, beside, NULL, e->acts[2 * j] + y * e->pitch, w);
    kernel->select(above, beside, high, e->acts[(j + 1) * bytes - 1] + y * e->pitch, w);
}

static void transform_rows(encoding *e, const zt__pred_kernel *kernel) {
    clear_rows(e, e->values);
    clear_rows(e, e->magnitudes);
    load_row(e, 0, e->transform);
    take_first(e);
    for (uint32_t y = 0; y < e->shape.height; y++) {
        load_row(e, y, e->transform);
        for (uint32_t j = 0; j < e->shape.channels; j++)
            transform_row(e, kernel, y, j);
        swap_rows(e->values);
        swap_rows(e->magnitudes);
    }
}

static bool any(const uint8_t *p, size_t n) {
    uint32_t seen = 0;
    for (size_t i = 0; i < n; i++)
        seen |= p[i];
    return seen != 0;
}

/* Which planes and blocks are not zero. Returns whether there are enough zero blocks for a map of them. */
static bool find_zeros(encoding *e) {
    size_t zero = 0, all = 0;
    e->coded = 0;
    for (uint32_t k = 0; k < e->planes; k++) {
        uint8_t *flags = e->blocks + k * round64(block_count(&e->shape));
        size_t coded = 0;
        memset(flags, 0, block_count(&e->shape));
        for (uint32_t y = 0; y < e->shape.height; y++)
            for (uint32_t i = 0; i < e->across; i++)
                flags[y / ZT__PRED_STRIP * e->across + i] |= any(
                    e->residuals[k] + y * e->pitch + (size_t)i * ZT__PRED_BLOCK, ZT__PRED_BLOCK);
        for (size_t i = 0; i < block_count(&e->shape); i++)
            coded += flags[i];
        if (coded == 0)
            continue;
        e->coded |= 1u << k;
        zero += block_count(&e->shape) - coded;
        all += block_count(&e->shape);
    }
    return zero != 0 && zero * 16 >= all;
}

/* Samples x to its end of row y in plane k are coded: *end; or not: false, and *end is where that changes. */
static bool block_coded(const encoding *e, uint32_t k, uint32_t y, uint32_t x, uint32_t *end) {
    if (!e->zeros) {
        *end = e->shape.width;
        return true;
    }
    *end = zt__min32((x / ZT__PRED_BLOCK + 1) * ZT__PRED_BLOCK, e->shape.width);
    return e->blocks[k * round64(block_count(&e->shape)) + y / ZT__PRED_STRIP * e->across + x / ZT__PRED_BLOCK];
}

/* Counts the symbols of each context. Returns the number of coded samples. */
/* Samples of one row of a plane by activity; returns how many are coded. */
static uint64_t count_row(const encoding *e, uint32_t k, uint32_t y, zt__pred_counts *counts) {
    const uint8_t *r = e->residuals[k] + y * e->pitch, *acts = e->acts[k] + y * e->pitch;
    uint64_t samples = 0;
    for (uint32_t x = 0, end; x < e->shape.width; x = end) {
        if (!block_coded(e, k, y, x, &end))
            continue;
        samples += end - x;
        for (uint32_t i = x; i < end; i++)
            counts[acts[i]].of[r[i]]++;
    }
    return samples;
}

/* Bytes are counted by magnitude, in the order in which tables hold them. */
static void sort_counts(encoding *e) {
    for (uint32_t i = 0; i < e->planes * ZT__PRED_ACTS; i++) {
        uint32_t sorted[256];
        for (uint32_t s = 0; s < 256; s++)
            sorted[s] = e->model->counts[i].of[zt__pred_symbol(1, s)];
        memcpy(e->model->counts[i].of, sorted, sizeof sorted);
    }
}

static uint64_t count(encoding *e) {
    uint64_t samples = 0;
    memset(e->model->counts, 0, sizeof e->model->counts);
    for (uint32_t k = 0; k < e->planes; k++) {
        zt__pred_counts *counts = e->model->counts + (size_t)k * ZT__PRED_ACTS;
        for (uint32_t y = 0; (e->coded >> k & 1) && y < e->shape.height; y++)
            samples += count_row(e, k, y, counts);
    }
    if (e->shape.channel_bytes == 1)
        sort_counts(e);
    return samples;
}

/* What the coder wants to know of each symbol; slots are in the order of storing. */
static void prepare_symbols(encoding *e) {
    for (uint32_t t = 0; t < e->model->table_count; t++) {
        uint32_t start = 0;
        for (uint32_t i = 0; i < 256; i++) {
            uint32_t f = e->model->frequencies[t][i];
            symbol *s = &e->symbols[t * 256 + zt__pred_symbol(e->shape.channel_bytes, i)];
            if (f == 0)
                continue;
            uint32_t bits = 0;
            while (f > 1u << bits)
                bits++;
            s->limit = f << 20;
            s->complement = (uint16_t)(ZT__PRED_SLOTS - f);
            s->bias = (uint16_t)(f == 1 ? start + ZT__PRED_SLOTS - 1 : start);
            s->shift = f == 1 ? 0 : bits - 1;
            s->reciprocal = f == 1 ? UINT32_MAX : (uint32_t)(((UINT64_C(1) << (bits + 31)) + f - 1) / f);
            start += f;
        }
    }
}

/* Codes a run of samples backwards; words grow towards lower addresses. */
static uint8_t *code_run(encoding *e, const uint8_t *map, const uint8_t *acts, const uint8_t *residuals, uint32_t from,
                         uint32_t to, uint8_t *at) {
    uint32_t mask = e->lanes - 1;
    for (uint32_t x = to; x-- > from;) {
        const symbol *s = &e->symbols[map[acts[x]] * 256u + residuals[x]];
        uint32_t state = e->states[x & mask], give = 0 - (uint32_t)(state >= s->limit);
        zt__store16(at - 2, (uint16_t)state);
        at -= give & 2;
        state >>= give & 16;
        uint32_t q = (uint32_t)((uint64_t)state * s->reciprocal >> 32) >> s->shift;
        e->states[x & mask] = state + s->bias + q * s->complement;
    }
    return at;
}

/* Codes all samples in the reverse of the order in which they are decoded. */
/* One row of a plane, from its end; returns where the words begin now. */
static uint8_t *code_row(encoding *e, uint32_t k, uint32_t y, uint8_t *at) {
    const uint8_t *r = e->residuals[k] + y * e->pitch, *acts = e->acts[k] + y * e->pitch;
    const uint8_t *map = e->model->map + (size_t)k * ZT__PRED_ACTS;
    if (!e->zeros)
        return code_run(e, map, acts, r, 0, e->shape.width, at);
    for (uint32_t i = e->across, end; i-- > 0;) {
        if (block_coded(e, k, y, i * ZT__PRED_BLOCK, &end))
            at = code_run(e, map, acts, r, i * ZT__PRED_BLOCK, end, at);
    }
    return at;
}

static void code_samples(encoding *e) {
    uint8_t *at = e->words_end;
    for (uint32_t i = 0; i < e->lanes; i++)
        e->states[i] = ZT__PRED_LOW;
    for (uint32_t y = e->shape.height; y-- > 0;) {
        for (uint32_t k = e->planes; k-- > 0;)
            at = e->coded >> k & 1 ? code_row(e, k, y, at) : at;
    }
    e->first_word = at;
}

/* Bits to memory, the least significant of a byte first. full: no more room. */
typedef struct sink {
    uint8_t *at, *end;
    uint64_t held;
    uint32_t count;
    bool full;
} sink;

static void put_bytes(sink *out, const void *bytes, size_t n) {
    if ((size_t)(out->end - out->at) < n) {
        out->full = true;
        return;
    }
    memcpy(out->at, bytes, n);
    out->at += n;
}

static void put_byte(sink *out, uint32_t v) {
    uint8_t byte = (uint8_t)v;
    put_bytes(out, &byte, 1);
}

static void put_bits(sink *out, uint32_t v, uint32_t n) {
    out->held |= (uint64_t)v << out->count;
    for (out->count += n; out->count >= 8; out->count -= 8) {
        put_byte(out, (uint32_t)out->held & 255);
        out->held >>= 8;
    }
}

static void put_table(sink *out, const uint16_t frequencies[256]) {
    uint32_t sum = 0, length = ZT__PRED_BITS - 3;
    for (uint32_t i = 0; sum < ZT__PRED_SLOTS; i++) {
        uint32_t v = frequencies[i] + 1u, k = zt__log2(v), d = k - length;
        put_bits(out, UINT32_C(1) << ((d << 1) ^ (0 - (d >> 31))), (d << 1 ^ (0 - (d >> 31))) + 1);
        put_bits(out, v - (1u << k), k);
        length = k;
        sum += frequencies[i];
    }
}

static void put_zeros(const encoding *e, sink *out) {
    for (uint32_t k = 0; k < e->planes; k++)
        for (size_t i = 0; (e->coded >> k & 1) != 0 && i < block_count(&e->shape); i++)
            put_bits(out, e->blocks[k * round64(block_count(&e->shape)) + i], 1);
}

/* Puts the tile together. Returns its size, or 0. */
static size_t put_tile(const encoding *e, uint8_t *dst, size_t dst_size) {
    sink out = {dst, dst + dst_size, 0, 0, false};
    const uint8_t *map = e->model->map;
    uint32_t lanes_code = e->lanes == 64 ? 2 : e->lanes == 32 ? 1 : 0;
    put_byte(&out, e->transform | (e->zeros ? ZT__PRED_ZEROS : 0u) | lanes_code << 2);
    put_byte(&out, e->coded ? e->model->table_count : 0);
    put_byte(&out, e->coded);
    put_bytes(&out, e->first, e->planes);
    for (uint32_t k = 0; k < e->planes; k++)
        for (uint32_t i = 0; (e->coded >> k & 1) != 0 && i < ZT__PRED_ACTS; i += 2)
            put_byte(&out, map[k * ZT__PRED_ACTS + i] | (uint32_t)map[k * ZT__PRED_ACTS + i + 1] << 4);
    if (e->coded) {
        if (e->zeros)
            put_zeros(e, &out);
        for (uint32_t i = 0; i < e->model->table_count; i++)
            put_table(&out, e->model->frequencies[i]);
        put_bits(&out, 0, (8 - out.count) & 7);
        for (uint32_t i = 0; i < e->lanes; i++) {
            uint8_t state[4];
            zt__store32(state, e->states[i]);
            put_bytes(&out, state, sizeof state);
        }
        put_bytes(&out, e->first_word, (size_t)(e->words_end - e->first_word));
    }
    return out.full ? 0 : (size_t)(out.at - dst);
}

/* Predicts and codes the tile one way. Returns its size, or 0. */
static size_t encode_one(encoding *e, uint32_t transform, uint8_t *dst, size_t dst_size) {
    e->transform = transform;
    transform_rows(e, zt__pred_kernel_best());
    e->zeros = find_zeros(e);
    e->lanes = 16;
    if (e->coded) {
        uint64_t samples = count(e);
        e->lanes = samples >= 65536 ? 64 : samples >= 8192 ? 32 : 16;
        zt__pred_choose(e->model, e->planes * ZT__PRED_ACTS, e->effort);
        prepare_symbols(e);
        code_samples(e);
    }
    return put_tile(e, dst, dst_size);
}

/* The transform that promises most. */
static uint32_t choose_transform(encoding *e) {
    static const uint8_t steps[ZT__PRED_MAX_EFFORT + 1] = {0, 32, 32, 8, 8, 8, 8, 4, 2, 2};
    uint64_t least = UINT64_MAX;
    uint32_t best = 0;
    for (uint32_t i = 0; i < TRANSFORMS; i++) {
        if (!zt__pred_transform_ok(&e->shape, transforms[i]) || e->shape.channels < 3)
            continue;
        uint64_t cost = transform_cost(e, transforms[i], steps[e->effort]);
        best = cost < least ? transforms[i] : best;
        least = cost < least ? cost : least;
    }
    return best;
}

size_t zt__pred_encode(const zt__pred_shape *shape, const uint8_t *src, size_t src_pitch, uint32_t effort, void *work,
                       uint8_t *dst, size_t dst_size) {
    encoding e = {.shape = *shape,
                  .planes = shape->channels * shape->channel_bytes,
                  .effort = effort,
                  .src = src,
                  .src_pitch = src_pitch};
    place(&e, work);
    zt__pred_model_init(e.model);
    zt__pred_fill_slopes(e.slopes);
    uint32_t chosen = choose_transform(&e), best = chosen, last = chosen;
    size_t size = encode_one(&e, best, dst, dst_size);
    for (uint32_t i = 0; effort == ZT__PRED_MAX_EFFORT && shape->channels >= 3 && i < TRANSFORMS; i++) {
        if (transforms[i] == chosen || !zt__pred_transform_ok(shape, transforms[i]))
            continue;
        last = transforms[i];
        size_t other = encode_one(&e, last, dst, size ? size - 1 : dst_size);
        best = other ? last : best;
        size = other ? other : size;
    }
    return best == last || size == 0 ? size : encode_one(&e, best, dst, dst_size);
}
