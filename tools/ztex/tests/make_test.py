# SPDX-License-Identifier: Apache-2.0
"""Property: a picture's texels arrive in the texture file exactly, in the format that says what they are; failures leave everything as it
was. It matters because all that follows is only as good as what make stored."""
import os
import signal
import subprocess
import unittest

import numpy
from PIL import Image, ImageOps

import support
from support import CANCELLED, IO, LIMIT, USAGE, ZTEX, ramps, save

NONE, STRAIGHT, PREMULTIPLIED = range(3)
LINEAR, SRGB = 8, 13


def srgb_to_linear(v):
    return numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


class Pictures(support.Case):
    def make(self, name, *words):
        self.ztex("make", name, "-o", "out.ztex", *words)
        found = self.probe("out.ztex")
        return found, found["images"][0]

    def test_each_kind_of_png(self):
        for channels, kind, alpha in ((1, "R8_SRGB", NONE), (3, "R8G8B8_SRGB", NONE), (4, "R8G8B8A8_SRGB", STRAIGHT)):
            pixels = ramps(channels=channels)
            save("p.png", pixels)
            found, image = self.make("p.png")
            self.assertEqual((image["format"], image["alpha"], image["transfer"]), (kind, alpha, SRGB))
            self.assertEqual(image["size"], [64, 48, 1])
            self.assertEqual(image["levels"], 7)
            self.assertTrue((self.texels("out.ztex") == pixels.ravel()).all())
            self.assertEqual(found["textures"][0]["name"], "p")
            self.assertEqual(found["textures"][0]["layers"], [[1, 0]])

    def test_grey_with_alpha(self):
        pixels = ramps(channels=2)
        Image.fromarray(pixels, "LA").save("la.png")
        _, image = self.make("la.png")
        self.assertEqual((image["format"], image["alpha"]), ("R8G8B8A8_SRGB", STRAIGHT))
        self.assertTrue((self.texels("out.ztex").reshape(-1, 4) == pixels.reshape(-1, 2)[:, [0, 0, 0, 1]]).all())

    def test_sixteen_bits(self):
        pixels = (ramps(channels=1).astype(numpy.uint16) * 257)[..., 0]
        Image.fromarray(pixels).save("p.png")
        _, image = self.make("p.png")
        self.assertEqual((image["format"], image["transfer"]), ("R16_UNORM", SRGB))
        self.assertTrue((self.texels("out.ztex", dtype=numpy.uint16) == pixels.ravel()).all())

    def test_float(self):
        pixels = numpy.linspace(-1, 5, 64 * 48, dtype=numpy.float32).reshape(48, 64)
        Image.fromarray(pixels).save("p.tif")
        _, image = self.make("p.tif")
        self.assertEqual((image["format"], image["transfer"]), ("R32_SFLOAT", LINEAR))
        self.assertTrue((self.texels("out.ztex", dtype=numpy.float32) == pixels.ravel()).all())

    def test_straight_alpha_of_other_formats(self):
        pixels = ramps(channels=4)
        for name, options in (("p.tif", {}), ("p.tga", {}), ("p.webp", {"lossless": True, "exact": True})):
            save(name, pixels, **options)
            _, image = self.make(name)
            self.assertEqual((image["format"], image["alpha"]), ("R8G8B8A8_SRGB", STRAIGHT), name)
            stored = self.texels("out.ztex").reshape(-1, 4).astype(int)
            opaque = pixels.reshape(-1, 4).astype(int)
            self.assertTrue((stored[:, 3] == opaque[:, 3]).all(), name)
            # WebP comes multiplied into eight bits; what the division gives back is as exact as alpha allows.
            allowed = 255 / numpy.maximum(opaque[:, 3:], 1) if name == "p.webp" else 0
            visible = opaque[:, 3] > 0
            self.assertTrue((abs(stored - opaque) <= allowed)[visible].all(), name)

    def test_jpeg_and_palette(self):
        save("p.jpg", ramps(), quality=95)
        self.assertEqual(self.make("p.jpg")[1]["format"], "R8G8B8_SRGB")
        Image.fromarray(ramps()).quantize(16).save("q.png")
        self.assertEqual(self.make("q.png")[1]["format"], "R8G8B8_SRGB")
        self.assertTrue((self.texels("out.ztex") == numpy.asarray(Image.open("q.png").convert("RGB")).ravel()).all())

    def test_orientation(self):
        for turn in range(1, 9):
            exif = Image.Exif()
            exif[0x0112] = turn
            save("p.png", ramps(), exif=exif)
            save("p.jpg", ramps(), exif=exif, quality=100, subsampling=0)
            upright = numpy.asarray(ImageOps.exif_transpose(Image.open("p.jpg")))
            _, image = self.make("p.jpg")
            self.assertEqual(image["size"][:2], [upright.shape[1], upright.shape[0]])
            self.assertTrue((self.texels("out.ztex") == upright.ravel()).all(), turn)
            _, image = self.make("p.jpg", "--keep-orientation")
            self.assertTrue((self.texels("out.ztex") == numpy.asarray(Image.open("p.jpg")).ravel()).all(), turn)

    def test_authorship_goes_along(self):
        exif = Image.Exif()
        exif[0x8298] = "(c) 2026 Somebody"
        exif[0x013B] = "Somebody"
        save("p.jpg", ramps(), exif=exif)
        found, _ = self.make("p.jpg", "--meta", "zt.title=A=B", "--license", "CC0-1.0")
        self.assertEqual(found["metadata"], {"zt.author": "Somebody", "zt.copyright": "(c) 2026 Somebody",
                                             "zt.title": "A=B", "zt.license": "CC0-1.0"})
        found, _ = self.make("p.jpg", "--meta", "zt.author=Else", "--writer")
        self.assertEqual(found["metadata"]["zt.author"], "Else")
        self.assertRegex(found["metadata"]["zt.writer"], r"^ztex \d")

    def test_options(self):
        save("p.png", ramps(300, 200, 4))
        found, image = self.make("p.png", "--levels", "3", "--tile-edge", "64", "--wrap", "mirror", "--name", "Wand ä",
                                 "--primaries", "p3-d65", "--transfer", "bt709", "--format", "R8G8B8A8_UNORM")
        self.assertEqual((image["levels"], image["tile_edge"], image["primaries"], image["transfer"]), (3, 64, 12, 1))
        self.assertEqual(found["textures"][0]["wrap"], [1, 1, 1])
        self.assertEqual(found["textures"][0]["name"], "Wand ä")
        _, image = self.make("p.png", "--alpha", "none")
        self.assertEqual((image["format"], image["alpha"]), ("R8G8B8_SRGB", NONE))
        self.assertTrue((self.texels("out.ztex").reshape(-1, 3) == ramps(300, 200, 4).reshape(-1, 4)[:, :3]).all())

    def test_conversions(self):
        pixels = ramps(channels=4)
        save("p.png", pixels)
        values = pixels.reshape(-1, 4) / 255.0
        linear = srgb_to_linear(values[:, :3])
        _, image = self.make("p.png", "--format", "R32G32B32A32_SFLOAT")
        self.assertEqual(image["transfer"], LINEAR)
        stored = self.texels("out.ztex", dtype=numpy.float32).reshape(-1, 4)
        self.assertLess(abs(stored[:, :3] - linear).max(), 1e-5)
        self.assertLess(abs(stored[:, 3] - values[:, 3]).max(), 1e-6)
        _, image = self.make("p.png", "--format", "R32G32B32A32_SFLOAT", "--alpha", "premultiplied")
        stored = self.texels("out.ztex", dtype=numpy.float32).reshape(-1, 4)
        self.assertEqual(image["alpha"], PREMULTIPLIED)
        self.assertLess(abs(stored[:, :3] - linear * values[:, 3:]).max(), 1e-5)
        _, image = self.make("p.png", "--format", "E5B9G9R9_UFLOAT_PACK32")
        save("g.png", ramps(channels=1))
        _, image = self.make("g.png", "--format", "R8G8B8A8_SRGB")
        self.assertTrue((self.texels("out.ztex").reshape(-1, 4)[:, 1] == ramps(channels=1).ravel()).all())
        _, errors = self.ztex("make", "p.png", "-o", "out.ztex", "-f", "R8_SRGB")
        self.assertIn("keeps the first 1 of 3 channels", errors)
        _, errors = self.ztex("make", "p.png", "-o", "out.ztex", "-f", "BC7_SRGB_BLOCK", status=USAGE)
        self.assertIn("uncompressed", errors)

    def test_values_are_not_colours(self):
        pixels = ramps(channels=3)
        save("n.png", pixels)
        found, image = self.make("n.png", "--semantic", "normal")
        self.assertEqual((image["format"], image["transfer"]), ("R8G8B8_UNORM", LINEAR))
        self.assertEqual(found["textures"][0]["layers"], [[2, 0]])
        self.assertTrue((self.texels("out.ztex") == pixels.ravel()).all())
        _, errors = self.ztex("make", "n.png", "-o", "x.ztex", "--semantic", "normal", "-f", "R8G8B8_SRGB", status=USAGE)
        self.assertIn("UNORM", errors)

    def test_material(self):
        save("c.png", ramps(channels=4))
        save("n.png", ramps(channels=3))
        save("r.png", ramps(channels=1))
        found, _ = self.make("c.png", "--layer", "normal=n.png", "--layer", "roughness=r.png")
        self.assertEqual(found["textures"][0]["layers"], [[1, 0], [2, 1], [4, 2]])
        self.assertEqual([image["format"] for image in found["images"]], ["R8G8B8A8_SRGB", "R8G8B8_UNORM", "R8_UNORM"])
        save("s.png", ramps(32, 32, 1))
        _, errors = self.ztex("make", "c.png", "--layer", "roughness=s.png", "-o", "x.ztex", status=USAGE)
        self.assertIn("32 x 32", errors)

    def test_several_pictures(self):
        for i in range(12):
            save(f"f{i:02d}.png", numpy.full((16, 16, 3), i * 20, numpy.uint8))
        names = [f"f{i:02d}.png" for i in range(12)]
        self.ztex("make", *names, "--frames", "-o", "out.ztex")
        self.ztex("make", "f%02d.png", "--frames", "-o", "same.ztex")
        with open("out.ztex", "rb") as a, open("same.ztex", "rb") as b:
            self.assertEqual(a.read(), b.read())
        image = self.probe("out.ztex")["images"][0]
        self.assertEqual((image["layers"], image["layer_kind"]), (12, 2))
        self.assertTrue((self.texels("out.ztex").reshape(12, -1) == numpy.arange(12)[:, None] * 20).all())
        self.ztex("make", *names[:6], "--cube", "-o", "out.ztex")
        self.assertEqual(self.probe("out.ztex")["images"][0]["layer_kind"], 1)
        self.ztex("make", *names[:5], "--cube", "-o", "x.ztex", status=USAGE)
        self.ztex("make", *names, "--volume", "-o", "out.ztex")
        self.assertEqual(self.probe("out.ztex")["images"][0]["size"], [16, 16, 12])
        self.ztex("make", *names[:3], "--array", "-o", "out.ztex")
        self.assertEqual(self.probe("out.ztex")["images"][0]["layers"], 3)
        save("g.png", ramps())
        _, errors = self.ztex("make", "f00.png", "g.png", "--array", "-o", "x.ztex", status=USAGE)
        self.assertIn("g.png is 64 x 48", errors)

    def test_gif_frames(self):
        frames = [Image.fromarray(numpy.full((16, 16, 3), 40 * i + 20, numpy.uint8)) for i in range(4)]
        frames[0].save("a.gif", save_all=True, append_images=frames[1:])
        self.ztex("make", "a.gif", "--frames", "-o", "out.ztex")
        self.assertEqual(self.probe("out.ztex")["images"][0]["layers"], 4)
        middle = self.texels("out.ztex").reshape(4, 16, 16, 4)[:, 8, 8, 0]
        self.assertTrue((middle == [20, 60, 100, 140]).all(), middle)


class Files(support.Case):
    def test_streams(self):
        save("p.png", ramps())
        self.ztex("make", "p.png", "--name", "", "-o", "p.ztex")
        with open("p.png", "rb") as file:
            out, _ = self.ztex("make", "-", "-o", "-", data=file.read())
        with open("p.ztex", "rb") as file:
            self.assertEqual(out, file.read())
        self.trace_free("p.png", "p.ztex")

    def test_threads_do_not_matter(self):
        save("p.png", ramps(700, 500, 4))
        for threads in ("1", "2", "7"):
            self.ztex("make", "p.png", "-o", f"{threads}.ztex", "--threads", threads, "--tile-edge", "64")
        with open("1.ztex", "rb") as a, open("2.ztex", "rb") as b, open("7.ztex", "rb") as c:
            first = a.read()
            self.assertTrue(first == b.read() == c.read())

    def test_failures_leave_the_output_alone(self):
        save("p.png", ramps(256, 256))
        with open("p.png", "rb") as file:
            whole = file.read()
        with open("cut.png", "wb") as file:
            file.write(whole[: len(whole) // 2])
        with open("text.png", "w") as file:
            file.write("no picture")
        with open("out.ztex", "w") as file:
            file.write("precious")
        before = sorted(os.listdir("."))
        for name in ("missing.png", "text.png", "cut.png"):
            _, errors = self.ztex("make", name, "-o", "out.ztex", status=IO, leaks=False)
            self.assertIn(name, errors)
            self.trace_free(*before)
            with open("out.ztex") as file:
                self.assertEqual(file.read(), "precious")
        self.ztex("make", "p.png", "-o", "no/folder/x.ztex", status=IO)

    def test_inputs_are_never_overwritten(self):
        save("p.png", ramps())
        os.link("p.png", "q.png")
        for output in ("p.png", "./p.png", "q.png"):
            _, errors = self.ztex("make", "p.png", "-o", output, status=USAGE)
            self.assertIn("overwritten", errors)
        save("n.png", ramps())
        self.ztex("make", "p.png", "--layer", "normal=n.png", "-o", "n.png", status=USAGE)
        with Image.open("p.png") as picture:
            self.assertEqual(picture.size, (64, 48))

    def test_devices(self):
        save("p.png", ramps())
        self.ztex("make", "p.png", "-o", "/dev/null")
        self.assertTrue(os.path.exists("/dev/null") and not os.path.isfile("/dev/null"))
        self.ztex("make", "p.png", "-o", "/dev/full", status=IO)

    def test_memory_limit(self):
        save("p.png", ramps())
        with open("p.png", "rb") as file:
            _, errors = self.ztex("make", "-", "-o", "x.ztex", "--memory", "100", data=file.read(), status=LIMIT)
        self.assertIn("--memory", errors)
        self.trace_free("p.png")

    def wait_until_open(self, run, name):
        """Until the process has the file open: then it is at work on it, which takes seconds at effort 9."""
        folder = f"/proc/{run.pid}/fd"
        while run.poll() is None:
            for entry in os.listdir(folder):
                try:
                    if os.path.basename(os.readlink(os.path.join(folder, entry))) == name:
                        return
                except FileNotFoundError:
                    pass  # closed since it was listed
        self.fail(f"the process ended before it opened {name}")

    def test_interruption(self):
        numpy.random.seed(1)
        save("p.png", numpy.random.randint(0, 256, (3000, 3000, 3), numpy.uint8), compress_level=0)
        with open("out.ztex", "w") as file:
            file.write("precious")
        run = subprocess.Popen([ZTEX, "make", "p.png", "-o", "out.ztex", "--effort", "9"], stderr=subprocess.PIPE)
        self.wait_until_open(run, "p.png")
        run.send_signal(signal.SIGINT)
        errors = run.communicate()[1].decode()
        self.assertEqual(run.returncode, CANCELLED, errors)
        self.assertIn("interrupted", errors)
        self.trace_free("out.ztex", "p.png")
        with open("out.ztex") as file:
            self.assertEqual(file.read(), "precious")

    def peak_of(self, width, height):
        """MiB of memory at most while a picture of that size is made into a texture."""
        save("big.png", numpy.tile(ramps(width, 50), (height // 50, 1, 1)), compress_level=0)
        program = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
                   "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
        run = subprocess.run(["/usr/bin/python3", "-c", program, ZTEX, "make", "big.png", "-o", "b.ztex", "--no-fsync",
                              "--effort", "1", "--threads", "2"], stdout=subprocess.PIPE, check=True)
        return int(run.stdout) / 1024

    @unittest.skipIf(support.SANITIZED, "sanitizers need memory of their own")
    def test_big_pictures_stream(self):
        # Both fill what of the compressed tiles is held in memory (64 MiB), so that only the pictures differ.
        low, high = self.peak_of(4000, 6000), self.peak_of(4000, 12000)
        self.assertLess(high - low, 30, "MiB more for 69 MiB more of picture and 92 MiB more of levels")


support.main()
