// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometry in files. A file is mapped, not read: a program that opens it traces rays at once, what no ray meets stays on
 * disk, and all processes of a machine share the memory of one file. */

#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

/* A file that is written, and one that is open. */
typedef struct RTCCompressedFileWriterTy* RTCCompressedFileWriter;
typedef struct RTCCompressedFileTy* RTCCompressedFile;

/* Saves one geometry to a file.
 *
 * geometry: compressed, in a scene that was committed, or by its own commit (RTC_COMPRESSION_FLAG_RELEASE_INPUT), and not changed since.
 *           What is saved is its surface: blocks, tree, time steps, primitives, statistics. Not saved are mask, filters, user data, vertex
 *           attributes and the cage.
 * path: of the file. A file that has the name is replaced when all is written, in one step: whatever happens before, it
 *       stays as it was. Symbolic links are followed, and the file's permissions are kept. A process that is killed
 *       leaves a file next to it, whose name goes on with ".cbvh-part-" and digits. The next save to the same path
 *       removes it, but no file that another process still writes.
 *
 * Returns whether it was saved.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and for a path that cannot be written or leads to a device or a pipe;
 * RTC_ERROR_INVALID_OPERATION for a geometry that is not compressed, or not as a whole (faces of edge rates that only
 * GRID takes), and where writing ends, as on a full disk or at a limit on file sizes (SIGXFSZ does not reach the
 * application). Thread safety: geometries are saved at a time while they are traced; one is not to be committed
 * meanwhile. */
RTC_API bool rtcSaveCompressedGeometry(RTCGeometry geometry, const char* path);

/* Makes a geometry of a file with one.
 *
 * device: of the geometry, whatever device saved it.
 * path: of a regular file, which is neither to be written into nor to be cut while the geometry lives; it may be
 *       replaced or removed.
 *
 * Returns the geometry, which is committed, or NULL. It is attached to scenes, instanced, given a mask, filters and user data, and traced as any
 * other, with the same hits to the bit. It has no cage: rtcInterpolate, buffers, displacement, edge rates, time steps and compression are
 * refused with RTC_ERROR_INVALID_OPERATION.
 *
 * The header, the directory and the tree are read and checked; of a geometry that moves also the blocks. Other blocks are checked one by
 * one when rays meet them first: one that is damaged is left out, with an error for the device the first time. rtcVerifyCompressedFile
 * checks all.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and, with the reason, for a file that does not exist, is foreign, truncated, altered, or of a
 * newer version; RTC_ERROR_OUT_OF_MEMORY. Thread safety: as rtcNewGeometry. */
RTC_API RTCGeometry rtcLoadCompressedGeometry(RTCDevice device, const char* path);

/* Begins a file of any number of geometries.
 *
 * device: that has the errors.
 * path: as above.
 *
 * Returns the writer, to be released by rtcReleaseCompressedFileWriter, or NULL.
 *
 * Errors: as rtcSaveCompressedGeometry. Thread safety: a writer is used by one thread at a time. */
RTC_API RTCCompressedFileWriter rtcNewCompressedFileWriter(RTCDevice device, const char* path);

/* Begins a file whose geometries take long to make, or goes on with one. What is appended is kept beside the file, under its name with ".part" behind, when
 * the writer is released, or the process ends, without a commit. The next writer of the same path and key goes on behind it: it has rtcGetCompressedFileWriterCount
 * geometries, and takes those that follow. A released writer loses none; a process that is killed, and a disk that is full, lose the last geometry, or the last
 * 64 MiB of smaller ones.
 *
 * device, path: as rtcNewCompressedFileWriter.
 * key: a number for what the geometries are made from, so that files of different input are not mixed.
 *
 * Returns the writer, or NULL.
 *
 * Errors: as rtcNewCompressedFileWriter; also RTC_ERROR_INVALID_ARGUMENT where what is there was begun with another key or by another version of the
 * library, or is damaged, and while another writer has it. */
RTC_API RTCCompressedFileWriter rtcResumeCompressedFileWriter(RTCDevice device, const char* path, unsigned long long key);

/* Returns how many geometries a writer has; 0 for NULL. */
RTC_API unsigned int rtcGetCompressedFileWriterCount(RTCCompressedFileWriter writer);

/* Appends a geometry, which may be released then: so a scene that memory does not hold is saved while it is built. Their order is that of the
 * indices in the file.
 *
 * writer: not committed.
 * geometry: as of rtcSaveCompressedGeometry.
 *
 * Returns whether it was appended. A geometry that cannot be saved is left out, and others may follow; after writing failed nothing can.
 *
 * Errors and thread safety: as above. */
RTC_API bool rtcAppendCompressedGeometry(RTCCompressedFileWriter writer, RTCGeometry geometry);

/* Ends a file: all is on the disk, and has its name.
 *
 * writer: with at least one geometry, not committed.
 *
 * Returns whether it was; else what was there under that name stays.
 *
 * Errors and thread safety: as above. */
RTC_API bool rtcCommitCompressedFile(RTCCompressedFileWriter writer);

/* Releases a writer. What was not committed is removed, or, of rtcResumeCompressedFileWriter, kept. */
RTC_API void rtcReleaseCompressedFileWriter(RTCCompressedFileWriter writer);

/* Opens a file with any number of geometries. Arguments, errors and thread safety: as rtcLoadCompressedGeometry.
 *
 * Returns the file, to be released by rtcReleaseCompressedFile, or NULL. */
RTC_API RTCCompressedFile rtcOpenCompressedFile(RTCDevice device, const char* path);

/* Returns how many geometries a file has. */
RTC_API unsigned int rtcGetCompressedFileGeometryCount(RTCCompressedFile file);

/* What a file says of a geometry. */
struct RTCCompressedFileGeometry
{
  size_t structSize RTC_SIZE_OF(RTCCompressedFileGeometry); /* see rtcore_compression.h */
  enum RTCGeometryType type;                  /* that it was made as */
  enum RTCCompression compression;            /* that it was stored as */
  unsigned int primitiveCount, timeStepCount;
  float begin, end;                           /* times of the first step and of the last */
  float lower[3], upper[3];                   /* of all that a ray may hit, at all times; lower is above upper if that is nothing */
  size_t bytes;                               /* in the file */
};

/* Describes a geometry of a file, without loading it.
 *
 * file: open.
 * index: below rtcGetCompressedFileGeometryCount.
 * description: written during the call, not NULL; structSize is read.
 *
 * Returns whether it was written.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, for an index out of range, and for a wrong structSize. */
RTC_API bool rtcGetCompressedFileGeometry(RTCCompressedFile file, unsigned int index, struct RTCCompressedFileGeometry* description);

/* Reports the compression of one geometry of a file, as its last commit before it was saved did, without loading it.
 *
 * file: open.
 * index: below rtcGetCompressedFileGeometryCount.
 * statistics: of the geometry alone. Written during the call, not NULL; structSize is read.
 *
 * Returns whether they were written.
 *
 * Errors: as rtcGetCompressedFileGeometry. */
RTC_API bool rtcGetCompressedFileGeometryStatistics(RTCCompressedFile file, unsigned int index,
    struct RTCCompressionStatistics* statistics);

/* Makes a geometry of one in an open file, as rtcLoadCompressedGeometry. The file may be released before it. Each call makes another geometry: a
 * second one that lives beside the first has copies of its own of what rays meet, so an instance is better.
 *
 * file: open.
 * index: below rtcGetCompressedFileGeometryCount.
 *
 * Returns the geometry, or NULL. Errors and thread safety: as rtcLoadCompressedGeometry. */
RTC_API RTCGeometry rtcNewGeometryFromCompressedFile(RTCCompressedFile file, unsigned int index);

/* Reads all of a file, and compares its checksums.
 *
 * file: open.
 *
 * Returns whether nothing was altered; else the error of the device says what. Errors: RTC_ERROR_INVALID_ARGUMENT. */
RTC_API bool rtcVerifyCompressedFile(RTCCompressedFile file);

/* Releases a file. Geometries made of it stay. */
RTC_API void rtcReleaseCompressedFile(RTCCompressedFile file);

RTC_NAMESPACE_END
