/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When the system refuses a call of the writer, whichever and whenever: ZT_IO with the name of the call and the reason,
 * at the path what was there before (or, behind the rename, the new file whole), no temporary file and no descriptor
 * left. Calls that a signal interrupts are made again (no signal interrupts a rename). Disks fill up and fail while
 * textures are written.
 *
 * This program defines the calls itself; they stand in front of libc's.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "test.h"

typedef enum call { OPEN, WRITE, PREAD, FSYNC, CLOSE, RENAME, CALLS } call;

static const char *const call_names[CALLS] = {"open", "write", "pread", "fsync", "close", "rename"};
/* What the diagnostic calls them; open is told as what it was for. */
static const char *const words[CALLS] = {"", "write", "pread", "fsync", "close", "rename"};

/* Which call fails: the at-th of its kind from now on, 0: none. */
static struct {
    call kind;
    int at, error;
    bool shortened; /* it does only a part of the work instead */
} fault;
static int made[CALLS];

/* MemorySanitizer's, which does not see what a plain system call reads. */
void __msan_unpoison(const volatile void *data, size_t size) __attribute__((weak));

static bool fails(call kind) {
    return ++made[kind] == fault.at && kind == fault.kind;
}

static int refuse(void) {
    errno = fault.error;
    return -1;
}

int open(const char *path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    unsigned mode = flags & O_CREAT ? va_arg(list, unsigned) : 0;
    va_end(list);
    return fails(OPEN) ? refuse() : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

ssize_t write(int fd, const void *data, size_t size) {
    if (fails(WRITE)) {
        if (!fault.shortened)
            return refuse();
        size = size > 1 ? size / 2 : size;
    }
    return syscall(SYS_write, fd, data, size);
}

ssize_t pread(int fd, void *data, size_t size, off_t offset) {
    if (fails(PREAD)) {
        if (!fault.shortened)
            return refuse();
        size = size > 1 ? size / 2 : size;
    }
    ssize_t n = syscall(SYS_pread64, fd, data, size, offset);
    if (n > 0 && __msan_unpoison)
        __msan_unpoison(data, (size_t)n);
    return n;
}

int fsync(int fd) {
    return fails(FSYNC) ? refuse() : (int)syscall(SYS_fsync, fd);
}

/* As on Linux, the descriptor is gone even then. */
int close(int fd) {
    int result = (int)syscall(SYS_close, fd);
    return fails(CLOSE) ? refuse() : result;
}

int rename(const char *from, const char *to) {
    return fails(RENAME) ? refuse() : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

/* ---- writing ---- */

enum { EDGE = 640 }; /* more bytes than the writer's buffer has */

static uint8_t texels[EDGE * EDGE * 4];
static char folder[200], path[256];
static const char old[] = "what was here before";

static zt_result write_texture(bool wait, zt_diag *diag) {
    zt_writer_options options = {.raw_only = 1, .spool_memory = 1, .flags = wait ? 0 : ZT_WRITE_NO_FSYNC};
    zt_image_desc desc = {.format = 37, .width = EDGE, .height = EDGE, .levels = 1};
    zt_writer *writer = NULL;
    uint32_t image;
    zt_result r = zt_writer_open_path(path, &options, diag, &writer);
    if (r == ZT_OK)
        r = zt_writer_add_image(writer, &desc, diag, &image);
    if (r == ZT_OK)
        r = zt_writer_put_rows(writer, image, texels, EDGE, 0, diag);
    if (r == ZT_OK)
        r = zt_writer_add_texture(writer, &(zt_texture_desc){.name = "one"}, diag, NULL);
    if (r == ZT_OK)
        r = zt_writer_finish(writer, diag);
    zt_writer_close(writer);
    return r;
}

/* ---- what is there afterwards ---- */

static int files_in_folder(void) {
    int n = 0;
    DIR *d = opendir(folder);
    CHECK(d != NULL);
    for (struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d))
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    if (d)
        closedir(d);
    return n;
}

static void put_old(void) {
    FILE *f = fopen(path, "wb");
    CHECK(f && fwrite(old, 1, sizeof old, f) == sizeof old && fclose(f) == 0);
}

static bool is_old(void) {
    char found[sizeof old + 1];
    FILE *f = fopen(path, "rb");
    size_t n = f ? fread(found, 1, sizeof found, f) : 0;
    if (f)
        fclose(f);
    return n == sizeof old && memcmp(found, old, sizeof old) == 0;
}

static bool is_new(void) {
    zt_check_summary summary;
    return zt_check_path(path, NULL, NULL, &summary) == ZT_OK && summary.complete && summary.errors == 0;
}

static int next_descriptor(void) {
    int fd = (int)syscall(SYS_dup, 0);
    syscall(SYS_close, fd);
    return fd;
}

/* ---- the property ---- */

/* Returns whether the fault was met. */
static bool run(call kind, int at, int error, bool shortened, bool with_old) {
    zt_diag diag = {0};
    int descriptor = next_descriptor();
    unlink(path);
    if (with_old)
        put_old();
    memset(made, 0, sizeof made);
    fault.kind = kind, fault.at = at, fault.error = error, fault.shortened = shortened;
    zt_result r = write_texture(true, &diag);
    fault.at = 0;
    bool met = made[kind] >= at, harmless = shortened || (error == EINTR && kind != RENAME);
    /* Behind the rename a new file is there; a folder that cannot be synced is told all the same. */
    bool in_place = made[RENAME] > 0 && kind != RENAME;
    bool ok = r == ZT_OK ? is_new() : in_place ? is_new() : with_old ? is_old() : access(path, F_OK) != 0;
    ok = ok && files_in_folder() == (r == ZT_OK || in_place || with_old) && next_descriptor() == descriptor;
    if (r != ZT_OK)
        ok = ok && r == ZT_IO && diag.result == r && strstr(diag.text, words[kind]) &&
             strstr(diag.text, strerror(error));
    if (!met || harmless)
        ok = ok && r == ZT_OK;
    CHECK(ok);
    if (!ok)
        fprintf(stderr, "%s number %d, %s%s: %s: %s\n", call_names[kind], at, strerror(error),
                shortened ? ", shortened" : "", zt_result_text(r), diag.text);
    return met;
}

/* Every call of a kind fails once, for each reason; then some work by halves. */
static void test_kind(call kind) {
    static const int errors[] = {EIO, ENOSPC, EINTR};
    int count = 0;
    for (int e = 0; e < 3; e++)
        for (int at = 1; run(kind, at, errors[e], false, at % 2 != 0) && at < 1000; at++)
            count++;
    CHECK(count >= 3);
    for (int at = 1; (kind == WRITE || kind == PREAD) && run(kind, at, EIO, true, true) && at < 1000; at++)
        count++;
}

/* Without waiting for the disk there is nothing to sync. */
static void test_no_fsync(void) {
    zt_diag diag = {0};
    memset(made, 0, sizeof made);
    CHECK(write_texture(false, &diag) == ZT_OK);
    CHECK(made[FSYNC] == 0 && made[RENAME] == 1);
    CHECK(is_new());
}

int main(void) {
    const char *temporary = getenv("TMPDIR");
    uint64_t seed = 3;
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)test_random(&seed);
    snprintf(folder, sizeof folder, "%s/zt-faults-XXXXXX", temporary ? temporary : "/tmp");
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof path, "%s/texture.ztex", folder);
    for (call kind = OPEN; kind < CALLS; kind++)
        test_kind(kind);
    test_no_fsync();
    unlink(path);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
