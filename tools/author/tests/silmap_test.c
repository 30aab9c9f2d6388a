/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Properties of author_silmap_fit. Straight edges of every direction are held to less than the grid that points stand
 * on, a square whose sides are on that grid exactly; the colours of flat regions stay pure; a gradient gets no cuts; a
 * line thinner than a cell is reported; no picture gets worse than the bilinear texture of the same grid; and the bytes
 * do not depend on threads. Every filter, number of channels, way to repeat and size of grid gives a valid silmap;
 * colours under alpha stay in their range; progress never goes back. An edge is held at the border as well as inside;
 * with paths_only nothing else is cut; hinting is worth it, is the same each time and moves nothing further than it
 * says. It matters because these are the reasons to make a silmap instead of a bilinear texture or a distance field.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "author_silmap.h"
#include "checks.h"

#define EDGE 128
#define CELLS 16

typedef float (*shade)(double x, double y, uint32_t channel);

static double turn; /* of the half plane */

static int in_half(double x, double y) {
    return (x - 0.507) * cos(turn) + (y - 0.492) * sin(turn) > 0;
}

static int in_square(double x, double y) {
    double low = (4 + 3.5 / 8) / CELLS, high = (11 + 4.5 / 8) / CELLS;
    return x > low && x < high && y > low && y < high;
}

static float half_plane(double x, double y, uint32_t channel) {
    return in_half(x, y) ? 0.9f - 0.2f * (float)channel : 0.1f * (float)(channel + 1);
}

static float square(double x, double y, uint32_t channel) {
    return in_square(x, y) ? 0.8f : 0.05f + 0.1f * (float)channel;
}

static float gradient(double x, double y, uint32_t channel) {
    return (float)(0.2 + 0.3 * x + 0.2 * y + 0.1 * channel);
}

/* Smooth, with one sharp step: what a photograph has. */
static float photograph(double x, double y, uint32_t channel) {
    double waves = 0.06 * sin(31 * x + channel) * cos(23 * y) + 0.02 * sin(390 * x) * sin(370 * y);
    return (float)(waves + 0.15 + (hypot(x - 0.5, y - 0.45) < 0.3 ? 0.5 : 0));
}

static float thin_line(double x, double y, uint32_t channel) {
    (void)channel;
    return fabs(y - 0.4 - 0.1 * x) < 0.2 / CELLS ? 1.0f : 0.0f;
}

static author_random chance;

static float noise(double x, double y, uint32_t channel) {
    (void)x, (void)y, (void)channel;
    return (float)author_random_unit(&chance);
}

static author_picture paint(uint32_t w, uint32_t h, uint32_t channels, shade colour) {
    author_run run = {0};
    author_picture picture;
    if (author_picture_create(&run, w, h, channels, &picture) != AUTHOR_OK)
        abort();
    for (uint32_t i = 0; i < w * h * channels; i++)
        picture.texels[i] = colour((i / channels % w + 0.5) / w, (i / channels / w + 0.5) / h, i % channels);
    return picture;
}

static author_silmap_result fit_with(const author_silmap_input *input, const author_silmap_options *options,
                                     const zt_parallel *parallel) {
    author_run run = {.parallel = parallel};
    author_silmap_result result;
    author_result code = author_silmap_fit(&run, input, options, &result);
    if (code != AUTHOR_OK)
        fprintf(stderr, "author_silmap_fit: %s\n", run.error);
    CHECK(code == AUTHOR_OK);
    return result;
}

static author_silmap_result fit(const author_picture *picture, uint32_t cells_x, uint32_t cells_y) {
    author_silmap_input input = {.picture = picture};
    author_silmap_options options = {.cells_x = cells_x, .cells_y = cells_y};
    return fit_with(&input, &options, NULL);
}

/* ---- drawings ------------------------------------------------------------------------------------------- */

/* Area between the edge that is shown and the true one, by the length of the edge: a mean distance, in cells. */
static void test_half_planes(void) {
    for (int i = 0; i < 9; i++) {
        turn = 0.35 * i;
        double c = cos(turn), s = sin(turn);
        const double corners[] = {0.507 - 3 * s,         0.492 + 3 * c,         0.507 + 3 * s,
                                  0.492 - 3 * c,         0.507 + 3 * s + 3 * c, 0.492 - 3 * c + 3 * s,
                                  0.507 - 3 * s + 3 * c, 0.492 + 3 * c + 3 * s};
        author_path path = {corners, 4, 1};
        author_picture picture = paint(EDGE, EDGE, 3, half_plane);
        author_silmap_input input = {.picture = &picture, .paths = &path, .path_count = 1};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS};
        author_silmap_result result = fit_with(&input, &options, NULL);
        double length = 1 / fmax(fabs(c), fabs(s));
        CHECK(result.disagreement * CELLS / length < 1.0 / 16);
        CHECK(result.psnr > result.bilinear_psnr + 3);
        author_silmap_release(&result);
        author_silmap_result found = fit(&picture, CELLS, CELLS);
        CHECK(found.disagreement * CELLS / length < 1.0 / 16);
        author_silmap_release(&found);
        author_picture_release(&picture);
    }
}

static void test_square(void) {
    double low = (4 + 3.5 / 8) / CELLS, high = (11 + 4.5 / 8) / CELLS;
    const double corners[] = {low, low, high, low, high, high, low, high};
    author_path path = {corners, 4, 1};
    author_picture picture = paint(EDGE, EDGE, 3, square);
    author_silmap_input input = {.picture = &picture, .paths = &path, .path_count = 1};
    author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS};
    author_silmap_result result = fit_with(&input, &options, NULL);
    CHECK(result.disagreement < 1e-9);
    CHECK(result.cut_cells == 28);
    CHECK(result.thin_cells == 0 && result.junction_cells == 0);
    /* No sample is a mixture. */
    for (uint32_t s = 0; s < (CELLS + 1) * (CELLS + 1); s++) {
        int inside = in_square((double)(s % (CELLS + 1)) / CELLS, (double)(s / (CELLS + 1)) / CELLS);
        for (uint32_t ch = 0; ch < 3; ch++) {
            float wanted = inside ? 0.8f : 0.05f + 0.1f * (float)ch;
            CHECK(fabsf(result.samples.texels[3 * s + ch] - wanted) < 1e-4f);
        }
    }
    author_silmap_release(&result);
    author_picture_release(&picture);
}

static void test_gradient(void) {
    author_picture picture = paint(EDGE, EDGE, 3, gradient);
    author_silmap_result result = fit(&picture, CELLS, CELLS);
    CHECK(result.cut_cells == 0);
    for (uint32_t c = 0; c < CELLS * CELLS; c++)
        CHECK(result.cells[c] == ZT_SILMAP_DEFAULT);
    CHECK(result.psnr > 55);
    author_silmap_release(&result);
    author_picture_release(&picture);
}

static void test_thin_line(void) {
    author_picture picture = paint(4 * EDGE, 4 * EDGE, 1, thin_line);
    author_silmap_result result = fit(&picture, CELLS, CELLS);
    CHECK(result.thin_cells >= CELLS / 2);
    CHECK(result.psnr >= result.bilinear_psnr - 1e-9);
    author_silmap_release(&result);
    author_picture_release(&picture);
}

/* ---- pictures ------------------------------------------------------------------------------------------- */

static void test_photograph(void) {
    author_picture picture = paint(EDGE, EDGE, 3, photograph);
    author_silmap_input input = {.picture = &picture};
    author_silmap_options options = {.cells_x = 32, .cells_y = 32};
    author_silmap_result solved = fit_with(&input, &options, NULL);
    options.no_least_squares = 1;
    author_silmap_result means = fit_with(&input, &options, NULL);
    CHECK(solved.cut_cells > 0);
    CHECK(solved.psnr > solved.bilinear_psnr + 1);
    CHECK(solved.psnr >= means.psnr);
    CHECK(solved.bilinear_psnr >= solved.box_psnr);
    author_silmap_release(&solved);
    author_silmap_release(&means);
    author_picture_release(&picture);
}

static void test_noise(void) {
    static const uint32_t shapes[][5] = {{1, 1, 1, 1, 1},    {1, 9, 2, 1, 3},     {64, 64, 3, 16, 16},
                                         {61, 47, 4, 17, 9}, {40, 90, 2, 40, 90}, {33, 32, 4, 1, 32}};
    for (size_t i = 0; i < 4 * sizeof shapes / sizeof *shapes; i++) {
        const uint32_t *shape = shapes[i / 4];
        author_picture picture = paint(shape[0], shape[1], shape[2], noise);
        uint32_t *labels = calloc((size_t)shape[0] * shape[1], sizeof *labels);
        for (uint32_t t = 0; labels && t < shape[0] * shape[1]; t++)
            labels[t] = author_random_below(&chance, 30) * 99999999;
        author_silmap_input input = {
            .picture = &picture, .labels = i & 1 ? labels : NULL, .repeat_x = i & 2 ? 1 : 0, .repeat_y = i & 2 ? 1 : 0};
        author_silmap_options options = {.cells_x = shape[3], .cells_y = shape[4]};
        author_silmap_result result = fit_with(&input, &options, NULL);
        CHECK(result.psnr >= result.bilinear_psnr - 1e-9);
        for (uint32_t c = 0; !input.repeat_x && c < shape[4]; c++)
            CHECK(!(result.cells[(size_t)c * shape[3]] & ZT_SILMAP_WEST));
        author_silmap_release(&result);
        free(labels);
        author_picture_release(&picture);
    }
}

static int same_result(const author_silmap_result *a, const author_silmap_result *b) {
    size_t cells = (size_t)a->cells_x * a->cells_y;
    size_t values = (size_t)a->samples.width * a->samples.height * a->samples.channels;
    return a->cells_x == b->cells_x && a->cells_y == b->cells_y && memcmp(a->cells, b->cells, cells) == 0 &&
           memcmp(a->samples.texels, b->samples.texels, values * sizeof(float)) == 0 &&
           memcmp(a->error, b->error, cells * sizeof(float)) == 0;
}

static void test_threads(void) {
    static const shade pictures[] = {photograph, thin_line, half_plane};
    zt_threads *threads = NULL;
    CHECK(zt_threads_open(3, &threads) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(threads);
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++) {
        author_picture picture = paint(EDGE, EDGE, 3, pictures[i]);
        author_silmap_input input = {.picture = &picture, .repeat_x = i & 1};
        author_silmap_options options = {.cells_x = 21, .cells_y = 30};
        author_silmap_result one = fit_with(&input, &options, NULL);
        author_silmap_result many = fit_with(&input, &options, &parallel);
        CHECK(same_result(&one, &many));
        author_silmap_release(&one);
        author_silmap_release(&many);
        author_picture_release(&picture);
    }
    zt_threads_close(threads);
}

/* ---- kinds of pictures and filters ----------------------------------------------------------------------- */

/* Two colours, cut out by a disc: hard, or fading out over its outer half. */
static int soft_alpha;

static float cut_out(double x, double y, uint32_t channel) {
    double distance = hypot(x - 0.52, y - 0.47) / 0.36;
    if (channel == 3)
        return (float)(!soft_alpha ? distance < 1 : distance < 0.5 ? 1 : distance < 1 ? 2 - 2 * distance : 0);
    return x + 0.3 * y < 0.6 ? 0.9f : 0.2f * (float)channel;
}

static void test_alpha(void) {
    for (soft_alpha = 0; soft_alpha < 2; soft_alpha++) {
        author_picture picture = paint(EDGE, EDGE, 4, cut_out);
        author_silmap_result result = fit(&picture, CELLS, CELLS);
        CHECK(result.psnr >= result.bilinear_psnr + (soft_alpha ? 1 : 6));
        CHECK(result.cut_cells > 0);
        for (uint32_t s = 0; s < (CELLS + 1) * (CELLS + 1); s++)
            for (uint32_t ch = 0; ch < 4; ch++) {
                float v = result.samples.texels[4 * s + ch];
                CHECK(v >= 0 && v <= 1.0001f);
            }
        author_silmap_release(&result);
        author_picture_release(&picture);
    }
}

static void test_filters(void) {
    static const zt_silmap_filter filters[] = {ZT_SILMAP_CONTINUOUS, ZT_SILMAP_SEN2004, ZT_SILMAP_NEAREST};
    for (uint32_t i = 0; i < 12; i++) {
        uint32_t channels = 1 + i / 3;
        author_picture picture = paint(EDGE, EDGE, channels, i & 1 ? photograph : square);
        author_silmap_input input = {.picture = &picture};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS, .filter = filters[i % 3]};
        author_silmap_result result = fit_with(&input, &options, NULL);
        CHECK(result.psnr >= result.bilinear_psnr - 1e-9 || filters[i % 3] == ZT_SILMAP_NEAREST);
        CHECK(result.cut_cells > 0 || filters[i % 3] == ZT_SILMAP_NEAREST);
        CHECK(result.samples.channels == channels && result.minified.channels == channels);
        author_silmap_release(&result);
        author_picture_release(&picture);
    }
}

/* Where the texture repeats, an edge that leaves on one side and comes in on the other is one edge. */
static float across_seams(double x, double y, uint32_t channel) {
    double u = fmod(x + 0.47, 1) - 0.5, v = fmod(y + 0.55, 1) - 0.5;
    return hypot(u, v) < 0.3 ? 0.9f : 0.1f * (float)channel;
}

static void test_repeat(void) {
    author_picture picture = paint(EDGE, EDGE, 3, across_seams);
    double wrong[2];
    for (int repeat = 0; repeat < 2; repeat++) {
        author_silmap_input input = {.picture = &picture, .repeat_x = repeat, .repeat_y = repeat};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS};
        author_silmap_result result = fit_with(&input, &options, NULL);
        uint32_t seam = 0;
        for (uint32_t c = 0; c < CELLS; c++)
            seam += (result.cells[(size_t)c * CELLS] & ZT_SILMAP_WEST) != 0;
        CHECK(repeat ? seam == 2 : seam == 0);
        CHECK(result.samples.width == (uint32_t)(CELLS + !repeat) && result.samples.height == result.samples.width);
        wrong[repeat] = result.disagreement;
        CHECK(result.psnr > result.bilinear_psnr + 3);
        author_silmap_release(&result);
    }
    CHECK(wrong[1] < 2 * wrong[0] + 1e-4);
    author_picture_release(&picture);
}

static void test_too_small(void) {
    author_picture picture = paint(5, 3, 1, gradient);
    author_silmap_input input = {.picture = &picture};
    static const uint32_t sizes[][2] = {{6, 3}, {5, 4}, {0, 1}, {1, 0}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        author_silmap_options options = {.cells_x = sizes[i][0], .cells_y = sizes[i][1]};
        author_silmap_result result;
        author_run run = {0};
        CHECK(author_silmap_fit(&run, &input, &options, &result) == AUTHOR_BAD_INPUT);
        CHECK(strstr(run.error, "5 x 3") && !result.cells);
    }
    author_silmap_result result = fit(&picture, 5, 3);
    CHECK(result.cells_x == 5 && result.cells_y == 3);
    author_silmap_release(&result);
    author_picture_release(&picture);
}

/* Mixed as if drawn: paint takes one place a texel. */
static author_picture smooth(uint32_t edge, shade colour) {
    author_picture fine = paint(8 * edge, 8 * edge, 1, colour), picture;
    author_run run = {0};
    if (author_picture_create(&run, edge, edge, 1, &picture) != AUTHOR_OK)
        abort();
    for (size_t i = 0; i < (size_t)64 * edge * edge; i++)
        picture.texels[i / (8 * edge) / 8 * edge + i % (8 * edge) / 8] += fine.texels[i] / 64;
    author_picture_release(&fine);
    return picture;
}

/* ---- borders, and where a drawing lies -------------------------------------------------------------------- */

/* Mean distance of what cell (x, y) shows from the half plane; 0 where its edge does not pass. *soft gets the places
 * that show neither side. */
static double cell_error(const author_silmap_result *r, uint32_t x, uint32_t y, int *soft) {
    const int places = 37;
    zt_silmap_cell cell;
    double sum = 0, weights[4];
    int inside = 0;
    zt_silmap_cell_at(r->cells, CELLS, CELLS, 0, 0, x, y, &cell);
    for (int i = 0; i < places * places; i++) {
        double u = (i % places + 0.5) / places, v = (i / places + 0.5) / places, shown = 0;
        zt_silmap_weights(ZT_SILMAP_CONTINUOUS, &cell, zt_silmap_quadrant(&cell, u, v), u, v, weights);
        for (uint32_t k = 0; k < 4; k++)
            shown += weights[k] * (double)r->samples.texels[(y + k / 2) * (CELLS + 1) + x + k % 2];
        int wanted = in_half((x + u) / CELLS, (y + v) / CELLS);
        inside += wanted;
        *soft += shown > 0.05 && shown < 0.95;
        sum += fabs(shown - wanted);
    }
    return inside > 0 && inside < places * places ? sum / (places * places) : 0;
}

static float black_and_white(double x, double y, uint32_t channel) {
    (void)channel;
    return in_half(x, y) ? 1.0f : 0.0f;
}

/* An edge that leaves a texture that does not repeat is sharp to the last pixel, and held nearly as well as elsewhere:
 * its last piece is at right angles to the border (spec/silmap.md section 3), so that the point has to be near to
 * it. */
static void test_border(void) {
    double inner = 0, border = 0;
    int inner_count = 0, border_count = 0, soft = 0;
    for (int i = 0; i < 12; i++) {
        turn = 0.07 + 0.523 * i;
        author_picture picture = smooth(8 * CELLS, black_and_white);
        author_silmap_input input = {.picture = &picture};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS, .plain = 1};
        author_silmap_result result = fit_with(&input, &options, NULL);
        for (uint32_t c = 0; c < CELLS * CELLS; c++) {
            uint32_t x = c % CELLS, y = c / CELLS;
            int outer = x == 0 || y == 0 || x == CELLS - 1 || y == CELLS - 1;
            double error = cell_error(&result, x, y, &soft);
            if (!(error > 0))
                continue;
            *(outer ? &border : &inner) += error;
            *(outer ? &border_count : &inner_count) += 1;
        }
        author_silmap_release(&result);
        author_picture_release(&picture);
    }
    CHECK(border_count >= 24 && inner_count > 180);
    CHECK(soft == 0);
    CHECK(border / border_count <= 2 * inner / inner_count);
}

/* Only edges that are drawn are cut, and none is drawn. */
static void test_nothing_drawn(void) {
    static const shade pictures[] = {photograph, half_plane};
    for (int i = 0; i < 2; i++) {
        author_picture picture = paint(EDGE, EDGE, 3, pictures[i]);
        author_silmap_input input = {.picture = &picture, .paths_only = 1};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS};
        author_silmap_result result = fit_with(&input, &options, NULL);
        CHECK(result.cut_cells == 0);
        author_silmap_release(&result);
        author_picture_release(&picture);
    }
}

static author_silmap_place placed = {0, 0, 1, 1};

/* Two bars whose sides are where no points are. */
static float bars(double x, double y, uint32_t channel) {
    double u = (x - placed.x) / placed.width * CELLS, v = (y - placed.y) / placed.height * CELLS;
    (void)channel;
    return (u > 3.01 && u < 6.02 && v > 2.49) || (v > 9.26 && v < 12.99 && u > 3.01 && u < 12.77) ? 1.0f : 0.0f;
}

static int out_by_half_a_cell(double start, double size) {
    double most = 0.5 / CELLS + 1e-12;
    return start <= 0 && start >= -most && start + size >= 1 && start + size <= 1 + most;
}

/* The same place each time, not further off than is said, and worth it; what has no edges along the axes stays where it
 * is. */
static void test_hint(void) {
    author_run run = {0};
    author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS, .plain = 1};
    double wrong[2];
    for (int hinted = 0; hinted < 2; hinted++) {
        author_picture picture = smooth(16 * CELLS, bars);
        author_silmap_input input = {.picture = &picture};
        author_silmap_result result = fit_with(&input, &options, NULL);
        wrong[hinted] = result.disagreement;
        author_silmap_release(&result);
        author_silmap_place place, again;
        CHECK(author_silmap_hint(&run, &input, CELLS, CELLS, 1, &place) == AUTHOR_OK);
        CHECK(author_silmap_hint(&run, &input, CELLS, CELLS, 1, &again) == AUTHOR_OK);
        CHECK(memcmp(&place, &again, sizeof place) == 0);
        CHECK(out_by_half_a_cell(place.x, place.width) && out_by_half_a_cell(place.y, place.height));
        placed = place;
        author_picture_release(&picture);
    }
    CHECK(wrong[1] * 3 < wrong[0]);
    turn = 0.5;
    author_picture slanted = smooth(16 * CELLS, black_and_white);
    author_silmap_input flat = {.picture = &slanted};
    author_silmap_place place;
    CHECK(author_silmap_hint(&run, &flat, CELLS, CELLS, 1, &place) == AUTHOR_OK);
    CHECK(memcmp(&place, &(author_silmap_place){0, 0, 1, 1}, sizeof place) == 0);
    CHECK(author_silmap_hint(&run, &flat, 16 * CELLS + 1, 1, 1, &place) == AUTHOR_BAD_INPUT && run.error[0]);
    author_picture_release(&slanted);
}

static const double triangle_corners[] = {0.131, 0.107, 0.871, 0.263, 0.407, 0.873};

static float triangle(double x, double y, uint32_t channel) {
    const double *c = triangle_corners;
    double u = (x - placed.x) / placed.width, v = (y - placed.y) / placed.height;
    int inside = 1;
    (void)channel;
    for (int i = 0; i < 3; i++) {
        const double *a = c + 2 * i, *b = c + 2 * ((i + 1) % 3);
        inside = inside && (b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0]) > 0;
    }
    return inside ? 1.0f : 0.0f;
}

static double wrong_of_triangle(const author_run *run, author_silmap_place *place) {
    author_run own = *run;
    double corners[6];
    for (int i = 0; i < 6; i += 2) {
        corners[i] = placed.x + placed.width * triangle_corners[i];
        corners[i + 1] = placed.y + placed.height * triangle_corners[i + 1];
    }
    author_path path = {corners, 3, 1};
    author_picture picture = paint(EDGE, EDGE, 1, triangle);
    author_silmap_input input = {.picture = &picture, .paths = &path, .path_count = 1};
    author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS, .plain = 1};
    author_silmap_result result = fit_with(&input, &options, NULL);
    double wrong = result.disagreement;
    CHECK(author_silmap_hint(&own, &input, CELLS, CELLS, 1, place) == AUTHOR_OK);
    author_silmap_release(&result);
    author_picture_release(&picture);
    return wrong;
}

/* Of paths the area decides, and none of them is along an axis here; with threads as without. */
static void test_hint_of_paths(void) {
    zt_threads *threads = NULL;
    CHECK(zt_threads_open(3, &threads) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(threads);
    author_silmap_place place, again;
    placed = (author_silmap_place){0, 0, 1, 1};
    double wrong = wrong_of_triangle(&(author_run){0}, &place);
    wrong_of_triangle(&(author_run){.parallel = &parallel}, &again);
    CHECK(memcmp(&place, &again, sizeof place) == 0);
    CHECK(out_by_half_a_cell(place.x, place.width) && out_by_half_a_cell(place.y, place.height));
    placed = place;
    CHECK(wrong_of_triangle(&(author_run){0}, &again) < wrong);
    zt_threads_close(threads);
}

/* Of one channel the area counts, unless it is equal; of colours the PSNR. */
static void test_better(void) {
    author_silmap_result a = {.samples = {.channels = 1}, .psnr = 20, .disagreement = 0.01}, b = a;
    CHECK(!author_silmap_is_better(&a, &b) && !author_silmap_is_better(&b, &a));
    b.disagreement = 0.02;
    b.psnr = 30;
    CHECK(author_silmap_is_better(&a, &b) && !author_silmap_is_better(&b, &a));
    a.samples.channels = b.samples.channels = 3;
    CHECK(author_silmap_is_better(&b, &a) && !author_silmap_is_better(&a, &b));
    a.samples.channels = b.samples.channels = 1;
    a.disagreement = b.disagreement = 0;
    CHECK(author_silmap_is_better(&b, &a) && !author_silmap_is_better(&a, &b));
    b.psnr = INFINITY;
    CHECK(author_silmap_is_better(&b, &a));
}

/* ---- progress ------------------------------------------------------------------------------------------- */

static int note_progress(void *user, const char *stage, double done) {
    double *last = user;
    CHECK(stage && done >= *last && done <= 1);
    *last = done;
    return 0;
}

static int stop_soon(void *user, const char *stage, double done) {
    int *left = user;
    (void)stage, (void)done;
    return --*left == 0;
}

static void test_progress(void) {
    static const shade pictures[] = {photograph, half_plane};
    for (size_t i = 0; i < 4; i++) {
        author_picture picture = paint(EDGE, EDGE, 3, pictures[i & 1]);
        author_silmap_input input = {.picture = &picture};
        author_silmap_options options = {.cells_x = CELLS, .cells_y = CELLS, .quality = i > 1 ? 15 : 0};
        author_silmap_result result;
        double last = 0;
        author_run run = {.progress = note_progress, .user = &last};
        CHECK(author_silmap_fit(&run, &input, &options, &result) == AUTHOR_OK);
        CHECK(last > 0.25);
        author_silmap_release(&result);
        int left = 20;
        run = (author_run){.progress = stop_soon, .user = &left};
        CHECK(author_silmap_fit(&run, &input, &options, &result) == AUTHOR_CANCELLED);
        CHECK(run.error[0] && !result.cells);
        author_picture_release(&picture);
    }
}

/* The grid that is found reaches the quality; no grid, a text that says so. */
static void test_quality(void) {
    author_picture picture = paint(EDGE, EDGE / 2, 3, half_plane);
    author_silmap_input input = {.picture = &picture};
    author_silmap_options options = {.quality = 25};
    author_silmap_result result = fit_with(&input, &options, NULL);
    CHECK(result.psnr >= 25);
    CHECK(result.cells_x <= EDGE / 2 && result.cells_y == (result.cells_x + 1) / 2);
    author_silmap_release(&result);
    options.quality = 99;
    options.cells_x = options.cells_y = 3;
    author_run run = {0};
    CHECK(author_silmap_fit(&run, &input, &options, &result) == AUTHOR_BAD_INPUT);
    CHECK(run.error[0] && !result.cells && !result.samples.texels);
    author_picture_release(&picture);
}

int main(void) {
    author_random_seed(&chance, 7, 1);
    test_half_planes();
    test_square();
    test_gradient();
    test_thin_line();
    test_photograph();
    test_noise();
    test_threads();
    test_alpha();
    test_filters();
    test_repeat();
    test_too_small();
    test_border();
    test_nothing_drawn();
    test_hint();
    test_hint_of_paths();
    test_better();
    test_progress();
    test_quality();
    return failures != 0;
}
