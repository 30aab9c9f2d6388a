/* SPDX-License-Identifier: Apache-2.0 */
#include "file_list.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { MAX_DEPTH = 64 };

static int append(file_list *list, char *path) {
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 64;
        char **paths = realloc(list->paths, capacity * sizeof *paths);
        if (!paths) {
            free(path);
            return cmd_fail(CMD_INTERNAL, "out of memory");
        }
        list->paths = paths;
        list->capacity = capacity;
    }
    list->paths[list->count++] = path;
    return CMD_OK;
}

static char *joined(const char *folder, const char *name) {
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    size_t length = strlen(folder);
    if (path)
        snprintf(path, size, "%s%s%s", folder, length && folder[length - 1] == '/' ? "" : "/", name);
    return path;
}

static int is_texture_name(const char *name) {
    size_t length = strlen(name);
    return length > 5 && strcmp(name + length - 5, ".ztex") == 0;
}

static int read_folder(file_list *list, const char *folder, int depth);

/* Takes the path over. */
static int take_entry(file_list *list, char *path, int depth) {
    struct stat info;
    int status = CMD_OK;
    if (!path)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    if (lstat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        status = read_folder(list, path, depth + 1);
    } else if (is_texture_name(path)) {
        return append(list, path);
    }
    free(path);
    return status;
}

static int read_folder(file_list *list, const char *folder, int depth) {
    struct dirent *entry;
    int status = CMD_OK;
    DIR *dir = depth < MAX_DEPTH ? opendir(folder) : NULL;
    if (!dir)
        return cmd_fail(CMD_IO, "%s: %s", folder, depth < MAX_DEPTH ? strerror(errno) : "folders too deep");
    while (status == CMD_OK && (entry = readdir(dir))) {
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            status = take_entry(list, joined(folder, entry->d_name), depth);
    }
    closedir(dir);
    return status;
}

static int by_bytes(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static int read_operand(const cmd_args *args, file_list *list, const char *operand) {
    struct stat info;
    size_t first = list->count;
    if (strcmp(operand, "-") == 0 || stat(operand, &info) != 0 || !S_ISDIR(info.st_mode)) {
        char *copy = strdup(operand);
        return copy ? append(list, copy) : cmd_fail(CMD_INTERNAL, "out of memory");
    }
    int status = read_folder(list, operand, 0);
    if (list->count == first && status == CMD_OK)
        cmd_warn(args, "%s: no .ztex files in it", operand);
    else if (list->count > first)
        qsort(list->paths + first, list->count - first, sizeof *list->paths, by_bytes);
    return status;
}

int file_list_read(const cmd_args *args, file_list *list) {
    int status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && i < args->operand_count; i++)
        status = read_operand(args, list, args->operands[i]);
    return status;
}

void file_list_free(file_list *list) {
    for (size_t i = 0; i < list->count; i++)
        free(list->paths[i]);
    free(list->paths);
    *list = (file_list){0};
}
