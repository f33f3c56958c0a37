// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "file_writer.h"
#include "../base/mapped_blocks.h"
#include "../base/primitive_type.h"
#include "../embree/scene.h"
#include "block_bytes.h"
#include "file_record.h"
#include "surface_blocks.h"
#include <cerrno>
#include <cstring>

namespace embree
{
  namespace cbvh
  {
    namespace
    {
      /*! The tree of a surface as a file has it, and its blocks in the file's order. */
      class Layout
      {
      public:
        std::vector<char> tree;
        std::vector<const void*> blocks;
        std::vector<uint64_t> offsets; //!< of each, and the end
        std::vector<bool> isVert;      //!< of each

        Layout (const SurfaceBlocks& surface, bool moves)
        {
          offsets.push_back(0);
          form = moves ? FILE_MOVING : surface.root != BVH4::emptyNode ? FILE_TREE : FILE_LIST;
          if (form == FILE_TREE) node(surface.root);
          if (form == FILE_LIST)
            for (const PrimRef& part : surface.parts) entry(part.bounds(),BVH4::NodeRef(part.ID()));
          if (form == FILE_MOVING)
            for (size_t ref : surface.moving) entry(BBox3fa(Vec3fa(zero),Vec3fa(zero)),BVH4::NodeRef(ref));
        }

        FileForm form;

      private:
        uint64_t leaf (BVH4::NodeRef ref)
        {
          size_t type;
          const void* const block = ref.leaf(type);
          if (!isBlock(type))
            throw_RTCError(RTC_ERROR_INVALID_OPERATION,"a part of the geometry is left to GRID, for its edge rates or because it has no good frame: only compressed blocks can be saved, which cVERT has of all");
          const bool moves = type == MOVING_VERT_BLOCK, vert = type != FRAMED_BLOCK;
          if (!moves && !isUsable(block,vert))
            throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry's own file is damaged: one of its blocks is none");
          const uint64_t begin = offsets.back();
          blocks.push_back(block);
          isVert.push_back(vert);
          offsets.push_back((begin + bytesOfBlock(block,vert) + blockAlignment-1) & ~uint64_t(blockAlignment-1));
          return begin | (moves ? FILE_MOVING_VERT : vert ? FILE_VERT : FILE_FRAMED);
        }

        uint64_t child (BVH4::NodeRef ref)
        {
          if (ref == BVH4::emptyNode) return FILE_NONE;
          return ref.isLeaf() ? leaf(ref) : node(ref);
        }

        uint64_t node (BVH4::NodeRef ref)
        {
          const BVH4::AABBNode* const from = ref.getAABBNode();
          const size_t begin = tree.size();
          tree.resize(begin + sizeof(FileNode));
          FileNode to;
          const vfloat4* const planes[3][2] = { { &from->lower_x,&from->upper_x },{ &from->lower_y,&from->upper_y },{ &from->lower_z,&from->upper_z } };
          for (size_t i=0; i<4; i++) {
            to.children[i] = child(from->child(i));
            for (int k=0; k<3; k++)
              for (int side=0; side<2; side++) to.planes[k][side][i] = to.children[i] == FILE_NONE ? 0.0f : (*planes[k][side])[i];
            if (to.children[i] == FILE_NONE) continue;
            float lower[3], upper[3];
            for (int k=0; k<3; k++) { lower[k] = to.planes[k][0][i]; upper[k] = to.planes[k][1][i]; }
            requireBounds(lower,upper);
          }
          memcpy(tree.data()+begin,&to,sizeof(to));
          return begin | FILE_NODE;
        }

        /*! files with others are not loaded */
        static void requireBounds (const float lower[3], const float upper[3]) {
          if (areBounds(lower,upper)) return;
          throw_RTCError(RTC_ERROR_INVALID_OPERATION,"blocks without finite bounds cannot be saved");
        }

        void entry (const BBox3fa& bounds, BVH4::NodeRef ref)
        {
          if (!ref.isLeaf()) throw_RTCError(RTC_ERROR_UNKNOWN,"a list of blocks has a node");
          FileEntry to;
          for (int k=0; k<3; k++) { to.lower[k] = bounds.lower[k]; to.upper[k] = bounds.upper[k]; }
          requireBounds(to.lower,to.upper);
          to.child = leaf(ref);
          tree.insert(tree.end(),(const char*)&to,(const char*)(&to+1));
        }
      };

      uint32_t sourceOf (const CompressibleGeometry* geometry)
      {
        switch (geometry->ownType) {
        case Geometry::GTY_GRID_MESH: return FILE_GRIDS;
        case Geometry::GTY_QUAD_MESH: return FILE_QUADS;
        case Geometry::GTY_TRIANGLE_MESH: return FILE_TRIANGLES;
        default: return FILE_CAGE;
        }
      }
    }

    void FileWriter::open (const std::string& ending)
    {
      if (path.empty()) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"path is empty");
      std::string name = path;
      try
      {
        const OutputPath place(path);
        if (place.kind == OutputPath::STREAM)
          throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                         path + ": is a device, a pipe or open already: compressed surfaces need a regular file");
        name = place.path + ending;
        file.reset(ending.empty() ? new UnfinishedFile(place) : new UnfinishedFile(place,ending));
      }
      catch (const std::system_error& error)
      {
        const bool isTaken = error.code().value() == EWOULDBLOCK;
        if (isTaken) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,name + ": another writer has it");
        throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,name + ": cannot be written: " + error.code().message());
      }
    }

    FileWriter::FileWriter (const std::string& path) : path(path), keeps(false)
    {
      open("");
      begin();
    }

    FileWriter::FileWriter (const std::string& path, uint64_t key) : path(path), keeps(true), key(key)
    {
      open(".part");
      resume();
    }

    FileWriter::~FileWriter ()
    {
      if (!file || !keeps) return;
      try { if (!failed && !directory.empty() && at != saved) writeDirectory(); }
      catch (...) {} // what was saved before is still there
      file->keep(saved != 0);
    }

    void FileWriter::begin ()
    {
      file->takeOver();
      const FileHeader none = FileHeader();
      write(&none,sizeof(none));
      padTo(filePage);
    }

    void FileWriter::resume ()
    {
      const int part = file->descriptor();
      auto refuse = [&](const std::string& why) {
        throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,file->path() + ": " + why);
      };
      struct stat status;
      if (::fstat(part,&status) != 0 || !S_ISREG(status.st_mode)) refuse("is not a regular file");
      FileHeader header = FileHeader();
      const FileHeader none = FileHeader();
      if (::pread(part,&header,sizeof(header),0) != ssize_t(sizeof(header)) || memcmp(&header,&none,sizeof(none)) == 0)
      {
        /* nothing was saved in it, unless it is another's */
        if (memcmp(&header,&none,sizeof(none)) != 0) refuse("is no file of compressed surfaces");
        if (::ftruncate(part,0) != 0) refuse(std::string("cannot be written: ") + std::strerror(errno));
        return begin();
      }
      const std::string anew = "; without it the file is begun anew";
      if (memcmp(header.magic,fileMagic,sizeof(fileMagic)) != 0) refuse("is no file of compressed surfaces");
      if (header.byteOrder != fileByteOrder || header.version != fileVersion || header.vertVersion != vertFormatVersion || header.framedVersion != formatVersion)
        refuse("was begun by another version of the library" + anew);
      const uint64_t count = header.numGeometries;
      if (header.checksum != fileChecksum(&header,offsetof(FileHeader,checksum)) || header.recordBytes != sizeof(FileGeometry) || header.fileBytes > uint64_t(status.st_size) ||
          header.directory > header.fileBytes || header.fileBytes-header.directory != count*sizeof(FileGeometry))
        refuse("is damaged" + anew);
      if (header.key[0] != uint32_t(key) || header.key[1] != uint32_t(key >> 32)) refuse("was begun with something else" + anew);
      directory.resize(size_t(count));
      const size_t bytes = directory.size()*sizeof(FileGeometry);
      const bool isRead = ::pread(part,directory.data(),bytes,off_t(header.directory)) == ssize_t(bytes);
      if (!isRead || header.directoryChecksum != fileChecksum(directory.data(),bytes)) refuse("is damaged" + anew);
      for (const FileGeometry& record : directory) numbers.insert(record.surface & ~(firstFileNumber | movingSurface));
      at = saved = header.fileBytes;
      if (::ftruncate(part,off_t(at)) != 0 || ::lseek(part,off_t(at),SEEK_SET) < 0)
        refuse(std::string("cannot be written: ") + std::strerror(errno));
    }

    void FileWriter::fail (const std::string& what)
    {
      failed = true;
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": " + what);
    }

    void FileWriter::write (const void* data, size_t bytes)
    {
      const int error = writeAll(file->descriptor(),data,bytes);
      if (error) fail(std::string("cannot be written: ") + std::strerror(error));
      at += bytes;
    }

    void FileWriter::padTo (uint64_t alignment)
    {
      static const char zeros[filePage] = {};
      if (at % alignment) write(zeros,size_t(alignment - at % alignment));
    }

    uint32_t FileWriter::numberOf (const FileGeometry& record, bool moves)
    {
      /* the same file for the same surface; for others most likely another number */
      const uint32_t count = firstFileNumber-1; // the last number with bit 31 is no surface's
      uint32_t number = fileChecksum(&record,sizeof(record)) % count;
      while (!numbers.insert(number).second) number = (number+1) % count;
      return number | firstFileNumber | (moves ? movingSurface : 0);
    }

    void FileWriter::add (const CompressibleGeometry* geometry, const SurfaceBlocks& surface)
    {
      if (!file) throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": was committed");
      if (failed) throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": could not be written before");
      const Layout layout(surface,geometry->numTimeSteps != 1);
      if (keeps && at-saved >= checkpointBytes) writeDirectory();
      padTo(filePage); // behind a directory
      FileGeometry record = FileGeometry();
      record.form = layout.form;
      record.source = sourceOf(geometry);
      record.numPrimitives = geometry->numPrimitives;
      record.numTimeSteps = geometry->numTimeSteps;
      record.begin = geometry->time_range.lower;
      record.end = geometry->time_range.upper;
      record.compression = layout.form == FILE_MOVING || record.source != FILE_CAGE ? RTC_COMPRESSION_VERT : geometry->compression.resolve(geometry->device->compression).compression;
      for (int k=0; k<3; k++) { record.lower[k] = surface.bounds.lower[k]; record.upper[k] = surface.bounds.upper[k]; }
      record.numBlocks = layout.blocks.size();
      setStatistics(record,surface.statistics);
      record.treeBytes = layout.tree.size();
      record.blockBytes = layout.offsets.back();
      record.treeChecksum = fileChecksum(layout.tree.data(),layout.tree.size());
      record.surface = numberOf(record,layout.form == FILE_MOVING);
      const std::string error = errorOfRecord(record);
      if (!error.empty())
        throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry cannot be saved: its record would have " + error);

      record.tree = at;
      write(layout.tree.data(),layout.tree.size());
      padTo(filePage);
      record.blocks = at;
      std::vector<char> piece;
      auto flush = [&] {
        record.blocksChecksum = fileChecksum(piece.data(),piece.size(),record.blocksChecksum);
        write(piece.data(),piece.size());
        piece.clear();
      };
      for (size_t i=0; i<layout.blocks.size(); i++)
      {
        const size_t begin = piece.size();
        const bool vert = layout.isVert[i];
        piece.resize(begin + size_t(layout.offsets[i+1]-layout.offsets[i]));
        memcpy(piece.data()+begin,layout.blocks[i],bytesOfBlock(layout.blocks[i],vert));
        memcpy(piece.data()+begin + (vert ? offsetof(VertHeader,surface) : offsetof(BlockHeader,surface)),&record.surface,sizeof(record.surface));
        if (piece.size() >= size_t(1) << 20) flush();
      }
      flush();
      const uint64_t end = at;
      padTo(filePage);
      if (at-end < fileReadBehind) { const char zeros[fileReadBehind] = {}; write(zeros,sizeof(zeros)); padTo(filePage); }
      directory.push_back(record);
      /* so that the next checkpoint need not wait */
      if (keeps) (void)!::sync_file_range(file->descriptor(),off_t(saved),0,SYNC_FILE_RANGE_WRITE);
    }

    void FileWriter::writeDirectory ()
    {
      FileHeader header = FileHeader();
      memcpy(header.magic,fileMagic,sizeof(header.magic));
      header.byteOrder = fileByteOrder;
      header.version = fileVersion;
      header.vertVersion = vertFormatVersion;
      header.framedVersion = formatVersion;
      header.numGeometries = uint32_t(directory.size());
      header.recordBytes = sizeof(FileGeometry);
      header.directory = at;
      const size_t bytes = directory.size()*sizeof(FileGeometry);
      header.directoryChecksum = fileChecksum(directory.data(),bytes);
      write(directory.data(),bytes);
      header.fileBytes = at;
      header.key[0] = uint32_t(key);
      header.key[1] = uint32_t(key >> 32);
      header.checksum = fileChecksum(&header,offsetof(FileHeader,checksum));
      /* where the file may be gone on with, a header is only of what is on the disk */
      int error = keeps && ::fsync(file->descriptor()) != 0 ? errno : 0;
      if (!error) error = writeAllAt(file->descriptor(),&header,sizeof(header),0);
      if (!error && ::fsync(file->descriptor()) != 0) error = errno;
      if (error) fail(std::string("cannot be written: ") + std::strerror(error));
      saved = at;
    }

    void FileWriter::commit ()
    {
      if (!file) throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": was committed");
      if (failed) throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": could not be written before");
      if (directory.empty()) fail("no geometry was added");
      if (at != saved) writeDirectory();
      try { file->commit(); }
      catch (const std::system_error& error) {
        throw_RTCError(RTC_ERROR_INVALID_OPERATION,path + ": cannot be written: " + error.code().message());
      }
      file.reset();
    }
  }
}
