/* SPDX-License-Identifier: Apache-2.0 */
/*
 * silmap_bench KIND FILE CELLS LEFT TOP WIDTH [WORD...]: one input at one size, as JSON.
 *
 * KIND is outline, drawing or photo; the crop is that of a drawing. Outlines and drawings are hinted where that makes
 * the silmap better, for all contestants alike. Words: "plain" leaves them where they are; "equal" adds contestants of
 * the silmap's bytes in memory and in the file; "bytes" gives the sizes of the silmap's files alone, "areas" those of
 * disagreement; "crops=PREFIX" writes a part of each picture at 16x as PPM.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "silmap_bench.h"

enum {
    EFFORT = 5,
    WINDOWS = 24,     /* at 64x */
    WINDOW_CELLS = 4, /* their edge */
    CROP_CELLS = 8,
    CROP_ZOOM = 16,
    WHOLE_ZOOM = 16,
    MAX_FACTOR = 3 /* of a grid of the same bytes in the file */
};

typedef struct job {
    truth t;
    uint32_t cells;
    int hinted; /* it has been moved */
    author_silmap_result silmap, uncut;
    window windows[WINDOWS]; /* where there are edges */
    size_t window_count;
    window crop; /* where most goes on */
    const char *crops;
    float *whole; /* the truth at WHOLE_ZOOM, rendered once */
} job;

/* ---- the fit -------------------------------------------------------------------------------------------- */

static author_path *paths_of(const shape *s) {
    author_path *paths = bench_alloc(s->contour_count, sizeof *paths);
    double *points = bench_alloc(2 * s->count, sizeof *points);
    for (size_t i = 0; i < s->count; i++) {
        author_path *path = &paths[s->pieces[i].contour];
        points[2 * i] = s->pieces[i].x0;
        points[2 * i + 1] = s->pieces[i].y0;
        path->points = path->count++ ? path->points : points + 2 * i;
        path->closed = 1;
    }
    return paths;
}

/* The best samples without a cut: only edges that are drawn are cut, and none is. */
static void fit_uncut(job *j, author_run *run, const author_picture *picture, const author_silmap_options *options) {
    author_silmap_input input = {.picture = picture, .paths_only = 1};
    if (author_silmap_fit(run, &input, options, &j->uncut) != AUTHOR_OK)
        bench_fail("fit", run->error);
    if (j->uncut.cut_cells)
        bench_fail("fit", "there are cuts where none are drawn");
}

/* Outlines are known exactly, as glyphs are. */
static author_silmap_input input_of(const job *j, author_picture *picture) {
    author_silmap_input input = {.picture = picture};
    *picture = truth_picture(&j->t, j->cells);
    if (j->t.kind == TRUTH_OUTLINE) {
        input.paths = paths_of(&j->t.outline);
        input.path_count = j->t.outline.contour_count;
        input.paths_only = 1;
    }
    return input;
}

static void release_input(author_silmap_input *input, author_picture *picture) {
    if (input->paths)
        free((void *)(uintptr_t)input->paths[0].points);
    free((void *)(uintptr_t)input->paths);
    author_picture_release(picture);
}

static void fit(job *j) {
    author_run run = {0};
    author_picture picture;
    author_silmap_input input = input_of(j, &picture);
    author_silmap_options options = {.cells_x = j->cells, .cells_y = j->cells};
    if (author_silmap_fit(&run, &input, &options, &j->silmap) != AUTHOR_OK)
        bench_fail("fit", run.error);
    if (j->t.kind == TRUTH_PHOTO)
        fit_uncut(j, &run, &picture, &options);
    release_input(&input, &picture);
}

/* As `ztex make silmap --hint` does it: what is fitted moves if it is better so. All contestants get the drawing where
 * it is then. */
static void try_hint(job *j, truth again) {
    author_run run = {0};
    author_silmap_place place;
    author_picture picture;
    author_silmap_input input = input_of(j, &picture);
    if (author_silmap_hint(&run, &input, j->cells, j->cells, j->t.kind == TRUTH_OUTLINE, &place) != AUTHOR_OK)
        bench_fail("hint", run.error);
    release_input(&input, &picture);
    job moved = {.t = again, .cells = j->cells};
    truth_place(&moved.t, &place);
    if (author_silmap_is_moved(&place))
        fit(&moved);
    j->hinted = moved.silmap.cells && author_silmap_is_better(&moved.silmap, &j->silmap);
    author_silmap_release(j->hinted ? &j->silmap : &moved.silmap);
    truth_release(j->hinted ? &j->t : &moved.t);
    if (j->hinted) {
        j->t = moved.t;
        j->silmap = moved.silmap;
    }
}

/* ---- where to look -------------------------------------------------------------------------------------- */

static int varies(const float *texels, size_t pitch, uint32_t channels) {
    int varied = 0;
    for (size_t y = 0; y < WINDOW_CELLS; y++)
        for (size_t i = 0; i < WINDOW_CELLS * channels; i++)
            varied = varied || fabsf(texels[y * pitch + i] - texels[i % channels]) > 0.1F;
    return varied;
}

static double change(const float *means, size_t n, uint32_t channels, size_t x, size_t y) {
    const float *at = means + (y * n + x) * channels;
    double sum = 0;
    for (uint32_t i = 0; i < channels; i++)
        sum += fabs((double)at[i] - (double)at[i + channels]) + fabs((double)at[i] - (double)at[i + n * channels]);
    return sum;
}

static window busiest(const job *j, const float *means) {
    size_t n = j->cells, best = 0;
    double most = -1, cell = 1 / (double)n;
    for (size_t b = 0; b < (n - CROP_CELLS) * (n - CROP_CELLS); b++) {
        size_t x = b % (n - CROP_CELLS), y = b / (n - CROP_CELLS);
        double sum = 0;
        for (size_t i = 0; i < CROP_CELLS * CROP_CELLS; i++)
            sum += change(means, n, j->t.channels, x + i % CROP_CELLS, y + i / CROP_CELLS);
        best = sum > most ? b : best;
        most = sum > most ? sum : most;
    }
    return (window){(double)(best % (n - CROP_CELLS)) * cell, (double)(best / (n - CROP_CELLS)) * cell,
                    CROP_CELLS * cell, CROP_CELLS * CROP_ZOOM};
}

/* Blocks of cells that edges cross, evenly taken out of all. */
static void choose_windows(job *j) {
    size_t n = j->cells, found = 0, taken = 0, blocks = n / WINDOW_CELLS;
    float *means = bench_alloc(n * n * j->t.channels, sizeof *means);
    size_t *places = bench_alloc(blocks * blocks, sizeof *places);
    truth_render(&j->t, &(window){0, 0, 1, n}, means);
    for (size_t b = 0; b < blocks * blocks; b++) {
        size_t x = b % blocks * WINDOW_CELLS, y = b / blocks * WINDOW_CELLS;
        if (varies(means + (y * n + x) * j->t.channels, n * j->t.channels, j->t.channels))
            places[found++] = b;
    }
    for (; taken < WINDOWS && taken < found; taken++) {
        size_t b = places[found <= WINDOWS ? taken : (2 * taken + 1) * found / (2 * WINDOWS)];
        double size = (double)WINDOW_CELLS / (double)n;
        j->windows[taken] = (window){(double)(b % blocks) * size, (double)(b / blocks) * size, size, 64 * WINDOW_CELLS};
    }
    j->window_count = taken;
    j->crop = busiest(j, means);
    free(means);
    free(places);
}

/* ---- measuring ------------------------------------------------------------------------------------------ */

static void measure_window(const job *j, method *m, const window *w, score *s) {
    size_t values = w->pixels * w->pixels * j->t.channels;
    float *shown = bench_alloc(values, sizeof *shown), *wanted = j->whole;
    if (w->pixels != WHOLE_ZOOM * j->cells) {
        wanted = bench_alloc(values, sizeof *wanted);
        truth_render(&j->t, w, wanted);
    }
    method_render(m, w, shown);
    score_add(s, shown, wanted, w, j->t.channels);
    free(shown);
    if (wanted != j->whole)
        free(wanted);
}

static void print_zoom(const job *j, method *m, size_t zoom) {
    score s = {0};
    if (zoom < 64 && zoom * j->cells <= truth_limit(&j->t, 1))
        measure_window(j, m, &(window){0, 0, 1, zoom * j->cells}, &s);
    for (size_t i = 0; zoom == 64 && i < j->window_count; i++)
        if (j->windows[i].pixels <= truth_limit(&j->t, j->windows[i].size))
            measure_window(j, m, &j->windows[i], &s);
    if (s.windows > 0)
        printf(",\"psnr%zu\":%.4f,\"ssim%zu\":%.5f", zoom, score_psnr(&s), zoom, score_ssim(&s));
}

/* Share of the area on the wrong side. The places lie between those of any fit: their number along a cell is prime. */
static double disagreement(const job *j, method *m) {
    size_t n = j->cells * 37, wrong = 0;
    double d = 1.0 / (double)n;
    uint8_t *wanted = bench_alloc(n, 1), *shown = bench_alloc(n, 1);
    for (size_t y = 0; y < n; y++) {
        shape_row(&j->t.outline, ((double)y + 0.5) * d, 0.5 * d, d, n, wanted);
        method_row(m, ((double)y + 0.5) * d, 0.5 * d, d, n, shown);
        for (size_t x = 0; x < n; x++)
            wrong += wanted[x] != shown[x];
    }
    free(wanted);
    free(shown);
    return (double)wrong / ((double)n * (double)n);
}

static void write_crop(const job *j, const char *name, const float *texels, size_t pixels, uint32_t channels) {
    char path[512];
    snprintf(path, sizeof path, "%s_%s.ppm", j->crops, name);
    FILE *file = fopen(path, "wb");
    if (!file)
        bench_fail(path, "cannot be written");
    fprintf(file, "P6 %zu %zu 255\n", pixels, pixels);
    for (size_t i = 0; i < pixels * pixels * 3; i++) {
        float value = zt_transfer_encode(ZT_TRANSFER_SRGB,
                                         fminf(fmaxf(texels[i / 3 * channels + (channels == 3 ? i % 3 : 0)], 0), 1));
        fputc((int)(value * 255 + 0.5F), file);
    }
    fclose(file);
}

/* m NULL: the truth. */
static void crop(const job *j, method *m) {
    window w = j->crop;
    if (!j->crops)
        return;
    float *texels = bench_alloc(w.pixels * w.pixels * 3, sizeof *texels);
    if (m)
        method_render(m, &w, texels);
    else
        truth_render(&j->t, &w, texels);
    write_crop(j, m ? method_names[m->kind] : "truth", texels, w.pixels, j->t.channels);
    free(texels);
}

static void print_method(const job *j, method *m, const char *prefix, int all) {
    printf(",\"%s%s\":{\"grid\":%u,\"memory\":%zu,\"file\":%zu,\"cells_size\":%zu", prefix, method_names[m->kind],
           m->grid, m->memory, m->file_size, m->cells_size);
    if (all)
        print_zoom(j, m, 4);
    print_zoom(j, m, 16);
    if (all)
        print_zoom(j, m, 64);
    printf(",\"ns\":%.1f", m->seconds / m->lookups * 1e9);
    if (j->t.kind == TRUTH_OUTLINE)
        printf(",\"disagreement\":%.8f", disagreement(j, m));
    printf("}");
}

static int takes_part(const job *j, method_kind kind) {
    if (kind == METHOD_SDF || kind == METHOD_MSDF)
        return j->t.kind == TRUTH_OUTLINE;
    return kind != METHOD_UNCUT || j->t.kind == TRUTH_PHOTO;
}

static method make(const job *j, method_kind kind, uint32_t grid) {
    return method_make(kind, &j->t, grid, EFFORT, kind == METHOD_UNCUT ? &j->uncut : &j->silmap);
}

/* ---- equal bytes ---------------------------------------------------------------------------------------- */

/* The largest grid whose file is not larger; file sizes grow with the grid but for small steps. */
static uint32_t grid_of_file(const job *j, method_kind kind, size_t bytes) {
    uint32_t low = 4, high = j->cells * MAX_FACTOR;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        method m = make(j, kind, middle);
        if (m.file_size <= bytes)
            low = middle;
        else
            high = middle;
        method_release(&m);
    }
    return low;
}

static void print_equal(const job *j, const method *silmap) {
    for (method_kind kind = METHOD_BILINEAR; kind <= METHOD_MSDF; kind++) {
        if (!takes_part(j, kind))
            continue;
        uint32_t channels = kind == METHOD_SDF ? 1 : kind == METHOD_MSDF ? 3 : j->t.channels;
        method m = make(j, kind, (uint32_t)(sqrt((double)silmap->memory / channels) + 0.5));
        print_method(j, &m, "memory_", 0);
        method_release(&m);
        m = make(j, kind, grid_of_file(j, kind, silmap->file_size));
        print_method(j, &m, "file_", 0);
        method_release(&m);
    }
}

static void print_bytes(const job *j) {
    static const int efforts[] = {5, 9};
    for (size_t i = 0; i < 2; i++) {
        method m = method_make(METHOD_SILMAP, &j->t, j->cells, efforts[i], &j->silmap);
        printf(",\"effort%d\":{\"file\":%zu,\"cells_size\":%zu}", efforts[i], m.file_size, m.cells_size);
        method_release(&m);
    }
}

static void print_all(job *j, int equal) {
    choose_windows(j);
    j->whole = bench_alloc((size_t)WHOLE_ZOOM * WHOLE_ZOOM * j->cells * j->cells, j->t.channels * sizeof *j->whole);
    truth_render(&j->t, &(window){0, 0, 1, WHOLE_ZOOM * j->cells}, j->whole);
    crop(j, NULL);
    for (method_kind kind = METHOD_BILINEAR; kind < METHOD_KINDS; kind++) {
        if (!takes_part(j, kind))
            continue;
        method m = make(j, kind, j->cells);
        print_method(j, &m, "", 1);
        crop(j, &m);
        if (equal && kind == METHOD_SILMAP)
            print_equal(j, &m);
        method_release(&m);
    }
}

static void print_areas(const job *j) {
    for (method_kind kind = METHOD_BILINEAR; kind <= METHOD_SILMAP; kind++) {
        method m = make(j, kind, j->cells);
        printf(",\"%s\":{\"disagreement\":%.8f}", method_names[kind], disagreement(j, &m));
        method_release(&m);
    }
}

static int has_word(int argc, char **argv, const char *word) {
    for (int i = 7; i < argc; i++)
        if (strcmp(argv[i], word) == 0)
            return 1;
    return 0;
}

int main(int argc, char **argv) {
    if (argc < 7)
        bench_fail("usage", "KIND FILE CELLS LEFT TOP WIDTH [WORD...]");
    double crops[3] = {atof(argv[4]), atof(argv[5]), atof(argv[6])};
    job j = {.t = truth_load(argv[1], argv[2], crops), .cells = (uint32_t)atoi(argv[3])};
    for (int i = 7; i < argc; i++)
        if (strncmp(argv[i], "crops=", 6) == 0)
            j.crops = argv[i] + 6;
    fit(&j);
    if (j.t.kind != TRUTH_PHOTO && !has_word(argc, argv, "plain"))
        try_hint(&j, truth_load(argv[1], argv[2], crops));
    printf("{\"cells\":%u,\"hinted\":%s,\"cut\":%llu,\"thin\":%llu,\"junction\":%llu", j.cells,
           j.hinted ? "true" : "false", (unsigned long long)j.silmap.cut_cells, (unsigned long long)j.silmap.thin_cells,
           (unsigned long long)j.silmap.junction_cells);
    printf(",\"fit_psnr\":%.3f,\"fit_bilinear\":%.3f,\"fit_disagreement\":%.8f", j.silmap.psnr, j.silmap.bilinear_psnr,
           j.silmap.disagreement);
    if (has_word(argc, argv, "bytes"))
        print_bytes(&j);
    else if (has_word(argc, argv, "areas"))
        print_areas(&j);
    else
        print_all(&j, has_word(argc, argv, "equal"));
    printf("}\n");
    free(j.whole);
    author_silmap_release(&j.silmap);
    author_silmap_release(&j.uncut);
    truth_release(&j.t);
    return 0;
}
