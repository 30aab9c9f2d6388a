#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes valid/lookups.json and valid/rays.json: what lookups in files of the corpus give and what rays
meet there, computed by zsample.py. check.py compares them with the two files.

Places are random but always the same, and exact in binary32. One is left out where the result jumps
within 2^-20, so that readers with less precision can be compared; those on purpose on a line or a
side of a cell are exact for them too."""

import json
import math
import os
import sys
import zlib
from dataclasses import replace

sys.dont_write_bytecode = True

import zsample
import zsilmap
import ztexref
import zumbrella

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
VALID = os.path.join(ROOT, "valid")
ZIPMAPS = ("zip_patch", "zip_patch_levels", "zip_patch_npot_levels", "zip_patch_straight",
           "zip_rotation", "zip_reflection", "zip_homography", "zip_chain", "zip_mask",
           "zip_mask_other_size", "zip_layers", "zip_frames_static_patch", "zip_texture_source",
           "zip_texture_source_mask", "zip_texture_source_no_alpha", "zip_in_zip",
           "zip_texture_source_layers")
MANY = ("silmap_patterns_", "silmap_minified_", "silmap_wrap_", "silmap_extreme_", "silmap_in_")
OTHER_POINT = ("silmap_planes_", "silmap_1048576_", "silmap_65536_", "umbrella_planes_", "umbrella_far_",
               "umbrella_f32_", "umbrella_bases_", "umbrella_grid_8192", "umbrella_grid_1x8192",
               "umbrella_aspect_", "umbrella_base_corners", "umbrella_base_centre", "umbrella_several")
RAYS = ("umbrella_solid_", "umbrella_prism_", "umbrella_taper_", "umbrella_shift_", "umbrella_form",
        "umbrella_example", "umbrella_wrap_repeat_", "umbrella_wrap_mirror_mirror",
        "umbrella_wrap_border_clamp", "umbrella_background_", "umbrella_base_of_", "umbrella_levels_2",
        "umbrella_none_3x5", "umbrella_grid_7x5_", "umbrella_mirrored", "umbrella_colours_",
        "umbrella_morph_turns")
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
    return [rounded(layer) for layer in zsample.look_up(z, texture, q)]


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


def umbrella_jumps(z, texture, q) -> bool:
    """The same for umbrellas, whose derivatives decide too."""
    there = zsample.look_up(z, texture, q)[0]
    for a, b, c in ((1, 1, 1), (1, -1, -1), (-1, 1, 1), (-1, -1, -1)):
        scale = 1 + c * 2 ** -20
        beside = replace(q, u=q.u + a * 2 ** -20, v=q.v + b * 2 ** -20,
                         du=tuple(d * scale for d in q.du), dv=tuple(d * scale for d in q.dv))
        if max(abs(x - y) for x, y in zip(there, zsample.look_up(z, texture, beside)[0])) > 5e-4:
            return True
    return False


def light_of(random) -> zumbrella.Light:
    return zumbrella.Light(random.step(1.0), random.step(1.0), (1 + random.below(4)) / 4)


def umbrella_places(name: str, z, texture, count: int) -> list:
    random = Random(name)
    first = texture.umbrellas.levels[0] if texture.umbrellas else None
    unit = 2.0 ** -round(math.log2(max(first.width, first.height))) if first else 0.25
    out = []
    while len(out) < count:
        k = len(out)
        low, high = (-0.75, 1.75) if k % 3 == 2 else (0, 1)
        q = zsample.Query(random.between(low, high), random.between(low, high),
                          filter=FILTERS[max(0, k % 6 - 3)])
        scale = 2.0 ** (random.below(10) - 8) * unit
        q.du, q.dv = ((random.step(scale), random.step(scale)) for _ in range(2))
        if k % 7 == 3:
            q.du = q.dv = (0.0, 0.0)
        if first and k % 2:
            q.light = light_of(random)
        if max(image.layers for image in z.images) > 1:
            q.frame = random.below(4)
        if not umbrella_jumps(z, texture, q):
            out.append(q)
    return out


def far_apart(a, b) -> bool:
    """Whether two answers of rays differ by more than readers may."""
    pairs = list(zip(a.rgba, b.rgba)) + [(a.t, b.t)]
    return ((a.kind, a.umbrella) != (b.kind, b.umbrella) or max(abs(x - y) for x, y in pairs) > 5e-4
            or max(abs(x - y) for x, y in zip(a.normal, b.normal)) > 1e-2)


def ray_jumps(z, texture, ray) -> bool:
    there = zsample.trace(z, texture, ray)
    along = [b - a for a, b in zip(ray.start, ray.end)]
    if there.kind == 2 and sum(n * d for n, d in zip(there.normal, along)) > -1e-3 * math.hypot(*along):
        return True                    # seen from the side
    high = 2 ** -20 * texture.umbrellas.h
    for k in range(8):
        a, b, c = (2 ** -20 * (1 - 2 * (k >> n & 1)) for n in range(3))
        end = ray.end[2] + (c * texture.umbrellas.h if ray.end[2] > 0 else 0)
        beside = replace(ray, start=(ray.start[0] + a, ray.start[1] + b, max(0.0, ray.start[2] - high)),
                         end=(ray.end[0] + b, ray.end[1] + c, end),
                         footprints=tuple(v * (1 + a) for v in ray.footprints))
        if far_apart(there, zsample.trace(z, texture, beside)):
            return True
    return False


def some_ray(random, t) -> dict:
    """Most end on the ground, some beside or above it; two of three are aimed at an umbrella."""
    first = t.levels[0]
    long = (0.0, 0.5, 2.0, 4.0, 8.0)[random.below(5)]
    u1, v1 = random.between(-0.25, 1.25), random.between(-0.25, 1.25)
    u0, v0 = u1 + random.step(long / first.width), v1 + random.step(long / first.height)
    z0 = t.h * (4, 4, 4, 3, 2)[random.below(5)] / 4
    z1 = t.h / 8 * max(0, random.below(10) - 7)
    if random.below(3) and first.umbrellas and t.h > 0:
        aim = first.umbrellas[random.below(len(first.umbrellas))]
        x = (aim.centre[0] + random.step(0.5)) / first.width
        y = (aim.centre[1] + random.step(0.5)) / first.height
        z = min(aim.lift + aim.height / 2, z0 * 3 / 4)
        z1, on = 0.0, z0 / (z0 - z)
        u1, v1 = u0 + (x - u0) * on, v0 + (y - v0) * on
    u0, v0, u1, v1 = (round(x * 8192) / 8192 + 2.0 ** -15 for x in (u0, v0, u1, v1))
    wide = t.taper[1] * (1, 2, 4, 8, 12, 16, 24)[random.below(7)] / 16
    footprints = [wide * (16 + random.below(9)) / 16, wide * (16 + random.below(17)) / 16]
    if random.below(4) == 0:
        footprints[0] /= 4
    return {"u0": u0, "v0": v0, "z0": z0, "u1": u1, "v1": v1, "z1": z1, "footprint0": footprints[0],
            "footprint1": footprints[1]}


def ray_of(texture, e: dict):
    first = texture.umbrellas.levels[0]
    light = zumbrella.Light(e["light_x"], e["light_y"], e["shadow"]) if "shadow" in e else None
    return zumbrella.Ray((e["u0"] * first.width, e["v0"] * first.height, e["z0"]),
                         (e["u1"] * first.width, e["v1"] * first.height, e["z1"]),
                         (e["footprint0"], e["footprint1"]), texture.wrap[:2], light)


def light_fields(light) -> dict:
    return {"light_x": light.x, "light_y": light.y, "shadow": light.darkness} if light else {}


def rounded(values) -> list:
    return [float("%.7g" % (v + 0.0)) for v in values]


def rays_of(name: str, z, texture, count: int) -> list:
    random, out = Random("rays " + name), []
    kinds = {}
    while len(out) < count:
        e = some_ray(random, texture.umbrellas)
        if len(out) % 3 == 1:
            e.update(light_fields(light_of(random)))
        ray = ray_of(texture, e)
        if ray_jumps(z, texture, ray):
            continue
        a = zsample.trace(z, texture, ray)
        if a.kind == 0 and kinds.get(0, 0) >= count // 4:  # not too many that meet nothing
            continue
        kinds[a.kind] = kinds.get(a.kind, 0) + 1
        out.append({**e, "rgba": rounded(a.rgba), "normal": rounded(a.normal), "t": rounded([a.t])[0],
                    "kind": a.kind, "umbrella": a.umbrella})
    return out


def border_places(name: str, z, texture) -> list:
    """In each cell at a border, in every layer of cells."""
    random, grid = Random(name), texture.silmap.grid
    out = []
    for layer in range(grid.layers):
        for k in range(grid.width * grid.height):
            i, j = k % grid.width, k // grid.width
            leave = [arm for arm in zsilmap.TOWARDS if grid.neighbour(arm, i, j, layer) is None]
            if not leave or grid.layers > 8 and (k + layer) % 2:
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


def files(*prefixes) -> list:
    """Name and content of the valid files of these prefixes."""
    with open(os.path.join(VALID, "manifest.json"), encoding="utf-8") as f:
        names = [e["file"][:-5] for e in json.load(f)]
    out = []
    for name in names:
        if name.startswith(prefixes) and not name.startswith(OTHER_POINT):
            with open(os.path.join(VALID, name + ".ztex"), "rb") as f:
                out.append((name, ztexref.read(f.read())))
    return out


def queries_of(name: str, index: int, z, texture) -> list:
    own = "%s %d" % (name, index)
    if name.startswith("umbrella_"):
        return umbrella_places(own, z, texture, 10 if texture.umbrellas and index else 7)
    queries = places(own, z, texture, 14 if name.startswith(MANY) or name in ZIPMAPS else 6)
    if name.startswith("silmap_border_"):
        queries += border_places("border " + name, z, texture)
    if name.startswith("silmap_patterns_"):
        queries += exact_places(texture.silmap.grid)
    return queries


def entries() -> list:
    out = []
    for name, z in files("silmap_", "umbrella_", *ZIPMAPS):
        if name.startswith("zip_") and name not in ZIPMAPS:
            continue
        for index, texture in enumerate(z.textures):
            if not zsample.can_look_up(z, texture) or len(texture.images) > 8:
                continue
            if name.startswith("umbrella_") and index < len(z.textures) - 1:
                continue                                   # those that are only shown
            out += [{"file": name + ".ztex", "texture": index, "frame": q.frame, "filter": q.filter,
                     "at": [q.u, q.v, *q.du, *q.dv], **light_fields(q.light),
                     "layers": result(z, texture, q)} for q in queries_of(name, index, z, texture)]
    return out


def rays() -> list:
    out = []
    for name, z in files(*RAYS):
        index = len(z.textures) - 1
        texture = z.textures[index]
        if texture.umbrellas and zsample.can_look_up(z, texture):
            out.append({"file": name + ".ztex", "texture": index,
                        "rays": rays_of(name, z, texture, 20 if "solid" in name else 9)})
    return out


def main() -> int:
    lines = ",\n".join(json.dumps(e) for e in entries())
    with open(os.path.join(VALID, "lookups.json"), "w", encoding="utf-8") as f:
        f.write("[\n%s\n]\n" % lines)
    blocks = []
    for e in rays():
        lines = ",\n ".join(json.dumps(ray) for ray in e["rays"])
        blocks.append('{"file": "%s", "texture": %d, "rays": [\n %s]}' % (e["file"], e["texture"], lines))
    with open(os.path.join(VALID, "rays.json"), "w", encoding="utf-8") as f:
        f.write("[\n%s\n]\n" % ",\n".join(blocks))
    return 0


if __name__ == "__main__":
    sys.exit(main())
