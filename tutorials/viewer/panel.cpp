// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "panel.h"
#include "measure/hit_metrics.h"
#include "pictures/shading.h"
#include "surface/up_axis.h"

#include "tutorials/common/imgui/imgui.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace programs {
namespace {

const ImVec4 attention(1, 0.85f, 0.3f, 1);

constexpr float itemWidth = 165;   // room for the longest label
constexpr float footerHeight = 44; // a line and a progress bar

constexpr std::pair<const char*, const char*> keyHelp[] = {
    {"L, N", "next level, frame level; Shift: previous"},
    {"M", "next mode; Shift: previous"},
    {"X", "split screen; the line can be dragged"},
    {"drag", "orbit; Shift: look around; Ctrl: distance"},
    {"middle drag", "pan"},
    {"wheel", "zoom at the cursor"},
    {"right click", "orbit about this point"},
    {"arrows", "orbit"},
    {"W A S D", "walk; page up, page down: speed"},
    {"F", "fit the whole model into the picture"},
    {"R", "reset the view"},
    {"U", "next up axis; Shift: previous"},
    {"P", "save the picture"},
    {"C", "print the camera for --view"},
    {"B", "render continuously"},
    {"Tab, H", "fold this panel; hide it"},
    {"Q, Esc", "quit; quit after a question"},
};

/* Each is terminated by NUL. */
std::string representationEntries() {
  std::string entries;
  for (RepresentationKind kind : representationKinds()) entries += labelOf(kind) + '\0';
  return entries;
}

std::string frameLevelEntries() {
  std::string entries = std::string("auto") + '\0';
  for (int level = 0; level <= maxLevel; level++) entries += std::to_string(level) + '\0';
  return entries;
}

/* Representations of the surfaces in a file, separated by commas. */
std::string kindsIn(const SavedScene& scene) {
  std::string kinds;
  for (RepresentationKind kind : representationKinds())
    for (const CbvhFileSurfaceInfo& geometry : scene.geometries())
      if (RepresentationKind(geometry.representation) == kind) {
        kinds += (kinds.empty() ? "" : ", ") + labelOf(kind);
        break;
      }
  return kinds;
}

std::string quadsText(size_t quads) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f million", double(quads) * 1e-6);
  return quads < 1000000 ? std::to_string(quads) : text;
}

std::string bytesText(size_t bytes) {
  char text[32];
  const bool few = bytes < 1 << 20;
  std::snprintf(text, sizeof(text), "%.1f %s", double(bytes) / (few ? 1 << 10 : 1 << 20), few ? "KiB" : "MiB");
  return text;
}

constexpr ImGuiWindowFlags overlayFlags =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoNav;

} // namespace

WindowLayout Panel::layout(ImageSize window) const {
  return computeLayout(window, state(), viewer.panes().size() == 2);
}

void Panel::draw() {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const WindowLayout where = layout({std::max(1, int(display.x)), std::max(1, int(display.y))});
  if (!hidden) drawPanel(where.panel);
  if (where.captions.height > 0) drawCaptions(where.captions);
  drawMiddle();
  drawQuestion();
}

/* The folded panel's title shows its most important content. "###" precedes the window's ID. */
std::string Panel::title() const {
  std::string text = "cbvh_viewer";
  const std::optional<Worker::Progress> progress = viewer.progress();
  if (folded && progress) text += ": " + progress->work;
  else if (folded && !viewer.message().empty()) text += ": message, press Tab";
  return text + "###panel";
}

void Panel::drawPanel(const Rectangle& area) {
  ImGui::SetNextWindowPos(ImVec2(float(area.x), float(area.y)), ImGuiCond_Always);
  ImGui::SetNextWindowSize(ImVec2(float(area.width), float(area.height)), ImGuiCond_Always);
  ImGui::SetNextWindowBgAlpha(1.0f);
  if (foldToggled) ImGui::SetNextWindowCollapsed(!folded, ImGuiCond_Always);
  foldToggled = false;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  folded = !ImGui::Begin(title().c_str(), nullptr, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
  if (!folded) {
    ImGui::BeginChild("content", ImVec2(0, -footerHeight));
    ImGui::PushTextWrapPos(0.0f); // wrap at the border
    drawSettings();
    drawReports();
    drawMessage();
    if (ImGui::CollapsingHeader("keys and mouse")) drawKeys();
    ImGui::PopTextWrapPos();
    ImGui::EndChild();
    drawFooter();
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

void Panel::drawMessage() {
  if (viewer.message().empty()) return;
  ImGui::Separator();
  ImGui::PushStyleColor(ImGuiCol_Text, attention);
  ImGui::TextUnformatted(viewer.message().c_str());
  ImGui::PopStyleColor();
}

void Panel::drawKeys() {
  constexpr float column = 92;
  const auto line = [=](const char* keys, const std::string& effect) {
    ImGui::TextUnformatted(keys);
    ImGui::SameLine(column);
    ImGui::TextUnformatted(effect.c_str());
  };
  std::string kinds;
  for (RepresentationKind kind : kindsOfKeys()) kinds += (kinds.empty() ? "" : ", ") + labelOf(kind);
  line(("1 to " + std::to_string(kindsOfKeys().size())).c_str(), kinds + "; right half: Shift");
  for (const auto& [keys, effect] : keyHelp) line(keys, effect);
  ImGui::TextUnformatted("Drop a cage (OBJ), a height map, both, or compressed surfaces (.cbvh) here to open them.");
}

/* The height is constant, so that nothing moves under the mouse. */
void Panel::drawFooter() {
  ImGui::Separator();
  if (const std::optional<Worker::Progress> progress = viewer.progress()) drawProgress(*progress);
  else drawSamples();
}

/* Draws captions on both sides of the split line, or close to it. */
void Panel::drawCaptions(const Rectangle& area) {
  const std::vector<Pane> panes = viewer.panes();
  constexpr float gap = 8;
  const auto caption = [&](size_t i) {
    return panes[i].built->representation().label() + ", level " + levelText(viewer.shownLevel());
  };
  const std::string left = caption(0), right = caption(1);
  const float widths[] = {ImGui::CalcTextSize(left.c_str()).x, ImGui::CalcTextSize(right.c_str()).x};
  const float begin = float(area.x), end = float(area.x + area.width);
  const float line = begin + float(splitColumn({area.width, area.height}, viewer.split()));
  const float leftAt = std::max(begin + gap, std::min(line - gap, end - 3 * gap - widths[1]) - widths[0]);
  const float rightAt = std::max(std::min(line + gap, end - gap - widths[1]), leftAt + widths[0] + 2 * gap);

  ImGui::SetNextWindowPos(ImVec2(begin, float(area.y)), ImGuiCond_Always);
  ImGui::SetNextWindowSize(ImVec2(float(area.width), float(area.height)), ImGuiCond_Always);
  ImGui::SetNextWindowBgAlpha(1.0f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
  ImGui::Begin("captions", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoInputs);
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_Text);
  const float y = float(area.y) + 3;
  list->AddText(ImVec2(leftAt, y), color, left.c_str());
  list->AddText(ImVec2(rightAt, y), color, right.c_str());
  ImGui::End();
  ImGui::PopStyleVar(2);
}

void Panel::drawSettings() {
  ViewState state = viewer.state();
  const bool isFile = viewer.isFile();
  for (size_t i = 0; !isFile && i < state.representations.size(); i++) {
    Representation& r = state.representations[i];
    ImGui::PushID(int(i));
    const std::vector<RepresentationKind>& kinds = representationKinds();
    int kind = int(std::find(kinds.begin(), kinds.end(), r.kind) - kinds.begin()), frame = r.frameLevel + 1;
    ImGui::PushItemWidth(104);
    if (ImGui::Combo("##kind", &kind, representationEntries().c_str())) r.kind = kinds[size_t(kind)];
    if (r.hasFrames()) {
      ImGui::SameLine();
      if (ImGui::Combo("frame level", &frame, frameLevelEntries().c_str())) r.frameLevel = frame - 1;
    }
    ImGui::PopItemWidth();
    ImGui::PopID();
  }
  int mode = int(isFile ? viewer.picturedMode() : state.mode);
  ImGui::PushItemWidth(itemWidth);
  if (!isFile) ImGui::SliderInt("level", &state.level, autoLevel, maxLevel, state.level == autoLevel ? "auto" : "%d");
  if (ImGui::Combo("mode", &mode, isFile ? "shading\0normals\0" : "shading\0normals\0error\0leaf cells\0blocks\0"))
    state.mode = PictureMode(mode);
  viewer.requestState(state);
  drawStrength();
  drawTime();
  drawUp();
  ImGui::PopItemWidth();
  bool split = viewer.isSplit();
  if (!isFile) {
    if (ImGui::Checkbox("split screen", &split)) viewer.setSplit(split);
    ImGui::SameLine();
  }
  ImGui::Checkbox("continuous", &viewer.continuous);
}

void Panel::drawTime() {
  if (!viewer.moves()) return;
  float time = viewer.time();
  if (ImGui::SliderFloat("time", &time, 0.0f, 1.0f, "%.3f")) viewer.setTime(time);
}

void Panel::drawUp() {
  if (!viewer.opened()) return;
  const std::vector<std::string>& axes = upAxes();
  std::string entries;
  for (const std::string& axis : axes) entries += axis + '\0';
  int now = int(std::find(axes.begin(), axes.end(), viewer.up()) - axes.begin());
  if (ImGui::Combo(viewer.isUpGuessed() ? "up (guessed)###up" : "up###up", &now, entries.c_str()))
    viewer.setUp(axes[size_t(now)]);
}

/* Takes effect when the user releases the control. */
void Panel::drawStrength() {
  const LoadedModel* const opened = viewer.opened();
  if (!opened || !(opened->source.mapScale || opened->source.amplitude)) return;
  const bool isScale = opened->source.mapScale.has_value();
  if (!changesStrength) strength = isScale ? *opened->source.mapScale : *opened->source.amplitude;
  const float step = std::max(0.01f * std::abs(strength), 1e-5f); // per pixel
  ImGui::DragFloat(isScale ? "height scale" : "amplitude", &strength, step, 0.0f, 0.0f, "%.6g");
  if (changesStrength && !ImGui::IsItemActive()) viewer.setStrength(strength);
  changesStrength = ImGui::IsItemActive();
  if (ImGui::IsItemHovered() && !changesStrength) ImGui::SetTooltip("drag, or double-click and type");
}

void Panel::drawBuilt(const BuiltScene& scene, const char* side) {
  const BuildReport& b = scene.report();
  ImGui::Text("%s%s, level %s", side, scene.representation().label().c_str(), levelText(viewer.shownLevel()).c_str());
  ImGui::Text("%.2f bytes per quad, %s quads", b.bytesPerQuad(), quadsText(b.quads).c_str());
  ImGui::Text("%s, built in %.2f s", bytesText(b.liveBytes).c_str(), b.seconds);
}

void Panel::drawSaved(const SavedScene& scene) {
  const size_t count = scene.geometries().size(), quads = scene.quads();
  ImGui::Text("%s, a file of %zu geometr%s", kindsIn(scene).c_str(), count, count == 1 ? "y" : "ies");
  ImGui::Text("opened in %.1f ms", 1e3 * scene.seconds());
  const double bytesPerQuad = quads ? double(scene.bytes()) / double(quads) : 0.0;
  ImGui::Text("%.2f bytes per quad, %s quads", bytesPerQuad, quadsText(quads).c_str());
  ImGui::Text("%s of surfaces, mapped", bytesText(scene.bytes()).c_str());
  ImGui::Text("%s of other memory", bytesText(scene.liveBytes()).c_str());
}

void Panel::drawReports() {
  const std::vector<Pane> panes = viewer.panes();
  const Picture* const picture = viewer.picture();
  if (viewer.isPreview()) {
    ImGui::Separator();
    ImGui::TextUnformatted("preview with few quads");
  }
  for (size_t i = 0; picture && i < panes.size() && i < picture->reports().size(); i++) {
    const PaneReport& report = picture->reports()[i];
    ImGui::Separator();
    if (panes[i].built) drawBuilt(*panes[i].built, panes.size() < 2 ? "" : i ? "right: " : "left: ");
    else drawSaved(*panes[i].saved);
    ImGui::Text("%.2f million hits per second, %.2f million rays", report.mhits(), report.mrays());
    ImGui::Text("on %u thread%s", threads, threads == 1 ? "" : "s");
    if (panes[i].reference && viewer.picturedMode() == PictureMode::Error) {
      ImGui::Text("error in pixels: median %.3f, 99th percentile %.3f", report.median, report.p99);
      ImGui::Text("%zu false hits, %zu misses", report.falseHits, report.misses);
    }
  }
  if (viewer.picturedMode() == PictureMode::Error && !panes.empty()) drawLegend();
}

/* All figures belong to the first sample. */
void Panel::drawSamples() {
  const Picture* const picture = viewer.picture();
  if (!picture) return;
  if (picture->wantedSamples() > 1)
    ImGui::Text("%d of %d samples per pixel", picture->samples(), picture->wantedSamples());
  else ImGui::TextUnformatted("one ray per pixel");
  ImGui::TextUnformatted("figures: one ray per pixel");
}

void Panel::drawLegend() {
  const std::pair<float, const char*> entries[] = {{0.0f, "0"},        {1.25f, "1.25"},    {2.5f, "2.5"},
                                                   {3.75f, "3.75"},    {5.0f, "5 pixels"}, {falseHitError, "false hit"},
                                                   {missError, "miss"}};
  constexpr float box = 12, gap = 8;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  Image color(ImageSize{1, 1}); // for conversion to sRGB
  float end = right;            // of the previous entry
  for (const auto& [error, text] : entries) {
    if (end + gap + box + gap + ImGui::CalcTextSize(text).x <= right) ImGui::SameLine();
    color.set(0, errorColor(error));
    const ImVec4 rgb(float(color.rgb[0]) / 255.0f, float(color.rgb[1]) / 255.0f, float(color.rgb[2]) / 255.0f, 1);
    ImGui::ColorButton(text, rgb, ImGuiColorEditFlags_NoTooltip, ImVec2(box, box));
    ImGui::SameLine();
    ImGui::TextUnformatted(text);
    end = ImGui::GetItemRectMax().x;
  }
}

void Panel::drawProgress(const Worker::Progress& progress) {
  char percent[160] = "";
  if (!progress.phase.empty())
    std::snprintf(percent, sizeof(percent), "%s %d%%", progress.phase.c_str(), int(100.0 * progress.fraction));
  ImGui::TextUnformatted(progress.work.c_str());
  ImGui::ProgressBar(progress.phase.empty() ? 0.0f : float(progress.fraction), ImVec2(220, 0), percent);
  ImGui::SameLine();
  if (ImGui::Button("stop")) viewer.stop();
}

/* A hint without a model, and progress that the panel does not show: in the middle if that covers nothing, otherwise
 * at the lower border while the panel is hidden. */
void Panel::drawMiddle() {
  const std::optional<Worker::Progress> progress = viewer.progress();
  const bool empty = !viewer.opened();
  if (progress ? !(hidden || (empty && folded)) : !empty) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const Rectangle area = layout({std::max(1, int(display.x)), std::max(1, int(display.y))}).picture;
  const float x = float(area.x) + 0.5f * float(area.width);
  const float y = empty ? float(area.y) + 0.5f * float(area.height) : display.y - 8;
  ImGui::SetNextWindowPos(ImVec2(x, y), ImGuiCond_Always, ImVec2(0.5f, empty ? 0.5f : 1.0f));
  ImGui::SetNextWindowBgAlpha(0.7f);
  ImGui::Begin("progress", nullptr, overlayFlags);
  if (progress) drawProgress(*progress);
  else {
    ImGui::TextUnformatted("Drop a cage (OBJ) here,");
    ImGui::TextUnformatted("and a height map if it has one,");
    ImGui::TextUnformatted("or compressed surfaces (.cbvh).");
  }
  ImGui::End();
}

void Panel::drawQuestion() {
  if (!asking) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(0.5f * display.x, 0.5f * display.y), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowFocus();
  ImGui::Begin("question", nullptr, overlayFlags);
  ImGui::TextUnformatted("Quit cbvh_viewer?");
  if (ImGui::Button("Quit (Enter)")) quit = true;
  ImGui::SameLine();
  if (ImGui::Button("Stay (Esc)")) asking = false;
  ImGui::End();
}

} // namespace programs
