/* SPDX-License-Identifier: Apache-2.0 */
/* From argv to a verb: which one, its options, its values, its end. */
#include "command_private.h"

#include <stdlib.h>
#include <string.h>

char *cmd_dashed(const cmd_verb *verb, char dst[CMD_VERB_NAME]) {
    snprintf(dst, CMD_VERB_NAME, "%s", verb->name);
    for (char *at = dst; *at; at++)
        if (*at == ' ')
            *at = '-';
    return dst;
}

const cmd_verb *cmd_find_verb(const char *name) {
    char dashed[CMD_VERB_NAME];
    for (size_t i = 0; cmd_verbs[i]; i++)
        if (strcmp(cmd_verbs[i]->name, name) == 0 || strcmp(cmd_dashed(cmd_verbs[i], dashed), name) == 0)
            return cmd_verbs[i];
    return NULL;
}

const char *cmd_second_word(const cmd_verb *verb, const char *first) {
    size_t length = strlen(first);
    return strncmp(verb->name, first, length) == 0 && verb->name[length] == ' ' ? verb->name + length + 1 : NULL;
}

const cmd_verb *cmd_match_verb(const char *const *words, size_t count, size_t *used) {
    *used = 2;
    for (size_t i = 0; count >= 2 && cmd_verbs[i]; i++) {
        const char *second = cmd_second_word(cmd_verbs[i], words[0]);
        if (second && strcmp(second, words[1]) == 0)
            return cmd_verbs[i];
    }
    *used = 1;
    return count > 0 ? cmd_find_verb(words[0]) : NULL;
}

/* ---- values ------------------------------------------------------------------------------------ */

static const cmd_option *option_of(const cmd_args *args, const char *name) {
    const struct cmd_private *p = args->private_data;
    for (int i = 0; i < p->option_count; i++)
        if (strcmp(p->options[i]->name, name) == 0)
            return p->options[i];
    fprintf(stderr, "ztex: bug: verb %s has no option --%s\n", args->verb->name, name);
    abort();
}

int cmd_given(const cmd_args *args, const char *name) {
    const cmd_option *option = option_of(args, name);
    int count = 0;
    for (size_t i = 0; i < args->private_data->value_count; i++)
        count += args->private_data->values[i].option == option;
    return count;
}

const char *cmd_text_at(const cmd_args *args, const char *name, size_t index) {
    const cmd_option *option = option_of(args, name);
    const struct cmd_private *p = args->private_data;
    for (size_t i = 0; i < p->value_count; i++)
        if (p->values[i].option == option && index-- == 0)
            return p->values[i].text;
    return NULL;
}

const char *cmd_text(const cmd_args *args, const char *name) {
    int count = cmd_given(args, name);
    return count > 0 ? cmd_text_at(args, name, (size_t)count - 1) : option_of(args, name)->fallback;
}

uint64_t cmd_integer(const cmd_args *args, const char *name) {
    const char *text = cmd_text(args, name);
    uint64_t value = 0;
    if (!text)
        return 0;
    int failed = option_of(args, name)->kind == CMD_SIZE ? cmd_parse_size(text, &value) : cmd_parse_u64(text, &value);
    return failed ? 0 : value;
}

double cmd_real(const cmd_args *args, const char *name) {
    const char *text = cmd_text(args, name);
    return text ? strtod(text, NULL) : 0.0;
}

int cmd_choice(const cmd_args *args, const char *name) {
    const char *text = cmd_text(args, name);
    return text ? cmd_choice_index(option_of(args, name)->choices, text) : -1;
}

const zt_limits *cmd_limits(const cmd_args *args) {
    return &args->private_data->limits;
}

const zt_parallel *cmd_parallel(cmd_args *args) {
    struct cmd_private *p = args->private_data;
    if (!p->parallel_ready) {
        p->parallel_ready = 1;
        uint64_t count = args->verb->common & CMD_WITH_THREADS ? cmd_integer(args, "threads") : 1;
        /* Without threads the work is done all the same, in this one. */
        if (count != 1 && zt_threads_open((unsigned)count, &p->threads) == ZT_OK)
            p->parallel = zt_threads_parallel(p->threads);
    }
    return p->threads ? &p->parallel : NULL;
}

/* ---- start and end ------------------------------------------------------------------------------ */

static void args_release(cmd_args *args) {
    struct cmd_private *p = args->private_data;
    zt_threads_close(p->threads);
    free(p->values);
    free(p->operands);
}

/* Data that never reached standard output is an error even when the verb went well. */
static int flush_output(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return status;
    if (status == CMD_OK)
        return cmd_fail(CMD_IO, "standard output: writing failed");
    return status;
}

static int print_version(void) {
    printf("ztex %d.%d.%d (libzt %s)\n", ZT_VERSION_MAJOR, ZT_VERSION_MINOR, ZT_VERSION_PATCH, zt_version_string());
    return CMD_OK;
}

static int run_verb(const cmd_verb *verb, int argc, char **argv) {
    struct cmd_private data = {0};
    cmd_args args = {.verb = verb, .private_data = &data};
    int status = cmd_parse(&args, argc, argv);
    if (status == CMD_OK && data.wants_help)
        status = cmd_help_print(stdout, verb);
    else if (status == CMD_OK && data.wants_version)
        status = print_version();
    else if (status == CMD_OK)
        status = verb->run(&args);
    args_release(&args);
    return flush_output(status);
}

static int unknown_verb(const char *word) {
    const char *names[64];
    size_t count = 0;
    for (; cmd_verbs[count] && count < 64; count++)
        names[count] = cmd_verbs[count]->name;
    const char *near = cmd_nearest(word, names, count);
    cmd_error("there is no verb '%s'", word);
    if (near)
        cmd_hint("Did you mean '%s'?", near);
    cmd_hint("'ztex help' lists the verbs.");
    return CMD_USAGE;
}

/* ztex-inspect is ztex inspect: the verb of the name the program was started with, or NULL. */
static const cmd_verb *verb_of_program(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *dash = strncmp(name, "ztex-", 5) == 0 ? name + 5 : NULL;
    return dash ? cmd_find_verb(dash) : NULL;
}

/* first is the verb's first word; argv continues behind it and may begin with the second. */
static const cmd_verb *verb_of_words(const char *first, int argc, char **argv, size_t *used) {
    const char *words[2] = {first, argc > 0 ? argv[0] : NULL};
    return cmd_match_verb(words, argc > 0 ? 2 : 1, used);
}

int cmd_main(int argc, char **argv) {
    cmd_signals_install();
    const cmd_verb *verb = argc > 0 ? verb_of_program(argv[0]) : NULL;
    size_t used = 1;
    if (verb) {
        verb = verb_of_words(verb->name, argc - 1, argv + 1, &used);
        return run_verb(verb, argc - (int)used, argv + used);
    }
    if (argc < 2) {
        cmd_help_print(stderr, NULL);
        return CMD_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return flush_output(cmd_help_print(stdout, NULL));
    if (strcmp(argv[1], "--version") == 0)
        return flush_output(print_version());
    if (argv[1][0] == '-') {
        cmd_error("the verb comes first, then its options: '%s' is no verb", argv[1]);
        cmd_hint("'ztex help' lists the verbs.");
        return CMD_USAGE;
    }
    verb = verb_of_words(argv[1], argc - 2, argv + 2, &used);
    return verb ? run_verb(verb, argc - 1 - (int)used, argv + 1 + used) : unknown_verb(argv[1]);
}
