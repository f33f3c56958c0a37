// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/mesh_file.h"
#include "basics/error.h"
#include "basics/input_files.h"
#include "basics/open_input.h"
#include "basics/text.h"
#include "meshes/gltf_reader.h"
#include "meshes/input_bytes.h"
#include "meshes/ply_reader.h"
#include "meshes/stl_reader.h"
#include "surface/mesh.h"
#include "surface/obj_reader.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

namespace programs {
namespace {

std::string extensionOf(const std::string& path) { return lowerCase(std::filesystem::path(path).extension().string()); }

void removeHoles(Cage& cage, const std::string& name) {
  if (cage.holes.empty()) return;
  std::vector<bool> isHole(cage.numFaces());
  for (const unsigned face : cage.holes) isHole[face] = true;
  size_t faces = 0, corners = 0, first = 0;
  for (size_t face = 0; face < isHole.size(); face++) {
    const unsigned size = cage.faceSizes[face];
    if (!isHole[face]) {
      std::copy_n(cage.faceIndices.begin() + ptrdiff_t(first), size, cage.faceIndices.begin() + ptrdiff_t(corners));
      cage.faceSizes[faces++] = size;
      corners += size;
    }
    first += size;
  }
  if (faces == 0) throw Error(name + ": all faces are holes: expected at least one other face");
  cage.faceSizes.resize(faces);
  cage.faceIndices.resize(corners);
}

PolygonMesh readObjMesh(std::istream& stream, const std::string& name, std::string& warnings) {
  PolygonMesh mesh;
  Cage cage = readObj(stream, name, warnings, &mesh.positions);
  removeHoles(cage, name);
  mesh.faceSizes = std::move(cage.faceSizes);
  mesh.faceIndices = std::move(cage.faceIndices);
  mesh.splitsAreExplicit = cage.comments.find(objSplitComment) != std::string::npos;
  mesh.comments = std::move(cage.comments);
  return mesh;
}

/* The first bytes of a stream, which stays at its beginning. Of a pipe, at most those of its first write. */
std::string peek(std::istream& stream, size_t bytes) {
  std::streambuf& from = *stream.rdbuf();
  std::string text;
  try {
    if (from.sgetc() == std::streambuf::traits_type::eof()) return text;
    for (size_t left = std::min(bytes, size_t(std::max<std::streamsize>(from.in_avail(), 0))); left > 0; left--)
      text += char(from.sbumpc());
    for (size_t i = text.size(); i > 0; i--) from.sungetc();
  } catch (const std::ios_base::failure&) {} // the reader reports it
  return text;
}

enum class MeshFormat { Obj, Ply, Stl, Gltf };

MeshFormat formatOf(const std::string& start, const std::string& path) {
  const std::string extension = extensionOf(path);
  if (start.substr(0, 4) == "ply\n" || start.substr(0, 4) == "ply\r") return MeshFormat::Ply;
  if (start.substr(0, 4) == "glTF") return MeshFormat::Gltf;
  if (extension == ".ply") return MeshFormat::Ply;
  if (extension == ".stl") return MeshFormat::Stl;
  if (extension == ".gltf" || extension == ".glb") return MeshFormat::Gltf;
  return start == "solid " && extension != ".obj" ? MeshFormat::Stl : MeshFormat::Obj;
}

} // namespace

bool isMeshExtension(const std::string& extension) {
  const char* const all[] = {".ply", ".stl", ".gltf", ".glb"};
  return std::find(std::begin(all), std::end(all), extension) != std::end(all);
}

PolygonMesh readMesh(std::istream& stream, const std::string& name, std::string& warnings) {
  const MeshFormat format = formatOf(peek(stream, 6), name);
  if (format == MeshFormat::Obj) return readObjMesh(stream, name, warnings);
  InputBytes input(stream, name);
  if (format == MeshFormat::Ply) return readPly(input);
  return format == MeshFormat::Stl ? readStl(input) : readGltf(input, warnings);
}

PolygonMesh readMesh(const std::string& path, std::string& warnings) {
  PolygonMesh mesh = readMesh(*openInput(path), path, warnings);
  recordInputFile(path);
  return mesh;
}

std::vector<Vec3f> roundedPositions(const PolygonMesh& mesh, const std::string& path, std::string& warnings) {
  std::vector<Vec3f> rounded;
  rounded.reserve(mesh.positions.size());
  Box3f box;
  double moved = 0;
  for (const Vec3d& p : mesh.positions) {
    const Vec3f r{float(p.x), float(p.y), float(p.z)};
    box.extend(r);
    moved = std::max({moved, std::abs(p.x - r.x), std::abs(p.y - r.y), std::abs(p.z - r.z)});
    rounded.push_back(r);
  }
  if (moved > 1e-6 * double(box.diagonal()))
    warnings += path + ": coordinates are rounded to 32 bits, which moves vertices by up to " + shortNumber(moved) +
                "; subtract an origin near the mesh before to avoid it\n";
  return rounded;
}

} // namespace programs
