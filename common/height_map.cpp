// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "height_map.h"
#include "error.h"
#include "file_output.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace cbvh {
namespace {

/* libpng writes its complaints to stderr itself, past OpenImageIO, which reports
 * them, too. Holds stderr shut for the length of a call; the programs read maps
 * while they do nothing else. */
class QuietStderr
{
public:
  QuietStderr() : saved(dup(STDERR_FILENO))
  {
    std::fflush(stderr);
    const int nowhere = open("/dev/null", O_WRONLY);
    if (saved >= 0 && nowhere >= 0)
      dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0)
      close(nowhere);
  }
  ~QuietStderr()
  {
    if (saved < 0)
      return;
    std::fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
  }

private:
  int saved;
};

} // namespace

HeightMap HeightMap::read(const std::string& path)
{
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw Error(path + ": no such height map");
  auto fail = [&](std::string reason) {
    while (!reason.empty() && reason.back() == '\n')
      reason.pop_back();
    for (char& c : reason)
      if (c == '\n')
        c = ' ';
    return Error(path + ": cannot be read as a height map: " + (reason.empty() ? "unknown reason" : reason));
  };
  const QuietStderr quiet;
  const auto input = OIIO::ImageInput::open(path);
  if (!input)
    throw fail(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1)
    throw fail("it is empty");
  HeightMap map(spec.width, spec.height);
  if (!input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, map.texels.data()))
    throw fail(input->geterror());
  /* Some readers fill what a truncated file lacks and only leave a message. */
  if (input->has_error())
    throw fail(input->geterror());
  for (size_t i = 0; i < map.texels.size(); i++)
    if (!std::isfinite(map.texels[i]))
      throw Error(path + ": the height at texel " + std::to_string(i % map.w) + "," + std::to_string(i / map.w) +
                  " is not finite");
  return map;
}

void HeightMap::write(const std::string& path) const
{
  PendingFile file(path);
  const auto output = OIIO::ImageOutput::create(file.temporary());
  if (!output)
    throw Error(path + ": " + OIIO::geterror());
  OIIO::ImageSpec spec(w, h, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Y"};
  spec.attribute("compression", "none"); // noise hardly shrinks, and takes long to try
  if (!output->open(file.temporary(), spec) || !output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) ||
      !output->close())
    throw Error(path + ": cannot be written: " + output->geterror());
  file.commit();
}

float HeightMap::sampleTexels(float x, float y) const
{
  x = std::min(std::max(x, 0.0f), float(w - 1));
  y = std::min(std::max(y, 0.0f), float(h - 1));
  const int x0 = int(x), y0 = int(y);
  const int x1 = std::min(x0 + 1, w - 1), y1 = std::min(y0 + 1, h - 1);
  const float fx = x - float(x0), fy = y - float(y0);
  const float top = at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx;
  const float bottom = at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx;
  return top * (1.0f - fy) + bottom * fy;
}

float HeightMap::sampleRepeated(float s, float t) const
{
  auto wrap = [](int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; };
  const float x = (s - std::floor(s)) * float(w) - 0.5f;
  const float y = (1.0f - (t - std::floor(t))) * float(h) - 0.5f;
  const float bx = std::floor(x), by = std::floor(y);
  const float fx = x - bx, fy = y - by;
  const int x0 = wrap(int(bx), w), x1 = wrap(int(bx) + 1, w);
  const int y0 = wrap(int(by), h), y1 = wrap(int(by) + 1, h);
  const float top = at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx;
  const float bottom = at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx;
  return top * (1.0f - fy) + bottom * fy;
}

bool HeightMap::hasConstantBorder() const
{
  for (int x = 0; x < w; x++)
    if (at(x, 0) != at(0, 0) || at(x, h - 1) != at(0, 0))
      return false;
  for (int y = 0; y < h; y++)
    if (at(0, y) != at(0, 0) || at(w - 1, y) != at(0, 0))
      return false;
  return true;
}

} // namespace cbvh
