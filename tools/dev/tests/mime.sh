#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Property: a desktop that installs share/ztex.xml knows *.ztex by name and by content.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

mkdir -p "$scratch/mime/packages"
cp share/ztex.xml "$scratch/mime/packages/"
export XDG_DATA_HOME=$scratch XDG_DATA_DIRS=$scratch
complaints=$(update-mime-database "$scratch/mime" 2>&1)
if [ -n "$complaints" ]; then
    printf 'update-mime-database: %s\n' "$complaints"
    exit 1
fi

grep -qxF '50:image/x-ztex:*.ztex' "$scratch/mime/globs2"
grep -qxF 'image/x-ztex' "$scratch/mime/types"
grep -q '<mime-type xmlns=.*type="image/x-ztex"' "$scratch/mime/image/x-ztex.xml"

# The compiled rule (shared-mime-info, "The magic files"): [priority:type], then
# >offset=, the length of the value in two bytes, most significant first, and the value.
/usr/bin/python3 - "$scratch/mime/magic" <<'PYTHON'
import sys
magic = b'\xabZTEX\xbb\r\n\x1a\n'
rule = b'[80:image/x-ztex]\n>0=' + len(magic).to_bytes(2, 'big') + magic + b'\n'
with open(sys.argv[1], 'rb') as file:
    if rule not in file.read():
        sys.exit('the compiled magic lacks the rule for image/x-ztex')
PYTHON
echo "image/x-ztex is known by *.ztex and by its first ten bytes"
