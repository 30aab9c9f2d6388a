/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Regions into fewer umbrellas (section 5 of the paper): k-means on their centres, cell by cell; around each cluster
 * the convex hull of what is seen of it, its flattest vertices dropped, or a polygon that wraps it more closely.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_level.h"

#define ROUNDS 12    /* of k-means */
#define GROWN 0.02   /* cells: between neighbours there shall be no gap */
#define LEAST 0.04   /* cells: radius of the smallest umbrella */
#define HALF 0.03125 /* cells: half a sample */
#define PI 3.14159265358979323846
#define COLOUR 0.5 /* cells that the full range of a channel counts for */

typedef struct merging {
    author_run *run;
    const umb_shaping *how;
    size_t *members; /* regions, cell after cell */
    size_t *starts;  /* of the cells */
    uint32_t *of;    /* cluster of each member */
    author_xy *means;
    double (*colours)[3]; /* of the clusters */
    double *weights, *nearest;
    author_xy *points; /* scratch: a cluster's samples */
    size_t *order;
    double *depths; /* of the umbrellas made */
    umb_candidate *out;
} merging;

/* ---- k-means ----------------------------------------------------------------------------------------------- */

/* How far a region is from a cluster, squared: in place and, since one umbrella shows few colours, in colour. */
static double square_apart(const merging *m, size_t region, uint32_t c) {
    const double *own = m->how->regions->colours[region], *other = m->colours[c];
    author_xy d = umb_less(m->how->regions->homes[region], m->means[c]);
    double square = d.x * d.x + d.y * d.y;
    for (int k = 0; k < 3; k++)
        square += COLOUR * COLOUR * (own[k] - other[k]) * (own[k] - other[k]);
    return square;
}

static void begin_cluster(const merging *m, uint32_t c, size_t region) {
    m->means[c] = m->how->regions->homes[region];
    memcpy(m->colours[c], m->how->regions->colours[region], sizeof m->colours[c]);
}

static double weight_of(const umb_regions *r, size_t region) {
    return (double)(r->first[region + 1] - r->first[region]);
}

/* k-means++: each next mean is drawn by the squared distance from those that are there, times what is seen. */
static void seed_means(const merging *m, const size_t *members, size_t count, uint32_t k, author_random *random) {
    const umb_regions *r = m->how->regions;
    for (size_t i = 0; i < count; i++)
        m->nearest[i] = 1;
    for (uint32_t c = 0; c < k; c++) {
        double total = 0;
        for (size_t i = 0; i < count; i++)
            total += m->nearest[i] * weight_of(r, members[i]);
        double at = author_random_unit(random) * total;
        size_t chosen = 0;
        for (size_t i = 0; i < count; i++) {
            double part = m->nearest[i] * weight_of(r, members[i]);
            if (part > 0)
                chosen = i;
            if (at < part)
                break;
            at -= part;
        }
        begin_cluster(m, c, members[chosen]);
        for (size_t i = 0; i < count; i++) {
            double far = square_apart(m, members[i], c);
            m->nearest[i] = c == 0 ? far : fmin(m->nearest[i], far);
        }
    }
}

static void assign(const merging *m, const size_t *members, size_t count, uint32_t k, uint32_t *of) {
    for (size_t i = 0; i < count; i++) {
        double best = INFINITY;
        for (uint32_t c = 0; c < k; c++) {
            double far = square_apart(m, members[i], c);
            if (far < best) {
                best = far;
                of[i] = c;
            }
        }
    }
}

static void average(const merging *m, const size_t *members, size_t count, uint32_t k, const uint32_t *of) {
    const umb_regions *r = m->how->regions;
    for (uint32_t c = 0; c < k; c++) {
        double sum = 0, x = 0, y = 0, colour[3] = {0, 0, 0};
        for (size_t i = 0; i < count; i++) {
            double w = of[i] == c ? weight_of(r, members[i]) : 0;
            sum += w;
            x += w * r->homes[members[i]].x;
            y += w * r->homes[members[i]].y;
            for (int ch = 0; ch < 3; ch++)
                colour[ch] += w * r->colours[members[i]][ch];
        }
        if (sum > 0)
            m->means[c] = (author_xy){x / sum, y / sum};
        for (int ch = 0; sum > 0 && ch < 3; ch++)
            m->colours[c][ch] = colour[ch] / sum;
    }
}

static void cluster(const merging *m, const size_t *members, size_t count, uint32_t k, uint32_t *of, uint64_t stream) {
    author_random random;
    if (count <= k) {
        for (size_t i = 0; i < count; i++) {
            of[i] = (uint32_t)i;
            begin_cluster(m, (uint32_t)i, members[i]);
        }
        return;
    }
    author_random_seed(&random, m->how->seed, stream);
    seed_means(m, members, count, k, &random);
    for (int i = 0; i < ROUNDS; i++) {
        assign(m, members, count, k, of);
        average(m, members, count, k, of);
    }
    assign(m, members, count, k, of);
}

/* ---- outlines ----------------------------------------------------------------------------------------------- */

static int by_place(const void *left, const void *right) {
    const author_xy *a = left, *b = right;
    if (a->x != b->x)
        return a->x < b->x ? -1 : 1;
    return a->y < b->y ? -1 : a->y > b->y;
}

/* The corners of the samples' squares; sorts points. Room for count + 1 in hull. Clockwise as one sees it. */
static size_t convex_hull(author_xy *points, size_t count, author_xy *hull) {
    size_t made = 0;
    qsort(points, count, sizeof *points, by_place);
    for (int side = 0; side < 2; side++) {
        size_t base = made + (side == 0);
        for (size_t i = 0; i < count; i++) {
            author_xy p = points[side ? count - 1 - i : i];
            while (made > base && umb_cross(umb_less(hull[made - 1], hull[made - 2]), umb_less(p, hull[made - 1])) <= 0)
                made--;
            if (made == 0 || hull[made - 1].x != p.x || hull[made - 1].y != p.y)
                hull[made++] = p;
        }
    }
    return made > 1 ? made - 1 : made;
}

/* How far a corner is from a straight line: the sine of what the outline turns there. */
static double turn_at(const author_xy *hull, size_t count, size_t i) {
    author_xy a = umb_less(hull[i], hull[(i + count - 1) % count]), b = umb_less(hull[(i + 1) % count], hull[i]);
    double length = sqrt((a.x * a.x + a.y * a.y) * (b.x * b.x + b.y * b.y));
    double sine = length > 0 ? umb_cross(a, b) / length : 0;
    return a.x * b.x + a.y * b.y < 0 ? 2 - sine : sine;
}

static size_t drop_flattest(author_xy *hull, size_t count, size_t most) {
    while (count > most && count > 3) {
        size_t flattest = 0;
        for (size_t i = 1; i < count; i++)
            if (turn_at(hull, count, i) < turn_at(hull, count, flattest))
                flattest = i;
        memmove(hull + flattest, hull + flattest + 1, (count - flattest - 1) * sizeof *hull);
        count--;
    }
    return count;
}

/* The farthest sample in each of `most` directions, or what makes the area right. Where there is none the polygon goes
 * in. */
static size_t wrap_closely(const author_xy *points, size_t count, size_t most, umb_style style, author_xy *out) {
    double far[64] = {0}, squares[64] = {0}, seen[64] = {0};
    for (size_t k = 0; k < most; k++) {
        double c, s;
        umb_turn((double)k / (double)most, &c, &s);
        out[k] = (author_xy){c, s};
        far[k] = LEAST;
    }
    double half, unused;
    umb_turn(0.5 / (double)most, &half, &unused);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < most; k++) {
            double along = points[i].x * out[k].x + points[i].y * out[k].y, across = umb_cross(points[i], out[k]);
            double length = sqrt(along * along + across * across);
            if (along >= half * length)
                far[k] = fmax(far[k], length);
            squares[k] += along >= half * length ? length * length : 0;
            seen[k] += along >= half * length;
        }
    /* In a wedge that is full the squares of the distances are half that of its radius on the mean. */
    for (size_t k = 0; style == UMB_FAIR && k < most; k++)
        if (seen[k] > 0)
            far[k] = fmax(fmin(sqrt(2 * squares[k] / seen[k]), far[k] + HALF), LEAST);
    /* The area of a wedge is half the square of its radius for each radian. */
    for (size_t k = 0; style == UMB_AREA && k < most; k++)
        far[k] = fmax(sqrt(seen[k] * 4 * HALF * HALF * (double)most / PI), LEAST);
    for (size_t k = 0; k < most; k++)
        out[k] = (author_xy){out[k].x * far[k], out[k].y * far[k]};
    return most;
}

/* Samples of all members, less the cluster's centre; the corners of their squares for a hull. */
static size_t gather(const merging *m, const size_t *members, const uint32_t *of, size_t count, uint32_t c) {
    const umb_regions *r = m->how->regions;
    size_t made = 0;
    for (size_t i = 0; i < count; i++) {
        if (of[i] != c)
            continue;
        author_xy offset = umb_less(r->homes[members[i]], m->means[c]);
        for (size_t k = r->first[members[i]]; k < r->first[members[i] + 1]; k++) {
            author_xy p = {r->samples[k].x + offset.x, r->samples[k].y + offset.y};
            m->points[made++] = p;
        }
    }
    return made;
}

static void grow(author_xy *polygon, size_t count, double by, double most) {
    for (size_t i = 0; i < count; i++) {
        double length = sqrt(polygon[i].x * polygon[i].x + polygon[i].y * polygon[i].y);
        double wanted = fmin(length + by, most), scale = length > 0 ? wanted / length : 1;
        polygon[i] = (author_xy){polygon[i].x * scale, polygon[i].y * scale};
    }
}

/* In steps of the file; vertices that are not seen from the centre once they are rounded go. */
static size_t code_outline(const merging *m, const author_xy *polygon, size_t count, zt_umbrella_offset *out) {
    double scale = (double)(UINT32_C(1) << m->how->bits);
    for (size_t i = 0; i < count; i++)
        out[i] = (zt_umbrella_offset){(int32_t)umb_round(polygon[i].x * scale),
                                      (int32_t)umb_round(polygon[i].y * scale)};
    for (size_t bad; count >= 3 && (bad = umb_bad_offset(out, count)) < count; count--)
        memmove(out + bad, out + bad + 1, (count - bad - 1) * sizeof *out);
    if (count >= 3)
        return count;
    int32_t size = (int32_t)fmax(1, LEAST * scale);
    out[0] = (zt_umbrella_offset){0, -size};
    out[1] = (zt_umbrella_offset){size, size};
    out[2] = (zt_umbrella_offset){-size, size};
    return 3;
}

static int32_t code_centre(double value, uint32_t cells) {
    int64_t code = umb_round(value * 65536), most = (int64_t)cells * 65536 - 1;
    return (int32_t)(code < 0 ? 0 : code > most ? most : code);
}

static void make_umbrella(merging *m, const size_t *members, const uint32_t *of, size_t count, uint32_t c,
                          author_xy *polygon) {
    const umb_grid *g = m->how->grid;
    umb_candidate *out = m->out;
    double depth = 0, weight = 0;
    for (size_t i = 0; i < count; i++) {
        double w = of[i] == c ? weight_of(m->how->regions, members[i]) : 0;
        weight += w;
        depth += w * m->how->regions->depths[members[i]];
    }
    size_t samples = gather(m, members, of, count, c), vertices = 0;
    if (samples == 0)
        return;
    if (m->how->style == UMB_HULL)
        vertices = drop_flattest(polygon, convex_hull(m->points, samples, polygon), m->how->most_vertices);
    else
        vertices = wrap_closely(m->points, samples, m->how->most_vertices, m->how->style, polygon);
    /* A grid that repeats has room for one shift. */
    grow(polygon, vertices,
         m->how->style == UMB_AREA   ? 0
         : m->how->style == UMB_FAIR ? GROWN
                                     : HALF + GROWN,
         0.8 * (g->width < g->height ? g->width : g->height));
    vertices = code_outline(m, polygon, vertices, out->vertices + out->vertex_count);
    m->depths[out->level.umbrella_count] = depth / weight;
    out->umbrellas[out->level.umbrella_count++] = (zt_umbrella){.x = code_centre(m->means[c].x, g->width),
                                                                .y = code_centre(m->means[c].y, g->height),
                                                                .first_vertex = out->vertex_count,
                                                                .vertex_count = (uint16_t)vertices,
                                                                .form = ZT_UMBRELLA_COLOURED};
    out->vertex_count += (uint32_t)vertices;
}

/* ---- all cells ----------------------------------------------------------------------------------------------- */

static void sort_members(const merging *m) {
    const umb_regions *r = m->how->regions;
    const umb_grid *g = m->how->grid;
    size_t cells = (size_t)g->width * g->height;
    memset(m->starts, 0, (cells + 2) * sizeof *m->starts);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < r->count; i++) {
            size_t cell = (size_t)r->homes[i].y * g->width + (size_t)r->homes[i].x;
            if (pass == 0)
                m->starts[cell + 2]++;
            else
                m->members[m->starts[cell + 1]++] = i;
        }
        for (size_t c = 0; pass == 0 && c < cells; c++)
            m->starts[c + 2] += m->starts[c + 1];
    }
}

static void merge_cells(merging *m, author_xy *polygon) {
    size_t cells = (size_t)m->how->grid->width * m->how->grid->height;
    for (size_t cell = 0; cell < cells; cell++) {
        const size_t *members = m->members + m->starts[cell];
        size_t count = m->starts[cell + 1] - m->starts[cell];
        uint32_t k = m->how->counts[cell];
        cluster(m, members, count, k, m->of, m->how->stream + cell);
        for (uint32_t c = 0; c < k && c < count; c++)
            make_umbrella(m, members, m->of, count, c, polygon);
    }
}

typedef struct ranked {
    double depth;
    uint32_t index;
} ranked;

static int by_depth(const void *left, const void *right) {
    const ranked *a = left, *b = right;
    if (a->depth != b->depth)
        return a->depth < b->depth ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* The highest comes last, and its vertices and colours with it. */
static author_result sort_by_depth(merging *m) {
    umb_candidate *out = m->out;
    uint32_t count = out->level.umbrella_count, vertex = 0, colour = 0;
    ranked *order = author_alloc(m->run, count, sizeof *order);
    zt_umbrella *umbrellas = author_alloc(m->run, count, sizeof *umbrellas);
    zt_umbrella_offset *vertices = author_alloc(m->run, out->vertex_count, sizeof *vertices);
    if (!order || !umbrellas || !vertices) {
        free(order);
        free(umbrellas);
        free(vertices);
        return AUTHOR_NO_MEMORY;
    }
    for (uint32_t i = 0; i < count; i++)
        order[i] = (ranked){m->depths[i], i};
    qsort(order, count, sizeof *order, by_depth);
    for (uint32_t i = 0; i < count; i++) {
        umbrellas[i] = out->umbrellas[order[i].index];
        memcpy(vertices + vertex, out->vertices + umbrellas[i].first_vertex,
               umbrellas[i].vertex_count * sizeof *vertices);
        umbrellas[i].first_vertex = vertex;
        umbrellas[i].first_colour = colour;
        vertex += umbrellas[i].vertex_count;
        colour += umbrellas[i].vertex_count + 1u;
    }
    free(order);
    free(out->umbrellas);
    free(out->vertices);
    out->umbrellas = umbrellas;
    out->vertices = vertices;
    out->colour_count = colour;
    return AUTHOR_OK;
}

static author_result allocate(merging *m) {
    const umb_grid *g = m->how->grid;
    size_t cells = (size_t)g->width * g->height, most = 0, all = 0, regions = m->how->regions->count;
    for (size_t c = 0; c < cells; c++) {
        most = m->how->counts[c] > most ? m->how->counts[c] : most;
        all += m->how->counts[c];
    }
    all = all < regions ? all : regions;
    m->members = author_alloc(m->run, regions, sizeof *m->members);
    m->starts = author_alloc(m->run, cells + 2, sizeof *m->starts);
    m->of = author_alloc(m->run, regions, sizeof *m->of);
    m->means = author_alloc(m->run, most + 1, sizeof *m->means);
    m->colours = author_alloc(m->run, most + 1, sizeof *m->colours);
    m->nearest = author_alloc(m->run, regions, sizeof *m->nearest);
    m->points = author_alloc(m->run, m->how->regions->first[regions] + 1, sizeof *m->points);
    m->depths = author_alloc(m->run, all, sizeof *m->depths);
    m->out->umbrellas = author_alloc(m->run, all, sizeof *m->out->umbrellas);
    m->out->vertices = author_alloc(m->run, all * m->how->most_vertices, sizeof *m->out->vertices);
    return m->members && m->starts && m->of && m->means && m->colours && m->nearest && m->points && m->depths &&
                   m->out->umbrellas && m->out->vertices
               ? AUTHOR_OK
               : AUTHOR_NO_MEMORY;
}

author_result umb_shape_level(author_run *run, const umb_shaping *how, umb_candidate *out) {
    merging m = {.run = run, .how = how, .out = out};
    *out = (umb_candidate){.level = {.width = how->grid->width, .height = how->grid->height, .bits = how->bits}};
    author_result result = allocate(&m);
    author_xy *polygon = author_alloc(run, how->regions->first[how->regions->count] + 64, sizeof *polygon);
    if (!polygon)
        result = AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK) {
        sort_members(&m);
        merge_cells(&m, polygon);
        result = sort_by_depth(&m);
    }
    free(polygon);
    free(m.members);
    free(m.starts);
    free(m.of);
    free(m.means);
    free(m.colours);
    free(m.nearest);
    free(m.points);
    free(m.depths);
    if (result != AUTHOR_OK)
        umb_candidate_release(out);
    return result;
}

zt_umbrella_info umb_candidate_view(const umb_candidate *candidate) {
    return (zt_umbrella_info){.grid_x = candidate->level.width,
                              .grid_y = candidate->level.height,
                              .level_count = 1,
                              .umbrella_count = candidate->level.umbrella_count,
                              .levels = &candidate->level,
                              .umbrellas = candidate->umbrellas,
                              .explicit_vertices = candidate->vertices};
}

void umb_candidate_release(umb_candidate *candidate) {
    free(candidate->umbrellas);
    free(candidate->vertices);
    free(candidate->colours);
    free(candidate->starts);
    free(candidate->entries);
    *candidate = (umb_candidate){0};
}
