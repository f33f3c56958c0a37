// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>

namespace embree
{
  /*! A camera, and how large quads may be in its picture. Plain data, which includes nothing of Embree. World space
   *  unless stated otherwise. */
  struct DicingCamera
  {
    float position[3] = { 0,0,0 };
    float direction[3] = { 0,0,1 };    //!< into the middle of the picture, of any length
    float up[3] = { 0,1,0 };           //!< of the picture, of any length, not along direction
    bool orthographic = false;         //!< its position does not matter
    /*! Width of a pixel at distance 1; for an orthographic camera at any distance. More than 0 */
    float pixelSize = 0;
    /*! Of the picture in pixels. 0: everything counts as inside of the picture; direction and up do not matter */
    float width = 0, height = 0;
    /*! Geometry to world, 12 floats, column by column; null: the geometry is in world space */
    const float* transform = nullptr;
    float quadSize = 1;                //!< approximate length of quads' edges in pixels. More than 0
    /*! Quads far outside of the picture and behind the camera are that many times as large. At least 1 */
    float outside = 8;
    float maxRate = 4096;              //!< quads along an edge, 1 to 4096
    const float* maxRates = nullptr;   //!< the same for each edge, one per index, at least 1; null: maxRate alone
  };

  /*! Returns the camera that a struct of an interface describes, which has members of the same names. */
  template<typename Arguments>
  DicingCamera dicingCamera (const Arguments& args)
  {
    DicingCamera camera;
    std::copy_n(args.position,3,camera.position);
    std::copy_n(args.direction,3,camera.direction);
    std::copy_n(args.up,3,camera.up);
    camera.orthographic = args.orthographic != 0;
    camera.pixelSize = args.pixelSize;
    camera.width = args.width;
    camera.height = args.height;
    camera.transform = args.transform;
    camera.quadSize = args.quadSize;
    camera.outside = args.outside;
    camera.maxRate = args.maxRate;
    camera.maxRates = args.maxRates;
    return camera;
  }
}
