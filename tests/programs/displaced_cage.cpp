// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* For Embree's own programs, which do not support displacement: writes the displaced tessellation of a generated scene
 * as the cage of a subdivision surface. Prints a camera for their command lines that shows the entire scene.
 *
 * usage: displaced_cage SCENE LEVEL FILE.xml */

#include "basics/error.h"
#include "building/built_scene.h"
#include "programs/view_options.h"
#include "scenes/catalogue.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <tuple>

namespace programs::test { namespace {

/* Merges vertices of neighboring patches, which each have their own copies. */
struct Welded {
  std::vector<Vec3f> positions;
  std::vector<size_t> index; // new index of each vertex of the layout
};

/* tolerance: patches compute their common border separately. */
Welded weld(const std::vector<Vec3f>& vertices, float tolerance) {
  using Key = std::tuple<long, long, long>;
  Welded welded;
  std::map<Key, size_t> known;
  for (const Vec3f& p : vertices) {
    size_t found = SIZE_MAX;
    const long x = std::lround(p.x / tolerance), y = std::lround(p.y / tolerance), z = std::lround(p.z / tolerance);
    for (int n = 0; n < 27 && found == SIZE_MAX; n++) {
      const auto it = known.find({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
      if (it != known.end()) found = it->second;
    }
    if (found == SIZE_MAX) {
      found = welded.positions.size();
      known[{x, y, z}] = found;
      welded.positions.push_back(p);
    }
    welded.index.push_back(found);
  }
  return welded;
}

struct FileClose {
  void operator()(FILE* file) const { std::fclose(file); }
};

void writeXml(const std::string& path, const Welded& welded, const PatchLayout& layout) {
  std::unique_ptr<FILE, FileClose> file(std::fopen(path.c_str(), "w"));
  if (!file) throw Error(path + ": cannot be written");
  std::fputs("<?xml version=\"1.0\"?>\n<scene>\n<Group>\n<SubdivisionMesh>\n<positions>\n", file.get());
  for (const Vec3f& p : welded.positions)
    std::fprintf(file.get(), "%.9g %.9g %.9g\n", double(p.x), double(p.y), double(p.z));
  std::fputs("</positions>\n<position_indices>\n", file.get());
  for (const Patch& patch : layout.patches())
    for (size_t y = 0; y < patch.resolution; y++)
      for (size_t x = 0; x < patch.resolution; x++) {
        const size_t row = patch.resolution + 1, v = patch.firstVertex + y * row + x;
        std::fprintf(file.get(), "%zu %zu %zu %zu\n", welded.index[v], welded.index[v + 1], welded.index[v + row + 1],
                     welded.index[v + row]);
      }
  std::fputs("</position_indices>\n<faces>\n", file.get());
  for (size_t i = 0; i < layout.numQuads(); i++) std::fputs("4\n", file.get());
  std::fputs("</faces>\n<material>\n<code>\"OBJ\"</code>\n<parameters>\n<float3 name=\"Kd\">0.7 0.6 0.5</float3>\n"
             "</parameters>\n</material>\n</SubdivisionMesh>\n</Group>\n</scene>\n",
             file.get());
}

/* In the syntax of Embree's programs. */
void printFullView(const Model& model, const BuildSettings& build) {
  const BuiltScene grid(model, {RepresentationKind::Grid}, build);
  const Camera camera = chooseCamera("full", model, grid, {512, 512}, 1);
  const Vec3f e = camera.eye(), l = camera.lookAt(), u = model.view.up;
  std::printf("--vp %g %g %g --vi %g %g %g --vu %g %g %g --fov %g\n", e.x, e.y, e.z, l.x, l.y, l.z, u.x, u.y, u.z,
              camera.fov());
}

void write(const std::string& scene, int level, const std::string& path) {
  SceneSettings settings;
  settings.scene = scene;
  settings.mapFolder = std::filesystem::path(path).parent_path().string();
  std::string warning;
  const Model model = loadScene(settings, warning);
  BuildSettings build;
  build.level = level;
  writeXml(path, weld(tessellate(model, build), 1e-6f * model.cage.bounds().diagonal()), model.layout(level));
  printFullView(model, build);
}

}} // namespace programs::test

int main(int argc, char** argv) {
  try {
    if (argc != 4) throw programs::Error("usage: displaced_cage SCENE LEVEL FILE.xml");
    programs::test::write(argv[1], std::atoi(argv[2]), argv[3]);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "displaced_cage: %s\n", e.what());
    return 1;
  }
}
