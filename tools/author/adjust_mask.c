/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradient density mask (Eisemann and Magnor, equations 2 and 3).
 *
 * The cost of a path is the sum of |I_x| + |I_y| over its texels: central differences and steps to the four neighbours,
 * since with other choices paths slip through thin edges. It is counted in whole numbers, so there is one answer
 * whatever the order in which texels are improved, until none can be: tiles that fit a cache, and only those into which
 * a neighbour spreads. What costs as much as opaque is not told apart any more, so nothing deeper is looked at.
 */
#include "author_adjust.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CODES 4096       /* of the full range of a channel */
#define UNIT (2 * CODES) /* of cost: central differences are halves of differences of codes */
#define TILE 64u
#define LEAST_TAU 0.05 /* of the range, when the picture decides */
#define MOST_TAU 0.5
#define RING_FROM 0.05 /* depth of the ring whose median cost is tau, of the shorter side */
#define RING_TO 0.1
#define TABLE 4096

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

float author_ramp(uint32_t width, uint32_t height, uint32_t ramp, uint32_t x, uint32_t y) {
    uint32_t inside = least(least(x, width - 1 - x), least(y, height - 1 - y));
    ramp = least(ramp, (least(width, height) - 1) / 2);
    if (inside == 0)
        return 0.0f;
    return inside >= ramp ? 1.0f : (float)inside / (float)ramp;
}

typedef struct mask_work {
    const author_picture *picture;
    author_picture *mask;
    uint32_t ramp, limit; /* cost from which on nothing is told apart */
    uint16_t *table;      /* linear light, by its root, to the sRGB code */
    uint16_t *costs[3];   /* of paths in each channel, at most limit */
} mask_work;

/* One channel while it is searched. */
typedef struct search {
    uint32_t width, height;
    uint32_t across, down; /* tiles */
    uint16_t *own, *paths; /* cost of each texel, and of its path so far */
    uint8_t *active;       /* tiles beside which something has changed */
} search;

/* ---- one channel --------------------------------------------------------------------------------------------- */

static void fill_table(uint16_t *table) {
    for (int i = 0; i <= TABLE; i++) {
        float root = (float)i / TABLE;
        table[i] = (uint16_t)(zt_transfer_encode(ZT_TRANSFER_SRGB, root * root) * CODES + 0.5f);
    }
}

static uint16_t code_of(const mask_work *w, float value) {
    return w->table[(int)(sqrtf(fminf(fmaxf(value, 0.0f), 1.0f)) * TABLE + 0.5f)];
}

static uint16_t difference(uint16_t a, uint16_t b) {
    return (uint16_t)(a > b ? a - b : b - a);
}

/* Codes in place of costs first; then, row by row, the sums of the central differences. rows: three rows of scratch. */
static void find_costs(const mask_work *w, uint32_t channel, const search *s, uint16_t *rows) {
    uint32_t width = s->width, step = w->picture->channels;
    for (uint32_t y = 0; y < s->height; y++) {
        const float *from = w->picture->texels + (size_t)y * width * step + channel;
        uint16_t *here = rows + (size_t)(y % 3) * width;
        for (uint32_t x = 0; x < width; x++)
            here[x] = code_of(w, from[(size_t)x * step]);
        if (y < 2)
            continue;
        const uint16_t *middle = rows + (size_t)((y - 1) % 3) * width, *above = rows + (size_t)((y - 2) % 3) * width;
        uint16_t *own = s->own + (size_t)(y - 1) * width;
        for (uint32_t x = 1; x + 1 < width; x++)
            own[x] = (uint16_t)(difference(middle[x - 1], middle[x + 1]) + difference(above[x], here[x]));
    }
}

static int improve(uint16_t *path, uint32_t own, uint16_t a, uint16_t b) {
    uint32_t sum = own + (a < b ? a : b);
    if (sum >= *path)
        return 0;
    *path = (uint16_t)sum;
    return 1;
}

/* The texels of a tile that are not on the border of the picture. */
typedef struct tile {
    uint32_t x0, y0, x1, y1;
} tile;

static tile tile_at(const search *s, uint32_t index) {
    uint32_t x = index % s->across * TILE, y = index / s->across * TILE;
    return (tile){x ? x : 1, y ? y : 1, least(x + TILE, s->width - 1), least(y + TILE, s->height - 1)};
}

/* From the left and above, then from the right and below, until nothing changes. */
static int settle(const search *s, const tile *t) {
    size_t width = s->width;
    int changed = 1, any = 0;
    while (changed) {
        changed = 0;
        for (uint32_t y = t->y0; y < t->y1; y++) {
            uint16_t *path = s->paths + y * width;
            const uint16_t *own = s->own + y * width;
            for (uint32_t x = t->x0; x < t->x1; x++)
                changed |= improve(&path[x], own[x], path[x - 1], *(path + x - width));
        }
        for (uint32_t y = t->y1; y-- > t->y0;) {
            uint16_t *path = s->paths + y * width;
            const uint16_t *own = s->own + y * width;
            for (uint32_t x = t->x1; x-- > t->x0;)
                changed |= improve(&path[x], own[x], path[x + 1], path[x + width]);
        }
        any |= changed;
    }
    return any;
}

/* The neighbours look again, whichever edge has changed: most often it is all of them. */
static void visit(const search *s, uint32_t index) {
    tile t = tile_at(s, index);
    uint32_t x = index % s->across, y = index / s->across;
    s->active[index] = 0;
    if (t.x0 >= t.x1 || t.y0 >= t.y1 || !settle(s, &t))
        return;
    if (x > 0)
        s->active[index - 1] = 1;
    if (x + 1 < s->across)
        s->active[index + 1] = 1;
    if (y > 0)
        s->active[index - s->across] = 1;
    if (y + 1 < s->down)
        s->active[index + s->across] = 1;
}

static void spread(const search *s) {
    uint32_t tiles = s->across * s->down;
    for (uint32_t i = 0; i < tiles; i++) {
        uint32_t x = i % s->across, y = i / s->across;
        s->active[i] = x == 0 || y == 0 || x + 2 >= s->across || y + 2 >= s->down;
    }
    for (int busy = 1; busy;) {
        busy = 0;
        for (uint32_t i = 0; i < tiles; i++)
            if (s->active[i])
                visit(s, i);
        for (uint32_t i = tiles; i-- > 0;)
            if (s->active[i])
                visit(s, i);
        for (uint32_t i = 0; i < tiles && !busy; i++)
            busy = s->active[i];
    }
}

static void start_paths(const search *s, uint16_t limit) {
    for (uint32_t y = 0; y < s->height; y++)
        for (uint32_t x = 0; x < s->width; x++) {
            int border = x == 0 || y == 0 || x + 1 == s->width || y + 1 == s->height;
            s->paths[(size_t)y * s->width + x] = border ? 0 : limit;
        }
}

static author_result search_channel(void *context, size_t channel, unsigned worker, char *error) {
    const mask_work *w = context;
    (void)worker;
    search s = {.width = w->picture->width, .height = w->picture->height, .paths = w->costs[channel]};
    size_t texels = (size_t)s.width * s.height;
    s.across = (s.width + TILE - 1) / TILE;
    s.down = (s.height + TILE - 1) / TILE;
    s.own = malloc(texels * sizeof *s.own);
    s.active = malloc((size_t)s.across * s.down);
    uint16_t *rows = malloc(3 * (size_t)s.width * sizeof *rows);
    int made = s.own && s.active && rows;
    if (made) {
        find_costs(w, (uint32_t)channel, &s, rows);
        start_paths(&s, (uint16_t)w->limit);
        spread(&s);
    } else {
        snprintf(error, AUTHOR_ERROR, "no memory for the mask of a patch of %zu texels", texels);
    }
    free(s.own);
    free(s.active);
    free(rows);
    return made ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* ---- tau ------------------------------------------------------------------------------------------------------- */

static uint32_t cost_at(const mask_work *w, uint32_t channels, size_t texel) {
    uint32_t most = 0;
    for (uint32_t c = 0; c < channels; c++) {
        uint32_t cost = least(w->costs[c][texel], w->limit);
        most = cost > most ? cost : most;
    }
    return most;
}

/* The median cost on the ring. */
static uint32_t ring_median(const mask_work *w, uint32_t channels, uint64_t *histogram) {
    uint32_t width = w->picture->width, height = w->picture->height, side = least(width, height);
    uint32_t from = (uint32_t)(RING_FROM * side), to = (uint32_t)(RING_TO * side) + 1;
    uint64_t count = 0, seen = 0;
    for (uint32_t y = from; y + from < height; y++)
        for (uint32_t x = from; x + from < width; x++) {
            uint32_t depth = least(least(x, width - 1 - x), least(y, height - 1 - y));
            if (depth > to) {
                x = width - 1 - x;
                continue;
            }
            histogram[cost_at(w, channels, (size_t)y * width + x)]++;
            count++;
        }
    uint32_t median = 0;
    while (median < w->limit && (seen += histogram[median]) * 2 < count)
        median++;
    return median;
}

static author_result choose_tau(author_run *run, const mask_work *w, uint32_t channels, double *tau) {
    uint64_t *histogram = author_alloc(run, (size_t)w->limit + 1, sizeof *histogram);
    if (!histogram)
        return AUTHOR_NO_MEMORY;
    *tau = fmin(fmax(ring_median(w, channels, histogram) / (double)UNIT, LEAST_TAU), MOST_TAU);
    free(histogram);
    return AUTHOR_OK;
}

/* ---- all channels ------------------------------------------------------------------------------------------------ */

static void fill_mask(const mask_work *w, uint32_t channels, double tau) {
    uint32_t width = w->picture->width, height = w->picture->height;
    float scale = (float)(1.0 / (tau * UNIT));
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            size_t texel = (size_t)y * width + x;
            float alpha = fminf((float)cost_at(w, channels, texel) * scale, 1.0f);
            w->mask->texels[texel] = alpha * author_ramp(width, height, w->ramp, x, y);
        }
}

static author_result make_mask(author_run *run, mask_work *w, uint32_t channels, double wanted, double *tau) {
    size_t texels = (size_t)w->picture->width * w->picture->height;
    int made = (w->table = author_alloc(run, TABLE + 1, sizeof *w->table)) != NULL;
    for (uint32_t c = 0; c < channels; c++)
        made = made && (w->costs[c] = author_alloc(run, texels, sizeof(uint16_t))) != NULL;
    if (!made)
        return AUTHOR_NO_MEMORY;
    fill_table(w->table);
    author_result result = author_for(run, "mask", channels, search_channel, w);
    if (result == AUTHOR_OK && wanted == 0.0)
        result = choose_tau(run, w, channels, tau);
    if (result == AUTHOR_OK)
        fill_mask(w, channels, *tau);
    return result;
}

author_result author_gradient_mask(author_run *run, const author_picture *picture, const author_mask_options *options,
                                   author_picture *mask, double *tau) {
    double wanted = options ? options->tau : 0.0, used = wanted;
    uint32_t channels = picture->channels - (picture->channels % 2 == 0);
    mask_work w = {.picture = picture, .mask = mask, .ramp = options && options->ramp ? options->ramp : 1};
    *mask = (author_picture){0};
    if (!(wanted >= 0.0 && wanted <= AUTHOR_TAU_MOST))
        return author_fail(run, AUTHOR_BAD_INPUT, "tau is above 0 and at most %g", AUTHOR_TAU_MOST);
    if ((uint64_t)picture->width * picture->height >= UINT32_MAX)
        return author_fail(run, AUTHOR_BAD_INPUT, "a picture of %u x %u is too large for a mask",
                           (unsigned)picture->width, (unsigned)picture->height);
    w.limit = (uint32_t)ceil((wanted > 0.0 ? wanted : MOST_TAU) * UNIT);
    author_result result = author_picture_create(run, picture->width, picture->height, 1, mask);
    if (result == AUTHOR_OK)
        result = make_mask(run, &w, channels, wanted, &used);
    free(w.table);
    for (int c = 0; c < 3; c++)
        free(w.costs[c]);
    if (result != AUTHOR_OK)
        author_picture_release(mask);
    if (tau)
        *tau = result == AUTHOR_OK ? used : 0.0;
    return result;
}
