#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""./dev bench author: are heaps of photographs put together rightly, how exactly, how well hidden are the seams, and at what cost?

    ./dev bench author [--heaps N] [--large] [--many] [--write]

Makes N heaps (default 20) of 12 photographs with tools/bench/heap.py, runs `ztex make zipmap` on each, compares with the truth, and says of
each bound whether it is met; the exit code is 1 when one is not. --large adds one heap of photographs of 12 megapixels, for time and memory,
with one thread and with two, and its graph. --many throws six of the heaps together, and compares what `ztex` does with so many photographs with a
comparison of all pairs. --write writes docs/author-bench.md. Heaps are kept in build/bench/heaps.

    ./dev bench author --heaps 0 --large        the large heap alone (about five minutes to make it at first, then three)
    ./dev bench author --large --many --write   everything"""
import argparse
import datetime
import hashlib
import json
import math
import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path

import heap

ZTEX = os.environ.get('ZTEX', 'build/release/tools/ztex/ztex')
HEAPS = Path('build/bench/heaps')
KINDS = ('2x', '4x', '8x', '12x', 'chain', 'mixed')
# Pixels of the child that a corner may be off: median, worst. Those of chains are about the root.
CORNERS = {'2x': (0.3, 1.0), '4x': (0.3, 1.0), '8x': (0.5, 2.0), '12x': (0.5, 2.0), 'chain': (1.0, 4.0)}
STEPS = 1.0, 4.0, 1.0  # of 255: median and worst of the seams, mean colours
WRONG_SHARE = 0.05     # of the heaps
LARGE = 60.0, 3 * 1024  # seconds with two threads, MiB
LARGE_WIDTH = 5300     # pixels across the root: the twelve photographs have about twelve megapixels each, in the mean
FEWEST_PLACES = 16     # of a seam that counts


def folder_of(kind, seed, **how):
    """The heap, made at first use."""
    folder = HEAPS / '_'.join([kind, str(seed), *map(str, how.values())])
    if not (folder / 'truth.json').exists():
        shutil.rmtree(folder, ignore_errors=True)
        print(f'    making {folder}', file=sys.stderr)
        heap.make_heap(kind, seed, folder, **how)
    with open(folder / 'truth.json', encoding='utf-8') as file:
        return folder, json.load(file)


def run(folder, truth, *words, reported=True):
    """Exit code, seconds, peak MiB, report, seconds of the processors."""
    pictures = sorted(str(folder / picture['file']) for picture in truth['pictures'])
    return run_pictures(folder, pictures, *words, reported=reported)


def run_pictures(folder, pictures, *words, reported=True):
    out, report = folder / 'out.ztex', folder / 'report.json'
    report.unlink(missing_ok=True)
    start = time.monotonic()
    process = subprocess.Popen([ZTEX, 'make', 'zipmap', *pictures, '-o', str(out), '-q', *words,
                                *(['--report', str(report)] if reported else [])])
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.monotonic() - start
    found = json.loads(report.read_text(encoding='utf-8')) if report.exists() else None
    return os.waitstatus_to_exitcode(status), seconds, usage.ru_maxrss / 1024, found, usage.ru_utime + usage.ru_stime


def judge(truth, report):
    """What is wrong with the graph (a list of texts), and a record for each placed child."""
    photos = {os.path.basename(photo['file']): photo for photo in report['photographs']}
    names = [os.path.basename(photo['file']) for photo in report['photographs']]
    wrong, placed = [], []
    for picture in truth['pictures']:
        photo, name = photos[picture['file']], picture['file']
        if picture['role'] == 'root' and photo['state'] != 'root':
            wrong.append(f'root {name} is {photo["state"]}')
        if picture['role'] == 'distractor' and photo['state'] != 'unplaced':
            wrong.append(f'distractor {name} is {photo["state"]}')
        if picture['role'] == 'trap' and photo['state'] == 'placed':
            if heap.corner_error(picture['root_matrix'], photo['root_matrix'], picture['size']) > 5:
                wrong.append(f'trap {name} lies in a wrong place')
        if picture['role'] != 'child':
            continue
        if photo['state'] != 'placed' or names[photo['parent']] != picture['parent']:
            wrong.append(f'child {name} ({picture["ratio"]:.1f}x) is {photo["state"]}: {photo.get("reason", "another parent")}')
        if photo['state'] == 'placed':
            own = heap.corner_error(picture['matrix'], photo['matrix'], picture['size']) if names[photo['parent']] == picture['parent'] else None
            whole = heap.corner_error(picture['root_matrix'], photo['root_matrix'], picture['size'])
            placed.append({'ratio': picture['ratio'], 'root_ratio': picture['root_ratio'], 'error': own, 'root_error': whole})
    return wrong, placed


def median_worst(values, digits=3):
    values = sorted(v for v in values if v is not None)
    if not values:
        return '- | -'
    return f'{values[len(values) // 2]:.{digits}f} | {values[-1]:.{digits}f}'


# --- tables ----------------------------------------------------------------------------------------


def accuracy_table(results):
    lines = ['| heaps | children placed | corner error, pixels of the child: median | worst | to the root: median | worst |',
             '|---|--:|--:|--:|--:|--:|']
    for kind in KINDS:
        placed = [child for result in results if result['kind'] == kind for child in result['placed']]
        total = sum(result['children'] for result in results if result['kind'] == kind)
        if total:
            lines.append(f'| {kind} | {len(placed)} of {total} | {median_worst([c["error"] for c in placed])} | '
                         f'{median_worst([c["root_error"] for c in placed])} |')
    far = [c for result in results for c in result['placed'] if c['root_ratio'] > 50]
    if far:
        lines.append(f'| finer than 50x, through chains | {len(far)} | {median_worst([c["error"] for c in far])} | '
                     f'{median_worst([c["root_error"] for c in far])} |')
    return lines


def heap_table(results):
    lines = ['| heap | graph | seconds | MiB | what differs |', '|---|---|--:|--:|---|']
    for result in results:
        lines.append(f'| {result["kind"]} {result["seed"]} | {"right" if not result["wrong"] else "differs"} | {result["seconds"]:.1f} | '
                     f'{result["memory"]:.0f} | {"; ".join(result["wrong"])} |')
    return lines


def seams_of(results):
    return [seam for result in results for seam in result['seams'] if seam['places'] >= FEWEST_PLACES]


def seam_table(results):
    lines = ['| steps, of 255 | before: median | worst | after: median | worst |', '|---|--:|--:|--:|--:|']
    seams = seams_of(results)
    for name, text in (('median', 'median of a seam'), ('high', '95 % of a seam'), ('worst', 'worst place of a seam'),
                       ('sharp', 'worst difference of sharpness'), ('mean', 'mean colour')):
        lines.append(f'| {text} | {median_worst([s["before"][name] for s in seams], 2)} | {median_worst([s["after"][name] for s in seams], 2)} |')
    return lines


def large_table(rows):
    lines = ['| 12 photographs of 12 megapixels | seconds | seconds of the processors | peak MiB | bytes |', '|---|--:|--:|--:|--:|']
    return lines + [f'| {threads} thread{"s" if threads > 1 else ""} | {seconds:.1f} | {busy:.1f} | {memory:.0f} | {size:,} |'
                    for threads, seconds, busy, memory, size in rows]


def many_table(many):
    lines = ['| compared | pairs | of those that hold | of those of child and parent | children placed in their parent | seconds | seconds of the processors | '
             'peak MiB |', '|---|--:|--:|--:|--:|--:|--:|--:|']
    return lines + [f'| {row["text"]} | {row["pairs"]} | {row["held"]} | {row["edges"]} | {row["right"]} of {many["children"]} | '
                    f'{row["seconds"]:.1f} | {row["busy"]:.1f} | {row["memory"]:.0f} |' for row in many['rows']]


def processor():
    for line in Path('/proc/cpuinfo').read_text(encoding='ascii', errors='replace').splitlines():
        if line.startswith('model name'):
            return line.split(':', 1)[1].strip()
    return platform.machine()


# --- bounds ----------------------------------------------------------------------------------------


def bound(text, value, most, digits=2):
    return f'{"PASS" if value <= most else "FAIL"}: {text}: {value:.{digits}f}, at most {most:g}', value <= most


def corner_bounds(results):
    for kind, (median, worst) in CORNERS.items():
        which = 'root_error' if kind == 'chain' else 'error'
        errors = sorted(c[which] for r in results if r['kind'] == kind for c in r['placed'] if c[which] is not None)
        if errors:
            yield bound(f'corner error, {kind}, median', errors[len(errors) // 2], median, 3)
            yield bound(f'corner error, {kind}, worst', errors[-1], worst, 3)


def bounds_of(results, large, many):
    """Text and whether it is met, for each bound."""
    wrong = sum(bool(r['wrong']) for r in results)
    strangers = sum('distractor' in text or 'trap' in text for r in results for text in r['wrong'])
    yield bound(f'heaps of {len(results)} with another graph', wrong, math.floor(WRONG_SHARE * len(results)), 0)
    yield bound('distractors and traps that were placed', strangers, 0, 0)
    yield from corner_bounds(results)
    after = [seam['after'] for seam in seams_of(results)]
    if after:
        medians = sorted(steps['median'] for steps in after)
        yield bound('colour step of a seam, median of the seams', medians[len(medians) // 2], STEPS[0])
        yield bound('colour step of a seam, median of its places, worst seam', medians[-1], STEPS[0])
        yield bound('colour step of a seam, worst place', max(steps['worst'] for steps in after), STEPS[1])
        yield bound('mean colour', max(steps['mean'] for steps in after), STEPS[2])
    if large:
        yield bound('12 photographs of 12 megapixels, seconds with 2 threads', large['rows'][-1][1], LARGE[0], 1)
        yield bound('12 photographs of 12 megapixels, peak MiB', max(row[3] for row in large['rows']), LARGE[1], 0)
        yield bound('12 photographs of 12 megapixels, what differs from the right graph', len(large['wrong']), 0, 0)
        yield f'{"PASS" if large["same"] else "FAIL"}: 12 photographs of 12 megapixels, one thread and two give the same bytes', large['same']
    if many:
        every, chosen = many['rows']
        yield bound(f'{many["pictures"]} photographs, pairs of child and parent that a quick look loses', every['edges'] - chosen['edges'], 0, 0)
        yield bound(f'{many["pictures"]} photographs, children that lose their place', every['right'] - chosen['right'], 0, 0)


# --- the runs --------------------------------------------------------------------------------------


def run_heaps(count):
    results = []
    for number in range(count):
        kind, seed = KINDS[number % len(KINDS)], number // len(KINDS) + 1
        folder, truth = folder_of(kind, seed)
        status, seconds, memory, report, _ = run(folder, truth, '--allow-many')
        wrong, placed = judge(truth, report) if report else ([f'exit code {status}'], [])
        children = sum(picture['role'] == 'child' for picture in truth['pictures'])
        results.append({'kind': kind, 'seed': seed, 'seconds': seconds, 'memory': memory, 'wrong': wrong, 'placed': placed,
                        'children': children, 'seams': report['seams'] if report else []})
        print(f'{kind} {seed}: {"right" if not wrong else "; ".join(wrong)} ({seconds:.1f} s)', flush=True)
    return results


def run_large():
    folder, truth = folder_of('mixed', 1, width=LARGE_WIDTH)
    rows, sums, words = [], set(), ['--allow-many', '--no-fsync', '--threads']
    for threads in (1, 2):
        status, seconds, memory, _, busy = run(folder, truth, *words, str(threads), reported=False)
        if status:
            raise SystemExit(f'the large heap: exit code {status}')
        data = (folder / 'out.ztex').read_bytes()
        sums.add(hashlib.sha256(data).hexdigest())
        rows.append((threads, seconds, busy, memory, len(data)))
        print(f'large, {threads} threads: {seconds:.1f} s, {busy:.1f} s of the processors, {memory:.0f} MiB', flush=True)
    report = run(folder, truth, *words, '2')[3]
    wrong, placed = judge(truth, report)
    print(f'large: {"; ".join(wrong) or "right"}', flush=True)
    megapixels = sum(picture["size"][0] * picture["size"][1] for picture in truth["pictures"]) / 1e6
    return {'rows': rows, 'same': len(sums) == 1, 'megapixels': megapixels, 'wrong': wrong, 'placed': placed}


def run_many():
    """Heaps of all kinds in one, compared pair by pair and as ztex does it by itself."""
    pictures, children = [], {}
    for kind in KINDS:
        folder, truth = folder_of(kind, 1)
        pictures += [str(folder / picture['file']) for picture in truth['pictures']]
        children.update({str(folder / p['file']): str(folder / p['parent']) for p in truth['pictures'] if p['role'] == 'child'})
    rows, held = [], []
    for text, words in (('all pairs', ['--candidates', '4096']), ('candidates', [])):
        # As little as possible beside the registration.
        words = ['--allow-many', '--no-fsync', '--raw', '--levels', '1', '--colour', 'none', '--mask', 'none', '--threads', '2', *words]
        _, seconds, memory, _, busy = run_pictures(HEAPS, sorted(pictures), *words, reported=False)
        report = run_pictures(HEAPS, sorted(pictures), *words)[3]
        names = [photo['file'] for photo in report['photographs']]
        right = sum(photo['parent'] is not None and children.get(photo['file']) == names[photo['parent']] for photo in report['photographs'])
        held.append({frozenset((names[pair['coarse']], names[pair['fine']])) for pair in report['pairs'] if pair['accepted']})
        rows.append({'text': text, 'pairs': len(report['pairs']), 'held': len(held[-1] & held[0]), 'right': right, 'seconds': seconds,
                     'edges': sum(frozenset(edge) in held[-1] for edge in children.items()), 'busy': busy, 'memory': memory})
        print(f'many, {text}: {rows[-1]}', flush=True)
    return {'rows': rows, 'pictures': len(pictures), 'children': len(children)}


def document(words, results, large, many, bounds):
    right = sum(not result['wrong'] for result in results)
    strangers = sum('distractor' in text or 'trap' in text for result in results for text in result['wrong'])
    lines = ['# Heaps of photographs: how right, how exact, at what cost', '',
             f'Made by `./dev bench author {" ".join(words)}` on {datetime.date.today()}. Machine: {processor()}, {os.cpu_count()} processors.', '',
             f'Heaps of 12 photographs from tools/bench/heap.py: {right} of {len(results)} have the right graph; {strangers} distractors or traps '
             'were placed wrongly.', '', *['- ' + text for text, _ in bounds], '',
             'The thing in each heap is a real photograph with other real photographs on it as posters; cameras look at it from '
             'any side, with their own exposure, white balance, vignetting, blur, noise and JPEG. 2x to 12x: each child is so much '
             'finer than its parent; chain: up to 100x in steps; mixed: 2x to 12x, with a wall of exactly repeated bricks of which one '
             'picture shows one period. Views of which their parent shows next to nothing (out of focus, plain sky) are not drawn.', '',
             '## Places', '', *accuracy_table(results), '', '## Seams', '',
             'Differences between the mean colours of a patch and of its parent, in squares of 8 texels of the parent through which the seam '
             'goes, with a soft window; median and worst of all seams. From the worst place is taken by how much the mean would differ if the '
             'parent were moved by half a texel: that is what edges at the border of the patch do when two cameras are not equally sharp. The '
             'other rows are as they are; that of sharpness counts only texels that are half transparent.', '', *seam_table(results), '',
             '## Heaps', '',
             *heap_table(results), '']
    if large:
        lines += ['## Twelve photographs of twelve megapixels', '',
                  f'A heap of the kind mixed, {large["megapixels"]:.0f} megapixels together; the photographs behind have fewer pixels, so that most '
                  'views are enlarged. The time is without a report. Corner error, pixels of the child, median and worst: '
                  f'{median_worst([c["error"] for c in large["placed"]]).replace(" |", ",")}.', '', *large_table(large['rows']), '',
                  f'One thread and two give {"the same bytes" if large["same"] else "DIFFERENT bytes"}. What differs from the right graph: '
                  f'{"; ".join(large["wrong"]) or "nothing"}.', '']
    if many:
        lines += ['## Many photographs', '',
                  f'The first heap of each kind, thrown together: {many["pictures"]} photographs. Either all pairs are compared, or, as ztex does it '
                  'by itself with so many, each photograph with those that look most alike at a quick look. Colours, masks and coarser '
                  'levels are left out of the time.', '', *many_table(many), '']
    return '\n'.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--heaps', type=int, default=20)
    parser.add_argument('--large', action='store_true')
    parser.add_argument('--many', action='store_true')
    parser.add_argument('--write', action='store_true')
    words = parser.parse_args()
    if words.write and not words.heaps:
        parser.error('--write needs heaps: the document is about them')
    if not all(os.path.exists(path) for path in heap.PHOTOS):
        subprocess.run(['bash', 'tools/bench/setup.sh'], check=True)
    results = run_heaps(words.heaps)
    large = run_large() if words.large else None
    many = run_many() if words.many else None
    bounds = list(bounds_of(results, large, many))
    text = document(sys.argv[1:], results, large, many, bounds)
    print('\n' + text)
    if words.write:
        Path('docs/author-bench.md').write_text(text, encoding='utf-8')
    for line, _ in bounds:
        print(line)
    return 0 if all(met for _, met in bounds) else 1


if __name__ == '__main__':
    sys.exit(main())
