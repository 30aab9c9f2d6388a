/* SPDX-License-Identifier: Apache-2.0 */
/* JSON that every reader understands alike: exact integers, valid UTF-8, keys in a fixed order. */
#include "command_private.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

json_t *cmd_json_u64(uint64_t value) {
    char text[24];
    /* Readers with binary64 numbers are exact up to here. */
    if (value <= UINT64_C(1) << 53)
        return json_integer((json_int_t)value);
    snprintf(text, sizeof text, "%" PRIu64, value);
    return json_string(text);
}

json_t *cmd_json_hash(uint64_t value) {
    char text[24];
    snprintf(text, sizeof text, "%016" PRIx64, value);
    return json_string(text);
}

json_t *cmd_json_offset(uint64_t value) {
    return value == UINT64_MAX ? json_null() : cmd_json_u64(value);
}

json_t *cmd_json_text(const char *text) {
    if (!text)
        return json_null();
    json_t *valid = json_string(text);
    if (valid)
        return valid;
    char *mended = malloc(3 * strlen(text) + 1);
    size_t at = 0;
    if (!mended)
        return NULL;
    while (*text) {
        uint32_t code;
        size_t used = cmd_utf8(text, &code);
        memcpy(mended + at, used ? text : "\xEF\xBF\xBD", used ? used : 3);
        at += used ? used : 3;
        text += used ? used : 1;
    }
    valid = json_stringn(mended, at);
    free(mended);
    return valid;
}

int cmd_json_print(FILE *stream, const json_t *value) {
    /* A NULL comes from a json_ call that had no memory. */
    if (!value)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    if (json_dumpf(value, stream, JSON_INDENT(2) | JSON_ENCODE_ANY | JSON_REAL_PRECISION(17)) != 0)
        return cmd_fail(CMD_IO, "standard output: writing failed");
    fputc('\n', stream);
    return ferror(stream) ? cmd_fail(CMD_IO, "standard output: writing failed") : CMD_OK;
}

int cmd_json_write(const char *path, const json_t *value) {
    cmd_output output = {0};
    int status = cmd_output_open(&output, path, 0);
    if (status == CMD_OK)
        status = cmd_json_print(output.stream, value);
    return cmd_output_end(&output, status);
}
