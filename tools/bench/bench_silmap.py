#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""./dev bench silmap: what is a silmap worth beside a bilinear texture, a distance field and one of three channels?

    ./dev bench silmap [--cells 32,64,128] [--only TEXT] [--jobs N] [--keep] [--write]

The inputs are in silmap_inputs.txt; their packages, silmap_packages.txt, are installed. Everything is written as .ztex and looked up through
libzt. --only takes the inputs whose name has TEXT. --jobs: how many run at once (default 2; times are CPU times).
--keep takes the figures that a run before has left in build/bench/silmap.
--write writes docs/silmap-bench.md and docs/silmap-bench.jpg. BENCH_SILMAP in the environment: the program that measures, built already."""
import argparse
import datetime
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FOLDER = Path('build/bench/silmap')
PROGRAM = os.environ.get('BENCH_SILMAP', 'build/release/tools/bench/bench_silmap_one')
FILE_CELLS = 256        # of the table of file sizes
EQUAL_CELLS = 64        # the grid at which outlines are compared at equal bytes
PHOTO_CELLS = {32: 32, 64: 64, 128: 96}  # a photograph has 16 of its pixels a cell, no more
SHEET_CELLS = 32
CROP = 128              # pixels
METHODS = ('bilinear', 'sdf', 'msdf', 'silmap')


def setup():
    """Packages, then the program."""
    subprocess.run(['bash', 'tools/bench/setup.sh', 'tools/bench/silmap_packages.txt'], check=True)
    if 'BENCH_SILMAP' in os.environ:
        return
    build = ['cmake', '--build', 'build/release', '--target', 'bench_silmap_one']
    if subprocess.run(build, capture_output=True, check=False).returncode:
        subprocess.run(['cmake', '--preset', 'release'], check=True, capture_output=True)
        subprocess.run(build, check=True)


def crops_of(item):
    return FOLDER / 'crops' / item['name'].replace(' ', '_')


def measure(item, cells, words, keep):
    kind, path, crop = item['words']
    special = [word for word in words if word in ('bytes', 'plain')]
    left = FOLDER / ('_'.join([Path(crops_of(item)).name, str(cells), *special]) + '.json')
    if keep and left.exists():
        return json.loads(left.read_text(encoding='ascii'))
    run = subprocess.run([PROGRAM, kind, path, str(cells), *crop, *words], capture_output=True, text=True, check=False)
    if run.returncode:
        sys.exit(f'{item["name"]}, {cells} cells: {run.stderr}')
    print(f'  {item["name"]}, {cells} cells', file=sys.stderr, flush=True)
    left.write_text(run.stdout, encoding='ascii')
    return json.loads(run.stdout)


def jobs_of(items, sizes):
    """(item, size of the table, cells, words)"""
    for size in sizes:
        for item in items:
            cells = PHOTO_CELLS[size] if item['set'] == 'photo' else size
            words = ['equal'] if item['set'] == 'flat' or (item['set'] != 'photo' and size == EQUAL_CELLS) else []
            words += [f'crops={crops_of(item)}'] if size == SHEET_CELLS else []
            yield item, size, cells, words
            if item['set'] in ('two', 'logo'):
                yield item, f'{size} plain', cells, ['plain', 'areas']
    for item in items:
        if item['set'] in ('logo', 'flat'):
            yield item, 'bytes', FILE_CELLS, ['bytes']


def run_all(items, sizes, at_once, keep):
    """{(name, size): figures}"""
    jobs = list(jobs_of(items, sizes))
    with ThreadPoolExecutor(at_once) as pool:
        found = pool.map(lambda job: measure(job[0], job[2], job[3], keep), jobs)
        return {(job[0]['name'], job[1]): result for job, result in zip(jobs, found)}


def median(values):
    values = sorted(values)
    if not values:
        return float('nan')
    middle = len(values) // 2
    return values[middle] if len(values) % 2 else (values[middle - 1] + values[middle]) / 2


# --- two regions -----------------------------------------------------------------------------------


def two(items):
    return [item for item in items if item['set'] in ('two', 'logo')]


def wrong(figures, method):
    """Area of disagreement in 1/10000 of the picture."""
    return figures[method]['disagreement'] * 1e4


def area_table(items, results, size):
    lines = ['| input | bilinear, threshold | SDF | MSDF | silmap | bilinear / silmap | SDF / silmap | cells: cut | thin |',
             '|---|--:|--:|--:|--:|--:|--:|--:|--:|']
    for item in two(items):
        figures = results[item['name'], size]
        areas = [wrong(figures, method) for method in METHODS]
        lines.append(f'| {item["name"]} | ' + ' | '.join(f'{area:.2f}' for area in areas) +
                     f' | {areas[0] / areas[3]:.2f} | {areas[1] / areas[3]:.2f} | {figures["cut"]} | {figures["thin"]} |')
    return lines


def plain_table(items, results, sizes):
    """The same where the drawings are not hinted."""
    lines = ['| input | ' + ' | '.join(f'{size} cells: bilinear / silmap | SDF / silmap' for size in sizes) + ' |', '|---|' + '--:|' * (2 * len(sizes))]
    for item in two(items):
        row = [item['name']]
        for size in sizes:
            bilinear, field, _, own = (wrong(results[item['name'], f'{size} plain'], method) for method in METHODS)
            row += [f'{bilinear / own:.2f}', f'{field / own:.2f}']
        lines.append('| ' + ' | '.join(row) + ' |')
    return lines


def quality_table(items, results, sizes):
    lines = ['| cells | magnified | ' + ' | '.join(f'{method}: dB | SSIM' for method in METHODS) + ' |', '|--:|--:|' + '--:|' * 8]
    for size in sizes:
        for zoom in (4, 16, 64):
            row = [f'| {size} | {zoom}x']
            for method in METHODS:
                figures = [results[item['name'], size][method] for item in two(items)]
                row.append(f'{median(f[f"psnr{zoom}"] for f in figures):.2f}')
                row.append(f'{median(f[f"ssim{zoom}"] for f in figures):.4f}')
            lines.append(' | '.join(row) + ' |')
    return lines


def equal_table(items, results, size, prefix):
    peers = [f'{prefix}_{method}' for method in METHODS[:3]] + ['silmap']
    what = 'memory' if prefix == 'memory' else 'file'
    lines = [f'| input | bytes | grids: bilinear, SDF, MSDF | ' + ' | '.join(f'{m}: wrong | dB' for m in METHODS) + ' |',
             '|---|--:|---|' + '--:|' * 8]
    for item in two(items):
        figures = results[item['name'], size]
        grids = ', '.join(str(figures[peer]['grid']) for peer in peers[:3])
        lines.append(f'| {item["name"]} | {figures["silmap"][what]} | {grids} | ' +
                     ' | '.join(f'{wrong(figures, peer):.2f} | {figures[peer]["psnr16"]:.2f}' for peer in peers) + ' |')
    return lines


# --- many colours and photographs ------------------------------------------------------------------


def colour_table(items, results, sizes):
    lines = ['| input | cells | silmap: bytes in memory | in the file | dB 4x | 16x | 64x | SSIM 16x | bilinear, same grid: dB 16x | SSIM | '
             'same memory: grid | dB | same file: grid | dB | gain at the same file size, dB |', '|---|--:|' + '--:|' * 13]
    for item in items:
        for size in sizes if item['set'] == 'flat' else ():
            figures = results[item['name'], size]
            own, plain, memory, file = (figures[key] for key in ('silmap', 'bilinear', 'memory_bilinear', 'file_bilinear'))
            far = f'{own["psnr64"]:.2f}' if 'psnr64' in own else '-'
            lines.append(f'| {item["name"]} | {figures["cells"]} | {own["memory"]} | {own["file"]} | {own["psnr4"]:.2f} | {own["psnr16"]:.2f} | '
                         f'{far} | {own["ssim16"]:.4f} | {plain["psnr16"]:.2f} | {plain["ssim16"]:.4f} | {memory["grid"]} | '
                         f'{memory["psnr16"]:.2f} | {file["grid"]} | {file["psnr16"]:.2f} | {own["psnr16"] - file["psnr16"]:+.2f} |')
    return lines


def photo_table(items, results, sizes):
    lines = ['| input | cells | cut | silmap: dB 4x | 16x | bilinear, means: 4x | 16x | bilinear, best samples: 4x | 16x | '
             'silmap over the better, worst |', '|---|--:|--:|' + '--:|' * 7]
    for item in items:
        for size in sizes if item['set'] == 'photo' else ():
            figures = results[item['name'], size]
            columns = [f'{figures[method][key]:.2f}' for method in ('silmap', 'bilinear', 'uncut') for key in ('psnr4', 'psnr16')]
            lines.append(f'| {item["name"]} | {figures["cells"]} | {figures["cut"]} | ' + ' | '.join(columns) +
                         f' | {photo_margin(figures):+.2f} |')
    return lines


def photo_margin(figures):
    return min(figures['silmap'][key] - max(figures['bilinear'][key], figures['uncut'][key]) for key in ('psnr4', 'psnr16'))


# --- bytes and time --------------------------------------------------------------------------------


def byte_table(items, results):
    lines = [f'| input, {FILE_CELLS} x {FILE_CELLS} cells | effort 5: cells, bytes each | whole file, bytes a cell | effort 9: cells | whole file |',
             '|---|--:|--:|--:|--:|']
    for item in items:
        figures = results.get((item['name'], 'bytes'))
        if figures:
            each = [figures[f'effort{effort}'][key] / FILE_CELLS ** 2 for effort in (5, 9) for key in ('cells_size', 'file')]
            lines.append(f'| {item["name"]} | ' + ' | '.join(f'{value:.4f}' for value in each) + ' |')
    return lines


def time_table(items, results, sizes):
    lines = ['| cells | ' + ' | '.join(METHODS) + ' |', '|--:|' + '--:|' * 4]
    for size in sizes:
        lines.append(f'| {size} | ' + ' | '.join(
            f'{median(results[item["name"], size][method]["ns"] for item in two(items)):.0f}' for method in METHODS) + ' |')
    return lines


# --- goals -----------------------------------------------------------------------------------------


def goal_of_area(items, results, size):
    figures = [results[item['name'], size] for item in two(items)]
    third = [wrong(f, 'silmap') <= wrong(f, 'bilinear') / 3 for f in figures]
    field = [wrong(f, 'silmap') <= wrong(f, 'sdf') for f in figures]
    both = sum(a and b for a, b in zip(third, field))
    return (f'disagreement, {size} cells: at most 1/3 of bilinear {sum(third)}, at most the SDF {sum(field)}, both {both} of {len(figures)} '
            'inputs (10 of 12 wanted)', both * 12 >= 10 * len(figures))


def goals(items, results, sizes):
    """(text, whether it is reached)"""
    found = [goal_of_area(items, results, size) for size in sizes if two(items)]
    for size in sizes:
        flat = [results[item['name'], size] for item in items if item['set'] == 'flat']
        if flat:
            gains = [f['silmap']['psnr16'] - f['file_bilinear']['psnr16'] for f in flat]
            found.append((f'many colours, {size} cells: gain at 16x at the same file size, median {median(gains):.2f}, least {min(gains):.2f} dB, '
                          f'>= 6 dB in {sum(gain >= 6 for gain in gains)} of {len(gains)} (all wanted)', min(gains) >= 6))
    photos = [photo_margin(results[item['name'], size]) for item in items if item['set'] == 'photo' for size in sizes]
    if photos:
        found.append((f'photographs: at worst {min(photos):+.3f} dB against the better bilinear (>= -0.1 wanted)', min(photos) >= -0.1))
    each = {(item['name'], size): results[item['name'], size]['silmap'] for item in two(items) for size in sizes}
    if each:
        exact = all(own['memory'] == own['grid'] ** 2 + (own['grid'] + 1) ** 2 for own in each.values())
        found.append(('memory: one byte a cell beside the samples', exact))
    for effort in (5, 9):
        sums = [results[item['name'], 'bytes'][f'effort{effort}']['cells_size'] for item in items if item['set'] in ('logo', 'flat')]
        if sums:
            mean = sum(sums) / len(sums) / FILE_CELLS ** 2
            found.append((f'file, effort {effort}: {mean:.4f} bytes a cell over logos, signs and flat art at {FILE_CELLS} cells '
                          '(<= 0.1 wanted)', mean <= 0.1))
    return found


# --- the report ------------------------------------------------------------------------------------


def processor():
    for line in Path('/proc/cpuinfo').read_text(encoding='ascii', errors='replace').splitlines():
        if line.startswith('model name'):
            return line.split(':', 1)[1].strip()
    return 'unknown processor'


def intro(sizes):
    return ['# Silmaps against bilinear textures and distance fields', '',
            f'{datetime.date.today()}, {processor()}. Made by `./dev bench silmap --write`; the inputs are in `tools/bench/silmap_inputs.txt`.', '',
            'Each contestant is written as a .ztex file without further levels and looked up through `zt_sample`. *bilinear* is a texture whose texels '
            'are means over their squares; *SDF* holds 8 bits over 4 texels to each side, exact distances; *MSDF* three channels of 8 bits over '
            '2 texels to each side, colours changing at corners. Two-region inputs are outlines, known exactly; their silmaps have one channel of '
            'samples, so 2 bytes a cell in memory. Outlines and drawings are hinted (`ztex make silmap --hint`): each side goes out by up to half a '
            'cell, so that edges along the axes lie where a silmap can hold them, if the fit is better so. All contestants get the drawing in that '
            'place; one table has the areas without it. *Wrong* is the area that shows the other side, in 1/10000 of the picture, at places that no fit has seen (37 x 37 a '
            'cell; a bilinear texture is cut at 1/2). dB and SSIM are of the picture as displayed, sRGB-coded, '
            'each method with the edge smoothing that it allows; at 64x over 24 blocks of 4 x 4 cells that edges cross, so these figures '
            'are lower for all. The fit of drawings and photographs saw other pixels than those that are compared.', '',
            f'Cells: {", ".join(str(size) for size in sizes)} in each direction, photographs at most {PHOTO_CELLS[128]}.', '']


def unmoved(items, results, sizes):
    """Which drawings are where they were."""
    stay = [f'{item["name"]} ({size})' for item in items if item['set'] != 'photo' for size in sizes if not results[item['name'], size]['hinted']]
    return ['', f'Not moved, since hinting would not make them better: {", ".join(stay) if stay else "none"}.']


def section(title, table):
    """Nothing for a table without rows."""
    return ['', f'## {title}', '', *table] if len(table) > 2 else []


def report(items, results, sizes):
    lines = intro(sizes) + ['## Goals', '', '| goal | |', '|---|---|']
    lines += [f'| {text} | {"pass" if reached else "FAIL"} |' for text, reached in goals(items, results, sizes)]
    lines += unmoved(items, results, sizes)
    for size in sizes:
        lines += section(f'Two regions: area of disagreement, the same grid of {size}', area_table(items, results, size))
    if two(items):
        lines += section('Two regions: area of disagreement where drawings are not hinted', plain_table(items, results, sizes))
        lines += section('Two regions: pictures, medians over the inputs', quality_table(items, results, sizes))
    for prefix, text in (('memory', 'in memory'), ('file', 'in the file')):
        if EQUAL_CELLS in sizes:
            lines += section(f'Two regions: equal bytes {text}, {EQUAL_CELLS} cells, at 16x', equal_table(items, results, EQUAL_CELLS, prefix))
    lines += section('Many colours', colour_table(items, results, sizes))
    lines += section('Photographs', photo_table(items, results, sizes))
    lines += section('Bytes in the file', byte_table(items, results))
    if two(items):
        lines += section('Nanoseconds a lookup, one thread, medians over the two-region inputs', time_table(items, results, sizes))
    lines += ['', '![A part of each input at 16x](silmap-bench.jpg)', '',
              f'{SHEET_CELLS} cells, 8 x 8 of them at 16x; from the left: truth, bilinear, SDF, MSDF, silmap.']
    return '\n'.join(lines) + '\n'


def contact_sheet(items, path):
    from PIL import Image
    blocks, gap = 2, 4
    rows = (len(items) + blocks - 1) // blocks
    wide = 5 * (CROP + gap) + 4 * gap
    sheet = Image.new('RGB', (blocks * wide - 5 * gap, rows * (CROP + gap) - gap), (120, 120, 120))
    for i, item in enumerate(items):
        for k, name in enumerate(('truth', *METHODS)):
            crop = Path(f'{crops_of(item)}_{name}.ppm')
            if crop.exists():
                sheet.paste(Image.open(crop), (i // rows * wide + k * (CROP + gap), i % rows * (CROP + gap)))
    sheet.save(path, quality=72, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', 1)[0])
    parser.add_argument('--cells', default='32,64,128')
    parser.add_argument('--only', default='')
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--keep', action='store_true')
    parser.add_argument('--write', action='store_true')
    args = parser.parse_args()
    setup()
    import silmap_inputs
    sizes = [int(word) for word in args.cells.split(',')]
    items = [item for item in silmap_inputs.load('tools/bench/silmap_inputs.txt') if args.only in item['name']]
    (FOLDER / 'crops').mkdir(parents=True, exist_ok=True)
    for item in items:
        item['words'] = silmap_inputs.prepare(item, FOLDER)
    results = run_all(items, sizes, args.jobs, args.keep)
    text = report(items, results, sizes)
    print(text)
    if args.write:
        Path('docs/silmap-bench.md').write_text(text, encoding='utf-8')
        contact_sheet(items, 'docs/silmap-bench.jpg')
    sys.exit(0 if all(reached for _, reached in goals(items, results, sizes)) else 1)


if __name__ == '__main__':
    main()
