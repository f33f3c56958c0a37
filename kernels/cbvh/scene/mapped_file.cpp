// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "mapped_file.h"
#include "../base/primitive_type.h"
#include "../base/thread_cache.h"
#include "../embree/scene.h"
#include "file_record.h"
#include "mapped_blocks.h"
#include "surface_blocks.h"
#include "tree.h"
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <functional>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace embree
{
  namespace cbvh
  {
    namespace
    {
      [[noreturn]] void refuse (const std::string& path, const std::string& why) { throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,path + ": " + why); }

      /*! the begin of what is wrong with a geometry */
      std::string damaged (size_t geometry) { return "is damaged: geometry " + std::to_string(geometry) + ": "; }

      const char* kindOfFile (mode_t mode) {
        return S_ISDIR(mode) ? "a folder" : S_ISFIFO(mode) ? "a pipe" : S_ISSOCK(mode) ? "a socket" : "a device";
      }

      /*! pages of a file that its own file writes into, each when it is written into */
      struct PrivatePages
      {
        char* const data;
        const size_t bytes;

        PrivatePages (int file, uint64_t offset, size_t bytes)
          : data((char*)::mmap(nullptr,bytes,PROT_READ | PROT_WRITE,MAP_PRIVATE | MAP_NORESERVE,file,off_t(offset))), bytes(bytes) {
          if (data == MAP_FAILED) throw std::bad_alloc();
        }
        ~PrivatePages () { ::munmap(data,bytes); }
      };

      /*! the file that the blocks of a geometry need, and pages of their own if they have any */
      struct FileAndPages
      {
        std::shared_ptr<const MappedFile> file;
        std::unique_ptr<PrivatePages> pages;
      };
    }

    /* Without O_NONBLOCK a FIFO would wait for its writer. */
    MappedFile::MappedFile (const std::string& path)
      : path(path), file(::open(path.c_str(),O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC))
    {
      if (file < 0) refuse(path,std::string("cannot be opened: ") + std::strerror(errno));
      std::string error;
      struct stat status;
      if (::fstat(file,&status) != 0) error = std::strerror(errno);
      else if (!S_ISREG(status.st_mode))
        error = std::string("is ") + kindOfFile(status.st_mode) + ": expected a regular file";
      else if (size_t(status.st_size) < sizeof(FileHeader)) error = "is no file of compressed surfaces: it has only " + std::to_string(status.st_size) + " bytes";
      else {
        bytes = size_t(status.st_size);
        void* const mapped = ::mmap(nullptr,bytes,PROT_READ,MAP_PRIVATE,file,0);
        if (mapped == MAP_FAILED) { error = std::string("cannot be mapped: ") + std::strerror(errno); bytes = 0; }
        else {
          data = (const char*)mapped;
          error = errorOf();
        }
      }
      if (error.empty()) return;
      if (data) ::munmap((void*)data,bytes);
      ::close(file);
      refuse(path,error);
    }

    MappedFile::~MappedFile ()
    {
      ::munmap((void*)data,bytes);
      ::close(file);
    }

    std::string MappedFile::errorOf () const
    {
      const FileHeader& h = *header();
      auto version = [](const char* of, uint32_t found, uint32_t ours) {
        return std::string("is of a") + (found > ours ? " newer" : "n older") + " version of " + of + ", " + std::to_string(found) + "; this library reads " + std::to_string(ours);
      };
      if (memcmp(h.magic,fileMagic,sizeof(fileMagic)) != 0) return "is no file of compressed surfaces";
      if (h.byteOrder != fileByteOrder) return "was written by a machine with another order of bytes, or is damaged";
      if (h.version != fileVersion) return version("these files",h.version,fileVersion);
      if (h.checksum != fileChecksum(&h,offsetof(FileHeader,checksum))) return "is damaged: the header's checksum is another";
      if (h.vertVersion != vertFormatVersion) return version("cVERT",h.vertVersion,vertFormatVersion);
      if (h.framedVersion != formatVersion) return version("blocks with frames",h.framedVersion,formatVersion);
      if (h.fileBytes != bytes) return (h.fileBytes > bytes ? "is truncated: it has " : "has something behind its end: it has ") + std::to_string(bytes) + " bytes of " + std::to_string(h.fileBytes);
      if (h.recordBytes != sizeof(FileGeometry) || h.numGeometries == 0 || h.directory > bytes || h.directory % 16 != 0 || (bytes-h.directory)/sizeof(FileGeometry) < h.numGeometries)
        return "is damaged: its directory is none";
      if (h.directoryChecksum != fileChecksum(data+h.directory,h.numGeometries*sizeof(FileGeometry))) return "is damaged: the directory's checksum is another";
      for (size_t i=0; i<h.numGeometries; i++) {
        const std::string error = errorOf(geometry(i));
        if (!error.empty()) return damaged(i) + error;
      }
      return std::string();
    }

    std::string MappedFile::errorOf (const FileGeometry& g) const
    {
      auto isPart = [&](uint64_t begin, uint64_t size, uint64_t behind) {
        return begin % filePage == 0 && begin <= bytes && size <= bytes-begin && behind <= bytes-begin-size;
      };
      if (!isPart(g.tree,g.treeBytes,0) || !isPart(g.blocks,g.blockBytes,fileReadBehind)) return "parts outside of the file";
      return errorOfRecord(g);
    }

    /*! Makes the tree of a geometry of what the file has. */
    class SurfaceLoader
    {
    public:
      SurfaceLoader (const MappedFile& file, const FileGeometry& record, size_t i, const MappedBlocks& mapped, SurfaceBlocks& surface)
        : path(file.path), name(damaged(i)), record(record), tree(file.data+record.tree), mapped(mapped), surface(surface) {}

      void run ()
      {
        if (record.treeChecksum != fileChecksum(tree,size_t(record.treeBytes))) fail("the tree's checksum is another");
        if (record.form == FILE_TREE) loadTree();
        else loadList();
        if (numBlocks != record.numBlocks) fail("more leaves than blocks");
      }

    private:
      [[noreturn]] void fail (const std::string& why) const { refuse(path,name + why); }

      /*! a block, which comes behind those before it */
      BVH4::NodeRef leaf (uint64_t child)
      {
        const uint64_t type = child & FILE_CHILD_MASK, offset = child & ~uint64_t(FILE_CHILD_MASK);
        const bool moves = record.form == FILE_MOVING;
        if (moves ? type != FILE_MOVING_VERT : type != FILE_VERT && type != FILE_FRAMED) fail("a leaf that is none");
        if (offset < next || offset > record.blockBytes || record.blockBytes-offset < vertHeaderBytes) fail("a leaf without a block");
        next = offset+1;
        numBlocks++;
        /* its boxes are decoded at once */
        if (moves) {
          if (const char* error = mapped.errorOf(size_t(offset),true,true)) fail("the block at " + std::to_string(offset) + ": " + error);
          mapped.number(size_t(offset),true);
        }
        return BVH4::encodeTypedLeaf((void*)(mapped.first()+offset),moves ? MOVING_VERT_BLOCK : type == FILE_VERT ? VERT_BLOCK : FRAMED_BLOCK);
      }

      void loadTree ()
      {
        const size_t nodes = size_t(record.treeBytes/sizeof(FileNode));
        surface.memory.expect(nodes*sizeof(BVH4::AABBNode));
        surface.root = node(0,1);
        if (used != nodes) fail("nodes that no other has");
        surface.root = isa::moveLargestNodes(surface.root,nodes,*surface.memory.pool());
        isa::TreeCutter(surface.parts).cut(surface.root,surface.bounds);
      }

      /*! Nodes come in the order in which they are met: so each has one above it, and none is above itself. */
      BVH4::NodeRef node (uint64_t offset, size_t depth)
      {
        if (offset != used*sizeof(FileNode) || offset >= record.treeBytes) fail("a node in another place");
        if (depth > BVH4::maxBuildDepthLeaf) fail("nodes below more others than a tree has");
        used++;
        const FileNode& from = ((const FileNode*)tree)[offset/sizeof(FileNode)];
        BVH4::AABBNode* const to = (BVH4::AABBNode*)surface.memory.pool()->getCachedAllocator().malloc0(sizeof(BVH4::AABBNode),BVH4::byteNodeAlignment);
        to->clear();
        for (size_t i=0; i<4; i++)
        {
          const uint64_t child = from.children[i];
          if (child == FILE_NONE) continue;
          float lower[3], upper[3];
          for (int k=0; k<3; k++) { lower[k] = from.planes[k][0][i]; upper[k] = from.planes[k][1][i]; }
          if (!areBounds(lower,upper)) fail("bounds that are none");
          to->setBounds(i,BBox3fa(Vec3fa(lower[0],lower[1],lower[2]),Vec3fa(upper[0],upper[1],upper[2])));
          to->setRef(i,(child & FILE_CHILD_MASK) == FILE_NODE ? node(child & ~uint64_t(FILE_CHILD_MASK),depth+1) : leaf(child));
        }
        return BVH4::encodeNode(to);
      }

      void loadList ()
      {
        const FileEntry* const entries = (const FileEntry*)tree;
        const size_t n = size_t(record.treeBytes/sizeof(FileEntry));
        for (size_t i=0; i<n; i++)
        {
          const FileEntry& entry = entries[i];
          const size_t ref = leaf(entry.child);
          if (record.form == FILE_MOVING) { surface.moving.push_back(ref); continue; }
          if (!areBounds(entry.lower,entry.upper)) fail("bounds that are none");
          surface.parts.push_back(PrimRef(BBox3fa(Vec3fa(entry.lower[0],entry.lower[1],entry.lower[2]),Vec3fa(entry.upper[0],entry.upper[1],entry.upper[2])),ref));
        }
      }

      const std::string path, name;
      const FileGeometry& record;
      const char* const tree;
      const MappedBlocks& mapped;
      SurfaceBlocks& surface;
      uint64_t next = 0;    //!< where a block may begin
      uint64_t numBlocks = 0;
      uint64_t used = 0;    //!< nodes
    };

    std::shared_ptr<const SurfaceBlocks> MappedFile::load (const std::shared_ptr<const MappedFile>& file, Device* device, size_t i)
    {
      const FileGeometry& record = file->geometry(i);
      const uint32_t moving = record.surface & movingSurface;
      const std::shared_ptr<const SurfaceNumber> number = numberOfFile(record.surface & ~movingSurface);
      const std::shared_ptr<SurfaceBlocks> surface = std::make_shared<SurfaceBlocks>(device,number);
      MappedBlocks::Limits limits;
      limits.surface = record.surface;
      limits.number = *number | moving;
      limits.numPrimitives = record.numPrimitives;
      limits.numTimeSteps = record.numTimeSteps;
      limits.begin = record.begin;
      limits.end = record.end;

      /* a second surface of the same blocks has pages of its own, where its number is written into them */
      std::shared_ptr<FileAndPages> memory = std::make_shared<FileAndPages>();
      memory->file = file;
      char* first = (char*)file->data + record.blocks;
      if (limits.number != limits.surface && record.blockBytes) {
        memory->pages.reset(new PrivatePages(file->file,record.blocks,size_t(record.blockBytes+fileReadBehind)));
        first = memory->pages->data;
      }
      const std::shared_ptr<const MappedFile> owner(memory,file.get());
      const std::shared_ptr<const MappedBlocks> mapped = std::make_shared<MappedBlocks>(device,owner,first,size_t(record.blockBytes),limits,file->path + ": geometry " + std::to_string(i));
      surface->mapped = mapped;
      const bool isEmpty = !areBounds(record.lower,record.upper);
      surface->bounds = isEmpty ? BBox3fa(empty) : BBox3fa(Vec3fa(record.lower[0],record.lower[1],record.lower[2]),Vec3fa(record.upper[0],record.upper[1],record.upper[2]));
      surface->numPrimitives = size_t(record.numBlocks);
      surface->statistics = statisticsOf(record);
      SurfaceLoader(*file,record,i,*mapped,*surface).run();
      surface->memory.end();
      outdateThreadCaches(); // others may have lain here
      return surface;
    }

    void MappedFile::verifyAll (const std::shared_ptr<const MappedFile>& file, Device* device)
    {
      for (size_t i=0; i<file->size(); i++)
      {
        const FileGeometry& record = file->geometry(i);
        const std::string name = damaged(i);
        if (record.blocksChecksum != fileChecksum(file->data+record.blocks,size_t(record.blockBytes))) refuse(file->path,name + "the blocks' checksum is another");
        const std::shared_ptr<const SurfaceBlocks> surface = load(file,device,i);
        if (record.form == FILE_MOVING) continue; // each block was looked at
        const FileChild none = FILE_NONE;
        auto check = [&](uint64_t child) {
          const uint64_t type = child & FILE_CHILD_MASK;
          if (child == none || type == FILE_NODE) return;
          const size_t offset = size_t(child & ~uint64_t(FILE_CHILD_MASK));
          if (const char* error = surface->mapped->errorOf(offset,type == FILE_VERT,false)) refuse(file->path,name + "the block at " + std::to_string(offset) + ": " + error);
        };
        const char* const tree = file->data+record.tree;
        if (record.form == FILE_LIST)
          for (size_t k=0; k<record.treeBytes/sizeof(FileEntry); k++) check(((const FileEntry*)tree)[k].child);
        else
          for (size_t k=0; k<record.treeBytes/sizeof(FileNode); k++)
            for (uint64_t child : ((const FileNode*)tree)[k].children) check(child);
      }
    }
  }
}
