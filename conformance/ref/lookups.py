#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes valid/lookups.json: what lookups in files of the corpus give, computed by zsample.py.
check.py compares the two.

Places are random but always the same, and exact in binary32. One is left out where the result jumps
within 2^-20, so that readers with less precision can be compared; those on purpose on a line or a
side of a cell are exact for them too."""

import json
import math
import os
import sys
import zlib

sys.dont_write_bytecode = True

import zsample
import zsilmap
import ztexref

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
PATH = os.path.join(ROOT, "valid", "lookups.json")
ZIPMAPS = ("zip_patch", "zip_patch_levels", "zip_patch_npot_levels", "zip_patch_straight",
           "zip_rotation", "zip_reflection", "zip_homography", "zip_chain", "zip_mask",
           "zip_mask_other_size", "zip_layers", "zip_frames_static_patch", "zip_texture_source",
           "zip_texture_source_mask", "zip_texture_source_no_alpha", "zip_in_zip",
           "zip_texture_source_layers")
MANY = ("silmap_patterns_", "silmap_minified_", "silmap_wrap_", "silmap_extreme_", "silmap_in_")
OTHER_POINT = ("silmap_planes_", "silmap_1048576_", "silmap_65536_")
FILTERS = ("trilinear", "bilinear", "nearest")


class Random:
    """Numbers that depend on the name only."""

    def __init__(self, name: str):
        self.state = zlib.crc32(name.encode())

    def below(self, n: int) -> int:
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % (1 << 64)
        return (self.state >> 33) % n

    def between(self, low: float, high: float) -> float:
        """An odd multiple of 2^-13."""
        a, b = int(low * 4096), int(high * 4096)
        return (2 * (a + self.below(b - a)) + 1) / 8192

    def step(self, cells: float) -> float:
        """A derivative of up to so many cells."""
        return (self.below(2049) - 1024) / 1024 * cells


def result(z, texture, q) -> list:
    return [[float("%.7g" % (v + 0.0)) for v in layer] for layer in zsample.look_up(z, texture, q)]


def jumps(z, texture, q) -> bool:
    there = zsample.look_up(z, texture, q)
    for du, dv in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        beside = zsample.replace(q, u=q.u + du * 2 ** -20, v=q.v + dv * 2 ** -20)
        for a, b in zip(there, zsample.look_up(z, texture, beside)):
            if max(abs(x - y) for x, y in zip(a, b)) > 1e-3:
                return True
    return False


def places(name: str, z, texture, count: int) -> list:
    random = Random(name)
    grid = texture.silmap.grid if texture.silmap else None
    size = max(grid.width, grid.height) if grid else 4
    unit = 2.0 ** round(math.log2(1 / size))
    frames = max(image.layers for image in z.images)
    out = []
    while len(out) < count:
        k = len(out)
        q = zsample.Query(random.between(-0.75, 1.75), random.between(-0.75, 1.75),
                          filter=FILTERS[max(0, k % 6 - 3)])
        if k % 2:
            q.u, q.v = random.between(0, 1), random.between(0, 1)
        scale = (0.0, 0.25, 0.5, 0.75, 1.0, 2.0, 5.0)[random.below(7)] * unit
        q.du, q.dv = ((random.step(scale), random.step(scale)) for _ in range(2))
        if k % 5 == 4:                                     # a box with no height, or no width
            q.du, q.dv = ((0.0, 0.0), q.dv) if k % 10 == 4 else (q.du, (0.0, 0.0))
        q.frame = random.below(frames + 2) if frames > 1 else 0
        if not jumps(z, texture, q):
            out.append(q)
    return out


def exact_places(grid) -> list:
    """On points, arms and sides of cells, where W and H are powers of two."""
    out = []
    for k in range(0, grid.width * grid.height, 5):
        i, j = k % grid.width, k // grid.width
        cell = grid.cell(i, j, 0)
        for x, y in (cell.p, ((cell.p[0] + cell.n[0]) / 2, (cell.p[1] + cell.n[1]) / 2),
                     ((cell.p[0] + cell.e[0]) / 2, (cell.p[1] + cell.e[1]) / 2), (0.0, 0.0)):
            out.append(zsample.Query((i + x) / grid.width, (j + y) / grid.height,
                                     filter=FILTERS[k % 3]))
    return out


def border_places(name: str, z, texture) -> list:
    """In each cell at a border, in every layer of cells."""
    random, grid = Random(name), texture.silmap.grid
    out = []
    for layer in range(grid.layers):
        for k in range(grid.width * grid.height):
            i, j = k % grid.width, k // grid.width
            if grid.layers > 8 and (k + layer) % 2 or all(grid.neighbour(arm, i, j, layer) is not None for arm in zsilmap.TOWARDS):
                continue
            q = None
            while q is None or jumps(z, texture, q):
                q = zsample.Query((i + random.between(0, 1)) / grid.width,
                                  (j + random.between(0, 1)) / grid.height, frame=layer)
                scale = (0.0, 0.25, 0.5, 0.75, 1.0)[random.below(5)]
                unit = 2.0 ** round(math.log2(scale / max(grid.width, grid.height))) if scale else 0.0
                q.du, q.dv = ((random.step(unit), random.step(unit)) for _ in range(2))
                q.u, q.v = (round(x * 65536) / 65536 for x in (q.u, q.v))
            out.append(q)
    return out


def entries() -> list:
    with open(os.path.join(ROOT, "valid", "manifest.json"), encoding="utf-8") as f:
        names = [e["file"][:-5] for e in json.load(f)]
    out = []
    for name in names:
        if not (name in ZIPMAPS or name.startswith("silmap_")) or name.startswith(OTHER_POINT):
            continue
        with open(os.path.join(ROOT, "valid", name + ".ztex"), "rb") as f:
            z = ztexref.read(f.read())
        for index, texture in enumerate(z.textures):
            if not zsample.can_look_up(z, texture) or len(texture.images) > 8:
                continue
            count = 14 if name.startswith(MANY) or name in ZIPMAPS else 6
            queries = places("%s %d" % (name, index), z, texture, count)
            if name.startswith("silmap_border_"):
                queries += border_places("border " + name, z, texture)
            if name.startswith("silmap_patterns_"):
                queries += exact_places(texture.silmap.grid)
            out += [{"file": name + ".ztex", "texture": index, "frame": q.frame, "filter": q.filter,
                     "at": [q.u, q.v, *q.du, *q.dv], "layers": result(z, texture, q)}
                    for q in queries]
    return out


def main() -> int:
    lines = ",\n".join(json.dumps(e) for e in entries())
    with open(PATH, "w", encoding="utf-8") as f:
        f.write("[\n%s\n]\n" % lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
