/* SPDX-License-Identifier: Apache-2.0 */
/* Completions for bash, zsh and fish out of the table. */
#include "command_private.h"

#include <string.h>

/* "a|b|c" or the names of formats or verbs, divided by spaces. */
static void put_words(FILE *stream, const cmd_option *option) {
    char word[64];
    if (option->kind == CMD_FORMAT)
        for (uint32_t i = 0; zt_get_format(i); i++)
            fprintf(stream, "%s%s", i ? " " : "", zt_get_format(i)->name);
    else if (option->choices)
        for (int i = 0; cmd_choice_word(option->choices, i, word, sizeof word) == 0; i++)
            fprintf(stream, "%s%s", i ? " " : "", word);
}

static int has_two_words(const cmd_verb *verb) {
    return strchr(verb->name, ' ') != NULL;
}

/* The verbs of one word. */
static void put_verbs(FILE *stream) {
    const char *before = "";
    for (size_t i = 0; cmd_verbs[i]; i++) {
        if (has_two_words(cmd_verbs[i]))
            continue;
        fprintf(stream, "%s%s", before, cmd_verbs[i]->name);
        before = " ";
    }
}

/* The second words of the verbs that begin with this one, divided by spaces; returns how many there are. */
static int put_seconds(FILE *stream, const cmd_verb *verb) {
    int count = 0;
    for (size_t i = 0; cmd_verbs[i]; i++) {
        const char *second = cmd_second_word(cmd_verbs[i], verb->name);
        if (second)
            fprintf(stream, "%s%s", count++ ? " " : "", second);
    }
    return count;
}

static int has_seconds(const cmd_verb *verb) {
    for (size_t i = 0; cmd_verbs[i]; i++)
        if (cmd_second_word(cmd_verbs[i], verb->name))
            return 1;
    return 0;
}

/* All verbs, with a dash for the space of two words, each behind the text before. */
static void put_dashed(FILE *stream, const char *before) {
    char name[CMD_VERB_NAME];
    for (size_t i = 0; cmd_verbs[i]; i++)
        fprintf(stream, "%s%s", before, cmd_dashed(cmd_verbs[i], name));
}

static int has_words(const cmd_option *option) {
    return option->choices != NULL || option->kind == CMD_FORMAT;
}

/* The first sentence of a help text, cut where a line would be too long. */
static size_t summary_length(const char *help) {
    const char *stop = strstr(help, ". ");
    size_t length = stop ? (size_t)(stop - help) : strlen(help);
    if (length > 0 && help[length - 1] == '.')
        length--;
    return length;
}

/* ---- bash ------------------------------------------------------------------------------------------ */

static const char *bash_action(cmd_kind kind) {
    switch (kind) {
    case CMD_FILE:
        return "_ztex_files \"$cur\"";
    case CMD_TEXTURE:
        return "_ztex_textures \"$cur\"";
    case CMD_FOLDER:
        return "_ztex_folders \"$cur\"";
    case CMD_COMMAND:
        return "_ztex_words \"$cur\" $_ztex_verbs";
    default:
        return ":";
    }
}

static const char bash_head[] =
    "_ztex_words() {\n"
    "    local cur=\"$1\"\n"
    "    shift\n"
    "    COMPREPLY=($(compgen -W \"$*\" -- \"$cur\"))\n"
    "}\n"
    "_ztex_files() {\n"
    "    compopt -o filenames 2>/dev/null\n"
    "    mapfile -t COMPREPLY < <(compgen -f -- \"$1\")\n"
    "}\n"
    "_ztex_textures() {\n"
    "    compopt -o filenames 2>/dev/null\n"
    "    mapfile -t COMPREPLY < <(compgen -d -- \"$1\"; compgen -f -X '!*.ztex' -- \"$1\")\n"
    "}\n"
    "_ztex_folders() {\n"
    "    compopt -o filenames 2>/dev/null\n"
    "    mapfile -t COMPREPLY < <(compgen -d -- \"$1\")\n"
    "}\n"
    "# Adds the second words of a verb, where the second word is being written.\n"
    "_ztex_seconds() {\n"
    "    local cur=\"$1\" at=\"$2\"\n"
    "    shift 2\n"
    "    ((COMP_CWORD == at)) && COMPREPLY+=($(compgen -W \"$*\" -- \"$cur\"))\n"
    "}\n"
    "_ztex() {\n"
    "    local cur=\"${COMP_WORDS[COMP_CWORD]}\" prev=\"\" verb at=2\n"
    "    ((COMP_CWORD > 0)) && prev=\"${COMP_WORDS[COMP_CWORD - 1]}\"\n"
    "    COMPREPLY=()\n"
    "    case \"${COMP_WORDS[0]##*/}\" in\n"
    "    ztex-*) verb=\"${COMP_WORDS[0]##*/ztex-}\"; verb=\"${verb#ztex-}\" at=1 ;;\n"
    "    *)\n"
    "        if ((COMP_CWORD == 1)); then\n"
    "            _ztex_words \"$cur\" $_ztex_verbs --help --version\n"
    "            return\n"
    "        fi\n"
    "        verb=\"${COMP_WORDS[1]}\"\n"
    "        ;;\n"
    "    esac\n"
    "    if ((COMP_CWORD > at)) && [[ \" $_ztex_all \" == *\" $verb-${COMP_WORDS[at]} \"* ]]; then\n"
    "        verb=\"$verb-${COMP_WORDS[at]}\"\n"
    "    fi\n"
    "    # The shell splits --name=value at the equals sign.\n"
    "    if [[ $cur == = ]]; then\n"
    "        cur=\"\"\n"
    "    elif [[ $prev == = ]] && ((COMP_CWORD > 1)); then\n"
    "        prev=\"${COMP_WORDS[COMP_CWORD - 2]}\"\n"
    "    fi\n"
    "    case \"$verb:$prev\" in\n";

static void bash_option(FILE *stream, const cmd_verb *verb, const cmd_option *option) {
    if (!option->metavar)
        return;
    char name[CMD_VERB_NAME];
    cmd_dashed(verb, name);
    fprintf(stream, "    %s:--%s", name, option->name);
    if (option->letter)
        fprintf(stream, " | %s:-%c", name, option->letter);
    fputs(") ", stream);
    if (has_words(option)) {
        fputs("_ztex_words \"$cur\" ", stream);
        put_words(stream, option);
    } else {
        fputs(bash_action(option->kind), stream);
    }
    fputs("; return ;;\n", stream);
}

/* Behind 'help' the second word of a verb follows the first. */
static void bash_help_words(FILE *stream) {
    for (size_t i = 0; cmd_verbs[i]; i++) {
        if (!has_seconds(cmd_verbs[i]))
            continue;
        fprintf(stream, "        [[ $prev != %s ]] || _ztex_words \"$cur\" ", cmd_verbs[i]->name);
        put_seconds(stream, cmd_verbs[i]);
        fputc('\n', stream);
    }
}

static void bash_verb(FILE *stream, const cmd_verb *verb) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    int count = cmd_option_list(verb, options, CMD_MAX_OPTIONS);
    char name[CMD_VERB_NAME];
    cmd_dashed(verb, name);
    fprintf(stream, "    %s:-*) _ztex_words \"$cur\"", name);
    for (int i = 0; i < count; i++)
        fprintf(stream, " --%s", options[i]->name);
    fprintf(stream, " ;;\n    %s:*)\n        %s\n", name, bash_action(verb->operand));
    if (has_seconds(verb)) {
        fputs("        _ztex_seconds \"$cur\" $at ", stream);
        put_seconds(stream, verb);
        fputc('\n', stream);
    }
    if (verb->operand == CMD_COMMAND)
        bash_help_words(stream);
    fputs("        ;;\n", stream);
}

static void print_bash(FILE *stream) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    fputs("# bash completion for ztex, made by 'ztex help --completion bash'\n_ztex_verbs=\"", stream);
    put_verbs(stream);
    fputs("\"\n_ztex_all=\"", stream);
    put_dashed(stream, " ");
    fprintf(stream, "\"\n%s", bash_head);
    for (size_t v = 0; cmd_verbs[v]; v++) {
        int count = cmd_option_list(cmd_verbs[v], options, CMD_MAX_OPTIONS);
        for (int i = 0; i < count; i++)
            bash_option(stream, cmd_verbs[v], options[i]);
    }
    fputs("    esac\n    case \"$verb:$cur\" in\n", stream);
    for (size_t v = 0; cmd_verbs[v]; v++)
        bash_verb(stream, cmd_verbs[v]);
    fputs("    esac\n}\ncomplete -F _ztex ztex", stream);
    put_dashed(stream, " ztex-");
    fputc('\n', stream);
}

/* ---- zsh -------------------------------------------------------------------------------------------- */

static void zsh_text(FILE *stream, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '\'')
            fputs("'\\''", stream);
        else if (strchr("[]:\\", text[i]))
            fprintf(stream, "\\%c", text[i]);
        else
            fputc(text[i], stream);
    }
}

static const char *zsh_action(cmd_kind kind) {
    switch (kind) {
    case CMD_FILE:
        return "_files";
    case CMD_TEXTURE:
        return "_files -g \"*.ztex(-.)\"";
    case CMD_FOLDER:
        return "_files -/";
    case CMD_COMMAND:
        return "_ztex_verbs";
    default:
        return " ";
    }
}

static void zsh_spec(FILE *stream, const cmd_option *option, char letter) {
    fputs(" \\\n        '", stream);
    if (option->repeat)
        fputc('*', stream);
    else if (option->letter)
        fprintf(stream, "(-%c --%s)", option->letter, option->name);
    if (letter)
        fprintf(stream, "-%c%s[", letter, option->metavar ? "+" : "");
    else
        fprintf(stream, "--%s%s[", option->name, option->metavar ? "=" : "");
    zsh_text(stream, option->help, summary_length(option->help));
    fputc(']', stream);
    if (option->metavar) {
        fputc(':', stream);
        zsh_text(stream, option->metavar, strlen(option->metavar));
        fputc(':', stream);
        if (has_words(option)) {
            fputc('(', stream);
            put_words(stream, option);
            fputc(')', stream);
        } else {
            fputs(zsh_action(option->kind), stream);
        }
    }
    fputc('\'', stream);
}

static void zsh_verb(FILE *stream, const cmd_verb *verb) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    int count = cmd_option_list(verb, options, CMD_MAX_OPTIONS);
    char name[CMD_VERB_NAME];
    fprintf(stream, "    %s)\n", cmd_dashed(verb, name));
    if (has_seconds(verb)) {
        fputs("        ((CURRENT == 2)) && compadd -- ", stream);
        put_seconds(stream, verb);
        fputc('\n', stream);
    }
    fputs("        _arguments -s -S", stream);
    for (int i = 0; i < count; i++) {
        if (options[i]->letter)
            zsh_spec(stream, options[i], options[i]->letter);
        zsh_spec(stream, options[i], 0);
    }
    fprintf(stream, " \\\n        '*:operand:%s'\n        ;;\n", zsh_action(verb->operand));
}

static void print_zsh(FILE *stream) {
    fputs("#compdef ztex", stream);
    put_dashed(stream, " ztex-");
    fputs("\n# zsh completion for ztex, made by 'ztex help --completion zsh'\n"
          "_ztex_all=(",
          stream);
    put_dashed(stream, " ");
    fputs(" )\n"
          "_ztex_verbs() {\n    local -a verbs\n    verbs=(\n",
          stream);
    for (size_t v = 0; cmd_verbs[v]; v++) {
        if (has_two_words(cmd_verbs[v]))
            continue;
        fprintf(stream, "        '%s:", cmd_verbs[v]->name);
        zsh_text(stream, cmd_verbs[v]->summary, strlen(cmd_verbs[v]->summary));
        fputs("'\n", stream);
    }
    fputs("    )\n    _describe verb verbs\n}\n"
          "_ztex() {\n    local verb\n"
          "    if [[ $service == ztex-* ]]; then\n        verb=${service#ztex-}\n"
          "    elif ((CURRENT == 2)); then\n        _ztex_verbs\n        return\n"
          "    else\n        verb=$words[2]\n        shift words\n        ((CURRENT--))\n    fi\n"
          "    if ((CURRENT > 2 && $_ztex_all[(Ie)$verb-$words[2]])); then\n"
          "        verb=$verb-$words[2]\n        shift words\n        ((CURRENT--))\n    fi\n"
          "    case $verb in\n",
          stream);
    for (size_t v = 0; cmd_verbs[v]; v++)
        zsh_verb(stream, cmd_verbs[v]);
    fputs("    esac\n}\n_ztex \"$@\"\n", stream);
}

/* ---- fish -------------------------------------------------------------------------------------------- */

static void fish_text(FILE *stream, const char *text, size_t length) {
    fputc('\'', stream);
    for (size_t i = 0; i < length; i++) {
        if (text[i] == '\'' || text[i] == '\\')
            fputc('\\', stream);
        fputc(text[i], stream);
    }
    fputc('\'', stream);
}

static void fish_kind(FILE *stream, cmd_kind kind) {
    if (kind == CMD_TEXTURE)
        fputs(" -k -x -a '(__fish_complete_suffix .ztex)'", stream);
    else if (kind == CMD_FOLDER)
        fputs(" -x -a '(__fish_complete_directories)'", stream);
    else if (kind == CMD_FILE)
        fputs(" -r -F", stream);
    else if (kind == CMD_COMMAND) {
        fputs(" -x -a '", stream);
        put_verbs(stream);
        fputc('\'', stream);
    } else
        fputs(" -x", stream);
}

static void fish_option(FILE *stream, const char *head, const cmd_option *option) {
    fprintf(stream, "%s -l %s", head, option->name);
    if (option->letter)
        fprintf(stream, " -s %c", option->letter);
    if (option->metavar && has_words(option)) {
        fputs(" -x -a '", stream);
        put_words(stream, option);
        fputc('\'', stream);
    } else if (option->metavar) {
        fish_kind(stream, option->kind);
    }
    fputs(" -d ", stream);
    fish_text(stream, option->help, summary_length(option->help));
    fputc('\n', stream);
}

static void fish_verb(FILE *stream, const char *head, const cmd_verb *verb) {
    const cmd_option *options[CMD_MAX_OPTIONS];
    int count = cmd_option_list(verb, options, CMD_MAX_OPTIONS);
    if (verb->operand == CMD_TEXTURE || verb->operand == CMD_COMMAND) {
        fputs(head, stream);
        fish_kind(stream, verb->operand);
        fputc('\n', stream);
    }
    for (int i = 0; i < count; i++)
        fish_option(stream, head, options[i]);
}

/* The verb on the command line, with a dash between its two words. */
static const char fish_head[] = "function __ztex_verb\n"
                                "    set -l words (commandline -opc)\n"
                                "    set -q words[2]; or return\n"
                                "    if set -q words[3]; and contains -- $words[2]-$words[3] $__ztex_all\n"
                                "        echo $words[2]-$words[3]\n"
                                "    else\n"
                                "        echo $words[2]\n"
                                "    end\n"
                                "end\n"
                                "function __ztex_is\n"
                                "    test \"$(__ztex_verb)\" = $argv[1]\n"
                                "end\n"
                                "function __ztex_second\n"
                                "    __ztex_is $argv[1]; and test (count (commandline -opc)) -eq 2\n"
                                "end\n";

static void fish_entrance(FILE *stream, const cmd_verb *verb) {
    if (!has_two_words(verb)) {
        fprintf(stream, "complete -c ztex -n __fish_use_subcommand -x -a %s -d ", verb->name);
    } else {
        int first = (int)strcspn(verb->name, " ");
        fprintf(stream, "complete -c ztex -n '__ztex_second %.*s' -a %s -d ", first, verb->name,
                verb->name + first + 1);
    }
    fish_text(stream, verb->summary, strlen(verb->summary));
    fputc('\n', stream);
}

static void print_fish(FILE *stream) {
    char head[128], name[CMD_VERB_NAME];
    fputs("# fish completion for ztex, made by 'ztex help --completion fish'\nset -g __ztex_all", stream);
    put_dashed(stream, " ");
    fprintf(stream, "\n%s", fish_head);
    for (size_t v = 0; cmd_verbs[v]; v++) {
        const cmd_verb *verb = cmd_verbs[v];
        cmd_dashed(verb, name);
        fish_entrance(stream, verb);
        snprintf(head, sizeof head, "complete -c ztex -n '__ztex_is %s'", name);
        fish_verb(stream, head, verb);
        snprintf(head, sizeof head, "complete -c ztex-%s", name);
        fish_verb(stream, head, verb);
    }
}

int cmd_completion(FILE *stream, const char *shell) {
    if (strcmp(shell, "bash") == 0)
        print_bash(stream);
    else if (strcmp(shell, "zsh") == 0)
        print_zsh(stream);
    else
        print_fish(stream);
    return CMD_OK;
}
