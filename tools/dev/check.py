#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The house rules that a machine can see: `./dev check [RULE...]`.

Each rule prints one line with its figures, then what breaks it. An exception is a line with a
reason in check_exceptions.txt; one that is no longer needed is itself an error.
"""

import argparse
import fnmatch
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import csource
import spec

FILE_LINES = 800
FUNCTION_LINES = 60
NESTING = 3

COLUMNS = 120  # clang-format leaves comments as they are

# --- the layers ------------------------------------------------------------------------------------
# libzt/src is flat; a file's layer is its prefix, and a layer sees the ones named behind it.

LAYERS = {
    'base': ('base',),
    'file': ('base', 'file'),
    'zipmap': ('base', 'file', 'zipmap'),
    'silmap': ('base', 'file', 'silmap'),
    'umbrella': ('base', 'file', 'umbrella'),
    'top': ('base', 'file', 'zipmap', 'silmap', 'umbrella', 'top'),
}
LAYER_OF_NAME = [
    ('base_*', 'base'), ('rules.def', 'base'), ('limits.h', 'base'),
    ('file_*', 'file'),
    ('zipmap_*', 'zipmap'), ('silmap_*', 'silmap'), ('umbrella_*', 'umbrella'),
    ('texture*', 'top'), ('validate*', 'top'), ('plan*', 'top'), ('recover*', 'top'), ('zt_*', 'top'),
]

C_HEADERS = set('''assert.h complex.h ctype.h errno.h fenv.h float.h inttypes.h iso646.h limits.h
    locale.h math.h setjmp.h signal.h stdalign.h stdarg.h stdatomic.h stdbool.h stddef.h stdint.h
    stdio.h stdlib.h stdnoreturn.h string.h tgmath.h threads.h time.h uchar.h wchar.h wctype.h'''
                .split())
POSIX_HEADERS = set('''dirent.h fcntl.h getopt.h libgen.h strings.h unistd.h sys/mman.h
    sys/resource.h sys/stat.h sys/time.h sys/types.h sys/wait.h'''.split())

# (files, headers that they may include beside libc, their own folder and zt/*.h)
EXTERNALS = [
    ('libzt/src/base_threads.c', ('pthread.h',)),
    ('libzt/src/file_pred_avx2.c', ('immintrin.h',)),
    ('libzt/src/file_pred_avx512.c', ('immintrin.h',)),
    ('libzt/src/base_hash_avx2.c', ('immintrin.h',)),
    ('libzt/src/base_hash_avx512.c', ('immintrin.h',)),
    ('libzt/src/file_pred_lanes.c', ('arm_neon.h', 'smmintrin.h')),
    ('libzt/src/*', ('zstd.h', 'zstd_errors.h', 'xxhash.h')),
    ('libzt/tests/test_*', ('pthread.h', 'zstd.h', 'xxhash.h')),
    ('libzt/tests/*', ('pthread.h',)),
    ('libzt/tests/api_write_faults.c', ('sys/syscall.h',)),
    ('tools/*oiio*.cpp', ('OpenImageIO/*',)),
    ('tools/*image_*.cpp', ('OpenImageIO/*',)),
    # The shim's own C++ header, which only its sources see.
    ('tools/ztex/image_support.h', ('OpenImageIO/*', 'cstdio', 'exception', 'new', 'stdexcept', 'string')),
    # The mutator seals what it changes.
    ('fuzz/*', ('zstd.h', 'xxhash.h')),
    ('tools/*_cv.cpp', ('opencv2/*',)),
    ('tools/ztex/vector_drawing.c', ('cairo-svg.h', 'librsvg/rsvg.h')),
    ('tools/ztex/vector_svg.c', ('glib.h',)),
    ('tools/ztex/vector_text.c', ('ft2build.h',)),
    # The peers of the codec benchmark.
    ('tools/bench/silmap_*', ('author_silmap.h', 'librsvg/rsvg.h')),
    ('tools/bench/codec_*.c', ('png.h', 'spng.h', 'qoi.h', 'webp/*', 'jxl/*', 'OpenEXR/openexr.h', 'zstd.h')),
    ('tools/bench/codec_zt.c', ('sched.h',)),
    ('tools/ztex/module.c', ('dlfcn.h',)),
    ('tools/author/tests/pair_test.c', ('dlfcn.h',)),
    ('tools/author/tests/register_test.c', ('dlfcn.h',)),
    ('tools/author/tests/select_test.c', ('dlfcn.h',)),
    # The authoring library.
    ('tools/ztex/*', ('author*.h',)),
    ('tools/ztex/pyramid_xml.c', ('expat.h',)),
    ('tools/*', ('jansson.h', 'pthread.h')),
]

# (file, headers of libzt's inside that it may include all the same)
INNER = [
    # Hashes and geometry in front of the tile decoder would take most of the time: it is fuzzed alone.
    ('fuzz/fuzz_tile.c', ('libzt/src/base_hash.h', 'libzt/src/file_codec.h', 'libzt/src/file_fields.h',
                          'libzt/tests/fence.h')),
    # libzt takes the fastest decoder by itself; the bench also times the plain one.
    ('tools/bench/codec_plain.c', ('libzt/src/file_codec.h', 'libzt/src/file_open.h')),
]

# --- the repository --------------------------------------------------------------------------------


@dataclass
class Problem:
    where: str  # path, path:function or path:line; what an exception names
    text: str


@dataclass
class Result:
    figures: str
    problems: list = field(default_factory=list)

    def add(self, where, text):
        self.problems.append(Problem(where, text))


class Repository:
    def __init__(self, root):
        self.root = Path(root)
        self.paths = sorted(self.list_paths())
        self.cache = {}

    def list_paths(self):
        git = subprocess.run(
            ['git', '-C', self.root, 'ls-files', '-z', '-co', '--exclude-standard'],
            capture_output=True, text=True, check=False)
        if git.returncode == 0:
            names = git.stdout.split('\0')
            return {name for name in names if name and (self.root / name).is_file()}
        found = set()
        for folder, folders, files in os.walk(self.root):
            folders[:] = [f for f in folders if f not in ('build', 'out', '.git', '__pycache__')]
            found.update(str((Path(folder) / f).relative_to(self.root)) for f in files)
        return found

    def text(self, path):
        """The text of a file; None for a binary one."""
        if path not in self.cache:
            data = (self.root / path).read_bytes()
            binary = b'\0' in data or path.endswith('.ztex')
            self.cache[path] = None if binary else data.decode('utf-8', 'replace')
        return self.cache[path]

    def match(self, *patterns):
        return [p for p in self.paths if any(fnmatch.fnmatchcase(p, q) for q in patterns)]

    def c_sources(self):
        return self.match('*.c', '*.h', '*.cpp')

    def sources(self):
        """Everything that carries a banner."""
        named = set(self.match('*.c', '*.h', '*.cpp', '*.def', '*.glsl', '*.py', '*.sh', '*.js',
                               '*.cmake', '*CMakeLists.txt', '*.magic', '*.ksy'))
        return sorted(named | {p for p in self.paths if (self.text(p) or '').startswith('#!')})

    def lines(self, paths):
        for path in paths:
            for number, line in enumerate((self.text(path) or '').split('\n'), 1):
                yield path, number, line


# --- formatting ------------------------------------------------------------------------------------


def check_format(repo):
    """C and C++ sources are what clang-format-14 makes of them"""
    sources = repo.c_sources()
    result = Result(f'{len(sources)} files')
    if not sources:
        return result
    run = subprocess.run(['clang-format-14', '--dry-run', '-Werror', '--', *sources],
                         cwd=repo.root, capture_output=True, text=True, check=False)
    places = {}
    for path, line in re.findall(r'^(.+?):(\d+):\d+: error:', run.stderr, re.M):
        places.setdefault(path, []).append(line)
    for path, lines in places.items():
        result.add(path, f'{len(lines)} places, first in line {lines[0]}; ./dev format')
    if run.returncode != 0 and not places:
        result.add('clang-format-14', run.stderr.strip())
    return result


def check_blanks(repo):
    """no tabs, no blanks at the end of a line, a newline at the end of a file; C of 120 columns, comments too"""
    paths = [p for p in repo.paths if repo.text(p) is not None]
    result = Result(f'{len(paths)} files')
    for path, number, line in repo.lines(paths):
        if '\t' in line:
            result.add(f'{path}:{number}', 'a tab')
        if line != line.rstrip():
            result.add(f'{path}:{number}', 'blanks at the end')
        if path.endswith(('.c', '.h', '.cpp')) and len(line) > COLUMNS:
            result.add(f'{path}:{number}', f'longer than {COLUMNS} columns')
    for path in paths:
        if repo.text(path) and not repo.text(path).endswith('\n'):
            result.add(path, 'no newline at the end')
    return result


def check_banner(repo):
    """each source names its licence in its first line"""
    sources = repo.sources()
    result = Result(f'{len(sources)} files')
    for path in sources:
        lines = repo.text(path).split('\n')
        first = lines[1:2] if lines[0].startswith('#!') else lines[:1]
        if 'SPDX-License-Identifier: Apache-2.0' not in ''.join(first):
            result.add(path, 'no SPDX-License-Identifier')
    return result


# --- names and words -------------------------------------------------------------------------------


def check_names(repo):
    """base names are unique within libzt; a .c and its .h share one"""
    paths = [p for p in repo.match('libzt/*') if not p.endswith('CMakeLists.txt')]
    result = Result(f'{len(paths)} files')
    seen = {}
    for path in paths:
        name = PurePosixPath(path)
        for other in seen.setdefault(name.stem, []):
            if {name.suffix, other.suffix} != {'.c', '.h'}:
                result.add(path, f'the same base name as {other}')
        seen[name.stem].append(name)
    return result


def check_todo(repo):
    """a mark for later carries its reason in brackets: MARK(reason): what"""
    word = 'TO' 'DO'  # in two halves, so that this file has none
    marks = '|'.join((word, 'FIX' 'ME', 'X' * 3))
    result = Result('')
    count = 0
    for path, number, line in repo.lines(repo.sources()):
        if re.search(rf'\b({marks})\b', line):
            count += 1
            if not re.search(rf'\b{word}\([^)]{{8,}}\): \S', line):
                result.add(f'{path}:{number}', line.strip())
    result.figures = f'{count} marks'
    return result


def check_paths(repo):
    """no absolute path of somebody's machine"""
    result = Result(f'{len(repo.paths)} files')
    pattern = re.compile(r'(?:^|[\s"\'`=(:<])(/(?:home|root|work|tmp|Users|mnt|media)/[\w.-]+)')
    for path, number, line in repo.lines(p for p in repo.paths if repo.text(p) is not None):
        for found in pattern.findall(line):
            result.add(f'{path}:{number}', found)
    return result


# --- layers ----------------------------------------------------------------------------------------


def layer_of(name):
    for pattern, layer in LAYER_OF_NAME:
        if fnmatch.fnmatchcase(name, pattern):
            return layer
    return None


def includes(repo, path):
    for number, line in enumerate(repo.text(path).split('\n'), 1):
        match = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
        if match:
            yield number, match.group(1), match.group(2)


def external_allowed(path, header):
    if header.startswith('zt/') or header in C_HEADERS:
        return True
    if header in POSIX_HEADERS:
        return not path.startswith('libzt/include/')
    if path.endswith('.cpp') and re.fullmatch(r'[a-z_]+', header):
        return True  # the C++ library
    return any(fnmatch.fnmatchcase(path, files) and
               any(fnmatch.fnmatchcase(header, h) for h in headers)
               for files, headers in EXTERNALS)


def quoted_problem(repo, path, header):
    """Why `path` may not include "header", or None."""
    folder = PurePosixPath(path).parent
    if path.startswith('libzt/src/'):
        if f'libzt/src/{header}' not in repo.paths:
            return f'"{header}" is not in libzt/src'
        own, other = layer_of(folder.joinpath(path).name), layer_of(header)
        if own and other and other not in LAYERS[own]:
            return f'layer {own} may not see {header} (layer {other})'
        return None
    if fnmatch.fnmatchcase(path, 'libzt/tests/test_*') and f'libzt/src/{header}' in repo.paths:
        return None
    if any(path == file and PurePosixPath(inner).name == header for file, inners in INNER for inner in inners):
        return None
    target = os.path.normpath(folder / header)
    if target not in repo.paths and folder.name == 'tests':
        target = os.path.normpath(folder.parent / header)
    if target not in repo.paths:
        return f'"{header}" is not in its own folder'
    unit = '/'.join(path.split('/')[:2]) if path.startswith(('libzt', 'tools')) else str(folder)
    if not target.startswith(unit + '/'):
        return f'"{header}" is outside {unit}'
    return None


def check_layers(repo):
    """each file includes only what its layer may see"""
    paths = repo.match('libzt/*.[ch]', 'libzt/*.cpp', 'tools/*.[ch]', 'tools/*.cpp', 'fuzz/*.[ch]',
                       'fuzz/*.cpp')
    result = Result('')
    count = 0
    for path in paths:
        name = PurePosixPath(path).name
        if path.startswith('libzt/src/') and layer_of(name) is None:
            result.add(path, 'its prefix is no layer of the table')
        for number, kind, header in includes(repo, path):
            count += 1
            problem = None
            if kind == '"' and not header.startswith('zt/'):
                problem = quoted_problem(repo, path, header)
            elif not external_allowed(path, header):
                problem = f'<{header}> is not for this file'
            if problem:
                result.add(f'{path}:{number}', problem)
    result.figures = f'{count} includes in {len(paths)} files'
    return result


def compile_alone(repo, language, header):
    compiler, flags = language
    run = subprocess.run(
        [compiler, *flags, '-pedantic', '-Wall', '-Wextra', '-Werror', '-fsyntax-only',
         '-Ilibzt/include', '-Ilibzt/src', '-'],
        input=f'#include "{header}"\ntypedef int not_empty;\n', cwd=repo.root,
        capture_output=True, text=True, check=False)
    return run.stderr.split('\n')[0] if run.returncode != 0 else None


def check_headers(repo):
    """public headers compile alone as C99 and C++11, internal ones as C11"""
    c99 = ('gcc', ('-x', 'c', '-std=c99'))
    c11 = ('gcc', ('-x', 'c', '-std=c11', '-D_POSIX_C_SOURCE=200809L'))
    cxx11 = ('g++', ('-x', 'c++', '-std=c++11'))
    public = repo.match('libzt/include/zt/*.h')
    internal = repo.match('libzt/src/*.h')
    jobs = [(path, language, 'zt/' + PurePosixPath(path).name)
            for path in public for language in (c99, cxx11)]
    jobs += [(path, c11, PurePosixPath(path).name) for path in internal]
    result = Result(f'{len(public)} public, {len(internal)} internal')
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        errors = pool.map(lambda job: compile_alone(repo, job[1], job[2]), jobs)
        for (path, language, _), error in zip(jobs, errors):
            if error:
                result.add(path, f'{language[1][2]}: {error}')
    return result


# --- sizes -----------------------------------------------------------------------------------------


def check_sizes(repo):
    """files, functions and nesting stay small"""
    sources = repo.c_sources()
    result = Result('')
    lengths = []
    for path in sources:
        text = repo.text(path)
        lines = text.count('\n')
        if path.endswith(('.c', '.cpp')) and lines > FILE_LINES:
            result.add(path, f'{lines} lines, at most {FILE_LINES}')
        try:
            functions = csource.functions(text)
        except (csource.ScanError, IndexError) as error:
            result.add(path, f'cannot be scanned: {error}')
            continue
        for function in functions:
            lengths.append(function.lines)
            where = f'{path}:{function.name}'
            if function.lines > FUNCTION_LINES:
                result.add(where, f'{function.lines} lines, at most {FUNCTION_LINES}')
            if function.nesting > NESTING:
                result.add(where, f'nesting {function.nesting}, at most {NESTING}')
    lengths.sort()
    if lengths:
        result.figures = (f'{len(lengths)} functions, median {lengths[len(lengths) // 2]} lines, '
                          f'longest {lengths[-1]}')
    return result


# --- rules of the format ---------------------------------------------------------------------------


def duplicates(items):
    return sorted({item for item in items if items.count(item) > 1})


def invalid_files(repo, result):
    """Rule ids that conformance/invalid/manifest.json gives a file for; None without a manifest."""
    path = 'conformance/invalid/manifest.json'
    if path not in repo.paths:
        return None
    covered = set()
    for entry in json.loads(repo.text(path)):
        rule = str(entry['rule']).lstrip('R')
        covered.add(rule)
        if f'conformance/invalid/{entry["file"]}' not in repo.paths:
            result.add(path, f'{entry["file"]} does not exist')
    return covered


def check_rules(repo):
    """a rule of the spec = a row of rules.def = a file in conformance/invalid"""
    table = 'libzt/src/rules.def'
    result = Result('nothing to check')
    if table not in repo.paths:
        return result
    rows = [(rule, re.findall(r'"(\w+\.md#[\w.]+)"', rest)) for rule, rest in
            re.findall(r'^\s*ZT_RULE_DEF\(\s*(\d{4})\b(.*)', repo.text(table), re.M)]
    anchors = {rule: anchor for rule, found in rows for anchor in found[:1]}
    rows = [rule for rule, _ in rows]
    marks = {}
    for path in repo.match('spec/*.md'):
        for mark in spec.rules(repo.text(path)):
            if mark.id in marks:
                result.add(f'{path}:{mark.line}', f'R{mark.id} is also in {marks[mark.id]}')
            marks[mark.id] = f'{path}:{mark.line}'
            anchor = f'{PurePosixPath(path).name}#{mark.number()}'
            if anchors.get(mark.id, anchor) != anchor:
                result.add(table, f'R{mark.id} points to {anchors[mark.id]}, but is in {anchor}')
    covered = invalid_files(repo, result)

    for rule in duplicates(rows):
        result.add(table, f'R{rule} has two rows')
    for rule in sorted(marks.keys() - set(rows)):
        result.add(marks[rule], f'R{rule} has no row in {table}')
    # The band 1xxx is about reading and limits, not about files.
    of_files = {rule for rule in rows if not rule.startswith('1')}
    for rule in sorted(of_files - marks.keys()) if marks else []:
        result.add(table, f'R{rule} stands in no margin of spec/')
    if covered is not None:
        for rule in sorted(of_files - covered):
            result.add(table, f'R{rule} has no file in conformance/invalid')
        for rule in sorted(covered - set(rows)):
            result.add('conformance/invalid/manifest.json', f'R{rule} is no rule')
    files = 'no manifest yet' if covered is None else f'{len(covered)} with a file'
    result.figures = f'{len(rows)} rows, {len(marks)} marks in spec/, {files}'
    return result


# --- running ---------------------------------------------------------------------------------------

RULES = {
    'format': check_format,
    'blanks': check_blanks,
    'banner': check_banner,
    'names': check_names,
    'todo': check_todo,
    'paths': check_paths,
    'layers': check_layers,
    'headers': check_headers,
    'sizes': check_sizes,
    'rules': check_rules,
}


class Exceptions:
    """Lines `RULE WHERE reason`; # starts a comment."""

    FILE = 'tools/dev/check_exceptions.txt'

    def __init__(self, repo):
        self.reasons = {}
        self.broken = []
        if self.FILE not in repo.paths:
            return
        for number, line in enumerate(repo.text(self.FILE).split('\n'), 1):
            words = line.split('#')[0].split(None, 2)
            if len(words) == 3 and words[0] in RULES:
                self.reasons[words[0], words[1]] = number
            elif words:
                self.broken.append((number, 'not RULE WHERE reason'))
        self.unused = dict(self.reasons)

    def excuses(self, rule, problem):
        key = (rule, problem.where)
        self.unused.pop(key, None)
        return key in self.reasons

    unused = {}

    def problems(self, ran):
        stale = [(number, f'{rule} {where}: no longer needed')
                 for (rule, where), number in self.unused.items() if rule in ran]
        return [Problem(f'{self.FILE}:{number}', text) for number, text in self.broken + stale]


def report(name, figures, problems):
    print(f'{"FAIL" if problems else "pass"}  {name:<11} {figures}')
    for problem in problems:
        print(f'      {problem.where}: {problem.text}')
    return not problems


def run(repo, names):
    exceptions = Exceptions(repo)
    good = True
    for name in names:
        result = RULES[name](repo)
        problems = [p for p in result.problems if not exceptions.excuses(name, p)]
        excused = len(result.problems) - len(problems)
        figures = result.figures + (f', {excused} excused' if excused else '')
        good = report(name, figures, problems) and good
    return report('exceptions', f'{len(exceptions.reasons)} listed', exceptions.problems(names)) \
        and good


def main():
    parser = argparse.ArgumentParser(prog='./dev check', description=__doc__.split('\n')[0])
    parser.add_argument('rules', nargs='*', metavar='RULE', help='only these rules')
    parser.add_argument('--list', action='store_true', help='name the rules')
    parser.add_argument('--sources', action='store_true', help='list the C and C++ sources')
    parser.add_argument('--root', default=Path(__file__).resolve().parents[2],
                        help='the repository (default: this one)')
    options = parser.parse_args()
    if options.list:
        for name, rule in RULES.items():
            print(f'{name:<11} {rule.__doc__}')
        return 0
    repo = Repository(options.root)
    if options.sources:
        for path in repo.c_sources():
            print(path)
        return 0
    unknown = [name for name in options.rules if name not in RULES]
    if unknown:
        parser.error(f'no rule called {", ".join(unknown)}; --list names them')
    return 0 if run(repo, options.rules or list(RULES)) else 1


if __name__ == '__main__':
    sys.exit(main())
