/* SPDX-License-Identifier: Apache-2.0 */
#include "base_memory.h"

#include <stdlib.h>
#include <string.h>

#include "base_bytes.h"
#include "base_diag.h"

static void *system_alloc(void *user, size_t size) {
    (void)user;
    return malloc(size);
}

static void system_free(void *user, void *ptr, size_t size) {
    (void)user;
    (void)size;
    free(ptr);
}

void zt__memory_init(zt__memory *memory, const zt_allocator *allocator, uint64_t budget) {
    if (allocator) {
        memory->allocator = *allocator;
    } else {
        memory->allocator.user = NULL;
        memory->allocator.alloc = system_alloc;
        memory->allocator.free = system_free;
    }
    memory->budget = budget;
    atomic_init(&memory->used, 0);
}

/* Takes size bytes from the budget; false when they are not there. */
static bool reserve(zt__memory *memory, uint64_t size) {
    uint64_t used = atomic_load_explicit(&memory->used, memory_order_relaxed);
    do {
        if (size > memory->budget || used > memory->budget - size)
            return false;
    } while (!atomic_compare_exchange_weak_explicit(&memory->used, &used, used + size, memory_order_relaxed,
                                                    memory_order_relaxed));
    return true;
}

zt_result zt__alloc_raw(zt__memory *memory, uint64_t count, size_t size, zt_diag *diag, void **out) {
    uint64_t product;
    size_t bytes;
    *out = NULL;
    if (!zt__mul64(count, size, &product) || !zt__to_size(product, &bytes) || bytes > PTRDIFF_MAX)
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "%llu x %zu bytes are more than can be addressed",
                        (unsigned long long)count, size);
    if (bytes == 0)
        return ZT_OK;
    if (!reserve(memory, bytes))
        return zt__fail(diag, ZT_LIMIT, 1010, ZT__NO_OFFSET,
                        "%zu more bytes of memory would be over the limit of %llu (zt_limits.memory)", bytes,
                        (unsigned long long)memory->budget);
    *out = memory->allocator.alloc(memory->allocator.user, bytes);
    if (!*out) {
        atomic_fetch_sub_explicit(&memory->used, bytes, memory_order_relaxed);
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "no memory for %zu bytes", bytes);
    }
    return ZT_OK;
}

zt_result zt__alloc(zt__memory *memory, uint64_t count, size_t size, zt_diag *diag, void **out) {
    ZT_TRY(zt__alloc_raw(memory, count, size, diag, out));
    if (*out)
        memset(*out, 0, (size_t)(count * size));
    return ZT_OK;
}

void zt__free(zt__memory *memory, void *ptr, uint64_t count, size_t size) {
    if (!ptr)
        return;
    memory->allocator.free(memory->allocator.user, ptr, (size_t)(count * size));
    atomic_fetch_sub_explicit(&memory->used, count * size, memory_order_relaxed);
}
