// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surface numbers. A geometry may have different IDs in several scenes, but its blocks are shared. Blocks therefore
 * store a number that is unique in the process, and each scene maps numbers to IDs of its geometries. Numbers of moving
 * surfaces have an additional bit to differ from IDs, because grids of static surfaces that Embree traces in the same
 * scene store IDs. */

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
      /*! Allocates `fileNumber`, the number in blocks of a file, if it is free, otherwise the lowest free number.
       *  Thread-safe. */
      explicit SurfaceNumber (uint32_t fileNumber = none);
      ~SurfaceNumber ();
      SurfaceNumber (const SurfaceNumber&) = delete;
      SurfaceNumber& operator= (const SurfaceNumber&) = delete;
      operator uint32_t () const { return value; }

    private:
      static const uint32_t none = ~0u;
      uint32_t value;
    };

    /*! Geometry IDs of a scene by surface number. Each hit looks up an ID. */
    class SurfaceIDs
    {
    public:
      /*! surfaces: pairs of number and ID. */
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

      /*! Numbers that are not in the table are returned as IDs. */
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

      std::vector<Slot> slots; //!< hash table, indexed by the number's low bits, with linear probing
      uint32_t mask = 0;
    };
  }
}
