#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A zipmap that `ztex extract --dzi` has cut into tiles is opened with OpenSeadragon in a browser without a screen, and each view
# compared with what `ztex render` draws of the same rectangle. Pictures of both, and the figures, go to build/audit/openseadragon.
#
#     ./dev audit openseadragon
#
# OpenSeadragon, and what drives the browser, come from npm in the versions of openseadragon/package-lock.json. node (20 or later) and npm
# must be there: Debian's packages nodejs and npm, or others.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."

source=$PWD/tools/dev/audit/openseadragon
folder=$PWD/build/audit/openseadragon
ztex=$PWD/build/release/tools/ztex/ztex
photo=/usr/share/backgrounds/mate/abstract/Elephants_5640x3172.jpg

say() {
    printf '==> %s\n' "$*"
}

# The photograph, reduced, with a part of it in more detail: 4096 texels wide in the end.
make_pyramid() {
    cat >"$folder/scene.json" <<SCENE
{"textures": [{"name": "wall", "wrap": "clamp", "patches": [
    {"image": {"file": "$photo", "crop": [0, 0, 5640, 2820], "resize": [2048, 1024]}},
    {"image": {"file": "$photo", "crop": [2820, 705, 1410, 705], "resize": [1024, 512]},
     "offset": [0.5, 0.25], "scale": [0.25, 0.25], "ramp": 16}]}]}
SCENE
    "$ztex" make "$folder/scene.json" -o "$folder/wall.ztex" -q --no-fsync
    "$ztex" extract "$folder/wall.ztex" --dzi "$folder/wall.dzi" --format png -q
}

command -v npm >/dev/null || {
    echo 'audit openseadragon: npm is missing (Debian: apt-get install nodejs npm)' >&2
    exit 1
}
rm -rf "$folder"
mkdir -p "$folder"
cp "$source"/package.json "$source"/package-lock.json "$folder"
say "fetching OpenSeadragon into $folder"
(cd "$folder" && npm ci --no-audit --no-fund --loglevel error)
say "building ztex"
cmake --preset release >/dev/null
cmake --build build/release --target ztex -- --quiet
say "making and cutting a zipmap"
make_pyramid
say "opening it"
(cd "$folder" && NODE_PATH=$folder/node_modules node "$source/view.js" "$folder")
say "comparing"
/usr/bin/python3 "$source/compare.py" "$ztex" "$folder"
