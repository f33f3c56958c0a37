// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The views that programs take on command lines: full, close, or numbers. */

#include "building/traced_scene.h"
#include "surface/model.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/shutter.h"

#include <string>

namespace cbvh {

/* Reads "WIDTHxHEIGHT". Throws Error. */
ImageSize parseImageSize(const std::string& text);

/* Reads "x0,y0,x1,y1"; the whole picture if empty. Throws Error for what is no part of a picture of that size. */
Crop parseCrop(const std::string& text, ImageSize whole);

/* Reads "0,1": two times from 0 to 1, the first not above the second. Throws Error. */
Shutter parseShutter(const std::string& text);

/* Reads "x,y,z". Throws Error. */
Vec3f parsePosition(const std::string& text);

/* Reads "ex,ey,ez,lx,ly,lz,fov". Throws Error. */
Camera parseView(const std::string& text, Vec3f up, ImageSize size);

/* Camera that shows the whole model along a direction, with a narrow rim.
 * surface: bounds of the model, displaced. fov: vertical, in degrees. */
Camera fitCamera(const Model& model, const Box3f& surface, const ViewHints& hints, float fov, ImageSize size);

/* Camera of a view: "full" shows the whole model, "close" stands before the point of
 * it that the model's hints name, anything else goes to parseView.
 * scene: of the model, as GRID or from a file; both are fitted to its surface. threads: to trace it.
 * Throws Error, also when there is no surface; Cancelled. */
Camera chooseCamera(const std::string& view, const Model& model, const TracedScene& scene, ImageSize size,
                    unsigned threads);

/* Of a scene without a model, one to see it by: no more than a name and the corners of its box. up: its axis, one of upAxes(), empty
 * or "auto" for y. Throws Error where there is no surface. */
Model modelOfBox(const std::string& name, const Box3f& bounds, const std::string& up = "");

} // namespace cbvh
