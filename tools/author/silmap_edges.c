/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Edges for silmaps of photographs: maxima of the gradient along its direction, with hysteresis; those that hang
 * together are a chain, and chains shorter than two cells are dropped. Coded values, because a step that is seen is one
 * of these. A chain cuts the sides that it crosses. It may well propose too much: the fit takes away what does not pay.
 */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TEXELS 4.0      /* of the picture that is searched, along a cell; a finer one is averaged down */
#define HIGH_FLOOR 0.03 /* of a step of 1, after smoothing */
#define HIGH_MEDIANS 2.5
#define LOW_SHARE 0.4
#define CHAIN_CELLS 2
#define BINS 1024

enum { EDGE_NONE, EDGE_WEAK, EDGE_STRONG, EDGE_CHAIN };

typedef struct edge_job {
    const author_picture *picture;
    const silmap_curve *curve;
    silmap_grid *grid;
    uint32_t factor, w, h, channels;
    float *texels, *other; /* w x h x channels */
    float *gx, *gy;        /* w x h */
    uint8_t *kind;
    uint32_t *stack;
    double *sums; /* of each cell: x, y, count; then the nearest place: x, y, distance */
    double low, high;
} edge_job;

/* ---- the gradient --------------------------------------------------------------------------------------- */

static author_result shrink_row(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    edge_job *job = context;
    float scale = 1.0f / (float)(job->factor * job->factor);
    float *out = job->texels + y * job->w * job->channels;
    for (uint32_t i = 0; i < job->factor; i++) {
        size_t row = (y * job->factor + i) * job->picture->width;
        for (uint32_t x = 0; x < job->w * job->factor; x++) {
            float texel[SILMAP_CHANNELS];
            silmap_texel(job->picture, job->curve, row + x, texel);
            for (uint32_t ch = 0; ch < job->channels; ch++)
                out[x / job->factor * job->channels + ch] += scale * silmap_code(job->curve, ch, texel[ch]);
        }
    }
    return AUTHOR_OK;
}

static size_t beside(size_t i, int step, size_t n, int repeat) {
    long long at = (long long)i + step, count = (long long)n;
    if (repeat)
        return (size_t)((at + count) % count);
    return at < 0 ? 0 : at >= count ? n - 1 : (size_t)at;
}

/* Binomial 1 4 6 4 1: a deviation of one texel. */
static void smooth(const float *from, float *to, size_t at, const size_t taps[5], uint32_t channels) {
    for (uint32_t ch = 0; ch < channels; ch++)
        to[at * channels + ch] = (from[taps[0] * channels + ch] + from[taps[4] * channels + ch] +
                                  4 * (from[taps[1] * channels + ch] + from[taps[3] * channels + ch]) +
                                  6 * from[taps[2] * channels + ch]) /
                                 16;
}

static author_result smooth_row_x(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    edge_job *job = context;
    for (size_t x = 0; x < job->w; x++) {
        size_t taps[5];
        for (int k = 0; k < 5; k++)
            taps[k] = y * job->w + beside(x, k - 2, job->w, job->grid->repeat_x && job->w > 4);
        smooth(job->texels, job->other, y * job->w + x, taps, job->channels);
    }
    return AUTHOR_OK;
}

static author_result smooth_row_y(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    edge_job *job = context;
    for (size_t x = 0; x < job->w; x++) {
        size_t taps[5];
        for (int k = 0; k < 5; k++)
            taps[k] = beside(y, k - 2, job->h, job->grid->repeat_y && job->h > 4) * job->w + x;
        smooth(job->other, job->texels, y * job->w + x, taps, job->channels);
    }
    return AUTHOR_OK;
}

/* Of the channel that has the strongest. */
static author_result gradient_row(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    edge_job *job = context;
    size_t up = beside(y, -1, job->h, job->grid->repeat_y) * job->w;
    size_t down = beside(y, 1, job->h, job->grid->repeat_y) * job->w;
    for (size_t x = 0; x < job->w; x++) {
        size_t left = y * job->w + beside(x, -1, job->w, job->grid->repeat_x);
        size_t right = y * job->w + beside(x, 1, job->w, job->grid->repeat_x);
        float most = -1;
        for (uint32_t ch = 0; ch < job->channels; ch++) {
            float gx = (job->texels[right * job->channels + ch] - job->texels[left * job->channels + ch]) / 2;
            float gy = (job->texels[(down + x) * job->channels + ch] - job->texels[(up + x) * job->channels + ch]) / 2;
            if (gx * gx + gy * gy <= most)
                continue;
            most = gx * gx + gy * gy;
            job->gx[y * job->w + x] = gx;
            job->gy[y * job->w + x] = gy;
        }
    }
    return AUTHOR_OK;
}

static float strength(const edge_job *job, long long x, long long y) {
    size_t i = (size_t)(x < 0 ? 0 : x >= job->w ? job->w - 1 : x);
    size_t at = (size_t)(y < 0 ? 0 : y >= job->h ? job->h - 1 : y) * job->w + i;
    return sqrtf(job->gx[at] * job->gx[at] + job->gy[at] * job->gy[at]);
}

/* Between texels, along the gradient. */
static float strength_at(const edge_job *job, float x, float y) {
    float fx = floorf(x), fy = floorf(y);
    long long i = (long long)fx, j = (long long)fy;
    fx = x - fx;
    fy = y - fy;
    return (1 - fy) * ((1 - fx) * strength(job, i, j) + fx * strength(job, i + 1, j)) +
           fy * ((1 - fx) * strength(job, i, j + 1) + fx * strength(job, i + 1, j + 1));
}

/* Whether the texel is a maximum, and how far along the gradient it is, in texels. */
static int is_maximum(const edge_job *job, uint32_t x, uint32_t y, float *offset) {
    size_t at = (size_t)y * job->w + x;
    float m = strength(job, x, y);
    if (!(m > 0))
        return 0;
    float ux = job->gx[at] / m, uy = job->gy[at] / m;
    float before = strength_at(job, (float)x - ux, (float)y - uy);
    float after = strength_at(job, (float)x + ux, (float)y + uy);
    if (m < before || m <= after)
        return 0;
    float curve = before - 2 * m + after;
    float o = curve < 0 ? (before - after) / (2 * curve) : 0;
    *offset = fminf(fmaxf(o, -0.5f), 0.5f);
    return 1;
}

static author_result maxima_row(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    edge_job *job = context;
    for (uint32_t x = 0; x < job->w; x++) {
        float offset;
        double m = (double)strength(job, x, (long long)y);
        if (m >= job->low && is_maximum(job, x, (uint32_t)y, &offset))
            job->kind[y * job->w + x] = m >= job->high ? EDGE_STRONG : EDGE_WEAK;
    }
    return AUTHOR_OK;
}

/* An edge stands out from what the picture has everywhere: texture and noise. */
static void choose_thresholds(edge_job *job, const author_silmap_options *options) {
    size_t bins[BINS] = {0}, texels = (size_t)job->w * job->h, sum = 0;
    for (size_t i = 0; i < texels; i++) {
        float m = sqrtf(job->gx[i] * job->gx[i] + job->gy[i] * job->gy[i]) * BINS;
        bins[m < BINS - 1 ? (size_t)m : BINS - 1]++;
    }
    int median = 0;
    while (median < BINS - 1 && (sum += bins[median]) * 2 < texels)
        median++;
    double floor = HIGH_MEDIANS * (median + 0.5) / BINS;
    job->high = options->edge_high > 0 ? options->edge_high : fmax(HIGH_FLOOR, floor);
    job->low = options->edge_low > 0 ? options->edge_low : LOW_SHARE * job->high;
}

/* ---- chains --------------------------------------------------------------------------------------------- */

/* Marks what hangs together with texel i; it stays if it has a strong one and is long enough. */
static void take_chain(edge_job *job, uint32_t i, size_t shortest) {
    size_t count = 0;
    int strong = 0;
    job->stack[count++] = i;
    strong |= job->kind[i] == EDGE_STRONG;
    job->kind[i] = EDGE_CHAIN;
    for (size_t at = 0; at < count; at++) {
        long long x = job->stack[at] % job->w, y = job->stack[at] / job->w;
        for (int k = 0; k < 9; k++) {
            long long nx = x + k % 3 - 1, ny = y + k / 3 - 1;
            if (nx < 0 || ny < 0 || nx >= job->w || ny >= job->h)
                continue;
            uint32_t next = (uint32_t)(ny * job->w + nx);
            if (job->kind[next] != EDGE_WEAK && job->kind[next] != EDGE_STRONG)
                continue;
            strong |= job->kind[next] == EDGE_STRONG;
            job->kind[next] = EDGE_CHAIN;
            job->stack[count++] = next;
        }
    }
    if (strong && count >= shortest)
        return;
    for (size_t at = 0; at < count; at++)
        job->kind[job->stack[at]] = EDGE_NONE;
}

static void take_chains(edge_job *job) {
    size_t shortest = (size_t)(CHAIN_CELLS * (double)job->w / job->grid->w);
    for (uint32_t i = 0; i < job->w * job->h; i++)
        if (job->kind[i] == EDGE_STRONG)
            take_chain(job, i, shortest);
    for (size_t i = 0; i < (size_t)job->w * job->h; i++)
        if (job->kind[i] != EDGE_CHAIN)
            job->kind[i] = EDGE_NONE;
}

/* ---- cells ---------------------------------------------------------------------------------------------- */

static size_t cell_at(const silmap_grid *grid, double x, double y) {
    size_t i = x <= 0 ? 0 : x >= grid->w ? grid->w - 1 : (size_t)x;
    size_t j = y <= 0 ? 0 : y >= grid->h ? grid->h - 1 : (size_t)y;
    return j * grid->w + i;
}

/* Cuts the sides that a segment crosses; coordinates in cells. */
static void cut_segment(silmap_grid *grid, const double a[2], const double b[2]) {
    for (int axis = 0; axis < 2; axis++) {
        const double *low = a[axis] < b[axis] ? a : b, *high = a[axis] < b[axis] ? b : a;
        double first = ceil(fmax(low[axis], 0)), last = fmin(high[axis], axis ? grid->h - 1 : grid->w - 1);
        for (double k = first; k <= last && high[axis] > low[axis]; k++) {
            double t = (k - low[axis]) / (high[axis] - low[axis]);
            double other = low[1 - axis] + t * (high[1 - axis] - low[1 - axis]);
            size_t c = axis ? cell_at(grid, other, k) : cell_at(grid, k, other);
            silmap_set_cut(grid, c, axis ? SILMAP_N : SILMAP_W, 1);
        }
    }
}

/* Two passes over all places of edges: their mean in each cell, then the place nearest to that. */
static void take_place(edge_job *job, const double at[2], int pass) {
    double *sums = job->sums + 6 * cell_at(job->grid, at[0], at[1]);
    if (pass == 0) {
        sums[0] += at[0];
        sums[1] += at[1];
        sums[2]++;
        sums[5] = INFINITY;
        return;
    }
    double dx = at[0] - sums[0] / sums[2], dy = at[1] - sums[1] / sums[2];
    if (dx * dx + dy * dy < sums[5]) {
        sums[3] = at[0];
        sums[4] = at[1];
        sums[5] = dx * dx + dy * dy;
    }
}

static void set_points(edge_job *job) {
    silmap_grid *grid = job->grid;
    for (size_t c = 0; c < (size_t)grid->w * grid->h; c++) {
        const double *sums = job->sums + 6 * c;
        if (!(sums[2] > 0))
            continue;
        double x = (sums[3] - (double)(c % grid->w)) * 8, y = (sums[4] - (double)(c / grid->w)) * 8;
        unsigned px = x <= 0 ? 0 : x >= 7 ? 7 : (unsigned)x, py = y <= 0 ? 0 : y >= 7 ? 7 : (unsigned)y;
        grid->cells[c] = (uint8_t)((grid->cells[c] & 0xc0) | py << 3 | px);
    }
}

static void place_of(const edge_job *job, uint32_t x, uint32_t y, double out[2]) {
    float offset = 0;
    size_t at = (size_t)y * job->w + x;
    float m = strength(job, x, y);
    is_maximum(job, x, y, &offset);
    offset = m > 0 ? offset / m : 0;
    out[0] = ((double)x + 0.5 + (double)(offset * job->gx[at])) * job->factor * job->grid->w / job->picture->width;
    out[1] = ((double)y + 0.5 + (double)(offset * job->gy[at])) * job->factor * job->grid->h / job->picture->height;
}

static int in_chain(const edge_job *job, long long x, long long y) {
    return x >= 0 && y >= 0 && x < job->w && y < job->h && job->kind[y * job->w + x] == EDGE_CHAIN;
}

/* From a texel of a chain to those at its right and below; diagonally only where there is no way around. */
static void link_texel(edge_job *job, uint32_t x, uint32_t y, const double at[2]) {
    static const int8_t links[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    for (int k = 0; k < 4; k++) {
        long long nx = (long long)x + links[k][0], ny = (long long)y + links[k][1];
        if (!in_chain(job, nx, ny) || (k > 1 && (in_chain(job, nx, y) || in_chain(job, x, ny))))
            continue;
        double to[2];
        place_of(job, (uint32_t)nx, (uint32_t)ny, to);
        cut_segment(job->grid, at, to);
    }
}

static void use_chains(edge_job *job, int pass) {
    for (uint32_t y = 0; y < job->h; y++) {
        for (uint32_t x = 0; x < job->w; x++) {
            double at[2];
            if (!in_chain(job, x, y))
                continue;
            place_of(job, x, y, at);
            take_place(job, at, pass);
            if (pass == 0)
                link_texel(job, x, y, at);
        }
    }
}

static void use_path(edge_job *job, const author_path *path, int pass) {
    double scale[2] = {job->grid->w, job->grid->h};
    for (size_t i = 0; i + !path->closed < path->count; i++) {
        const double *p = path->points + 2 * i, *q = path->points + 2 * ((i + 1) % path->count);
        double a[2] = {p[0] * scale[0], p[1] * scale[1]}, b[2] = {q[0] * scale[0], q[1] * scale[1]};
        if (pass == 0)
            cut_segment(job->grid, a, b);
        double length = fmin(hypot(b[0] - a[0], b[1] - a[1]), 1e6);
        int places = 1 + (int)(length * 16);
        for (int k = 0; k < places; k++) {
            double t = (k + 0.5) / places, at[2] = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
            if (at[0] >= 0 && at[1] >= 0 && at[0] <= scale[0] && at[1] <= scale[1])
                take_place(job, at, pass);
        }
    }
}

/* ---- all together --------------------------------------------------------------------------------------- */

static author_result search_picture(author_run *run, edge_job *job, const author_silmap_options *options) {
    author_result result = author_for(run, "edges", job->h, shrink_row, job);
    if (result == AUTHOR_OK)
        result = author_for(run, "edges", job->h, smooth_row_x, job);
    if (result == AUTHOR_OK)
        result = author_for(run, "edges", job->h, smooth_row_y, job);
    if (result == AUTHOR_OK)
        result = author_for(run, "edges", job->h, gradient_row, job);
    if (result != AUTHOR_OK)
        return result;
    choose_thresholds(job, options);
    result = author_for(run, "edges", job->h, maxima_row, job);
    take_chains(job);
    return result;
}

static author_result edge_memory(author_run *run, edge_job *job) {
    size_t texels = (size_t)job->w * job->h;
    job->texels = author_alloc(run, texels * job->channels, sizeof *job->texels);
    job->other = author_alloc(run, texels * job->channels, sizeof *job->other);
    job->gx = author_alloc(run, texels, sizeof *job->gx);
    job->gy = author_alloc(run, texels, sizeof *job->gy);
    job->kind = author_alloc(run, texels, 1);
    job->stack = author_alloc(run, texels, sizeof *job->stack);
    job->sums = author_alloc(run, (size_t)job->grid->w * job->grid->h, 6 * sizeof *job->sums);
    int all = job->texels && job->other && job->gx && job->gy && job->kind && job->stack && job->sums;
    return all ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

author_result silmap_edges_find(author_run *run, const author_silmap_input *input, const author_silmap_options *options,
                                const silmap_curve *curve, silmap_grid *grid) {
    const author_picture *picture = input->picture;
    edge_job job = {.picture = picture, .curve = curve, .grid = grid, .channels = picture->channels};
    double most = fmin((double)picture->width / grid->w, (double)picture->height / grid->h);
    job.factor = most >= 2 * TEXELS ? (uint32_t)(most / TEXELS) : 1;
    job.w = picture->width / job.factor;
    job.h = picture->height / job.factor;
    author_result result = edge_memory(run, &job);
    if (result == AUTHOR_OK && !input->paths_only)
        result = search_picture(run, &job, options);
    for (int pass = 0; pass < 2 && result == AUTHOR_OK; pass++) {
        use_chains(&job, pass);
        for (size_t p = 0; p < input->path_count; p++)
            use_path(&job, &input->paths[p], pass);
    }
    if (result == AUTHOR_OK)
        set_points(&job);
    silmap_normalise(grid);
    free(job.texels);
    free(job.other);
    free(job.gx);
    free(job.gy);
    free(job.kind);
    free(job.stack);
    free(job.sums);
    return result;
}
