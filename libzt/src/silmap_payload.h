/* SPDX-License-Identifier: Apache-2.0 */
/* Silmaps (spec/silmap.md): the payload, its checks, coding. */
#ifndef ZT_SILMAP_PAYLOAD_H
#define ZT_SILMAP_PAYLOAD_H

#include "file_open.h"

/* The fields of the chunk's header. */
typedef struct zt__silmap_header {
    uint32_t cells_x, cells_y, cell_layers, layer_count;
    uint8_t filter;
} zt__silmap_header;

typedef struct zt__silmap {
    zt__silmap_header header;
    bool repeat_x, repeat_y; /* as the texture says: its samples and neighbours go round */
    uint64_t cell_count;     /* of all layers */
    uint64_t block_size;     /* bytes of the one block that all of this is in */
    uint32_t *samples;       /* image of each layer */
    uint32_t *minified;      /* likewise, or ZT_NONE */
    uint8_t *cells;          /* [layer][y][x] */
} zt__silmap;

/* Rules 8201 and 8202, those behind which nothing may be allocated. */
zt_result zt__check_silmap_header(zt__sink *sink, const zt__silmap_header *header, const zt__payload_scope *scope,
                                  uint64_t offset);

/* Rules 8203 to 8207. Used, as the former, by loader, validator and writer. */
zt_result zt__check_silmap(zt__sink *sink, const zt__silmap *silmap, const zt__payload_scope *scope, uint64_t offset);

/* Makes cells without a cut arm the default (R8207). */
void zt__tidy_silmap(zt__silmap *silmap);

/* Allocates a silmap with its arrays, which are left to be filled. The header has been checked. */
zt_result zt__silmap_new(zt__memory *memory, const zt__silmap_header *header, const zt__payload_scope *scope,
                         zt_diag *diag, zt__silmap **out);

/* Decodes a SLMP chunk; *out is one block, freed with zt__free(memory, s, 1, s->block_size). */
zt_result zt__decode_silmap(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const uint8_t *data, size_t size,
                            const zt__payload_scope *scope, uint64_t offset, zt__silmap **out);

/* Codes the SLMP chunk; *out has *out_capacity bytes allocated, *out_size used. */
zt_result zt__encode_silmap(zt__encoder *encoder, const zt__silmap *silmap, zt_diag *diag, uint8_t **out,
                            uint64_t *out_capacity, size_t *out_size);

#endif
