/* SPDX-License-Identifier: Apache-2.0 */
/* What the codecs were made to reach, and whether they do. */
#include "codec.h"

typedef enum {
    SIZE,        /* bytes, ours / peer's, tiles of 256 */
    EVERY_CLASS, /* the same in the worst class */
    EVERY_ONE,   /* the same in the worst picture, highest effort */
    DECODE,      /* speed, ours / peer's, tiles of 256 */
    PLAIN,       /* the same without vector instructions */
    THREADS,     /* wall time of two threads, as a speed */
    ENCODE,      /* MB/s */
    LOAD         /* time, ours / peer's */
} kind;

typedef struct {
    const char *text;
    kind kind;
    int set, peer;
    int at_most; /* else at least */
    double limit;
} goal;

static const goal goals[] = {
    {"bytes / KTX2 way, zstd 19", SIZE, CODEC_ALL_8, CODEC_ZSTD_19, 1, 0.72},
    {"bytes / PNG 9", SIZE, CODEC_ALL_8, CODEC_PNG, 1, 0.84},
    {"bytes / WebP lossless", SIZE, CODEC_ALL_8, CODEC_WEBP, 1, 1.03},
    {"half: bytes / OpenEXR ZIP", SIZE, CODEC_HDR, CODEC_EXR_ZIP, 1, 0.77},
    {"worst class: bytes / PNG 9", EVERY_CLASS, CODEC_ALL_8, CODEC_PNG, 1, 1.0},
    {"worst picture: bytes / PNG 9", EVERY_ONE, CODEC_ALL_8, CODEC_PNG, 1, 1.0},
    {"worst picture: bytes / zstd 19", EVERY_ONE, CODEC_ALL_8, CODEC_ZSTD_19, 1, 1.08},
    {"decode speed / zstd 19", DECODE, CODEC_ALL_8, CODEC_ZSTD_19, 0, 1.6},
    {"decode speed / libpng", DECODE, CODEC_ALL_8, CODEC_PNG, 0, 7},
    {"decode speed / QOI", DECODE, CODEC_ALL_8, CODEC_QOI, 0, 2},
    {"decode speed / memcpy (1.45 GB/s where it makes 9)", DECODE, CODEC_ALL_8, CODEC_COPY, 0, 0.161},
    {"plain C: decode speed / memcpy (0.6 GB/s where it makes 9)", PLAIN, CODEC_ALL_8, CODEC_COPY, 0, 0.067},
    {"decode speed, 2 threads / 1", THREADS, CODEC_ALL_8, CODEC_WALL_1, 0, 1.8},
    {"decode speed, 2 threads / 2 threads, a picture each", THREADS, CODEC_ALL_8, CODEC_WALL_BOTH, 0, 0.9},
    {"encode speed at default effort, MB/s", ENCODE, CODEC_ALL_8, CODEC_DEFAULT, 0, 60},
    {"loading 4096 x 4096 with all levels: time / zstd 19", LOAD, CODEC_ALL_8, CODEC_ZSTD_19, 1, 0.5},
};

static double size_ratio(const codec_report *report, int set, int ours, int peer) {
    codec_sum a = codec_add_up(report, set, ours, peer), b = codec_add_up(report, set, peer, ours);
    return a.pictures > 0 ? (double)a.size / (double)b.size : -1;
}

static double worst_size(const codec_report *report, int first, int end, int ours, int peer) {
    double worst = -1;
    for (int set = first; set < end; set++) {
        double ratio = size_ratio(report, set, ours, peer);
        worst = ratio > worst ? ratio : worst;
    }
    return worst;
}

static double decode_ratio(const codec_report *report, int set, int ours, int peer) {
    codec_sum a = codec_add_up(report, set, ours, peer), b = codec_add_up(report, set, peer, ours);
    return a.pictures > 0 ? b.decode / a.decode : -1;
}

/* Negative: not measured, or not a question of effort. */
static double value_of(const codec_report *report, const goal *g, int highest) {
    int ours = highest ? CODEC_CHOSEN : CODEC_DEFAULT;
    codec_sum encoded = codec_add_up(report, g->set, ours, -1);
    switch (g->kind) {
    case SIZE:
        return size_ratio(report, g->set, ours, g->peer);
    case EVERY_CLASS:
        return worst_size(report, 0, CODEC_GROUPS, ours, g->peer);
    case EVERY_ONE:
        return highest ? worst_size(report, CODEC_ONE, CODEC_ONE + (int)report->count, ours, g->peer) : -1;
    case DECODE:
        return decode_ratio(report, g->set, highest ? CODEC_HIGHEST : CODEC_DEFAULT, g->peer);
    case PLAIN:
        return highest ? -1 : decode_ratio(report, g->set, CODEC_PLAIN, g->peer);
    case THREADS:
        return highest ? -1 : decode_ratio(report, g->set, CODEC_WALL_2, g->peer);
    case ENCODE:
        return highest || encoded.encode <= 0 ? -1 : (double)encoded.raw / encoded.encode * 1e-6;
    case LOAD:
        return highest || !report->load.there ? -1 : report->load.ours_cpu / report->load.peer_cpu;
    }
    return -1;
}

static int passes(const goal *g, double value) {
    return value >= 0 && (g->at_most ? value <= g->limit : value >= g->limit);
}

static void print_value(double value, FILE *out) {
    if (value < 0)
        fprintf(out, " - |");
    else
        fprintf(out, " %.3f |", value);
}

void codec_write_goals(const codec_report *report, FILE *out) {
    fprintf(
        out,
        "\n## Goals\n\n8-bit pictures where nothing else is said, and tiles of 256; for sizes at the highest effort "
        "libzt chooses the tile edge.\n\n"
        "| goal | | default effort | highest effort | |\n|---|--:|--:|--:|---|\n");
    for (size_t i = 0; i < sizeof goals / sizeof goals[0]; i++) {
        const goal *g = &goals[i];
        double usual = value_of(report, g, 0), highest = value_of(report, g, 1);
        double first = usual < 0 ? highest : usual;
        const char *verdict = first < 0            ? "not measured"
                              : passes(g, first)   ? "pass"
                              : passes(g, highest) ? "FAIL, pass at the highest effort"
                                                   : "FAIL";
        fprintf(out, "| %s | %s %g |", g->text, g->at_most ? "at most" : "at least", g->limit);
        print_value(usual, out);
        print_value(highest, out);
        fprintf(out, " %s |\n", verdict);
    }
}
