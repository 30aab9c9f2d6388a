/* SPDX-License-Identifier: Apache-2.0 */
/* Running tasks through the caller's zt_parallel, or in this thread when there is none. */
#ifndef ZT_BASE_PARALLEL_H
#define ZT_BASE_PARALLEL_H

#include "zt/zt.h"

typedef void zt__task(void *context, size_t index, unsigned worker);

static inline unsigned zt__workers(const zt_parallel *parallel) {
    return parallel && parallel->run && parallel->workers > 1 ? parallel->workers : 1;
}

static inline void zt__run(const zt_parallel *parallel, size_t count, zt__task *task, void *context) {
    if (count > 1 && zt__workers(parallel) > 1) {
        parallel->run(parallel->user, count, task, context);
        return;
    }
    for (size_t i = 0; i < count; i++)
        task(context, i, 0);
}

#endif
