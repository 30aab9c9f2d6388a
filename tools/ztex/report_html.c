/* SPDX-License-Identifier: Apache-2.0 */
/* The report of a heap as one page that needs nothing beside it. */
#include "heap_report.h"
#include "report_parts.h"

#include <math.h>
#include <stdlib.h>

/* ---- the graph ------------------------------------------------------------------------------------------- */

static void put_placing(const heap_report *report, uint32_t index, FILE *stream) {
    const heap_photo *photo = &report->heap->photos[index];
    const author_placing *p = &report->heap->found.placings[index];
    fputs("<b>", stream);
    report_put(stream, photo->path);
    fprintf(stream, "</b> %u x %u", (unsigned)photo->width, (unsigned)photo->height);
    if (p->state != AUTHOR_PLACED)
        return;
    fprintf(stream, "; %.2f times as fine, ", p->ratio);
    if (p->matches)
        fprintf(stream, "%u of %u matches agree, ", (unsigned)p->inliers, (unsigned)p->matches);
    else
        fputs("placed by way of other photographs, ", stream);
    fprintf(stream, "residual %.2f pixels, correlation %.3f, %.0f %% inside", p->residual, p->correlation,
            100.0 * p->contained);
    if (fabs(p->distortion) > 1.0)
        fprintf(stream, "; <span class=\"bad\">the lens bends its corners by %.1f pixels</span>", p->distortion);
}

static int put_branch(const heap_report *report, uint32_t index, FILE *stream) {
    const author_registration *found = &report->heap->found;
    int children = 0;
    fputs("<li>", stream);
    int status = report_put_picture(stream, heap_look_photo(report, index), NULL);
    put_placing(report, index, stream);
    for (size_t i = 0; status == CMD_OK && i < found->order_count; i++) {
        if (found->placings[found->order[i]].parent != index)
            continue;
        fputs(children++ ? "" : "\n<ul>\n", stream);
        status = put_branch(report, found->order[i], stream);
    }
    fputs(children ? "</ul>\n</li>\n" : "</li>\n", stream);
    return status;
}

static int put_graph(const heap_report *report, FILE *stream) {
    const author_registration *found = &report->heap->found;
    int status = CMD_OK;
    fputs("<h2>Who is a zoom into whom</h2>\n<ul class=\"tree\">\n", stream);
    for (size_t i = 0; status == CMD_OK && i < found->group_count; i++)
        status = put_branch(report, found->roots[i], stream);
    fputs("</ul>\n<p class=\"note\">Residual: what is left of the shifts between a photograph and its parent, in the "
          "photograph's own "
          "pixels. More than two or three say that the thing is not flat, that it moved, or that the lens bends lines. "
          "Correlation: how alike both are at the parent's resolution; 1 is the same.</p>\n",
          stream);
    return status;
}

static int put_unplaced(const heap_report *report, FILE *stream) {
    const heap *h = report->heap;
    int count = 0, status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && i < h->count; i++) {
        if (h->found.placings[i].state != AUTHOR_UNPLACED)
            continue;
        fputs(count++ ? "" : "<h2>Left out</h2>\n<ul class=\"tree\">\n", stream);
        fputs("<li>", stream);
        status = report_put_picture(stream, heap_look_photo(report, (uint32_t)i), NULL);
        fputs("<b>", stream);
        report_put(stream, h->photos[i].path);
        fprintf(stream, "</b>: <span class=\"bad\">%s</span>; ", author_reason_name(h->found.placings[i].reason));
        report_put(stream, h->found.placings[i].text);
        fputs("</li>\n", stream);
    }
    fputs(count ? "</ul>\n" : "", stream);
    return status;
}

/* ---- seams ----------------------------------------------------------------------------------------------- */

static void put_steps(FILE *stream, const char *name, const heap_steps *s) {
    fprintf(stream,
            "<tr><td>%s</td><td class=\"n\">%.2f</td><td class=\"n\">%.2f</td><td class=\"n\">%.2f</td>"
            "<td class=\"n\">%.2f</td><td class=\"n\">%.2f</td></tr>\n",
            name, s->median, s->high, s->worst, s->sharp, s->mean);
}

static int put_seam(const heap_report *report, const heap_seam *seam, FILE *stream) {
    fputs("<h3>", stream);
    report_put(stream, report->heap->photos[seam->photo].path);
    fputs("</h3>\n<div class=\"strip\">\n", stream);
    int status = report_put_picture(stream, heap_look_view(report, report->before, seam), "before");
    if (status == CMD_OK)
        status = report_put_picture(stream, heap_look_view(report, report->after, seam), "after");
    if (status == CMD_OK)
        status = report_put_picture(stream, heap_look_mask(report, seam), "mask: white is opaque");
    fprintf(stream, "<div><table>\n<tr><th>steps, of 255</th><th class=\"n\">median</th><th class=\"n\">95 %%</th>"
                    "<th class=\"n\">worst</th><th class=\"n\">sharpness</th><th class=\"n\">mean colour</th></tr>\n");
    put_steps(stream, "before", &seam->before);
    put_steps(stream, "after", &seam->after);
    fprintf(stream, "</table>\n<p>%.0f %% opaque, %.0f %% fading; %zu places measured</p></div>\n</div>\n",
            100.0 * seam->opaque, 100.0 * seam->partly, seam->places);
    return status;
}

static int put_seams(const heap_report *report, FILE *stream) {
    int status = CMD_OK;
    fprintf(
        stream,
        "<h2>Seams</h2>\n<p class=\"note\">Steps are the differences between the mean colours of a photograph and of "
        "its "
        "parent, in squares of %d texels of the parent through which the seam goes. A large median that stays says "
        "that the "
        "colours differ in a way that no gain explains, such as another light; a large worst one that something is "
        "there in "
        "one photograph and not in the other. Sharpness is the worst difference on the seam itself, where edges are "
        "not equally sharp in both.</p>\n",
        HEAP_LOWPASS);
    for (size_t i = 0; status == CMD_OK && i < report->seam_count; i++)
        status = cmd_interrupted() ? cmd_cancelled() : put_seam(report, &report->seams[i], stream);
    return status;
}

/* ---- pairs ----------------------------------------------------------------------------------------------- */

static void put_pair(const heap *h, const author_pair *pair, FILE *stream) {
    fputs("<tr><td>", stream);
    report_put(stream, h->photos[pair->fine].path);
    fputs("</td><td>", stream);
    report_put(stream, h->photos[pair->coarse].path);
    fprintf(stream, "</td><td class=\"n\">%u</td><td class=\"n\">%u</td>", (unsigned)pair->matches,
            (unsigned)pair->inliers);
    if (pair->reason == AUTHOR_REASON_NONE)
        fprintf(stream,
                "<td class=\"n\">%.2f</td><td class=\"n\">%.2f</td><td class=\"n\">%.3f</td><td>holds</td></tr>\n",
                pair->ratio, pair->residual, pair->correlation);
    else
        fprintf(stream, "<td></td><td></td><td></td><td class=\"bad\">%s</td></tr>\n",
                author_reason_name(pair->reason));
}

static void put_pairs(const heap *h, FILE *stream) {
    fputs("<h2>Pairs that were looked at</h2>\n<table>\n<tr><th>finer</th><th>coarser</th><th class=\"n\">matches</th>"
          "<th class=\"n\">agree</th><th class=\"n\">ratio</th><th class=\"n\">residual</th>"
          "<th class=\"n\">correlation</th><th></th></tr>\n",
          stream);
    for (int holds = 1; holds >= 0; holds--)
        for (size_t i = 0; i < h->found.pair_count; i++)
            if ((h->found.pairs[i].reason == AUTHOR_REASON_NONE) == holds)
                put_pair(h, &h->found.pairs[i], stream);
    fputs("</table>\n", stream);
}

int heap_report_html(const heap_report *report, FILE *stream) {
    const heap *h = report->heap;
    fputs(report_head, stream);
    fputs("<title>", stream);
    report_put(stream, report->output);
    fputs("</title>\n<h1>", stream);
    report_put(stream, report->output);
    fprintf(stream, "</h1>\n<p>%zu photographs, %zu of them used, %zu texture%s.</p>\n", h->count, h->found.order_count,
            h->found.group_count, h->found.group_count == 1 ? "" : "s");
    int status = put_unplaced(report, stream);
    if (status == CMD_OK)
        status = put_graph(report, stream);
    if (status == CMD_OK)
        status = put_seams(report, stream);
    put_pairs(h, stream);
    fputs("</html>\n", stream);
    return status;
}
