/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The samples. First the mean of what is in a sample's own deformed cell. Then least squares: what a silmap shows is
 * linear in its samples, but for the curve of displayed colours, along whose slope each round goes (Gauss and Newton).
 * The normal equations are kept cell by cell, 4 x 4 for each channel, and solved by Gauss-Seidel in four colours of
 * samples, each clamped to the range of the picture.
 */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SOLVER_SWEEPS 12
#define DAMPING 1e-4
#define TRIES 3
#define CLASSES (SILMAP_CLASSES(2) * SILMAP_CLASSES(2))
#define ENTRIES 14 /* upper triangle of 4 x 4, right side */
#define LEVELS 8   /* of mixtures, as displayed */

static const silmap_pattern fit_pattern = {4, 1};

/* ---- means ---------------------------------------------------------------------------------------------- */

typedef struct mean_job {
    const silmap_model *model;
    const silmap_labels *labels;
} mean_job;

/* Adds what sample s has in one of its cells. */
static void add_quadrant(const mean_job *job, size_t s, size_t c, int corner, double sum[SILMAP_CHANNELS + 1]) {
    const silmap_model *model = job->model;
    silmap_view view = silmap_view_of(model, c);
    for (uint32_t y = view.span.y0; y < view.span.y1; y++) {
        double v = (y + 0.5) * view.sy - view.top;
        for (uint32_t x = view.span.x0; x < view.span.x1; x++) {
            double u = (x + 0.5) * view.sx - view.left;
            size_t index = (size_t)y * model->picture->width + x;
            int pure = 1;
            if (zt_silmap_shape_quadrant(&view.shape, u, v) != corner)
                continue;
            if (job->labels &&
                (silmap_truth_texel(job->labels->truth, index, &pure) != job->labels->sample[s] || !pure))
                continue;
            float texel[SILMAP_CHANNELS];
            silmap_texel(model->picture, model->curve, index, texel);
            for (uint32_t ch = 0; ch < model->picture->channels; ch++)
                sum[ch] += (double)texel[ch];
            sum[SILMAP_CHANNELS]++;
        }
    }
}

static void nearest_texel(const silmap_model *model, size_t s, float *out) {
    size_t w = model->picture->width, h = model->picture->height;
    size_t x = s % model->grid->sw * w / model->grid->w, y = s / model->grid->sw * h / model->grid->h;
    float texel[SILMAP_CHANNELS];
    silmap_texel(model->picture, model->curve, (y < h ? y : h - 1) * w + (x < w ? x : w - 1), texel);
    memcpy(out, texel, model->picture->channels * sizeof *out);
}

static author_result visit_mean(void *context, size_t s, unsigned worker) {
    (void)worker;
    const mean_job *job = context;
    const silmap_model *model = job->model;
    uint32_t channels = model->picture->channels;
    float *out = model->samples + s * channels;
    const silmap_region *region = job->labels ? &job->labels->truth->regions[job->labels->sample[s]] : NULL;
    double sum[SILMAP_CHANNELS + 1] = {0};
    for (int k = 0; k < 4 && !(region && region->flat); k++) {
        size_t c = silmap_cell_of(model->grid, s, k);
        if (c != SIZE_MAX)
            add_quadrant(job, s, c, k, sum);
    }
    if (sum[SILMAP_CHANNELS] > 0)
        for (uint32_t ch = 0; ch < channels; ch++)
            out[ch] = (float)(sum[ch] / sum[SILMAP_CHANNELS]);
    else if (region)
        memcpy(out, region->colour, channels * sizeof *out);
    else
        nearest_texel(model, s, out);
    return AUTHOR_OK;
}

author_result silmap_colour_means(author_run *run, const silmap_model *model, const silmap_labels *labels) {
    silmap_model full = silmap_full(model);
    mean_job job = {&full, labels};
    return silmap_each(run, "colours", NULL, (size_t)model->grid->sw * model->grid->sh, visit_mean, &job);
}

/* ---- least squares -------------------------------------------------------------------------------------- */

typedef struct solve_job {
    silmap_model *model;
    const uint8_t *fixed;
    size_t *list; /* samples that are not fixed, by class */
    size_t ends[CLASSES + 1];
    float *equations; /* of each cell and channel: ENTRIES */
    double *errors;   /* of each cell, before the round */
    float *start;     /* samples before the round */
} solve_job;

static int entry(int i, int j) {
    static const int8_t first[4] = {0, 4, 7, 9};
    return i <= j ? first[i] + j - i : first[j] + i - j;
}

/* One texel's share in a cell's equations for a channel. Returns its squared error. */
static double add_equation(const silmap_view *view, const silmap_parts *parts, uint32_t ch, float wanted, double *to) {
    const silmap_curve *curve = view->model->curve;
    double row[4] = {0}, shown = 0;
    float level = 0;
    for (int i = 0; i < parts->count; i++) {
        float value = silmap_value(parts, i, view->corners, ch);
        float coded = silmap_code(curve, ch, value);
        double slope = (double)silmap_slope(curve, ch, value, coded);
        shown += (double)coded;
        level += coded;
        for (int k = 0; k < 4; k++)
            row[k] += slope * parts->weights[i][k];
    }
    double residual = (double)wanted - shown / parts->count;
    for (int i = 0; i < 4; i++) {
        row[i] /= parts->count;
        to[10 + i] += row[i] * residual;
        for (int j = 0; j <= i; j++)
            to[entry(j, i)] += row[i] * row[j];
    }
    return silmap_squared(level, parts->count, wanted);
}

static author_result visit_equations(void *context, size_t c, unsigned worker) {
    (void)worker;
    solve_job *job = context;
    const silmap_model *model = job->model;
    uint32_t channels = model->picture->channels;
    silmap_view view = silmap_view_of(model, c);
    int fixed = job->fixed != NULL;
    for (int k = 0; k < 4 && fixed; k++)
        fixed = job->fixed[silmap_corner(model->grid, c, k)];
    if (fixed) { /* nobody asks for its equations */
        job->errors[c] = silmap_cell_error(&view, fit_pattern);
        return AUTHOR_OK;
    }
    double sums[SILMAP_CHANNELS][ENTRIES] = {{0}}, error = 0;
    silmap_parts parts;
    for (uint32_t y = view.span.y0; y < view.span.y1; y++) {
        for (uint32_t x = view.span.x0; x < view.span.x1; x++) {
            float wanted[SILMAP_CHANNELS];
            silmap_wanted(model, (size_t)y * model->width + x, wanted);
            silmap_split(&view, x, y, fit_pattern, &parts);
            double squares = 0;
            for (uint32_t ch = 0; ch < channels; ch++)
                squares += add_equation(&view, &parts, ch, wanted[ch], sums[ch]);
            error += squares;
        }
    }
    job->errors[c] = error;
    float *to = job->equations + c * channels * ENTRIES;
    for (uint32_t i = 0; i < channels * ENTRIES; i++)
        to[i] = (float)sums[i / ENTRIES][i % ENTRIES];
    return AUTHOR_OK;
}

/* The cells of a sample, by the corner that it is, and the nine samples around it, from north-west to south-east. */
typedef struct sample_cells {
    size_t cells[4], samples[9];
} sample_cells;

/* The best value of one sample, the others as they are. */
static void relax(const solve_job *job, size_t s, uint32_t ch, const sample_cells *around) {
    const silmap_model *model = job->model;
    uint32_t channels = model->picture->channels;
    double diagonal = 0, right = 0;
    for (int k = 0; k < 4; k++) {
        if (around->cells[k] == SIZE_MAX)
            continue;
        const float *e = job->equations + (around->cells[k] * channels + ch) * ENTRIES;
        diagonal += (double)e[entry(k, k)];
        right += (double)e[10 + k];
        for (int m = 0; m < 4; m++) {
            /* The sample is corner k: the cell's first corner is one to the west of it if k is at the right, and so
             * on. */
            int place = (1 - (k >> 1) + (m >> 1)) * 3 + 1 - (k & 1) + (m & 1);
            size_t other = around->samples[place] * channels + ch;
            right -= (double)e[entry(k, m)] * ((double)model->samples[other] - (double)job->start[other]);
        }
    }
    if (!(diagonal > 1e-9))
        return;
    /* Without damping this is the value that solves the equation of this sample. */
    float *value = &model->samples[s * channels + ch];
    double from_start = (double)*value - (double)job->start[s * channels + ch];
    double step = (right - DAMPING * diagonal * from_start) / (diagonal * (1 + DAMPING));
    *value = fminf(fmaxf((float)((double)*value + step), model->low[ch]), model->high[ch]);
}

static author_result visit_relax(void *context, size_t s, unsigned worker) {
    (void)worker;
    solve_job *job = context;
    const silmap_grid *grid = job->model->grid;
    sample_cells around;
    size_t j = s / grid->sw, i = s - j * grid->sw;
    size_t rows[3] = {(j ? j : grid->sh) - 1, j, j + 1 < grid->sh ? j + 1 : 0};
    size_t columns[3] = {(i ? i : grid->sw) - 1, i, i + 1 < grid->sw ? i + 1 : 0};
    for (int k = 0; k < 9; k++)
        around.samples[k] = rows[k / 3] * grid->sw + columns[k % 3];
    for (int k = 0; k < 4; k++)
        around.cells[k] = silmap_cell_of(grid, s, k);
    for (uint32_t ch = 0; ch < job->model->picture->channels; ch++)
        relax(job, s, ch, &around);
    return AUTHOR_OK;
}

static author_result solve_equations(author_run *run, solve_job *job) {
    author_result result = AUTHOR_OK;
    for (uint32_t i = 0; i < SOLVER_SWEEPS * CLASSES && result == AUTHOR_OK; i++) {
        size_t first = job->ends[i % CLASSES], count = job->ends[i % CLASSES + 1] - first;
        result = count ? silmap_each(run, "colours", job->list + first, count, visit_relax, job) : AUTHOR_OK;
    }
    return result;
}

/* Samples of one class have no cell in common. */
static author_result list_samples(author_run *run, solve_job *job) {
    const silmap_grid *grid = job->model->grid;
    size_t samples = (size_t)grid->sw * grid->sh, count = 0;
    size_t *all = author_alloc(run, samples, sizeof *all);
    job->list = author_alloc(run, samples, sizeof *job->list);
    for (size_t s = 0; all && s < samples; s++)
        if (!job->fixed || !job->fixed[s])
            all[count++] = s;
    for (uint32_t i = 0; all && job->list && i < CLASSES; i++)
        job->ends[i + 1] = job->ends[i] + silmap_select(all, count, grid->sw, grid->sh, 2, i, job->list + job->ends[i]);
    int done = all && job->list;
    free(all);
    return done ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* Colours cannot be more than their alpha allows. */
static void limit_by_alpha(const silmap_model *model) {
    uint32_t channels = model->picture->channels;
    int alpha = model->curve->alpha;
    size_t samples = (size_t)model->grid->sw * model->grid->sh;
    for (size_t s = 0; alpha >= 0 && s < samples; s++) {
        float *sample = model->samples + s * channels;
        for (int ch = 0; ch < alpha; ch++)
            sample[ch] = fminf(sample[ch], sample[alpha]);
    }
}

void silmap_colour_round(const silmap_model *model, const silmap_labels *labels, const uint8_t *fixed) {
    uint32_t channels = model->picture->channels;
    for (size_t i = 0; i < (size_t)model->grid->sw * model->grid->sh * channels; i++) {
        size_t s = i / channels;
        uint32_t ch = (uint32_t)(i % channels);
        const silmap_region *region = &labels->truth->regions[labels->sample[s]];
        float *value = &model->samples[i], coded = silmap_code(model->curve, ch, *value);
        float rounded = roundf(coded * LEVELS) / LEVELS;
        if (fixed[s] || !region->flat)
            continue;
        if (fabsf(coded - region->coded[ch]) <= 0.5f / LEVELS)
            *value = region->colour[ch];
        else
            *value = ch < model->curve->colours ? zt_transfer_decode(ZT_TRANSFER_SRGB, rounded) : rounded;
    }
    limit_by_alpha(model);
}

/* One round; the step is halved until it lowers the error, or not taken. */
static author_result solve_round(author_run *run, solve_job *job, double *errors, double *trial, int *better) {
    silmap_model *model = job->model;
    size_t cells = (size_t)model->grid->w * model->grid->h;
    size_t values = (size_t)model->grid->sw * model->grid->sh * model->picture->channels;
    memcpy(job->start, model->samples, values * sizeof *job->start);
    author_result result = silmap_each(run, "colours", NULL, cells, visit_equations, job);
    if (result == AUTHOR_OK)
        result = solve_equations(run, job);
    limit_by_alpha(model);
    double before = silmap_sum(errors, cells);
    *better = 0;
    for (int i = 0; i < TRIES && result == AUTHOR_OK && !*better; i++) {
        result = silmap_errors(run, model, fit_pattern, trial);
        *better = result == AUTHOR_OK && silmap_sum(trial, cells) < before;
        for (size_t v = 0; v < values && !*better; v++)
            model->samples[v] = (model->samples[v] + job->start[v]) / 2;
    }
    if (*better)
        memcpy(errors, trial, cells * sizeof *errors);
    else
        memcpy(model->samples, job->start, values * sizeof *job->start);
    return result;
}

author_result silmap_colour_solve(author_run *run, silmap_model *model, const uint8_t *fixed, int rounds,
                                  double *errors) {
    size_t cells = (size_t)model->grid->w * model->grid->h;
    size_t values = (size_t)model->grid->sw * model->grid->sh * model->picture->channels;
    solve_job job = {.model = model, .fixed = fixed, .errors = errors};
    job.equations = author_alloc(run, cells * model->picture->channels * ENTRIES, sizeof *job.equations);
    job.start = author_alloc(run, values, sizeof *job.start);
    double *trial = author_alloc(run, cells, sizeof *trial);
    author_result result = job.equations && job.start && trial ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        result = list_samples(run, &job);
    int better = 1;
    for (int i = 0; i < rounds && better && result == AUTHOR_OK; i++)
        result = solve_round(run, &job, errors, trial, &better);
    free(job.equations);
    free(job.start);
    free(job.list);
    free(trial);
    return result;
}
