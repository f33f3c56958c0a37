// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/height_map.h"
#include "basics/error.h"
#include "basics/file_output.h"

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

constexpr const char* recipeAttribute = "recipe";

Error unreadable(const std::string& path, std::string reason)
{
  while (!reason.empty() && reason.back() == '\n')
    reason.pop_back();
  for (char& c : reason)
    if (c == '\n')
      c = ' ';
  return Error(path + ": cannot be read as a height map: " + (reason.empty() ? "unknown reason" : reason));
}

std::unique_ptr<OIIO::ImageInput> openImage(const std::string& path)
{
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    throw Error(path + ": no such height map");
  const std::string extension = std::filesystem::path(path).extension().string();
  const std::string formats = "," + std::string(OIIO::get_string_attribute("input_format_list")) + ",";
  if ((extension == ".ptx" || extension == ".ptex") && formats.find(",ptex,") == std::string::npos)
    throw Error(path + ": this OpenImageIO is built without its Ptex reader; a TIFF of one page a face serves as well");
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path);
  if (!input)
    throw unreadable(path, OIIO::geterror());
  return input;
}

/* The image that the input is at. */
HeightMap readImage(OIIO::ImageInput& input, int image, const std::string& path)
{
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.width < 1 || spec.height < 1)
    throw unreadable(path, "it is empty");
  HeightMap map(spec.width, spec.height);
  if (!input.read_image(image, 0, 0, 1, OIIO::TypeDesc::FLOAT, &map.at(0, 0)))
    throw unreadable(path, input.geterror());
  /* Some readers fill what a truncated file lacks and only leave a message. */
  if (input.has_error())
    throw unreadable(path, input.geterror());
  const size_t width = size_t(spec.width), texels = width * size_t(spec.height);
  for (size_t i = 0; i < texels; i++)
    if (!std::isfinite((&map.at(0, 0))[i]))
      throw Error(path + ": the height at texel " + std::to_string(i % width) + "," + std::to_string(i / width) +
                  (image ? " of image " + std::to_string(image) : "") + " is not finite");
  return map;
}

} // namespace

HeightMap HeightMap::read(const std::string& path)
{
  const QuietStderr quiet;
  return readImage(*openImage(path), 0, path);
}

HeightMap::FileInfo HeightMap::inspect(const std::string& path)
{
  const QuietStderr quiet;
  const auto input = openImage(path);
  FileInfo info;
  while (input->seek_subimage(int(info.images), 0))
  {
    const HeightMap map = readImage(*input, int(info.images), path);
    if (info.images++ == 0)
      info.constantBorder = map.hasConstantBorder();
  }
  return info;
}

std::string HeightMap::recipeOf(const std::string& path)
{
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return "";
  const QuietStderr quiet;
  const auto input = OIIO::ImageInput::open(path);
  if (input)
    return std::string(input->spec().get_string_attribute(recipeAttribute));
  OIIO::geterror(); // else it is reported at OpenImageIO's leisure
  return "";
}

void HeightMap::write(const std::string& path, const std::string& recipe) const
{
  PendingFile file(path);
  const auto output = OIIO::ImageOutput::create(file.temporary());
  if (!output)
    throw Error(path + ": " + OIIO::geterror());
  OIIO::ImageSpec spec(w, h, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Y"};
  spec.attribute("compression", "none"); // noise hardly shrinks, and takes long to try
  if (!recipe.empty())
    spec.attribute(recipeAttribute, recipe);
  if (!output->open(file.temporary(), spec) || !output->write_image(OIIO::TypeDesc::FLOAT, texels.data()) ||
      !output->close())
    throw Error(path + ": cannot be written: " + output->geterror());
  file.commit();
}

} // namespace cbvh
