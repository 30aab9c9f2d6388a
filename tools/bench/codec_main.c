/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Question: how small does libzt store real textures, and how fast does it decode and encode them, against the formats
 * that people use now?
 *
 * A round first encodes, picture by picture, with all contenders. Then each contender decodes all pictures, one after
 * the other as a loader does, after one that does not count: so its code is in the caches and its threads are awake,
 * and the texels of the picture before are in the caches instead of those that come. Those whose wall time counts have
 * turns of their own behind the rounds, many, since it is the machine's whole time that they measure.
 *
 * usage: bench_codec [--rounds N] [--only TEXT] [--no-load] [--list FILE] [--pictures FOLDER] [--write FOLDER]
 *     --only TEXT       pictures whose name or class contains TEXT
 *     --write FOLDER    also FOLDER/codec-bench.md and FOLDER/codec-bench.svg
 */
#include <stdlib.h>
#include <string.h>

#include "codec.h"

enum { MAX_ROUNDS = 99, WALL_TURNS = 51 };

/* A round repeats what is shorter than this; the clock is good to a microsecond. Slow encoders are timed once. */
static const double shortest = 2e-4, slow_bytes_per_second = 15e6;

typedef struct {
    const char *list, *pictures, *write, *only;
    unsigned rounds;
    int no_load;
} settings;

typedef struct {
    codec_bytes stored[CODEC_CONTENDERS];
    double encode[CODEC_CONTENDERS][MAX_ROUNDS], decode[CODEC_CONTENDERS][MAX_ROUNDS];
    unsigned encodes[CODEC_CONTENDERS], decodes[CODEC_CONTENDERS];
} samples;

static double now(const codec_contender *contender) {
    return contender->threads ? codec_wall_seconds() : codec_cpu_seconds();
}

static int is_slow(const samples *s, int c, const codec_picture *picture) {
    return s->encodes[c] > 0 && (double)picture->size < slow_bytes_per_second * s->encode[c][0];
}

static int encode_once(int c, const codec_picture *picture, samples *s) {
    const codec_contender *contender = &codec_contenders[c];
    double start = now(contender), took = 0;
    unsigned runs = 0;
    do {
        if (!contender->encode(contender, picture, &s->stored[c]))
            return 0;
        runs++;
        took = now(contender) - start;
    } while (took < shortest);
    s->encode[c][s->encodes[c]++] = took / runs;
    return 1;
}

static int decode_once(int c, const codec_picture *picture, samples *s, void *texels, double *out) {
    const codec_contender *contender = &codec_contenders[c];
    const codec_bytes *in = &s->stored[contender->encode ? c : contender->bytes_of];
    double start = now(contender), took = 0;
    unsigned runs = 0;
    do {
        if (!contender->decode(contender, picture, in, texels))
            return 0;
        runs++;
        took = now(contender) - start;
    } while (took < shortest);
    *out = took / runs / (contender->at_once ? contender->at_once : 1);
    return 1;
}

/* Whether all texels that differ are half floats below the normal range. */
static int only_subnormals_differ(const codec_picture *picture, const unsigned char *texels) {
    for (size_t i = 0; i + 1 < picture->size; i += 2) {
        int same = memcmp(texels + i, picture->texels + i, 2) == 0;
        if (!same && (picture->channel_bytes != 2 || (picture->texels[i + 1] & 0x7C) != 0))
            return 0;
    }
    return picture->channel_bytes == 2;
}

static void encode(int c, const codec_picture *picture, unsigned round, samples *s, codec_figure *figure) {
    const codec_contender *contender = &codec_contenders[c];
    if (round == 0)
        figure->there = !contender->takes || contender->takes(picture);
    if (!figure->there || !contender->encode || is_slow(s, c, picture) || encode_once(c, picture, s))
        return;
    fprintf(stderr, "%s: cannot encode %s\n", contender->name, picture->name);
    figure->there = 0;
}

/* The first time what is decoded is compared with the source. */
static void decode(int c, const codec_picture *picture, samples *s, unsigned char *texels, codec_figure *figure) {
    const codec_contender *contender = &codec_contenders[c];
    unsigned turn = s->decodes[c];
    if (!figure->there)
        return;
    if (turn == 0)
        memset(texels, 0xA5, picture->size);
    if (!decode_once(c, picture, s, texels, &s->decode[c][turn])) {
        fprintf(stderr, "%s: cannot decode %s\n", contender->name, picture->name);
        figure->there = 0;
        return;
    }
    s->decodes[c]++;
    if (turn == 0 && memcmp(texels, picture->texels, picture->size) != 0) {
        fprintf(stderr, "%s: %s comes back different\n", contender->name, picture->name);
        figure->wrong = only_subnormals_differ(picture, texels) ? 2 : 1;
    }
}

static void decode_all(const codec_report *report, int c, samples *all, unsigned char *texels) {
    size_t first = 0;
    double ignored;
    while (first + 1 < report->count && !report->figures[first][c].there)
        first++;
    if (report->figures[first][c].there)
        decode_once(c, &report->pictures[first], &all[first], texels, &ignored);
    for (size_t i = 0; i < report->count; i++)
        decode(c, &report->pictures[i], &all[i], texels, &report->figures[i][c]);
}

static void run_round(const codec_report *report, unsigned round, samples *all, unsigned char *texels) {
    for (size_t i = 0; i < report->count; i++) {
        for (int c = 0; c < CODEC_CONTENDERS; c++)
            encode(c, &report->pictures[i], round, &all[i], &report->figures[i][c]);
    }
    for (int c = 0; c < CODEC_CONTENDERS; c++) {
        if (!codec_contenders[c].threads)
            decode_all(report, c, all, texels);
    }
}

static void run_wall_turns(const codec_report *report, samples *all, unsigned char *texels) {
    for (int turn = 0; turn < WALL_TURNS; turn++) {
        for (int c = 0; c < CODEC_CONTENDERS; c++) {
            if (codec_contenders[c].threads)
                decode_all(report, c, all, texels);
        }
    }
}

static void settle(samples *s, codec_figure *figures) {
    for (int c = 0; c < CODEC_CONTENDERS; c++) {
        const codec_contender *contender = &codec_contenders[c];
        if (!figures[c].there)
            continue;
        figures[c].size = s->stored[contender->encode ? c : contender->bytes_of].size;
        figures[c].encode = codec_median(s->encode[c], s->encodes[c]);
        figures[c].decode = codec_median(s->decode[c], s->decodes[c]);
    }
}

static int measure(codec_report *report) {
    samples *all = calloc(report->count, sizeof *all);
    size_t largest = 1;
    for (size_t i = 0; i < report->count; i++)
        largest = report->pictures[i].size > largest ? report->pictures[i].size : largest;
    unsigned char *texels = malloc(largest);
    for (unsigned round = 0; all && texels && round < report->rounds; round++) {
        double start = codec_wall_seconds();
        run_round(report, round, all, texels);
        fprintf(stderr, "round %u of %u: %.0f s\n", round + 1, report->rounds, codec_wall_seconds() - start);
    }
    if (all && texels)
        run_wall_turns(report, all, texels);
    for (size_t i = 0; all && texels && i < report->count; i++) {
        settle(&all[i], report->figures[i]);
        for (int c = 0; c < CODEC_CONTENDERS; c++)
            free(all[i].stored[c].data);
    }
    int done = all && texels;
    free(all);
    free(texels);
    return done;
}

static int write_file(const codec_report *report, const char *folder, const char *name,
                      void (*writer)(const codec_report *, FILE *)) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (!file) {
        perror(path);
        return 0;
    }
    writer(report, file);
    return fclose(file) == 0;
}

static int parse(int argc, char **argv, settings *out) {
    for (int i = 1; i < argc; i++) {
        const char **text = strcmp(argv[i], "--list") == 0       ? &out->list
                            : strcmp(argv[i], "--pictures") == 0 ? &out->pictures
                            : strcmp(argv[i], "--write") == 0    ? &out->write
                            : strcmp(argv[i], "--only") == 0     ? &out->only
                                                                 : NULL;
        if (strcmp(argv[i], "--no-load") == 0)
            out->no_load = 1;
        else if (text && i + 1 < argc)
            *text = argv[++i];
        else if (strcmp(argv[i], "--rounds") == 0 && i + 1 < argc)
            out->rounds = (unsigned)strtoul(argv[++i], NULL, 10);
        else
            return 0;
    }
    return out->rounds >= 1 && out->rounds <= MAX_ROUNDS;
}

static size_t pick(codec_picture *pictures, size_t count, const char *text) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (!text || strstr(pictures[i].name, text) || strstr(pictures[i].group, text))
            pictures[kept++] = pictures[i];
        else
            codec_release_picture(&pictures[i]);
    }
    return kept;
}

int main(int argc, char **argv) {
    settings set = {.list = "tools/bench/pictures.txt", .pictures = "build/bench/pictures", .rounds = 5};
    codec_picture *pictures = NULL;
    codec_report report = {.command = "./dev bench codec --write"};
    if (!parse(argc, argv, &set)) {
        fprintf(stderr, "usage: bench_codec [--rounds N] [--only TEXT] [--no-load] [--list FILE] [--pictures FOLDER] "
                        "[--write FOLDER]\n");
        return 2;
    }
    if (!codec_read_list(set.list, set.pictures, &pictures, &report.count))
        return 1;
    report.count = pick(pictures, report.count, set.only);
    report.pictures = pictures;
    report.rounds = set.rounds;
    report.figures = calloc(report.count + 1, sizeof *report.figures);
    if (!report.figures || !measure(&report))
        return 1;
    if (!set.no_load)
        codec_load_test(pictures, report.count, set.rounds, &report.load);
    codec_write_report(&report, stdout);
    int done = !set.write || (write_file(&report, set.write, "codec-bench.md", codec_write_report) &&
                              write_file(&report, set.write, "codec-bench.svg", codec_write_plot));
    for (size_t i = 0; i < report.count; i++)
        codec_release_picture(&pictures[i]);
    free(pictures);
    free(report.figures);
    return done ? 0 : 1;
}
