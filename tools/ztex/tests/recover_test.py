# SPDX-License-Identifier: Apache-2.0
"""recover makes a valid file of a damaged one, and what was intact stays what it was: a file can be longer ill than its
maker is around."""
import json
import os
import random

import numpy

import corpus
import support


class Recover(support.Case):
    def setUp(self):
        super().setUp()
        self.schema = corpus.validator("recover")

    def recover(self, data, status=None):
        """Recovers bytes to out.ztex, which must be valid; returns the report."""
        with open("bad.ztex", "wb") as file:
            file.write(data)
        status = support.LOSS if status is None else status
        report = json.loads(self.ztex("recover", "--json", "bad.ztex", "-o", "out.ztex", status=status)[0])
        self.schema.validate(report)
        self.assertEqual(report["complete"], status == support.OK)
        self.ztex("validate", "-q", "out.ztex")
        with open("bad.ztex", "rb") as file:
            self.assertEqual(file.read(), data, "the damaged file has changed")
        return report

    def sample(self, *words):
        """A tiled file with levels, as bytes and as inspect sees it."""
        noise = numpy.random.default_rng(1).integers(0, 256, (150, 210, 4), dtype=numpy.uint8)
        support.save("a.png", noise)
        self.ztex("make", "a.png", "-o", "a.ztex", "--tile-edge", "32", "--meta", "zt.title=Noise", *words)
        self.told = corpus.objects(self.ztex("inspect", "--json", "--tiles", "a.ztex")[0])[0]
        with open("a.ztex", "rb") as file:
            return bytearray(file.read())

    def tiles(self, level):
        return self.told["images"][0]["levels"][level]["tiles"]

    def same_texels(self, level, but=()):
        """Levels are equal outside the tiles named in `but` (edge 32)."""
        size = self.told["images"][0]["levels"][level]
        shape = (size["height"], size["width"], 4)
        a = self.texels("a.ztex", 0, level).reshape(shape).copy()
        b = self.texels("out.ztex", 0, level).reshape(shape).copy()
        columns = -(-size["width"] // 32)
        for tile in but:
            y, x = 32 * (tile // columns), 32 * (tile % columns)
            self.assertFalse((a[y:y + 32, x:x + 32] == b[y:y + 32, x:x + 32]).all())
            a[y:y + 32, x:x + 32] = b[y:y + 32, x:x + 32] = 0
        self.assertTrue((a == b).all(), f"level {level}")

    def test_whole_file(self):
        report = self.recover(bytes(self.sample()), support.OK)
        self.assertTrue(report["directory_intact"])
        self.assertEqual(report["metadata_pairs"], 1)
        self.ztex("diff", "a.ztex", "out.ztex")

    def test_tile(self):
        data = self.sample()
        data[self.tiles(0)[9]["offset"] + 5] ^= 0x40
        report = self.recover(bytes(data))
        self.assertEqual([(x["level"], x["tile"], x["fill"]) for x in report["losses"]], [(0, 9, "coarser")])
        self.same_texels(0, [9])
        self.same_texels(1)

    def test_tile_is_filled_from_the_next_level(self):
        data = self.sample()
        data[self.tiles(0)[0]["offset"]] ^= 1
        self.recover(bytes(data))
        fine = self.texels("out.ztex", 0, 0).reshape(150, 210, 4)[:32, :32]
        coarse = self.texels("a.ztex", 0, 1).reshape(75, 105, 4)[:16, :16]
        self.assertTrue((fine == coarse.repeat(2, 0).repeat(2, 1)).all())

    def test_index(self):
        data = self.sample()
        data[self.told["images"][0]["levels"][0]["unit_offset"] + 3] ^= 1
        report = self.recover(bytes(data))
        self.assertEqual(report["tiles_replaced"], len(self.tiles(0)))
        self.same_texels(1)

    def test_tail(self):
        data = self.sample()
        level = self.told["images"][0]["tail_level"]
        data[self.tiles(level)[0]["offset"]] ^= 1
        report = self.recover(bytes(data))
        self.assertEqual([x["fill"] for x in report["losses"]], ["finer"])
        self.same_texels(0)
        self.same_texels(level - 1)

    def test_directory(self):
        data = self.sample()
        for at in (0, 9, 13, 16, 24, 28, 40, 60, 64, 70, 80, 90, 130, 64 + 48 * 3 + 9):
            damaged = data[:]
            damaged[at] ^= 0x55
            report = self.recover(bytes(damaged), support.OK)
            self.assertFalse(report["directory_intact"])
            self.assertEqual(report["tiles_replaced"], 0)
        damaged = data[:]
        damaged[:256] = bytes(256)
        self.recover(bytes(damaged), support.OK)
        self.ztex("diff", "a.ztex", "out.ztex")

    def test_directory_and_head_of_the_texels(self):
        data = self.sample()
        chunk = [c for c in self.told["chunks"] if c["type"] == "TEXL"][0]
        data[:256] = bytes(256)
        data[chunk["offset"]:chunk["offset"] + 64] = bytes(64)
        report = self.recover(bytes(data), support.OK)
        self.assertEqual(report["tiles_replaced"], 0)

    def test_heads_and_padding(self):
        data = self.sample()
        for chunk in self.told["chunks"]:
            data[chunk["offset"] + 20] ^= 1
        self.recover(bytes(data), support.OK)

    def test_textures(self):
        data = self.sample()
        chunk = [c for c in self.told["chunks"] if c["type"] == "TEXS"][0]
        data[chunk["offset"] + 64] ^= 1
        report = self.recover(bytes(data))
        self.assertEqual((report["textures_kept"], report["textures_rebuilt"]), (0, 1))
        told = corpus.objects(self.ztex("inspect", "--json", "out.ztex")[0])[0]
        self.assertEqual([t["name"] for t in told["textures"]], ["recovered 0"])
        self.same_texels(0)

    def test_metadata(self):
        data = self.sample()
        chunk = [c for c in self.told["chunks"] if c["type"] == "META"][0]
        data[chunk["offset"] + 64] ^= 1
        report = self.recover(bytes(data))
        self.assertEqual((report["metadata_pairs"], report["textures_kept"]), (0, 1))
        self.same_texels(0)

    def test_images_lost(self):
        data = self.sample()
        chunk = [c for c in self.told["chunks"] if c["type"] == "IMAG"][0]
        data[chunk["offset"] + 64] ^= 1
        with open("bad.ztex", "wb") as file:
            file.write(data)
        self.ztex("recover", "bad.ztex", "-o", "out.ztex", status=support.INVALID)
        self.assertFalse(os.path.exists("out.ztex"))

    def test_truncated(self):
        data = self.sample()
        texels = [c for c in self.told["chunks"] if c["type"] == "TEXL"][0]["offset"]
        places = [texels, texels + 10, texels + 64, len(data) - 1, len(data) - 17]
        places += [random.Random(7).randrange(texels, len(data)) for _ in range(6)]
        for size in places:
            report = self.recover(bytes(data[:size]), support.OK if size >= len(data) - 1 and not data[-1] else None)
            self.assertTrue(report["directory_intact"])
            # Coarse levels come first: what is before the cut is whole.
            for level in range(len(self.told["images"][0]["levels"])):
                l = self.told["images"][0]["levels"][level]
                if l["unit_offset"] + l["unit_size"] <= size:
                    self.same_texels(level)

    def test_patches_lose_coverage_not_truth(self):
        name = os.path.join(corpus.folder("valid"), "zip_patch_tiled.ztex")
        told = corpus.objects(self.ztex("inspect", "--json", "--tiles", name)[0])[0]
        with open(name, "rb") as file:
            data = bytearray(file.read())
        image = told["textures"][0]["patches"][1]["images"][0]
        for level in told["images"][image]["levels"]:
            if level.get("tiles"):
                data[level["tiles"][0]["offset"]] ^= 1
        report = self.recover(bytes(data))
        self.assertEqual({x["fill"] for x in report["losses"]}, {"zero"})
        self.assertEqual(report["textures_kept"], 1)

    def test_lost_patches(self):
        for name in ("zip_mask.ztex", "zip_in_zip.ztex", "zip_several.ztex"):
            path = os.path.join(corpus.folder("valid"), name)
            told = corpus.objects(self.ztex("inspect", "--json", path)[0])[0]
            with open(path, "rb") as file:
                data = bytearray(file.read())
            chunk = [c for c in told["chunks"] if c["type"] == "ZPMP"][0]
            data[chunk["offset"] + 64 + 16 + 40] ^= 1
            report = self.recover(bytes(data))
            self.assertGreater(report["textures_lost"], 0, name)
            # In the third file another texture shows the same images.
            self.assertEqual(report["textures_rebuilt"] > 0, name != "zip_several.ztex", name)
            self.assertEqual(report["tiles_replaced"], 0, name)

    def test_random_damage(self):
        data = self.sample()
        dice = random.Random(3)
        for _ in range(12):
            damaged = data[:]
            for _ in range(dice.randrange(1, 12)):
                damaged[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
            with open("bad.ztex", "wb") as file:
                file.write(damaged)
            run = support.subprocess.run([support.ZTEX, "recover", "-q", "bad.ztex", "-o", "out.ztex"], check=False)
            self.assertIn(run.returncode, (support.OK, support.LOSS, support.INVALID))
            if run.returncode != support.INVALID:
                self.ztex("validate", "-q", "out.ztex")

    def test_valid_corpus_loses_nothing(self):
        for path in corpus.paths("valid")[::8]:
            words = ("recover", "-q", path, "-o", "out.ztex")
            if "unsafe" in path or "meta_version" in path:
                self.ztex(*words, status=support.LOSS)
                continue
            self.ztex(*words)
            self.ztex("diff", path, "out.ztex")

    def test_input_is_safe(self):
        self.sample()
        self.ztex("recover", "a.ztex", "-o", "a.ztex", status=support.USAGE)
        self.ztex("recover", "a.ztex", status=support.USAGE)


if __name__ == "__main__":
    support.main()
