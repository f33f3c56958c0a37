// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The surface of a geometry: its blocks, which are built when it changed, and what changed since the geometry was committed last. */

#include <memory>

namespace embree
{
  struct SurfaceBlocks;
  struct QuadRegions;
  namespace cbvh { class SurfaceNumber; }

  struct SurfaceState
  {
    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< null until a scene or a commit needs it
    std::shared_ptr<const SurfaceBlocks> blocks;       //!< null until they are built, and when the surface was changed
    std::shared_ptr<const QuadRegions> regions;        //!< of quads and triangles, from the commit until blocks are built
    bool inputReleased = false;                        //!< RTC_COMPRESSION_FLAG_RELEASE_INPUT, or the key release_input
    const char* whyNot = nullptr;                      //!< of a geometry that asks for compression and is not compressed

    /*! Who sees the surface was changed. counted: how often Embree counts that as a modification of the geometry */
    void changeVisibility (unsigned counted) { visibilityChanged = true; visibilityChanges += counted; }

    /*! The surface was changed, or what a displacement function gets; also where Embree does not count it. */
    void change () { changed = true; }

    /*! Whether, since the last commit, something was changed, and nothing but who sees the surface. Where nothing was that the library
     *  sees, a displacement may answer otherwise; but not without the input. */
    bool isKept (unsigned modCounter) const {
      return (visibilityChanged || (inputReleased && blocks)) && !changed && modCounter - committedModCounter == visibilityChanges;
    }

    void commit (unsigned modCounter)
    {
      visibilityChanged = changed = false;
      visibilityChanges = 0;
      committedModCounter = modCounter;
    }

  private:
    bool visibilityChanged = false, changed = false;
    unsigned visibilityChanges = 0, committedModCounter = 0;
  };
}
