/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tile from random numbers: tables of any shape, maps that no statistics would give, any sample that has a frequency.
 * Written from the specification alone (spec/ztex.md section 6.4), slow and plain, so that what it makes is also a
 * test of what libzt decodes.
 */
#include "tile.h"

enum { ACTIVITIES = 16, BLOCK_WIDTH = 64, BLOCK_HEIGHT = 8, LOWEST_STATE = 1 << 15 };

typedef struct table {
    uint16_t frequency[256], first[256]; /* of each symbol */
    uint8_t symbol_of[TILE_SLOTS];
} table;

typedef struct sample {
    uint8_t table, symbol;
    uint16_t column;
} sample;

typedef struct making {
    fuzz_random *random;
    uint32_t width, height, channels, channel_bytes;
    uint32_t lanes, table_count, coded;
    bool colour, zero_map;
    uint8_t maps[TILE_PLANES][ACTIVITIES];
    uint8_t zeros[TILE_PLANES * TILE_HEIGHT * TILE_WIDTH / 64]; /* a byte for each block, in the order of the map */
    table tables[TILE_TABLES];
    uint8_t first[8];
    uint8_t planes[TILE_PLANES][TILE_TEXELS];
    sample samples[TILE_PLANES * TILE_TEXELS];
    size_t sample_count;
    /* Bits being written. */
    uint8_t *out;
    uint64_t bit;
} making;

/* ---- heads ---- */

bool tile_parse(tile *t, const uint8_t *data, size_t size) {
    if (size < TILE_HEAD)
        return false;
    t->channels = 1 + (data[0] & 3u);
    t->channel_bytes = 1 + (data[0] >> 2 & 1u);
    t->stored_low = (data[0] >> 3 & 1) != 0;
    t->dst_low = (data[0] >> 4 & 1) != 0;
    t->gap = data[0] >> 5;
    t->width = 1 + (data[1] | (uint32_t)data[2] << 8) % TILE_WIDTH;
    t->height = 1 + (data[3] | (uint32_t)(data[4] & 0x0F) << 8) % TILE_HEIGHT;
    t->fields = data[4] >> 7 ? 1 + (data[4] >> 4 & 7u) % TILE_FIELD_FORMATS : 0;
    if (t->fields) /* blocks are larger than texels */
        t->width = 1 + (t->width - 1) % (TILE_WIDTH / 2);
    t->gap *= 1u + data[5];
    t->stored = data + TILE_HEAD;
    t->size = size - TILE_HEAD;
    return true;
}

void tile_store_head(const tile *t, uint8_t *out) {
    memset(out, 0, TILE_HEAD);
    out[0] = (uint8_t)((t->channels - 1) | (t->channel_bytes - 1) << 2 | (uint32_t)t->stored_low << 3 |
                       (uint32_t)t->dst_low << 4 | (t->gap & 7) << 5);
    fuzz_store(out + 1, t->width - 1, 2);
    fuzz_store(out + 3, t->height - 1, 2);
    out[4] = (uint8_t)(t->fields ? out[4] | 0x80 | (t->fields - 1) << 4 : out[4]);
}

/* ---- tables ---- */

/* The symbol that comes i-th in a table. */
static uint8_t symbol_at(uint32_t channel_bytes, uint32_t i) {
    if (channel_bytes == 2)
        return (uint8_t)i;
    return (uint8_t)(i % 2 == 0 ? i / 2 : 256 - (i + 1) / 2);
}

/* Frequencies in the order of a table, which sum to TILE_SLOTS. */
static void random_frequencies(fuzz_random *random, uint16_t *f) {
    uint32_t left = TILE_SLOTS, kind = fuzz_below(random, 6);
    memset(f, 0, 256 * sizeof *f);
    if (kind == 0) { /* one symbol */
        f[fuzz_below(random, fuzz_below(random, 2) ? 256 : 4)] = TILE_SLOTS;
        return;
    }
    if (kind == 1) { /* all the same */
        for (uint32_t i = 0; i < 256; i++)
            f[i] = TILE_SLOTS / 256;
        return;
    }
    uint32_t alphabet = kind < 4 ? 2 + fuzz_below(random, 12) : 256, most = kind % 2 ? TILE_SLOTS : 64;
    while (left > 0) {
        uint32_t i = fuzz_below(random, alphabet), n = 1 + fuzz_below(random, left < most ? left : most);
        f[i] = (uint16_t)(f[i] + n);
        left -= n;
    }
}

static void make_table(making *m, table *t, uint16_t *f) {
    uint32_t sum = 0;
    random_frequencies(m->random, f);
    memset(t, 0, sizeof *t);
    for (uint32_t i = 0; i < 256; i++) {
        uint8_t symbol = symbol_at(m->channel_bytes, i);
        t->frequency[symbol] = f[i];
        t->first[symbol] = (uint16_t)sum;
        memset(t->symbol_of + sum, symbol, f[i]);
        sum += f[i];
    }
}

static void put_bits(making *m, uint32_t value, uint32_t count) {
    for (uint32_t i = 0; i < count; i++, m->bit++)
        m->out[m->bit >> 3] |= (uint8_t)((value >> i & 1) << (m->bit & 7));
}

static void put_table(making *m, const uint16_t *f) {
    int32_t length = 8;
    for (uint32_t i = 0, sum = 0; sum < TILE_SLOTS; sum += f[i++]) {
        uint32_t v = f[i] + 1u;
        int32_t k = 0;
        while (v >> (k + 1) != 0)
            k++;
        int32_t d = k - length;
        put_bits(m, 0, (uint32_t)(d >= 0 ? 2 * d : -2 * d - 1));
        put_bits(m, 1, 1);
        put_bits(m, v, (uint32_t)k);
        length = k;
    }
}

/* ---- samples ---- */

static uint32_t sample_of(const making *m, uint32_t plane, uint32_t x, uint32_t y) {
    return m->planes[plane][y * m->width + x];
}

/* Magnitude of the j-th channel; outside of the tile 0. */
static uint32_t magnitude(const making *m, uint32_t j, int64_t x, int64_t y) {
    if (x < 0 || y < 0 || x >= m->width)
        return 0;
    uint32_t high = sample_of(m, j * m->channel_bytes, (uint32_t)x, (uint32_t)y), bits = 0;
    if (m->channel_bytes == 1)
        return high < 128 ? high : 256 - high;
    for (uint32_t z = high << 8 | sample_of(m, 2 * j + 1, (uint32_t)x, (uint32_t)y); z != 0; z >>= 1)
        bits++;
    return bits;
}

static uint32_t average(uint32_t a, uint32_t b) {
    return (a + b + 1) / 2;
}

static uint32_t activity(const making *m, uint32_t plane, uint32_t x, uint32_t y) {
    static const uint32_t reference[4] = {0, 0, 1, 0};
    uint32_t j = plane / m->channel_bytes;
    int64_t above = (int64_t)y - 1;
    uint32_t u = average(magnitude(m, j, (int64_t)x - 1, above), magnitude(m, j, (int64_t)x + 1, above));
    u = average(u, magnitude(m, j, x, above));
    if (j > 0)
        u = average(u, magnitude(m, reference[j], x, y));
    if (plane % m->channel_bytes == 0)
        return u < 15 ? u : 15;
    if (sample_of(m, plane - 1, x, y) != 0)
        return 15;
    return u < 14 ? u : 14;
}

static size_t block_of(const making *m, uint32_t coded_index, uint32_t x, uint32_t y) {
    size_t across = (m->width + BLOCK_WIDTH - 1) / BLOCK_WIDTH, down = (m->height + BLOCK_HEIGHT - 1) / BLOCK_HEIGHT;
    return (coded_index * down + y / BLOCK_HEIGHT) * across + x / BLOCK_WIDTH;
}

/* The samples of a row of a plane. */
static void choose_row(making *m, uint32_t plane, uint32_t coded_index, uint32_t y) {
    for (uint32_t x = 0; x < m->width; x++) {
        if (m->zero_map && !m->zeros[block_of(m, coded_index, x, y)])
            continue;
        uint8_t number = m->maps[plane][activity(m, plane, x, y)];
        uint8_t symbol = m->tables[number].symbol_of[fuzz_below(m->random, TILE_SLOTS)];
        m->planes[plane][y * m->width + x] = symbol;
        m->samples[m->sample_count++] = (sample){number, symbol, (uint16_t)x};
    }
}

static void choose_samples(making *m) {
    memset(m->planes, 0, sizeof m->planes);
    m->sample_count = 0;
    for (uint32_t y = 0; y < m->height; y++) {
        uint32_t coded_index = 0;
        for (uint32_t k = 0; k < m->channels * m->channel_bytes; k++)
            if (m->coded >> k & 1)
                choose_row(m, k, coded_index++, y);
    }
}

/* States and words, backwards from the last sample. Returns the end of what was written at out. */
static uint8_t *put_samples(const making *m, uint8_t *out) {
    static uint16_t words[TILE_PLANES * TILE_TEXELS];
    size_t count = 0;
    uint32_t states[64];
    for (uint32_t i = 0; i < m->lanes; i++)
        states[i] = LOWEST_STATE;
    for (size_t i = m->sample_count; i-- > 0;) {
        const sample *s = m->samples + i;
        const table *t = m->tables + s->table;
        uint32_t *state = states + s->column % m->lanes, f = t->frequency[s->symbol];
        if (*state >= (uint64_t)f << 20) {
            words[count++] = (uint16_t)*state;
            *state >>= 16;
        }
        *state = *state / f * TILE_SLOTS + *state % f + t->first[s->symbol];
    }
    for (uint32_t i = 0; i < m->lanes; i++, out += 4)
        fuzz_store(out, states[i], 4);
    for (; count > 0; out += 2)
        fuzz_store(out, words[--count], 2);
    return out;
}

/* ---- texels ---- */

static uint32_t median(uint32_t a, uint32_t b, uint32_t c) {
    uint32_t least = a < b ? a : b, most = a < b ? b : a;
    return c < least ? least : c > most ? most : c;
}

static uint32_t residual(const making *m, uint32_t j, uint32_t x, uint32_t y) {
    if (m->channel_bytes == 1)
        return sample_of(m, j, x, y);
    uint32_t z = sample_of(m, 2 * j, x, y) << 8 | sample_of(m, 2 * j + 1, x, y);
    return z >> 1 ^ (0 - (z & 1));
}

static uint32_t load_channel(const making *m, const uint8_t *p) {
    return m->channel_bytes == 1 ? p[0] : p[0] | (uint32_t)p[1] << 8;
}

static void store_channel(const making *m, uint8_t *p, uint32_t v) {
    p[0] = (uint8_t)v;
    if (m->channel_bytes == 2)
        p[1] = (uint8_t)(v >> 8);
}

static void restore_channel(const making *m, uint32_t j, uint32_t channel, uint8_t *texels) {
    size_t texel = (size_t)m->channels * m->channel_bytes, row = texel * m->width;
    uint8_t *at = texels + channel * m->channel_bytes;
    for (uint32_t y = 0; y < m->height; y++) {
        for (uint32_t x = 0; x < m->width; x++, at += texel) {
            uint32_t a = x ? load_channel(m, at - texel) : 0, b = y ? load_channel(m, at - row) : 0;
            uint32_t c = x && y ? load_channel(m, at - row - texel) : 0, p = a + b - median(a, b, c);
            if (x == 0 && y == 0)
                p = load_channel(m, m->first + channel * m->channel_bytes);
            store_channel(m, at, p + residual(m, j, x, y));
        }
    }
}

static void restore(const making *m, uint8_t *texels) {
    static const uint32_t swapped[4] = {1, 0, 2, 3}, plain[4] = {0, 1, 2, 3};
    uint32_t bytes = m->channel_bytes;
    for (uint32_t j = 0; j < m->channels; j++)
        restore_channel(m, j, (m->channels >= 3 ? swapped : plain)[j], texels);
    for (uint32_t i = 0; i < m->width * m->height && m->colour; i++) {
        uint8_t *texel = texels + (size_t)i * m->channels * bytes;
        for (uint32_t c = 0; c <= 2; c += 2)
            store_channel(m, texel + c * bytes, load_channel(m, texel + c * bytes) + load_channel(m, texel + bytes));
    }
}

/* ---- the whole ---- */

/* Mostly small: what is wrong with a large tile shows in a small one sooner, but for the ends of vector loops. */
static void choose_shape(making *m, tile *t) {
    bool wide = fuzz_below(m->random, 16) == 0;
    m->width = 1 + fuzz_below(m->random, wide ? TILE_WIDTH : 8);
    uint32_t most = TILE_TEXELS / m->width < TILE_HEIGHT ? TILE_TEXELS / m->width : TILE_HEIGHT;
    m->height = 1 + fuzz_below(m->random, wide ? most : 4);
    m->channels = 1 + fuzz_below(m->random, 4);
    m->channel_bytes = 1 + fuzz_below(m->random, 2);
    *t = (tile){.width = m->width, .height = m->height, .channels = m->channels, .channel_bytes = m->channel_bytes};
    t->gap = fuzz_below(m->random, 8);
    t->stored_low = fuzz_below(m->random, 2) != 0;
    t->dst_low = fuzz_below(m->random, 2) != 0;
}

static void choose_fields(making *m) {
    uint32_t planes = m->channels * m->channel_bytes;
    m->colour = m->channels >= 3 && fuzz_below(m->random, 2);
    m->coded = (fuzz_below(m->random, 4) ? 255 : fuzz_below(m->random, 256)) & ((1u << planes) - 1);
    m->zero_map = m->coded && fuzz_below(m->random, 3) == 0;
    m->lanes = m->coded ? 16u << fuzz_below(m->random, 3) : 16;
    m->table_count = m->coded ? 1 + fuzz_below(m->random, fuzz_below(m->random, 3) ? 3 : TILE_TABLES) : 0;
    for (uint32_t i = 0; i < sizeof m->first; i++)
        m->first[i] = (uint8_t)fuzz_next(m->random);
    for (uint32_t k = 0; k < planes && m->coded; k++)
        for (uint32_t i = 0; i < ACTIVITIES; i++)
            m->maps[k][i] = (uint8_t)fuzz_below(m->random, m->table_count);
}

/* Flags, counts, first texel and maps. Returns their end. */
static uint8_t *put_fields(const making *m, uint8_t *out) {
    uint32_t planes = m->channels * m->channel_bytes, lane_code = m->lanes == 16 ? 0 : m->lanes == 32 ? 1 : 2;
    *out++ = (uint8_t)((uint32_t)m->colour | (uint32_t)m->zero_map << 1 | lane_code << 2);
    *out++ = (uint8_t)m->table_count;
    *out++ = (uint8_t)m->coded;
    memcpy(out, m->first, planes);
    out += planes;
    for (uint32_t k = 0; k < planes; k++)
        for (uint32_t i = 0; i < ACTIVITIES && (m->coded >> k & 1) != 0; i += 2)
            *out++ = (uint8_t)(m->maps[k][i] | m->maps[k][i + 1] << 4);
    return out;
}

static void put_zero_map(making *m) {
    uint32_t coded_planes = (uint32_t)__builtin_popcount(m->coded);
    size_t blocks = block_of(m, coded_planes, 0, 0);
    for (size_t i = 0; i < blocks && m->zero_map; i++) {
        m->zeros[i] = fuzz_below(m->random, 3) != 0;
        put_bits(m, m->zeros[i], 1);
    }
}

size_t tile_make(fuzz_random *random, uint8_t *input, uint8_t *texels) {
    static making m;
    tile t;
    m.random = random;
    choose_shape(&m, &t);
    choose_fields(&m);
    tile_store_head(&t, input);
    uint8_t *out = put_fields(&m, input + TILE_HEAD);
    if (m.coded) {
        memset(out, 0, 4096);
        m.out = out;
        m.bit = 0;
        put_zero_map(&m);
        for (uint32_t i = 0; i < m.table_count; i++) {
            uint16_t f[256];
            make_table(&m, &m.tables[i], f);
            put_table(&m, f);
        }
        out += (m.bit + 7) / 8;
    }
    choose_samples(&m);
    if (m.coded)
        out = put_samples(&m, out);
    restore(&m, texels);
    return (size_t)(out - input);
}
