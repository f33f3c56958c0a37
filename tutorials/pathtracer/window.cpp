// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "window.h"
#include "picture_file.h"
#include "basics/error.h"
#include "basics/progress.h"

#include <GLFW/glfw3.h>

namespace programs {
namespace {

std::string glfwMessage;

class Window {
public:
  explicit Window(ImageSize size) {
    requireWindows();
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    window = glfwCreateWindow(size.width, size.height, "cbvh_pathtracer", nullptr, nullptr);
    if (!window) {
      glfwTerminate();
      throw Error("cannot open a window (" + glfwMessage + "): expected a display, or --output without --window");
    }
    glfwMakeContextCurrent(window);
    glfwSetKeyCallback(window, onKey);
  }
  ~Window() { glfwTerminate(); }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool isOpen() const { return !glfwWindowShouldClose(window); }
  void setTitle(const std::string& title) { glfwSetWindowTitle(window, title.c_str()); }

  void draw(const Image& image) {
    int width, height; // larger than the image if the screen is scaled
    glfwGetFramebufferSize(window, &width, &height);
    glViewport(0, 0, width, height);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glRasterPos2i(-1, 1);
    glPixelZoom(float(width) / float(image.size.width), -float(height) / float(image.size.height));
    glDrawPixels(image.size.width, image.size.height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
    glfwSwapBuffers(window);
  }

private:
  static void onKey(GLFWwindow* window, int key, int, int action, int) {
    if (action == GLFW_PRESS && (key == GLFW_KEY_Q || key == GLFW_KEY_ESCAPE))
      glfwSetWindowShouldClose(window, GLFW_TRUE);
  }

  GLFWwindow* window;
};

} // namespace

void requireWindows() {
  glfwSetErrorCallback([](int, const char* text) { glfwMessage = text; });
  if (!glfwInit()) // may be repeated
    throw Error("cannot open a window (" + glfwMessage + "): expected a display, or --output without --window");
}

void showWindow(PathTracer& tracer, ImageSize size, unsigned samples) {
  constexpr double pause = 0.1; // seconds between updates after the last sample
  Window window(size);
  Image image(size);
  while (window.isOpen()) {
    throwIfCanceled();
    if (tracer.samples() < samples) {
      tracer.addSample();
      image = toImage(size, tracer.picture());
      window.setTitle("cbvh_pathtracer: " + std::to_string(tracer.samples()) + " of " + std::to_string(samples) +
                      " samples, Q quits");
      glfwPollEvents();
    } else glfwWaitEventsTimeout(pause);
    window.draw(image);
  }
}

} // namespace programs
