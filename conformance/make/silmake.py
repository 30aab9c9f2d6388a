# SPDX-License-Identifier: Apache-2.0
"""Silmaps (spec/silmap.md), written field by field. Overrides (see ztexmake.py) are

    slmp.S.FIELD                    of the header
    slmp.S.PLANE.FIELD              of a plane: cells, samples, minified

A cell is made by `cell`, and `lawful` turns any bytes into cells that [R8206] and [R8207] allow."""

from dataclasses import dataclass, field

from ztexmake import NONE, Overrides, Plane, noise, plane_bytes, uint

REPEAT, MIRROR, CLAMP, BORDER = range(4)
CONTINUOUS, SEN2004, NEAREST = range(3)
NORTH, WEST = 128, 64


def cell(a: int = 4, b: int = 4, west: bool = False, north: bool = False) -> int:
    return north << 7 | west << 6 | b << 3 | a


UNCUT = cell()


def cut_arms(cells: list, w: int, h: int, wrap: tuple, i: int, j: int) -> str:
    """The arms of a cell of one layer that are stored as cut, of "NESW"."""
    def byte(x, y):
        if x == w and wrap[0] != REPEAT or y == h and wrap[1] != REPEAT:
            return UNCUT
        return cells[y % h * w + x % w]
    arms = (byte(i, j) & NORTH, byte(i + 1, j) & WEST, byte(i, j + 1) & NORTH, byte(i, j) & WEST)
    return "".join(name for name, bit in zip("NESW", arms) if bit)


def lawful(cells, w: int, h: int, wrap: tuple) -> list:
    """One layer: no arm that leaves the texture is cut, and cells without a cut have the byte
    0x24."""
    out = list(cells)
    for j in range(h):
        for i in range(w):
            if i == 0 and wrap[0] != REPEAT:
                out[j * w + i] &= ~WEST
            if j == 0 and wrap[1] != REPEAT:
                out[j * w + i] &= ~NORTH
    return [byte if cut_arms(out, w, h, wrap, k % w, k // w) else UNCUT
            for k, byte in enumerate(out)]


def scattered(w: int, h: int, wrap: tuple, seed: int) -> list:
    """A layer of cells with points and cuts anywhere."""
    return lawful(noise(w * h, seed), w, h, wrap)


@dataclass
class Silmap:
    cells_x: int
    cells_y: int
    cells: list                        # layer after layer
    samples: list
    minified: list = None              # default: none
    filter: int = CONTINUOUS
    cell_layers: int = 1
    planes: dict = field(default_factory=dict)  # cells, samples, minified -> Plane; "": others

    def __post_init__(self):
        if self.minified is None:
            self.minified = [NONE] * len(self.samples)

    def arrays(self) -> list:
        """(name, element size, values) of each plane in file order."""
        return [("cells", 1, self.cells), ("samples", 4, self.samples),
                ("minified", 4, self.minified)]

    def elements(self) -> bytes:
        return b"".join(bytes(values) if size == 1 else b"".join(uint(v, size) for v in values)
                        for _, size, values in self.arrays())

    def build(self, over: Overrides, s: int) -> bytes:
        out = over.pack("slmp.%d" % s, [
            ("cells_x", 4, self.cells_x), ("cells_y", 4, self.cells_y),
            ("cell_layers", 4, self.cell_layers), ("layer_count", 4, len(self.samples)),
            ("filter", 1, self.filter), ("reserved", 7, 0)])
        default = self.planes.get("", Plane())
        for name, size, values in self.arrays():
            out += plane_bytes(over, "slmp.%d.%s" % (s, name), size, values,
                               self.planes.get(name, default))
        return out
