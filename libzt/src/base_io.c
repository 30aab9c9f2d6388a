/* SPDX-License-Identifier: Apache-2.0 */
#include "base_io.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base_bytes.h"
#include "base_diag.h"

static zt_result memory_read(void *user, uint64_t offset, void *dst, size_t size) {
    const zt__memory_io *memory = user;
    if (!zt__range_ok(offset, size, memory->size))
        return ZT_IO;
    memcpy(dst, memory->data + offset, size);
    return ZT_OK;
}

zt_io zt__io_of_memory(zt__memory_io *memory) {
    zt_io io = {memory, memory_read, memory->size};
    return io;
}

const uint8_t *zt__bytes_in_memory(const zt_io *io, uint64_t offset, size_t size) {
    if (io->read_at != memory_read)
        return NULL;
    const zt__memory_io *memory = io->user;
    return zt__range_ok(offset, size, memory->size) ? memory->data + offset : NULL;
}

static zt_result path_read(void *user, uint64_t offset, void *dst, size_t size) {
    const zt__path_io *path_io = user;
    uint8_t *out = dst;
    while (size > 0) {
        ssize_t n = pread(path_io->fd, out, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            if (n == 0)
                errno = ENODATA; /* the file shrank while it was open */
            return ZT_IO;
        }
        out += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return ZT_OK;
}

zt_result zt__path_io_open(zt__path_io *path_io, const char *path, zt_diag *diag, zt_io *out) {
    struct stat info;
    /* O_NONBLOCK: opening a FIFO must not wait for a writer; it is refused below. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (fd < 0)
        return zt__fail(diag, ZT_IO, 0, ZT__NO_OFFSET, "cannot open the file: %s", strerror(errno));
    if (fstat(fd, &info) != 0) {
        zt_result result = zt__fail(diag, ZT_IO, 0, ZT__NO_OFFSET, "cannot read the file's size: %s", strerror(errno));
        close(fd);
        return result;
    }
    if (!S_ISREG(info.st_mode)) {
        close(fd);
        return zt__fail(diag, ZT_IO, 0, ZT__NO_OFFSET, "not a regular file");
    }
    path_io->fd = fd;
    out->user = path_io;
    out->read_at = path_read;
    out->size = (uint64_t)info.st_size;
    return ZT_OK;
}

void zt__path_io_close(zt__path_io *path_io) {
    if (path_io->fd >= 0)
        close(path_io->fd);
    path_io->fd = -1;
}

zt_result zt__read(const zt_io *io, uint64_t offset, void *dst, size_t size, zt_diag *diag) {
    if (!zt__range_ok(offset, size, io->size))
        return zt__fail(diag, ZT_TRUNCATED, 2006, io->size,
                        "the file ends at byte %llu, %zu bytes from %llu are wanted", (unsigned long long)io->size,
                        size, (unsigned long long)offset);
    if (size == 0)
        return ZT_OK;
    errno = 0;
    zt_result result = io->read_at(io->user, offset, dst, size);
    if (result == ZT_OK)
        return ZT_OK;
    if (result == ZT_AGAIN) {
        bool first = diag && diag->result == ZT_OK;
        zt__fail(diag, ZT_AGAIN, 0, offset, "%zu bytes from %llu are not here yet", size, (unsigned long long)offset);
        if (first)
            diag->size = size;
        return ZT_AGAIN;
    }
    return zt__fail(diag, ZT_IO, 0, offset, "reading %zu bytes at %llu failed%s%s", size, (unsigned long long)offset,
                    errno ? ": " : "", errno ? strerror(errno) : "");
}
