/* SPDX-License-Identifier: Apache-2.0 */
/* Memory between two pages that cannot be accessed: a byte read or written outside of it ends the process. */
#ifndef ZT_FENCE_H
#define ZT_FENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

typedef struct fence {
    uint8_t *pages; /* the first page without access */
    size_t size;    /* of all pages */
} fence;

static inline size_t fence_page(void) {
    return (size_t)sysconf(_SC_PAGESIZE);
}

/* Room for blocks of up to size bytes. */
static inline fence fence_open(size_t size) {
    size_t page = fence_page();
    fence f = {NULL, ((size + page - 1) / page + 2) * page};
    void *pages = mmap(NULL, f.size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    f.pages = pages;
    if (pages == MAP_FAILED || mprotect(f.pages, page, PROT_NONE) != 0 ||
        mprotect(f.pages + f.size - page, page, PROT_NONE) != 0) {
        perror("memory between pages without access");
        abort();
    }
    return f;
}

/* A block of size bytes that begins where the room begins (low), or ends where it ends. */
static inline uint8_t *fence_block(const fence *f, size_t size, bool low) {
    size_t page = fence_page();
    return low ? f->pages + page : f->pages + f->size - page - size;
}

static inline void fence_close(fence *f) {
    munmap(f->pages, f->size);
}

#endif
