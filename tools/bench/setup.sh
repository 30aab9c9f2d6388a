#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# setup.sh [PACKAGES]: what a bench needs beside ./dev setup. Without an argument that is ./dev bench codec: the peers'
# libraries and the pictures; those that are inside an archive are put into build/bench/pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

install_packages() { # LIST
    local wanted missing
    mapfile -t wanted < <(sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$1")
    mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | LC_ALL=C sort -u) \
        <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null |
            sed -n 's/^installed //p' | LC_ALL=C sort -u))
    [ "${#missing[@]}" -gt 0 ] || return 0
    printf '==> installing: %s\n' "${missing[*]}"
    local apt=(env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=600)
    as_root "${apt[@]}" update
    as_root "${apt[@]}" install -y --no-install-recommends "${missing[@]}"
}

unpack_pictures() {
    /usr/bin/python3 - tools/bench/pictures.txt build/bench/pictures <<'PYTHON'
import sys
import zipfile
from pathlib import Path

folder = Path(sys.argv[2])
for line in Path(sys.argv[1]).read_text().splitlines():
    if line.startswith('#') or line.count('|') != 3:
        continue
    archive, mark, member = line.split('|')[2].strip().partition('!')
    if mark and not (folder / member).exists():
        (folder / member).parent.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(archive) as opened:
            (folder / member).write_bytes(opened.read(member))
PYTHON
}

if command -v dpkg-query >/dev/null; then
    install_packages "${1:-tools/bench/packages.txt}"
fi
if [ $# -eq 0 ]; then
    unpack_pictures
fi
