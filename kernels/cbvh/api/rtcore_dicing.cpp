// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../surface/dicing_samples.h"
#include "../embree/scene.h"
#include "cage_check.h"
#include "loaded_geometry.h"

using namespace embree;

namespace
{
  void requireFinite (const char* name, const float* values, size_t n)
  {
    for (size_t i=0; i<n; i++)
      if (!std::isfinite(values[i])) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,std::string("invalid ") + name + ": " + std::to_string(values[i]) + " is not finite");
  }

  void requireAbove (const char* name, float value, float bound, bool orEqual)
  {
    if (!std::isfinite(value) || !(orEqual ? value >= bound : value > bound))
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,std::string("invalid ") + name + " " + std::to_string(value) + ": expected " + (orEqual ? "at least " : "more than ") + (bound == 1.0f ? "1" : "0"));
  }

  void validate (const RTCDicingArguments* args, size_t numEdges)
  {
    if (args == nullptr) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"args is NULL");
    requireFinite("position",args->position,3);
    requireAbove("pixelSize",args->pixelSize,0.0f,false);
    requireAbove("width",args->width,0.0f,true);
    requireAbove("height",args->height,0.0f,true);
    requireAbove("quadSize",args->quadSize,0.0f,false);
    requireAbove("outside",args->outside,1.0f,true);
    requireAbove("maxRate",args->maxRate,1.0f,true);
    if (args->maxRate > 4096.0f) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid maxRate " + std::to_string(args->maxRate) + ": expected 1 to 4096");
    if (args->transform) requireFinite("transform",args->transform,12);
    if (args->maxRates) for (size_t i=0; i<numEdges; i++)
      if (!(args->maxRates[i] >= 1.0f)) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid maxRates: " + std::to_string(args->maxRates[i]) + " of index " + std::to_string(i) + ": expected at least 1");
    if (!(args->width > 0.0f && args->height > 0.0f)) return;
    requireFinite("direction",args->direction,3);
    requireFinite("up",args->up,3);
    const Double3 direction = { args->direction[0],args->direction[1],args->direction[2] }, up = { args->up[0],args->up[1],args->up[2] };
    const double lengths2 = dot(direction,direction)*dot(up,up), right2 = dot(cross(direction,up),cross(direction,up));
    if (!(right2 > 1e-14*lengths2)) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid direction or up: both have a length, and are not parallel");
  }

  /*! of both faces, and of any number of them: what the neediest wants. rates: one an index */
  void agree (const SubdivMesh* mesh, std::vector<float>& rates)
  {
    struct Edge { uint64_t vertices; uint32_t index; bool operator< (const Edge& e) const { return vertices < e.vertices; } };
    const BufferView<unsigned>& indices = mesh->topology[0].vertexIndices;
    std::vector<Edge> edges(rates.size());
    for (size_t f=0, e=0; f<mesh->numFaces(); f++)
    {
      const unsigned n = mesh->faceVertices[f];
      for (unsigned i=0; i<n; i++) {
        const uint64_t a = indices[e+i], b = indices[e+(i+1)%n];
        edges[e+i] = Edge{ min(a,b) << 32 | max(a,b),uint32_t(e+i) };
      }
      e += n;
    }
    std::sort(edges.begin(),edges.end());
    for (size_t i=0, j; i<edges.size(); i=j)
    {
      float highest = 1.0f;
      for (j=i; j<edges.size() && edges[j].vertices == edges[i].vertices; j++) highest = max(highest,rates[edges[j].index]);
      for (size_t k=i; k<j; k++) rates[edges[k].index] = highest;
    }
  }

  /*! the power of two that is the nearest, in times, up to a bound, which may be none */
  float rounded (float rate, float bound)
  {
    const float power = std::ldexp(1.0f,int(std::lround(std::log2(max(rate,1.0f)))));
    return min(power,std::ldexp(1.0f,int(std::floor(std::log2(bound)))));
  }

  void dice (SubdivMesh* mesh, const RTCDicingArguments& args, std::vector<float>& rates)
  {
    const DicingView view(args);
    std::vector<uint32_t> first(mesh->numFaces());
    uint32_t edges = 0;
    for (size_t f=0; f<first.size(); f++) { first[f] = edges; edges += mesh->faceVertices[f]; }
    rates.assign(mesh->numEdges(),1.0f);
    parallel_for(size_t(0),mesh->numFaces(),size_t(16),[&](const range<size_t>& r) {
        DicingSamples samples(mesh,view);
        for (size_t f=r.begin(); f!=r.end(); f++)
        {
          const unsigned n = mesh->faceVertices[f];
          float* const out = &rates[first[f]];
          for (unsigned step=0; step<mesh->numTimeSteps; step++)
          {
            float quads[4];
            if (!mesh->valid(f,step)) continue;
            if (n == 4) {
              samples.measure(unsigned(f),step,0.0f,0.0f,quads);
              for (int i=0; i<4; i++) out[i] = max(out[i],quads[i]);
            }
            /* A patch a corner, of half an edge ahead and half an edge behind; what is opposite of them follows from both. Embree numbers 16. */
            else for (unsigned i=0; i<min(n,16u); i++) {
              samples.measure(unsigned(f),step,0.5f+2.0f*float(i%4),0.5f+2.0f*float(i/4),quads);
              float &ahead = out[i], &behind = out[(i+n-1)%n];
              ahead = max(ahead,2.0f*max(quads[0],quads[2]));
              behind = max(behind,2.0f*max(quads[1],quads[3]));
            }
          }
          if (args.maxRates) for (unsigned i=0; i<n; i++) out[i] = min(out[i],args.maxRates[first[f]+i]);
        }
      });
    agree(mesh,rates);
    for (float& rate : rates) rate = rounded(rate,args.maxRate);
  }
}

RTC_NAMESPACE_BEGIN;

RTC_API void rtcDiceGeometry (RTCGeometry hgeometry, const RTCDicingArguments* args)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  if (geometry == nullptr) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"geometry is NULL");
  const CompressibleGeometry* const own = compressible(geometry);
  if (!own || own->ownType != Geometry::GTY_SUBDIV_MESH) throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry is no subdivision surface");
  if (dynamic_cast<const LoadedGeometry*>(geometry)) throw_RTCError(RTC_ERROR_INVALID_OPERATION,LoadedGeometry::whyNot);
  SubdivMesh* const mesh = (SubdivMesh*) geometry;
  if (Geometry::State(geometry->state) != Geometry::State::COMMITTED || mesh->topology[0].halfEdges.size() < mesh->numEdges() || !mesh->vertices[0])
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry is not committed");
  checkIndices(mesh); // a commit of what is not compressed has not
  validate(args,mesh->numEdges());
  std::vector<float> rates;
  dice(mesh,*args,rates);
  float* const levels = (float*) rtcSetNewGeometryBuffer(hgeometry,RTC_BUFFER_TYPE_LEVEL,0,RTC_FORMAT_FLOAT,sizeof(float),rates.size());
  if (levels) std::copy(rates.begin(),rates.end(),levels);
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
