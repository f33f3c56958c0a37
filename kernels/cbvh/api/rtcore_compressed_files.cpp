// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_compressed_files.h: checks pointers, calls operations/files.h, and reports
 * exceptions to the device. Errors that concern no device, such as NULL objects, are reported to the calling thread. */

#define RTC_EXPORT_API

#include "structs.h"
#include "../operations/files.h"

using namespace embree;

typedef core::CompressedFile File;
typedef core::CompressedFileWriter Writer;

RTC_NAMESPACE_BEGIN;

RTC_API bool rtcSaveCompressedGeometry(RTCGeometry hgeometry, const char* path) {
  Geometry* geometry = (Geometry*)hgeometry;
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  requireNotNull(path, "path");
  core::saveGeometry(geometry, path);
  return true;
  RTC_CATCH_END2(geometry);
  return false;
}

RTC_API RTCGeometry rtcLoadCompressedGeometry(RTCDevice hdevice, const char* path) {
  Device* device = (Device*)hdevice;
  RTC_CATCH_BEGIN;
  requireNotNull(device, "device");
  requireNotNull(path, "path");
  const File file(device, path);
  if (file.size() != 1)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, std::string(path) + ": has " + std::to_string(file.size()) +
                                                   " geometries: expected 1; use rtcOpenCompressedFile");
  return (RTCGeometry)file.load(0);
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API RTCCompressedFileWriter rtcNewCompressedFileWriter(RTCDevice hdevice, const char* path) {
  Device* device = (Device*)hdevice;
  RTC_CATCH_BEGIN;
  requireNotNull(device, "device");
  requireNotNull(path, "path");
  return (RTCCompressedFileWriter) new Writer(device, path);
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API RTCCompressedFileWriter rtcResumeCompressedFileWriter(RTCDevice hdevice, const char* path,
                                                              unsigned long long key) {
  Device* device = (Device*)hdevice;
  RTC_CATCH_BEGIN;
  requireNotNull(device, "device");
  requireNotNull(path, "path");
  return (RTCCompressedFileWriter) new Writer(device, path, key);
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API unsigned int rtcGetCompressedFileWriterGeometryCount(RTCCompressedFileWriter hwriter) {
  Writer* writer = (Writer*)hwriter;
  RTC_CATCH_BEGIN;
  requireNotNull(writer, "writer");
  return (unsigned int)writer->size();
  RTC_CATCH_END2(writer);
  return 0;
}

RTC_API bool rtcAppendCompressedGeometry(RTCCompressedFileWriter hwriter, RTCGeometry hgeometry) {
  Writer* writer = (Writer*)hwriter;
  RTC_CATCH_BEGIN;
  requireNotNull(writer, "writer");
  requireNotNull(hgeometry, "geometry");
  writer->append((Geometry*)hgeometry);
  return true;
  RTC_CATCH_END2(writer);
  return false;
}

RTC_API bool rtcCommitCompressedFileWriter(RTCCompressedFileWriter hwriter) {
  Writer* writer = (Writer*)hwriter;
  RTC_CATCH_BEGIN;
  requireNotNull(writer, "writer");
  writer->commit();
  return true;
  RTC_CATCH_END2(writer);
  return false;
}

RTC_API void rtcReleaseCompressedFileWriter(RTCCompressedFileWriter hwriter) {
  RTC_CATCH_BEGIN;
  requireNotNull(hwriter, "writer");
  delete (Writer*)hwriter;
  RTC_CATCH_END(nullptr);
}

RTC_API RTCCompressedFile rtcOpenCompressedFile(RTCDevice hdevice, const char* path) {
  Device* device = (Device*)hdevice;
  RTC_CATCH_BEGIN;
  requireNotNull(device, "device");
  requireNotNull(path, "path");
  return (RTCCompressedFile) new File(device, path);
  RTC_CATCH_END(device);
  return nullptr;
}

RTC_API unsigned int rtcGetCompressedFileGeometryCount(RTCCompressedFile hfile) {
  File* file = (File*)hfile;
  RTC_CATCH_BEGIN;
  requireNotNull(file, "file");
  return unsigned(file->size());
  RTC_CATCH_END2(file);
  return 0;
}

RTC_API bool rtcGetCompressedFileGeometryInfo(RTCCompressedFile hfile, unsigned int index,
                                              struct RTCCompressedFileGeometryInfo* info) {
  File* file = (File*)hfile;
  RTC_CATCH_BEGIN;
  requireNotNull(file, "file");
  requireNotNull(info, "info");
  const core::CompressedFileGeometryInfo from = file->geometryInfo(index);
  RTCCompressedFileGeometryInfo to = RTCCompressedFileGeometryInfo();
  to.type = from.type;
  to.compression = from.compression;
  to.numPrimitives = from.numPrimitives;
  to.numTimeSteps = from.numTimeSteps;
  to.startTime = from.begin;
  to.endTime = from.end;
  std::copy_n(from.lower, 3, to.lower);
  std::copy_n(from.upper, 3, to.upper);
  to.bytes = from.bytes;
  core::writeStruct(info, to);
  return true;
  RTC_CATCH_END2(file);
  return false;
}

RTC_API bool rtcGetCompressedFileGeometryStatistics(RTCCompressedFile hfile, unsigned int index,
                                                    struct RTCCompressionStatistics* statistics) {
  File* file = (File*)hfile;
  RTC_CATCH_BEGIN;
  requireNotNull(file, "file");
  requireNotNull(statistics, "statistics");
  core::writeStruct(statistics, toPublic(file->statistics(index)));
  return true;
  RTC_CATCH_END2(file);
  return false;
}

RTC_API RTCGeometry rtcNewGeometryFromCompressedFile(RTCCompressedFile hfile, unsigned int index) {
  File* file = (File*)hfile;
  RTC_CATCH_BEGIN;
  requireNotNull(file, "file");
  return (RTCGeometry)file->load(index);
  RTC_CATCH_END2(file);
  return nullptr;
}

RTC_API bool rtcVerifyCompressedFile(RTCCompressedFile hfile) {
  File* file = (File*)hfile;
  RTC_CATCH_BEGIN;
  requireNotNull(file, "file");
  file->verifyAll();
  return true;
  RTC_CATCH_END2(file);
  return false;
}

RTC_API void rtcReleaseCompressedFile(RTCCompressedFile hfile) {
  RTC_CATCH_BEGIN;
  requireNotNull(hfile, "file");
  delete (File*)hfile;
  RTC_CATCH_END(nullptr);
}

RTC_NAMESPACE_END
