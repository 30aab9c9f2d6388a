# SPDX-License-Identifier: Apache-2.0
"""Property: a picture that is a folder of tiles (Deep Zoom, Zoomify, static IIIF) is the picture that was cut, wherever a picture can stand; a broken
folder is answered with the tile that is wrong; and --dzi writes pyramids by the rules that viewers rely on. It matters because people
with gigapixel pictures have them in this form, and read only this form in browsers."""
import json
import math
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy
import tifffile
from PIL import Image

import support
from support import IO, USAGE, ZTEX, ramps, save


def noisy(width, height, channels=3):
    """No two tiles are alike, and no texel is like its neighbours."""
    picture = ramps(width, height, channels)
    return picture ^ numpy.random.default_rng(5).integers(0, 32, picture.shape, numpy.uint8)


def write_dzi(name, picture, size=64, overlap=1, kind="png", levels=None, xml=None):
    """By the rules of Deep Zoom. levels: how many of the finest have tiles; None: the finest alone."""
    height, width = picture.shape[:2]
    finest = math.ceil(math.log2(max(width, height)))
    for level in range(finest, finest - (levels or 1), -1):
        step = 2 ** (finest - level)
        small = picture[::step, ::step]
        os.makedirs(f"{name}_files/{level}")
        for row in range(math.ceil(small.shape[0] / size)):
            for column in range(math.ceil(small.shape[1] / size)):
                tile = small[max(row * size - overlap, 0):(row + 1) * size + overlap,
                             max(column * size - overlap, 0):(column + 1) * size + overlap]
                save(f"{name}_files/{level}/{column}_{row}.{kind}", tile)
    with open(f"{name}.dzi", "w") as file:
        file.write(xml or f'<?xml version="1.0"?><Image xmlns="http://schemas.microsoft.com/deepzoom/2008" Format="{kind}" '
                   f'Overlap="{overlap}" TileSize="{size}"><Size Width="{width}" Height="{height}"/></Image>')


def write_iiif(folder, picture, size, version, whole="full"):
    height, width = picture.shape[:2]
    for y in range(0, height, size):
        for x in range(0, width, size):
            w, h = min(size, width - x), min(size, height - y)
            region = whole if (w, h) == (width, height) else f"{x},{y},{w},{h}"
            wanted = {1: f"{w},", 2: f"{w},", 3: f"{w},{h}"}[version]
            if region == "full" and version == 3:
                wanted = "max"
            path = f"{folder}/{region}/{wanted}/0/{'native' if version == 1 else 'default'}.png"
            os.makedirs(os.path.dirname(path))
            save(path, picture[y:y + h, x:x + w])
    info = {"width": width, "height": height}
    if version == 1:
        info.update(tile_width=size, tile_height=size, scale_factors=[1])
    else:
        info.update(protocol="http://iiif.io/api/image", tiles=[{"width": size, "scaleFactors": [1]}])
    with open(f"{folder}/info.json", "w") as file:
        json.dump(info, file)


def write_zoomify(folder, picture, size=64, down=False, kind="jpg", xml=None):
    """By the rules of Zoomify: levels down to one tile, groups of 256 tiles, and sizes halved upwards or downwards. kind: of the names; what
    is in them is PNG, which keeps texels. Returns the number of tiles."""
    levels = [picture]
    while max(levels[0].shape[:2]) > size:
        small = levels[0][::2, ::2]
        levels.insert(0, small[:max(levels[0].shape[0] // 2, 1), :max(levels[0].shape[1] // 2, 1)] if down else small)
    number = 0
    for z, level in enumerate(levels):
        for y in range(math.ceil(level.shape[0] / size)):
            for x in range(math.ceil(level.shape[1] / size)):
                group = f"{folder}/TileGroup{number // 256}"
                os.makedirs(group, exist_ok=True)
                save(f"{group}/{z}-{x}-{y}.{kind}", level[y * size:(y + 1) * size, x * size:(x + 1) * size], format="PNG")
                number += 1
    with open(f"{folder}/ImageProperties.xml", "w") as file:
        file.write(xml or f'<IMAGE_PROPERTIES WIDTH="{picture.shape[1]}" HEIGHT="{picture.shape[0]}" NUMTILES="{number}" NUMIMAGES="1" '
                   f'VERSION="1.8" TILESIZE="{size}" />')
    return number


class Pyramids(support.Case):
    def same(self, path, picture, *words):
        save("plain.png", picture)
        self.ztex("make", "plain.png", "--name", "x", "-o", "plain.ztex", *words)
        self.ztex("make", path, "--name", "x", "-o", "tiles.ztex", *words)
        with open("plain.ztex", "rb") as a, open("tiles.ztex", "rb") as b:
            self.assertEqual(a.read(), b.read(), path)

    def wrong(self, path, *texts, status=IO):
        _, errors = self.ztex("make", path, "-o", "never.ztex", status=status)
        self.assertFalse(os.path.exists("never.ztex"))
        for text in texts:
            self.assertIn(text, errors)


class Reading(Pyramids):
    def test_deep_zoom(self):
        for number, (width, height, channels, size, overlap) in enumerate(
                [(200, 150, 3, 64, 1), (128, 128, 4, 64, 0), (65, 130, 1, 64, 3), (40, 30, 3, 254, 1), (1, 1, 3, 254, 1),
                 (193, 65, 3, 64, 64)]):
            picture = noisy(width, height, channels)
            write_dzi(f"p{number}", picture, size, overlap)
            self.same(f"p{number}.dzi", picture)

    def test_iiif(self):
        picture = noisy(150, 100)
        for version in (1, 2, 3):
            write_iiif(f"v{version}", picture, 64, version)
            self.same(f"v{version}/info.json", picture)
            write_iiif(f"one{version}", picture, 512, version)
            self.same(f"one{version}/info.json", picture)
        write_iiif("numbers", picture, 512, 3, whole="0,0,150,100")
        self.same("numbers/info.json", picture)
        self.ztex("make", "v3/info.json", "-o", "named.ztex")
        self.assertEqual(self.probe("named.ztex")["textures"][0]["name"], "v3")

    def test_zoomify(self):
        for number, (width, height, channels, size, down) in enumerate(
                [(200, 150, 3, 64, False), (200, 150, 3, 64, True), (129, 129, 3, 64, False), (129, 129, 3, 64, True), (40, 30, 4, 256, False),
                 (257, 190, 1, 8, False), (257, 190, 1, 8, True), (1, 1, 3, 256, False), (67, 1, 3, 32, True)]):
            picture = noisy(width, height, channels)
            tiles = write_zoomify(f"z{number}", picture, size, down)
            self.assertEqual(os.path.exists(f"z{number}/TileGroup1"), tiles > 256)
            self.same(f"z{number}/ImageProperties.xml", picture)
        write_zoomify("other", noisy(200, 150), kind="png")
        self.same("other/ImageProperties.xml", noisy(200, 150))
        for down in (False, True): # without a number of tiles the coarsest one tells
            name = f"uncounted{down:d}"
            write_zoomify(name, noisy(257, 190), 8, down, xml='<IMAGE_PROPERTIES WIDTH="257" HEIGHT="190" TILESIZE="8"/>')
            self.same(f"{name}/ImageProperties.xml", noisy(257, 190))
        self.ztex("make", "z0/ImageProperties.xml", "-o", "named.ztex")
        self.assertEqual(self.probe("named.ztex")["textures"][0]["name"], "z0")

    def test_zoomify_levels(self):
        """The finest level that fits is read, whichever way its size was rounded."""
        for down in (False, True):
            picture = noisy(2047, 1023)
            write_zoomify(f"z{down:d}", picture, 256, down)
            small = picture[::2, ::2]
            save("small.png", small[:511, :1023] if down else small)
            made = []
            for name, memory in ((f"z{down:d}/ImageProperties.xml", "16M"), ("small.png", "1G")):
                scene = {"textures": [{"image": {"file": name, "resize": [300, 200]}}]}
                with open("scene.json", "w") as file:
                    json.dump(scene, file)
                self.ztex("make", "scene.json", "-o", "out.ztex", "--memory", memory)
                with open("out.ztex", "rb") as file:
                    made.append(file.read())
            self.assertEqual(made[0], made[1], f"rounded {'down' if down else 'up'}")

    def test_in_scenes(self):
        """Crop, resize and at_crop mean what they mean for any picture."""
        picture = noisy(200, 150)
        write_dzi("wall", picture, 64, 1)
        save("wall.png", picture)
        made = []
        for name in ("wall.dzi", "wall.png"):
            scene = {"textures": [{"patches": [{"image": {"file": name, "resize": [50, 40]}},
                                               {"image": {"file": name, "crop": [63, 10, 70, 100]}, "at_crop": True}]}]}
            with open("scene.json", "w") as file:
                json.dump(scene, file)
            self.ztex("make", "scene.json", "-o", "out.ztex")
            self.probe("out.ztex")
            with open("out.ztex", "rb") as file:
                made.append(file.read())
        self.assertEqual(made[0], made[1])

    def test_small_from_large(self):
        """What is resized is held in memory: where it does not fit, the finest level that fits is read, and no other."""
        write_dzi("large", noisy(2048, 2048), 512, 0, levels=3)
        os.rename("large_files/11", "large_files/away")
        os.makedirs("large_files/11")
        os.rename("large_files/away/0_0.png", "large_files/11/0_0.png") # says what the picture is like
        scene = {"textures": [{"image": {"file": "large.dzi", "resize": [500, 500]}}]}
        with open("scene.json", "w") as file:
            json.dump(scene, file)
        self.ztex("make", "scene.json", "-o", "out.ztex", "--memory", "16M")
        found = self.probe("out.ztex")["images"][0]
        self.assertEqual(found["size"][:2], [500, 500])
        self.wrong("scene.json", "tile large_files/11/1_0.png")

    def test_memory(self):
        """A row of tiles at a time: a picture of 96 MiB takes less than 64 more than one of a single row."""
        peaks = []
        for name, rows in (("small", 1), ("large", 128)):
            level = 10 + int(math.log2(max(rows / 4, 1)))
            os.makedirs(f"{name}_files/{level}")
            save("tile.png", noisy(256, 256))
            for column in range(4):
                for row in range(rows):
                    os.link("tile.png", f"{name}_files/{level}/{column}_{row}.png")
            os.remove("tile.png")
            with open(f"{name}.dzi", "w") as file:
                file.write(f'<Image Format="png" Overlap="0" TileSize="256"><Size Width="1024" Height="{256 * rows}"/></Image>')
            code = ("import resource,subprocess,sys;subprocess.run(sys.argv[1:],check=True);"
                    "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
            run = subprocess.run([sys.executable, "-c", code, ZTEX, "make", f"{name}.dzi", "-o", f"{name}.ztex", "--raw",
                                  "--levels", "1", "--no-fsync", "--threads", "2"], check=True, stdout=subprocess.PIPE,
                                 env=dict(os.environ, ASAN_OPTIONS="quarantine_size_mb=1"))
            peaks.append(int(run.stdout))
        self.assertLess(peaks[1] - peaks[0], 64 << 10)


class Tiff(Pyramids):
    """Coarser levels that a TIFF brings along are taken where they are all that are wanted, and never taken for the picture."""

    def write(self, name, sizes):
        self.levels = [noisy(*size) for size in sizes]
        with tifffile.TiffWriter(name) as tiff:
            for i, level in enumerate(self.levels):
                tiff.write(level, tile=(64, 64), photometric="rgb", subfiletype=int(i > 0), metadata=None)

    def taken(self, *words):
        """How many of the file's levels are in the texture."""
        self.ztex("make", "p.tif", "--name", "x", "-o", "out.ztex", *words)
        count = self.probe("out.ztex")["images"][0]["levels"]
        return count, sum(numpy.array_equal(self.texels("out.ztex", 0, i).reshape(-1, 3), level.reshape(-1, 3))
                          for i, level in enumerate(self.levels[:count]))

    def test_levels(self):
        self.write("p.tif", [(151, 90), (75, 45), (37, 22)])
        self.assertEqual(self.taken(), (8, 1))  # three of eight: all are made alike
        self.same("p.tif", self.levels[0])
        self.assertEqual(self.taken("--levels", "3"), (3, 3))
        self.assertEqual(self.taken("--levels", "2"), (2, 2))
        self.assertEqual(self.taken("--levels", "4"), (4, 1))
        self.assertEqual(self.taken("--levels", "3", "--mip-filter", "kaiser"), (3, 1))
        self.write("p.tif", [(151, 90), (76, 45)])  # rounded up
        self.assertEqual(self.taken("--levels", "2"), (2, 1))
        self.write("p.tif", [(2, 2), (1, 1)])
        self.assertEqual(self.taken(), (2, 2))


class Broken(Pyramids):
    def setUp(self):
        super().setUp()
        self.picture = noisy(200, 150)
        write_dzi("p", self.picture, 64, 1)

    def test_tiles(self):
        tile = "p_files/8/1_2.png"
        with open(tile, "rb") as file:
            good = file.read()
        os.remove(tile)
        self.wrong("p.dzi", f"p.dzi: tile {tile}: ", "missing")
        with open(tile, "wb") as file:
            file.write(good[:len(good) // 2])
        _, errors = self.ztex("make", "p.dzi", "-o", "never.ztex", status=IO, leaks=False)
        self.assertIn(f"tile {tile}: ", errors)
        with open(tile, "w") as file:
            file.write("nothing")
        self.wrong("p.dzi", f"tile {tile}: ")
        save(tile, noisy(66, 20))
        self.wrong("p.dzi", f"tile {tile}: 66 x 20 pixels", "66 x 23")
        save(tile, noisy(66, 23, 1))
        self.wrong("p.dzi", f"tile {tile}: 1 channels")
        save(tile, noisy(66, 23))
        self.ztex("make", "p.dzi", "-o", "good.ztex")

    def test_descriptors(self):
        size = '<Size Width="200" Height="150"/>'
        for xml, text in (("", "no element"), ("<Image", "line 1"), ("<html/>", "Image"), ("<Collection/>", "collection"),
                          (f'<Image TileSize="64" Overlap="1" Format="../../etc/passwd">{size}</Image>', "Format"),
                          (f'<Image TileSize="64" Overlap="1" Format="dzi">{size}</Image>', "Format"),
                          (f'<Image TileSize="64" Overlap="1">{size}</Image>', "Format"),
                          (f'<Image TileSize="0" Overlap="1" Format="png">{size}</Image>', "size of tiles"),
                          (f'<Image TileSize="-64" Overlap="1" Format="png">{size}</Image>', "size of tiles"),
                          (f'<Image TileSize="64" Overlap="65" Format="png">{size}</Image>', "overlap"),
                          ('<Image TileSize="64" Overlap="1" Format="png"/>', "width and height"),
                          ('<Image TileSize="64" Overlap="1" Format="png"><Size Width="99999999999999999999" Height="1"/></Image>',
                           "width and height"),
                          ('<Image TileSize="64" Overlap="1" Format="png"><Size Width="1073741824" Height="1073741824"/></Image>',
                           "missing"),
                          ('<!DOCTYPE Image [<!ENTITY a "b">]><Image Format="&a;"/>', "document type"),
                          ("<!-- " + "x" * (1 << 20) + " -->", "too long")):
            with open("bad.dzi", "w") as file:
                file.write(xml)
            with self.subTest(xml=xml[:60]):
                self.wrong("bad.dzi", "bad.dzi: ", text)

    def test_zoomify_descriptors(self):
        write_zoomify("z", self.picture)
        for values, text in (('WIDTH="0" HEIGHT="150" TILESIZE="64"', "width and height"),
                             ('WIDTH="200" HEIGHT="150"', "size of tiles"),
                             ('WIDTH="200" HEIGHT="150" TILESIZE="99999999"', "size of tiles"),
                             ('WIDTH="2e2" HEIGHT="150" TILESIZE="64"', "width and height"),
                             ('WIDTH="200" HEIGHT="150" TILESIZE="64" NUMTILES="4"', "it counts 4 tiles"),
                             ('WIDTH="200" HEIGHT="150" TILESIZE="64" NUMTILES="99999999999"', ""),
                             ('WIDTH="1073741824" HEIGHT="1073741824" TILESIZE="1"', "missing"),
                             ('WIDTH="200" HEIGHT="151" TILESIZE="64"', "64 x 22 pixels, where the descriptor wants 64 x 23")):
            with open("z/ImageProperties.xml", "w") as file:
                file.write(f"<IMAGE_PROPERTIES {values} />")
            with self.subTest(values=values):
                if text:
                    self.wrong("z/ImageProperties.xml", "z/ImageProperties.xml: ", text)
                else: # a number that is none counts as none
                    self.same("z/ImageProperties.xml", self.picture)
        for xml, text in (("<html/>", "IMAGE_PROPERTIES"), ("", "no element"),
                          ('<!DOCTYPE IMAGE_PROPERTIES [<!ENTITY a "b">]><IMAGE_PROPERTIES/>', "document type")):
            with open("z/ImageProperties.xml", "w") as file:
                file.write(xml)
            self.wrong("z/ImageProperties.xml", "z/ImageProperties.xml: ", text)
        write_zoomify("y", self.picture)
        os.remove("y/TileGroup0/2-1-2.jpg")
        self.wrong("y/ImageProperties.xml", "tile TileGroup0/2-1-2.jpg: the file is missing")
        os.remove("y/TileGroup0/0-0-0.jpg")
        self.wrong("y/ImageProperties.xml", "first tile", "TileGroup0/0-0-0.jpg")

    def test_iiif_descriptors(self):
        os.makedirs("i")
        for info, text in (("{", "line 1"), ("[]", "width and height"), ('{"width": 5}', "width and height"),
                           ('{"width": 5, "height": -5}', "width and height"),
                           ('{"width": 50, "height": 50, "tiles": [{"width": 16, "scaleFactors": [2, 4]}]}', "scale factor 1"),
                           ('{"width": 50, "height": 50, "tiles": [{"width": 100000000, "scaleFactors": [1]}]}', "size of tiles"),
                           ('{"width": 50, "height": 50, "tiles": [{"width": 16, "scaleFactors": [1]}]}', "first tile"),
                           ('{"width": 50, "height": 50}', "first tile"), ('{"textures": []}', "another name")):
            with open("i/info.json", "w") as file:
                file.write(info)
            with self.subTest(info=info):
                self.wrong("i/info.json", "i/info.json: ", text)


class Writing(Pyramids):
    def check(self, name, size, overlap, kind):
        """The rules of Deep Zoom: a level for each halving, rounded up, down to one pixel; overlap at inner edges only."""
        image = ElementTree.parse(f"{name}.dzi").getroot()
        space = "{http://schemas.microsoft.com/deepzoom/2008}"
        self.assertEqual(image.tag, f"{space}Image")
        self.assertEqual((image.get("TileSize"), image.get("Overlap"), image.get("Format")), (str(size), str(overlap), kind))
        width, height = (int(image.find(f"{space}Size").get(key)) for key in ("Width", "Height"))
        finest = math.ceil(math.log2(max(width, height)))
        self.assertEqual(sorted(os.listdir(f"{name}_files"), key=int), [str(i) for i in range(finest + 1)])
        whole = None
        for level in range(finest + 1):
            w, h = math.ceil(width / 2 ** (finest - level)), math.ceil(height / 2 ** (finest - level))
            columns, rows = math.ceil(w / size), math.ceil(h / size)
            self.assertEqual(sorted(os.listdir(f"{name}_files/{level}")),
                             sorted(f"{c}_{r}.{kind}" for c in range(columns) for r in range(rows)))
            whole = None
            for r in range(rows):
                for c in range(columns):
                    tile = numpy.asarray(Image.open(f"{name}_files/{level}/{c}_{r}.{kind}"))
                    left, top = max(c * size - overlap, 0), max(r * size - overlap, 0)
                    right, bottom = min((c + 1) * size + overlap, w), min((r + 1) * size + overlap, h)
                    self.assertEqual(tile.shape[:2], (bottom - top, right - left), f"{level}/{c}_{r}")
                    whole = numpy.zeros((h, w) + tile.shape[2:], int) - 1 if whole is None else whole
                    there = whole[top:bottom, left:right]
                    if kind == "png": # what tiles repeat of each other is the same
                        self.assertTrue(((there == -1) | (there == tile)).all(), f"{level}/{c}_{r}")
                    there[...] = tile
            if level == 0:
                self.assertEqual(whole.shape[:2], (1, 1))
        return whole

    def test_rounds(self):
        for width, height, channels in ((200, 150, 3), (128, 64, 3), (130, 70, 1), (40, 50, 4), (1, 1, 3)):
            picture = noisy(width, height, channels)
            save("a.png", picture)
            self.ztex("make", "a.png", "--name", "x", "-o", "a.ztex")
            self.ztex("extract", "a.ztex", "--dzi", "out.dzi", "--tile-size", "64", "--overlap", "3", "--format", "png")
            self.assertTrue((self.check("out", 64, 3, "png") == picture.squeeze()).all())
            self.ztex("make", "out.dzi", "--name", "x", "-o", "again.ztex")
            with open("a.ztex", "rb") as a, open("again.ztex", "rb") as b:
                self.assertEqual(a.read(), b.read())
            subprocess.run(["rm", "-r", "out.dzi", "out_files"], check=True)

    def test_lower_levels(self):
        """A coarser level shows the same, averaged in linear light."""
        y, x = numpy.mgrid[0:150, 0:200]
        picture = numpy.stack([128 + 100 * numpy.sin(x / 17), 128 + 100 * numpy.cos(y / 13), 60 + (x + y) / 3], -1)
        picture = picture.round().astype(numpy.uint8)
        save("a.png", picture)
        self.ztex("make", "a.png", "-o", "a.ztex", "--wrap", "clamp")
        self.ztex("extract", "a.ztex", "--dzi", "out.dzi", "--format", "png")
        small = numpy.asarray(Image.open("out_files/7/0_0.png")).astype(int)
        means = picture.reshape(75, 2, 100, 2, 3).mean((1, 3))
        self.assertLess(abs(small - means).max(), 3.0)

    def test_zipmap(self):
        """The finest patch is shown texel by texel, and --max-size bounds it."""
        save("root.png", ramps(64, 64))
        save("patch.png", noisy(64, 64))
        with open("scene.json", "w") as file:
            json.dump({"textures": [{"wrap": "clamp", "patches": [
                {"image": "root.png"}, {"image": "patch.png", "offset": [0.25, 0.5], "scale": [0.25, 0.25], "ramp": 1}]}]}, file)
        self.ztex("make", "scene.json", "-o", "z.ztex")
        self.ztex("extract", "z.ztex", "--dzi", "z.dzi", "--format", "png", "--tile-size", "100")
        whole = self.check("z", 100, 1, "png")
        self.assertEqual(whole.shape[:2], (256, 256))
        inner = numpy.asarray(Image.open("patch.png")).astype(int)[1:-1, 1:-1]
        self.assertLessEqual(abs(whole[129:191, 65:127, :3] - inner).max(), 1)
        _, errors = self.ztex("extract", "z.ztex", "--dzi", "s.dzi", "--max-size", "100")
        self.assertIn("256", errors)
        self.assertEqual(self.check("s", 254, 1, "jpg").shape[:2], (100, 100))

    def test_wrong(self):
        save("a.png", noisy(40, 30, 4))
        self.ztex("make", "a.png", "-o", "a.ztex")
        self.ztex("extract", "a.ztex", "--dzi", "a.dzi")
        self.check("a", 254, 1, "png") # alpha
        allowed = ["a.dzi", "a.png", "a.ztex", "a_files"]
        for words, status, text in ((["--dzi", "a.dzi"], USAGE, "there already"), (["--dzi", "b.png"], USAGE, ".dzi"),
                                    (["--dzi", "b.dzi", "--format", "jpg"], IO, "alpha"),
                                    (["--dzi", "no/b.dzi"], IO, "no/"), (["--dzi", "b.dzi", "--level", "1"], USAGE, "--level"),
                                    (["--dzi", "b.dzi", "--array-layer", "1"], USAGE, "--array-layer"),
                                    (["--dzi", "b.dzi", "--tile-size", "16", "--overlap", "17"], USAGE, "--overlap"),
                                    (["-o", "b.png", "--tile-size", "64"], USAGE, "--tile-size")):
            _, errors = self.ztex("extract", "a.ztex", *words, status=status)
            self.assertIn(text, errors)
            self.trace_free(*allowed)


if __name__ == "__main__":
    support.main()
