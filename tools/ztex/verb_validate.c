/* SPDX-License-Identifier: Apache-2.0 */
/* ztex validate: every rule of the format over whole files and folders. */
#include "file_list.h"
#include "validate.h"

#include <stdlib.h>
#include <string.h>

static const cmd_option options[] = {
    {.name = "json", .letter = 'j', .help = "Print one JSON object (spec/validate.schema.json)."},
    {.name = "structure",
     .letter = 's',
     .help = "Check only what opening a file checks: no texels, no metadata. Fast also for large files."},
    {.name = "only",
     .metavar = "RULE,...",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Count only these rules, given by number or by name."},
    {.name = "ignore",
     .metavar = "RULE,...",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Do not count these rules, given by number or by name."},
    {.name = "severity",
     .metavar = "RULE=LEVEL",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Count a rule as error, warning or ignore. Stands above --only and --ignore."},
    {.name = "werror", .help = "Count warnings as errors."},
    {.name = "max",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "5",
     .max = 1000000,
     .help = "Findings of one rule in one file that are shown; the others are counted."},
    {.name = "list-rules", .help = "Print the catalogue of rules, as the other options change it, and end."},
    {0}};

static const cmd_example examples[] = {{"ztex validate brick.ztex", "Check a file."},
                                       {"ztex validate --json textures/ > report.json", "Check all files of a folder."},
                                       {"ztex validate --ignore metadata-reserved-key *.ztex", "Leave out one rule."},
                                       {"ztex validate --list-rules", "See what is checked."},
                                       {0}};

typedef struct totals {
    size_t files, valid, invalid, limited, unread;
    int unread_status;
} totals;

/* The check has one user for both callbacks. */
static int step(void *user, double done) {
    return cmd_progress_step(((vld_file *)user)->progress, done);
}

static void check(cmd_args *args, const char *path, vld_file *file) {
    cmd_progress progress;
    zt_check_options options_of = {.size = sizeof options_of,
                                   .limits = cmd_limits(args),
                                   .parallel = cmd_parallel(args),
                                   .flags = cmd_given(args, "structure") ? ZT_CHECK_STRUCTURE : 0,
                                   .finding = vld_take,
                                   .progress = step};
    zt_check_summary summary = {0};
    zt_result result;
    void *data = NULL;
    size_t size;
    file->name = cmd_input_name(path);
    if (strcmp(path, "-") == 0) {
        file->status = cmd_read_all(args, path, 0, &data, &size);
        if (file->status != CMD_OK)
            return;
    }
    cmd_progress_begin(&progress, args, file->name);
    file->progress = &progress;
    options_of.user = file;
    result = data ? zt_check_memory(data, size, &options_of, &file->diag, &summary)
                  : zt_check_path(path, &options_of, &file->diag, &summary);
    cmd_progress_end(&progress);
    free(data);
    file->complete = result == ZT_OK && summary.complete;
    file->status = cmd_status_of(result);
}

static void count(totals *t, const vld_file *file) {
    t->files++;
    if (file->status != CMD_OK) {
        t->unread++;
        t->unread_status = file->status;
        return;
    }
    t->valid += file->errors == 0;
    t->invalid += file->errors > 0;
    t->limited += file->limits > 0;
}

static int verdict(const totals *t) {
    if (t->invalid > 0)
        return CMD_INVALID;
    if (t->unread > 0)
        return t->unread_status;
    return t->limited > 0 ? CMD_LIMIT : CMD_OK;
}

static json_t *totals_json(const totals *t) {
    json_t *object = json_object();
    json_object_set_new(object, "files", cmd_json_u64(t->files));
    json_object_set_new(object, "valid", cmd_json_u64(t->valid));
    json_object_set_new(object, "invalid", cmd_json_u64(t->invalid));
    json_object_set_new(object, "not_checked", cmd_json_u64(t->unread));
    return object;
}

static int print_end(const totals *t, json_t *reports, int quiet) {
    int status = CMD_OK;
    if (reports) {
        json_t *root = json_object();
        json_object_set_new(root, "files", reports);
        json_object_set_new(root, "summary", totals_json(t));
        status = cmd_json_print(stdout, root);
        json_decref(root);
    } else if (t->files > 1 && !quiet) {
        printf("%zu files: %zu valid, %zu invalid", t->files, t->valid, t->invalid);
        if (t->unread > 0)
            printf(", %zu not checked", t->unread);
        printf("\n");
    }
    if (status == CMD_OK && ferror(stdout))
        status = cmd_fail(CMD_IO, "standard output: writing failed");
    return status;
}

static int check_all(cmd_args *args, const vld_settings *settings, const file_list *list) {
    totals t = {0};
    json_t *reports = cmd_given(args, "json") ? json_array() : NULL;
    for (size_t i = 0; i < list->count; i++) {
        vld_file file = {.settings = settings};
        check(args, list->paths[i], &file);
        if (cmd_interrupted()) {
            vld_file_free(&file);
            json_decref(reports);
            return cmd_cancelled();
        }
        count(&t, &file);
        if (reports)
            json_array_append_new(reports, vld_json(&file));
        else
            vld_print(args, &file);
        vld_file_free(&file);
    }
    int status = print_end(&t, reports, args->quiet);
    return status == CMD_OK ? verdict(&t) : status;
}

static int run(cmd_args *args) {
    vld_settings settings = {0};
    file_list list = {0};
    int status = vld_settings_read(args, &settings);
    if (status == CMD_OK && cmd_given(args, "list-rules")) {
        status = args->operand_count > 0 ? cmd_usage(args, "--list-rules takes no files")
                                         : vld_list_rules(&settings, cmd_given(args, "json"));
    } else if (status == CMD_OK) {
        status = args->operand_count == 0 ? cmd_usage(args, "no file is given") : file_list_read(args, &list);
        if (status == CMD_OK)
            status = check_all(args, &settings, &list);
    }
    file_list_free(&list);
    free(settings.levels);
    return status;
}

const cmd_verb verb_validate = {
    .name = "validate",
    .summary = "Check texture files against every rule of the format",
    .synopsis = "[OPTION]... FILE|FOLDER...\n--list-rules [--json]",
    .text = "Checks whole files, texels included, and names each broken rule with the place in the file. Folders are "
            "searched for .ztex files, at any depth.\n\n"
            "A finding of a rule that occurs often is shown a few times and then counted (--max); the verdict counts "
            "all of them. The exit code is 3 when a file has errors.\n\n"
            "Rules are numbered as in the specification: R5203 is in spec/ztex.md.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 0,
    .max_operands = 0,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
