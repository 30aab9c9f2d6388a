/* SPDX-License-Identifier: Apache-2.0 */
/* Files in, and files out that appear whole or not at all. */
#include "command_private.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int is_standard(const char *path) {
    return strcmp(path, "-") == 0;
}

const char *cmd_input_name(const char *path) {
    return is_standard(path) ? "standard input" : path;
}

/* ---- reading -------------------------------------------------------------------------------------- */

typedef struct buffer {
    char *data;
    size_t size, capacity;
} buffer;

static int grow(buffer *b, uint64_t limit) {
    size_t next = b->capacity ? 2 * b->capacity : 65536;
    if (next > limit + 2)
        next = (size_t)limit + 2; /* one byte to notice that there is more, one for the NUL */
    char *data = realloc(b->data, next);
    if (!data)
        return -1;
    b->data = data;
    b->capacity = next;
    return 0;
}

static int read_stream(int fd, const char *name, uint64_t limit, buffer *b) {
    char bytes[16];
    for (;;) {
        if (b->size + 1 >= b->capacity && grow(b, limit))
            return cmd_fail(CMD_INTERNAL, "%s: out of memory", name);
        ssize_t count = read(fd, b->data + b->size, b->capacity - 1 - b->size);
        if (cmd_interrupted())
            return cmd_cancelled();
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return cmd_fail(CMD_IO, "%s: %s", name, strerror(errno));
        if (count == 0)
            break;
        b->size += (size_t)count;
        if (b->size > limit) {
            cmd_error("%s: more than %s", name, cmd_bytes_text(bytes, sizeof bytes, limit));
            cmd_hint("Raise the limit with --memory, or give a file instead of a pipe.");
            return CMD_LIMIT;
        }
    }
    b->data[b->size] = '\0';
    return CMD_OK;
}

int cmd_read_all(const cmd_args *args, const char *path, uint64_t limit, void **data, size_t *size) {
    const char *name = cmd_input_name(path);
    buffer b = {0};
    uint64_t most = limit ? limit : cmd_limits(args)->memory;
    *data = NULL;
    *size = 0;
    if (most == 0)
        most = UINT64_C(1) << 30;
    if (most > SIZE_MAX / 4)
        most = SIZE_MAX / 4;
    int fd = is_standard(path) ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return cmd_fail(CMD_IO, "%s: %s", name, strerror(errno));
    int status = read_stream(fd, name, most, &b);
    if (fd != STDIN_FILENO)
        close(fd);
    if (status != CMD_OK) {
        free(b.data);
        return status;
    }
    *data = b.data;
    *size = b.size;
    return CMD_OK;
}

int cmd_open(const cmd_args *args, const char *path, uint32_t flags, cmd_input *input) {
    zt_diag diag = {.offset = UINT64_MAX};
    zt_open_options options = {.size = sizeof options, .limits = cmd_limits(args), .flags = flags};
    zt_result result;
    *input = (cmd_input){.name = cmd_input_name(path)};
    if (is_standard(path)) {
        int status = cmd_read_all(args, path, 0, &input->data, &input->size);
        if (status != CMD_OK) {
            *input = (cmd_input){0};
            return status;
        }
        result = zt_open_memory(input->data, input->size, &options, &diag, &input->file);
    } else {
        result = zt_open_path(path, &options, &diag, &input->file);
    }
    if (result == ZT_OK)
        return CMD_OK;
    int status = cmd_fail_result(input->name, result, &diag);
    cmd_close(input);
    return status;
}

void cmd_close(cmd_input *input) {
    zt_close(input->file);
    free(input->data);
    *input = (cmd_input){0};
}

/* ---- writing ---------------------------------------------------------------------------------------- */

int cmd_ends_with(const char *text, const char *end) {
    size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

int cmd_check_output(const char *output, const char *const *inputs, size_t input_count) {
    struct stat out, in;
    if (is_standard(output) || stat(output, &out) != 0)
        return CMD_OK;
    if (S_ISDIR(out.st_mode))
        return cmd_fail(CMD_USAGE, "%s is a folder: give the name of a file in it", output);
    for (size_t i = 0; i < input_count; i++) {
        if (is_standard(inputs[i]) || stat(inputs[i], &in) != 0)
            continue;
        if (S_ISREG(out.st_mode) && in.st_dev == out.st_dev && in.st_ino == out.st_ino) {
            cmd_error("%s is an input as well: it would be overwritten", output);
            cmd_hint("Give another name with --output.");
            return CMD_USAGE;
        }
    }
    return CMD_OK;
}

/* Devices and pipes cannot be replaced by a rename; they are written to. */
static int is_special(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

static mode_t mode_for(const char *path) {
    struct stat info;
    if (stat(path, &info) == 0 && S_ISREG(info.st_mode))
        return info.st_mode & 0777;
    mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

char *cmd_temporary(const char *path) {
    static const char suffix[] = ".ztex-XXXXXX";
    const char *slash = strrchr(path, '/');
    size_t folder = slash ? (size_t)(slash - path) + 1 : 0;
    char *name = malloc(folder + sizeof suffix);
    if (!name) {
        cmd_error("%s: out of memory", path);
        return NULL;
    }
    memcpy(name, path, folder);
    memcpy(name + folder, suffix, sizeof suffix);
    int fd = mkstemp(name);
    if (fd < 0 || fchmod(fd, mode_for(path)) != 0) {
        cmd_error("%s: cannot write to its folder: %s", path, strerror(errno));
        if (fd >= 0) {
            close(fd);
            unlink(name);
        }
        free(name);
        return NULL;
    }
    close(fd);
    cmd_temporary_register(name);
    return name;
}

int cmd_temporary_keep(char *temporary, const char *path) {
    int status = CMD_OK;
    int fd = open(temporary, O_RDONLY | O_CLOEXEC);
    int written = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0)
        close(fd);
    if (!written || rename(temporary, path) != 0) {
        status = cmd_fail(CMD_IO, "%s: %s", path, strerror(errno));
        unlink(temporary);
    }
    cmd_temporary_forget(temporary);
    free(temporary);
    return status;
}

void cmd_temporary_drop(char *temporary) {
    if (!temporary)
        return;
    unlink(temporary);
    cmd_temporary_forget(temporary);
    free(temporary);
}

static int refuse_terminal(void) {
    if (!isatty(STDOUT_FILENO))
        return CMD_OK;
    cmd_error("standard output is a terminal, which cannot show this data");
    cmd_hint("Name a file with --output, or send it into a pipe or file: > FILE.");
    return CMD_USAGE;
}

int cmd_output_open(cmd_output *output, const char *path, int binary) {
    *output = (cmd_output){.path = path};
    if (is_standard(path)) {
        int status = binary ? refuse_terminal() : CMD_OK;
        output->stream = status == CMD_OK ? stdout : NULL;
        return status;
    }
    if (!is_special(path)) {
        output->temporary = cmd_temporary(path);
        if (!output->temporary)
            return CMD_IO;
    }
    output->stream = fopen(output->temporary ? output->temporary : path, "wb");
    if (output->stream)
        return CMD_OK;
    int status = cmd_fail(CMD_IO, "%s: %s", path, strerror(errno));
    cmd_output_drop(output);
    return status;
}

int cmd_output_commit(cmd_output *output) {
    FILE *stream = output->stream;
    int bad = ferror(stream) != 0 || fflush(stream) != 0;
    if (stream != stdout)
        bad |= fclose(stream) != 0;
    output->stream = NULL;
    if (bad) {
        int status = cmd_fail(CMD_IO, "%s: writing failed: %s", output->path, strerror(errno));
        cmd_output_drop(output);
        return status;
    }
    char *temporary = output->temporary;
    output->temporary = NULL;
    return temporary ? cmd_temporary_keep(temporary, output->path) : CMD_OK;
}

void cmd_output_drop(cmd_output *output) {
    if (output->stream && output->stream != stdout)
        fclose(output->stream);
    cmd_temporary_drop(output->temporary);
    *output = (cmd_output){0};
}

int cmd_output_end(cmd_output *output, int status) {
    if (status == CMD_OK)
        return cmd_output_commit(output);
    cmd_output_drop(output);
    return status;
}

/* ---- a writer ------------------------------------------------------------------------------------------ */

static zt_result write_stream(void *user, const void *data, size_t size) {
    if (cmd_interrupted())
        return ZT_CANCELLED;
    return fwrite(data, 1, size, user) == size ? ZT_OK : ZT_IO;
}

static int open_stream(const char *path, FILE **stream) {
    if (is_standard(path)) {
        *stream = stdout;
        return refuse_terminal();
    }
    /* One special file a process: it stays open until exit. */
    *stream = fopen(path, "wb");
    return *stream ? CMD_OK : cmd_fail(CMD_IO, "%s: %s", path, strerror(errno));
}

int cmd_writer_open(cmd_args *args, const char *path, const zt_writer_options *options, zt_writer **out) {
    zt_diag diag = {.offset = UINT64_MAX};
    zt_writer_options filled = options ? *options : (zt_writer_options){0};
    zt_result result;
    *out = NULL;
    filled.size = sizeof filled;
    if (!filled.limits)
        filled.limits = cmd_limits(args);
    if (!filled.parallel)
        filled.parallel = cmd_parallel(args);
    if (!filled.progress) {
        filled.progress = cmd_progress_step;
        filled.user = NULL;
    }
    if (is_standard(path) || is_special(path)) {
        FILE *stream;
        int status = open_stream(path, &stream);
        if (status != CMD_OK)
            return status;
        static zt_sink sink; /* outlives the call, whether it is copied or not */
        sink = (zt_sink){stream, write_stream};
        result = zt_writer_open_sink(&sink, &filled, &diag, out);
    } else {
        result = zt_writer_open_path(path, &filled, &diag, out);
    }
    return result == ZT_OK ? CMD_OK : cmd_fail_result(path, result, &diag);
}

int cmd_writer_finish(const char *path, zt_writer *writer) {
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_writer_finish(writer, &diag);
    if (result != ZT_OK)
        return cmd_fail_result(is_standard(path) ? "standard output" : path, result, &diag);
    if (is_standard(path) && fflush(stdout) != 0)
        return cmd_fail(CMD_IO, "standard output: %s", strerror(errno));
    return CMD_OK;
}
