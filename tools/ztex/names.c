/* SPDX-License-Identifier: Apache-2.0 */
/* Names of the numbers of spec/registry.md, for people and scripts. */
#include "command_private.h"

#include <stdlib.h>
#include <string.h>

typedef struct name_row {
    uint32_t number;
    const char *name;
} name_row;

#define COUNT(rows) (sizeof(rows) / sizeof(rows)[0])

static const name_row semantics[] = {{0, "unspecified"},
                                     {1, "base_colour"},
                                     {2, "normal"},
                                     {3, "displacement"},
                                     {4, "roughness"},
                                     {5, "metalness"},
                                     {6, "occlusion"},
                                     {7, "emissive"},
                                     {8, "opacity"},
                                     {9, "specular"},
                                     {10, "occlusion_roughness_metalness"}};

/* The first name of a number is the one that is shown. */
static const name_row transfers[] = {
    {1, "bt709"},      {2, "unspecified"}, {4, "gamma22"}, {5, "gamma28"},   {6, "bt601"},   {7, "smpte240"},
    {8, "linear"},     {9, "log100"},      {10, "log316"}, {11, "xvycc"},    {12, "bt1361"}, {13, "srgb"},
    {14, "bt2020-10"}, {15, "bt2020-12"},  {16, "pq"},     {17, "smpte428"}, {18, "hlg"}};

static const name_row primaries[] = {{1, "bt709"},    {2, "unspecified"}, {4, "bt470m"}, {5, "bt470bg"}, {6, "bt601"},
                                     {7, "smpte240"}, {8, "film"},        {9, "bt2020"}, {10, "xyz"},    {11, "p3-dci"},
                                     {12, "p3-d65"},  {22, "ebu3213"},    {1, "srgb"}};

static const name_row wraps[] = {{0, "repeat"}, {1, "mirror"}, {2, "clamp"}, {3, "border"}};
static const name_row alphas[] = {{0, "none"}, {1, "straight"}, {2, "premultiplied"}};
static const name_row layer_kinds[] = {{0, "array"}, {1, "cube"}, {2, "frames"}};
static const name_row kinds[] = {{0, "image"}, {1, "zipmap"}, {2, "silmap"}, {3, "umbrellas"}};

static const char *name_of(const name_row *rows, size_t count, uint32_t number) {
    for (size_t i = 0; i < count; i++)
        if (rows[i].number == number)
            return rows[i].name;
    return NULL;
}

static char plain(char c) {
    if (c >= 'A' && c <= 'Z')
        return (char)(c - 'A' + 'a');
    return c == '_' ? '-' : c;
}

static int same_name(const char *a, const char *b) {
    for (; *a && *b; a++, b++)
        if (plain(*a) != plain(*b))
            return 0;
    return *a == *b;
}

static int number_of(const name_row *rows, size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (same_name(rows[i].name, name))
            return (int)rows[i].number;
    return -1;
}

/* CICP numbers have eight bits. */
static int number_or_name(const name_row *rows, size_t count, const char *name) {
    uint64_t number;
    if (cmd_parse_u64(name, &number) == 0)
        return number <= 255 ? (int)number : -1;
    return number_of(rows, count, name);
}

const char *cmd_semantic_name(uint32_t semantic) {
    return name_of(semantics, COUNT(semantics), semantic);
}

int cmd_semantic_number(const char *name) {
    uint64_t number;
    if (cmd_parse_u64(name, &number) == 0)
        return number <= 65535 ? (int)number : -1;
    /* Two spellings of one word. */
    if (same_name(name, "base_color"))
        return 1;
    return number_of(semantics, COUNT(semantics), name);
}

const char *cmd_transfer_name(uint32_t transfer) {
    return name_of(transfers, COUNT(transfers), transfer);
}

int cmd_transfer_number(const char *name) {
    return number_or_name(transfers, COUNT(transfers), name);
}

const char *cmd_primaries_name(uint32_t number) {
    return name_of(primaries, COUNT(primaries), number);
}

int cmd_primaries_number(const char *name) {
    return number_or_name(primaries, COUNT(primaries), name);
}

const char *cmd_wrap_name(uint32_t wrap) {
    return name_of(wraps, COUNT(wraps), wrap);
}

const char *cmd_alpha_name(uint32_t alpha) {
    return name_of(alphas, COUNT(alphas), alpha);
}

const char *cmd_layer_kind_name(uint32_t kind) {
    return name_of(layer_kinds, COUNT(layer_kinds), kind);
}

const char *cmd_kind_name(uint32_t kind) {
    return name_of(kinds, COUNT(kinds), kind);
}
