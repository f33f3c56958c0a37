// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Mistakes of other readers that the tests exclude: normalized integers used as they are, sparse values and fans left
 * out, and surfaces of mirrored nodes inside out. */

#include "meshes/gltf_reader.h"
#include "meshes/gltf_accessors.h"
#include "meshes/gltf_buffers.h"
#include "meshes/gltf_nodes.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace programs {
namespace {

enum Mode : uint64_t { FirstSurface = 4, Triangles = 4, Strip = 5, Fan = 6 };

class GltfMeshes {
public:
  GltfMeshes(InputBytes& input, std::string& warnings)
    : file(input.name()),
      warnings(warnings),
      buffers(input),
      accessors(buffers),
      document(buffers.document()),
      nodes(readGltfNodes(document, file, warnings)) {}

  PolygonMesh run() {
    mesh.up = "y";
    for (const size_t node : nodes.inSceneOrder) addNode(node);
    if (document.count("nodes") == 0)
      for (size_t i = 0; i < document.count("meshes"); i++) addMesh(i, {}, GltfMatrix(), {});
    if (leftOut > 0)
      warnings += file + ": points and lines are left out (" + std::to_string(leftOut) + " of all primitives)\n";
    if (mesh.faceSizes.empty()) throw Error(file + ": no triangles in the scene: expected at least one");
    return std::move(mesh);
  }

private:
  void addNode(size_t index) {
    const GltfValue node = document.element("nodes", index);
    if (!node.has("mesh")) return;
    if (node.hasExtension("EXT_mesh_gpu_instancing"))
      node.fail("has the extension 'EXT_mesh_gpu_instancing', which is not supported: expected a node per copy");
    const std::vector<double> weights = node.has("weights") ? node.member("weights").numbers() : std::vector<double>();
    addMesh(size_t(node.integer("mesh")), weights, nodes.toWorld[index], node.index("skin"));
  }

  void addMesh(size_t index, std::vector<double> weights, const GltfMatrix& toWorld, std::optional<size_t> skin) {
    const GltfValue object = document.element("meshes", index);
    if (weights.empty() && object.has("weights")) weights = object.member("weights").numbers();
    const std::vector<GltfMatrix> joints = skin ? jointsOf(*skin) : std::vector<GltfMatrix>();
    firstVertexOf.clear();
    for (size_t i = 0; i < object.count("primitives"); i++) {
      const GltfValue primitive = object.member("primitives").element(i);
      const uint64_t mode = primitive.integer("mode", Triangles);
      if (mode > Fan) primitive.fail("has the mode " + std::to_string(mode) + ": expected 0 to 6");
      if (mode < FirstSurface) leftOut++;
      else addPrimitive(primitive, Mode(mode), weights, toWorld, joints);
    }
  }

  /* Matrices from the mesh to the world. */
  std::vector<GltfMatrix> jointsOf(size_t index) {
    const GltfValue skin = document.element("skins", index), joints = skin.member("joints");
    std::vector<double> inverse;
    if (skin.has("inverseBindMatrices")) inverse = accessors.numbers(*skin.index("inverseBindMatrices"), 16);
    std::vector<GltfMatrix> matrices(joints.elements());
    if (!inverse.empty() && inverse.size() < 16 * matrices.size())
      skin.fail("has fewer matrices than joints: expected " + std::to_string(matrices.size()));
    for (size_t i = 0; i < matrices.size(); i++) {
      const uint64_t node = joints.element(i).integer();
      if (node >= nodes.toWorld.size())
        joints.element(i).fail("names node " + std::to_string(node) + ", which does not exist");
      matrices[i] = nodes.toWorld[node];
      if (!inverse.empty()) matrices[i] = matrices[i] * gltfMatrixOf(&inverse[16 * i], skin);
    }
    return matrices;
  }

  struct Vertices {
    size_t first = 0, count = 0;
  };

  void addPrimitive(const GltfValue& primitive, Mode mode, const std::vector<double>& weights,
                    const GltfMatrix& toWorld, const std::vector<GltfMatrix>& joints) {
    const GltfValue attributes = primitive.member("attributes");
    if (!attributes.has("POSITION")) return; // the specification requires to skip it
    const Vertices vertices = addVertices(primitive, attributes, weights, toWorld, joints);
    std::vector<unsigned> indices;
    if (primitive.has("indices")) indices = accessors.indices(*primitive.index("indices"));
    const bool isIndexed = primitive.has("indices");
    const size_t count = isIndexed ? indices.size() : vertices.count;
    for (size_t i = 0; i < indices.size(); i++)
      if (indices[i] >= vertices.count)
        primitive.member("indices").fail("has the vertex index " + std::to_string(indices[i]) + " at " +
                                         std::to_string(i) + ": the primitive has " + std::to_string(vertices.count) +
                                         " vertices");
    if (count < 3 || (mode == Triangles && count % 3 != 0))
      primitive.fail("has " + std::to_string(count) + " corners: expected " +
                     (mode == Triangles ? "three per triangle" : "at least 3"));
    const size_t firstCorner = mesh.faceIndices.size();
    mesh.reserveTriangles(mode == Triangles ? count / 3 : count - 2);
    const auto vertex = [&](size_t i) { return unsigned(vertices.first + (isIndexed ? indices[i] : i)); };
    addTriangles(mode, count, vertex);
    if (joints.empty() && toWorld.isMirrored())
      for (size_t i = firstCorner; i < mesh.faceIndices.size(); i += 3)
        std::swap(mesh.faceIndices[i + 1], mesh.faceIndices[i + 2]);
    if (mesh.numFaces() > mostMeshElements)
      throw Error(file + ": too many triangles: expected at most " + std::to_string(mostMeshElements));
  }

  template<typename Vertex>
  void addTriangles(Mode mode, size_t count, const Vertex& vertex) {
    if (mode == Strip) {
      StripTriangles strip(mesh);
      for (size_t i = 0; i < count; i++) strip.add(vertex(i));
    } else if (mode == Fan)
      for (size_t i = 2; i < count; i++) mesh.addTriangle(vertex(0), vertex(i - 1), vertex(i));
    else
      for (size_t i = 0; i < count; i += 3) mesh.addTriangle(vertex(i), vertex(i + 1), vertex(i + 2));
  }

  /* Primitives of one mesh, as those of its materials, may have the same vertices. */
  Vertices addVertices(const GltfValue& primitive, const GltfValue& attributes, const std::vector<double>& weights,
                       const GltfMatrix& toWorld, const std::vector<GltfMatrix>& joints) {
    const size_t accessor = *attributes.index("POSITION");
    const bool isShared = joints.empty() && !primitive.has("targets");
    const auto known = firstVertexOf.find(accessor);
    if (isShared && known != firstVertexOf.end()) return known->second;
    Vertices vertices{mesh.positions.size(), 0};
    vertices.count = accessors.appendPositions(accessor, mesh.positions);
    if (mesh.positions.size() > mostMeshElements)
      throw Error(file + ": too many vertices: expected at most " + std::to_string(mostMeshElements));
    addTargets(primitive, weights, vertices);
    if (joints.empty())
      for (size_t i = 0; i < vertices.count; i++) {
        Vec3d& p = mesh.positions[vertices.first + i];
        p = toWorld.apply(p);
      }
    else applySkin(attributes, joints, vertices);
    for (size_t i = 0; i < vertices.count; i++) {
      const Vec3d& p = mesh.positions[vertices.first + i];
      if (!isCoordinate(p.x) || !isCoordinate(p.y) || !isCoordinate(p.z))
        attributes.member("POSITION")
            .fail("has a coordinate at vertex " + std::to_string(i) + " that is not finite, or too large for 32 bits");
    }
    if (isShared) firstVertexOf[accessor] = vertices;
    return vertices;
  }

  void addTargets(const GltfValue& primitive, const std::vector<double>& weights, const Vertices& vertices) {
    for (size_t t = 0; t < primitive.count("targets") && t < weights.size(); t++) {
      const GltfValue target = primitive.member("targets").element(t);
      if (weights[t] == 0 || !target.has("POSITION")) continue;
      std::vector<Vec3d> moves;
      if (accessors.appendPositions(*target.index("POSITION"), moves) != vertices.count)
        target.fail("has " + std::to_string(moves.size()) + " vertices: expected " + std::to_string(vertices.count));
      for (size_t i = 0; i < vertices.count; i++) mesh.positions[vertices.first + i] += moves[i] * weights[t];
    }
  }

  /* A vertex moves as the weighted mean of up to 4 joints per set of attributes. */
  void applySkin(const GltfValue& attributes, const std::vector<GltfMatrix>& joints, const Vertices& vertices) {
    std::vector<Vec3d> sum(vertices.count);
    std::vector<double> total(vertices.count);
    for (size_t set = 0;; set++) {
      const std::string jointsName = "JOINTS_" + std::to_string(set), weightsName = "WEIGHTS_" + std::to_string(set);
      if (set > 0 && !attributes.has(jointsName.c_str())) break;
      const std::vector<double> numbers = accessors.numbers(size_t(attributes.integer(jointsName.c_str())), 4);
      const std::vector<double> weights = accessors.numbers(size_t(attributes.integer(weightsName.c_str())), 4);
      if (numbers.size() != 4 * vertices.count || weights.size() != 4 * vertices.count)
        attributes.member(jointsName.c_str()).fail("has another number of elements than POSITION");
      for (size_t i = 0; i < numbers.size(); i++) {
        if (weights[i] == 0) continue;
        if (!(numbers[i] >= 0 && numbers[i] < double(joints.size())))
          attributes.member(jointsName.c_str())
              .fail("names a joint beyond the " + std::to_string(joints.size()) + " of the skin");
        sum[i / 4] += joints[size_t(numbers[i])].apply(mesh.positions[vertices.first + i / 4]) * weights[i];
        total[i / 4] += weights[i];
      }
    }
    for (size_t i = 0; i < vertices.count; i++) {
      if (!(total[i] > 0)) attributes.fail("has no weights of joints at vertex " + std::to_string(i));
      mesh.positions[vertices.first + i] = sum[i] * (1 / total[i]);
    }
  }

  const std::string& file;
  std::string& warnings;
  GltfBuffers buffers;
  GltfAccessors accessors;
  const GltfValue document;
  const GltfNodes nodes;
  PolygonMesh mesh;
  std::map<size_t, Vertices> firstVertexOf; // of accessors of positions, for the mesh that is being added
  size_t leftOut = 0;
};

} // namespace

PolygonMesh readGltf(InputBytes& input, std::string& warnings) { return GltfMeshes(input, warnings).run(); }

} // namespace programs
