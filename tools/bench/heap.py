#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Heaps of photographs whose truth is known: pictures of one flat thing, from near and from far, and pictures of other things.

    heap.py KIND SEED FOLDER [--pictures N] [--width PIXELS]

The thing is a real photograph (Debian packages, PHOTOS below) with others on it as posters, so that there is real detail to come
closer to. A virtual camera looks at it through a homography: any rotation, perspective, and its own exposure, white balance,
vignetting, blur, noise and JPEG. Everything is averaged over a pixel's area, in linear light. FOLDER gets the pictures, and truth.json:
for each its role, its parent and the matrix from the parent's coordinates (0 to 1) to its own. Equal seeds give equal pictures.
FOLDER appears when all is there. Until then pictures are in FOLDER.part, where the next run goes on if this one is stopped.

Kinds: 2x, 4x, 8x, 12x (how much finer a child is than its parent), chain (to 100x in steps), mixed.
"""
import argparse
import functools
import hashlib
import json
import math
import os
import shutil
import sys
import time
from dataclasses import dataclass, field

import numpy
import skimage.data
from PIL import Image

MATE = '/usr/share/backgrounds/mate/'
PLASMA = '/usr/share/wallpapers/%s/contents/images/2560x1600.jpg'
PHOTOS = [MATE + 'abstract/Elephants_5640x3172.jpg', '/usr/share/backgrounds/Kleiber_by_Lukas_Baubkus.jpg',
          *[PLASMA % name for name in ('EveningGlow', 'FallenLeaf', 'OneStandsOut', 'Path', 'ColorfulCups')],
          MATE + 'nature/Garden.jpg', MATE + 'nature/Wood.jpg', MATE + 'nature/RainDrops.jpg', MATE + 'nature/Dune.jpg',
          MATE + 'nature/YellowFlower.jpg', MATE + 'nature/LadyBird.jpg']
FACTORS = {'2x': 2.0, '4x': 4.0, '8x': 8.0, '12x': 12.0}
# Pixels across the root. A zoom of 12x that is 1600 pixels wide is 130 wide in its parent.
WIDTHS = {'2x': 1000, '4x': 1200, '8x': 1600, '12x': 2000, 'chain': 1400, 'mixed': 2000}
CHAIN = (4.8, 4.6, 4.6)  # 101.6 together
LONGEST = 5700           # pixels of a photograph's edge that are kept
SUPERSAMPLE = 2          # lookups along each side of a pixel
CHUNK = 2 ** 14          # lookups at a time that fit the cache
BAND = 2 ** 19           # lookups or values that are held at once, beside the photographs and one picture
DETAIL = 0.006           # see detail_at
MOST_ROWS = 1000         # that it looks at all of
MARGIN = 0.04            # of the parent, that a child keeps away from its edge
LEAST = 1.1, 0.6         # a parent is at least so much coarser, and contains this share


# --- linear light --------------------------------------------------------------------------------------------


def decode(values):
    return numpy.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode(values):
    values = numpy.clip(values, 0, 1)
    return numpy.where(values <= 0.0031308, values * 12.92, 1.055 * values ** (1 / 2.4) - 0.055)


TABLE = decode(numpy.arange(256) / 255).astype(numpy.float32)


def halve(picture):
    """Each texel the mean of two by two; a last odd row or column stays out."""
    h, w = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
    even = picture[:h, :w]
    return (even[0::2, 0::2] + even[1::2, 0::2] + even[0::2, 1::2] + even[1::2, 1::2]) / 4


class Photo:
    """A picture in linear light with its pyramid."""

    def __init__(self, pixels):
        self.levels = [TABLE[pixels]]
        while min(self.levels[-1].shape[:2]) >= 8:
            self.levels.append(halve(self.levels[-1]))
        self.height, self.width = pixels.shape[:2]

    @classmethod
    @functools.lru_cache(maxsize=None)
    def load(cls, path):
        picture = Image.open(path).convert('RGB')
        if max(picture.size) > LONGEST:
            picture.thumbnail((LONGEST, LONGEST), Image.Resampling.BOX)
        return cls(numpy.asarray(picture))

    def look_up(self, u, v, footprint):
        """Bilinear lookups at u, v in [0, 1], out of the level whose texels are no smaller than the footprint (in texels of level 0)."""
        level = min(max(0, math.ceil(math.log2(max(footprint, 1)))), len(self.levels) - 1)
        texels = self.levels[level]
        height, width = texels.shape[:2]
        # Levels leave odd edges out, so that a texel is exactly 2^level texels of level 0.
        x = numpy.clip(u * (self.width / 2 ** level) - 0.5, 0, width - 1.001)
        y = numpy.clip(v * (self.height / 2 ** level) - 0.5, 0, height - 1.001)
        left, top = x.astype(numpy.int32), y.astype(numpy.int32)
        fx, fy = (x - left).astype(numpy.float32)[:, None], (y - top).astype(numpy.float32)[:, None]
        flat, at = texels.reshape(-1, 3), top * width + left
        out = numpy.empty((at.size, 3), numpy.float32)
        for i in range(0, at.size, CHUNK):
            part = slice(i, i + CHUNK)
            a, x, y = at[part], fx[part], fy[part]
            upper = flat.take(a, 0) * (1 - x) + flat.take(a + 1, 0) * x
            lower = flat.take(a + width, 0) * (1 - x) + flat.take(a + width + 1, 0) * x
            out[part] = upper * (1 - y) + lower * y
        return out


# --- homographies --------------------------------------------------------------------------------------------


def apply(matrix, x, y):
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    return (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / w, (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / w


def corner_error(truth, found, size):
    """Pixels between where the corners of a picture of this size are and where they belong. Matrices as nine numbers."""
    back = numpy.array(truth).reshape(3, 3) @ numpy.linalg.inv(numpy.array(found).reshape(3, 3))
    x, y = numpy.array([0, 1, 1, 0.0]), numpy.array([0, 0, 1, 1.0])
    u, v = apply(back, x, y)
    return float(numpy.hypot((u - x) * size[0], (v - y) * size[1]).max())


def density(matrix, x, y):
    """How much a length grows at x, y."""
    step = 1e-6
    (x0, y0), (x1, y1), (x2, y2) = (apply(matrix, *p) for p in ((x, y), (x + step, y), (x, y + step)))
    return math.sqrt(abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0))) / step


def placement(centre, width, aspect, angle, tilt):
    """Unit square to a rectangle of this width about centre: turned by angle, seen from a side by tilt (two numbers)."""
    unit = numpy.array([[1, 0, -0.5], [0, aspect, -0.5 * aspect], [0, 0, 1]])
    seen = numpy.array([[1, 0, 0], [0, 1, 0], [tilt[0], tilt[1], 1]])
    c, s = math.cos(angle) * width, math.sin(angle) * width
    return numpy.array([[c, -s, centre[0]], [s, c, centre[1]], [0, 0, 1]]) @ seen @ unit


def grid(n=9):
    across, down = numpy.meshgrid((numpy.arange(n) + 0.5) / n, (numpy.arange(n) + 0.5) / n)
    return across.ravel(), down.ravel()


# --- the thing, and the camera -------------------------------------------------------------------------------


@dataclass
class World:
    """Layers from below: a photograph, and where it lies: world coordinates to its own. The first one is 1 wide."""
    layers: list = field(default_factory=list)
    walls: list = field(default_factory=list)  # views of what repeats, which no other view may show

    @classmethod
    def of(cls, photo):
        return cls([(photo, numpy.diag([1.0, photo.width / photo.height, 1.0]))])

    def aspect(self):
        return self.layers[0][0].height / self.layers[0][0].width

    def paste(self, photo, to_world):
        self.layers.append((photo, numpy.linalg.inv(to_world)))

    def seen(self, x, y):
        """Numbers of the layers that a convex quadrilateral can show, when its corners are given."""
        numbers = [0]
        for number, (_, matrix) in enumerate(self.layers[1:], 1):
            w = matrix[2] @ [x, y, numpy.ones(x.size)]
            if w.min() <= 0 <= w.max():  # over the horizon of what is far away
                numbers.append(number)
                continue
            u, v = apply(matrix, x, y)
            if u.min() >= 0 and u.max() <= 1 and v.min() >= 0 and v.max() <= 1:
                numbers = []  # nothing below
            if u.max() >= 0 and u.min() <= 1 and v.max() >= 0 and v.min() <= 1:
                numbers.append(number)
        return numbers

    def look_up(self, x, y, spacing, numbers=None):
        """Colours at world coordinates; spacing is the distance of neighbouring lookups. numbers: of the layers to look at."""
        out = numpy.zeros((x.size, 3), numpy.float32)
        for number in range(len(self.layers)) if numbers is None else numbers:
            photo, matrix = self.layers[number]
            u, v = apply(matrix, x, y)
            inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1) if number else numpy.ones(x.size, bool)
            if not inside.any():
                continue
            middle = numpy.flatnonzero(inside)[inside.sum() // 2]
            grows = density(matrix, x[middle], y[middle]) * math.sqrt(photo.width * photo.height)
            out[inside] = photo.look_up(u[inside], v[inside], spacing * grows)
        return out


@dataclass
class View:
    """One photograph to be taken: unit square to world coordinates, and how the camera was set."""
    to_world: numpy.ndarray
    width: int
    height: int
    camera: dict
    role: str = 'child'
    parent: int = -1
    world: World = None

    def pixels_per_length(self, x, y):
        """At a place of the world."""
        u, v = apply(numpy.linalg.inv(self.to_world), x, y)
        return math.sqrt(self.width * self.height) / density(self.to_world, u, v)

    def centre(self):
        return apply(self.to_world, 0.5, 0.5)


def settings(random, strong=True):
    """Exposure up to half a stop up or down, white balance, vignetting, blur, noise, JPEG quality."""
    reach = 1.0 if strong else 0.25
    return {'gain': 2.0 ** (random.uniform(-0.5, 0.3) * reach),
            'balance': [1 + random.uniform(-0.1, 0.1) * reach, 1.0, 1 + random.uniform(-0.1, 0.1) * reach],
            'vignette': random.uniform(0, 0.3) * reach, 'blur': random.uniform(0.3, 0.7),
            'noise': random.uniform(0.5, 2.0) / 255, 'quality': int(random.integers(88, 97))}


def blur_rows(picture, sigma):
    radius = max(1, math.ceil(3 * sigma))
    kernel = numpy.exp(-0.5 * (numpy.arange(-radius, radius + 1) / sigma) ** 2)
    kernel = (kernel / kernel.sum()).astype(numpy.float32)
    padded = numpy.pad(picture, ((radius, radius), (0, 0), (0, 0)), 'edge')
    return sum(kernel[k] * padded[k:k + picture.shape[0]] for k in range(2 * radius + 1))


def expose(view):
    """The picture in linear light, before the camera."""
    n, out = SUPERSAMPLE, numpy.empty((view.height, view.width, 3), numpy.float32)
    spacing = 1 / (view.pixels_per_length(*view.centre()) * n)
    u = (numpy.arange(view.width * n) + 0.5) / (view.width * n)
    band = max(1, BAND // (view.width * n * n))
    for y in range(0, view.height, band):
        rows = min(band, view.height - y)
        v = (numpy.arange(y * n, (y + rows) * n) + 0.5) / (view.height * n)
        uu, vv = numpy.meshgrid(u, v)
        x, z = apply(view.to_world, uu.ravel(), vv.ravel())
        corners = [0, len(u) - 1, -len(u), -1]
        fine = view.world.look_up(x, z, spacing, view.world.seen(x[corners], z[corners])).reshape(rows, n, view.width, n, 3)
        out[y:y + rows] = fine.mean((1, 3))
    return out


def blurred(picture, y, rows, sigma):
    """Rows of the picture after the lens."""
    radius = max(1, math.ceil(3 * sigma))
    top, bottom = max(y - radius, 0), min(y + rows + radius, picture.shape[0])
    part = blur_rows(picture[top:bottom], sigma)[y - top:y - top + rows]
    return blur_rows(part.transpose(1, 0, 2), sigma).transpose(1, 0, 2)


def bands(view):
    """First row and number of rows."""
    step = max(1, BAND // view.width)
    return [(y, min(step, view.height - y)) for y in range(0, view.height, step)]


def noise(view, random, rows):
    return random.normal(0, view.camera['noise'], (rows, view.width, 3))


def take(view, random):
    """The picture as 8-bit pixels."""
    c, picture, out = view.camera, expose(view), numpy.empty((view.height, view.width, 3), numpy.uint8)
    x = (numpy.arange(view.width, dtype=numpy.float32) + 0.5) / view.width - 0.5
    y = ((numpy.arange(view.height, dtype=numpy.float32) + 0.5) / view.height - 0.5)[:, None] * view.height / view.width
    for first, rows in bands(view):
        part = picture[first:first + rows]
        part *= (1 - c['vignette'] * (x * x + y[first:first + rows] ** 2) / 0.5)[..., None]
        part *= numpy.array(c['balance'], numpy.float32) * c['gain']
    for first, rows in bands(view):
        coded = encode(blurred(picture, first, rows, c['blur'])) + noise(view, random, rows)
        out[first:first + rows] = (numpy.clip(coded, 0, 1) * 255 + 0.5).astype(numpy.uint8)
    return out


def skip(view, random):
    """Leaves chance as take() does."""
    for _, rows in bands(view):
        noise(view, random, rows)


# --- heaps ---------------------------------------------------------------------------------------------------


def contained(view, other):
    """Share of view's area that lies inside other."""
    u, v = apply(numpy.linalg.inv(other.to_world) @ view.to_world, *grid())
    return float(((u > 0) & (u < 1) & (v > 0) & (v < 1)).mean())


def parent_of(view, views):
    """The finest of the coarser pictures that contain it."""
    best, finest = -1, math.inf
    for i, other in enumerate(views):
        if other is view or other.world is not view.world:
            continue
        ratio = view.pixels_per_length(*view.centre()) / other.pixels_per_length(*view.centre())
        if LEAST[0] < ratio < finest and contained(view, other) >= LEAST[1]:
            best, finest = i, ratio
    return best


def is_inside(view, other, margin=MARGIN):
    u, v = apply(numpy.linalg.inv(other.to_world) @ view.to_world, numpy.array([0, 1, 1, 0.0]), numpy.array([0, 0, 1, 1.0]))
    return bool(((u > margin) & (u < 1 - margin) & (v > margin) & (v < 1 - margin)).all())


def detail_at(world, view, parent):
    """How much is to be seen of the view in its parent: mean second difference of the parent's pixels there. What is smooth, as all
    that is out of focus, cannot be found again by anybody."""
    n = max(8, round(view.width * parent.pixels_per_length(*view.centre()) / view.pixels_per_length(*view.centre())))
    # Of what is large, some rows with their neighbours.
    v = numpy.arange(n)[None] if n <= MOST_ROWS else (numpy.arange(64)[:, None] * (n - 3) // 63 + numpy.arange(3))
    uu, vv = numpy.meshgrid((numpy.arange(n) + 0.5) / n, (v.ravel() + 0.5) / n)
    x, y = apply(view.to_world, uu.ravel(), vv.ravel())
    grey = encode(world.look_up(x, y, 1 / parent.pixels_per_length(*view.centre()))).mean(1).reshape(*v.shape, n)
    return float(numpy.abs(numpy.diff(grey, 2, axis=1)).mean() + numpy.abs(numpy.diff(grey, 2, axis=2)).mean())


def zoom(random, world, parent, factor, width, poster, cover=(1.15, 1.5)):
    """A view that shows a part of parent factor times as fine; with a poster pasted there first, when one is given, which is
    as much wider as cover says."""
    before = len(world.layers)
    for _ in range(200):
        height = int(width * random.uniform(0.66, 0.8))
        u, v = random.uniform(0.08, 0.92, 2)
        centre = apply(parent.to_world, u, v)
        angle = random.uniform(0, 2 * math.pi) if random.uniform() < 0.5 else random.normal(0, 0.15)
        size = width / (factor * parent.pixels_per_length(*centre))
        view = View(placement(centre, size, height / width, angle, random.uniform(-0.12, 0.12, 2)), width, height,
                    settings(random), world=world)
        if not is_inside(view, parent):
            continue
        if poster:
            frame = placement(centre, size * random.uniform(*cover), poster.height / poster.width, random.normal(0, 0.2),
                              random.uniform(-0.05, 0.05, 2))
            if not is_inside(View(frame, poster.width, poster.height, {}), parent, 0.01):
                continue
            world.paste(poster, frame)
        if detail_at(world, view, parent) > DETAIL:
            return view
        del world.layers[before:]
    raise NoPlace()


def add_zoom(random, views, parent, factor, width, posters):
    """Appends a zoom into views[parent] whose parent, among all the views, is that one."""
    for _ in range(50):
        world = views[parent].world
        before = len(world.layers)
        chosen = int(random.integers(len(posters))) if posters else -1
        view = zoom(random, world, views[parent], factor, width, posters[chosen] if posters else None)
        others = views + [view]
        # A poster changes what views that are there show: it may only lie in coarser ones.
        clear = all(parent_of(v, others) == v.parent for v in views if v.role != 'root') and all(
            contained(view, wall) == 0 for wall in world.walls)
        untouched = before == len(world.layers) or not any(touches(world.layers[-1][1], v, views, parent) for v in views)
        if clear and untouched and parent_of(view, others) == parent and apart(view, views, parent):
            view.parent = parent
            views.append(view)
            if posters:
                posters.pop(chosen)
            return
        del world.layers[before:]
    raise NoPlace()


def add_trap(random, views, width):
    """A wall of bricks that repeat exactly, and a view that shows one period of it: it fits in a dozen places."""
    brick = numpy.asarray(Image.open(os.path.join(os.path.dirname(skimage.data.__file__), 'brick.png')).convert('RGB'))
    wall = Photo(numpy.tile(brick, (4, 4, 1)))
    for _ in range(50):
        world = views[0].world
        before = len(world.layers)
        view = zoom(random, world, views[0], 10, width // 2, wall, (3.2, 3.4))
        if not any(touches(world.layers[-1][1], other, views, 0) for other in views):
            view.role, view.parent = 'trap', 0
            views.append(view)
            wall_to_world = numpy.linalg.inv(world.layers[-1][1])
            world.walls.append(View(wall_to_world, wall.width, wall.height, {}))
            return
        del world.layers[before:]
    raise NoPlace()


def ancestors(views, index):
    while index >= 0:
        yield index
        index = views[index].parent


def touches(to_photo, view, views, parent):
    """Would this poster be seen by a view that is no ancestor of its zoom?"""
    if any(views[i] is view for i in ancestors(views, parent)):
        return False
    u, v = apply(to_photo @ view.to_world, *grid(16))
    return bool(((u > 0) & (u < 1) & (v > 0) & (v < 1)).any())


def apart(view, views, parent):
    """Siblings do not lie upon each other."""
    return all(contained(view, other) < 0.45 and contained(other, view) < 0.45
               for other in views if other.parent == parent and other.world is view.world)


def factors_of(kind, random, count):
    """Parent index and factor for each child."""
    if kind == 'chain':
        plan = [(i, factor) for i, factor in enumerate(CHAIN)]
        return (plan + [(int(random.integers(0, 3)), random.uniform(2, 5)) for _ in range(count)])[:count]
    if kind == 'mixed':
        return [(0, 12.0), (0, 4.0), (2, 3.0)][:count] + [(0, random.uniform(2, 12)) for _ in range(count - 3)]
    factor = FACTORS[kind]
    # Few zooms of 2x have room beside each other: the others go into the first ones.
    flat = count if factor > 4 else 3 if factor < 4 else 6
    return [(0 if i < flat else 1 + i - flat, factor * random.uniform(0.96, 1.04)) for i in range(count)]


def make_world(random, photos):
    """The base and the posters that may be pasted on it, best detail last."""
    base, *rest = [Photo.load(photos[i]) for i in random.permutation(len(photos))]
    return World.of(base), rest


class NoPlace(Exception):
    """Chance has led into a corner where the next view fits nowhere."""


def make_views(kind, seed, pictures, width, photos):
    for attempt in range(50):
        random = numpy.random.default_rng([seed, attempt, *kind.encode()])
        try:
            return try_views(random, kind, seed, pictures, width, photos), random
        except NoPlace:
            continue
    raise RuntimeError(f'{kind} {seed}: no room for {pictures} pictures')


def try_views(random, kind, seed, pictures, width, photos):
    order = [photos[i] for i in random.permutation(len(photos))]
    if kind == '2x':  # no poster fits, so the photograph needs pixels of its own
        order.sort(key=lambda path: path != photos[seed % 2])
    world, posters = make_world(random, order[:max(3, len(order) - 3)])
    strangers = max(1, pictures // 5)
    aspect = world.aspect()
    root = View(placement((0.5, aspect / 2), 0.96, aspect, random.normal(0, 0.01), random.uniform(-0.02, 0.02, 2)), width,
                round(width * aspect), settings(random, False), 'root', world=world)
    views = [root]
    if kind == 'mixed':
        add_trap(random, views, round(width * 0.8))
    for parent, factor in factors_of(kind, random, pictures - strangers - len(views)):
        parent += (kind == 'mixed' and parent > 0)  # behind the trap
        # Only photographs of many pixels have detail left where a zoom ends; elsewhere a poster brings it. Into a zoom of 2x
        # none fits.
        fine = views[parent].pixels_per_length(*views[parent].centre()) * factor
        needs = fine > 1.5 * world.layers[0][0].width and factor > 3
        add_zoom(random, views, parent, factor, round(width * random.uniform(0.7, 0.85)), posters if needs else [])
    for k in range(strangers):  # pictures of other things
        other = World.of(Photo.load(order[-1 - k % 3]))
        size = random.uniform(0.2, 0.9)
        views.append(View(placement((0.5, other.aspect() / 2), size, 0.75, random.normal(0, 0.1), (0, 0)), round(width * 0.8),
                          round(width * 0.6), settings(random), 'distractor', world=other))
    return views


def truth_of(views, names):
    root = views[0]
    records = []
    for view, name in zip(views, names):
        record = {'file': name, 'role': view.role, 'size': [view.width, view.height], 'camera': view.camera}
        if view.parent >= 0:
            own = numpy.linalg.inv(view.to_world)
            matrix, whole = own @ views[view.parent].to_world, own @ root.to_world
            record.update(parent=names[view.parent], matrix=(matrix / matrix[2, 2]).ravel().tolist(),
                          root_matrix=(whole / whole[2, 2]).ravel().tolist(),
                          ratio=view.pixels_per_length(*view.centre()) / views[view.parent].pixels_per_length(*view.centre()),
                          root_ratio=view.pixels_per_length(*view.centre()) / root.pixels_per_length(*view.centre()))
        records.append(record)
    return records


class Progress:
    """On a terminal: how far the work is, in the last line."""

    def __init__(self, what, total):
        self.what, self.total, self.begin = what, total, time.monotonic()

    def show(self, done):
        if sys.stderr.isatty():
            print(f'\r{self.what}: {done} of {self.total} pictures, {time.monotonic() - self.begin:.0f} s', end='', file=sys.stderr, flush=True)

    def end(self):
        if sys.stderr.isatty():
            print('\r\033[K', end='', file=sys.stderr, flush=True)


def open_part(folder, recipe):
    """FOLDER.part, with what an earlier run left there when it was about the same pictures."""
    part, stamp = f'{folder}.part', os.path.join(f'{folder}.part', 'recipe')
    if os.path.isdir(folder) and os.listdir(folder):
        raise FileExistsError(f'{folder} is there already')
    if os.path.exists(stamp):
        with open(stamp, encoding='ascii') as file:
            if file.read() == recipe:
                return part
    shutil.rmtree(part, ignore_errors=True)
    os.makedirs(part)
    with open(stamp, 'w', encoding='ascii') as file:
        file.write(recipe)
    return part


def write_pictures(part, views, names, random, progress):
    fresh = os.path.join(part, 'unfinished')
    for number, (view, name) in enumerate(zip(views, names)):
        progress.show(number)
        path = os.path.join(part, name)
        if os.path.exists(path):
            skip(view, random)
            continue
        Image.fromarray(take(view, random)).save(fresh, 'JPEG', quality=view.camera['quality'], subsampling=0)
        os.replace(fresh, path)
    progress.end()


def make_heap(kind, seed, folder, pictures=12, width=None, photos=None):
    """Writes the heap, whole or not at all; returns what truth.json says."""
    width, photos, folder = width or WIDTHS[kind], photos or PHOTOS, os.fspath(folder).rstrip('/')
    with open(os.path.abspath(__file__), 'rb') as file:
        recipe = hashlib.sha256(file.read() + repr([kind, seed, pictures, width, photos]).encode()).hexdigest()
    part = open_part(folder, recipe)
    views, random = make_views(kind, seed, pictures, width, photos)
    # Neither the names nor their order shall help.
    names = [f'IMG_{number:04d}.jpg' for number in random.permutation(9000)[:len(views)] + 1000]
    write_pictures(part, views, names, random, Progress(os.path.basename(folder), len(views)))
    truth = {'kind': kind, 'seed': seed, 'pictures': truth_of(views, names)}
    with open(os.path.join(part, 'truth.json'), 'w', encoding='utf-8') as file:
        json.dump(truth, file, indent=1)
    os.remove(os.path.join(part, 'recipe'))
    os.replace(part, folder)
    return truth


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('kind', choices=list(WIDTHS))
    parser.add_argument('seed', type=int)
    parser.add_argument('folder')
    parser.add_argument('--pictures', type=int, default=12)
    parser.add_argument('--width', type=int, help='of the root; the others are a little narrower')
    words = parser.parse_args()
    truth = make_heap(words.kind, words.seed, words.folder, words.pictures, words.width)
    for record in truth['pictures']:
        print(record['file'], record['role'], record.get('parent', ''), f"{record.get('ratio', 1):.2f}", record['size'])


if __name__ == '__main__':
    main()
