#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# ./dev bench codec [--write] [--rounds N] [--only TEXT] [--no-load]
# Question and options: codec_main.c. --write also writes docs/codec-bench.md and docs/codec-bench.svg.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

options=()
for option in "$@"; do
    options+=("$option")
    [ "$option" != --write ] || options+=(docs)
done

bash tools/bench/setup.sh
# CMake only knows the program once the peers' libraries are there.
if ! cmake --build build/release --target bench_codec 2>/dev/null; then
    cmake --preset release >/dev/null
    cmake --build build/release --target bench_codec
fi
exec build/release/tools/bench/bench_codec "${options[@]}"
