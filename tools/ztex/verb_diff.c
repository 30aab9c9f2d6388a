/* SPDX-License-Identifier: Apache-2.0 */
/* ztex diff: what is different in two files. */
#include "diff.h"

static const cmd_option options[] = {
    {.name = "json", .letter = 'j', .help = "Print a JSON object (spec/diff.schema.json)."},
    {.name = "structure-only", .letter = 's', .help = "Compare no texels."},
    {.name = "rendered",
     .letter = 'r',
     .help = "Compare only what the textures look like, by lookups on a grid: tiles, levels and patches may differ."},
    {.name = "size",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "256",
     .min = 1,
     .max = 16384,
     .help = "Points in each direction of the grid of --rendered."},
    {.name = "tolerance",
     .metavar = "X",
     .kind = CMD_REAL,
     .fallback = "0",
     .help = "Values of texels that differ by no more are the same: 0.004 is one step of 8 bits."},
    {0}};

static const cmd_example examples[] = {
    {"ztex diff old.ztex new.ztex", "See what is different."},
    {"ztex diff --rendered --tolerance 0.01 a.ztex b.ztex", "See whether they look alike."},
    {"ztex diff -q a.ztex b.ztex && echo same", "Only the exit code."},
    {0}};

static int compare(dif_job *job) {
    if (cmd_given(job->args, "rendered"))
        return dif_rendered(job);
    int status = dif_structure(job);
    if (status == CMD_OK && !cmd_given(job->args, "structure-only"))
        status = dif_texels(job);
    return status;
}

static int print_json(const dif_job *job) {
    json_t *object = json_object();
    json_object_set_new(object, "a", cmd_json_text(cmd_input_name(job->args->operands[0])));
    json_object_set_new(object, "b", cmd_json_text(cmd_input_name(job->args->operands[1])));
    json_object_set_new(object, "same", json_boolean(job->count == 0));
    json_object_set(object, "differences", job->list);
    int status = cmd_json_print(stdout, object);
    json_decref(object);
    return status;
}

static int run(cmd_args *args) {
    cmd_input a, b;
    dif_job job = {.args = args,
                   .as_json = cmd_given(args, "json"),
                   .tolerance = cmd_real(args, "tolerance"),
                   .size = (uint32_t)cmd_integer(args, "size")};
    if (cmd_given(args, "rendered") && cmd_given(args, "structure-only"))
        return cmd_usage(args, "--rendered and --structure-only exclude each other");
    if (job.tolerance < 0)
        return cmd_usage(args, "--tolerance is not negative");
    int status = cmd_open(args, args->operands[0], 0, &a);
    if (status != CMD_OK)
        return status;
    status = cmd_open(args, args->operands[1], 0, &b);
    if (status != CMD_OK) {
        cmd_close(&a);
        return status;
    }
    job.a = a.file;
    job.b = b.file;
    job.list = json_array();
    status = compare(&job);
    if (status == CMD_OK && job.as_json)
        status = print_json(&job);
    json_decref(job.list);
    cmd_close(&a);
    cmd_close(&b);
    return status == CMD_OK && job.count > 0 ? CMD_DIFFERENT : status;
}

const cmd_verb verb_diff = {
    .name = "diff",
    .summary = "Compare two texture files",
    .synopsis = "[OPTION]... A B",
    .text =
        "Compares what is in two files: textures, patches, images, metadata, chunks of other types, cells of silmaps, "
        "arrays of umbrellas, and the texels of all levels. How it is stored (places, codecs, tiles' sizes in the "
        "file) is no "
        "difference.\n\n"
        "Texels of uncompressed formats are compared as values, from 0 to 1 for UNORM, with the largest difference "
        "and the PSNR; those of other formats, cells and umbrellas, as bytes.\n\n"
        "The exit code is 0 when nothing differs and 7 when something does.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 2,
    .max_operands = 2,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
