#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The parts of the demo that are easier in Python: the scene, the contact sheet with its labels, and the figures.

    demo.py scene NAME PHOTO FOLDER     FOLDER/scene.json
    demo.py path NAME                   the zoom path, as `ztex render --zoom-path` wants it
    demo.py sheet FOLDER FRAMES         FOLDER/sheet.png of root_NNNN.png, zipmap_NNNN.png, full_NNNN.png
    demo.py heap FOLDER                 a heap of photographs and truth.json
    demo.py heap-path FOLDER REPORT     the zoom path into the finest photograph of the heap
    demo.py heap-report FOLDER REPORT   what was found, against the truth; fails when the graph is not the right one
    demo.py row FOLDER TARGET           one row of root.png, zipmap.png, full.png, as JPEG
    demo.py report NAME FOLDER ZTEX     tables of bytes and of errors; fails when a goal is missed
"""
import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass

import numpy
from PIL import Image, ImageDraw, ImageFont

RAMP = 8     # texels over which a patch fades in
MARGIN = 16  # texels from a patch's edge where errors are not measured: the ramp and its filter
GOAL_DB = 45
GOAL_BYTES = 1.10  # times what the whole texture spends on the same regions at the same resolutions


@dataclass
class Detail:
    name: str
    rect: tuple      # x, y, width, height in pixels of the photograph
    shrink: int = 1  # 2: stored at half the photograph's resolution
    parent: str = ''


@dataclass
class Work:
    size: tuple
    shrink: int  # of the root
    details: list
    target: tuple  # x, y, width, height where the zoom ends

    def rect(self, name):
        return next((d.rect for d in self.details if d.name == name), (0, 0, *self.size))


WORKS = {
    'elephants': Work((5640, 3172), 8, [
        Detail('head', (2700, 560, 1240, 1060), shrink=2),
        Detail('eye', (3110, 820, 560, 400), parent='head'),
        Detail('tusk', (3200, 1660, 360, 440)),
        Detail('trunk', (2880, 1880, 460, 520)),
        Detail('toes', (2140, 2240, 300, 280)),
        Detail('calf', (2040, 1200, 360, 260)),
        Detail('wrinkles', (1900, 1540, 340, 260)),
        Detail('flame', (560, 1900, 500, 300)),
    ], target=(3190, 910, 320, 180)),
    'astronaut': Work((512, 512), 8, [
        Detail('face', (160, 24, 140, 160)),
    ], target=(139, 8, 187, 187)),
}


# --- the scene -------------------------------------------------------------------------------------


def make_scene(work, name, photo, folder):
    """Each patch lies exactly where its crop was in the photograph, however large the root or the parent is stored."""
    width, height = work.size
    root = {'file': photo, 'resize': [round(width / work.shrink), round(height / work.shrink)]}
    patches = [{'name': 'root', 'image': root}]
    for detail in work.details:
        x, y, w, h = detail.rect
        px, py, pw, ph = work.rect(detail.parent)
        image = {'file': photo, 'crop': list(detail.rect)}
        if detail.shrink > 1:
            image['resize'] = [w // detail.shrink, h // detail.shrink]
        patches.append({'name': detail.name, 'image': image, 'parent': detail.parent or 'root',
                        'ramp': RAMP, 'separate_mask': True,
                        'offset': [(x - px) / pw, (y - py) / ph], 'scale': [w / pw, h / ph]})
    scene = {'comment': 'Written by tools/dev/demo.py.',
             'textures': [{'name': name, 'wrap': 'clamp', 'patches': patches}]}
    with open(os.path.join(folder, 'scene.json'), 'w', encoding='utf-8') as file:
        json.dump(scene, file, indent=2)
        file.write('\n')


def view_of(work, rect):
    (width, height), (x, y, w, h) = work.size, rect
    return ','.join(repr(v) for v in (x / width, y / height, (x + w) / width, (y + h) / height))


# --- the sheet -------------------------------------------------------------------------------------

ROWS = [('root', 'root alone'), ('zipmap', 'zipmap'), ('full', 'whole texture')]


def font(size):
    try:
        return ImageFont.truetype('DejaVuSans.ttf', size)
    except OSError:
        return ImageFont.load_default()


def label(draw, xy, text, size, **how):
    draw.text(xy, text, fill=(40, 40, 40), font=font(size), **how)


def make_sheet(folder, frames):
    pictures = [[Image.open(os.path.join(folder, f'{name}_{i + 1:04d}.png')) for i in range(frames)]
                for name, _ in ROWS]
    w, h = pictures[0][0].size
    gap, left, top = 6, 150, 34
    sheet = Image.new('RGB', (left + frames * (w + gap), top + len(ROWS) * (h + gap)), (250, 250, 248))
    draw = ImageDraw.Draw(sheet)
    for r, (_, text) in enumerate(ROWS):
        label(draw, (10, top + r * (h + gap) + h // 2 - 10), text, 18)
        for i, picture in enumerate(pictures[r]):
            sheet.paste(picture, (left + i * (w + gap), top + r * (h + gap)))
    for i in range(frames):
        label(draw, (left + i * (w + gap), 8), f'step {i + 1}', 16)
    sheet.save(os.path.join(folder, 'sheet.png'))


def make_row(folder, target):
    pictures = [Image.open(os.path.join(folder, f'{name}.png')).convert('RGB') for name, _ in ROWS]
    w, h = pictures[0].size
    gap, top = 6, 28
    row = Image.new('RGB', (len(pictures) * (w + gap) - gap, h + top), (255, 255, 255))
    draw = ImageDraw.Draw(row)
    for i, picture in enumerate(pictures):
        row.paste(picture, (i * (w + gap), top))
        size = os.path.getsize(os.path.join(folder, 'full.ztex' if i == 2 else 'zipmap.ztex')) / 1024
        label(draw, (i * (w + gap) + 2, 4), ROWS[i][1] + (f', {size:.0f} KiB' if i else ''), 16)
    row.save(target, quality=88, optimize=True)


# --- figures ---------------------------------------------------------------------------------------


def psnr(a, b):
    error = numpy.mean((a.astype(float) - b.astype(float)) ** 2)
    return math.inf if error == 0 else 10 * math.log10(255 ** 2 / error)


def render(ztex, folder, file, work, rect, size, *options):
    name = os.path.join(folder, 'measured.png')
    subprocess.run([ztex, 'render', os.path.join(folder, file), '-o', name, '--view', view_of(work, rect), '--size',
                    f'{size[0]}x{size[1]}', *options], check=True)
    pixels = numpy.asarray(Image.open(name))
    os.remove(name)
    return pixels


def measure(work, detail, folder, ztex):
    """Errors against the whole texture, at the patch's own resolution, inside its ramp."""
    x, y, w, h = detail.rect
    edge = MARGIN * detail.shrink
    rect = (x + edge, y + edge, w - 2 * edge, h - 2 * edge)
    size = (rect[2] // detail.shrink, rect[3] // detail.shrink)
    truth = render(ztex, folder, 'full.ztex', work, rect, size)
    return (psnr(render(ztex, folder, 'zipmap.ztex', work, rect, size), truth),
            psnr(render(ztex, folder, 'zipmap.ztex', work, rect, size, '--root-only'), truth))


def decibel(value):
    return 'exact' if math.isinf(value) else f'{value:.1f} dB'


def tile_bytes(level, edge, rect):
    """Bytes that the tiles of a level spend on a rectangle of it, each tile in proportion to what it shares with it."""
    x0, y0, x1, y1 = rect
    across = -(-level['width'] // edge)
    total = 0.0
    for number, tile in enumerate(level['tiles']):
        left, top = number % across * edge, number // across * edge
        right, bottom = min(left + edge, level['width']), min(top + edge, level['height'])
        shared = max(0, min(right, x1) - max(left, x0)) * max(0, min(bottom, y1) - max(top, y0))
        total += tile['stored_size'] * shared / ((right - left) * (bottom - top))
    return total


def bytes_of_the_same(work, folder, ztex):
    """What the whole texture spends on what root and patches show: the same regions, from the same resolution down."""
    out = subprocess.run([ztex, 'inspect', '--json', '--tiles', os.path.join(folder, 'full.ztex')], check=True,
                         capture_output=True).stdout
    report = json.loads(out)
    image = (report[0] if isinstance(report, list) else report)['images'][0]
    total = 0.0
    for shrink, (x, y, w, h) in [(work.shrink, (0, 0, *work.size))] + [(d.shrink, d.rect) for d in work.details]:
        for k, level in enumerate(image['levels']):
            if 2 ** k >= shrink and not level['tail']:
                scale = 2 ** k
                total += tile_bytes(level, image['tile_edge'], (x / scale, y / scale, (x + w) / scale, (y + h) / scale))
    return total


def report_bytes(work, folder, ztex):
    full = os.path.getsize(os.path.join(folder, 'full.ztex'))
    print(f'{"":26}{"bytes":>12}{"of the whole":>14}')
    for file, text in (('full.ztex', 'whole texture'), ('root.ztex', 'root alone'), ('zipmap.ztex', 'zipmap')):
        size = os.path.getsize(os.path.join(folder, file))
        print(f'{text:26}{size:12,}{100 * size / full:13.1f} %')
    same = bytes_of_the_same(work, folder, ztex)
    print(f'{"the same in the whole":26}{same:12,.0f}{100 * same / full:13.1f} %')
    return size <= same * GOAL_BYTES


def report_errors(work, folder, ztex):
    good = True
    print(f'\nPSNR against the whole texture inside the patches, at their resolution\n'
          f'{"patch":12}{"pixels":>12}{"stored at":>12}{"zipmap":>12}{"root alone":>12}')
    for detail in work.details:
        zipmap, root = measure(work, detail, folder, ztex)
        print(f'{detail.name:12}{detail.rect[2]:>7} x {detail.rect[3]:<4}{"1 / " + str(detail.shrink):>10}'
              f'{decibel(zipmap):>12}{decibel(root):>12}')
        # A patch at another resolution is another filtering of the photograph, not a copy.
        good &= detail.shrink > 1 or zipmap >= GOAL_DB
    return good


def report(work, folder, ztex):
    small = report_bytes(work, folder, ztex)
    close = report_errors(work, folder, ztex)
    print(f'\nat most {GOAL_BYTES:.2f} times what the whole texture spends on the same: {"yes" if small else "NO"}; '
          f'at least {GOAL_DB} dB in patches of full resolution: {"yes" if close else "NO"}')
    return 0 if small and close else 1


# --- a heap of photographs -------------------------------------------------------------------------

MATE = '/usr/share/backgrounds/mate/'
HEAP_PHOTOS = [MATE + name for name in ('abstract/Elephants_3840x2160.jpg', 'nature/Garden.jpg', 'nature/Dune.jpg',
                                        'nature/GreenMeadow.jpg', 'nature/RainDrops.jpg', 'nature/YellowFlower.jpg')]
HEAP_SEED = 2
HEAP_ERROR = 1.0  # pixels of a photograph that its corners may be off


def heap_generator():
    sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'bench'))
    import heap
    return heap


def load(*path):
    with open(os.path.join(*path), encoding='utf-8') as file:
        return json.load(file)


def heap_path(folder, report):
    """From the whole root to the middle of the finest photograph."""
    photos = load(folder, report)['photographs']
    views = []
    for photo in photos:
        if photo['state'] == 'placed':
            back = numpy.linalg.inv(numpy.array(photo['root_matrix']).reshape(3, 3))
            corners = back @ numpy.array([[0, 1, 1, 0], [0, 0, 1, 1], [1, 1, 1, 1.0]])
            u, v = corners[:2] / corners[2]
            size = 0.35 * min(numpy.ptp(u), numpy.ptp(v))
            views.append((size, u.mean(), v.mean()))
    size, u, v = min(views)
    return f'0,0,1,1;{u - size},{v - size},{u + size},{v + size}'


def heap_report(folder, report):
    heap, found, good = heap_generator(), load(folder, report), True
    photos = {os.path.basename(p['file']): p for p in found['photographs']}
    print(f'{"photograph":16}{"is":>12}{"parent":>16}{"finer":>9}{"corner error":>17}')
    for picture in load(folder, 'truth.json')['pictures']:
        photo = photos[picture['file']]
        parent = os.path.basename(found['photographs'][photo['parent']]['file']) if photo['parent'] is not None else ''
        expected = {'child': 'placed', 'distractor': 'unplaced', 'root': 'root'}[picture['role']]
        good &= photo['state'] == expected and parent == picture.get('parent', '')
        error = ''
        if picture['role'] == 'child' and photo['state'] == 'placed':
            off = heap.corner_error(picture['root_matrix'], photo['root_matrix'], picture['size'])
            good &= off <= HEAP_ERROR * picture['root_ratio'] / picture['ratio']
            error = f'{photo["ratio"]:8.2f}x{off:10.2f} pixels'
        print(f'{picture["file"]:16}{photo["state"]:>12}{parent:>16}{error}')
    print(f'\nthe right graph, and corners less than {HEAP_ERROR:.0f} pixel of the parent off: {"yes" if good else "NO"}')
    return 0 if good else 1


def main(words):
    verb, rest = words[0], words[1:]
    if verb == 'scene':
        make_scene(WORKS[rest[0]], rest[0], os.path.abspath(rest[1]), rest[2])
    elif verb == 'path':
        work = WORKS[rest[0]]
        print(f'0,0,1,1;{view_of(work, work.target)}')
    elif verb == 'sheet':
        make_sheet(rest[0], int(rest[1]))
    elif verb == 'row':
        make_row(*rest)
    elif verb == 'heap':
        heap_generator().make_heap('chain', HEAP_SEED, rest[0], 6, 800, HEAP_PHOTOS)
    elif verb == 'heap-path':
        print(heap_path(*rest))
    elif verb == 'heap-report':
        return heap_report(*rest)
    elif verb == 'report':
        return report(WORKS[rest[0]], rest[1], rest[2])
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
