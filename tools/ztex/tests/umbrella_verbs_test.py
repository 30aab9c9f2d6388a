# SPDX-License-Identifier: Apache-2.0
"""Property: every verb knows umbrella textures: what inspect counts is what is there, the camera of render sees the plane where it is and elements
above it, drawings and models hold the same polygons, and no bit of them is lost by convert and recover. It matters because a texture that only its
maker can look into is of no use to anybody else."""
import json
import os
import re
import xml.etree.ElementTree

import numpy
from PIL import Image

import corpus
import support
from support import DIFFERENT, UNSUPPORTED, USAGE, ramps, save

SOME = ('example', 'forms_mixed', 'sources_mixed', 'levels_3', 'in_zipmap_mask', 'base_in_base_in_base', 'background_of_silmap', 'morph_some',
        'solid_many_repeat', 'no_umbrellas')


def of(name):
    return os.path.join(corpus.folder('valid'), f'umbrella_{name}.ztex')


class Umbrellas(support.Case):
    def inspect(self, path):
        found = json.loads(self.ztex('inspect', '--json', path)[0])
        corpus.validator('inspect').validate(found)
        return found

    def numbers(self, path):
        """Of the textures that are umbrellas."""
        return [i for i, texture in enumerate(self.inspect(path)['textures']) if texture['kind'] == 'umbrellas']

    def pixels(self, path, *words):
        self.ztex('render', path, '-o', 'r.png', *words)
        with Image.open('r.png') as picture:
            return numpy.asarray(picture).astype(float)


class Inspect(Umbrellas):
    def test_all_of_the_corpus(self):
        for name in SOME:
            text = self.ztex('inspect', of(name))[0].decode()
            for texture in self.inspect(of(name))['textures']:
                if texture['kind'] == 'umbrellas':
                    found = texture['umbrellas']
                    self.assertIn(f'{found["cells_x"]} x {found["cells_y"]} cells, {found["umbrellas"]} umbrellas', text)
                    self.assertEqual(sum(level['umbrellas'] for level in found['levels']), found['umbrellas'])
                    self.assertEqual(sum(found['forms'].values()), found['umbrellas'])
                    self.assertEqual(max(level['longest_list'] for level in found['levels']), found['longest_list'])

    def test_account(self):
        """Equations 2 and 3 of the paper, out of the model that extract writes, which counts on its own."""
        found = self.inspect(of('example'))
        umbrellas = found['textures'][0]['umbrellas']
        words = umbrellas['longest_list'] * umbrellas['cells_x'] * umbrellas['cells_y']
        for base in umbrellas['bases']:
            image = found['images'][base['image']]
            words += image['width'] * image['height'] + 2 * base['vertices']
        svg = self.ztex('extract', of('example'), '--arrangement', '-o', '-')[0].decode()
        polygons = [re.findall(r'[ML]([-\d.e]+) ([-\d.e]+)', path) for path in re.findall(r'<path d="(M[^"]*z)" fill=', svg)]
        self.assertGreaterEqual(len(polygons), umbrellas['levels'][0]['umbrellas'])
        if len(polygons) == umbrellas['levels'][0]['umbrellas']:
            words += sum(1 + 3 * len(polygon) for polygon in polygons)
            self.assertEqual(umbrellas['account']['paper_size'], 4 * words)
        low, mean, high = umbrellas['account']['whole_size']
        self.assertTrue(0 < low <= mean <= high)
        self.assertEqual(umbrellas['account']['file_size'],
                         umbrellas['stored_size'] + sum(image['stored_size'] for image in found['images']))


class Camera(Umbrellas):
    """From straight above, with the field of view that the view fills."""

    def above(self, aspect, height=1.0):
        fov = 2 * numpy.degrees(numpy.arctan(aspect / 2 / height))
        return ['--3d', '--eye', f'0.5,{aspect / 2},{height}', '--target', f'0.5,{aspect / 2},0', '--up', '0,-1,0', '--fov', repr(float(fov))]

    def test_a_picture_from_above_is_the_picture(self):
        save('p.png', ramps(64, 48))
        self.ztex('make', 'p.png', '-o', 'p.ztex', '--wrap', 'clamp')
        flat = self.pixels('p.ztex', '--size', '96x72')
        seen = self.pixels('p.ztex', '--size', '96x72', '--background', '0,0,0', *self.above(0.75))
        self.assertLess(numpy.abs(flat - seen).max(), 2)
        part = self.pixels('p.ztex', '--size', '96x72', '--view', '0.2,0.1,0.6,0.5')
        seen = self.pixels('p.ztex', '--size', '96x72', '--view', '0.2,0.1,0.6,0.5', '--background', '0,0,0', *self.above(0.75))
        self.assertLess(numpy.abs(part - seen).max(), 2)

    def test_flat_umbrellas_from_above_are_the_plane(self):
        grid = self.inspect(of('prism_flat'))['textures'][0]['umbrellas']
        aspect = grid['cells_y'] / grid['cells_x']
        self.assertEqual(grid['prism_height'], 0)
        size = ['--size', f'120x{round(120 * aspect)}', '--background', '0,0,0']
        off = numpy.abs(self.pixels(of('prism_flat'), *size) - self.pixels(of('prism_flat'), *size, '--shadow', '0', *self.above(aspect)))
        self.assertLess(numpy.mean(off > 3), 0.01)

    def test_far_away_heights_are_gone(self):
        """Pixels so large that all is tapered away show the plane, whatever stands there."""
        name = of('solid_convex')
        grid = self.inspect(name)['textures'][0]['umbrellas']
        self.assertGreater(grid['prism_height'], 0)
        wide = round(grid['cells_x'] / grid['taper_end'] * 0.9)
        aspect = grid['cells_y'] / grid['cells_x']
        size = ['--size', f'{wide}x{round(wide * aspect)}', '--background', '0,0,0']
        # From so high that sides of the prism are not seen.
        off = numpy.abs(self.pixels(name, *size) - self.pixels(name, *size, '--shadow', '0', *self.above(aspect, 1000)))
        self.assertLess(numpy.mean(off > 6), 0.05)

    def test_silhouettes(self):
        """From low, elements stand out over the far edge of the ground, and are as they are for any number of threads."""
        name = of('solid_many_clamp')
        grid = self.inspect(name)['textures'][0]['umbrellas']
        aspect, high = grid['cells_y'] / grid['cells_x'], grid['prism_height'] / grid['cells_x']
        pose = ['--3d', '--eye', f'0.5,{aspect + 0.3},{high}', '--target', '0.5,0,0', '--fov', '60', '--size', '480x360']
        self.ztex('render', name, '-o', 'one.png', '--threads', '1', *pose)
        self.ztex('render', name, '-o', 'four.png', '--threads', '4', *pose)
        with open('one.png', 'rb') as one, open('four.png', 'rb') as four:
            self.assertEqual(one.read(), four.read())
        with Image.open('one.png') as picture:
            alpha = numpy.asarray(picture)[..., 3]
        # The far edge lies in the middle row: what is above it has height.
        self.assertGreater(numpy.sum(alpha[:175] > 0), 20)
        self.assertEqual(alpha[0].max(), 0)

    def test_light(self):
        name = of('solid_many_clamp')
        plain = self.pixels(name, '--size', '128', '--background', '0,0,0')
        self.assertTrue((self.pixels(name, '--size', '128', '--background', '0,0,0', '--light', '1,1,1') == plain).all())
        dark = self.pixels(name, '--size', '128', '--background', '0,0,0', '--shadow', '0.6', '--light', '-0.3,-0.3,1')
        self.assertTrue((dark <= plain + 1).all() and (dark < plain - 5).any())

    def test_wrong_words(self):
        save('p.png', ramps())
        self.ztex('make', 'p.png', '-o', 'p.ztex')
        for words in (['--eye', '0,0,1'], ['--fov', '30'], ['--3d', '--eye', '0,0'], ['--3d', '--fov', '180'], ['--3d', '--shadow', '2'],
                      ['--3d', '--eye', '0.5,0.5,1', '--target', '0.5,0.5,0'], ['--3d', '--light', '1,1,-1'], ['--3d', '--ambient', '3'],
                      ['--3d', '--eye', '0,0,0', '--target', '0,0,0']):
            self.ztex('render', 'p.ztex', '-o', 'no.png', *words, status=USAGE)
            self.assertFalse(os.path.exists('no.png'), words)


class Extract(Umbrellas):
    def test_bases(self):
        found = self.inspect(of('morph_some'))
        self.ztex('extract', of('morph_some'), '--bases', 'bases')
        with open('bases/bases.json', encoding='utf-8') as file:
            bases = json.load(file)['bases']
        told = found['textures'][0]['umbrellas']['bases']
        self.assertEqual(len(bases), len(told))
        for base, row in zip(bases, told):
            self.assertEqual(len(base['vertices']), row['vertices'])
            self.assertEqual('morph' in base, row['morph'])
            self.assertEqual([len(variant) for variant in base['variants']], [1 + row['vertices']] * row['variants'])
            image = found['images'][row['image']]
            with Image.open(os.path.join('bases', base['file'])) as picture:
                self.assertEqual(picture.size, (image['width'], image['height']))
            d = numpy.array(base['vertices']) - base['centre']
            e = numpy.roll(d, -1, 0)
            self.assertTrue((d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0] > 0).all())
        self.ztex('extract', of('morph_some'), '--base', '0', '-o', 'one.png')
        _, errors = self.ztex('extract', of('morph_some'), '-o', 'no.png', status=USAGE)
        self.assertIn('--bases', errors)
        self.ztex('extract', of('morph_some'), '--base', '999', '-o', 'no.png', status=USAGE)
        self.ztex('extract', of('base_of_zipmap'), '-t', str(self.numbers(of('base_of_zipmap'))[0]), '--base', '0', '-o', 'no.png', status=USAGE)
        self.assertFalse(os.path.exists('no.png'))

    def test_drawing(self):
        for name in SOME:
            for number in self.numbers(of(name)):
                grid = self.inspect(of(name))['textures'][number]['umbrellas']
                self.ztex('extract', of(name), '-t', str(number), '--arrangement', '-o', 'a.svg')
                root = xml.etree.ElementTree.parse('a.svg').getroot()
                self.assertEqual(root.get('viewBox'), f'0 0 {64 * grid["cells_x"]} {64 * grid["cells_y"]}')
                lists = [int(text.text) for text in root.iter('{http://www.w3.org/2000/svg}text')]
                self.assertEqual(sum(lists), grid['levels'][0]['entries'])

    def read_model(self, name):
        with open(name, encoding='utf-8') as file:
            model = json.load(file)
        with open(model['buffers'][0]['uri'], 'rb') as file:
            data = file.read()
        self.assertEqual(len(data), model['buffers'][0]['byteLength'])
        return model, data

    def values(self, model, data, number):
        accessor = model['accessors'][number]
        view = model['bufferViews'][accessor['bufferView']]
        wide = {'SCALAR': 1, 'VEC2': 2, 'VEC3': 3}[accessor['type']]
        part = numpy.frombuffer(data, '<u4' if accessor['componentType'] == 5125 else '<f4', view['byteLength'] // 4, view['byteOffset'])
        part = part.reshape(-1, view.get('byteStride', 4 * wide) // 4)[:, accessor['byteOffset'] // 4:][:, :wide]
        self.assertEqual(len(part), accessor['count'])
        return part

    def test_model(self):
        for name in ('example', 'forms_mixed', 'solid_many_repeat', 'levels_3', 'base_of_zipmap', 'background_image_repeat'):
            number = self.numbers(of(name))[0]
            grid = self.inspect(of(name))['textures'][number]['umbrellas']
            self.ztex('extract', of(name), '-t', str(number), '--arrangement', '-o', 'with space.gltf')
            self.assertTrue(os.path.exists('with space.bin'))
            model, data = self.read_model_escaped('with space.gltf')
            for part in model['meshes'][0]['primitives']:
                place = self.values(model, data, part['attributes']['POSITION'])
                accessor = model['accessors'][part['attributes']['POSITION']]
                self.assertEqual((list(place.min(0)), list(place.max(0))), (accessor['min'], accessor['max']))
                self.assertLessEqual(place[:, 1].max(), grid['prism_height'] * 1.0001 + 0.011)
                index = self.values(model, data, part['indices'])[:, 0].reshape(-1, 3)
                self.assertLess(index.max(), len(place))
                a, b, c = (place[index[:, i]].astype(float) for i in range(3))
                self.assertGreater(numpy.mean(numpy.cross(b - a, c - a)[:, 1] > 0), 0.99, name)
                normals = self.values(model, data, part['attributes']['NORMAL'])
                self.assertLess(numpy.abs(numpy.linalg.norm(normals, axis=1) - 1).max(), 1e-4)

    def read_model_escaped(self, name):
        with open(name, encoding='utf-8') as file:
            model = json.load(file)
        self.assertEqual(model['buffers'][0]['uri'], 'with%20space.bin')
        model['buffers'][0]['uri'] = 'with space.bin'
        for image in model.get('images', []):
            self.assertTrue(os.path.exists(image['uri'].replace('%20', ' ')), image)
        with open('plain.gltf', 'w', encoding='utf-8') as file:
            json.dump(model, file)
        return self.read_model('plain.gltf')

    def test_coarser_level(self):
        self.ztex('extract', of('levels_3'), '--arrangement', '--level', '2', '-o', 'c.svg')
        self.ztex('extract', of('levels_3'), '--arrangement', '--level', '2', '-o', 'c.gltf')
        self.ztex('extract', of('levels_3'), '--arrangement', '--level', '3', '-o', 'd.gltf', status=USAGE)
        self.trace_free('c.svg', 'c.gltf', 'c.bin')

    def test_what_does_not_fit(self):
        save('p.png', ramps())
        self.ztex('make', 'p.png', '-o', 'p.ztex')
        left = sorted(os.listdir('.'))
        for words in (['p.ztex', '--arrangement', '-o', 'x.svg'], ['p.ztex', '--arrangement', '-o', 'x.gltf'], ['p.ztex', '--bases', 'x'],
                      ['p.ztex', '--base', '0', '-o', 'x.png'], [of('example'), '--arrangement', '-o', 'x.obj'],
                      [of('example'), '--arrangement'], [of('example'), '--arrangement', '--raw', '-o', 'x.svg']):
            self.ztex('extract', *words, status=USAGE)
            self.assertEqual(sorted(os.listdir('.')), left, words)
        # A drawing can do without pictures, a model cannot.
        self.ztex('extract', of('format_bc7'), '--arrangement', '-o', 'bc7.svg')
        self.ztex('extract', of('format_bc7'), '--arrangement', '-o', 'bc7.gltf', status=UNSUPPORTED)
        self.assertFalse(os.path.exists('bc7.gltf') or os.path.exists('bc7.bin'))

    def test_all(self):
        _, errors = self.ztex('extract', of('example'), '--all', 'all', status=UNSUPPORTED)
        self.assertIn('is not in scene.json', errors)
        self.assertEqual(sum(name.endswith('.svg') for name in os.listdir('all')), 1)


class Copies(Umbrellas):
    def test_convert_and_diff(self):
        for name in SOME:
            self.ztex('convert', of(name), '-o', 'same.ztex', '--no-fsync')
            self.ztex('diff', of(name), 'same.ztex')
            self.ztex('convert', of(name), '-o', 'anew.ztex', '--effort', '7', '--no-fsync')
            self.ztex('diff', of(name), 'anew.ztex')
            self.probe('anew.ztex')

    def test_recover(self):
        for name in SOME:
            self.ztex('recover', of(name), '-o', 'whole.ztex')
            self.ztex('diff', of(name), 'whole.ztex')

    def test_differences_are_told(self):
        out = self.ztex('diff', of('morph_0'), of('morph_128'), status=DIFFERENT)[0].decode()
        self.assertRegex(out, r'texels: texture 0/umbrellas: \d+ bytes differ')
        out = self.ztex('diff', of('colours_barycentric'), of('colours_inverse_distance'), status=DIFFERENT)[0].decode()
        self.assertIn('colour_mode: "barycentric" | "inverse-distance"', out)

    def test_what_is_shown_is_kept(self):
        for name in ('base_of_zipmap', 'background_of_silmap', 'base_in_base_in_base'):
            number = self.numbers(of(name))[-1]
            self.ztex('convert', of(name), '-o', 'one.ztex', '--keep-textures', str(number), '--no-fsync')
            before, after = (self.pixels(path, '-t', which, '--size', '48x48', '--background', '0,0,0')
                             for path, which in ((of(name), str(number)), ('one.ztex', str(self.numbers('one.ztex')[-1]))))
            self.assertTrue((before == after).all(), name)


class Composition(Umbrellas):
    """All kinds in one file: a silmap and umbrellas as patches of a zipmap, a zipmap as a base of the umbrellas."""

    def setUp(self):
        super().setUp()
        with open('sign.svg', 'w', encoding='utf-8') as file:
            file.write('<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40"><circle cx="20" cy="20" r="15" fill="#c01020"/></svg>')
        save('wall.png', ramps(64, 48) // 2)
        save('leaf.png', ramps(32, 32))
        square = [[0, 0], [1, 0], [1, 1], [0, 1]]
        places = [{'base': 'leaf', 'at': [1, 1], 'size': 1.2}, {'base': 'card', 'at': [2.5, 1.5], 'size': 1.0}]
        scene = {'textures': [
            {'name': 'sign', 'silmap': {'file': 'sign.svg', 'cells': 12}},
            {'name': 'card', 'wrap': 'clamp', 'patches': [{'image': 'wall.png'}, {'texture': 'sign', 'offset': [0.2, 0.2], 'scale': [0.6, 0.6]}]},
            {'name': 'leaves', 'wrap': 'clamp', 'umbrellas': {
                'grid': [4, 3], 'background': 'none', 'levels': {'count': 1},
                'bases': [{'name': 'leaf', 'image': 'leaf.png', 'outline': square, 'centre': [0.5, 0.5], 'rotation': 0},
                          {'name': 'card', 'texture': 'card', 'outline': square, 'centre': [0.5, 0.5], 'rotation': 0}],
                'arrangement': {'method': 'places', 'places': places}}},
            {'name': 'all', 'wrap': 'clamp', 'patches': [
                {'image': 'wall.png'},
                {'texture': 'leaves', 'offset': [0.5, 0.5], 'scale': [0.4, 0.4]},
                {'texture': 'sign', 'offset': [0.1, 0.1], 'scale': [0.25, 0.25]}]}]}
        with open('scene.json', 'w', encoding='utf-8') as file:
            json.dump(scene, file)
        self.ztex('make', 'scene.json', '-o', 'all.ztex', '--no-fsync')

    def test_structure(self):
        self.probe('all.ztex')
        self.ztex('validate', 'all.ztex')
        found = self.inspect('all.ztex')
        self.assertEqual([texture['kind'] for texture in found['textures']], ['silmap', 'zipmap', 'umbrellas', 'zipmap'])
        self.assertEqual([base['texture'] for base in found['textures'][2]['umbrellas']['bases']], [None, 1])
        self.assertEqual([patch['texture'] for patch in found['textures'][3]['patches']], [None, 2, 0])
        self.ztex('convert', 'all.ztex', '-o', 'copy.ztex', '--keep-textures', 'all', '--no-fsync')
        self.ztex('diff', 'all.ztex', 'copy.ztex')

    def test_each_looks_as_it_does_alone(self):
        black = ['--background', '0,0,0']
        # The card with its sign lies from 2 to 3 across and, a picture of 4 x 3, from 1.125 to 1.875 down in 4 x 3 cells.
        alone = self.pixels('all.ztex', '-t', 'card', '--view', '0.1,0.1,0.9,0.9', '--size', '48x36', *black)
        among = self.pixels('all.ztex', '-t', 'leaves', '--view', '0.525,0.4,0.725,0.6', '--size', '48x36', *black)
        self.assertLess(numpy.mean(numpy.abs(alone - among) > 6), 0.02)
        shown = self.pixels('all.ztex', '-t', 'all', '--view', '0.71,0.66,0.79,0.74', '--size', '48x36', *black)
        self.assertLess(numpy.mean(numpy.abs(alone - shown) > 6), 0.02)
        # The middle of the sign, on the wall and on the card.
        for view in ('0.2,0.2,0.25,0.25', '0.74,0.69,0.76,0.71'):
            self.assertLess(numpy.abs(self.pixels('all.ztex', '-t', 'all', '--view', view, '--size', '8x8', *black) - (0xC0, 0x10, 0x20)).max(), 3)


if __name__ == '__main__':
    support.main()
