# SPDX-License-Identifier: Apache-2.0
"""Finds the functions of a C or C++ source, their length and their nesting.

Not a compiler: it reads formatted code of this project, without expanding macros, and says so
(ScanError) when the braces do not add up.
"""

import re
from dataclasses import dataclass


class ScanError(Exception):
    pass


@dataclass
class Function:
    name: str
    line: int  # of the first line of the signature
    lines: int
    nesting: int  # control statements inside each other; 0 for straight-line code


def blank(text):
    """The same text, line for line, without comments, literals and preprocessor lines."""
    pattern = re.compile(
        r'//(?:\\\n|[^\n])*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)

    def spaces(match):
        token = match.group()
        fill = '0' if token[0] in '"\'' else ' '
        return fill + '\n' * token.count('\n')

    text = pattern.sub(spaces, text)
    return re.sub(r'^[ \t]*#(?:\\\n|[^\n])*', lambda m: '\n' * m.group().count('\n'), text,
                  flags=re.M)


def tokens(text):
    line = 1
    for match in re.finditer(r'\n|[A-Za-z_]\w*|::|[0-9][\w.]*|[^\s]', text):
        if match.group() == '\n':
            line += 1
        else:
            yield match.group(), line


class Scanner:
    def __init__(self, text):
        self.tokens = list(tokens(blank(text)))
        self.at = 0
        self.functions = []

    def word(self, ahead=0):
        index = self.at + ahead
        return self.tokens[index][0] if index < len(self.tokens) else ''

    def line(self):
        return self.tokens[min(self.at, len(self.tokens) - 1)][1]

    def fail(self, what):
        raise ScanError(f'line {self.line()}: {what}')

    def skip_group(self):
        """From an opening bracket to behind its closing one."""
        pairs = {'(': ')', '[': ']', '{': '}'}
        stack = []
        while self.at < len(self.tokens):
            word = self.word()
            self.at += 1
            if word in pairs:
                stack.append(pairs[word])
            elif word in pairs.values():
                if word != stack.pop():
                    self.fail('brackets do not match')
                if not stack:
                    return
        self.fail('a bracket is never closed')

    # --- outside functions ---------------------------------------------------------------------

    def declarations(self, closing):
        """Declarations up to `closing` ('' at the end of the file), collecting functions."""
        head = []  # (word, line) of the declaration so far, bracket groups left out
        while self.at < len(self.tokens):
            word, line = self.tokens[self.at]
            if word == closing:
                self.at += 1
                return
            if word == ';':
                head = []
                self.at += 1
            elif word == '(' and head:
                head.append(('(', line))
                self.skip_group()
            elif word in '([':
                self.skip_group()
            elif word == '{':
                head = self.brace(head)
            else:
                head.append((word, line))
                self.at += 1
        if closing:
            self.fail('a bracket is never closed')

    def brace(self, head):
        words = [word for word, _ in head]
        if '=' in words:
            self.skip_group()
            return head
        if '(' in words and words[0] not in ('enum', 'typedef'):
            self.function(head)
            return []
        if 'namespace' in words or 'extern' in words or 'class' in words or 'struct' in words:
            self.at += 1
            self.declarations('}')
            return []
        self.skip_group()
        return []

    def function(self, head):
        words = [word for word, _ in head]
        opening = words.index('(')
        # A leading macro with arguments, such as ATTRIBUTE(x), is not the name.
        while '(' in words[opening + 1:] and words[opening - 1].isupper():
            opening = words.index('(', opening + 1)
        name = words[opening - 1]
        first = head[0][1]
        self.at += 1
        nesting = self.statements()
        last = self.tokens[self.at - 1][1]
        self.functions.append(Function(name, first, last - first + 1, nesting))

    # --- inside functions ----------------------------------------------------------------------

    def statements(self):
        """Statements up to the closing brace, which is eaten; the deepest nesting among them."""
        deepest = 0
        while self.word() != '}':
            if not self.word():
                self.fail('a function is never closed')
            deepest = max(deepest, self.statement())
        self.at += 1
        return deepest

    def statement(self):
        word = self.word()
        if word == '{':
            self.at += 1
            return self.statements()
        if word in ('if', 'for', 'while', 'switch', 'catch'):
            return self.control()
        if word == 'do':
            self.at += 1
            depth = 1 + self.statement()
            self.expression()
            return depth
        if word == 'try':
            self.at += 1
            return self.statement()
        if word == 'case':
            while self.word() != ':':
                self.at += 1
            self.at += 1
            return 0
        if self.word(1) == ':' and (word == 'default' or re.match(r'[A-Za-z_]', word)):
            self.at += 2
            return 0
        return self.expression()

    def control(self):
        is_if = self.word() == 'if'
        while self.word() != '(':
            self.at += 1  # the keyword, and C++'s constexpr
        self.skip_group()
        depth = 1 + self.statement()
        if is_if and self.word() == 'else':
            self.at += 1
            chained = self.word() == 'if'  # else if goes on with the chain, it does not nest
            other = self.statement()
            depth = max(depth, other if chained else 1 + other)
        return depth

    def expression(self):
        start = self.at
        while self.word() != ';':
            if self.word() in ('(', '[', '{'):
                called = self.word() == '(' and self.at == start + 1 and self.word(-1) != 'return'
                self.skip_group()
                if called and self.word() == '{':
                    return 1 + self.statement()  # name(...) { ... }: a macro that loops
            elif self.word() in ('}', ''):
                self.fail('a statement has no end')
            else:
                self.at += 1
        self.at += 1
        return 0


def functions(text):
    scanner = Scanner(text)
    scanner.declarations('')
    return scanner.functions
