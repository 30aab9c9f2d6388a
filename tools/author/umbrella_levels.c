/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coarser levels, from the bottom up: the umbrellas of 2 x 2 cells become fewer, as many as the longest list allows; of
 * several outlines the cheapest one is kept that is good enough, or the best.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_level.h"

#define LONGEST 8 /* a list may always be so long */
#define LIMIT 49  /* and so long where nothing else is good enough: 5 x 5 rectangles, and those around them */
#define VERTICES 12
#define VERTICES_MOST 64
#define QUALITY 31.0                     /* dB */
#define BETWEEN_MOST 40.0                /* dB: nobody sees a mipmap that is better */
#define HOPELESS 8.0                     /* dB that another outline will not bring */
#define BITS 6                           /* of a cell: colours are fitted to the vertices as they are then */
#define ROUNDS 24                        /* until no list is too long */
#define CELLS_STREAM (UINT64_C(1) << 32) /* of chance: each level has its own, and each cell in it */

/* ---- averages ------------------------------------------------------------------------------------------------ */

/* Texels of one axis under a texel of the result: from first on, count of them, the first and the last in part. */
typedef struct span {
    uint32_t first, count;
    double head, tail; /* shares of the first and of the last */
} span;

static span span_of(uint32_t i, uint32_t from, uint32_t to) {
    uint64_t begin = (uint64_t)i * from, end = begin + from; /* in 1/to of a texel */
    span s = {(uint32_t)(begin / to), (uint32_t)((end + to - 1) / to - begin / to), 1, 1};
    s.head = 1 - (double)(begin % to) / to;
    s.tail = end % to ? (double)(end % to) / to : 1;
    return s;
}

static double share(const span *s, uint32_t i) {
    if (s->count == 1)
        return s->head + s->tail - 1;
    return i == 0 ? s->head : i + 1 == s->count ? s->tail : 1;
}

author_result author_umbrella_average(author_run *run, const author_picture *picture, uint32_t width, uint32_t height,
                                      author_picture *out) {
    uint32_t n = picture->channels;
    author_result result = author_picture_create(run, width, height, n, out);
    for (uint32_t i = 0; result == AUTHOR_OK && i < width * height; i++) {
        span x = span_of(i % width, picture->width, width), y = span_of(i / width, picture->height, height);
        double sum[4] = {0, 0, 0, 0}, area = (double)picture->width / width * ((double)picture->height / height);
        for (uint32_t k = 0; k < x.count * y.count; k++) {
            double weight = share(&x, k % x.count) * share(&y, k / x.count) / area;
            const float *from = picture->texels +
                                ((size_t)(y.first + k / x.count) * picture->width + x.first + k % x.count) * n;
            for (uint32_t c = 0; c < n; c++)
                sum[c] += weight * (double)from[c];
        }
        for (uint32_t c = 0; c < n; c++)
            out->texels[(size_t)i * n + c] = (float)sum[c];
    }
    return result;
}

typedef struct leveling {
    author_run *run;
    author_umbrellas *umbrellas;
    const author_levels *how;
    uint32_t longest, limit, most_vertices, bits;
    uint32_t allowed; /* longest or limit: lists of what is merged */
    double quality;
    /* of the level that is made */
    uint32_t number;
    umb_grid grid;
    umb_sources sources;
    author_picture truth; /* at all phases */
    author_phase_errors mipmap;
    double between_quality, last_lack; /* of the candidate that was judged last */
    umb_candidate best;
} leveling;

/* ---- what is merged ---------------------------------------------------------------------------------------- */

static uint32_t cells_at(uint32_t cells, uint32_t level) {
    return cells >> level ? cells >> level : 1;
}

/* The umbrellas of the level before, in cells of this one. */
static author_result find_sources(leveling *l) {
    const zt_umbrella_info *info = &l->umbrellas->info;
    const zt_umbrella_level *from = &l->umbrellas->levels[l->number - 1];
    author_xy polygon[AUTHOR_VERTICES];
    double sx = (double)l->grid.width / from->width, sy = (double)l->grid.height / from->height;
    size_t points = 0;
    for (uint32_t i = 0; i < from->umbrella_count; i++)
        points += umb_polygon(info, &info->umbrellas[from->first_umbrella + i], from->bits, polygon);
    umb_sources *s = &l->sources;
    s->centres = author_alloc(l->run, from->umbrella_count, sizeof *s->centres);
    s->first = author_alloc(l->run, from->umbrella_count + (size_t)1, sizeof *s->first);
    s->points = author_alloc(l->run, points, sizeof *s->points);
    if (!s->centres || !s->first || !s->points)
        return AUTHOR_NO_MEMORY;
    for (points = 0; s->count < from->umbrella_count; s->count++) {
        const zt_umbrella *u = &info->umbrellas[from->first_umbrella + s->count];
        size_t count = umb_polygon(info, u, from->bits, polygon);
        s->centres[s->count] = (author_xy){u->x / 65536.0 * sx, u->y / 65536.0 * sy};
        s->first[s->count] = (uint32_t)points;
        for (size_t i = 0; i < count; i++)
            s->points[points++] = (author_xy){polygon[i].x * sx, polygon[i].y * sy};
    }
    s->first[s->count] = (uint32_t)points;
    return AUTHOR_OK;
}

/* ---- one candidate ------------------------------------------------------------------------------------------- */

static author_result list_cells(leveling *l, umb_candidate *c) {
    zt_umbrella_info info = umb_candidate_view(c);
    free(c->starts);
    free(c->entries);
    c->entries = NULL;
    c->starts = author_alloc(l->run, (size_t)l->grid.width * l->grid.height + 1, sizeof *c->starts);
    if (!c->starts)
        return AUTHOR_NO_MEMORY;
    return umb_lists(l->run, &info, 0, l->grid.repeat, c->starts, &c->entries, &c->longest);
}

/* Cells around one whose list is too long get fewer umbrellas. 1 if that changed anything. */
static int lower_counts(const leveling *l, const umb_candidate *c, const uint32_t *counts, uint32_t *lower) {
    int64_t w = l->grid.width, h = l->grid.height;
    int changed = 0;
    memcpy(lower, counts, (size_t)(w * h) * sizeof *lower);
    for (int64_t cell = 0; cell < w * h; cell++) {
        uint32_t length = c->starts[cell + 1] - c->starts[cell];
        for (int64_t i = 0; length > l->allowed && i < 9; i++) {
            int64_t x = cell % w + i % 3 - 1, y = cell / w + i / 3 - 1;
            if (((x < 0 || x >= w) && !l->grid.repeat[0]) || ((y < 0 || y >= h) && !l->grid.repeat[1]))
                continue;
            int64_t other = (y + h) % h * w + (x + w) % w;
            uint64_t fewer = (uint64_t)counts[other] * l->allowed / length;
            fewer = fewer < 1 ? 1 : fewer;
            changed |= fewer < lower[other];
            lower[other] = fewer < lower[other] ? (uint32_t)fewer : lower[other];
        }
    }
    return changed;
}

static author_result shape(leveling *l, const umb_regions *regions, umb_style style, uint32_t vertices,
                           umb_candidate *out) {
    size_t cells = (size_t)l->grid.width * l->grid.height;
    uint32_t *counts = author_alloc(l->run, 2 * cells, sizeof *counts), *lower = counts ? counts + cells : NULL;
    umb_shaping how = {.regions = regions,
                       .grid = &l->grid,
                       .counts = counts,
                       .style = style,
                       .most_vertices = vertices,
                       .bits = l->bits,
                       .seed = l->how->seed,
                       .stream = CELLS_STREAM * l->number};
    author_result result = counts ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t c = 0; result == AUTHOR_OK && c < cells; c++)
        counts[c] = l->allowed;
    for (int round = 0; result == AUTHOR_OK && round < ROUNDS; round++) {
        umb_candidate_release(out);
        result = umb_shape_level(l->run, &how, out);
        if (result == AUTHOR_OK)
            result = list_cells(l, out);
        if (result != AUTHOR_OK || !lower_counts(l, out, counts, lower))
            break;
        memcpy(counts, lower, cells * sizeof *counts);
    }
    free(counts);
    return result;
}

/* All phases and channels; alpha is one where the truth is opaque. */
static double error_of(const umb_candidate *c) {
    return c->errors.pixels.coded + c->errors.between.coded + c->errors.alpha.linear;
}

/* dB that colours lack at most; not above 0: enough. */
static double lack(const leveling *l, const author_phase_errors *e) {
    return fmax(l->quality - umb_decibel(e->pixels.coded, e->pixels.count),
                l->between_quality - umb_decibel(e->between.coded, e->between.count));
}

/* Fits the candidate, and keeps it if it is better than what there is; it is released in any case. */
static author_result judge(leveling *l, umb_candidate *given) {
    umb_candidate candidate = *given;
    *given = (umb_candidate){0};
    const zt_umbrella_info *info = &l->umbrellas->info;
    double step = (double)(UINT32_C(1) << l->number) / UMB_PIXELS;
    author_xy pixel = {step * l->grid.width / info->grid_x, step * l->grid.height / info->grid_y};
    author_result result = umb_fit_level(l->run, &candidate, info->colour_mode, pixel, &l->truth,
                                         &l->how->background[l->number - 1]);
    l->last_lack = lack(l, &candidate.errors);
    int fits = candidate.longest <= l->limit, best_fits = l->best.longest <= l->limit;
    int better = fits && best_fits ? error_of(&candidate) < error_of(&l->best) : candidate.longest < l->best.longest;
    if (result == AUTHOR_OK && (better || !l->best.umbrellas)) {
        umb_candidate_release(&l->best);
        l->best = candidate;
        return AUTHOR_OK;
    }
    umb_candidate_release(&candidate);
    return result;
}

static int is_good(const leveling *l) {
    const umb_candidate *c = &l->best;
    return c->umbrellas && c->longest <= l->limit && lack(l, &c->errors) <= 0 &&
           umb_decibel(c->errors.alpha.linear, c->errors.alpha.count) >= l->quality;
}

static author_result try_merged(leveling *l, const umb_regions *regions, umb_style style, uint32_t vertices) {
    umb_candidate candidate = {0};
    author_result result = shape(l, regions, style, vertices < 4 ? 4 : vertices, &candidate);
    return result == AUTHOR_OK ? judge(l, &candidate) : result;
}

static int is_opaque(const author_picture *picture) {
    for (size_t i = 0; i < (size_t)picture->width * picture->height; i++)
        if (picture->texels[4 * i + 3] < 0.999f)
            return 0;
    return 1;
}

/* The next one will not do either where much is lacking; but the last ones are the best that there is. */
static size_t after(const leveling *l, size_t way) {
    return way + (l->limit < LIMIT || way >= 8 || l->last_lack <= 4 ? 1 : l->last_lack <= 8 ? 2 : 3);
}

/* Rectangles along a side that a cell lists: its own, and the nearest of each neighbour. */
static uint32_t listed_along(const leveling *l, int axis, uint32_t own) {
    uint32_t cells = axis ? l->grid.height : l->grid.width;
    return own + (l->grid.repeat[axis] || cells > 2 ? 2 : cells - 1);
}

/* Rectangles hide the background. */
static author_result try_tiles(leveling *l) {
    static const uint32_t ways[][3] = {{1, 1, 4}, {2, 1, 4}, {2, 2, 2}, {2, 2, 3}, {3, 2, 3}, {3, 3, 2}, {3, 3, 3},
                                       {4, 3, 3}, {4, 4, 3}, {5, 4, 3}, {5, 5, 2}, {5, 5, 3}, {6, 6, 3}, {7, 7, 3}};
    author_result result = AUTHOR_OK;
    l->last_lack = 0;
    for (size_t i = 0; result == AUTHOR_OK && !is_good(l) && i < sizeof ways / sizeof ways[0]; i = after(l, i)) {
        umb_candidate candidate;
        uint32_t columns = ways[i][0], rows = ways[i][1], vertices = 4 * ways[i][2];
        if (listed_along(l, 0, columns) * listed_along(l, 1, rows) > l->limit || vertices > l->most_vertices)
            continue;
        result = umb_tile_level(l->run, &l->grid, columns, rows, vertices, l->bits, &candidate);
        if (result == AUTHOR_OK)
            result = list_cells(l, &candidate);
        if (result == AUTHOR_OK)
            result = judge(l, &candidate);
        umb_candidate_release(&candidate);
    }
    return result;
}

/* Is the ground something that the colours of a level cannot show exactly, and opaque? */
static int wants_ground(const leveling *l) {
    const author_picture *ground = &l->how->background[l->number - 1];
    return l->umbrellas->info.background_kind != ZT_BACKGROUND_COLOUR && is_opaque(ground);
}

typedef struct way {
    umb_style style;
    uint32_t part; /* of most_vertices, in sixths */
} way;

/* Not on once a level lacks `most` dB. */
static author_result try_ways(leveling *l, const umb_regions *regions, const way *ways, size_t count, double most) {
    author_result result = AUTHOR_OK;
    l->last_lack = 0;
    for (size_t i = 0; result == AUTHOR_OK && !is_good(l) && l->last_lack < most && i < count; i++)
        result = try_merged(l, regions, ways[i].style, l->most_vertices * ways[i].part / 6);
    return result;
}

static author_result try_all(leveling *l) {
    static const way merged[] = {{UMB_FAIR, 3}, {UMB_FAIR, 4}, {UMB_FAIR, 6}, {UMB_WRAP, 6}, {UMB_HULL, 6}};
    static const way clear[] = {{UMB_AREA, 3}, {UMB_AREA, 6}, {UMB_FAIR, 6}};
    umb_regions regions;
    int opaque = is_opaque(&l->truth);
    author_result result = umb_find_regions(l->run, &l->sources, &l->grid, wants_ground(l), &l->truth, &regions);
    l->allowed = l->longest;
    if (result == AUTHOR_OK)
        result = try_ways(l, &regions, merged, sizeof merged / sizeof merged[0], opaque ? HOPELESS : INFINITY);
    l->allowed = l->limit;
    if (result == AUTHOR_OK && !opaque)
        result = try_ways(l, &regions, clear, sizeof clear / sizeof clear[0], INFINITY);
    umb_regions_release(&regions);
    return result == AUTHOR_OK && opaque && !is_good(l) ? try_tiles(l) : result;
}

/* ---- into the texture ----------------------------------------------------------------------------------------- */

static int extend(void *array, size_t size, size_t count, size_t more, const void *from) {
    void **memory = array;
    char *longer = realloc(*memory, (count + more + 1) * size);
    if (!longer)
        return -1;
    *memory = longer;
    if (more > 0)
        memcpy(longer + count * size, from, more * size);
    return 0;
}

static author_result append(leveling *l) {
    author_umbrellas *u = l->umbrellas;
    zt_umbrella_info *info = &u->info;
    umb_candidate *c = &l->best;
    uint32_t cells = l->grid.width * l->grid.height, entries = c->starts[cells];
    c->level.first_umbrella = info->umbrella_count;
    c->level.first_cell = info->cell_count;
    for (uint32_t i = 0; i < c->level.umbrella_count; i++) {
        c->umbrellas[i].first_vertex += info->explicit_vertex_count;
        c->umbrellas[i].first_colour += info->explicit_colour_count;
    }
    for (uint32_t i = 0; i <= cells; i++)
        c->starts[i] += info->entry_count;
    if (extend(&u->levels, sizeof *u->levels, l->number, 1, &c->level) ||
        extend(&u->umbrellas, sizeof *u->umbrellas, info->umbrella_count, c->level.umbrella_count, c->umbrellas) ||
        extend(&u->explicit_vertices, sizeof *u->explicit_vertices, info->explicit_vertex_count, c->vertex_count,
               c->vertices) ||
        extend(&u->explicit_colours, sizeof *u->explicit_colours, info->explicit_colour_count, c->colour_count,
               c->colours) ||
        extend(&u->entries, sizeof *u->entries, info->entry_count, entries, c->entries) ||
        extend(&u->list_starts, sizeof *u->list_starts, info->cell_count + (size_t)1, cells, c->starts + 1))
        return author_fail(l->run, AUTHOR_NO_MEMORY, "no memory for level %u", l->number);
    info->level_count = l->number + 1;
    info->umbrella_count += c->level.umbrella_count;
    info->explicit_vertex_count += c->vertex_count;
    info->explicit_colour_count += c->colour_count;
    info->entry_count += entries;
    info->cell_count += cells;
    info->longest_list = c->longest > info->longest_list ? c->longest : info->longest_list;
    umb_show(u);
    return AUTHOR_OK;
}

/* Between pixels a mipmap is the measure, unless somebody has said what is good enough. */
static void choose_quality(leveling *l) {
    author_umbrella_bilinear(&l->truth, l->grid.repeat, &l->mipmap);
    double mipmap = umb_decibel(l->mipmap.between.coded, l->mipmap.between.count);
    l->between_quality = l->how->quality > 0 ? l->quality : fmin(fmax(l->quality, mipmap), BETWEEN_MOST);
}

static author_result make_level(leveling *l, author_level_report *report) {
    const zt_umbrella_info *info = &l->umbrellas->info;
    l->grid = (umb_grid){
        cells_at(info->grid_x, l->number), cells_at(info->grid_y, l->number), {l->how->repeat_x, l->how->repeat_y}};
    author_result result = find_sources(l);
    if (result == AUTHOR_OK)
        result = author_umbrella_phases(l->run, l->how->truth, l->grid.width * UMB_PHASES, l->grid.height * UMB_PHASES,
                                        l->grid.repeat, &l->truth);
    if (result == AUTHOR_OK)
        choose_quality(l);
    if (result == AUTHOR_OK)
        result = try_all(l);
    if (result == AUTHOR_OK)
        result = append(l);
    if (result == AUTHOR_OK && report) {
        *report = (author_level_report){.width = l->grid.width,
                                        .height = l->grid.height,
                                        .umbrellas = l->best.level.umbrella_count,
                                        .longest = l->best.longest,
                                        .vertices = l->best.vertex_count};
        author_umbrella_figures(&l->best.errors, &l->mipmap, report);
    }
    umb_candidate_release(&l->best);
    umb_sources_release(&l->sources);
    author_picture_release(&l->truth);
    return result;
}

author_result author_umbrella_levels(author_run *run, author_umbrellas *umbrellas, const author_levels *how,
                                     author_level_report *reports) {
    leveling l = {.run = run, .umbrellas = umbrellas, .how = how};
    author_picture mean;
    uint32_t longest = umbrellas->info.longest_list > LONGEST ? umbrellas->info.longest_list : LONGEST;
    uint32_t vertices = how->most_vertices ? how->most_vertices : VERTICES;
    l.longest = how->longest ? how->longest : longest;
    l.limit = how->longest || l.longest > LIMIT ? l.longest : LIMIT;
    l.most_vertices = vertices < 4 ? 4 : vertices > VERTICES_MOST ? VERTICES_MOST : vertices;
    l.bits = how->bits ? how->bits : BITS;
    l.quality = how->quality > 0 ? how->quality : QUALITY;
    author_result result = author_umbrella_average(run, how->truth, 1, 1, &mean);
    if (result == AUTHOR_OK)
        memcpy(umbrellas->info.mean, mean.texels, sizeof umbrellas->info.mean);
    author_picture_release(&mean);
    for (l.number = 1; result == AUTHOR_OK && l.number < how->level_count; l.number++)
        result = make_level(&l, reports ? &reports[l.number - 1] : NULL);
    return result;
}
