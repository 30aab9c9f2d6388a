/* SPDX-License-Identifier: Apache-2.0 */
/* The authoring library under the roof of the command: its threads, its progress, its errors. */
#ifndef ZTEX_MAKE_AUTHOR_H
#define ZTEX_MAKE_AUTHOR_H

#include <author.h>

#include "command.h"

/* The line of the progress shows the stage's name, and each stage has its own hundred per cent. */
typedef struct make_stages {
    const cmd_args *args;
    cmd_progress progress;
    char label[64];
} make_stages;

/* How the library works for this verb: --threads, progress, interruption. stages lives as long as the run;
 * make_stages_end clears its line. */
author_run make_author_run(cmd_args *args, make_stages *stages);
void make_stages_end(make_stages *stages);

/* Prints what went wrong; the exit code. */
int make_author_status(author_result result, const author_run *run);

#endif
