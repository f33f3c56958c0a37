// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How large a camera sees what lies somewhere: lengths in pixels, as if they were seen from the front. */

#include "../embree/scene.h"
#include "../../../include/embree3/rtcore_dicing.h"

namespace embree
{
  class DicingView
  {
  public:
    /*! of arguments that were found valid */
    explicit DicingView (const RTCDicingArguments& args)
      : eye(args.position[0],args.position[1],args.position[2]), orthographic(args.orthographic), pixelSize(args.pixelSize*args.quadSize), outside(args.outside),
        hasPicture(args.width > 0.0f && args.height > 0.0f)
    {
      for (int i=0; i<12; i++) transform[i] = args.transform ? args.transform[i] : i % 4 == 0 ? 1.0f : 0.0f;
      if (!hasPicture) return;
      const Vec3f forward = normalize(Vec3f(args.direction[0],args.direction[1],args.direction[2]));
      const Vec3f right = normalize(cross(forward,Vec3f(args.up[0],args.up[1],args.up[2])));
      const Vec3f down = cross(forward,right);
      const float halfWidth = 0.5f*args.width*args.pixelSize, halfHeight = 0.5f*args.height*args.pixelSize;
      size = max(halfWidth,halfHeight);
      if (orthographic) {
        const Vec3f axes[4] = { right,-right,down,-down };
        for (int i=0; i<4; i++) { normals[i] = axes[i]; offsets[i] = i < 2 ? halfWidth : halfHeight; }
        return;
      }
      const Vec3f axes[4] = { right-halfWidth*forward,-right-halfWidth*forward,down-halfHeight*forward,-down-halfHeight*forward };
      for (int i=0; i<4; i++) { normals[i] = normalize(axes[i]); offsets[i] = 0.0f; }
    }

    Vec3f toWorld (const Vec3f& p) const
    {
      const float* m = transform;
      return Vec3f(m[0]*p.x+m[3]*p.y+m[6]*p.z+m[9],m[1]*p.x+m[4]*p.y+m[7]*p.z+m[10],m[2]*p.x+m[5]*p.y+m[8]*p.z+m[11]);
    }

    /*! Quads of the size that is asked for in a unit of length, on a cell with such corners. Of the cell what is nearest counts: its borders, its diagonals, and whether any of
     *  the ball around it is in the picture. */
    float quadsPerUnit (const Vec3f corners[4]) const
    {
      const Vec3f center = 0.25f*(corners[0]+corners[1]+corners[2]+corners[3]);
      float distance = 1.0f;
      if (!orthographic)
      {
        float d2 = inf;
        for (int i=0; i<4; i++) for (int j=i+1; j<4; j++) d2 = min(d2,squaredDistance(corners[i],corners[j]));
        distance = max(std::sqrt(d2),1e-30f);
      }
      return 1.0f/(distance*pixelSize*growth(corners,center));
    }

  private:
    float squaredDistance (const Vec3f& a, const Vec3f& b) const
    {
      const Vec3f d = b-a, e = eye-a;
      const float length2 = dot(d,d), t = length2 > 0.0f ? clamp(dot(d,e)/length2,0.0f,1.0f) : 0.0f;
      return sqr_length(e-t*d);
    }

    /*! By how much quads may be larger than in the picture: more and more outside of it, up to where a line to them is 60 degrees off its border. Without a
     *  step, as faces beside each other are to be alike. */
    float growth (const Vec3f corners[4], const Vec3f& center) const
    {
      if (!hasPicture) return 1.0f;
      float radius = 0.0f, beyond = 0.0f;
      for (int i=0; i<4; i++) radius = max(radius,sqr_length(corners[i]-center));
      radius = std::sqrt(radius);
      for (int i=0; i<4; i++) beyond = max(beyond,dot(normals[i],center-eye)-offsets[i]-radius);
      const float scale = orthographic ? 4.0f*size : std::sqrt(sqr_length(center-eye));
      return beyond > 0.0f ? 1.0f + (outside-1.0f)*min(1.0f,1.15f*beyond/scale) : 1.0f;
    }

    static float sqr_length (const Vec3f& v) { return dot(v,v); }

    Vec3f eye;
    bool orthographic;
    float pixelSize, outside;
    bool hasPicture;
    float transform[12];
    float size = 0.0f;
    Vec3f normals[4];   //!< of the picture's borders, outwards
    float offsets[4];
  };
}
