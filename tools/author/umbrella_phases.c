/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where coarser levels are fitted and measured: at pixels of a grid, of this grid shifted by half a pixel along one
 * side or both, and of all these shifted by a quarter along both. Hardly a lookup lies in the middle of a pixel of one
 * grid.
 */
#include <math.h>

#include "umbrella_private.h"

static uint32_t into(int64_t at, uint32_t count, int repeat) {
    if (repeat)
        return (uint32_t)((at + count) % count);
    return at < 0 ? 0 : at >= count ? count - 1 : (uint32_t)at;
}

/* The mean of 4 x 4 texels around the upper left corner of texel (x, y). */
static void mean_around(const author_picture *fine, const int repeat[2], uint32_t x, uint32_t y, float out[4]) {
    double sum[4] = {0, 0, 0, 0};
    for (int i = 0; i < 16; i++) {
        size_t px = into((int64_t)x + i % 4 - 2, fine->width, repeat[0]);
        size_t py = into((int64_t)y + i / 4 - 2, fine->height, repeat[1]);
        for (size_t c = 0; c < 4; c++)
            sum[c] += (double)fine->texels[4 * (py * fine->width + px) + c] / 16;
    }
    for (size_t c = 0; c < 4; c++)
        out[c] = (float)sum[c];
}

author_result author_umbrella_phases(author_run *run, const author_picture *picture, uint32_t width, uint32_t height,
                                     const int repeat[2], author_picture *out) {
    author_picture fine = {0};
    *out = (author_picture){0};
    author_result result = author_umbrella_average(run, picture, 2 * width, 2 * height, &fine);
    if (result == AUTHOR_OK)
        result = author_picture_create(run, width, 2 * height, 4, out);
    for (uint32_t y = 0; result == AUTHOR_OK && y < 2 * height; y++)
        for (uint32_t x = 0; x < width; x++)
            mean_around(&fine, repeat, 2 * x + (y >= height), 2 * (y % height) + (y >= height),
                        out->texels + 4 * ((size_t)y * width + x));
    author_picture_release(&fine);
    return result;
}

/* ---- errors ------------------------------------------------------------------------------------------------ */

static double coded(double value) {
    return (double)zt_transfer_encode(ZT_TRANSFER_SRGB, (float)fmin(fmax(value, 0), 1));
}

void umb_add_error(author_phase_errors *errors, const author_picture *wanted, size_t texel, double shown) {
    size_t x = texel / 4 % wanted->width, y = texel / 4 / wanted->width;
    int is_middle = y < wanted->height / 2 && x & y & 1;
    author_error *e = texel % 4 == 3 ? &errors->alpha : is_middle ? &errors->pixels : &errors->between;
    double value = (double)wanted->texels[texel];
    double off = coded(shown) - coded(value);
    e->coded += off * off;
    e->linear += (shown - value) * (shown - value);
    e->count++;
}

void author_umbrella_compare(const author_picture *shown, const author_picture *wanted, author_phase_errors *errors) {
    *errors = (author_phase_errors){0};
    for (size_t i = 0; i < (size_t)shown->width * shown->height * 4; i++)
        umb_add_error(errors, wanted, i, (double)shown->texels[i]);
}

void author_umbrella_bilinear(const author_picture *wanted, const int repeat[2], author_phase_errors *errors) {
    uint32_t width = wanted->width, height = wanted->height / 2;
    *errors = (author_phase_errors){0};
    for (size_t i = 0; i < (size_t)width * 2 * height * 4; i++) {
        uint32_t x = (uint32_t)(i / 4 % width), y = (uint32_t)(i / 4 / width), second = y >= height;
        /* From the middle of the pixel before, in quarters of a pixel. */
        uint32_t right = (x & 1 ? 0u : 2u) + second, down = (y % height & 1 ? 0u : 2u) + second;
        int64_t x0 = (int64_t)x - (x & 1 ? 0 : 1), y0 = (int64_t)(y % height) - (y % height & 1 ? 0 : 1);
        double sum = 0;
        for (uint32_t corner = 0; corner < 4; corner++) {
            size_t px = into(x0 + (corner & 1 ? 2 : 0), width, repeat[0]);
            size_t py = into(y0 + (corner & 2 ? 2 : 0), height, repeat[1]);
            double weight = (double)(corner & 1 ? right : 4 - right) * (corner & 2 ? down : 4 - down);
            sum += weight * (double)wanted->texels[4 * (py * width + px) + i % 4] / 16;
        }
        umb_add_error(errors, wanted, i, sum);
    }
}

double umb_decibel(double squares, size_t count) {
    return squares > 0 ? -10 * log10(squares / (double)count) : INFINITY;
}

void author_umbrella_figures(const author_phase_errors *errors, const author_phase_errors *mipmap,
                             author_level_report *report) {
    report->psnr = umb_decibel(errors->pixels.coded, errors->pixels.count);
    report->linear_psnr = umb_decibel(errors->pixels.linear, errors->pixels.count);
    report->between_psnr = umb_decibel(errors->between.coded, errors->between.count);
    report->between_linear_psnr = umb_decibel(errors->between.linear, errors->between.count);
    report->alpha_psnr = umb_decibel(errors->alpha.linear, errors->alpha.count);
    report->mipmap_psnr = umb_decibel(mipmap->between.coded, mipmap->between.count);
}
