// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "input_bytes.h"
#include "../embree/scene.h"
#include "loaded_geometry.h"

namespace embree
{
  namespace
  {
    class InputBytes
    {
    public:
      explicit InputBytes (std::set<const void*>& counted) : counted(counted) {}

      void add (const RawBufferView& view)
      {
        const Buffer* const buffer = view.buffer.ptr;
        if (buffer && !buffer->shared && counted.insert(buffer).second) bytes += buffer->bytes();
      }

      template<typename View>
      void add (const vector<View>& views) { for (const View& view : views) add(view); }

      template<typename Mesh>
      void addVertices (const Mesh* mesh)
      {
        add(mesh->vertices);
        add(mesh->vertexAttribs);
      }

      void addCage (const SubdivMesh* mesh)
      {
        addVertices(mesh);
        for (const auto& topology : mesh->topology) {
          add(topology.vertexIndices);
          bytes += topology.halfEdges.size()*sizeof(HalfEdge);
        }
        add(mesh->faceVertices);
        add(mesh->edge_creases);
        add(mesh->edge_crease_weights);
        add(mesh->vertex_creases);
        add(mesh->vertex_crease_weights);
        add(mesh->levels);
        add(mesh->holes);
      }

      size_t bytes = 0;

    private:
      std::set<const void*>& counted;
    };
  }

  size_t bytesOfInput (CompressibleGeometry* geometry, std::set<const void*>& counted)
  {
    if (dynamic_cast<const LoadedGeometry*>(geometry)) return 0;
    InputBytes input(counted);
    switch (geometry->ownType) {
    case Geometry::GTY_SUBDIV_MESH: input.addCage((const SubdivMesh*)geometry); break;
    case Geometry::GTY_GRID_MESH: input.addVertices((const GridMesh*)geometry); input.add(((const GridMesh*)geometry)->grids); break;
    case Geometry::GTY_QUAD_MESH: input.addVertices((const QuadMesh*)geometry); input.add(((const QuadMesh*)geometry)->quads); break;
    default: input.addVertices((const TriangleMesh*)geometry); input.add(((const TriangleMesh*)geometry)->triangles); break;
    }
    return input.bytes;
  }
}
