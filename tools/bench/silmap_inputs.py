# SPDX-License-Identifier: Apache-2.0
"""The inputs of ./dev bench silmap: silmap_inputs.txt, and outlines of glyphs and drawings in the unit square."""
from pathlib import Path

from PIL import Image

PHOTO = 1536  # pixels
MARGIN = 1 / 16


def load(path):
    """A dict of name, set, package, file, what for each line."""
    inputs = []
    for line in Path(path).read_text(encoding='ascii').splitlines():
        if line.strip() and not line.startswith('#'):
            words = [word.strip() for word in line.split('|')]
            inputs.append(dict(zip(('name', 'set', 'package', 'file', 'what'), words)))
    return inputs


def outline_of(item):
    """(recorded pen commands, whether y points up, fill rule)"""
    from fontTools.pens.recordingPen import DecomposingRecordingPen, RecordingPen
    from fontTools.svgLib.path import SVGPath
    from fontTools.ttLib import TTFont
    if item['file'].endswith('.svg'):
        pen = RecordingPen()
        SVGPath(item['file']).draw(pen)
        text = Path(item['file']).read_text(encoding='utf-8', errors='replace')
        return pen.value, False, 'evenodd' if 'evenodd' in text else 'nonzero'
    font = TTFont(item['file'])
    glyphs = font.getGlyphSet()
    pen = DecomposingRecordingPen(glyphs)
    glyphs[font.getBestCmap()[int(item['what'][2:], 16)]].draw(pen)
    return pen.value, True, 'nonzero'


def plain(commands):
    """As (letter, points), quadratic splines without the points that they imply."""
    from fontTools.pens.basePen import decomposeQuadraticSegment
    for name, points in commands:
        if name == 'qCurveTo' and points[-1] is None:
            raise ValueError('a contour without a point on it')
        if name == 'qCurveTo':
            yield from (('Q', pair) for pair in decomposeQuadraticSegment(points))
        elif name == 'curveTo' and len(points) != 3:
            raise ValueError('a cubic spline of several curves')
        else:
            letter = {'moveTo': 'M', 'lineTo': 'L', 'curveTo': 'C', 'closePath': 'Z', 'endPath': 'Z'}[name]
            yield letter, points


def write_outline(item, path):
    """Fits the outline into the unit square, a margin left free."""
    commands, upwards, rule = outline_of(item)
    segments = list(plain(commands))
    places = [point for _, points in segments for point in points]
    left, right = min(x for x, _ in places), max(x for x, _ in places)
    low, high = min(y for _, y in places), max(y for _, y in places)
    scale = (1 - 2 * MARGIN) / max(right - left, high - low)
    lines = [rule]
    for letter, points in segments:
        numbers = []
        for x, y in points:
            y = (low + high) / 2 - y if upwards else y - (low + high) / 2
            numbers += [0.5 + (x - (left + right) / 2) * scale, 0.5 + y * scale]
        lines.append(' '.join([letter, *(f'{number:.9f}' for number in numbers)]))
    path.write_text('\n'.join(lines) + '\n', encoding='ascii')


def write_photograph(item, path):
    left, top = (int(word) for word in item['what'].split(','))
    with Image.open(item['file']) as picture:
        picture.convert('RGB').crop((left, top, left + PHOTO, top + PHOTO)).save(path)


def prepare(item, folder):
    """The words of bench_silmap_one that name the input: KIND, FILE; and behind the cells LEFT TOP WIDTH."""
    base = folder / item['name'].replace(' ', '_').replace('&', 'and')
    if item['set'] == 'photo':
        path = base.with_suffix('.ppm')
        write_photograph(item, path)
        return 'photo', str(path), ['0', '0', '1']
    if item['set'] == 'flat':
        return 'drawing', item['file'], item['what'].split(',')
    path = base.with_suffix('.outline')
    write_outline(item, path)
    return 'outline', str(path), ['0', '0', '1']
