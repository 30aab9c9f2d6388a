/* SPDX-License-Identifier: Apache-2.0 */
/* Where coded tiles wait until the file is laid out: memory first, then a temporary file without a name. */
#ifndef ZT_FILE_SPOOL_H
#define ZT_FILE_SPOOL_H

#include <stdbool.h>

#include "base_memory.h"

typedef struct zt__spool {
    zt__memory *memory;
    const char *folder; /* of the temporary file; lives as long as the spool */
    uint8_t **blocks;
    uint64_t block_count, block_capacity;
    uint64_t most_blocks;
    bool full;     /* memory is: everything behind it is in the file */
    uint64_t size; /* bytes so far */
    int fd;        /* -1: none yet */
} zt__spool;

void zt__spool_init(zt__spool *spool, zt__memory *memory, const char *folder, uint64_t memory_bytes);
void zt__spool_free(zt__spool *spool);

/* *place gets where the bytes are. */
zt_result zt__spool_append(zt__spool *spool, const void *data, size_t size, zt_diag *diag, uint64_t *place);
zt_result zt__spool_read(const zt__spool *spool, uint64_t place, void *dst, size_t size, zt_diag *diag);

#endif
