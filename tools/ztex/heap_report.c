/* SPDX-License-Identifier: Apache-2.0 */
/* Making the report: beside the file that was asked for, a small one of the pictures as they were, and what lies between. */
#include "heap_report.h"

#include <stdlib.h>
#include <string.h>

static int ends_with(const char *text, const char *end) {
    size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

/* The pictures before adjustment, as a temporary file beside the result; its malloc'd name in *path. */
static int make_before(const heap *h, const char *output, char **path) {
    json_t *description = NULL;
    *path = cmd_temporary(output);
    int status = *path ? heap_scene(h, HEAP_BEFORE, "", &description) : CMD_IO;
    zt_writer_options fast = {.size = sizeof fast, .effort = 1, .flags = ZT_WRITE_NO_FSYNC};
    if (status == CMD_OK)
        status = heap_store(h->args, description, *path, &fast, "comparing");
    json_decref(description);
    return status;
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
        status = ends_with(path, ".json") ? heap_report_json(report, output.stream)
                                          : heap_report_html(report, output.stream);
    if (status == CMD_OK)
        return cmd_output_commit(&output);
    cmd_output_drop(&output);
    return status;
}

int heap_write_report(const heap *h, const char *output, const char *path) {
    heap_report report = {.heap = h, .output = output};
    cmd_input before = {0}, after = {0};
    char *temporary = NULL;
    int status = make_before(h, output, &temporary);
    if (status == CMD_OK)
        status = cmd_open(h->args, temporary, 0, &before);
    if (status == CMD_OK)
        status = cmd_open(h->args, output, 0, &after);
    report.before = before.file;
    report.after = after.file;
    if (status == CMD_OK)
        status = list_seams(&report);
    if (status == CMD_OK)
        status = heap_measure_seams(&report);
    if (status == CMD_OK)
        status = write_to(&report, path);
    free(report.seams);
    cmd_close(&after);
    cmd_close(&before);
    cmd_temporary_drop(temporary);
    return status;
}
