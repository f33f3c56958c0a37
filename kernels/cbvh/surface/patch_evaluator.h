// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Evaluates and displaces vertices of a cage's patch, with the parameters and operations of Embree's GRID
 * (subdivpatch1base_eval.cpp), so that the results are the same floats. Each part subdivides an irregular patch again,
 * and calls the displacement function once. */

#include "../embree/scene.h"
#include "patch_vertices.h"

namespace embree::isa {
class PatchEvaluator : public PatchVertices {
public:
  explicit PatchEvaluator(Device* device) : PatchVertices(device), arrays(device, 0) {}

  /*! Evaluates a part of a patch. quadsX, quadsY: size of the whole patch, at least its edges' rates; edges of
   *  lower rates are stitched as in Embree. */
  void evalPart(const SubdivPatch1Base& patch, const SubdivMesh* mesh, unsigned quadsX, unsigned quadsY,
                const PatchPart& part) {
    setSize(part);
    const float* rate = patch.level;
    isStitched = min(rate[0], rate[2]) < float(quadsX) || min(rate[1], rate[3]) < float(quadsY);
    stride = (count + 2 * VSIZEX - 1) & ~size_t(VSIZEX - 1); // allows full-width stores
    arrays.reserve(8 * stride + 16); // 16 floats for alignment, see array(); resize alone would grow to a power of two
    arrays.resize(8 * stride + 16);
    float* P[3] = {array(0), array(1), array(2)};
    float* N[3] = {array(3), array(4), array(5)};
    float* u = array(6);
    float* v = array(7);

    const Range range = {quadsX + 1, quadsY + 1, part};
    if (patch.type == SubdivPatch1Base::EVAL_PATCH) evalIrregular(patch, mesh, range, P, N, u, v);
    else evalRegular(patch, mesh, range, P, N, u, v);

    interleave(undisplaced());
    if (mesh->displFunc) displace(patch, mesh, P, N, u, v);
    interleave(displaced());
  }

private:
  /*! A part, and the vertices of the whole patch along u and v. */
  struct Range {
    unsigned width, height;
    PatchPart part;
  };

  /*! Array i of `arrays`, aligned for full-width loads. */
  float* array(size_t i) { return (float*)((size_t(arrays.data()) + 63) & ~size_t(63)) + i * stride; }

  void interleave(float (*out)[3]) {
    for (int k = 0; k < 3; k++) {
      const float* in = array(k);
      for (size_t i = 0; i < count; i++) out[i][k] = in[i];
    }
  }

  void evalRegular(const SubdivPatch1Base& patch, const SubdivMesh* mesh, const Range& range, float* P[3], float* N[3],
                   float* u, float* v) {
    gridUVTessellator(patch.level, range.width, range.height, range.part.x0, range.part.y0, unsigned(width),
                      unsigned(height), u, v);
    for (size_t i = count; i < stride; i++) {
      u[i] = u[count - 1];
      v[i] = v[count - 1];
    }
    if (isStitched) stitchParameters(patch.level, range, u, v);
    for (size_t i = 0; i < count; i += VSIZEX) {
      const vfloatx uu = vfloatx::load(u + i), vv = vfloatx::load(v + i);
      const Vec3vfx p = patchEval(patch, uu, vv);
      for (int k = 0; k < 3; k++) vfloatx::store(P[k] + i, p[k]);
      if (!mesh->displFunc) continue;
      const Vec3vfx n = normalize_safe(patchNormal(patch, uu, vv));
      for (int k = 0; k < 3; k++) vfloatx::store(N[k] + i, n[k]);
    }
  }

  /*! Moves parameters on edges of lower rates to these edges' vertices. Replaces Embree's stitchUVGrid(), which
   *  would stitch columns of a part to the rates of the opposite edges. */
  void stitchParameters(const float rate[4], const Range& range, float* u, float* v) const {
    const PatchPart& part = range.part;
    const unsigned vertices[4] = {unsigned(rate[0]) + 1, unsigned(rate[1]) + 1, unsigned(rate[2]) + 1,
                                  unsigned(rate[3]) + 1},
                   columns = unsigned(width);
    auto stitchRow = [&](int s, size_t row) {
      if (vertices[s] < range.width) stitchGridEdges(vertices[s], range.width, part.x0, part.x1, u + row * width, 1);
    };
    auto stitchColumn = [&](int s, size_t column) {
      if (vertices[s] < range.height) stitchGridEdges(vertices[s], range.height, part.y0, part.y1, v + column, columns);
    };
    if (part.y0 == 0) stitchRow(0, 0);
    if (part.x1 == range.width - 1) stitchColumn(1, width - 1);
    if (part.y1 == range.height - 1) stitchRow(2, height - 1);
    if (part.x0 == 0) stitchColumn(3, 0);
  }

  void evalIrregular(const SubdivPatch1Base& patch, const SubdivMesh* mesh, const Range& range, float* P[3],
                     float* N[3], float* u, float* v) {
    const bool normals = mesh->displFunc;
    const float* rate = isStitched ? patch.level : nullptr;
    const unsigned w = unsigned(width), h = unsigned(height), x0 = range.part.x0, x1 = range.part.x1,
                   y0 = range.part.y0, y1 = range.part.y1;
    float *Nx = normals ? N[0] : nullptr, *Ny = normals ? N[1] : nullptr, *Nz = normals ? N[2] : nullptr;
    if (mesh->patch_eval_trees.size())
      feature_adaptive_eval_grid<PatchEvalGrid>(
          mesh->patch_eval_trees[mesh->numTimeSteps * patch.primID() + patch.time()], patch.subPatch(), rate, x0, x1,
          y0, y1, range.width, range.height, P[0], P[1], P[2], u, v, Nx, Ny, Nz, w, h);
    else {
      GeneralCatmullClarkPatch3fa ccpatch(patch.edge(), mesh->getVertexBuffer(patch.time()));
      feature_adaptive_eval_grid<FeatureAdaptiveEvalGrid, GeneralCatmullClarkPatch3fa>(
          ccpatch, patch.subPatch(), rate, x0, x1, y0, y1, range.width, range.height, P[0], P[1], P[2], u, v, Nx, Ny,
          Nz, w, h);
    }

    /* parameters of the sub-patch to parameters of the face */
    const Vec2f uv0 = patch.getUV(0), uv1 = patch.getUV(1), uv2 = patch.getUV(2), uv3 = patch.getUV(3);
    for (size_t i = 0; i < count; i += VSIZEX) {
      const vfloatx uu = vfloatx::load(u + i), vv = vfloatx::load(v + i);
      vfloatx::store(u + i, lerp2(uv0.x, uv1.x, uv3.x, uv2.x, uu, vv));
      vfloatx::store(v + i, lerp2(uv0.y, uv1.y, uv3.y, uv2.y, uu, vv));
    }
  }

  void displace(const SubdivPatch1Base& patch, const SubdivMesh* mesh, float* P[3], float* N[3], float* u, float* v) {
    RTCDisplacementFunctionNArguments args = {
        mesh->userPtr, (RTCGeometry)mesh, patch.primID(), patch.time(), u, v, N[0], N[1], N[2], P[0], P[1],
        P[2],          unsigned(count)};
    mesh->displFunc(&args);
  }

  mvector<float> arrays; //!< arrays of P, N, u and v
  size_t stride = 0;
  bool isStitched = false; //!< an edge has a lower rate than the patch
};

/*! Rows and columns of a patch, evaluated on request, or copied from the whole patch, evaluated once. */
class PatchLines {
public:
  struct Line {
    const float (*vertices)[3];
    size_t count;
  };

  /*! all: memory for all vertices, which the constructor evaluates, or null. */
  PatchLines(const SubdivMesh* mesh, const SubdivPatch1Base& base, PatchEvaluator& evaluator, const unsigned quads[2],
             float (*all)[3])
    : mesh(mesh),
      base(base),
      evaluator(evaluator),
      quads(quads),
      all(all) {
    if (!all) return;
    evaluator.evalPart(base, mesh, quads[0], quads[1], {0, quads[0], 0, quads[1]});
    memcpy(all, evaluator.displaced(), size_t(quads[0] + 1) * size_t(quads[1] + 1) * sizeof(*all));
  }

  /*! Row `at`, or column `at` if not alongU. Valid until the next call or other use of the evaluator. */
  Line operator()(bool alongU, unsigned at) {
    if (!all) {
      const PatchPart row = {0, quads[0], at, at}, column = {at, at, 0, quads[1]};
      evaluator.evalPart(base, mesh, quads[0], quads[1], alongU ? row : column);
      return {evaluator.displaced(), evaluator.width * evaluator.height};
    }
    const size_t width = quads[0] + 1, height = quads[1] + 1;
    if (alongU) return {all + at * width, width};
    float(*column)[3] = evaluator.undisplaced(); // memory that is not used otherwise
    for (size_t y = 0; y < height; y++) memcpy(column[y], all[y * width + at], sizeof(*column));
    return {column, height};
  }

private:
  const SubdivMesh* mesh;
  const SubdivPatch1Base& base;
  PatchEvaluator& evaluator;
  const unsigned* quads;
  float (*all)[3];
};
} // namespace embree::isa
