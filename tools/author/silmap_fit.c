/* SPDX-License-Identifier: Apache-2.0 */
/* Fitting a silmap: the parts in their order, the comparison with a bilinear texture, the search for a grid. */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_TEXELS (UINT32_C(1) << 31)
#define MAX_CELLS (UINT32_C(1) << 20)
#define ROUNDS 2         /* of least squares */
#define LOOP_SHARE 0.2   /* of the rest of a phase that the next loop is taken to be */
#define TRIAL_SHARE 0.25 /* of the rest of the search that the next grid is taken to be */
#define PRUNINGS 3
#define POLISH_SWEEPS 2
#define FIRST_PATIENCE 2 /* before the points are where the picture wants them */
#define FIRST_CELLS 8    /* of the search for a grid */
#define NOT_HELD 0.03    /* squared, of a cell's error: its samples may be mixtures */
#define DRAWN_SHARE 0.5  /* of the picture is of flat regions: a drawing, whose edges are sure */

static const silmap_pattern judge_pattern = {5, 1};

/* One number for all loops. How many there are depends on the picture, so each has a share of what is left of its
 * phase: never back, never beyond. */
typedef struct fit_progress {
    const author_run *outer;
    const char *stage;
    double from, to;   /* of the loop that runs, and of its phase */
    double last;       /* reported by that loop, 0 to 1 */
    double start, end; /* of the grid that is tried */
} fit_progress;

typedef struct fit_job {
    author_run *run;
    fit_progress progress;
    int hasty; /* only to see whether a grid is worth a whole fit */
    const author_silmap_input *input;
    const author_silmap_options *options;
    silmap_curve curve;
    float low[SILMAP_CHANNELS], high[SILMAP_CHANNELS];
    silmap_truth truth;
    int labelled, drawn;
    /* of one grid */
    silmap_grid plain_grid, grid;
    silmap_model plain, model;
    double *plain_errors, *errors;
    silmap_labels labels;
    float *target;
} fit_job;

/* ---- progress ------------------------------------------------------------------------------------------- */

static double loop_share(const fit_progress *p) {
    return LOOP_SHARE * (p->to - p->from);
}

static int report(void *user, const char *stage, double done) {
    fit_progress *p = user;
    if (done < p->last || stage != p->stage) {
        p->from += loop_share(p) * p->last;
        p->stage = stage;
    }
    p->last = done;
    return p->outer->progress(p->outer->user, stage, p->from + loop_share(p) * done);
}

/* The phase that begins ends at this share of the grid. */
static void enter_phase(fit_job *job, double end) {
    fit_progress *p = &job->progress;
    p->from = p->to;
    p->to = p->start + end * (p->end - p->start);
    p->last = 0;
}

/* ---- one grid ------------------------------------------------------------------------------------------- */

static void release_grid(fit_job *job) {
    silmap_labels_release(&job->labels);
    silmap_grid_release(&job->plain_grid);
    silmap_grid_release(&job->grid);
    free(job->plain.samples);
    free(job->model.samples);
    free(job->plain_errors);
    free(job->errors);
    free(job->target);
    job->target = NULL;
    job->plain = job->model = (silmap_model){0};
    job->plain_errors = job->errors = NULL;
}

static author_result create_model(fit_job *job, silmap_grid *grid, zt_silmap_filter filter, silmap_model *out,
                                  double **errors) {
    size_t samples = (size_t)grid->sw * grid->sh;
    *out = (silmap_model){.picture = job->input->picture, .curve = &job->curve, .grid = grid, .filter = filter};
    memcpy(out->low, job->low, sizeof out->low);
    memcpy(out->high, job->high, sizeof out->high);
    out->samples = author_alloc(job->run, samples * job->input->picture->channels, sizeof *out->samples);
    *errors = author_alloc(job->run, (size_t)grid->w * grid->h, sizeof **errors);
    return out->samples && *errors ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static author_result create_grid(fit_job *job, uint32_t w, uint32_t h) {
    author_result result = silmap_grid_create(job->run, job->input, w, h, &job->plain_grid);
    if (result == AUTHOR_OK)
        result = silmap_grid_create(job->run, job->input, w, h, &job->grid);
    if (result == AUTHOR_OK)
        result = create_model(job, &job->plain_grid, ZT_SILMAP_CONTINUOUS, &job->plain, &job->plain_errors);
    if (result == AUTHOR_OK)
        result = create_model(job, &job->grid, job->options->filter, &job->model, &job->errors);
    silmap_model *plain = &job->plain, *model = &job->model;
    if (result == AUTHOR_OK)
        result = silmap_target_create(job->run, job->input->picture, &job->curve, &job->grid, &job->target,
                                      &model->width, &model->height);
    plain->target = model->target = job->target;
    plain->width = model->width;
    plain->height = model->height;
    return result;
}

/* The bilinear textures that the silmap is compared with. */
static author_result fit_plain(fit_job *job, double *box) {
    size_t cells = (size_t)job->grid.w * job->grid.h;
    author_result result = silmap_colour_means(job->run, &job->plain, NULL);
    silmap_model full = silmap_full(&job->plain);
    if (result == AUTHOR_OK)
        result = silmap_errors(job->run, &full, judge_pattern, job->plain_errors);
    if (result != AUTHOR_OK)
        return result;
    *box = silmap_psnr(job->input->picture, silmap_sum(job->plain_errors, cells));
    return silmap_colour_solve(job->run, &job->plain, NULL, job->hasty ? 1 : ROUNDS, job->plain_errors);
}

/* Samples whose regions are of one colour have it exactly, unless a cell beside them holds more than it can. */
static author_result find_fixed(fit_job *job, uint8_t **fixed) {
    const silmap_grid *grid = &job->grid;
    size_t samples = (size_t)grid->sw * grid->sh;
    *fixed = author_alloc(job->run, samples, 1);
    if (!*fixed)
        return AUTHOR_NO_MEMORY;
    for (size_t s = 0; s < samples; s++) {
        (*fixed)[s] = (uint8_t)job->truth.regions[job->labels.sample[s]].flat;
        for (int k = 0; k < 4; k++) {
            size_t c = silmap_cell_of(grid, s, k);
            silmap_span span = {0};
            if (c == SIZE_MAX)
                continue;
            span = silmap_texels(&job->model, c);
            double texels = (double)(span.x1 - span.x0) * (double)(span.y1 - span.y0);
            if (texels > 0 && job->errors[c] / texels > NOT_HELD)
                (*fixed)[s] = 0;
        }
    }
    return AUTHOR_OK;
}

/* Removes the cuts where a bilinear texture is better, its error being taken `patience` times. Returns how many. */
static size_t prune(fit_job *job, double patience) {
    silmap_grid *grid = &job->grid;
    size_t removed = 0;
    for (size_t c = 0; c < (size_t)grid->w * grid->h; c++) {
        for (int arm = SILMAP_W; arm <= SILMAP_N; arm++) {
            uint8_t bit = arm == SILMAP_W ? ZT_SILMAP_WEST : ZT_SILMAP_NORTH;
            size_t next = silmap_next(grid, c, arm);
            if (!(grid->cells[c] & bit) || next == SIZE_MAX)
                continue;
            double gain = patience * (job->plain_errors[c] + job->plain_errors[next]) - job->errors[c] -
                          job->errors[next];
            if (gain >= 0)
                continue;
            silmap_set_cut(grid, c, arm, 0);
            removed++;
        }
    }
    silmap_normalise(grid);
    return removed;
}

/* Photographs: the picture itself decides about points and cuts. */
static author_result refine_photograph(fit_job *job) {
    author_result result = AUTHOR_OK;
    prune(job, FIRST_PATIENCE);
    for (int i = job->hasty ? PRUNINGS - 1 : 0; i < PRUNINGS && result == AUTHOR_OK; i++) {
        if (i < 2)
            result = silmap_points_polish(job->run, &job->model, &job->grid, POLISH_SWEEPS);
        if (result == AUTHOR_OK)
            result = silmap_colour_solve(job->run, &job->model, NULL, 1, job->errors);
        if (result == AUTHOR_OK && !prune(job, 1) && i > 1)
            break;
    }
    return result == AUTHOR_OK ? silmap_colour_solve(job->run, &job->model, NULL, 1, job->errors) : result;
}

static author_result fit_cuts(fit_job *job) {
    static const author_silmap_place whole = {0, 0, 1, 1};
    if (!job->labelled)
        return silmap_edges_find(job->run, job->input, job->options, &job->curve, &job->grid);
    author_result result = silmap_labels_create(job->run, &job->truth, &whole, job->hasty, &job->grid, &job->labels);
    return result == AUTHOR_OK ? silmap_points_fit(job->run, &job->labels, job->hasty) : result;
}

static author_result fit_colours(fit_job *job) {
    author_result result = silmap_colour_means(job->run, &job->model, job->labelled ? &job->labels : NULL);
    if (result != AUTHOR_OK || job->options->no_least_squares)
        return result;
    uint8_t *fixed = NULL;
    if (job->labelled)
        result = silmap_errors(job->run, &job->model, judge_pattern, job->errors);
    if (result == AUTHOR_OK && job->labelled)
        result = find_fixed(job, &fixed);
    if (result == AUTHOR_OK)
        result = silmap_colour_solve(job->run, &job->model, fixed, job->hasty ? 1 : ROUNDS, job->errors);
    if (result == AUTHOR_OK && fixed)
        silmap_colour_round(&job->model, &job->labels, fixed);
    free(fixed);
    return result == AUTHOR_OK && !job->drawn ? refine_photograph(job) : result;
}

/* Against every texel of the picture. A silmap that is worse than the bilinear texture gives way to it. */
static author_result compare(fit_job *job, author_silmap_result *out) {
    size_t cells = (size_t)job->grid.w * job->grid.h;
    size_t values = (size_t)job->grid.sw * job->grid.sh * job->input->picture->channels;
    job->plain = silmap_full(&job->plain);
    job->model = silmap_full(&job->model);
    author_result result = silmap_errors(job->run, &job->plain, judge_pattern, job->plain_errors);
    if (result == AUTHOR_OK)
        result = silmap_errors(job->run, &job->model, judge_pattern, job->errors);
    if (result != AUTHOR_OK)
        return result;
    double plain = silmap_sum(job->plain_errors, cells), own = silmap_sum(job->errors, cells);
    if (own > plain && !job->options->no_least_squares) {
        memset(job->grid.cells, ZT_SILMAP_DEFAULT, cells);
        memcpy(job->model.samples, job->plain.samples, values * sizeof *job->model.samples);
        memcpy(job->errors, job->plain_errors, cells * sizeof *job->errors);
        own = plain;
    }
    out->psnr = silmap_psnr(job->input->picture, own);
    out->bilinear_psnr = silmap_psnr(job->input->picture, plain);
    return AUTHOR_OK;
}

/* ---- the result ----------------------------------------------------------------------------------------- */

static void straighten(const fit_job *job, const float *from, float *to) {
    int alpha = job->curve.alpha;
    for (uint32_t ch = 0; ch < job->input->picture->channels; ch++) {
        float divisor = alpha < 0 || (int)ch == alpha ? 1 : from[alpha];
        to[ch] = divisor > 0 ? from[ch] / divisor : 0;
    }
}

static void minify(const fit_job *job, size_t c, float *to) {
    zt_silmap_cell bytes = silmap_look(&job->grid, c);
    double areas[4];
    float mean[SILMAP_CHANNELS] = {0};
    zt_silmap_areas(&bytes, areas);
    for (int k = 0; k < 4; k++) {
        const float *corner = job->model.samples + silmap_corner(&job->grid, c, k) * job->input->picture->channels;
        for (uint32_t ch = 0; ch < job->input->picture->channels; ch++)
            mean[ch] += (float)areas[k] * corner[ch];
    }
    straighten(job, mean, to);
}

static void count_cells(const fit_job *job, author_silmap_result *out) {
    for (size_t c = 0; c < (size_t)job->grid.w * job->grid.h; c++) {
        silmap_span span = silmap_texels(&job->model, c);
        double texels = (double)(span.x1 - span.x0) * (double)(span.y1 - span.y0) * job->input->picture->channels;
        out->error[c] = texels > 0 ? (float)sqrt(job->errors[c] / texels) : 0;
        out->cut_cells += silmap_cuts(&job->grid, c) != 0;
        out->thin_cells += (out->defects[c] & AUTHOR_SILMAP_THIN) != 0;
        out->junction_cells += (out->defects[c] & AUTHOR_SILMAP_JUNCTION) != 0;
    }
}

static author_result hand_out(fit_job *job, author_silmap_result *out) {
    const silmap_grid *grid = &job->grid;
    uint32_t channels = job->input->picture->channels;
    size_t cells = (size_t)grid->w * grid->h;
    out->cells_x = grid->w;
    out->cells_y = grid->h;
    out->cells = author_alloc(job->run, cells, 1);
    out->defects = author_alloc(job->run, cells, 1);
    out->error = author_alloc(job->run, cells, sizeof *out->error);
    author_result result = out->cells && out->defects && out->error ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        result = author_picture_create(job->run, grid->sw, grid->sh, channels, &out->samples);
    if (result == AUTHOR_OK)
        result = author_picture_create(job->run, grid->w, grid->h, channels, &out->minified);
    if (result == AUTHOR_OK && job->labelled && !job->hasty)
        result = silmap_labels_judge(job->run, &job->labels, job->options->filter, 0, &out->disagreement, out->defects);
    if (result != AUTHOR_OK)
        return result;
    memcpy(out->cells, grid->cells, cells);
    for (size_t s = 0; s < (size_t)grid->sw * grid->sh; s++)
        straighten(job, job->model.samples + s * channels, out->samples.texels + s * channels);
    for (size_t c = 0; c < cells; c++)
        minify(job, c, out->minified.texels + c * channels);
    count_cells(job, out);
    return AUTHOR_OK;
}

static author_result fit_grid(fit_job *job, uint32_t w, uint32_t h, author_silmap_result *out) {
    *out = (author_silmap_result){0};
    enter_phase(job, 0.05);
    author_result result = create_grid(job, w, h);
    enter_phase(job, 0.25);
    if (result == AUTHOR_OK)
        result = fit_plain(job, &out->box_psnr);
    enter_phase(job, job->labelled ? 0.6 : 0.3);
    if (result == AUTHOR_OK)
        result = fit_cuts(job);
    enter_phase(job, 0.85);
    if (result == AUTHOR_OK)
        result = fit_colours(job);
    enter_phase(job, 0.95);
    if (result == AUTHOR_OK)
        result = compare(job, out);
    enter_phase(job, 1);
    if (result == AUTHOR_OK)
        result = hand_out(job, out);
    release_grid(job);
    if (result != AUTHOR_OK)
        author_silmap_release(out);
    return result;
}

/* ---- the smallest grid ---------------------------------------------------------------------------------- */

static void grid_of(const author_picture *picture, uint32_t longer, uint32_t *w, uint32_t *h) {
    double ratio = (double)(picture->width < picture->height ? picture->width : picture->height) /
                   (picture->width < picture->height ? picture->height : picture->width);
    uint32_t shorter = (uint32_t)(longer * ratio + 0.5);
    shorter = shorter ? shorter : 1;
    *w = picture->width < picture->height ? shorter : longer;
    *h = picture->width < picture->height ? longer : shorter;
}

/* best may be NULL: a trial in haste. */
static author_result try_grid(fit_job *job, uint32_t longer, author_silmap_result *best, int *reached) {
    author_silmap_result trial;
    job->hasty = best == NULL;
    job->progress.start = job->progress.end;
    job->progress.end += TRIAL_SHARE * (1 - job->progress.end);
    uint32_t w, h;
    grid_of(job->input->picture, longer, &w, &h);
    author_result result = fit_grid(job, w, h, &trial);
    *reached = result == AUTHOR_OK && trial.psnr >= job->options->quality;
    if (*reached && best) {
        author_silmap_release(best);
        *best = trial;
    } else
        author_silmap_release(&trial);
    return result;
}

/* Doubles the grid until a hasty fit is good enough, then halves the interval. *found is the smallest that was, or the
 * largest allowed. */
static author_result search_hastily(fit_job *job, uint32_t most, uint32_t *found) {
    uint32_t low = 0, high = FIRST_CELLS < most ? FIRST_CELLS : most;
    author_result result = AUTHOR_OK;
    int reached = 0;
    for (;;) {
        result = try_grid(job, high, NULL, &reached);
        if (result != AUTHOR_OK || reached || high == most)
            break;
        low = high;
        high = high > most / 2 ? most : high * 2;
    }
    while (result == AUTHOR_OK && reached && high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        int enough = 0;
        result = try_grid(job, middle, NULL, &enough);
        if (enough)
            high = middle;
        else
            low = middle;
    }
    *found = high;
    return result;
}

/* From where the hasty search ended: larger until a whole fit reaches the quality, or smaller as long as it does. */
static author_result search_grid(fit_job *job, author_silmap_result *out) {
    const author_picture *picture = job->input->picture;
    const author_silmap_options *options = job->options;
    uint32_t most = options->cells_x > options->cells_y ? options->cells_x : options->cells_y;
    if (!most)
        most = (picture->width > picture->height ? picture->width : picture->height) / 2;
    most = most ? most : 1;
    uint32_t longer = 1;
    author_result result = search_hastily(job, most, &longer);
    int reached = 0, first = 0;
    if (result == AUTHOR_OK)
        result = try_grid(job, longer, out, &first);
    reached = first;
    while (result == AUTHOR_OK && !reached && longer < most) {
        uint32_t step = longer / 32 + 1;
        longer = most - longer < step ? most : longer + step;
        result = try_grid(job, longer, out, &reached);
    }
    if (result == AUTHOR_OK && !reached)
        return author_fail(
            job->run, AUTHOR_BAD_INPUT,
            "%.1f dB are not reached with %u cells along the longer side: allow more cells or less quality",
            options->quality, most);
    for (reached = first; result == AUTHOR_OK && reached && longer > 1;)
        result = try_grid(job, --longer, out, &reached);
    if (result != AUTHOR_OK)
        author_silmap_release(out);
    return result;
}

/* ---- the whole ------------------------------------------------------------------------------------------ */

static int paths_finite(const author_silmap_input *input) {
    for (size_t p = 0; p < input->path_count; p++)
        for (size_t i = 0; i < 2 * input->paths[p].count; i++)
            if (!(fabs(input->paths[p].points[i]) < 1e6))
                return 0;
    return 1;
}

static author_result check_input(author_run *run, const author_silmap_input *input,
                                 const author_silmap_options *options) {
    const author_picture *picture = input->picture;
    if (!picture || !picture->width || !picture->height || !picture->channels || picture->channels > SILMAP_CHANNELS)
        return author_fail(run, AUTHOR_BAD_INPUT, "no picture of 1 to 4 channels to fit a silmap to");
    if ((uint64_t)picture->width * picture->height >= MAX_TEXELS)
        return author_fail(run, AUTHOR_BAD_INPUT, "the picture of %u x %u is too large: at most 2^31 texels",
                           picture->width, picture->height);
    if (!paths_finite(input))
        return author_fail(run, AUTHOR_BAD_INPUT, "a path has a point far outside the picture or none at all");
    if (options->quality > 0)
        return AUTHOR_OK;
    uint32_t x = options->cells_x, y = options->cells_y;
    if (!x || !y || x > picture->width || y > picture->height || x > MAX_CELLS || y > MAX_CELLS)
        return author_fail(run, AUTHOR_BAD_INPUT,
                           "%u x %u cells for a picture of %u x %u: at least 1 cell and at most one for each texel", x,
                           y, picture->width, picture->height);
    return AUTHOR_OK;
}

static int is_drawn(const silmap_truth *truth) {
    double flat = 0, all = 0;
    for (uint32_t r = 0; r < truth->region_count; r++) {
        all += truth->regions[r].texels;
        flat += truth->regions[r].flat ? truth->regions[r].texels : 0;
    }
    return flat >= DRAWN_SHARE * all;
}

author_result author_silmap_fit(author_run *run, const author_silmap_input *input, const author_silmap_options *options,
                                author_silmap_result *out) {
    *out = (author_silmap_result){0};
    author_result result = check_input(run, input, options);
    if (result != AUTHOR_OK)
        return result;
    author_run own = *run;
    fit_job job = {.run = &own, .input = input, .options = options, .progress = {.outer = run, .to = 0.1}};
    if (run->progress) {
        own.progress = report;
        own.user = &job.progress;
    }
    silmap_curve_set(&job.curve, input->picture->channels, options->plain);
    silmap_range(input->picture, &job.curve, job.low, job.high);
    result = silmap_truth_create(&own, input, &job.curve, &job.truth, &job.labelled);
    if (result == AUTHOR_OK) {
        job.drawn = job.labelled && is_drawn(&job.truth);
        job.progress.start = job.progress.end = job.progress.to;
        if (options->quality > 0) {
            result = search_grid(&job, out);
        } else {
            job.progress.end = 1;
            result = fit_grid(&job, options->cells_x, options->cells_y, out);
        }
    }
    silmap_truth_release(&job.truth);
    memcpy(run->error, own.error, sizeof run->error);
    return result;
}

void author_silmap_release(author_silmap_result *result) {
    free(result->cells);
    free(result->error);
    free(result->defects);
    author_picture_release(&result->samples);
    author_picture_release(&result->minified);
    *result = (author_silmap_result){0};
}
