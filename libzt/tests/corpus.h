/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests over conformance/ share: files in memory, and an allocator that counts and fails when told to. */
#ifndef ZT_TEST_CORPUS_H
#define ZT_TEST_CORPUS_H

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zt/zt.h>

#define VALID_FOLDER "conformance/valid/"
#define INVALID_FOLDER "conformance/invalid/"

typedef struct blob {
    uint8_t *data;
    size_t size;
} blob;

/* A heap block of exactly the file's size: a sanitizer sees reads behind the end. */
static inline blob blob_read(const char *folder, const char *name) {
    char path[512];
    blob b = {NULL, 0};
    snprintf(path, sizeof path, "%s%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: cannot be opened (the working directory is the repository)\n", path);
        exit(2);
    }
    fseek(file, 0, SEEK_END);
    b.size = (size_t)ftell(file);
    rewind(file);
    b.data = malloc(b.size ? b.size : 1);
    assert(b.data && fread(b.data, 1, b.size, file) == b.size);
    fclose(file);
    return b;
}

/* The first size bytes in a block of their own. */
static inline blob blob_prefix(blob from, size_t size) {
    blob b = {malloc(size ? size : 1), size};
    assert(b.data);
    memcpy(b.data, from.data, size);
    return b;
}

static inline void blob_free(blob b) {
    free(b.data);
}

/* Is all of this in one of the extents? */
static inline bool covers(const zt_extent *extents, size_t count, uint64_t offset, uint64_t size) {
    for (size_t i = 0; i < count; i++) {
        if (offset >= extents[i].offset && offset + size <= extents[i].offset + extents[i].size)
            return true;
    }
    return false;
}

/* ---- manifests: one entry a line ---- */

/* The text behind "key": in a line, or NULL. */
static inline const char *value_of(const char *line, const char *key) {
    char pattern[64];
    snprintf(pattern, sizeof pattern, "\"%s\": ", key);
    const char *at = strstr(line, pattern);
    return at ? at + strlen(pattern) : NULL;
}

static inline void string_of(const char *line, const char *key, char *out, size_t size) {
    const char *value = value_of(line, key);
    size_t n = 0;
    assert(value && *value == '"');
    for (value++; *value != '"' && n + 1 < size; value++)
        out[n++] = *value;
    out[n] = 0;
}

static inline uint32_t number_of(const char *line, const char *key) {
    const char *value = value_of(line, key);
    return value ? (uint32_t)strtoul(value, NULL, 10) : 0;
}

/* Calls test with each line that has the key (NULL: with all); returns their number. */
static inline uint32_t each_line_with(const char *path, const char *key, void test(const char *line)) {
    static char line[1 << 16];
    uint32_t count = 0;
    FILE *file = fopen(path, "r");
    assert(file);
    while (fgets(line, sizeof line, file)) {
        if (!key || value_of(line, key)) {
            test(line);
            count++;
        }
    }
    fclose(file);
    return count;
}

/* Of the manifests and lists whose entries have a line each. */
static inline uint32_t each_line(const char *path, void test(const char *line)) {
    return each_line_with(path, "file", test);
}

/* Reads count numbers of a JSON list; returns what is behind them. */
static inline const char *numbers_of(const char *text, double *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *end;
        text += strspn(text, "[, ");
        out[i] = strtod(text, &end);
        assert(end != text);
        text = end;
    }
    return text;
}

/* A file of the corpus by its name. The last one is kept open, for files follow each other in the lists; "" closes
 * it. */
static inline const zt_file *valid_file(const char *name) {
    static char open_name[256];
    static zt_file *file;
    static blob bytes;
    zt_diag diag;
    if (strcmp(open_name, name) == 0)
        return file;
    zt_close(file);
    blob_free(bytes);
    file = NULL;
    bytes = (blob){NULL, 0};
    snprintf(open_name, sizeof open_name, "%s", name);
    if (!name[0])
        return NULL;
    bytes = blob_read(VALID_FOLDER, name);
    zt_result result = zt_open_memory(bytes.data, bytes.size, NULL, &diag, &file);
    assert(result == ZT_OK);
    (void)result;
    return file;
}

static inline double real_of(const char *line, const char *key) {
    const char *value = value_of(line, key);
    return value ? strtod(value, NULL) : 0;
}

/* The light of a lookup or a ray, if there is one. */
static inline void light_of(const char *line, zt_sampler_options *options) {
    options->light_x = real_of(line, "light_x");
    options->light_y = real_of(line, "light_y");
    options->shadow = real_of(line, "shadow");
}

/* Not for several threads at once. */
typedef struct counting {
    zt_allocator allocator;
    uint64_t live, peak, calls;
    uint64_t fail_at; /* this call gets no memory, counted from 1; 0: none */
    bool fail_on;     /* and none of those behind it */
} counting;

static inline void *counting_alloc(void *user, size_t size) {
    counting *c = user;
    assert(size > 0);
    c->calls++;
    if (c->fail_at > 0 && (c->calls == c->fail_at || (c->fail_on && c->calls > c->fail_at)))
        return NULL;
    c->live += size;
    c->peak = c->live > c->peak ? c->live : c->peak;
    return malloc(size);
}

static inline void counting_free(void *user, void *ptr, size_t size) {
    counting *c = user;
    assert(ptr && size > 0 && size <= c->live);
    c->live -= size;
    free(ptr);
}

/* allocator.user points into c, which must not move. */
static inline void counting_init(counting *c) {
    memset(c, 0, sizeof *c);
    c->allocator.user = c;
    c->allocator.alloc = counting_alloc;
    c->allocator.free = counting_free;
}

#endif
