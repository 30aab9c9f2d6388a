/* SPDX-License-Identifier: Apache-2.0 */
/* What the command says on standard error, and the exit code that goes with it. */
#include "command_private.h"

#include <stdarg.h>
#include <string.h>

/* Messages quote names and texts from outside, so the whole line is made safe, here and once. */
static void print_line(const char *prefix, const char *format, va_list list) CMD_PRINTF(2, 0);

static void print_line(const char *prefix, const char *format, va_list list) {
    char text[2048];
    vsnprintf(text, sizeof text, format, list);
    cmd_progress_clear();
    fputs(prefix, stderr);
    cmd_print_safe(stderr, text);
    fputc('\n', stderr);
}

void cmd_error(const char *format, ...) {
    va_list list;
    va_start(list, format);
    print_line("ztex: ", format, list);
    va_end(list);
}

void cmd_warn(const cmd_args *args, const char *format, ...) {
    va_list list;
    va_start(list, format);
    if (!args->quiet)
        print_line("ztex: warning: ", format, list);
    va_end(list);
}

void cmd_note(const cmd_args *args, const char *format, ...) {
    va_list list;
    va_start(list, format);
    if (!args->quiet)
        print_line("ztex: ", format, list);
    va_end(list);
}

void cmd_verbose(const cmd_args *args, const char *format, ...) {
    va_list list;
    va_start(list, format);
    if (args->verbose && !args->quiet)
        print_line("ztex: ", format, list);
    va_end(list);
}

void cmd_hint(const char *format, ...) {
    va_list list;
    va_start(list, format);
    print_line("      ", format, list);
    va_end(list);
}

int cmd_fail(int status, const char *format, ...) {
    va_list list;
    va_start(list, format);
    print_line("ztex: ", format, list);
    va_end(list);
    return status;
}

int cmd_usage(const cmd_args *args, const char *format, ...) {
    va_list list;
    char prefix[64];
    snprintf(prefix, sizeof prefix, "ztex %s: ", args->verb->name);
    va_start(list, format);
    print_line(prefix, format, list);
    va_end(list);
    cmd_hint("Try 'ztex %s --help'.", args->verb->name);
    return CMD_USAGE;
}

int cmd_cancelled(void) {
    return cmd_fail(CMD_CANCELLED, "interrupted; nothing was written");
}

int cmd_status_of(zt_result result) {
    switch (result) {
    case ZT_OK:
        return CMD_OK;
    case ZT_BAD_ARGUMENT:
        return CMD_USAGE;
    case ZT_IO:
        return CMD_IO;
    case ZT_NOT_ZTEX:
    case ZT_CORRUPT:
    case ZT_TRUNCATED:
        return CMD_INVALID;
    case ZT_UNSUPPORTED:
        return CMD_UNSUPPORTED;
    case ZT_LIMIT:
        return CMD_LIMIT;
    case ZT_CANCELLED:
        return CMD_CANCELLED;
    default:
        return CMD_INTERNAL;
    }
}

static void hint_for(zt_result result, const char *text) {
    switch (result) {
    case ZT_NOT_ZTEX:
        cmd_hint("This is no .ztex file. A picture becomes one with 'ztex make PICTURE -o "
                 "OUT.ztex'.");
        break;
    case ZT_CORRUPT:
        cmd_hint("'ztex validate' lists every fault; 'ztex recover' saves what can be read.");
        break;
    case ZT_TRUNCATED:
        cmd_hint("Fetch the file again, or save what is there with 'ztex recover'.");
        break;
    case ZT_UNSUPPORTED:
        cmd_hint("The file may be right, but needs a feature that this version has not.");
        break;
    case ZT_LIMIT:
        cmd_hint(strstr(text, "memory") ? "If you trust the file, raise the limit: --memory 8G."
                                        : "The limit protects against hostile files.");
        break;
    case ZT_NO_MEMORY:
        cmd_hint("Close other programs, or work in parts.");
        break;
    case ZT_INTERNAL:
        cmd_hint("This is a bug in ztex. Please report it, with the file if you can.");
        break;
    default:
        break;
    }
}

int cmd_fail_result(const char *file, zt_result result, const zt_diag *diag) {
    char where[160] = "";
    size_t at = 0;
    if (result == ZT_CANCELLED)
        return cmd_cancelled();
    const char *text = diag && diag->text[0] ? diag->text : zt_result_text(result);
    if (diag && diag->rule)
        at += (size_t)snprintf(where + at, sizeof where - at, ", rule %u", (unsigned)diag->rule);
    if (diag && diag->path[0])
        at += (size_t)snprintf(where + at, sizeof where - at, ", %s", diag->path);
    /* A diag that no function has touched is all zero: offset 0 means nothing without a rule. */
    if (diag && diag->rule && diag->offset != UINT64_MAX && result != ZT_BAD_ARGUMENT)
        at += (size_t)snprintf(where + at, sizeof where - at, ", offset %llu", (unsigned long long)diag->offset);
    if (at > 0)
        cmd_error("%s: %s (%s)", file, text, where + 2);
    else
        cmd_error("%s: %s", file, text);
    hint_for(result, text);
    return cmd_status_of(result);
}
