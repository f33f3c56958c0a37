// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Names of surfaces. A geometry may be in several scenes, in each under another ID, and its blocks are the same in all: so they
 * hold a number that is the process's, and each scene has a table of its own that takes it to the geometry's ID there. Surfaces that
 * move have a bit more in theirs, so that it is no ID: beside them Embree may trace surfaces that do not move, whose grids have IDs. */

#include "codec.h"
#include "../../cvert/format/limits.h"
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace embree
{
  namespace cbvh
  {
    /*! A number that no other surface has while this object exists. */
    class SurfaceNumber
    {
    public:
      /*! Takes the lowest number that is free, or `fileNumber`, a number that the blocks of a file have, unless another
       *  surface has that one. Thread-safe. */
      explicit SurfaceNumber (uint32_t fileNumber = none);
      ~SurfaceNumber ();
      SurfaceNumber (const SurfaceNumber&) = delete;
      SurfaceNumber& operator= (const SurfaceNumber&) = delete;
      operator uint32_t () const { return value; }

    private:
      static const uint32_t none = ~0u;
      uint32_t value;
    };

    /*! IDs of the geometries of a scene by the numbers of their surfaces; looked up for each hit. */
    class SurfaceIDs
    {
    public:
      /*! numbers and IDs */
      void set (const std::vector<std::pair<uint32_t,uint32_t>>& surfaces)
      {
        size_t size = 1;
        while (size < 2*surfaces.size()) size *= 2;
        mask = uint32_t(size-1);
        slots.assign(size,Slot{ none,none });
        for (const auto& surface : surfaces)
        {
          uint32_t at = surface.first & mask;
          while (slots[at].number != none) at = (at+1) & mask;
          slots[at] = Slot{ surface.first,surface.second };
        }
      }

      /*! of a surface of the scene; a number that is not in the table is an ID */
      uint32_t operator[] (uint32_t number) const
      {
        if (slots.empty()) return number;
        uint32_t at = number & mask;
        while (slots[at].number != number) {
          if (slots[at].number == none) return number;
          at = (at+1) & mask;
        }
        return slots[at].id;
      }

      void clear () { slots.clear(); }

    private:
      static const uint32_t none = 0xFFFFFFFFu;
      struct Slot { uint32_t number, id; };

      std::vector<Slot> slots; //!< by the number's low bits, or the next that was free
      uint32_t mask = 0;
    };
  }
}
