/* SPDX-License-Identifier: Apache-2.0 */
/* ztex recover: a valid file out of what is left of a damaged one. */
#include "file_io.h"

#include <inttypes.h>
#include <string.h>

static const cmd_option options[] = {
    {.name = "output", .letter = 'o', .metavar = "FILE", .kind = CMD_TEXTURE, .help = "The file to write. Required."},
    {.name = "json", .letter = 'j', .help = "Print a report as JSON (spec/recover.schema.json)."},
    {.name = "max",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "20",
     .max = 1000000,
     .help = "Lost tiles that are listed; all are counted."},
    {0}};

static const cmd_example examples[] = {
    {"ztex recover broken.ztex -o saved.ztex", "Save what can be saved."},
    {"ztex recover --json broken.ztex -o saved.ztex | jq .tiles_replaced", "Count what was lost."},
    {0}};

typedef struct loss_list {
    cmd_progress progress;
    uint64_t most, count;
    int as_json;
    json_t *array;
} loss_list;

static const char *fill_name(zt_fill fill) {
    return fill == ZT_FILL_COARSER ? "coarser" : fill == ZT_FILL_FINER ? "finer" : "zero";
}

static const char *fill_text(zt_fill fill) {
    return fill == ZT_FILL_COARSER ? "filled from a coarser level"
           : fill == ZT_FILL_FINER ? "filled from a finer level"
                                   : "filled with zeros";
}

/* The text goes out at once, so that a file with millions of losses needs no memory for them. */
static int take_loss(void *user, const zt_loss *loss) {
    loss_list *list = user;
    if (list->count++ >= list->most)
        return cmd_interrupted();
    if (!list->as_json) {
        cmd_progress_end(&list->progress);
        fprintf(stderr, "  lost: image %u, level %u, tile %" PRIu64 ": %s\n", (unsigned)loss->image,
                (unsigned)loss->level, loss->tile, fill_text(loss->fill));
        return cmd_interrupted();
    }
    json_t *object = json_object();
    json_object_set_new(object, "image", json_integer(loss->image));
    json_object_set_new(object, "level", json_integer(loss->level));
    json_object_set_new(object, "tile", cmd_json_u64(loss->tile));
    json_object_set_new(object, "fill", json_string(fill_name(loss->fill)));
    json_array_append_new(list->array, object);
    return cmd_interrupted();
}

static int step(void *user, double done) {
    return cmd_progress_step(&((loss_list *)user)->progress, done);
}

static int print_json(const zt_recover_report *r, loss_list *list) {
    json_t *object = json_object();
    json_object_set_new(object, "complete", json_boolean(r->complete));
    json_object_set_new(object, "directory_intact", json_boolean(r->directory_intact));
    json_object_set_new(object, "chunks_expected", json_integer(r->chunks_expected));
    json_object_set_new(object, "chunks_intact", json_integer(r->chunks_intact));
    json_object_set_new(object, "tiles", cmd_json_u64(r->tiles));
    json_object_set_new(object, "tiles_copied", cmd_json_u64(r->tiles_copied));
    json_object_set_new(object, "tiles_replaced", cmd_json_u64(r->tiles_replaced));
    json_object_set_new(object, "textures_kept", json_integer(r->textures_kept));
    json_object_set_new(object, "textures_lost", json_integer(r->textures_lost));
    json_object_set_new(object, "textures_rebuilt", json_integer(r->textures_rebuilt));
    json_object_set_new(object, "metadata_pairs", json_integer(r->metadata_pairs));
    json_object_set_new(object, "chunks_kept", json_integer(r->chunks_kept));
    json_object_set_new(object, "chunks_dropped", json_integer(r->chunks_dropped));
    json_object_set(object, "losses", list->array);
    int status = cmd_json_print(stdout, object);
    json_decref(object);
    return status;
}

static void print_text(const cmd_args *args, const char *name, const zt_recover_report *r, const loss_list *list) {
    if (list->count > list->most)
        fprintf(stderr, "  and %" PRIu64 " tiles more\n", list->count - list->most);
    cmd_note(args, "%s: %s", name, r->complete ? "nothing was lost" : "saved with losses");
    cmd_note(args, "  directory %s; %u of %u chunks intact", r->directory_intact ? "intact" : "damaged",
             (unsigned)r->chunks_intact, (unsigned)r->chunks_expected);
    cmd_note(args, "  tiles: %" PRIu64 " of %" PRIu64 " copied, %" PRIu64 " replaced", r->tiles_copied, r->tiles,
             r->tiles_replaced);
    cmd_note(args, "  textures: %u kept, %u lost, %u made anew as \"recovered N\"", (unsigned)r->textures_kept,
             (unsigned)r->textures_lost, (unsigned)r->textures_rebuilt);
    cmd_note(args, "  metadata: %u pairs; other chunks: %u kept, %u not safe to copy", (unsigned)r->metadata_pairs,
             (unsigned)r->chunks_kept, (unsigned)r->chunks_dropped);
}

static int recover(cmd_args *args, const file_io *input, const char *output, zt_recover_report *report,
                   loss_list *list) {
    const char *name = cmd_input_name(args->operands[0]);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_writer *writer;
    zt_recover_options recover_options = {
        .size = sizeof recover_options, .limits = cmd_limits(args), .user = list, .loss = take_loss, .progress = step};
    int status = cmd_writer_open(args, output, NULL, &writer);
    if (status != CMD_OK)
        return status;
    cmd_progress_begin(&list->progress, args, "recovering");
    zt_result result = zt_recover(&input->io, writer, &recover_options, &diag, report);
    cmd_progress_end(&list->progress);
    status = result == ZT_OK ? cmd_writer_finish(output, writer) : cmd_fail_result(name, result, &diag);
    zt_writer_close(writer);
    return status;
}

static int run(cmd_args *args) {
    const char *output = cmd_text(args, "output");
    zt_recover_report report;
    file_io input;
    if (!output)
        return cmd_usage(args, "--output is missing: the damaged file is never changed");
    int status = cmd_check_output(output, args->operands, 1);
    if (status == CMD_OK && cmd_given(args, "json") && strcmp(output, "-") == 0)
        status = cmd_usage(args, "--json and the file cannot both go to standard output");
    if (status == CMD_OK)
        status = file_io_open(args, args->operands[0], &input);
    if (status != CMD_OK)
        return status;
    loss_list list = {.most = cmd_integer(args, "max"), .as_json = cmd_given(args, "json"), .array = json_array()};
    if (args->quiet && !list.as_json)
        list.most = 0;
    status = recover(args, &input, output, &report, &list);
    if (status == CMD_OK && list.as_json)
        status = print_json(&report, &list);
    else if (status == CMD_OK && !args->quiet)
        print_text(args, cmd_input_name(args->operands[0]), &report, &list);
    json_decref(list.array);
    file_io_close(&input);
    return status == CMD_OK && !report.complete ? CMD_LOSS : status;
}

const cmd_verb verb_recover = {
    .name = "recover",
    .summary = "Save what is left of a damaged or truncated file",
    .synopsis = "[OPTION]... DAMAGED -o FILE",
    .text = "Writes a new, valid file with everything that is intact: chunks are found by the directory or by their "
            "heads, and believed when their hashes are right; texels are believed tile by tile and copied without "
            "coding them anew.\n\n"
            "Lost tiles are filled from the next coarser level where there is one, else with zeros; the coverage of "
            "patches with zeros, so that what lies beneath shows. When the list of textures is lost, each image "
            "becomes a texture called \"recovered N\". Without an intact IMAG chunk nothing can be saved.\n\n"
            "The exit code is 0 when nothing was lost and 8 when something was. The damaged file is not touched.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 1,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
