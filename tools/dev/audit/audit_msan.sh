#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of libzt under MemorySanitizer (clang): no decision and no written byte comes from memory that nobody set.
# zstd is compiled from Debian's source, xxHash from its header: code without instrumentation would look like a fault.
#
#     ./dev audit msan [CTEST ARGUMENT...]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
source tools/dev/audit/debian.sh

folder=$PWD/build/audit/msan
prefix=$folder/zstd
flags=(-O1 -g -fsanitize=memory -fno-omit-frame-pointer -fno-sanitize-recover=all)

say() {
    printf '==> %s\n' "$*"
}

build_zstd() {
    local source
    say "fetching the source of libzstd"
    debian_lists "$folder/apt" "$(dpkg --print-architecture)" >/dev/null
    (cd "$folder" && debian_apt "$folder/apt" "$(dpkg --print-architecture)" source --download-only libzstd >/dev/null)
    mkdir -p "$folder/source"
    tar -xf "$folder"/libzstd_*.orig.tar.xz -C "$folder/source" --strip-components=1
    source=$folder/source/lib
    say "compiling it"
    mkdir -p "$folder/objects" "$prefix/lib/pkgconfig" "$prefix/include"
    (cd "$folder/objects" && find "$source/common" "$source/compress" "$source/decompress" -name '*.c' -print0 |
        xargs -0 -n 8 -P 2 clang-14 "${flags[@]}" -DZSTD_DISABLE_ASM -DXXH_NAMESPACE=ZSTD_ -c)
    ar rcs "$prefix/lib/libzstd.a" "$folder"/objects/*.o
    cp "$source"/*.h "$prefix/include"
    printf 'Name: zstd\nDescription: instrumented\nVersion: %s\nLibs: -L%s/lib -lzstd\nCflags: -I%s/include\n' \
        "$(dpkg-query -W -f '${Version}' libzstd-dev | cut -d+ -f1)" "$prefix" "$prefix" \
        >"$prefix/lib/pkgconfig/libzstd.pc"
}

mkdir -p "$folder"
[ -f "$prefix/lib/pkgconfig/libzstd.pc" ] || build_zstd
# clang 14 knows that fstat() sets memory, but not that fstat64() does.
c_flags='-DXXH_INLINE_ALL= -U_FILE_OFFSET_BITS'
say "building into $folder/build"
PKG_CONFIG_PATH=$prefix/lib/pkgconfig cmake -S . -B "$folder/build" -G Ninja -DCMAKE_C_COMPILER=clang-14 \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG='-O1 -g' -DCMAKE_C_FLAGS="$c_flags" -DZT_SANITIZE=memory \
    -DZT_WERROR=ON -DZT_BUILD_TOOLS=OFF -DZT_SMOKE_DIVISOR=10 -DZT_TEST_TIMEOUT=3000 >/dev/null
cmake --build "$folder/build" -- --quiet
say "tests"
MSAN_SYMBOLIZER_PATH=$(command -v llvm-symbolizer-14) \
    ctest --test-dir "$folder/build" -L 'internal|api|fuzz' --output-on-failure --no-tests=error -j "$(nproc)" "$@"
