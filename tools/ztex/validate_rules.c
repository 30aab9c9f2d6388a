/* SPDX-License-Identifier: Apache-2.0 */
/* --ignore, --only and --severity: which rules count, and as what. */
#include "validate.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_RULES = 512 };

static const char *nearest_name(const char *word) {
    const char *names[MOST_RULES];
    size_t count = 0;
    while (count < MOST_RULES && zt_get_rule((uint32_t)count)) {
        names[count] = zt_get_rule((uint32_t)count)->name;
        count++;
    }
    return cmd_nearest(word, names, count);
}

/* A number, also as R5203, or a name. Prints the message when there is no such rule. */
static int find_rule(const cmd_args *args, const char *option, const char *word, uint32_t *position) {
    char *end;
    const char *digits = word + (word[0] == 'R' || word[0] == 'r');
    unsigned long number = strtoul(digits, &end, 10);
    *position = 0;
    int numeric = digits[0] >= '0' && digits[0] <= '9' && *end == '\0';
    for (uint32_t i = 0; zt_get_rule(i); i++) {
        const zt_rule *rule = zt_get_rule(i);
        if (numeric ? rule->id == number : strcmp(rule->name, word) == 0) {
            *position = i;
            return CMD_OK;
        }
    }
    const char *near = numeric ? NULL : nearest_name(word);
    if (near)
        return cmd_usage(args, "--%s: there is no rule '%s': did you mean '%s'?", option, word, near);
    return cmd_usage(args, "--%s: there is no rule '%s': --list-rules lists them", option, word);
}

/* Sets the level of each rule of a comma-separated list. */
static int set_list(const cmd_args *args, const char *option, char *list, vld_level level, vld_level *levels) {
    char *rest = NULL;
    int status = CMD_OK;
    for (char *word = strtok_r(list, ",", &rest); word && status == CMD_OK; word = strtok_r(NULL, ",", &rest)) {
        uint32_t position;
        status = find_rule(args, option, word, &position);
        if (status == CMD_OK)
            levels[position] = level;
    }
    return status;
}

static int set_copy(const cmd_args *args, const char *option, const char *list, vld_level level, vld_level *levels) {
    char *copy = strdup(list);
    if (!copy)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    int status = set_list(args, option, copy, level, levels);
    free(copy);
    return status;
}

/* Rules that are not named are ignored. */
static int apply_only(const cmd_args *args, vld_settings *s) {
    vld_level *chosen = calloc(s->rule_count, sizeof *chosen);
    int status = chosen ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    for (size_t i = 0; status == CMD_OK && cmd_text_at(args, "only", i); i++)
        status = set_copy(args, "only", cmd_text_at(args, "only", i), VLD_IGNORE, chosen);
    for (uint32_t i = 0; status == CMD_OK && i < s->rule_count; i++) {
        if (chosen[i] != VLD_IGNORE)
            s->levels[i] = VLD_IGNORE;
    }
    free(chosen);
    return status;
}

static int apply_severity(const cmd_args *args, const char *text, vld_settings *s) {
    static const struct {
        const char *name;
        vld_level level;
    } words[] = {{"error", VLD_ERROR}, {"warning", VLD_WARNING}, {"ignore", VLD_IGNORE}};
    const char *equals = strchr(text, '=');
    for (size_t i = 0; equals && i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(equals + 1, words[i].name) != 0)
            continue;
        char *copy = strdup(text);
        if (!copy)
            return cmd_fail(CMD_INTERNAL, "out of memory");
        copy[equals - text] = '\0';
        int status = set_list(args, "severity", copy, words[i].level, s->levels);
        free(copy);
        return status;
    }
    return cmd_usage(args, "--severity: '%s' is not RULE=error, RULE=warning or RULE=ignore", text);
}

int vld_settings_read(const cmd_args *args, vld_settings *s) {
    while (zt_get_rule(s->rule_count))
        s->rule_count++;
    s->most = cmd_integer(args, "max");
    s->werror = cmd_given(args, "werror");
    s->levels = calloc(s->rule_count, sizeof *s->levels);
    if (!s->levels)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; i < s->rule_count; i++) {
        s->levels[i] = (vld_level)zt_get_rule(i)->severity;
        if (s->werror && s->levels[i] == VLD_WARNING)
            s->levels[i] = VLD_ERROR;
    }
    int status = cmd_given(args, "only") ? apply_only(args, s) : CMD_OK;
    for (size_t i = 0; status == CMD_OK && cmd_text_at(args, "ignore", i); i++)
        status = set_copy(args, "ignore", cmd_text_at(args, "ignore", i), VLD_IGNORE, s->levels);
    for (size_t i = 0; status == CMD_OK && cmd_text_at(args, "severity", i); i++)
        status = apply_severity(args, cmd_text_at(args, "severity", i), s);
    return status;
}
