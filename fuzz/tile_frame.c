/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tiles whose stored bytes hold a zstd frame, from random numbers: those of codec 2 (spec/ztex.md section 6.4, Frames)
 * and those of codec 4 (section 6.5). Written from the specification alone; frames consist of raw and run-length
 * blocks.
 */
#include "tile.h"

enum { COLOUR = 1, FRAME = 16, NORMAL = 32, MOST_BYTES = TILE_TEXELS * 8 };

const uint32_t tile_fields[TILE_FIELD_FORMATS][4] = {{4, 4}, {2, 6, 4, 4}, {2, 6}, {2, 6, 2, 6}, {8, 8}};

/* A frame of the profile of section 6.1. Returns its end. */
static uint8_t *put_frame(fuzz_random *random, const uint8_t *content, size_t size, uint8_t *out) {
    fuzz_store(out, 0xFD2FB528, 4);
    out[4] = 0xA0; /* single segment, a content size of 4 bytes */
    fuzz_store(out + 5, size, 4);
    out += 9;
    for (size_t at = 0; at < size;) {
        size_t n = 1, most = 1 + fuzz_below(random, 3000);
        while (at + n < size && n < most && content[at + n] == content[at])
            n++;
        bool run = n > 3;
        while (!run && at + n < size && n < most)
            n++;
        fuzz_store(out, (uint32_t)(at + n == size) | (uint32_t)run << 1 | (uint32_t)n << 3, 3);
        memcpy(out + 3, content + at, run ? 1 : n);
        out += 3 + (run ? 1 : n);
        at += n;
    }
    return out;
}

static void random_bytes(fuzz_random *random, uint8_t *bytes, size_t size) {
    uint32_t run = 1 + fuzz_below(random, 40), spread = 1 + fuzz_below(random, 256);
    for (size_t i = 0; i < size; i++)
        bytes[i] = i > 0 && fuzz_below(random, run) ? bytes[i - 1] : (uint8_t)fuzz_below(random, spread);
}

static void choose_places(fuzz_random *random, tile *t) {
    t->gap = fuzz_below(random, 8);
    t->stored_low = fuzz_below(random, 2) != 0;
    t->dst_low = fuzz_below(random, 2) != 0;
}

/* ---- codec 4 ---- */

size_t tile_make_fields(fuzz_random *random, uint8_t *input, uint8_t *blocks) {
    static uint8_t content[MOST_BYTES];
    tile t = {.width = 1 + fuzz_below(random, 40), .height = 1 + fuzz_below(random, 12)};
    t.channels = t.channel_bytes = 1;
    t.fields = 1 + fuzz_below(random, TILE_FIELD_FORMATS);
    choose_places(random, &t);
    const uint32_t *sizes = tile_fields[t.fields - 1];
    size_t step = tile_texel_bytes(&t), count = (size_t)t.width * t.height;
    random_bytes(random, content, step * count);
    for (size_t i = 0, o = 0; o < step; o += sizes[i++])
        for (size_t j = 0; j < count; j++)
            memcpy(blocks + step * j + o, content + count * o + sizes[i] * j, sizes[i]);
    tile_store_head(&t, input);
    return (size_t)(put_frame(random, content, step * count, input + TILE_HEAD) - input);
}

/* ---- codec 2 with a frame ---- */

typedef struct making {
    tile t;
    uint32_t flags, form;
    uint8_t *texels;
    const uint8_t *samples;
} making;

static uint32_t load(const making *m, size_t at) {
    return m->texels[at] | (m->t.channel_bytes == 2 ? (uint32_t)m->texels[at + 1] << 8 : 0);
}

static void add(const making *m, size_t at, uint32_t more) {
    fuzz_store(m->texels + at, load(m, at) + more, m->t.channel_bytes);
}

/* The residual of channel c of the texel (x, y). */
static uint32_t residual(const making *m, uint32_t x, uint32_t y, uint32_t c) {
    uint32_t n = m->t.channels, bytes = m->t.channel_bytes, z;
    size_t texel = (size_t)y * m->t.width + x, all = (size_t)m->t.width * m->t.height;
    if (m->form & 4) {
        const uint8_t *p = m->samples + (texel * n + c) * bytes;
        z = bytes == 2 ? p[0] | (uint32_t)p[1] << 8 : p[0];
    } else {
        uint32_t j = n >= 3 && c < 2 ? 1 - c : c;
        z = m->samples[j * bytes * all + texel];
        z = bytes == 2 ? z << 8 | m->samples[(j * bytes + 1) * all + texel] : z;
    }
    return bytes == 2 ? z >> 1 ^ (0 - (z & 1)) : z;
}

static void restore_value(const making *m, uint32_t x, uint32_t y, uint32_t c) {
    size_t step = tile_texel_bytes(&m->t), row = step * m->t.width;
    size_t at = y * row + x * step + (size_t)c * m->t.channel_bytes;
    uint32_t predictor = m->form & 3, p = 0;
    bool left = predictor == 1 ? x > 0 : predictor == 2 && y == 0 && x > 0;
    bool above = predictor == 1 ? x == 0 && y > 0 : predictor == 2 && y > 0;
    if (left || above)
        p = load(m, at - (left ? step : row));
    fuzz_store(m->texels + at, p + residual(m, x, y, c), m->t.channel_bytes);
}

/* The third component of a unit vector. */
static uint32_t third(int r, int g) {
    int s = 255 * 255 - (2 * r - 255) * (2 * r - 255) - (2 * g - 255) * (2 * g - 255), root = 0;
    while (s > 0 && (root + 1) * (root + 1) <= s)
        root++;
    return s > 0 ? (uint32_t)(256 + root) >> 1 : 128;
}

static void restore(const making *m) {
    const tile *t = &m->t;
    for (uint32_t y = 0; y < t->height; y++)
        for (uint32_t i = 0; i < t->width * t->channels; i++)
            restore_value(m, i / t->channels, y, i % t->channels);
    for (size_t i = 0; i < (size_t)t->width * t->height; i++) {
        size_t at = i * tile_texel_bytes(t), bytes = t->channel_bytes;
        uint32_t green = m->flags & COLOUR ? load(m, at + bytes) : 0;
        if (m->flags & COLOUR)
            add(m, at, green);
        if (m->flags & COLOUR)
            add(m, at + 2 * bytes, green);
        if (m->flags & NORMAL)
            add(m, at + 2, third(m->texels[at], m->texels[at + 1]));
    }
}

size_t tile_make_frame(fuzz_random *random, uint8_t *input, uint8_t *texels) {
    static const uint8_t transforms[] = {0, COLOUR, NORMAL};
    static uint8_t samples[MOST_BYTES];
    making m = {.texels = texels, .samples = samples};
    m.t.width = 1 + fuzz_below(random, fuzz_below(random, 4) ? 12 : 150);
    m.t.height = 1 + fuzz_below(random, 8);
    m.t.channels = 1 + fuzz_below(random, 4);
    m.t.channel_bytes = 1 + fuzz_below(random, 2);
    choose_places(random, &m.t);
    uint32_t possible = m.t.channels < 3 ? 1 : m.t.channel_bytes == 1 ? 3 : 2;
    m.flags = FRAME | transforms[fuzz_below(random, possible)];
    m.form = fuzz_below(random, 3) | fuzz_below(random, 2) << 2;
    size_t size = tile_texel_bytes(&m.t) * m.t.width * m.t.height;
    random_bytes(random, samples, size);
    restore(&m);
    tile_store_head(&m.t, input);
    input[TILE_HEAD] = (uint8_t)m.flags;
    input[TILE_HEAD + 1] = (uint8_t)m.form;
    return (size_t)(put_frame(random, samples, size, input + TILE_HEAD + 2) - input);
}
