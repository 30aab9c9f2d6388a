/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas (spec/umbrella.md): the payload, its checks, coding. */
#ifndef ZT_UMBRELLA_PAYLOAD_H
#define ZT_UMBRELLA_PAYLOAD_H

#include "file_open.h"

/* The fields of the chunk's header, in its order. */
typedef struct zt__umbrella_header {
    uint32_t grid_x, grid_y, level_count;
    uint32_t base_count, umbrella_count, base_vertex_count, morph_vertex_count, variant_colour_count;
    uint32_t explicit_vertex_count, entry_count, longest_list;
    uint8_t colour_mode, background_kind;
    uint8_t reserved0[2];
    uint32_t background_source;
    float background[4], mean[4];
    float prism_height, taper_start, taper_end;
    uint32_t layer_count;
    uint32_t reserved1;
} zt__umbrella_header;

enum { ZT__UMBRELLA_HEADER_SIZE = 104 };

/* The arrays, all in one block, are those of zt_umbrella_info: view points to them. */
typedef struct zt__umbrellas {
    zt__umbrella_header header;
    bool repeat_x, repeat_y; /* as the texture says: lists may shift their umbrellas */
    uint64_t block_size;     /* bytes of the one block that all of this is in */
    zt_umbrella_info view;
    zt_umbrella_level *levels;
    zt_umbrella_base *bases;
    zt_umbrella_texel *base_vertices, *morph_vertices;
    zt_umbrella_colour *variant_colours, *explicit_colours;
    zt_umbrella *umbrellas;
    zt_umbrella_offset *explicit_vertices;
    uint32_t *list_starts, *entries;
} zt__umbrellas;

/* Forms 1 and 2 have vertices and colours of their own. */
static inline bool zt__has_vertices(const zt_umbrella *umbrella) {
    return umbrella->form == ZT_UMBRELLA_EXPLICIT || umbrella->form == ZT_UMBRELLA_COLOURED;
}

/* Of all levels; below 2^27 for any grid that rule 8301 lets pass. */
uint32_t zt__count_cells(const zt__umbrella_header *header);

/* Rules 8301 to 8303, those behind which nothing may be allocated. */
zt_result zt__check_umbrella_header(zt__sink *sink, const zt__umbrella_header *header, const zt__payload_scope *scope,
                                    uint64_t offset);

/* Allocates umbrellas with their arrays, which are left to be filled; what the header gives of levels is there. The
 * header has been checked. Bases, umbrellas and colours are zeros. */
zt_result zt__umbrellas_new(zt__memory *memory, const zt__umbrella_header *header, const zt__payload_scope *scope,
                            zt_diag *diag, zt__umbrellas **out);

/* Rules 8304, 8309 and 8311, and what follows from the order: first_vertex and its like of levels, bases and umbrellas,
 * and view.explicit_colour_count. first_morph comes as 0 or ZT_NONE. Behind it the explicit arrays may be filled. */
zt_result zt__link_umbrellas(zt__sink *sink, zt__umbrellas *umbrellas, const zt__payload_scope *scope, uint64_t offset);

/* Rule 8304 for the lists, whose sizes are at list_starts + 1: makes them list_starts. */
zt_result zt__link_lists(zt__sink *sink, zt__umbrellas *umbrellas, const zt__payload_scope *scope, uint64_t offset);

/* The rest of rules 8305 to 8315. Used, as all of these, by loader, validator and writer. */
zt_result zt__check_umbrellas(zt__sink *sink, const zt__umbrellas *umbrellas, const zt__payload_scope *scope,
                              uint64_t offset);

/* Decodes a UMBR chunk; of the limits listed_umbrellas counts here. *out is one block, freed with zt__free(memory, u,
 * 1, u->block_size). */
zt_result zt__decode_umbrellas(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const zt_limits *limits,
                               const uint8_t *data, size_t size, const zt__payload_scope *scope, uint64_t offset,
                               zt__umbrellas **out);

/* Codes the UMBR chunk; *out has *out_capacity bytes allocated, *out_size used. */
zt_result zt__encode_umbrellas(zt__encoder *encoder, const zt__umbrellas *umbrellas, zt_diag *diag, uint8_t **out,
                               uint64_t *out_capacity, size_t *out_size);

#endif
