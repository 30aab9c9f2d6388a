/* SPDX-License-Identifier: Apache-2.0 */
#include "base_hash.h"

#define XXH_STATIC_LINKING_ONLY /* for the size of the state: nothing else of it is used */
#include <xxhash.h>

_Static_assert(sizeof(XXH3_state_t) <= sizeof(((zt__hasher *)0)->state), "zt__hasher has room for the state");
_Static_assert(_Alignof(XXH3_state_t) <= 64, "zt__hasher is aligned for the state");

uint64_t zt__hash(const void *data, size_t size) {
    return XXH3_64bits(data, size);
}

void zt__hash_begin(zt__hasher *hasher) {
    XXH3_64bits_reset((XXH3_state_t *)(void *)hasher->state);
}

void zt__hash_more(zt__hasher *hasher, const void *data, size_t size) {
    XXH3_64bits_update((XXH3_state_t *)(void *)hasher->state, data, size);
}

uint64_t zt__hash_end(const zt__hasher *hasher) {
    return XXH3_64bits_digest((const XXH3_state_t *)(const void *)hasher->state);
}
