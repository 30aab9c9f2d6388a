#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Property: a program outside this repository gets libzt in every way that the README names, with no
# flags of its own, and the library it then runs with is this version.
#
# usage: consumer.sh WAY PREFIX LIBDIR SCRATCH VERSION
set -euo pipefail
way=$1 prefix=$2 libdir=$3 scratch=$4 version=$5
root=$PWD
here=$root/tools/dev/tests/consumer
: "${CC:=cc}" "${CMAKE:=cmake}"
export CC

rm -rf "$scratch"
mkdir -p "$scratch"
kind=${way##*_}

with_cmake() {
    "$CMAKE" -G Ninja -S "$here" -B "$scratch" -DCMAKE_BUILD_TYPE= "$@" >"$scratch/log" ||
        { cat "$scratch/log"; exit 1; }
    "$CMAKE" --build "$scratch" >"$scratch/log" || { cat "$scratch/log"; exit 1; }
}

shared=OFF
[ "$kind" = static ] || shared=ON
case $way in
find_package_*)
    with_cmake "-DCMAKE_PREFIX_PATH=$prefix" "-DBUILD_SHARED_LIBS=$shared"
    ;;
subdirectory_*)
    with_cmake "-DZT_SOURCE=$root" "-DBUILD_SHARED_LIBS=$shared"
    # As a guest libzt brings neither its tests nor its tools.
    if find "$scratch" -type f -perm -u+x \( -name 'test_*' -o -name 'api_*' -o -name 'ztex*' \) |
        grep .; then
        echo "built without being asked for" >&2
        exit 1
    fi
    ;;
pkg_config_shared)
    export PKG_CONFIG_PATH=$prefix/$libdir/pkgconfig
    read -ra flags <<<"$(pkg-config --cflags --libs zt)"
    "$CC" -std=c99 -o "$scratch/consumer" "$here/consumer.c" "${flags[@]}"
    ;;
pkg_config_static)
    # Without the shared library beside it, -lzt means the archive.
    mkdir -p "$scratch/lib/pkgconfig"
    cp "$prefix/$libdir/libzt.a" "$scratch/lib"
    sed -e "s|^libdir=.*|libdir=$scratch/lib|" "$prefix/$libdir/pkgconfig/zt.pc" \
        >"$scratch/lib/pkgconfig/zt.pc"
    export PKG_CONFIG_PATH=$scratch/lib/pkgconfig
    read -ra flags <<<"$(pkg-config --static --cflags --libs zt)"
    "$CC" -std=c99 -o "$scratch/consumer" "$here/consumer.c" "${flags[@]}"
    ;;
*)
    echo "unknown way '$way'" >&2
    exit 2
    ;;
esac

program=$scratch/consumer
if [ "$kind" = shared ]; then
    export LD_LIBRARY_PATH=$prefix/$libdir
fi
linked=static
libraries=$(ldd "$program") # whole: a pipe that grep -q closes early would fail ldd
[[ $libraries != *libzt.so* ]] || linked=shared
if [ "$linked" != "$kind" ]; then
    echo "linked with the $linked library, expected $kind" >&2
    exit 1
fi
said=$("$program")
echo "$way: $said"
[ "$said" = "libzt $version" ]
