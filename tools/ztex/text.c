/* SPDX-License-Identifier: Apache-2.0 */
/* Texts for people: safe on a terminal, near misses, sizes. */
#include "command_private.h"

#include <stdlib.h>
#include <string.h>

size_t cmd_utf8(const char *text, uint32_t *code) {
    const unsigned char *b = (const unsigned char *)text;
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    size_t length = b[0] < 0x80 ? 1 : b[0] >= 0xF0 ? 4 : b[0] >= 0xE0 ? 3 : 2;
    if ((b[0] >= 0x80 && b[0] < 0xC2) || b[0] > 0xF4)
        return 0;
    uint32_t value = length == 1 ? b[0] : b[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((b[i] & 0xC0) != 0x80)
            return 0;
        value = value << 6 | (b[i] & 0x3Fu);
    }
    if (value < least[length] || value > 0x10FFFF || (value >= 0xD800 && value <= 0xDFFF))
        return 0;
    *code = value;
    return length;
}

/* Characters that move the cursor, end the line, or turn the reading direction. */
static int is_unsafe(uint32_t code) {
    return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E || code == 0x200F ||
           (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF;
}

/* One character of text as it may be printed; returns the bytes used up. */
static size_t safe_step(const char *text, char out[16]) {
    uint32_t code = 0;
    size_t used = cmd_utf8(text, &code);
    if (used == 0 || (used == 1 && is_unsafe(code))) {
        snprintf(out, 16, "\\x%02x", (unsigned char)text[0]);
        return 1;
    }
    if (is_unsafe(code)) {
        snprintf(out, 16, "\\u{%x}", (unsigned)code);
        return used;
    }
    memcpy(out, text, used);
    out[used] = '\0';
    return used;
}

char *cmd_safe(char *dst, size_t size, const char *text) {
    size_t at = 0, cut = 0; /* cut: where "..." still fits */
    char out[16];
    if (size == 0)
        return dst;
    while (*text) {
        text += safe_step(text, out);
        size_t length = strlen(out);
        if (at + length + 1 > size) {
            at = cut;
            snprintf(dst + at, size - at, "...");
            return dst;
        }
        memcpy(dst + at, out, length);
        at += length;
        if (at + 4 <= size)
            cut = at;
    }
    dst[at] = '\0';
    return dst;
}

void cmd_print_safe(FILE *stream, const char *text) {
    char out[16];
    while (*text) {
        text += safe_step(text, out);
        fputs(out, stream);
    }
}

/* ---- near misses -------------------------------------------------------------------------------- */

#define WORD_MAX 63

static size_t least_of(size_t a, size_t b, size_t c) {
    size_t least = a < b ? a : b;
    return least < c ? least : c;
}

static char folded(char c) {
    if (c >= 'A' && c <= 'Z')
        return (char)(c - 'A' + 'a');
    return c == '_' ? '-' : c;
}

/* Edits (insert, delete, replace, swap of neighbours) from a to b. */
static size_t distance(const char *a, const char *b) {
    size_t rows[3][WORD_MAX + 1];
    size_t *before = rows[0], *above = rows[1], *row = rows[2];
    size_t length = strlen(b);
    if (strlen(a) > WORD_MAX || length > WORD_MAX)
        return WORD_MAX;
    for (size_t j = 0; j <= length; j++)
        above[j] = j;
    for (size_t i = 1; a[i - 1]; i++) {
        row[0] = i;
        for (size_t j = 1; j <= length; j++) {
            size_t same = folded(a[i - 1]) == folded(b[j - 1]);
            row[j] = least_of(above[j] + 1, row[j - 1] + 1, above[j - 1] + !same);
            int swapped = i > 1 && j > 1 && folded(a[i - 1]) == folded(b[j - 2]) &&
                          folded(a[i - 2]) == folded(b[j - 1]);
            if (swapped && before[j - 2] + 1 < row[j])
                row[j] = before[j - 2] + 1;
        }
        size_t *spare = before;
        before = above;
        above = row;
        row = spare;
    }
    return above[length];
}

const char *cmd_nearest(const char *word, const char *const *names, size_t count) {
    size_t best = strlen(word) / 3 + 1;
    const char *nearest = NULL;
    for (size_t i = 0; i < count; i++) {
        size_t edits = distance(word, names[i]);
        if (edits <= best && edits < strlen(names[i]) && (!nearest || edits < best)) {
            best = edits;
            nearest = names[i];
        }
    }
    for (size_t i = 0; !nearest && strlen(word) >= 3 && i < count; i++)
        if (strncmp(word, names[i], strlen(word)) == 0)
            nearest = names[i];
    return nearest;
}

char *cmd_bytes_text(char *dst, size_t size, uint64_t bytes) {
    static const char units[] = "KMGTPE";
    double value = (double)bytes;
    int unit = -1;
    if (bytes < 1024) {
        snprintf(dst, size, "%u B", (unsigned)bytes);
        return dst;
    }
    while (value >= 1024.0 && unit < 5) {
        value /= 1024.0;
        unit++;
    }
    snprintf(dst, size, "%.*f %ciB", value < 10 ? 2 : value < 100 ? 1 : 0, value, units[unit]);
    return dst;
}
