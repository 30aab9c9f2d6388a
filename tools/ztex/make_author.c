/* SPDX-License-Identifier: Apache-2.0 */
/* Between the command and the authoring library. */
#include "make_author.h"

#include <string.h>

static int show_stage(void *user, const char *stage, double done) {
    make_stages *stages = user;
    if (strcmp(stages->label, stage) != 0) {
        make_stages_end(stages);
        snprintf(stages->label, sizeof stages->label, "%s", stage);
        cmd_progress_begin(&stages->progress, stages->args, stages->label);
    }
    return cmd_progress_step(&stages->progress, done);
}

author_run make_author_run(cmd_args *args, make_stages *stages) {
    *stages = (make_stages){.args = args};
    return (author_run){.parallel = cmd_parallel(args), .progress = show_stage, .user = stages};
}

void make_stages_end(make_stages *stages) {
    if (stages->label[0])
        cmd_progress_end(&stages->progress);
    stages->label[0] = '\0';
}

int make_author_status(author_result result, const author_run *run) {
    switch (result) {
    case AUTHOR_OK:
        return CMD_OK;
    case AUTHOR_CANCELLED:
        return cmd_cancelled();
    case AUTHOR_BAD_INPUT:
        return cmd_fail(CMD_USAGE, "%s", run->error);
    default:
        return cmd_fail(CMD_INTERNAL, "%s", run->error);
    }
}
