/* SPDX-License-Identifier: Apache-2.0 */
/* The one symbol that the module of pictures exports. */
#include "image_module.h"

extern const img_module ztex_pictures_module;

__attribute__((visibility("default"))) const img_module ztex_pictures_module = {
    .open = img_open,
    .get_info = img_get_info,
    .read_rows = img_read_rows,
    .close = img_close,
    .create = img_create,
    .writer_type = img_writer_type,
    .write_rows = img_write_rows,
    .finish = img_finish,
    .discard = img_discard,
    .write = img_write,
    .can_write = img_can_write,
    .extension = img_extension,
    .set_temporary_hooks = img_set_temporary_hooks,
};
