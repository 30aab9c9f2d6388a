/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which pairs of many photographs are worth a look. All features go into one index; the largest of each picture, which
 * are those that a coarser picture can show, are looked up there, and vote for the pictures that have something alike.
 * Features of one zoom differ by one size and one turn: only votes that agree in both count together, so that chance
 * makes few.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    QUERIES = 800,    /* the largest features of a picture */
    NEIGHBOURS = 16,  /* of each; the last one says how near chance comes */
    SIZES = 14,       /* bins of one octave; the outer ones take what lies beyond */
    TURNS = 12,       /* bins of 30 degrees */
    ROW_BYTES = 256,  /* of a feature in the index */
    LEAST_ROWS = 500, /* of one picture in the index, whatever the memory */
    MORE = 4,         /* times the candidates that are wanted, at most */
    CELLS = SIZES * TURNS
};

static const float CLEAR = 6;            /* a score that chance hardly reaches */
static const float LARGEST = 255 / 0.5f; /* of a number of a descriptor; what is more becomes 0.5 */

typedef struct row {
    uint32_t photo, point;
} row;

typedef struct selection {
    const author_vision *vision;
    const photo *photos;
    size_t count, each; /* pictures; rows of one, at most */
    size_t row_count;
    uint8_t *bytes;
    row *rows;
    author_index *index;
    float *scores; /* of count x count, by query, then by what was found */
} selection;

static void quantise(const float *descriptor, uint8_t *out) {
    for (int i = 0; i < AUTHOR_DESCRIPTOR; i++)
        out[i] = (uint8_t)fminf(descriptor[i] * LARGEST + 0.5f, 255);
}

/* ---- the index ---------------------------------------------------------------------------------------------- */

static size_t rows_of(const selection *s, const photo *p) {
    size_t count;
    s->vision->points(p->features, &count);
    return count < s->each ? count : s->each;
}

/* Of all sizes alike: what is large in a zoom is small in the picture around it. */
static void fill_rows(selection *s, uint32_t photo_index, size_t first) {
    const author_features *features = s->photos[photo_index].features;
    const float *descriptors = s->vision->descriptors(features);
    size_t count, taken = rows_of(s, &s->photos[photo_index]);
    s->vision->points(features, &count);
    for (size_t i = 0; i < taken; i++) {
        size_t point = i * count / taken;
        s->rows[first + i] = (row){photo_index, (uint32_t)point};
        quantise(descriptors + point * AUTHOR_DESCRIPTOR, s->bytes + (first + i) * AUTHOR_DESCRIPTOR);
    }
}

static author_result fill_index(author_run *run, selection *s) {
    for (size_t i = 0; i < s->count; i++)
        s->row_count += rows_of(s, &s->photos[i]);
    s->rows = author_alloc(run, s->row_count, sizeof *s->rows);
    s->bytes = author_alloc(run, s->row_count, AUTHOR_DESCRIPTOR);
    s->scores = author_alloc(run, s->count * s->count, sizeof *s->scores);
    if (!s->rows || !s->bytes || !s->scores)
        return AUTHOR_NO_MEMORY;
    size_t first = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        fill_rows(s, i, first);
        first += rows_of(s, &s->photos[i]);
    }
    return s->vision->index_create(s->bytes, s->row_count, &s->index, run->error) ? AUTHOR_INTERNAL : AUTHOR_OK;
}

/* ---- votes -------------------------------------------------------------------------------------------------- */

typedef struct ballot {
    uint8_t *queries;
    uint32_t *numbers;
    float *squares;
    float *cells; /* of each picture: by size, then by turn */
} ballot;

static size_t cell_of(const author_point *from, const author_point *to) {
    double size = floor(log2((double)(to->size / from->size))) + SIZES / 2;
    double turn = (double)(to->angle - from->angle) / 360;
    int across = (int)((turn - floor(turn)) * TURNS);
    int down = (int)fmin(fmax(size, 0), SIZES - 1);
    return (size_t)(down * TURNS + across % TURNS);
}

/* The neighbours of one feature: the nearer one is, compared with the last, the more it says. */
static void vote(const selection *s, const ballot *b, size_t query, uint32_t photo_index, const author_point *point) {
    const uint32_t *numbers = b->numbers + query * NEIGHBOURS;
    const float *squares = b->squares + query * NEIGHBOURS;
    if (numbers[NEIGHBOURS - 1] == UINT32_MAX || !(squares[NEIGHBOURS - 1] > 0))
        return;
    for (int k = 0; k < NEIGHBOURS - 1; k++) {
        const row *found = &s->rows[numbers[k]];
        size_t count;
        if (found->photo == photo_index)
            continue;
        const author_point *points = s->vision->points(s->photos[found->photo].features, &count);
        float weight = 1 - squares[k] / squares[NEIGHBOURS - 1];
        b->cells[found->photo * (size_t)CELLS + cell_of(point, &points[found->point])] += weight * weight;
    }
}

/* The most that neighbouring cells have together: two sizes, two turns. */
static float best_cells(const float *cells) {
    float best = 0;
    for (int size = 0; size + 1 < SIZES; size++)
        for (int turn = 0; turn < TURNS; turn++) {
            const float *a = cells + size * TURNS, *b = a + TURNS;
            int next = (turn + 1) % TURNS;
            best = fmaxf(best, a[turn] + a[next] + b[turn] + b[next]);
        }
    return best;
}

static author_result ballot_open(author_run *run, size_t count, ballot *b) {
    b->queries = author_alloc(run, QUERIES, AUTHOR_DESCRIPTOR);
    b->numbers = author_alloc(run, QUERIES * NEIGHBOURS, sizeof *b->numbers);
    b->squares = author_alloc(run, QUERIES * NEIGHBOURS, sizeof *b->squares);
    b->cells = author_alloc(run, count * CELLS, sizeof *b->cells);
    return b->queries && b->numbers && b->squares && b->cells ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static void ballot_close(ballot *b) {
    free(b->queries);
    free(b->numbers);
    free(b->squares);
    free(b->cells);
}

static author_result score_photo(author_run *run, const selection *s, uint32_t i, ballot *b) {
    const author_features *features = s->photos[i].features;
    const float *descriptors = s->vision->descriptors(features);
    size_t count;
    const author_point *points = s->vision->points(features, &count);
    author_result result = ballot_open(run, s->count, b);
    if (result != AUTHOR_OK)
        return result;
    if (count > QUERIES)
        count = QUERIES;
    for (size_t q = 0; q < count; q++)
        quantise(descriptors + q * AUTHOR_DESCRIPTOR, b->queries + q * AUTHOR_DESCRIPTOR);
    if (s->vision->index_search(s->index, b->queries, count, NEIGHBOURS, b->numbers, b->squares, run->error))
        return AUTHOR_INTERNAL;
    for (size_t q = 0; q < count; q++)
        vote(s, b, q, i, &points[q]);
    for (size_t k = 0; k < s->count; k++)
        s->scores[i * s->count + k] = best_cells(b->cells + k * CELLS);
    return AUTHOR_OK;
}

static author_result score_task(void *context, size_t i, unsigned worker, char *error) {
    author_run run = {0};
    ballot b = {0};
    (void)worker;
    author_result result = score_photo(&run, context, (uint32_t)i, &b);
    ballot_close(&b);
    memcpy(error, run.error, AUTHOR_ERROR);
    return result;
}

/* ---- the choice --------------------------------------------------------------------------------------------- */

static float score(const selection *s, size_t a, size_t b) {
    return fmaxf(s->scores[a * s->count + b], s->scores[b * s->count + a]);
}

/* Marks the best partners of a picture, as many as wanted, and more of them while they are clear: where many pictures
 * show one thing, its own parent need not be among the first. */
static void mark_best(const selection *s, size_t i, uint32_t wanted, bool *chosen) {
    bool *own = chosen + i * s->count;
    for (uint32_t n = 0; n < MORE * wanted; n++) {
        size_t best = i;
        for (size_t k = 0; k < s->count; k++)
            if (k != i && !own[k] && (best == i || score(s, i, k) > score(s, i, best)))
                best = k;
        if (best == i || (n >= wanted && score(s, i, best) < CLEAR))
            return;
        own[best] = true;
    }
}

static author_result choose(author_run *run, const selection *s, uint32_t wanted, edge_list *out) {
    bool *chosen = author_alloc(run, s->count * s->count, sizeof *chosen);
    author_result result = chosen ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < s->count && result == AUTHOR_OK; i++)
        mark_best(s, i, wanted, chosen);
    for (uint32_t a = 0; a < s->count && result == AUTHOR_OK; a++)
        for (uint32_t b = a + 1; b < s->count && result == AUTHOR_OK; b++) {
            bool looked = chosen[a * s->count + b] || chosen[b * s->count + a];
            edge *e = looked ? edge_append(run, out) : NULL;
            if (e)
                *e = (edge){.coarse = a, .fine = b};
            else if (looked)
                result = AUTHOR_NO_MEMORY;
        }
    free(chosen);
    return result;
}

author_result select_pairs(author_run *run, const author_vision *vision, const photo *photos, size_t count,
                           uint32_t wanted, uint64_t memory, edge_list *out) {
    selection s = {.vision = vision, .photos = photos, .count = count};
    uint64_t each = memory / ROW_BYTES / count;
    s.each = each < LEAST_ROWS ? LEAST_ROWS : (size_t)each;
    author_result result = fill_index(run, &s);
    if (result == AUTHOR_OK)
        result = author_for(run, "candidates", count, score_task, &s);
    if (result == AUTHOR_OK)
        result = choose(run, &s, wanted, out);
    vision->index_release(s.index);
    free(s.rows);
    free(s.bytes);
    free(s.scores);
    return result;
}
