/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures are a module of the command, loaded when the first one is opened: OpenImageIO brings some 250 shared
 * libraries, and loading them would take most of the time of `ztex inspect`. image_load.c gives the functions of
 * image_io.h to the command by calling these.
 */
#ifndef ZTEX_IMAGE_MODULE_H
#define ZTEX_IMAGE_MODULE_H

#include "image_io.h"

typedef struct img_module {
    img_reader *(*open)(const char *path, const img_open_options *options, char *error);
    const img_info *(*get_info)(const img_reader *reader);
    int (*read_rows)(img_reader *reader, uint32_t z, uint32_t y, uint32_t count, uint32_t channels, img_type type,
                     void *dst, size_t pitch, char *error);
    void (*close)(img_reader *reader);
    img_writer *(*create)(const char *path, const img_create_options *options, char *error);
    img_type (*writer_type)(const img_writer *writer);
    int (*write_rows)(img_writer *writer, uint32_t count, img_type type, const void *src, size_t pitch, char *error);
    int (*finish)(img_writer *writer, char *error);
    void (*discard)(img_writer *writer);
    int (*write)(const char *path, const img_create_options *options, img_type type, const void *src, size_t pitch,
                 char *error);
    int (*can_write)(const char *name);
    const char *(*extension)(uint32_t i);
    void (*set_temporary_hooks)(int (*added)(const char *name), void (*gone)(const char *name));
} img_module;

#define IMG_MODULE_FILE "ztex-pictures.so"
#define IMG_MODULE_SYMBOL "ztex_pictures_module"

#endif
