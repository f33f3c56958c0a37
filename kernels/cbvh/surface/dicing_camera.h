// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>

namespace embree {
/*! CbvhDicingArguments without structSize, and independent of Embree: a camera, and the requested size of quads in its
 *  picture. In world space unless stated otherwise. */
struct DicingCamera {
  float position[3] = {0, 0, 0};
  float direction[3] = {0, 0, 1}; //!< towards the picture's center; any length but 0
  float up[3] = {0, 1, 0};        //!< up in the picture; any length but 0, not parallel to direction
  bool orthographic = false;      //!< sizes in the picture are independent of the distance
  /*! Width of a pixel at distance 1, or at any distance if orthographic. Greater than 0. */
  float pixelSize = 0;
  /*! Size of the picture in pixels. 0: all points count as inside of the picture; direction and up are ignored. */
  float width = 0, height = 0;
  /*! Object to world space: 12 floats, column by column. Null: identity. */
  const float* transform = nullptr;
  float quadSize = 1; //!< approximate edge length in pixels; greater than 0
  /*! Quads outside of the picture and behind the camera are larger by up to this factor. At least 1. */
  float outsideFactor = 8;
  float maxRate = 4096;            //!< quads along an edge, 1 to 4096
  const float* maxRates = nullptr; //!< one per index of the cage, at least 1; null: maxRate only
};

/*! args: struct of a public interface with members of the same names. The result keeps its pointers. */
template<typename Arguments>
DicingCamera dicingCamera(const Arguments& args) {
  DicingCamera camera;
  std::copy_n(args.position, 3, camera.position);
  std::copy_n(args.direction, 3, camera.direction);
  std::copy_n(args.up, 3, camera.up);
  camera.orthographic = args.orthographic != 0;
  camera.pixelSize = args.pixelSize;
  camera.width = args.width;
  camera.height = args.height;
  camera.transform = args.transform;
  camera.quadSize = args.quadSize;
  camera.outsideFactor = args.outsideFactor;
  camera.maxRate = args.maxRate;
  camera.maxRates = args.maxRates;
  return camera;
}
} // namespace embree
