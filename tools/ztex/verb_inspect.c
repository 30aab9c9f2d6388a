/* SPDX-License-Identifier: Apache-2.0 */
/* ztex inspect: what is in a file, as far as it can be read. */
#include "file_io.h"
#include "inspect.h"

#include <stdlib.h>
#include <string.h>

static const cmd_option options[] = {
    {.name = "json",
     .letter = 'j',
     .help = "Print one JSON object for each file (spec/inspect.schema.json), also for broken ones."},
    {.name = "tree", .letter = 't', .help = "Show the levels of each image, with their places in the file."},
    {.name = "tiles", .help = "Show also the tiles, with place, size, codec and hash. Implies --tree."},
    {.name = "patches", .letter = 'p', .help = "Show all patches of zipmaps, not only the first sixteen."},
    {.name = "textconv", .help = "For git diff: leave out the name of the file, and end with 0 also for broken files."},
    {0}};

static const cmd_example examples[] = {{"ztex inspect brick.ztex", "See what is in a file."},
                                       {"ztex inspect --tiles brick.ztex", "See where each tile is."},
                                       {"ztex inspect --json brick.ztex | jq .images[0].width", "Ask for one number."},
                                       {"git config diff.ztex.textconv 'ztex inspect --textconv --tiles'",
                                        "Let git show what changed (with '*.ztex diff=ztex' in .gitattributes)."},
                                       {0}};

/* Strict first; what fails is opened as far as it goes, and keeps the error of the first try. */
static zt_result open_file(ins_job *job, const file_io *input, zt_file **file) {
    zt_open_options open = {.size = sizeof open, .limits = cmd_limits(job->args)};
    zt_result result = zt_open_io(&input->io, &open, &job->error, file);
    job->whole = result == ZT_OK;
    if (result == ZT_TRUNCATED) {
        open.flags = ZT_OPEN_BEST_EFFORT;
        if (zt_open_io(&input->io, &open, NULL, file) != ZT_OK)
            *file = NULL;
    }
    return result;
}

static int take_chunk(void *user, const zt_chunk_info *chunk, int intact) {
    ins_job *job = user;
    if (job->salvaged_count == INS_SALVAGED)
        return 1;
    job->salvaged[job->salvaged_count].info = *chunk;
    job->salvaged[job->salvaged_count++].intact = intact;
    return 0;
}

static int show(ins_job *job) {
    if (!cmd_given(job->args, "json")) {
        ins_text(job);
        return ferror(stdout) ? cmd_fail(CMD_IO, "standard output: writing failed") : CMD_OK;
    }
    json_t *object = ins_json(job);
    int status = cmd_json_print(stdout, object);
    json_decref(object);
    return status;
}

static int inspect(cmd_args *args, const char *path) {
    ins_job *job = calloc(1, sizeof *job);
    file_io input;
    zt_file *file = NULL;
    int status = job ? file_io_open(args, path, &input) : cmd_fail(CMD_INTERNAL, "out of memory");
    if (status != CMD_OK) {
        free(job);
        return status;
    }
    job->args = args;
    job->name = cmd_input_name(path);
    job->tiles = cmd_given(args, "tiles");
    job->tree = cmd_given(args, "tree") || job->tiles;
    job->patches = cmd_given(args, "patches");
    job->textconv = cmd_given(args, "textconv");
    zt_result result = open_file(job, &input, &file);
    job->file = file;
    /* What no open accepts may still have chunks that can be found. */
    if (!file)
        (void)zt_find_chunks(&input.io, cmd_limits(args), job, take_chunk, NULL);
    status = show(job);
    if (status == CMD_OK && result != ZT_OK && !job->textconv)
        status = cmd_fail_result(job->name, result, &job->error);
    if (cmd_interrupted())
        status = cmd_cancelled();
    zt_close(file);
    file_io_close(&input);
    free(job);
    return status;
}

static int run(cmd_args *args) {
    int worst = CMD_OK;
    for (size_t i = 0; i < args->operand_count && !cmd_interrupted(); i++) {
        if (i > 0 && !cmd_given(args, "json"))
            printf("\n");
        int status = inspect(args, args->operands[i]);
        if (worst == CMD_OK)
            worst = status;
    }
    return cmd_interrupted() ? CMD_CANCELLED : worst;
}

const cmd_verb verb_inspect = {
    .name = "inspect",
    .summary = "Show what is in a texture file",
    .synopsis = "[OPTION]... FILE...",
    .text = "Shows chunks, textures with their layers and patches, images with format, colour and size, and metadata. "
            "Of a file that is damaged it shows what can be read, and then what is wrong.\n\n"
            "Opening a file reads its structure and not its texels; 'ztex validate' looks at everything.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 1,
    .max_operands = 0,
    .common = CMD_WITH_MEMORY,
    .run = run,
};
