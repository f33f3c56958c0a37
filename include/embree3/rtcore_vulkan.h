// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traces rays against a committed scene on a Vulkan device. The library is libembree3_vulkan.so.
 *
 * There are three ways to trace, from the most to the least efficient:
 *
 * - In a shader of the application: `#include <embree3/cbvh.glsl>` and call cbvhIntersect(scene, ray, hit) and
 *   cbvhOccluded(scene, ray) with the address that rtcGetVulkanSceneAddress returns.
 * - On a device of the application: rtcRecordVulkanIntersect and rtcRecordVulkanOccluded record commands that trace a
 *   buffer of rays.
 * - From the host: rtcStartVulkanIntersect and rtcStartVulkanOccluded trace arrays of rays.
 *
 * On devices with VK_KHR_acceleration_structure and VK_KHR_ray_query, a scene can be created for ray queries
 * (RTC_VULKAN_TRAVERSAL_RAY_QUERY). The driver then builds acceleration structures with one box for each block, and
 * all three ways use them. The application can place the scene in a top-level structure of its own, next to its own
 * triangles, with the instances that rtcGetVulkanSceneInstances returns.
 *
 * A device must support Vulkan 1.2 with the features bufferDeviceAddress and scalarBlockLayout. If it has
 * shaderFloat64, distances of hits in cVERT are computed in double, as on the CPU, and otherwise in float.
 *
 * rtcGetVulkanDevices and rtcNewVulkanDevice load libvulkan.so.1, or the Vulkan loader that the environment variable
 * EMBREE_VULKAN_LOADER names.
 *
 * This header includes Vulkan's. An application that loads Vulkan's functions itself, for example with volk, defines
 * VK_NO_PROTOTYPES first.
 *
 * Errors: as in Embree, a function that fails returns NULL, 0 or false. rtcGetDeviceError of the RTCDevice returns the
 * error code, and the function that rtcSetDeviceErrorFunction sets receives the message. Without an RTCDevice, and if
 * the object of a function is NULL, rtcGetDeviceError(NULL) returns the code. Messages about an exceeded limit name the
 * limit and the value. The codes:
 *
 * - RTC_ERROR_INVALID_ARGUMENT: an argument is NULL although the comment does not allow it, or is out of range, or a
 *   structSize is wrong.
 * - RTC_ERROR_INVALID_OPERATION: the scene is not committed or contains what the device cannot trace, or the device was
 *   not opened for the operation.
 * - RTC_ERROR_OUT_OF_MEMORY: memory of the host or the device ran out.
 * - RTC_ERROR_UNSUPPORTED_CPU: there is no Vulkan loader, no driver, or no device with the required features.
 * - RTC_ERROR_UNKNOWN: a function of Vulkan failed for another reason, for example because the device was lost.
 *
 * Structs begin with structSize, see rtcore_compression.h. `unsigned int` members that begin with `is` or `has` are 0
 * or 1, as VkBool32. The manual page of a function names the version since which the function is available.
 *
 * Cost: the first closest-hit and the first any-hit trace of a scene compile a shader, unless an earlier scene with the
 * same kinds of leaves, stackSize and traversal did. Compiled shaders are kept in the folder embree-cbvh of
 * $XDG_CACHE_HOME, or of ~/.cache, between runs.
 *
 * Thread safety: any thread may call any function, also for the same object, with these restrictions: a command buffer
 * and a trace are used by one thread at a time. rtcNewVulkanScene and the rtcStart functions use the queue of the
 * device, one call at a time. An application that uses the same queue, its own or the queue that
 * rtcGetVulkanDeviceHandles returns, must not use it during these calls. */

#include "rtcore_compression.h"
#include <vulkan/vulkan_core.h>

RTC_NAMESPACE_BEGIN

/* --- devices --------------------------------------------------------------------------- */

typedef struct RTCVulkanDeviceTy* RTCVulkanDevice;

/* Description of a Vulkan device. */
struct RTCVulkanDeviceInfo {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCVulkanDeviceInfo); /* see rtcore_compression.h */
  char name[256] RTC_ZERO;              /* as Vulkan reports it, for example "llvmpipe (LLVM 15.0.6, 256 bits)" */
  char driver[256] RTC_ZERO;            /* name and version of the driver */
  char unsupportedReason[256] RTC_ZERO; /* features that the device lacks, or an error of its driver; empty if it is
                                         * supported */
  unsigned int isDiscrete RTC_ZERO;     /* 1 if the device has its own memory */
  unsigned int hasFloat64 RTC_ZERO;     /* 1 if it has shaderFloat64 */
  size_t memoryBytes RTC_ZERO;          /* size of the largest heap of the device's memory */
  unsigned int hasRayQuery RTC_ZERO;    /* 1 if it has VK_KHR_acceleration_structure and VK_KHR_ray_query with their
                                         * features */
};

/* Lists the Vulkan devices of the machine, in the order of the Vulkan loader.
 *
 * device: receives errors, may be NULL.
 * infos:  written: array of `capacity` entries, or NULL. The application sets structSize in each entry, to the same
 *         value, which is the distance in bytes from one entry to the next.
 *
 * Returns the number of devices, which may exceed `capacity`. Returns 0 also on errors.
 *
 * Errors: RTC_ERROR_UNSUPPORTED_CPU if there is no loader or no driver. RTC_ERROR_INVALID_ARGUMENT for a wrong
 * structSize. An unsupported device is no error, see RTCVulkanDeviceInfo::unsupportedReason. */
RTC_API unsigned int rtcGetVulkanDevices(RTCDevice device, struct RTCVulkanDeviceInfo* infos, unsigned int capacity);

/* Opens a Vulkan device.
 *
 * device:   retained; receives errors. May be NULL.
 * selector: an index of rtcGetVulkanDevices (only digits, "0"), or a part of a name ("llvmpipe", "nvidia"; case is
 *           ignored). NULL or "" selects the first supported device, discrete devices first.
 *
 * Returns the device, to be released by rtcReleaseVulkanDevice, or NULL.
 *
 * Errors: RTC_ERROR_UNSUPPORTED_CPU if there is no loader, no driver or no device, or if all devices that fit lack a
 * feature. RTC_ERROR_INVALID_ARGUMENT if no device has this index or name. */
RTC_API RTCVulkanDevice rtcNewVulkanDevice(RTCDevice device, const char* selector);

/* Handles of a device that the application opened, for example with extensions that rtcNewVulkanDevice does not enable.
 * The application owns them and keeps them valid while the RTCVulkanDevice exists.
 *
 * The library creates its buffers with VK_SHARING_MODE_EXCLUSIVE and writes them on `queue`. Command buffers that trace
 * scenes must therefore be submitted to queues of queueFamily, also if their shaders are the application's. If rays or
 * hits are in exclusive buffers that another queue family used before, the application transfers their ownership. */
struct RTCVulkanDeviceHandles {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCVulkanDeviceHandles); /* see rtcore_compression.h */
  PFN_vkGetInstanceProcAddr getInstanceProcAddr RTC_ZERO;
  VkInstance instance RTC_ZERO; /* created for Vulkan 1.2 or later */
  VkPhysicalDevice physicalDevice RTC_ZERO;
  VkDevice device RTC_ZERO;            /* with bufferDeviceAddress and scalarBlockLayout enabled */
  VkQueue queue RTC_ZERO;              /* supports compute */
  uint32_t queueFamily RTC_ZERO;       /* family of `queue`, and of all queues that trace scenes of the device */
  unsigned int hasFloat64 RTC_ZERO;    /* 1 if shaderFloat64 is enabled */
  unsigned int hasHostImport RTC_ZERO; /* 1 if VK_EXT_external_memory_host is enabled */
  unsigned int hasRayQuery RTC_ZERO;   /* 1 if VK_KHR_acceleration_structure and VK_KHR_ray_query are enabled with
                                        * their features */
};

/* Creates a device from the application's handles.
 *
 * device:  retained; receives errors. May be NULL.
 * handles: read during the call, not NULL.
 *
 * Returns the device, to be released by rtcReleaseVulkanDevice, or NULL.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT if a handle is missing, structSize is wrong, the physical device lacks a feature
 * that is required or that a member declares as enabled, or queueFamily does not support compute.
 * RTC_ERROR_INVALID_OPERATION if the instance or the device has no functions of Vulkan 1.2 or of an extension that a
 * member declares as enabled. */
RTC_API RTCVulkanDevice rtcNewVulkanDeviceFromHandles(RTCDevice device, const struct RTCVulkanDeviceHandles* handles);

/* Add and remove a reference to a device. Removing the last one closes it. Scenes of the device hold a reference.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API void rtcRetainVulkanDevice(RTCVulkanDevice device);
RTC_API void rtcReleaseVulkanDevice(RTCVulkanDevice device);

/* Return the description and the handles of a device.
 *
 * info, handles: written during the call, not NULL; structSize is read. Handles that rtcNewVulkanDevice opened are
 *                valid while the device exists.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a wrong structSize. */
RTC_API void rtcGetVulkanDeviceInfo(RTCVulkanDevice device, struct RTCVulkanDeviceInfo* info);
RTC_API void rtcGetVulkanDeviceHandles(RTCVulkanDevice device, struct RTCVulkanDeviceHandles* handles);

/* --- scenes ---------------------------------------------------------------------------- */

typedef struct RTCVulkanSceneTy* RTCVulkanScene;

/* Location of the blocks of a scene. */
enum RTCVulkanMemory {
  RTC_VULKAN_MEMORY_AUTO = 0,  /* IMPORT if host and device share their memory and the driver can import it, otherwise
                                * COPY */
  RTC_VULKAN_MEMORY_COPY = 1,  /* copies blocks to the memory of the device */
  RTC_VULKAN_MEMORY_IMPORT = 2 /* leaves blocks in host memory. Requires VK_EXT_external_memory_host. Fails if the
                                * driver cannot import the memory: some drivers cannot import mapped files, which
                                * cbvhLoadSurface uses */
};

enum RTCVulkanTraversal {
  RTC_VULKAN_TRAVERSAL_COMPUTE = 0,  /* compute shaders traverse the tree of the scene */
  RTC_VULKAN_TRAVERSAL_RAY_QUERY = 1 /* the driver traverses its own structures, with a box for each block */
};

struct RTCVulkanSceneArguments {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCVulkanSceneArguments); /* see rtcore_compression.h */
  enum RTCVulkanMemory memory RTC_ZERO;
  enum RTCVulkanTraversal traversal RTC_ZERO;
  RTCVulkanScene previousScene RTC_ZERO; /* for ray queries: a scene from before an edit, or NULL. If a geometry has
                                          * new blocks, but the same number of them, the driver updates the
                                          * structure of the previous scene. This is faster than a build; rays
                                          * become slower the farther the geometry has moved. Of the same device,
                                          * also for ray queries. Read during the call only */
};

/* Puts a committed scene on a device, with the scenes that it instances.
 *
 * The Vulkan scene does not change when the scene is committed again: create a new one then, and release the old one
 * afterwards. Blocks of compressed geometry that did not change, or that another scene on the device has, are not sent
 * again. With imported memory, the Vulkan scene retains the scene, which must not change while the Vulkan scene exists.
 * With copied memory, the scene may be changed and released afterwards.
 *
 * Supported are subdivision surfaces (GRID and all compressed representations), compressed grids, quads and triangles,
 * triangle meshes, and instances, all without filter functions. With motion blur, compressed geometry and instances
 * with linear transforms are supported, except for irregular meshes. Any other enabled geometry is an error that names
 * the geometry or what is not supported.
 *
 * A scene for ray queries has a bottom-level structure for each geometry, but one for all triangle meshes of a scene,
 * and further ones for each moving instance. Boxes are in Morton order. Structures of geometry that did not change
 * since another scene on the device was created are not built again. Rays of the library's shaders may start at a
 * distance of up to 20 times the size of a geometry, or 20 times its distance from the origin if that is larger. At
 * larger distances, the driver's arithmetic may miss boxes.
 *
 * device: of the new scene.
 * scene:  committed.
 * args:   read during the call. NULL selects the defaults: all members zero.
 *
 * Returns the scene, to be released by rtcReleaseVulkanScene, or NULL. The function waits for the device.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for invalid members. RTC_ERROR_INVALID_OPERATION for a scene that is
 * not committed, unsupported geometry, instances of scenes with instances, a damaged block, an exceeded limit of the
 * device, and for ray queries or imported memory that the device does not support. If the scene belongs to another
 * RTCDevice than the Vulkan device, that one may receive the reason. */
RTC_API RTCVulkanScene rtcNewVulkanScene(RTCVulkanDevice device, RTCScene scene,
                                         const struct RTCVulkanSceneArguments* args);

/* Add and remove a reference to a scene. Removing the last one frees its memory on the device: no command that traces
 * the scene may be pending then. Traces of the rtcStart functions hold a reference.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API void rtcRetainVulkanScene(RTCVulkanScene scene);
RTC_API void rtcReleaseVulkanScene(RTCVulkanScene scene);

/* Returns the argument `scene` of cbvhIntersect in shaders, which receive it as two words, the lower word first. The
 * address is valid as long as the scene. */
RTC_API VkDeviceAddress rtcGetVulkanSceneAddress(RTCVulkanScene scene);

/* Returns the kinds of leaves in a scene, as a bit mask that only shaders interpret. A shader that defines
 * CBVH_LEAF_KINDS as this mask contains code for no other kinds. */
RTC_API unsigned int rtcGetVulkanSceneLeafKinds(RTCVulkanScene scene);

/* Lists the instances that place a scene in a top-level structure of the application: one for each bottom-level
 * structure of the scene itself, and for each instance in the scene, one for each structure of the instanced scene.
 *
 * scene:     created for ray queries.
 * instances: array of `capacity` entries, or NULL.
 *
 * Returns the number of instances, which may exceed `capacity`. The mask of an instance is 0xFF, and its custom index
 * is read by cbvhIntersectCandidate: the application must not change it. Its transform is the transform of the instance
 * in the scene, and the identity for a moving instance, whose boxes are in world space. The application may multiply it
 * from the left by a transform of its own. The structures that instances refer to live as long as the scene.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. RTC_ERROR_INVALID_OPERATION if the scene was not created for ray
 * queries. */
RTC_API unsigned int rtcGetVulkanSceneInstances(RTCVulkanScene scene, VkAccelerationStructureInstanceKHR* instances,
                                                unsigned int capacity);

/* Memory of a scene on its device, and its size. */
struct RTCVulkanSceneStatistics {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCVulkanSceneStatistics); /* see rtcore_compression.h */
  size_t deviceBytes RTC_ZERO;   /* total memory on the device, including memory that scenes share */
  size_t importedBytes RTC_ZERO; /* host memory that the device reads in place */
  size_t topLevelBytes RTC_ZERO; /* tree above the blocks, and addresses of blocks */
  size_t numNodes RTC_ZERO, numBlocks RTC_ZERO, numGeometries RTC_ZERO, numInstances RTC_ZERO;
  unsigned int stackSize RTC_ZERO; /* stack entries that a ray may need: the smallest CBVH_STACK_SIZE of a shader */
  size_t uploadedBytes RTC_ZERO;   /* bytes sent to the device for this scene, without shared ones */
  /* of scenes for ray queries */
  size_t structureBytes RTC_ZERO; /* the driver's structures, part of deviceBytes, including structures that scenes
                                   * share */
  size_t numBoxes RTC_ZERO;       /* in bottom-level structures, each structure counted once */
  size_t numBuiltBoxes RTC_ZERO, numUpdatedBoxes RTC_ZERO; /* boxes in structures that were built, or updated, for
                                                            * this scene */
};

/* Returns the statistics of a scene.
 *
 * statistics: written during the call, not NULL; structSize is read.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a wrong structSize. */
RTC_API void rtcGetVulkanSceneStatistics(RTCVulkanScene scene, struct RTCVulkanSceneStatistics* statistics);

/* --- tracing --------------------------------------------------------------------------- */

/* Record commands that trace `count` rays in device memory. Return true on success.
 *
 * rays: device address, a multiple of 16. Intersect: array of RTCRayHit, in which geomID and instID are
 *       RTC_INVALID_GEOMETRY_ID. Hits are written; rays that miss are unchanged. Occluded: array of RTCRay. tfar
 *       becomes -inf if the ray hits anything.
 *
 * The caller records the barriers before and after: the commands read and write the rays in
 * VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT. They bind a compute pipeline and set push constants. The scene and the rays
 * must exist until the commands have been executed. `count` may be 0.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and for an address that is 0 or not a multiple of 16. */
RTC_API bool rtcRecordVulkanIntersect(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                      size_t count);
RTC_API bool rtcRecordVulkanOccluded(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                     size_t count);

/* Record commands that sort the indices of rays by origin and direction, and that trace in this order. Rays stay
 * where they are. Incoherent rays are faster if neighbors in the buffer have similar origins and directions. Sorting
 * pays off for rays of several bounces, not for camera rays.
 *
 * rtcGetVulkanRayOrderBytes returns the size of the memory for the order. rtcRecordVulkanRayOrder records the sort and
 * a barrier to compute shaders. The other functions record the trace of the same rays, as rtcRecordVulkanIntersect and
 * rtcRecordVulkanOccluded do.
 *
 * rays:   device address, a multiple of 16. rtcRecordVulkanRayOrder accepts any rays that begin like an RTCRay.
 * stride: bytes from one ray to the next, a multiple of 4, at least 28. stride*count is at most 2^34.
 * count:  of rays, at most 2^27.
 * order:  device address, a multiple of 16, of rtcGetVulkanRayOrderBytes(count) bytes. The functions that trace accept
 *         0, which traces without an order.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, an invalid address, an invalid stride, and a count above 2^27 or above
 * the device's limit; RTC_ERROR_INVALID_OPERATION if workgroups of the device have fewer than 256 threads.
 * rtcGetVulkanRayOrderBytes has no device: rtcGetDeviceError(NULL) returns its error. */
RTC_API size_t rtcGetVulkanRayOrderBytes(size_t count);
RTC_API bool rtcRecordVulkanRayOrder(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                     size_t stride, size_t count, VkDeviceAddress order);
RTC_API bool rtcRecordVulkanIntersectInOrder(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                             size_t count, VkDeviceAddress order);
RTC_API bool rtcRecordVulkanOccludedInOrder(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                            size_t count, VkDeviceAddress order);

/* Enables sorting of the rays of later calls of the rtcStart functions. Disabled by default.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API void rtcSetVulkanSceneRaySorting(RTCVulkanScene scene, bool enabled);

typedef struct RTCVulkanTraceTy* RTCVulkanTrace;

/* Durations of a trace. All are 0 if the device has no clock. */
struct RTCVulkanTraceTimes {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCVulkanTraceTimes); /* see rtcore_compression.h */
  double traceSeconds RTC_ZERO;                                   /* tracing on the device, without copies */
  double copySeconds RTC_ZERO;                                    /* copies of rays and hits on the device */
  double sortSeconds RTC_ZERO;                                    /* sorting of rays, see rtcSetVulkanSceneRaySorting */
};

/* Start tracing an array of `count` rays in host memory, and return before they are traced.
 *
 * rays: read during the call. Members as for rtcRecordVulkanIntersect and rtcRecordVulkanOccluded. May be NULL if
 *       `count` is 0.
 *
 * Return the trace, or NULL on failure. The trace retains the scene. Each trace must be ended by rtcFinishVulkanTrace.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. If rays are sorted, the errors of rtcRecordVulkanRayOrder for the count
 * and the device. RTC_ERROR_OUT_OF_MEMORY if the rays do not fit into the device's memory. */
RTC_API RTCVulkanTrace rtcStartVulkanIntersect(RTCVulkanScene scene, const struct RTCRayHit* rays, size_t count);
RTC_API RTCVulkanTrace rtcStartVulkanOccluded(RTCVulkanScene scene, const struct RTCRay* rays, size_t count);

/* Returns true if a trace has ended, also if it failed, so that rtcFinishVulkanTrace does not wait. Does not wait
 * itself.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API bool rtcIsVulkanTraceDone(RTCVulkanTrace trace);

/* Waits for a trace, writes its rays and releases it, also on failure.
 *
 * rays:  array of the type and length that the trace was started with, or NULL.
 * times: NULL, or written; structSize is read.
 *
 * Returns false if the trace failed, for example because the device was lost, or for a wrong structSize. The rays are
 * unchanged then.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a wrong structSize. RTC_ERROR_UNKNOWN if the device was lost. */
RTC_API bool rtcFinishVulkanTrace(RTCVulkanTrace trace, void* rays, struct RTCVulkanTraceTimes* times);

RTC_NAMESPACE_END
