/* SPDX-License-Identifier: Apache-2.0 */
/* Registration of a heap of photographs, from the texels to the matrices. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

enum {
    MOST_PHOTOS = 4096,
    FEATURE_TEXELS = 2000000, /* of the picture that features are sought in */
    FEATURES = 16000,         /* of one picture, at most */
    FEW_FEATURES = 2000,      /* of one picture, however many pictures there are */
    FEATURE_BYTES = 800,      /* with its descriptor and its share of the index */
    TEST_TEXELS = 40000,      /* that decide whether a pair holds */
    FINAL_TEXELS = 200000,    /* that the matrices of the result come from */
    LUMA_BYTES = 6            /* of one texel in a pyramid, with all levels */
};

static const uint64_t DEFAULT_MEMORY = (uint64_t)1 << 30;
static const double GUIDED_RATIO = 4; /* from here on more inliers are wanted of the first match */
/* Inliers that need no second match, in the frame of the first homography: at small and at large ratios. */
static const uint32_t SURE = 60, VERY_SURE = 150;

typedef struct job {
    const author_vision *vision;
    const author_photos *named;
    author_register_options options;
    uint64_t max_texels;
    uint32_t max_features;
    photo *photos;
    size_t count;
    edge_list edges;
    edge *work; /* of the edges that a loop is about */
    size_t texels;
} job;

static author_register_options options_of(const author_register_options *given) {
    author_register_options out = {0};
    if (given)
        memcpy(&out, given, given->size && given->size < sizeof out ? given->size : sizeof out);
    out.min_correlation = out.min_correlation > 0 ? out.min_correlation : 0.9;
    out.min_contained = out.min_contained > 0 ? out.min_contained : 0.6;
    out.min_ratio = out.min_ratio > 1 ? out.min_ratio : 1.1;
    out.memory = out.memory ? out.memory : DEFAULT_MEMORY;
    return out;
}

/* ---- pictures ----------------------------------------------------------------------------------------------- */

static author_result find_features(author_run *run, const job *j, photo *p) {
    double texels = (double)p->light.level[0].width * p->light.level[0].height;
    double factor = texels > FEATURE_TEXELS ? sqrt(FEATURE_TEXELS / texels) : 1;
    luma_level level;
    uint8_t *bytes = NULL;
    for (int i = 0; i < 2; i++) {
        uint32_t size = i ? p->light.level[0].height : p->light.level[0].width;
        p->feature_size[i] = (uint32_t)fmax(1, floor(size * factor));
    }
    author_result result = luma_shrink(run, &p->light, LUMA_GREY, 1, p->feature_size[0], p->feature_size[1], &level);
    if (result == AUTHOR_OK)
        result = luma_bytes(run, &level, &bytes);
    if (result == AUTHOR_OK &&
        j->vision->detect(bytes, level.width, level.height, j->max_features, &p->features, run->error) != 0)
        result = AUTHOR_INTERNAL;
    free(level.texels);
    free(bytes);
    return result;
}

static author_result prepare_photo(author_run *run, const job *j, size_t i) {
    const author_photos *named = j->named;
    author_picture picture = {0};
    author_result result = named->load(named->user, i, j->max_texels, &picture, run->error);
    if (result == AUTHOR_OK && (!picture.texels || !picture.width || !picture.height || !picture.channels))
        result = author_fail(run, AUTHOR_BAD_INPUT, "%.200s is empty", named->photos[i].name);
    if (result == AUTHOR_OK)
        result = luma_create(run, &picture, &j->photos[i].light);
    author_picture_release(&picture);
    return result == AUTHOR_OK ? find_features(run, j, &j->photos[i]) : result;
}

static author_result prepare_task(void *context, size_t i, unsigned worker, char *error) {
    author_run run = {0};
    (void)worker;
    author_result result = prepare_photo(&run, context, i);
    memcpy(error, run.error, AUTHOR_ERROR);
    return result;
}

/* ---- pairs -------------------------------------------------------------------------------------------------- */

/* Whether the pair lies where the features say. */
static author_result test_place(author_run *run, const job *j, edge *e) {
    author_result result = AUTHOR_OK;
    if (e->inliers < (e->ratio > GUIDED_RATIO ? VERY_SURE : SURE))
        result = pair_match_again(run, j->vision, j->photos, e);
    if (result == AUTHOR_OK)
        result = pair_refine(run, j->photos, &j->options, TEST_TEXELS, e);
    return result == AUTHOR_OK && e->reason == AUTHOR_REASON_NONE ? pair_unique(run, j->photos, e) : result;
}

static author_result match_pair(author_run *run, const job *j, edge *e) {
    pair_places places;
    author_result result = pair_match(run, j->vision, j->photos, e, &places);
    if (result != AUTHOR_OK)
        return result;
    *e = places.edges[0];
    for (size_t i = 0; i < places.count && places.edges[i].reason == AUTHOR_REASON_NONE; i++) {
        edge *tested = &places.edges[i];
        result = test_place(run, j, tested);
        bool known = tested->reason == AUTHOR_REASON_NONE || tested->reason == AUTHOR_REASON_AMBIGUOUS;
        if (known || i == 0)
            *e = *tested;
        if (known || result != AUTHOR_OK)
            return result;
    }
    return AUTHOR_OK;
}

static author_result match_task(void *context, size_t i, unsigned worker, char *error) {
    const job *j = context;
    author_run run = {0};
    (void)worker;
    author_result result = match_pair(&run, j, &j->work[i]);
    memcpy(error, run.error, AUTHOR_ERROR);
    return result;
}

static author_result refine_task(void *context, size_t i, unsigned worker, char *error) {
    const job *j = context;
    author_run run = {0};
    (void)worker;
    author_result result = pair_refine(&run, j->photos, &j->options, j->texels, &j->work[i]);
    memcpy(error, run.error, AUTHOR_ERROR);
    return result;
}

static author_result place_task(void *context, size_t i, unsigned worker, char *error) {
    const job *j = context;
    author_run run = {0};
    (void)worker;
    author_result result = pair_refine(&run, j->photos, &j->options, j->texels, &j->work[i]);
    if (result == AUTHOR_OK)
        result = pair_polish(&run, j->photos, j->texels, &j->work[i]);
    memcpy(error, run.error, AUTHOR_ERROR);
    return result;
}

static author_result list_all(author_run *run, job *j) {
    for (uint32_t a = 0; a < j->count; a++)
        for (uint32_t b = a + 1; b < j->count; b++) {
            edge *e = edge_append(run, &j->edges);
            if (!e)
                return AUTHOR_NO_MEMORY;
            e->coarse = a;
            e->fine = b;
        }
    return AUTHOR_OK;
}

static author_result match_all(author_run *run, job *j) {
    uint32_t wanted = j->options.candidates;
    bool all = wanted ? wanted >= j->count - 1 : j->count <= AUTHOR_FEW_PHOTOS;
    author_result result = all ? list_all(run, j)
                               : select_pairs(run, j->vision, j->photos, j->count, wanted ? wanted : AUTHOR_CANDIDATES,
                                              j->options.memory / 4, &j->edges);
    j->work = j->edges.edges;
    return result == AUTHOR_OK ? author_for(run, "pairs", j->edges.count, match_task, j) : result;
}

/* Pairs that features did not find, but that follow from others. */
static author_result propose(author_run *run, job *j) {
    edge_list more = {0};
    author_result result = graph_propose(run, j->photos, j->count, &j->edges, &j->options, &more);
    j->work = more.edges;
    j->texels = TEST_TEXELS;
    if (result == AUTHOR_OK)
        result = author_for(run, "pairs by way of others", more.count, refine_task, j);
    for (size_t i = 0; i < more.count && result == AUTHOR_OK; i++) {
        edge *e = more.edges[i].reason == AUTHOR_REASON_NONE ? edge_append(run, &j->edges) : NULL;
        if (e)
            *e = more.edges[i];
        else if (more.edges[i].reason == AUTHOR_REASON_NONE)
            result = AUTHOR_NO_MEMORY;
    }
    free(more.edges);
    return result;
}

/* ---- the result --------------------------------------------------------------------------------------------- */

static author_result make_room(author_run *run, size_t count, author_registration *out) {
    out->count = count;
    out->placings = author_alloc(run, count, sizeof *out->placings);
    out->roots = author_alloc(run, count, sizeof *out->roots);
    out->order = author_alloc(run, count, sizeof *out->order);
    if (!out->placings || !out->roots || !out->order)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < count; i++) {
        plane identity = plane_identity();
        author_placing *p = &out->placings[i];
        p->parent = p->group = AUTHOR_NONE;
        p->ratio = p->contained = p->correlation = 1;
        memcpy(p->matrix, identity.m, sizeof p->matrix);
        memcpy(p->root_matrix, identity.m, sizeof p->root_matrix);
    }
    return AUTHOR_OK;
}

static const edge *edge_to(const job *j, uint32_t parent, uint32_t i) {
    for (size_t k = 0; k < j->edges.count; k++) {
        const edge *e = &j->edges.edges[k];
        if (e->reason == AUTHOR_REASON_NONE && e->coarse == parent && e->fine == i)
            return e;
    }
    return NULL;
}

static void fill_placing(const edge *e, author_placing *p) {
    memcpy(p->matrix, e->matrix.m, sizeof p->matrix);
    p->ratio = e->ratio;
    p->contained = e->contained;
    p->matches = e->matches;
    p->inliers = e->inliers;
    p->residual = e->residual;
    p->distortion = e->distortion;
    p->uncertainty = e->spread;
    p->correlation = e->correlation;
}

static author_result finish(author_run *run, job *j, author_registration *out) {
    edge *tree = author_alloc(run, j->count, sizeof *tree);
    size_t count = 0;
    author_result result = tree ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (uint32_t i = 0; i < j->count && result == AUTHOR_OK; i++) {
        const edge *e = edge_to(j, out->placings[i].parent, i);
        if (e)
            tree[count++] = *e;
    }
    j->work = tree;
    j->texels = FINAL_TEXELS;
    if (result == AUTHOR_OK)
        result = author_for(run, "refinement", count, place_task, j);
    for (size_t i = 0; i < count && result == AUTHOR_OK; i++)
        fill_placing(&tree[i], &out->placings[tree[i].fine]);
    for (size_t i = 0; i < out->order_count && result == AUTHOR_OK; i++) {
        author_placing *p = &out->placings[out->order[i]];
        plane own, parent, root;
        if (p->parent == AUTHOR_NONE)
            continue;
        memcpy(own.m, p->matrix, sizeof own.m);
        memcpy(parent.m, out->placings[p->parent].root_matrix, sizeof parent.m);
        root = plane_multiply(&own, &parent);
        plane_normalise(&root);
        memcpy(p->root_matrix, root.m, sizeof root.m);
    }
    free(tree);
    return result;
}

static author_result keep_pairs(author_run *run, const job *j, author_registration *out) {
    out->pairs = author_alloc(run, j->edges.count, sizeof *out->pairs);
    if (!out->pairs)
        return AUTHOR_NO_MEMORY;
    out->pair_count = j->edges.count;
    for (size_t i = 0; i < j->edges.count; i++) {
        const edge *e = &j->edges.edges[i];
        author_pair *p = &out->pairs[i];
        *p = (author_pair){.coarse = e->coarse,
                           .fine = e->fine,
                           .matches = e->matches,
                           .inliers = e->inliers,
                           .reason = e->reason,
                           .ratio = e->ratio,
                           .residual = e->residual,
                           .correlation = e->correlation};
        memcpy(p->matrix, e->matrix.m, sizeof p->matrix);
    }
    return AUTHOR_OK;
}

static author_result register_all(author_run *run, job *j, author_registration *out) {
    author_result result = author_for(run, "features", j->count, prepare_task, j);
    if (result == AUTHOR_OK)
        result = match_all(run, j);
    if (result == AUTHOR_OK)
        result = propose(run, j);
    if (result == AUTHOR_OK)
        result = make_room(run, j->count, out);
    if (result == AUTHOR_OK)
        result = graph_choose(run, j->named, j->photos, &j->edges, &j->options, out);
    if (result == AUTHOR_OK)
        result = finish(run, j, out);
    return result == AUTHOR_OK ? keep_pairs(run, j, out) : result;
}

author_result author_register(author_run *run, const author_vision *vision, const author_photos *photos,
                              const author_register_options *options, author_registration *out) {
    *out = (author_registration){0};
    if (!photos->count || photos->count > MOST_PHOTOS)
        return author_fail(run, AUTHOR_BAD_INPUT, "%zu photographs: give 1 to %d", photos->count, MOST_PHOTOS);
    job j = {.vision = vision, .named = photos, .options = options_of(options), .count = photos->count};
    j.max_texels = j.options.memory / LUMA_BYTES / photos->count;
    j.max_features = (uint32_t)fmin(fmax((double)(j.options.memory / FEATURE_BYTES / photos->count), FEW_FEATURES),
                                    FEATURES);
    j.photos = author_alloc(run, j.count, sizeof *j.photos);
    if (!j.photos)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < j.count; i++) {
        j.photos[i].pixels[0] = photos->photos[i].width;
        j.photos[i].pixels[1] = photos->photos[i].height;
    }
    author_result result = register_all(run, &j, out);
    for (size_t i = 0; i < j.count; i++) {
        luma_release(&j.photos[i].light);
        vision->release(j.photos[i].features);
    }
    free(j.photos);
    free(j.edges.edges);
    if (result != AUTHOR_OK)
        author_registration_release(out);
    return result;
}

void author_registration_release(author_registration *registration) {
    free(registration->placings);
    free(registration->roots);
    free(registration->order);
    free(registration->pairs);
    *registration = (author_registration){0};
}
