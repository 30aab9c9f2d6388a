/* SPDX-License-Identifier: Apache-2.0 */
#include "light_rows.h"

#include <stdlib.h>

enum { BAND = 64 };

int light_rows_open(light_rows *rows, img_reader *reader, uint32_t channels, uint32_t transfer, img_type type) {
    uint32_t count = type == IMG_U8 ? 256 : type == IMG_U16 ? 65536 : 0;
    const img_info *info = img_get_info(reader);
    *rows = (light_rows){.reader = reader, .info = info, .channels = channels, .transfer = transfer, .type = type};
    rows->table = calloc(count + 1, sizeof *rows->table);
    rows->band = malloc((size_t)info->width * BAND * channels * img_type_size(type));
    for (uint32_t i = 0; rows->table && i < count; i++)
        rows->table[i] = zt_transfer_decode(transfer, (float)i / (float)(count - 1));
    return rows->table && rows->band ? 0 : -1;
}

void light_rows_close(light_rows *rows) {
    free(rows->table);
    free(rows->band);
}

int light_rows_each(const light_rows *rows, void (*row)(void *user, uint32_t y, size_t first), void *user,
                    char *error) {
    const img_info *info = rows->info;
    for (uint32_t y = 0; y < info->height; y += BAND) {
        uint32_t count = info->height - y < BAND ? info->height - y : BAND;
        if (img_read_rows(rows->reader, 0, y, count, rows->channels, rows->type, rows->band, 0, error))
            return -1;
        for (uint32_t i = 0; i < count; i++)
            row(user, y + i, (size_t)i * info->width * rows->channels);
    }
    return 0;
}
