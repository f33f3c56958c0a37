// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing rays against a committed scene on a Vulkan device. Library: libembree3_vulkan.so.
 *
 * There are three ways to use a scene, in this order of worth:
 *
 * - in a shader of your own: `#include <embree3/cbvh.glsl>` and call cbvhIntersect(scene, ray, hit)
 *   and cbvhOccluded(scene, ray) with the address of rtcGetVulkanSceneAddress;
 * - on a device of your own: rtcRecordVulkanIntersect and rtcRecordVulkanOccluded record the trace of
 *   a buffer of rays into a command buffer;
 * - from the host: rtcStartVulkanIntersect and rtcStartVulkanOccluded take arrays of rays.
 *
 * On devices with VK_KHR_acceleration_structure and VK_KHR_ray_query a scene may be one for ray queries
 * (RTC_VULKAN_TRAVERSAL_RAY_QUERY): the driver has a box for each block then. All of the above goes through its structures; and the scene can be placed
 * in a top level of your own, beside your own triangles, with the instances of rtcGetVulkanSceneInstances.
 *
 * A device needs Vulkan 1.2 with the features bufferDeviceAddress and scalarBlockLayout. With
 * shaderFloat64 the distances of hits in cVERT are computed in double, as on the processor; without it in float.
 *
 * rtcGetVulkanDevices and rtcNewVulkanDevice load libvulkan.so.1, or the loader of Vulkan that the environment
 * variable EMBREE_VULKAN_LOADER names.
 *
 * This header includes Vulkan's. Who loads functions of Vulkan themselves, by volk for one, defines
 * VK_NO_PROTOTYPES before, as always.
 *
 * Errors: as everywhere in Embree a function that fails returns NULL or 0, the error is read with
 * rtcGetDeviceError of the RTCDevice, and its message goes to the function that
 * rtcSetDeviceErrorFunction sets. A limit that is met is named with its value.
 *
 * Structs begin with structSize, by the rule of rtcore_compression.h.
 *
 * Thread safety: functions of different objects may be called at the same time. The queue of a
 * device is used by rtcNewVulkanScene and rtcStart..., one call at a time: who uses it besides, their own or that
 * of rtcGetVulkanDeviceHandles, does not use it in the meantime. */

#include "rtcore_compression.h"
#include <vulkan/vulkan_core.h>

RTC_NAMESPACE_BEGIN

/* --- devices --------------------------------------------------------------------------- */

typedef struct RTCVulkanDeviceTy* RTCVulkanDevice;

/* What there is to open. */
struct RTCVulkanDeviceInfo
{
  size_t structSize RTC_SIZE_OF(RTCVulkanDeviceInfo); /* see rtcore_compression.h */
  char name[256];           /* as Vulkan has it: "llvmpipe (LLVM 15.0.6, 256 bits)" */
  char driver[256];         /* name and version of the driver */
  char unsupported[256];    /* what it lacks, in words; empty if it can be opened */
  unsigned int isDiscrete;  /* has memory of its own */
  unsigned int hasFloat64;
  size_t memoryBytes;       /* of the largest heap of its own memory */
  unsigned int hasRayQuery; /* VK_KHR_acceleration_structure and VK_KHR_ray_query */
};

/* Lists the Vulkan devices of the machine, in the order of Vulkan's loader. device: gets errors, may be
 * NULL. infos: room for `capacity` of them, or NULL; structSize is set in each, and is the distance in bytes from one
 * to the next. Returns how many there are, 0 also if there is no loader, or if a structSize is wrong. */
RTC_API unsigned int rtcGetVulkanDevices (RTCDevice device, struct RTCVulkanDeviceInfo* infos, unsigned int capacity);

/* Opens a device. which: an index of rtcGetVulkanDevices ("0"), or a part of a name ("llvmpipe", "nvidia";
 * case does not matter), or NULL or "" for the first that can be opened, discrete ones first. Errors: no loader, no
 * device, none of that name, one that lacks a feature. */
RTC_API RTCVulkanDevice rtcNewVulkanDevice (RTCDevice device, const char* which);

/* A device of the application's: for instance one with extensions, as for a window, that rtcNewVulkanDevice
 * does not enable. All handles are its own and outlive the RTCVulkanDevice. */
struct RTCVulkanHandles
{
  size_t structSize RTC_SIZE_OF(RTCVulkanHandles); /* see rtcore_compression.h */
  PFN_vkGetInstanceProcAddr getInstanceProcAddr;
  VkInstance instance;              /* of an application of Vulkan 1.2 or later */
  VkPhysicalDevice physicalDevice;
  VkDevice device;                  /* with bufferDeviceAddress and scalarBlockLayout enabled */
  VkQueue queue;                    /* that can compute */
  uint32_t queueFamily;
  unsigned int hasFloat64;          /* shaderFloat64 is enabled */
  unsigned int hasHostImport;       /* VK_EXT_external_memory_host is enabled */
  unsigned int hasRayQuery;         /* VK_KHR_acceleration_structure and VK_KHR_ray_query and their features are enabled */
};

/* Takes a device of the application's. handles: read during the call. Errors: handles that are missing, a wrong
 * structSize. */
RTC_API RTCVulkanDevice rtcNewVulkanDeviceFromHandles (RTCDevice device, const struct RTCVulkanHandles* handles);

/* Add a reference to a device, or take one away: without any, it is closed. Its scenes keep one. */
RTC_API void rtcRetainVulkanDevice (RTCVulkanDevice device);
RTC_API void rtcReleaseVulkanDevice (RTCVulkanDevice device);

/* Return the device that was opened, or given: what it is, and its handles. info, handles: written during the call;
 * structSize is read. */
RTC_API void rtcGetVulkanDeviceInfo (RTCVulkanDevice device, struct RTCVulkanDeviceInfo* info);
RTC_API void rtcGetVulkanDeviceHandles (RTCVulkanDevice device, struct RTCVulkanHandles* handles);

/* --- scenes ---------------------------------------------------------------------------- */

typedef struct RTCVulkanSceneTy* RTCVulkanScene;

enum RTCVulkanMemory
{
  RTC_VULKAN_MEMORY_AUTO = 0,   /* imports if the memory of the device is the host's and can be imported, else copies */
  RTC_VULKAN_MEMORY_COPY = 1,   /* to memory of the device */
  RTC_VULKAN_MEMORY_IMPORT = 2  /* blocks stay in the host's memory: needs VK_EXT_external_memory_host. An error if the
                                   driver refuses the memory: some drivers do not import mapped files, in which
                                   rtcLoadCompressedGeometry keeps blocks */
};

enum RTCVulkanTraversal
{
  RTC_VULKAN_TRAVERSAL_COMPUTE = 0,   /* the scene's own tree, in compute shaders */
  RTC_VULKAN_TRAVERSAL_RAY_QUERY = 1  /* the driver's structures, a box for each block */
};

struct RTCVulkanSceneArguments
{
  size_t structSize RTC_SIZE_OF(RTCVulkanSceneArguments); /* see rtcore_compression.h */
  enum RTCVulkanMemory memory;
  enum RTCVulkanTraversal traversal;
  RTCVulkanScene previous;      /* of ray queries, or NULL: a scene before an edit. Where a geometry has other blocks now, but as many, the
                                   driver updates the structure that this scene has, which is faster than to build one, and traced
                                   slower the farther the geometry has moved */
};

/* Puts a committed scene on a device, with the scenes that it instances. It does not change when the scene is
 * committed again: make a new one then, and release the old one afterwards: blocks of compressed surfaces that did not
 * change in between are not sent again, nor those that another scene on the device has. With imported memory the RTCScene
 * has to stay as it is for as long as this one lives; it is retained.
 *
 * Taken are subdivision surfaces (GRID and every compression), compressed grids, quads and triangles, triangle meshes and instances, without
 * filters of geometries; with motion blur what is compressed, and instances with linear transforms. Anything else that is enabled is
 * an error that names the geometry.
 *
 * A scene for ray queries has a bottom level for each geometry, with boxes in Morton order; what did not change since another scene on the
 * device was made is not built again. Rays of the library's own shaders may start up to 20 times as far from a geometry as it is large or far
 * from the origin: farther out the driver's arithmetic may lose a box at its edge.
 * args: NULL for defaults. */
RTC_API RTCVulkanScene rtcNewVulkanScene (RTCVulkanDevice device, RTCScene scene, const struct RTCVulkanSceneArguments* args);

/* Add a reference to a scene, or take one away: without any, its memory on the device is freed. */
RTC_API void rtcRetainVulkanScene (RTCVulkanScene scene);
RTC_API void rtcReleaseVulkanScene (RTCVulkanScene scene);

/* Gives shaders the scene: what cbvhIntersect takes, as two words, the lower first. */
RTC_API VkDeviceAddress rtcGetVulkanSceneAddress (RTCVulkanScene scene);

/* Lists the kinds of leaves that the scene has: what a shader may define as CBVH_KINDS, so that it is compiled for no other. */
RTC_API unsigned int rtcGetVulkanSceneKinds (RTCVulkanScene scene);

/* Gives what a top level of the application's own needs to have the scene: an instance for each geometry, and for each geometry of each
 * instanced scene. scene: made for ray queries. instances: room for `capacity` of them, or NULL. Returns how many there are. The mask is
 * 0xFF, the custom index what cbvhIntersectCandidate reads; transforms are those of instances, and may be multiplied from the left by one of
 * your own. What they refer to lives as long as the scene. */
RTC_API unsigned int rtcGetVulkanSceneInstances (RTCVulkanScene scene, VkAccelerationStructureInstanceKHR* instances, unsigned int capacity);

struct RTCVulkanSceneStatistics
{
  size_t structSize RTC_SIZE_OF(RTCVulkanSceneStatistics); /* see rtcore_compression.h */
  size_t deviceBytes;       /* of the device's memory, everything included, also what scenes share */
  size_t importedBytes;     /* of the host's memory, used in place */
  size_t topLevelBytes;     /* of the tree above blocks, and of their addresses */
  size_t numNodes, numBlocks, numGeometries, numInstances;
  unsigned int stackSize;   /* entries that a ray may need: what a shader defines as CBVH_STACK, at least */
  size_t sentBytes;         /* to the device, when the scene was made: without what it had from other scenes */
  /* of a scene for ray queries */
  size_t structureBytes;    /* of the driver's structures, which deviceBytes includes, also what scenes share */
  size_t numBoxes;          /* in bottom levels */
  size_t numBuiltBoxes, numUpdatedBoxes; /* of which in such that were built, or updated, for this scene */
};

/* Reports what a scene takes on its device. statistics: written during the call; structSize is read. */
RTC_API void rtcGetVulkanSceneStatistics (RTCVulkanScene scene, struct RTCVulkanSceneStatistics* statistics);

/* --- tracing --------------------------------------------------------------------------- */

/* Records the trace of `count` rays at a device address, which is a multiple of 16. Intersect: RTCRayHit, of which
 * geomID and instID are RTC_INVALID_GEOMETRY_ID before; those of rays that hit nothing are left as they are.
 * Occluded: RTCRay, of which tfar becomes -inf if something is hit. Barriers before and after
 * are the caller's: the trace reads and writes the buffer in VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT. It binds a
 * compute pipeline and sets push constants. Returns false if it fails, true else. */
RTC_API bool rtcRecordVulkanIntersect (RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays, size_t count);
RTC_API bool rtcRecordVulkanOccluded (RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays, size_t count);

/* Record a sort of the indices of rays, by origin and direction, and traces in that order; rays stay where they are.
 * Incoherent rays are faster where neighbours in the buffer start near each other and go the same way. Worth it
 * for rays of several bounces, not for rays of a camera.
 * rays: at a multiple of 16, `stride` bytes apart, each begins as an RTCRay does. order: memory of the device for
 * rtcGetVulkanRayOrderBytes(count) bytes, at a multiple of 16. Behind the sort there is a barrier to compute shaders. */
RTC_API size_t rtcGetVulkanRayOrderBytes (size_t count);
RTC_API bool rtcRecordVulkanRayOrder (RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays, size_t stride, size_t count, VkDeviceAddress order);
RTC_API bool rtcRecordVulkanIntersectInOrder (RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays, size_t count, VkDeviceAddress order);
RTC_API bool rtcRecordVulkanOccludedInOrder (RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays, size_t count, VkDeviceAddress order);

/* Says whether rays of the host, below, are sorted first. They are not by default. */
RTC_API void rtcSetVulkanSceneRaySort (RTCVulkanScene scene, bool enabled);

typedef struct RTCVulkanTraceTy* RTCVulkanTrace;

struct RTCVulkanTimes
{
  size_t structSize RTC_SIZE_OF(RTCVulkanTimes); /* see rtcore_compression.h */
  double seconds;          /* of tracing on the device, without copies; 0 if the device has no clock */
  double copySeconds;      /* of copies of rays and hits on the device */
  double sortSeconds;      /* of rtcSetVulkanSceneRaySort */
};

/* Starts to trace `count` rays of an array, which is read at once. rays: as above. Needs to be ended by
 * rtcWaitVulkanTrace. */
RTC_API RTCVulkanTrace rtcStartVulkanIntersect (RTCVulkanScene scene, const struct RTCRayHit* rays, size_t count);
RTC_API RTCVulkanTrace rtcStartVulkanOccluded (RTCVulkanScene scene, const struct RTCRay* rays, size_t count);

/* Returns whether a trace has ended: rtcWaitVulkanTrace does not wait. */
RTC_API bool rtcIsVulkanTraceDone (RTCVulkanTrace trace);

/* Waits for a trace, writes its rays, of the type that it was started with, and releases it. rays, times: may be
 * NULL; structSize of times is read. Returns false if it failed, as when the device was lost, or for a
 * wrong structSize; rays are then left as they are. */
RTC_API bool rtcWaitVulkanTrace (RTCVulkanTrace trace, void* rays, struct RTCVulkanTimes* times);

RTC_NAMESPACE_END
