/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lookups agree with conformance/valid/lookups.json, which the reference sampler computed from the specification alone:
 * every kind of texture, filter and frame. A sampler that only agrees with itself may have misread the text.
 */
#include <math.h>

#include "corpus.h"
#include "test.h"

enum { MOST_LAYERS = 32 };

static uint32_t lookups;

static zt_filter filter_of(const char *line) {
    char text[32];
    string_of(line, "filter", text, sizeof text);
    return text[0] == 't' ? ZT_FILTER_TRILINEAR : text[0] == 'b' ? ZT_FILTER_BILINEAR : ZT_FILTER_NEAREST;
}

static void compare(const char *line, const float *got, const double *expected) {
    bool same = true;
    for (int k = 0; k < 4; k++)
        same &= fabs((double)got[k] - expected[k]) <= 2e-6 * fmax(1.0, fabs(expected[k]));
    CHECK(same);
    if (!same)
        fprintf(stderr, "%.200s\n  gives %.8g %.8g %.8g %.8g\n", line, (double)got[0], (double)got[1], (double)got[2],
                (double)got[3]);
}

static void test_lookup(const char *line) {
    char name[256];
    double at[6], expected[4];
    zt_texture_info info;
    zt_diag diag;
    float got[4];
    string_of(line, "file", name, sizeof name);
    const zt_file *file = valid_file(name);
    uint32_t texture = number_of(line, "texture");
    CHECK(zt_get_texture(file, texture, &info) == ZT_OK);
    numbers_of(value_of(line, "at"), at, 6);
    const char *layers = value_of(line, "layers");
    zt_point point = {.u = at[0],
                      .v = at[1],
                      .du_dx = at[2],
                      .du_dy = at[3],
                      .dv_dx = at[4],
                      .dv_dy = at[5],
                      .array_layer = number_of(line, "frame")};
    for (uint32_t layer = 0; layer < info.layer_count; layer++) {
        zt_sampler_options options = {.filter = filter_of(line), .layer = layer};
        light_of(line, &options);
        zt_sampler *sampler;
        layers = numbers_of(layers + strspn(layers, "[], "), expected, 4);
        CHECK(zt_sampler_open(file, texture, &options, &diag, &sampler) == ZT_OK);
        CHECK(zt_sample(sampler, &point, 1, got, &diag) == ZT_OK);
        compare(line, got, expected);
        zt_sampler_close(sampler);
        lookups++;
    }
}

int main(void) {
    uint32_t entries = each_line(VALID_FOLDER "lookups.json", test_lookup);
    valid_file("");
    CHECK(entries > 1000);
    printf("%u entries, %u lookups\n", entries, lookups);
    return test_end();
}
