/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The picture that a silmap shows, and how far it is from the original. A texel of the original is the mean over its
 * box, so it is compared with the mean over the same box: of the colours as displayed, since that is what drawing
 * programs average and what people see the errors of. Where no line passes through the box, its centre is its mean.
 */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- colours as displayed ------------------------------------------------------------------------------- */

#define TARGET_TEXELS 4 /* along a cell are enough to fit it to */

void silmap_curve_set(silmap_curve *curve, uint32_t channels, int plain) {
    *curve = (silmap_curve){.colours = plain ? 0 : channels, .alpha = -1};
    if (channels == 2 || channels == 4) {
        curve->alpha = (int)channels - 1;
        curve->colours = plain ? 0 : channels - 1;
    }
    for (int i = 0; i < SILMAP_CURVE + 2; i++) {
        double root = (double)i / SILMAP_CURVE;
        curve->table[i] = (float)(1.055 * pow(root * root, 1 / 2.4) - 0.055);
    }
}

void silmap_texel(const author_picture *picture, const silmap_curve *curve, size_t index, float out[SILMAP_CHANNELS]) {
    const float *texel = picture->texels + index * picture->channels;
    float alpha = curve->alpha >= 0 ? texel[curve->alpha] : 1;
    for (uint32_t ch = 0; ch < picture->channels; ch++)
        out[ch] = (int)ch == curve->alpha ? alpha : texel[ch] * alpha;
}

/* ---- what it is compared with --------------------------------------------------------------------------- */

typedef struct target_job {
    const author_picture *picture;
    const silmap_curve *curve;
    float *target;
    uint32_t factor, width;
} target_job;

static author_result target_row(void *context, size_t y, unsigned worker, char *error) {
    (void)worker, (void)error;
    const target_job *job = context;
    uint32_t channels = job->picture->channels;
    float scale = 1.0f / (float)(job->factor * job->factor);
    float *out = job->target + y * job->width * channels;
    for (uint32_t i = 0; i < job->factor; i++) {
        size_t row = (y * job->factor + i) * job->picture->width;
        for (uint32_t x = 0; x < job->picture->width; x++) {
            float texel[SILMAP_CHANNELS];
            silmap_texel(job->picture, job->curve, row + x, texel);
            for (uint32_t ch = 0; ch < channels; ch++)
                out[x / job->factor * channels + ch] += scale * silmap_code(job->curve, ch, texel[ch]);
        }
    }
    return AUTHOR_OK;
}

author_result silmap_target_create(author_run *run, const author_picture *picture, const silmap_curve *curve,
                                   const silmap_grid *grid, float **out, uint32_t *width, uint32_t *height) {
    uint32_t across = picture->width / grid->w, down = picture->height / grid->h;
    uint32_t factor = (across < down ? across : down) / TARGET_TEXELS;
    factor = factor ? factor : 1;
    while (picture->width % factor || picture->height % factor)
        factor--;
    *width = picture->width / factor;
    *height = picture->height / factor;
    *out = author_alloc(run, (size_t)*width * *height * picture->channels, sizeof **out);
    target_job job = {picture, curve, *out, factor, *width};
    return *out ? author_for(run, "picture", *height, target_row, &job) : AUTHOR_NO_MEMORY;
}

silmap_model silmap_full(const silmap_model *model) {
    silmap_model full = *model;
    full.target = NULL;
    full.width = model->picture->width;
    full.height = model->picture->height;
    return full;
}

void silmap_wanted(const silmap_model *model, size_t index, float out[SILMAP_CHANNELS]) {
    uint32_t channels = model->picture->channels;
    if (model->target) {
        for (uint32_t ch = 0; ch < channels; ch++)
            out[ch] = model->target[index * channels + ch];
        return;
    }
    silmap_texel(model->picture, model->curve, index, out);
    for (uint32_t ch = 0; ch < channels; ch++)
        out[ch] = silmap_code(model->curve, ch, out[ch]);
}

void silmap_range(const author_picture *picture, const silmap_curve *curve, float low[SILMAP_CHANNELS],
                  float high[SILMAP_CHANNELS]) {
    size_t texels = (size_t)picture->width * picture->height;
    for (uint32_t ch = 0; ch < SILMAP_CHANNELS; ch++) {
        low[ch] = INFINITY;
        high[ch] = -INFINITY;
    }
    for (size_t i = 0; i < texels; i++) {
        float texel[SILMAP_CHANNELS];
        silmap_texel(picture, curve, i, texel);
        for (uint32_t ch = 0; ch < picture->channels; ch++) {
            low[ch] = fminf(low[ch], texel[ch]);
            high[ch] = fmaxf(high[ch], texel[ch]);
        }
    }
}

/* ---- texels --------------------------------------------------------------------------------------------- */

/* First texel with its centre at or behind the border of cell i of n. */
static uint32_t first_texel(uint64_t i, uint32_t n, uint32_t texels) {
    /* (t + 1/2) / texels >= i / n */
    uint64_t twice = 2 * i * texels;
    return (uint32_t)(twice < n ? 0 : (twice - n + 2 * (uint64_t)n - 1) / (2 * (uint64_t)n));
}

silmap_span silmap_texels(const silmap_model *model, size_t c) {
    uint32_t w = model->grid->w, h = model->grid->h;
    uint64_t x = c % w, y = c / w;
    return (silmap_span){first_texel(x, w, model->width), first_texel(x + 1, w, model->width),
                         first_texel(y, h, model->height), first_texel(y + 1, h, model->height)};
}

static double within(double v) {
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

silmap_view silmap_view_of(const silmap_model *model, size_t c) {
    const silmap_grid *grid = model->grid;
    zt_silmap_cell bytes = silmap_look(grid, c);
    silmap_view view = {.model = model, .span = silmap_texels(model, c)};
    zt_silmap_shape_of(&bytes, &view.shape);
    view.left = (double)(c % grid->w);
    view.top = (double)(c / grid->w);
    view.sx = (double)grid->w / model->width;
    view.sy = (double)grid->h / model->height;
    for (int k = 0; k < 4; k++)
        view.corners[k] = model->samples + silmap_corner(grid, c, k) * model->picture->channels;
    return view;
}

void silmap_split(const silmap_view *view, uint32_t x, uint32_t y, silmap_pattern pattern, silmap_parts *out) {
    const zt_silmap_shape *shape = &view->shape;
    zt_silmap_filter filter = view->model->filter;
    double sx = view->sx, sy = view->sy, x0 = x * sx - view->left, y0 = y * sy - view->top;
    int n = pattern.plain, first = 0, crossed = 0;
    if (!shape->cut && filter != ZT_SILMAP_NEAREST) {
        /* bilinear, whatever the quadrant */
    } else if (pattern.crossed == n) {
        crossed = 1; /* it does not matter */
    } else {
        first = zt_silmap_shape_quadrant(shape, within(x0), within(y0));
        for (int k = 1; k < 4; k++)
            crossed |= first != zt_silmap_shape_quadrant(shape, within(x0 + (k & 1) * sx), within(y0 + (k >> 1) * sy));
        n = crossed ? pattern.crossed : n;
    }
    out->count = n * n;
    for (int j = 0, i = 0; j < n; j++) {
        double v = within(y0 + (j + 0.5) * sy / n);
        for (int k = 0; k < n; k++, i++) {
            double u = within(x0 + (k + 0.5) * sx / n);
            int quadrant = crossed ? zt_silmap_shape_quadrant(shape, u, v) : first;
            out->limited[i] = zt_silmap_shape_weights(filter, shape, quadrant, u, v, out->weights[i]);
        }
    }
}

float silmap_limited(const silmap_parts *parts, int part, const float *const corners[4], uint32_t channel,
                     float value) {
    float low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 4; k++) {
        if (!(parts->limited[part] >> k & 1))
            continue;
        low = fminf(low, corners[k][channel]);
        high = fmaxf(high, corners[k][channel]);
    }
    return fminf(fmaxf(value, low), high);
}

static double texel_error(const silmap_view *view, const silmap_parts *parts, size_t index) {
    const silmap_model *model = view->model;
    float wanted[SILMAP_CHANNELS];
    silmap_wanted(model, index, wanted);
    double sum = 0;
    for (uint32_t ch = 0; ch < model->picture->channels; ch++) {
        float shown = 0;
        for (int i = 0; i < parts->count; i++)
            shown += silmap_code(model->curve, ch, silmap_value(parts, i, view->corners, ch));
        sum += silmap_squared(shown, parts->count, wanted[ch]);
    }
    return sum;
}

double silmap_cell_error(const silmap_view *view, silmap_pattern pattern) {
    const silmap_span *span = &view->span;
    double sum = 0;
    silmap_parts parts;
    for (uint32_t y = span->y0; y < span->y1; y++) {
        for (uint32_t x = span->x0; x < span->x1; x++) {
            silmap_split(view, x, y, pattern, &parts);
            sum += texel_error(view, &parts, (size_t)y * view->model->width + x);
        }
    }
    return sum;
}

typedef struct error_job {
    const silmap_model *model;
    silmap_pattern pattern;
    double *errors;
} error_job;

static author_result visit_error(void *context, size_t c, unsigned worker) {
    (void)worker;
    error_job *job = context;
    silmap_view view = silmap_view_of(job->model, c);
    job->errors[c] = silmap_cell_error(&view, job->pattern);
    return AUTHOR_OK;
}

author_result silmap_errors(author_run *run, const silmap_model *model, silmap_pattern pattern, double *errors) {
    error_job job = {model, pattern, errors};
    return silmap_each(run, "errors", NULL, (size_t)model->grid->w * model->grid->h, visit_error, &job);
}

double silmap_sum(const double *errors, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += errors[i];
    return sum;
}

double silmap_psnr(const author_picture *picture, double sum) {
    double mean = sum / ((double)picture->width * picture->height * picture->channels);
    return mean > 1e-10 ? -10 * log10(mean) : 100;
}
