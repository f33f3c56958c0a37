// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Lengths are in meters, heights in units of the amplitude (about 0.052 m in the smooth variant). */

#include "scenes/trex_skin.h"
#include "scenes/noise.h"

namespace programs {
namespace {

float bell(float x, float width) { return std::exp(-(x * x) / (width * width)); }

/* One scale per cell: a dome of height 1 surrounded by a groove of the given width. */
float scale(const CellNoise& cell, float groove) {
  const float dome = std::max(0.0f, 1.0f - 0.75f * cell.nearest * cell.nearest);
  return dome * smoothstep(0.0f, groove, cell.second - cell.nearest);
}

/* 0 in a groove, 1 between grooves. Grooves are where noise is near 0. */
float creases(Vec3f p, float width, uint32_t seed) { return smoothstep(0.0f, width, std::abs(gradientNoise(p, seed))); }

struct Regions {
  float head, snout, neck, belly, legs, back;
};

Regions regionsAt(Vec3f p) {
  Regions r;
  r.head = smoothstep(2.95f, 3.35f, p.x) * smoothstep(3.6f, 3.8f, p.y);
  r.snout = r.head * smoothstep(3.9f, 4.4f, p.x);
  const float alongNeck = dot(p - Vec3f{2.7f, 4.2f, 0}, normalize(Vec3f{0.65f, 0.75f, 0}));
  r.neck = p.y < 2.9f ? 0.0f : bell(alongNeck, 0.7f) * smoothstep(2.9f, 3.6f, p.y);
  r.legs = smoothstep(2.5f, 1.9f, p.y);
  r.belly = smoothstep(3.0f, 2.4f, p.y) * (1.0f - r.legs);
  r.back = smoothstep(3.5f, 4.1f, p.y) * (1.0f - r.head);
  return r;
}

/* Folds cross the axis of parts that bend: neck, trunk, tail and limbs. */
float folds(Vec3f p, const Regions& r, float wobble) {
  const Vec3f q = p + 0.12f * Vec3f{wobble, -wobble, wobble};
  const float along = 0.65f * q.x + 0.75f * q.y, across = 0.75f * q.x - 0.65f * q.y;
  const float weight = 1.0f - 0.75f * r.head;
  const float neckShare = r.neck, limbShare = r.legs * (1.0f - r.neck), trunkShare = 1.0f - neckShare - limbShare;
  float mixed = 0.0f;
  if (neckShare > 0.0f) mixed += neckShare * creases({5.0f * along, 1.2f * across, 1.4f * q.z}, 0.3f, 21);
  if (limbShare > 0.0f) mixed += limbShare * creases({1.5f * q.x, 5.5f * q.y, 1.8f * q.z}, 0.3f, 23);
  if (trunkShare > 0.0f) mixed += trunkShare * creases({3.1f * q.x, 0.9f * q.y, 0.9f * q.z}, 0.3f, 22);
  return 1.0f - weight * (1.0f - mixed);
}

/* Height above the lips, which are straight lines in x and y. */
float aboveUpperLip(Vec3f p) { return p.y - (4.55f - 0.01f * (p.x - 3.6f)); }
float aboveLowerLip(Vec3f p) { return p.y - (4.5f - 0.36f * (p.x - 3.35f)); }

/* 1 in the mouth. */
float inMouth(Vec3f p) {
  return smoothstep(3.5f, 3.7f, p.x) * smoothstep(0.02f, 0.07f, aboveLowerLip(p)) *
         smoothstep(-0.02f, -0.07f, aboveUpperLip(p));
}

/* Creases around the eye, the nostril, and grooves along the lips, as an offset to the height. */
float headFeatures(Vec3f p) {
  const Vec3f m{p.x, p.y, std::abs(p.z)};
  const float d = length(m - trexEye) + 0.012f * gradientNoise(9.0f * p, 14);
  const float eye = 0.14f * bell(d - 1.75f * trexEyeRadius, 0.02f) - 0.16f * bell(d - 2.05f * trexEyeRadius, 0.014f) +
                    0.08f * bell(d - 2.35f * trexEyeRadius, 0.02f) - 0.1f * bell(d - 2.65f * trexEyeRadius, 0.013f);
  const float e = length(Vec3f{0.7f, 1.2f, 1.0f} * (m - Vec3f{5.02f, 4.89f, 0.24f}));
  const float nostril = 0.2f * bell(e - 0.085f, 0.025f) - 0.5f * bell(e, 0.055f);
  const float side = smoothstep(3.5f, 3.7f, m.x), upper = aboveUpperLip(m), lower = aboveLowerLip(m);
  const float lips = side * (0.07f * bell(upper, 0.02f) - 0.08f * bell(upper - 0.055f, 0.014f) +
                             0.06f * bell(lower + 0.01f, 0.018f) - 0.07f * bell(lower + 0.06f, 0.014f));
  return eye + nostril + lips;
}

float gums(Vec3f p) {
  return 0.06f * gradientNoise({16.0f * p.x, 5.0f * p.y, 5.0f * p.z}, 41) + 0.03f * gradientNoise(35.0f * p, 42);
}

/* Rings along the rim and small scales. */
float lid(Vec3f p) {
  const Vec3f d = {p.x - trexEye.x, p.y - trexEye.y, std::abs(p.z) - trexEye.z};
  const float rings = std::sin(110.0f * std::abs(d.y) + 9.0f * d.x * d.x);
  return 0.42f + 0.1f * scale(cellNoise(60.0f * p, 43), 0.35f) + 0.05f * rings;
}

float skin(Vec3f p) {
  const Regions r = regionsAt(p);
  const float wobble = gradientNoise(0.9f * p, 11);
  const Vec3f coarse{gradientNoise(4.0f * p, 1), gradientNoise(4.0f * p, 2), gradientNoise(4.0f * p, 3)};
  const Vec3f warped = p + 0.025f * coarse;

  const float mouth = inMouth(p);
  if (mouth == 1.0f) return 0.42f + gums(p);

  /* Scales of 3 cm, and of 2 cm on the head and where skin stretches. */
  const float share2 = smoothstep(0.35f, 0.5f, 0.45f * r.head + 0.35f * r.neck + 0.5f * coarse.y);
  const float fine = (share2 < 1.0f ? (1.0f - share2) * scale(cellNoise(30.0f * warped, 5), 0.34f) : 0.0f) +
                     (share2 > 0.0f ? share2 * scale(cellNoise(47.0f * warped, 9), 0.34f) : 0.0f);

  /* Scales of 9 cm, mostly on back and snout. */
  const CellNoise cell = cellNoise(11.0f * warped, 4);
  const float rank = float(cell.id >> 22) / 1023.0f;
  const float share = 0.12f + 0.4f * r.back + 0.62f * r.snout + 0.2f * r.head * (1.0f - r.snout) + 0.12f * coarse.x;
  const float dome = smoothstep(0.02f, 0.9f, scale(cell, 0.3f));
  const float feature = rank < share ? dome * (0.6f + 0.8f * (share - rank)) : 0.0f;

  const float grain = gradientNoise(95.0f * p, 12);
  const float fold = folds(p, r, wobble);
  const float wrinkles = creases(Vec3f{9.0f, 15.0f, 12.0f} * warped, 0.16f, 7);
  const float bumps = gradientNoise(1.9f * p, 8) + 0.5f * gradientNoise(5.3f * p, 13);

  const float relief = 0.105f + 0.05f * coarse.z; // varies over the body
  const float head = r.head > 0.0f ? r.head * headFeatures(p) : 0.0f;
  const float height = 0.22f + relief * fine * (1.0f - 0.6f * std::min(feature, 1.0f)) + 0.21f * feature +
                       0.17f * fold + 0.1f * wrinkles + 0.1f * bumps + 0.014f * grain + head;
  return std::min(std::max(height + mouth * (0.42f + gums(p) - height), 0.0f), 1.0f);
}

} // namespace

float trexHeight(TrexPart part, Vec3f p) {
  switch (part) {
  case TrexPart::Skin: return skin(p);
  case TrexPart::Tooth: // faint rings, and a vein along
    return 0.5f + 0.012f * gradientNoise({14.0f * p.x, 60.0f * p.y, 14.0f * p.z}, 31) +
           0.008f * gradientNoise({90.0f * p.x, 9.0f * p.y, 90.0f * p.z}, 32);
  case TrexPart::Claw: // growth lines
    return 0.5f + 0.05f * gradientNoise({10.0f * p.x, 45.0f * p.y, 45.0f * p.z}, 33) +
           0.02f * gradientNoise(40.0f * p, 34);
  case TrexPart::Eye: // a pupil, a slit
  {
    const Vec3f d = {p.x - trexEye.x, p.y - trexEye.y, std::abs(p.z) - trexEye.z};
    const Vec3f n = normalize(d);
    const float front = smoothstep(0.55f, 0.7f, n.z);
    return 0.5f + 0.06f * front - 0.14f * front * bell(n.x, 0.16f) * bell(n.y, 0.5f) +
           0.01f * front * gradientNoise(60.0f * p, 35);
  }
  case TrexPart::Lid: return lid(p);
  case TrexPart::Tongue: return 0.5f + 0.12f * scale(cellNoise(38.0f * p, 36), 0.4f) - 0.2f * bell(p.z, 0.02f);
  }
  return 0.5f;
}

} // namespace programs
