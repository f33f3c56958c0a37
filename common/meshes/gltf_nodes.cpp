// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "meshes/gltf_nodes.h"

#include <utility>

namespace programs {
namespace {

std::vector<double> numbersOf(const GltfValue& node, const char* key, std::vector<double> missing) {
  if (!node.has(key)) return missing;
  std::vector<double> values = node.member(key).numbers();
  if (values.size() != missing.size())
    node.member(key).fail("has " + std::to_string(values.size()) + " numbers: expected " +
                          std::to_string(missing.size()));
  return values;
}

/* Translation times rotation times scale. The rotation is a quaternion x, y, z, w. */
GltfMatrix localMatrix(const GltfValue& node) {
  if (node.has("matrix"))
    return gltfMatrixOf(numbersOf(node, "matrix", std::vector<double>(16)).data(), node.member("matrix"));
  const std::vector<double> t = numbersOf(node, "translation", {0, 0, 0}), s = numbersOf(node, "scale", {1, 1, 1});
  std::vector<double> q = numbersOf(node, "rotation", {0, 0, 0, 1});
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0) || !std::isfinite(size)) node.member("rotation").fail("is no rotation: expected a unit quaternion");
  for (double& x : q) x /= size;
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  GltfMatrix m;
  m.columns[0] = Vec3d{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)} * s[0];
  m.columns[1] = Vec3d{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)} * s[1];
  m.columns[2] = Vec3d{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)} * s[2];
  m.columns[3] = {t[0], t[1], t[2]};
  return m;
}

class GltfHierarchy {
public:
  GltfHierarchy(const GltfValue& document, const std::string& file) : document(document), file(file) {}

  GltfNodes run(std::string& warnings) {
    const size_t count = document.count("nodes");
    for (size_t i = 0; i < count; i++) {
      const GltfValue node = document.element("nodes", i);
      nodes.toWorld.push_back(localMatrix(node));
      children.emplace_back();
      for (size_t c = 0; c < node.count("children"); c++)
        children.back().push_back(size_t(node.member("children").element(c).integer()));
    }
    const std::vector<bool> isChild = findChildren();
    std::vector<size_t> roots;
    for (size_t i = 0; i < count; i++)
      if (!isChild[i]) roots.push_back(i);
    const std::vector<size_t> all = descend(roots, true);
    if (all.size() != count) throw Error(file + ": nodes are their own children: expected trees");
    nodes.inSceneOrder = document.count("scenes") == 0 ? all : descend(rootsOfScene(warnings), false);
    return std::move(nodes);
  }

private:
  std::vector<bool> findChildren() const {
    std::vector<bool> isChild(children.size());
    for (size_t i = 0; i < children.size(); i++)
      for (const size_t child : children[i]) {
        if (child >= children.size() || isChild[child])
          document.element("nodes", i)
              .member("children")
              .fail("names node " + std::to_string(child) + ", which " +
                    (child < children.size() ? "has another parent" : "does not exist") + ": expected trees of nodes");
        isChild[child] = true;
      }
    return isChild;
  }

  /* The nodes of trees, parents first and in order. Multiplies matrices by those of parents if asked to. */
  std::vector<size_t> descend(const std::vector<size_t>& roots, bool multiply) {
    std::vector<size_t> order, open(roots.rbegin(), roots.rend());
    while (!open.empty()) {
      const size_t node = open.back();
      open.pop_back();
      order.push_back(node);
      for (auto child = children[node].rbegin(); child != children[node].rend(); ++child) {
        if (multiply) nodes.toWorld[*child] = nodes.toWorld[node] * nodes.toWorld[*child];
        open.push_back(*child);
      }
    }
    return order;
  }

  std::vector<size_t> rootsOfScene(std::string& warnings) const {
    const size_t scenes = document.count("scenes"), number = size_t(document.integer("scene", 0));
    if (scenes > 1)
      warnings += file + ": only scene " + std::to_string(number) + " of " + std::to_string(scenes) + " is read\n";
    const GltfValue scene = document.element("scenes", number);
    std::vector<size_t> roots;
    std::vector<bool> isRoot(children.size());
    for (size_t i = 0; i < scene.count("nodes"); i++) {
      const size_t node = size_t(scene.member("nodes").element(i).integer());
      if (node >= children.size() || isRoot[node])
        scene.member("nodes").fail("names node " + std::to_string(node) + (node < children.size() ? " twice" : "") +
                                   ": the file has " + std::to_string(children.size()) + " nodes");
      isRoot[node] = true;
      roots.push_back(node);
    }
    return roots;
  }

  const GltfValue& document;
  const std::string& file;
  GltfNodes nodes;
  std::vector<std::vector<size_t>> children;
};

} // namespace

GltfMatrix gltfMatrixOf(const double* m, const GltfValue& place) {
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
    place.fail("is not affine: expected 0, 0, 0, 1 in the last row");
  GltfMatrix matrix;
  for (size_t i = 0; i < 4; i++) matrix.columns[i] = {m[4 * i], m[4 * i + 1], m[4 * i + 2]};
  return matrix;
}

GltfNodes readGltfNodes(const GltfValue& document, const std::string& file, std::string& warnings) {
  return GltfHierarchy(document, file).run(warnings);
}

} // namespace programs
