// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "panel.h"
#include "measure/hit_metrics.h"
#include "pictures/shading.h"

#include "tutorials/common/imgui/imgui.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace cbvh {
namespace {

const ImVec4 attention(1, 0.85f, 0.3f, 1);

const char* const keyHelp = "L, N        level, frame level up; down: Shift\n"
                            "M           next mode; back: Shift\n"
                            "X           split screen, whose line can be dragged\n"
                            "drag        orbit; Shift: look around; Ctrl: distance\n"
                            "middle drag pan\n"
                            "wheel       zoom at the cursor\n"
                            "right click orbit about that point\n"
                            "arrows      orbit\n"
                            "W A S D     walk, faster and slower: page up, page down\n"
                            "F           fit all of it into the window\n"
                            "R           where it started\n"
                            "P           save the picture\n"
                            "C           print the camera for --view\n"
                            "B           render without pause\n"
                            "Tab, H      fold this panel; hide it\n"
                            "Q, Esc      quit; ask before that\n"
                            "Drop a cage (OBJ), a height map or both here to open them.\n";

std::string representationKeyHelp()
{
  std::string labels;
  for (RepresentationKind kind : representationKinds())
    labels += (labels.empty() ? "" : ", ") + labelOf(kind);
  return "1 to " + std::to_string(representationKinds().size()) + "      " + labels + "; right half: Shift\n";
}

/* Of a combo box: entries end in a NUL each. */
std::string representationEntries()
{
  std::string entries;
  for (RepresentationKind kind : representationKinds())
    entries += labelOf(kind) + '\0';
  return entries;
}

std::string frameLevelEntries()
{
  std::string entries = std::string("auto") + '\0';
  for (int level = 0; level <= maxLevel; level++)
    entries += std::to_string(level) + '\0';
  return entries;
}

std::string quadsText(size_t quads)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f million", double(quads) * 1e-6);
  return quads < 1000000 ? std::to_string(quads) : text;
}

std::string bytesText(size_t bytes)
{
  char text[32];
  const bool few = bytes < 1 << 20;
  std::snprintf(text, sizeof(text), "%.1f %s", double(bytes) / (few ? 1 << 10 : 1 << 20), few ? "KiB" : "MiB");
  return text;
}

constexpr ImGuiWindowFlags overlayFlags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize |
                                          ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoNav;

} // namespace

void Panel::draw()
{
  if (!hidden)
    drawPanel();
  drawProgress();
  drawQuestion();
}

void Panel::drawPanel()
{
  ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_Once);
  ImGui::SetNextWindowBgAlpha(0.7f);
  if (changeFold)
    ImGui::SetNextWindowCollapsed(!folded, ImGuiCond_Always);
  changeFold = false;
  folded = !ImGui::Begin("cbvh_viewer", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  if (!folded)
  {
    drawSettings();
    drawReports();
    if (!viewer.message().empty())
    {
      ImGui::Separator();
      ImGui::PushTextWrapPos(ImGui::GetFontSize() * 24.0f);
      ImGui::PushStyleColor(ImGuiCol_Text, attention);
      ImGui::TextUnformatted(viewer.message().c_str());
      ImGui::PopStyleColor();
      ImGui::PopTextWrapPos();
    }
    if (ImGui::CollapsingHeader("keys and mouse"))
      ImGui::TextUnformatted((representationKeyHelp() + keyHelp).c_str());
  }
  ImGui::End();
}

void Panel::drawSettings()
{
  ViewState state = viewer.state();
  for (size_t i = 0; i < state.representations.size(); i++)
  {
    Representation& r = state.representations[i];
    ImGui::PushID(int(i));
    const std::vector<RepresentationKind>& kinds = representationKinds();
    int kind = int(std::find(kinds.begin(), kinds.end(), r.kind) - kinds.begin()), frame = r.frameLevel + 1;
    ImGui::PushItemWidth(90);
    if (ImGui::Combo("##kind", &kind, representationEntries().c_str()))
      r.kind = kinds[size_t(kind)];
    if (r.hasFrames())
    {
      ImGui::SameLine();
      if (ImGui::Combo("frame level", &frame, frameLevelEntries().c_str()))
        r.frameLevel = frame - 1;
    }
    ImGui::PopItemWidth();
    ImGui::PopID();
  }
  int mode = int(state.mode);
  ImGui::SliderInt("level", &state.level, 0, maxLevel);
  if (ImGui::Combo("mode", &mode, "shading\0normals\0error\0leaf cells\0blocks\0"))
    state.mode = PictureMode(mode);
  viewer.want(state);
  drawStrength();
  bool split = viewer.isSplit();
  if (ImGui::Checkbox("split screen", &split))
    viewer.setSplit(split);
  ImGui::SameLine();
  ImGui::Checkbox("without pause", &viewer.continuous);
}

/* It counts as soon as the user is done with it. */
void Panel::drawStrength()
{
  const LoadedModel* const opened = viewer.opened();
  if (!opened || !(opened->source.mapScale || opened->source.amplitude))
    return;
  const bool isScale = opened->source.mapScale.has_value();
  if (!changesStrength)
    strength = isScale ? *opened->source.mapScale : *opened->source.amplitude;
  const float step = std::max(0.01f * std::abs(strength), 1e-5f); // a pixel
  ImGui::DragFloat(isScale ? "height scale" : "amplitude", &strength, step, 0.0f, 0.0f, "%.6g");
  if (changesStrength && !ImGui::IsItemActive())
    viewer.setStrength(strength);
  changesStrength = ImGui::IsItemActive();
  if (ImGui::IsItemHovered() && !changesStrength)
    ImGui::SetTooltip("drag, or double-click and type");
}

void Panel::drawReports()
{
  const std::vector<Pane> panes = viewer.panes();
  const Picture* const picture = viewer.picture();
  if (viewer.isPreview())
  {
    ImGui::Separator();
    ImGui::TextUnformatted("a preview of few quads");
  }
  for (size_t i = 0; picture && i < panes.size() && i < picture->reports().size(); i++)
  {
    const PaneReport& report = picture->reports()[i];
    const BuildReport& b = panes[i].scene->report();
    ImGui::Separator();
    ImGui::Text("%s%s, level %d", panes.size() < 2 ? "" : i ? "right: " : "left: ",
                panes[i].scene->representation().label().c_str(), viewer.shownLevel());
    ImGui::Text("%.2f bytes a quad, %s quads", b.bytesPerQuad(), quadsText(b.quads).c_str());
    ImGui::Text("%s, built in %.2f s", bytesText(b.liveBytes).c_str(), b.seconds);
    ImGui::Text("%.2f million rays a second, %.0f %% hit", report.mrays(), report.percentHit());
    ImGui::Text("on %u thread%s", threads, threads == 1 ? "" : "s");
    if (panes[i].reference && viewer.shownMode() == PictureMode::Error)
    {
      ImGui::Text("error in pixels: median %.3f, 99th percentile %.3f", report.median, report.p99);
      ImGui::Text("%zu false hits, %zu misses", report.falseHits, report.misses);
    }
  }
  if (viewer.shownMode() == PictureMode::Error && !panes.empty())
    drawLegend();
  drawSamples();
}

/* Figures are never of what has been gathered since. */
void Panel::drawSamples()
{
  const Picture* const picture = viewer.picture();
  if (!picture)
    return;
  ImGui::Separator();
  if (picture->wantedSamples() > 1)
    ImGui::Text("%d of %d samples a pixel, figures of one", picture->samples(), picture->wantedSamples());
  else
    ImGui::TextUnformatted("picture and figures: one ray a pixel");
}

void Panel::drawLegend()
{
  const std::pair<float, const char*> entries[] = {{0.0f, "0"}, {1.25f, "1.25"}, {2.5f, "2.5"}, {3.75f, "3.75"},
                                                   {5.0f, "5 pixels"}, {falseHitError, "false"}, {missError, "missed"}};
  Image color(ImageSize{1, 1}); // encodes
  for (const auto& [error, text] : entries)
  {
    color.set(0, errorColor(error));
    const ImVec4 rgb(float(color.rgb[0]) / 255.0f, float(color.rgb[1]) / 255.0f, float(color.rgb[2]) / 255.0f, 1);
    ImGui::ColorButton(text, rgb, ImGuiColorEditFlags_NoTooltip, ImVec2(12, 12));
    ImGui::SameLine();
    ImGui::TextUnformatted(text);
    ImGui::SameLine();
  }
  ImGui::NewLine();
}

/* At the lower border, so that it hides little, or in the middle while there is nothing else.
 * It is there while the panel is hidden, too: nothing else shows that something goes on. */
void Panel::drawProgress()
{
  const std::optional<Worker::Progress> progress = viewer.progress();
  const bool empty = !viewer.opened();
  if (!progress && !empty)
    return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(0.5f * display.x, empty ? 0.5f * display.y : display.y - 8), ImGuiCond_Always,
                          ImVec2(0.5f, empty ? 0.5f : 1.0f));
  ImGui::SetNextWindowBgAlpha(0.7f);
  ImGui::Begin("progress", nullptr, overlayFlags);
  if (progress)
  {
    char percent[160] = "";
    if (!progress->phase.empty())
      std::snprintf(percent, sizeof(percent), "%s %d%%", progress->phase.c_str(), int(100.0 * progress->fraction));
    ImGui::TextUnformatted(progress->work.c_str());
    ImGui::ProgressBar(progress->phase.empty() ? 0.0f : float(progress->fraction), ImVec2(240, 0), percent);
    ImGui::SameLine();
    if (ImGui::Button("stop"))
      viewer.stop();
  }
  else
    ImGui::TextUnformatted("Drop a cage (OBJ) here, and a height map if it has one.");
  ImGui::End();
}

void Panel::drawQuestion()
{
  if (!asking)
    return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(0.5f * display.x, 0.5f * display.y), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowFocus();
  ImGui::Begin("question", nullptr, overlayFlags);
  ImGui::TextUnformatted("Quit cbvh_viewer?");
  if (ImGui::Button("Quit (Enter)"))
    quit = true;
  ImGui::SameLine();
  if (ImGui::Button("Stay (Esc)"))
    asking = false;
  ImGui::End();
}

} // namespace cbvh
