#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Property: `cmake --install` writes exactly the files that cmake/install_manifest.txt lists.
# A header or a man page that is forgotten, or a file that slips in, is seen here and not by users.
#
# usage: manifest.sh PREFIX LIBDIR [--refresh]
set -euo pipefail
prefix=$1
libdir=$2
list=cmake/install_manifest.txt

# The library folder differs between distributions; the list always says lib/.
installed() {
    (cd "$prefix" && find . \( -type f -o -type l \) -printf '%P\n') |
        sed -e "s|^$libdir/|lib/|" | LC_ALL=C sort
}

if [ "${3:-}" = --refresh ]; then
    installed >"$list"
    exit 0
fi
if ! diff -u --label "$list" --label installed "$list" <(installed); then
    echo
    echo "If that is meant: bash tools/dev/tests/manifest.sh '$prefix' '$libdir' --refresh"
    exit 1
fi
