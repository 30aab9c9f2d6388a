/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The mutator of all targets: one or a few changes to a file taken apart, which is then sealed. One call in sixteen
 * leaves out a step of the sealing, one in sixteen changes plain bytes: what guards the format is fuzzed too.
 */
#ifndef ZT_FUZZ_MUTATE_H
#define ZT_FUZZ_MUTATE_H

#include "seal.h"

/* What libFuzzer calls beside the entry points of support.h. */
size_t LLVMFuzzerCustomCrossOver(const uint8_t *data1, size_t size1, const uint8_t *data2, size_t size2, uint8_t *out,
                                 size_t max_size, unsigned seed);

#endif
