/* SPDX-License-Identifier: Apache-2.0 */
/* The list of verbs, in the order of the help. */
#include "command.h"

const cmd_verb *const cmd_verbs[] = {
    &verb_make,    &verb_make_zipmap, &verb_make_silmap, &verb_make_umbrellas, &verb_inspect, &verb_validate,
    &verb_extract, &verb_render,      &verb_convert,     &verb_diff,           &verb_recover, &verb_help,
    NULL,
};
