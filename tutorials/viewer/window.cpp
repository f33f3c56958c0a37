// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "window.h"
#include "view_state.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "measure/hit_metrics.h"
#include "pictures/image_output.h"
#include "pictures/shading.h"
#include "tracing/trace_hits.h"

#include "tutorials/common/tutorial/tutorial.h"

#include <GL/gl.h>

#include <chrono>
#include <cstdio>
#include <thread>

namespace cbvh {
namespace {

using embree::Vec3fa;

constexpr int numKinds = int(RepresentationKind::CVert) + 1;

const char* const keyHelp = "1 to 6      NAIVE, GRID, cGRID, cVOXEL, cLEAF, cVERT; right half: Shift\n"
                            "L, N        level, frame level up; down: Shift\n"
                            "M           next mode; back: Shift\n"
                            "X           split screen\n"
                            "P           save the picture\n"
                            "C           print the camera for --view\n"
                            "B           render without pause\n"
                            "H           hide this\n"
                            "R           where it started\n"
                            "drag        orbit; Shift: look around; Ctrl: distance\n"
                            "wheel       distance\n"
                            "right click orbit about that point\n"
                            "W A S D     move, faster and slower: page up, page down\n"
                            "Q           quit\n";

Vec3f toVec3f(const Vec3fa& v)
{
  return {v.x, v.y, v.z};
}

class Window : public embree::TutorialApplication
{
public:
  Window(const ViewerOptions& options, const Model& model, SceneStore& store, const cbvh::Camera& start)
    : TutorialApplication("cbvh_viewer", 0), options(options), up(model.view.up), store(store), start(start)
  {
    wanted.representations = options.representations;
    wanted.level = options.build.level;
    wanted.mode = options.mode;
    shown = wanted;
    other = {RepresentationKind::Grid};
    width = unsigned(options.size.width);
    height = unsigned(options.size.height);
    resetCamera();
    store.request(wanted.scenes());
  }

  /* --- what upstream's application asks for -------------------------------------------- */

  void displayFunc() override
  {
    if (!prepared)
    {
      ImGui::GetIO().IniFilename = nullptr; // leave no file behind
      glfwSetScrollCallback(window, onScroll);
      prepared = true;
    }
    if (cancelRequested())
      glfwSetWindowShouldClose(window, 1);
    camera.move(moveDelta.x * speed, moveDelta.y * speed, moveDelta.z * speed);
    store.poll();
    if (shown != wanted && !findPanes(wanted, store).empty())
    {
      shown = wanted;
      store.request(wanted.scenes());
      picture.reset();
    }
    if (!refresh())
      std::this_thread::sleep_for(std::chrono::milliseconds(10)); // nothing new

    if (picture)
    {
      glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
      glRasterPos2i(-1, 1);
      glPixelZoom(1.0f, -1.0f);
      glDrawPixels(picture->size.width, picture->size.height, GL_RGB, GL_UNSIGNED_BYTE, picture->rgb.data());
    }
    else
      glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplGlfwGL2_NewFrame();
    if (!hidden)
    {
      ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_Once);
      ImGui::SetNextWindowBgAlpha(0.7f);
      ImGui::Begin("cbvh_viewer", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
      drawGUI();
      ImGui::End();
    }
    ImGui::Render();
    ImGui_ImplGlfwGL2_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window);
  }

  void reshapeFunc(GLFWwindow* window, int w, int h) override
  {
    TutorialApplication::reshapeFunc(window, w, h);
    picture.reset();
  }

  void drawGUI() override
  {
    drawSettings();
    drawReports();
    const std::string activity = store.activity();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 24.0f);
    ImGui::TextColored(ImVec4(1, 0.85f, 0.3f, 1), "%s", store.failure().empty() ? activity.c_str() : store.failure().c_str());
    ImGui::TextUnformatted(message.c_str());
    ImGui::PopTextWrapPos();
    if (ImGui::CollapsingHeader("keys"))
      ImGui::TextUnformatted(keyHelp);
  }

  void keyboardFunc(GLFWwindow* window, int key, int scancode, int action, int mods) override
  {
    const bool free = !ImGui::GetIO().WantCaptureKeyboard;
    if (free && action == GLFW_PRESS && pressed(key, (mods & GLFW_MOD_SHIFT) != 0))
    {
      ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, mods);
      return;
    }
    /* Of upstream's keys: full screen loses ImGui's textures, the space bar writes a
     * picture of its own. */
    if (action == GLFW_PRESS && (key == GLFW_KEY_F || key == GLFW_KEY_SPACE))
      return;
    TutorialApplication::keyboardFunc(window, key, scancode, action, mods);
  }

  void clickFunc(GLFWwindow* window, int button, int action, int mods) override
  {
    enum { orbit = 1, look = 4 }; // upstream's mouseMode
    if (button == GLFW_MOUSE_BUTTON_RIGHT)
    {
      ImGui_ImplGlfw_MouseButtonCallback(window, button, action, mods);
      if (action == GLFW_PRESS && !ImGui::GetIO().WantCaptureMouse)
        centre();
      return;
    }
    TutorialApplication::clickFunc(window, button, action, mods);
    if (mouseMode == orbit)
      mouseMode = look;
    else if (mouseMode == look)
      mouseMode = orbit;
  }

private:
  /* Renders if anything changed, and says so. */
  bool refresh()
  {
    if (width == 0 || height == 0)
      return false; // an icon
    const cbvh::Camera now = currentCamera(ImageSize{int(width), int(height)});
    const std::string description = now.description();
    const std::vector<Pane> panes = findPanes(shown, store);
    if (panes.empty() || (picture && description == pictureCamera && !continuous))
      return false;
    PictureSettings settings;
    settings.mode = shown.mode;
    settings.up = up;
    settings.threads = threadCount(options.build.threads);
    picture = renderPicture(now, panes, settings, reports);
    pictureCamera = description;
    return true;
  }

  static void onScroll(GLFWwindow* window, double x, double y)
  {
    ImGui_ImplGlfw_ScrollCallback(window, x, y);
    if (!ImGui::GetIO().WantCaptureMouse)
      instance->camera.dolly(5.0f * float(y));
  }

  /* --- camera ------------------------------------------------------------------------------ */

  void resetCamera()
  {
    const Vec3f from = start.eye(), to = start.lookAt();
    camera = embree::Camera(Vec3fa(from.x, from.y, from.z), Vec3fa(to.x, to.y, to.z), Vec3fa(up.x, up.y, up.z),
                            start.fov(), embree::Camera::RIGHT_HANDED);
    speed = 0.02f * length(to - from);
  }

  cbvh::Camera currentCamera(ImageSize size) const
  {
    return cbvh::Camera(toVec3f(camera.from), toVec3f(camera.to), up, camera.fov, size);
  }

  /* Orbits about what is under the mouse. */
  void centre()
  {
    const std::vector<Pane> panes = findPanes(shown, store);
    double x, y;
    glfwGetCursorPos(window, &x, &y);
    if (panes.empty() || x < 0 || y < 0 || x >= width || y >= height)
      return;
    Ray ray;
    ray.origin = toVec3f(camera.from);
    ray.direction = currentCamera({int(width), int(height)}).direction(float(x), float(y));
    SurfaceHit hit;
    traceClosest(*panes[x < width / 2 ? 0 : panes.size() - 1].scene, 1, &ray, &hit);
    if (hit.hit())
    {
      const Vec3f p = ray.origin + hit.t * ray.direction;
      camera.to = Vec3fa(p.x, p.y, p.z);
    }
  }

  /* --- switching --------------------------------------------------------------------------- */

  /* What is shown stays until what is wanted is there. */
  void changed()
  {
    std::vector<SceneKey> keys = wanted.scenes();
    for (const SceneKey& key : shown.scenes())
      keys.push_back(key);
    message.clear();
    store.request(keys);
  }

  void setSplit(bool split)
  {
    if (split == (wanted.representations.size() == 2))
      return;
    if (split)
      wanted.representations.push_back(other);
    else
    {
      other = wanted.representations[1];
      wanted.representations.pop_back();
    }
    changed();
  }

  bool pressed(int key, bool shift)
  {
    const int step = shift ? -1 : 1;
    Representation& last = wanted.representations.back();
    if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + numKinds)
      (shift ? last : wanted.representations[0]).kind = RepresentationKind(key - GLFW_KEY_1);
    else
      switch (key)
      {
      case GLFW_KEY_L: wanted.level = std::clamp(wanted.level + step, 0, maxLevel); break;
      case GLFW_KEY_N:
        for (Representation& r : wanted.representations)
          r.frameLevel = std::clamp(r.frameLevel + step, autoFrameLevel, maxLevel);
        break;
      case GLFW_KEY_M:
      {
        constexpr int n = int(std::size(allPictureModes));
        wanted.mode = PictureMode((int(wanted.mode) + n + step) % n);
        break;
      }
      case GLFW_KEY_X: setSplit(wanted.representations.size() == 1); return true;
      case GLFW_KEY_P: save(); return true;
      case GLFW_KEY_C: std::printf("--view %s\n", currentCamera(options.size).description().c_str()); std::fflush(stdout); return true;
      case GLFW_KEY_B: continuous = !continuous; return true;
      case GLFW_KEY_H: hidden = !hidden; return true;
      case GLFW_KEY_R: resetCamera(); return true;
      default: return false;
      }
    changed();
    return true;
  }

  void save()
  {
    if (!picture || shown != wanted)
    {
      message = "not saved: the picture is not there yet";
      return;
    }
    try
    {
      writePng(options.picture, *picture);
      message = "saved " + options.picture;
    }
    catch (const Error& e)
    {
      message = e.what();
    }
    std::printf("%s\n", message.c_str());
    std::fflush(stdout);
  }

  /* --- overlay ------------------------------------------------------------------------------- */

  void drawSettings()
  {
    bool changes = false;
    for (size_t i = 0; i < wanted.representations.size(); i++)
    {
      Representation& r = wanted.representations[i];
      ImGui::PushID(int(i));
      int kind = int(r.kind), frame = r.frameLevel + 1;
      ImGui::PushItemWidth(90);
      if (ImGui::Combo("##kind", &kind, "NAIVE\0GRID\0cGRID\0cVOXEL\0cLEAF\0cVERT\0"))
      {
        r.kind = RepresentationKind(kind);
        changes = true;
      }
      if (r.hasFrames())
      {
        ImGui::SameLine();
        if (ImGui::Combo("frame level", &frame, "auto\0" "0\0" "1\0" "2\0" "3\0" "4\0" "5\0" "6\0" "7\0" "8\0"))
        {
          r.frameLevel = frame - 1;
          changes = true;
        }
      }
      ImGui::PopItemWidth();
      ImGui::PopID();
    }
    int mode = int(wanted.mode);
    changes |= ImGui::SliderInt("level", &wanted.level, 0, maxLevel);
    if (ImGui::Combo("mode", &mode, "shading\0normals\0error\0leaf cells\0blocks\0"))
    {
      wanted.mode = PictureMode(mode);
      changes = true;
    }
    if (changes)
      changed();
    bool split = wanted.representations.size() == 2;
    if (ImGui::Checkbox("split screen", &split))
      setSplit(split);
    ImGui::SameLine();
    ImGui::Checkbox("without pause", &continuous);
  }

  void drawReports()
  {
    const std::vector<Pane> panes = findPanes(shown, store);
    for (size_t i = 0; i < panes.size() && i < reports.size(); i++)
    {
      const BuildReport& b = panes[i].scene->report();
      ImGui::Separator();
      ImGui::Text("%s%s, level %d", panes.size() < 2 ? "" : i ? "right: " : "left: ",
                  panes[i].scene->representation().label().c_str(), shown.level);
      ImGui::Text("%.2f bytes a quad, %.3f M quads", b.bytesPerQuad(), double(b.quads) * 1e-6);
      ImGui::Text("%.2f MiB, built in %.2f s", double(b.liveBytes) / (1 << 20), b.seconds);
      ImGui::Text("%.2f Mrays/s on %u threads", reports[i].mrays(), threadCount(options.build.threads));
      if (shown.mode == PictureMode::Error)
        ImGui::Text("RMSE %.3f pixels, %zu false, %zu missed", reports[i].rmse, reports[i].falseHits, reports[i].misses);
    }
    if (shown.mode == PictureMode::Error)
      drawLegend();
  }

  void drawLegend()
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

  const ViewerOptions& options;
  const Vec3f up;
  SceneStore& store;
  const cbvh::Camera start;
  ViewState wanted, shown;
  Representation other; // of the right half while there is none
  std::optional<Image> picture;
  std::string pictureCamera; // what it was rendered with
  std::vector<PaneReport> reports;
  std::string message;
  bool prepared = false, continuous = false, hidden = false;
};

std::string glfwMessage;

} // namespace

void showWindow(const ViewerOptions& options, const Model& model, SceneStore& store, const Camera& camera)
{
  /* Upstream's application takes errors for exceptions through GLFW's frames: see
   * before it starts whether there is a display at all. */
  glfwSetErrorCallback([](int, const char* text) { glfwMessage = text; });
  if (!glfwInit())
    throw Error("no window can be opened (" + glfwMessage + "); --screenshot needs none");
  Window(options, model, store, camera).renderInteractive();
  throwIfCancelled();
}

} // namespace cbvh

/* --- what upstream links a tutorial against ------------------------------------------------- */

/* Our application renders by itself and asks none of these. */
namespace embree {

RTCScene g_scene = nullptr;

extern "C" void device_init(const char*) {}
extern "C" void device_render(unsigned*, const unsigned, const unsigned, const float, const ISPCCamera&) {}
extern "C" void device_cleanup() {}
extern "C" void renderFrameStandard(int*, const unsigned, const unsigned, const float, const ISPCCamera&) {}

} // namespace embree
