/* SPDX-License-Identifier: Apache-2.0 */
/* A plot of bytes against decode speed, over all 8-bit pictures, as SVG: small and fast is at the lower right. */
#include <math.h>

#include "codec.h"

enum { WIDTH = 860, HEIGHT = 520, LEFT = 70, RIGHT = 840, TOP = 50, BOTTOM = 460 };

static const double slowest = 0.01, fastest = 4, most = 35;

static double x_of(double speed) {
    return LEFT + (RIGHT - LEFT) * log(speed / slowest) / log(fastest / slowest);
}

static double y_of(double percent) {
    return BOTTOM - (BOTTOM - TOP) * percent / most;
}

static void axes(FILE *out) {
    static const double speeds[] = {0.01, 0.03, 0.1, 0.3, 1, 3};
    for (size_t i = 0; i < sizeof speeds / sizeof speeds[0]; i++) {
        double x = x_of(speeds[i]);
        fprintf(out,
                "<path class=\"grid\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%g</text>\n",
                x, TOP, BOTTOM, x, BOTTOM + 18, speeds[i]);
    }
    for (int percent = 0; percent <= (int)most; percent += 5) {
        double y = y_of(percent);
        fprintf(out,
                "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%d</text>\n",
                LEFT, y, RIGHT, LEFT - 8, y + 4, percent);
    }
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">decoding, GB/s of texels, one thread</text>\n",
            (LEFT + RIGHT) / 2, HEIGHT - 16);
    fprintf(out, "<text transform=\"translate(22 %d) rotate(-90)\" text-anchor=\"middle\">bytes, %% of raw</text>\n",
            (TOP + BOTTOM) / 2);
}

static void point(const codec_report *report, FILE *out, int row, int above, int right) {
    codec_sum sum = codec_add_up(report, CODEC_ALL_8, row, -1);
    if (sum.pictures == 0)
        return;
    double x = x_of((double)sum.raw / sum.decode * 1e-9), y = y_of(100 * (double)sum.size / (double)sum.raw);
    int ours = row < CODEC_COPY;
    fprintf(out,
            "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" class=\"%s\"/><text x=\"%.1f\" y=\"%.1f\" "
            "text-anchor=\"%s\">%s</text>\n",
            x, y, ours ? "ours" : "peer", right ? x + 9 : x - 9, above ? y - 5 : y + 12, right ? "start" : "end",
            codec_row_name(row));
}

void codec_write_plot(const codec_report *report, FILE *out) {
    /* Where the name goes: above or below, right or left. */
    static const struct {
        int row, above, right;
    } points[] = {{CODEC_ZSTD_1, 1, 1}, {CODEC_ZSTD_9, 1, 1},  {CODEC_ZSTD_19, 0, 1}, {CODEC_PNG, 1, 1},
                  {CODEC_SPNG, 0, 0},   {CODEC_QOI, 1, 0},     {CODEC_WEBP, 0, 0},    {CODEC_JXL_3, 1, 1},
                  {CODEC_JXL_7, 0, 1},  {CODEC_DEFAULT, 1, 1}, {CODEC_CHOSEN, 0, 0}};
    fprintf(out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" "
            "font-size=\"12\">\n",
            WIDTH, HEIGHT);
    fprintf(out, "<title>Bytes against decode speed</title>\n"
                 "<style>.grid{stroke:#ddd}.ours{fill:#c22}.peer{fill:#37a}text{fill:#222}</style>\n"
                 "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n");
    fprintf(out,
            "<text x=\"%d\" y=\"26\" font-size=\"15\">Bytes against decode speed, all 8-bit pictures: small and "
            "fast is at the lower right</text>\n",
            LEFT);
    axes(out);
    for (size_t i = 0; i < sizeof points / sizeof points[0]; i++)
        point(report, out, points[i].row, points[i].above, points[i].right);
    fprintf(out, "</svg>\n");
}
