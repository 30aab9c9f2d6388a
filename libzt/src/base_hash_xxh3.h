/* SPDX-License-Identifier: Apache-2.0 */
/* XXH3-64 as a kernel: that of the system's library, which is made for SSE2, or compiled into a source that has chosen
 * XXH_VECTOR and the instructions for it. */
#ifdef XXH_VECTOR
#define XXH_INLINE_ALL
#else
#define XXH_STATIC_LINKING_ONLY /* for the size of the state: nothing else of it is used */
#endif
#include <xxhash.h>

#include "base_hash.h"

_Static_assert(sizeof(XXH3_state_t) <= sizeof(((zt__hasher *)0)->state), "zt__hasher has room for the state");
_Static_assert(_Alignof(XXH3_state_t) <= 64, "zt__hasher is aligned for the state");

static uint64_t hash(const void *data, size_t size) {
    return XXH3_64bits(data, size);
}

static void begin(zt__hasher *hasher) {
    XXH3_64bits_reset((XXH3_state_t *)(void *)hasher->state);
}

static void more(zt__hasher *hasher, const void *data, size_t size) {
    XXH3_64bits_update((XXH3_state_t *)(void *)hasher->state, data, size);
}

static uint64_t end(const zt__hasher *hasher) {
    return XXH3_64bits_digest((const XXH3_state_t *)(const void *)hasher->state);
}
