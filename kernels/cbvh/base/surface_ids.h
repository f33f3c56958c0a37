// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surface numbers. A geometry may be in several scenes with different IDs, while its blocks are the same in all of
 * them. Blocks therefore store a number that is unique in the process, and each scene has a table that maps numbers to
 * the IDs of its geometries. Numbers of moving surfaces have an additional bit, so that they differ from IDs: Embree
 * may trace static surfaces in the same scene, whose grids store IDs. */

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
    /*! A number that no other surface has during the lifetime of this object. */
    class SurfaceNumber
    {
    public:
      /*! Allocates `fileNumber`, the number that blocks of a file have, if no other surface has it, else the lowest
       *  free number. Thread-safe. */
      explicit SurfaceNumber (uint32_t fileNumber = none);
      ~SurfaceNumber ();
      SurfaceNumber (const SurfaceNumber&) = delete;
      SurfaceNumber& operator= (const SurfaceNumber&) = delete;
      operator uint32_t () const { return value; }

    private:
      static const uint32_t none = ~0u;
      uint32_t value;
    };

    /*! IDs of the geometries of a scene by surface number. Each hit looks up an ID. */
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

      /*! Returns the ID of a surface of the scene. Numbers that are not in the table are IDs. */
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

      std::vector<Slot> slots; //!< hash table: indexed by the low bits of the number, with linear probing
      uint32_t mask = 0;
    };
  }
}
