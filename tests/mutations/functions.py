# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

"""The functions that mutate.py breaks, the number of mutants, and the tests that must detect them.

A function has the name that scanner.Function.is_called accepts, and may be anywhere in kernels/cvert or kernels/cbvh.
Tests are "unit" or "unit Suite.Name:Suite.Other" as for test_unit --gtest_filter, those that build fastest first.
Mutants that no test can detect are explained: a part of the mutant's name (mutate.py --list), and the reason.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Entry:
    name: str
    most: int  # number of mutants, spread evenly over the function
    tests: tuple
    explained: dict = field(default_factory=dict)


BLOCK = ("vert_block", "vert_bytes")
MOTION = ("motion_block", "vert_bytes")
CLUSTERS = ("cluster_codec",)
MOTION_DECODING = tuple(f"motion_decoding_{isa}" for isa in ("avx512", "avx2", "sse2"))
DECODING = tuple(f"vert_decoding_{isa} VertDecoding.*" for isa in ("avx512", "avx2", "sse2"))
MESH_DECODING = tuple(f"mesh_decoding_{isa}" for isa in ("avx512", "avx2", "sse2"))
MESH_MOTION = ("mesh_motion",)
MESH_MOTION_DECODING = tuple(f"mesh_motion_decoding_{isa}" for isa in ("avx512", "avx2", "sse2"))
TRIANGLES = tuple(f"vert_decoding_{isa} VertTriangles.*" for isa in ("avx512", "sse2"))
RULE = ("vert_rule",)
BORDERS = ("vert_surfaces -VertRays.*:VertCache.*:Isas/*", "mixed_rates BordersOfMixedRates.*:*VERT", "cage_topology")
GRIDS = ("grid_geometry GridSurfaces.*",)
HITS = ("vert_surfaces *VertRays.*",)
RAYS = ("vert_surfaces *VertRays.*", "scene_features *cVERT*:Packets.*", "coherent_packets *cVERT*")
SETTINGS = ("compression_api Settings.*:SetGeometryCompression.*",)

FUNCTIONS = (
    # the codec of cVERT
    Entry("cellSlope", 1, BLOCK),
    Entry("cellField", 2, BLOCK),
    Entry("cellWeight", 2, BLOCK, {"[> => >=] quads": "x equals quads then"}),
    Entry("cellResidual", 3, BLOCK),
    Entry("slopeResidual", 2, BLOCK),
    Entry("cellPrediction", 3, BLOCK),
    Entry("cellBytes", 1, BLOCK),
    Entry("quadsOfGroup", 2, BLOCK, {"[< => <=] groupQuads": "both are equal then"}),
    Entry("stitchedVertex", 2, BLOCK),
    Entry("vertLayout", 3, BLOCK),
    # its decoder for C++ and shaders
    Entry("residualOfField", 4, BLOCK),
    Entry("rowOfCell", 2, BLOCK),
    Entry("cellOfGroup", 2, BLOCK),
    Entry("vertexIndexInBlock", 2, BLOCK),
    Entry("planesOfGroup", 3, BLOCK),
    Entry("endOfFields", 1, BLOCK),
    Entry("viewOfLaterStep", 2, MOTION),
    # its encoder
    Entry("CellEncoder::encode", 3, BLOCK, {"{ 0 , [0 => 1] , 0 }": "the loop sets it"}),
    Entry("CellEncoder::write", 2, BLOCK),
    Entry("CellEncoder::bitsOf", 2, BLOCK),
    Entry("CellEncoder::removeSlope", 3, BLOCK, {"[< => <=] - maxSlope": "both are equal then"}),
    Entry("BlockVertices::computeBounds", 3, BLOCK),
    Entry("BlockVertices::chooseSpacings", 2, BLOCK),
    Entry("BlockVertices::computeCoordinates", 2, BLOCK),
    Entry("BlockVertices::findSteps", 3, BLOCK,
          {"[max => min] ( std :: fabs": "integers overflow; findStepOfFloats, which is slower, finds the same steps"}),
    Entry("BlockVertices::leastExponent", 3, BLOCK, {"largest > [0 => 1]": "the loop rejects smaller exponents"}),
    Entry("BlockVertices::setRemainders", 3, BLOCK,
          {"return [false => true]": "coordinates are less than 2^61, and no spacing is larger than 2^100"}),
    Entry("BlockVertices::computeWithRemainders", 2, BLOCK),
    Entry("VertEncoder::pack", 5, BLOCK),
    Entry("BoxEncoder::chooseShear", 2, BLOCK,
          {"[0 => 1] ) ) return unsheared": "boxes contain their groups along any slope"}),
    Entry("BoxEncoder::encodeBounds", 4, BLOCK),
    Entry("BoxEncoder::writeMargins", 2, BLOCK),
    Entry("VertEncoder::packRaw", 2, BLOCK),
    Entry("VertEncoder::packCells", 4, BLOCK, {"onCell ( - [1 => 2]": "callers only test the sign"}),
    Entry("VertEncoder::extendByGroup", 2, BLOCK),
    # its motion
    Entry("rotatedResidual", 2, MOTION),
    Entry("rotationEntry", 2, MOTION + ("vert_format",)),
    Entry("vertStepLayout", 3, MOTION),
    Entry("timeInMotion", 2, ("moving_hard_cases", "moving_surfaces *Range*:*Time*")),
    Entry("RotationFit::fit", 3, MOTION),
    Entry("MotionEncoder::packFirst", 2, MOTION),
    Entry("MotionEncoder::packStep", 5, MOTION, {"15u [<< => >>] shiftAt": "these bits are 0 before"}),
    Entry("MotionEncoder::tryCellsOfStep", 4, MOTION,
          {"maxVertGroups + [1 => 2]": "an element more, which nothing reads"}),
    Entry("MotionDecoder", 6, MOTION_DECODING),
    Entry("RotatedBase", 2, MOTION_DECODING),
    Entry("SegmentBounds", 3, ("moving_hard_cases", "moving_surfaces")),
    Entry("MotionTree", 8, ("moving_surfaces *Range*:*Time*:*Hits*", "moving_hard_cases")),
    Entry("stepFieldBits", 2, MESH_MOTION),
    Entry("meshStepLayout", 2, MESH_MOTION),
    Entry("predictedPosition", 1, MESH_MOTION),
    Entry("predictedCoordinate", 2, MESH_MOTION),
    Entry("MeshStepView", 4, MESH_MOTION),
    Entry("AffineFit", 4, MESH_MOTION, {"[< => <=] 3.4e38": "3.4e38 is as valid an entry as 0"}),
    Entry("MeshMotionEncoder", 6, MESH_MOTION),
    Entry("MeshMotionDecoder", 7, MESH_MOTION_DECODING),
    # clusters for GPUs
    Entry("LatticePoints::convert", 3, CLUSTERS, {"shift >= [0 => 1]": "a shift by 0 has no effect"}),
    Entry("LatticePoints::set", 2, CLUSTERS),
    Entry("writeCompressed1", 3, CLUSTERS),
    Entry("QuadTriangles::QuadTriangles", 3, CLUSTERS),
    Entry("Block::write", 4, CLUSTERS),
    Entry("Block::controlOf", 3, CLUSTERS),
    Entry("hasRoom", 3, CLUSTERS, {
        "vertices [<= => <] maxVertices": "grids of 64 vertices have more than 64 triangles, or are longer than a part",
        "triangles [- => +] 1": "no strip of a whole grid has 1021 to 1024 bits, and 4 more bits do not affect others",
    }),
    Entry("Tiling::forEachPiece", 2, CLUSTERS),
    # its decoder and triangles
    Entry("CellFields", 3, DECODING,
          {"[1u => 2u] << ( words - 16": "a word more is loaded, in which no field has bits"}),
    Entry("CellDecoder", 4, DECODING),
    Entry("VertDecoder", 7, DECODING),
    Entry("MeshDecoder", 7, MESH_DECODING),
    Entry("trianglesHitByLine", 2, MESH_DECODING, {"y [ [3 => 4] ]": "an element more, which nothing reads"}),
    Entry("setWindows", 2, DECODING),
    Entry("::mayContain", 2, TRIANGLES, {
        "mayContain, word": "triangles that miss the ray are rejected by their own sides",
        "<= Real ( [0.0f => 1.0f]": "triangles that miss the ray are rejected by their own sides",
    }),
    Entry("triangleSides", 2, TRIANGLES + HITS),
    Entry("exactProduct", 4, RULE),
    Entry("compareMagnitudes", 2, RULE),
    Entry("exactSideOfFloats", 2, RULE),
    Entry("distanceOfHit", 2, RULE),
    Entry("isPlaneDecisive", 1, RULE),
    Entry("::hasPrecedence", 2, RULE, {"[< => <=] b . geomID": "they differ there"}),
    Entry("GroupTriangles", 3, TRIANGLES),
    Entry("GroupTrianglesK", 3, TRIANGLES),
    Entry("::contains", 3, RULE),
    # nodes and leaves
    Entry("lowerPlane", 2, ("node_codec",)),
    Entry("decodeChild", 2, ("node_codec",)),
    Entry("encodeLowerPair", 2, ("node_codec",)),
    Entry("latticeHeight", 2, ("leaf_codec", "format_tables"),
          {"[- => +] 32": "a processor shifts 32 bits by the same modulo 32"}),
    Entry("decodeLatticeLeaf", 2, ("leaf_codec",)),
    Entry("crossLeaf", 3, ("hit_rule",)),
    Entry("passBox", 2, ("hit_rule",)),
    Entry("parabolaRoot", 2, ("crossing",)),
    Entry("crossPatch", 2, ("crossing",)),
    Entry("GroupDecoder4", 2, ("simd_decoding_avx512", "simd_decoding_sse2")),
    # borders and lattices
    Entry("claimOf", 2, BORDERS, {"[32 => 33]": "rates are far below 2^30, so the order of claims does not change"}),
    Entry("CageTopology::findOwners", 3, BORDERS),
    Entry("CageTopology::joinEdges", 2, BORDERS),
    Entry("CageTopology::joinWithoutOpposite", 1, BORDERS),
    Entry("CageSide::half", 2, BORDERS),
    Entry("CageBorders::edgeOf", 2, BORDERS),
    Entry("CageBorders::storeOwnedPoints", 2, BORDERS),
    Entry("firstStitched", 1, BORDERS),
    Entry("BorderLattices::ofShared", 1, BORDERS),
    Entry("LatticeChoice::requestedSpacing", 2, BORDERS),
    # grids that applications dice
    Entry("StitchedVertices::isOnEdge", 2, GRIDS),
    Entry("StitchedVertices::parameterOn", 1, GRIDS),
    Entry("GridsOfGridMesh::isValid", 2, GRIDS),
    Entry("areSmallerAsBlocks", 2, GRIDS),
    # primitives of meshes that lie in no grid
    Entry("IrregularTriangles::findHittable", 2, ("irregular_meshes",)),
    Entry("MeshEncoder::encodeCluster", 2, ("irregular_meshes", "random_meshes")),
    Entry("shareBorder", 3, BORDERS, {
        "at < part . x0 [|| => &&]": "written parts are whole rows",
        "[- => +] part . x0": "written parts are whole rows",
    }),
    Entry("spreadBorder", 2, ("mixed_rates BordersOfMixedRates.*:*GRID",)),
    Entry("::latticeExponent", 2, BLOCK, {"[> => >=] 0 ?": "the exponent of 0 is less than all others"}),
    # what a ray hits in cVERT
    Entry("intersectPlane", 1, RAYS),
    Entry("normalOf", 1, RAYS),
    Entry("classifyHit", 3, RAYS),
    Entry("VertHitReporter::isInRange", 3, RAYS),
    Entry("VertHitReporter::reportNearest", 2, RAYS),
    Entry("positionInQuad", 1, RAYS),
    Entry("faceParameterOfQuad", 1, RAYS),
    Entry("parametersAtStitchedEdge", 2, RULE),
    Entry("intersectsBounds", 2, RAYS),
    Entry("intersectGroupBoxes", 2, RAYS, {
        "open = [0 => 1]": "triangles of a missed group are not hit",
        "[without] tNear": "boxes before or after the ray are entered, but their triangles are not hit",
    }),
    Entry("CachedVertBlock::vertices", 2, RAYS),
    Entry("ThreadCache", 2, ("vert_surfaces VertCache.*", "threads")),
    # settings
    Entry("setMaxError", 2, SETTINGS),
    Entry("finishParsing", 2, SETTINGS),
    Entry("resolve", 2, SETTINGS + ("fallback_faces FallbackFaces.Geometry*",)),
)
