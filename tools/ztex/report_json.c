/* SPDX-License-Identifier: Apache-2.0 */
/* The report of a heap as JSON: zipmap_report.schema.json describes it. */
#include "heap_report.h"

static json_t *index_or_null(uint32_t index) {
    return index == AUTHOR_NONE ? json_null() : cmd_json_u64(index);
}

static json_t *matrix_json(const double m[9]) {
    json_t *list = json_array();
    for (int i = 0; i < 9; i++)
        json_array_append_new(list, json_real(m[i]));
    return list;
}

static json_t *photo_json(const heap *h, size_t index) {
    static const char *const states[] = {"unplaced", "root", "placed"};
    const heap_photo *photo = &h->photos[index];
    const author_placing *p = &h->found.placings[index];
    json_t *object = json_pack("{so so s[ii] ss so so}", "file", cmd_json_text(photo->path), "name",
                               cmd_json_text(photo->name), "size", (int)photo->width, (int)photo->height, "state",
                               states[p->state], "group", index_or_null(p->group), "parent", index_or_null(p->parent));
    if (p->state == AUTHOR_UNPLACED) {
        json_object_set_new(object, "reason", json_string(author_reason_name(p->reason)));
        json_object_set_new(object, "text", cmd_json_text(p->text));
    }
    if (p->state != AUTHOR_PLACED)
        return object;
    json_object_set_new(object, "matrix", matrix_json(p->matrix));
    json_object_set_new(object, "root_matrix", matrix_json(p->root_matrix));
    json_object_set_new(object, "ratio", json_real(p->ratio));
    json_object_set_new(object, "contained", json_real(p->contained));
    json_object_set_new(object, "matches", cmd_json_u64(p->matches));
    json_object_set_new(object, "inliers", cmd_json_u64(p->inliers));
    json_object_set_new(object, "residual", json_real(p->residual));
    json_object_set_new(object, "distortion", json_real(p->distortion));
    json_object_set_new(object, "correlation", json_real(p->correlation));
    return object;
}

static json_t *pair_json(const author_pair *pair) {
    json_t *object = json_pack("{so so sb so so}", "coarse", cmd_json_u64(pair->coarse), "fine",
                               cmd_json_u64(pair->fine), "accepted", pair->reason == AUTHOR_REASON_NONE, "matches",
                               cmd_json_u64(pair->matches), "inliers", cmd_json_u64(pair->inliers));
    if (pair->reason != AUTHOR_REASON_NONE) {
        json_object_set_new(object, "reason", json_string(author_reason_name(pair->reason)));
        return object;
    }
    json_object_set_new(object, "ratio", json_real(pair->ratio));
    json_object_set_new(object, "residual", json_real(pair->residual));
    json_object_set_new(object, "correlation", json_real(pair->correlation));
    return object;
}

static json_t *steps_json(const heap_steps *steps) {
    return json_pack("{sf sf sf sf sf}", "median", steps->median, "high", steps->high, "worst", steps->worst, "sharp",
                     steps->sharp, "mean", steps->mean);
}

static json_t *seam_json(const heap_seam *seam) {
    return json_pack("{so so so so sf sf so so}", "photograph", cmd_json_u64(seam->photo), "texture",
                     cmd_json_u64(seam->texture), "patch", cmd_json_u64(seam->patch), "places",
                     cmd_json_u64(seam->places), "opaque", seam->opaque, "partly", seam->partly, "before",
                     steps_json(&seam->before), "after", steps_json(&seam->after));
}

int heap_report_json(const heap_report *report, FILE *stream) {
    const heap *h = report->heap;
    json_t *photos = json_array(), *pairs = json_array(), *seams = json_array(), *roots = json_array();
    for (size_t i = 0; i < h->count; i++)
        json_array_append_new(photos, photo_json(h, i));
    for (size_t i = 0; i < h->found.group_count; i++)
        json_array_append_new(roots, cmd_json_u64(h->found.roots[i]));
    for (size_t i = 0; i < h->found.pair_count; i++)
        json_array_append_new(pairs, pair_json(&h->found.pairs[i]));
    for (size_t i = 0; i < report->seam_count; i++)
        json_array_append_new(seams, seam_json(&report->seams[i]));
    json_t *root = json_pack("{ss so si so so so so}", "report", "make zipmap", "output", cmd_json_text(report->output),
                             "lowpass", HEAP_LOWPASS, "photographs", photos, "roots", roots, "pairs", pairs, "seams",
                             seams);
    int status = cmd_json_print(stream, root);
    json_decref(root);
    return status;
}
