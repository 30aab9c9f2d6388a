/* SPDX-License-Identifier: Apache-2.0 */
/* What ztex validate keeps of a file's findings, and how it shows them. */
#ifndef ZTEX_VALIDATE_H
#define ZTEX_VALIDATE_H

#include "command.h"

typedef enum vld_level { VLD_ERROR = 0, VLD_WARNING = 1, VLD_LIMIT = 2, VLD_IGNORE = 3 } vld_level;

/* What the options say about each rule of the catalogue. */
typedef struct vld_settings {
    vld_level *levels; /* by position in the catalogue */
    uint32_t rule_count;
    uint64_t most; /* findings shown of a rule in a file */
    int werror;
} vld_settings;

typedef struct vld_place {
    char *text;
    char path[64];
    uint64_t offset;
} vld_place;

/* All findings of one rule in one file: the first ones in full, the others counted. */
typedef struct vld_group {
    const zt_rule *rule;
    vld_level level;
    uint64_t count;
    vld_place *places;
    size_t place_count;
} vld_group;

typedef struct vld_file {
    const vld_settings *settings;
    cmd_progress *progress;
    const char *name;
    vld_group *groups;
    size_t group_count;
    uint64_t errors, warnings, limits, ignored;
    int complete;
    int status; /* of the check itself: CMD_OK when it ran */
    zt_diag diag;
} vld_file;

/* From --ignore, --only, --severity, --max, --werror. Prints what is wrong with them. */
int vld_settings_read(const cmd_args *args, vld_settings *settings);

/* For zt_check_options.finding with user = the vld_file. */
int vld_take(void *user, const zt_finding *finding);
void vld_file_free(vld_file *file);

int vld_is_valid(const vld_file *file); /* the check ran, and there are no errors */
void vld_print(const cmd_args *args, const vld_file *file);
json_t *vld_json(const vld_file *file);

/* The catalogue. */
int vld_list_rules(const vld_settings *settings, int as_json);

#endif
