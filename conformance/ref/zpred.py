# SPDX-License-Identifier: Apache-2.0
"""Codec 2, "pred", of spec/ztex.md section 6.4: the stored bytes of one tile to its texels, step by
step in the order of the text.

`decode(stored, w, h, n, size, unzstd)` returns the texels or raises `Broken`, which names the rule;
`unzstd(frame, content size)` decodes a frame (6.1). The work is bounded by the size of the tile
whatever the bytes are."""

import math


class Broken(Exception):
    def __init__(self, rule: str, text: str = ""):
        super().__init__("%s %s" % (rule, text))
        self.rule = rule


def need(condition, rule: str, text: str = ""):
    if not condition:
        raise Broken(rule, text)


def number(data: bytes, at: int, size: int) -> int:
    return int.from_bytes(data[at:at + size], "little")


def avg(a: int, b: int) -> int:
    return (a + b + 1) >> 1


# ---- bits, tables --------------------------------------------------------------------------------

class Bits:
    """Bits from the least significant bit of the byte `at` on."""

    def __init__(self, data: bytes, at: int):
        self.data, self.at = data, 8 * at

    def take(self) -> int:
        need(self.at < 8 * len(self.data), "R5306")
        self.at += 1
        return self.data[self.at - 1 >> 3] >> (self.at - 1 & 7) & 1

    def number(self, count: int) -> int:
        return sum(self.take() << k for k in range(count))

    def to_byte(self) -> int:
        """The place of the next whole byte; what lies before is zero."""
        while self.at & 7:
            need(self.take() == 0, "R5308")
        return self.at >> 3


def symbol_order(size: int) -> list:
    if size == 2:
        return list(range(256))
    out = [0]
    for k in range(1, 128):
        out += [256 - k, k]
    return out + [128]


def read_table(bits: Bits, size: int) -> list:
    """The table as 2048 slots: slot q is (symbol, its frequency, the slots before it)."""
    slots, before = [], 8
    for symbol in symbol_order(size):
        z = 0
        while not bits.take():
            z += 1
            need(z <= 22, "R5307", "z")
        k = before + (z >> 1 if z & 1 == 0 else -(z + 1 >> 1))
        need(0 <= k <= 11, "R5307", "K")
        f = (1 << k | bits.number(k)) - 1
        need(len(slots) + f <= 2048, "R5307", "sum above 2048")
        slots += [(symbol, f, len(slots))] * f
        before = k
        if len(slots) == 2048:
            return slots
    raise Broken("R5307", "sum below 2048")


# ---- one tile ------------------------------------------------------------------------------------

class Tile:
    def __init__(self, w: int, h: int, n: int, size: int):
        self.w, self.h, self.n, self.size = w, h, n, size
        # residuals[j][y][x], and their samples before they are put together: samples[plane][y][x]
        self.samples = [[[0] * w for _ in range(h)] for _ in range(n * size)]

    def residual(self, place: int, x: int, y: int) -> int:
        """The residual as the signed number nearest to zero; `place` is that in the order of
        coding."""
        if self.size == 1:
            r = self.samples[place][y][x]
            return r - 256 if r >= 128 else r
        z = self.samples[2 * place][y][x] << 8 | self.samples[2 * place + 1][y][x]
        return z >> 1 if z & 1 == 0 else -(z + 1 >> 1)

    def magnitude(self, place: int, x: int, y: int) -> int:
        if not (0 <= x < self.w and 0 <= y < self.h):
            return 0
        if self.size == 1:
            return abs(self.residual(place, x, y))
        z = self.samples[2 * place][y][x] << 8 | self.samples[2 * place + 1][y][x]
        return z.bit_length()

    def activity(self, plane: int, x: int, y: int) -> int:
        j = plane // self.size
        u = avg(avg(self.magnitude(j, x - 1, y - 1), self.magnitude(j, x + 1, y - 1)),
                self.magnitude(j, x, y - 1))
        if j > 0:
            u = avg(u, self.magnitude((0, 1, 0)[j - 1], x, y))
        if self.size == 2 and plane % 2 == 1:
            return 15 if self.samples[plane - 1][y][x] else min(u, 14)
        return min(u, 15)


def coding_order(n: int) -> tuple:
    """The channels in the order of the planes."""
    return (1, 0, 2, 3)[:n] if n >= 3 else (0, 1)[:n]


def restore(tile: Tile, first: list) -> list:
    """Channels from residuals: channels[c][y][x]."""
    w, h, n, size = tile.w, tile.h, tile.n, tile.size
    mask = (1 << 8 * size) - 1
    channels = [None] * n
    for place, channel in enumerate(coding_order(n)):
        rows = [[0] * w for _ in range(h)]
        for y in range(h):
            for x in range(w):
                a = rows[y][x - 1] if x else 0
                b = rows[y - 1][x] if y else 0
                c = rows[y - 1][x - 1] if x and y else 0
                p = first[channel] if x == y == 0 else a + b - max(min(a, b), min(c, max(a, b)))
                rows[y][x] = (p + tile.residual(place, x, y)) & mask
        channels[channel] = rows
    return channels


def third_component(r: int, g: int) -> int:
    """What the normal bit adds to channel 2."""
    s = 255 ** 2 - (2 * r - 255) ** 2 - (2 * g - 255) ** 2
    return (256 + math.isqrt(s)) >> 1 if s > 0 else 128


def texels(channels: list, size: int, flags: int) -> bytes:
    """Texels from channels, after what the colour and normal bits add."""
    mask = (1 << 8 * size) - 1
    out = bytearray()
    for rows in zip(*channels):
        for texel in map(list, zip(*rows)):
            if flags & COLOUR:
                texel[0] += texel[1]
                texel[2] += texel[1]
            if flags & NORMAL:
                texel[2] += third_component(texel[0], texel[1])
            out += b"".join((v & mask).to_bytes(size, "little") for v in texel)
    return bytes(out)


# ---- frames --------------------------------------------------------------------------------------

def frame_residuals(content: bytes, w: int, h: int, n: int, size: int, by_texel: bool):
    """residual(channel, x, y) of the content of a frame."""
    order = coding_order(n)

    def residual(channel: int, x: int, y: int) -> int:
        if by_texel:
            z = number(content, ((y * w + x) * n + channel) * size, size)
        else:
            plane = order.index(channel) * size
            z = 0
            for k in range(size):              # the high byte first
                z = z << 8 | content[(plane + k) * w * h + y * w + x]
        return z if size == 1 else (z >> 1) ^ -(z & 1)
    return residual


def decode_frame(stored: bytes, w: int, h: int, n: int, size: int, unzstd) -> bytes:
    flags = stored[0]
    need(flags & (ZERO_MAP | LANES) == 0, "R5313", "flags")
    need(len(stored) >= 2, "R5313", "no form")
    predictor, by_texel = stored[1] & 3, stored[1] & 4
    need(predictor != 3 and stored[1] < 8, "R5313", "form")
    content = unzstd(stored[2:], w * h * n * size)
    residual = frame_residuals(content, w, h, n, size, by_texel)
    mask = (1 << 8 * size) - 1
    channels = [[[0] * w for _ in range(h)] for _ in range(n)]
    for channel, rows in enumerate(channels):
        for y in range(h):
            for x in range(w):
                to_the_left = x > 0 if predictor == 1 else y == 0
                if predictor == 0 or x == y == 0:
                    p = 0
                else:
                    p = rows[y][x - 1] if to_the_left else rows[y - 1][x]
                rows[y][x] = (p + residual(channel, x, y)) & mask
    return texels(channels, size, flags)


# ---- a whole tile --------------------------------------------------------------------------------

COLOUR, ZERO_MAP, LANES, FRAME, NORMAL, RESERVED = 1, 2, 12, 16, 32, 192


def decode(stored: bytes, w: int, h: int, n: int, size: int, unzstd) -> bytes:
    need(len(stored) >= 1, "R5302", "cut")
    flags = stored[0]
    need(flags & RESERVED == 0, "R5302", "flags")
    need(not flags & COLOUR or n >= 3, "R5303", "colour")
    need(not flags & NORMAL or (n >= 3 and size == 1), "R5303", "normal")
    need(flags & (COLOUR | NORMAL) != COLOUR | NORMAL, "R5303", "both")
    if flags & FRAME:
        return decode_frame(stored, w, h, n, size, unzstd)
    need(len(stored) >= 3 + n * size, "R5302", "cut")
    table_count, coded = stored[1:3]
    zero_map, lane_code = flags >> 1 & 1, flags >> 2 & 3
    need(lane_code != 3 and coded >> n * size == 0, "R5302")
    first = [number(stored, 3 + k * size, size) for k in range(n)]
    at = 3 + n * size
    planes = [k for k in range(n * size) if coded >> k & 1]
    need(len(stored) >= at + 8 * len(planes), "R5302", "cut in maps")
    tile = Tile(w, h, n, size)
    if not planes:
        need(table_count == lane_code == zero_map == 0 and len(stored) == at, "R5304")
        return texels(restore(tile, first), size, flags)
    need(1 <= table_count <= 8, "R5304")
    maps = {}
    for plane in planes:
        maps[plane] = [stored[at + k // 2] >> 4 * (k % 2) & 15 for k in range(16)]
        need(max(maps[plane]) < table_count, "R5305")
        at += 8
    bits = Bits(stored, at)
    blocks = {}                        # (plane, column of blocks, row of blocks) -> coded
    for plane in planes:
        for y in range(0, h, 8):
            for x in range(0, w, 64):
                blocks[plane, x // 64, y // 8] = bits.take() if zero_map else 1
    tables = [read_table(bits, size) for _ in range(table_count)]
    at = bits.to_byte()
    lanes = 16 << lane_code
    need(len(stored) >= at + 4 * lanes, "R5309", "cut")
    states = [number(stored, at + 4 * k, 4) for k in range(lanes)]
    need(all(1 << 15 <= x < 1 << 31 for x in states), "R5309")
    at += 4 * lanes
    need((len(stored) - at) % 2 == 0, "R5310")
    for y in range(h):
        for plane in planes:
            for x in range(w):
                if not blocks[plane, x // 64, y // 8]:
                    continue
                state = states[x % lanes]
                q = state % 2048
                symbol, f, below = tables[maps[plane][tile.activity(plane, x, y)]][q]
                state = f * (state // 2048) + q - below
                if state < 1 << 15:
                    need(at < len(stored), "R5311", "no word left")
                    state = state << 16 | number(stored, at, 2)
                    at += 2
                states[x % lanes] = state
                tile.samples[plane][y][x] = symbol
    need(at == len(stored), "R5311", "words left")
    need(all(x == 1 << 15 for x in states), "R5312")
    return texels(restore(tile, first), size, flags)
