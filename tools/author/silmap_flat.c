/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Regions of flat art. A texel is inside of a region if it is in a block of 2 x 2 texels of one colour; blocks that
 * share texels are one region. What is left are the mixtures along the borders that anti-aliasing makes. Since drawing
 * programs mix coded values, it is coded values whose interpolation crosses half way between two regions where the
 * border was.
 */
#include "silmap_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define TOLERANCE (1.5f / 255)
#define INSIDE_SHARE 0.8 /* of all texels are inside of a region: else it is no drawing */
#define FLAT_SHARE 0.6   /* of those inside are in regions of one colour */
#define SMALLEST 6       /* texels */
#define PASSES 64

typedef struct flat_job {
    author_run *run;
    silmap_truth *truth;
    uint32_t *parent; /* of each texel, itself for the root; NONE: in no block */
    uint32_t w, h;
    float *rows; /* two coded rows */
} flat_job;

static uint32_t root_of(uint32_t *parent, uint32_t i) {
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b) {
    if (parent[b] == NONE)
        parent[b] = b;
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static void code_row(const flat_job *job, uint32_t y, float *out) {
    const silmap_truth *truth = job->truth;
    uint32_t channels = truth->picture->channels;
    for (uint32_t x = 0; x < job->w; x++) {
        float texel[SILMAP_CHANNELS];
        silmap_texel(truth->picture, truth->curve, (size_t)y * job->w + x, texel);
        for (uint32_t ch = 0; ch < channels; ch++)
            out[(size_t)x * channels + ch] = silmap_code(truth->curve, ch, texel[ch]);
    }
}

static int one_colour(const float *above, const float *below, uint32_t channels) {
    for (uint32_t ch = 0; ch < channels; ch++) {
        float low = fminf(fminf(above[ch], above[ch + channels]), fminf(below[ch], below[ch + channels]));
        float high = fmaxf(fmaxf(above[ch], above[ch + channels]), fmaxf(below[ch], below[ch + channels]));
        if (!(high - low <= TOLERANCE))
            return 0;
    }
    return 1;
}

/* Returns how many texels are in no block; it stops when they are more than the limit. */
static size_t join_blocks(flat_job *job, double limit) {
    size_t outside = 0;
    uint32_t channels = job->truth->picture->channels;
    size_t row = (size_t)job->w * channels;
    code_row(job, 0, job->rows);
    for (uint32_t y = 0; y + 1 < job->h && (double)outside <= limit; y++) {
        const float *above = job->rows + (y & 1 ? row : 0);
        float *below = job->rows + (y & 1 ? 0 : row);
        code_row(job, y + 1, below);
        for (uint32_t x = 0; x + 1 < job->w; x++) {
            uint32_t i = y * job->w + x;
            if (!one_colour(above + (size_t)x * channels, below + (size_t)x * channels, channels))
                continue;
            if (job->parent[i] == NONE)
                job->parent[i] = i;
            join(job->parent, i, i + 1);
            join(job->parent, i, i + job->w);
            join(job->parent, i, i + job->w + 1);
        }
        for (uint32_t x = 0; x < job->w; x++)
            outside += job->parent[y * job->w + x] == NONE;
    }
    for (uint32_t x = 0; x < job->w; x++)
        outside += job->parent[(job->h - 1) * job->w + x] == NONE;
    return outside;
}

/* ---- components ----------------------------------------------------------------------------------------- */

typedef struct component {
    double sum[SILMAP_CHANNELS], square[SILMAP_CHANNELS];
    double count;
    int flat;
    uint32_t region;
    uint64_t key;
} component;

/* Flattens the forest: parent becomes the number of the component. Returns how many. */
static uint32_t number_components(flat_job *job) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < job->w * job->h; i++) {
        if (job->parent[i] == NONE)
            continue;
        /* Roots are the lowest of their component, so theirs has been replaced already, by a number with the top
         * bit. */
        uint32_t up = job->parent[i];
        if (up == i)
            job->parent[i] = SILMAP_MIXED | count++;
        else {
            while (!(job->parent[up] & SILMAP_MIXED))
                up = job->parent[up];
            job->parent[i] = job->parent[up];
        }
    }
    for (uint32_t i = 0; i < job->w * job->h; i++)
        if (job->parent[i] != NONE)
            job->parent[i] &= ~SILMAP_MIXED;
    return count;
}

static void measure_components(flat_job *job, component *components) {
    uint32_t channels = job->truth->picture->channels;
    for (uint32_t y = 0; y < job->h; y++) {
        code_row(job, y, job->rows);
        for (uint32_t x = 0; x < job->w; x++) {
            uint32_t id = job->parent[y * job->w + x];
            if (id == NONE)
                continue;
            component *c = &components[id];
            c->count++;
            for (uint32_t ch = 0; ch < channels; ch++) {
                double v = (double)job->rows[(size_t)x * channels + ch];
                c->sum[ch] += v;
                c->square[ch] += v * v;
            }
        }
    }
}

static void finish_component(component *c, uint32_t channels) {
    c->flat = 1;
    for (uint32_t ch = 0; ch < channels; ch++) {
        double mean = c->sum[ch] / c->count;
        if (c->square[ch] / c->count - mean * mean > (double)TOLERANCE * (double)TOLERANCE)
            c->flat = 0;
        double code = fmin(fmax(floor(mean * 255 + 0.5), 0), 65535);
        c->key = c->key << 16 | (uint64_t)code;
    }
}

static int compare_keys(const void *a, const void *b) {
    const component *x = *(const component *const *)a, *y = *(const component *const *)b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x > y) - (x < y);
}

/* Numbers the regions: components of one colour are one region wherever they are. Returns the share of the flat
 * ones. */
static double name_regions(component *components, const component **sorted, uint32_t count, uint32_t channels,
                           uint32_t *regions) {
    double flat = 0, all = 0;
    size_t kept = 0;
    *regions = 0;
    for (uint32_t i = 0; i < count; i++) {
        component *c = &components[i];
        finish_component(c, channels);
        all += c->count;
        flat += c->flat ? c->count : 0;
        c->region = NONE;
        if (c->count >= SMALLEST && c->flat)
            sorted[kept++] = c;
        else if (c->count >= SMALLEST)
            c->region = (*regions)++;
    }
    qsort(sorted, kept, sizeof *sorted, compare_keys);
    for (size_t i = 0; i < kept; i++) {
        int same = i > 0 && sorted[i]->key == sorted[i - 1]->key;
        components[sorted[i] - components].region = same ? sorted[i - 1]->region : (*regions)++;
    }
    return all > 0 ? flat / all : 0;
}

/* ---- texels at the borders ------------------------------------------------------------------------------ */

static float distance(const float *a, const float *b, uint32_t channels) {
    float sum = 0;
    for (uint32_t ch = 0; ch < channels; ch++)
        sum += (a[ch] - b[ch]) * (a[ch] - b[ch]);
    return sum;
}

static void coded_texel(const silmap_truth *truth, size_t i, float out[SILMAP_CHANNELS]) {
    silmap_texel(truth->picture, truth->curve, i, out);
    for (uint32_t ch = 0; ch < truth->picture->channels; ch++)
        out[ch] = silmap_code(truth->curve, ch, out[ch]);
}

/* The region beside a texel whose colour is nearest; NONE: there is none yet. */
static uint32_t nearest_beside(const flat_job *job, uint32_t i) {
    const silmap_truth *truth = job->truth;
    int x = (int)(i % job->w), y = (int)(i / job->w);
    float own[SILMAP_CHANNELS];
    coded_texel(truth, i, own);
    uint32_t best = NONE;
    float least = INFINITY;
    for (int k = 0; k < 9; k++) {
        int nx = x + k % 3 - 1, ny = y + k / 3 - 1;
        if (nx < 0 || ny < 0 || nx >= (int)job->w || ny >= (int)job->h)
            continue;
        uint32_t label = truth->labels[(size_t)ny * job->w + (size_t)nx];
        if (label == NONE)
            continue;
        label &= ~SILMAP_MIXED;
        float d = distance(own, truth->regions[label].coded, truth->picture->channels);
        if (d < least || (!(d > least) && label < best)) {
            least = d;
            best = label;
        }
    }
    return best;
}

static void fill_rest(silmap_truth *truth, const uint32_t *list, size_t count) {
    for (size_t i = 0; i < count; i++)
        truth->labels[list[i]] = SILMAP_MIXED | (list[i] ? truth->labels[list[i] - 1] & ~SILMAP_MIXED : 0);
}

/* Every texel gets a region, from the borders of those that have one. */
static author_result spread(flat_job *job) {
    silmap_truth *truth = job->truth;
    size_t texels = (size_t)job->w * job->h, count = 0;
    for (size_t i = 0; i < texels; i++)
        count += truth->labels[i] == NONE;
    uint32_t *list = author_alloc(job->run, count, 2 * sizeof *list);
    if (!list)
        return AUTHOR_NO_MEMORY;
    uint32_t *found = list + count;
    count = 0;
    for (size_t i = 0; i < texels; i++)
        if (truth->labels[i] == NONE)
            list[count++] = (uint32_t)i;
    for (int pass = 0; pass < PASSES && count; pass++) {
        size_t left = 0;
        for (size_t i = 0; i < count; i++)
            found[i] = nearest_beside(job, list[i]);
        for (size_t i = 0; i < count; i++) {
            if (found[i] == NONE)
                list[left++] = list[i];
            else
                truth->labels[list[i]] = SILMAP_MIXED | found[i];
        }
        count = left;
    }
    fill_rest(truth, list, count);
    free(list);
    return AUTHOR_OK;
}

/* ---- all together --------------------------------------------------------------------------------------- */

static author_result label_components(flat_job *job, uint32_t count, int *found) {
    silmap_truth *truth = job->truth;
    component *components = author_alloc(job->run, count, sizeof *components);
    const component **sorted = author_alloc(job->run, count, sizeof *sorted);
    if (!components || !sorted) {
        free(components);
        free(sorted);
        return AUTHOR_NO_MEMORY;
    }
    measure_components(job, components);
    double flat = name_regions(components, sorted, count, truth->picture->channels, &truth->region_count);
    *found = flat >= FLAT_SHARE && truth->region_count > 0;
    truth->regions = author_alloc(job->run, truth->region_count, sizeof *truth->regions);
    for (size_t i = 0; *found && truth->regions && i < (size_t)job->w * job->h; i++)
        truth->labels[i] = job->parent[i] == NONE ? NONE : components[job->parent[i]].region;
    for (uint32_t i = 0; *found && truth->regions && i < count; i++)
        for (uint32_t ch = 0; components[i].region != NONE && ch < truth->picture->channels; ch++)
            truth->regions[components[i].region].coded[ch] = (float)(components[i].sum[ch] / components[i].count);
    free(components);
    free(sorted);
    return truth->regions ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static author_result find_flat(flat_job *job, int *found) {
    size_t texels = (size_t)job->w * job->h;
    double limit = (1 - INSIDE_SHARE) * (double)texels;
    memset(job->parent, 0xff, texels * sizeof *job->parent);
    *found = 0;
    if ((double)join_blocks(job, limit) > limit)
        return AUTHOR_OK;
    author_result result = label_components(job, number_components(job), found);
    if (result != AUTHOR_OK || !*found)
        return result;
    result = spread(job);
    free(job->truth->regions); /* measured again, linear too */
    job->truth->regions = NULL;
    job->truth->resolve = 1;
    return result;
}

author_result silmap_flat_find(author_run *run, silmap_truth *truth, int *found) {
    flat_job job = {.run = run, .truth = truth, .w = truth->picture->width, .h = truth->picture->height};
    job.parent = author_alloc(run, (size_t)job.w * job.h, sizeof *job.parent);
    job.rows = author_alloc(run, (size_t)job.w * truth->picture->channels, 2 * sizeof *job.rows);
    author_result result = job.parent && job.rows ? find_flat(&job, found) : AUTHOR_NO_MEMORY;
    free(job.parent);
    free(job.rows);
    return result;
}

/* ---- between texels ------------------------------------------------------------------------------------- */

#define REACH 2 /* texels around the four that are mixed */
#define CANDIDATES 8

typedef struct candidate {
    uint32_t label;
    float colour[SILMAP_CHANNELS];
    int inside; /* texels in colour */
} candidate;

static size_t clamp_texel(long long i, uint32_t count) {
    return i < 0 ? 0 : i >= (long long)count ? count - 1 : (size_t)i;
}

static candidate *candidate_of(candidate list[CANDIDATES], int *count, uint32_t label) {
    for (int i = 0; i < *count; i++)
        if (list[i].label == label)
            return &list[i];
    if (*count == CANDIDATES)
        return NULL;
    list[*count] = (candidate){.label = label};
    return &list[(*count)++];
}

/* Regions near the texels (x, y) to (x + 1, y + 1); their colours there if they are not of one colour everywhere. */
static int find_candidates(const silmap_truth *truth, long long x, long long y, candidate list[CANDIDATES]) {
    int count = 0;
    for (long long j = y - REACH; j <= y + 1 + REACH; j++) {
        for (long long i = x - REACH; i <= x + 1 + REACH; i++) {
            size_t at = clamp_texel(j, truth->picture->height) * truth->picture->width +
                        clamp_texel(i, truth->picture->width);
            uint32_t label = truth->labels[at] & ~SILMAP_MIXED;
            candidate *c = candidate_of(list, &count, label);
            if (!c || truth->regions[label].flat || (truth->labels[at] & SILMAP_MIXED))
                continue;
            float texel[SILMAP_CHANNELS];
            coded_texel(truth, at, texel);
            c->inside++;
            for (uint32_t ch = 0; ch < truth->picture->channels; ch++)
                c->colour[ch] += texel[ch];
        }
    }
    for (int i = 0; i < count; i++)
        for (uint32_t ch = 0; ch < truth->picture->channels; ch++)
            list[i].colour[ch] = list[i].inside ? list[i].colour[ch] / (float)list[i].inside
                                                : truth->regions[list[i].label].coded[ch];
    return count;
}

uint32_t silmap_flat_at(const silmap_truth *truth, double x, double y) {
    const author_picture *picture = truth->picture;
    double u = x * picture->width - 0.5, v = y * picture->height - 0.5;
    long long i = (long long)floor(u), j = (long long)floor(v);
    size_t at[4];
    uint32_t label = 0;
    int plain = 1;
    for (int k = 0; k < 4; k++) {
        at[k] = clamp_texel(j + k / 2, picture->height) * picture->width + clamp_texel(i + k % 2, picture->width);
        label = truth->labels[at[k]];
        plain = plain && label == truth->labels[at[0]];
    }
    if (plain && !(label & SILMAP_MIXED))
        return label;
    double fx = u - (double)i, fy = v - (double)j;
    double weights[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    float mean[SILMAP_CHANNELS] = {0};
    for (int k = 0; k < 4; k++) {
        float texel[SILMAP_CHANNELS];
        coded_texel(truth, at[k], texel);
        for (uint32_t ch = 0; ch < picture->channels; ch++)
            mean[ch] += (float)weights[k] * texel[ch];
    }
    candidate list[CANDIDATES];
    int count = find_candidates(truth, i, j, list);
    int best = 0;
    for (int k = 1; k < count; k++)
        if (distance(mean, list[k].colour, picture->channels) < distance(mean, list[best].colour, picture->channels))
            best = k;
    return list[best].label;
}
