#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The demo's page of umbrella textures: leaves, pebbles and flowers from near, from far and in perspective; and all kinds of textures in one file.

    demo_umbrella.py FOLDER ZTEX      FOLDER/sheet.png, with all that it is made of beside it; fails when something is wrong
"""
import os
import subprocess
import sys

from PIL import Image

import demo

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'umbrellas')
SKY = '172,192,214'
PANEL = (420, 300)
WHOLE, FRAMES = '0,0,1,1', 10


class Page:
    def __init__(self, folder, ztex):
        self.folder, self.ztex = folder, ztex
        self.rows = []  # a text, and the pictures with theirs

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self, *words):
        print('    ztex', *words, flush=True)
        subprocess.run([self.ztex, *words], check=True)

    def make(self, name, verb=('make', 'umbrellas')):
        self.run(*verb, os.path.join(SCENES, f'{name}.json'), '-o', self.path(f'{name}.ztex'))
        self.run('validate', self.path(f'{name}.ztex'))

    def render(self, file, target, *words, size=PANEL):
        self.run('render', self.path(file), '-o', self.path(target), '--size', f'{size[0]}x{size[1]}', *words)
        return self.path(target)

    def add(self, text, *panels):
        self.rows.append((text, panels))

    def save(self):
        gap, left, top = 8, 170, 24
        w, h = PANEL
        columns = max(len(panels) for _, panels in self.rows)
        sheet = Image.new('RGB', (left + columns * (w + gap), len(self.rows) * (h + gap + top)), (250, 250, 248))
        draw = demo.ImageDraw.Draw(sheet)
        for r, (text, panels) in enumerate(self.rows):
            y = r * (h + gap + top)
            demo.label(draw, (10, y + top + h // 2 - 20), text, 17)
            for c, (path, title) in enumerate(panels):
                demo.label(draw, (left + c * (w + gap), y + 3), title, 15)
                with Image.open(path) as picture:
                    picture = picture.convert('RGB')
                    picture.thumbnail(PANEL, Image.LANCZOS)
                    sheet.paste(picture, (left + c * (w + gap), y + top))
        sheet.save(self.path('sheet.png'))


def view(width, at=(0.3, 0.3)):
    """Panels of a square grid."""
    return f'{at[0]},{at[1]},{at[0] + width},{at[1] + width * PANEL[1] / PANEL[0]}'


def leaves(page):
    page.make('leaves')
    page.run('inspect', page.path('leaves.ztex'))
    page.add('leaves,\na plane',
             (page.render('leaves.ztex', 'leaves_near.png', '--view', view(0.12), '--shadow', '0.4', '--supersample', '2'), 'from near, with shadows'),
             (page.render('leaves.ztex', 'leaves.png', '--view', view(0.5), '--shadow', '0.4', '--supersample', '2'), 'half of the texture'),
             (page.render('leaves.ztex', 'leaves_all.png', '--view', '0,0,1.4,1', '--supersample', '2'), 'once and a bit'),
             (page.render('leaves.ztex', 'leaves_far.png', '--view', view(6)), 'from far: six times over'))
    page.add('leaves,\nin perspective',
             (page.render('leaves.ztex', 'leaves_space.png', '--3d', '--view', '0.1,0.1,0.35,0.3', '--background', SKY, '--supersample', '2'),
              'a part, as it stands up'),
             (page.render('leaves.ztex', 'leaves_low.png', '--3d', '--view', '0.1,0.1,0.25,0.2', '--background', SKY, '--supersample', '2', '--eye',
                          '0.5,0.95,0.14', '--target', '0.5,0.3,0.02'), 'from low: silhouettes'),
             (page.render('leaves.ztex', 'leaves_wide.png', '--3d', '--view', '0,0,3,3', '--background', SKY, '--supersample', '2', '--eye',
                          '0.5,1.02,0.06', '--target', '0.5,0.6,0'), 'to the horizon: heights taper away'),
             (page.render('leaves.ztex', 'leaves_high.png', '--3d', '--view', '0,0,3,3', '--background', SKY, '--supersample', '2', '--eye',
                          '0.5,1.05,0.3', '--target', '0.5,0.72,0'), 'from higher'))


def stones(page):
    page.make('pebbles')
    page.make('flowers')
    page.add('pebbles\nand flowers',
             (page.render('pebbles.ztex', 'pebbles.png', '--3d', '--view', '0,0,0.4,0.3', '--background', SKY, '--supersample', '2'),
              'convex'),
             (page.render('pebbles.ztex', 'pebbles_low.png', '--3d', '--view', '0,0,0.15,0.12', '--background', SKY, '--supersample', '2', '--eye',
                          '0.5,1.05,0.2', '--target', '0.5,0.4,0.02', '--light', '-0.4,-0.1,0.25'), 'convex, with the sun from the left'),
             (page.render('flowers.ztex', 'flowers.png', '--3d', '--view', '0,0,0.4,0.3', '--background', SKY, '--supersample', '2'), 'concave'),
             (page.render('flowers.ztex', 'flowers_plane.png', '--view', view(0.4), '--shadow', '0.3', '--supersample', '2'), 'the same as a plane'))


def strip(page):
    """The leaves at 8 pixels a cell of each level, all as large as each other."""
    panels = []
    for i in (0, 2, 3, 4):
        edge = 256 >> i
        page.render('leaves.ztex', f'level_{i}.png', '--view', WHOLE, size=(edge, edge))
        with Image.open(page.path(f'level_{i}.png')) as picture:
            picture.convert('RGB').resize((300, 300), Image.NEAREST).save(page.path(f'level_{i}.png'))
        panels.append((page.path(f'level_{i}.png'), f'level {i}: {edge} x {edge} pixels show all'))
    page.add('levels', *panels)


def composition(page):
    """A silmap on a photograph, umbrellas on its ground, and a zipmap as one of the elements."""
    page.make('composition', ('make',))
    page.run('inspect', page.path('composition.ztex'))
    shown = ['-t', 'road', '--supersample', '2']
    page.add('all kinds\nin one file',
             (page.render('composition.ztex', 'composition.png', *shown, size=(420, 280)), 'a photograph with a sign and leaves'),
             (page.render('composition.ztex', 'composition_sign.png', '--view', '0.13,0.41,0.178,0.458', *shown, size=(420, 280)),
              'the sign: a silmap'),
             (page.render('composition.ztex', 'composition_card.png', '--view', '0.52,0.885,0.68,0.965', *shown, size=(420, 140)),
              'a postcard among leaves: a zipmap'),
             (page.render('composition.ztex', 'composition_bug.png', '--view', '0.606,0.917,0.636,0.937', *shown, size=(420, 187)),
              'its close-up'))
    page.render('composition.ztex', 'composition_large.png', *shown, size=(1200, 800))


def main(folder, ztex):
    os.makedirs(folder, exist_ok=True)
    page = Page(folder, os.path.abspath(ztex))
    leaves(page)
    stones(page)
    strip(page)
    composition(page)
    page.run('render', page.path('leaves.ztex'), '-o', page.path('zoom.png'), '--zoom-path', '-2,-2,3,3;0.31,0.31,0.36,0.36', '--frames',
             str(FRAMES), '--sheet', '5', '--size', '240x240', '--supersample', '2')
    page.run('extract', page.path('leaves.ztex'), '--arrangement', '-o', page.path('leaves.svg'))
    page.run('extract', page.path('leaves.ztex'), '--arrangement', '-o', page.path('leaves.gltf'))
    page.save()
    print(f'\nSee {page.path("sheet.png")}, {page.path("zoom.png")} and {page.path("leaves.svg")}; {page.path("leaves.gltf")} is for other programs.')
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
