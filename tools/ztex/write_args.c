/* SPDX-License-Identifier: Apache-2.0 */
#include "write_args.h"

int write_read_tile_edge(const cmd_args *args, int *edge) {
    uint64_t value = cmd_integer(args, "tile-edge");
    if ((value & (value - 1)) != 0)
        return cmd_usage(args, "--tile-edge: %u is not a power of two", (unsigned)value);
    *edge = cmd_given(args, "tile-edge") ? (int)value : 0;
    return CMD_OK;
}

zt_writer_options write_options(const cmd_args *args, cmd_progress *progress) {
    return (zt_writer_options){.size = sizeof(zt_writer_options),
                               .effort = (int)cmd_integer(args, "effort"),
                               .raw_only = cmd_given(args, "raw") > 0,
                               .flags = cmd_given(args, "no-fsync") ? ZT_WRITE_NO_FSYNC : 0,
                               .user = progress,
                               .progress = cmd_progress_step};
}
