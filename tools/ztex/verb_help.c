/* SPDX-License-Identifier: Apache-2.0 */
/* ztex help: texts for people, manual readers and shells. */
#include "command.h"

#include <string.h>

static const cmd_option options[] = {
    {.name = "man", .help = "Print the man page in troff: of VERB, or of the whole command."},
    {.name = "completion",
     .metavar = "SHELL",
     .kind = CMD_CHOICE,
     .choices = "bash|zsh|fish",
     .help = "Print the script that completes words in this shell."},
    {0}};

static const cmd_example examples[] = {
    {"ztex help make", "Say how to make a texture file."},
    {"ztex help make zipmap", "Say how to make a zipmap from a heap of photographs."},
    {"ztex help formats", "List the texel formats."},
    {"ztex help --man make | man -l -", "Read the man page of a verb."},
    {"source <(ztex help --completion bash)", "Complete words in this shell."},
    {0}};

static int print_formats(void) {
    for (uint32_t i = 0; zt_get_format(i); i++) {
        const zt_format_info *f = zt_get_format(i);
        printf("%4u  %-28s %2u x %-2u  %2u bytes  %u channels%s%s\n", (unsigned)f->format, f->name, f->block_width,
               f->block_height, f->block_bytes, f->channels, f->has_alpha ? ", alpha" : "",
               f->is_plain ? "" : ", stored only");
    }
    return CMD_OK;
}

static int run(cmd_args *args) {
    const char *shell = cmd_text(args, "completion");
    const cmd_verb *verb = NULL;
    size_t used = 0;
    if (shell && args->operand_count > 0)
        return cmd_usage(args, "--completion is for all verbs at once: leave '%s' out", args->operands[0]);
    if (shell)
        return cmd_completion(stdout, shell);
    if (args->operand_count == 1 && strcmp(args->operands[0], "formats") == 0)
        return print_formats();
    if (args->operand_count > 0) {
        verb = cmd_match_verb(args->operands, args->operand_count, &used);
        if (!verb || used < args->operand_count)
            return cmd_usage(args, "there is no verb '%s%s%s'", args->operands[0], args->operand_count > 1 ? " " : "",
                             args->operand_count > 1 ? args->operands[1] : "");
    }
    return cmd_given(args, "man") ? cmd_help_man(stdout, verb) : cmd_help_print(stdout, verb);
}

const cmd_verb verb_help = {
    .name = "help",
    .summary = "Say what the verbs do, print man pages and completions",
    .synopsis = "[--man] [VERB | formats]\n--completion SHELL",
    .text = "Without anything it lists the verbs; with a verb it prints what 'ztex VERB --help' "
            "prints. 'ztex help formats' lists the texel formats with their numbers.",
    .options = options,
    .examples = examples,
    .operand = CMD_COMMAND,
    .min_operands = 0,
    .max_operands = 2,
    .run = run,
};
