/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of the codec benchmark, as Markdown. */
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "codec.h"

static int in_set(const codec_report *report, size_t picture, int set) {
    if (set >= CODEC_ONE)
        return picture == (size_t)(set - CODEC_ONE);
    int group = codec_group_of(&report->pictures[picture]);
    return set == CODEC_ALL_8 ? group != CODEC_HDR : group == set;
}

codec_sum codec_add_up(const codec_report *report, int set, int row, int also) {
    codec_sum sum = {0};
    int timed = 1;
    for (size_t i = 0; i < report->count; i++) {
        const codec_figure *figure = &report->figures[i][row];
        if (!in_set(report, i, set) || !figure->there || (also >= 0 && !report->figures[i][also].there))
            continue;
        sum.pictures++;
        sum.raw += report->pictures[i].size;
        sum.size += figure->size;
        sum.decode += figure->decode;
        sum.encode += figure->encode;
        timed = timed && figure->encode > 0;
    }
    if (!timed)
        sum.encode = 0;
    return sum;
}

typedef double measure_function(const codec_report *report, int set, int row, int against);

/* All give a negative number where there is nothing to say. */
static double percent(const codec_report *report, int set, int row, int against) {
    codec_sum sum = codec_add_up(report, set, row, -1);
    (void)against;
    return sum.pictures > 0 ? 100 * (double)sum.size / (double)sum.raw : -1;
}

static double size_ratio(const codec_report *report, int set, int row, int against) {
    codec_sum peer = codec_add_up(report, set, row, against), ours = codec_add_up(report, set, against, row);
    return peer.pictures > 0 ? (double)ours.size / (double)peer.size : -1;
}

static double decode_speed(const codec_report *report, int set, int row, int against) {
    codec_sum sum = codec_add_up(report, set, row, -1);
    (void)against;
    return sum.pictures > 0 ? (double)sum.raw / sum.decode * 1e-9 : -1;
}

static double decode_ratio(const codec_report *report, int set, int row, int against) {
    codec_sum peer = codec_add_up(report, set, row, against), ours = codec_add_up(report, set, against, row);
    return peer.pictures > 0 ? peer.decode / ours.decode : -1;
}

static double encode_speed(const codec_report *report, int set, int row, int against) {
    codec_sum sum = codec_add_up(report, set, row, -1);
    (void)against;
    return sum.pictures > 0 && sum.encode > 0 ? (double)sum.raw / sum.encode * 1e-6 : -1;
}

static void cell(FILE *out, double value, int digits) {
    if (value < 0)
        fprintf(out, " - |");
    else
        fprintf(out, " %.*f |", digits, value);
}

/* Rows end with -1; one that has nothing to say is left out. against: for ratios, ours. */
static void table(const codec_report *report, FILE *out, const char *title, measure_function *measure, int digits,
                  const int *rows, int against) {
    fprintf(out, "\n%s\n\n| |", title);
    for (int set = 0; set <= CODEC_ALL_8; set++)
        fprintf(out, " %s |", codec_groups[set]);
    fprintf(out, "\n|---|");
    for (int set = 0; set <= CODEC_ALL_8; set++)
        fprintf(out, "--:|");
    fprintf(out, "\n");
    for (; *rows >= 0; rows++) {
        double best = -1;
        for (int set = 0; set <= CODEC_ALL_8; set++)
            best = measure(report, set, *rows, against) > best ? measure(report, set, *rows, against) : best;
        if (best < 0)
            continue;
        fprintf(out, "| %s |", codec_row_name(*rows));
        for (int set = 0; set <= CODEC_ALL_8; set++)
            cell(out, measure(report, set, *rows, against), digits);
        fprintf(out, "\n");
    }
}

static const int ours_rows[] = {
    CODEC_DEFAULT, CODEC_DEFAULT_512, CODEC_HIGHEST, CODEC_CHOSEN,  CODEC_PLAIN,   CODEC_COPY,
    CODEC_ZSTD_1,  CODEC_ZSTD_9,      CODEC_ZSTD_19, CODEC_PNG,     CODEC_SPNG,    CODEC_QOI,
    CODEC_WEBP,    CODEC_JXL_3,       CODEC_JXL_7,   CODEC_EXR_ZIP, CODEC_EXR_PIZ, -1};
static const int size_rows[] = {CODEC_DEFAULT, CODEC_DEFAULT_512, CODEC_HIGHEST, CODEC_CHOSEN,  CODEC_ZSTD_1,
                                CODEC_ZSTD_9,  CODEC_ZSTD_19,     CODEC_PNG,     CODEC_QOI,     CODEC_WEBP,
                                CODEC_JXL_3,   CODEC_JXL_7,       CODEC_EXR_ZIP, CODEC_EXR_PIZ, -1};
static const int peer_rows[] = {CODEC_ZSTD_1, CODEC_ZSTD_9, CODEC_ZSTD_19, CODEC_PNG,     CODEC_QOI, CODEC_WEBP,
                                CODEC_JXL_3,  CODEC_JXL_7,  CODEC_EXR_ZIP, CODEC_EXR_PIZ, -1};
static const int speed_rows[] = {CODEC_COPY, CODEC_ZSTD_1, CODEC_ZSTD_9, CODEC_ZSTD_19, CODEC_PNG,     CODEC_SPNG,
                                 CODEC_QOI,  CODEC_WEBP,   CODEC_JXL_3,  CODEC_JXL_7,   CODEC_EXR_ZIP, CODEC_EXR_PIZ,
                                 -1};
static const int encode_rows[] = {CODEC_DEFAULT, CODEC_DEFAULT_512, CODEC_HIGHEST, CODEC_CHOSEN,  CODEC_ZSTD_1,
                                  CODEC_ZSTD_9,  CODEC_ZSTD_19,     CODEC_PNG,     CODEC_QOI,     CODEC_WEBP,
                                  CODEC_JXL_3,   CODEC_JXL_7,       CODEC_EXR_ZIP, CODEC_EXR_PIZ, -1};
static const int wall_rows[] = {CODEC_WALL_1, CODEC_WALL_2, CODEC_WALL_BOTH, CODEC_WALL_1_512, CODEC_WALL_2_512, -1};

static void write_cpu(FILE *out) {
    char line[512];
    FILE *file = fopen("/proc/cpuinfo", "r");
    const char *name = "unknown CPU";
    while (file && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon)
            continue;
        line[strcspn(line, "\n")] = 0;
        name = colon + 2;
        break;
    }
    fprintf(out, "%s, %ld processors", name, sysconf(_SC_NPROCESSORS_ONLN));
    if (file)
        fclose(file);
#ifdef __x86_64__
    fprintf(out, ", %s",
            __builtin_cpu_supports("avx512vl") ? "AVX2 and AVX-512"
            : __builtin_cpu_supports("avx2")   ? "AVX2"
                                               : "no AVX2");
#endif
}

static void write_head(const codec_report *report, FILE *out) {
    char date[32] = "";
    time_t seconds = time(NULL);
    struct tm utc;
    if (gmtime_r(&seconds, &utc))
        strftime(date, sizeof date, "%Y-%m-%d", &utc);
    fprintf(out, "# The tile codecs against their peers\n\n");
    fprintf(out, "Made by `%s` on %s; median of %u rounds. Machine: ", report->command, date, report->rounds);
    write_cpu(out);
    fprintf(out, ". Compiler: %s %s. Libraries: ",
#ifdef __clang__
            "clang",
#else
            "gcc",
#endif
            __VERSION__);
    codec_versions(out);
    fprintf(
        out,
        ".\n\nIn each round all encode, picture by picture; then they take turns to decode the whole set, one picture "
        "after the other, after one\ndecoding that does not count. From memory into memory that is there before. "
        "Figures of one thread are its CPU time, those of two\nare wall time, each of them kept on a processor of "
        "its own, where a system may leave both on one; they have 51 turns of their own. \"A picture each\" is what "
        "this machine\nhas of two processors: two threads that share nothing, and its speed is that of both together. "
        "Every picture that is decoded is compared with its source. One level; sizes\nare those of whole files. "
        "Opening the file "
        "counts as decoding. The pictures are those of tools/bench/pictures.txt.\n");
    fprintf(out, "\n![Bytes against decode speed](codec-bench.svg)\n");
    fprintf(out, "\n| class | pictures | MB |\n|---|--:|--:|\n");
    for (int set = 0; set <= CODEC_ALL_8; set++) {
        codec_sum sum = codec_add_up(report, set, CODEC_COPY, -1);
        fprintf(out, "| %s | %zu | %.1f |\n", codec_groups[set], sum.pictures, (double)sum.raw * 1e-6);
    }
}

static void write_pictures(const codec_report *report, FILE *out) {
    static const int rows[] = {CODEC_DEFAULT, CODEC_HIGHEST, CODEC_CHOSEN,  CODEC_ZSTD_19,
                               CODEC_PNG,     CODEC_WEBP,    CODEC_EXR_ZIP, -1};
    fprintf(out, "\n## Picture by picture, %% of raw\n\n| class | picture | texels |");
    for (int i = 0; rows[i] >= 0; i++)
        fprintf(out, " %s |", codec_row_name(rows[i]));
    fprintf(out, " chosen / PNG | chosen / zstd 19 |\n|---|---|---|");
    for (int i = 0; rows[i] >= 0; i++)
        fprintf(out, "--:|");
    fprintf(out, "--:|--:|\n");
    for (size_t p = 0; p < report->count; p++) {
        const codec_picture *picture = &report->pictures[p];
        int set = CODEC_ONE + (int)p;
        fprintf(out, "| %s | %s | %u x %u, %u x %u bits |", picture->group, picture->name, picture->width,
                picture->height, picture->channels, picture->channel_bytes * 8);
        for (int i = 0; rows[i] >= 0; i++)
            cell(out, percent(report, set, rows[i], -1), 2);
        cell(out, size_ratio(report, set, CODEC_PNG, CODEC_CHOSEN), 3);
        cell(out, size_ratio(report, set, CODEC_ZSTD_19, CODEC_CHOSEN), 3);
        fprintf(out, "\n");
    }
}

static void write_load(const codec_load *load, FILE *out) {
    fprintf(out, "\n## Loading a texture of 4096 x 4096 RGBA8 with all levels\n\n");
    if (!load->there) {
        fprintf(out, "Not measured.\n");
        return;
    }
    double gb = (double)load->texels * 1e-9;
    fprintf(
        out,
        "An atlas of %u pictures of the set, from the bytes of its file into memory that can be uploaded. The peer: "
        "one zstd frame at\nlevel 19 for each level.\n\n",
        load->sources);
    fprintf(out, "| | MB | s | GB/s |\n|---|--:|--:|--:|\n");
    fprintf(out, "| ztex | %.1f | %.4f | %.2f |\n", (double)load->ours * 1e-6, load->ours_cpu, gb / load->ours_cpu);
    fprintf(out, "| ztex, 1 thread, wall | | %.4f | %.2f |\n", load->ours_wall, gb / load->ours_wall);
    fprintf(out, "| ztex, 2 threads, wall | | %.4f | %.2f |\n", load->ours_wall_2, gb / load->ours_wall_2);
    fprintf(out, "| KTX2 way, zstd 19 | %.1f | %.4f | %.2f |\n", (double)load->peer * 1e-6, load->peer_cpu,
            gb / load->peer_cpu);
    fprintf(out, "| memcpy | %.1f | %.4f | %.2f |\n", (double)load->texels * 1e-6, load->copy_cpu, gb / load->copy_cpu);
}

/* Names what a contender did not give back; the number of pictures. */
static int write_wrong(const codec_report *report, int c, FILE *out) {
    int wrong = 0, worst = 2;
    for (size_t i = 0; i < report->count; i++) {
        if (!report->figures[i][c].wrong)
            continue;
        worst = report->figures[i][c].wrong < worst ? report->figures[i][c].wrong : worst;
        fprintf(out, "%s%s", wrong++ ? ", " : "- ", report->pictures[i].name);
    }
    if (wrong)
        fprintf(out, ": **%s does not give %s back bit for bit**%s.\n", codec_row_name(c), wrong > 1 ? "them" : "it",
                worst == 2 ? " (only subnormal half floats differ)" : "");
    return wrong;
}

static void write_notes(const codec_report *report, FILE *out) {
    fprintf(
        out,
        "\n## Notes\n\n"
        "- Pictures whose alpha is one everywhere go to PNG, WebP, JPEG XL and OpenEXR without it, as a "
        "sensible tool would, and come back\n  with it. QOI is given it: its files have no use for the "
        "difference.\n"
        "- The KTX2 way is one zstd frame for the level, decoded with a context that is kept. Its size is that of a "
        "KTX2 file: the frame, 80 bytes\n  of header, 24 of level index, and a data format descriptor of "
        "28 and 16 a channel (RGBA8: 92).\n"
        "- \"Edge chosen\": no tile edge is given, so libzt tries 256, 512 and the whole level at the highest effort "
        "and keeps the smallest.\n"
        "- PNG is the smaller of adaptive filters and none; its encode time is that of both tries.\n"
        "- OpenEXR ZIP is written at the library's default level.\n"
        "- WebP has no one-channel pictures: it gets three equal channels, and one is picked afterwards.\n"
        "- QOI has no one-channel pictures: those are left out, also from what it is compared with.\n"
        "- Encoders that make less than 15 MB/s of a picture are timed once, the others in every round.\n");
    int wrong = 0;
    for (int c = 0; c < CODEC_CONTENDERS; c++)
        wrong += write_wrong(report, c, out);
    if (!wrong)
        fprintf(out, "- Every contender gave back every picture bit for bit.\n");
}

void codec_write_report(const codec_report *report, FILE *out) {
    write_head(report, out);
    fprintf(out, "\n## Size\n");
    table(report, out, "Bytes, % of raw:", percent, 2, size_rows, -1);
    table(report, out, "Bytes of ztex, tiles of 256, default effort, as a ratio to", size_ratio, 3, peer_rows,
          CODEC_DEFAULT);
    table(report, out, "Bytes of ztex, highest effort, tile edge chosen, as a ratio to", size_ratio, 3, peer_rows,
          CODEC_CHOSEN);
    fprintf(out, "\n## Speed\n");
    table(report, out, "Decoding, GB/s of texels, one thread:", decode_speed, 3, ours_rows, -1);
    table(report, out, "Decoding ztex, tiles of 256, default effort, is this many times as fast as", decode_ratio, 2,
          speed_rows, CODEC_DEFAULT);
    table(report, out, "Encoding, MB/s of texels, one thread:", encode_speed, 1, encode_rows, -1);
    table(report, out, "Decoding in wall time, GB/s:", decode_speed, 3, wall_rows, -1);
    table(report, out, "Encoding in wall time, MB/s:", encode_speed, 1, wall_rows, -1);
    write_load(&report->load, out);
    write_pictures(report, out);
    write_notes(report, out);
    codec_write_goals(report, out);
}
