/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rays agree with conformance/valid/rays.json, which the reference reader computed from the specification alone: what
 * they hit, where, its colour and its normal.
 */
#include <math.h>

#include "corpus.h"
#include "test.h"

static char name[256];
static uint32_t texture, rays, hits;

static bool near_by(double got, double expected) {
    return fabs(got - expected) <= 4e-6 * fmax(1.0, fabs(expected));
}

static bool same_hit(const char *line, const zt_hit *got) {
    double rgba[4], normal[3];
    uint32_t umbrella = (uint32_t)real_of(line, "umbrella");
    if (real_of(line, "umbrella") < 0)
        umbrella = ZT_NONE;
    numbers_of(value_of(line, "rgba"), rgba, 4);
    numbers_of(value_of(line, "normal"), normal, 3);
    bool same = got->kind == (zt_hit_kind)number_of(line, "kind") && got->umbrella == umbrella;
    for (int k = 0; k < 4; k++)
        same &= near_by((double)got->rgba[k], rgba[k]);
    if (got->kind != ZT_HIT_UMBRELLA)
        return same;
    for (int k = 0; k < 3; k++)
        same &= near_by((double)got->normal[k], normal[k]);
    return same && near_by((double)got->t, real_of(line, "t"));
}

static void test_ray(const char *line) {
    zt_diag diag;
    zt_hit hit;
    zt_sampler *sampler;
    zt_sampler_options options = {0};
    light_of(line, &options);
    zt_ray ray = {.u0 = real_of(line, "u0"),
                  .v0 = real_of(line, "v0"),
                  .z0 = real_of(line, "z0"),
                  .u1 = real_of(line, "u1"),
                  .v1 = real_of(line, "v1"),
                  .z1 = real_of(line, "z1"),
                  .footprint0 = real_of(line, "footprint0"),
                  .footprint1 = real_of(line, "footprint1")};
    CHECK(zt_sampler_open(valid_file(name), texture, &options, &diag, &sampler) == ZT_OK);
    CHECK(zt_sample_rays(sampler, &ray, 1, &hit, &diag) == ZT_OK);
    zt_sampler_close(sampler);
    bool same = same_hit(line, &hit);
    CHECK(same);
    if (!same)
        fprintf(stderr, "%s: %s  gives kind %d, umbrella %d, t %.8g, %.8g %.8g %.8g %.8g, normal %.8g %.8g %.8g\n",
                name, line, (int)hit.kind, (int)hit.umbrella, (double)hit.t, (double)hit.rgba[0], (double)hit.rgba[1],
                (double)hit.rgba[2], (double)hit.rgba[3], (double)hit.normal[0], (double)hit.normal[1],
                (double)hit.normal[2]);
    rays++;
    hits += hit.kind == ZT_HIT_UMBRELLA;
}

/* A line begins a file, or is a ray of the last one. */
static void test_line(const char *line) {
    if (value_of(line, "u0"))
        test_ray(line);
    if (!value_of(line, "file"))
        return;
    string_of(line, "file", name, sizeof name);
    texture = number_of(line, "texture");
}

int main(void) {
    each_line_with(VALID_FOLDER "rays.json", NULL, test_line);
    valid_file("");
    CHECK(rays > 300 && hits > 100);
    printf("%u rays, %u hit an umbrella\n", rays, hits);
    return test_end();
}
