#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# OpenEXR files store IDs of objects and faces in channels of 32-bit integers, next to colors and depths as floats.
#
# Guess: oiiotool copies such a file with its types, and joins two parts of a picture by --paste with their IDs.
#
# Seen (OpenImageIO 2.4.7 of Debian 12): already a copy has only float channels, and an ID is its fraction of 2^32:
# 16777217 becomes 0.00390625. No message says so.
#
# Pictures of cbvh_render --exr contain primID. `cbvh_render --join` joins parts with their types (docs/programs.md).
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm openimageio-tools=2.4.7.1+dfsg-2

# One row of two pixels: depths 1.5 and 2, IDs 16777217 and 7
python3 - "$root/ids.exr" << 'END'
import struct
import sys


def attribute(name, kind, data):
    return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data


channels = b"".join(name + b"\0" + struct.pack("<iB3xii", kind, 0, 1, 1) for name, kind in ((b"Z", 2), (b"id", 0)))
window = struct.pack("<4i", 0, 0, 1, 0)
header = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
header += attribute("channels", "chlist", channels + b"\0") + attribute("compression", "compression", b"\0")
header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
header += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
with open(sys.argv[1], "wb") as file:
    file.write(header + struct.pack("<Q", len(header) + 8))
    file.write(struct.pack("<ii2f2I", 0, 16, 1.5, 2, 16777217, 7))
END
types() { in_root oiiotool --info "$1" | sed 's/.*channel, //'; }
observe "the file has the types" "float/uint openexr" "$(types "$root/ids.exr")"
in_root oiiotool "$root/ids.exr" -o "$root/copy.exr"
observe "its copy has the type" "float openexr" "$(types "$root/copy.exr")"
observe "the first pixel of the copy is" "1.500000000 0.003906250" \
  "$(in_root oiiotool --dumpdata "$root/copy.exr" | sed -n 's/.*Pixel (0, 0): *//p' | sed 's/ *$//')"
