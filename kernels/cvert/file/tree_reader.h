// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads and checks a geometry's tree in a file: every node but the root has one parent, nodes and blocks are in
 * depth-first order, and boxes are finite. Does not read blocks. */

#include "../format/block.h"
#include "record.h"

namespace cvert {
/*! Passes the tree to a Sink, which defines
 *
 *    typedef Ref                                                        reference to a node or a block
 *    Ref leaf (FileChild type, uint64_t offset)                         a block; offset: from FileGeometry::blocks
 *    Node* beginNode ()                                                 before the children of a node are read
 *    void setChild (Node*, unsigned i, lower, upper, Ref)               child i with its box
 *    Ref endNode (Node*)
 *    void entry (const FileEntry&, Ref)                                 an entry of a list
 *
 *  Sinks may throw. */
template<typename Sink>
class TreeReader {
public:
  /*! Nodes on a path from the root. Limits the recursion. */
  static const unsigned maxDepth = 40;

  TreeReader(const FileGeometry& record, const char* tree, Sink& sink) : record(record), tree(tree), sink(sink) {}

  /*! Returns the first error; the sink may then have received a part of the tree. root: receives the reference to the
   *  root, unless the geometry has a list. */
  Reason read(typename Sink::Ref& root) {
    if (record.treeChecksum != fileChecksum(tree, size_t(record.treeBytes)))
      return Reason::damaged("the checksum of its tree differs");
    if (record.form == FILE_TREE) {
      root = node(0, 1);
      if (!reason && numRead * sizeof(FileNode) != record.treeBytes)
        fail("its tree has % nodes that no other node refers to", record.treeBytes / sizeof(FileNode) - numRead);
    } else readList();
    if (!reason && numBlocks != record.numBlocks)
      fail("its tree has % leaves: expected %, one for each block", numBlocks, record.numBlocks);
    return reason;
  }

  uint64_t numNodes() const { return numRead; }

private:
  typedef typename Sink::Ref Ref;

  Ref fail(const char* text, uint64_t first = 0, uint64_t second = 0) {
    reason = Reason::damaged(text, first, second);
    return Ref();
  }

  Ref leaf(uint64_t child) {
    const uint64_t type = child & FILE_CHILD_MASK, offset = child & ~uint64_t(FILE_CHILD_MASK);
    const bool moves = record.form == FILE_MOVING;
    if (!isKnownBlock(blockTypeOf(FileChild(type), moves), moves))
      return fail(moves ? "a leaf of its tree has type %: expected 4 or 6"
                        : "a leaf of its tree has type %: expected 2, 3 or 5",
                  type);
    if (offset < next) return fail("a leaf of its tree refers to a block at %: expected % or later", offset, next);
    if (offset > record.blockBytes || record.blockBytes - offset < vertHeaderBytes)
      return fail("a leaf of its tree refers to a block at %: its blocks have % bytes", offset, record.blockBytes);
    next = offset + 1;
    numBlocks++;
    return sink.leaf(FileChild(type), offset);
  }

  Ref node(uint64_t offset, unsigned depth) {
    if (offset != numRead * sizeof(FileNode))
      return fail("a node of its tree refers to a node at %: expected %", offset, numRead * sizeof(FileNode));
    if (offset >= record.treeBytes)
      return fail("a node of its tree refers to a node at %: its tree has % bytes", offset, record.treeBytes);
    if (depth > maxDepth) return fail("its tree is deeper than % nodes", maxDepth);
    numRead++;
    const FileNode& from = ((const FileNode*)tree)[offset / sizeof(FileNode)];
    auto* const to = sink.beginNode();
    for (unsigned i = 0; i < 4; i++) {
      const uint64_t child = from.children[i];
      if (child == FILE_NONE) continue;
      float lower[3], upper[3];
      for (int k = 0; k < 3; k++) {
        lower[k] = from.planes[k][0][i];
        upper[k] = from.planes[k][1][i];
      }
      if (!areBounds(lower, upper))
        return fail("the node at % of its tree has a box that is empty or not finite", offset);
      const Ref ref =
          (child & FILE_CHILD_MASK) == FILE_NODE ? node(child & ~uint64_t(FILE_CHILD_MASK), depth + 1) : leaf(child);
      if (reason) return Ref();
      sink.setChild(to, i, lower, upper, ref);
    }
    return sink.endNode(to);
  }

  void readList() {
    const FileEntry* const entries = (const FileEntry*)tree;
    for (uint64_t i = 0; i < record.treeBytes / sizeof(FileEntry) && !reason; i++) {
      if (record.form != FILE_MOVING && !areBounds(entries[i].lower, entries[i].upper)) {
        fail("entry % of its list has a box that is empty or not finite", i);
        return;
      }
      const Ref ref = leaf(entries[i].child);
      if (!reason) sink.entry(entries[i], ref);
    }
  }

  const FileGeometry& record;
  const char* const tree;
  Sink& sink;
  Reason reason;
  uint64_t next = 0; //!< lowest valid offset of the next block
  uint64_t numBlocks = 0;
  uint64_t numRead = 0; //!< nodes
};

/*! Calls visit(type,offset) for each block in the order of the file. Returns the tree's first error. */
template<typename Visit>
Reason forEachBlock(const FileGeometry& record, const char* tree, const Visit& visit) {
  struct Sink {
    typedef int Ref;
    const Visit& visit;

    Ref leaf(FileChild type, uint64_t offset) {
      visit(type, offset);
      return 0;
    }
    Sink* beginNode() { return this; }
    void setChild(Sink*, unsigned, const float*, const float*, Ref) {}
    Ref endNode(Sink*) { return 0; }
    void entry(const FileEntry&, Ref) {}
  } sink = {visit};
  int root;
  return TreeReader<Sink>(record, tree, sink).read(root);
}
} // namespace cvert
