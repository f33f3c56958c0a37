// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Settings of compression, the same struct for a device and for a geometry. Every
 * field may be left to the next one in the order geometry, device string,
 * environment, default; resolve() closes the chain. */

#include "../../../include/embree3/rtcore_compression.h"
#include <string>

namespace embree
{
  class Token;
  class TokenStream;

  struct CompressionSettings
  {
    RTCCompression compression = RTC_COMPRESSION_INHERIT;
    int frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT;
    float maxError = -1.0f; //!< world units; 0: cVERT is lossless; negative: inherited, or the default
    float maxPixelError = 0.0f, cameraPosition[3] = { 0.0f,0.0f,0.0f }, pixelSize = 0.0f; //!< only a geometry's
    int exactFaces = -1;    //!< 0 or 1, negative to inherit
    bool releasesInput = false; //!< of a geometry if it or its device says so
    bool takesGrids = true, takesQuads = true, takesTriangles = true; //!< only a device's: types that are compressed if they do not ask
    RTCProgressMonitorFunction progress = nullptr; //!< only a geometry's
    void* progressUserPtr = nullptr;

    /*! Takes cbvh_frame_level, cbvh_max_error, cbvh_exact_faces, cbvh_grids, cbvh_quads, cbvh_triangles and
     *  cbvh_release_input out of a device string; false for any other key. Throws rtcore_error naming key and value. */
    bool parse (const Token& key, TokenStream& stream);

    /*! What EMBREE_CBVH=1 and subdiv_accel=cbvh stand for: a fifth of cGRID's memory, smaller and more exact than
     *  cLEAF, and the fastest to build. cVOXEL may be smaller, but its boxes are no surface to shade (README.md). */
    static const RTCCompression bestCompression = RTC_COMPRESSION_VERT;

    /*! Takes EMBREE_CBVH, for example "leaf,frame_level=2". Throws rtcore_error. */
    void parseEnvironment ();

    /*! Takes the device string's subdiv_accel once it is known; "default" says nothing.
     *  Throws rtcore_error for an unknown "cbvh." kind. Where `verbose`, prints what we are, above Embree's banner. */
    void verify (const std::string& subdivAccel, bool verbose);

    /*! what holds for a geometry with these settings on that device: nothing inherits any more */
    CompressionSettings resolve (const CompressionSettings& device) const;

  private:
    void setFrameLevel (const std::string& name, const std::string& value);
    void setMaxError (const std::string& name, const std::string& value);
    void set (const std::string& name, const std::string& key, const std::string& value);
  };
}
