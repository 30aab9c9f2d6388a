# SPDX-License-Identifier: Apache-2.0
"""Property: the layers of a patch follow its place: each lands in its layer, and the normals of a patch that lies turned, mirrored or in
perspective are turned into the root's frame. It matters because light falls wrongly on a turned patch whose normals are not turned, which
nobody notices in the colours."""
import json
import math

import numpy
from PIL import Image

import support
from support import USAGE, ramps, save

SIZE = 96


def heights(x, y):
    """A relief over the root, and its slopes; lengths are those of the root's texels."""
    return 3 * numpy.sin(x / 7) * numpy.cos(y / 9), 3 / 7 * numpy.cos(x / 7) * numpy.cos(y / 9), -3 / 9 * numpy.sin(x / 7) * numpy.sin(y / 9)


def normals(sx, sy, y_down=False):
    n = numpy.stack([-sx, -sy if y_down else sy, numpy.ones_like(sx)], -1)
    n /= numpy.linalg.norm(n, axis=-1, keepdims=True)
    return ((n + 1) / 2 * 255).round().astype(numpy.uint8)


def root_slopes():
    y, x = numpy.mgrid[0:SIZE, 0:SIZE] + 0.5
    return heights(x, y)[1:]


def turned(angle, side, mirrored=False):
    """Corners of a square around the root's middle, and the slopes in the frame of a picture of 2 * side texels that lies there."""
    c, s = math.cos(angle), math.sin(angle)
    axes = numpy.array([[c, -s], [s, c]]) @ numpy.diag([-1 if mirrored else 1, 1])  # columns: where the picture's x and y go
    n = 2 * side
    y, x = (numpy.mgrid[0:n, 0:n] + 0.5) / n - 0.5
    px, py = (axes @ numpy.stack([x.ravel(), y.ravel()]) * side + SIZE / 2).reshape(2, n, n)
    _, sx, sy = heights(px, py)
    corners = [(axes @ numpy.array(p) * side + SIZE / 2) / SIZE for p in ((-.5, -.5), (.5, -.5), (.5, .5), (-.5, .5))]
    along = axes.T @ numpy.stack([sx.ravel(), sy.ravel()])
    return [list(map(float, p)) for p in corners], along.reshape(2, n, n)


class Layers(support.Case):
    def setUp(self):
        super().setUp()
        save("root.png", ramps(SIZE, SIZE))
        save("patch.png", ramps(64, 64))
        save("rough.png", numpy.full((SIZE, SIZE, 1), 60, numpy.uint8))
        save("patch_rough.png", numpy.full((64, 64, 1), 200, numpy.uint8))

    def make(self, patch, status=support.OK, **more):
        scene = {"textures": [{"name": "m", "wrap": "clamp", "patches": [
            {"layers": {"base_colour": "root.png", "normal": "n.png", "roughness": "rough.png"}},
            {"layers": {"base_colour": "patch.png", "normal": "patch_n.png", "roughness": "patch_rough.png"}, "ramp": 1, **patch}]}]}
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        return self.ztex("make", "scene.json", "-o", "m.ztex", status=status)[1]

    def rendered(self, layer, *words):
        self.ztex("render", "m.ztex", "-o", "r.png", "-l", layer, "--size", str(SIZE), *words)
        return numpy.asarray(Image.open("r.png")).astype(float)

    def worst_angle(self):
        """Between the rendered normals and the relief's, in degrees, inside the patch."""
        half = 14
        middle = slice(SIZE // 2 - half, SIZE // 2 + half)
        found = self.rendered("normal")[middle, middle] / 255 * 2 - 1
        truth = normals(*root_slopes(), self.y_down)[middle, middle] / 255 * 2 - 1
        found, truth = (n / numpy.linalg.norm(n, axis=-1, keepdims=True) for n in (found, truth))
        return math.degrees(numpy.arccos((found * truth).sum(-1).clip(-1, 1)).max())

    def relief(self, y_down, *turn):
        self.y_down = y_down
        corners, slopes = turned(*turn)
        save("n.png", normals(*root_slopes(), y_down))
        save("patch_n.png", normals(*slopes, y_down))
        return corners

    def test_turned(self):
        for y_down in (False, True):
            for turn in ((0.0, 40), (0.7, 42), (math.pi / 2, 40), (-2.5, 42), (0.4, 42, True)):
                corners = self.relief(y_down, *turn)
                frame = "y_down" if y_down else "y_up"
                self.make({"corners": corners, "normals": frame})
                self.probe("m.ztex")
                with self.subTest(turn=turn, frame=frame):
                    self.assertLess(self.worst_angle(), 3.0)
        self.make({"corners": corners, "normals": "y_up"})
        self.assertGreater(self.worst_angle(), 10.0)
        self.make({"corners": corners, "normals": "keep"})
        self.assertGreater(self.worst_angle(), 10.0)

    def test_chain(self):
        """What counts is how it lies in the root, not in its parent."""
        corners = self.relief(False, 0.7, 42)
        scene = {"textures": [{"wrap": "clamp", "patches": [
            {"layers": {"base_colour": "root.png", "normal": "n.png"}},
            {"layers": {"base_colour": "patch.png", "normal": "patch_n.png"}, "corners": corners, "ramp": 1},
            {"layers": {"base_colour": "patch.png", "normal": "patch_n.png"}, "parent": 1, "offset": [0, 0], "scale": [1, 1],
             "ramp": 1}]}]}
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", "m.ztex")
        self.assertLess(self.worst_angle(), 3.0)
        self.assertEqual(len(self.probe("m.ztex")["images"]), 4)  # root 2, patch 2: the same picture turned alike is one

    def test_straight_stays(self):
        """Not a bit changes where nothing turns, at any scale."""
        save("n.png", normals(*root_slopes()))
        picture = numpy.random.default_rng(1).integers(0, 256, (64, 64, 3), numpy.uint8)
        save("patch_n.png", picture)
        self.make({"offset": [0.1, 0.2], "scale": [0.3, 0.3]})
        self.ztex("extract", "m.ztex", "--patch", "1", "--layer", "normal", "-o", "e.png")
        self.assertTrue((numpy.asarray(Image.open("e.png")) == picture).all())

    def test_two_channels(self):
        corners = self.relief(False, 0.7, 42)
        for form in ("R8G8_UNORM", "R16G16_UNORM"):
            scene = {"image": {"file": "n.png", "format": form}}
            self.ztex("make", self.file({"textures": [{"wrap": "clamp", "patches": [
                {"image": scene["image"], "semantic": "normal"},
                {"image": {"file": "patch_n.png", "format": form}, "corners": corners, "ramp": 1}]}]}), "-o", "m.ztex")
            half = slice(SIZE // 2 - 14, SIZE // 2 + 14)
            found = self.rendered("normal")[half, half, :2]
            truth = normals(*root_slopes())[half, half, :2]
            self.assertLess(abs(found - truth).max(), 6)

    def file(self, scene):
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        return "scene.json"

    def test_treated(self):
        """Also where colours are adjusted, hidden detail goes, and perspective is taken out."""
        corners = self.relief(False, 0.7, 42)
        for more in ({"colour": "gain"}, {"mask": "auto", "tau": 0.05, "ramp": 2}, {"prune": True}):
            self.make({"corners": corners, **more})
            if "mask" not in more:
                with self.subTest(**more):
                    self.assertLess(self.worst_angle(), 3.0)
        # Perspective: the baked patch has the normals that the unbaked one shows.
        corners[2] = [corners[2][0] + 0.05, corners[2][1] + 0.03]
        shown = []
        for bake in (False, True):
            self.make({"corners": corners, "bake_affine": bake})
            shown.append(self.rendered("normal")[36:60, 36:60])
        self.assertLess(abs(shown[0] - shown[1]).mean(), 2.0)

    def test_layers(self):
        """Roughness lands in the roughness."""
        self.relief(False, 0.0, 40)
        self.make({"offset": [0.25, 0.25], "scale": [0.5, 0.5]})
        found = self.rendered("roughness")
        self.assertEqual(found[48, 48], 200)
        self.assertEqual(found[4, 4], 60)
        errors = self.make({"offset": [0.25, 0.25], "scale": [0.5, 0.5], "normals": "up"}, status=USAGE)
        self.assertIn("/textures/0/patches/1/normals: ", errors)


if __name__ == "__main__":
    support.main()
