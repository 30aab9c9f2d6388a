# SPDX-License-Identifier: Apache-2.0
"""Property: drawings, pictures, masks and glyphs become silmaps whose edges lie where they were and stay sharp however close one looks; what is
in them can be seen, compared, converted and taken out again. It matters because an edge in the wrong place, or a soft one, is all that a
silmap could do worse than an ordinary texture of the same size."""
import json
import os
import re
import subprocess
import xml.etree.ElementTree

import numpy
from PIL import Image

import corpus
import jsonschema
import support
from support import DIFFERENT, IO, LIMIT, UNSUPPORTED, USAGE, ramps, save

FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
HERE = os.path.dirname(os.path.abspath(__file__))
BACK, DISC = (0xF4, 0xF0, 0xE4), (0x1A, 0x23, 0x7E)
DISC_SVG = f"""<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100"><rect width="100" height="100" fill="rgb{BACK}"/>
<circle cx="47" cy="52" r="31" fill="rgb{DISC}"/></svg>"""
CUT_OUT_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><circle cx="47" cy="52" r="31" fill="#ff8000"/></svg>"""
BARS_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><rect width="1" height="1"/>
<rect x="0.2213" y="0.1577" width="0.2458" height="0.9" fill="#fff"/><rect x="0.2213" y="0.1577" width="0.6" height="0.2241" fill="#fff"/></svg>"""
# The gradient makes it no flat drawing: its place is chosen by the edges along the axes alone.
THIN_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><linearGradient id="g"><stop/><stop offset="1" stop-color="#010101"/></linearGradient>
<rect width="1" height="1" fill="url(#g)"/>
<rect x="0.269" y="0.112" width="0.534" height="0.713" fill="#444"/>
<path d="M0.1 0.092L0.9 0.152M0.1 0.228L0.9 0.288M0.1 0.363L0.9 0.423M0.1 0.499L0.9 0.559M0.1 0.634L0.9 0.694" stroke="#fff" stroke-width="0.04"/></svg>"""
LINES_SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="96" height="96"><g transform="translate(1,2)" style="opacity:0.5">
<path d="M 30 -2 C 30 30 60 60 60 94" style="fill:none;stroke:#f00;stroke-dasharray:3 2"/></g></svg>"""


def disc(pixels):
    """1 inside of the disc of the drawings above, at the centres of pixels."""
    at = (numpy.arange(pixels) + 0.5) * 100 / pixels
    return ((at[None, :] - 47) ** 2 + (at[:, None] - 52) ** 2 < 31 ** 2).astype(float)


def light(coded):
    """sRGB, 0 to 255, in linear light."""
    coded = coded / 255
    return numpy.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def write(name, text):
    with open(name, "w", encoding="utf-8") as file:
        file.write(text)


class Silmap(support.Case):
    def silmap(self, *words, output="s.ztex", status=support.OK):
        return self.ztex("make", "silmap", *words, "-o", output, "--no-fsync", status=status)[1]

    def inspect(self, path="s.ztex"):
        found = json.loads(self.ztex("inspect", "--json", path)[0])
        corpus.validator("inspect").validate(found)
        return found

    def pixels(self, *words, path="s.ztex"):
        self.ztex("render", path, "-o", "r.png", *words)
        with Image.open("r.png") as picture:
            return numpy.asarray(picture).astype(float)

    def looked_up(self, edge, frame=0, layer=0, path="s.ztex"):
        """What the library finds, without the seconds that a picture's module takes to load."""
        run = subprocess.run([support.PROBE, path, "look", str(layer), str(frame), str(edge)], check=True, stdout=subprocess.PIPE)
        return numpy.frombuffer(run.stdout, numpy.float32).reshape(edge, edge, 4)

    def check_disc(self, covered, pixels, most_wrong):
        """covered: 0 to 1 for each pixel."""
        wrong = numpy.mean((covered > 0.5) != (disc(pixels) > 0.5))
        self.assertLess(wrong, most_wrong)
        # Sharp: a pixel's width of the circumference is in between, whatever the magnification.
        between = numpy.sum((covered > 0.04) & (covered < 0.96))
        self.assertLess(between, 2 * 2 * numpy.pi * 31 / 100 * pixels, f"{pixels} pixels")


class Edges(Silmap):
    def disc_of(self, picture):
        low, high = numpy.array(BACK), numpy.array(DISC)
        return ((picture[..., :3] - low) @ (high - low) / ((high - low) @ (high - low))).clip(0, 1)

    def test_drawing(self):
        write("d.svg", DISC_SVG)
        self.silmap("d.svg", "--cells", "16")
        for pixels, wrong in ((256, 0.01), (1024, 0.01)):
            self.check_disc(self.disc_of(self.pixels("--size", str(pixels))), pixels, wrong)
        picture = self.pixels("--size", "256")
        self.assertEqual(tuple(picture[132, 120]), DISC)
        self.assertEqual(tuple(picture[8, 8]), BACK)
        self.probe("s.ztex")

    def test_picture(self):
        """The same from a picture, which is anti-aliased as such pictures are."""
        write("d.svg", DISC_SVG)
        many = disc(1024).reshape(256, 4, 256, 4).mean((1, 3))[..., None]
        save("d.png", (many * DISC + (1 - many) * BACK).round().astype(numpy.uint8))
        self.silmap("d.png", "--cells", "16")
        self.check_disc(self.disc_of(self.pixels("--size", "512")), 512, 0.01)

    def test_zoomed_edge_is_one_pixel_wide(self):
        write("d.svg", DISC_SVG)
        self.silmap("d.svg", "--cells", "16")
        picture = self.disc_of(self.pixels("--view", "0.7,0.48,0.8,0.56", "--size", "200x160"))
        for row in picture:
            self.assertLess(numpy.sum((row > 0.04) & (row < 0.96)), 4)
        self.assertTrue((picture[:, 0] > 0.9).all() and (picture[:, -1] < 0.1).all())

    def test_seen_from_afar(self):
        write("d.svg", DISC_SVG)
        self.silmap("d.svg", "--cells", "32")
        share = disc(1000).mean()
        wanted = share * light(numpy.array(DISC)) + (1 - share) * light(numpy.array(BACK))
        for pixels in (8, 16, 24, 48):
            mean = self.looked_up(pixels)[..., :3].mean((0, 1))
            self.assertLess(numpy.abs(mean - wanted).max(), 0.015, pixels)

    def test_quality_finds_the_fewest_cells(self):
        write("d.svg", DISC_SVG)
        self.silmap("d.svg", "--quality", "28", "--report", "r.json")
        with open("r.json", encoding="utf-8") as file:
            report = json.load(file)
        self.assertGreaterEqual(report["psnr"], 28)
        self.assertLess(report["cells"][0], 32)
        self.assertGreater(report["psnr"], report["bilinear_psnr"] + 3)


class Masks(Silmap):
    def test_alpha_of_a_drawing(self):
        write("c.svg", CUT_OUT_SVG)
        self.silmap("c.svg", "--mask", "alpha", "--cells", "16")
        found = self.inspect()
        self.assertEqual(found["images"][0]["format_name"], "R8_UNORM")
        self.assertEqual(found["textures"][0]["layers"][0]["semantic_name"], "opacity")
        self.check_disc(self.pixels("--size", "400") / 255, 400, 0.01)

    def test_cut_out_keeps_its_colour(self):
        """A billboard: colour and alpha, and no dark seam, because what is transparent has no colour to mix in."""
        write("c.svg", CUT_OUT_SVG)
        self.silmap("c.svg", "--cells", "16")
        found = self.inspect()["images"][0]
        self.assertEqual((found["format_name"], found["alpha"]), ("R8G8B8A8_SRGB", "straight"))
        picture = self.pixels("--size", "400")
        self.check_disc(picture[..., 3] / 255, 400, 0.01)
        seen = picture[picture[..., 3] > 200][:, :3]
        self.assertLess(numpy.abs(seen - (255, 128, 0)).max(), 3)

    def test_brightness_of_a_picture(self):
        """A shader control painted in grey: its values stay what they were painted as."""
        grey = numpy.full((128, 128), 64, numpy.uint8)
        grey[:, 60:] = 192
        save("g.png", grey)
        self.silmap("g.png", "--mask", "brightness", "--cells", "16", "--semantic", "roughness")
        picture = self.pixels("--size", "512")
        self.assertLess(numpy.abs(picture[:, :200] - 64).max(), 2)
        self.assertLess(numpy.abs(picture[:, 300:] - 192).max(), 2)

    def test_alpha_of_a_picture(self):
        rgba = numpy.zeros((128, 128, 4), numpy.uint8)
        rgba[:, :50] = (200, 10, 10, 255)
        save("a.png", rgba)
        self.silmap("a.png", "--mask", "alpha", "--cells", "8")
        picture = self.pixels("--size", "256")
        self.assertTrue((picture[:, :95] > 250).all() and (picture[:, 105:] < 5).all())


class Glyphs(Silmap):
    def test_glyph(self):
        """An L is two bars, whose places are those of the font's outline."""
        self.silmap("--font", FONT, "--glyph", "L", "--cells", "18", "--report", "r.json")
        with open("r.json", encoding="utf-8") as file:
            report = json.load(file)
        x, y = report["cells"]
        picture = self.pixels("--size", f"{40 * x}x{40 * y}") / 255
        self.assertEqual(y, 18)
        self.assertLess(report["disagreement"], 0.02)
        # A cell around the ink is empty; the stem and the foot are there, the upper right is not.
        self.assertLess(picture[:20].max(), 0.01)
        self.assertGreater(picture[40 * 9, 60], 0.99)
        self.assertGreater(picture[-52, 20 * x], 0.99)
        self.assertLess(picture[40 * 9, 20 * x], 0.01)

    def test_text_is_wider_than_a_glyph(self):
        self.silmap("--font", FONT, "--text", "AV", "--cells", "24x12")
        self.silmap("--font", FONT, "--glyph", "U+0041", "--cells", "12", output="a.ztex")
        self.assertEqual(self.inspect()["textures"][0]["silmap"]["cells_x"], 24)
        self.assertEqual(self.inspect("a.ztex")["textures"][0]["silmap"]["cells_y"], 12)


class FlatDrawings(Silmap):
    """A drawing of flat colours gives its paths, so its edges do not depend on pixels; any other one is drawn, and it is said why."""

    def made(self, *words):
        said = self.silmap(*words, "--report", "r.json", "-v")
        with open("r.json", encoding="utf-8") as file:
            report = json.load(file)
        return report["edges_from"], report["not_flat"], "drawn supersampled" in said, report

    def test_flat(self):
        write("d.svg", DISC_SVG)
        *source, report = self.made("d.svg", "--cells", "16")
        self.assertEqual(source, ["paths", None, False])
        write("c.svg", CUT_OUT_SVG)
        for mask in ("alpha", "brightness"):
            *source, masked = self.made("c.svg", "--mask", mask, "--cells", "16")
            self.assertEqual(source, ["paths", None, False])
            self.assertAlmostEqual(masked["disagreement"], report["disagreement"], places=9)

    def test_gradient(self):
        write("g.svg", DISC_SVG.replace("<circle", """<linearGradient id="g"><stop offset="0" stop-color="red"/>
<stop offset="1" stop-color="blue"/></linearGradient><rect x="5" y="5" width="9" height="9" fill="url(#g)"/><circle"""))
        *source, report = self.made("g.svg", "--cells", "16")
        self.assertEqual(source, ["texels", "it has a gradient", True])
        self.assertEqual(report["fitted_to"], [256, 256])

    def test_what_needs_pixels(self):
        """Values under what is transparent, a picture, and edges drawn by hand."""
        write("c.svg", CUT_OUT_SVG)
        *source, _ = self.made("c.svg", "--cells", "16", "--semantic", "roughness")
        self.assertEqual((source[0], source[2]), ("texels", True))
        save("p.png", ramps(64, 64, 3))
        self.assertEqual(self.made("p.png", "--cells", "16")[:3], ("texels", None, False))

    def test_same_bytes_for_any_number_of_threads(self):
        write("d.svg", DISC_SVG)
        for threads in ("1", "3"):
            self.silmap("d.svg", "--cells", "24x16", "--threads", threads, output=f"{threads}.ztex")
        with open("1.ztex", "rb") as one, open("3.ztex", "rb") as other:
            self.assertEqual(one.read(), other.read())


class Hints(Silmap):
    """A drawing that may lie where it suits the cells has its edges along the axes held better, is not far from where it was, and takes all its layers
    with it. Where it would look worse there, it stays."""

    def reported(self, *words, name="r.json"):
        self.silmap(*words, "--report", name)
        with open(name, encoding="utf-8") as file:
            return json.load(file)

    def check_place(self, report):
        x, y, width, height = report["place"]
        for start, size, cells in ((x, width, report["cells"][0]), (y, height, report["cells"][1])):
            self.assertTrue(-0.5 / cells <= start <= 0 and 1 <= start + size <= 1 + 0.5 / cells, (start, size))

    def test_glyph(self):
        words = ("--font", FONT, "--glyph", "L", "--cells", "18")
        plain, hinted = self.reported(*words), self.reported(*words, "--hint")
        self.assertEqual((plain["place"], plain["hint"]), ([0, 0, 1, 1], None))
        self.assertEqual(hinted["hint"]["plain"], {name: plain[name] for name in ("psnr", "disagreement")})
        self.check_place(hinted)
        self.assertLess(hinted["disagreement"] * 3, plain["disagreement"])
        self.assertGreater(hinted["psnr"], plain["psnr"] + 3)

    def test_drawing(self):
        """The bars' own sides are found at the place that is told."""
        write("b.svg", BARS_SVG)
        words = ("b.svg", "--cells", "16")
        plain, hinted = self.reported(*words), self.reported(*words, "--hint", "--layer", "normal=b.svg", "--layer", "roughness=b.png")
        self.check_place(hinted)
        self.assertGreater(hinted["psnr"], plain["psnr"] + 3)
        x, _, width, _ = hinted["place"]
        for layer in ("base_colour", "normal", "roughness"):
            row = self.pixels("--layer", layer, "--size", "1600")[1200].reshape(1600, -1)[:, 0] > 200
            for i, at in enumerate((x + width * 0.2213, x + width * 0.4671)):
                found = numpy.flatnonzero(row)[-i] + i
                self.assertLess(abs(found - 1600 * at), 4, (layer, i))

    def setUp(self):
        super().setUp()
        at = numpy.arange(512) / 512
        save("b.png", numpy.where((at > 0.2213) & (at < 0.4671), 255, 0).astype(numpy.uint8)[None].repeat(512, 0))

    def test_never_worse(self):
        """Strokes thinner than a cell fare worse where the rectangle has its best place, so all stays as without hinting."""
        write("t.svg", THIN_SVG)
        report = self.reported("t.svg", "--cells", "16", "--hint")
        hint = report["hint"]
        self.assertEqual(hint["kept"], "plain")
        self.assertLess(hint["hinted"]["psnr"], hint["plain"]["psnr"] - 0.2)
        self.assertEqual((report["place"], report["psnr"]), ([0, 0, 1, 1], hint["plain"]["psnr"]))
        self.assertIn("stays where it is drawn", self.silmap("t.svg", "--cells", "16", "--hint", "-v"))
        self.silmap("t.svg", "--cells", "16", output="plain.ztex")
        self.ztex("diff", "s.ztex", "plain.ztex")

    def test_choice(self):
        """Masks by the area that is wrong, colours by PSNR; and the report says what was chosen from."""
        write("b.svg", BARS_SVG)
        write("t.svg", THIN_SVG)
        for path in ("b.svg", "t.svg"):
            for mask, figure, sign in (((), "psnr", -1), (("--mask", "brightness"), "disagreement", 1)):
                report = self.reported(path, "--cells", "16", "--hint", *mask)
                hint = report["hint"]
                other = "plain" if hint["kept"] == "hinted" else "hinted"
                self.assertLess(sign * hint[hint["kept"]][figure], sign * hint[other][figure], (path, mask))
                self.assertEqual(report[figure], hint[hint["kept"]][figure])
                self.assertEqual(report["place"] == [0, 0, 1, 1], hint["kept"] == "plain")

    def test_what_cannot_be_hinted(self):
        write("b.svg", BARS_SVG)
        for words in (["b.png"], ["b.svg", "--quality", "30"], ["b.svg", "--wrap", "repeat"]):
            self.assertIn("cannot be hinted", self.silmap(*words, "--hint", output="bad.ztex", status=USAGE))

    def test_scene(self):
        write("b.svg", BARS_SVG)
        for hint in (False, True):
            write("scene.json", json.dumps({"textures": [{"name": "b", "silmap": {"file": "b.svg", "cells": 16, "hint": hint}}]}))
            self.ztex("make", "scene.json", "-o", f"{hint}.ztex")
        self.silmap("b.svg", "--cells", "16", "--hint", "--name", "b")
        self.ztex("diff", "s.ztex", "True.ztex")
        self.ztex("diff", "s.ztex", "False.ztex", status=DIFFERENT)


class Frames(Silmap):
    """Each frame of an animated silmap is what a silmap of that picture alone would be; cells that are the same in all frames are there once."""

    def animation(self, silmap, status=support.OK):
        scene = {"textures": [{"name": "s", "silmap": {"cells": 16, **silmap}}]}
        with open(os.path.join(HERE, "../scene.schema.json"), encoding="utf-8") as file:
            jsonschema.Draft202012Validator(json.load(file)).validate(scene)
        write("scene.json", json.dumps(scene))
        return self.ztex("make", "scene.json", "-o", "a.ztex", "--no-fsync", status=status)[1]

    def check_cells(self, layers):
        self.assertEqual(self.inspect("a.ztex")["textures"][0]["silmap"]["cell_layers"], layers)
        images = self.probe("a.ztex")["images"]
        self.assertEqual({(image["layers"], image["layer_kind"]) for image in images}, {(3, 2)})

    def check_frames(self, files, *words):
        for i, path in enumerate(files):
            self.silmap(path, "--cells", "16", *words)
            for edge in (96, 7):
                found, wanted = self.looked_up(edge, i, path="a.ztex"), self.looked_up(edge)
                numpy.testing.assert_array_equal(found[..., :3], wanted[..., :3], f"{path} {edge}")
            self.assertEqual(*(self.ztex("extract", name, "--cells", "-o", "-", *layer)[0]
                               for name, layer in (("a.ztex", ("--array-layer", str(i))), ("s.ztex", ()))), path)

    def test_drawings(self):
        """Named by a pattern, and by a list; the disc wanders."""
        files = [f"walk_{i:02}.svg" for i in range(3)]
        for i, path in enumerate(files):
            write(path, DISC_SVG.replace('cx="47"', f'cx="{40 + 9 * i}"'))
        self.animation({"file": {"file": "walk_%02d.svg", "as": "frames"}})
        os.replace("a.ztex", "pattern.ztex")
        self.animation({"file": {"files": files, "as": "frames"}})
        self.ztex("diff", "a.ztex", "pattern.ztex")
        self.check_cells(3)
        self.check_frames(files)
        for size, option in (("96", "--frame"), ("7", "--array-layer")):
            numpy.testing.assert_array_equal(self.pixels("--size", size, option, "2", path="a.ztex"), self.pixels("--size", size), size)
        self.ztex("convert", "a.ztex", "-o", "c.ztex", "--no-fsync")
        self.ztex("diff", "a.ztex", "c.ztex")
        self.ztex("render", "a.ztex", "-o", "film%d.png", "--play", "--frames", "4", "--size", "32")
        with Image.open("film1.png") as first, Image.open("film4.png") as again:
            self.assertEqual(first.tobytes(), again.tobytes())
        self.ztex("render", "a.ztex", "-o", "r.png", "--frame", "3", status=USAGE)

    def test_equal_cells_are_kept_once(self):
        """The same picture in each frame, whose other layer has three."""
        write("d.svg", DISC_SVG)
        for i in range(3):
            save(f"n{i}.png", numpy.full((64, 64, 3), 40 + 60 * i, numpy.uint8))
        normals = {"normal": {"files": ["n0.png", "n1.png", "n2.png"], "as": "frames"}}
        for image in ("d.svg", {"files": ["d.svg"] * 3, "as": "frames"}):
            self.animation({"file": image, "layers": normals})
            self.check_cells(1)
            for i in range(3):
                picture = self.looked_up(20, i, 1, path="a.ztex")
                self.assertEqual(set((picture[..., :3] * 255).round().ravel()), {40 + 60 * i})
            self.check_frames(["d.svg"])

    def test_layer_of_one_picture(self):
        """It has its samples in the cells of each frame."""
        files = [f"d{i}.svg" for i in range(3)]
        for i, path in enumerate(files):
            write(path, DISC_SVG.replace('cy="52"', f'cy="{50 + 5 * i}"'))
        self.animation({"file": {"files": files, "as": "frames"}, "layers": {"normal": "d1.svg"}})
        self.check_cells(3)
        for i, path in enumerate(files):
            self.silmap(path, "--cells", "16", "--layer", "normal=d1.svg")
            numpy.testing.assert_array_equal(self.looked_up(40, i, 1, path="a.ztex"), self.looked_up(40, 0, 1))

    def test_alpha_of_one_frame(self):
        """What is transparent in one frame, whatever the first one is, stays so; the others are opaque."""
        write("a.svg", DISC_SVG)
        write("b.svg", CUT_OUT_SVG)
        picture = ramps(96, 96)
        save("a.png", picture)
        picture = numpy.concatenate((picture, numpy.full((96, 96, 1), 255, numpy.uint8)), -1)
        picture[:, 48:, 3] = 0
        save("b.png", picture)
        for kind in ("svg", "png"):
            self.animation({"file": {"files": [f"a.{kind}", f"b.{kind}", f"a.{kind}"], "as": "frames"}})
            for i in range(3):
                alpha = self.pixels("--size", "64", "--frame", str(i), path="a.ztex")[..., 3]
                self.assertEqual(alpha.min(), 0 if i == 1 else 255, (kind, i))
            self.check_frames([f"a.{kind}"])

    def test_what_is_no_animation(self):
        write("d.svg", DISC_SVG)
        write("e.svg", DISC_SVG.replace('height="100"', 'height="60"', 1))
        save("d.png", ramps())
        save("grey.png", ramps(channels=1)[..., 0])
        two = {"files": ["d.svg", "d.svg"], "as": "frames"}
        for silmap, text in (({"file": {"files": ["d.svg", "e.svg"], "as": "frames"}}, "one size"),
                             ({"file": {"files": ["d.png", "grey.png"], "as": "frames"}}, "one size and kind"),
                             ({"file": two, "quality": 25}, "share one grid"),
                             ({"file": two, "hint": True}, "cannot be hinted"),
                             ({"file": {"files": ["d.svg"] * 6, "as": "cube"}}, "frames"),
                             ({"file": {"file": "d.png", "as": "array"}}, "frames"),
                             ({"file": two, "layers": {"normal": {"files": ["d.svg"] * 3, "as": "frames"}}}, "as many")):
            self.assertIn(text, self.animation(silmap, status=USAGE))
        self.assertFalse(os.path.exists("a.ztex"))


class Overlays(Silmap):
    def setUp(self):
        super().setUp()
        t = numpy.linspace(0, 1, 500)[:, None]
        p = [numpy.array(v) for v in ((31, 0), (31, 32), (61, 62), (61, 96))]
        self.curve = (1 - t) ** 3 * p[0] + 3 * (1 - t) ** 2 * t * p[1] + 3 * (1 - t) * t ** 2 * p[2] + t ** 3 * p[3]
        at = numpy.arange(96) + 0.5
        left = at[None, :] < numpy.interp(at, self.curve[:, 1], self.curve[:, 0])[:, None]
        picture = ramps(96, 96) // 2
        picture[left] = 255 - picture[left]
        picture[40:, 10:13] = 255 - picture[40:, 10:13]
        save("p.png", picture)
        write("o.svg", LINES_SVG)

    def cut(self, path="s.ztex"):
        """The cut arms, in cells: x, y of both ends."""
        svg = self.ztex("extract", path, "--cells", "-o", "-")[0].decode()
        thick = re.findall(r'd="([^"]*)" stroke="#000" stroke-width="1.2"', svg)[0]
        return [[float(v) / 16 for v in re.findall(r"[-\d.]+", line)] for line in thick.strip().split("\n") if line]

    def test_lines_are_cuts(self):
        self.silmap("p.png", "--edges", "o.svg", "--edges-only", "--cells", "12")
        arms = self.cut()
        self.assertGreater(len(arms), 10)
        for x0, y0, x1, y1 in arms:
            for x, y in ((x0, min(max(y0, 0), 12)), (x1, min(max(y1, 0), 12))):  # the last arms lead out of the picture
                self.assertLess(numpy.hypot(*(self.curve / 8 - (x, y)).T).min(), 0.5, (x, y))

    def test_no_lines_no_cuts(self):
        save("p.png", ramps(96, 96))
        self.silmap("p.png", "--cells", "12")
        self.assertLess(self.inspect()["textures"][0]["silmap"]["cut_cells"], 8)

    def test_layers_share_the_cells(self):
        normal = numpy.full((50, 50, 3), (128, 128, 255), numpy.uint8)
        normal[:, :25] = (255, 128, 128)
        save("n.png", normal)
        self.silmap("p.png", "--edges", "o.svg", "--edges-only", "--cells", "12", "--layer", "normal=n.png", "--no-minified")
        found = self.inspect()
        self.assertEqual([layer["semantic_name"] for layer in found["textures"][0]["layers"]], ["base_colour", "normal"])
        self.assertEqual(found["textures"][0]["silmap"]["minified"], [None, None])
        self.assertEqual([image["format_name"] for image in found["images"]], ["R8G8B8_SRGB", "R8G8B8_UNORM"])
        picture = self.pixels("--layer", "normal", "--size", "48")
        self.assertLess(numpy.abs(picture[5, 5] - (255, 128, 128)).max(), 3)
        self.assertLess(numpy.abs(picture[5, 43] - (128, 128, 255)).max(), 3)


class Files(Silmap):
    def setUp(self):
        super().setUp()
        write("d.svg", DISC_SVG)
        self.silmap("d.svg", "--cells", "16", "--name", "disc")

    def test_same_bytes_for_any_number_of_threads(self):
        for threads in ("1", "2", "5"):
            self.silmap("d.svg", "--cells", "16", "--name", "disc", "--threads", threads, output="t.ztex")
            with open("s.ztex", "rb") as a, open("t.ztex", "rb") as b:
                self.assertEqual(a.read(), b.read(), threads)

    def test_inspect(self):
        silmap = self.inspect()["textures"][0]["silmap"]
        self.assertEqual((silmap["cells_x"], silmap["cells_y"], silmap["filter"]), (16, 16, "continuous"))
        self.assertEqual(silmap["cells_size"], 256)
        self.assertEqual(silmap["minified"], [1])
        self.assertTrue(20 < silmap["cut_cells"] < 70)
        text = self.ztex("inspect", "s.ztex")[0].decode()
        self.assertIn("16 x 16 cells, ", text)
        self.assertIn("minified 1", text)

    def test_extract(self):
        self.ztex("extract", "s.ztex", "--cells", "-o", "cells.svg")
        root = xml.etree.ElementTree.parse("cells.svg").getroot()
        self.assertEqual(root.get("viewBox"), "0 0 256 256")
        self.ztex("extract", "s.ztex", "-o", "samples.png")
        self.ztex("extract", "s.ztex", "--minified", "-o", "minified.png")
        for name, size in (("samples.png", 17), ("minified.png", 16)):
            with Image.open(name) as picture:
                self.assertEqual(picture.size, (size, size))
        self.ztex("extract", "s.ztex", "--cells", status=USAGE)
        self.ztex("extract", "s.ztex", "--cells", "--raw", "-o", "x.svg", status=USAGE)
        _, errors = self.ztex("extract", "s.ztex", "--all", "all", status=UNSUPPORTED)
        self.assertIn("disc", errors)
        self.assertEqual(sorted(os.listdir("all")), ["disc.cells.svg", "disc.minified.0.png", "disc.png", "scene.json"])

    def test_cells_of_another_kind_cannot_be_extracted(self):
        save("p.png", ramps())
        self.ztex("make", "p.png", "-o", "p.ztex")
        self.ztex("extract", "p.ztex", "--cells", "-o", "x.svg", status=USAGE)
        self.assertFalse(os.path.exists("x.svg"))

    def test_convert(self):
        self.ztex("convert", "s.ztex", "-o", "same.ztex")
        with open("s.ztex", "rb") as a, open("same.ztex", "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.ztex("convert", "s.ztex", "-o", "half.ztex", "--format", "R16G16B16A16_SFLOAT", "--levels", "all")
        images = self.inspect("half.ztex")["images"]
        self.assertEqual([image["format_name"] for image in images], ["R16G16B16A16_SFLOAT"] * 2)
        self.assertEqual(len(images[0]["levels"]), 1)
        self.ztex("diff", "--rendered", "--tolerance", "0.01", "s.ztex", "half.ztex")
        self.ztex("convert", "s.ztex", "-o", "anew.ztex", "--effort", "9", "--levels", "rebuild")
        self.ztex("diff", "s.ztex", "anew.ztex")

    def test_diff(self):
        self.silmap("d.svg", "--cells", "16", "--name", "disc", "--filter", "nearest", output="n.ztex")
        out = self.ztex("diff", "s.ztex", "n.ztex", status=DIFFERENT)[0].decode()
        self.assertIn('textures/0/silmap/filter: "continuous" | "nearest"', out)
        write("e.svg", DISC_SVG.replace('r="31"', 'r="27"'))
        self.silmap("e.svg", "--cells", "16", "--name", "disc", output="e.ztex")
        out = self.ztex("diff", "s.ztex", "e.ztex", status=DIFFERENT)[0].decode()
        self.assertRegex(out, r"texels: texture 0/cells: \d+ bytes differ")

    def test_report_replaces_no_original(self):
        write("lines.svg", DISC_SVG)
        for word in ("d.svg", "lines.svg"):
            with open(word, encoding="utf-8") as file:
                before = file.read()
            self.silmap("d.svg", "--edges", "lines.svg", "--cells", "16", "--report", word, status=support.USAGE)
            with open(word, encoding="utf-8") as file:
                self.assertEqual(file.read(), before, word)
        self.silmap("d.svg", "--cells", "16", "--report", "same.ztex", output="same.ztex", status=support.USAGE)

    def test_report(self):
        self.silmap("d.svg", "--cells", "16", "--report", "r.json", output="r.ztex")
        with open(os.path.join(HERE, "../silmap_report.schema.json"), encoding="utf-8") as file:
            schema = json.load(file)
        with open("r.json", encoding="utf-8") as file:
            jsonschema.Draft202012Validator(schema).validate(json.load(file))
        self.silmap("d.svg", "--cells", "16", "--report", "r.html", output="r.ztex")
        with open("r.html", encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("data:image/png;base64,"), 2)
        self.assertIn("<svg ", page)

    def test_scene(self):
        save("p.png", ramps(64, 64))
        scene = {"textures": [
            {"name": "disc", "kind": "silmap", "silmap": {"file": "d.svg", "cells": 16}},
            {"name": "glyph", "silmap": {"font": FONT, "text": "g", "cells": [10, 14], "minified": False}},
            {"name": "wall", "wrap": "clamp", "patches": [
                {"image": "p.png"},
                {"texture": "disc", "offset": [0.25, 0.25], "scale": [0.5, 0.5]}]}]}
        write("scene.json", json.dumps(scene))
        with open(os.path.join(HERE, "../scene.schema.json"), encoding="utf-8") as file:
            jsonschema.Draft202012Validator(json.load(file)).validate(scene)
        self.ztex("make", "scene.json", "-o", "scene.ztex")
        self.probe("scene.ztex")
        found = self.inspect("scene.ztex")
        self.assertEqual([texture["kind"] for texture in found["textures"]], ["silmap", "silmap", "zipmap"])
        self.assertEqual(found["textures"][1]["silmap"]["minified"], [None])
        inside = self.pixels("-t", "wall", "--view", "0.4,0.4,0.6,0.6", "--size", "64", path="scene.ztex")
        alone = self.pixels("--view", "0.3,0.3,0.7,0.7", "--size", "64")
        self.assertLess(numpy.abs(inside - alone).max(), 2)
        for wrong in ({"file": "d.svg", "cells": 0}, {"file": "d.svg", "font": FONT, "text": "a"}, {"cells": 4}, {"font": FONT},
                      {"file": "d.svg", "edges_only": True}, {"file": "d.svg", "celsl": 4}):
            write("bad.json", json.dumps({"textures": [{"name": "x", "silmap": wrong}]}))
            self.assertIn("/textures/0/silmap", self.ztex("make", "bad.json", "-o", "bad.ztex", status=USAGE)[1])

    def test_wrong_words(self):
        save("p.png", ramps(32, 32))
        write("no.svg", "no drawing")
        write("blank.svg", '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>')
        left = sorted(os.listdir("."))
        for status, words in ((USAGE, ["p.png", "--cells", "0"]), (USAGE, ["p.png", "--cells", "12x"]), (USAGE, ["p.png", "--cells", "64"]),
                              (USAGE, ["d.svg", "--cells", "100000"]), (LIMIT, ["d.svg", "--memory", "1M"]),
                              (USAGE, ["--font", FONT, "--glyph", "\U0001F9D9"]), (USAGE, ["--font", FONT]),
                              (USAGE, ["--font", "d.svg", "--glyph", "a"]), (USAGE, ["--glyph", "a", "d.svg"]), (USAGE, []),
                              (USAGE, ["p.png", "--mask", "alpha"]), (USAGE, ["d.svg", "--edges-only"]),
                              (USAGE, ["p.png", "--edges", "blank.svg"]), (IO, ["no.svg"]), (IO, ["missing.svg"]),
                              (USAGE, ["d.svg", "--format", "BC7_UNORM_BLOCK"]), (USAGE, ["d.svg", "--quality", "-3"])):
            self.silmap(*words, output="bad.ztex", status=status)
            self.assertEqual(sorted(os.listdir(".")), left, words)


if __name__ == "__main__":
    support.main()
