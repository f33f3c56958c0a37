// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* One unit is about a metre; x runs from tail to head, y up, the left side is +z. */

#include "trex.h"

#include "../face_atlas.h"
#include "../noise.h"
#include "../parallel.h"
#include "../subdivision_geometry.h"
#include "implicit_cage.h"

namespace cbvh {
namespace {

constexpr float voxelSize = 0.115f;

void addLeg(std::vector<Capsule>& body, float side, float stride)
{
  const float z = 0.78f * side;
  const Vec3f hip{0.05f + 0.1f * stride, 2.95f, 0.55f * side};
  const Vec3f knee{0.75f + 0.45f * stride, 1.85f, z};
  const Vec3f ankle{-0.15f + 0.65f * stride, 0.95f, z};
  const Vec3f ball{0.15f + 0.8f * stride, 0.24f, z};
  body.push_back({hip, knee, 0.78f, 0.4f, 0.35f});
  body.push_back({knee, ankle, 0.39f, 0.2f, 0.15f});
  body.push_back({ankle, ball, 0.18f, 0.19f, 0.1f});
  for (float spread : {-0.42f, 0.0f, 0.42f})
  {
    const Vec3f knuckle = ball + Vec3f{0.5f, -0.06f, spread * 0.75f};
    const Vec3f tip = ball + Vec3f{0.88f, -0.12f, spread * 1.15f};
    body.push_back({ball, knuckle, 0.17f, 0.15f, 0.06f});
    body.push_back({knuckle, tip, 0.14f, 0.085f, 0.04f});
  }
  body.push_back({ball, ball + Vec3f{-0.42f, -0.04f, -0.1f * side}, 0.14f, 0.09f, 0.05f});
}

void addArm(std::vector<Capsule>& body, float side)
{
  const Vec3f shoulder{2.0f, 2.95f, 0.62f * side}, elbow{2.12f, 2.42f, 0.78f * side}, hand{2.55f, 2.3f, 0.66f * side};
  body.push_back({shoulder, elbow, 0.25f, 0.15f, 0.2f});
  body.push_back({elbow, hand, 0.15f, 0.12f, 0.05f});
  body.push_back({hand, {2.82f, 2.12f, 0.52f * side}, 0.12f, 0.1f, 0.03f});
  body.push_back({hand, {2.86f, 2.18f, 0.82f * side}, 0.12f, 0.1f, 0.03f});
}

void addHead(std::vector<Capsule>& body)
{
  for (float side : {-1.0f, 1.0f}) // in halves: wider than high
  {
    body.push_back({{3.0f, 4.88f, 0.18f * side}, {3.6f, 5.05f, 0.2f * side}, 0.46f, 0.44f, 0.3f});  // skull
    body.push_back({{3.6f, 4.95f, 0.17f * side}, {4.85f, 4.76f, 0.09f * side}, 0.42f, 0.29f, 0.15f}); // upper jaw
    body.push_back({{3.1f, 4.48f, 0.2f * side}, {4.66f, 3.88f, 0.07f * side}, 0.27f, 0.16f, 0.06f}); // lower jaw
    body.push_back({{3.15f, 4.62f, 0.32f * side}, {3.3f, 4.45f, 0.3f * side}, 0.24f, 0.2f, 0.15f}); // cheek
  }
  body.push_back({{3.8f, 5.28f, 0}, {4.9f, 4.99f, 0}, 0.12f, 0.1f, 0.12f});                         // nasal ridge
  for (float side : {-1.0f, 1.0f})
  {
    body.push_back({{3.5f, 5.46f, 0.38f * side}, {4.0f, 5.32f, 0.36f * side}, 0.12f, 0.09f, 0.08f}); // brow
    body.push_back({{3.86f, 5.14f, 0.46f * side}, {3.87f, 5.14f, 0.46f * side}, 0.13f, 0.13f, 0.0f}); // eye
  }
}

std::vector<Capsule> trexBody()
{
  std::vector<Capsule> body;
  body.push_back({{0, 3.15f, 0}, {1.0f, 3.05f, 0}, 0.95f, 1.0f, 0.0f});           // hip and belly
  body.push_back({{1.0f, 3.1f, 0}, {2.0f, 3.45f, 0}, 0.98f, 0.78f, 0.4f});        // chest
  body.push_back({{2.0f, 3.55f, 0}, {2.65f, 4.2f, 0}, 0.7f, 0.5f, 0.4f});         // neck
  body.push_back({{2.65f, 4.2f, 0}, {3.1f, 4.75f, 0}, 0.5f, 0.45f, 0.3f});
  body.push_back({{-0.3f, 3.2f, 0}, {-1.9f, 3.3f, 0.05f}, 0.88f, 0.58f, 0.5f});   // tail
  body.push_back({{-1.9f, 3.3f, 0.05f}, {-3.5f, 3.25f, 0.3f}, 0.57f, 0.36f, 0.3f});
  body.push_back({{-3.5f, 3.25f, 0.3f}, {-4.9f, 3.4f, 0.75f}, 0.35f, 0.2f, 0.3f});
  body.push_back({{-4.9f, 3.4f, 0.75f}, {-6.0f, 3.75f, 1.35f}, 0.2f, 0.09f, 0.2f});
  addLeg(body, -1.0f, 0.35f);
  addLeg(body, 1.0f, -0.6f);
  addArm(body, -1.0f);
  addArm(body, 1.0f);
  addHead(body);
  return body;
}

float smoothstep(float a, float b, float x)
{
  const float t = std::min(std::max((x - a) / (b - a), 0.0f), 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/* A pebble a cell: 1 in its middle, falling to 0 in a groove on its border. Squared
 * distances make it smooth in the middle. */
float pebble(const CellNoise& cell)
{
  const float a = cell.nearest * cell.nearest, b = cell.second * cell.second;
  const float s = (b - a) / (b + a);
  return s * (2.0f - s);
}

/* Grooves where the noise crosses zero; 0 in them, 1 between. */
float creases(Vec3f p, float width, uint32_t seed)
{
  return smoothstep(0.0f, width, std::abs(gradientNoise(p, seed)));
}

/* Height of the skin at a point of the limit surface, within 0 and 1: fine pebbles
 * everywhere, a large feature scale here and there, more of them along the back and
 * on the head, folds around trunk and limbs, wrinkles across them. */
float skinHeight(Vec3f p)
{
  const float wobble = gradientNoise(0.9f * p, 11);
  const float high = smoothstep(-0.4f, 0.6f, p.y - 3.3f - 0.6f * std::max(0.0f, p.x - 2.0f) + 0.5f * wobble);
  const Vec3f warped = p + 0.03f * Vec3f{gradientNoise(5.0f * p, 1), gradientNoise(5.0f * p, 2), gradientNoise(5.0f * p, 3)};

  const float fine = pebble(cellNoise(13.0f * warped, 5));
  const CellNoise cell = cellNoise(4.5f * warped, 4);
  const float rank = float(cell.id >> 22) / 1023.0f; // of the cell's scale among all
  const float feature = smoothstep(0.62f - 0.45f * high, 0.72f - 0.45f * high, rank) *
                        smoothstep(0.1f, 1.0f, pebble(cell));
  const Vec3f folded = Vec3f{2.4f, 0.6f, 0.6f} * (p + 0.2f * Vec3f{wobble, -wobble, wobble});
  const float folds = creases(folded, 0.35f, 6);
  const float wrinkles = creases(Vec3f{4.0f, 7.0f, 7.0f} * warped, 0.15f, 7);
  const float bumps = 0.5f + 0.5f * gradientNoise(1.7f * p, 8);

  const float scales = fine * (0.2f - 0.06f * feature) + 0.36f * feature;
  return std::min(1.0f, scales + 0.26f * folds + 0.06f * wrinkles + 0.12f * bumps);
}

HeightMap bakeSkin(const Cage& cage, const FaceAtlas& atlas, unsigned threads)
{
  Phase phase("trex: skin");
  EmbreeDevice device("threads=1");
  DisplacementContext plain;
  const GeometryHandle geometry = SharedTopology(device, cage).makeGeometry(Placement(), plain);
  HeightMap map(atlas.columns(), atlas.rows(cage.numFaces()));
  const int side = atlas.tileSize + 1;
  const unsigned points = unsigned((side * side + 3) & ~3); // Embree evaluates four at a time
  std::vector<float> u(points, 0.0f), v(points, 0.0f);
  for (int i = 0; i < side * side; i++)
  {
    u[i] = float(i % side) / float(atlas.tileSize);
    v[i] = float(i / side) / float(atlas.tileSize);
  }
  std::atomic<size_t> done{0};
  parallelFor(cage.numFaces(), 16, threads, [&](size_t begin, size_t end) {
    std::vector<float> positions(3 * points);
    std::vector<unsigned> faces(points);
    for (size_t face = begin; face < end; face++)
    {
      std::fill(faces.begin(), faces.end(), unsigned(face));
      RTCInterpolateNArguments args{};
      args.geometry = geometry.get();
      args.primIDs = faces.data();
      args.u = u.data();
      args.v = v.data();
      args.N = points;
      args.bufferType = RTC_BUFFER_TYPE_VERTEX;
      args.P = positions.data();
      args.valueCount = 3;
      rtcInterpolateN(&args);
      const int x0 = int(face) % atlas.tilesPerRow * side, y0 = int(face) / atlas.tilesPerRow * side;
      for (int i = 0; i < side * side; i++)
        map.at(x0 + i % side, y0 + i / side) =
          skinHeight({positions[i], positions[points + i], positions[2 * points + i]});
    }
    done += end - begin;
    phase.update(double(done) / double(cage.numFaces()));
  });
  device.check("evaluating the limit surface");
  return map;
}

} // namespace

Cage makeTrexCage()
{
  Cage cage = makeImplicitCage(trexBody(), voxelSize);
  cage.name = "trex";
  return cage;
}

Model makeTrex(const TrexSettings& settings)
{
  Model model;
  model.name = "trex";
  model.cage = makeTrexCage();
  const FaceAtlas atlas = FaceAtlas::forFaces(model.cage.numFaces(), 64);
  bakeSkin(model.cage, atlas, threadCount(settings.threads)).write(settings.mapPath);
  model.displacement = displaceByAtlas(model.cage, atlas, HeightMap::read(settings.mapPath),
                                       settings.amplitude * model.cage.bounds().diagonal());
  model.view.direction = {-0.62f, -0.12f, -0.8f};
  model.view.closePoint = {0.8f, 0.33f};
  model.view.closeDistance = 0.13f;
  return model;
}

} // namespace cbvh
