/* SPDX-License-Identifier: Apache-2.0 */
/* The geometry and the filters of one silmap cell (spec/silmap.md sections 3 to 5 and 7) are public, but for how a cell is found. */
#ifndef ZT_SILMAP_FILTER_H
#define ZT_SILMAP_FILTER_H

#include <stdbool.h>
#include <stdint.h>

#include "zt/zt.h"

/* Cell (x, y) of a layer with its neighbours. */
zt_silmap_cell zt__silmap_cell_at(const uint8_t *cells, uint32_t cells_x, uint32_t cells_y, bool repeat_x,
                                  bool repeat_y, uint32_t x, uint32_t y);

#endif
