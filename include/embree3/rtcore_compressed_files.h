// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compressed geometry in files.
 *
 * The library maps files instead of reading them: a program that opens a file can trace rays at once, blocks that no
 * ray visits stay on disk, and all processes of a machine share the memory of a file. docs/formats/file.md specifies
 * the format. */

#include "rtcore_compression.h"

RTC_NAMESPACE_BEGIN

/* Writer of a file, and an open file. */
typedef struct RTCCompressedFileWriterTy* RTCCompressedFileWriter;
typedef struct RTCCompressedFileTy* RTCCompressedFile;

/* Saves one geometry to a file.
 *
 * geometry: compressed, and not changed since the commit of its scene, or since its own commit with
 *           RTC_COMPRESSION_FLAG_RELEASE_INPUT. The file stores blocks, tree, time steps, primitive numbers and
 *           statistics. It does not store the mask, filters, user data, vertex attributes and the control cage.
 * path:     of the file. An existing file is replaced in one step after everything is written; it is unchanged if
 *           anything fails before. Symbolic links are followed, and permissions of the file are kept. A killed process
 *           leaves a file whose name continues with ".cbvh-part-" and 16 hexadecimal digits. The next save to the same
 *           path removes it, unless another process is still writing it.
 *
 * Returns true if the geometry was saved.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and for a path that cannot be written or that names a device or a pipe.
 * RTC_ERROR_INVALID_OPERATION for a geometry that is not compressed or changed since its commit, for a geometry that is
 * compressed only in part, because GRID stores the rest, for a geometry from a file with a damaged block, and if
 * writing fails, for example on a full disk or at a limit of the file size. SIGXFSZ does not reach the application.
 * Thread safety: several threads may save different geometries, also while rays are traced. No thread may commit a
 * geometry while it is saved. */
RTC_API bool rtcSaveCompressedGeometry(RTCGeometry geometry, const char* path);

/* Loads a file with one geometry.
 *
 * device: of the new geometry. It need not be the device that saved the file.
 * path:   of a regular file. While the geometry exists, the file may be replaced or removed, but must not be written to
 *         or truncated.
 *
 * Returns the geometry, or NULL. The geometry is committed. It can be attached to scenes, instanced, given a mask,
 * filters and user data, and traced like any other, with hits that are equal to the bit. It has no input:
 * rtcInterpolate and functions that set buffers, displacement, edge rates, time steps or compression fail with
 * RTC_ERROR_INVALID_OPERATION.
 *
 * The function reads and checks the header, the directory and the tree, and for geometry with motion blur also the
 * blocks. All other blocks are checked when a ray visits them for the first time. A damaged block is left out, and
 * reported as an error of the device if it is the first one of its geometry. rtcVerifyCompressedFile checks everything.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, and for a file that does not exist, has another format or
 * version, is truncated, has a damaged header, directory or tree, or contains several geometries. Thread safety: as
 * rtcNewGeometry. */
RTC_API RTCGeometry rtcLoadCompressedGeometry(RTCDevice device, const char* path);

/* Creates a writer for a file with any number of geometries.
 *
 * device: retained; receives the errors.
 * path:   as for rtcSaveCompressedGeometry.
 *
 * Returns the writer, to be released by rtcReleaseCompressedFileWriter, or NULL.
 *
 * Errors: as rtcSaveCompressedGeometry. Thread safety: only one thread may use a writer at a time. */
RTC_API RTCCompressedFileWriter rtcNewCompressedFileWriter(RTCDevice device, const char* path);

/* Creates a writer that can be resumed after an interruption, for geometries that take long to build.
 *
 * If the writer is released or the process ends before rtcCommitCompressedFileWriter, the appended geometries are kept
 * next to the file, under its path with ".part" appended. The next writer with the same path and key continues after
 * them: rtcGetCompressedFileWriterGeometryCount returns their number, and the application appends the remaining
 * geometries. A released writer loses no geometry. A killed process and a full disk lose the last geometry and up to
 * 64 MiB of geometries before it.
 *
 * device, path: as for rtcNewCompressedFileWriter.
 * key: number that identifies the input of the geometries, so that files of different input are not mixed.
 *
 * Returns the writer, or NULL.
 *
 * Errors: as rtcNewCompressedFileWriter. Also RTC_ERROR_INVALID_ARGUMENT if the kept part has another key, is of
 * another version of the library or is damaged, and while another writer uses it. */
RTC_API RTCCompressedFileWriter rtcResumeCompressedFileWriter(RTCDevice device, const char* path,
                                                              unsigned long long key);

/* Returns the number of geometries in a writer, including those that a resumed writer continues after.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL; the result is 0. Thread safety: only one thread may use a writer at a
 * time. */
RTC_API unsigned int rtcGetCompressedFileWriterGeometryCount(RTCCompressedFileWriter writer);

/* Appends a geometry to a file. The index of the geometry in the file is the number of geometries before it. The
 * geometry may be released afterwards: an application can save a scene that is larger than memory while it builds it.
 *
 * writer:   not committed.
 * geometry: as for rtcSaveCompressedGeometry.
 *
 * Returns true if the geometry was appended. After a geometry that cannot be saved, others can be appended. After a
 * failed write nothing can be appended.
 *
 * Errors: as rtcSaveCompressedGeometry; also RTC_ERROR_INVALID_OPERATION for a writer that is committed, or whose
 * earlier write failed. Thread safety: only one thread may use a writer at a time. No thread may commit the geometry
 * meanwhile. */
RTC_API bool rtcAppendCompressedGeometry(RTCCompressedFileWriter writer, RTCGeometry geometry);

/* Completes a file: writes everything to disk and renames it to its path.
 *
 * writer: with at least one geometry, not committed.
 *
 * Returns true if the file is complete. Otherwise an existing file at its path is unchanged.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. RTC_ERROR_INVALID_OPERATION for a writer without geometries, for a
 * writer that is committed or whose earlier write failed, and if writing fails. Geometries can be appended to a writer
 * without geometries afterwards. Thread safety: only one thread may use a writer at a time. */
RTC_API bool rtcCommitCompressedFileWriter(RTCCompressedFileWriter writer);

/* Releases a writer. Geometries that were not committed are removed, or kept by a writer of
 * rtcResumeCompressedFileWriter.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API void rtcReleaseCompressedFileWriter(RTCCompressedFileWriter writer);

/* Opens a file with any number of geometries. The function maps the file, and reads and checks its header and
 * directory. Any number of threads may use an open file at the same time, but only one may release it.
 *
 * device: of geometries that are created from the file. Retained; receives the errors.
 * path:   as for rtcLoadCompressedGeometry.
 *
 * Returns the file, to be released by rtcReleaseCompressedFile, or NULL.
 *
 * Errors: as rtcLoadCompressedGeometry, but several geometries are no error. Thread safety: as
 * rtcLoadCompressedGeometry. */
RTC_API RTCCompressedFile rtcOpenCompressedFile(RTCDevice device, const char* path);

/* Returns the number of geometries in a file.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL; the result is 0. */
RTC_API unsigned int rtcGetCompressedFileGeometryCount(RTCCompressedFile file);

/* Description of a geometry in a file. */
struct RTCCompressedFileGeometryInfo {
  size_t structSize RTC_COMPRESSION_SIZE_OF(RTCCompressedFileGeometryInfo); /* see rtcore_compression.h */
  enum RTCGeometryType type RTC_ZERO;                                       /* of the geometry that was saved */
  enum RTCCompression compression RTC_ZERO;                                 /* representation in the file */
  unsigned int numPrimitives RTC_ZERO, numTimeSteps RTC_ZERO;
  float startTime RTC_ZERO, endTime RTC_ZERO; /* times of the first and the last time step */
  float lower[3] RTC_ZERO, upper[3] RTC_ZERO; /* bounds at all times; lower is above upper if they are empty */
  size_t bytes RTC_ZERO;                      /* of its tree and blocks in the file */
};

/* Returns the description of a geometry in a file, without loading the geometry.
 *
 * file:  open.
 * index: below rtcGetCompressedFileGeometryCount.
 * info:  written during the call, not NULL; structSize is read.
 *
 * Returns true if the description was written.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, for an index out of range, and for a wrong structSize. */
RTC_API bool rtcGetCompressedFileGeometryInfo(RTCCompressedFile file, unsigned int index,
                                              struct RTCCompressedFileGeometryInfo* info);

/* Returns the compression statistics of a geometry in a file, without loading the geometry: the statistics of its last
 * commit before it was saved, but numUnsupportedFaces, inputBytes and cacheBytesPerThread are 0.
 *
 * file:       open.
 * index:      below rtcGetCompressedFileGeometryCount.
 * statistics: of this geometry alone. Written during the call, not NULL; structSize is read.
 *
 * Returns true if the statistics were written.
 *
 * Errors: as rtcGetCompressedFileGeometryInfo. */
RTC_API bool rtcGetCompressedFileGeometryStatistics(RTCCompressedFile file, unsigned int index,
                                                    struct RTCCompressionStatistics* statistics);

/* Creates a geometry from one in an open file, as rtcLoadCompressedGeometry does. The file may be released before the
 * geometry. Each call creates another geometry. Two geometries with the same index do not share the memory of blocks
 * that rays visit: instance one geometry instead.
 *
 * file:  open.
 * index: below rtcGetCompressedFileGeometryCount.
 *
 * Returns the geometry, or NULL.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL, for an index out of range, and for a geometry that is damaged or that
 * the library does not support. Thread safety: as rtcLoadCompressedGeometry. */
RTC_API RTCGeometry rtcNewGeometryFromCompressedFile(RTCCompressedFile file, unsigned int index);

/* Reads a whole file, checks all blocks and compares the checksums. Takes as long as reading the file from disk.
 *
 * file: open.
 *
 * Returns true if the file is intact. Otherwise the message of the device's error describes the damage.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL and for a damaged file. */
RTC_API bool rtcVerifyCompressedFile(RTCCompressedFile file);

/* Releases a file. Geometries that were created from it remain valid.
 *
 * Errors: RTC_ERROR_INVALID_ARGUMENT for NULL. */
RTC_API void rtcReleaseCompressedFile(RTCCompressedFile file);

RTC_NAMESPACE_END
