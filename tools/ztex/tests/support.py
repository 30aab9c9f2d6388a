# SPDX-License-Identifier: Apache-2.0
"""Shared by the tests: running ztex, looking into its files, and pictures made on the fly."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy
from PIL import Image

ZTEX = os.path.abspath(os.environ.get("ZTEX", "ztex"))
SANITIZED = bool(os.environ.get("ZTEX_SANITIZE"))
PROBE = os.path.abspath(os.environ.get("ZTEX_PROBE", "ztex_probe"))

OK, USAGE, IO, INVALID, INTERNAL, UNSUPPORTED, LIMIT, DIFFERENT, LOSS, CANCELLED = range(10)


class Case(unittest.TestCase):
    """Each test runs in an empty folder of its own."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.back = os.getcwd()
        os.chdir(self.folder.name)
        self.addCleanup(os.chdir, self.back)

    def ztex(self, *words, status=OK, data=None, leaks=True):
        """Runs ztex, checks the exit code, and returns (stdout bytes, stderr text). leaks False: libraries behind OpenImageIO lose a few
        bytes over damaged pictures, which is nothing of ours."""
        env = dict(os.environ) if leaks else dict(os.environ, ASAN_OPTIONS="detect_leaks=0")
        run = subprocess.run([ZTEX, *words], input=data, stdin=None if data is not None else subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=300, env=env)
        errors = run.stderr.decode("utf-8", "surrogateescape")
        self.assertEqual(run.returncode, status, f"ztex {' '.join(words)}: {errors}")
        return run.stdout, errors

    def probe(self, path):
        """What is in the file; there must be no findings."""
        found = json.loads(subprocess.run([PROBE, path], check=True, stdout=subprocess.PIPE).stdout)
        self.assertEqual(found["findings"], [], path)
        return found

    def texels(self, path, image=0, level=0, dtype=numpy.uint8):
        run = subprocess.run([PROBE, path, str(image), str(level)], check=True, stdout=subprocess.PIPE)
        return numpy.frombuffer(run.stdout, dtype)

    def trace_free(self, *allowed):
        """Nothing but these files is in the folder."""
        self.assertEqual(sorted(os.listdir(".")), sorted(allowed))


def ramps(width=64, height=48, channels=3):
    """An 8-bit picture whose channels differ and have all kinds of values."""
    x = numpy.linspace(0, 255, width)[None, :].repeat(height, 0)
    y = numpy.linspace(0, 255, height)[:, None].repeat(width, 1)
    planes = [x, y, 255 - x, (x + y) / 2][:channels]
    return numpy.stack(planes, -1).round().astype(numpy.uint8)


def save(path, pixels, **options):
    pixels = pixels[..., 0] if pixels.ndim == 3 and pixels.shape[2] == 1 else pixels
    Image.fromarray(pixels).save(path, **options)


def main():
    unittest.main(argv=sys.argv[:1], verbosity=2)
