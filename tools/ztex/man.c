/* SPDX-License-Identifier: Apache-2.0 */
/* Man pages out of the table, as troff with the man macros. */
#include "command_private.h"

#include <ctype.h>
#include <string.h>

/* Escapes what troff would take as its own. A line must not begin with a full stop or an apostrophe. */
static void put_text(FILE *stream, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        char c = text[i];
        if ((i == 0 || text[i - 1] == '\n') && (c == '.' || c == '\''))
            fputs("\\&", stream);
        if (c == '\\')
            fputs("\\e", stream);
        else if (c == '-')
            fputs("\\-", stream);
        else if (c == '\'')
            fputs("\\(aq", stream);
        else
            fputc(c, stream);
    }
}

static void put(FILE *stream, const char *text) {
    put_text(stream, text, strlen(text));
}

static void put_upper(FILE *stream, const char *text) {
    for (; *text; text++)
        fputc(*text == '-' ? '-' : toupper((unsigned char)*text), stream);
}

static void put_title(FILE *stream, const char *name) {
    fputs(".TH \"", stream);
    put_upper(stream, name);
    fprintf(stream, "\" \"1\" \"\" \"ztex %d.%d.%d\" \"ztex manual\"\n", ZT_VERSION_MAJOR, ZT_VERSION_MINOR,
            ZT_VERSION_PATCH);
}

/* Paragraphs; runs of lines that begin with a space are kept as they are. */
static void put_paragraphs(FILE *stream, const char *text) {
    int kept = 0;
    while (*text) {
        size_t length = strcspn(text, "\n");
        int keep = text[0] == ' ';
        if (keep != kept)
            fputs(keep ? ".PP\n.nf\n" : ".fi\n", stream);
        kept = keep;
        if (length == 0)
            fputs(".PP\n", stream);
        else {
            put_text(stream, text, length);
            fputc('\n', stream);
        }
        text += length + (text[length] == '\n');
    }
    if (kept)
        fputs(".fi\n", stream);
}

static void put_option(FILE *stream, const cmd_option *option) {
    char choices[256];
    fputs(".TP\n", stream);
    if (option->letter)
        fprintf(stream, "\\fB\\-%c\\fR, ", option->letter);
    fputs("\\fB\\-\\-", stream);
    put(stream, option->name);
    fputs("\\fR", stream);
    if (option->metavar) {
        fputs(" \\fI", stream);
        put(stream, option->metavar);
        fputs("\\fR", stream);
    }
    fputc('\n', stream);
    put(stream, option->help);
    fputc('\n', stream);
    if (option->choices) {
        fputs(option->kind == CMD_CHOICE ? "One of: " : "Such as: ", stream);
        cmd_choice_list(option->choices, choices, sizeof choices);
        put(stream, choices);
        fputs(".\n", stream);
    }
    if (option->repeat && option->metavar)
        fputs("May be given several times.\n", stream);
    if (option->fallback) {
        fputs("Default: ", stream);
        put(stream, option->fallback);
        fputs(".\n", stream);
    }
}

static void put_exit_codes(FILE *stream) {
    fputs(".SH EXIT STATUS\n", stream);
    for (const cmd_exit_text *e = cmd_exit_texts; e->text; e++) {
        fprintf(stream, ".TP\n\\fB%d\\fR\n", (int)e->status);
        put(stream, e->text);
        fputc('\n', stream);
    }
}

static void put_others(FILE *stream, const cmd_verb *self) {
    const char *before = "";
    char name[CMD_VERB_NAME];
    fputs(".SH SEE ALSO\n", stream);
    if (self) {
        fputs("\\fBztex\\fR(1)", stream);
        before = ",\n";
    }
    for (size_t i = 0; cmd_verbs[i]; i++) {
        if (cmd_verbs[i] == self)
            continue;
        fprintf(stream, "%s\\fBztex\\-", before);
        put(stream, cmd_dashed(cmd_verbs[i], name));
        fputs("\\fR(1)", stream);
        before = ",\n";
    }
    fputc('\n', stream);
}

static void put_overview(FILE *stream) {
    put_title(stream, "ztex");
    fputs(".SH NAME\nztex \\- make, show, check and convert .ztex texture files\n", stream);
    fputs(".SH SYNOPSIS\n\\fBztex\\fR \\fIVERB\\fR [\\fIOPTION\\fR]... [\\fIFILE\\fR]...\n", stream);
    fputs(".SH DESCRIPTION\n", stream);
    put_paragraphs(stream, cmd_overview);
    fputs(".SH VERBS\n", stream);
    for (size_t i = 0; cmd_verbs[i]; i++) {
        fprintf(stream, ".TP\n\\fB%s\\fR\n", cmd_verbs[i]->name);
        put(stream, cmd_verbs[i]->summary);
        fputs(".\n", stream);
    }
}

static void put_synopsis(FILE *stream, const cmd_verb *verb) {
    const char *line = verb->synopsis;
    fputs(".SH SYNOPSIS\n", stream);
    while (*line) {
        size_t length = strcspn(line, "\n");
        fprintf(stream, "\\fBztex %s\\fR ", verb->name);
        put_text(stream, line, length);
        line += length + (line[length] == '\n');
        fputs(*line ? "\n.br\n" : "\n", stream);
    }
}

static void put_verb(FILE *stream, const cmd_verb *verb) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    char name[64], dashed[CMD_VERB_NAME];
    int count = cmd_option_list(verb, options, CMD_MAX_OPTIONS);
    snprintf(name, sizeof name, "ztex-%s", cmd_dashed(verb, dashed));
    put_title(stream, name);
    fputs(".SH NAME\n", stream);
    put(stream, name);
    fputs(" \\- ", stream);
    put(stream, verb->summary);
    fputc('\n', stream);
    put_synopsis(stream, verb);
    fputs(".SH DESCRIPTION\n", stream);
    put_paragraphs(stream, verb->text ? verb->text : verb->summary);
    fputs(".SH OPTIONS\n", stream);
    for (int i = 0; i < count; i++)
        put_option(stream, options[i]);
    if (verb->examples && verb->examples->text)
        fputs(".SH EXAMPLES\n", stream);
    for (const cmd_example *e = verb->examples; e && e->text; e++) {
        fputs(".TP\n\\fB", stream);
        put(stream, e->line);
        fputs("\\fR\n", stream);
        put(stream, e->text);
        fputc('\n', stream);
    }
}

int cmd_help_man(FILE *stream, const cmd_verb *verb) {
    if (verb)
        put_verb(stream, verb);
    else
        put_overview(stream);
    put_exit_codes(stream);
    put_others(stream, verb);
    return CMD_OK;
}
