#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The demo's page of silmaps: a sign, an alpha billboard, and a mask that switches between two materials, each at three magnifications beside
an ordinary texture of the same size.

    demo_silmap.py FOLDER ZTEX      FOLDER/sheet.png, with all that it is made of beside it; fails when a goal is missed
"""
import json
import os
import subprocess
import sys

import numpy
from PIL import Image

import demo

SIGN = '/usr/share/iso-flags-svg/country-4x3/ke.svg'
FONT = '/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf'
FLOWER = 'U+2740'
PHOTOS = {name: demo.MATE + f'nature/{name}.jpg' for name in ('Aqua', 'Dune', 'GreenMeadow')}
PANEL = (320, 240)
GOAL_DB = 6  # above a bilinear texture of the same grid, 16 times enlarged

# A tree as a drawing program would make it: a few flat shapes, and nothing where there is no tree.
TREE = '''<svg xmlns="http://www.w3.org/2000/svg" width="120" height="160" viewBox="0 0 120 160">
<path d="M54 150 C57 130 57 110 55 92 L40 78 L44 75 L57 86 L60 60 L65 60 L66 84 L80 70 L83 74 L67 92 C65 110 66 130 70 150 Z" fill="#6b4a2f"/>
<path d="M60 12 C72 6 86 14 86 26 C100 26 108 40 102 50 C114 58 108 76 94 76 C90 88 74 88 68 80 C60 90 44 88 40 78 C26 82 14 70 20 58
C10 48 18 32 32 32 C32 16 48 8 60 12 Z" fill="#2f6b2c"/>
<path d="M58 20 C68 14 78 20 78 30 C70 26 62 28 58 36 C52 30 44 32 40 38 C38 28 48 18 58 20 Z" fill="#58a03c"/>
<circle cx="36" cy="56" r="5" fill="#c0392b"/><circle cx="84" cy="54" r="5" fill="#c0392b"/><circle cx="62" cy="66" r="5" fill="#c0392b"/>
</svg>
'''


class Page:
    def __init__(self, folder, ztex):
        self.folder, self.ztex = folder, ztex
        self.rows = []  # a text, and the panels

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self, *words, quiet=False):
        if not quiet:
            print('    ztex', *words, flush=True)
        subprocess.run([self.ztex, *words], check=True)

    def render(self, file, view, size=PANEL, texture='0', background='255,255,255'):
        words = ['-t', texture, '--view', ','.join(repr(v) for v in view), '--size', f'{size[0]}x{size[1]}', '--background', background]
        self.run('render', self.path(file), '-o', self.path('panel.png'), *words, quiet=True)
        with Image.open(self.path('panel.png')) as picture:
            pixels = numpy.asarray(picture.convert('RGB'))
        os.remove(self.path('panel.png'))
        return pixels

    def ordinary(self, picture, size, target, **options):
        """An ordinary texture of this size with mip levels."""
        scene = {'textures': [{'name': 'texture', 'wrap': 'clamp', **options, 'image': {'file': picture, 'resize': list(size)}}]}
        with open(self.path('ordinary.json'), 'w', encoding='utf-8') as file:
            json.dump(scene, file)
        self.run('make', self.path('ordinary.json'), '-o', self.path(target), quiet=True)

    def inspect(self, file):
        return json.loads(subprocess.run([self.ztex, 'inspect', '--json', self.path(file)], check=True, capture_output=True).stdout)

    def add(self, text, panels):
        self.rows.append((text, panels))

    def save(self):
        gap, left, top = 6, 210, 34
        w, h = PANEL
        sheet = Image.new('RGB', (left + 3 * (w + gap), top + len(self.rows) * (h + gap)), (250, 250, 248))
        draw = demo.ImageDraw.Draw(sheet)
        for i, text in enumerate(('a pixel a cell', '8 times closer', '64 times closer')):
            demo.label(draw, (left + i * (w + gap), 8), text, 16)
        for r, (text, panels) in enumerate(self.rows):
            demo.label(draw, (8, top + r * (h + gap) + h // 2 - 20), text, 16)
            for i, panel in enumerate(panels):
                sheet.paste(Image.fromarray(panel), (left + i * (w + gap), top + r * (h + gap)))
        sheet.save(self.path('sheet.png'))


def views(cells, middle):
    """Views of a texture with so many cells for a panel: a pixel a cell, then 8 and 64 times closer to the middle."""
    found = []
    for zoom in (1, 8, 64):
        w, h = PANEL[0] / zoom / cells[0], PANEL[1] / zoom / cells[1]
        u, v = middle if zoom > 1 else (0.5, 0.5)
        found.append((u - w / 2, v - h / 2, u + w / 2, v + h / 2))
    return found


def light(pixels):
    coded = pixels / 255
    return numpy.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def coded(values):
    return (255 * numpy.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)).round().astype(numpy.uint8)


# --- the three examples ----------------------------------------------------------------------------


def sign(page):
    """A drawing of flat colours."""
    page.run('make', 'silmap', SIGN, '--cells', '96', '-o', page.path('sign.ztex'), '--report', page.path('sign.html'))
    page.run('validate', page.path('sign.ztex'))
    page.run('inspect', page.path('sign.ztex'))
    page.run('extract', page.path('sign.ztex'), '--cells', '-o', page.path('sign_cells.svg'))
    subprocess.run(['rsvg-convert', '-w', str(96 * 64), '-h', str(72 * 64), SIGN, '-o', page.path('sign.png')], check=True)
    page.ordinary('sign.png', (96, 72), 'sign_texture.ztex')
    page.run('make', page.path('sign.png'), '-o', page.path('sign_whole.ztex'), '--wrap', 'clamp', '--effort', '1', quiet=True)
    # At a pixel a cell all of it is too small to fill a panel: what is around it is the background.
    for text, file in (('silmap,\n96 x 72 cells', 'sign.ztex'), ('texture,\n96 x 72 texels', 'sign_texture.ztex'),
                       ('the drawing', 'sign_whole.ztex')):
        page.add(text, [framed(page, file, view) for view in views((96, 72), (0.4903, 0.3))])
    return measure_sign(page)


def framed(page, file, view):
    panel = page.render(file, view)
    u = view[0] + (numpy.arange(PANEL[0]) + 0.5) / PANEL[0] * (view[2] - view[0])
    v = view[1] + (numpy.arange(PANEL[1]) + 0.5) / PANEL[1] * (view[3] - view[1])
    outside = ((u < 0) | (u > 1))[None, :] | ((v < 0) | (v > 1))[:, None]
    panel = panel.copy()
    panel[outside] = (250, 250, 248)
    return panel


def measure_sign(page):
    size = (96 * 16, 72 * 16)
    truth = page.render('sign_whole.ztex', (0, 0, 1, 1), size)
    own, other = (demo.psnr(page.render(name, (0, 0, 1, 1), size), truth) for name in ('sign.ztex', 'sign_texture.ztex'))
    silmap = page.inspect('sign.ztex')['textures'][0]['silmap']
    print(f'\n{"":10}{"PSNR at 16x":>12}{"file":>10}')
    for text, value, name in (('silmap', own, 'sign.ztex'), ('texture', other, 'sign_texture.ztex')):
        print(f'{text:10}{value:9.1f} dB{os.path.getsize(page.path(name)):>10,}')
    print(f'cells: {silmap["cells_size"]} bytes in memory, {silmap["stored_size"]} in the file, {silmap["cut_cells"]} with an edge')
    return own >= other + GOAL_DB


def billboard(page):
    """Colour and a cut-out in one silmap, shown by patches of a zipmap."""
    with open(page.path('tree.svg'), 'w', encoding='utf-8') as file:
        file.write(TREE)
    subprocess.run(['rsvg-convert', '-w', '960', page.path('tree.svg'), '-o', page.path('tree.png')], check=True)
    root = {'image': {'file': PHOTOS['GreenMeadow'], 'resize': [640, 480]}}
    place = {'offset': [0.35, 0.2], 'scale': [0.28125, 0.5]}
    scene = {'textures': [
        {'name': 'tree', 'silmap': {'file': 'tree.svg', 'cells': 64}},
        {'name': 'silmap', 'wrap': 'clamp', 'patches': [root, {'texture': 'tree', **place}]},
        {'name': 'texture', 'wrap': 'clamp', 'patches': [
            root, {'image': {'file': 'tree.png', 'resize': [48, 64]}, 'mask': 'none', **place}]}]}
    with open(page.path('billboard.json'), 'w', encoding='utf-8') as file:
        json.dump(scene, file, indent=2)
    page.run('make', page.path('billboard.json'), '-o', page.path('billboard.ztex'))
    page.run('validate', page.path('billboard.ztex'))
    # The middle lies on the edge of the crown; all of the landscape, then its tree, then a leaf's breadth.
    middle = (0.35 + 0.28125 * 0.72, 0.2 + 0.5 * 0.165)
    shown = [(0, 0, 1, 1)]
    for part in (0.125, 0.125 / 8):
        shown.append((middle[0] - part / 2, middle[1] - part / 2, middle[0] + part / 2, middle[1] + part / 2))
    for text, name in (('billboard: silmap,\n48 x 64 cells', 'silmap'), ('billboard: texture,\n48 x 64 texels', 'texture')):
        page.add(text, [page.render('billboard.ztex', view, texture=name) for view in shown])


def control(page):
    """One channel that says where which of two materials is."""
    page.run('make', 'silmap', '--font', FONT, '--glyph', FLOWER, '--cells', '48', '-o', page.path('mask.ztex'))
    page.run('extract', page.path('mask.ztex'), '--minified', '-o', page.path('mask.png'))
    silmap = page.inspect('mask.ztex')['textures'][0]['silmap']
    cells = silmap['cells_x'], silmap['cells_y']
    page.ordinary('mask.png', cells, 'mask_texture.ztex', semantic='opacity')
    for name in ('Aqua', 'Dune'):
        page.ordinary(PHOTOS[name], (1280, 800), f'{name}.ztex')
    for text, file in ((f'two materials: silmap,\n{cells[0]} x {cells[1]} cells', 'mask.ztex'),
                       (f'two materials: texture,\n{cells[0]} x {cells[1]} texels', 'mask_texture.ztex')):
        panels = []
        for view in views(cells, (0.66, 0.36)):
            mask = page.render(file, view)[..., :1] / 255
            water, sand = (light(page.render(f'{name}.ztex', [0.4 + 0.12 * v for v in view])) for name in ('Aqua', 'Dune'))
            panels.append(coded(mask * water + (1 - mask) * sand))
        page.add(text, panels)


def main(folder, ztex):
    for needed in (SIGN, FONT, *PHOTOS.values()):
        if not os.path.exists(needed):
            print(f'demo: {needed} is not there: ./dev setup installs it', file=sys.stderr)
            return 1
    os.makedirs(folder, exist_ok=True)
    page = Page(folder, os.path.abspath(ztex))
    good = sign(page)
    billboard(page)
    control(page)
    page.save()
    print(f'\nat least {GOAL_DB} dB above a bilinear texture of the same grid: {"yes" if good else "NO"}')
    print(f'See {page.path("sheet.png")}, {page.path("sign.html")} and {page.path("sign_cells.svg")}.')
    return 0 if good else 1


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
