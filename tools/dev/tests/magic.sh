#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Property: file(1) with share/ztex.magic names a .ztex, its version and its number of chunks, and
# does not claim a file that a text-mode transfer has damaged.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# preamble MAGIC MAJOR MINOR CHUNKS: 64 bytes; fields that file(1) does not read are zero.
preamble() {
    /usr/bin/python3 - "$@" <<'PYTHON'
import struct, sys
magic, (major, minor, chunks) = bytes.fromhex(sys.argv[1]), map(int, sys.argv[2:])
head = bytearray(64)
head[0:10] = magic
struct.pack_into('<HH', head, 10, major, minor)
struct.pack_into('<I', head, 28, chunks)
sys.stdout.buffer.write(head)
PYTHON
}

failed=0
expect() {
    local said
    said=$(file -b -m share/ztex.magic "${@:3}" "$scratch/$1")
    if [ "$said" != "$2" ]; then
        printf 'file %s said: %s\n    expected: %s\n' "${*:3}" "$said" "$2"
        failed=1
    fi
}

magic=ab5a544558bb0d0a1a0a
preamble $magic 1 0 4 >"$scratch/four.ztex"
preamble $magic 1 2 1 >"$scratch/one.ztex"
preamble ${magic/0d0a1a/0a001a} 1 0 4 >"$scratch/damaged.ztex"

expect four.ztex 'ztex texture, version 1.0, 4 chunks'
expect one.ztex 'ztex texture, version 1.2, 1 chunk'
expect four.ztex 'image/x-ztex' --mime-type
expect four.ztex 'ztex' --extension
expect damaged.ztex 'data'

# And a whole file of the conformance set, when this is a full checkout.
if [ -f conformance/valid/first.ztex ]; then
    cp conformance/valid/first.ztex "$scratch"
    expect first.ztex 'ztex texture, version 1.0, 3 chunks'
fi
exit $failed
