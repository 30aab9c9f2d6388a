/* SPDX-License-Identifier: Apache-2.0 */
#include "file_io.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static zt_result read_data(void *user, uint64_t offset, void *dst, size_t size) {
    const file_io *file = user;
    if (offset > file->io.size || size > file->io.size - offset)
        return ZT_IO;
    memcpy(dst, (const char *)file->data + offset, size);
    return ZT_OK;
}

static zt_result read_file(void *user, uint64_t offset, void *dst, size_t size) {
    const file_io *file = user;
    char *out = dst;
    while (size > 0) {
        ssize_t count = pread(file->fd, out, size, (off_t)offset);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return ZT_IO;
        out += count;
        offset += (uint64_t)count;
        size -= (size_t)count;
    }
    return ZT_OK;
}

int file_io_open(const cmd_args *args, const char *path, file_io *out) {
    struct stat info;
    size_t size;
    *out = (file_io){.fd = -1};
    out->io.user = out;
    if (strcmp(path, "-") == 0) {
        int status = cmd_read_all(args, path, 0, &out->data, &size);
        out->io.read_at = read_data;
        out->io.size = status == CMD_OK ? size : 0;
        return status;
    }
    /* O_NONBLOCK: opening a FIFO must not wait for a writer; it is refused below. */
    out->fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (out->fd < 0 || fstat(out->fd, &info) != 0) {
        int status = cmd_fail(CMD_IO, "%s: %s", path, strerror(errno));
        file_io_close(out);
        return status;
    }
    if (!S_ISREG(info.st_mode)) {
        file_io_close(out);
        return cmd_fail(CMD_IO, "%s: not a regular file", path);
    }
    out->io.read_at = read_file;
    out->io.size = (uint64_t)info.st_size;
    return CMD_OK;
}

void file_io_close(file_io *file) {
    if (file->fd >= 0)
        close(file->fd);
    free(file->data);
    *file = (file_io){.fd = -1};
}
