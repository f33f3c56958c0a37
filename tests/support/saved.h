// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Geometries in files: a folder for files, their bytes, and surfaces of all forms. */

#include "support/irregular_mesh.h"
#include "support/scene.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <dirent.h>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>
#include <vector>

namespace programs::test {

// A new, empty folder. The destructor removes it with its files.
class Folder {
public:
  Folder() {
    char name[] = "/tmp/cbvh-files-XXXXXX";
    if (char* made = mkdtemp(name)) path = made;
  }
  ~Folder() {
    for (const std::string& name : names()) std::remove((path + "/" + name).c_str());
    rmdir(path.c_str());
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return path + "/" + name; }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    if (DIR* folder = opendir(path.c_str())) {
      while (const dirent* entry = readdir(folder))
        if (entry->d_name[0] != '.') all.push_back(entry->d_name);
      closedir(folder);
    }
    return all;
  }

  std::string path;
};

inline std::string bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void writeBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// Named geometries of each form of a file. They are committed and compressed by their own commit, which releases
// their input.
struct Saveable {
  std::string name;
  std::function<RTCGeometry(RTCDevice)> make;
  bool moves = false, hasTriangles = true;
};

inline RTCGeometry releasing(RTCGeometry geometry, RTCCompression compression,
                             int frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT, int fallbackFaces = -1) {
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = compression;
  args.frameLevel = frameLevel;
  args.fallbackFaces = fallbackFaces;
  args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  return geometry;
}

inline std::vector<Saveable> allSaveable() {
  static Displacement displacement;
  std::vector<Saveable> all;
  const auto cage = [&](const std::string& name, RTCCompression compression, float rate, unsigned timeSteps,
                        int fallbackFaces, const Cage& cage) {
    all.push_back({name,
                   [=](RTCDevice device) {
                     SurfaceSettings settings;
                     settings.rate = rate;
                     settings.displacement = &displacement;
                     settings.timeSteps = timeSteps;
                     if (timeSteps > 1) {
                       settings.begin = 0.125f;
                       settings.end = 0.75f;
                     }
                     return releasing(newSurface(device, cage, settings), compression,
                                      RTC_COMPRESSION_FRAME_LEVEL_INHERIT, fallbackFaces);
                   },
                   timeSteps > 1, compression == RTC_COMPRESSION_CVERT || compression == RTC_COMPRESSION_CGRID});
  };
  for (RTCCompression compression :
       {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CGRID}) {
    cage(kindName(compression), compression, 64, 1, 0, cubeCage());
    cage(std::string(kindName(compression)) + ", few blocks", compression, 8, 1, 0, cubeCage());
  }
  cage("cLEAF with fallback faces", RTC_COMPRESSION_CLEAF, 32, 1, 1, sheetCage(3));
  cage("cVERT of n-gons", RTC_COMPRESSION_CVERT, 37, 1, -1, prismCage(5));
  cage("cVERT that moves", RTC_COMPRESSION_CVERT, 40, 4, -1, cubeCage());
  const auto diced = [&](const std::string& name, unsigned timeSteps,
                         const std::function<RTCGeometry(RTCDevice, const Diced&, unsigned)>& make) {
    all.push_back({name,
                   [=](RTCDevice device) {
                     Diced sheet = dicedSheet(4, 32);
                     sheet.motion = [](const Vec& p, unsigned step) {
                       return Vec{p[0] + 0.05f * float(step), p[1], p[2] + 0.1f * float(step) * p[0]};
                     };
                     return make(device, sheet, timeSteps);
                   },
                   timeSteps > 1, true});
  };
  for (unsigned timeSteps : {1u, 3u}) {
    const std::string suffix = timeSteps > 1 ? " that move" : "";
    diced("grids" + suffix, timeSteps, [](RTCDevice device, const Diced& sheet, unsigned timeSteps) {
      return newGrids(device, sheet, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT, timeSteps);
    });
    for (QuadOrder order : {QuadOrder::Rows, QuadOrder::Shuffled})
      for (bool triangles : {false, true})
        diced(std::string(triangles ? "triangles" : "quads") + suffix + ", " + nameOf(order), timeSteps,
              [=](RTCDevice device, const Diced& sheet, unsigned timeSteps) {
                Random random(5);
                DicedMesh mesh = meshOf(sheet, order, random);
                if (triangles) mesh = trianglesOf(mesh, 1, 2);
                mesh.motion = sheet.motion;
                return newMesh(device, mesh, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT, timeSteps);
              });
  }
  for (bool triangles : {false, true})
    diced(triangles ? "triangles, irregular in part" : "quads, irregular in part", 1,
          [=](RTCDevice device, const Diced& sheet, unsigned) {
            Random random(6);
            return newMesh(device, partlyIrregular(meshOf(sheet, QuadOrder::Rows, random), random, triangles),
                           RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT);
          });
  diced("irregular triangles", 1, [](RTCDevice device, const Diced& sheet, unsigned) {
    Random random(7);
    return newMesh(device, irregularTriangles(meshOf(sheet, QuadOrder::Rows, random), random), RTC_COMPRESSION_CVERT,
                   RTC_COMPRESSION_FLAG_RELEASE_INPUT);
  });
  for (bool triangles : {false, true})
    diced(triangles ? "irregular triangles that move" : "irregular quads that move", 3,
          [=](RTCDevice device, const Diced& sheet, unsigned timeSteps) {
            Random random(8);
            const DicedMesh quads = meshOf(sheet, QuadOrder::Rows, random);
            DicedMesh mesh = triangles ? irregularTriangles(quads, random) : irregularQuads(quads, random);
            mesh.motion = sheet.motion;
            return newMesh(device, mesh, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT, timeSteps);
          });
  return all;
}

} // namespace programs::test
