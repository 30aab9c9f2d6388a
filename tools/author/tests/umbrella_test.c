/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Properties of author_umbrella.h. What becomes a base is star-shaped in the file's integers, with and without a morph
 * and its mixtures, and its outline covers all of the element; the centre found is the one farthest from all sides, and
 * where there is none the text names the vertex; a repair covers what was there. A cell lists an umbrella if any place
 * in it shows the umbrella, in 2-D or bent in 3-D, and never one that is farther than the eighth of a cell; also over
 * sides that repeat. Arrangement, lists and levels have the same bytes for any number of threads and each time; levels
 * obey the limits they are given, and are as good between the pixels of a grid as there, and as a mipmap. It matters
 * because a file is refused or shows holes where one of these fails, because nobody could repeat what a scene makes,
 * and because hardly a lookup is in the middle of a pixel that somebody has fitted.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "author_umbrella.h"
#include "umbrella_private.h"
#include "checks.h"

#define EDGE 96

static author_random chance;

/* ---- shapes -------------------------------------------------------------------------------------------- */

/* A blob whose radius waves, as alpha; at least `least` of the largest radius everywhere. */
static author_picture blob(double least) {
    author_run run = {0};
    author_picture picture;
    double waves[4][2];
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++)
            waves[i][k] = umb_signed(&chance) / 4;
    if (author_picture_create(&run, EDGE, EDGE, 4, &picture) != AUTHOR_OK)
        abort();
    for (int i = 0; i < EDGE * EDGE; i++) {
        double x = i % EDGE + 0.5 - EDGE / 2.0, y = i / EDGE + 0.5 - EDGE / 2.0, angle = atan2(y, x), wave = 0;
        for (int k = 0; k < 4; k++)
            wave += waves[k][0] * cos((k + 1) * angle) + waves[k][1] * sin((k + 1) * angle);
        double radius = EDGE * 0.42 * fmax(least, 1 - fabs(wave));
        float *texel = picture.texels + 4 * i;
        texel[0] = 0.6f;
        texel[1] = (float)i / (EDGE * EDGE);
        texel[2] = 0.1f;
        texel[3] = (float)fmin(fmax(radius - hypot(x, y) + 0.5, 0), 1);
    }
    return picture;
}

static int inside(const author_xy *polygon, size_t count, author_xy p) {
    int crossings = 0;
    for (size_t i = 0, j = count - 1; i < count; j = i++) {
        author_xy a = polygon[i], b = polygon[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x)
            crossings++;
    }
    return crossings & 1;
}

static void check_star(const zt_umbrella_texel *points, size_t count, zt_umbrella_texel centre) {
    int turns = 0;
    for (size_t i = 0; i < count; i++) {
        size_t j = (i + 1) % count;
        int64_t ax = points[i].x - centre.x, ay = points[i].y - centre.y;
        int64_t bx = points[j].x - centre.x, by = points[j].y - centre.y;
        CHECK(ax * by - ay * bx > 0);
        turns += ay < 0 && by >= 0;
    }
    CHECK(turns == 1);
}

static void check_mixtures(const author_base *b) {
    size_t count = b->record.vertex_count;
    for (size_t i = 0; b->morph && i < count; i++) {
        size_t j = (i + 1) % count;
        int64_t cx = b->record.centre.x, cy = b->record.centre.y;
        int64_t dix = b->vertices[i].x - cx, diy = b->vertices[i].y - cy, djx = b->vertices[j].x - cx;
        int64_t djy = b->vertices[j].y - cy, eix = b->morph[i].x - cx, eiy = b->morph[i].y - cy;
        int64_t ejx = b->morph[j].x - cx, ejy = b->morph[j].y - cy;
        CHECK(dix * ejy - diy * ejx + eix * djy - eiy * djx >= 0);
    }
}

/* Every texel of the cut-out that shows anything lies in the outline. */
static void check_covers(const author_base *b, float threshold) {
    author_xy polygon[256];
    for (size_t i = 0; i < b->record.vertex_count; i++)
        polygon[i] = (author_xy){b->vertices[i].x / 65535.0 * b->picture.width,
                                 b->vertices[i].y / 65535.0 * b->picture.height};
    for (uint32_t i = 0; i < b->picture.width * b->picture.height; i++) {
        author_xy p = {i % b->picture.width + 0.5, i / b->picture.width + 0.5};
        if (b->picture.texels[4 * i + 3] > threshold)
            CHECK(inside(polygon, b->record.vertex_count, p));
    }
}

static void test_bases(void) {
    static const uint32_t vertices[] = {6, 12, 24, 60};
    for (int round = 0; round < 24; round++) {
        author_run run = {0};
        author_picture picture = blob(0.45);
        author_variant tint = {.centre = {0.2f, 0.5f, 0.1f}, .rim = {0.7f, 0.1f, 0.1f}, .spread = 0.1};
        author_base_input input = {.picture = &picture,
                                   .most_vertices = vertices[round % 4],
                                   .repair = 1,
                                   .morph_amount = round % 3 * 0.3,
                                   .variants = &tint,
                                   .variant_count = 1,
                                   .seed = (uint64_t)round};
        author_base base;
        author_result result = author_umbrella_base(&run, &input, &base);
        if (result != AUTHOR_OK)
            fprintf(stderr, "round %d: %s\n", round, run.error);
        CHECK(result == AUTHOR_OK);
        if (result == AUTHOR_OK) {
            check_star(base.vertices, base.record.vertex_count, base.record.centre);
            if (base.morph)
                check_star(base.morph, base.record.vertex_count, base.record.centre);
            check_mixtures(&base);
            check_covers(&base, 0.15f);
            CHECK(base.record.vertex_count <= vertices[round % 4] + (base.morph ? 16u : 0u));
            CHECK((base.morph != NULL) == (round % 3 > 0));
        }
        author_base_release(&base);
        author_picture_release(&picture);
    }
}

/* ---- centres and errors ---------------------------------------------------------------------------------- */

static void test_kernels(void) {
    author_xy square[] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}},
              ell[] = {{0, 0}, {4, 0}, {4, 8}, {10, 8}, {10, 12}, {0, 12}};
    author_xy horseshoe[] = {{0, 0}, {3, 0}, {3, 8}, {7, 8}, {7, 0}, {10, 0}, {10, 12}, {0, 12}}, centre;
    author_outline a = {square, 4}, b = {ell, 6}, c = {horseshoe, 8};
    CHECK(fabs(author_outline_kernel(&a, &centre) - 5) < 1e-6 && hypot(centre.x - 5, centre.y - 5) < 1e-5);
    CHECK(author_outline_bad_vertex(&a, centre) == 4);
    /* What sees all of an L is the square in its corner. */
    CHECK(fabs(author_outline_kernel(&b, &centre) - 2) < 1e-6 && hypot(centre.x - 2, centre.y - 10) < 1e-5);
    CHECK(author_outline_bad_vertex(&b, centre) == 6);
    CHECK(author_outline_kernel(&c, &centre) < 0);
    CHECK(fabs(author_outline_centroid(&a).x - 5) < 1e-12 && fabs(author_outline_area(&a) - 100) < 1e-12);
}

static void test_errors(void) {
    author_run run = {0};
    author_xy horseshoe[] = {{0, 0}, {3, 0}, {3, 8}, {7, 8}, {7, 0}, {10, 0}, {10, 12}, {0, 12}}, three[3] = {{0, 0}};
    author_outline outline = {horseshoe, 8}, other = {three, 3};
    author_base_input input = {.width = 16, .height = 16, .outline = &outline};
    author_base base;
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_BAD_INPUT);
    CHECK(strstr(run.error, "not star-shaped: vertex 1 at 3.0, 0.0 is not seen from the centre 5.0,") != NULL);
    input.centre_kind = AUTHOR_CENTRE_GIVEN;
    input.centre = (author_xy){1.5, 10};
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_BAD_INPUT && strstr(run.error, "vertex 3 at 7.0, 8.0"));
    input.repair = 1;
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_OK);
    check_star(base.vertices, base.record.vertex_count, base.record.centre);
    author_base_release(&base);
    input.centre = (author_xy){20, 4};
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_BAD_INPUT);
    input.morph = &other;
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_BAD_INPUT &&
          strstr(run.error, "the morph has 3 vertices and the outline 8"));
    author_picture clear;
    CHECK(author_picture_create(&run, 8, 8, 4, &clear) == AUTHOR_OK);
    input = (author_base_input){.picture = &clear};
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_BAD_INPUT && strstr(run.error, "nothing to cut out"));
    author_picture_release(&clear);
}

/* Whatever is in the outline before is in it after. */
static void test_repair(void) {
    for (int round = 0; round < 40; round++) {
        author_run run = {0};
        author_xy points[24], before[24];
        for (int i = 0; i < 24; i++) {
            double c, s, far = 2 + 8 * author_random_unit(&chance);
            umb_turn((i + 0.9 * umb_signed(&chance)) / 24.0, &c, &s);
            before[i] = points[i] = (author_xy){far * c, far * s};
        }
        author_outline outline = {malloc(sizeof points), 24};
        memcpy(outline.points, points, sizeof points);
        author_result result = author_outline_repair(&run, &outline, (author_xy){0, 0});
        CHECK(result == AUTHOR_OK);
        CHECK(author_outline_bad_vertex(&outline, (author_xy){0, 0}) == outline.count);
        for (int k = 0; result == AUTHOR_OK && k < 400; k++) {
            author_xy p = {10 * umb_signed(&chance), 10 * umb_signed(&chance)};
            if (inside(before, 24, p))
                CHECK(inside(outline.points, outline.count, p));
        }
        author_outline_release(&outline);
    }
}

/* ---- lists ----------------------------------------------------------------------------------------------- */

static author_base some_base(int round) {
    author_run run = {0};
    author_picture picture = blob(0.5);
    author_variant tint = {.centre = {0.2f, 0.5f, 0.1f}, .rim = {0.7f, 0.1f, 0.1f}, .spread = 0.1};
    author_base_input input = {.picture = &picture,
                               .most_vertices = 16,
                               .repair = 1,
                               .morph_amount = 0.2,
                               .variants = &tint,
                               .variant_count = 1,
                               .seed = (uint64_t)round};
    author_base base;
    CHECK(author_umbrella_base(&run, &input, &base) == AUTHOR_OK);
    author_picture_release(&picture);
    return base;
}

static author_umbrellas arrange(const author_base *base, int repeat, int is_explicit, zt_umbrella_ellipsoid ellipsoid,
                                const zt_parallel *parallel) {
    author_run run = {.parallel = parallel};
    author_species species = {.weight = 1,
                              .size = {0.5, 2},
                              .rotation = {0, 1},
                              .morph = {0, 1},
                              .strength = {0, 1},
                              .mirrored = 0.5,
                              .ellipsoid = ellipsoid,
                              .height = {0.1, 0.9},
                              .curvature = {0.05, 1},
                              .lift = {0, 0.2}};
    author_arrangement how = {.grid_x = 7,
                              .grid_y = 5,
                              .repeat_x = repeat & 1,
                              .repeat_y = repeat >> 1,
                              .density = 1.5,
                              .species = &species,
                              .species_count = 1,
                              .is_explicit = is_explicit,
                              .vertex_jitter = 0.2,
                              .colour_jitter = 0.1,
                              .seed = 9};
    author_umbrellas out;
    author_result result = author_umbrella_arrange(&run, base, 1, &how, &out);
    if (result != AUTHOR_OK)
        fprintf(stderr, "arrange: %s\n", run.error);
    CHECK(result == AUTHOR_OK);
    return out;
}

static int lists(const zt_umbrella_info *info, uint32_t cell, uint32_t entry) {
    for (uint32_t e = info->list_starts[cell]; e < info->list_starts[cell + 1]; e++)
        if (info->entries[e] == entry)
            return 1;
    return 0;
}

/* Where section 6 looks up, for a hit at q on the whole height. */
static author_xy unbend(author_xy q, double radius, double curvature) {
    double r = hypot(q.x, q.y), rim = sqrt(curvature * (2 - curvature));
    if (r == 0 || r >= radius)
        return q;
    double scale = radius * asin(r * rim / radius) / acos(1 - curvature) / r;
    return (author_xy){q.x * scale, q.y * scale};
}

static double distance_to(const author_xy *polygon, size_t count, author_xy p) {
    double least = INFINITY;
    for (size_t i = 0; i < count; i++) {
        author_xy a = polygon[i], b = polygon[(i + 1) % count];
        double dx = b.x - a.x, dy = b.y - a.y;
        double t = fmin(fmax(((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy), 0), 1);
        least = fmin(least, hypot(p.x - a.x - t * dx, p.y - a.y - t * dy));
    }
    return inside(polygon, count, p) ? 0 : least;
}

/* One umbrella, shifted, in one cell, at many places of it. */
static void check_cell(const zt_umbrella_info *info, uint32_t index, int shift, uint32_t cell) {
    enum { STEPS = 12 };
    const zt_umbrella *u = &info->umbrellas[index];
    author_xy polygon[64];
    size_t count = umb_polygon(info, u, info->levels[0].bits, polygon);
    double radius = umb_radius(polygon, count), least = INFINITY, curvature = (u->curvature + 1) / 65536.0;
    double cx = u->x / 65536.0 + (shift % 3 - 1) * (double)info->grid_x;
    double cy = u->y / 65536.0 + (shift / 3 - 1) * (double)info->grid_y;
    double far = hypot(cell % info->grid_x + 0.5 - cx, cell / info->grid_x + 0.5 - cy);
    int shown = 0, bent = 0, listed = lists(info, cell, index | (uint32_t)shift << ZT_UMBRELLA_SHIFT);
    if (!listed && far > radius + 1)
        return;
    for (int i = 0; i <= STEPS * (STEPS + 2); i++) {
        author_xy p = {cell % info->grid_x + (double)(i % (STEPS + 1)) / STEPS - cx,
                       cell / info->grid_x + (double)(i / (STEPS + 1)) / STEPS - cy};
        shown |= inside(polygon, count, p);
        bent |= u->height && inside(polygon, count, unbend(p, radius, curvature));
        least = fmin(least, distance_to(polygon, count, p));
    }
    CHECK(listed || !(shown || bent));
    CHECK(listed || least > 0.125 - 1e-9);
    /* Places are a twelfth of a cell apart. A bent outline goes beyond the polygon by a third of the radius at most. */
    CHECK(!listed || least < 0.125 + 0.06 + (u->height ? 0.58 * radius : 0));
}

static void check_order(const zt_umbrella_info *info, uint32_t cell) {
    for (uint32_t e = info->list_starts[cell]; e + 1 < info->list_starts[cell + 1]; e++) {
        uint32_t a = info->entries[e], b = info->entries[e + 1];
        uint32_t first = a & ZT_UMBRELLA_ENTRY, second = b & ZT_UMBRELLA_ENTRY;
        CHECK(first < second || (first == second && a >> ZT_UMBRELLA_SHIFT < b >> ZT_UMBRELLA_SHIFT));
    }
}

/* repeat: bit 0 along x, bit 1 along y. */
static void check_umbrella(const zt_umbrella_info *info, uint32_t index, int repeat) {
    for (int i = 0; i < 9 * 35; i++) {
        int shift = i / 35;
        if ((shift % 3 == 1 || repeat & 1) && (shift / 3 == 1 || repeat >> 1))
            check_cell(info, index, shift, (uint32_t)i % 35);
    }
}

static void test_lists(void) {
    for (int round = 0; round < 6; round++) {
        author_base base = some_base(round);
        author_umbrellas u = arrange(&base, round % 4, round == 4, (zt_umbrella_ellipsoid)(round % 3), NULL);
        CHECK(u.info.list_starts[35] == u.info.entry_count && u.info.umbrella_count > 40);
        for (uint32_t cell = 0; cell < 35; cell++)
            check_order(&u.info, cell);
        for (uint32_t i = 0; i < u.info.umbrella_count; i++)
            check_umbrella(&u.info, i, round % 4);
        author_umbrellas_release(&u);
        author_base_release(&base);
    }
}

/* ---- placement ------------------------------------------------------------------------------------------- */

/* Discs: the number that was asked for, and no two much closer than the densest random packing allows. */
static void test_discs(void) {
    author_base base = some_base(1);
    author_umbrellas u = arrange(&base, 3, 0, ZT_ELLIPSOID_FLAT, NULL);
    double least = INFINITY;
    CHECK(u.info.umbrella_count == 53); /* 1.5 x 35, rounded up */
    for (uint32_t i = 0; i < u.info.umbrella_count; i++)
        for (uint32_t j = 0; j < i; j++) {
            double dx = fabs((double)u.umbrellas[i].x - u.umbrellas[j].x) / 65536;
            double dy = fabs((double)u.umbrellas[i].y - u.umbrellas[j].y) / 65536;
            least = fmin(least, hypot(fmin(dx, 7 - dx), fmin(dy, 5 - dy)));
        }
    CHECK(least > 0.5);
    author_umbrellas_release(&u);
    author_base_release(&base);
}

/* ---- levels ---------------------------------------------------------------------------------------------- */

static author_picture truth_of(uint32_t width, uint32_t height) {
    author_run run = {0};
    author_picture picture;
    if (author_picture_create(&run, width, height, 4, &picture) != AUTHOR_OK)
        abort();
    for (uint32_t i = 0; i < width * height; i++)
        for (uint32_t c = 0; c < 4; c++)
            picture.texels[4 * i + c] = c == 3
                                            ? 1.0f
                                            : (float)(0.4 + 0.3 * sin(0.25 * (i % width) + c) * cos(0.2 * (i / width)));
    return picture;
}

/* Texels odd in x and y are the averages of pixels, of which a mipmap is made; the others are of shifted ones. */
static void test_phases(void) {
    static const int repeats[][2] = {{1, 1}, {0, 1}, {1, 0}, {0, 0}};
    author_picture picture = truth_of(80, 48);
    for (int round = 0; round < 4; round++) {
        author_run run = {0};
        author_picture phases, pixels;
        author_phase_errors errors;
        const int *repeat = repeats[round];
        CHECK(author_umbrella_phases(&run, &picture, 20, 12, repeat, &phases) == AUTHOR_OK);
        CHECK(author_umbrella_average(&run, &picture, 10, 6, &pixels) == AUTHOR_OK);
        for (size_t i = 0; i < 10 * 6 * 4; i++) {
            size_t x = i / 4 % 10, y = i / 40;
            CHECK(fabsf(phases.texels[4 * ((2 * y + 1) * 20 + 2 * x + 1) + i % 4] - pixels.texels[i]) < 1e-5f);
        }
        /* A pixel is 8 texels wide: the one around (8, 8), the one around (10, 10), and the first one where the sides
         * meet. */
        double second = 0, quarter = 0, first = 0;
        for (size_t i = 0; i < 64; i++) {
            size_t x = i % 8, y = i / 8;
            second += (double)picture.texels[4 * ((y + 4) * 80 + x + 4)] / 64;
            quarter += (double)picture.texels[4 * ((y + 6) * 80 + x + 6)] / 64;
            first += (double)picture.texels[4 * (y * 80 + (x >= 4 ? x - 4 : 76 + x))] / 64;
        }
        CHECK(fabs((double)phases.texels[4 * (2 * 20 + 2)] - second) < 1e-5);
        CHECK(fabs((double)phases.texels[4 * (14 * 20 + 2)] - quarter) < 1e-5);
        CHECK(!repeat[0] || fabs((double)phases.texels[4 * 20] - first) < 1e-5);
        author_umbrella_bilinear(&phases, repeat, &errors);
        CHECK(errors.pixels.coded == 0 && errors.pixels.count == 180 && errors.between.count == 1260);
        CHECK(errors.between.coded > 0 && errors.alpha.linear == 0 && errors.alpha.count == 480);
        author_umbrella_compare(&phases, &phases, &errors);
        CHECK(errors.pixels.coded == 0 && errors.between.coded == 0);
        author_picture_release(&phases);
        author_picture_release(&pixels);
    }
    author_picture_release(&picture);
}

static author_umbrellas with_levels(const author_base *base, const zt_parallel *parallel, uint32_t longest,
                                    author_level_report *reports) {
    author_run run = {.parallel = parallel};
    author_umbrellas u = arrange(base, 3, 0, ZT_ELLIPSOID_CONVEX, parallel);
    author_picture truth = truth_of(96, 64), background[2] = {truth_of(48, 64), truth_of(16, 32)};
    author_levels how = {.repeat_x = 1,
                         .repeat_y = 1,
                         .truth = &truth,
                         .background = background,
                         .level_count = 3,
                         .longest = longest,
                         .seed = 4};
    author_result result = author_umbrella_levels(&run, &u, &how, reports);
    if (result != AUTHOR_OK)
        fprintf(stderr, "levels: %s\n", run.error);
    CHECK(result == AUTHOR_OK);
    author_picture_release(&truth);
    author_picture_release(&background[0]);
    author_picture_release(&background[1]);
    return u;
}

static int same(const author_umbrellas *a, const author_umbrellas *b) {
    const zt_umbrella_info *i = &a->info, *k = &b->info;
    return i->umbrella_count == k->umbrella_count && i->entry_count == k->entry_count &&
           i->explicit_vertex_count == k->explicit_vertex_count && memcmp(i->mean, k->mean, sizeof i->mean) == 0 &&
           memcmp(a->umbrellas, b->umbrellas, i->umbrella_count * sizeof *a->umbrellas) == 0 &&
           memcmp(a->entries, b->entries, i->entry_count * sizeof *a->entries) == 0 &&
           memcmp(a->explicit_vertices, b->explicit_vertices,
                  i->explicit_vertex_count * sizeof *a->explicit_vertices) == 0 &&
           memcmp(a->explicit_colours, b->explicit_colours, i->explicit_colour_count * sizeof *a->explicit_colours) ==
               0;
}

static void test_levels(void) {
    author_base base = some_base(2);
    author_level_report reports[2];
    author_umbrellas first = with_levels(&base, NULL, 0, reports);
    CHECK(first.info.level_count == 3 && reports[0].width == 3 && reports[0].height == 2 && reports[1].width == 1);
    for (int i = 0; i < 2; i++) {
        const author_level_report *r = &reports[i];
        if (!(r->psnr > 30 && r->between_psnr > fmin(r->mipmap_psnr, 40)))
            fprintf(stderr, "level %d: %.2f dB, at other phases %.2f, a mipmap %.2f\n", i + 1, r->psnr, r->between_psnr,
                    r->mipmap_psnr);
        CHECK(r->psnr > 30 && r->between_psnr > 30);
        CHECK(r->between_psnr >= fmin(r->mipmap_psnr, 40));
    }
    for (unsigned workers = 1; workers <= 4; workers *= 2) {
        zt_threads *threads;
        if (zt_threads_open(workers, &threads) != ZT_OK)
            abort();
        zt_parallel parallel = zt_threads_parallel(threads);
        author_umbrellas again = with_levels(&base, &parallel, 0, NULL);
        CHECK(same(&first, &again));
        author_umbrellas_release(&again);
        zt_threads_close(threads);
    }
    author_umbrellas short_lists = with_levels(&base, NULL, 12, reports);
    CHECK(reports[0].longest <= 12 && reports[1].longest <= 12);
    author_umbrellas_release(&short_lists);
    for (uint32_t l = 1; l < 3; l++)
        for (uint32_t i = 0; i < first.levels[l].umbrella_count; i++) {
            const zt_umbrella *u = &first.umbrellas[first.levels[l].first_umbrella + i];
            CHECK(u->form == ZT_UMBRELLA_COLOURED && u->vertex_count >= 3);
            CHECK(umb_bad_offset(first.explicit_vertices + u->first_vertex, u->vertex_count) == u->vertex_count);
        }
    author_umbrellas_release(&first);
    author_base_release(&base);
}

static void test_numbers(void) {
    for (int i = -400; i < 400; i++) {
        double c, s;
        umb_turn(i / 97.0, &c, &s);
        CHECK(fabs(c - cos(6.283185307179586 * i / 97.0)) < 1e-13 &&
              fabs(s - sin(6.283185307179586 * i / 97.0)) < 1e-13);
    }
    for (int i = 0; i <= 100; i++)
        CHECK(fabs(umb_arc(i / 100.0) - acos(i / 100.0) / 6.283185307179586) < 1e-12);
    for (int q = -127; q <= 127; q++)
        CHECK((int8_t)umb_offset_code(umb_offset((uint8_t)(int8_t)q)) == q);
}

int main(void) {
    author_random_seed(&chance, 77, 1);
    test_numbers();
    test_kernels();
    test_errors();
    test_repair();
    test_bases();
    test_lists();
    test_discs();
    test_phases();
    test_levels();
    if (failures)
        fprintf(stderr, "%d failures\n", failures);
    return failures > 0;
}
