/* SPDX-License-Identifier: Apache-2.0 */
/* A module lies beside the command where both are built, and in the library folder where they are installed. */
#include "module.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { PATH_ROOM = 4096 };

static void *open_module(const char *file, char *error) {
    static const char *const folders[] = {"/", "/" ZTEX_MODULE_FOLDER "/"};
    char program[PATH_ROOM], path[PATH_ROOM + 256];
    ssize_t size = readlink("/proc/self/exe", program, sizeof program - 1);
    program[size > 0 ? size : 0] = '\0';
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = '\0';
    snprintf(error, MODULE_ERROR, "%s is not there, beside the command or in %s of its folder", file,
             ZTEX_MODULE_FOLDER);
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        snprintf(path, sizeof path, "%s%s%s", program, folders[i], file);
        if (access(path, R_OK) != 0)
            continue;
        void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        if (handle)
            return handle;
        snprintf(error, MODULE_ERROR, "%s cannot be loaded: %.160s", file, dlerror());
    }
    return NULL;
}

const void *module_load(const char *file, const char *symbol, char *error) {
    void *handle = open_module(file, error);
    if (!handle)
        return NULL;
    const void *table = dlsym(handle, symbol);
    if (!table)
        snprintf(error, MODULE_ERROR, "%s is of another version", file);
    return table;
}
