// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The surface of a geometry: its blocks, and what changed since the last commit of the geometry. */

#include <memory>

namespace embree
{
  struct SurfaceBlocks;
  struct QuadRegions;
  namespace cbvh { class SurfaceNumber; }

  struct SurfaceState
  {
    std::shared_ptr<const cbvh::SurfaceNumber> number; //!< null until a scene or a commit needs it
    std::shared_ptr<const SurfaceBlocks> blocks;       //!< null until they are built, and after the surface changed
    std::shared_ptr<const QuadRegions> regions;        //!< quads and triangles: from the commit until blocks are built
    bool inputReleased = false;                        //!< RTC_COMPRESSION_FLAG_RELEASE_INPUT, or the key release_input
    const char* rejectionReason = nullptr;             //!< reason why compression was requested but not done

    /*! Records a change of the visibility. counted: number of modifications that Embree counts for it. */
    void changeVisibility (unsigned counted) { visibilityChanged = true; visibilityChanges += counted; }

    /*! Records a change of the surface or of the arguments of its displacement function that Embree may not count. */
    void change () { changed = true; }

    /*! True if blocks remain valid: since the last commit something changed, and only the visibility. If nothing
     *  changed that the library can detect, a displacement function may return other values, so blocks are rebuilt,
     *  unless the input was released. */
    bool isKept (unsigned modCounter) const {
      return (visibilityChanged || (inputReleased && blocks)) && !changed
        && modCounter - committedModCounter == visibilityChanges;
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
