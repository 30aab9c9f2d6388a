/* SPDX-License-Identifier: Apache-2.0 */
/* CHECK prints where it failed and counts. It goes on behind a failure, so that one run shows all; the first thirty are
 * printed. */
#ifndef AUTHOR_CHECKS_H
#define AUTHOR_CHECKS_H

#include <stdio.h>

static int failures;

#define CHECK(condition)                                                            \
    do {                                                                            \
        if (!(condition) && failures++ < 30)                                        \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
    } while (0)

#endif
