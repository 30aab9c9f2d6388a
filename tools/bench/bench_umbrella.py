#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""./dev bench umbrella: what do umbrella textures cost in bytes and in time, and how good are their coarser levels?

    ./dev bench umbrella [--only storage,lookup,levels,zoom] [--keep] [--write]

Storage: the five parameter sets of the paper's Table 1 with elements drawn by umbrella_elements.py. Lookup: against the longest list k and the number
of vertices v, beside a mipmapped image in the same run. Levels and zoom: the leaves of tools/dev/umbrellas. --keep takes the files that a run before
has left in build/bench/umbrella. --write writes docs/umbrella-bench.md and its pictures. ZTEX and BENCH_UMBRELLA in the environment: programs that
are built already."""
import argparse
import datetime
import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy
from PIL import Image

import umbrella_elements

FOLDER = Path('build/bench/umbrella')
ZTEX = os.environ.get('ZTEX', 'build/release/tools/ztex/ztex')
PROGRAM = os.environ.get('BENCH_UMBRELLA', 'build/release/tools/bench/bench_umbrella_one')
LEAVES = 'tools/dev/umbrellas/leaves.json'
PARTS = ('storage', 'lookup', 'levels', 'zoom')
EFFORT = '9'
TRIES = 9               # sizes tried until the lists are as long as wanted
K = (2, 4, 8, 13, 20, 32, 48, 68)
V = (8, 16, 32, 64, 128)
V_K = 8                 # k of the sweep over v
LOOKUP_GRID = (32, 32)
SHOWN = 5               # cells a side in the picture of the sets
FRAMES, FRAME = 60, (240, 240)
ZOOM = (32.0, 0.05)     # widths of the first and the last view


@dataclass
class Set:
    name: str
    kind: str
    bases: int
    vertices: int
    longest: int
    umbrellas: int
    grid: tuple
    paper: tuple  # T / J: least, mean, largest


SETS = [
    Set('Fall leaves', 'fall leaf', 9, 63, 19, 6100, (64, 24), (16, 25, 47)),
    Set('Berries', 'berry', 3, 58, 16, 14000, (64, 24), (10, 23, 48)),
    Set('Green leaves', 'green leaf', 6, 51, 68, 25000, (64, 24), (5, 13, 53)),
    Set('Peppers', 'pepper', 4, 35, 37, 14000, (64, 24), (21, 32, 56)),
    Set('Flowers', 'flower', 6, 74, 12, 390, (10, 13), (5, 10, 18)),
]


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f'{" ".join(map(str, words))}: {done.stderr}')
    return done.stdout


def build():
    for name, program, target in (('ZTEX', ZTEX, 'ztex'), ('BENCH_UMBRELLA', PROGRAM, 'bench_umbrella_one')):
        if name not in os.environ:
            run('cmake', '--build', 'build/release', '--target', target)
        if not os.path.exists(program):
            sys.exit(f'{program} is not there')


def inspect(path):
    found = json.loads(run(ZTEX, 'inspect', '--json', path))
    return found['textures'][0]['umbrellas']


# --- scenes ----------------------------------------------------------------------------------------


def base(folder, kind, vertices, number, morph):
    picture, contour = umbrella_elements.make(kind, vertices, number + 1)
    name = f'{kind.replace(" ", "_")}_{vertices}_{number}.png'
    if not (folder / name).exists():
        Image.fromarray(picture).save(folder / name)
    # A second shape may need more vertices than the first has.
    second = {'morph': {'amount': 0.08}} if morph else {}
    return {**second, 'name': str(number), 'image': name, 'outline': contour.round(6).tolist(), 'centre': [0.5, 0.5], 'vertices': vertices, 'texels': 256,
            'strength': [0.3, 1],
            'variants': [{'offset': [0.1, 0.05, 0.0], 'rim': [0.0, 0.05, 0.02], 'spread': 0.03},
                         {'offset': [-0.12, -0.1, -0.04], 'rim': [-0.03, -0.08, -0.03], 'spread': 0.03}]}


def make(target, kind, bases, vertices, grid, umbrellas, size, spread, levels):
    """A file with copies whose sizes vary by a factor of spread about the given one."""
    folder = target.parent
    half = math.sqrt(spread)
    drawn = [dict(base(folder, kind, vertices, i, grid != LOOKUP_GRID), size=[size / half, size * half]) for i in range(bases)]
    scene = {'textures': [{'name': kind, 'wrap': 'repeat', 'umbrellas': {
        'seed': 1, 'grid': list(grid), 'background': '#2a2018', 'bases': drawn, 'levels': {'count': levels},
        'arrangement': {'density': umbrellas / (grid[0] * grid[1])}}}]}
    target.with_suffix('.json').write_text(json.dumps(scene), encoding='ascii')
    run(ZTEX, 'make', 'umbrellas', target.with_suffix('.json'), '-o', target, '--effort', EFFORT if levels == 'all' else '1', '--no-fsync')


def bisect(trial, make_one, too_large):
    """The largest size that is not too large, or 0."""
    low, high = 0.0, 16.0
    for _ in range(TRIES):
        size = math.sqrt(max(low, 0.05) * high)
        make_one(trial, size)
        low, high = (low, size) if too_large(inspect(trial)) else (size, high)
    return low


def fit(target, kind, bases, vertices, grid, umbrellas, spread, longest, levels, keep, multiple=0):
    """Copies as large as lists of this length allow; where no size does, so large that T is this multiple of J."""
    if keep and target.exists():
        return inspect(target)
    trial = target.with_name('trial.ztex')

    def make_one(path, size, count=1):
        make(path, kind, bases, vertices, grid, umbrellas, size, spread, count)

    def multiple_of(found):
        return found['account']['whole_size'][1] / found['account']['paper_size']

    size = bisect(trial, make_one, lambda found: found['longest_list'] > longest)
    if size == 0:
        size = bisect(trial, make_one, lambda found: multiple_of(found) < multiple)
    make_one(target, size, levels)
    return inspect(target)


# --- storage ---------------------------------------------------------------------------------------


def storage(keep):
    rows = []
    for one in SETS:
        # As the paper's own largest and least T tell it, less what turning an element does to its box.
        spread = (one.paper[2] / one.paper[0]) ** 0.5 * 0.85
        target = FOLDER / f'{one.kind.replace(" ", "_")}.ztex'
        found = fit(target, one.kind, one.bases, one.vertices, one.grid, one.umbrellas, spread, one.longest, 'all', keep, one.paper[1])
        account = found['account']
        rows.append({'set': one, 'n': found['levels'][0]['umbrellas'], 'k': found['levels'][0]['longest_list'], 'levels': len(found['levels']),
                     'all': found['umbrellas'], 'vertices': sum(b['vertices'] for b in found['bases']) / len(found['bases']),
                     'J': account['paper_size'], 'T': account['whole_size'], 'file': os.path.getsize(target),
                     'images': account['images_size'], 'chunk': found['stored_size']})
        run(ZTEX, 'render', target, '-o', FOLDER / f'{target.stem}.png', '--view', view_of(one.grid, SHOWN), '--size', '256x256', '--shadow', '0.4',
            '--light', '-0.06,-0.08,0.2', '--supersample', '2')
        print(f'  {one.name}: {rows[-1]["file"]} bytes', file=sys.stderr, flush=True)
    return rows


def view_of(grid, cells):
    return f'0,0,{cells / grid[0]},{cells / grid[1]}'


def mega(size):
    return f'{size / 1e6:.3g} MB' if size < 1e9 else f'{size / 1e9:.3g} GB'


def storage_lines(rows):
    lines = ['| set | b | v | k | n | umbrellas of all levels | J | file | of it pictures | J / file | T: least, mean, largest | T / J | T / file | '
             'paper\'s T / J |', '|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|---|---|---|']
    for r in rows:
        one = r['set']
        ratios = [', '.join(f'{t / r[key]:.0f}' for t in r['T']) for key in ('J', 'file')]
        lines.append(f'| {one.name} | {one.bases} | {r["vertices"]:.0f} | {r["k"]} | {r["n"]} | {r["all"]} | {mega(r["J"])} | {mega(r["file"])} | '
                     f'{mega(r["images"])} | {r["J"] / r["file"]:.1f} | {", ".join(mega(t) for t in r["T"])} | {ratios[0]} | {ratios[1]} | '
                     f'{", ".join(map(str, one.paper))} |')
    total = sum(r['file'] for r in rows) / sum(r['J'] for r in rows)
    lines.append(f'| all | | | | | | {mega(sum(r["J"] for r in rows))} | {mega(sum(r["file"] for r in rows))} | | {1 / total:.1f} | | | | |')
    return lines


def storage_goals(rows):
    total = sum(r['file'] for r in rows) / sum(r['J'] for r in rows)
    worst = max(r['file'] / r['J'] for r in rows)
    own = sum(r['T'][1] / r['file'] >= 4 * r['set'].paper[1] for r in rows)
    strict = sum(r['J'] / r['file'] >= 4 for r in rows)
    return [(f'storage: all files together {total:.3f} of J (<= 0.25 wanted)', total <= 0.25),
            (f'storage: each file at most {worst:.3f} of J (<= 0.5 wanted)', worst <= 0.5),
            (f'storage: T / file at least 4 times the paper\'s mean in {own} of {len(rows)} sets (4 wanted)', own >= 4),
            (f'storage: the same if T were the paper\'s multiple of J, in {strict} of {len(rows)} sets (4 wanted)', strict >= 4)]


# --- lookup ----------------------------------------------------------------------------------------


def lookup_file(kind, k, v, keep):
    """As many copies a cell as a fifth of k, so large that the lists are as long as k."""
    target = FOLDER / f'lookup_{kind.replace(" ", "_")}_k{k}_v{v}.ztex'
    if keep and target.exists():
        return target, inspect(target)
    cells = LOOKUP_GRID[0] * LOOKUP_GRID[1]
    return target, fit(target, kind, 3, v, LOOKUP_GRID, cells * k / 5, 1.5, k, 1, keep)


def lookup(keep):
    whole = FOLDER / 'image.ztex'
    if not whole.exists():
        rng = numpy.random.Generator(numpy.random.PCG64(1))
        Image.fromarray(rng.integers(0, 256, (1448, 1448, 4), numpy.uint8)).save(FOLDER / 'image.png')
        run(ZTEX, 'make', FOLDER / 'image.png', '-o', whole, '--effort', '1', '--no-fsync')
    names = [('k', k, *lookup_file('fall leaf', k, 64, keep)) for k in K] + [('v', v, *lookup_file('berry', V_K, v, keep)) for v in V]
    times = json.loads(run(PROGRAM, whole, *(target for _, _, target, _ in names)))
    rows = [{'sweep': 'image', 'value': 0, 'k': 0, 'mean': 0, 'v': 0, **times[0]}]
    for (sweep, value, _, found), measured in zip(names, times[1:]):
        level = found['levels'][0]
        rows.append({'sweep': sweep, 'value': value, 'k': level['longest_list'], 'mean': level['entries'] / (level['cells_x'] * level['cells_y']),
                     'v': sum(b['vertices'] for b in found['bases']) / len(found['bases']), **measured})
    return rows


def lookup_lines(rows):
    lines = ['| | k | mean list | v | in rows, ns | median | scattered, ns | median | in rows, lookups of the image | scattered |',
             '|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|']
    first = rows[0]
    for r in rows:
        name = 'mipmapped image' if r['sweep'] == 'image' else f'over {r["sweep"]}'
        lines.append(f'| {name} | {r["k"]} | {r["mean"]:.1f} | {r["v"]:.0f} | {r["rows"]:.0f} | {r["rows_median"]:.0f} | {r["scattered"]:.0f} | '
                     f'{r["scattered_median"]:.0f} | {r["rows"] / first["rows"]:.1f} | {r["scattered"] / first["scattered"]:.1f} |')
    return lines


def lookup_goals(rows):
    first, found = rows[0], []
    eight = next(r for r in rows if r['sweep'] == 'k' and r['value'] == 8)
    few, many = (next(r for r in rows if r['sweep'] == 'v' and r['value'] == v) for v in (V[0], V[-1]))
    for order in ('rows', 'scattered'):
        ratio, growth = eight[order] / first[order], many[order] / few[order]
        found.append((f'lookup, {order}: {ratio:.1f} lookups of the image at k = 8 (<= 12 wanted)', ratio <= 12))
        found.append((f'lookup, {order}: {growth:.2f} times the cost from v = 8 to v = 128 (<= 1.5 wanted)', growth <= 1.5))
    return found


# --- levels ----------------------------------------------------------------------------------------


def leaves(keep):
    target = FOLDER / 'leaves.ztex'
    if not (keep and target.exists()):
        run(ZTEX, 'make', 'umbrellas', LEAVES, '-o', target, '--no-fsync')
    return target, inspect(target)


def render(path, view, size, *options, kind='png'):
    """Linear light from exr, else coded, 0 to 1."""
    name = FOLDER / f'rendered.{kind}'
    run(ZTEX, 'render', path, '-o', name, '--view', view, '--size', f'{size[0]}x{size[1]}', *options)
    if kind == 'png':
        with Image.open(name) as picture:
            return numpy.asarray(picture.convert('RGB')).astype(float) / 255
    raw = FOLDER / 'rendered.ztex'
    run(ZTEX, 'make', name, '-o', raw, '--levels', '1', '--effort', '1', '--no-fsync', '--format', 'R32G32B32A32_SFLOAT')
    run(ZTEX, 'extract', raw, '--raw', '-o', FOLDER / 'rendered.raw')
    return numpy.fromfile(FOLDER / 'rendered.raw', numpy.float32).reshape(size[1], size[0], 4).astype(float)[..., :3]


def coded(light):
    light = light.clip(0, 1)
    return numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def decibel(a, b):
    error = numpy.mean((a - b) ** 2)
    return math.inf if error == 0 else -10 * math.log10(error)


def shrink(picture, by):
    height, width, channels = picture.shape
    return picture.reshape(height // by, by, width // by, by, channels).mean((1, 3))


def levels(keep):
    """Each level as it is shown at 8 pixels for a cell of its own, against the box-filtered finest."""
    target, found = leaves(keep)
    across, down = found['cells_x'], found['cells_y']
    truth = render(target, '0,0,1,1', (8 * across, 8 * down), '--supersample', '4', kind='exr')
    rows, strips = [], []
    for number, level in enumerate(found['levels']):
        by = 2 ** number
        if across % by and number:
            break
        size = (8 * across // by, 8 * down // by)
        own, wanted = render(target, '0,0,1,1', size, kind='exr'), shrink(truth, by)
        rows.append({'level': number, 'cells': (level['cells_x'], level['cells_y']), 'umbrellas': level['umbrellas'], 'k': level['longest_list'],
                     'coded': decibel(coded(own), coded(wanted)), 'linear': decibel(own, wanted)})
        strips.append((wanted, own))
    save_strip(strips)
    return rows


def save_strip(strips):
    edge, gap = 192, 6
    sheet = Image.new('RGB', (len(strips) * (edge + gap) - gap, 2 * edge + gap), (255, 255, 255))
    for i, pair in enumerate(strips):
        for k, picture in enumerate(pair):
            part = (coded(picture) * 255).round().astype(numpy.uint8)[:edge, :edge]
            sheet.paste(Image.fromarray(part).resize((edge, edge), Image.NEAREST), (i * (edge + gap), k * (edge + gap)))
    sheet.save(FOLDER / 'levels.png')


def level_lines(rows):
    lines = ['| level | cells | umbrellas | k | dB, as displayed | dB, linear light |', '|--:|---|--:|--:|--:|--:|']
    for r in rows:
        lines.append(f'| {r["level"]} | {r["cells"][0]} x {r["cells"][1]} | {r["umbrellas"]} | {r["k"]} | {r["coded"]:.1f} | {r["linear"]:.1f} |')
    return lines


def level_goals(rows):
    worst = min(r['coded'] for r in rows if r['level'] > 0)
    return [(f'levels: at worst {worst:.1f} dB against the box-filtered finest, levels 1 to {len(rows) - 1} (>= 30 wanted)', worst >= 30)]


# --- zoom ------------------------------------------------------------------------------------------


def zoom(keep):
    """60 frames into the leaves. What is left between a frame and the one before it, enlarged to the same view, is what changed."""
    target, _ = leaves(keep)
    paths = [f'{0.5 - w / 2},{0.5 - w / 2},{0.5 + w / 2},{0.5 + w / 2}' for w in ZOOM]
    frames = FOLDER / 'zoom_%04d.png'
    run(ZTEX, 'render', target, '-o', frames, '--zoom-path', ';'.join(paths), '--frames', str(FRAMES), '--size', f'{FRAME[0]}x{FRAME[1]}',
        '--supersample', '2')
    pictures = [Image.open(str(frames) % (i + 1)).convert('RGB') for i in range(FRAMES)]
    factor = (ZOOM[0] / ZOOM[1]) ** (1 / (FRAMES - 1))
    changes = []
    for before, after in zip(pictures, pictures[1:]):
        w, h = FRAME
        box = (w / 2 - w / 2 / factor, h / 2 - h / 2 / factor, w / 2 + w / 2 / factor, h / 2 + h / 2 / factor)
        enlarged = numpy.asarray(before.resize(FRAME, Image.BICUBIC, box=box)).astype(float) / 255
        # The frame that follows as coarse as the one before it was.
        coarse = after.resize((round(w / factor), round(h / factor)), Image.BOX).resize(FRAME, Image.BICUBIC)
        changes.append(float(numpy.sqrt(numpy.mean((enlarged - numpy.asarray(coarse).astype(float) / 255) ** 2))))
    sheet = Image.new('RGB', (10 * (FRAME[0] // 2 + 2) - 2, 6 * (FRAME[1] // 2 + 2) - 2), (255, 255, 255))
    for i, picture in enumerate(pictures):
        sheet.paste(picture.resize((FRAME[0] // 2, FRAME[1] // 2), Image.LANCZOS), (i % 10 * (FRAME[0] // 2 + 2), i // 10 * (FRAME[1] // 2 + 2)))
    sheet.save(FOLDER / 'zoom.png')
    return changes


def zoom_lines(changes):
    worst = max(range(len(changes)), key=lambda i: changes[i])
    beside = [changes[i] for i in (worst - 2, worst - 1, worst + 1, worst + 2) if 0 <= i < len(changes)]
    return [f'{FRAMES} frames of {FRAME[0]} x {FRAME[1]} pixels, each {(ZOOM[0] / ZOOM[1]) ** (1 / (FRAMES - 1)):.3f} times closer. Largest change from a '
            f'frame to the next, seen at the same place and size: {changes[worst]:.4f} of full scale (root of the mean square, as displayed), at frame '
            f'{worst + 1}; its neighbours {", ".join(f"{c:.4f}" for c in beside)}; median of all {sorted(changes)[len(changes) // 2]:.4f}.']


# --- the report ------------------------------------------------------------------------------------


def processor():
    for line in Path('/proc/cpuinfo').read_text(encoding='ascii', errors='replace').splitlines():
        if line.startswith('model name'):
            return line.split(':', 1)[1].strip()
    return 'unknown processor'


TEXTS = {
    'storage': 'The parameter sets of the paper\'s Table 1 (bases b, vertices v, longest list k, umbrellas n of level 0), pictures of 256 x 256 texels '
               'drawn by formulas, stored without loss with their mip levels; files hold all levels of umbrellas. Sizes of the copies are such that '
               'the longest list is k or, where no size gives that (14,000 in 64 x 24 cells have longer lists however small they are), that T is the '
               'paper\'s mean multiple of J. J is the paper\'s own encoding (equation 2), T a conventional texture (equation 3). The paper does not say how large '
               'its elements are; the T that its ratios imply would in some sets need larger ones than lists of k allow.',
    'lookup': f'Grid {LOOKUP_GRID[0]} x {LOOKUP_GRID[1]}, three bases, 512 x 512 pixels of the whole texture, CPU time of one thread, the least and the median of '
              f'7 rounds in which all files take turns. The sweep over k has leaves with v = 64, that over v has berries, whose shape is the same for every v, '
              f'with k = {V_K}. The image has 1448 x 1448 texels: '
              'lookups between two levels.',
    'levels': f'`{LEAVES}`. Level by level at 8 pixels a cell, where nothing else is mixed in, against the finest one averaged over the same boxes; level 0 '
              'differs from that by its filter alone.',
    'zoom': '',
}


def measure(part, keep):
    if part == 'storage':
        rows = storage(keep)
        return storage_lines(rows), storage_goals(rows)
    if part == 'lookup':
        rows = lookup(keep)
        return lookup_lines(rows), lookup_goals(rows)
    if part == 'levels':
        rows = levels(keep)
        return level_lines(rows), level_goals(rows)
    return zoom_lines(zoom(keep)), []


PICTURES = {
    'storage': '![The five sets](umbrella-bench-sets.jpg)\n\n5 x 5 cells of each set.',
    'levels': '![Levels](umbrella-bench-levels.png)\n\nFrom the left level 0, 1 ...; above the truth, below the level.',
    'zoom': '![Zoom](umbrella-bench-zoom.jpg)',
}


def report(found):
    lines = ['# Umbrella textures: bytes, time, levels', '',
             f'{datetime.date.today()}, {processor()}. Made by `./dev bench umbrella --write`.', '', '## Goals', '', '| goal | |', '|---|---|']
    lines += [f'| {text} | {"pass" if reached else "FAIL"} |' for _, goals in found.values() for text, reached in goals]
    for part, (table, _) in found.items():
        lines += ['', f'## {part.capitalize()}', '', *([TEXTS[part], ''] if TEXTS[part] else []), *table]
        if part in PICTURES:
            lines += ['', PICTURES[part]]
    return '\n'.join(lines) + '\n'


def save_pictures():
    pictures = [Image.open(FOLDER / f'{one.kind.replace(" ", "_")}.png').convert('RGB') for one in SETS]
    sheet = Image.new('RGB', (len(pictures) * 260 - 4, 256), (255, 255, 255))
    for i, picture in enumerate(pictures):
        sheet.paste(picture.resize((256, 256)), (260 * i, 0))
    sheet.save('docs/umbrella-bench-sets.jpg', quality=85, optimize=True)
    Image.open(FOLDER / 'levels.png').save('docs/umbrella-bench-levels.png', optimize=True)
    Image.open(FOLDER / 'zoom.png').save('docs/umbrella-bench-zoom.jpg', quality=80, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', 1)[0])
    parser.add_argument('--only', default=','.join(PARTS))
    parser.add_argument('--keep', action='store_true')
    parser.add_argument('--write', action='store_true')
    args = parser.parse_args()
    build()
    FOLDER.mkdir(parents=True, exist_ok=True)
    found = {part: measure(part, args.keep) for part in PARTS if part in args.only.split(',')}
    text = report(found)
    print(text)
    if args.write:
        if len(found) < len(PARTS):
            sys.exit('--write needs all parts')
        Path('docs/umbrella-bench.md').write_text(text, encoding='utf-8')
        save_pictures()
    sys.exit(0 if all(reached for _, goals in found.values() for _, reached in goals) else 1)


if __name__ == '__main__':
    main()
