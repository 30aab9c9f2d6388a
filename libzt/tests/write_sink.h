/* SPDX-License-Identifier: Apache-2.0 */
/* Files that a test makes: a zt_sink into memory, which can be told to fail, and the way back. */
#ifndef ZT_TESTS_WRITE_SINK_H
#define ZT_TESTS_WRITE_SINK_H

#include <stdio.h>
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

/* For what comes before the test: ends the program where it fails. */
static inline void must(zt_result result, const zt_diag *diag) {
    if (result == ZT_OK)
        return;
    fprintf(stderr, "%s: rule %u: %s: %s\n", zt_result_text(result), diag->rule, diag->path, diag->text);
    abort();
}

static inline zt_file *memory_sink_open(const memory_sink *s) {
    zt_file *file;
    zt_diag diag;
    must(zt_open_memory(s->data, s->size, NULL, &diag, &file), &diag);
    return file;
}

#endif
