// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures lengths in pixels, for dicing_samples.h: at their distance from a camera, but as if seen from the front.
 * Uses doubles, because squares of lengths such as 1e20 and 1e-20 overflow or underflow in floats. */

#include "../embree/scene.h"
#include "../base/codec_names.h"
#include "../../cvert/portable/world.h"
#include "dicing_camera.h"

namespace embree {
using cbvh::Double3; // Embree's vectors compute in floats, whatever their element type is

inline Double3 normalized(const Double3& v) { return (1.0 / std::sqrt(dot(v, v))) * v; }

class DicingView {
public:
  /*! camera: checked by validate() in operations/dicing.cpp. Not used afterwards. */
  explicit DicingView(const DicingCamera& camera)
    : eye{camera.position[0], camera.position[1], camera.position[2]},
      orthographic(camera.orthographic),
      quadSize(double(camera.pixelSize) * camera.quadSize),
      outsideFactor(camera.outsideFactor),
      hasPicture(camera.width > 0.0 && camera.height > 0.0) {
    for (int i = 0; i < 12; i++) transform[i] = camera.transform ? camera.transform[i] : i % 4 == 0 ? 1.0 : 0.0;
    if (!hasPicture) return;
    forward = normalized(Double3{camera.direction[0], camera.direction[1], camera.direction[2]});
    const Double3 right = normalized(cross(forward, Double3{camera.up[0], camera.up[1], camera.up[2]}));
    const Double3 down = cross(forward, right);
    const double halfWidth = 0.5 * camera.width * camera.pixelSize, halfHeight = 0.5 * camera.height * camera.pixelSize;
    size = max(halfWidth, halfHeight);
    if (orthographic) {
      const Double3 axes[4] = {right, -1.0 * right, down, -1.0 * down};
      for (int i = 0; i < 4; i++) {
        normals[i] = axes[i];
        offsets[i] = i < 2 ? halfWidth : halfHeight;
      }
      return;
    }
    const Double3 axes[4] = {right - halfWidth * forward, -1.0 * right - halfWidth * forward,
                             down - halfHeight * forward, -1.0 * down - halfHeight * forward};
    for (int i = 0; i < 4; i++) {
      normals[i] = normalized(axes[i]);
      offsets[i] = 0.0;
    }
  }

  Double3 toWorld(const Double3& p) const {
    const double* m = transform;
    return Double3{m[0] * p.x + m[3] * p.y + m[6] * p.z + m[9], m[1] * p.x + m[4] * p.y + m[7] * p.z + m[10],
                   m[2] * p.x + m[5] * p.y + m[8] * p.z + m[11]};
  }

  /*! Returns the number of quads of the requested size per unit of length, on a cell with these corners; infinite at
   *  the eye. Measures the distance to the nearest point on the cell's borders and diagonals, and the growth outside
   *  of the picture at the nearest point of a ball around the cell. */
  double quadsPerUnit(const Double3 corners[4]) const {
    const Double3 center = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    double distance = 1.0;
    if (!orthographic) {
      double d2 = inf;
      for (int i = 0; i < 4; i++)
        for (int j = i + 1; j < 4; j++) d2 = min(d2, squaredDistance(corners[i], corners[j]));
      distance = std::sqrt(d2);
    }
    const double size = distance * quadSize * growth(corners, center);
    return size > 0.0 ? 1.0 / size : double(inf);
  }

private:
  /*! Squared distance of the eye from the segment from a to b. */
  double squaredDistance(const Double3& a, const Double3& b) const {
    const Double3 d = b - a, e = eye - a;
    const double length2 = dot(d, d), t = length2 > 0.0 ? clamp(dot(d, e) / length2, 0.0, 1.0) : 0.0;
    return sqr_length(e - t * d);
  }

  /*! Factor of quad sizes outside of the picture. Grows with the distance from the picture, continuously, so that
   *  adjacent faces get similar rates. Reaches outsideFactor 60 degrees off the picture's border (1.15 = 1/sin(60
   *  degrees)), or 1.7 times the longer side off an orthographic picture. */
  double growth(const Double3 corners[4], const Double3& center) const {
    if (!hasPicture) return 1.0;
    double radius = 0.0, outside = 0.0;
    for (int i = 0; i < 4; i++) radius = max(radius, sqr_length(corners[i] - center));
    radius = std::sqrt(radius);
    for (int i = 0; i < 4; i++) outside = max(outside, dot(normals[i], center - eye) - offsets[i] - radius);
    // behind the camera, the distance from the borders' planes decreases again
    if (!orthographic) outside += max(0.0, dot(forward, eye - center) - radius);
    const double scale = orthographic ? 4.0 * size : std::sqrt(sqr_length(center - eye));
    return outside > 0.0 ? 1.0 + (outsideFactor - 1.0) * min(1.0, 1.15 * outside / scale) : 1.0;
  }

  static double sqr_length(const Double3& v) { return dot(v, v); }

  Double3 eye;
  bool orthographic;
  double quadSize, outsideFactor; //!< quadSize: requested size of a quad at distance 1
  bool hasPicture;
  double transform[12];
  Double3 forward;    //!< unit vector
  double size = 0.0;  //!< half of the picture's longer side, in world units at distance 1
  Double3 normals[4]; //!< normals of the picture's borders, outwards
  double offsets[4];  //!< distances of the borders from the eye along the normals; 0 in perspective
};
} // namespace embree
