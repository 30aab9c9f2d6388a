/* SPDX-License-Identifier: Apache-2.0 */
#include "base_diag.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const zt__rule rules[] = {
#define ZT_RULE_DEF(id, severity, fatal, result, name, anchor, text) \
    {{id, ZT_SEVERITY_##severity, name, anchor, text}, fatal, ZT_##result},
#include "rules.def"
#undef ZT_RULE_DEF
};

enum { RULE_COUNT = sizeof rules / sizeof rules[0] };

const zt_rule *zt_get_rule(uint32_t i) {
    return i < RULE_COUNT ? &rules[i].pub : NULL;
}

const zt__rule *zt__find_rule(uint32_t id) {
    uint32_t low = 0, high = RULE_COUNT;
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (rules[middle].pub.id < id)
            low = middle + 1;
        else
            high = middle;
    }
    return low < RULE_COUNT && rules[low].pub.id == id ? &rules[low] : NULL;
}

const zt_rule *zt_find_rule(uint32_t id) {
    const zt__rule *rule = zt__find_rule(id);
    return rule ? &rule->pub : NULL;
}

const char *zt_result_text(zt_result result) {
    switch (result) {
    case ZT_OK:
        return "no error";
    case ZT_AGAIN:
        return "more bytes are needed first";
    case ZT_BAD_ARGUMENT:
        return "bad argument";
    case ZT_NO_MEMORY:
        return "out of memory";
    case ZT_IO:
        return "input or output failed";
    case ZT_NOT_ZTEX:
        return "not a .ztex file";
    case ZT_CORRUPT:
        return "corrupt file";
    case ZT_TRUNCATED:
        return "truncated file";
    case ZT_UNSUPPORTED:
        return "not supported";
    case ZT_LIMIT:
        return "over a limit";
    case ZT_CANCELLED:
        return "cancelled";
    case ZT_INTERNAL:
        return "internal error in libzt";
    }
    return "unknown result";
}

/* Texts may carry bytes of the file (chunk types, names): only printable ASCII goes out. */
static void make_printable(char *text) {
    for (; *text; text++) {
        if (*text < 0x20 || *text > 0x7e)
            *text = '?';
    }
}

static void format_text(char *dst, size_t size, const char *format, va_list args) __attribute__((format(printf, 3, 0)));

static void format_text(char *dst, size_t size, const char *format, va_list args) {
    if (vsnprintf(dst, size, format, args) < 0)
        dst[0] = 0;
    make_printable(dst);
}

static void fill(zt_diag *diag, zt_result result, uint32_t rule, uint64_t offset, const char *path, const char *text) {
    if (!diag || diag->result != ZT_OK)
        return;
    diag->result = result;
    diag->rule = rule;
    diag->offset = offset;
    diag->size = 0;
    snprintf(diag->path, sizeof diag->path, "%s", path);
    snprintf(diag->text, sizeof diag->text, "%s", text);
}

void zt__begin(zt_diag *diag) {
    if (diag)
        memset(diag, 0, sizeof *diag);
}

void zt__enter(zt__sink *sink, const char *format, ...) {
    va_list args;
    va_start(args, format);
    format_text(sink->path, sizeof sink->path, format, args);
    va_end(args);
}

zt_result zt__report(zt__sink *sink, uint32_t id, uint64_t offset, const char *format, ...) {
    char text[sizeof((zt_diag *)0)->text];
    va_list args;
    va_start(args, format);
    format_text(text, sizeof text, format, args);
    va_end(args);

    const zt__rule *rule = zt__find_rule(id);
    if (!rule) {
        fill(sink->diag, ZT_INTERNAL, id, offset, sink->path, "a rule without a row in the table");
        return ZT_INTERNAL;
    }
    if (!sink->check) {
        if (rule->result != ZT_OK)
            fill(sink->diag, rule->result, id, offset, sink->path, text);
        return rule->result;
    }
    if (rule->pub.severity == ZT_SEVERITY_ERROR)
        sink->summary->errors++;
    else if (rule->pub.severity == ZT_SEVERITY_WARNING)
        sink->summary->warnings++;
    else
        sink->summary->limits++;
    if (sink->check->finding) {
        zt_finding finding = {id, rule->pub.severity, offset, sink->path, text};
        if (sink->check->finding(sink->check->user, &finding)) {
            sink->stopped = ZT_CANCELLED;
            return ZT_CANCELLED;
        }
    }
    return rule->fatal ? rule->result : ZT_OK;
}

zt_result zt__fail(zt_diag *diag, zt_result result, uint32_t rule, uint64_t offset, const char *format, ...) {
    char text[sizeof diag->text];
    va_list args;
    va_start(args, format);
    format_text(text, sizeof text, format, args);
    va_end(args);
    fill(diag, result, rule, offset, "", text);
    return result;
}

zt_result zt__bad_argument(zt_diag *diag, const char *text) {
    return zt__fail(diag, ZT_BAD_ARGUMENT, 0, ZT__NO_OFFSET, "%s", text);
}
