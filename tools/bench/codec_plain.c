/* SPDX-License-Identifier: Apache-2.0 */
/* Ours with the decoder in plain C, as machines have it for which there is no vector path. libzt itself has no way to
 * ask for that, so this looks inside. */
#include <zt/zt.h>

#include "codec.h"
#include "file_codec.h"
#include "file_open.h"

static zt_result decode_tiles(const zt_file *file, unsigned char *texels, zt_diag *diag) {
    zt__decoder decoder;
    zt__sink sink = {.diag = diag};
    zt_level_info level;
    zt_result result = zt_get_level(file, 0, 0, &level);
    zt__decoder_init(&decoder, zt__memory_of(file));
    decoder.kernel = zt__pred_kernel_c();
    for (uint64_t tile = 0; result == ZT_OK && tile < (uint64_t)level.tiles_x * level.tiles_y; tile++) {
        zt__tile_box box;
        zt__tile_geometry(&file->images[0].record, &level, tile, &box);
        unsigned char *to = texels + box.y * level.row_size + (size_t)box.x * file->images[0].record.block_bytes;
        result = zt__read_tile_into(file, &sink, &decoder, 0, 0, tile, to, (size_t)level.row_size);
    }
    zt__decoder_free(&decoder);
    return result;
}

int codec_zt_plain_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in,
                          void *texels) {
    zt_diag diag = {0};
    zt_file *file = NULL;
    zt_result result = zt_open_memory(in->data, in->size, NULL, &diag, &file);
    (void)self;
    (void)picture;
    if (result == ZT_OK)
        result = decode_tiles(file, texels, &diag);
    zt_close(file);
    if (result != ZT_OK)
        fprintf(stderr, "ztex: %s\n", diag.text);
    return result == ZT_OK;
}
