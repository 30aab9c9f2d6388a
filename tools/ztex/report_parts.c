/* SPDX-License-Identifier: Apache-2.0 */
/* Pieces of pages. */
#include "report_parts.h"

#include <stdlib.h>
#include <string.h>

#include "image_io.h"

const char report_head[] =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
    "content=\"width=device-width\">\n"
    "<style>\n"
    "body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 78em; padding: 0 1em; color: #222; }\n"
    "h1 { font-size: 1.5em } h2 { font-size: 1.2em; margin-top: 2em; border-bottom: 1px solid #ccc }\n"
    "table { border-collapse: collapse } th, td { padding: .25em .8em; border-bottom: 1px solid #e4e4e4; text-align: "
    "left }\n"
    "td.n, th.n { text-align: right; font-variant-numeric: tabular-nums }\n"
    ".tree, .tree ul { list-style: none; padding-left: 1.6em; border-left: 2px solid #ddd } .tree { border: 0; "
    "padding: 0 }\n"
    ".tree li { margin: .6em 0 } .tree img { width: 110px; vertical-align: middle; margin-right: .8em }\n"
    ".strip { display: flex; flex-wrap: wrap; gap: .8em } figure { margin: 0 } figcaption { font-size: .85em; color: "
    "#555 }\n"
    ".bad { color: #a11 } .note { color: #555; max-width: 52em }\n"
    "</style>\n";

void report_put(FILE *stream, const char *text) {
    for (; *text; text++) {
        if (*text == '<')
            fputs("&lt;", stream);
        else if (*text == '&')
            fputs("&amp;", stream);
        else if (*text == '"')
            fputs("&quot;", stream);
        else
            fputc(*text, stream);
    }
}

static char *base64(const char *head, const unsigned char *data, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t length = strlen(head);
    char *text = malloc(length + (size + 2) / 3 * 4 + 1);
    if (!text)
        return NULL;
    memcpy(text, head, length);
    char *at = text + length;
    for (size_t i = 0; i < size; i += 3) {
        unsigned long bits = (unsigned long)data[i] << 16;
        bits |= i + 1 < size ? (unsigned long)data[i + 1] << 8 : 0;
        bits |= i + 2 < size ? data[i + 2] : 0;
        for (int k = 0; k < 4; k++)
            *at++ = digits[bits >> (18 - 6 * k) & 63];
    }
    for (size_t pad = (3 - size % 3) % 3, k = 1; k <= pad; k++)
        at[-(ptrdiff_t)k] = '=';
    *at = '\0';
    return text;
}

char *report_picture(const cmd_args *args, const char *beside, const char *type, const float *rgb, uint32_t width,
                     uint32_t height) {
    char error[IMG_ERROR], intro[48];
    void *data = NULL;
    size_t size = 0;
    char *text = NULL;
    img_create_options how = {
        .width = width, .height = height, .channels = 3, .type = IMG_U8, .quality = 82, .format = type};
    char *name = cmd_temporary(beside);
    if (!name)
        return NULL;
    snprintf(intro, sizeof intro, "data:image/%s;base64,", type);
    if (img_write(name, &how, IMG_FLOAT, rgb, 0, error))
        cmd_error("%s: %s", name, error);
    else if (cmd_read_all(args, name, 0, &data, &size) == CMD_OK)
        text = base64(intro, data, size);
    free(data);
    cmd_temporary_drop(name);
    return text;
}

int report_put_picture(FILE *stream, char *text, const char *caption) {
    if (!text)
        return CMD_INTERNAL;
    if (caption)
        fputs("<figure>", stream);
    fprintf(stream, "<img alt=\"\" src=\"%s\">", text);
    if (caption)
        fprintf(stream, "<figcaption>%s</figcaption></figure>\n", caption);
    free(text);
    return CMD_OK;
}
