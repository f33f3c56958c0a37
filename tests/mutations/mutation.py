# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""What a list of mutations is made of."""

from dataclasses import dataclass

# Test programs that a mutation may name before they exist.
PLANNED = set()


@dataclass(frozen=True)
class Mutation:
    """One edit that makes the code wrong, as a slip of the hand would."""

    name: str
    file: str  # below the root of the checkout
    old: str  # exactly once in it
    new: str
    breaks: str  # what is wrong then
    tests: tuple  # "unit" or "unit Suite.Name:Suite.Other", as test_unit --gtest_filter takes it: each has to fail
    harmless: str = ""  # why nothing can notice: then each of the tests has to pass


def room(folder):
    """Constructor of mutations of a room of the kernels: file is relative to it."""

    def make(name, file, old, new, breaks, *tests, harmless=""):
        return Mutation(name, f"kernels/cbvh/{folder}/{file}", old, new, breaks, tests, harmless)

    return make
