/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of image_io.h, out of the module that is loaded when the first is called. */
#include <pthread.h>
#include <stdio.h>

#include "image_module.h"
#include "module.h"

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const img_module *module;
static char trouble[MODULE_ERROR];
static int (*hook_added)(const char *name);
static void (*hook_gone)(const char *name);

static void load(void) {
    module = module_load(IMG_MODULE_FILE, IMG_MODULE_SYMBOL, trouble);
    if (module)
        module->set_temporary_hooks(hook_added, hook_gone);
}

/* NULL with the reason in error, which may be NULL. */
static const img_module *module_of(char *error) {
    pthread_once(&once, load);
    if (!module && error)
        snprintf(error, IMG_ERROR, "%s", trouble);
    return module;
}

void img_set_temporary_hooks(int (*added)(const char *name), void (*gone)(const char *name)) {
    hook_added = added;
    hook_gone = gone;
}

img_reader *img_open(const char *path, const img_open_options *options, char *error) {
    return module_of(error) ? module->open(path, options, error) : NULL;
}

const img_info *img_get_info(const img_reader *reader) {
    return module->get_info(reader); /* whoever has a reader has the module */
}

int img_read_rows(img_reader *reader, uint32_t z, uint32_t y, uint32_t count, uint32_t channels, img_type type,
                  void *dst, size_t pitch, char *error) {
    return module->read_rows(reader, z, y, count, channels, type, dst, pitch, error);
}

void img_close(img_reader *reader) {
    if (reader)
        module->close(reader);
}

img_writer *img_create(const char *path, const img_create_options *options, char *error) {
    return module_of(error) ? module->create(path, options, error) : NULL;
}

img_type img_writer_type(const img_writer *writer) {
    return module->writer_type(writer);
}

int img_write_rows(img_writer *writer, uint32_t count, img_type type, const void *src, size_t pitch, char *error) {
    return module->write_rows(writer, count, type, src, pitch, error);
}

int img_finish(img_writer *writer, char *error) {
    return module->finish(writer, error);
}

void img_discard(img_writer *writer) {
    if (writer)
        module->discard(writer);
}

int img_write(const char *path, const img_create_options *options, img_type type, const void *src, size_t pitch,
              char *error) {
    return module_of(error) ? module->write(path, options, type, src, pitch, error) : -1;
}

int img_can_write(const char *name) {
    return module_of(NULL) ? module->can_write(name) : 0;
}

const char *img_extension(uint32_t i) {
    return module_of(NULL) ? module->extension(i) : NULL;
}
