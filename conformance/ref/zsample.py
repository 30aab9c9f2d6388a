# SPDX-License-Identifier: Apache-2.0
"""Looking up textures: images (spec/ztex.md section 12), zipmaps (spec/zipmap.md section 3), silmaps
(spec/silmap.md section 6), in binary64, step by step in the order of the texts. Umbrellas are in
zumbrella.py.

`look_up(z, texture, query)` gives the four linear, premultiplied channels of each layer,
`trace(z, texture, ray)` what a ray meets in umbrellas."""

import math
import struct
from dataclasses import dataclass, replace

import zsilmap
import zumbrella
from ztexref import FORMATS, IMAGE, NONE, SILMAP, UMBRELLAS, ZIPMAP, Image, Texture, Ztex
from zumbrella import CLAMP, MIRROR, REPEAT, into_unit

CLEAR = [0.0, 0.0, 0.0, 0.0]


@dataclass
class Query:
    u: float
    v: float
    du: tuple = (0.0, 0.0)         # for one step in x and for one in y
    dv: tuple = (0.0, 0.0)
    frame: int = 0                 # array layer
    filter: str = "trilinear"      # or bilinear, nearest
    light: object = None           # a zumbrella.Light, for umbrellas


# ---- texels: ztex.md section 12, step 1 ----------------------------------------------------------

def to_linear(transfer: int, v: float) -> float:
    if v < 0:
        return -to_linear(transfer, -v)
    if transfer in (2, 8):
        return v
    if transfer == 13:
        return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4
    if transfer in (4, 5):
        return v ** (2.2 if transfer == 4 else 2.8)
    raise ValueError("transfer %d is not for this sampler" % transfer)


def numbers(image: Image, raw: bytes) -> list:
    name, block, channels, _ = FORMATS[image.format]
    size = block[2] // channels
    if name.endswith("SFLOAT"):
        return list(struct.unpack("<%d%s" % (channels, {2: "e", 4: "f"}[size]), raw))
    assert name.endswith(("UNORM", "SRGB")) and block[:2] == (1, 1), name
    top = (1 << 8 * size) - 1
    return [int.from_bytes(raw[k * size:(k + 1) * size], "little") / top for k in range(channels)]


def texel(image: Image, level: int, frame: int, x: int, y: int) -> list:
    w, h, _ = image.extent(level)
    frame = min(frame, image.layers - 1)
    at = ((frame * h + y) * w + x) * image.block[2]
    c = numbers(image, image.decoded[level][at:at + image.block[2]])
    colour = [to_linear(image.transfer, v) for v in c[:3]] + [0.0] * (3 - len(c[:3]))
    alpha = c[3] if len(c) == 4 else 1.0
    if image.alpha_mode == 1:
        colour = [v * alpha for v in colour]
    return colour + [alpha]


# ---- images: steps 2 to 4 ------------------------------------------------------------------------

def log2_rho(q: Query, w: int, h: int) -> float:
    rho = max(math.hypot(q.du[k] * w, q.dv[k] * h) for k in range(2))
    return math.log2(rho) if rho > 0 else -math.inf


def wrapped(i: int, n: int, mode: int):
    """The index of a texel, None for the border."""
    if mode == REPEAT:
        return i % n
    if mode == MIRROR:
        m = i % (2 * n)
        return m if m < n else 2 * n - 1 - m
    if mode == CLAMP:
        return min(max(i, 0), n - 1)
    return i if 0 <= i < n else None


def fetch(image: Image, level: int, frame: int, x: int, y: int, wrap: tuple) -> list:
    w, h, _ = image.extent(level)
    x, y = wrapped(x, w, wrap[0]), wrapped(y, h, wrap[1])
    return CLEAR if x is None or y is None else texel(image, level, frame, x, y)


def nearest(image: Image, level: int, q: Query, wrap: tuple) -> list:
    w, h, _ = image.extent(level)
    return fetch(image, level, q.frame, math.floor(q.u * w), math.floor(q.v * h), wrap)


def bilinear(image: Image, level: int, q: Query, wrap: tuple) -> list:
    w, h, _ = image.extent(level)
    s, t = q.u * w - 0.5, q.v * h - 0.5
    i, j = math.floor(s), math.floor(t)
    f, g = s - i, t - j
    return zsilmap.mix(((1 - f, f)[a] * (1 - g, g)[b],
                        fetch(image, level, q.frame, i + a, j + b, wrap))
                       for a in (0, 1) for b in (0, 1))


def look_up_image(image: Image, q: Query, wrap: tuple) -> list:
    assert image.depth == 1 and image.layer_kind != 1
    last = image.levels - 1
    level = min(max(log2_rho(q, image.width, image.height), 0.0), float(last))
    if q.filter != "trilinear":
        one = nearest if q.filter == "nearest" else bilinear
        return one(image, math.floor(level + 0.5), q, wrap)
    k = math.floor(level)
    f = level - k
    return zsilmap.mix(((1 - f, bilinear(image, k, q, wrap)),
                        (f, bilinear(image, min(k + 1, last), q, wrap))))


# ---- silmaps: silmap.md section 6 ----------------------------------------------------------------

def parts(centre: float, extent: float, n: int, repeat: bool) -> list:
    """(cell, centre and half extent in the cell, length) of the pieces in one direction."""
    if extent == 0:
        i = min(math.floor(centre), n - 1)
        return [(i, centre - i, 0.0, 1.0)]
    low, high = centre - extent, centre + extent
    if not repeat:
        low, high = max(low, 0.0), min(high, float(n))
    out = []
    for i in range(math.floor(low), math.ceil(high)):
        a, b = max(low, i), min(high, i + 1)
        out.append((i % n, (a + b) / 2 - i, (b - a) / 2, b - a))
    return out


def corner_colours(image: Image, i: int, j: int, frame: int) -> dict:
    """Sample W is sample 0 where the texture repeats, where there are only W of them."""
    return {(a, b): texel(image, 0, frame, (i + a) % image.width, (j + b) % image.height)
            for a, b in zsilmap.CORNERS}


def silmap_value(z: Ztex, texture: Texture, layer: int, q: Query, at: tuple, wrap: tuple) -> list:
    """Step 3 for the point `at` in cells."""
    s = texture.silmap
    grid, image = s.grid, z.images[s.samples[layer]]
    ax = min((abs(q.du[0]) + abs(q.du[1])) * grid.width / 2, 0.5)
    ay = min((abs(q.dv[0]) + abs(q.dv[1])) * grid.height / 2, 0.5)
    if q.filter != "trilinear":
        ax = ay = 0.0
    kind = zsilmap.NEAREST if q.filter == "nearest" else s.filter
    total, sum_of_weights = CLEAR, 0.0
    for i, x, bx, length in parts(at[0], ax, grid.width, wrap[0] == REPEAT):
        for j, y, by, height in parts(at[1], ay, grid.height, wrap[1] == REPEAT):
            cell = grid.cell(i, j, min(q.frame, grid.layers - 1))
            corners = corner_colours(image, i, j, q.frame)
            one = zsilmap.part_value(kind, cell, corners, x, y, bx, by)
            total = zsilmap.mix(((1, total), (length * height, one)))
            sum_of_weights += length * height
    return [v / sum_of_weights for v in total]


def look_up_silmap(z: Ztex, texture: Texture, q: Query, wrap: tuple) -> list:
    grid = texture.silmap.grid
    u, v = into_unit(q.u, wrap[0]), into_unit(q.v, wrap[1])
    if u is None or v is None:
        return [CLEAR] * len(texture.images)
    inside = replace(q, u=u, v=v)
    level = log2_rho(q, grid.width, grid.height)
    out = []
    for layer, small in enumerate(texture.silmap.minified):
        weight = min(max(level + 1, 0.0), 1.0) if q.filter == "trilinear" else float(level > -0.5)
        weight = 0.0 if small == NONE else weight
        mixed = []
        if weight < 1:
            at = u * grid.width, v * grid.height
            mixed.append((1 - weight, silmap_value(z, texture, layer, q, at, wrap)))
        if weight > 0:
            mixed.append((weight, look_up_image(z.images[small], inside, wrap)))
        out.append(zsilmap.mix(mixed))
    return out


# ---- zipmaps: zipmap.md section 3 ----------------------------------------------------------------

def into_patch(m, q: Query):
    """The query in the coordinates of a patch, None outside of it."""
    x, y, w = (row[0] * q.u + row[1] * q.v + row[2] for row in m)
    if not w > 0 or not (0 <= x / w <= 1 and 0 <= y / w <= 1):
        return None
    px, py = x / w, y / w
    j = [[(m[r][c] - p * m[2][c]) / w for c in range(2)] for r, p in ((0, px), (1, py))]
    du, dv = (tuple(row[0] * q.du[k] + row[1] * q.dv[k] for k in range(2)) for row in j)
    return replace(q, u=px, v=py, du=du, dv=dv)


def look_up_patch(z: Ztex, patch: tuple, q: Query) -> tuple:
    """The layers of a patch as they are added, and its coverage."""
    _, kind, sources, mask, _ = patch
    clamped = (CLAMP, CLAMP)
    hidden = 1.0 if mask == NONE else look_up_image(z.images[mask], q, clamped)[0]
    if kind == 1:
        layers, f = look_up(z, z.textures[sources[0]], q, clamped), 1.0
    else:
        layers = [look_up_image(z.images[k], q, clamped) for k in sources]
        cover = z.images[sources[0] if mask == NONE else mask]
        f = min(max(cover.levels - log2_rho(q, cover.width, cover.height), 0.0), 1.0)
    own = layers[0][3] if kind == 1 or mask == NONE else 1.0
    coverage = f * own * hidden
    first = [f * hidden * v for v in layers[0]]
    return [first] + [[coverage * v for v in layer] for layer in layers[1:]], coverage


def look_up_zipmap(z: Ztex, texture: Texture, q: Query, wrap: tuple) -> list:
    u, v = into_unit(q.u, wrap[0]), into_unit(q.v, wrap[1])
    left, total = 1.0, [CLEAR] * len(texture.images)
    for patch in reversed(texture.zipmap[1:]) if u is not None and v is not None else ():
        inside = into_patch(patch[4], replace(q, u=u, v=v))
        if inside:
            layers, coverage = look_up_patch(z, patch, inside)
            total = [zsilmap.mix(((1, c), (left, layer))) for c, layer in zip(total, layers)]
            left *= 1 - coverage
    root = [look_up_image(z.images[k], q, wrap) for k in texture.zipmap[0][2]]
    return [zsilmap.mix(((1, c), (left, layer))) for c, layer in zip(total, root)]


# ---- umbrellas: the pictures for umbrella.md -----------------------------------------------------

def pictures(z: Ztex, frame: int, filter_: str):
    """What zumbrella.py looks bases and backgrounds up with. Of a texture it takes the first
    layer."""
    def look(kind, source, u, v, du, dv, wrap):
        q = Query(u, v, du, dv, frame, filter_)
        if kind == 1:
            return look_up(z, z.textures[source], q, wrap)[0]
        return look_up_image(z.images[source], q, wrap)
    return look


def look_up_umbrellas(z: Ztex, texture: Texture, q: Query, wrap: tuple) -> list:
    inner = zumbrella.Query(q.u, q.v, q.du, q.dv, wrap, q.filter, q.light)
    return [zumbrella.look_up(texture.umbrellas, inner, pictures(z, q.frame, q.filter))]


def trace(z: Ztex, texture: Texture, ray: zumbrella.Ray) -> zumbrella.Answer:
    return zumbrella.trace(texture.umbrellas, ray, pictures(z, 0, "trilinear"))


def sources(texture: Texture) -> tuple:
    """Images and textures that umbrellas name."""
    t = texture.umbrellas
    named = [(b.kind, b.source) for b in t.bases]
    if t.background_kind != zumbrella.COLOUR:
        named.append((t.background_kind - 1, t.background_source))
    return [k for kind, k in named if kind == 0], [k for kind, k in named if kind == 1]


def can_look_up(z: Ztex, texture: Texture) -> bool:
    """Whether this sampler knows the formats and kinds of the images that the texture names."""
    images, textures = texture.images, []
    if texture.kind == ZIPMAP:
        images = [k for _, kind, sources, _, _ in texture.zipmap if kind == 0 for k in sources]
        images += [mask for _, _, _, mask, _ in texture.zipmap if mask != NONE]
    elif texture.kind == SILMAP:
        images = texture.silmap.samples
    elif texture.kind == UMBRELLAS:
        images, textures = sources(texture)
    if not all(can_look_up(z, z.textures[k]) for k in textures):
        return False
    used = [z.images[k] for k in images]
    return all(i.format in FORMATS and FORMATS[i.format][1][:2] == (1, 1) and i.depth == 1
               and i.layer_kind != 1 for i in used)


def look_up(z: Ztex, texture: Texture, q: Query, wrap: tuple = None) -> list:
    """`wrap` replaces the texture's wrap modes: a patch of a zipmap clamps."""
    wrap = wrap or texture.wrap[:2]
    if texture.kind == ZIPMAP:
        return look_up_zipmap(z, texture, q, wrap)
    if texture.kind == SILMAP:
        return look_up_silmap(z, texture, q, wrap)
    if texture.kind == UMBRELLAS:
        return look_up_umbrellas(z, texture, q, wrap)
    assert texture.kind == IMAGE
    return [look_up_image(z.images[k], q, wrap) for k in texture.images]
