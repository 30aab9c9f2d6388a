/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checking .ztex files: the same rules that opening a file applies, carried on behind the first error, and the rest of
 * the file with them. What holds everywhere in zt.h holds here.
 */
#ifndef ZT_ZT_CHECK_H
#define ZT_ZT_CHECK_H

#include <zt/zt.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum zt_severity {
    ZT_SEVERITY_ERROR = 0,   /* not a valid file */
    ZT_SEVERITY_WARNING = 1, /* valid, but probably not meant so */
    ZT_SEVERITY_LIMIT = 2    /* over a limit of the reader's: not a rule of the format */
} zt_severity;

typedef struct zt_rule {
    uint32_t id;
    zt_severity severity;
    const char *name;   /* "preamble-magic": stable, for people and scripts */
    const char *anchor; /* where the specification states it: "ztex.md#3" */
    const char *text;   /* the rule in one sentence */
} zt_rule;

/* The i-th rule in ascending order of ids, NULL behind the last. */
ZT_API const zt_rule *zt_get_rule(uint32_t i);
/* By id, NULL when unknown. */
ZT_API const zt_rule *zt_find_rule(uint32_t id);

typedef struct zt_finding {
    uint32_t rule;
    zt_severity severity;
    uint64_t offset;  /* UINT64_MAX: none */
    const char *path; /* "IMAG/image 3": lives during the call */
    const char *text; /* lives during the call */
} zt_finding;

enum {
    ZT_CHECK_STRUCTURE = 1 /* only what opening checks: no texels, no hashes of TEXL */
};

typedef struct zt_check_options {
    size_t size;                   /* sizeof(zt_check_options), or 0 */
    const zt_allocator *allocator; /* NULL: malloc */
    const zt_limits *limits;       /* NULL: defaults */
    const zt_parallel
        *parallel;  /* NULL: in the calling thread. Findings come from the calling thread, in the same order */
    uint32_t flags; /* ZT_CHECK_... */
    void *user;
    /* Called for each finding; a result other than 0 ends the check with ZT_CANCELLED. NULL: only count. */
    int (*finding)(void *user, const zt_finding *finding);
    /* Called now and then with the share that is done, 0 to 1; a result other than 0 cancels. NULL: not wanted. */
    int (*progress)(void *user, double done);
} zt_check_options;

typedef struct zt_check_summary {
    uint64_t errors, warnings, limits;
    int complete; /* 1: every part could be looked at; 0: an error hid what comes behind it */
} zt_check_summary;

/* Checks a file. ZT_OK: the check ran, see summary for the verdict (errors == 0: valid). Other results: it could not
 * run: ZT_BAD_ARGUMENT, ZT_NO_MEMORY, ZT_IO, ZT_AGAIN, ZT_CANCELLED. options and diag may be NULL. */
ZT_API zt_result zt_check_memory(const void *data, size_t size, const zt_check_options *options, zt_diag *diag,
                                 zt_check_summary *out);
ZT_API zt_result zt_check_path(const char *path, const zt_check_options *options, zt_diag *diag, zt_check_summary *out);
ZT_API zt_result zt_check_io(const zt_io *io, const zt_check_options *options, zt_diag *diag, zt_check_summary *out);

#ifdef __cplusplus
}
#endif

#endif
