/* SPDX-License-Identifier: Apache-2.0 */
#include "command_private.h"
#include "image_io.h"

int main(int argc, char **argv) {
    img_set_temporary_hooks(cmd_temporary_register, cmd_temporary_forget);
    return cmd_main(argc, argv);
}
