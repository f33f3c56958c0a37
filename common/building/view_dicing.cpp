// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/view_dicing.h"
#include "basics/parallel.h"
#include "basics/progress.h"
#include "building/subdivision_geometry.h"
#include "building/surface_handles.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

/* Quads that keep smooth shapes round: the 64 chords of an arc of a right angle deviate by 1/20000 of its length. */
constexpr float smoothRate = 64.0f;

CbvhDicingArguments argumentsOf(const Camera& camera, const ViewDicing& dicing) {
  CbvhDicingArguments args;
  const auto set = [](float* out, Vec3f v) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
  };
  set(args.position, camera.eye());
  set(args.direction, camera.viewDirection());
  set(args.up, camera.upDirection());
  args.pixelSize = camera.footprint();
  args.width = float(camera.size().width);
  args.height = float(camera.size().height);
  args.quadSize = dicing.quadSize;
  args.maxRate = dicing.maxRate;
  return args;
}

std::vector<float> highestRates(const Model& model) {
  std::vector<float> highest;
  for (unsigned face = 0; face < model.cage.numFaces(); face++)
    for (unsigned edge = 0; edge < model.cage.faceSizes[face]; edge++) {
      const float texels = model.displacement ? model.displacement->texelsAlongEdge(face, edge) : INFINITY;
      highest.push_back(std::max(smoothRate, texels));
    }
  return highest;
}

class Dicer {
public:
  Dicer(const Model& model, const Camera& camera, const ViewDicing& dicing, const BuildSettings& settings)
    : model(model),
      args(argumentsOf(camera, dicing)),
      highest(highestRates(model)),
      device("threads=" + std::to_string(threadCount(settings.threads)) +
             (settings.isa.empty() ? "" : ",isa=" + settings.isa)),
      topology(device, model.cage, model.poses) {
    args.maxRates = highest.data();
  }

  /* Replaces the rates. If `displaced`, measures the surface displaced and filtered to the previous rates. */
  void dice(EdgeRates& rates, bool displaced) {
    rates.copies.resize(model.copies.size());
    for (size_t i = 0; i < model.copies.size(); i++) {
      throwIfCanceled();
      DisplacementContext context;
      if (displaced) {
        context.displacement = model.displacement.get();
        context.rates = &rates;
        context.copy = &rates.copies[i];
      }
      const GeometryHandle geometry = topology.makeGeometry(model.copies[i], context, nullptr, model.shapeOf(i));
      std::vector<float> diced(model.cage.faceIndices.size()); // displacement uses the previous rates meanwhile
      cbvhDiceSurface(surfaceOf(geometry.get()).get(), &args, diced.data());
      device.check("dicing by the view");
      rates.copies[i].rates = std::move(diced);
    }
    setLevels(model.cage, rates);
  }

private:
  const Model& model;
  CbvhDicingArguments args;
  std::vector<float> highest;
  EmbreeDevice device;
  SharedTopology topology;
};

} // namespace

std::shared_ptr<const EdgeRates> diceByView(const Model& model, const Camera& camera, const ViewDicing& dicing,
                                            const BuildSettings& settings) {
  Phase phase("rates by the view");
  auto rates = std::make_shared<EdgeRates>();
  Dicer dicer(model, camera, dicing, settings);
  dicer.dice(*rates, false);
  if (model.displacement) dicer.dice(*rates, true); // edges are longer after displacement
  return rates;
}

BuildSettings settingsForView(BuildSettings settings, const Model& model, const Camera& camera,
                              const std::optional<ViewDicing>& dicing, float maxPixelError) {
  settings.pixelBound = {maxPixelError, camera.eye(), camera.footprint()};
  if (dicing) settings.rates = diceByView(model, camera, *dicing, settings);
  return settings;
}

float highestRate(const std::vector<Representation>& representations) {
  float highest = 4096;
  for (const Representation& r : representations)
    if (!r.isExact()) highest = float(1 << maxLevel);
  return highest;
}

} // namespace programs
