/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Damage never goes unnoticed: every truncation of a file is refused as such, and every single bit that flips, wherever
 * it lies, is found by the validator, because every byte of a file is fixed by a rule or covered by a hash.
 */
#include <zt/zt_check.h>

#include "corpus.h"
#include "test.h"

static void test_truncations(const char *name) {
    enum { MAGIC_SIZE = 10 };
    blob whole = blob_read(VALID_FOLDER, name);
    for (size_t size = 0; size < whole.size; size++) {
        blob cut = blob_prefix(whole, size);
        zt_diag diag;
        zt_file *file;
        zt_check_summary summary;
        zt_result result = zt_open_memory(cut.data, cut.size, NULL, &diag, &file);
        CHECK(file == NULL);
        CHECK(result == ZT_TRUNCATED || (size < MAGIC_SIZE && result == ZT_NOT_ZTEX));
        CHECK(diag.result == result && diag.text[0] && (diag.rule == 2006 || diag.rule == 2001));
        CHECK(zt_check_memory(cut.data, cut.size, NULL, &diag, &summary) == ZT_OK);
        CHECK(summary.errors > 0 && !summary.complete);
        blob_free(cut);
    }
    blob_free(whole);
}

static void test_growth(const char *name) {
    blob whole = blob_read(VALID_FOLDER, name);
    for (size_t more = 1; more <= 33; more++) {
        zt_diag diag;
        zt_file *file;
        blob grown = {calloc(1, whole.size + more), whole.size + more};
        assert(grown.data);
        memcpy(grown.data, whole.data, whole.size);
        CHECK(zt_open_memory(grown.data, grown.size, NULL, &diag, &file) == ZT_CORRUPT && diag.rule == 2007);
        CHECK(file == NULL);
        blob_free(grown);
    }
    blob_free(whole);
}

static void test_flips(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    for (size_t bit = 0; bit < 8 * b.size; bit++) {
        zt_diag diag;
        zt_file *file;
        zt_check_summary summary;
        b.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        CHECK(zt_check_memory(b.data, b.size, NULL, &diag, &summary) == ZT_OK);
        CHECK(summary.errors > 0);
        if (summary.errors == 0)
            fprintf(stderr, "%s: bit %zu may flip\n", name, bit);
        zt_result result = zt_open_memory(b.data, b.size, NULL, &diag, &file);
        CHECK((result == ZT_OK) == (file != NULL));
        CHECK(result == ZT_OK || (diag.result == result && (diag.offset <= b.size || diag.offset == UINT64_MAX)));
        zt_close(file);
        b.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    blob_free(b);
}

int main(void) {
    static const char *const names[] = {"first.ztex",
                                        "meta_zstd.ztex",
                                        "zip_patch.ztex",
                                        "imag_zstd_encoder.ztex",
                                        "array_tiled.ztex",
                                        "zip_in_zip.ztex",
                                        "levels_full_5x3.ztex",
                                        "tile_zstd_encoder.ztex",
                                        "chunk_unknown_several.ztex",
                                        "format_145_bc7_unorm_block.ztex",
                                        "planes_zstd_encoder.ztex"};
    static const char *const flipped[] = {
        "first.ztex",       "meta_zstd.ztex",          "zip_patch.ztex", "array_tiled.ztex", "chunk_unknown_zstd.ztex",
        "planes_bits.ztex", "zstd_two_rle_blocks.ztex"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        test_truncations(names[i]);
        test_growth(names[i]);
    }
    for (size_t i = 0; i < sizeof flipped / sizeof *flipped; i++)
        test_flips(flipped[i]);
    return test_end();
}
