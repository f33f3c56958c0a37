// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the programs' option parsers share, beyond the options themselves. */

#include "error.h"
#include "representation.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <string>
#include <vector>

namespace cbvh {

/* False after --help, which has been printed then. Throws Error for what CLI11 refuses. */
inline bool parseCommandLine(CLI::App& app, int argc, char** argv)
{
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::CallForHelp&)
  {
    std::fputs(app.help().c_str(), stdout);
    return false;
  }
  catch (const CLI::ParseError& e)
  {
    throw Error(e.what());
  }
  return true;
}

/* Values of --representation and --frame-level. Throws Error that names the options. */
inline std::vector<Representation> parseRepresentationOptions(const std::string& list, const std::string& frameLevel)
{
  try
  {
    return parseRepresentations(list, parseFrameLevel(frameLevel));
  }
  catch (const Error& e)
  {
    throw Error(std::string("--representation or --frame-level: ") + e.what());
  }
}

} // namespace cbvh
