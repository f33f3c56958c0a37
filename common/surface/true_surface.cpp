// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/true_surface.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

/* Step of finite differences in parameters: below a texel in all scenes, and large for the precision of floats. */
constexpr double difference = 0x1p-12;

/* Heights are read inside a patch, because displacements return the mean of the sides on the border. Exceeds the
 * rounding of encoded (u,v). */
constexpr double inset = 0x1p-20;

double inside(double x) { return std::min(std::max(x, inset), 1.0 - inset); }

double square(double x) { return x * x; }

struct Step {
  double u, v;

  Step clamped(double maxLength) const {
    const double size = std::hypot(u, v);
    return size > maxLength ? Step{u * (maxLength / size), v * (maxLength / size)} : *this;
  }
};

/* Longest step, in cells. Farther away, derivatives do not describe the surface. */
constexpr double longestStep = 4.0;

Cage cageOf(const Model& model, size_t copy) {
  Cage cage = model.cage;
  if (const std::vector<Vec3f>* shape = model.shapeOf(copy)) cage.positions = *shape;
  return cage;
}

} // namespace

TrueSurface::TrueSurface(const Model& model, size_t copy) : TrueSurface(model, cageOf(model, copy)) {}

TrueSurface::TrueSurface(const Model& model, const Cage& cage)
  : displacement(model.displacement),
    limit(cage),
    walk(cage, [&](unsigned face) { return limit.has(face); }) {}

TrueSurfaces::TrueSurfaces(const Model& model) {
  for (size_t copy = 0; copy < std::max<size_t>(model.shapes.size(), 1); copy++) surfaces.emplace_back(model, copy);
}

TruePoint TrueSurface::evaluate(const PatchPoint& p) const {
  if (!displacement) {
    const LimitSample s = limit.evaluate(p);
    return {p, s.p, s.du, s.dv};
  }
  return displacement->isAlongNormals() ? evaluateAlongNormal(p) : evaluateByVectors(p);
}

TruePoint TrueSurface::evaluateAlongNormal(const PatchPoint& p) const {
  const LimitSample s = limit.evaluate(p);
  TruePoint result{p, s.p, s.du, s.dv};
  const double u = inside(p.u), v = inside(p.v);
  const double u0 = inside(u - difference), u1 = inside(u + difference);
  const double v0 = inside(v - difference), v1 = inside(v + difference);
  const PatchPoint around[5] = {{p.face, p.subPatch, u, v},
                                {p.face, p.subPatch, u0, v},
                                {p.face, p.subPatch, u1, v},
                                {p.face, p.subPatch, u, v0},
                                {p.face, p.subPatch, u, v1}};
  float us[5], vs[5], offsets[5];
  for (int i = 0; i < 5; i++) {
    const FacePoint q = walk.toEmbree(around[i]);
    us[i] = q.u;
    vs[i] = q.v;
  }
  displacement->offsets({p.face, finestLevel, 5, us, vs}, offsets);
  const double d = offsets[0];
  const double slopeU = (double(offsets[2]) - offsets[1]) / (double(us[2]) - us[1]);
  const double slopeV = (double(offsets[4]) - offsets[3]) / (double(vs[4]) - vs[3]);

  /* Derivative of the unit normal n = m / |m|, m = du x dv: that of m, divided by |m|, minus its part along n. */
  const Vec3d m = cross(s.du, s.dv), n = normalize(m);
  const double size = length(m);
  const auto slopeOfNormal = [&](Vec3d slopeOfM) {
    return size > 0.0 ? (slopeOfM - n * dot(n, slopeOfM)) * (1.0 / size) : Vec3d();
  };
  const Vec3d nu = slopeOfNormal(cross(s.duu, s.dv) + cross(s.du, s.duv));
  const Vec3d nv = slopeOfNormal(cross(s.duv, s.dv) + cross(s.du, s.dvv));
  result.position += d * n;
  result.du += slopeU * n + d * nu;
  result.dv += slopeV * n + d * nv;
  return result;
}

/* Derivatives: the limit surface's plus finite differences of the vectors. */
TruePoint TrueSurface::evaluateByVectors(const PatchPoint& p) const {
  const LimitSample s = limit.evaluate(p);
  TruePoint result{p, s.p + vectorAt(p, s), s.du, s.dv};
  const double u = inside(p.u), v = inside(p.v);
  const double u0 = inside(u - difference), u1 = inside(u + difference);
  const double v0 = inside(v - difference), v1 = inside(v + difference);
  const auto at = [&](double x, double y) {
    const PatchPoint q{p.face, p.subPatch, x, y};
    return vectorAt(q, limit.evaluate(q));
  };
  result.du += (at(u1, v) - at(u0, v)) * (1.0 / (u1 - u0));
  result.dv += (at(u, v1) - at(u, v0)) * (1.0 / (v1 - v0));
  return result;
}

/* `s` is the limit sample at p. */
Vec3d TrueSurface::vectorAt(const PatchPoint& p, const LimitSample& s) const {
  const FacePoint q = walk.toEmbree({p.face, p.subPatch, inside(p.u), inside(p.v)});
  const Vec3d n = normalize(cross(s.du, s.dv));
  const Vec3f normal{float(n.x), float(n.y), float(n.z)};
  Vec3f vector;
  displacement->vectors({q.face, finestLevel, 1, &q.u, &q.v}, &normal, &vector);
  return toDouble(vector);
}

Vec3d TrueSurface::position(const PatchPoint& p) const {
  const LimitSample s = limit.evaluate(p);
  if (!displacement) return s.p;
  if (!displacement->isAlongNormals()) return s.p + vectorAt(p, s);
  const FacePoint q = walk.toEmbree({p.face, p.subPatch, inside(p.u), inside(p.v)});
  float offset;
  displacement->offsets({q.face, finestLevel, 1, &q.u, &q.v}, &offset);
  return s.p + double(offset) * normalize(cross(s.du, s.dv));
}

/* Gauss-Newton with Levenberg-Marquardt damping: a step is accepted only if it reduces the distance. */
TruePoint TrueSurface::descend(Vec3d x, const TruePoint& start, double cell) const {
  constexpr int maxSteps = 100;
  constexpr double firstDamping = 1e-3, maxDamping = 1e6;
  TruePoint best = start;
  double damping = 0.0;
  for (int i = 0; i < maxSteps && damping < maxDamping; i++) {
    const Vec3d r = best.position - x;
    const double gu = dot(best.du, r), gv = dot(best.dv, r);
    const double a = dot(best.du, best.du) * (1.0 + damping), b = dot(best.du, best.dv),
                 c = dot(best.dv, best.dv) * (1.0 + damping), determinant = a * c - b * b;
    if (!(determinant > 0.0)) break;
    const Step full{(b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant};
    const Step step = full.clamped(longestStep * cell);
    /* An error of s in the foot point makes an error of s^2 / 2d in the distance d. If the radius of curvature is
     * close to d, many short steps remain. */
    const double moved = length(best.du * step.u + best.dv * step.v);
    if (moved <= 1e-6 * length(r) + 1e-7 * cell * length(best.du)) break;
    const TruePoint next = evaluate(walk.advance(best.at, step.u, step.v));
    if (length(next.position - x) < length(r)) {
      best = next;
      damping = damping > firstDamping ? 0.1 * damping : 0.0;
    } else damping = damping > 0.0 ? 10.0 * damping : firstDamping;
  }
  return best;
}

/* Parameters around a point, sampled at (2 nu + 1) x (2 nv + 1) places. */
struct TrueSurface::Window {
  PatchPoint middle;
  double width, height; // from the middle to a side, in parameters
  int nu, nv;           // samples from the middle to a side

  int columns() const { return 2 * nu + 1; }
  int rows() const { return 2 * nv + 1; }
};

/* Parameters that can hold a nearer point: it is less than two distances away, and so is the limit surface below it,
 * except for curvature and changes of height. Empty without tangents, and for windows so small that the surface is
 * assumed to be smooth. */
std::optional<TrueSurface::Window> TrueSurface::nearerWindow(const TruePoint& p, double distance, double cell) const {
  constexpr double widest = 8.0, narrowest = 1.0 / 16; // cells
  constexpr int fewest = 2, most = 8;                  // samples from the middle to a side
  const LimitSample s = limit.evaluate(p.at);
  const double uu = dot(s.du, s.du), uv = dot(s.du, s.dv), vv = dot(s.dv, s.dv);
  const double determinant = uu * vv - square(uv);
  if (!(determinant > 0.0)) return {};
  const double reach = 2.0 * distance;
  const double width = std::min(reach * std::sqrt(vv / determinant), widest * cell);
  const double height = std::min(reach * std::sqrt(uu / determinant), widest * cell);
  if (std::max(width, height) < narrowest * cell) return {};
  const auto samplesOf = [&](double size) {
    return std::min(std::max(int(std::ceil(2.0 * size / cell)), fewest), most);
  };
  return Window{p.at, width, height, samplesOf(width), samplesOf(height)};
}

/* Local minima of the distance to x among the samples except the middle one, nearest first. */
std::vector<PatchPoint> TrueSurface::localMinima(const Window& window, Vec3d x) const {
  struct Sample {
    PatchPoint at;
    double distance;
  };
  const int columns = window.columns(), rows = window.rows();
  std::vector<Sample> samples;
  for (int j = -window.nv; j <= window.nv; j++)
    for (int i = -window.nu; i <= window.nu; i++) {
      const PatchPoint at = walk.advance(window.middle, window.width * i / window.nu, window.height * j / window.nv);
      samples.push_back({at, length(position(at) - x)});
    }
  const auto isLowest = [&](int i, int j) {
    const double own = samples[size_t(j * columns + i)].distance;
    for (int b = std::max(j - 1, 0); b <= std::min(j + 1, rows - 1); b++)
      for (int a = std::max(i - 1, 0); a <= std::min(i + 1, columns - 1); a++)
        if (!(own <= samples[size_t(b * columns + a)].distance)) return false;
    return true;
  };
  std::vector<Sample> lowest;
  for (int j = 0; j < rows; j++)
    for (int i = 0; i < columns; i++)
      if (isLowest(i, j) && !(i == window.nu && j == window.nv)) lowest.push_back(samples[size_t(j * columns + i)]);
  std::sort(lowest.begin(), lowest.end(), [](const Sample& a, const Sample& b) { return a.distance < b.distance; });
  std::vector<PatchPoint> points;
  for (const Sample& sample : lowest) points.push_back(sample.at);
  return points;
}

TruePoint TrueSurface::nearest(Vec3d x, const PatchPoint& start, double cell) const {
  constexpr size_t maxDescents = 4;
  TruePoint best = descend(x, evaluate(start), cell);
  const auto distance = [&] { return length(best.position - x); };
  const std::optional<Window> window = nearerWindow(best, distance(), cell);
  if (!window) return best;
  const std::vector<PatchPoint> starts = localMinima(*window, x);
  for (size_t i = 0; i < std::min(starts.size(), maxDescents); i++) {
    const TruePoint foot = descend(x, evaluate(starts[i]), cell);
    if (length(foot.position - x) < distance()) best = foot;
  }
  return best;
}

/* Newton's method in the plane perpendicular to the line. */
std::optional<TruePoint> TrueSurface::crossing(Vec3d origin, Vec3d direction, const TruePoint& start, double cell,
                                               double tolerance) const {
  constexpr int maxSteps = 40, maxHalvings = 12;
  const Vec3d axis = std::abs(direction.x) < 0.6 * length(direction) ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d e0 = normalize(cross(direction, axis)), e1 = normalize(cross(direction, e0));
  const auto distanceToLine = [&](const TruePoint& p) {
    return std::hypot(dot(e0, p.position - origin), dot(e1, p.position - origin));
  };
  TruePoint p = start;
  for (int i = 0; i < maxSteps; i++) {
    const double distance = distanceToLine(p);
    if (distance <= tolerance) return p;
    const double f0 = dot(e0, p.position - origin), f1 = dot(e1, p.position - origin);
    const double a = dot(e0, p.du), b = dot(e0, p.dv), c = dot(e1, p.du), d = dot(e1, p.dv);
    const double determinant = a * d - b * c;
    if (determinant == 0.0) return {};
    Step step = Step{(b * f1 - d * f0) / determinant, (c * f0 - a * f1) / determinant}.clamped(longestStep * cell);
    TruePoint next;
    int halvings = 0;
    do {
      next = evaluate(walk.advance(p.at, step.u, step.v));
      step = {0.5 * step.u, 0.5 * step.v};
    } while (distanceToLine(next) >= distance && ++halvings < maxHalvings);
    if (halvings == maxHalvings) return {};
    p = next;
  }
  return {};
}

} // namespace programs
