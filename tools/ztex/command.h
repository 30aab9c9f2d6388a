/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The frame of the command `ztex`: one table of verbs and options, from which come parsing, --help, man
 * pages and shell completions; and what all verbs share: opening files, messages, exit codes, progress,
 * output that appears whole or not at all, JSON.
 *
 * A verb is one file, verb_NAME.c, that defines one table row:
 *
 *     static const cmd_option options[] = {
 *         {.name = "json", .letter = 'j', .help = "Print JSON."},                          // a flag
 *         {.name = "level", .letter = 'l', .metavar = "N", .kind = CMD_INTEGER, .max = 31,
 *          .fallback = "0", .help = "Mip level."},
 *         {.name = "wrap", .metavar = "MODE", .kind = CMD_CHOICE, .choices = "repeat|clamp",
 *          .fallback = "repeat", .help = "How the edges go on."},
 *         {0}};
 *
 *     static int run(cmd_args *args)
 *     {
 *         cmd_input input;
 *         int status = cmd_open(args, args->operands[0], 0, &input);
 *         if (status != CMD_OK)
 *             return status;
 *         ... input.file is a zt_file; every failed call: return cmd_fail_result(input.name, result, &diag) ...
 *         cmd_close(&input);
 *         return CMD_OK;
 *     }
 *
 *     const cmd_verb verb_inspect = {.name = "inspect", .summary = "Show what is in a texture file", ..., .run = run};
 *
 * Standard output carries data only; messages go to standard error through the functions below.
 * A verb may have two words, as "make zipmap": a verb of its own with a table of its own, which stands in its own file
 * (verb_make_zipmap.c), in cmd_verbs and, with a dash, in ztex_verbs of CMakeLists.txt. Where it is the name of a
 * program, a man page or a shell word, the space is a dash.
 *
 * `-` as an input is standard input, as an output standard output. All functions are for the main thread.
 */
#ifndef ZTEX_COMMAND_H
#define ZTEX_COMMAND_H

#include <stdio.h>

#include <jansson.h>

#include <zt/zt.h>
#include <zt/zt_check.h>
#include <zt/zt_write.h>

#if defined(__GNUC__)
#define CMD_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define CMD_PRINTF(text, first)
#endif

/* Exit codes of all verbs. The texts for the help are in help.c, in this order. */
typedef enum cmd_status {
    CMD_OK = 0,
    CMD_USAGE = 1,       /* the command line, or a scene file, is wrong */
    CMD_IO = 2,          /* reading or writing failed */
    CMD_INVALID = 3,     /* a file is not what it should be: not a .ztex file, corrupt, truncated */
    CMD_INTERNAL = 4,    /* out of memory, or a bug */
    CMD_UNSUPPORTED = 5, /* valid, but not for this version */
    CMD_LIMIT = 6,       /* over a limit: see --memory */
    CMD_DIFFERENT = 7,   /* diff: differences found */
    CMD_LOSS = 8,        /* recover: something could not be saved */
    CMD_CANCELLED = 9    /* interrupted; nothing half-written stays behind */
} cmd_status;

/* ---- the table ---------------------------------------------------------------------------------- */

typedef enum cmd_kind {
    CMD_FLAG = 0,    /* no argument */
    CMD_TEXT = 1,    /* any text */
    CMD_CHOICE = 2,  /* one of .choices */
    CMD_INTEGER = 3, /* unsigned decimal or 0x..., .min to .max (max 0: 2^53) */
    CMD_REAL = 4,    /* a finite number; .min and .max do not apply */
    CMD_SIZE = 5,    /* bytes: 4096, 64K, 512M, 2G (1024-based) */
    CMD_FILE = 6,    /* a path: completes to any file */
    CMD_TEXTURE = 7, /* a path: completes to *.ztex and folders */
    CMD_FOLDER = 8,  /* a path: completes to folders */
    CMD_FORMAT = 9,  /* name of a texel format (zt_find_format_name): checked, completes to all names */
    CMD_COMMAND = 10 /* name of a verb */
} cmd_kind;

typedef struct cmd_option {
    const char *name;    /* long name without dashes; NULL ends the list */
    char letter;         /* short name, or 0. h, q, v are taken */
    const char *metavar; /* "N", "FILE"; NULL: a flag */
    cmd_kind kind;
    const char *choices;  /* CMD_CHOICE: "a|b|c". Also completes CMD_TEXT and CMD_INTEGER, where other words stay
                             allowed;  CMD_INTEGER then accepts these words too: read them with cmd_text */
    const char *fallback; /* shown in the help as default, and the value when the option is not given; NULL: none */
    const char *help;     /* one or more sentences */
    uint64_t min, max;    /* CMD_INTEGER */
    int repeat;           /* 1: may be given several times (cmd_count, cmd_text_at) */
} cmd_option;

typedef struct cmd_example {
    const char *line; /* "ztex make brick.png -o brick.ztex" */
    const char *text; /* what it does; NULL ends the list */
} cmd_example;

enum {
    CMD_WITH_THREADS = 1, /* the verb has --threads N */
    CMD_WITH_MEMORY = 2   /* the verb has --memory SIZE */
};

typedef struct cmd_args cmd_args;

typedef struct cmd_verb {
    const char *name;     /* one word, or two with a space between */
    const char *summary;  /* for the list of verbs: no final stop */
    const char *synopsis; /* "[OPTION]... FILE": what follows the verb; several lines are divided by \n */
    const char
        *text; /* description: paragraphs divided by an empty line; lines that begin with a space stay as they are */
    const cmd_option *options;
    const cmd_example *examples;
    cmd_kind operand;                  /* CMD_FILE, CMD_TEXTURE, ...: for completion */
    size_t min_operands, max_operands; /* max 0: any number */
    unsigned common;                   /* CMD_WITH_... */
    int (*run)(cmd_args *args);        /* returns a cmd_status */
} cmd_verb;

extern const cmd_verb *const cmd_verbs[]; /* verbs.c; ends with NULL */

/* The rows, each defined in the file of its name: `const cmd_verb verb_inspect = {...};` */
extern const cmd_verb verb_make, verb_make_zipmap, verb_make_silmap, verb_make_umbrellas, verb_inspect, verb_validate,
    verb_extract, verb_render, verb_convert, verb_diff, verb_recover, verb_help;

/* ---- the parsed command line -------------------------------------------------------------------- */

struct cmd_args {
    const cmd_verb *verb;
    const char *const *operands; /* in order; "-" stays "-" */
    size_t operand_count;
    int quiet;   /* -q: no progress, no notes, no warnings */
    int verbose; /* -v, counted */
    struct cmd_private *private_data;
};

/* Values, by long name. Asking for a name that is not in the table is a bug and aborts. */
int cmd_given(const cmd_args *args, const char *name);        /* how often it was given */
const char *cmd_text(const cmd_args *args, const char *name); /* last value, else the fallback, else NULL */
uint64_t cmd_integer(const cmd_args *args, const char *name); /* CMD_INTEGER, CMD_SIZE; 0 when there is no value */
double cmd_real(const cmd_args *args, const char *name);      /* CMD_REAL; 0 when there is no value */
int cmd_choice(const cmd_args *args, const char *name); /* CMD_CHOICE: position in choices, from 0; -1: no value */
const char *cmd_text_at(const cmd_args *args, const char *name, size_t index); /* the index-th value given, or NULL */

/* --memory in zt_limits; NULL-free, lives as long as args. Verbs without CMD_WITH_MEMORY get the defaults. */
const zt_limits *cmd_limits(const cmd_args *args);

/* The pool of --threads (default: the processors), opened at first use and closed by the frame. NULL: one thread. */
const zt_parallel *cmd_parallel(cmd_args *args);

/* Of "a|b|c": the position of a word, or -1; and all of them as "a, b, c". */
int cmd_choice_index(const char *choices, const char *word);
void cmd_choice_list(const char *choices, char *dst, size_t size);

/* ---- messages ------------------------------------------------------------------------------------ */

/* "ztex: " + text + newline on standard error; clears a progress line first. Texts from files go through cmd_safe. */
void cmd_error(const char *format, ...) CMD_PRINTF(1, 2);
void cmd_warn(const cmd_args *args, const char *format, ...) CMD_PRINTF(2, 3);    /* "ztex: warning: ", not with -q */
void cmd_note(const cmd_args *args, const char *format, ...) CMD_PRINTF(2, 3);    /* not with -q */
void cmd_verbose(const cmd_args *args, const char *format, ...) CMD_PRINTF(2, 3); /* only with -v */
void cmd_hint(const char *format, ...) CMD_PRINTF(1, 2); /* "      " + what to do, under an error */

/* Prints like cmd_error and returns status: `return cmd_fail(CMD_IO, "%s: %s", ...)`. */
int cmd_fail(int status, const char *format, ...) CMD_PRINTF(2, 3);
/* Prints the message and "Try 'ztex VERB --help'." and returns CMD_USAGE. */
int cmd_usage(const cmd_args *args, const char *format, ...) CMD_PRINTF(2, 3);
/* "ztex: FILE: text (rule 3001, IMAG/image 3, offset 123)" and a hint. Returns the exit code of the result. diag may be
 * NULL. */
int cmd_fail_result(const char *file, zt_result result, const zt_diag *diag);
int cmd_status_of(zt_result result); /* only the mapping */

/* Makes text from a file fit for a terminal: control characters, invalid UTF-8, bidirectional controls become \xNN or
 * \u{...}. The result is NUL-terminated, cut with "..." when longer than size. Returns dst. */
char *cmd_safe(char *dst, size_t size, const char *text);
/* The same, printed whole. */
void cmd_print_safe(FILE *stream, const char *text);

/* One UTF-8 character; returns its length, or 0 when it is malformed. */
size_t cmd_utf8(const char *text, uint32_t *code);

/* "did you mean": the nearest of count names, or NULL when none is near. */
const char *cmd_nearest(const char *word, const char *const *names, size_t count);

/* "12.3 MiB" and the like into dst (at least 16 bytes). Returns dst. */
char *cmd_bytes_text(char *dst, size_t size, uint64_t bytes);

/* ---- interruption and progress --------------------------------------------------------------------- */

/* 1 after SIGINT, SIGTERM or SIGHUP: stop, release, return CMD_CANCELLED. A second signal ends the process at once
 * (status 128 + signal), temporary files removed. */
int cmd_interrupted(void);
/* Prints "interrupted" and returns CMD_CANCELLED. */
int cmd_cancelled(void);

/* A line on standard error with per cent and time left: only on a terminal, only without -q, only after half a
 * second. */
typedef struct cmd_progress {
    const char *label; /* lives until cmd_progress_end */
    double start, last_time, base, span;
    int enabled, shown;
} cmd_progress;

void cmd_progress_begin(cmd_progress *progress, const cmd_args *args, const char *label);
/* For zt_writer_options.progress and zt_check_options.progress with user = the cmd_progress (works with NULL too).
 * Returns 1 when interrupted. done is of the part set by cmd_progress_part. */
int cmd_progress_step(void *progress, double done);
/* From now on 0 to 1 of cmd_progress_step means from..to of the whole. NULL is allowed. */
void cmd_progress_part(cmd_progress *progress, double from, double to);
void cmd_progress_end(cmd_progress *progress); /* clears the line */

/* ---- files ------------------------------------------------------------------------------------------- */

typedef struct cmd_input {
    zt_file *file;
    const char *name; /* for messages: the path, or "standard input" */
    void *data;       /* bytes of standard input, else NULL */
    size_t size;
} cmd_input;

/* Opens a texture file, or standard input for "-" (read whole, within --memory), with --memory as limit. flags:
 * ZT_OPEN_... Prints the message on failure. Returns a cmd_status; input is all zero unless it is CMD_OK. */
int cmd_open(const cmd_args *args, const char *path, uint32_t flags, cmd_input *input);
void cmd_close(cmd_input *input); /* all zero is allowed */

/* Reads a whole file or, for "-", standard input, at most limit bytes (0: --memory). *data is malloc'd, has one NUL
 * behind the last byte, and is freed by the caller. Prints the message on failure. */
int cmd_read_all(const cmd_args *args, const char *path, uint64_t limit, void **data, size_t *size);

/* "standard input" for "-", else the path. */
const char *cmd_input_name(const char *path);

int cmd_ends_with(const char *text, const char *end);

/* Refuses, with message and CMD_USAGE, when output is the same file as one of the inputs (same inode, or the same
 * path). "-" never is. */
int cmd_check_output(const char *output, const char *const *inputs, size_t input_count);

/* Any file that appears whole or not at all: a temporary file beside path, renamed by cmd_output_commit. For "-":
 * standard output directly (with binary != 0 a terminal is refused). Between them write to output.stream. All functions
 * print their message. */
typedef struct cmd_output {
    FILE *stream;
    const char *path; /* must live until commit or drop */
    char *temporary;  /* NULL for standard output */
} cmd_output;

int cmd_output_open(cmd_output *output, const char *path, int binary);
int cmd_output_commit(cmd_output *output); /* flush, check, rename; drops on failure */
void cmd_output_drop(cmd_output *output);  /* leaves no trace; all zero is allowed */
/* Commits if status, that of all that came before, is CMD_OK, and else drops. Returns what has become of it. */
int cmd_output_end(cmd_output *output, int status);

/* A temporary file's name beside path (malloc'd; the file exists, is empty, and is removed by a signal) and its end. Of
 * use where a library wants a path. cmd_temporary_keep renames it to path (CMD_OK or a printed CMD_IO); _drop deletes
 * it. Both free the name. */
char *cmd_temporary(const char *path);
int cmd_temporary_keep(char *temporary, const char *path);
void cmd_temporary_drop(char *temporary); /* NULL is allowed */

/* A writer to a path or, for "-", to standard output (a terminal is refused), with --threads, --memory and
 * interruption. options may be NULL; its limits and parallel are filled in when they are NULL. Prints the message on
 * failure. */
int cmd_writer_open(cmd_args *args, const char *path, const zt_writer_options *options, zt_writer **out);
/* zt_writer_finish with message. Does not close the writer. */
int cmd_writer_finish(const char *path, zt_writer *writer);

/* ---- names of numbers --------------------------------------------------------------------------------- */

/* Names of spec/registry.md. Unknown numbers give NULL, unknown names -1. "base_colour" and "base-colour" are the
 * same. */
const char *cmd_semantic_name(uint32_t semantic);
int cmd_semantic_number(const char *name);
const char *cmd_transfer_name(uint32_t transfer);   /* "srgb", "linear", "bt709", "pq", ... */
int cmd_transfer_number(const char *name);          /* a name or a decimal number */
const char *cmd_primaries_name(uint32_t primaries); /* "bt709", "p3-d65", "bt2020", ... */
int cmd_primaries_number(const char *name);
const char *cmd_wrap_name(uint32_t wrap);       /* "repeat", "mirror", "clamp", "border" */
const char *cmd_alpha_name(uint32_t alpha);     /* "none", "straight", "premultiplied" */
const char *cmd_layer_kind_name(uint32_t kind); /* "array", "cube", "frames" */
const char *cmd_kind_name(uint32_t kind);       /* "image", "zipmap", "silmap", "umbrellas" */

/* ---- JSON ------------------------------------------------------------------------------------------------ */

/* Keys come out in the order in which they were set. Setters take the reference, like json_object_set_new. */
json_t *cmd_json_u64(uint64_t value);    /* a number up to 2^53; above, a decimal string, so that no reader rounds it */
json_t *cmd_json_hash(uint64_t value);   /* "0123456789abcdef" */
json_t *cmd_json_offset(uint64_t value); /* as u64; null for UINT64_MAX */
json_t *cmd_json_text(const char *text); /* invalid UTF-8 becomes U+FFFD; NULL becomes null */
/* Two-space indent, order kept, final newline. Returns CMD_OK or a printed CMD_IO. */
int cmd_json_print(FILE *stream, const json_t *value);
/* The same as a file, whole or not at all. */
int cmd_json_write(const char *path, const json_t *value);

/* ---- the frame's own ------------------------------------------------------------------------------------- */

int cmd_main(int argc, char **argv);

/* help.c, completion.c; each returns a cmd_status. verb NULL: the overview. */
int cmd_help_print(FILE *stream, const cmd_verb *verb);
int cmd_help_man(FILE *stream, const cmd_verb *verb);
int cmd_completion(FILE *stream, const char *shell);
int cmd_option_list(const cmd_verb *verb, const cmd_option **list,
                    size_t capacity); /* own, then common; returns the count */
/* The verb of this name, with a space or a dash between two words. */
const cmd_verb *cmd_find_verb(const char *name);
/* The verb that the first one or two of count words name; the longer one wins. *used is the number of its words. NULL:
 * none. */
const cmd_verb *cmd_match_verb(const char *const *words, size_t count, size_t *used);
/* The name with a dash for its space: "make-zipmap". */
#define CMD_VERB_NAME 32
char *cmd_dashed(const cmd_verb *verb, char dst[CMD_VERB_NAME]);
/* The second word of a verb that begins with the word first: "zipmap" of "make zipmap", "make"; else NULL. */
const char *cmd_second_word(const cmd_verb *verb, const char *first);

#endif
