/* SPDX-License-Identifier: Apache-2.0 */
/* Findings of ztex validate: collected by rule, so that one mistake made a thousand times is told once. */
#include "validate.h"

#include <stdlib.h>
#include <string.h>

static const char *const level_names[] = {"error", "warning", "limit", "ignored"};

/* ---- collecting --------------------------------------------------------------------------------- */

static uint32_t position_of(uint32_t rule) {
    uint32_t i = 0;
    while (zt_get_rule(i) && zt_get_rule(i)->id != rule)
        i++;
    return i;
}

static vld_group *group_of(vld_file *file, uint32_t rule, vld_level level) {
    for (size_t i = 0; i < file->group_count; i++) {
        if (file->groups[i].rule->id == rule)
            return &file->groups[i];
    }
    vld_group *groups = realloc(file->groups, (file->group_count + 1) * sizeof *groups);
    if (!groups)
        return NULL;
    file->groups = groups;
    groups[file->group_count] = (vld_group){.rule = zt_find_rule(rule), .level = level};
    return &groups[file->group_count++];
}

static int add_place(vld_group *group, const zt_finding *finding) {
    vld_place *places = realloc(group->places, (group->place_count + 1) * sizeof *places);
    if (!places)
        return -1;
    group->places = places;
    vld_place *place = &places[group->place_count];
    *place = (vld_place){.text = strdup(finding->text), .offset = finding->offset};
    snprintf(place->path, sizeof place->path, "%s", finding->path);
    group->place_count += place->text != NULL;
    return place->text ? 0 : -1;
}

int vld_take(void *user, const zt_finding *finding) {
    vld_file *file = user;
    const vld_settings *settings = file->settings;
    uint32_t position = position_of(finding->rule);
    vld_level level = position < settings->rule_count ? settings->levels[position] : (vld_level)finding->severity;
    uint64_t *counts[] = {&file->errors, &file->warnings, &file->limits, &file->ignored};
    ++*counts[level];
    if (level == VLD_IGNORE)
        return cmd_interrupted();
    vld_group *group = group_of(file, finding->rule, level);
    if (!group)
        return 1;
    if (++group->count <= settings->most && add_place(group, finding))
        return 1;
    return cmd_interrupted();
}

void vld_file_free(vld_file *file) {
    for (size_t i = 0; i < file->group_count; i++) {
        for (size_t k = 0; k < file->groups[i].place_count; k++)
            free(file->groups[i].places[k].text);
        free(file->groups[i].places);
    }
    free(file->groups);
    *file = (vld_file){0};
}

int vld_is_valid(const vld_file *file) {
    return file->status == CMD_OK && file->errors == 0;
}

/* ---- text ------------------------------------------------------------------------------------------ */

static void print_count(uint64_t count, const char *noun, const char *before) {
    if (count > 0)
        printf("%s%llu %s%s", before, (unsigned long long)count, noun, count == 1 ? "" : "s");
}

static void print_verdict(const vld_file *file) {
    cmd_print_safe(stdout, file->name);
    if (file->status != CMD_OK) {
        printf(": not checked: ");
        cmd_print_safe(stdout, file->diag.text[0] ? file->diag.text : zt_result_text(file->diag.result));
        printf("\n");
        return;
    }
    printf(": %s", file->errors ? "invalid" : "valid");
    print_count(file->errors, "error", ": ");
    print_count(file->warnings, "warning", file->errors ? ", " : ": ");
    print_count(file->limits, "limit", file->errors + file->warnings ? ", " : ": ");
    if (!file->complete)
        printf("; not all of it could be checked");
    printf("\n");
}

static void print_group(const vld_group *group) {
    for (size_t i = 0; i < group->place_count; i++) {
        const vld_place *place = &group->places[i];
        printf("  %-7s R%u %s: %s", level_names[group->level], (unsigned)group->rule->id, group->rule->name,
               place->text);
        printf(" (%s", place->path[0] ? place->path : "file");
        if (place->offset != UINT64_MAX)
            printf(", offset %llu", (unsigned long long)place->offset);
        printf(")\n");
    }
    if (group->count > group->place_count)
        printf("  %-7s R%u %s: and %llu more\n", level_names[group->level], (unsigned)group->rule->id,
               group->rule->name, (unsigned long long)(group->count - group->place_count));
}

void vld_print(const cmd_args *args, const vld_file *file) {
    if (args->quiet && vld_is_valid(file))
        return;
    print_verdict(file);
    for (size_t i = 0; i < file->group_count; i++)
        print_group(&file->groups[i]);
}

/* ---- JSON ------------------------------------------------------------------------------------------ */

static json_t *group_json(const vld_group *group) {
    json_t *object = json_object(), *places = json_array();
    json_object_set_new(object, "rule", json_integer(group->rule->id));
    json_object_set_new(object, "name", json_string(group->rule->name));
    json_object_set_new(object, "severity", json_string(level_names[group->level]));
    json_object_set_new(object, "anchor", json_string(group->rule->anchor));
    json_object_set_new(object, "count", cmd_json_u64(group->count));
    for (size_t i = 0; i < group->place_count; i++) {
        json_t *place = json_object();
        json_object_set_new(place, "text", cmd_json_text(group->places[i].text));
        json_object_set_new(place, "path", cmd_json_text(group->places[i].path));
        json_object_set_new(place, "offset", cmd_json_offset(group->places[i].offset));
        json_array_append_new(places, place);
    }
    json_object_set_new(object, "places", places);
    return object;
}

json_t *vld_json(const vld_file *file) {
    json_t *object = json_object(), *findings = json_array();
    json_object_set_new(object, "file", cmd_json_text(file->name));
    json_object_set_new(object, "checked", json_boolean(file->status == CMD_OK));
    json_object_set_new(object, "valid", json_boolean(vld_is_valid(file)));
    json_object_set_new(object, "complete", json_boolean(file->complete));
    json_object_set_new(object, "errors", cmd_json_u64(file->errors));
    json_object_set_new(object, "warnings", cmd_json_u64(file->warnings));
    json_object_set_new(object, "limits", cmd_json_u64(file->limits));
    json_object_set_new(object, "ignored", cmd_json_u64(file->ignored));
    for (size_t i = 0; i < file->group_count; i++)
        json_array_append_new(findings, group_json(&file->groups[i]));
    json_object_set_new(object, "findings", findings);
    if (file->status != CMD_OK)
        json_object_set_new(object, "problem",
                            cmd_json_text(file->diag.text[0] ? file->diag.text : zt_result_text(file->diag.result)));
    return object;
}

/* ---- the catalogue ---------------------------------------------------------------------------------- */

static int list_json(const vld_settings *settings) {
    json_t *rules = json_array(), *root = json_object();
    for (uint32_t i = 0; i < settings->rule_count; i++) {
        const zt_rule *rule = zt_get_rule(i);
        json_t *row = json_object();
        json_object_set_new(row, "rule", json_integer(rule->id));
        json_object_set_new(row, "name", json_string(rule->name));
        json_object_set_new(row, "severity", json_string(level_names[settings->levels[i]]));
        json_object_set_new(row, "anchor", json_string(rule->anchor));
        json_object_set_new(row, "text", json_string(rule->text));
        json_array_append_new(rules, row);
    }
    json_object_set_new(root, "rules", rules);
    int status = cmd_json_print(stdout, root);
    json_decref(root);
    return status;
}

int vld_list_rules(const vld_settings *settings, int as_json) {
    if (as_json)
        return list_json(settings);
    for (uint32_t i = 0; i < settings->rule_count; i++) {
        const zt_rule *rule = zt_get_rule(i);
        printf("R%-5u %-8s %-28s %s (%s)\n", (unsigned)rule->id, level_names[settings->levels[i]], rule->name,
               rule->text, rule->anchor);
    }
    return ferror(stdout) ? cmd_fail(CMD_IO, "standard output: writing failed") : CMD_OK;
}
