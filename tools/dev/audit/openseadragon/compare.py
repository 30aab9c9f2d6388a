# SPDX-License-Identifier: Apache-2.0
"""Compares the screenshots of view.js with what ztex renders of the same rectangles: compare.py ZTEX FOLDER. A view fails when tiles did not
load, or when the pictures differ by more than the resampling of two programs does."""
import json
import subprocess
import sys
from pathlib import Path

import numpy
from PIL import Image

MEAN, HIGH = 2, 16  # of 255: mean difference, and that of all but one value in a hundred


def main():
    ztex, folder = sys.argv[1], Path(sys.argv[2])
    seen = json.loads((folder / 'views.json').read_text(encoding='utf-8'))
    width, height = seen['size']['width'], seen['size']['height']
    print(f'OpenSeadragon {seen["version"]} in Chromium {seen["browser"]}, {width} x {height} pixels')
    bad = 0
    for name, view in seen['views'].items():
        drawn = folder / f'drawn_{name}.png'
        subprocess.run([ztex, 'render', str(folder / 'wall.ztex'), '-q', '-o', str(drawn), '--view', ','.join(f'{x:.9f}' for x in view['view']),
                        '--size', f'{width}x{height}', '--supersample', '4', '--background', '0,0,0'], check=True)
        a = numpy.asarray(Image.open(folder / f'seen_{name}.png').convert('RGB')).astype(int)
        b = numpy.asarray(Image.open(drawn).convert('RGB')).astype(int)
        off = abs(a - b)[:-1, :-1]  # where it enlarges, OpenSeadragon leaves the last row and column empty
        fits = not view['failures'] and off.mean() <= MEAN and numpy.percentile(off, 99) <= HIGH
        bad += not fits
        print(f'{"PASS" if fits else "FAIL"}: {name}, {view["zoom"]:.3f} pixels a texel: mean difference {off.mean():.2f}, '
              f'99 % {numpy.percentile(off, 99):.0f}, worst {off.max()} of 255', *view['failures'])
    return 1 if bad else 0


if __name__ == '__main__':
    sys.exit(main())
