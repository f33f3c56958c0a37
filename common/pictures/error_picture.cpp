// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures/error_picture.h"
#include "measure/hit_metrics.h"
#include "pictures/label.h"
#include "pictures/shading.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace programs {
namespace {

constexpr float end = 5.0f; // of the scale, in pixels

/* In dots: a margin, the quad's label, its tick, the bar, the labels of pixels, and a margin. */
constexpr int margin = 4, bar = 8, tick = 3, gap = 3, side = 8;
constexpr int scaleHeight = margin + labelHeight + gap + tick + bar + gap + labelHeight + margin;

std::string quadLabel(float quadPixels) {
  if (quadPixels <= end) return "1 quad";
  char text[48];
  std::snprintf(text, sizeof text, "1 quad is %.0f pixels", std::min(quadPixels, 99999.0f));
  return text;
}

class Scale {
public:
  Scale(Image& image, int top, int dot)
    : image(image),
      dot(dot),
      top(top + margin * dot),
      left(side * dot),
      width(std::min(image.size.width - 2 * left, 160 * dot)) {}

  void draw(float quadPixels) {
    const int barTop = top + (labelHeight + gap + tick) * dot, labels = barTop + (bar + gap) * dot;
    for (int x = 0; x < width; x++)
      fillRectangle(image, left + x, barTop, 1, bar * dot, errorColor(end * float(x) / float(std::max(width - 1, 1))));
    drawLabel(image, left, labels, dot, "0");
    const std::string most = labelWidth("0 5 pixels or more") * dot <= width ? "5 pixels or more" : "5 pixels";
    if (labelWidth("0 " + most) * dot <= width)
      drawLabel(image, left + width - labelWidth(most) * dot, labels, dot, most);
    if (quadPixels > 0.0f) drawQuad(quadPixels);
    int x = left + width + 2 * side * dot;
    for (const auto& [error, text] : {std::pair<float, const char*>{falseHitError, "false hit"}, {missError, "miss"}}) {
      const int next = x + (bar + gap + labelWidth(text) + side) * dot;
      if (next > image.size.width) return;
      fillRectangle(image, x, barTop, bar * dot, bar * dot, errorColor(error));
      drawLabel(image, x + (bar + gap) * dot, barTop, dot, text);
      x = next;
    }
  }

private:
  void drawQuad(float quadPixels) {
    const int at = left + int(float(width) * std::min(quadPixels / end, 1.0f));
    const std::string text = quadLabel(quadPixels);
    const int length = labelWidth(text) * dot;
    if (length > image.size.width - 2 * left) return;
    drawLabel(image, std::clamp(at - length / 2, left, image.size.width - left - length), top, dot, text);
    if (quadPixels <= end)
      fillRectangle(image, at, top + (labelHeight + gap) * dot, dot, (tick + bar) * dot, {0, 0, 0});
  }

  Image& image;
  int dot, top, left, width;
};

} // namespace

Image errorPicture(ImageSize size, const std::vector<float>& errors, float quadPixels) {
  const int dot = std::max(1, size.width / 480);
  Image image({size.width, size.height + scaleHeight * dot});
  fillRectangle(image, 0, size.height, size.width, scaleHeight * dot, {1, 1, 1});
  for (size_t i = 0; i < errors.size(); i++) image.set(i, errorColor(errors[i]));
  fillRectangle(image, 0, size.height, size.width, dot, {0.6f, 0.6f, 0.6f});
  Scale(image, size.height, dot).draw(quadPixels);
  return image;
}

} // namespace programs
