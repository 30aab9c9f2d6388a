# SPDX-License-Identifier: Apache-2.0
# Toolchain file for Debian's cross compilers; programs run under qemu. -DZT_CROSS_ARCH=aarch64 (or s390x ...) names the
# architecture, -DZT_CROSS_ROOT a folder into which Debian's libzstd-dev and libxxhash-dev for it were unpacked.
# `./dev audit cross` uses it.

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ZT_CROSS_ARCH ZT_CROSS_ROOT)
if(NOT ZT_CROSS_ARCH OR NOT ZT_CROSS_ROOT)
  message(FATAL_ERROR "cmake/cross.cmake needs -DZT_CROSS_ARCH=... and -DZT_CROSS_ROOT=...")
endif()

set(zt_triple ${ZT_CROSS_ARCH}-linux-gnu)
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR ${ZT_CROSS_ARCH})
set(CMAKE_C_COMPILER ${zt_triple}-gcc)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-${ZT_CROSS_ARCH}-static -L /usr/${zt_triple})

# pkg-config sees only the target's libraries, and they lie below the root.
set(ENV{PKG_CONFIG_LIBDIR} ${ZT_CROSS_ROOT}/usr/lib/${zt_triple}/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${ZT_CROSS_ROOT})
set(CMAKE_FIND_ROOT_PATH ${ZT_CROSS_ROOT} /usr/${zt_triple})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
