/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A program that rewrites a file keeps what it does not know: metadata, unknown chunks that are safe to copy, tiles of
 * codecs and formats that it cannot decode. Who reads version 1.0 must not destroy what version 1.1 wrote.
 */
#include <stdbool.h>

#include "test.h"
#include "write_sink.h"
#include "zt/zt_check.h"

enum { UNKNOWN_FORMAT = 1000054000 };

static const char long_text[] = "one two three one two three one two three one two three one two three one two three";

static void write_first(memory_sink *s, bool odd_codec) {
    zt_sink sink = memory_sink_of(s);
    zt_writer *w;
    uint32_t a, b;
    uint8_t rows[100 * 70 * 4];
    for (size_t i = 0; i < sizeof rows; i++)
        rows[i] = (uint8_t)(i / 5);
    zt_image_desc plain = {.format = 43, .width = 100, .height = 70, .tile_edge = 16, .alpha_mode = ZT_ALPHA_STRAIGHT};
    zt_image_desc odd = {.format = UNKNOWN_FORMAT,
                         .width = 64,
                         .height = 64,
                         .levels = 1,
                         .tile_edge = 16,
                         .given_levels = 1,
                         .layers = 80,
                         .block_width = 4,
                         .block_height = 4,
                         .block_bytes = 16};
    CHECK(zt_writer_open_sink(&sink, NULL, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, &plain, NULL, &a) == ZT_OK);
    CHECK(zt_writer_add_image(w, &odd, NULL, &b) == ZT_OK);
    CHECK(zt_writer_put_rows(w, a, rows, 70, 0, NULL) == ZT_OK);
    for (uint64_t tile = 80; tile-- > 0;) {
        if (odd_codec)
            CHECK(zt_writer_put_stored_tile(w, b, 0, tile, 99, tile, rows + tile, 100 + tile, NULL) == ZT_OK);
        else
            CHECK(zt_writer_put_level_rows(w, b, 0, rows, 16, 0, NULL) == ZT_OK);
    }
    CHECK(zt_writer_put_stored_tile(w, b, 0, 3, 99, 3, rows, 100, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_put_level_rows(w, b, 0, rows, 1, 0, NULL) == ZT_BAD_ARGUMENT);
    zt_texture_desc t = {.name = "a", .image = a}, u = {.name = "b", .image = b};
    CHECK(zt_writer_add_texture(w, &t, NULL, NULL) == ZT_OK);
    CHECK(zt_writer_add_texture(w, &u, NULL, NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "zt.title", "gone", NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "b.key", "\xC3\xA4", NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "a.key", "", NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "zt.title", "kept", NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "a.gone", "x", NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "a.gone", NULL, NULL) == ZT_OK);
    CHECK(zt_writer_add_chunk(w, "XZZZ", 7, 2, "z", 1, NULL) == ZT_OK);
    CHECK(zt_writer_add_chunk(w, "XAAA", 3, 2, long_text, sizeof long_text, NULL) == ZT_OK);
    CHECK(zt_writer_add_chunk(w, "XBBB", 1, 0, "unsafe", 6, NULL) == ZT_OK);
    CHECK(zt_writer_add_chunk(w, "XAAA", 3, 2, "z", 1, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_finish(w, NULL) == ZT_OK);
    zt_writer_close(w);
}

static void copy_unit(zt_writer *w, const zt_file *file, uint32_t image, uint32_t level) {
    zt_level_info info;
    CHECK(zt_get_level(file, image, level, &info) == ZT_OK);
    for (uint64_t tile = 0; tile < info.tile_count; tile++) {
        zt_tile_info t;
        CHECK(zt_get_tile(file, image, level, tile, &t, NULL) == ZT_OK);
        uint8_t *bytes = malloc(t.stored_size);
        CHECK(zt_read_tile(file, image, level, tile, bytes, t.stored_size, NULL) == ZT_OK);
        CHECK(zt_writer_put_stored_tile(w, image, level, tile, t.codec, t.hash, bytes, t.stored_size, NULL) == ZT_OK);
        free(bytes);
    }
}

/* As `ztex` verbs do it: everything by the public interface, tiles as they are. */
static void rewrite(const memory_sink *from, memory_sink *to) {
    zt_sink sink = memory_sink_of(to);
    zt_writer *w;
    zt_file *file;
    zt_diag diag = {0};
    uint32_t dropped = 0;
    CHECK(zt_open_memory(from->data, from->size, NULL, &diag, &file) == ZT_OK);
    CHECK(zt_writer_open_sink(&sink, NULL, NULL, &w) == ZT_OK);
    for (uint32_t i = 0; i < 2; i++) {
        zt_image_info info;
        uint32_t image;
        CHECK(zt_get_image(file, i, &info) == ZT_OK);
        zt_image_desc desc;
        zt_describe_image(&info, &desc);
        CHECK(zt_writer_add_image(w, &desc, &diag, &image) == ZT_OK);
        for (uint32_t level = 0; level <= info.tail_level && level < info.levels; level++)
            copy_unit(w, file, i, level);
        zt_texture_info t;
        CHECK(zt_get_texture(file, i, &t) == ZT_OK);
        zt_texture_desc texture = {.name = t.name, .image = i};
        CHECK(zt_writer_add_texture(w, &texture, NULL, NULL) == ZT_OK);
    }
    CHECK(zt_writer_copy_rest(w, file, &diag, &dropped) == ZT_OK && dropped == 1);
    CHECK(zt_writer_finish(w, &diag) == ZT_OK);
    zt_writer_close(w);
    zt_close(file);
}

static void check_rest(const memory_sink *s) {
    zt_file *file;
    zt_file_info info;
    zt_chunk_info chunk;
    uint32_t pairs, found = 0;
    char text[sizeof long_text];
    CHECK(zt_open_memory(s->data, s->size, NULL, NULL, &file) == ZT_OK);
    CHECK(zt_load_metadata(file, &pairs, NULL) == ZT_OK && pairs == 3);
    CHECK(strcmp(zt_find_metadata(file, "zt.title"), "kept") == 0);
    CHECK(strcmp(zt_find_metadata(file, "b.key"), "\xC3\xA4") == 0);
    CHECK(strcmp(zt_find_metadata(file, "a.key"), "") == 0);
    zt_get_file(file, &info);
    for (uint32_t i = 0; i < info.chunk_count; i++) {
        CHECK(zt_get_chunk(file, i, &chunk) == ZT_OK);
        CHECK(strcmp(chunk.type, "XBBB") != 0);
        found += strcmp(chunk.type, "XZZZ") == 0 && chunk.version == 7;
        if (strcmp(chunk.type, "XAAA") != 0)
            continue;
        found++;
        CHECK(chunk.version == 3 && chunk.flags == 2 && chunk.decoded_size == sizeof text);
        CHECK(zt_read_chunk(file, i, text, sizeof text, NULL) == ZT_OK && strcmp(text, long_text) == 0);
    }
    CHECK(found == 2);
    zt_close(file);
}

int main(void) {
    for (int odd = 0; odd < 2; odd++) {
        memory_sink first, second;
        zt_check_summary summary;
        write_first(&first, odd != 0);
        rewrite(&first, &second);
        check_rest(&second);
        /* Texels are the same to the byte: TEXL comes last and begins with its head. */
        zt_file *a, *b;
        zt_level_info la, lb;
        CHECK(zt_open_memory(first.data, first.size, NULL, NULL, &a) == ZT_OK);
        CHECK(zt_open_memory(second.data, second.size, NULL, NULL, &b) == ZT_OK);
        for (uint32_t image = 0; image < 2; image++) {
            CHECK(zt_get_level(a, image, 0, &la) == ZT_OK && zt_get_level(b, image, 0, &lb) == ZT_OK);
            CHECK(la.unit_size == lb.unit_size);
            CHECK(memcmp(first.data + la.unit_offset, second.data + lb.unit_offset, la.unit_size) == 0);
        }
        zt_close(a);
        zt_close(b);
        CHECK(zt_check_memory(second.data, second.size, NULL, NULL, &summary) == ZT_OK);
        CHECK(odd || summary.errors == 0);
        free(first.data);
        free(second.data);
    }
    return test_end();
}
