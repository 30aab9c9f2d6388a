/* SPDX-License-Identifier: Apache-2.0 */
/* A file, or standard input read whole, as a zt_io: for damaged files, which cmd_open refuses. */
#ifndef ZTEX_FILE_IO_H
#define ZTEX_FILE_IO_H

#include "command.h"

typedef struct file_io {
    zt_io io; /* its user is this struct, which must stay where it is */
    int fd;
    void *data;
} file_io;

/* Prints the message on failure. Returns a cmd_status. */
int file_io_open(const cmd_args *args, const char *path, file_io *out);
void file_io_close(file_io *file);

#endif
