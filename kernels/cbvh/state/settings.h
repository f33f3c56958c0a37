// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compression settings of a device or a geometry. Each member may be inherited, in the order geometry, device string,
 * environment, default. resolve() computes the effective settings. */

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
    float maxPixelError = 0.0f, cameraPosition[3] = { 0.0f,0.0f,0.0f }, pixelSize = 0.0f; //!< geometries only
    int exactFaces = -1;    //!< 0 or 1, negative to inherit
    bool releasesInput = false; //!< true if the geometry or its device requests it
    /*! devices only: types that inherit compression */
    bool compressesGrids = true, compressesQuads = true, compressesTriangles = true;
    RTCProgressMonitorFunction progress = nullptr; //!< geometries only
    void* progressUserPtr = nullptr;

    /*! Parses cbvh_frame_level, cbvh_max_error, cbvh_exact_faces, cbvh_grids, cbvh_quads, cbvh_triangles and
     *  cbvh_release_input in a device string. Returns false for keys of Embree. Throws rtcore_error with key and
     *  value. */
    bool parse (const Token& key, TokenStream& stream);

    /*! Compression that EMBREE_CBVH=1 and subdiv_accel=cbvh select. cVERT needs less memory than cGRID, is smaller and
     *  more exact than cLEAF, and builds fastest. cVOXEL may be smaller, but its boxes are not a surface to shade. */
    static const RTCCompression bestCompression = RTC_COMPRESSION_VERT;

    /*! Parses EMBREE_CBVH, for example "leaf,frame_level=2". Throws rtcore_error. */
    void parseEnvironment ();

    /*! Applies subdiv_accel of the device string when it is complete; "default" has no effect. Throws rtcore_error for
     *  unknown "cbvh." kinds and for unknown keys. verbose: print version and setting above Embree's banner. */
    void verify (const std::string& subdivAccel, bool verbose);

    /*! Returns the effective settings of a geometry with these settings. Nothing in the result is inherited. */
    CompressionSettings resolve (const CompressionSettings& device) const;

  private:
    void setFrameLevel (const std::string& name, const std::string& value);
    void setMaxError (const std::string& name, const std::string& value);
    void set (const std::string& name, const std::string& key, const std::string& value);
  };
}
