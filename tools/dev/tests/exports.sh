#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Property: the shared library exports every function that the public headers declare with ZT_API,
# and nothing else. A symbol between files (zt__*) or of a dependency must not become an interface.
#
# usage: exports.sh LIBRARY
set -euo pipefail
exported=$(nm -D --defined-only --format=posix "$1" | cut -d ' ' -f 1 | LC_ALL=C sort -u)
declared=$(cat libzt/include/zt/*.h | tr '\n' ' ' | grep -oE '\bZT_API\b[^;{]*' |
    grep -oE '\bzt_[a-z0-9_]+ *\(' | tr -d ' (' | LC_ALL=C sort -u)
diff -u --label 'declared with ZT_API' --label exported \
    <(printf '%s\n' "$declared") <(printf '%s\n' "$exported")
