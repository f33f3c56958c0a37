// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "../embree/scene.h"
#include "settings.h"
#include "../base/kinds.h"
#include <cstdlib>
#include <iostream>
#include <locale>
#include <sstream>
#include <cmath>

namespace embree
{
  /*! There is no device yet to take a message to its error function: Embree would keep
   *  the code alone, and rtcNewDevice return NULL without a reason. */
  static void invalid (const std::string& name, const std::string& value, const std::string& expected)
  {
    const std::string message = "invalid value \"" + value + "\" of " + name + ": " + expected;
    std::cerr << "Embree: Invalid argument, (" << message << ")" << std::endl;
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,message);
  }

  static bool parseKind (const std::string& key, RTCCompression& compression)
  {
    for (const cbvh::KindDescription& kind : cbvh::kindDescriptions)
      if (key == kind.key) { compression = kind.compression(); return true; }
    return false;
  }

  /*! "cbvh.grid, cbvh.voxel or cbvh.leaf" */
  static std::string kindKeys (const std::string& prefix)
  {
    std::string keys;
    for (uint32_t k=0; k<cbvh::numKinds; k++)
      keys += (k == 0 ? "" : k+1 < cbvh::numKinds ? ", " : " or ") + prefix + cbvh::kindDescriptions[k].key;
    return keys;
  }

  void CompressionSettings::setFrameLevel (const std::string& name, const std::string& value)
  {
    if (value == "auto") { frameLevel = RTC_COMPRESSION_FRAME_LEVEL_AUTO; return; }
    char* end = nullptr;
    const long n = strtol(value.c_str(),&end,10);
    if (value.empty() || *end != 0 || n < 0 || n > long(cbvh::maxLevel))
      invalid(name,value,"expected 0 to " + std::to_string(cbvh::maxLevel) + " or auto");
    frameLevel = int(n);
  }

  void CompressionSettings::setMaxError (const std::string& name, const std::string& value)
  {
    /* with a point in every locale */
    std::istringstream stream(value);
    stream.imbue(std::locale::classic());
    float e = -1.0f;
    if (!(stream >> e) || !stream.eof() || !std::isfinite(e) || e < 0.0f)
      invalid(name,value,"expected a distance, 0 or more");
    maxError = e;
  }

  void CompressionSettings::setExactFaces (const std::string& name, const std::string& value)
  {
    if (value != "0" && value != "1") invalid(name,value,"expected 0 or 1");
    exactFaces = value == "1";
  }

  /*! text of a value, whatever type the tokenizer gave it */
  static std::string valueText (const Token& token)
  {
    try { return token.Identifier(); } catch (const std::exception&) {}
    try { return std::to_string(token.Int()); } catch (const std::exception&) {}
    try { std::ostringstream s; s.imbue(std::locale::classic()); s.precision(9); s << token.Float(); return s.str(); } catch (const std::exception&) {}
    return "";
  }

  bool CompressionSettings::parse (const Token& key, TokenStream& stream)
  {
    const bool isFrameLevel = key == Token::Id("cbvh_frame_level");
    const bool isMaxError   = key == Token::Id("cbvh_max_error");
    const bool isExactFaces = key == Token::Id("cbvh_exact_faces");
    if (!isFrameLevel && !isMaxError && !isExactFaces) return false;
    std::string value;
    if (stream.trySymbol("=")) value = valueText(stream.get());
    if (isFrameLevel)    setFrameLevel("cbvh_frame_level",value);
    else if (isMaxError) setMaxError("cbvh_max_error",value);
    else                 setExactFaces("cbvh_exact_faces",value);
    return true;
  }

  void CompressionSettings::parseEnvironment ()
  {
    const char* text = getenv("EMBREE_CBVH");
    if (text == nullptr) return;
    std::stringstream items(text);
    std::string item;
    while (std::getline(items,item,','))
    {
      const size_t begin = item.find_first_not_of(" \t"), end = item.find_last_not_of(" \t");
      if (begin == std::string::npos) continue;
      item = item.substr(begin,end-begin+1);
      const size_t equals = item.find('=');
      const std::string key = item.substr(0,equals);
      const std::string value = equals == std::string::npos ? "" : item.substr(equals+1);
      if (equals == std::string::npos) {
        if (key == "none" || key == "0") compression = RTC_COMPRESSION_NONE;
        else if (key == "1") compression = bestCompression;
        else if (!parseKind(key,compression)) invalid("EMBREE_CBVH",item,"expected 1, 0, none, " + kindKeys(""));
      }
      else if (key == "frame_level" || key == "level") setFrameLevel("EMBREE_CBVH " + key,value);
      else if (key == "max_error") setMaxError("EMBREE_CBVH max_error",value);
      else if (key == "exact_faces") setExactFaces("EMBREE_CBVH exact_faces",value);
      else invalid("EMBREE_CBVH",item,"expected frame_level, max_error or exact_faces");
    }
  }

  static const char* nameOf (RTCCompression compression)
  {
    for (const cbvh::KindDescription& kind : cbvh::kindDescriptions)
      if (kind.compression() == compression) return kind.name;
    return "GRID, Embree's own";
  }

  void CompressionSettings::verify (const std::string& subdivAccel, bool verbose)
  {
    if (subdivAccel == "cbvh")
      compression = bestCompression;
    else if (subdivAccel.compare(0,4,"cbvh") == 0) {
      if (subdivAccel.compare(0,5,"cbvh.") != 0 || !parseKind(subdivAccel.substr(5),compression))
        invalid("subdiv_accel",subdivAccel,"expected cbvh, " + kindKeys("cbvh."));
    }
    else if (subdivAccel != "default")
      compression = RTC_COMPRESSION_NONE;

    if (verbose)
      std::cout << std::endl << "Embree CBVH " << RTC_COMPRESSION_VERSION_STRING << std::endl
                << "  Subdivision surfaces: " << nameOf(compression) << ", where a geometry does not say otherwise" << std::endl;
  }

  CompressionSettings CompressionSettings::resolve (const CompressionSettings& device) const
  {
    CompressionSettings r = *this;
    if (r.compression == RTC_COMPRESSION_INHERIT) r.compression = device.compression;
    if (r.compression == RTC_COMPRESSION_INHERIT) r.compression = RTC_COMPRESSION_NONE;
    if (r.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_INHERIT) r.frameLevel = device.frameLevel;
    if (r.frameLevel == RTC_COMPRESSION_FRAME_LEVEL_INHERIT) r.frameLevel = RTC_COMPRESSION_FRAME_LEVEL_AUTO;
    if (r.maxError < 0.0f) r.maxError = device.maxError;
    if (r.maxError < 0.0f) r.maxError = 0.0f;
    if (r.exactFaces < 0) r.exactFaces = device.exactFaces;
    if (r.exactFaces < 0) r.exactFaces = 1;
    return r;
  }
}
