// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "window.h"
#include "panel.h"
#include "viewer.h"
#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "surface/up_axis.h"

#include "tutorials/common/tutorial/tutorial.h"

#include <GL/gl.h>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace programs {
namespace {

class Window : public embree::TutorialApplication {
public:
  Window(const ViewerOptions& options, Viewer& viewer)
    : TutorialApplication("cbvh_viewer", 0),
      viewer(viewer),
      panel(viewer, threadCount(options.build.threads)) {
    width = unsigned(options.size.width);
    height = unsigned(options.size.height);
  }

  /* --- functions of upstream's application ----------------------------------------------- */

  void displayFunc() override {
    if (!prepared) prepare();
    try {
      viewer.update();
    } catch (const Canceled&) // after a signal
    {}
    if (interrupted() || panel.quitChosen()) glfwSetWindowShouldClose(window, 1);
    const bool walking = walk();
    const bool rendered = width > 0 && height > 0 && viewer.refresh(pictureSize()); // the size is 0 for an icon
    draw();
    if (!rendered && !walking) glfwWaitEventsTimeout(0.05); // progress changes without events
  }

  void keyboardFunc(GLFWwindow* window, int key, int scancode, int action, int mods) override {
    if (key == GLFW_KEY_UNKNOWN) return;
    ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, mods);
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    if (panel.isAsking()) handleAnswer(key);
    else if (!handleOrbit(key) && action == GLFW_PRESS && !handleSwitch(key, (mods & GLFW_MOD_SHIFT) != 0))
      handleKey(key, (mods & GLFW_MOD_SHIFT) != 0);
  }

  void clickFunc(GLFWwindow* window, int button, int action, int mods) override {
    ImGui_ImplGlfw_MouseButtonCallback(window, button, action, mods);
    if (action == GLFW_RELEASE) drag = Drag::None;
    if (action != GLFW_PRESS || ImGui::GetIO().WantCaptureMouse) return;
    last = cursor();
    if (button == GLFW_MOUSE_BUTTON_MIDDLE) {
      drag = Drag::Pan;
      panDepth = viewer.depthAt(last);
    } else if (button == GLFW_MOUSE_BUTTON_RIGHT) viewer.centerAt(last);
    else if (button == GLFW_MOUSE_BUTTON_LEFT)
      drag = isOnSplit(last)           ? Drag::Split
             : mods & GLFW_MOD_SHIFT   ? Drag::Look
             : mods & GLFW_MOD_CONTROL ? Drag::Distance
                                       : Drag::Orbit;
  }

  void motionFunc(GLFWwindow*, double, double) override {
    constexpr float radians = 0.005f; // per pixel
    const Vec2f now = cursor(), moved = now - last;
    last = now;
    switch (drag) {
    case Drag::None: break;
    case Drag::Orbit: viewer.orbit(radians * moved.x, -radians * moved.y); break;
    case Drag::Look: viewer.look(radians * moved.x, -radians * moved.y); break;
    case Drag::Distance: viewer.zoom(std::pow(1.01f, moved.y)); break;
    case Drag::Pan: viewer.pan(moved, panDepth); break;
    case Drag::Split: viewer.moveSplit(now.x / float(pictureSize().width)); break;
    }
  }

private:
  enum class Drag { None, Orbit, Look, Distance, Pan, Split };

  /* Area in pixels: on dense screens a window has more pixels than units. */
  Rectangle pictureArea() const {
    int w, h;
    glfwGetWindowSize(window, &w, &h);
    const Rectangle area = panel.layout({std::max(w, 1), std::max(h, 1)}).picture;
    const auto pixels = [](int units, unsigned all, int allUnits) {
      return int(int64_t(units) * int64_t(all) / std::max(allUnits, 1));
    };
    const int x = pixels(area.x, width, w), y = pixels(area.y, height, h);
    const int x1 = pixels(area.x + area.width, width, w), y1 = pixels(area.y + area.height, height, h);
    return {x, y, std::max(1, x1 - x), std::max(1, y1 - y)};
  }

  ImageSize pictureSize() const {
    const Rectangle area = pictureArea();
    return {area.width, area.height};
  }

  static Window& self() { return *static_cast<Window*>(instance); }

  /* Callbacks that upstream's application does not set. */
  void prepare() {
    prepared = true;
    ImGui::GetIO().IniFilename = nullptr; // no settings file
    glfwSetScrollCallback(window, [](GLFWwindow* window, double x, double y) {
      ImGui_ImplGlfw_ScrollCallback(window, x, y);
      if (!ImGui::GetIO().WantCaptureMouse) self().viewer.zoomAt(self().cursor(), std::pow(1.15f, float(y)));
    });
    glfwSetDropCallback(window, [](GLFWwindow*, int count, const char** paths) {
      self().viewer.openFiles(std::vector<std::string>(paths, paths + count));
    });
  }

  void draw() {
    glClearColor(0.2f, 0.2f, 0.2f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    if (viewer.picture()) {
      const Image& picture = viewer.picture()->image();
      const Rectangle area = pictureArea();
      glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
      glViewport(area.x, int(height) - area.y - area.height, area.width, area.height);
      glRasterPos2i(-1, 1);
      glPixelZoom(1.0f, -1.0f);
      glDrawPixels(picture.size.width, picture.size.height, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
      glViewport(0, 0, int(width), int(height));
    }
    ImGui_ImplGlfwGL2_NewFrame();
    panel.draw();
    if (drag == Drag::Split || (isOnSplit(cursor()) && !ImGui::GetIO().WantCaptureMouse))
      ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    ImGui::Render();
    ImGui_ImplGlfwGL2_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window);
    const std::string now = title();
    if (now != shownTitle) glfwSetWindowTitle(window, now.c_str());
    shownTitle = now;
  }

  std::string title() const {
    std::string text = "cbvh_viewer";
    if (viewer.opened()) text += " - " + viewer.opened()->model.name;
    if (const auto progress = viewer.progress()) {
      text += " - " + progress->work;
      if (!progress->phase.empty()) text += ", " + std::to_string(int(100.0 * progress->fraction)) + "%";
    }
    return text;
  }

  /* --- mouse ------------------------------------------------------------------------------- */

  /* Cursor in pixels of the picture. */
  Vec2f cursor() const {
    double x, y;
    int w, h;
    glfwGetCursorPos(window, &x, &y);
    glfwGetWindowSize(window, &w, &h);
    const Rectangle area = pictureArea();
    return {float(x) * float(width) / float(std::max(w, 1)) - float(area.x),
            float(y) * float(height) / float(std::max(h, 1)) - float(area.y)};
  }

  bool isOnSplit(Vec2f pixel) const {
    constexpr float reach = 6;
    const float line = float(splitColumn(pictureSize(), viewer.split()));
    return viewer.panes().size() == 2 && std::abs(pixel.x - line) <= reach;
  }

  /* --- keys -------------------------------------------------------------------------------- */

  /* Moves while keys are held. */
  bool walk() {
    const auto now = std::chrono::steady_clock::now();
    const float seconds = std::min(0.1f, std::chrono::duration<float>(now - walkedAt).count());
    walkedAt = now;
    if (ImGui::GetIO().WantTextInput || panel.isAsking()) return false;
    const auto held = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS ? 1.0f : 0.0f; };
    const float right = held(GLFW_KEY_D) - held(GLFW_KEY_A), forward = held(GLFW_KEY_W) - held(GLFW_KEY_S);
    if (right == 0.0f && forward == 0.0f) return false;
    constexpr float steps = 30; // per second
    viewer.walk(steps * seconds * walkSpeed * right, steps * seconds * walkSpeed * forward);
    return true;
  }

  void handleAnswer(int key) {
    if (key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER || key == GLFW_KEY_Y || key == GLFW_KEY_Q)
      glfwSetWindowShouldClose(window, 1);
    else if (key == GLFW_KEY_ESCAPE || key == GLFW_KEY_N) panel.askToQuit(false);
  }

  /* Handles key repeats, too. Returns false for other keys. */
  bool handleOrbit(int key) {
    constexpr float angle = 0.05f;
    switch (key) {
    case GLFW_KEY_LEFT: viewer.orbit(-angle, 0); return true;
    case GLFW_KEY_RIGHT: viewer.orbit(angle, 0); return true;
    case GLFW_KEY_UP: viewer.orbit(0, angle); return true;
    case GLFW_KEY_DOWN: viewer.orbit(0, -angle); return true;
    default: return false;
    }
  }

  /* Representation, level or mode. Returns false for other keys. */
  bool handleSwitch(int key, bool shift) {
    const int step = shift ? -1 : 1;
    ViewState state = viewer.state();
    const std::vector<RepresentationKind> kinds = kindsOfKeys();
    if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + int(kinds.size()))
      (shift ? state.representations.back() : state.representations[0]).kind = kinds[size_t(key - GLFW_KEY_1)];
    else if (key == GLFW_KEY_L) state.level = std::clamp(state.level + step, autoLevel, maxLevel);
    else if (key == GLFW_KEY_N)
      for (Representation& r : state.representations)
        r.frameLevel = std::clamp(r.frameLevel + step, autoFrameLevel, maxLevel);
    else if (key == GLFW_KEY_M) {
      constexpr int n = int(std::size(allPictureModes));
      state.mode = PictureMode((int(state.mode) + n + step) % n);
    } else return false;
    viewer.requestState(state);
    return true;
  }

  void handleKey(int key, bool shift) {
    switch (key) {
    case GLFW_KEY_X: viewer.setSplit(!viewer.isSplit()); break;
    case GLFW_KEY_P: viewer.savePicture(); break;
    case GLFW_KEY_C:
      std::printf("%s\n", viewer.viewOptions().c_str());
      std::fflush(stdout);
      break;
    case GLFW_KEY_B: viewer.continuous = !viewer.continuous; break;
    case GLFW_KEY_F: viewer.fitView(); break;
    case GLFW_KEY_R: viewer.resetView(); break;
    case GLFW_KEY_U: switchUp(shift); break;
    case GLFW_KEY_PAGE_UP: walkSpeed *= 1.2f; break;
    case GLFW_KEY_PAGE_DOWN: walkSpeed /= 1.2f; break;
    case GLFW_KEY_TAB: panel.toggleFolded(); break;
    case GLFW_KEY_H: panel.toggleHidden(); break;
    case GLFW_KEY_ESCAPE: panel.askToQuit(true); break;
    case GLFW_KEY_Q: glfwSetWindowShouldClose(window, 1); break;
    default: break;
    }
  }

  void switchUp(bool back) {
    const std::vector<std::string>& axes = upAxes();
    const size_t now = size_t(std::find(axes.begin(), axes.end(), viewer.up()) - axes.begin());
    viewer.setUp(axes[(now + (back ? axes.size() - 1 : 1)) % axes.size()]);
  }

  Viewer& viewer;
  Panel panel;
  bool prepared = false;
  std::string shownTitle;

  Drag drag = Drag::None;
  Vec2f last; // cursor at the last event
  float panDepth = 0;
  float walkSpeed = 1;
  std::chrono::steady_clock::time_point walkedAt;
};

std::string glfwMessage;

} // namespace

void showWindow(const ViewerOptions& options) {
  /* Here, because upstream's application throws exceptions through GLFW's frames. */
  glfwSetErrorCallback([](int, const char* text) { glfwMessage = text; });
  if (!glfwInit()) throw Error("cannot open a window (" + glfwMessage + "): expected a display, or --no-window");
  {
    Viewer viewer(options);
    Window(options, viewer).renderInteractive();
  }
  throwIfCanceled();
}

} // namespace programs

/* --- functions that upstream's framework links against -------------------------------------- */

/* Never called, because our application renders itself. */
namespace embree {

RTCScene g_scene = nullptr;

extern "C" void device_init(const char*) {}
extern "C" void device_render(unsigned*, const unsigned, const unsigned, const float, const ISPCCamera&) {}
extern "C" void device_cleanup() {}
extern "C" void renderFrameStandard(int*, const unsigned, const unsigned, const float, const ISPCCamera&) {}

} // namespace embree
