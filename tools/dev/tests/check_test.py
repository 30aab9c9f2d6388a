#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Property: every rule of `./dev check` sees what it is for, and is quiet about a clean tree.

A check that cannot fail is worse than none, so each is shown a small repository with one fault.
"""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.dont_write_bytecode = True

import check  # noqa: E402
import csource  # noqa: E402

C = '// SPDX-License-Identifier: Apache-2.0\n'
CLEAN = {
    '.clang-format': (Path(__file__).resolve().parents[3] / '.clang-format').read_text(),
    'libzt/include/zt/zt.h': C + '#include <stddef.h>\nextern size_t zt_size;\n',
    'libzt/src/base_bytes.h': C + '#include <stdint.h>\ntypedef uint8_t zt__byte;\n',
    'libzt/src/base_bytes.c': C + '#include "base_bytes.h"\n',
    'libzt/src/base_threads.c': C + '#include <pthread.h>\n',
    'libzt/src/zipmap_check.h': C,
    'libzt/src/silmap_check.c': C + '#include "base_bytes.h"\n#include <zt/zt.h>\n',
    'libzt/src/rules.def': C + 'ZT_RULE_DEF(1001, a)\nZT_RULE_DEF(2001, "ztex.md#3", b)\n',
    'spec/ztex.md': '## 3. A\n\nSee\n[R2001], and:\n\n[R2001] Must.\n',
    'conformance/invalid/2001.ztex': 'x\n',
    'conformance/invalid/manifest.json': json.dumps([{'file': '2001.ztex', 'rule': 2001}]) + '\n',
    'tools/ztex/verb.c': C + '#include <zt/zt.h>\n#include <jansson.h>\n#include "verb.h"\n',
    'tools/ztex/verb.h': C,
    'tools/ztex/image_io.cpp': C + '#include <OpenImageIO/imageio.h>\n#include <vector>\n',
}


def body(lines):
    return C + 'int f(void) {\n' + '    g();\n' * lines + '}\n'


MARK = 'TO' 'DO'
FAULTS = [
    ('format', {'libzt/src/base_bytes.c': C + 'int  x;\n'}),
    ('blanks', {'spec/ztex.md': '[R2001] Must. \n'}),
    ('blanks', {'spec/ztex.md': '[R2001]\tMust.\n'}),
    ('blanks', {'spec/ztex.md': '[R2001] Must.'}),
    ('blanks', {'libzt/src/base_bytes.c': C + f'/* {"long " * 24}*/\n'}),
    ('banner', {'libzt/src/base_bytes.c': '#include "base_bytes.h"\n'}),
    ('banner', {'tools/run': '#!/bin/sh\necho\n'}),
    ('names', {'libzt/tests/base_bytes.c': C}),
    ('todo', {'tools/ztex/verb.h': C + f'// {MARK}: later\n'}),
    ('paths', {'tools/ztex/verb.h': C + '// see ' + '/ho' + 'me/someone/notes\n'}),
    ('layers', {'libzt/src/base_bytes.c': C + '#include "zipmap_check.h"\n'}),
    ('layers', {'libzt/src/silmap_check.c': C + '#include "zipmap_check.h"\n'}),
    ('layers', {'libzt/src/other_thing.c': C}),
    ('layers', {'libzt/src/base_bytes.c': C + '#include <pthread.h>\n'}),
    ('layers', {'libzt/src/base_bytes.c': C + '#include <jansson.h>\n'}),
    ('layers', {'tools/ztex/verb.c': C + '#include <zstd.h>\n'}),
    ('layers', {'tools/ztex/verb.c': C + '#include "../../libzt/src/base_bytes.h"\n'}),
    ('layers', {'tools/ztex/verb.cpp': C + '#include <OpenImageIO/imageio.h>\n'}),
    ('layers', {'libzt/tests/api_open.c': C + '#include "base_bytes.h"\n'}),
    ('layers', {'fuzz/fuzz_open.c': C + '#include "base_bytes.h"\n'}),
    ('headers', {'libzt/include/zt/zt.h': C + 'extern size_t zt_size;\n'}),
    ('headers', {'libzt/include/zt/zt.h': C + 'extern int new;\n'}),  # a word of C++
    ('headers', {'libzt/src/base_bytes.h': C + 'typedef uint8_t zt__byte;\n'}),
    ('sizes', {'libzt/src/base_bytes.c': body(check.FUNCTION_LINES - 1)}),
    ('sizes', {'libzt/src/base_bytes.c': C + '\n' * check.FILE_LINES}),
    ('sizes', {'libzt/src/base_bytes.c': C + 'int f(void) { if (a) if (b) if (c) if (d) e(); }\n'}),
    ('sizes', {'libzt/src/base_bytes.c': C + 'int f(void) {\n'}),
    ('rules', {'spec/ztex.md': '[R2001] Must.\n\n[R2002] Must.\n'}),
    ('rules', {'libzt/src/rules.def': C + 'ZT_RULE_DEF(2001, b)\nZT_RULE_DEF(2002, c)\n'}),
    ('rules', {'libzt/src/rules.def': C + 'ZT_RULE_DEF(2001, b)\nZT_RULE_DEF(2001, c)\n'}),
    ('rules', {'libzt/src/rules.def': C + 'ZT_RULE_DEF(2001, "ztex.md#4", b)\n'}),
    ('rules', {'conformance/invalid/manifest.json': '[]\n'}),
    ('rules', {'conformance/invalid/manifest.json': '[{"file": "none", "rule": "R2001"}]\n'}),
]


def problems(files, rule):
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            target = Path(root, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
        repo = check.Repository(root)
        exceptions = check.Exceptions(repo)
        found = [p for p in check.RULES[rule](repo).problems if not exceptions.excuses(rule, p)]
        return found + exceptions.problems([rule])


def test_clean():
    for rule in check.RULES:
        assert not problems(CLEAN, rule), (rule, problems(CLEAN, rule))


def test_faults():
    for rule, changed in FAULTS:
        assert problems({**CLEAN, **changed}, rule), f'{rule} does not see {changed}'
    unseen = set(check.RULES) - {rule for rule, _ in FAULTS}
    assert not unseen, f'never shown a fault: {unseen}'


def test_limits_are_inclusive():
    longest = {'libzt/src/base_bytes.c': body(check.FUNCTION_LINES - 2)}
    assert not problems({**CLEAN, **longest}, 'sizes')


def test_exceptions():
    long = {'libzt/src/base_bytes.c': body(100)}
    excuse = {check.Exceptions.FILE: 'sizes libzt/src/base_bytes.c:f a table in disguise\n'}
    assert not problems({**CLEAN, **long, **excuse}, 'sizes')
    assert problems({**CLEAN, **excuse}, 'sizes'), 'an exception that nothing needs'
    no_reason = {check.Exceptions.FILE: 'sizes libzt/src/base_bytes.c:f\n'}
    assert problems({**CLEAN, **long, **no_reason}, 'sizes')


def test_nesting():
    cases = {
        'if (a) b(); else if (c) d(); else if (e) f();': 1,
        'for (;;) { switch (a) { case 1: if (b) c(); break; default: break; } }': 3,
        'do { if (a) goto done; } while (0); done: b();': 2,
        'x = (struct s){.a = {1}}; EACH(i, n) { if (i) c(); }': 2,
        'if (a) { } else { while (b) { } }': 2,
        'char c = \'{\'; s("}\\"{"); /* { */ // }\n': 0,
    }
    for code, depth in cases.items():
        found = csource.functions(f'int f(void) {{ {code} }}')
        assert [f.nesting for f in found] == [depth], (code, found)


def test_functions():
    text = ('#define M(x) { \\\n  {\n'
            'static const int t[] = {1, 2};\nenum e { A };\nstruct s { int (*call)(void); };\n'
            'extern "C" {\nATTRIBUTE(1) static int *\nf(int a,\n  int b) {\n  return 0;\n}\n}\n')
    found = csource.functions(text)
    assert [(f.name, f.line, f.lines) for f in found] == [('f', 7, 5)], found


def main():
    tests = [value for name, value in globals().items() if name.startswith('test_')]
    for test in tests:
        test()
    print(f'{len(tests)} tests, {len(FAULTS)} faults seen')


if __name__ == '__main__':
    main()
