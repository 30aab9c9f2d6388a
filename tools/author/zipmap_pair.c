/* SPDX-License-Identifier: Apache-2.0 */
/* The homography between two pictures, from features; then what its test says. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    QUERIES = 1500,    /* the largest features of the finer picture: those that the coarser one can show */
    CLEAR = 60,        /* inliers that settle which picture is the finer one */
    LEAST_MATCHES = 8, /* that agree in size and direction, before a homography is tried */
    LEAST_INLIERS = 6,
    TRIES = 4 /* changes of size and direction that are looked into, each way */
};

static const double LEAST_SHARE = 0.25; /* of the matches that agree in size and direction */
static const float DISTINCT = 0.85F;    /* of a match's distance to the second best's */
static const double SIZE_REACH = 0.6;   /* octaves about the most frequent change of size */
static const double ANGLE_REACH = 35;   /* degrees about the most frequent turn; perspective shears a little */
static const double LEAST_LOCAL = 0.6;  /* correlation of detail */
static const double REACH = 2;          /* pixels that a match may be off */
static const double NEAR_REACH = 0.06;  /* of the picture's width: how far a first homography may be off */

/* A match in pixels of both feature pictures, with the change of size and direction that it stands for. */
typedef struct tie {
    double from[2], to[2];
    double size, turn; /* octaves, degrees */
} tie;

static double turned(double degrees) {
    return degrees - 360 * floor(degrees / 360 + 0.5);
}

static bool agrees(const tie *a, const tie *b) {
    return fabs(a->size - b->size) < SIZE_REACH && fabs(turned(a->turn - b->turn)) < ANGLE_REACH;
}

/* Brings the ties that most others agree with to the front, and counts them: of wrong ones hardly any agree. */
static size_t gather_agreeing(tie *ties, size_t count) {
    size_t best = 0, most = 0, kept = 0;
    for (size_t i = 0; i < count; i++) {
        size_t friends = 0;
        for (size_t j = 0; j < count; j++)
            friends += agrees(&ties[i], &ties[j]);
        if (friends > most) {
            most = friends;
            best = i;
        }
    }
    tie middle = count ? ties[best] : (tie){0};
    for (size_t i = 0; i < count; i++) {
        tie other = ties[i];
        if (!agrees(&middle, &other))
            continue;
        ties[i] = ties[kept];
        ties[kept++] = other;
    }
    return kept;
}

/* Where many features are thought to be the same one, as on plain colour, at most one is: the most distinctive
 * stays. */
static author_result keep_one_each(author_run *run, author_match *matches, size_t *count, size_t trains) {
    uint32_t *first = author_alloc(run, trains, sizeof *first); /* 1 + the best match */
    size_t kept = 0;
    if (!first)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < *count; i++) {
        uint32_t *best = &first[matches[i].train];
        if (!*best || matches[i].ratio < matches[*best - 1].ratio)
            *best = (uint32_t)i + 1;
    }
    for (size_t i = 0; i < *count; i++)
        if (first[matches[i].train] == i + 1)
            matches[kept++] = matches[i];
    *count = kept;
    free(first);
    return AUTHOR_OK;
}

static size_t ties_of(const author_point *from, const author_point *to, const author_match *matches, size_t count,
                      tie *ties) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        const author_point *a = &from[matches[i].query], *b = &to[matches[i].train];
        if (matches[i].ratio < DISTINCT)
            ties[kept++] = (tie){.from = {(double)a->x, (double)a->y},
                                 .to = {(double)b->x, (double)b->y},
                                 .size = log2((double)(b->size / a->size)),
                                 .turn = (double)(b->angle - a->angle)};
    }
    return kept;
}

/* The homography that the ties follow, in pixels; inliers 0 when there is none. */
static author_result fit(author_run *run, const author_vision *vision, const tie *ties, size_t count, plane *matrix,
                         uint32_t *inliers) {
    double *places = author_alloc(run, count, 4 * sizeof *places);
    uint8_t *inlier = author_alloc(run, count, 1);
    author_result result = places && inlier ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    int found = 0;
    *inliers = 0;
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++) {
        memcpy(places + 2 * i, ties[i].from, sizeof ties[i].from);
        memcpy(places + 2 * (count + i), ties[i].to, sizeof ties[i].to);
    }
    if (result == AUTHOR_OK &&
        vision->homography(places, places + 2 * count, count, REACH, matrix->m, inlier, &found, run->error) != 0)
        result = AUTHOR_INTERNAL;
    for (size_t i = 0; i < count && found; i++)
        *inliers += inlier[i];
    free(places);
    free(inlier);
    return result;
}

/* From pixels of the fine picture's features to pixels of the coarse one's, into e->matrix. */
static bool take_matrix(const plane *pixels, const uint32_t fine[2], const uint32_t coarse[2], edge *e) {
    plane to_pixels = plane_scale(fine[0], fine[1]), to_unit = plane_scale(1.0 / coarse[0], 1.0 / coarse[1]);
    plane a = plane_multiply(pixels, &to_pixels), b = plane_multiply(&to_unit, &a);
    return plane_inverse(&b, &e->matrix) && plane_normalise(&e->matrix);
}

typedef struct look {
    author_match *matches;
    tie *ties;
    size_t room;
} look;

static author_result look_open(author_run *run, size_t room, look *out) {
    *out = (look){.room = room};
    out->matches = author_alloc(run, room, sizeof *out->matches);
    out->ties = author_alloc(run, room, sizeof *out->ties);
    return out->matches && out->ties ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static void look_close(look *l) {
    free(l->matches);
    free(l->ties);
    *l = (look){0};
}

/* Turns an edge whose fine picture is the coarser one. */
static bool orient(const photo *photos, edge *e) {
    plane back;
    e->ratio = plane_ratio(&e->matrix, photos[e->coarse].pixels, photos[e->fine].pixels);
    if (!(e->ratio > 0) || !isfinite(e->ratio) || !plane_inverse(&e->matrix, &back))
        return false;
    if (e->ratio >= 1)
        return true;
    uint32_t coarse = e->coarse;
    e->coarse = e->fine;
    e->fine = coarse;
    e->matrix = back;
    e->ratio = plane_ratio(&e->matrix, photos[e->coarse].pixels, photos[e->fine].pixels);
    return plane_normalise(&e->matrix);
}

/* Whether ties enough follow one homography. What is far outside of the fine picture may look odd, so it is turned
 * before it is judged. */
static author_result try_ties(author_run *run, const author_vision *vision, const photo *photos, const tie *ties,
                              size_t count, edge *e) {
    plane pixels;
    e->matches = (uint32_t)count;
    e->reason = AUTHOR_REASON_FEW_MATCHES;
    if (count < LEAST_MATCHES)
        return AUTHOR_OK;
    author_result result = fit(run, vision, ties, count, &pixels, &e->inliers);
    e->reason = AUTHOR_REASON_NO_HOMOGRAPHY;
    if (result != AUTHOR_OK || e->inliers < LEAST_INLIERS || e->inliers < LEAST_SHARE * e->matches)
        return result;
    if (take_matrix(&pixels, photos[e->fine].feature_size, photos[e->coarse].feature_size, e) && orient(photos, e) &&
        plane_plausible(&e->matrix, photos[e->coarse].pixels, photos[e->fine].pixels))
        e->reason = AUTHOR_REASON_NONE;
    return AUTHOR_OK;
}

static bool better(const edge *a, const edge *b) {
    bool held = a->reason == AUTHOR_REASON_NONE, other = b->reason == AUTHOR_REASON_NONE;
    return held != other ? held : a->inliers != b->inliers ? a->inliers > b->inliers : a->matches > b->matches;
}

/* Keeps the best places that were tried, the best first. */
static void offer(pair_places *places, const edge *tried) {
    size_t i = places->count;
    while (i > 0 && better(tried, &places->edges[i - 1]))
        i--;
    if (i == PAIR_PLACES)
        return;
    places->count += places->count < PAIR_PLACES;
    memmove(places->edges + i + 1, places->edges + i, (places->count - 1 - i) * sizeof *tried);
    places->edges[i] = *tried;
}

static bool is_clear(const pair_places *places) {
    return places->count && places->edges[0].reason == AUTHOR_REASON_NONE && places->edges[0].inliers >= CLEAR;
}

/* fine as the finer picture of the two. */
static author_result look_one_way(author_run *run, const author_vision *vision, const photo *photos, uint32_t fine,
                                  uint32_t coarse, look *l, pair_places *places) {
    size_t fine_count, coarse_count, count;
    const author_features *from = photos[fine].features, *to = photos[coarse].features;
    const author_point *from_points = vision->points(from, &fine_count), *to_points = vision->points(to, &coarse_count);
    if (vision->match(from, l->room, to, l->matches, &count, run->error) != 0)
        return AUTHOR_INTERNAL;
    author_result result = keep_one_each(run, l->matches, &count, coarse_count);
    tie *rest = l->ties;
    size_t left = result == AUTHOR_OK ? ties_of(from_points, to_points, l->matches, count, rest) : 0;
    for (int i = 0; i < TRIES && result == AUTHOR_OK && !is_clear(places); i++) {
        edge tried = {.coarse = coarse, .fine = fine};
        size_t agreeing = gather_agreeing(rest, left);
        result = try_ties(run, vision, photos, rest, agreeing, &tried);
        offer(places, &tried);
        rest += agreeing;
        left -= agreeing;
        if (left < LEAST_MATCHES)
            break;
    }
    return result;
}

author_result pair_match(author_run *run, const author_vision *vision, const photo *photos, const edge *e,
                         pair_places *out) {
    look l;
    *out = (pair_places){0};
    author_result result = look_open(run, QUERIES, &l);
    if (result == AUTHOR_OK)
        result = look_one_way(run, vision, photos, e->fine, e->coarse, &l, out);
    if (result == AUTHOR_OK && !is_clear(out))
        result = look_one_way(run, vision, photos, e->coarse, e->fine, &l, out);
    look_close(&l);
    return result;
}

/* ---- again, in the frame of the first homography ------------------------------------------------------------ */

enum { AGAIN_TEXELS = 250000, AGAIN_FEATURES = 4000, AGAIN_LEAST = 24 };

/* The fine picture as the coarse one would show it; the mean where it does not reach. */
static author_result warp(author_run *run, const view *v, const plane *matrix, luma_level *out) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)v->fine.width * v->fine.height; i++)
        sum += (double)v->fine.texels[i];
    *out = (luma_level){.width = v->coarse.width, .height = v->coarse.height};
    out->texels = author_alloc(run, (size_t)out->width * out->height, sizeof *out->texels);
    if (!out->texels)
        return AUTHOR_NO_MEMORY;
    double mean = sum / ((double)v->fine.width * v->fine.height);
    for (size_t i = 0; i < (size_t)out->width * out->height; i++) {
        double x = ((double)(v->box[0] + i % out->width) + 0.5) / v->size[0];
        double y = ((double)(v->box[1] + i / out->width) + 0.5) / v->size[1];
        double fx, fy, value = mean;
        if (plane_apply(matrix, x, y, &fx, &fy) && fx >= 0 && fx <= 1 && fy >= 0 && fy <= 1)
            value = (double)luma_sample(&v->fine, fx * v->fine.width, fy * v->fine.height);
        out->texels[i] = (float)fmax(value, 0);
    }
    return AUTHOR_OK;
}

static author_result detect_in(author_run *run, const author_vision *vision, const luma_level *level,
                               author_features **out) {
    uint8_t *bytes;
    author_result result = luma_bytes(run, level, &bytes);
    if (result == AUTHOR_OK && vision->detect(bytes, level->width, level->height, AGAIN_FEATURES, out, run->error) != 0)
        result = AUTHOR_INTERNAL;
    free(bytes);
    return result;
}

/* matches: the warped picture's features, near their place in the coarse one's. */
static author_result fit_again(author_run *run, const author_vision *vision, const view *v,
                               author_features *const features[2], edge *e) {
    size_t counts[2], found;
    const author_point *from = vision->points(features[0], &counts[0]), *to = vision->points(features[1], &counts[1]);
    look l;
    size_t count = 0;
    plane pixels, back;
    uint32_t inliers = 0;
    author_result result = look_open(run, counts[0], &l);
    if (result == AUTHOR_OK &&
        vision->match_near(features[0], features[1], NEAR_REACH * v->coarse.width, l.matches, &found, run->error) != 0)
        result = AUTHOR_INTERNAL;
    if (result == AUTHOR_OK) {
        count = ties_of(from, to, l.matches, found, l.ties);
        if (count >= AGAIN_LEAST)
            result = fit(run, vision, l.ties, count, &pixels, &inliers);
    }
    if (result == AUTHOR_OK && inliers >= AGAIN_LEAST / 2 && inliers > e->inliers && plane_inverse(&pixels, &back)) {
        plane to_box = {{v->size[0], 0, -(double)v->box[0], 0, v->size[1], -(double)v->box[1], 0, 0, 1}}, from_box;
        plane_inverse(&to_box, &from_box);
        plane a = plane_multiply(&back, &to_box), b = plane_multiply(&from_box, &a), c = plane_multiply(&e->matrix, &b);
        if (plane_normalise(&c)) {
            e->matrix = c;
            e->matches = (uint32_t)count;
            e->inliers = inliers;
        }
    }
    look_close(&l);
    return result;
}

author_result pair_match_again(author_run *run, const author_vision *vision, const photo *photos, edge *e) {
    view v;
    double box[4];
    luma_level warped = {0};
    author_features *features[2] = {NULL, NULL};
    const luma *coarse = &photos[e->coarse].light, *fine = &photos[e->fine].light;
    float weights[2][3];
    if (!view_footprint(&e->matrix, box))
        return AUTHOR_OK;
    memcpy(weights[0], LUMA_GREY, sizeof LUMA_GREY);
    memcpy(weights[1], LUMA_GREY, sizeof LUMA_GREY);
    author_result result = view_open(run, coarse, fine, weights, 1, view_level(coarse, box, AGAIN_TEXELS), &e->matrix,
                                     &v);
    if (result == AUTHOR_OK && v.fine.texels) {
        result = warp(run, &v, &e->matrix, &warped);
        if (result == AUTHOR_OK)
            result = detect_in(run, vision, &warped, &features[0]);
        if (result == AUTHOR_OK)
            result = detect_in(run, vision, &v.coarse, &features[1]);
        if (result == AUTHOR_OK)
            result = fit_again(run, vision, &v, features, e);
    }
    vision->release(features[0]);
    vision->release(features[1]);
    free(warped.texels);
    view_release(&v);
    return result;
}

/* ---- the test ---------------------------------------------------------------------------------------------- */

author_result pair_refine(author_run *run, const photo *photos, const author_register_options *options, size_t texels,
                          edge *e) {
    refine_result r;
    const photo *coarse = &photos[e->coarse], *fine = &photos[e->fine];
    author_result result = refine_plane(run, coarse, fine, &e->matrix, texels, &r);
    if (result != AUTHOR_OK)
        return result;
    e->reason = AUTHOR_REASON_CORRELATION;
    e->compared = false;
    if (!r.converged || !plane_plausible(&r.matrix, coarse->pixels, fine->pixels))
        return AUTHOR_OK;
    e->compared = true;
    e->matrix = r.matrix;
    e->correlation = r.correlation;
    e->local_correlation = r.local_correlation;
    e->residual = r.residual;
    e->distortion = r.distortion;
    e->spread = r.spread;
    e->ratio = plane_ratio(&r.matrix, coarse->pixels, fine->pixels);
    e->contained = plane_contained(&r.matrix);
    if (r.correlation >= options->min_correlation && r.local_correlation >= LEAST_LOCAL)
        e->reason = AUTHOR_REASON_NONE;
    return AUTHOR_OK;
}
