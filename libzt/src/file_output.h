/* SPDX-License-Identifier: Apache-2.0 */
/* Where a file is written: a temporary file that takes the place of a path in the end, or a sink. And the system calls
 * for both, and for the spool, that do not give up half-way. */
#ifndef ZT_FILE_OUTPUT_H
#define ZT_FILE_OUTPUT_H

#include <stdbool.h>

#include "base_memory.h"
#include "zt/zt_write.h"

/* ZT_IO with the name of the call and the system's reason. */
zt_result zt__io_failed(zt_diag *diag, const char *call, const char *path, int error);

/* Creates a file of a new name in a folder; its name, allocated, in *name when that is not NULL, else the file has no
 * name any more. */
zt_result zt__create_temporary(zt__memory *memory, const char *folder, zt_diag *diag, int *fd, char **name);

/* All of the bytes, or ZT_IO. */
zt_result zt__write_all(int fd, const void *data, size_t size, zt_diag *diag);
zt_result zt__pread_all(int fd, void *dst, size_t size, uint64_t offset, zt_diag *diag);

/* The folder of a path, allocated; "." when it names none. */
zt_result zt__folder_of(zt__memory *memory, const char *path, zt_diag *diag, char **folder);
void zt__free_text(zt__memory *memory, char *text);

typedef struct zt__output {
    zt__memory *memory;
    const zt_sink *sink; /* NULL: a path */
    const char *path, *folder;
    bool wait; /* for the disk */
    int fd;
    char *temporary;
    uint8_t *buffer;
    size_t fill;
} zt__output;

/* sink, path and folder live as long as the output. Then put, then either finish or abandon. */
zt_result zt__output_open(zt__output *output, zt__memory *memory, const zt_sink *sink, const char *path,
                          const char *folder, bool wait, zt_diag *diag);
zt_result zt__output_put(zt__output *output, const void *data, size_t size, zt_diag *diag);
/* Writes what is left; for a path: fsync, rename, fsync of the folder. */
zt_result zt__output_finish(zt__output *output, zt_diag *diag);
/* Releases everything and removes the temporary file, if there still is one. */
void zt__output_close(zt__output *output);

#endif
