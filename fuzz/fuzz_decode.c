/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decoding: a tile decodes exactly when the validator finds nothing wrong with it; regions give the texels that their
 * level gives; a sampler answers any coordinates. All within the limit of memory.
 */
#include <math.h>
#include <stdbool.h>

#include "support.h"

enum { MOST_TILES = 4096, MOST_BYTES = 1 << 22, MOST_LEVEL = 1 << 20, REGIONS = 3, POINTS = 12 };

typedef struct run {
    const zt_file *file;
    uint64_t size; /* of the file */
    fuzz_random random;
    uint64_t bytes; /* decoded so far */
    bool whole;     /* every tile has been decoded or tried */
    bool damaged;   /* one could not be */
} run;

/* ---- tiles ---- */

static void decode_tile(run *r, uint32_t image, uint32_t level, uint64_t tile) {
    zt_tile_info info;
    zt_diag diag;
    zt_result result = zt_get_tile(r->file, image, level, tile, &info, &diag);
    fuzz_require_diag(&diag, result, r->size);
    if (result != ZT_OK) {
        r->damaged = true;
        return;
    }
    uint8_t *decoded = fuzz_malloc(info.decoded_size), *stored = fuzz_malloc(info.stored_size);
    result = zt_decode_tile(r->file, image, level, tile, decoded, info.decoded_size, &diag);
    fuzz_require_diag(&diag, result, r->size);
    REQUIRE(zt_read_tile(r->file, image, level, tile, stored, info.stored_size, &diag) == ZT_OK);
    REQUIRE(zt_decode_tile(r->file, image, level, tile, decoded, info.decoded_size - 1u, &diag) == ZT_BAD_ARGUMENT);
    r->damaged |= result != ZT_OK;
    r->bytes += info.decoded_size;
    free(decoded);
    free(stored);
}

static void decode_tiles(run *r, uint32_t image, const zt_image_info *im) {
    zt_level_info level;
    for (uint32_t k = 0; k < im->levels && k <= im->tail_level; k++) {
        REQUIRE(zt_get_level(r->file, image, k, &level) == ZT_OK);
        for (uint64_t tile = 0; tile < level.tile_count; tile++) {
            if (r->bytes > MOST_BYTES || tile == MOST_TILES) {
                r->whole = false;
                return;
            }
            decode_tile(r, image, k, tile);
        }
    }
}

/* ---- levels and regions ---- */

static uint32_t multiple_below(fuzz_random *random, uint32_t edge, uint32_t block) {
    uint32_t blocks = (edge + block - 1) / block;
    return fuzz_below(random, blocks) * block;
}

static uint32_t length_from(fuzz_random *random, uint32_t first, uint32_t edge, uint32_t block) {
    uint32_t blocks = (edge - first + block - 1) / block, length = (1 + fuzz_below(random, blocks)) * block;
    return length < edge - first ? length : edge - first;
}

static void compare_region(const zt_region *region, const zt_image_info *im, const zt_level_info *level,
                           const uint8_t *whole, const uint8_t *part, size_t pitch, size_t slice_pitch) {
    uint32_t x = region->x / im->block_width, y = region->y / im->block_height;
    uint32_t width = (region->width + im->block_width - 1u) / im->block_width;
    uint32_t height = (region->height + im->block_height - 1u) / im->block_height;
    for (uint32_t z = 0; z < region->depth; z++) {
        for (uint32_t row = 0; row < height; row++) {
            const uint8_t *from = whole + (region->z + z) * level->slice_size + (y + row) * level->row_size;
            REQUIRE(memcmp(from + (size_t)x * im->block_bytes, part + z * slice_pitch + row * pitch,
                           (size_t)width * im->block_bytes) == 0);
        }
    }
}

static void decode_region(run *r, uint32_t image, const zt_image_info *im, uint32_t k, uint32_t layer,
                          const uint8_t *whole) {
    zt_level_info level;
    zt_diag diag;
    zt_region region = {.level = k, .layer = layer};
    REQUIRE(zt_get_level(r->file, image, k, &level) == ZT_OK);
    region.x = multiple_below(&r->random, level.width, im->block_width);
    region.y = multiple_below(&r->random, level.height, im->block_height);
    region.z = fuzz_below(&r->random, level.depth);
    region.width = length_from(&r->random, region.x, level.width, im->block_width);
    region.height = length_from(&r->random, region.y, level.height, im->block_height);
    region.depth = 1 + fuzz_below(&r->random, level.depth - region.z);
    size_t row = (size_t)((region.width + im->block_width - 1u) / im->block_width) * im->block_bytes;
    size_t rows = (region.height + im->block_height - 1u) / im->block_height;
    size_t pitch = row + fuzz_below(&r->random, 2) * (size_t)fuzz_below(&r->random, 9);
    size_t slice_pitch = pitch * rows + fuzz_below(&r->random, 2) * (size_t)5;
    size_t need = (region.depth - 1u) * slice_pitch + (rows - 1) * pitch + row;
    uint8_t *part = fuzz_malloc(need);
    zt_result result = zt_decode_region(r->file, image, &region, part, need, pitch, slice_pitch, NULL, &diag);
    fuzz_require_diag(&diag, result, r->size);
    REQUIRE(!whole || result == ZT_OK);
    if (whole)
        compare_region(&region, im, &level, whole, part, pitch, slice_pitch);
    REQUIRE(zt_decode_region(r->file, image, &region, part, need - 1, pitch, slice_pitch, NULL, &diag) ==
            ZT_BAD_ARGUMENT);
    free(part);
}

static void decode_levels(run *r, uint32_t image, const zt_image_info *im) {
    zt_level_info level;
    zt_diag diag;
    for (uint32_t k = 0; k < im->levels && r->bytes <= MOST_BYTES; k++) {
        REQUIRE(zt_get_level(r->file, image, k, &level) == ZT_OK);
        if (level.layer_size > MOST_LEVEL)
            continue;
        size_t size = (size_t)level.layer_size;
        uint32_t layer = fuzz_below(&r->random, im->layers);
        uint8_t *whole = fuzz_malloc(size);
        zt_result result = zt_decode_level(r->file, image, k, layer, whole, size, 0, NULL, &diag);
        fuzz_require_diag(&diag, result, r->size);
        REQUIRE(result == ZT_OK || r->damaged || !r->whole || result == ZT_LIMIT);
        for (int i = 0; i < REGIONS; i++)
            decode_region(r, image, im, k, layer, result == ZT_OK ? whole : NULL);
        r->bytes += size;
        free(whole);
    }
}

/* ---- sampling ---- */

static double coordinate(fuzz_random *random) {
    static const double special[] = {0,   1,    -0.0,   0.5,     1e300,  -1e300,  1e-300,   5e-324,    1 - 0x1p-53,
                                     1e9, -1e9, 0x1p53, -0x1p31, 0x1p62, -0x1p64, INFINITY, -INFINITY, NAN};
    if (fuzz_below(random, 3) == 0)
        return special[fuzz_below(random, sizeof special / sizeof *special)];
    return (double)(fuzz_next(random) >> 11) * 0x1p-53 * 3 - 1;
}

static double derivative(fuzz_random *random) {
    return fuzz_below(random, 4) ? ldexp((double)fuzz_below(random, 1000) - 500, -(int)fuzz_below(random, 20))
                                 : coordinate(random);
}

static void sample_points(run *r, const zt_sampler *sampler) {
    zt_point points[POINTS];
    float out[4 * POINTS];
    zt_diag diag;
    zt_sampler_info info;
    for (int i = 0; i < POINTS; i++) {
        zt_point *p = &points[i];
        double *fields[] = {&p->u, &p->v, &p->w};
        double *changes[] = {&p->du_dx, &p->dv_dx, &p->dw_dx, &p->du_dy, &p->dv_dy, &p->dw_dy};
        for (int k = 0; k < 3; k++)
            *fields[k] = coordinate(&r->random);
        for (int k = 0; k < 6; k++)
            *changes[k] = derivative(&r->random);
        p->array_layer = fuzz_below(&r->random, 4) ? fuzz_below(&r->random, 3) : UINT32_MAX;
    }
    zt_result result = zt_sample(sampler, points, POINTS, out, &diag);
    fuzz_require_diag(&diag, result, r->size);
    zt_get_sampler(sampler, &info);
    for (int i = 0; i < POINTS && result == ZT_OK; i++) {
        if (!isfinite(points[i].u) || !isfinite(points[i].v))
            REQUIRE(out[4 * i] == 0 && out[4 * i + 1] == 0 && out[4 * i + 2] == 0 && out[4 * i + 3] == 0);
    }
}

/* Seldom anything: a ray across a million repeats of a texture takes its time. */
static zt_ray any_ray(fuzz_random *random) {
    bool wild = fuzz_below(random, 256) == 0;
    zt_ray ray;
    double *fields[] = {&ray.u0, &ray.v0, &ray.z0, &ray.footprint0, &ray.u1, &ray.v1, &ray.z1, &ray.footprint1};
    for (int k = 0; k < 8; k++)
        *fields[k] = wild ? coordinate(random) : (double)fuzz_below(random, 1 << 20) * 0x1p-19 - (k % 4 < 2 ? 0.5 : 0);
    ray.z1 = fuzz_below(random, 2) ? 0 : ray.z1;
    ray.footprint1 *= fuzz_below(random, 2) ? 0.0625 : 1; /* the taper ends at 1/8 */
    ray.footprint0 *= 0.03125;
    return ray;
}

/* Rays through umbrellas: any is answered with what there is. */
static void sample_rays(run *r, const zt_sampler *sampler, uint32_t texture) {
    zt_ray rays[POINTS];
    zt_hit hits[POINTS];
    zt_diag diag;
    zt_umbrella_info info;
    bool umbrellas = zt_get_umbrellas(r->file, texture, &info) == ZT_OK;
    for (int i = 0; i < POINTS; i++)
        rays[i] = any_ray(&r->random);
    zt_result result = zt_sample_rays(sampler, rays, POINTS, hits, &diag);
    fuzz_require_diag(&diag, result, r->size);
    REQUIRE(umbrellas == (result != ZT_BAD_ARGUMENT));
    for (int i = 0; i < POINTS && result == ZT_OK; i++) {
        REQUIRE(hits[i].kind <= ZT_HIT_BACKGROUND);
        REQUIRE((hits[i].kind == ZT_HIT_UMBRELLA) == (hits[i].umbrella != ZT_NONE));
        REQUIRE(hits[i].umbrella == ZT_NONE || hits[i].umbrella < info.levels[0].umbrella_count);
    }
}

static void sample_texture(run *r, uint32_t texture, uint32_t layer_count) {
    zt_sampler *sampler;
    zt_diag diag;
    zt_sampler_options options = {.filter = (zt_filter)fuzz_below(&r->random, 3),
                                  .layer = fuzz_below(&r->random, layer_count),
                                  .first_patch_only = fuzz_below(&r->random, 8) == 0};
    if (options.filter == ZT_FILTER_TRILINEAR)
        options.max_anisotropy = fuzz_below(&r->random, 17);
    if (fuzz_below(&r->random, 4) == 0) {
        options.light_x = fuzz_below(&r->random, 1000) / 100.0 - 5;
        options.light_y = fuzz_below(&r->random, 1000) / 100.0 - 5;
        options.shadow = 0.5;
    }
    zt_result result = zt_sampler_open(r->file, texture, &options, &diag, &sampler);
    fuzz_require_diag(&diag, result, r->size);
    REQUIRE((result == ZT_OK) == (sampler != NULL));
    REQUIRE(result != ZT_BAD_ARGUMENT);
    if (sampler) {
        sample_points(r, sampler);
        sample_rays(r, sampler, texture);
    }
    zt_sampler_close(sampler);
}

/* ---- the target ---- */

static void visit(run *r) {
    zt_file_info info;
    zt_image_info image;
    zt_texture_info texture;
    zt_get_file(r->file, &info);
    for (uint32_t i = 0; i < info.image_count; i++) {
        REQUIRE(zt_get_image(r->file, i, &image) == ZT_OK);
        decode_tiles(r, i, &image);
    }
    r->bytes = 0;
    for (uint32_t i = 0; i < info.image_count && i < 64; i++) {
        REQUIRE(zt_get_image(r->file, i, &image) == ZT_OK);
        decode_levels(r, i, &image);
    }
    for (uint32_t i = 0; i < info.texture_count && i < 16; i++) {
        REQUIRE(zt_get_texture(r->file, i, &texture) == ZT_OK);
        sample_texture(r, i, texture.layer_count);
    }
}

static int on_finding(void *user, const zt_finding *finding) {
    bool *texels = user;
    REQUIRE(finding->path && finding->text && finding->text[0] && zt_find_rule(finding->rule));
    *texels |= strncmp(finding->path, "TEXL/image", 10) == 0;
    return 0;
}

/* Whether the validator finds something wrong with a tile or a tile index. */
static zt_result check(const uint8_t *data, size_t size, const zt_limits *limits, bool *texels,
                       zt_check_summary *summary) {
    fuzz_memory memory;
    zt_diag diag;
    *texels = false;
    fuzz_memory_init(&memory, limits->memory);
    zt_check_options options = {
        .allocator = &memory.allocator, .limits = limits, .user = texels, .finding = on_finding};
    zt_result result = zt_check_memory(data, size, &options, &diag, summary);
    fuzz_require_diag(&diag, result, size);
    REQUIRE(memory.live == 0);
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    zt_limits limits = fuzz_limits();
    fuzz_memory memory;
    zt_file *file = NULL;
    zt_check_summary summary;
    bool texels;
    uint8_t *copy = fuzz_copy(data, size);
    fuzz_memory_init(&memory, limits.memory);
    zt_open_options options = {.allocator = &memory.allocator, .limits = &limits};
    if (zt_open_memory(copy, size, &options, NULL, &file) == ZT_OK) {
        run r = {.file = file, .size = size, .random = fuzz_random_of(data, size), .whole = true};
        visit(&r);
        zt_result checked = check(copy, size, &limits, &texels, &summary);
        if (checked == ZT_OK && r.whole)
            REQUIRE(texels == r.damaged);
        REQUIRE(checked != ZT_OK || summary.errors > 0 || summary.limits > 0 || !r.damaged);
    }
    zt_close(file);
    REQUIRE(memory.live == 0);
    free(copy);
    return 0;
}
