#!/usr/bin/env python3
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
"""The type stubs name the classes, functions, members and arguments that the module has."""

import ast
import inspect
import pathlib
import re
import unittest

import embree_cbvh as cbvh

STUBS = pathlib.Path(__file__).resolve().parents[2] / "tutorials/python/embree_cbvh.pyi"


def public(names):
    return {name for name in names if not name.startswith("_")}


def arguments_of_stub(function):
    """Names in order, with "*" before those that need a keyword, and "=" after those with a default."""
    a = function.args
    first = len(a.args) - len(a.defaults)
    names = [arg.arg + ("=" if i >= first else "") for i, arg in enumerate(a.args)]
    only = [arg.arg + ("=" if default else "") for arg, default in zip(a.kwonlyargs, a.kw_defaults)]
    return names + (["*"] + only if only else [])


def arguments_of_module(function):
    """The same, of the signature in the first line of the docstring."""
    signature = re.match(r"\w+\((.*)\) -> ", function.__doc__.splitlines()[0]).group(1)
    parts, depth = [""], 0
    for letter in signature:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [re.match(r"[\w*]+", p.strip()).group() + ("=" if re.search(r": .* = ", p) else "") for p in parts if p]


class Stubs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        tree = ast.parse(STUBS.read_text(encoding="utf-8"))
        cls.classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        cls.functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}

    def test_all_classes_and_functions_have_stubs(self):
        self.assertEqual(public(dir(cbvh)), set(self.classes) | set(self.functions))

    def test_classes_have_the_same_bases_and_members(self):
        for name, node in self.classes.items():
            if name == "Error":
                continue
            with self.subTest(name):
                self.assertEqual(public(vars(getattr(cbvh, name))), public(f.name for f in node.body))
                bases = [base.__name__ for base in getattr(cbvh, name).__bases__]
                self.assertEqual([b.id for b in node.bases], [b for b in bases if b in self.classes])
                for member in node.body:
                    kind = "property" in [d.id for d in member.decorator_list]
                    of_module = inspect.getattr_static(getattr(cbvh, name), member.name)
                    self.assertEqual(kind, isinstance(of_module, property), member.name)

    def test_arguments_have_the_same_names(self):
        functions = [(getattr(cbvh, name), node) for name, node in self.functions.items()]
        for name, node in self.classes.items():
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and "property" not in [d.id for d in member.decorator_list]:
                    functions.append((getattr(getattr(cbvh, name), member.name), member))
        for function, node in functions:
            with self.subTest(node.name):
                self.assertEqual(arguments_of_module(function), arguments_of_stub(node))


if __name__ == "__main__":
    unittest.main()
