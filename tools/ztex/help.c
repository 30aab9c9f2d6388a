/* SPDX-License-Identifier: Apache-2.0 */
/* --help: the table as a text that teaches. The same texts make the man pages (man.c). */
#include "command_private.h"

#include <string.h>

#define WIDTH 80

const cmd_exit_text cmd_exit_texts[] = {
    {CMD_OK, "all went well"},
    {CMD_USAGE, "the command line or a scene file is wrong"},
    {CMD_IO, "reading or writing failed"},
    {CMD_INVALID, "a file is not what it should be: no .ztex file, corrupt, or cut short"},
    {CMD_INTERNAL, "out of memory, or a bug in ztex"},
    {CMD_UNSUPPORTED, "a file is valid, but needs what this version cannot do"},
    {CMD_LIMIT, "over a limit, such as --memory"},
    {CMD_DIFFERENT, "diff: the files differ"},
    {CMD_LOSS, "recover: something could not be saved"},
    {CMD_CANCELLED, "interrupted; nothing half-written stays behind"},
    {CMD_OK, NULL}};

const char
    *const cmd_overview = "Makes, shows, checks and converts .ztex texture files: images with mip levels, layers and "
                          "materials, zipmaps, pictures that have more detail where somebody looked closer, and "
                          "silmaps, whose edges stay sharp.\n\n"
                          "Every verb also exists as a command of its own, 'ztex inspect' as 'ztex-inspect'. A file "
                          "named '-' is standard input or standard output. Output files appear whole or not at all, "
                          "and an input is never overwritten.";

/* Length of the piece of text that fits into room columns; at least one word. Bytes count as columns. */
static size_t fitting(const char *text, size_t room) {
    size_t length = strcspn(text, "\n");
    if (length <= room)
        return length;
    for (size_t i = room; i > 0; i--)
        if (text[i] == ' ')
            return i;
    return strcspn(text, " \n");
}

void cmd_wrap_print(FILE *stream, const char *text, int indent, int width) {
    size_t room = (size_t)(width - indent);
    while (*text) {
        size_t length = text[0] == ' ' ? strcspn(text, "\n") : fitting(text, room);
        if (length > 0)
            fprintf(stream, "%*s%.*s\n", indent, "", (int)length, text);
        else
            fputc('\n', stream);
        text += length;
        if (*text == ' ')
            text += strspn(text, " ");
        else if (*text == '\n')
            text++;
    }
}

void cmd_option_heading(const cmd_option *option, char *dst, size_t size) {
    char letter[8] = "    ";
    if (option->letter)
        snprintf(letter, sizeof letter, "-%c, ", option->letter);
    snprintf(dst, size, "%s--%s%s%s", letter, option->name, option->metavar ? " " : "",
             option->metavar ? option->metavar : "");
}

static void print_option(FILE *stream, const cmd_option *option) {
    char heading[128], text[1024], choices[256];
    size_t at = 0;
    cmd_option_heading(option, heading, sizeof heading);
    at += (size_t)snprintf(text, sizeof text, "%s", option->help);
    if (option->choices)
        cmd_choice_list(option->choices, choices, sizeof choices);
    if (option->choices && at < sizeof text)
        at += (size_t)snprintf(text + at, sizeof text - at, " %s: %s.",
                               option->kind == CMD_CHOICE ? "One of" : "Such as", choices);
    if (option->repeat && option->metavar && at < sizeof text)
        at += (size_t)snprintf(text + at, sizeof text - at, " May be given several times.");
    if (option->fallback && at < sizeof text)
        snprintf(text + at, sizeof text - at, " Default: %s.", option->fallback);
    fprintf(stream, "  %s\n", heading);
    cmd_wrap_print(stream, text, 10, WIDTH);
}

static void print_synopsis(FILE *stream, const cmd_verb *verb) {
    const char *line = verb->synopsis;
    const char *prefix = "Usage: ";
    while (*line) {
        size_t length = strcspn(line, "\n");
        fprintf(stream, "%sztex %s %.*s\n", prefix, verb->name, (int)length, line);
        prefix = "       ";
        line += length + (line[length] == '\n');
    }
}

/* The verbs of two words that begin with this one. */
static void print_relatives(FILE *stream, const cmd_verb *verb) {
    const char *heading = "\nMore:\n";
    for (size_t i = 0; cmd_verbs[i]; i++) {
        if (!cmd_second_word(cmd_verbs[i], verb->name))
            continue;
        fprintf(stream, "%s  ztex %-14s %s\n", heading, cmd_verbs[i]->name, cmd_verbs[i]->summary);
        heading = "";
    }
}

static int print_verb(FILE *stream, const cmd_verb *verb) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    int count = cmd_option_list(verb, options, CMD_MAX_OPTIONS);
    print_synopsis(stream, verb);
    fprintf(stream, "\n%s.\n\n", verb->summary);
    if (verb->text)
        cmd_wrap_print(stream, verb->text, 0, WIDTH);
    fprintf(stream, "\nOptions:\n");
    for (int i = 0; i < count; i++)
        print_option(stream, options[i]);
    if (verb->examples && verb->examples->text)
        fprintf(stream, "\nExamples:\n");
    for (const cmd_example *e = verb->examples; e && e->text; e++) {
        fprintf(stream, "  %s\n", e->line);
        cmd_wrap_print(stream, e->text, 10, WIDTH);
    }
    print_relatives(stream, verb);
    fprintf(stream, "\nExit codes:\n");
    for (const cmd_exit_text *e = cmd_exit_texts; e->text; e++)
        fprintf(stream, "  %d  %s\n", (int)e->status, e->text);
    return CMD_OK;
}

int cmd_help_print(FILE *stream, const cmd_verb *verb) {
    if (verb)
        return print_verb(stream, verb);
    fprintf(stream, "Usage: ztex VERB [OPTION]... [FILE]...\n\n");
    cmd_wrap_print(stream, cmd_overview, 0, WIDTH);
    fprintf(stream, "\nVerbs:\n");
    for (size_t i = 0; cmd_verbs[i]; i++)
        fprintf(stream, "  %-14s %s\n", cmd_verbs[i]->name, cmd_verbs[i]->summary);
    fprintf(stream, "\n'ztex help VERB' or 'ztex VERB --help' says more about a verb.\n");
    return CMD_OK;
}
