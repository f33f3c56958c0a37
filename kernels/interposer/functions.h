// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* All functions of Embree 4.3 and 4.4, and why this library overrides them or need not. A test compares these tables
 * with Embree's headers and with the functions that this library exports, so that a function of a later Embree is
 * noticed. Independent of Embree's headers. */

#include <initializer_list>

namespace interposer {

struct Functions {
  const char* reason;
  std::initializer_list<const char*> names;
};

inline const std::initializer_list<Functions> overriddenFunctions = {
    {"trace rays, and call functions of the application with user data",
     {"rtcIntersect1", "rtcIntersect4", "rtcIntersect8", "rtcIntersect16", "rtcOccluded1", "rtcOccluded4",
      "rtcOccluded8", "rtcOccluded16", "rtcTraversableIntersect1", "rtcTraversableIntersect4",
      "rtcTraversableIntersect8", "rtcTraversableIntersect16", "rtcTraversableOccluded1", "rtcTraversableOccluded4",
      "rtcTraversableOccluded8", "rtcTraversableOccluded16"}},
    {"call a function of the application with a geomID and a primID",
     {"rtcPointQuery", "rtcPointQuery4", "rtcPointQuery8", "rtcPointQuery16", "rtcTraversablePointQuery",
      "rtcTraversablePointQuery4", "rtcTraversablePointQuery8", "rtcTraversablePointQuery16", "rtcCollide"}},
    {"return a geometry, or its user data, by geomID",
     {"rtcGetGeometry", "rtcGetGeometryThreadSafe", "rtcGetGeometryUserDataFromScene",
      "rtcGetGeometryUserDataFromTraversable"}},
    {"create objects, and end their lifetime",
     {"rtcNewDevice", "rtcRetainDevice", "rtcReleaseDevice", "rtcGetSceneDevice", "rtcNewScene", "rtcRetainScene",
      "rtcReleaseScene", "rtcNewGeometry", "rtcRetainGeometry", "rtcReleaseGeometry", "rtcNewBuffer",
      "rtcNewBufferHostDevice", "rtcNewSharedBuffer", "rtcNewSharedBufferHostDevice", "rtcRetainBuffer",
      "rtcReleaseBuffer"}},
    {"determine what a scene contains",
     {"rtcAttachGeometry", "rtcAttachGeometryByID", "rtcDetachGeometry", "rtcCommitScene", "rtcJoinCommitScene",
      "rtcSetSceneProgressMonitorFunction", "rtcEnableGeometry", "rtcDisableGeometry", "rtcSetGeometryInstancedScene",
      "rtcSetGeometryInstancedScenes"}},
    {"set the input of a build",
     {"rtcSetGeometryBuffer", "rtcSetSharedGeometryBuffer", "rtcSetSharedGeometryBufferHostDevice",
      "rtcSetNewGeometryBuffer", "rtcSetNewGeometryBufferHostDevice", "rtcUpdateGeometryBuffer",
      "rtcSetGeometryTimeStepCount", "rtcSetGeometryTimeRange", "rtcSetGeometryTessellationRate",
      "rtcSetGeometrySubdivisionMode", "rtcSetGeometryDisplacementFunction", "rtcSetGeometryBuildQuality",
      "rtcCommitGeometry"}},
    {"set what rays find",
     {"rtcSetGeometryMask", "rtcSetGeometryUserData", "rtcSetGeometryIntersectFilterFunction",
      "rtcSetGeometryOccludedFilterFunction", "rtcSetGeometryEnableFilterFunctionFromArguments",
      "rtcSetGeometryPointQueryFunction"}},
};

inline const std::initializer_list<Functions> otherFunctions = {
    {"do not depend on geometry",
     {"rtcGetDeviceProperty", "rtcSetDeviceProperty", "rtcGetErrorString", "rtcGetDeviceError",
      "rtcGetDeviceLastErrorMessage", "rtcSetDeviceErrorFunction", "rtcSetDeviceMemoryMonitorFunction", "rtcNewBVH",
      "rtcBuildBVH", "rtcThreadLocalAlloc", "rtcRetainBVH", "rtcReleaseBVH"}},
    {"apply to the application's own geometry, which Embree keeps with its buffers and topology",
     {"rtcGetBufferData", "rtcGetBufferDataDevice", "rtcCommitBuffer", "rtcGetGeometryBufferData",
      "rtcGetGeometryBufferDataDevice", "rtcGetGeometryUserData", "rtcSetGeometryVertexAttributeCount",
      "rtcSetGeometryTopologyCount", "rtcSetGeometryVertexAttributeTopology", "rtcGetGeometryFirstHalfEdge",
      "rtcGetGeometryFace", "rtcGetGeometryNextHalfEdge", "rtcGetGeometryPreviousHalfEdge",
      "rtcGetGeometryOppositeHalfEdge", "rtcInterpolate", "rtcInterpolateN"}},
    {"apply to curves, points, user geometry and instances, which are never replaced",
     {"rtcSetGeometryMaxRadiusScale", "rtcSetGeometryUserPrimitiveCount", "rtcSetGeometryBoundsFunction",
      "rtcSetGeometryIntersectFunction", "rtcSetGeometryOccludedFunction", "rtcSetGeometryTransform",
      "rtcSetGeometryTransformQuaternion", "rtcGetGeometryTransform", "rtcGetGeometryTransformEx",
      "rtcGetGeometryTransformFromScene", "rtcGetGeometryTransformFromTraversable"}},
    {"apply to all that a scene contains",
     {"rtcSetSceneBuildQuality", "rtcSetSceneFlags", "rtcGetSceneFlags", "rtcGetSceneBounds", "rtcGetSceneLinearBounds",
      "rtcGetSceneTraversable"}},
    {"continue the query that called the application's function, with the arguments of that query",
     {"rtcForwardIntersect1",
      "rtcForwardIntersect1Ex",
      "rtcForwardIntersect4",
      "rtcForwardIntersect4Ex",
      "rtcForwardIntersect8",
      "rtcForwardIntersect8Ex",
      "rtcForwardIntersect16",
      "rtcForwardIntersect16Ex",
      "rtcForwardOccluded1",
      "rtcForwardOccluded1Ex",
      "rtcForwardOccluded4",
      "rtcForwardOccluded4Ex",
      "rtcForwardOccluded8",
      "rtcForwardOccluded8Ex",
      "rtcForwardOccluded16",
      "rtcForwardOccluded16Ex",
      "rtcTraversableForwardIntersect1",
      "rtcTraversableForwardIntersect1Ex",
      "rtcTraversableForwardIntersect4",
      "rtcTraversableForwardIntersect4Ex",
      "rtcTraversableForwardIntersect8",
      "rtcTraversableForwardIntersect8Ex",
      "rtcTraversableForwardIntersect16",
      "rtcTraversableForwardIntersect16Ex",
      "rtcTraversableForwardOccluded1",
      "rtcTraversableForwardOccluded1Ex",
      "rtcTraversableForwardOccluded4",
      "rtcTraversableForwardOccluded4Ex",
      "rtcTraversableForwardOccluded8",
      "rtcTraversableForwardOccluded8Ex",
      "rtcTraversableForwardOccluded16",
      "rtcTraversableForwardOccluded16Ex"}},
    {"call filters of the application's user geometry, with arguments of the application",
     {"rtcInvokeIntersectFilterFromGeometry", "rtcInvokeOccludedFilterFromGeometry"}},
    {"concern devices of SYCL, whose geometry is never replaced",
     {"rtcNewSYCLDevice", "rtcIsSYCLDeviceSupported", "rtcSYCLDeviceSelector", "rtcSetDeviceSYCLDevice",
      "rtcCommitSceneWithQueue", "rtcCommitBufferWithQueue", "rtcGetSYCLDeviceFunctionPointer"}},
    {"are inlined into the application, and call functions of these tables",
     {"rtcInterpolate0", "rtcInterpolate1", "rtcInterpolate2", "rtcInitIntersectArguments", "rtcInitOccludedArguments",
      "rtcInitPointQueryContext", "rtcInitRayQueryContext", "rtcDefaultBuildArguments",
      "rtcInitQuaternionDecomposition", "rtcQuaternionDecompositionSetQuaternion", "rtcQuaternionDecompositionSetScale",
      "rtcQuaternionDecompositionSetShift", "rtcQuaternionDecompositionSetSkew",
      "rtcQuaternionDecompositionSetTranslation", "rtcCopyHitToHitN", "rtcGetHitFromHitN", "rtcGetRayFromRayN",
      "rtcGetRayHitFromRayHitN"}},
    {"the same, in ISPC",
     {"rtcInterpolateV0", "rtcInterpolateV1", "rtcInterpolateV2", "rtcIntersectV", "rtcOccludedV", "rtcPointQueryV",
      "rtcForwardIntersectV", "rtcForwardIntersectVEx", "rtcForwardOccludedV", "rtcForwardOccludedVEx",
      "rtcTraversableIntersectV", "rtcTraversableOccludedV", "rtcTraversablePointQueryV",
      "rtcTraversableForwardIntersectV", "rtcTraversableForwardIntersectVEx", "rtcTraversableForwardOccludedV",
      "rtcTraversableForwardOccludedVEx"}},
};

} // namespace interposer
