// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes a file of compressed surfaces, one surface after the other. The file receives its name in one step when it is
 * complete. Until then an existing file of that name is unchanged. */

#include "../basics/reason.h"
#include "format.h"
#include "unfinished_file.h"
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace cvert
{
  /*! A geometry to be written: its record, tree and blocks. */
  class FileSurface
  {
  public:
    /*! The caller sets form, source, compression, numPrimitives, numTimeSteps, begin, end, lower, upper and,
     *  optionally, statistics. The writer sets the rest. */
    FileGeometry record = FileGeometry();

    std::vector<char> tree;  //!< FileNode or FileEntry, by record.form

    struct Block
    {
      const void* data;      //!< must remain valid until the surface is written
      uint32_t bytes;
      uint32_t surface;      //!< offset of its surface number
    };
    std::vector<Block> blocks;

    /*! Appends a block. type: FILE_FRAMED, FILE_VERT, FILE_MOVING_VERT or FILE_MESH. surface: offset in the block of
     *  its surface number. Returns the child that refers to the block. */
    uint64_t append (FileChild type, const void* data, uint32_t bytes, uint32_t surface);

    /*! Appends a cVERT block to a surface that is a list of blocks, and extends the record's bounds by the block's
     *  vertices. For callers without a tree. record.form must be FILE_LIST or FILE_MOVING. Throws Error if it is not,
     *  or if the block is damaged or has no finite vertex. block: a VertHeader and the bytes that follow it; must
     *  remain valid until the surface is written. */
    void appendToList (const void* block, uint32_t bytes);

  private:
    friend class FileWriter;

    uint64_t end = 0;        //!< size of the blocks
    bool hasMeshBlocks = false;
  };

  /*! Only one thread at a time may use a writer. Functions throw Error. After an error during writing, only the
   *  destructor may be called. */
  class FileWriter
  {
  public:
    /*! Throws if no file can be created at the path. */
    explicit FileWriter (const std::string& path);

    /*! Continues a file that a writer with a key did not commit, or starts one. key: identifies the source of the
     *  geometries. Throws if the file was started with another key, or if another process writes it. */
    FileWriter (const std::string& path, uint64_t key);

    /*! Deletes an uncommitted file. A writer with a key keeps it, so that another writer can continue it. */
    ~FileWriter ();

    FileWriter (const FileWriter&) = delete;
    FileWriter& operator= (const FileWriter&) = delete;

    /*! Throws if the writer was committed or has failed. */
    void requireOpen () const;

    /*! Appends a surface, and sets its record as in the file. */
    void add (FileSurface& surface);

    /*! Writes everything to the disk, and gives the file its name. */
    void commit ();

    /*! Number of geometries in the file, including those of earlier writers. */
    size_t size () const { return directory.size(); }

  private:
    /*! Number of bytes that may be lost if the process ends. */
    static const uint64_t checkpointBytes = uint64_t(64) << 20;

    /*! Opens the unfinished file. ending: added to the path if another writer may continue the file, else empty. */
    void open (const std::string& ending);
    void begin ();
    void resume ();

    /*! Writes the directory after the last surface, flushes both to the disk, then writes the header that refers to
     *  them. */
    void writeDirectory ();

    void writeBlocks (FileSurface& surface);
    void write (const void* data, size_t bytes);
    void padTo (uint64_t alignment);
    [[noreturn]] void fail (const std::string& what);
    [[noreturn]] void failToWrite (int error);

    /*! Returns a surface number that no other geometry of the file has. */
    uint32_t numberOf (const FileGeometry& record);

    const std::string path;
    std::unique_ptr<UnfinishedFile> file; //!< null after commit
    const bool keeps;                     //!< keeps the file if it is not committed
    bool failed = false;
    uint64_t key = 0;
    uint64_t at = 0, saved = 0;           //!< bytes written, and bytes that the header on the disk covers
    bool hasMeshBlocks = false;           //!< true if a surface with mesh blocks was added
    std::vector<FileGeometry> directory;
    std::set<uint32_t> numbers;
  };
}
