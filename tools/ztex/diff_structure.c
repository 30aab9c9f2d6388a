/* SPDX-License-Identifier: Apache-2.0 */
/* Structure: both files as ztex inspect shows them, compared key by key. So nothing that it shows is forgotten here. */
#include "diff.h"
#include "inspect.h"

#include <stdlib.h>
#include <string.h>

/* Where and how something is stored is no difference of what is in a file, and what follows from other keys is told
 * with them. */
static int is_told(const char *key, const json_t *object) {
    static const char *const left_out[] = {"file",       "size",        "offset",       "stored_size", "decoded_size",
                                           "codec",      "stored_hash", "decoded_hash", "unit_offset", "unit_size",
                                           "here",       "box",         "corners",      "finer",       "root_matrix",
                                           "tile_count", "minor",       "account"};
    static const char *const known[] = {"TEXS", "IMAG", "ZPMP", "SLMP", "UMBR", "META", "TEXL"};
    const char *type = json_string_value(json_object_get(object, "type"));
    int unknown_chunk = type != NULL;
    for (size_t i = 0; type && i < sizeof known / sizeof known[0]; i++)
        unknown_chunk = unknown_chunk && strcmp(type, known[i]) != 0;
    if (unknown_chunk && strcmp(key, "decoded_hash") == 0)
        return 1;
    for (size_t i = 0; i < sizeof left_out / sizeof left_out[0]; i++) {
        if (strcmp(key, left_out[i]) == 0)
            return 0;
    }
    return 1;
}

static void compare(dif_job *job, const char *where, const json_t *a, const json_t *b);

static void compare_objects(dif_job *job, const char *where, const json_t *a, const json_t *b) {
    const char *key;
    json_t *value;
    char path[256];
    json_object_foreach((json_t *)(uintptr_t)a, key, value) {
        if (!is_told(key, a))
            continue;
        snprintf(path, sizeof path, "%s%s%s", where, where[0] ? "/" : "", key);
        compare(job, path, value, json_object_get(b, key));
    }
    json_object_foreach((json_t *)(uintptr_t)b, key, value) {
        snprintf(path, sizeof path, "%s%s%s", where, where[0] ? "/" : "", key);
        if (is_told(key, b) && !json_object_get(a, key))
            compare(job, path, NULL, value);
    }
}

static void compare_arrays(dif_job *job, const char *where, const json_t *a, const json_t *b) {
    size_t count_a = json_array_size(a), count_b = json_array_size(b);
    char path[256];
    for (size_t i = 0; i < count_a || i < count_b; i++) {
        snprintf(path, sizeof path, "%s/%zu", where, i);
        compare(job, path, json_array_get(a, i), json_array_get(b, i));
    }
}

/* One line for a value; of a whole object its first words. */
static void describe(const json_t *value, char text[96]) {
    char *all = value ? json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT) : NULL;
    if (all && strlen(all) > 92)
        snprintf(text, 96, "%.89s...", all);
    else
        snprintf(text, 96, "%s", all ? all : "");
    free(all);
}

static void compare(dif_job *job, const char *where, const json_t *a, const json_t *b) {
    char text_a[96], text_b[96];
    if (json_is_object(a) && json_is_object(b)) {
        compare_objects(job, where, a, b);
        return;
    }
    /* Numbers in a row, such as a matrix, are one value. */
    if (json_is_array(a) && json_is_array(b) && !json_is_number(json_array_get(a, 0))) {
        compare_arrays(job, where, a, b);
        return;
    }
    if (a && b && json_equal(a, b))
        return;
    describe(a, text_a);
    describe(b, text_b);
    dif_report(job, "structure", where, a ? text_a : NULL, b ? text_b : NULL);
}

int dif_structure(dif_job *job) {
    ins_job *side = calloc(1, sizeof *side);
    if (!side)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    side->args = job->args;
    side->name = "";
    side->whole = 1;
    side->file = job->a;
    json_t *a = ins_json(side);
    side->file = job->b;
    json_t *b = ins_json(side);
    compare(job, "", a, b);
    json_decref(a);
    json_decref(b);
    free(side);
    return CMD_OK;
}
