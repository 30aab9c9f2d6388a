/* SPDX-License-Identifier: Apache-2.0 */
#include "file_output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base_diag.h"

enum {
    BUFFER = 1 << 20,
    PIECE = 1 << 30, /* of one system call: some systems take no more than 2^31 - 1 */
    ATTEMPTS = 10000
};

zt_result zt__io_failed(zt_diag *diag, const char *call, const char *path, int error) {
    char reason[128] = "unknown reason";
    if (strerror_r(error, reason, sizeof reason) != 0)
        snprintf(reason, sizeof reason, "error %d", error);
    return zt__fail(diag, ZT_IO, 0, ZT__NO_OFFSET, "%s%s%s: %s", call, path ? " " : "", path ? path : "", reason);
}

void zt__free_text(zt__memory *memory, char *text) {
    if (text)
        zt__free(memory, text, strlen(text) + 1, 1);
}

zt_result zt__folder_of(zt__memory *memory, const char *path, zt_diag *diag, char **folder) {
    const char *slash = strrchr(path, '/');
    const char *from = slash ? path : ".";
    size_t size = 1;
    if (slash && slash != path)
        size = (size_t)(slash - path);
    void *block;
    *folder = NULL;
    ZT_TRY(zt__alloc(memory, size + 1, 1, diag, &block));
    memcpy(block, from, size);
    *folder = block;
    return ZT_OK;
}

/* The name is not in any output: process and a counter are enough, O_EXCL decides. */
static int create_numbered(char *name, size_t name_size, const char *folder) {
    for (int i = 0; i < ATTEMPTS; i++) {
        int n = snprintf(name, name_size, "%s/.ztex-%ld-%d.tmp", folder, (long)getpid(), i);
        if (n < 0 || (size_t)n >= name_size) {
            errno = ENAMETOOLONG;
            return -1;
        }
        int fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOCTTY, 0666);
        if (fd >= 0 || (errno != EEXIST && errno != EINTR))
            return fd;
    }
    errno = EEXIST;
    return -1;
}

zt_result zt__create_temporary(zt__memory *memory, const char *folder, zt_diag *diag, int *fd, char **name) {
    void *block;
    size_t size = strlen(folder) + 64;
    *fd = -1;
    if (name)
        *name = NULL;
    ZT_TRY(zt__alloc(memory, size, 1, diag, &block));
    char *full = block;
    int got = create_numbered(full, size, folder);
    zt_result r = ZT_OK;
    if (got < 0) {
        r = zt__io_failed(diag, "creating a temporary file in", folder, errno);
    } else if (!name) {
        (void)unlink(full);
    } else {
        r = zt__alloc(memory, strlen(full) + 1, 1, diag, &block);
        if (r == ZT_OK) {
            *name = block;
            memcpy(*name, full, strlen(full));
        } else {
            (void)unlink(full);
            close(got);
            got = -1;
        }
    }
    *fd = got;
    zt__free(memory, full, size, 1);
    return r;
}

zt_result zt__write_all(int fd, const void *data, size_t size, zt_diag *diag) {
    const uint8_t *bytes = data;
    while (size > 0) {
        ssize_t n = write(fd, bytes, size < PIECE ? size : PIECE);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return zt__io_failed(diag, "write", NULL, n < 0 ? errno : ENOSPC);
        bytes += n;
        size -= (size_t)n;
    }
    return ZT_OK;
}

zt_result zt__pread_all(int fd, void *dst, size_t size, uint64_t offset, zt_diag *diag) {
    uint8_t *bytes = dst;
    while (size > 0) {
        ssize_t n = pread(fd, bytes, size < PIECE ? size : PIECE, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return zt__io_failed(diag, "pread of the temporary file", NULL, n < 0 ? errno : EIO);
        bytes += n;
        size -= (size_t)n;
        offset += (uint64_t)n;
    }
    return ZT_OK;
}

zt_result zt__output_open(zt__output *output, zt__memory *memory, const zt_sink *sink, const char *path,
                          const char *folder, bool wait, zt_diag *diag) {
    void *block;
    memset(output, 0, sizeof *output);
    output->memory = memory;
    output->sink = sink;
    output->path = path;
    output->folder = folder;
    output->wait = wait;
    output->fd = -1;
    ZT_TRY(zt__alloc_raw(memory, BUFFER, 1, diag, &block));
    output->buffer = block;
    if (sink)
        return ZT_OK;
    return zt__create_temporary(memory, folder, diag, &output->fd, &output->temporary);
}

static zt_result flush(zt__output *output, zt_diag *diag) {
    size_t size = output->fill;
    output->fill = 0;
    if (size == 0)
        return ZT_OK;
    if (!output->sink)
        return zt__write_all(output->fd, output->buffer, size, diag);
    zt_result r = output->sink->write(output->sink->user, output->buffer, size);
    if (r != ZT_OK)
        zt__fail(diag, r, 0, ZT__NO_OFFSET, "the sink refused %llu bytes", (unsigned long long)size);
    return r;
}

zt_result zt__output_put(zt__output *output, const void *data, size_t size, zt_diag *diag) {
    const uint8_t *bytes = data;
    while (size > 0) {
        size_t n = size < BUFFER - output->fill ? size : BUFFER - output->fill;
        memcpy(output->buffer + output->fill, bytes, n);
        output->fill += n;
        bytes += n;
        size -= n;
        if (output->fill == BUFFER)
            ZT_TRY(flush(output, diag));
    }
    return ZT_OK;
}

static int sync_retrying(int fd) {
    int r;
    do {
        r = fsync(fd);
    } while (r != 0 && errno == EINTR);
    return r;
}

static zt_result sync_folder(const char *folder, zt_diag *diag) {
    int fd;
    do {
        fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    } while (fd < 0 && errno == EINTR);
    if (fd < 0)
        return zt__io_failed(diag, "opening the folder", folder, errno);
    int error = sync_retrying(fd) == 0 ? 0 : errno;
    close(fd);
    /* Some file systems cannot do this for folders, and say so. */
    if (error != 0 && error != EINVAL && error != ENOTSUP)
        return zt__io_failed(diag, "fsync of the folder", folder, error);
    return ZT_OK;
}

zt_result zt__output_finish(zt__output *output, zt_diag *diag) {
    ZT_TRY(flush(output, diag));
    if (output->sink)
        return ZT_OK;
    if (output->wait && sync_retrying(output->fd) != 0)
        return zt__io_failed(diag, "fsync of", output->temporary, errno);
    int fd = output->fd;
    output->fd = -1;
    if (close(fd) != 0 && errno != EINTR)
        return zt__io_failed(diag, "close of", output->temporary, errno);
    if (rename(output->temporary, output->path) != 0)
        return zt__io_failed(diag, "rename to", output->path, errno);
    zt__free_text(output->memory, output->temporary);
    output->temporary = NULL;
    return output->wait ? sync_folder(output->folder, diag) : ZT_OK;
}

void zt__output_close(zt__output *output) {
    if (output->fd >= 0)
        close(output->fd);
    output->fd = -1;
    if (output->temporary)
        (void)unlink(output->temporary);
    zt__free_text(output->memory, output->temporary);
    output->temporary = NULL;
    zt__free(output->memory, output->buffer, BUFFER, 1);
    output->buffer = NULL;
}
