# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""Finds functions of C++ headers by name, and their mutants.

A scanner of tokens and braces, not a parser: it handles comments, strings, preprocessor lines, templates and the
scopes of classes and namespaces, as far as the kernels use them.
"""

import re
from dataclasses import dataclass

TOKEN = re.compile(
    r"""(?P<skip>\s+|//[^\n]*|/\*.*?\*/|(?<![^\n])[ \t]*\#(?:[^\n\\]|\\.)*)
      | (?P<text>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')
      | (?P<number>(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)[uUlLfF]*)
      | (?P<word>[A-Za-z_]\w*)
      | (?P<op><<=|>>=|\.\.\.|::|->|\+\+|--|<<|>=|<=|==|!=|&&|\|\||[-+*/%&|^]=|.)""",
    re.VERBOSE | re.DOTALL,
)
# words before a parenthesis that do not name a function, for example macros
MACRO = re.compile(r"[A-Z][A-Z0-9_]+$")
NO_NAMES = set(
    "alignas decltype noexcept sizeof __attribute__ if for while switch catch return float void".split()
)


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    begin: int
    end: int


@dataclass(frozen=True)
class Function:
    """A definition: its scopes and name, and the tokens of its body including its braces."""

    scopes: tuple
    name: str
    tokens: tuple

    def is_called(self, name):
        """True for 'function', 'Class::function', '::function' outside of classes, or 'Class' for all of its
        functions."""
        wanted = tuple(name.split("::"))
        if name.startswith("::"):
            return ("", self.name) == wanted and not self.scopes
        full = (*self.scopes, self.name)
        return full[-len(wanted) :] == wanted or (self.scopes and self.scopes[-len(wanted) :] == wanted)


def tokens_of(text):
    tokens, position = [], 0
    while position < len(text):
        match = TOKEN.match(text, position)
        if match.lastgroup != "skip":
            tokens.append(Token(match.lastgroup, match.group(), match.start(), match.end()))
        position = match.end()
    return tokens


def closing(tokens, i):
    """Returns the index of the bracket that closes the one at i."""
    pairs = {"(": ")", "{": "}", "[": "]"}
    depth = 0
    for j in range(i, len(tokens)):
        depth += tokens[j].text in pairs
        depth -= tokens[j].text in pairs.values()
        if depth == 0:
            return j
    return len(tokens) - 1


def functions_of(text):
    """Returns all functions that a file defines, including members of classes, in order."""
    tokens, functions = tokens_of(text), []
    scan(tokens, 0, len(tokens), (), functions)
    return functions


def scan(tokens, i, end, scopes, out):
    """Appends the functions from i to end to `out`. A declaration ends with a semicolon or with braces."""
    while i < end:
        name, start = None, i
        while i < end and tokens[i].text not in (";", "{", "}"):
            t = tokens[i].text
            if t == "template" and tokens[i + 1].text == "<":
                i = behind_template(tokens, i + 1)
                continue
            if (
                t == "("
                and name is None
                and i > start
                and tokens[i - 1].kind == "word"
                and tokens[i - 1].text not in NO_NAMES
                and not MACRO.match(tokens[i - 1].text)
            ):
                name = i - 1
            if t in ("(", "["):
                i = closing(tokens, i)
            elif t == ":" and i > start and tokens[i - 1].text in ("public", "private", "protected"):
                start = i + 1
            i += 1
        if i >= end or tokens[i].text != "{":
            i += 1
            continue
        last = closing(tokens, i)
        head = [t.text for t in tokens[start:i]]
        kind = next((k for k in ("namespace", "class", "struct", "union", "enum", "extern") if k in head), None)
        if name is not None and kind != "enum":
            out.append(Function(scopes, tokens[name].text, tuple(tokens[i : last + 1])))
        elif kind in ("class", "struct", "union"):
            named = [t for t in head[head.index(kind) + 1 :] if re.match(r"[A-Za-z_]", t) and t != "alignas"]
            scan(tokens, i + 1, last, (*scopes, named[0] if named else ""), out)
        elif kind in ("namespace", "extern"):
            scan(tokens, i + 1, last, scopes, out)
        i = last + 1


def behind_template(tokens, i):
    """Returns the index after the angle brackets that begin at i."""
    depth = 0
    while i < len(tokens):
        depth += {"<": 1, "<<": 2, ">": -1, ">>": -2}.get(tokens[i].text, 0)
        i += 1
        if depth <= 0:
            return i


# --- operators ----------------------------------------------------------------------------

SWAPS = {
    "relation": {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    "sum": {"+": "-", "-": "+", "+=": "-=", "-=": "+="},
    "shift": {"<<": ">>"},
    "quotient": {"/": "*", "%": "/"},
    "logic": {"&&": "||", "||": "&&"},
    "bits": {"&": "|", "|": "&", "|=": "&=", "&=": "|="},
    "word": {
        "true": "false",
        "false": "true",
        "min": "max",
        "max": "min",
        "floor": "ceil",
        "ceil": "floor",
        "any": "all",
        "all": "any",
    },
}
SWAP_OF = {old: (operator, new) for operator, swaps in SWAPS.items() for old, new in swaps.items()}
UNARY = ("!", "~", "-")
# expressions inside of these are not tested
IGNORED = {"assert", "static_assert", "static_cast", "alignas", "sizeof", "decltype"}


@dataclass(frozen=True)
class Mutant:
    function: str
    operator: str
    begin: int  # position of the replaced text in the file
    end: int
    new: str
    context: str  # tokens before and after it, with the change in brackets

    @property
    def name(self):
        return f"{self.function}, {self.operator}: {self.context}"


def mutants_of(function, text):
    """Returns all mutants of a function, ordered by position."""
    tokens = function.tokens
    full = "::".join((*function.scopes, function.name))
    skipped, in_for, in_angles = regions(tokens)
    out = []

    def add(operator, first, last, new):
        old = text[tokens[first].begin : tokens[last].end]
        context = f"{shown(tokens[max(0, first - 5) : first])} [{old} => {new}] {shown(tokens[last + 1 : last + 6])}"
        out.append(Mutant(full, operator, tokens[first].begin, tokens[last].end, new, context))

    for i, token in enumerate(tokens):
        if i in skipped:
            continue
        t = token.text
        binary = i > 0 and (
            tokens[i - 1].kind in ("word", "number")
            and tokens[i - 1].text != "return"
            or tokens[i - 1].text in (")", "]")
        )
        if i in in_angles:
            pass
        elif t == ">" and i + 1 < len(tokens) and tokens[i + 1].text == ">" and tokens[i + 1].begin == token.end:
            add("shift", i, i + 1, "<<")  # two tokens, because templates may also end this way
            skipped.add(i + 1)
        elif t in ("<", "<=", "!=") and i in in_for:
            add("last round", i, i, f"+1{t}")
        elif token.kind == "op" and t in SWAP_OF and binary and is_operator(tokens, i, text):
            add(SWAP_OF[t][0], i, i, SWAP_OF[t][1])
        elif token.kind == "op" and t in UNARY and not binary and tokens[i + 1].kind != "number":
            add("sign", i, i, "")
        elif token.kind == "word" and t in SWAP_OF and (t in ("true", "false") or tokens[i + 1].text == "("):
            add("word", i, i, SWAP_OF[t][1])
        elif token.kind == "number" and i not in in_for:
            # of a declared array
            is_size = tokens[i - 1].text == "[" and tokens[i - 2].kind == tokens[i - 3].kind == "word"
            if not is_size:
                add("number", i, i, other_number(t))
        if t == "if" and tokens[i + 1].text == "(":
            j = closing(tokens, i + 1)
            inner = text[tokens[i + 1].begin : tokens[j].end]
            out.append(
                Mutant(
                    full,
                    "condition",
                    tokens[i + 1].begin,
                    tokens[j].end,
                    f"(!{inner})",
                    f"[not] if {shown(tokens[i + 1 : j + 1])}",
                )
            )
        if i not in in_for and is_statement(tokens, i):
            j = i
            while tokens[j].text not in (";", "}"):
                j = closing(tokens, j) + 1 if tokens[j].text in ("(", "[", "{") else j + 1
            if tokens[j].text == ";":
                out.append(
                    Mutant(full, "statement", token.begin, tokens[j].end, ";", f"[without] {shown(tokens[i : j + 1])}")
                )
    return out


def shown(tokens):
    return " ".join(t.text for t in tokens[:14])


def regions(tokens):
    """Returns the indices of tokens that are not mutated, of those in the head of a loop, and of those in the angle
    brackets of a template."""
    skipped, in_for, in_angles = set(), set(), set()
    for i, token in enumerate(tokens):
        if token.text in IGNORED and i + 1 < len(tokens) and tokens[i + 1].text == "(":
            skipped.update(range(i, closing(tokens, i + 1) + 1))
        if token.text == "for":
            in_for.update(range(i, closing(tokens, i + 1) + 1))
        if token.text == "<" and i > 0 and tokens[i - 1].kind == "word":
            j, depth = i + 1, 1
            while (
                j < len(tokens)
                and depth > 0
                and (
                    tokens[j].kind in ("word", "number")
                    or tokens[j].text in ("<", ">", ">>", "::", ",", "*", "&", "[", "]", "const")
                )
            ):
                depth += {"<": 1, ">": -1}.get(tokens[j].text, 0)
                j += 1
            if (
                depth == 0
                and j < len(tokens)
                and (tokens[j].kind == "word" or tokens[j].text in ("(", "::", "{", "&", "*", ">", ",", ")"))
                and tokens[i - 1].end == tokens[i].begin
            ):
                in_angles.update(range(i, j))
    return skipped, in_for, in_angles


def is_operator(tokens, i, text):
    """True if the token is not the sign of a reference, a capture or a declared pointer."""
    t = tokens[i]
    if t.text in ("&", "*"):
        return text[t.begin - 1].isspace() and text[t.end].isspace()
    return not (t.text in (">", "<") and tokens[i - 1].text == "operator")


def other_number(t):
    """Returns an integer plus one, or a real number times two."""
    integer = re.fullmatch(r"(0x[0-9a-fA-F]+|\d+)([uUlL]*)", t)
    if integer:
        return f"{int(integer.group(1), 0) + 1}{integer.group(2)}"
    return f"{2*float(t.rstrip('fF')) or 1.0}{'f' if t[-1] in 'fF' else ''}"


def is_statement(tokens, i):
    """True if a removable statement begins at i: an assignment or a call, but not a declaration."""
    no_statements = NO_NAMES | set("else do case default break continue const".split())
    if tokens[i].kind != "word" or tokens[i].text in no_statements:
        return False
    if tokens[i - 1].text not in (";", "{", "}", "else", ")"):  # or after the head of an if or of a loop
        return False
    j = i + 1
    while j < len(tokens) and (tokens[j].text in (".", "->", "::", "[") or tokens[j - 1].text in (".", "->", "::")):
        j = closing(tokens, j) + 1 if tokens[j].text == "[" else j + 1
    return j < len(tokens) and tokens[j].text in ("=", "+=", "-=", "|=", "&=", "(", "++", "--")


# --- all mutants in one file -----------------------------------------------------------------

HEAD = """#ifndef CBVH_MUTANT
#define CBVH_MUTANT
#include <cstdlib>
static const int cbvhMutant = getenv("CBVH_MUTANT") ? atoi(getenv("CBVH_MUTANT")) : 0;
#endif
"""


def with_mutants(text, functions):
    """Returns a file in which the environment variable CBVH_MUTANT selects bodies; functions: [(Function, {number:
    Mutant})]."""
    for function, mutants in sorted(functions, key=lambda f: -f[0].tokens[0].begin):
        begin, end = function.tokens[0].begin, function.tokens[-1].end
        body = "{\n"
        for number, m in mutants.items():
            body += f"if (cbvhMutant == {number}) {text[begin : m.begin]}{m.new}{text[m.end : end]}\nelse "
        text = f"{text[:begin]}{body}/*sound*/ {text[begin:end]}\n}}{text[end:]}"
    return HEAD + text


def numbers_of_lines(text):
    """Returns the mutants of the lines of such a file: {line: number}."""
    numbers, number = {}, None
    for i, line in enumerate(text.split("\n"), 1):
        begins = re.search(r"if \(cbvhMutant == (\d+)\)", line)
        number = int(begins.group(1)) if begins else None if "/*sound*/" in line else number
        if number:
            numbers[i] = number
    return numbers
