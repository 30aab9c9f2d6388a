#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `./dev demo`: one photograph as a zipmap, made, checked, shown and measured against the whole texture; then a heap of photographs.
# Results go to out/.
# `./dev demo --picture FILE` makes the picture of the README instead.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

readonly ztex=${ZTEX:-build/release/tools/ztex/ztex}
readonly python=/usr/bin/python3 # the one that sees Debian's modules
readonly photo=/usr/share/backgrounds/mate/abstract/Elephants_5640x3172.jpg
readonly out=out/demo
readonly frames=6

say() {
    printf '\n==> %s\n' "$*"
}

run() {
    printf '    ztex %s\n' "$*"
    "$ztex" "$@"
}

# The same views of the three files: render NAME FILE [OPTION...]
render_path() {
    local name=$1 file=$2
    shift 2
    run render "$file" -o "$out/${name}_%04d.png" --zoom-path "$path" --frames "$frames" --size 480x270 "$@"
}

readme_picture() {
    local target=$1 data
    data=$("$python" -c 'import os, skimage.data; print(os.path.dirname(skimage.data.__file__))')
    "$python" tools/dev/demo.py scene astronaut "$data/astronaut.png" "$out"
    run make "$out/scene.json" -o "$out/zipmap.ztex"
    run make "$data/astronaut.png" -o "$out/full.ztex" --wrap clamp
    local view=0.272,0.015,0.638,0.381
    run render "$out/zipmap.ztex" -o "$out/root.png" --view "$view" --size 396 --root-only
    run render "$out/zipmap.ztex" -o "$out/zipmap.png" --view "$view" --size 396
    run render "$out/full.ztex" -o "$out/full.png" --view "$view" --size 396
    "$python" tools/dev/demo.py row "$out" "$target"
    echo "$target"
}

mkdir -p "$out"
if [ "${1:-}" = --picture ]; then
    readme_picture "${2:?demo: --picture needs a file name}"
    exit
fi
[ $# -eq 0 ] || { printf 'demo: takes only --picture FILE\n' >&2; exit 1; }
[ -f "$photo" ] || { printf 'demo: %s is not there: ./dev setup installs mate-backgrounds\n' "$photo" >&2; exit 1; }

say "A zipmap: the photograph at an eighth, and details of it in full"
"$python" tools/dev/demo.py scene elephants "$photo" "$out"
run make "$out/scene.json" -o "$out/zipmap.ztex"

say "To compare: the whole photograph, and the root without patches"
run make "$photo" -o "$out/full.ztex" --name elephants --wrap clamp
run convert "$out/zipmap.ztex" -o "$out/root.ztex" --strip-patches

say "Is the file right, and what is in it?"
run validate "$out/zipmap.ztex"
run inspect "$out/zipmap.ztex"

say "Zooming in"
path=$("$python" tools/dev/demo.py path elephants)
render_path root "$out/zipmap.ztex" --root-only
render_path zipmap "$out/zipmap.ztex"
render_path full "$out/full.ztex"
run render "$out/zipmap.ztex" -o "$out/zoom.png" --zoom-path "$path" --frames 12 --sheet 4 --size 320x180
"$python" tools/dev/demo.py sheet "$out" "$frames"

say "What it costs, and what it gives"
"$python" tools/dev/demo.py report elephants "$out" "$ztex"
say "A heap of photographs: five of one thing, from near and from far, and one of another"
readonly heap=$out/heap
rm -rf "$heap"
"$python" tools/dev/demo.py heap "$heap"
run make zipmap "$heap"/*.jpg -o "$heap/heap.ztex" --scene-out "$heap/scene.json" --report "$heap/report.html"
run make zipmap "$heap"/*.jpg -o "$heap/again.ztex" --report "$heap/report.json" --quiet
cmp "$heap/heap.ztex" "$heap/again.ztex"
run validate "$heap/heap.ztex"
"$python" tools/dev/demo.py heap-report "$heap" report.json
path=$("$python" tools/dev/demo.py heap-path "$heap" report.json)
run render "$heap/heap.ztex" -o "$heap/zoom.png" --zoom-path "$path" --frames 12 --sheet 4 --size 320x180
printf '\nSee %s/zoom.png, a hundred times closer in twelve steps, and %s/report.html.\n' "$heap" "$heap"

say "Silmaps: a sign, a billboard and a control for a shader, whose edges stay sharp"
"$python" tools/dev/demo_silmap.py "$out/silmap" "$ztex"

say "Umbrellas: thousands of leaves out of five, from near, from far and in perspective; and all kinds of textures in one file"
"$python" tools/dev/demo_umbrella.py "$out/umbrellas" "$ztex"

printf '\nSee %s/sheet.png: columns zoom in; rows are the root alone, the zipmap, the whole texture.\n' "$out"
