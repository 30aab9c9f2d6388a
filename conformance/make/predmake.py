# SPDX-License-Identifier: Apache-2.0
"""Tiles of codec 2, "pred" (spec/ztex.md section 6.4), written field by field.

`Pred` says how a tile is coded; `Pred.tile()` gives a `Tile`, whose `build()` makes the bytes. Any
field can be replaced on the way, as in ztexmake.py, by an override pred.I.U.N.FIELD:

    flags  table_count  coded  first  maps  zero_bits  table.T  padding  bits  states  words  stored

`Framed` and `FramedTile` are the same for tiles with a frame, with the fields

    flags  form  frame  stored

zero_bits, table.T and padding are strings of 0 and 1, the first bit first; first, maps, bits,
states, words and stored are bytes. An override changes what is written, not how the rest is
coded."""

from dataclasses import dataclass, field
from math import isqrt
from typing import Callable, Optional

LOW = 1 << 15                                         # where states start


def symbols(size: int) -> list:
    """All symbols in the order of the tables."""
    return sorted(range(256), key=lambda s: (min(s, 256 - s), s < 128)) if size == 1 else list(
        range(256))


def guess(a: int, b: int, c: int) -> int:
    """The prediction from left, above, above left."""
    return min(a, b) if c >= max(a, b) else max(a, b) if c <= min(a, b) else a + b - c


def coding_order(n: int) -> list:
    return [1, 0, 2, 3][:n] if n > 2 else [0, 1][:n]


def zigzag(r: int, bits: int) -> int:
    """r modulo 2^bits as sign and magnitude in one number."""
    return 2 * r if r < 1 << bits - 1 else 2 * ((1 << bits) - r) - 1


def table_bits(frequencies: dict, size: int) -> str:
    """A table; symbols that are not in `frequencies` have 0."""
    out, total, before = "", 0, 8
    for symbol in symbols(size):
        piece, before = frequency_bits(frequencies.get(symbol, 0), before)
        out += piece
        total += frequencies.get(symbol, 0)
        if total >= 2048:
            break
    return out


def frequency_bits(f: int, before: int) -> tuple:
    """One frequency, and the K that comes before the next."""
    k = (f + 1).bit_length() - 1
    d = k - before
    low = "".join(str(f + 1 >> bit & 1) for bit in range(k))
    return "0" * (2 * d if d >= 0 else -2 * d - 1) + "1" + low, k


def scaled(counts: dict) -> dict:
    """Frequencies that sum to 2048, at least 1 for each symbol that occurs."""
    total = sum(counts.values())
    if total == 0:
        return {0: 2048}
    out = {s: max(1, c * 2048 // total) for s, c in sorted(counts.items())}
    largest = max(out, key=out.get)
    out[largest] += 2048 - sum(out.values())
    return out


def texels_of(residuals, w: int, h: int, n: int, size: int, first: list) -> bytes:
    """The texels of a tile without the colour bit whose residuals are residuals(channel, x, y)."""
    mask = (1 << 8 * size) - 1
    v = [[[0] * w for _ in range(h)] for _ in range(n)]
    for c in range(n):
        for y in range(h):
            for x in range(w):
                at = lambda i, j: v[c][j][i] if i >= 0 and j >= 0 else 0
                p = first[c] if x + y == 0 else guess(at(x - 1, y), at(x, y - 1), at(x - 1, y - 1))
                v[c][y][x] = p + residuals(c, x, y) & mask
    return b"".join(v[c][y][x].to_bytes(size, "little") for y in range(h) for x in range(w)
                    for c in range(n))


def slope(r: int, g: int) -> int:
    """What the normal bit adds to channel 2."""
    s = 255 ** 2 - (2 * r - 255) ** 2 - (2 * g - 255) ** 2
    return 256 + isqrt(s) >> 1 if s > 0 else 128


def channel_values(how, w: int, h: int, data: bytes) -> list:
    """values[channel][y][x] without what the colour and normal bits add."""
    n, size = how.channels, how.size
    mask = (1 << 8 * size) - 1
    assert len(data) == w * h * n * size, (len(data), w, h, n, size)
    v = [[[int.from_bytes(data[((y * w + x) * n + c) * size:][:size], "little") for x in range(w)]
          for y in range(h)] for c in range(n)]
    for y in range(h):
        for x in range(w):
            r, g = v[0][y][x], v[1][y][x] if n > 1 else 0
            if how.colour:
                v[0][y][x] = r - g & mask
                v[2][y][x] = v[2][y][x] - g & mask
            if how.normal:
                v[2][y][x] = v[2][y][x] - slope(r, g) & mask
    return v


@dataclass
class Pred:
    """A choice of coding. Tables, maps and planes come from the texels where they are not given."""
    channels: int
    size: int = 1                      # bytes of a channel
    colour: bool = False
    normal: bool = False
    lane_code: int = 0
    table_count: int = 1
    zero_map: bool = False
    first: Optional[list] = None       # default: the first texel
    planes: Optional[list] = None      # coded planes; default: those that are not zero
    maps: Optional[list] = None        # 16 numbers for each coded plane
    tables: Optional[list] = None      # frequencies by symbol for each table

    def tile(self, w: int, h: int, data: bytes) -> "Tile":
        return Tile(self, w, h, data)


@dataclass
class Tile:
    how: Pred
    w: int
    h: int
    data: bytes
    samples: list = field(default_factory=list)       # samples[plane][y][x]
    sizes: list = field(default_factory=list)         # magnitudes[j][y][x]

    def split(self) -> list:
        """Fills samples and magnitudes; returns `first`."""
        how, w, h = self.how, self.w, self.h
        n, size = how.channels, how.size
        mask = (1 << 8 * size) - 1
        v = channel_values(how, w, h, self.data)
        first = how.first or [v[c][0][0] for c in range(n)]
        self.samples, self.sizes = [], []
        for c in coding_order(n):
            r = [[0] * w for _ in range(h)]
            for y in range(h):
                for x in range(w):
                    a = v[c][y][x - 1] if x else 0
                    b = v[c][y - 1][x] if y else 0
                    d = v[c][y - 1][x - 1] if x and y else 0
                    r[y][x] = v[c][y][x] - (first[c] if x + y == 0 else guess(a, b, d)) & mask
            if size == 1:
                self.samples.append(r)
                self.sizes.append([[min(i, 256 - i) for i in row] for row in r])
            else:
                z = [[zigzag(i, 16) for i in row] for row in r]
                self.samples += [[[i >> 8 for i in row] for row in z],
                                 [[i & 255 for i in row] for row in z]]
                self.sizes.append([[i.bit_length() for i in row] for row in z])
        return first

    def activity(self, plane: int, x: int, y: int) -> int:
        j = plane // self.how.size
        above = lambda i: self.sizes[j][y - 1][i] if y and 0 <= i < self.w else 0
        u = ((above(x - 1) + above(x + 1) + 1 >> 1) + above(x) + 1) >> 1
        if j:
            u = u + self.sizes[1 if j == 2 else 0][y][x] + 1 >> 1
        if self.how.size == 1 or plane % 2 == 0:
            return min(u, 15)
        return 15 if self.samples[plane - 1][y][x] else min(u, 14)

    def build(self, over=None, path: str = "") -> bytes:
        how, w, h = self.how, self.w, self.h
        get = (lambda name, value: over.get(path + "." + name, value)) if over else (
            lambda name, value: value)
        first = self.split()
        planes = how.planes
        if planes is None:
            planes = [k for k, rows in enumerate(self.samples) if any(map(any, rows))]
        tables = len(how.tables) if how.tables else how.table_count if planes else 0
        maps = how.maps or [[a * tables // 16 for a in range(16)] for _ in planes]
        # Blocks that are coded, and the samples in the order of decoding.
        zero_bits, coded = "", {}
        for plane in planes:
            for y in range(0, h, 8):
                for x in range(0, w, 64):
                    used = any(any(row[x:x + 64]) for row in self.samples[plane][y:y + 8])
                    coded[plane, x, y] = used or not how.zero_map
                    zero_bits += str(int(used)) if how.zero_map else ""
        steps = []                     # (lane, table, symbol)
        for y in range(h):
            for k, plane in enumerate(planes):
                for x in range(w):
                    if coded[plane, x - x % 64, y - y % 8]:
                        steps.append((x % (16 << how.lane_code), maps[k][self.activity(plane, x,
                            y)], self.samples[plane][y][x]))
        frequencies = how.tables
        if frequencies is None:
            counts = [{} for _ in range(tables)]
            for _, table, symbol in steps:
                counts[table][symbol] = counts[table].get(symbol, 0) + 1
            frequencies = [scaled(c) for c in counts]
        states, words = code(steps, frequencies, how.size, 16 << how.lane_code)
        # Fields.
        flags = how.colour | how.zero_map << 1 | how.lane_code << 2 | how.normal << 5
        if not planes:
            flags, states = how.colour | how.normal << 5, []
        out = b"".join(get(name, value).to_bytes(1, "little") for name, value in (
            ("flags", flags), ("table_count", tables), ("coded", sum(1 << k for k in planes))))
        out += get("first", b"".join(c.to_bytes(how.size, "little") for c in first))
        out += get("maps", bytes(m[k] | m[k + 1] << 4 for m in maps for k in range(0, 16, 2)))
        bits = get("zero_bits", zero_bits)
        for k, f in enumerate(frequencies):
            bits += get("table.%d" % k, table_bits(f, how.size))
        bits += get("padding", "0" * (-len(bits) % 8))
        out += get("bits", bytes(int(bits[k:k + 8][::-1], 2) for k in range(0, len(bits), 8)))
        out += get("states", b"".join(x.to_bytes(4, "little") for x in states))
        out += get("words", b"".join(x.to_bytes(2, "little") for x in words))
        return get("stored", out)


def code(steps: list, frequencies: list, size: int, lanes: int) -> tuple:
    """States and words for (lane, table, symbol), by going backwards."""
    starts = []
    for table in frequencies:
        assert sum(table.values()) == 2048, table
        start, below = {}, 0
        for symbol in symbols(size):
            start[symbol] = below
            below += table.get(symbol, 0)
        starts.append(start)
    states, words = [LOW] * lanes, []
    for lane, table, symbol in reversed(steps):
        f, x = frequencies[table][symbol], states[lane]
        if x >= f << 20:
            words.append(x & 0xFFFF)
            x >>= 16
        states[lane] = (x // f) * 2048 + x % f + starts[table][symbol]
    return states, words[::-1]


@dataclass
class Framed:
    """A choice of coding with a frame. `pack` makes the frame."""
    channels: int
    size: int = 1
    colour: bool = False
    normal: bool = False
    predictor: int = 0
    by_texel: bool = False
    pack: Optional[Callable] = None

    def tile(self, w: int, h: int, data: bytes) -> "FramedTile":
        return FramedTile(self, w, h, data)


@dataclass
class FramedTile:
    how: Framed
    w: int
    h: int
    data: bytes

    def samples(self) -> bytes:
        how, w, h = self.how, self.w, self.h
        n, size = how.channels, how.size
        mask = (1 << 8 * size) - 1
        v = channel_values(how, w, h, self.data)

        def residual(c, x, y):
            left, above = v[c][y][x - 1] if x else None, v[c][y - 1][x] if y else None
            guesses = [[], [left, above], [above, left]][how.predictor]
            p = next((g for g in guesses if g is not None), 0)
            r = v[c][y][x] - p & mask
            return zigzag(r, 16) if size == 2 else r
        places = [(x, y) for y in range(h) for x in range(w)]
        if how.by_texel:
            return b"".join(residual(c, x, y).to_bytes(size, "little") for x, y in places
                            for c in range(n))
        return b"".join(bytes(residual(c, x, y) >> 8 * k & 255 for x, y in places)
                        for c in coding_order(n) for k in reversed(range(size)))

    def build(self, over=None, path: str = "") -> bytes:
        how = self.how
        get = (lambda name, value: over.get(path + "." + name, value)) if over else (
            lambda name, value: value)
        out = get("flags", how.colour | 16 | how.normal << 5).to_bytes(1, "little")
        out += get("form", how.predictor | how.by_texel << 2).to_bytes(1, "little")
        out += get("frame", how.pack(self.samples()))
        return get("stored", out)
