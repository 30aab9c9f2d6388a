/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rules, diagnostics and sinks. A check states a rule once; where the finding goes decides what happens next: the
 * loader's sink stops at the first error and fills a zt_diag, the validator's reports and goes on.
 */
#ifndef ZT_BASE_DIAG_H
#define ZT_BASE_DIAG_H

#include <stdbool.h>
#include <stdint.h>

#include "zt/zt.h"
#include "zt/zt_check.h"

#define ZT__NO_OFFSET UINT64_MAX

typedef struct zt__rule {
    zt_rule pub;
    bool fatal;       /* what comes behind cannot be read: the validator stops here too */
    zt_result result; /* what a loader returns */
} zt__rule;

const zt__rule *zt__find_rule(uint32_t id);

/* Where findings go. The zero sink with a diag is the loader's. */
typedef struct zt__sink {
    zt_diag *diag;                 /* loader: filled with the first error; may be NULL */
    const zt_check_options *check; /* validator: NULL for a loader */
    zt_check_summary *summary;     /* validator */
    zt_result stopped;             /* validator: ZT_CANCELLED once the callback asked to stop */
    char path[64];                 /* where the checks are now; see zt__enter */
} zt__sink;

/* Sets the path of the following findings. */
void zt__enter(zt__sink *sink, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Reports that a rule is broken at offset. Returns what to do: ZT_OK to go on (validator, rule not fatal; warnings),
 * else the result to return. */
zt_result zt__report(zt__sink *sink, uint32_t rule, uint64_t offset, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Fills diag (may be NULL) unless it holds an error already, and returns result. For errors that are not rules of the
 * format. */
zt_result zt__fail(zt_diag *diag, zt_result result, uint32_t rule, uint64_t offset, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* ZT_BAD_ARGUMENT with a text. */
zt_result zt__bad_argument(zt_diag *diag, const char *text);

/* A public call begins: clears *diag (may be NULL) so that the first error of the call wins. */
void zt__begin(zt_diag *diag);

/* The two macros that return. */
#define ZT_TRY(expr)                    \
    do {                                \
        zt_result try_result_ = (expr); \
        if (try_result_ != ZT_OK)       \
            return try_result_;         \
    } while (0)

/* States a rule; returns when the sink says stop. The offset and the text are evaluated only when the rule is broken.
 */
#define ZT_RULE(sink, id, condition, offset, ...)              \
    do {                                                       \
        if (!(condition))                                      \
            ZT_TRY(zt__report(sink, id, offset, __VA_ARGS__)); \
    } while (0)

#endif
