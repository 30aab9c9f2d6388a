/* SPDX-License-Identifier: Apache-2.0 */
/* A zt_sink into memory, which can be told to fail. */
#ifndef ZT_TESTS_WRITE_SINK_H
#define ZT_TESTS_WRITE_SINK_H

#include <stdlib.h>
#include <string.h>

#include "zt/zt_write.h"

typedef struct memory_sink {
    uint8_t *data;
    size_t size, capacity;
    long fail_at; /* this call fails; -1: none */
    long calls;
} memory_sink;

static inline zt_result memory_sink_write(void *user, const void *data, size_t size) {
    memory_sink *s = user;
    if (s->calls++ == s->fail_at)
        return ZT_IO;
    while (s->size + size > s->capacity) {
        s->capacity = s->capacity ? 2 * s->capacity : 65536;
        s->data = realloc(s->data, s->capacity);
        if (!s->data)
            abort();
    }
    memcpy(s->data + s->size, data, size);
    s->size += size;
    return ZT_OK;
}

static inline zt_sink memory_sink_of(memory_sink *s) {
    zt_sink sink = {s, memory_sink_write};
    memset(s, 0, sizeof *s);
    s->fail_at = -1;
    return sink;
}

#endif
