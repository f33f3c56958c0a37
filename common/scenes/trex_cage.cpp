// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/trex_cage.h"
#include "scenes/cage_parts.h"
#include "scenes/implicit_cage.h"
#include "scenes/noise.h"

namespace programs {
namespace {

float voxelSize(int axis, float coordinate) {
  switch (axis) {
  case 0: return coordinate > 2.9f ? 0.094f : 0.137f;
  case 1: return coordinate > 3.85f ? 0.094f : 0.137f;
  default: return 0.11f;
  }
}

/* Half a jaw, on the right side. */
struct Jaw {
  Vec3f back, tip;
  float radiusBack, radiusTip;
};
constexpr Jaw upperJaw{{3.5f, 4.93f, 0.19f}, {4.95f, 4.77f, 0.1f}, 0.4f, 0.25f};
constexpr Jaw lowerJaw{{3.1f, 4.4f, 0.22f}, {4.72f, 3.9f, 0.09f}, 0.24f, 0.15f};

Vec3f onSide(Vec3f p, float side) { return {p.x, p.y, p.z * side}; }

class Builder {
public:
  TrexCage run() {
    addTrunk();
    for (float side : {-1.0f, 1.0f}) {
      addLeg(side, side < 0.0f ? 0.35f : -0.6f);
      addArm(side);
    }
    addHead();
    result.cage = makeImplicitCage(body, voxelSize);
    result.cage.name = "trex";
    mark(TrexPart::Skin);
    for (const Horn& horn : claws) appendHorn(result.cage, horn);
    mark(TrexPart::Claw);
    for (float side : {-1.0f, 1.0f}) {
      addTeeth(upperJaw, side, -1.0f);
      addTeeth(lowerJaw, side, 1.0f);
    }
    mark(TrexPart::Tooth);
    for (float side : {-1.0f, 1.0f}) appendBall(result.cage, onSide(trexEye, side), trexEyeRadius, 2);
    mark(TrexPart::Eye);
    for (float side : {-1.0f, 1.0f}) // larger balls that leave a slit
    {
      appendBall(result.cage, onSide(trexEye + Vec3f{-0.01f, 0.075f, -0.012f}, side), 1.13f * trexEyeRadius, 3);
      appendBall(result.cage, onSide(trexEye + Vec3f{-0.005f, -0.085f, -0.025f}, side), 1.13f * trexEyeRadius, 3);
    }
    mark(TrexPart::Lid);
    addTongue();
    mark(TrexPart::Tongue);
    return std::move(result);
  }

private:
  void mark(TrexPart part) { result.parts.resize(result.cage.numFaces(), part); }

  void addTrunk() {
    body.push_back({{0, 3.2f, 0}, {1.0f, 3.1f, 0}, 0.86f, 0.94f, 0.0f});      // hip and belly
    body.push_back({{1.0f, 3.12f, 0}, {2.0f, 3.45f, 0}, 0.93f, 0.74f, 0.4f}); // chest
    body.push_back({{2.0f, 3.62f, 0}, {2.6f, 4.25f, 0}, 0.68f, 0.5f, 0.4f});  // neck
    body.push_back({{2.6f, 4.25f, 0}, {3.15f, 4.85f, 0}, 0.5f, 0.46f, 0.3f});
    body.push_back({{2.5f, 3.9f, 0}, {3.1f, 4.42f, 0}, 0.4f, 0.24f, 0.25f});       // throat
    body.push_back({{-0.3f, 3.25f, 0}, {-1.9f, 3.35f, 0.05f}, 0.8f, 0.52f, 0.5f}); // tail
    body.push_back({{-1.9f, 3.35f, 0.05f}, {-3.5f, 3.3f, 0.3f}, 0.51f, 0.32f, 0.3f});
    body.push_back({{-3.5f, 3.3f, 0.3f}, {-4.9f, 3.42f, 0.75f}, 0.31f, 0.18f, 0.3f});
    body.push_back({{-4.9f, 3.42f, 0.75f}, {-6.2f, 3.75f, 1.4f}, 0.18f, 0.09f, 0.2f});
    body.push_back({{-0.4f, 3.98f, 0}, {1.6f, 4.02f, 0}, 0.14f, 0.16f, 0.4f}); // spine
  }

  void addLeg(float side, float stride) {
    const float z = 0.78f * side;
    const Vec3f hip{0.05f + 0.1f * stride, 2.98f, 0.52f * side};
    const Vec3f knee{0.8f + 0.45f * stride, 1.85f, z};
    const Vec3f ankle{-0.15f + 0.65f * stride, 0.95f, z};
    const Vec3f ball{0.15f + 0.8f * stride, 0.24f, z};
    body.push_back({hip, knee, 0.76f, 0.36f, 0.3f});
    body.push_back({knee, lerp(knee, ankle, 0.45f) + Vec3f{-0.1f, 0, 0}, 0.36f, 0.29f, 0.15f}); // calf
    body.push_back({knee, ankle, 0.34f, 0.18f, 0.15f});
    body.push_back({ankle, ball, 0.18f, 0.18f, 0.1f});
    for (float spread : {-0.42f, 0.0f, 0.42f}) {
      const float reach = spread == 0.0f ? 1.12f : 1.0f;
      const Vec3f knuckle = ball + Vec3f{0.5f * reach, -0.05f, spread * 0.75f};
      const Vec3f tip = ball + Vec3f{0.84f * reach, -0.12f, spread * 1.12f};
      body.push_back({ball, knuckle, 0.17f, 0.15f, 0.06f});
      body.push_back({knuckle, tip, 0.135f, 0.105f, 0.04f});
      claws.push_back({lerp(tip, knuckle, 0.3f) + Vec3f{0, 0.02f, 0},
                       tip - knuckle + Vec3f{0, 0.06f, 0},
                       {0, -1, 0},
                       0.44f,
                       0.105f,
                       0.25f,
                       1.0f});
    }
    const Vec3f spur = ball + Vec3f{-0.42f, -0.02f, -0.1f * side};
    body.push_back({ball, spur, 0.14f, 0.09f, 0.05f});
    claws.push_back({lerp(spur, ball, 0.3f), spur - ball, {0, -1, 0}, 0.32f, 0.075f, 0.3f, 1.0f});
  }

  void addArm(float side) {
    const Vec3f shoulder{2.0f, 2.98f, 0.6f * side}, elbow{2.1f, 2.42f, 0.76f * side}, hand{2.53f, 2.32f, 0.66f * side};
    body.push_back({shoulder, elbow, 0.26f, 0.15f, 0.2f});
    body.push_back({elbow, hand, 0.15f, 0.115f, 0.05f});
    for (const Vec3f& tip : {Vec3f{2.78f, 2.16f, 0.54f * side}, Vec3f{2.82f, 2.22f, 0.82f * side}}) {
      body.push_back({hand, tip, 0.115f, 0.095f, 0.03f});
      claws.push_back({lerp(tip, hand, 0.35f), tip - hand, {-0.3f, -1, 0}, 0.32f, 0.07f, 0.35f, 0.9f});
    }
  }

  void addHead() {
    for (float side : {-1.0f, 1.0f}) // in halves, because the head is wider than high
    {
      const auto add = [&](Vec3f a, Vec3f b, float ra, float rb, float smooth, bool carve = false) {
        body.push_back({onSide(a, side), onSide(b, side), ra, rb, smooth, carve});
      };
      add({3.02f, 4.93f, 0.2f}, {3.6f, 5.05f, 0.2f}, 0.45f, 0.42f, 0.3f); // skull
      add(upperJaw.back, upperJaw.tip, upperJaw.radiusBack, upperJaw.radiusTip, 0.15f);
      add(lowerJaw.back, lowerJaw.tip, lowerJaw.radiusBack, lowerJaw.radiusTip, 0.06f);
      add({3.12f, 4.72f, 0.4f}, {3.3f, 4.42f, 0.34f}, 0.22f, 0.2f, 0.2f);         // muscle of the jaw
      add({3.6f, 4.62f, 0.46f}, {4.95f, 4.58f, 0.2f}, 0.1f, 0.09f, 0.1f);         // upper lip
      add({3.35f, 4.46f, 0.4f}, {4.7f, 4.0f, 0.16f}, 0.08f, 0.07f, 0.08f);        // lower lip
      add({3.55f, 5.4f, 0.4f}, {4.12f, 5.36f, 0.38f}, 0.12f, 0.1f, 0.1f);         // brow
      add({4.1f, 5.36f, 0.34f}, {4.95f, 5.02f, 0.13f}, 0.1f, 0.08f, 0.15f);       // nasal ridge
      add({4.1f, 4.85f, 0.55f}, {3.6f, 4.8f, 0.6f}, 0.1f, 0.13f, 0.15f);          // cheekbone
      add({4.3f, 5.05f, 0.58f}, {4.55f, 4.95f, 0.5f}, 0.17f, 0.14f, 0.12f, true); // hollow before the eye
      add(trexEye + Vec3f{0.02f, 0, 0.11f}, trexEye + Vec3f{-0.02f, 0, 0.14f}, 0.15f, 0.15f, 0.06f, true);
      add({4.98f, 4.9f, 0.33f}, {5.08f, 4.87f, 0.3f}, 0.1f, 0.08f, 0.05f, true); // nostril
    }
  }

  /* Point where a ray from inside leaves the body. */
  Vec3f surfaceFrom(Vec3f p, Vec3f direction) const {
    for (int i = 0; i < 40; i++) p = p - 0.8f * std::min(distanceToCapsules(body, p), 0.0f) * direction;
    return p;
  }

  /* Adds a row of teeth from the corner of the mouth to the middle of the snout. They grow up (1) or down (-1). */
  void addTeeth(const Jaw& jaw, float side, float up) {
    constexpr int count = 15;
    for (int i = 0; i < count; i++) {
      const float s = float(i) / float(count - 1);
      const float straight = std::min(1.0f, 1.13f * s);
      const float along = up > 0.0f ? 0.34f + 0.66f * straight : 0.22f + 0.78f * straight;
      const float round = std::max(0.0f, 1.13f * s - 1.0f) / 0.13f; // about the tip of the jaw
      const Vec3f axis = normalize(jaw.tip - jaw.back);
      const Vec3f upwards = up * normalize(Vec3f{-axis.y, axis.x, 0});
      const Vec3f inside = lerp(jaw.back, jaw.tip, along);
      const Vec3f outwards{0.55f * round, 0, 0.55f * (1.0f - 0.85f * round)};
      const Vec3f d = normalize(upwards + outwards);
      const float random = float(hashCell(i, int(side), int(up), 77) & 255) / 255.0f;
      const float longest = std::exp(-12.0f * (s - 0.6f) * (s - 0.6f)); // in the middle of the row
      Horn tooth;
      tooth.base = onSide(surfaceFrom(inside, d) - 0.06f * d, side);
      tooth.direction = onSide(normalize(upwards + 0.2f * outwards), side);
      tooth.bendTowards = {-1, 0, 0};
      tooth.length = 0.06f + (up > 0.0f ? 0.8f : 1.0f) * (0.07f + 0.13f * longest + 0.07f * random);
      tooth.radius = 0.046f + 0.016f * longest + 0.008f * random;
      tooth.bend = 0.16f;
      tooth.flatness = 0.75f;
      tooth.stations = 3;
      appendHorn(result.cage, tooth);
    }
  }

  void addTongue() {
    std::vector<Station> stations;
    constexpr int count = 6;
    for (int i = 0; i < count; i++) {
      const float t = float(i) / float(count - 1);
      const float width = (0.17f - 0.07f * t) * (i == count - 1 ? 0.4f : 1.0f);
      const Vec3f center{3.35f + 1.15f * t, 4.5f - 0.37f * t + 0.1f * t * (1.0f - t), 0.0f};
      stations.push_back({center, {0, 0, width}, {-0.02f, -0.45f * width, 0}});
    }
    appendTube(result.cage, stations, 8);
  }

  std::vector<Capsule> body;
  std::vector<Horn> claws;
  TrexCage result;
};

} // namespace

TrexCage makeTrexCage() { return Builder().run(); }

} // namespace programs
