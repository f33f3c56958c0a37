// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* An application adds a compressed scene to its own top level next to its triangles, and queries it with its own
 * shader, own_top_level.comp. */

#include "small_scenes.h"
#include "recorded_trace.h"

#include <vulkan/vulkan.h>

#include <stdexcept>

namespace programs::test { namespace {

const uint32_t code[] =
#include "own_top_level.inc"
    ;

constexpr unsigned triangleName = 1000;

// Functions of the extension, which the loader does not export.
struct Functions {
  explicit Functions(VkDevice device) {
    const auto get = [&](const char* name) {
      const PFN_vkVoidFunction found = vkGetDeviceProcAddr(device, name);
      if (!found) throw std::runtime_error(std::string("missing function ") + name);
      return found;
    };
    create = PFN_vkCreateAccelerationStructureKHR(get("vkCreateAccelerationStructureKHR"));
    destroy = PFN_vkDestroyAccelerationStructureKHR(get("vkDestroyAccelerationStructureKHR"));
    sizes = PFN_vkGetAccelerationStructureBuildSizesKHR(get("vkGetAccelerationStructureBuildSizesKHR"));
    address = PFN_vkGetAccelerationStructureDeviceAddressKHR(get("vkGetAccelerationStructureDeviceAddressKHR"));
    build = PFN_vkCmdBuildAccelerationStructuresKHR(get("vkCmdBuildAccelerationStructuresKHR"));
  }

  PFN_vkCreateAccelerationStructureKHR create;
  PFN_vkDestroyAccelerationStructureKHR destroy;
  PFN_vkGetAccelerationStructureBuildSizesKHR sizes;
  PFN_vkGetAccelerationStructureDeviceAddressKHR address;
  PFN_vkCmdBuildAccelerationStructuresKHR build;
};

constexpr VkBufferUsageFlags inputUsage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
constexpr VkBufferUsageFlags storageUsage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;

// An acceleration structure of one geometry, built immediately.
class OwnStructure {
public:
  OwnStructure(const RTCVulkanDeviceHandles& handles, const Functions& functions, VkAccelerationStructureTypeKHR type,
               const VkAccelerationStructureGeometryKHR& geometry, uint32_t count)
    : handles(handles),
      functions(functions) {
    VkAccelerationStructureBuildGeometryInfoKHR info = {};
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.type = type;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    VkAccelerationStructureBuildSizesInfoKHR sizes = {};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    functions.sizes(handles.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &count, &sizes);
    memory = std::make_unique<RayBuffer>(handles, nullptr, sizes.accelerationStructureSize, storageUsage);
    constexpr VkDeviceAddress alignment = 256;
    const RayBuffer scratch(handles, nullptr, sizes.buildScratchSize + alignment);
    VkAccelerationStructureCreateInfoKHR create = {};
    create.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
    create.buffer = memory->buffer;
    create.size = sizes.accelerationStructureSize;
    create.type = type;
    if (functions.create(handles.device, &create, nullptr, &handle) != VK_SUCCESS)
      throw std::runtime_error("vkCreateAccelerationStructureKHR failed");
    info.dstAccelerationStructure = handle;
    info.scratchData.deviceAddress = (scratch.address + alignment - 1) / alignment * alignment;
    const VkAccelerationStructureBuildRangeInfoKHR range = {count, 0, 0, 0}, *ranges = &range;
    RecordedTrace commands(handles);
    commands.record([&](VkCommandBuffer buffer) { functions.build(buffer, 1, &info, &ranges); });
    commands.submitAndWait();
    VkAccelerationStructureDeviceAddressInfoKHR ask = {};
    ask.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
    ask.accelerationStructure = handle;
    address = functions.address(handles.device, &ask);
  }
  ~OwnStructure() { functions.destroy(handles.device, handle, nullptr); }
  OwnStructure(const OwnStructure&) = delete;
  OwnStructure& operator=(const OwnStructure&) = delete;

  VkDeviceAddress address = 0;

private:
  const RTCVulkanDeviceHandles handles;
  const Functions functions;
  std::unique_ptr<RayBuffer> memory;
  VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
};

struct Arguments {
  VkDeviceAddress scene, topLevel, rays;
  uint32_t count;
  float offset;
};

// Runs own_top_level.comp.
void query(const RTCVulkanDeviceHandles& handles, const Arguments& arguments) {
  VkShaderModuleCreateInfo moduleInfo = {};
  moduleInfo.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  moduleInfo.codeSize = sizeof(code);
  moduleInfo.pCode = code;
  VkShaderModule module;
  const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(Arguments)};
  VkPipelineLayoutCreateInfo layoutInfo = {};
  layoutInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layoutInfo.pushConstantRangeCount = 1;
  layoutInfo.pPushConstantRanges = &range;
  VkPipelineLayout layout;
  ASSERT_EQ(vkCreateShaderModule(handles.device, &moduleInfo, nullptr, &module), VK_SUCCESS);
  ASSERT_EQ(vkCreatePipelineLayout(handles.device, &layoutInfo, nullptr, &layout), VK_SUCCESS);
  VkComputePipelineCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout;
  VkPipeline pipeline;
  ASSERT_EQ(vkCreateComputePipelines(handles.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), VK_SUCCESS);
  {
    RecordedTrace commands(handles);
    commands.record([&](VkCommandBuffer buffer) {
      vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      vkCmdPushConstants(buffer, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(arguments), &arguments);
      vkCmdDispatch(buffer, (arguments.count + 63) / 64, 1, 1);
    });
    commands.submitAndWait();
  }
  vkDestroyPipeline(handles.device, pipeline, nullptr);
  vkDestroyPipelineLayout(handles.device, layout, nullptr);
  vkDestroyShaderModule(handles.device, module, nullptr);
}

class VulkanOwnTopLevel : public VulkanTest {
protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (vulkan && !vulkan->handles.hasRayQuery) GTEST_SKIP() << vulkan->name << " does not support ray queries";
  }
};

// The application moves the scene along x, and its triangle intersects the scene.
TEST_F(VulkanOwnTopLevel, SceneNextToTrianglesMatchesCpu) {
  const RTCVulkanDeviceHandles& handles = vulkan->handles;
  const Functions functions(handles.device);
  Random random{97};
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.rate = 16;

  /* an instance next to a surface */
  Scene inside(embree), scene(embree);
  addSurface(embree, inside, cubeCage(), settings);
  rtcCommitScene(inside);
  attach(scene, newInstance(embree, inside, 0.4f));
  addSurface(embree, scene, sheetCage(3), settings);
  rtcCommitScene(scene);
  const VulkanScene onDevice = newQueryScene(device, scene);
  ASSERT_NE(onDevice, nullptr) << embree.message;

  const std::vector<Vec> vertices = {{-2, -2, 0.1f}, {3, -2, 0.3f}, {-2, 3, -0.2f}};
  const RayBuffer input(handles, vertices.data(), sizeof(Vec) * vertices.size(), inputUsage);
  VkAccelerationStructureGeometryKHR triangles = {};
  triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  triangles.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
  triangles.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  triangles.geometry.triangles = {};
  triangles.geometry.triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
  triangles.geometry.triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
  triangles.geometry.triangles.vertexData.deviceAddress = input.address;
  triangles.geometry.triangles.vertexStride = sizeof(Vec);
  triangles.geometry.triangles.maxVertex = uint32_t(vertices.size() - 1);
  triangles.geometry.triangles.indexType = VK_INDEX_TYPE_NONE_KHR;
  const OwnStructure mesh(handles, functions, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, triangles, 1);

  constexpr float offset = 0.25f;
  std::vector<VkAccelerationStructureInstanceKHR> instances(rtcGetVulkanSceneInstances(onDevice.get(), nullptr, 0));
  ASSERT_EQ(rtcGetVulkanSceneInstances(onDevice.get(), instances.data(), unsigned(instances.size())), 2u);
  for (VkAccelerationStructureInstanceKHR& instance : instances) instance.transform.matrix[0][3] += offset;
  VkAccelerationStructureInstanceKHR own = {};
  own.transform.matrix[0][0] = own.transform.matrix[1][1] = own.transform.matrix[2][2] = 1;
  own.mask = 0xFF;
  own.accelerationStructureReference = mesh.address;
  instances.push_back(own);
  const RayBuffer instanceInput(handles, instances.data(), sizeof(instances[0]) * instances.size(), inputUsage);
  VkAccelerationStructureGeometryKHR list = {};
  list.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  list.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  list.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
  list.geometry.instances.data.deviceAddress = instanceInput.address;
  const OwnStructure topLevel(handles, functions, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, list,
                              uint32_t(instances.size()));

  std::vector<RTCRayHit> rays = raysAt(random, 20000);
  const RayBuffer buffer(handles, rays.data(), sizeof(RTCRayHit) * rays.size());
  query(handles,
        {rtcGetVulkanSceneAddress(onDevice.get()), topLevel.address, buffer.address, uint32_t(rays.size()), offset});
  const RTCRayHit* found = static_cast<const RTCRayHit*>(buffer.mapped);

  /* the same world on the CPU, including the triangle */
  Scene world(embree);
  RTCGeometry whole = newInstance(embree, inside, 0);
  const float transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, offset, 0, 0.4f};
  rtcSetGeometryTransform(whole, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(whole);
  attach(world, whole);
  Scene sheet(embree);
  addSurface(embree, sheet, sheetCage(3), settings);
  rtcCommitScene(sheet);
  RTCGeometry moved = newInstance(embree, sheet, 0);
  const float aside[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, offset, 0, 0};
  rtcSetGeometryTransform(moved, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, aside);
  rtcCommitGeometry(moved);
  attach(world, moved);
  RTCGeometry mesh3 = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_TRIANGLE);
  setBuffer(mesh3, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices);
  setBuffer(mesh3, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, std::vector<std::array<unsigned, 3>>{{0, 1, 2}});
  rtcCommitGeometry(mesh3);
  attach(world, mesh3);
  rtcCommitScene(world);

  size_t differing = 0, counts[4] = {};
  for (size_t i = 0; i < rays.size(); i++) {
    const RTCRayHit truth = intersect(world, rays[i]);
    const unsigned kind = !isHit(truth) ? 3 : truth.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? truth.hit.instID[0] : 2;
    counts[kind]++;
    bool same = isHit(found[i]) == isHit(truth) &&
                (kind == 3 || std::fabs(found[i].ray.tfar - truth.ray.tfar) <= 1e-5f * truth.ray.tfar);
    if (kind == 0)
      same = same && found[i].hit.geomID == 0 && found[i].hit.instID[0] == 0 && found[i].hit.primID == truth.hit.primID;
    if (kind == 1)
      same = same && found[i].hit.geomID == 1 && found[i].hit.instID[0] == RTC_INVALID_GEOMETRY_ID &&
             found[i].hit.primID == truth.hit.primID;
    if (kind == 2) same = same && found[i].hit.geomID == triangleName;
    differing += !same;
  }
  for (size_t count : counts) EXPECT_GT(count, 500u);
  EXPECT_LE(differing, 3u);
}

}} // namespace programs::test
