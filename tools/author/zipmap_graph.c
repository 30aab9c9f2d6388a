/* SPDX-License-Identifier: Apache-2.0 */
/* Who is a zoom into whom: parents, groups and the order of drawing, out of pairs that hold. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

/* Where a picture lies among those that are connected with it. */
typedef struct place {
    uint32_t anchor; /* the picture whose coordinates the matrix is for */
    plane matrix;    /* those coordinates to its own */
    double density;  /* its pixels along the width of the anchor's unit square, at its centre */
    double extent;   /* width of its footprint there */
} place;

edge *edge_append(author_run *run, edge_list *list) {
    if (list->count == list->room) {
        size_t room = list->room ? 2 * list->room : 64;
        edge *edges = author_alloc(run, room, sizeof *edges);
        if (!edges)
            return NULL;
        if (list->count)
            memcpy(edges, list->edges, list->count * sizeof *edges);
        free(list->edges);
        list->edges = edges;
        list->room = room;
    }
    edge *added = &list->edges[list->count++];
    *added = (edge){0};
    return added;
}

static bool holds(const edge *e) {
    return e->reason == AUTHOR_REASON_NONE;
}

/* ---- places ------------------------------------------------------------------------------------------------ */

/* From coordinates of e's picture `from` to those of the other one. */
static bool across(const edge *e, uint32_t from, plane *out) {
    *out = e->matrix;
    return from == e->coarse || plane_inverse(&e->matrix, out);
}

/* The edge that holds between a placed and an unplaced picture, with the least spread. */
static const edge *next_edge(const edge_list *list, const place *places) {
    const edge *best = NULL;
    for (size_t i = 0; i < list->count; i++) {
        const edge *e = &list->edges[i];
        bool here = places[e->coarse].anchor != AUTHOR_NONE, there = places[e->fine].anchor != AUTHOR_NONE;
        if (holds(e) && here != there && (!best || e->spread < best->spread))
            best = e;
    }
    return best;
}

static void measure_place(const photo *photos, uint32_t i, place *p) {
    plane back;
    double x, y, pixels = sqrt((double)photos[i].pixels[0] * photos[i].pixels[1]);
    p->density = 0;
    p->extent = 0;
    if (!plane_inverse(&p->matrix, &back) || !plane_apply(&back, 0.5, 0.5, &x, &y))
        return;
    double m = plane_magnification(&p->matrix, x, y);
    const uint32_t *anchor = photos[p->anchor].pixels;
    double aspect = sqrt((double)anchor[1] / anchor[0]);
    p->density = m * pixels / aspect;
    p->extent = m > 0 ? aspect / m : 0;
}

static place *places_of(author_run *run, const photo *photos, size_t count, const edge_list *list) {
    place *places = author_alloc(run, count, sizeof *places);
    for (size_t i = 0; i < count && places; i++)
        places[i].anchor = AUTHOR_NONE;
    for (uint32_t i = 0; i < count && places; i++) {
        if (places[i].anchor != AUTHOR_NONE)
            continue;
        places[i] = (place){.anchor = i, .matrix = plane_identity()};
        for (const edge *e = next_edge(list, places); e; e = next_edge(list, places)) {
            uint32_t from = places[e->coarse].anchor != AUTHOR_NONE ? e->coarse : e->fine;
            uint32_t to = from == e->coarse ? e->fine : e->coarse;
            plane step = plane_identity();
            across(e, from, &step);
            places[to] = (place){.anchor = i, .matrix = plane_multiply(&step, &places[from].matrix)};
        }
    }
    for (uint32_t i = 0; i < count && places; i++)
        measure_place(photos, i, &places[i]);
    return places;
}

/* ---- edges by way of others --------------------------------------------------------------------------------- */

static const edge *edge_between(const edge_list *list, uint32_t coarse, uint32_t fine) {
    for (size_t i = 0; i < list->count; i++)
        if (list->edges[i].coarse == coarse && list->edges[i].fine == fine)
            return &list->edges[i];
    return NULL;
}

/* The ratio of the best parent that a picture has so far. */
static double best_ratio(const edge_list *list, uint32_t fine, const author_register_options *options) {
    double best = HUGE_VAL;
    for (size_t i = 0; i < list->count; i++) {
        const edge *e = &list->edges[i];
        if (holds(e) && e->fine == fine && e->ratio >= options->min_ratio && e->contained >= options->min_contained)
            best = fmin(best, e->ratio);
    }
    return best;
}

static bool composed(const photo *photos, const place *places, uint32_t coarse, uint32_t fine, edge *out) {
    plane back;
    if (places[coarse].anchor != places[fine].anchor || !plane_inverse(&places[coarse].matrix, &back))
        return false;
    *out = (edge){.coarse = coarse, .fine = fine, .matrix = plane_multiply(&places[fine].matrix, &back)};
    out->ratio = plane_ratio(&out->matrix, photos[coarse].pixels, photos[fine].pixels);
    out->contained = plane_contained(&out->matrix);
    return plane_normalise(&out->matrix) && plane_plausible(&out->matrix, photos[coarse].pixels, photos[fine].pixels);
}

author_result graph_propose(author_run *run, const photo *photos, size_t count, const edge_list *list,
                            const author_register_options *options, edge_list *out) {
    place *places = places_of(run, photos, count, list);
    author_result result = places ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (uint32_t fine = 0; fine < count && result == AUTHOR_OK; fine++) {
        double best = best_ratio(list, fine, options);
        for (uint32_t coarse = 0; coarse < count && result == AUTHOR_OK; coarse++) {
            edge e;
            const edge *known = edge_between(list, coarse, fine);
            if (coarse == fine || (known && holds(known)) || !composed(photos, places, coarse, fine, &e))
                continue;
            if (e.ratio < options->min_ratio || e.contained < options->min_contained || e.ratio >= best * 0.98)
                continue;
            edge *added = edge_append(run, out);
            result = added ? AUTHOR_OK : AUTHOR_NO_MEMORY;
            if (added)
                *added = e;
        }
    }
    free(places);
    return result;
}

/* ---- parents ------------------------------------------------------------------------------------------------ */

/* Parents, by picture; AUTHOR_NONE for roots. */
typedef struct choice {
    uint32_t *parents;
    const place *places;
    size_t count;
} choice;

static bool descends(const choice *c, uint32_t i, uint32_t from) {
    while (i != AUTHOR_NONE && i != from)
        i = c->parents[i];
    return i == from;
}

static void choose_finest(choice *c, const edge_list *list, const author_register_options *options) {
    for (uint32_t i = 0; i < c->count; i++) {
        const edge *best = NULL;
        for (size_t k = 0; k < list->count; k++) {
            const edge *e = &list->edges[k];
            bool able = holds(e) && e->fine == i && e->ratio >= options->min_ratio &&
                        e->contained >= options->min_contained && !descends(c, e->coarse, i);
            if (able && (!best || e->ratio < best->ratio))
                best = e;
        }
        c->parents[i] = best ? best->coarse : AUTHOR_NONE;
    }
}

/* A picture without a coarser one may lie in one that is about as fine: in the widest such. */
static void choose_equal(choice *c, const photo *photos, const edge_list *list,
                         const author_register_options *options) {
    for (uint32_t i = 0; i < c->count; i++) {
        uint32_t best = AUTHOR_NONE;
        for (uint32_t j = 0; j < c->count && c->parents[i] == AUTHOR_NONE; j++) {
            edge e;
            const edge *one = edge_between(list, j, i), *other = edge_between(list, i, j);
            bool known = (one && holds(one)) || (other && holds(other));
            bool wider = c->places[j].extent > c->places[i].extent ||
                         (c->places[j].extent == c->places[i].extent && j < i);
            if (i == j || !known || !wider || descends(c, j, i) || !composed(photos, c->places, j, i, &e))
                continue;
            if (e.ratio * options->min_ratio >= 1 && e.contained >= options->min_contained &&
                (best == AUTHOR_NONE || c->places[j].extent > c->places[best].extent))
                best = j;
        }
        if (c->parents[i] == AUTHOR_NONE)
            c->parents[i] = best;
    }
}

/* ---- groups and order --------------------------------------------------------------------------------------- */

static uint32_t root_of(const choice *c, uint32_t i) {
    while (c->parents[i] != AUTHOR_NONE)
        i = c->parents[i];
    return i;
}

static size_t members(const choice *c, uint32_t root) {
    size_t n = 0;
    for (uint32_t i = 0; i < c->count; i++)
        n += root_of(c, i) == root;
    return n;
}

/* Roots with the most pictures first. */
static void collect_roots(const choice *c, author_registration *out) {
    for (uint32_t i = 0; i < c->count; i++)
        if (c->parents[i] == AUTHOR_NONE && (members(c, i) > 1 || c->count == 1))
            out->roots[out->group_count++] = i;
    for (size_t i = 1; i < out->group_count; i++)
        for (size_t k = i; k > 0 && members(c, out->roots[k]) > members(c, out->roots[k - 1]); k--) {
            uint32_t root = out->roots[k];
            out->roots[k] = out->roots[k - 1];
            out->roots[k - 1] = root;
        }
}

/* The coarsest picture of the group that is not in the order while its parent is. */
static uint32_t next_in_order(const choice *c, uint32_t root, const bool *done) {
    uint32_t best = AUTHOR_NONE;
    for (uint32_t i = 0; i < c->count; i++) {
        bool ready = !done[i] && root_of(c, i) == root && (i == root || done[c->parents[i]]);
        if (ready && (best == AUTHOR_NONE || c->places[i].density < c->places[best].density))
            best = i;
    }
    return best;
}

static author_result collect_order(author_run *run, const choice *c, author_registration *out) {
    bool *done = author_alloc(run, c->count, sizeof *done);
    if (!done)
        return AUTHOR_NO_MEMORY;
    for (uint32_t g = 0; g < out->group_count; g++)
        for (;;) {
            uint32_t i = next_in_order(c, out->roots[g], done);
            if (i == AUTHOR_NONE)
                break;
            done[i] = true;
            out->order[out->order_count++] = i;
            out->placings[i].state = i == out->roots[g] ? AUTHOR_ROOT : AUTHOR_PLACED;
            out->placings[i].group = g;
            out->placings[i].parent = c->parents[i];
        }
    free(done);
    return AUTHOR_OK;
}

/* ---- reasons ------------------------------------------------------------------------------------------------ */

const char *author_reason_name(author_reason reason) {
    static const char *const names[] = {"none",
                                        "too few matches",
                                        "no consistent homography",
                                        "fails the correlation test",
                                        "fits in several places",
                                        "would be a group of its own"};
    return (size_t)reason < sizeof names / sizeof names[0] ? names[reason] : "unknown";
}

/* Which of two tests came closer to a place. */
static bool closer(const edge *a, const edge *b) {
    static const int rank[] = {5, 0, 1, 2, 3, 4};
    if (rank[a->reason] != rank[b->reason])
        return rank[a->reason] > rank[b->reason];
    return a->inliers != b->inliers ? a->inliers > b->inliers : a->matches > b->matches;
}

static void explain_difference(const edge *e, const char *other, author_placing *p) {
    if (e->compared)
        snprintf(p->text, sizeof p->text,
                 "%u features agree on a place in %.120s, but it does not look alike there: correlation %.2f, of "
                 "detail %.2f",
                 e->inliers, other, e->correlation, e->local_correlation);
    else
        snprintf(p->text, sizeof p->text,
                 "%u features agree on a place in %.120s, but the two cannot be compared there: too small, too plain "
                 "or not flat",
                 e->inliers, other);
}

static void explain(const author_photos *named, const edge_list *list, uint32_t i, author_placing *p) {
    const edge *best = NULL;
    for (size_t k = 0; k < list->count; k++) {
        const edge *e = &list->edges[k];
        if ((e->coarse == i || e->fine == i) && (!best || closer(e, best)))
            best = e;
    }
    p->reason = best ? best->reason : AUTHOR_REASON_FEW_MATCHES;
    if (!best || (p->reason == AUTHOR_REASON_FEW_MATCHES && !best->matches)) {
        snprintf(p->text, sizeof p->text, "none of its features is found again in another picture");
        return;
    }
    const char *other = named->photos[best->coarse == i ? best->fine : best->coarse].name;
    switch (p->reason) {
    case AUTHOR_REASON_FEW_MATCHES:
        snprintf(p->text, sizeof p->text, "too few features are found again: %u at most, in %.120s", best->matches,
                 other);
        break;
    case AUTHOR_REASON_NO_HOMOGRAPHY:
        snprintf(p->text, sizeof p->text,
                 "%u features are found again in %.120s, but they do not agree on a place (%u would, at most)",
                 best->matches, other, best->inliers);
        break;
    case AUTHOR_REASON_CORRELATION:
        explain_difference(best, other, p);
        break;
    case AUTHOR_REASON_AMBIGUOUS:
        snprintf(p->text, sizeof p->text, "it fits in several places of %.120s equally well", other);
        break;
    default:
        p->reason = AUTHOR_REASON_OWN_GROUP;
        snprintf(p->text, sizeof p->text,
                 "it overlaps with %.120s, but no coarser picture contains enough of it: %.0f %%", other,
                 100 * best->contained);
    }
}

author_result graph_choose(author_run *run, const author_photos *named, const photo *photos, const edge_list *list,
                           const author_register_options *options, author_registration *out) {
    place *places = places_of(run, photos, out->count, list);
    choice c = {author_alloc(run, out->count, sizeof *c.parents), places, out->count};
    author_result result = places && c.parents ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK) {
        for (size_t i = 0; i < c.count; i++)
            c.parents[i] = AUTHOR_NONE;
        choose_finest(&c, list, options);
        choose_equal(&c, photos, list, options);
        collect_roots(&c, out);
        result = collect_order(run, &c, out);
        for (uint32_t i = 0; i < c.count; i++)
            if (out->placings[i].state == AUTHOR_UNPLACED)
                explain(named, list, i, &out->placings[i]);
    }
    free(c.parents);
    free(places);
    return result;
}
