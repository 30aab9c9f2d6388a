/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Question: can an image larger than memory be written with all its levels, and read by region, in bounded memory?
 * Writes a square RGBA8 image (default 32768 x 32768, a gigatexel) of synthetic terrain in strips, checks and reads
 * 1000 regions at random levels, and prints times and the peak of resident memory.
 *
 * usage: bench_gigatexel [EDGE] [FILE]     FILE is removed at the end unless it was named
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <zt/zt_write.h>

enum { STRIP = 256, REGION = 512, REGIONS = 1000 };

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double peak_mib(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static int fail(const char *what, const zt_diag *diag) {
    fprintf(stderr, "%s: %s\n", what, diag->text);
    return 1;
}

/* Slopes with a little noise: what a compressor meets in an aerial picture. The texel is a function of its place, so
 * that what is read can be compared. */
static void texel(uint32_t x, uint32_t y, unsigned char *out) {
    uint32_t noise = (x * 2654435761u ^ y * 2246822519u) * 3266489917u >> 29;
    out[0] = (unsigned char)((x >> 4 ^ y >> 5) + noise);
    out[1] = (unsigned char)((x >> 3) + (y >> 4) + noise);
    out[2] = (unsigned char)((y >> 3) + noise);
    out[3] = 255;
}

static int write_image(const char *path, uint32_t edge, const zt_parallel *parallel) {
    zt_diag diag = {0};
    zt_writer *writer;
    zt_writer_options options = {.parallel = parallel, .effort = 1, .flags = ZT_WRITE_NO_FSYNC};
    zt_image_desc desc = {
        .format = 43, .width = edge, .height = edge, .wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP};
    uint32_t image;
    size_t pitch = (size_t)edge * 4;
    unsigned char *strip = malloc(pitch * STRIP);
    if (!strip)
        return 1;
    zt_result result = zt_writer_open_path(path, &options, &diag, &writer);
    if (result == ZT_OK)
        result = zt_writer_add_image(writer, &desc, &diag, &image);
    for (uint32_t y = 0; result == ZT_OK && y < edge; y += STRIP) {
        uint32_t rows = edge - y < STRIP ? edge - y : STRIP;
        for (uint32_t r = 0; r < rows; r++) {
            for (uint32_t x = 0; x < edge; x++)
                texel(x, y + r, strip + r * pitch + (size_t)x * 4);
        }
        result = zt_writer_put_rows(writer, image, strip, rows, pitch, &diag);
    }
    if (result == ZT_OK)
        result = zt_writer_add_texture(writer, &(zt_texture_desc){.name = "terrain", .image = image}, &diag, NULL);
    if (result == ZT_OK)
        result = zt_writer_finish(writer, &diag);
    zt_writer_close(writer);
    free(strip);
    return result == ZT_OK ? 0 : fail("writing", &diag);
}

static uint32_t next(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static int read_regions(const char *path) {
    static unsigned char texels[REGION * REGION * 4];
    zt_diag diag = {0};
    zt_file *file;
    uint32_t state = 1;
    double start = seconds();
    if (zt_open_path(path, NULL, &diag, &file) != ZT_OK)
        return fail("opening", &diag);
    printf("| opening | %.3f ms | |\n", 1e3 * (seconds() - start));
    start = seconds();
    for (int i = 0; i < REGIONS; i++) {
        zt_level_info level;
        zt_region region = {.level = next(&state) % 4, .depth = 1};
        zt_get_level(file, 0, region.level, &level);
        region.width = level.width < REGION ? level.width : REGION;
        region.height = level.height < REGION ? level.height : REGION;
        region.x = next(&state) % (level.width - region.width + 1);
        region.y = next(&state) % (level.height - region.height + 1);
        if (zt_decode_region(file, 0, &region, texels, sizeof texels, 0, 0, NULL, &diag) != ZT_OK)
            return fail("reading", &diag);
        unsigned char expected[4];
        texel(region.x, region.y, expected);
        if (region.level == 0 && memcmp(texels, expected, 4) != 0) {
            fprintf(stderr, "a texel differs\n");
            return 1;
        }
    }
    printf("| reading %d regions of %d x %d | %.2f s | %.2f ms a region |\n", REGIONS, REGION, REGION,
           seconds() - start, 1e3 * (seconds() - start) / REGIONS);
    zt_close(file);
    return 0;
}

int main(int argc, char **argv) {
    uint32_t edge = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 32768;
    const char *path = argc > 2 ? argv[2] : "bench_gigatexel.ztex";
    zt_threads *threads;
    if (edge < REGION || zt_threads_open(0, &threads) != ZT_OK)
        return 1;
    zt_parallel parallel = zt_threads_parallel(threads);
    double start = seconds();
    printf("| what | time | |\n|---|---|---|\n");
    if (write_image(path, edge, &parallel) != 0)
        return 1;
    double took = seconds() - start;
    printf("| writing %u x %u, all levels, %u threads | %.1f s | %.0f MB/s of texels |\n", edge, edge, parallel.workers,
           took, (double)edge * edge * 4e-6 / took);
    zt_threads_close(threads);
    int result = read_regions(path);
    printf("| peak resident memory | %.0f MiB | |\n", peak_mib());
    if (argc <= 2)
        unlink(path);
    return result;
}
