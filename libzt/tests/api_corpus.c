/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The library agrees with conformance/, which was written from the specification alone: valid files open, have no
 * findings and decode to the bytes whose SHA-256 the manifest gives; of invalid files the validator names the rule, and
 * opening refuses those whose structure is broken. Two implementations that meet only in the text cannot share a bug.
 */
#include <zt/zt_check.h>

#include "corpus.h"
#include "sha256.h"
#include "test.h"

enum { MOST_RULES = 16 };

static uint32_t levels_compared;

/* ---- valid ---- */

static bool level_hash_is(const zt_file *file, uint32_t image, uint32_t level, const char *expected) {
    zt_image_info im;
    zt_level_info info;
    zt_diag diag;
    sha256 hash;
    char text[65];
    if (zt_get_image(file, image, &im) != ZT_OK || zt_get_level(file, image, level, &info) != ZT_OK)
        return false;
    size_t size = (size_t)info.layer_size;
    uint8_t *texels = malloc(size);
    zt_result result = ZT_OK;
    sha256_begin(&hash);
    for (uint32_t layer = 0; layer < im.layers && result == ZT_OK; layer++) {
        result = zt_decode_level(file, image, level, layer, texels, size, 0, NULL, &diag);
        sha256_more(&hash, texels, size);
    }
    free(texels);
    sha256_end(&hash, text);
    if (result != ZT_OK)
        fprintf(stderr, "image %u level %u: %s\n", image, level, diag.text);
    return result == ZT_OK && strcmp(text, expected) == 0;
}

static int print_finding(void *user, const zt_finding *finding) {
    fprintf(stderr, "%s: R%u: %s: %s\n", (const char *)user, finding->rule, finding->path, finding->text);
    return 0;
}

static void test_valid(const char *line) {
    char name[256], expected[65];
    zt_diag diag;
    zt_file *file;
    zt_file_info info;
    zt_check_summary summary;
    string_of(line, "file", name, sizeof name);
    blob b = blob_read(VALID_FOLDER, name);
    zt_check_options options = {.user = name, .finding = print_finding};
    CHECK(zt_check_memory(b.data, b.size, &options, &diag, &summary) == ZT_OK);
    CHECK(summary.errors == 0 && summary.warnings == 0 && summary.limits == 0 && summary.complete);
    zt_result result = zt_open_memory(b.data, b.size, NULL, &diag, &file);
    CHECK(result == ZT_OK);
    if (result != ZT_OK) {
        fprintf(stderr, "%s: R%u: %s\n", name, diag.rule, diag.text);
        blob_free(b);
        return;
    }
    zt_get_file(file, &info);
    CHECK(info.texture_count == number_of(line, "textures") && info.image_count == number_of(line, "images"));
    const char *list = value_of(line, "decoded");
    for (const char *at = list ? strstr(list, "{\"image\": ") : NULL; at; at = strstr(at + 1, "{\"image\": ")) {
        string_of(at, "sha256", expected, sizeof expected);
        bool same = level_hash_is(file, number_of(at, "image"), number_of(at, "level"), expected);
        CHECK(same);
        levels_compared++;
        if (!same)
            fprintf(stderr, "%s: image %u level %u differs\n", name, number_of(at, "image"), number_of(at, "level"));
    }
    zt_close(file);
    blob_free(b);
}

/* ---- invalid ---- */

typedef struct expectation {
    const char *name;
    uint32_t rules[MOST_RULES]; /* the first is the one that is broken */
    uint32_t count;
    bool named;
} expectation;

static bool is_expected(const expectation *e, uint32_t rule) {
    for (uint32_t i = 0; i < e->count; i++) {
        if (e->rules[i] == rule)
            return true;
    }
    return false;
}

static int on_finding(void *user, const zt_finding *finding) {
    expectation *e = user;
    e->named |= is_expected(e, finding->rule);
    if (!is_expected(e, finding->rule))
        fprintf(stderr, "%s: also R%u: %s: %s\n", e->name, finding->rule, finding->path, finding->text);
    CHECK(is_expected(e, finding->rule));
    return 0;
}

/* Rules that opening states, whatever part of the file: all but those of hashes, frames, texels and metadata. */
static bool is_structural(uint32_t rule) {
    return rule < 4000 || (rule >= 5100 && rule < 5200) || (rule >= 6000 && rule < 7000) ||
           (rule >= 8000 && rule != 8112);
}

static void test_opening(const expectation *e, blob b) {
    zt_diag diag;
    zt_file *file;
    zt_check_summary summary;
    zt_check_options options = {.flags = ZT_CHECK_STRUCTURE};
    zt_result result = zt_open_memory(b.data, b.size, NULL, &diag, &file);
    CHECK(zt_check_memory(b.data, b.size, &options, NULL, &summary) == ZT_OK);
    CHECK((result == ZT_OK) == (summary.errors == 0));
    CHECK((result != ZT_OK) == (file == NULL));
    if (result == ZT_OK) {
        CHECK(!is_structural(e->rules[0]));
        if (is_structural(e->rules[0]))
            fprintf(stderr, "%s: opens\n", e->name);
    } else {
        CHECK(is_expected(e, diag.rule));
        if (!is_expected(e, diag.rule))
            fprintf(stderr, "%s: opening says R%u: %s\n", e->name, diag.rule, diag.text);
        CHECK(diag.result == result && diag.text[0] && (diag.offset <= b.size || diag.offset == UINT64_MAX));
    }
    zt_close(file);
}

static void read_rules(const char *line, expectation *e) {
    const char *rule = value_of(line, "rule"), *also = value_of(line, "also");
    assert(rule);
    e->rules[e->count++] = (uint32_t)strtoul(rule + 2, NULL, 10);
    for (const char *at = also; at && *at != ']' && e->count < MOST_RULES; at++) {
        if (*at == 'R')
            e->rules[e->count++] = (uint32_t)strtoul(at + 1, NULL, 10);
    }
}

static void test_invalid(const char *line) {
    char name[256], severity[16];
    expectation e = {.name = name};
    zt_diag diag;
    zt_check_summary summary;
    string_of(line, "file", name, sizeof name);
    string_of(line, "severity", severity, sizeof severity);
    read_rules(line, &e);
    blob b = blob_read(INVALID_FOLDER, name);
    zt_check_options options = {.user = &e, .finding = on_finding};
    CHECK(zt_check_memory(b.data, b.size, &options, &diag, &summary) == ZT_OK);
    CHECK(e.named);
    if (!e.named)
        fprintf(stderr, "%s: nothing named\n", name);
    if (strcmp(severity, "warning") == 0)
        CHECK(summary.errors == 0 && summary.warnings > 0);
    else
        CHECK(summary.errors > 0);
    if (strcmp(severity, "error") == 0)
        test_opening(&e, b);
    blob_free(b);
}

int main(void) {
    CHECK(each_line(VALID_FOLDER "manifest.json", test_valid) > 150);
    CHECK(levels_compared > 300);
    CHECK(each_line(INVALID_FOLDER "manifest.json", test_invalid) > 500);
    return test_end();
}
