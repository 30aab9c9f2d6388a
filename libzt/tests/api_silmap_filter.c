/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: the filters of silmaps are what spec/silmap.md sections 4, 5 and 7 say, over random cells: one quadrant for
 * each point, weights that sum to 1, values that jump across cut arms and nowhere else, areas that are those of the
 * quadrants. A filter with a seam shows as a line on every magnified picture.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "test.h"
#include "zt/zt.h"
#include "zt/zt_write.h"

enum { EDGE = 12, ROUNDS = 900, CASES = 16 }; /* 129600 cells */

typedef struct grid {
    uint8_t cells[EDGE][EDGE];
    double samples[EDGE + 1][EDGE + 1];
    bool repeat;
} grid;

/* A cell, its corners' values, and where its arms are. Arms and sides: north, east, south, west. */
typedef struct place {
    zt_silmap_cell cell;
    double corners[4];
    double px, py;
    double end[4][2];
    double crossing[4]; /* along the side */
    bool cut[4];
} place;

/* The corners at the ends of a side, the left or upper one first. */
static const int side_corners[4][2] = {{ZT_SILMAP_00, ZT_SILMAP_10},
                                       {ZT_SILMAP_10, ZT_SILMAP_11},
                                       {ZT_SILMAP_01, ZT_SILMAP_11},
                                       {ZT_SILMAP_00, ZT_SILMAP_01}};

static uint8_t random_cell(uint64_t *seed, uint32_t density) {
    uint8_t byte = (uint8_t)test_below(seed, 64);
    if (test_below(seed, 4) < density)
        byte |= ZT_SILMAP_WEST;
    if (test_below(seed, 4) < density)
        byte |= ZT_SILMAP_NORTH;
    return byte;
}

static void fill_grid(grid *g, uint64_t *seed, bool repeat) {
    uint32_t density = test_below(seed, 4) + (test_below(seed, 3) > 0);
    g->repeat = repeat;
    for (int y = 0; y < EDGE; y++) {
        for (int x = 0; x < EDGE; x++) {
            g->cells[y][x] = random_cell(seed, density);
            if (!repeat && x == 0)
                g->cells[y][x] &= (uint8_t)~ZT_SILMAP_WEST;
            if (!repeat && y == 0)
                g->cells[y][x] &= (uint8_t)~ZT_SILMAP_NORTH;
        }
    }
    for (int y = 0; y <= EDGE; y++) {
        for (int x = 0; x <= EDGE; x++)
            g->samples[y][x] = test_uniform(seed, 0, 1);
    }
    for (int i = 0; i <= EDGE && repeat; i++) {
        g->samples[EDGE][i] = g->samples[0][i];
        g->samples[i][EDGE] = g->samples[i][0];
    }
    if (repeat)
        g->samples[EDGE][EDGE] = g->samples[0][0];
}

static double point_x(uint8_t byte) {
    return ((byte & 7) + 0.5) / 8;
}

static double point_y(uint8_t byte) {
    return ((byte >> 3 & 7) + 0.5) / 8;
}

/* The cell next to (x, y) in a direction; false: the texture ends there. */
static bool cell_beside(const grid *g, int x, int y, const int step[2], uint8_t *out) {
    int i = x + step[0], j = y + step[1];
    *out = g->cells[(j + EDGE) % EDGE][(i + EDGE) % EDGE];
    return g->repeat || (i >= 0 && j >= 0 && i < EDGE && j < EDGE);
}

/* Section 3: an edge that is alone in a cell at the border runs on over it, straight on if it can. */
static void run_on(place *p, const bool inside[4]) {
    int cut = 0, to = -1;
    for (int i = 0; i < 4; i++) {
        if (inside[i] && p->cut[i]) {
            cut++;
            to = (i + 2) % 4;
        }
    }
    for (int i = 0; i < 4 && cut == 1 && inside[to]; i++)
        if (!inside[i])
            to = i;
    if (cut == 1 && !inside[to])
        p->cut[to] = true;
}

static void arms_of(const grid *g, int x, int y, place *p) {
    static const int steps[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    uint8_t own = g->cells[y][x];
    bool inside[4];
    p->px = point_x(own);
    p->py = point_y(own);
    for (int i = 0; i < 4; i++) {
        uint8_t next, bit = i % 2 ? ZT_SILMAP_WEST : ZT_SILMAP_NORTH;
        inside[i] = cell_beside(g, x, y, steps[i], &next);
        p->end[i][0] = inside[i] ? point_x(next) + steps[i][0] : i == 1 ? 2 - p->px : i == 3 ? -p->px : p->px;
        p->end[i][1] = inside[i] ? point_y(next) + steps[i][1] : i == 2 ? 2 - p->py : i == 0 ? -p->py : p->py;
        p->cut[i] = inside[i] && ((i == 0 || i == 3 ? own : next) & bit);
    }
    run_on(p, inside);
}

static void check_arms(const place *p) {
    zt_silmap_shape s;
    zt_silmap_shape_of(&p->cell, &s);
    const double ends[4][2] = {{s.nx, s.ny}, {s.ex, s.ey}, {s.sx, s.sy}, {s.wx, s.wy}};
    CHECK(s.px == p->px && s.py == p->py);
    for (int i = 0; i < 4; i++) {
        CHECK(ends[i][0] == p->end[i][0] && ends[i][1] == p->end[i][1]);
        CHECK((s.cut >> i & 1) == (unsigned)p->cut[i]);
    }
}

static place place_of(const grid *g, int x, int y) {
    place p = {0};
    arms_of(g, x, y, &p);
    zt_silmap_cell_at(&g->cells[0][0], EDGE, EDGE, g->repeat, g->repeat, (uint32_t)x, (uint32_t)y, &p.cell);
    check_arms(&p);
    for (int i = 0; i < 4; i++) {
        double *e = p.end[i];
        double f = i == 0   ? p.py / (p.py - e[1])
                   : i == 1 ? (1 - p.px) / (e[0] - p.px)
                   : i == 2 ? (1 - p.py) / (e[1] - p.py)
                            : p.px / (p.px - e[0]);
        p.crossing[i] = i % 2 == 0 ? p.px + f * (e[0] - p.px) : p.py + f * (e[1] - p.py);
    }
    p.corners[0] = g->samples[y][x];
    p.corners[1] = g->samples[y][x + 1];
    p.corners[2] = g->samples[y + 1][x];
    p.corners[3] = g->samples[y + 1][x + 1];
    return p;
}

static unsigned case_of(const place *p) {
    return (unsigned)p->cut[0] | (unsigned)p->cut[1] << 1 | (unsigned)p->cut[2] << 2 | (unsigned)p->cut[3] << 3;
}

/* The value of a quadrant's formula, in the range of its corners. */
static double value_of(const place *p, zt_silmap_filter filter, int quadrant, double x, double y) {
    double w[4], v = 0, low = HUGE_VAL, high = -HUGE_VAL;
    unsigned set = zt_silmap_weights(filter, &p->cell, quadrant, x, y, w);
    for (int k = 0; k < 4; k++) {
        v += w[k] * p->corners[k];
        if (set >> k & 1) {
            low = fmin(low, p->corners[k]);
            high = fmax(high, p->corners[k]);
        }
    }
    return set ? fmin(fmax(v, low), high) : v;
}

static double value_at(const place *p, zt_silmap_filter filter, double x, double y) {
    return value_of(p, filter, zt_silmap_quadrant(&p->cell, x, y), x, y);
}

/* ---- quadrants ---- */

/* Even-odd rule over corner, crossing, point, crossing. */
static bool in_quadrant(const place *p, int quadrant, double x, double y) {
    double cx = quadrant & 1, cy = quadrant >> 1;
    int side_x = quadrant & 2 ? 2 : 0, side_y = quadrant & 1 ? 1 : 3;
    const double polygon[4][2] = {{cx, cy}, {p->crossing[side_x], cy}, {p->px, p->py}, {cx, p->crossing[side_y]}};
    bool inside = false;
    for (int i = 0; i < 4; i++) {
        const double *a = polygon[i], *b = polygon[(i + 1) % 4];
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            inside = !inside;
    }
    return inside;
}

/* From an arm, as far as a quadrant can be told without doubt. */
static bool is_near_arm(const place *p, double x, double y) {
    for (int i = 0; i < 4; i++) {
        double dx = p->end[i][0] - p->px, dy = p->end[i][1] - p->py;
        if (fabs((x - p->px) * dy - (y - p->py) * dx) < 1e-9)
            return true;
    }
    return false;
}

/* A prepared cell gives the same answers. */
static void check_prepared(const place *p, zt_silmap_filter filter, int quadrant, double x, double y, const double w[4],
                           unsigned set) {
    zt_silmap_shape shape;
    double prepared[4];
    zt_silmap_shape_of(&p->cell, &shape);
    CHECK(zt_silmap_shape_quadrant(&shape, x, y) == zt_silmap_quadrant(&p->cell, x, y));
    CHECK(zt_silmap_shape_weights(filter, &shape, quadrant, x, y, prepared) == set);
    for (int k = 0; k < 4; k++)
        CHECK(prepared[k] == w[k]);
}

static void check_quadrants(const place *p, uint64_t *seed) {
    double x = test_uniform(seed, 0, 1), y = test_uniform(seed, 0, 1);
    if (is_near_arm(p, x, y))
        return;
    int count = 0;
    for (int q = 0; q < 4; q++)
        count += in_quadrant(p, q, x, y);
    CHECK(count == 1);
    CHECK(in_quadrant(p, zt_silmap_quadrant(&p->cell, x, y), x, y));
}

static void check_areas(const place *p, bool sampled) {
    enum { STEPS = 96 };
    double areas[4], sum = 0, counts[4] = {0};
    zt_silmap_areas(&p->cell, areas);
    for (int k = 0; k < 4; k++) {
        sum += areas[k];
        CHECK(areas[k] > 0);
    }
    CHECK(fabs(sum - 1) < 1e-12);
    for (int i = 0; sampled && i < STEPS * STEPS; i++)
        counts[zt_silmap_quadrant(&p->cell, (i % STEPS + 0.5) / STEPS, (i / STEPS + 0.5) / STEPS)]++;
    for (int k = 0; sampled && k < 4; k++)
        CHECK(fabs(counts[k] / (STEPS * STEPS) - areas[k]) < 1.0 / STEPS);
}

/* ---- values inside ---- */

static void check_weights(const place *p, uint64_t *seed) {
    double x = test_uniform(seed, 0, 1), y = test_uniform(seed, 0, 1);
    if (test_below(seed, 8) == 0)
        x = test_below(seed, 2);
    if (test_below(seed, 8) == 0)
        y = test_below(seed, 2);
    const double b[4] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
    double low = fmin(fmin(p->corners[0], p->corners[1]), fmin(p->corners[2], p->corners[3]));
    double high = fmax(fmax(p->corners[0], p->corners[1]), fmax(p->corners[2], p->corners[3]));
    for (int f = 0; f < 3; f++) {
        /* Also for the quadrants that the point is not in: the edges of a lookup mix them. */
        for (int q = 0; q < 4; q++) {
            double w[4];
            unsigned set = zt_silmap_weights((zt_silmap_filter)f, &p->cell, q, x, y, w);
            check_prepared(p, (zt_silmap_filter)f, q, x, y, w, set);
            CHECK(fabs(w[0] + w[1] + w[2] + w[3] - 1) < 1e-12);
            for (int k = 0; k < 4; k++) {
                CHECK(f == ZT_SILMAP_SEN2004 || w[k] >= -1e-12);
                CHECK(f != ZT_SILMAP_NEAREST || w[k] == (k == q));
                CHECK(f == ZT_SILMAP_NEAREST || case_of(p) != 0 || w[k] == b[k]);
            }
            double v = value_of(p, (zt_silmap_filter)f, q, x, y);
            CHECK(v >= low - 1e-12 && v <= high + 1e-12);
        }
    }
}

static void check_equal_colours(place p, uint64_t *seed) {
    double x = test_uniform(seed, 0, 1), y = test_uniform(seed, 0, 1);
    p.corners[0] = p.corners[1] = p.corners[2] = p.corners[3] = 0.7;
    for (int f = 0; f < 3; f++)
        CHECK(fabs(value_at(&p, (zt_silmap_filter)f, x, y) - 0.7) < 1e-12);
}

/* ---- sides ---- */

static void side_point(int side, double t, double *x, double *y) {
    *x = side == 1 ? 1 : side == 3 ? 0 : t;
    *y = side == 2 ? 1 : side == 0 ? 0 : t;
}

/* Linear where no cut arm crosses, the corner's value up to the crossing elsewhere. So what the cell beyond has is the
 * same. */
static void check_side(const place *p, int side, double t) {
    double x, y;
    double a = p->corners[side_corners[side][0]], b = p->corners[side_corners[side][1]];
    side_point(side, t, &x, &y);
    if (fabs(t - p->crossing[side]) < 1e-9)
        return;
    double want = p->cut[side] ? (t < p->crossing[side] ? a : b) : a + t * (b - a);
    CHECK(fabs(value_at(p, ZT_SILMAP_CONTINUOUS, x, y) - want) < 1e-9);
}

static void check_neighbours(const grid *g, const place *p, int x, int y, double t) {
    if (g->repeat || x + 1 < EDGE) {
        place east = place_of(g, (x + 1) % EDGE, y);
        if (fabs(t - p->crossing[1]) > 1e-9)
            CHECK(fabs(value_at(p, ZT_SILMAP_CONTINUOUS, 1, t) - value_at(&east, ZT_SILMAP_CONTINUOUS, 0, t)) < 1e-9);
    }
    if (g->repeat || y + 1 < EDGE) {
        place south = place_of(g, x, (y + 1) % EDGE);
        if (fabs(t - p->crossing[2]) > 1e-9)
            CHECK(fabs(value_at(p, ZT_SILMAP_CONTINUOUS, t, 1) - value_at(&south, ZT_SILMAP_CONTINUOUS, t, 0)) < 1e-9);
    }
}

/* ---- arms ---- */

/* Both sides of an arm, a share along it from the point to the side. */
static double jump_across(const place *p, int arm, double share) {
    double x, y;
    const double probe = 1e-9;
    side_point(arm, p->crossing[arm], &x, &y);
    double dx = x - p->px, dy = y - p->py, length = sqrt(dx * dx + dy * dy);
    x = p->px + share * dx;
    y = p->py + share * dy;
    double nx = -dy / length * probe, ny = dx / length * probe;
    return value_at(p, ZT_SILMAP_CONTINUOUS, x + nx, y + ny) - value_at(p, ZT_SILMAP_CONTINUOUS, x - nx, y - ny);
}

static void check_arm(const place *p, int arm, uint64_t *seed) {
    double ends = fabs(p->corners[side_corners[arm][0]] - p->corners[side_corners[arm][1]]);
    if (!p->cut[arm])
        CHECK(fabs(jump_across(p, arm, test_uniform(seed, 0.01, 0.99))) < 1e-6);
    else
        CHECK(fabs(fabs(jump_across(p, arm, 1 - 1e-9)) - ends) < 1e-6);
}

/* ---- minifying ---- */

static void check_minified(uint64_t *seed) {
    grid g;
    float samples[(EDGE + 1) * (EDGE + 1) * 4], out[EDGE * EDGE * 4];
    bool repeat = test_below(seed, 2) != 0;
    int edge = repeat ? EDGE : EDGE + 1;
    fill_grid(&g, seed, repeat);
    for (int i = 0; i < edge * edge * 4; i++)
        samples[i] = (float)(g.samples[i / 4 / edge][i / 4 % edge] * (i % 4 + 1));
    CHECK(zt_minify_silmap(&g.cells[0][0], EDGE, EDGE, samples, (uint32_t)edge, (uint32_t)edge, out) == ZT_OK);
    for (int i = 0; i < EDGE * EDGE * 4; i++) {
        double areas[4], want = 0;
        place p = place_of(&g, i / 4 % EDGE, i / 4 / EDGE);
        zt_silmap_areas(&p.cell, areas);
        for (int k = 0; k < 4; k++)
            want += areas[k] * p.corners[k] * (i % 4 + 1);
        CHECK(fabs((double)out[i] - want) < 1e-5);
    }
    CHECK(zt_minify_silmap(NULL, EDGE, EDGE, samples, EDGE, EDGE, out) == ZT_BAD_ARGUMENT);
    CHECK(zt_minify_silmap(&g.cells[0][0], 0, EDGE, samples, 1, EDGE, out) == ZT_BAD_ARGUMENT);
    CHECK(zt_minify_silmap(&g.cells[0][0], EDGE, EDGE, samples, EDGE, EDGE + 2, out) == ZT_BAD_ARGUMENT);
    CHECK(zt_minify_silmap(&g.cells[0][0], EDGE, EDGE, samples, EDGE - 1, EDGE, out) == ZT_BAD_ARGUMENT);
}

int main(void) {
    static grid g;
    uint64_t seed = 0x51117;
    unsigned seen[CASES] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        fill_grid(&g, &seed, round % 2 == 0);
        for (int i = 0; i < EDGE * EDGE; i++) {
            int x = i % EDGE, y = i / EDGE;
            place p = place_of(&g, x, y);
            seen[case_of(&p)]++;
            for (int n = 0; n < 2; n++) {
                check_quadrants(&p, &seed);
                check_weights(&p, &seed);
                check_neighbours(&g, &p, x, y, test_uniform(&seed, 0, 1));
            }
            check_equal_colours(p, &seed);
            check_areas(&p, i == 0 || round < 2);
            for (int side = 0; side < 4; side++) {
                check_side(&p, side, test_uniform(&seed, 0, 1));
                check_arm(&p, side, &seed);
            }
        }
    }
    for (unsigned i = 0; i < CASES; i++)
        CHECK(seen[i] > 500);
    for (int i = 0; i < 8; i++)
        check_minified(&seed);
    return test_end();
}
