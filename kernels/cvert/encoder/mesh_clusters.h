// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides triangles into clusters of up to 256, and these into groups, recursively at an axis' median, such that all
 * but the last are full. Compact groups share few vertices and have small boxes. Large parts are divided across their
 * longest axis, smaller ones across the axis that minimizes the sum of both areas, in bounds of 16 bits. */

#include "../format/mesh_block.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace cvert { inline namespace CVERT_ISA
{
  struct MeshCenter
  {
    float at[3];    //!< center of the triangle's bounds, finite
    uint32_t index; //!< chosen by the caller
  };

  class MeshClusters
  {
  public:
    /*! groupTriangles: of a full group, 1 to maxGroupTriangles */
    explicit MeshClusters (uint32_t groupTriangles)
      : groupTriangles(groupTriangles), clusterTriangles(std::min(groupTriangles*maxMeshGroups,maxMeshTriangles)),
        part(new Part) {}

    /*! Reorders triangles and calls onCluster(triangles,count) for each cluster, in order. Its groups are
     *  groupTriangles consecutive triangles. boundsOf(index,lower,upper) bounds a triangle. */
    template<typename BoundsOf, typename OnCluster>
    void cut (MeshCenter* triangles, size_t count, const BoundsOf& boundsOf, const OnCluster& onCluster)
    {
      if (count > maxPart())
      {
        const size_t half = halve(triangles,count);
        cut(triangles,half,boundsOf,onCluster);
        cut(triangles+half,count-half,boundsOf,onCluster);
        return;
      }
      load(triangles,count,boundsOf);
      split(part->items,count,clusterTriangles,
        [&](Item* cluster, size_t size) { split(cluster,size,groupTriangles,[](Item*, size_t) {}); });
      for (size_t i=0; i<count; i++) triangles[i] = part->centers[part->items[i].at[6]];
      for (size_t i=0; i<count; i+=clusterTriangles)
        onCluster(triangles+i,uint32_t(std::min(count-i,size_t(clusterTriangles))));
    }

    /*! cut() applies halve() to larger parts. Threads can cut the halves concurrently. */
    size_t maxPart () const { return partTriangles/clusterTriangles*clusterTriangles; }

    /*! Reorders more than maxPart() triangles into two parts. Returns the size of the first, whose clusters are
     *  full. */
    size_t halve (MeshCenter* triangles, size_t count) const
    {
      const size_t half = halfOf(count,clusterTriangles);
      cutAcrossLongest(triangles,count,half);
      return half;
    }

    const uint32_t groupTriangles, clusterTriangles;

  private:
    static const size_t partTriangles = 4096, sampleTriangles = 64;
    static const uint32_t bins = 32;

    /*! 0 to 2: lower bounds; 3 to 5: 65535 minus upper bounds, so that a minimum extends both; 6: index in the part; 7:
     *  bin. */
    struct Item
    {
      uint16_t at[8];

      uint32_t center (int k) const { return uint32_t(at[k]) + 65535u - at[3+k]; } //!< a center has 17 bits
      double size (int k) const { return 65535.0 - at[3+k] - at[k]; }
      double area () const { return size(0)*size(1) + size(1)*size(2) + size(2)*size(0); }
    };

    typedef uint16_t Lanes __attribute__((vector_size(16)));

    struct Bounds
    {
      Lanes lanes = Lanes{} + uint16_t(65535);

      /*! isPresent: 0xFFFF, or 0 for no change */
      void extend (Lanes item, uint16_t isPresent) {
        item |= uint16_t(~isPresent);
        lanes = item < lanes ? item : lanes;
      }
      double area () const {
        Item item;
        std::memcpy(item.at,&lanes,sizeof(lanes));
        return item.area();
      }
    };

    struct Part
    {
      MeshCenter centers[partTriangles];
      Item items[partTriangles];
    };

    static size_t halfOf (size_t count, size_t unit) { return (count+unit-1)/unit/2*unit; }

    /*! Moves the first `half` items on an axis to the front. counts: by bin. less: consistent with the bins. */
    template<typename T, typename Count, typename BinOf, typename Less>
    static void select (T* items, size_t count, size_t half, const Count* counts, const BinOf& binOf, const Less& less)
    {
      uint32_t bin = 0;
      size_t before = 0;
      while (before+counts[bin] <= half) before += counts[bin++];
      // without branches, which would be mispredicted
      T* to = items;
      for (T* i=items; i<items+count; i++) { const T item = *i; *i = *to; *to = item; to += binOf(item) < bin; }
      if (before == half) return;
      T* const first = to;
      for (T* i=first; i<items+count; i++)
        if (binOf(*i) == bin) std::swap(*i,*to++); // such items are rare
      std::nth_element(first,items+half,to,less);
    }

    static void cutAcrossLongest (MeshCenter* triangles, size_t count, size_t half)
    {
      float lower[3] = { INFINITY,INFINITY,INFINITY }, upper[3] = { -INFINITY,-INFINITY,-INFINITY };
      for (size_t i=0; i<count; i+=count/1024)
        for (int k=0; k<3; k++) {
          lower[k] = std::min(lower[k],triangles[i].at[k]); upper[k] = std::max(upper[k],triangles[i].at[k]);
        }
      int axis = 0;
      for (int k=1; k<3; k++)
        if (upper[k]-lower[k] > upper[axis]-lower[axis]) axis = k;
      const uint32_t bins = 1024;
      const float from = lower[axis], size = upper[axis]-from, scale = size > 0 ? float(bins-1)/size : 0.0f;
      const auto binOf = [=](const MeshCenter& c) {
        const float x = (c.at[axis]-from)*scale;
        return x < float(bins-1) ? x > 0 ? uint32_t(x) : 0u : bins-1; // NaN counts as the last bin
      };
      uint32_t counts[bins] = {};
      for (size_t i=0; i<count; i++) counts[binOf(triangles[i])]++;
      select(triangles,count,half,counts,binOf,
        [=](const MeshCenter& a, const MeshCenter& b) { return a.at[axis] < b.at[axis]; });
    }

    template<typename BoundsOf>
    void load (const MeshCenter* triangles, size_t count, const BoundsOf& boundsOf)
    {
      float lower[3] = { INFINITY,INFINITY,INFINITY }, upper[3] = { -INFINITY,-INFINITY,-INFINITY };
      for (size_t i=0; i<count; i++)
        for (int k=0; k<3; k++) {
          lower[k] = std::min(lower[k],triangles[i].at[k]); upper[k] = std::max(upper[k],triangles[i].at[k]);
        }
      const float size = std::max(std::max(upper[0]-lower[0],upper[1]-lower[1]),std::max(upper[2]-lower[2],1e-30f)),
        scale = 49152.0f/size;
      for (size_t i=0; i<count; i++)
      {
        part->centers[i] = triangles[i];
        float l[3], u[3];
        boundsOf(triangles[i].index,l,u);
        Item& item = part->items[i];
        for (int k=0; k<3; k++) { // triangles extend beyond their centers' bounds
          item.at[k] = toGrid((l[k]-lower[k])*scale);
          item.at[3+k] = uint16_t(65535-toGrid((u[k]-lower[k])*scale));
        }
        item.at[6] = uint16_t(i);
        item.at[7] = 0;
      }
    }

    static uint16_t toGrid (float x) { return uint16_t(std::min(std::max(x+8192.0f,0.0f),65535.0f)); }

    /*! Splits into parts of at most `unit` items. */
    template<typename OnPart>
    static void split (Item* items, size_t count, size_t unit, const OnPart& onPart)
    {
      if (count <= unit) { if (count > 0) onPart(items,count); return; }
      const size_t half = halfOf(count,unit);
      uint32_t lower, shift;
      const int k = axisOf(items,count,half,lower,shift);
      uint16_t counts[bins] = {};
      for (size_t i=0; i<count; i++) {
        // centers may be outside of a sample's range
        const uint32_t c = items[i].center(k), bin = std::min((std::max(c,lower)-lower) >> shift,bins-1);
        items[i].at[7] = uint16_t(bin);
        counts[bin]++;
      }
      select(items,count,half,counts,[](const Item& item) { return uint32_t(item.at[7]); },
        [k](const Item& a, const Item& b) { return a.center(k) < b.center(k); });
      split(items,half,unit,onPart);
      split(items+half,count-half,unit,onPart);
    }

    /*! Axis on which to split off `half` items, and bins of centers, from a sample. */
    static int axisOf (const Item* items, size_t count, size_t half, uint32_t& lower, uint32_t& shift)
    {
      const size_t step = (count+sampleTriangles-1)/sampleTriangles;
      uint32_t least[3] = { ~0u,~0u,~0u }, most[3] = { 0,0,0 };
      for (size_t i=0; i<count; i+=step)
        for (int k=0; k<3; k++) {
          const uint32_t c = items[i].center(k);
          least[k] = std::min(least[k],c);
          most[k] = std::max(most[k],c);
        }
      // approximate medians
      uint16_t counts[3][bins] = {};
      uint32_t shifts[3] = { 0,0,0 }, median[3];
      for (int k=0; k<3; k++)
        while ((most[k]-least[k]) >> shifts[k] >= bins) shifts[k]++;
      for (size_t i=0; i<count; i+=step)
        for (int k=0; k<3; k++) counts[k][(items[i].center(k)-least[k]) >> shifts[k]]++;
      const size_t before = half/step;
      for (int k=0; k<3; k++)
      {
        size_t sum = 0;
        uint32_t bin = 0;
        while (bin+1 < bins && sum+counts[k][bin] <= before) sum += counts[k][bin++];
        const bool isNearer = before-sum > counts[k][bin]/2u; // nearer to the bin's end than to its start
        median[k] = least[k] + ((bin+isNearer) << shifts[k]);
      }
      Bounds halves[3][2];
      for (size_t i=0; i<count; i+=step)
      {
        Lanes lanes;
        std::memcpy(&lanes,items[i].at,sizeof(lanes));
        const uint16_t isUpper[3] = { uint16_t(-int(items[i].center(0) >= median[0])),
          uint16_t(-int(items[i].center(1) >= median[1])),uint16_t(-int(items[i].center(2) >= median[2])) };
        halves[0][0].extend(lanes,uint16_t(~isUpper[0])); halves[0][1].extend(lanes,isUpper[0]);
        halves[1][0].extend(lanes,uint16_t(~isUpper[1])); halves[1][1].extend(lanes,isUpper[1]);
        halves[2][0].extend(lanes,uint16_t(~isUpper[2])); halves[2][1].extend(lanes,isUpper[2]);
      }
      int axis = 0;
      double best = INFINITY;
      for (int k=0; k<3; k++) {
        if (least[k] == most[k]) continue;
        const double area = halves[k][0].area() + halves[k][1].area();
        if (area < best) { best = area; axis = k; }
      }
      lower = least[axis];
      shift = shifts[axis];
      return axis;
    }

    const std::unique_ptr<Part> part;
  };
}}
