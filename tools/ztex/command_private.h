/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the frame share and verbs do not see. */
#ifndef ZTEX_COMMAND_PRIVATE_H
#define ZTEX_COMMAND_PRIVATE_H

#include "command.h"

#define CMD_MAX_OPTIONS 64 /* of one verb, common ones included */

typedef struct cmd_value {
    const cmd_option *option;
    const char *text; /* NULL for flags */
} cmd_value;

struct cmd_private {
    const cmd_option *options[CMD_MAX_OPTIONS];
    int option_count;
    cmd_value *values; /* in the order of the command line */
    size_t value_count;
    const char **operands;
    zt_limits limits;
    zt_threads *threads;
    zt_parallel parallel;
    int parallel_ready;
    int wants_help, wants_version;
};

/* parse.c: fills args from argv[0..argc), the words behind the verb. Prints the message on failure. */
int cmd_parse(cmd_args *args, int argc, char **argv);
/* Checks a value of an option; NULL or a message in text (size bytes) that follows "--name: ". */
int cmd_check_value(const cmd_option *option, const char *value, char *text, size_t size);
int cmd_parse_u64(const char *text, uint64_t *out);  /* 0, or -1 */
int cmd_parse_size(const char *text, uint64_t *out); /* 0, or -1 */
/* The index-th word of "a|b|c" into dst; 0, or -1 behind the last. */
int cmd_choice_word(const char *choices, int index, char *dst, size_t size);

/* progress.c */
void cmd_signals_install(void);
void cmd_progress_clear(void);
int cmd_temporary_register(const char *name); /* to be removed by a second signal; a slot, or -1: no room */
void cmd_temporary_forget(const char *name);

/* Exit codes for the help. */
typedef struct cmd_exit_text {
    cmd_status status;
    const char *text;
} cmd_exit_text;
extern const cmd_exit_text cmd_exit_texts[]; /* text NULL ends it */
extern const char *const cmd_overview;       /* description of the whole command */

/* Writes text with its lines broken at width columns and indented; lines that begin with a space stay. */
void cmd_wrap_print(FILE *stream, const char *text, int indent, int width);
/* "-o, --output FILE" or, with equals, "--output=FILE" parts into dst. */
void cmd_option_heading(const cmd_option *option, char *dst, size_t size);

#endif
