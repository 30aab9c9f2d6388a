/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: the patch grid loses nothing and costs what overlaps. For any point the list of its cell holds every patch
 * that covers the point, front to back; lists stay about as long as the true overlap; and the grid's size is bounded.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "zipmap_payload.h"

static bool covers(const double m[9], double u, double v) {
    double w = m[6] * u + m[7] * v + m[8];
    double x = (m[0] * u + m[1] * v + m[2]) / w;
    double y = (m[3] * u + m[4] * v + m[5]) / w;
    return w > 0 && x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

/* Root to patch: a turned rectangle about (cx, cy), with a little perspective. */
static void place(double m[9], double cx, double cy, double width, double height, double angle, double tilt) {
    double c = cos(angle), s = sin(angle);
    double to_centre[9] = {c / width, s / width, 0, -s / height, c / height, 0, 0, 0, 1};
    to_centre[6] = tilt * (to_centre[0] + to_centre[3]); /* in the patch's frame: w stays positive over it */
    to_centre[7] = tilt * (to_centre[1] + to_centre[4]);
    double shift[9] = {1, 0, -cx, 0, 1, -cy, 0, 0, 1};
    double to_unit[9] = {1, 0, 0.5, 0, 1, 0.5, 0, 0, 1};
    double part[9];
    zt__multiply(to_centre, shift, part);
    zt__multiply(to_unit, part, m);
}

typedef struct figures {
    double listed, covering; /* mean over random points */
} figures;

/* Checks the grid of z against brute force. around: points are taken near patches too. */
static figures check_grid(zt__memory *memory, const zt__zipmap *z, uint32_t points, uint64_t seed) {
    zt__patch_grid *g;
    figures f = {0, 0};
    CHECK(zt__build_patch_grid(memory, z, NULL, &g) == ZT_OK);
    CHECK(g->patches.count <= 200 * (uint64_t)z->patch_count + 64);
    CHECK(g->cells.count <= 200 * (uint64_t)z->patch_count + 64);
    for (uint32_t n = 0; n < points; n++) {
        double u = test_uniform(&seed, 0, 1), v = test_uniform(&seed, 0, 1);
        if (n % 16 == 0)
            u = (double)test_below(&seed, 2);
        if (n % 16 == 1)
            v = (double)test_below(&seed, 2);
        if (n % 3 == 0 && z->patch_count > 1) { /* a corner or a point within some patch */
            double a[9];
            zt__adjugate(z->composed[1 + test_below(&seed, z->patch_count - 1)], a);
            double x = n % 2 ? test_uniform(&seed, 0, 1) : test_below(&seed, 2);
            double y = n % 2 ? test_uniform(&seed, 0, 1) : test_below(&seed, 2);
            double w = a[6] * x + a[7] * y + a[8];
            u = fmin(1, fmax(0, (a[0] * x + a[1] * y + a[2]) / w));
            v = fmin(1, fmax(0, (a[3] * x + a[4] * y + a[5]) / w));
        }
        const uint32_t *list;
        uint32_t count = zt__patches_at(g, u, v, &list);
        uint32_t at = 0;
        CHECK(count <= g->longest);
        for (uint32_t k = 1; k < count; k++)
            CHECK(list[k] < list[k - 1]);
        CHECK(count == 0 || list[count - 1] > 0);
        for (uint32_t i = z->patch_count - 1; i > 0; i--) {
            if (!covers(z->composed[i], u, v))
                continue;
            while (at < count && list[at] > i)
                at++;
            CHECK(at < count && list[at] == i);
            f.covering += 1.0 / points;
        }
        f.listed += (double)count / points;
    }
    zt__free_patch_grid(memory, g);
    return f;
}

static zt__zipmap *make(zt__memory *memory, uint32_t count) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    zt__zipmap *z;
    CHECK(zt__zipmap_new(memory, count, 1, NULL, &z) == ZT_OK);
    for (uint32_t i = 0; i < count; i++)
        memcpy(z->composed[i], identity, sizeof identity);
    return z;
}

/* Patches of one size scattered over the square; size such that `overlap` of them cover a point. */
static void check_scattered(zt__memory *memory, uint32_t count, double overlap) {
    uint64_t seed = count;
    zt__zipmap *z = make(memory, count);
    double edge = sqrt(overlap / count);
    for (uint32_t i = 1; i < count; i++)
        place(z->composed[i], test_uniform(&seed, 0, 1), test_uniform(&seed, 0, 1), edge, edge,
              test_uniform(&seed, -0.2, 0.2), test_uniform(&seed, -0.1, 0.1));
    figures f = check_grid(memory, z, 2000, seed);
    printf("%u patches, overlap %.1f: lists of %.2f\n", count, f.covering, f.listed);
    CHECK(f.listed <= 2.5 * f.covering + 2);
    zt__free(memory, z, 1, (size_t)z->block_size);
}

/* Sizes over many orders, mirrored, outside, thin, and tiny ones in one place. */
static void check_mixed(zt__memory *memory, uint32_t count, uint64_t seed) {
    zt__zipmap *z = make(memory, count);
    for (uint32_t i = 1; i < count; i++) {
        double width = pow(10, test_uniform(&seed, -7, 0.5));
        double height = pow(10, test_uniform(&seed, -7, 0.5)) * (i % 4 == 0 ? -1 : 1);
        if (i % 3 == 0)
            place(z->composed[i], 0.3, 0.7, width, width, 0.1, 0);
        else
            place(z->composed[i], test_uniform(&seed, -0.5, 1.5), test_uniform(&seed, -0.5, 1.5), width, height,
                  test_uniform(&seed, -3, 3), test_uniform(&seed, -0.2, 0.2));
    }
    check_grid(memory, z, 3000, seed);
    zt__free(memory, z, 1, (size_t)z->block_size);
}

/* Crowds at three scales, a few patches over all: what a heap of photographs of one detail makes. */
static void check_crowds(zt__memory *memory) {
    uint64_t seed = 99;
    zt__zipmap *z = make(memory, 10001);
    for (uint32_t i = 1; i < 10001; i++) {
        double spread = i % 100 == 0 ? 1 : i % 10 == 0 ? 1e-3 : 1e-6;
        double edge = spread * sqrt(3.0 / (i % 100 == 0 ? 100 : i % 10 == 0 ? 900 : 9000));
        place(z->composed[i], 0.4 + spread * test_uniform(&seed, -0.4, 0.6),
              0.4 + spread * test_uniform(&seed, -0.4, 0.6), edge, edge, test_uniform(&seed, -0.2, 0.2), 0);
    }
    figures f = check_grid(memory, z, 3000, seed);
    printf("10000 patches in crowds of three scales: overlap %.2f, lists of %.2f\n", f.covering, f.listed);
    CHECK(f.listed <= 3 * f.covering + 4);
    zt__free(memory, z, 1, (size_t)z->block_size);
}

/* All over each other, and all in a corner far from the rest of the square. */
static void check_extremes(zt__memory *memory) {
    uint64_t seed = 77;
    zt__zipmap *z = make(memory, 1000);
    check_grid(memory, z, 200, seed); /* each covers all */
    for (uint32_t i = 1; i < 1000; i++)
        place(z->composed[i], 0.25 + test_uniform(&seed, 0, 1e-6), 0.75 + test_uniform(&seed, 0, 1e-6), 1e-7, 1e-7, 0,
              0);
    figures f = check_grid(memory, z, 2000, seed);
    printf("1000 patches in a corner of 1e-6: overlap %.2f, lists of %.2f\n", f.covering, f.listed);
    CHECK(f.listed < 40);
    for (uint32_t i = 1; i < 1000; i++)
        place(z->composed[i], 3, 3, 1, 1, 0, 0);
    check_grid(memory, z, 100, seed); /* none is inside */
    zt__free(memory, z, 1, (size_t)z->block_size);
    z = make(memory, 1);
    check_grid(memory, z, 100, seed);
    zt__free(memory, z, 1, (size_t)z->block_size);
}

static const zt__image_record any_image = {.format = 43, .depth = 1, .layers = 1, .alpha_mode = 1};

static const zt__image_record *image_of(const void *user, uint32_t image) {
    (void)user;
    return image == 0 ? &any_image : NULL;
}

static uint32_t texture_layers(const void *user, uint32_t texture) {
    (void)user;
    (void)texture;
    return 1;
}

/* Entries over many orders: those matrices that the rules let pass, however close to singular. */
static void check_degenerate(zt__memory *memory) {
    static const double decades[] = {1, 3, 12, 150};
    const zt__payload_scope scope = {
        .layer_count = 1, .image_count = 1, .image_of = image_of, .texture_layers = texture_layers};
    uint64_t seed = 123;
    uint32_t passed = 0;
    for (uint32_t round = 0; round < 20000; round++) {
        zt__sink sink = {0};
        zt__zipmap *z = make(memory, 3);
        memcpy(z->matrices[0], z->composed[0], sizeof z->composed[0]);
        for (uint32_t i = 0; i < 3; i++) {
            z->parents[i] = i / 2;
            z->masks[i] = ZT_NONE;
            for (uint32_t k = 0; k < 9 && i > 0; k++) {
                double size = pow(10, test_uniform(&seed, -1, 1) * decades[round % 4]);
                uint32_t sign = test_below(&seed, 5);
                z->matrices[i][k] = sign == 0 ? 0 : sign < 3 ? size : -size;
            }
        }
        if (zt__check_zipmap(&sink, z, &scope, 0) == ZT_OK) {
            check_grid(memory, z, 40, seed + round);
            passed++;
        }
        zt__free(memory, z, 1, (size_t)z->block_size);
    }
    CHECK(passed > 500);
}

int main(void) {
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    check_scattered(&memory, 31, 3);
    check_scattered(&memory, 1000, 3);
    check_scattered(&memory, 10001, 3);
    check_scattered(&memory, 10001, 20);
    for (uint64_t seed = 1; seed <= 10; seed++)
        check_mixed(&memory, 30 * (uint32_t)seed * (uint32_t)seed, seed);
    check_crowds(&memory);
    check_extremes(&memory);
    check_degenerate(&memory);
    CHECK(memory.used == 0);
    return test_end();
}
