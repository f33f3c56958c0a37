// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "file.h"
#include "tree_reader.h"
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <unordered_set>
#include <vector>

namespace cvert
{
  namespace
  {
    const char* kindOfFile (mode_t mode) {
      return S_ISDIR(mode) ? "a folder" : S_ISFIFO(mode) ? "a pipe" : S_ISSOCK(mode) ? "a socket" : "a device";
    }

    Reason checkVersion (uint32_t found, uint32_t oldest, uint32_t newest, const char* tooOld, const char* tooNew)
    {
      if (found < oldest) return Reason::unsupported(tooOld,found,oldest);
      if (found > newest) return Reason::unsupported(tooNew,found,newest);
      return Reason();
    }
  }

  // O_NONBLOCK: otherwise, opening a FIFO would wait for its writer
  File::File (const std::string& path)
    : path(path), file(::open(path.c_str(),O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC))
  {
    if (file < 0) throw Error(ErrorCode::INVALID_ARGUMENT,path + ": cannot be opened: " + std::strerror(errno));
    try {
      map();
      if (const Reason reason = validate()) throw Error(reason.code,path + ": " + reason.message());
    }
    catch (...) { unmap(); throw; }
  }

  File::~File () { unmap(); }

  void File::map ()
  {
    auto fail = [&](const std::string& why) { throw Error(ErrorCode::INVALID_ARGUMENT,path + ": " + why); };
    struct stat status;
    if (::fstat(file,&status) != 0) fail(std::strerror(errno));
    if (!S_ISREG(status.st_mode)) fail(std::string("is ") + kindOfFile(status.st_mode) + ": expected a regular file");
    bytes = uint64_t(status.st_size);
    if (bytes < sizeof(FileHeader))
      fail("is not a file of compressed surfaces: it has only " + std::to_string(bytes) + " bytes");
    void* const mapped = ::mmap(nullptr,size_t(bytes),PROT_READ,MAP_PRIVATE,file,0);
    if (mapped == MAP_FAILED) fail(std::string("cannot be mapped: ") + std::strerror(errno));
    data = (const char*)mapped;
  }

  void File::unmap ()
  {
    if (data) ::munmap((void*)data,size_t(bytes));
    ::close(file);
  }

  Reason File::validate () const
  {
    const FileHeader& h = *header();
    if (memcmp(h.magic,fileMagic,sizeof(fileMagic)) != 0)
      return Reason::damaged("is not a file of compressed surfaces");
    if (h.byteOrder != fileByteOrder) return Reason::damaged("has another byte order: expected little-endian");
    if (const Reason reason = checkVersion(h.version,fileVersion,fileVersion,
          "has an older version of these files, %: this library reads % and later",
          "has a newer version of these files, %: this library reads versions up to %"))
      return reason;
    if (h.checksum != fileChecksum(&h,offsetof(FileHeader,checksum)))
      return Reason::damaged("is damaged: the checksum of its header differs");
    if (const Reason reason = checkVersion(h.vertVersion,oldestVertVersion,movingMeshFormatVersion,
          "has blocks of an older version of cVERT, %: this library reads % and later",
          "has blocks of a newer version of cVERT, %: this library reads versions up to %"))
      return reason;
    if (const Reason reason = checkVersion(h.framedVersion,fileFramedVersion,fileFramedVersion,
          "has blocks with frames of an older version, %: this library reads % and later",
          "has blocks with frames of a newer version, %: this library reads versions up to %"))
      return reason;
    if (h.fileBytes > bytes) return Reason::damaged("is truncated: it has % bytes, expected %",bytes,h.fileBytes);
    if (h.fileBytes < bytes)
      return Reason::damaged("has data after its end: it has % bytes, expected %",bytes,h.fileBytes);
    if (h.recordBytes != sizeof(FileGeometry) || h.numGeometries == 0 || h.directory > bytes || h.directory % 16 != 0
        || (bytes-h.directory)/sizeof(FileGeometry) < h.numGeometries)
      return Reason::damaged("is damaged: its directory of % geometries at % is empty, misaligned, outside of the file "
        "or of another record size",h.numGeometries,h.directory);
    if (h.directoryChecksum != fileChecksum(data+h.directory,h.numGeometries*sizeof(FileGeometry)))
      return Reason::damaged("is damaged: the checksum of its directory differs");
    std::unordered_set<uint32_t> numbers;
    for (size_t i=0; i<h.numGeometries; i++)
    {
      const FileGeometry& g = geometry(i);
      auto isPart = [&](uint64_t begin, uint64_t size, uint64_t after) {
        return begin % filePage == 0 && begin <= bytes && size <= bytes-begin && after <= bytes-begin-size;
      };
      if (!isPart(g.tree,g.treeBytes,0)) failDamaged(i,"its tree is outside of the file");
      if (!isPart(g.blocks,g.blockBytes,fileReadPadding)) failDamaged(i,"its blocks are outside of the file");
      if (const Reason reason = validateRecord(g)) fail(i,"",reason);
      if (!numbers.insert(g.surface).second) failDamaged(i,"its surface number is also another geometry's");
    }
    requireDisjointBlocks();
    return Reason();
  }

  void File::requireDisjointBlocks () const
  {
    std::vector<size_t> order;
    for (size_t i=0; i<size(); i++)
      if (geometry(i).blockBytes) order.push_back(i);
    std::sort(order.begin(),order.end(),[&](size_t a, size_t b) { return geometry(a).blocks < geometry(b).blocks; });
    for (size_t k=1; k<order.size(); k++) {
      const FileGeometry& before = geometry(order[k-1]);
      if (geometry(order[k]).blocks-before.blocks < before.blockBytes)
        failDamaged(order[k],"its blocks overlap the blocks of geometry " + std::to_string(order[k-1]));
    }
  }

  void File::fail (size_t i, const std::string& where, const Reason& reason) const
  {
    if (reason.code == ErrorCode::UNSUPPORTED) failUnsupported(i,where+reason.message());
    failDamaged(i,where+reason.message());
  }

  void File::failDamaged (size_t i, const std::string& why) const {
    throw Error(ErrorCode::DAMAGED,path + ": is damaged: geometry " + std::to_string(i) + ": " + why);
  }

  void File::failUnsupported (size_t i, const std::string& why) const {
    throw Error(ErrorCode::UNSUPPORTED,path + ": geometry " + std::to_string(i) + ": " + why);
  }

  void File::verifyGeometry (size_t i, const BlockCheck& other) const
  {
    const FileGeometry& record = geometry(i);
    if (record.blocksChecksum != fileChecksum(blocks(i),size_t(record.blockBytes)))
      failDamaged(i,"the checksum of its blocks differs");
    const Reason reason = forEachBlock(record,tree(i),[&](FileChild type, uint64_t offset) {
        if (type == FILE_FRAMED && !other) return;
        const char* const block = blocks(i)+offset;
        const size_t bytes = size_t(record.blockBytes-offset);
        Reason reason = type == FILE_FRAMED ? other(record,block,bytes)
            : isMesh(type) ? validateMeshBlock(record,block,bytes) : validateVertBlock(record,block,bytes);
        if (!reason && type != FILE_FRAMED && ((const VertHeader*)block)->surface != record.surface)
          reason = Reason::damaged("its surface number differs from its geometry's");
        if (reason) fail(i,"the block at " + std::to_string(offset) + ": ",reason);
      });
    if (reason) fail(i,"",reason);
  }
}
