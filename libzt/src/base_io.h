/* SPDX-License-Identifier: Apache-2.0 */
/* zt_io over memory and over a path. */
#ifndef ZT_BASE_IO_H
#define ZT_BASE_IO_H

#include "base_memory.h"

/* data must stay. The io needs no closing: its user is the struct given. */
typedef struct zt__memory_io {
    const uint8_t *data;
    uint64_t size;
} zt__memory_io;

zt_io zt__io_of_memory(zt__memory_io *memory);

/* A regular file read with pread. fd is closed by zt__path_io_close. */
typedef struct zt__path_io {
    int fd;
} zt__path_io;

/* Errors: ZT_IO with the system's reason in diag (also for what is not a regular file). */
zt_result zt__path_io_open(zt__path_io *path_io, const char *path, zt_diag *diag, zt_io *out);
void zt__path_io_close(zt__path_io *path_io);

/* The bytes themselves where the io is zt__io_of_memory and has them; else NULL. */
const uint8_t *zt__bytes_in_memory(const zt_io *io, uint64_t offset, size_t size);

/* Reads and turns a refusal of the io into a diagnostic: ZT_AGAIN with the wanted range, ZT_IO. Bytes behind io->size:
 * ZT_TRUNCATED. */
zt_result zt__read(const zt_io *io, uint64_t offset, void *dst, size_t size, zt_diag *diag);

#endif
