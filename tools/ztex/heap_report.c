/* SPDX-License-Identifier: Apache-2.0 */
/* Making the report: beside the file that was asked for, one of the pictures as they were, one with
 * adjusted colours but without masks, and what lies between. */
#include "heap_report.h"

#include <stdlib.h>
#include <string.h>

/* A file beside the result that is only looked at. */
typedef struct companion {
    char *path;
    cmd_input input;
} companion;

static int make_companion(const heap *h, heap_purpose purpose, const char *output, companion *out) {
    json_t *description = NULL;
    out->path = cmd_temporary(output);
    int status = out->path ? heap_scene(h, purpose, "", &description) : CMD_IO;
    zt_writer_options fast = {.size = sizeof fast, .effort = 1, .flags = ZT_WRITE_NO_FSYNC};
    if (status == CMD_OK)
        status = heap_store(h->args, description, out->path, &fast, "comparing");
    json_decref(description);
    return status == CMD_OK ? cmd_open(h->args, out->path, 0, &out->input) : status;
}

static void drop_companion(companion *c) {
    cmd_close(&c->input);
    cmd_temporary_drop(c->path);
}

static int list_seams(heap_report *report) {
    const author_registration *found = &report->heap->found;
    uint32_t patch = 0;
    report->seams = calloc(found->order_count ? found->order_count : 1, sizeof *report->seams);
    if (!report->seams)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (size_t i = 0; i < found->order_count; i++) {
        const author_placing *p = &found->placings[found->order[i]];
        patch = p->state == AUTHOR_ROOT ? 0 : patch + 1;
        if (p->state == AUTHOR_PLACED)
            report->seams[report->seam_count++] = (heap_seam){
                .photo = found->order[i], .texture = p->group, .patch = patch};
    }
    return CMD_OK;
}

static int write_to(const heap_report *report, const char *path) {
    cmd_output output = {0};
    int status = cmd_output_open(&output, path, 0);
    if (status == CMD_OK)
        status = cmd_ends_with(path, ".json") ? heap_report_json(report, output.stream)
                                              : heap_report_html(report, output.stream);
    return cmd_output_end(&output, status);
}

int heap_write_report(const heap *h, const char *output, const char *path) {
    heap_report report = {.heap = h, .output = output};
    companion before = {0}, plain = {0};
    cmd_input after = {0};
    int status = make_companion(h, HEAP_BEFORE, output, &before);
    if (status == CMD_OK)
        status = make_companion(h, HEAP_PLAIN, output, &plain);
    if (status == CMD_OK)
        status = cmd_open(h->args, output, 0, &after);
    report.before = before.input.file;
    report.plain = plain.input.file;
    report.after = after.file;
    if (status == CMD_OK)
        status = list_seams(&report);
    if (status == CMD_OK)
        status = heap_measure_seams(&report);
    if (status == CMD_OK)
        status = write_to(&report, path);
    free(report.seams);
    cmd_close(&after);
    drop_companion(&plain);
    drop_companion(&before);
    return status;
}
