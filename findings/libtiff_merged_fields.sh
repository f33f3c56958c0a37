#!/bin/sh
# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0
#
# A program that reads tags of GeoTIFF or GDAL describes them to libtiff by TIFFMergeFieldInfo, for one open file. The
# mode "h" opens a file without reading its first directory, so that there is time for this call.
#
# Guess: TIFFReadDirectory then reads the tags as they were described.
#
# Seen (libtiff 4.5.0 of Debian 12): TIFFReadDirectory forgets the description, and reads the tag as one that it does
# not know, for which TIFFGetField has other arguments: a count in addition to the text. Only a function that
# TIFFSetTagExtender sets, for all files of the process, lasts. common/surface/geo_tiff.cpp therefore sets one.
. "$(dirname -- "$0")/debian_root.sh"
install_pinned bookworm libtiff6=4.5.0-6+deb12u4 libtiff-dev=4.5.0-6+deb12u4

cat > "$root/fields.c" << 'PROGRAM'
#include <stdint.h>
#include <stdio.h>
#include <tiffio.h>

static const TIFFFieldInfo nodata = {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char*)"GDALNoDataValue"};

static void print(TIFF* tiff, const char* when) {
  const TIFFField* field = TIFFFindField(tiff, 42113, TIFF_ANY);
  printf("%s%s", when, !field ? "unknown" : TIFFFieldPassCount(field) ? "text and count" : "text");
}

static void extend(TIFF* tiff) { TIFFMergeFieldInfo(tiff, &nodata, 1); }

int main(int argc, char** argv) {
  uint8_t sample = 0;
  TIFF* tiff = TIFFOpen(argv[argc - 1], "w");
  TIFFMergeFieldInfo(tiff, &nodata, 1);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 1);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, 42113, "-9999");
  TIFFWriteScanline(tiff, &sample, 0, 0);
  TIFFClose(tiff);
  TIFFSetWarningHandler(NULL);
  for (int i = 0; i < 2; i++) {
    if (i) TIFFSetTagExtender(extend);
    tiff = TIFFOpen(argv[argc - 1], "rh");
    if (!i) TIFFMergeFieldInfo(tiff, &nodata, 1);
    print(tiff, i ? "; extender: " : "merged: ");
    TIFFReadDirectory(tiff);
    print(tiff, ", read: ");
    TIFFClose(tiff);
  }
  printf("\n");
}
PROGRAM
usr=$root/system/usr
mkdir -p "$usr/bin"
cc -I "$(dirname "$(find "$usr/include" -name tiffio.h)")" "$root/fields.c" -o "$usr/bin/fields" \
  -Wl,--allow-shlib-undefined "$(find "$usr/lib" -name 'libtiff.so.6')"
observe "arguments" "merged: text, read: text and count; extender: unknown, read: text" \
  "$(in_root fields "$root/a.tif")"
