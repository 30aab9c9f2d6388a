# SPDX-License-Identifier: Apache-2.0
"""Elements for umbrella textures, drawn by formulas: leaves, berries, peppers and flowers with their contours, as detailed as photographs of
them would be. One seed gives one picture.

    picture, contour = make('fall leaf', 63, 1)     256 x 256 RGBA, and vertices in the unit square, clockwise
"""
import math

import numpy

SIZE = 256
FILL = 0.48  # of the picture: the largest distance of the contour from the middle


def octave(rng, size, cells):
    """Smooth noise of so many cells, -1 to 1."""
    grid = rng.uniform(-1, 1, (cells + 2, cells + 2))
    at = numpy.linspace(0, cells, size, endpoint=False)
    low = at.astype(int)
    t = at - low
    t = t * t * t * (t * (6 * t - 15) + 10)
    rows = grid[low] * (1 - t)[:, None] + grid[low + 1] * t[:, None]
    return rows[:, low] * (1 - t)[None, :] + rows[:, low + 1] * t[None, :]


def noise(rng, first=4, octaves=6, gain=0.6):
    """Detail of all sizes down to the texel, as surfaces have it: standard deviation 1."""
    total = numpy.zeros((SIZE, SIZE))
    for i in range(octaves):
        total += gain ** i * octave(rng, SIZE, min(first << i, SIZE - 1))
    return total / total.std()


def polar(centre=(0.0, 0.0)):
    """x and y of texels, -1 to 1, then radius and angle about a point."""
    at = (numpy.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = numpy.meshgrid(at, at)
    return x, y, numpy.hypot(x - centre[0], y - centre[1]), numpy.arctan2(y - centre[1], x - centre[0])


def colours(shade, dark, middle, light):
    """Colours along a shade of 0 to 1, as coded."""
    stops = numpy.array([dark, middle, light], float)
    return numpy.stack([numpy.interp(shade, (0, 0.5, 1), stops[:, c]) for c in range(3)], -1)


def line(x, y, start, end, width):
    """How near a straight line is, 1 on it."""
    (x0, y0), (x1, y1) = start, end
    dx, dy = x1 - x0, y1 - y0
    t = (((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)).clip(0, 1)
    distance = numpy.hypot(x - x0 - t * dx, y - y0 - t * dy)
    return numpy.exp(-(distance / (width * (1.1 - t))) ** 2)


# --- the five kinds: a radius for each angle, and a surface ----------------------------------------


def fall_leaf(rng):
    lobes = [(-90, 1.0, 0.34), (-38, 0.92, 0.3), (-142, 0.92, 0.3), (16, 0.74, 0.3), (164, 0.74, 0.3)]
    lobes = [(math.radians(a + rng.uniform(-5, 5)), h * rng.uniform(0.92, 1.04), w) for a, h, w in lobes]
    teeth, phase = rng.integers(17, 23), rng.uniform(0, 6.28)

    def radius(angle):
        off = [numpy.abs(numpy.arctan2(numpy.sin(angle - a), numpy.cos(angle - a))) for a, _, _ in lobes]
        r = sum(h * numpy.exp(-(d / w) ** 2 * 1.6) for d, (_, h, w) in zip(off, lobes))
        return 0.36 + 0.62 * r + 0.05 * numpy.sin(teeth * angle + phase)

    def surface(scale):
        x, y, r, _ = polar()
        veins = numpy.zeros((SIZE, SIZE))
        for a, h, _ in lobes:
            end = (h * scale * math.cos(a), h * scale * math.sin(a))
            veins = numpy.maximum(veins, line(x, y, (0, 0.1), end, 0.022))
            for t in (0.3, 0.45, 0.6, 0.75):
                root = (end[0] * t, 0.1 + (end[1] - 0.1) * t)
                for side in (-0.6, 0.6):
                    tip = (root[0] + 0.24 * math.cos(a + side), root[1] + 0.24 * math.sin(a + side))
                    veins = numpy.maximum(veins, 0.6 * line(x, y, root, tip, 0.011))
        shade = 0.5 + 0.1 * noise(rng, 3) + 0.1 * (r - 0.5) + 0.22 * veins
        shade -= 0.35 * (noise(rng, 10, 3) > 1.9)  # spots
        hue = rng.uniform(0, 1)
        return colours(shade, (96, 34 + 40 * hue, 14), (188, 84 + 70 * hue, 26), (232, 176 + 30 * hue, 92))
    return radius, surface


def green_leaf(rng):
    slim, bend = rng.uniform(0.42, 0.6), rng.uniform(-0.1, 0.1)

    def radius(angle):
        x, y = numpy.cos(angle + bend), numpy.sin(angle + bend)
        return 1 / ((numpy.abs(x) / slim) ** 1.7 + numpy.abs(y) ** 1.7) ** (1 / 1.7) * (1 + 0.1 * (y < 0) * y ** 2)

    def surface(scale):
        x, y, _, _ = polar()
        veins = line(x, y, (0, scale), (0, -scale), 0.03)
        for t in numpy.linspace(-0.8, 0.85, 11):
            for side in (-1, 1):
                veins = numpy.maximum(veins, 0.7 * line(x, y, (0, t), (side * slim * 1.1, t - 0.34), 0.014))
        cells = numpy.abs(noise(rng, 24, 2, 0.5))
        shade = 0.42 + 0.09 * noise(rng, 3) + 0.32 * veins - 0.05 * cells
        return colours(shade, (18, 52, 14), (66, 122, 34), (168, 200, 96))
    return radius, surface


def berry(rng):
    bumps = [(k, rng.uniform(0, 6.28), rng.uniform(0, 0.05 / k)) for k in range(2, 7)]

    def radius(angle):
        return 1 + sum(a * numpy.sin(k * angle + p) for k, p, a in bumps)

    def surface(scale):
        x, y, r, angle = polar()
        height = numpy.sqrt((1 - (r / scale).clip(0, 1) ** 2))
        _, _, spot, _ = polar((-0.3 * scale, -0.35 * scale))
        _, _, crown, _ = polar((0.15 * scale, 0.1 * scale))
        shade = 0.16 + 0.42 * height + 0.05 * noise(rng, 4) + 0.03 * noise(rng, 64, 2)
        shade += 0.45 * numpy.exp(-(spot / (0.17 * scale)) ** 2)
        shade -= 0.2 * numpy.exp(-((crown - 0.12) / 0.035) ** 2) * (1 + 0.5 * numpy.sin(10 * angle))
        hue = rng.uniform(0, 1)
        return colours(shade, (40 + 30 * hue, 8, 24), (130 + 70 * hue, 18, 60 - 30 * hue), (250, 210, 220))
    return radius, surface


def pepper(rng):
    lobes, phase, slim = rng.integers(3, 5), rng.uniform(0, 6.28), rng.uniform(0.72, 0.9)

    def radius(angle):
        y = numpy.sin(angle)
        return (1 - 0.12 * numpy.cos(lobes * angle + phase)) / numpy.hypot(numpy.cos(angle) / slim, y) * (1 - 0.1 * y)

    def surface(scale):
        x, y, r, angle = polar()
        folds = numpy.cos(lobes * angle + phase)
        _, _, gloss, _ = polar((-0.35 * scale, -0.3 * scale))
        shade = 0.5 - 0.12 * folds * r + 0.06 * noise(rng, 3) + 0.025 * noise(rng, 48, 3) - 0.25 * (r / scale) ** 4
        shade += 0.4 * numpy.exp(-(gloss / (0.16 * scale)) ** 2)
        stem = numpy.exp(-(numpy.hypot(x, y + 0.5 * scale) / 0.13) ** 4)
        hue = rng.uniform(0, 1)
        skin = colours(shade, (110 - 50 * hue, 16 + 40 * hue, 8), (206 - 30 * hue, 44 + 110 * hue, 18), (255, 225, 180))
        return skin * (1 - stem)[..., None] + stem[..., None] * colours(shade, (30, 60, 16), (70, 120, 40), (150, 190, 90))
    return radius, surface


def flower(rng):
    petals, phase, deep = rng.integers(6, 10), rng.uniform(0, 6.28), rng.uniform(0.3, 0.5)

    def radius(angle):
        return 1 - deep * (1 - numpy.abs(numpy.cos((petals * angle + phase) / 2)) ** 0.6)

    def surface(scale):
        _, _, r, angle = polar()
        rays = numpy.cos(petals * angle + phase)
        streaks = octave(rng, SIZE, 20)[0][(numpy.abs(angle) / math.pi * (SIZE - 1)).astype(int)]
        shade = 0.45 + 0.3 * r + 0.12 * rays + 0.1 * streaks + 0.04 * noise(rng, 6)
        hue = rng.uniform(0, 1)
        petal = colours(shade, (120, 30 + 60 * hue, 90 + 50 * hue), (214, 96 + 90 * hue, 160 + 50 * hue), (252, 226, 240))
        heart = 1 / (1 + numpy.exp((r - 0.24 * scale) * 60))
        core = colours(0.5 + 0.25 * noise(rng, 40, 2), (120, 70, 10), (226, 170, 30), (252, 230, 120))
        return petal * (1 - heart)[..., None] + core * heart[..., None]
    return radius, surface


KINDS = {'fall leaf': fall_leaf, 'berry': berry, 'green leaf': green_leaf, 'pepper': pepper, 'flower': flower}


def make(kind, vertices, seed):
    rng = numpy.random.Generator(numpy.random.PCG64(seed))
    radius, surface = KINDS[kind](rng)
    angles = (numpy.arange(vertices) + 0.5) * 2 * math.pi / vertices - math.pi
    r = radius(angles)
    scale = FILL / r.max()
    contour = numpy.stack([0.5 + scale * r * numpy.cos(angles), 0.5 + scale * r * numpy.sin(angles)], -1)
    texels = surface(2 * FILL) + rng.normal(0, 1.2, (SIZE, SIZE, 1))  # and what a sensor adds
    picture = numpy.empty((SIZE, SIZE, 4), numpy.uint8)
    picture[..., :3] = texels.round().clip(0, 255)
    picture[..., 3] = 255
    return picture, contour
