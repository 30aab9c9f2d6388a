/* SPDX-License-Identifier: Apache-2.0 */
/* The command line against the table of options. */
#include "command_private.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST (UINT64_C(1) << 53)

static const cmd_option common_options[] = {
    {.name = "help", .letter = 'h', .help = "Show this help and exit."},
    {.name = "quiet", .letter = 'q', .help = "Errors only: no progress, no notes, no warnings."},
    {.name = "verbose", .letter = 'v', .repeat = 1, .help = "Say what is being done."},
    {.name = "version", .help = "Show the version and exit."},
    {.name = "threads",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 256,
     .help = "Threads to work with. Default: as many as there are processors. The result does "
             "not depend on it."},
    {.name = "memory",
     .metavar = "SIZE",
     .kind = CMD_SIZE,
     .fallback = "1G",
     .help = "Most memory for one file's data, such as 512M or 8G."}};

int cmd_option_list(const cmd_verb *verb, const cmd_option **list, size_t capacity) {
    size_t count = 0;
    for (const cmd_option *own = verb->options; own && own->name; own++)
        if (count < capacity)
            list[count++] = own;
    for (size_t i = 0; i < sizeof common_options / sizeof common_options[0]; i++) {
        const cmd_option *option = &common_options[i];
        int wanted = 1;
        if (strcmp(option->name, "threads") == 0)
            wanted = (verb->common & CMD_WITH_THREADS) != 0;
        if (strcmp(option->name, "memory") == 0)
            wanted = (verb->common & CMD_WITH_MEMORY) != 0;
        if (wanted && count < capacity)
            list[count++] = option;
    }
    return (int)count;
}

/* ---- values -------------------------------------------------------------------------------------- */

int cmd_parse_u64(const char *text, uint64_t *out) {
    int hexadecimal = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *digits = hexadecimal ? text + 2 : text;
    size_t length = strspn(digits, hexadecimal ? "0123456789abcdefABCDEF" : "0123456789");
    if (length == 0 || digits[length] != '\0')
        return -1;
    errno = 0;
    *out = strtoull(digits, NULL, hexadecimal ? 16 : 10);
    return errno == ERANGE ? -1 : 0;
}

int cmd_parse_size(const char *text, uint64_t *out) {
    static const char units[] = "KMGT";
    char digits[24];
    size_t length = strspn(text, "0123456789");
    if (length == 0 || length >= sizeof digits)
        return -1;
    memcpy(digits, text, length);
    digits[length] = '\0';
    if (cmd_parse_u64(digits, out))
        return -1;
    const char *unit = text + length;
    if (*unit == '\0')
        return 0;
    char upper = *unit >= 'a' && *unit <= 'z' ? (char)(*unit - 'a' + 'A') : *unit;
    const char *found = strchr(units, upper);
    int known_end = strcmp(unit + 1, "") == 0 || strcmp(unit + 1, "B") == 0 || strcmp(unit + 1, "iB") == 0;
    if (!found || !known_end)
        return -1;
    unsigned shift = 10 * (unsigned)(found - units + 1);
    if (*out > (UINT64_MAX >> shift))
        return -1;
    *out <<= shift;
    return 0;
}

int cmd_choice_word(const char *choices, int index, char *dst, size_t size) {
    while (index-- > 0) {
        choices = strchr(choices, '|');
        if (!choices)
            return -1;
        choices++;
    }
    snprintf(dst, size, "%.*s", (int)strcspn(choices, "|"), choices);
    return 0;
}

void cmd_choice_list(const char *choices, char *dst, size_t size) {
    char word[64];
    size_t at = 0;
    for (int i = 0; cmd_choice_word(choices, i, word, sizeof word) == 0 && at < size; i++)
        at += (size_t)snprintf(dst + at, size - at, "%s%s", i ? ", " : "", word);
}

int cmd_choice_index(const char *choices, const char *word) {
    char name[64];
    for (int i = 0; cmd_choice_word(choices, i, name, sizeof name) == 0; i++)
        if (strcmp(name, word) == 0)
            return i;
    return -1;
}

static int check_choice(const cmd_option *option, const char *value, char *text, size_t size) {
    char words[32][64];
    const char *names[32];
    int count = 0;
    if (cmd_choice_index(option->choices, value) >= 0)
        return 0;
    for (; count < 32 && cmd_choice_word(option->choices, count, words[count], 64) == 0; count++)
        names[count] = words[count];
    const char *near = cmd_nearest(value, names, (size_t)count);
    if (near)
        snprintf(text, size, "there is no '%s': did you mean '%s'?", value, near);
    else
        snprintf(text, size, "there is no '%s': one of %s", value, option->choices);
    return -1;
}

static int check_integer(const cmd_option *option, const char *value, char *text, size_t size) {
    uint64_t number = 0;
    uint64_t max = option->max ? option->max : LARGEST;
    if (option->choices && cmd_choice_index(option->choices, value) >= 0)
        return 0;
    if (cmd_parse_u64(value, &number) == 0 && number >= option->min && number <= max)
        return 0;
    snprintf(text, size, "'%s' is not a whole number from %llu to %llu%s%s", value, (unsigned long long)option->min,
             (unsigned long long)max, option->choices ? " or " : "", option->choices ? option->choices : "");
    return -1;
}

static int check_format(const char *value, char *text, size_t size) {
    const char *names[512];
    size_t count = 0;
    if (zt_find_format_name(value))
        return 0;
    for (uint32_t i = 0; count < 512 && zt_get_format(i); i++)
        names[count++] = zt_get_format(i)->name;
    const char *near = cmd_nearest(value, names, count);
    snprintf(text, size, "there is no format '%s'%s%s%s", value, near ? ": did you mean '" : "",
             near ? near : ", see 'ztex help formats'", near ? "'?" : "");
    return -1;
}

int cmd_check_value(const cmd_option *option, const char *value, char *text, size_t size) {
    uint64_t number;
    char *end = NULL;
    switch (option->kind) {
    case CMD_CHOICE:
        return check_choice(option, value, text, size);
    case CMD_INTEGER:
        return check_integer(option, value, text, size);
    case CMD_FORMAT:
        return check_format(value, text, size);
    case CMD_SIZE:
        if (cmd_parse_size(value, &number) == 0 && number > 0)
            return 0;
        snprintf(text, size, "'%s' is not a size such as 65536, 512M or 2G", value);
        return -1;
    case CMD_REAL:
        if (value[0] != '\0' && isfinite(strtod(value, &end)) && *end == '\0')
            return 0;
        snprintf(text, size, "'%s' is not a number", value);
        return -1;
    default:
        if (value[0] != '\0' || option->kind == CMD_TEXT)
            return 0;
        snprintf(text, size, "the name is empty");
        return -1;
    }
}

/* ---- words ----------------------------------------------------------------------------------------- */

typedef struct parser {
    cmd_args *args;
    struct cmd_private *p;
    int argc, next;
    char **argv;
} parser;

static const cmd_option *find_long(const struct cmd_private *p, const char *name, size_t length) {
    for (int i = 0; i < p->option_count; i++)
        if (strlen(p->options[i]->name) == length && memcmp(p->options[i]->name, name, length) == 0)
            return p->options[i];
    return NULL;
}

static const cmd_option *find_short(const struct cmd_private *p, char letter) {
    for (int i = 0; i < p->option_count; i++)
        if (p->options[i]->letter == letter)
            return p->options[i];
    return NULL;
}

static int unknown_option(const parser *s, const char *word, size_t length) {
    const char *names[CMD_MAX_OPTIONS];
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)(length < 63 ? length : 63), word);
    for (int i = 0; i < s->p->option_count; i++)
        names[i] = s->p->options[i]->name;
    const char *near = cmd_nearest(name, names, (size_t)s->p->option_count);
    if (near)
        return cmd_usage(s->args, "there is no option --%s: did you mean --%s?", name, near);
    return cmd_usage(s->args, "there is no option --%s", name);
}

/* Files one option with its value; value is NULL for flags. */
static int take(parser *s, const cmd_option *option, const char *value) {
    char text[512];
    if (value && cmd_check_value(option, value, text, sizeof text))
        return cmd_usage(s->args, "--%s: %s", option->name, text);
    for (size_t i = 0; value && !option->repeat && i < s->p->value_count; i++)
        if (s->p->values[i].option == option)
            return cmd_usage(s->args, "--%s is given twice", option->name);
    s->p->values[s->p->value_count++] = (cmd_value){option, value};
    s->args->quiet += strcmp(option->name, "quiet") == 0;
    s->args->verbose += strcmp(option->name, "verbose") == 0;
    s->p->wants_help |= strcmp(option->name, "help") == 0;
    s->p->wants_version |= strcmp(option->name, "version") == 0;
    return CMD_OK;
}

static int take_next(parser *s, const cmd_option *option) {
    if (s->next >= s->argc)
        return cmd_usage(s->args, "--%s wants %s behind it", option->name, option->metavar);
    return take(s, option, s->argv[s->next++]);
}

static int parse_long(parser *s, const char *word) {
    size_t length = strcspn(word, "=");
    const cmd_option *option = find_long(s->p, word, length);
    if (!option)
        return unknown_option(s, word, length);
    if (word[length] == '=' && option->kind == CMD_FLAG)
        return cmd_usage(s->args, "--%s takes no value", option->name);
    if (word[length] == '=')
        return take(s, option, word + length + 1);
    return option->kind == CMD_FLAG ? take(s, option, NULL) : take_next(s, option);
}

static int parse_short(parser *s, const char *word) {
    for (const char *at = word; *at; at++) {
        const cmd_option *option = find_short(s->p, *at);
        if (!option)
            return cmd_usage(s->args, "there is no option -%c", *at);
        if (option->kind != CMD_FLAG)
            return at[1] ? take(s, option, at + 1 + (at[1] == '=')) : take_next(s, option);
        int status = take(s, option, NULL);
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

static int parse_words(parser *s) {
    int options_end = 0;
    while (s->next < s->argc) {
        const char *word = s->argv[s->next++];
        int status = CMD_OK;
        if (!options_end && strcmp(word, "--") == 0)
            options_end = 1;
        else if (!options_end && strncmp(word, "--", 2) == 0)
            status = parse_long(s, word + 2);
        else if (!options_end && word[0] == '-' && word[1] != '\0')
            status = parse_short(s, word + 1);
        else
            s->p->operands[s->args->operand_count++] = word;
        /* Who asks for help gets it, whatever else is wrong behind. */
        if (status != CMD_OK || s->p->wants_help)
            return status;
    }
    return CMD_OK;
}

int cmd_parse(cmd_args *args, int argc, char **argv) {
    struct cmd_private *p = args->private_data;
    const cmd_verb *verb = args->verb;
    size_t words = 0; /* a cluster of flags has one value a letter */
    for (int i = 0; i < argc; i++)
        words += 1 + strlen(argv[i]);
    p->option_count = cmd_option_list(verb, p->options, CMD_MAX_OPTIONS);
    p->values = calloc(words + 1, sizeof *p->values);
    p->operands = calloc((size_t)argc + 1, sizeof *p->operands);
    if (!p->values || !p->operands)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    args->operands = p->operands;
    parser s = {args, p, argc, 0, argv};
    int status = parse_words(&s);
    if (status != CMD_OK || p->wants_help || p->wants_version)
        return status;
    if (verb->common & CMD_WITH_MEMORY)
        p->limits.memory = cmd_integer(args, "memory");
    if (args->operand_count < verb->min_operands)
        return cmd_usage(args, "a file is missing: ztex %s %.*s", verb->name, (int)strcspn(verb->synopsis, "\n"),
                         verb->synopsis);
    if (verb->max_operands && args->operand_count > verb->max_operands)
        return cmd_usage(args, "'%s' is one too many", args->operands[verb->max_operands]);
    return CMD_OK;
}
