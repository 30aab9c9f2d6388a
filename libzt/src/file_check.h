/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rules of the container, each stated once and used by the loader, the validator and the writer. offset is the
 * place of the structure in the file, or ZT__NO_OFFSET in a writer.
 */
#ifndef ZT_FILE_CHECK_H
#define ZT_FILE_CHECK_H

#include "base_diag.h"
#include "file_geometry.h"
#include "file_layout.h"

/* Rules 2001 to 2005 and 2008; the limits on chunks. */
zt_result zt__check_preamble(zt__sink *sink, const zt_limits *limits, const zt__preamble *p);

/* Rules 3001 to 3008 and 3012 for one entry, and the limits that apply; expected_offset as R3001 computes it. */
zt_result zt__check_entry(zt__sink *sink, const zt__entry *e, uint32_t index, uint64_t expected_offset);

/* Rules 3009 to 3011 over the whole directory. */
zt_result zt__check_directory(zt__sink *sink, const zt__entry *entries, uint32_t count);

/* Rules 6002 to 6009 and the limits. */
zt_result zt__check_image(zt__sink *sink, const zt_limits *limits, const zt__image_record *r, uint64_t offset);

/* Rules 6103 to 6105, 6107 for one texture. name is not NUL-terminated. */
zt_result zt__check_texture(zt__sink *sink, const zt__texture_entry *t, const char *name, uint64_t offset);

/* Rules 7002, 7004, 7005. */
zt_result zt__check_metadata_key(zt__sink *sink, const char *key, size_t size, uint64_t offset);
zt_result zt__check_metadata_value(zt__sink *sink, const char *value, size_t size, uint64_t offset);

/* Rules 5201, 5202, 5301 and 5401; decoded_size as the geometry gives it; form: NULL for mip tails. An unknown codec is
 * not an error here: decoding refuses it. */
zt_result zt__check_tile(zt__sink *sink, const zt__tile_record *t, uint32_t decoded_size, const zt__tile_form *form,
                         uint64_t offset);

/* Valid UTF-8 (no overlong forms, no surrogates, at most U+10FFFF); control: whether U+0001 to U+001F and U+007F may
 * occur. U+0000 never may. */
bool zt__utf8_ok(const char *text, size_t size, bool control);

#endif
