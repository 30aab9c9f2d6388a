#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds libzt, its tests and its fuzz targets for another architecture and runs them under qemu: all tests, with a
# thousandth of the fuzz campaigns. The corpus must decode there, and the writer must write the same bytes.
#
#     ./dev audit cross [ARCHITECTURE]    aarch64 (NEON) or s390x (big-endian); without one, both
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
source tools/dev/audit/debian.sh

say() {
    printf '==> %s\n' "$*"
}

debian_name() {
    case $1 in
    aarch64) echo arm64 ;;
    s390x) echo s390x ;;
    *)
        printf 'audit cross: no architecture %s; there are aarch64 and s390x\n' "$1" >&2
        exit 2
        ;;
    esac
}

# libzstd and libxxhash for the architecture, unpacked into a folder.
fetch_libraries() { # ARCHITECTURE FOLDER
    local debian package
    debian=$(debian_name "$1")
    [ ! -d "$2/root/usr" ] || return 0
    say "fetching libzstd-dev and libxxhash-dev for $1"
    debian_lists "$2/apt" "$debian" >/dev/null
    (cd "$2/apt" && debian_apt "$2/apt" "$debian" download "libzstd-dev:$debian" "libxxhash-dev:$debian" >/dev/null)
    for package in "$2"/apt/*.deb; do
        dpkg-deb -x "$package" "$2/root"
    done
}

audit() { # ARCHITECTURE
    local folder=$PWD/build/audit/cross-$1
    mkdir -p "$folder"
    fetch_libraries "$1" "$folder"
    say "building for $1 into $folder"
    cmake -S . -B "$folder/build" -G Ninja --toolchain cmake/cross.cmake -DZT_CROSS_ARCH="$1" \
        -DZT_CROSS_ROOT="$folder/root" -DCMAKE_BUILD_TYPE=Release -DZT_WERROR=ON -DZT_BUILD_TOOLS=OFF \
        -DZT_SMOKE_DIVISOR=100 -DZT_TEST_TIMEOUT=3000 >/dev/null
    cmake --build "$folder/build" -- --quiet
    say "tests under qemu-$1"
    ctest --test-dir "$folder/build" -L 'internal|api|fuzz' --output-on-failure --no-tests=error -j "$(nproc)"
}

if [ $# -gt 1 ]; then
    echo 'usage: ./dev audit cross [aarch64|s390x]' >&2
    exit 2
fi
if [ $# -eq 1 ]; then
    debian_name "$1" >/dev/null
fi
for architecture in ${1:-aarch64 s390x}; do
    audit "$architecture"
done
