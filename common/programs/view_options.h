// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/traced_scene.h"
#include "surface/model.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/shutter.h"

#include <string>

namespace programs {

/* "WIDTHxHEIGHT". Throws Error. */
ImageSize parseImageSize(const std::string& text);

/* "x0,y0,x1,y1", or empty for the whole picture. Throws Error unless it is a part of a picture of size `whole`. */
Crop parseCrop(const std::string& text, ImageSize whole);

/* "0,1": two times from 0 to 1 in ascending order. Throws Error. */
Shutter parseShutter(const std::string& text);

/* "x,y,z". Throws Error. */
Vec3f parsePosition(const std::string& text);

/* "ex,ey,ez,lx,ly,lz,fov": eye, target, degrees. Throws Error. */
Camera parseView(const std::string& text, Vec3f up, ImageSize size);

/* Shows the whole model in the direction of the hints. `surface` holds the bounds of the displaced model; `fov` is
 * the vertical field of view in degrees. */
Camera fitCamera(const Model& model, const Box3f& surface, const ViewHints& hints, float fov, ImageSize size);

/* "full" shows the whole model, "close" the place in its hints; other values are for parseView. `scene` is the model
 * as GRID or from a file, and is traced on `threads` threads. Throws Error, also if there is no surface. */
Camera chooseCamera(const std::string& view, const Model& model, const TracedScene& scene, ImageSize size,
                    unsigned threads);

/* Stand-in for a scene without a model, to fit cameras to its box. `up` is one of upAxes(); empty or "auto" means y.
 * Throws Error if the box is empty. */
Model boxModel(const std::string& name, const Box3f& bounds, const std::string& up = "");

} // namespace programs
