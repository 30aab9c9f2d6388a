/* SPDX-License-Identifier: Apache-2.0 */
/* Memory on a budget: every block of an opened file, sampler or writer is counted against zt_limits.memory before it is
 * asked for. */
#ifndef ZT_BASE_MEMORY_H
#define ZT_BASE_MEMORY_H

#include <stdatomic.h>
#include <stdint.h>

#include "zt/zt.h"

typedef struct zt__memory {
    zt_allocator allocator;
    uint64_t budget;
    _Atomic uint64_t used;
} zt__memory;

/* allocator NULL: malloc and free. */
void zt__memory_init(zt__memory *memory, const zt_allocator *allocator, uint64_t budget);

/* count x size bytes, zeroed. ZT_LIMIT: over the budget (diag names it); ZT_NO_MEMORY: overflow of size_t, or the
 * allocator said no. *out is NULL on failure and when the product is 0. diag may be NULL. */
zt_result zt__alloc(zt__memory *memory, uint64_t count, size_t size, zt_diag *diag, void **out);

/* The same without zeroing, for buffers that are filled at once. */
zt_result zt__alloc_raw(zt__memory *memory, uint64_t count, size_t size, zt_diag *diag, void **out);

/* ptr may be NULL; count and size as at allocation. */
void zt__free(zt__memory *memory, void *ptr, uint64_t count, size_t size);

#endif
