/* SPDX-License-Identifier: Apache-2.0 */
/* Which region of the original is where: from given labels, from closed paths, from shapes (silmap_fill.c), or from
 * flat art (silmap_flat.c). */
#include "silmap_fill.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REGIONS (UINT32_C(1) << 24)
#define FLAT_DEVIATION (1.5 / 255)
#define SAME_COLOUR (2.5 / 255)
#define BLOCK 256                     /* places that are looked up at a time */
#define FEW_ENTRIES ((size_t)1 << 24) /* of edges in bands: beyond that, some for each edge */
#define ENTRIES_OF_EDGE 4

/* ---- numbering keys ----------------------------------------------------------------------------------- */

typedef struct key_map { /* open addressing; values count from 0 in order of appearance */
    uint64_t *keys;
    uint32_t *values; /* + 1; 0: free */
    size_t size, count;
} key_map;

static uint64_t mix(uint64_t key) {
    key = (key ^ (key >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    key = (key ^ (key >> 27)) * UINT64_C(0x94d049bb133111eb);
    return key ^ (key >> 31);
}

static size_t key_slot(const key_map *map, uint64_t key) {
    size_t slot = (size_t)mix(key) & (map->size - 1);
    while (map->values[slot] && map->keys[slot] != key)
        slot = (slot + 1) & (map->size - 1);
    return slot;
}

static void key_release(key_map *map) {
    free(map->keys);
    free(map->values);
    *map = (key_map){0};
}

static author_result key_grow(author_run *run, key_map *map) {
    key_map bigger = {.size = map->size ? map->size * 4 : 256, .count = map->count};
    bigger.keys = author_alloc(run, bigger.size, sizeof *bigger.keys);
    bigger.values = author_alloc(run, bigger.size, sizeof *bigger.values);
    if (!bigger.keys || !bigger.values) {
        key_release(&bigger);
        return AUTHOR_NO_MEMORY;
    }
    for (size_t i = 0; i < map->size; i++) {
        if (!map->values[i])
            continue;
        size_t slot = key_slot(&bigger, map->keys[i]);
        bigger.keys[slot] = map->keys[i];
        bigger.values[slot] = map->values[i];
    }
    key_release(map);
    *map = bigger;
    return AUTHOR_OK;
}

static author_result key_number(author_run *run, key_map *map, uint64_t key, uint32_t *value) {
    if (map->count * 2 >= map->size && key_grow(run, map) != AUTHOR_OK)
        return AUTHOR_NO_MEMORY;
    size_t slot = key_slot(map, key);
    if (!map->values[slot]) {
        if (map->count >= REGIONS)
            return author_fail(run, AUTHOR_BAD_INPUT, "more than %u regions: labels should be of a drawing", REGIONS);
        map->keys[slot] = key;
        map->values[slot] = (uint32_t)++map->count;
    }
    *value = map->values[slot] - 1;
    return AUTHOR_OK;
}

/* ---- paths -------------------------------------------------------------------------------------------- */

static size_t count_edges(const author_silmap_input *input) {
    size_t count = 0;
    for (size_t p = 0; p < input->path_count; p++)
        count += input->paths[p].count;
    return count;
}

static void put_edges(const author_silmap_input *input, silmap_truth *truth) {
    for (size_t p = 0; p < input->path_count; p++) {
        const author_path *path = &input->paths[p];
        uint64_t mark = mix(p + 1);
        for (size_t i = 0; i < path->count; i++) {
            const double *a = path->points + 2 * i;
            const double *b = path->points + 2 * ((i + 1) % path->count);
            int down = b[1] > a[1];
            if (!(a[1] < b[1]) && !(a[1] > b[1]))
                continue;
            truth->edges[truth->edge_count++] = down ? (silmap_edge){a[0], a[1], b[0], b[1], mark}
                                                     : (silmap_edge){b[0], b[1], a[0], a[1], 0 - mark};
        }
    }
}

uint32_t silmap_edges_band(const silmap_truth *truth, double y) {
    double row = y * truth->rows;
    return row <= 0 ? 0 : row >= truth->rows - 1 ? truth->rows - 1 : (uint32_t)row;
}

/* How often edges are in bands. */
static size_t count_entries(const silmap_truth *truth) {
    size_t count = 0;
    for (size_t e = 0; e < truth->edge_count; e++)
        count += silmap_edges_band(truth, truth->edges[e].y1) - silmap_edges_band(truth, truth->edges[e].y0) + 1;
    return count;
}

author_result silmap_edges_sort(author_run *run, silmap_truth *truth) {
    const silmap_edge *edges = truth->edges;
    truth->rows = truth->picture->height;
    while (truth->rows > 1 && count_entries(truth) > FEW_ENTRIES + ENTRIES_OF_EDGE * truth->edge_count)
        truth->rows /= 2;
    truth->row_first = author_alloc(run, (size_t)truth->rows + 2, sizeof *truth->row_first);
    if (!truth->row_first)
        return AUTHOR_NO_MEMORY;
    for (size_t e = 0; e < truth->edge_count; e++)
        for (uint32_t r = silmap_edges_band(truth, edges[e].y0); r <= silmap_edges_band(truth, edges[e].y1); r++)
            truth->row_first[r + 2]++;
    for (uint32_t r = 0; r < truth->rows; r++)
        truth->row_first[r + 2] += truth->row_first[r + 1];
    truth->row_edges = author_alloc(run, truth->row_first[truth->rows + 1], sizeof *truth->row_edges);
    if (!truth->row_edges)
        return AUTHOR_NO_MEMORY;
    for (size_t e = 0; e < truth->edge_count; e++)
        for (uint32_t r = silmap_edges_band(truth, edges[e].y0); r <= silmap_edges_band(truth, edges[e].y1); r++)
            truth->row_edges[truth->row_first[r + 1]++] = (uint32_t)e;
    return AUTHOR_OK;
}

/* Sums of marks for up to BLOCK places. */
static void marks_of_row(const silmap_truth *truth, double y, double x0, double dx, size_t count,
                         uint64_t marks[BLOCK]) {
    uint32_t row = silmap_edges_band(truth, y);
    memset(marks, 0, BLOCK * sizeof *marks);
    for (size_t i = truth->row_first[row]; i < truth->row_first[row + 1]; i++) {
        const silmap_edge *edge = &truth->edges[truth->row_edges[i]];
        if (y < edge->y0 || y >= edge->y1)
            continue;
        double x = edge->x0 + (edge->x1 - edge->x0) * ((y - edge->y0) / (edge->y1 - edge->y0));
        double at = ceil((x - x0) / dx);
        if (at < (double)count)
            marks[at > 0 ? (size_t)at : 0] += edge->mark;
    }
    for (size_t i = 1; i < count; i++)
        marks[i] += marks[i - 1];
}

static size_t mark_place(const silmap_truth *truth, uint64_t mark) {
    size_t low = 0, high = truth->mark_count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (truth->marks[middle] < mark)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* SIZE_MAX: no texel has it. */
static size_t region_of_mark(const silmap_truth *truth, uint64_t mark) {
    size_t place = mark_place(truth, mark);
    return place < truth->mark_count && truth->marks[place] == mark ? truth->mark_region[place] : SIZE_MAX;
}

static int compare_marks(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static author_result keep_marks(author_run *run, const key_map *map, silmap_truth *truth) {
    truth->marks = author_alloc(run, map->count, sizeof *truth->marks);
    truth->mark_region = author_alloc(run, map->count, sizeof *truth->mark_region);
    if (!truth->marks || !truth->mark_region)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < map->size; i++)
        if (map->values[i])
            truth->marks[truth->mark_count++] = map->keys[i];
    qsort(truth->marks, truth->mark_count, sizeof *truth->marks, compare_marks);
    for (size_t i = 0; i < truth->mark_count; i++)
        truth->mark_region[i] = map->values[key_slot(map, truth->marks[i])] - 1;
    truth->region_count = (uint32_t)map->count;
    return AUTHOR_OK;
}

static author_result number_marks(author_run *run, key_map *map, const uint64_t *marks, size_t count,
                                  uint32_t *labels) {
    author_result result = AUTHOR_OK;
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++)
        result = key_number(run, map, marks[i], &labels[i]);
    return result;
}

static author_result number_paths(author_run *run, silmap_truth *truth, key_map *map) {
    size_t w = truth->picture->width, h = truth->picture->height;
    double dx = 1.0 / (double)w;
    uint64_t marks[BLOCK];
    author_result result = AUTHOR_OK;
    for (size_t i = 0; i < w * h && result == AUTHOR_OK;) {
        size_t x = i % w, n = w - x < BLOCK ? w - x : BLOCK;
        marks_of_row(truth, ((double)(i / w) + 0.5) / (double)h, ((double)x + 0.5) * dx, dx, n, marks);
        result = number_marks(run, map, marks, n, truth->labels + i);
        i += n;
    }
    return result == AUTHOR_OK ? keep_marks(run, map, truth) : result;
}

static author_result labels_of_paths(author_run *run, const author_silmap_input *input, silmap_truth *truth) {
    truth->edges = author_alloc(run, count_edges(input), sizeof *truth->edges);
    if (!truth->edges)
        return AUTHOR_NO_MEMORY;
    put_edges(input, truth);
    author_result result = silmap_edges_sort(run, truth);
    key_map map = {0};
    if (result == AUTHOR_OK)
        result = number_paths(run, truth, &map);
    key_release(&map);
    return result;
}

/* Texels that have another region beside them may be mixtures of both. */
static void mark_mixed(silmap_truth *truth) {
    size_t w = truth->picture->width, h = truth->picture->height;
    for (size_t y = 0; y < h; y++) {
        for (size_t x = 0; x < w; x++) {
            uint32_t *at = &truth->labels[y * w + x];
            uint32_t own = *at & ~SILMAP_MIXED;
            if (x + 1 < w && (at[1] & ~SILMAP_MIXED) != own)
                at[0] |= SILMAP_MIXED, at[1] |= SILMAP_MIXED;
            if (y + 1 < h && (at[w] & ~SILMAP_MIXED) != own)
                at[0] |= SILMAP_MIXED, at[w] |= SILMAP_MIXED;
        }
    }
}

/* ---- shapes ------------------------------------------------------------------------------------------- */

typedef struct colour_job {
    const silmap_truth *truth;
    silmap_sweep *sweeps; /* of each worker */
} colour_job;

static author_result colour_row(void *context, size_t y, unsigned worker, char *error) {
    (void)error;
    const colour_job *job = context;
    const author_picture *picture = job->truth->picture;
    const silmap_run *run = job->sweeps[worker].runs;
    uint32_t *labels = job->truth->labels + y * picture->width;
    double dx = 1.0 / picture->width;
    silmap_fills_runs(&job->sweeps[worker], ((double)y + 0.5) / picture->height, dx / 2, dx, picture->width);
    for (size_t x = 0; x < picture->width; run++)
        for (; x < run->end; x++)
            labels[x] = run->key;
    return AUTHOR_OK;
}

/* The labels are the colours at the centres of texels. */
static author_result colour_texels(author_run *run, silmap_truth *truth) {
    unsigned workers = author_workers(run);
    colour_job job = {truth, author_alloc(run, workers, sizeof *job.sweeps)};
    author_result result = job.sweeps ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (unsigned i = 0; i < workers && result == AUTHOR_OK; i++)
        result = silmap_sweep_create(truth, &job.sweeps[i]);
    if (result == AUTHOR_OK)
        result = author_for(run, "regions", truth->picture->height, colour_row, &job);
    for (unsigned i = 0; job.sweeps && i < workers; i++)
        silmap_sweep_release(&job.sweeps[i]);
    free(job.sweeps);
    return result;
}

/* Regions by the first texel that they have; then those that are nowhere as large as that. */
static author_result number_colours(author_run *run, silmap_truth *truth, key_map *map) {
    size_t count = (size_t)truth->picture->width * truth->picture->height;
    author_result result = AUTHOR_OK;
    uint32_t last = ~truth->labels[0], region = 0;
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++) {
        if (truth->labels[i] != last) {
            last = truth->labels[i];
            result = key_number(run, map, last, &region);
        }
        truth->labels[i] = region;
    }
    for (size_t s = 0; s < truth->fills->count && result == AUTHOR_OK; s++)
        if (!truth->fills->shapes[s].bounds && !(truth->fills->paint[s].keep > 0))
            result = key_number(run, map, silmap_fills_key(truth->fills->paint[s].value), &region);
    return result == AUTHOR_OK ? keep_marks(run, map, truth) : result;
}

static void set_region(const silmap_truth *truth, const float value[SILMAP_CHANNELS], silmap_region *out) {
    float texel[SILMAP_CHANNELS];
    int alpha = truth->curve->alpha;
    silmap_fills_texel(truth->fills, value, texel);
    for (uint32_t ch = 0; ch < truth->picture->channels; ch++) {
        out->colour[ch] = alpha < 0 || (int)ch == alpha ? texel[ch] : texel[ch] * texel[alpha];
        out->coded[ch] = silmap_code(truth->curve, ch, out->colour[ch]);
    }
    out->flat = 1;
}

/* From a place of each: 8 bits are too few where little of a colour is seen. */
static author_result set_regions(author_run *run, silmap_truth *truth) {
    const struct silmap_fills *fills = truth->fills;
    size_t width = truth->picture->width, count = width * truth->picture->height;
    float value[SILMAP_CHANNELS];
    silmap_sweep sweep;
    truth->regions = author_alloc(run, truth->region_count, sizeof *truth->regions);
    if (!truth->regions || silmap_sweep_create(truth, &sweep) != AUTHOR_OK)
        return AUTHOR_NO_MEMORY;
    for (size_t s = 0; s < fills->count; s++)
        if (!fills->shapes[s].bounds && !(fills->paint[s].keep > 0))
            set_region(truth, fills->paint[s].value,
                       &truth->regions[region_of_mark(truth, silmap_fills_key(fills->paint[s].value))]);
    for (size_t i = 0; i < count; i++) {
        silmap_region *region = &truth->regions[truth->labels[i]];
        if (!region->flat) {
            double x = ((double)(i % width) + 0.5) / (double)width;
            silmap_sweep_line(&sweep, ((double)(i / width) + 0.5) / truth->picture->height);
            for (size_t k = 0; k < sweep.count && sweep.list[k].x <= x; k++)
                silmap_sweep_cross(&sweep, k);
            silmap_sweep_value(&sweep, value);
            silmap_sweep_end(&sweep);
            set_region(truth, value, region);
        }
        region->texels++;
    }
    silmap_sweep_release(&sweep);
    return AUTHOR_OK;
}

static author_result labels_of_shapes(author_run *run, const author_silmap_input *input, silmap_truth *truth) {
    key_map map = {0};
    author_result result = silmap_fills_create(run, input, truth->curve->colours == 0, truth);
    if (result == AUTHOR_OK)
        result = colour_texels(run, truth);
    if (result == AUTHOR_OK)
        result = number_colours(run, truth, &map);
    if (result == AUTHOR_OK)
        result = set_regions(run, truth);
    if (result == AUTHOR_OK)
        mark_mixed(truth);
    key_release(&map);
    return result;
}

/* ---- given labels ------------------------------------------------------------------------------------- */

static author_result labels_given(author_run *run, const uint32_t *labels, silmap_truth *truth) {
    size_t count = (size_t)truth->picture->width * truth->picture->height;
    key_map map = {0};
    author_result result = AUTHOR_OK;
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++) {
        if (i > 0 && labels[i] == labels[i - 1])
            truth->labels[i] = truth->labels[i - 1];
        else
            result = key_number(run, &map, labels[i], &truth->labels[i]);
    }
    truth->region_count = (uint32_t)map.count;
    key_release(&map);
    return result;
}

/* ---- statistics --------------------------------------------------------------------------------------- */

typedef struct region_sum {
    double linear[SILMAP_CHANNELS], coded[SILMAP_CHANNELS], square[SILMAP_CHANNELS];
    double count;
} region_sum;

/* Adds count equal texels. */
static void add_texels(const silmap_truth *truth, size_t i, size_t count, region_sum *sum) {
    float texel[SILMAP_CHANNELS];
    double times = (double)count;
    silmap_texel(truth->picture, truth->curve, i, texel);
    for (uint32_t ch = 0; ch < truth->picture->channels; ch++) {
        double coded = (double)silmap_code(truth->curve, ch, texel[ch]);
        sum->linear[ch] += times * (double)texel[ch];
        sum->coded[ch] += times * coded;
        sum->square[ch] += times * coded * coded;
    }
    sum->count += times;
}

/* How many texels from number i on are equal, in the same region. */
static size_t equal_texels(const silmap_truth *truth, size_t i, size_t count) {
    const float *texel = truth->picture->texels + i * truth->picture->channels;
    size_t size = truth->picture->channels * sizeof *texel, n = 1;
    for (const float *next = texel + truth->picture->channels; i + n < count; n++, next += truth->picture->channels)
        if (truth->labels[i + n] != truth->labels[i] || memcmp(next, texel, size) != 0)
            break;
    return n;
}

static void finish_region(uint32_t channels, const region_sum *sum, silmap_region *out) {
    double n = sum->count > 0 ? sum->count : 1;
    out->flat = 1;
    out->texels = sum->count;
    for (uint32_t ch = 0; ch < channels; ch++) {
        double mean = sum->coded[ch] / n;
        out->colour[ch] = (float)(sum->linear[ch] / n);
        out->coded[ch] = (float)mean;
        if (sum->square[ch] / n - mean * mean > FLAT_DEVIATION * FLAT_DEVIATION)
            out->flat = 0;
    }
}

/* Of the texels that are inside altogether; a region that has none takes those at its border. */
static author_result measure_regions(author_run *run, silmap_truth *truth) {
    size_t count = (size_t)truth->picture->width * truth->picture->height;
    region_sum *sums = author_alloc(run, truth->region_count, sizeof *sums);
    region_sum *border = author_alloc(run, truth->region_count, sizeof *border);
    free(truth->regions);
    truth->regions = author_alloc(run, truth->region_count, sizeof *truth->regions);
    if (!sums || !border || !truth->regions) {
        free(sums);
        free(border);
        return AUTHOR_NO_MEMORY;
    }
    for (size_t i = 0, n; i < count; i += n) {
        n = equal_texels(truth, i, count);
        add_texels(truth, i, n, &(truth->labels[i] & SILMAP_MIXED ? border : sums)[truth->labels[i] & ~SILMAP_MIXED]);
    }
    for (uint32_t r = 0; r < truth->region_count; r++)
        finish_region(truth->picture->channels, sums[r].count > 0 ? &sums[r] : &border[r], &truth->regions[r]);
    free(sums);
    free(border);
    return AUTHOR_OK;
}

static int same_colour(const silmap_truth *truth, uint32_t a, uint32_t b) {
    const silmap_region *x = &truth->regions[a], *y = &truth->regions[b];
    if (!x->flat || !y->flat)
        return 0;
    for (uint32_t ch = 0; ch < truth->picture->channels; ch++)
        if (fabs((double)x->coded[ch] - (double)y->coded[ch]) > SAME_COLOUR)
            return 0;
    return 1;
}

/* Paths may run below others, and several regions may be painted in one colour: there is no edge between them. */
static author_result merge_regions(author_run *run, silmap_truth *truth) {
    uint32_t *to = author_alloc(run, truth->region_count, sizeof *to);
    uint32_t *kept = author_alloc(run, truth->region_count, sizeof *kept);
    if (!to || !kept) {
        free(to);
        free(kept);
        return AUTHOR_NO_MEMORY;
    }
    uint32_t count = 0;
    for (uint32_t r = 0; r < truth->region_count; r++) {
        uint32_t k = 0;
        while (k < count && k < 4096 && !same_colour(truth, kept[k], r))
            k++;
        if (k == count || k == 4096)
            kept[k = count++] = r;
        to[r] = k;
    }
    size_t texels = (size_t)truth->picture->width * truth->picture->height;
    for (size_t i = 0; i < texels; i++)
        truth->labels[i] = to[truth->labels[i] & ~SILMAP_MIXED];
    for (size_t i = 0; i < truth->mark_count; i++)
        truth->mark_region[i] = to[truth->mark_region[i]];
    truth->region_count = count;
    free(to);
    free(kept);
    mark_mixed(truth);
    return measure_regions(run, truth);
}

/* ---- all together ------------------------------------------------------------------------------------- */

static int all_closed(const author_silmap_input *input) {
    for (size_t p = 0; p < input->path_count; p++)
        if (!input->paths[p].closed)
            return 0;
    return input->path_count > 0;
}

static author_result find_regions(author_run *run, const author_silmap_input *input, silmap_truth *truth, int *found) {
    author_result result;
    *found = 1;
    if (input->shape_count > 0)
        return labels_of_shapes(run, input, truth);
    if (all_closed(input))
        result = labels_of_paths(run, input, truth);
    else if (input->paths_only)
        return *found = 0, AUTHOR_OK;
    else if (input->labels)
        result = labels_given(run, input->labels, truth);
    else if (input->path_count == 0)
        return silmap_flat_find(run, truth, found);
    else
        return *found = 0, AUTHOR_OK;
    if (result != AUTHOR_OK)
        return result;
    mark_mixed(truth);
    result = measure_regions(run, truth);
    return result == AUTHOR_OK && truth->edges ? merge_regions(run, truth) : result;
}

author_result silmap_truth_create(author_run *run, const author_silmap_input *input, const silmap_curve *curve,
                                  silmap_truth *out, int *found) {
    *out = (silmap_truth){.picture = input->picture, .curve = curve};
    *found = 0;
    out->labels = author_alloc(run, (size_t)input->picture->width * input->picture->height, sizeof *out->labels);
    author_result result = out->labels ? find_regions(run, input, out, found) : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK && *found && !out->regions)
        result = measure_regions(run, out);
    if (result != AUTHOR_OK || !*found)
        silmap_truth_release(out);
    return result;
}

void silmap_truth_release(silmap_truth *truth) {
    free(truth->labels);
    free(truth->regions);
    free(truth->edges);
    free(truth->row_first);
    free(truth->row_edges);
    free(truth->marks);
    free(truth->mark_region);
    silmap_fills_release(truth->fills);
    *truth = (silmap_truth){0};
}

static size_t texel_at(const silmap_truth *truth, double x, double y) {
    size_t w = truth->picture->width, h = truth->picture->height;
    double u = x * (double)w, v = y * (double)h;
    size_t i = u <= 0 ? 0 : u >= (double)w ? w - 1 : (size_t)u;
    size_t j = v <= 0 ? 0 : v >= (double)h ? h - 1 : (size_t)v;
    return j * w + i;
}

static uint32_t label_at(const silmap_truth *truth, double x, double y) {
    return truth->labels[texel_at(truth, x, y)] & ~SILMAP_MIXED;
}

static void row_of_paths(const silmap_truth *truth, double y, double x0, double dx, size_t count, uint32_t *out) {
    uint64_t marks[BLOCK];
    for (size_t first = 0; first < count; first += BLOCK) {
        size_t n = count - first < BLOCK ? count - first : BLOCK;
        marks_of_row(truth, y, x0 + (double)first * dx, dx, n, marks);
        for (size_t i = 0; i < n; i++) {
            if (i > 0 && marks[i] == marks[i - 1]) {
                out[first + i] = out[first + i - 1];
                continue;
            }
            size_t region = region_of_mark(truth, marks[i]);
            out[first + i] = region != SIZE_MAX ? (uint32_t)region : label_at(truth, x0 + (double)(first + i) * dx, y);
        }
    }
}

/* Where several colours are seen through each other there may be one that no texel has: it counts as that of its texel.
 * So does everything when there is no memory. */
static void row_of_shapes(const silmap_truth *truth, double y, double x0, double dx, size_t count, uint32_t *out) {
    silmap_sweep sweep;
    const silmap_run everything = {count, 0}, *run = &everything;
    int swept = silmap_sweep_create(truth, &sweep) == AUTHOR_OK;
    if (swept && count > 0) {
        silmap_fills_runs(&sweep, y, x0, dx, count);
        run = sweep.runs;
    }
    for (size_t i = 0; i < count; run++) {
        size_t region = swept ? region_of_mark(truth, run->key) : SIZE_MAX;
        for (; i < run->end; i++)
            out[i] = region != SIZE_MAX ? (uint32_t)region : label_at(truth, x0 + (double)i * dx, y);
    }
    silmap_sweep_release(&sweep);
}

void silmap_truth_row(const silmap_truth *truth, double y, double x0, double dx, size_t count, uint32_t *out) {
    if (truth->fills) {
        row_of_shapes(truth, y, x0, dx, count, out);
        return;
    }
    if (truth->edges) {
        row_of_paths(truth, y, x0, dx, count, out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        double x = x0 + (double)i * dx;
        out[i] = truth->resolve ? silmap_flat_at(truth, x, y) : label_at(truth, x, y);
    }
}

uint32_t silmap_truth_texel(const silmap_truth *truth, size_t index, int *pure) {
    *pure = !(truth->labels[index] & SILMAP_MIXED);
    return truth->labels[index] & ~SILMAP_MIXED;
}

int silmap_truth_plain(const silmap_truth *truth, double x0, double y0, double x1, double y1, uint32_t *region) {
    if (truth->edges)
        return 0;
    size_t w = truth->picture->width;
    double margin = truth->resolve ? 1 : 0;
    size_t from = texel_at(truth, x0 - margin / (double)w, y0 - margin / truth->picture->height);
    size_t to = texel_at(truth, x1 + margin / (double)w, y1 + margin / truth->picture->height);
    *region = truth->labels[from] & ~SILMAP_MIXED;
    for (size_t y = from / w; y <= to / w; y++)
        for (size_t x = from % w; x <= to % w; x++)
            if (truth->labels[y * w + x] != *region)
                return 0;
    return 1;
}
