// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

namespace embree::vulkan {

using namespace cbvh;

namespace {

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
using HeldRTCDevice = std::unique_ptr<RTCDeviceTy, DeviceRelease>;

/* The traced scene, or a scene that it instances. */
struct InputScene {
  RTCScene scene;
  std::shared_ptr<const FlatScene> flat;
  uint32_t firstGeometry = 0; // index of geomID 0 in the geometries of all inputs
  Subtree tree;
};

std::string nameOf(const InputScene& input, const InputScene& top, size_t geomID) {
  return "geometry " + std::to_string(geomID) + (&input == &top ? "" : " of an instanced scene");
}

/* True if Embree accepts the vertex: with larger coordinates, areas of boxes would overflow. */
bool isVertexInRange(const float* p) {
  for (int k = 0; k < 3; k++)
    if (!(std::fabs(p[k]) < 1.844e18f)) return false;
  return true;
}

/* World-space bounds, over all times, of a box in an instance's space. Transforming its corners at each step suffices,
 * because they move linearly in between. Empty if a corner is not in range. */
Bounds worldBounds(const FlatGeometry& instance, const float* lower, const float* upper) {
  Bounds out = Bounds::empty();
  for (uint32_t step = 0; step < instance.numTimeSteps; step++)
    for (int corner = 0; corner < 8; corner++) {
      const float* m = instance.localToWorld + 12 * step;
      float p[3];
      for (int k = 0; k < 3; k++) {
        p[k] = m[9 + k];
        for (int axis = 0; axis < 3; axis++)
          p[k] += m[3 * axis + k] * ((corner >> axis) & 1 ? upper[axis] : lower[axis]);
      }
      if (!isVertexInRange(p)) return Bounds::empty();
      out.extend(p);
    }
  /* Margin for rounding errors of this transform, and of the inverse one, which transforms rays. Errors exceed it if
   * terms cancel or the transform is ill-conditioned. Embree has no margin. */
  for (int k = 0; k < 3; k++) {
    const float slack =
        1e-5f * std::max({std::fabs(out.lower[k]), std::fabs(out.upper[k]), out.upper[k] - out.lower[k]});
    out.lower[k] -= slack;
    out.upper[k] += slack;
  }
  return out;
}

/* Bounds of the whole instance. Embree does not trace instances for which they are empty. */
Bounds worldBounds(const FlatGeometry& instance) {
  return instance.lower[0] <= instance.upper[0] ? worldBounds(instance, instance.lower, instance.upper)
                                                : Bounds::empty();
}

/* For static instances: true if the driver can invert the transform, as it must to transform rays. */
bool isInvertible(const FlatGeometry& instance) {
  return std::all_of(instance.worldToLocal, instance.worldToLocal + 12, [](float x) { return std::isfinite(x); });
}

} // namespace

/* Converts a committed scene of Embree to the layout of scene_layout.h and uploads it, in the constructor. A scene and
 * the scenes that it instances are its inputs. Their nodes, blocks and geometries share arrays. */
class SceneUpload {
public:
  SceneUpload(Scene& out, RTCScene scene, const SceneOptions& options)
    : out(out),
      device(out.device),
      options(options),
      memory(options.memory),
      uploader(device) {
    addScene(scene);
    for (size_t i = 0; i < inputs.size(); i++) addInstancedScenes(i);
    checkGeometries();
    placeBlocks();
    for (InputScene& input : inputs) buildTree(input);
    write();
  }

private:
  void addScene(RTCScene scene) {
    if (inputIndex.count(scene)) return;
    InputScene input;
    input.scene = scene;
    // a call, because an address would be resolved also in programs that run with Embree's own library
    input.flat.reset(rtcFlattenScene(scene, flatSceneVersion),
                     [](const FlatScene* flat) { rtcReleaseFlatScene(flat); });
    if (!input.flat) {
      /* rtcFlattenScene reported the error to the scene's RTCDevice. RTC_ERROR_NONE: do not report it again. */
      const bool isReported = HeldRTCDevice(rtcGetSceneDevice(scene)).get() == device.embree;
      throw VulkanError(isReported ? RTC_ERROR_NONE : RTC_ERROR_INVALID_OPERATION,
                        "the scene cannot be read: its own RTCDevice, not the Vulkan device's, has the error that "
                        "says why");
    }
    input.firstGeometry = numGeometries;
    numGeometries += uint32_t(input.flat->numGeometries);
    inputIndex[scene] = inputs.size();
    inputs.push_back(std::move(input));
  }

  void addInstancedScenes(size_t s) {
    for (size_t i = 0; i < inputs[s].flat->numGeometries; i++) {
      const FlatGeometry& geometry = inputs[s].flat->geometries[i];
      if (geometry.type != FLAT_INSTANCE) continue;
      const bool isNested = s != 0;
      if (isNested || geometry.instanced == inputs[0].scene) // traversal of a scene in itself would never end
        throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                          nameOf(inputs[s], inputs[0], i) +
                              (isNested ? " is an instance" : " instances its own scene") +
                              ": scenes with instances cannot be instanced, RTC_MAX_INSTANCE_LEVEL_COUNT is 1");
      if (!geometry.instanced)
        throw VulkanError(RTC_ERROR_INVALID_OPERATION, nameOf(inputs[s], inputs[0], i) + " instances no scene");
      addScene(geometry.instanced);
    }
  }

  /* Throws VulkanError for geometry that shaders cannot trace. */
  void checkGeometries() const {
    for (const InputScene& input : inputs)
      for (size_t i = 0; i < input.flat->numGeometries; i++) {
        const FlatGeometry& geometry = input.flat->geometries[i];
        if (geometry.type == FLAT_NONE) continue;
        const std::string name = nameOf(input, inputs[0], i);
        if (geometry.type == FLAT_OTHER)
          throw VulkanError(RTC_ERROR_INVALID_OPERATION, name + " is " + geometry.typeName +
                                                             ": expected a subdivision surface, a triangle mesh, "
                                                             "an instance or compressed geometry");
        if (!geometry.isMotionSupported)
          throw VulkanError(
              RTC_ERROR_INVALID_OPERATION,
              name + " is " + geometry.typeName + " with motion blur (" + std::to_string(geometry.numTimeSteps) +
                  " time steps): Vulkan devices support motion blur only for compressed geometry, and for "
                  "instances with linear transforms");
        if (geometry.hasFilter)
          throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                            name + " has a filter function, which a Vulkan device cannot call");
        if (geometry.type == FLAT_TRIANGLES && (geometry.vertexStride % 4 || geometry.indexStride % 4 ||
                                                size_t(geometry.vertices) % 4 || size_t(geometry.indices) % 4))
          throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                            name + " has vertices or indices that are not aligned to 4 bytes");
      }
  }

  /* --- blocks --- */

  /* Imports or copies the blocks of all inputs, and sets `firstBlock` and `blocks`. */
  void placeBlocks() {
    size_t count = 0;
    for (const InputScene& input : inputs) {
      firstBlock.push_back(uint32_t(count));
      count += input.flat->numBlocks;
      requireIndexable(count, "blocks");
    }
    std::vector<PlacedBlock> placed;
    placed.reserve(count);
    for (const InputScene& input : inputs)
      for (size_t i = 0; i < input.flat->numBlocks; i++) {
        const FlatBlock& block = input.flat->blocks[i];
        placed.push_back({&block, input.flat->geometries[block.geomID].buildID});
      }
    const bool isImportRequired = memory == RTC_VULKAN_MEMORY_IMPORT;
    const bool isImportCheap = !device.capabilities.info.isDiscrete && device.handles.hasHostImport;
    bool import = isImportRequired || (memory == RTC_VULKAN_MEMORY_AUTO && isImportCheap);
    if (import && !device.handles.hasHostImport)
      throw VulkanError(RTC_ERROR_INVALID_OPERATION, std::string("memory cannot be imported: the Vulkan device ") +
                                                         device.capabilities.info.name +
                                                         " has no VK_EXT_external_memory_host, or it is not enabled");
    /* Drivers may reject some memory. NVIDIA's rejects files that are mapped read-only. */
    if (import) {
      try {
        out.blocks = importBlocks(device, placed);
        for (const InputScene& input : inputs)
          if (input.flat->hasOwnBlocks) out.blocks.imported.push_back(input.flat);
      } catch (const VulkanError& error) {
        if (isImportRequired)
          throw VulkanError(error.code, error.what() + std::string("; RTC_VULKAN_MEMORY_AUTO copies such blocks"));
        import = false;
      }
    }
    if (!import) out.blocks = copyBlocks(device, uploader, placed);
    for (const PlacedBlock& block : placed) blocks.push_back(BlockData{block.address, block.block->geomID, 0});
  }

  /* --- trees --- */

  /* Joins the scene's trees over blocks with new trees over its triangles and instances. */
  void buildTree(InputScene& input) {
    const size_t s = size_t(&input - inputs.data());
    const FlatScene& flat = *input.flat;
    std::vector<TreePrimitive> triangles, instances;
    for (size_t i = 0; i < flat.numGeometries; i++) {
      const FlatGeometry& geometry = flat.geometries[i];
      if (geometry.type == FLAT_TRIANGLES) addTriangles(geometry, uint32_t(i), triangles);
      if (geometry.type != FLAT_INSTANCE) continue;
      const Bounds bounds = worldBounds(geometry);
      if (bounds.isEmpty()) continue;
      out.statistics.numInstances++;
      instances.push_back({bounds, uint32_t(i), RTC_INVALID_GEOMETRY_ID});
    }
    const HeldRTCDevice embree(rtcGetSceneDevice(input.scene));
    copyNodes(flat, s);
    const auto subtreeOf = [&](const FlatTree& from) {
      Subtree subtree;
      if (from.root == emptyReference) return subtree;
      subtree.root = renumbered(from.root, s);
      std::copy(from.lower, from.lower + 3, subtree.bounds.lower);
      std::copy(from.upper, from.upper + 3, subtree.bounds.upper);
      subtree.depth = from.depth;
      return subtree;
    };
    input.tree =
        tree.join({subtreeOf(flat.staticTree), subtreeOf(flat.movingTree), tree.buildTriangles(embree.get(), triangles),
                   tree.buildInstances(embree.get(), instances)});
  }

  static void addTriangles(const FlatGeometry& geometry, uint32_t geomID, std::vector<TreePrimitive>& triangles) {
    for (size_t i = 0; i < geometry.numTriangles; i++) {
      uint32_t corners[3];
      std::memcpy(corners, geometry.indices + i * geometry.indexStride, sizeof(corners));
      TreePrimitive triangle = {Bounds::empty(), geomID, uint32_t(i)};
      bool valid = true;
      for (int c = 0; c < 3 && valid; c++) {
        valid = corners[c] < geometry.numVertices;
        if (!valid) break;
        float p[3];
        std::memcpy(p, geometry.vertices + corners[c] * geometry.vertexStride, sizeof(p));
        valid = isVertexInRange(p);
        triangle.bounds.extend(p);
      }
      if (valid) triangles.push_back(triangle); // as Embree, skips invalid triangles
    }
  }

  struct SceneOffsets {
    size_t node, movingNode, leaf;
  };

  /* Appends nodes and leaves of input s to the arrays that all inputs share. */
  void copyNodes(const FlatScene& flat, size_t s) {
    offsets.resize(inputs.size());
    offsets[s] = {tree.nodes.size(), tree.movingNodes.size(), leaves.size()};
    requireIndexable(tree.nodes.size() + flat.numNodes, "nodes");
    requireIndexable(tree.movingNodes.size() + flat.numMovingNodes, "moving nodes");
    requireIndexable(leaves.size() + flat.numGridLeaves, "leaves of grids");
    for (size_t i = 0; i < flat.numNodes; i++) {
      tree.nodes.push_back(flat.nodes[i]);
      for (uint32_t& child : tree.nodes.back().children) child = renumbered(child, s);
    }
    for (size_t i = 0; i < flat.numMovingNodes; i++) {
      tree.movingNodes.push_back(flat.movingNodes[i]);
      for (uint32_t& child : tree.movingNodes.back().atZero.children) child = renumbered(child, s);
    }
    for (size_t i = 0; i < flat.numGridLeaves; i++)
      leaves.push_back({firstBlock[s] + flat.gridLeaves[i].block, flat.gridLeaves[i].vertex});
    if (flat.numGridLeaves) out.kinds |= 1u << gridLeafReferenceType;
    if (flat.numMovingNodes) out.kinds |= 1u << movingNodeReferenceType;
    out.statistics.numBlocks += flat.numBlocks;
  }

  /* Converts a reference of input s to the shared arrays, and adds the type of a block to out.kinds. */
  uint32_t renumbered(uint32_t reference, size_t s) {
    if (reference == emptyReference) return reference;
    const uint32_t type = referenceType(reference), index = referenceIndex(reference);
    if (type == nodeReferenceType) return makeReference(type, uint32_t(offsets[s].node) + index);
    if (type == movingNodeReferenceType) return makeReference(type, uint32_t(offsets[s].movingNode) + index);
    if (type == gridLeafReferenceType) return makeReference(type, uint32_t(offsets[s].leaf) + index);
    out.kinds |= 1u << type;
    return makeReference(type, firstBlock[s] + index);
  }

  /* --- writing --- */

  /* Appends the triangles to `leaves`, and adjusts references to them. */
  void appendTriangles() {
    if (tree.triangles.empty()) return;
    out.kinds |= 1u << firstRunReferenceType;
    const uint32_t first = uint32_t(leaves.size());
    requireIndexable(first + tree.triangles.size(), "triangles and leaves of grids");
    auto adjusted = [&](uint32_t reference) {
      return isRunType(referenceType(reference)) ? reference + first : reference;
    };
    for (FlatNode& node : tree.nodes)
      for (uint32_t& child : node.children) child = adjusted(child);
    for (InputScene& input : inputs) input.tree.root = adjusted(input.tree.root);
    for (const auto& triangle : tree.triangles) leaves.push_back(triangle);
  }

  /* Uploads an array into memory of the scene. An empty array has an address, too. what: for messages. */
  template<typename T>
  Slice writeArray(const T* data, size_t count, const char* what) {
    const Slice slice = out.arena.allocate(std::max(count, size_t(1)) * sizeof(T), what);
    if (count) uploader.write(slice, 0, data, count * sizeof(T));
    return slice;
  }

  GeometryData uploadGeometry(const InputScene& input, const FlatGeometry& geometry) {
    GeometryData data = GeometryData();
    data.mask = geometry.type == FLAT_NONE ? 0 : geometry.mask;
    data.isRobust = input.flat->isRobust;
    if (geometry.type == FLAT_TRIANGLES && geometry.numTriangles) {
      /* without the padding after the last element, which may be unreadable */
      const size_t vertexBytes = geometry.numVertices ? (geometry.numVertices - 1) * geometry.vertexStride + 12 : 0;
      const size_t indexBytes = (geometry.numTriangles - 1) * geometry.indexStride + 12;
      data.vertices = writeArray(geometry.vertices, vertexBytes, "vertices of a triangle mesh").address();
      data.indices = writeArray(geometry.indices, indexBytes, "indices of a triangle mesh").address();
      data.vertexStride = uint32_t(geometry.vertexStride / 4);
      data.indexStride = uint32_t(geometry.indexStride / 4);
    }
    if (geometry.type == FLAT_INSTANCE) {
      const InputScene& instanced = inputs[inputIndex.at(geometry.instanced)];
      std::copy(geometry.worldToLocal, geometry.worldToLocal + 12, data.worldToLocal);
      data.numSteps = geometry.numTimeSteps;
      if (geometry.numTimeSteps > 1) {
        data.begin = geometry.begin;
        data.end = geometry.end;
        data.transforms =
            writeArray(geometry.localToWorld, 12 * size_t(geometry.numTimeSteps), "transforms of an instance")
                .address();
      }
      data.root = instanced.tree.root;
      data.firstGeometry = instanced.firstGeometry;
      out.kinds |= 1u << instanceReferenceType;
    }
    return data;
  }

  /* --- ray queries --- */

  uint32_t geomIDOf(uint32_t reference) const {
    const uint32_t type = referenceType(reference), index = referenceIndex(reference);
    if (isRunType(type)) return RTC_INVALID_GEOMETRY_ID;
    return blocks[type == gridLeafReferenceType ? leaves[index][0] : index].geomID;
  }

  struct SceneBoxes {
    LeafBoxes boxes;
    VkDeviceAddress address;
    size_t level; // result of addLevel: a bottom level in the instanced scene's space
  };

  /* Adds bottom levels and instances of all inputs. Moving instances have bottom levels of their own, for all times. */
  void addLevelsAndInstances(QueryStructuresBuilder& builder) {
    const float identity[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    const auto unchanged = [](const Bounds& b) { return b; };
    std::vector<std::vector<SceneBoxes>> boxesOfInputs(inputs.size());
    for (size_t s = 0; s < inputs.size(); s++)
      for (LeafBoxes& boxes :
           leafBoxesOf(tree, inputs[s].tree, [&](uint32_t reference) { return geomIDOf(reference); })) {
        const VkDeviceAddress address = writeArray(boxes.boxes.data(), boxes.boxes.size(), "boxes of blocks").address();
        const size_t level =
            builder.addLevel(boxes, QueryStructures::LevelID(s, boxes.geomID, RTC_INVALID_GEOMETRY_ID), unchanged);
        if (s == 0) builder.addInstance(level, identity, {address, RTC_INVALID_GEOMETRY_ID, 0});
        else boxesOfInputs[s].push_back({std::move(boxes), address, level});
      }
    const FlatScene& top = *inputs[0].flat;
    for (size_t i = 0; i < top.numGeometries; i++) {
      const FlatGeometry& instance = top.geometries[i];
      if (instance.type != FLAT_INSTANCE || worldBounds(instance).isEmpty()) continue;
      const size_t s = inputIndex.at(instance.instanced);
      if (instance.numTimeSteps == 1 && !isInvertible(instance)) continue;
      for (const SceneBoxes& sceneBoxes : boxesOfInputs[s]) {
        const PlacedBoxes placed = {sceneBoxes.address, uint32_t(i), inputs[s].firstGeometry};
        if (instance.numTimeSteps == 1) builder.addInstance(sceneBoxes.level, instance.localToWorld, placed);
        else
          builder.addInstance(
              builder.addLevel(sceneBoxes.boxes, QueryStructures::LevelID(s, sceneBoxes.boxes.geomID, uint32_t(i)),
                               [&](const Bounds& b) { return worldBounds(instance, b.lower, b.upper); }),
              identity, placed);
      }
    }
  }

  void write() {
    appendTriangles();
    std::vector<GeometryData> geometries;
    uint32_t instancedDepth = 0;
    for (size_t s = 0; s < inputs.size(); s++) {
      for (size_t i = 0; i < inputs[s].flat->numGeometries; i++)
        geometries.push_back(uploadGeometry(inputs[s], inputs[s].flat->geometries[i]));
      if (s > 0) instancedDepth = std::max(instancedDepth, inputs[s].tree.depth);
    }
    /* Traversal pushes up to three children per node. Two more entries, because an empty scene also needs a stack. A
     * multiple of 32, so that scenes of similar depth share a pipeline. */
    const uint32_t depth = inputs[0].tree.depth + instancedDepth;
    out.statistics.stackSize = (3 * depth + 2 + 31) & ~31u;

    static_assert(sizeof(FlatNode) == nodeBytes && sizeof(FlatMovingNode) == movingNodeBytes, "layout of a node");
    SceneData data = SceneData();
    data.nodes = writeArray(tree.nodes.data(), tree.nodes.size(), "nodes").address();
    data.movingNodes = tree.movingNodes.empty()
                           ? data.nodes
                           : writeArray(tree.movingNodes.data(), tree.movingNodes.size(), "moving nodes").address();
    data.blocks = writeArray(blocks.data(), blocks.size(), "addresses of blocks").address();
    data.leaves = writeArray(leaves.data(), leaves.size(), "leaves").address();
    data.geometries = writeArray(geometries.data(), geometries.size(), "geometries").address();
    if (out.usesRayQuery) {
      QueryStructuresBuilder builder(device, uploader,
                                     options.previousScene ? &options.previousScene->structures : nullptr);
      addLevelsAndInstances(builder);
      data.placed = writeArray(builder.placedBoxes().data(), builder.placedBoxes().size(), "placed boxes").address();
      builder.build(out.arena, out.structures, out.statistics);
      data.topLevel = out.structures.topLevel->address;
    }
    data.root = inputs[0].tree.root;
    std::copy(inputs[0].tree.bounds.lower, inputs[0].tree.bounds.lower + 3, data.lower);
    std::copy(inputs[0].tree.bounds.upper, inputs[0].tree.bounds.upper + 3, data.upper);
    out.address = writeArray(&data, 1, "a scene").address();
    uploader.flush();

    RTCVulkanSceneStatistics& statistics = out.statistics;
    statistics.numNodes = tree.nodes.size() + tree.movingNodes.size();
    statistics.numGeometries = numGeometries;
    statistics.topLevelBytes = tree.nodes.size() * sizeof(FlatNode) + tree.movingNodes.size() * sizeof(FlatMovingNode) +
                               leaves.size() * sizeof(leaves[0]) + blocks.size() * sizeof(BlockData);
    statistics.importedBytes = out.blocks.importedBytes;
    statistics.uploadedBytes = uploader.written;
    statistics.deviceBytes =
        out.arena.bytes() + statistics.structureBytes + (statistics.importedBytes ? 0 : out.blocks.bytes());
    if (statistics.importedBytes) {
      out.source = inputs[0].scene;
      rtcRetainScene(out.source);
    }
  }

  Scene& out;
  Device& device;
  const SceneOptions options;
  const RTCVulkanMemory memory;
  Uploader uploader;
  std::vector<InputScene> inputs;        // first is the traced scene
  std::map<RTCScene, size_t> inputIndex; // index of a scene in inputs
  uint32_t numGeometries = 0;
  std::vector<uint32_t> firstBlock; // index of the first block of each input in blocks
  std::vector<BlockData> blocks;
  Tree tree;
  std::vector<std::array<uint32_t, 2>> leaves;
  std::vector<SceneOffsets> offsets;
};

Scene::Scene(Device& device, RTCScene scene, const SceneOptions& options)
  : device(device),
    held(device),
    usesRayQuery(options.usesRayQuery),
    arena(device) {
  SceneUpload(*this, scene, options);
}

Scene::~Scene() {
  blocks = BlockBuffers(); // first, because they may import memory of `source`
  if (source) rtcReleaseScene(source);
}

void Scene::record(Query query, VkPipeline pipeline, VkCommandBuffer commands, VkDeviceAddress rays, size_t count,
                   VkDeviceAddress order) const {
  const DeviceFunctions& vk = device.vk;
  vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  const size_t groupSize = 64; // local_size_x of trace.comp
  /* the shader indexes words of rays with 32 bits: 2^26 rays of 20 words fit */
  const size_t maxRays =
      std::min(size_t(device.capabilities.properties.limits.maxComputeWorkGroupCount[0]) * groupSize, size_t(1) << 26);
  const size_t rayBytes = query == CLOSEST_HIT ? sizeof(RTCRayHit) : sizeof(RTCRay);
  for (size_t first = 0; first < count; first += maxRays) {
    const size_t n = std::min(count - first, maxRays);
    const TraceArguments arguments = order ? TraceArguments{address, rays, order, uint32_t(first), uint32_t(n)}
                                           : TraceArguments{address, rays + first * rayBytes, 0, 0, uint32_t(n)};
    vk.CmdPushConstants(commands, device.pipelineLayout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(arguments),
                        &arguments);
    vk.CmdDispatch(commands, uint32_t((n + groupSize - 1) / groupSize), 1, 1);
  }
}

} // namespace embree::vulkan
