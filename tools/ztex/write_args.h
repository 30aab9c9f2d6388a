/* SPDX-License-Identifier: Apache-2.0 */
/* Options that all verbs have that make texture files with --effort: rows for their tables, and what the words behind
 * them become. */
#ifndef ZTEX_WRITE_ARGS_H
#define ZTEX_WRITE_ARGS_H

#include "command.h"

#define WRITE_OPTION_OUTPUT                                                      \
    {                                                                            \
        .name = "output", .letter = 'o', .metavar = "FILE", .kind = CMD_TEXTURE, \
        .help = "The texture file to write; - is standard output. Required."     \
    }

#define WRITE_OPTION_RAW \
    { .name = "raw", .help = "Do not compress." }

#define WRITE_OPTION_NO_FSYNC \
    { .name = "no-fsync", .help = "Do not wait for the disk, for temporary files and bulk jobs." }

/* --tile-edge; 0 when it is not given: the library chooses, for block formats have smaller tiles. */
int write_read_tile_edge(const cmd_args *args, int *edge);
/* --effort, --raw and --no-fsync. progress may be NULL. */
zt_writer_options write_options(const cmd_args *args, cmd_progress *progress);

#endif
