// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes a file of compressed surfaces (format.h), which replaces an existing file in one step when complete. */

#include "../portable/reason.h"
#include "format.h"
#include "unfinished_file.h"
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace cvert {
/*! A geometry to write: its record, tree and blocks. */
class FileSurface {
public:
  /*! The caller sets form, source, compression, numPrimitives, numTimeSteps, begin and end; lower and upper, unless
   *  it calls appendToList(); optionally measures and counts. The writer sets the rest. */
  FileGeometry record = FileGeometry();

  std::vector<char> tree; //!< array of FileNode (FILE_TREE) or FileEntry (FILE_LIST and FILE_MOVING)

  struct Block {
    const void* data; //!< valid until the surface is written
    uint32_t bytes;
    uint32_t surfaceOffset; //!< of the surface number in the block
  };
  std::vector<Block> blocks;

  /*! Appends a block, which must remain valid until the surface is written. type: neither FILE_NONE nor FILE_NODE.
   *  Returns the child for a FileNode or FileEntry. Blocks must have the order of the tree. */
  uint64_t append(FileChild type, const void* data, uint32_t bytes, uint32_t surfaceOffset);

  /*! Calls append() for a cVERT block, adds it to the list, and extends the record's bounds by its vertices; the
   *  first block replaces them. Throws Error if record.form is not FILE_LIST or FILE_MOVING, or if the block is
   *  damaged, unsupported, contradicts the record, or has no finite vertex. bytes: size of the block; vertReadPadding
   *  bytes after it must be readable. */
  void appendToList(const void* block, uint32_t bytes);

  /*! Returns a copy of a block that is valid as long as the surface, for append(). Readers of blocks may read
   *  vertReadPadding bytes after it. */
  const void* keep(const void* block, size_t bytes);

private:
  friend class FileWriter;

  std::vector<std::unique_ptr<char[]>> kept;
  uint64_t blockBytes = 0;                  //!< of the blocks, with alignment
  uint32_t vertVersion = vertFormatVersion; //!< newest version of its blocks
};

/*! One thread at a time may use a writer. Functions throw Error. After an error during writing, add() and commit()
 *  throw again. If only the renaming fails, commit() can be called again. */
class FileWriter {
public:
  /*! Starts a file. Throws if `path` is a folder, a device, a pipe or an open descriptor, or cannot be written. */
  explicit FileWriter(const std::string& path);

  /*! Starts a file, or continues one that a writer with the same key did not commit. key: identifies the source of
   *  the geometries. Throws as above, or if the unfinished file has another key or version, is damaged, is of
   *  another kind, or is open in another writer. */
  FileWriter(const std::string& path, uint64_t key);

  /*! With a key, tries to write a checkpoint of all geometries, and keeps a file that has a checkpoint. Deletes other
   *  uncommitted files. */
  ~FileWriter();

  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /*! Throws if the file was committed or could not be written earlier. */
  void requireOpen() const;

  /*! Writes a geometry, and completes its record. Throws if the record is invalid or writing fails. Does not validate
   *  tree and blocks. */
  void add(FileSurface& surface);

  /*! Flushes the file and renames it to its path. Requires a geometry. */
  void commit();

  /*! Includes geometries of earlier writers. */
  size_t size() const { return directory.size(); }

private:
  /*! With a key, add() first writes a checkpoint (the directory) if this many bytes follow the last one. A killed
   *  process loses the geometries after its last checkpoint. */
  static const uint64_t checkpointInterval = uint64_t(64) << 20;

  /*! suffix: of the unfinished file if another writer may continue it, else empty. */
  void open(const std::string& suffix);

  void begin();

  /*! Continues the geometries of an earlier writer, or starts an empty file if there are none. */
  void resume();

  /*! Appends the directory, and writes the header that refers to it. */
  void writeDirectory();

  void writeBlocks(FileSurface& surface);
  void write(const void* data, size_t bytes);
  void padTo(uint64_t alignment);
  [[noreturn]] void fail(const std::string& what);
  [[noreturn]] void failToWrite(int error);

  /*! The number is unique in the file. */
  uint32_t chooseSurfaceNumber(const FileGeometry& record);

  const std::string path;
  std::unique_ptr<UnfinishedFile> file; //!< null after commit
  const bool isResumable;               //!< has a key: another writer may continue the file
  bool failed = false;
  uint64_t key = 0;
  uint64_t writtenBytes = 0;                //!< bytes in the file
  uint64_t checkpointedBytes = 0;           //!< bytes at the last writeDirectory(), 0 if none: resume() keeps them
  uint32_t vertVersion = vertFormatVersion; //!< newest version of all surfaces
  std::vector<FileGeometry> directory;
  std::set<uint32_t> numbers; //!< surface numbers, without their two highest bits
};
} // namespace cvert
