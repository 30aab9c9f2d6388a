/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: the gradient density mask is what equations 2 and 3 of the paper say, found here a second time by trying
 * every path until nothing changes; it is 0 on the border, 1 behind edges as strong as tau, and the same with any
 * number of threads. It matters because the mask decides where the seam runs: a path that slips through an edge would
 * put the seam across an object.
 */
#include "author_adjust.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double code_of(float value) {
    return (double)zt_transfer_encode(13, value < 0.0f ? 0.0f : value > 1.0f ? 1.0f : value);
}

static double gradient(const author_picture *p, uint32_t c, uint32_t x, uint32_t y) {
    const float *t = p->texels + ((size_t)y * p->width + x) * p->channels + c;
    size_t across = p->channels, down = (size_t)p->width * p->channels;
    return (fabs(code_of(t[across]) - code_of(*(t - across))) + fabs(code_of(t[down]) - code_of(*(t - down)))) / 2.0;
}

/* Least cost to the border of every texel: relaxed over all texels until a pass changes nothing. */
static void brute_force(const author_picture *p, uint32_t c, double *cost) {
    uint32_t w = p->width, h = p->height;
    for (uint32_t i = 0; i < w * h; i++)
        cost[i] = i % w == 0 || i % w == w - 1 || i / w == 0 || i / w == h - 1 ? 0.0 : HUGE_VAL;
    for (int changed = 1; changed;) {
        changed = 0;
        for (uint32_t i = 0; i < w * h; i++) {
            if (cost[i] == 0.0 && (i % w == 0 || i % w == w - 1 || i / w == 0 || i / w == h - 1))
                continue;
            double near = fmin(fmin(cost[i - 1], cost[i + 1]), fmin(cost[i - w], cost[i + w]));
            double sum = near + gradient(p, c, i % w, i / w);
            if (sum < cost[i]) {
                cost[i] = sum;
                changed = 1;
            }
        }
    }
}

static int compare(const char *name, const author_picture *p, double tau, uint32_t ramp, unsigned threads) {
    author_picture mask;
    zt_threads *pool;
    assert(zt_threads_open(threads, &pool) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(pool);
    author_run run = {.parallel = &parallel};
    author_mask_options options = {.tau = tau, .ramp = ramp};
    double used, worst = 0.0, *cost[3] = {0};
    assert(author_gradient_mask(&run, p, &options, &mask, &used) == AUTHOR_OK);
    uint32_t colours = p->channels < 3 ? 1 : 3, w = p->width, h = p->height;
    for (uint32_t c = 0; c < colours; c++) {
        cost[c] = malloc(sizeof(double) * w * h);
        assert(cost[c]);
        brute_force(p, c, cost[c]);
    }
    for (uint32_t i = 0; i < w * h; i++) {
        double most = 0.0;
        for (uint32_t c = 0; c < colours; c++)
            most = fmax(most, cost[c][i]);
        double wanted = fmin(most / used, 1.0) * (double)author_ramp(w, h, ramp, i % w, i / w);
        worst = fmax(worst, fabs(wanted - (double)mask.texels[i]));
    }
    for (uint32_t c = 0; c < colours; c++)
        free(cost[c]);
    author_picture_release(&mask);
    zt_threads_close(pool);
    /* Codes are rounded to 1/4096, and a path has up to a hundred texels. */
    if (worst <= 100.0 / 8192.0 / used && (tau == 0.0 || tau == used))
        return 0;
    printf("%s, tau %g (used %g), %u threads: off by %g\n", name, tau, used, threads, worst);
    return 1;
}

static author_picture noise(uint32_t w, uint32_t h, uint32_t channels, uint64_t seed, float strength) {
    author_run run = {0};
    author_picture p;
    author_random random;
    author_random_seed(&random, seed, 1);
    assert(author_picture_create(&run, w, h, channels, &p) == AUTHOR_OK);
    for (size_t i = 0; i < (size_t)w * h * channels; i++)
        p.texels[i] = 0.3f + strength * (float)(author_random_unit(&random) - 0.5);
    return p;
}

/* A disc of contrast 0.6 on even ground: all of it is 0.6 deep, however it is turned. */
static int check_disc(void) {
    author_picture p = noise(64, 64, 1, 1, 0.0f), mask;
    author_run run = {0};
    author_mask_options options = {.tau = 1.0};
    int bad = 0;
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++)
            p.texels[y * 64 + x] = zt_transfer_decode(13, hypot(x - 31.5, y - 31.5) < 20.0 ? 0.8f : 0.2f);
    assert(author_gradient_mask(&run, &p, &options, &mask, NULL) == AUTHOR_OK);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            double r = hypot(x - 31.5, y - 31.5), wanted = r < 18.0 ? 0.6 : 0.0;
            if ((r >= 18.0 && r < 22.0) || fabs((double)mask.texels[y * 64 + x] - wanted) < 0.01)
                continue;
            printf("disc: %g at %d, %d, not %g\n", (double)mask.texels[y * 64 + x], x, y, wanted);
            bad = 1;
            y = x = 64;
        }
    author_picture_release(&p);
    author_picture_release(&mask);
    return bad;
}

static int check_border(const author_picture *p) {
    author_run run = {0};
    author_picture mask;
    int bad = 0;
    assert(author_gradient_mask(&run, p, NULL, &mask, NULL) == AUTHOR_OK);
    for (uint32_t i = 0; i < p->width * p->height; i++) {
        uint32_t x = i % p->width, y = i / p->width;
        int border = x == 0 || y == 0 || x + 1 == p->width || y + 1 == p->height;
        bad |= border ? mask.texels[i] != 0.0f : !(mask.texels[i] >= 0.0f && mask.texels[i] <= 1.0f);
    }
    author_picture_release(&mask);
    if (bad)
        printf("%u x %u: border or range\n", (unsigned)p->width, (unsigned)p->height);
    return bad;
}

static int check_refusals(void) {
    author_picture p = noise(8, 8, 3, 1, 0.1f), mask;
    int bad = 0;
    for (int i = 0; i < 2; i++) {
        author_run run = {0};
        author_mask_options options = {.tau = i ? -1.0 : AUTHOR_TAU_MOST * 2.0};
        bad |= author_gradient_mask(&run, &p, &options, &mask, NULL) != AUTHOR_BAD_INPUT || mask.texels ||
               !run.error[0];
    }
    if (bad)
        puts("a tau that cannot be was taken");
    author_picture_release(&p);
    return bad;
}

int main(void) {
    static const uint32_t sizes[][2] = {{1, 1}, {1, 9}, {2, 2}, {3, 3}, {4, 3}, {9, 2}, {33, 17}, {40, 40}};
    int bad = check_disc() | check_refusals();
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        for (uint32_t channels = 1; channels <= 4; channels++) {
            author_picture p = noise(sizes[i][0], sizes[i][1], channels, i * 4 + channels, 0.02f * (float)(1 + i));
            bad |= check_border(&p);
            bad |= compare("noise", &p, 0.0, 1, 1) | compare("noise", &p, 0.3, 4, 2) | compare("noise", &p, 4.0, 2, 3);
            author_picture_release(&p);
        }
    }
    return bad;
}
