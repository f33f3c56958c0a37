// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a commit compressed, in a line: how else does one know in a closed renderer that it works? */

#include "../base/build_statistics.h"
#include "../base/kinds.h"
#include <iomanip>
#include <locale>
#include <sstream>

namespace embree
{
  namespace isa
  {
    class CommitLine
    {
    public:
      /*! a geometry of a kind, or of GRID where it asks for no compression */
      void addGeometry (bool compresses, cbvh::Kind kind) { geometries[compresses ? uint32_t(kind) : notCompressed]++; }

      std::string text (const RTCCompressionStatistics& sums, const cbvh::BuildStatistics& all) const
      {
        std::ostringstream line;
        line.imbue(std::locale::classic());
        const size_t bytes = sums.topLevelBytes + sums.frameBytes + sums.nodeBytes + sums.leafBytes + sums.gridBytes;
        const size_t quads = sums.numQuads + sums.numGridQuads;
        line << "compression: " << kinds() << ": " << quads << " quads in " << mebibytes(bytes) << " MiB, GRID would take about " << mebibytes(all.bytesInGrid) << " MiB; left to GRID: ";
        const char* between = "";
        auto left = [&](size_t n, const std::string& what) { if (n) { line << between << n << what; between = ", "; } };
        left(geometries[notCompressed],geometries[notCompressed] == 1 ? " surface that asks for no compression" : " surfaces that ask for no compression");
        left(all.highRateQuads," quads for their edge rates");
        left(all.refusedInGrid," quads of blocks without a good frame");
        if (*between == 0) line << "nothing";
        return line.str();
      }

    private:
      static std::string mebibytes (size_t bytes)
      {
        std::ostringstream text;
        text.imbue(std::locale::classic());
        text << std::fixed << std::setprecision(bytes < (size_t(10) << 20) ? 2 : 1) << double(bytes)/(1 << 20);
        return text.str();
      }

      /*! "2 surfaces as cVERT, 1 as cLEAF" */
      std::string kinds () const
      {
        std::string text;
        for (uint32_t k=0; k<cbvh::numKinds; k++) {
          const size_t n = geometries[uint32_t(cbvh::kindDescriptions[k].kind)];
          if (n == 0) continue;
          text += text.empty() ? std::to_string(n) + (n == 1 ? " surface as " : " surfaces as ") : ", " + std::to_string(n) + " as ";
          text += cbvh::kindDescriptions[k].name;
        }
        return text;
      }

      static const uint32_t notCompressed = cbvh::maxKinds;
      size_t geometries[cbvh::maxKinds+1] = {};
    };
  }
}
