// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Resolves an output path to a file that can be replaced, or to a device, pipe or descriptor of this process, which
 * must be written in place. Requires only Linux: programs include it without the codec. */

#include <cctype>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <string>
#include <system_error>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

namespace cvert {
/*! what() is the text of the errno. */
[[noreturn]] inline void throwErrno(int error) { throw std::system_error(error, std::generic_category()); }

inline std::string folderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

inline std::string fileNameOf(const std::string& path) { return path.substr(path.rfind('/') + 1); } // npos+1 is 0

struct OutputPath {
  /*! A REGULAR file is replaced when the output is complete. A STREAM is written in place. */
  enum Kind { NEW, REGULAR, STREAM };

  /*! Throws std::system_error for folders and paths that cannot be resolved. */
  explicit OutputPath(const std::string& given) : path(given) {
    if (given.empty()) throwErrno(ENOENT);
    if (followLinks()) {
      kind = STREAM;
      return;
    }
    if (::lstat(path.c_str(), &status) != 0) {
      if (errno != ENOENT) throwErrno(errno);
      return;
    }
    if (S_ISDIR(status.st_mode)) throwErrno(EISDIR);
    descriptor = standardDescriptor(status);
    kind = S_ISREG(status.st_mode) && descriptor < 0 ? REGULAR : STREAM;
  }

  static bool isSame(const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
  }

  std::string path; //!< after following links, also to files that do not exist yet
  Kind kind = NEW;
  int descriptor = -1; //!< of this process, if the path names one, or if output is redirected to the file
  struct stat status;  //!< undefined for a new file, and for a link of /proc to an open file

private:
  /*! Replaces `path` by the target of its symbolic links. Returns true at a link of /proc to an open file, whose text
   *  need not be a path. */
  bool followLinks() {
    for (int links = 0;; links++) {
      char target[PATH_MAX];
      const ssize_t size = ::readlink(path.c_str(), target, sizeof(target));
      if (size < 0) return false;
      if (isOpenFile(path)) {
        descriptor = ownDescriptor(path);
        return true;
      }
      if (links == 40 || size == ssize_t(sizeof(target))) throwErrno(ELOOP); // 40 links, as in Linux
      const std::string next(target, size_t(size));
      path = next[0] == '/' ? next : folderOf(path) + "/" + next;
    }
  }

  /*! True for an entry of /proc/PID/fd. */
  static bool isOpenFile(const std::string& path) {
    const long proc = 0x9fa0; // PROC_SUPER_MAGIC
    struct statfs system;
    const bool isNumber = isdigit((unsigned char)fileNameOf(path)[0]);
    return isNumber && ::statfs(folderOf(path).c_str(), &system) == 0 && system.f_type == proc;
  }

  /*! N for /proc/self/fd/N and all links to that folder, else -1. */
  static int ownDescriptor(const std::string& path) {
    char* const real = ::realpath(folderOf(path).c_str(), nullptr);
    const std::string folder = real ? real : "";
    ::free(real);
    return folder == "/proc/" + std::to_string(::getpid()) + "/fd" ? std::atoi(fileNameOf(path).c_str()) : -1;
  }

  /*! Descriptor of standard output or standard error if it is redirected to the file, else -1. A rename would lose
   *  this output. */
  static int standardDescriptor(const struct stat& file) {
    struct stat open;
    for (int standard : {STDOUT_FILENO, STDERR_FILENO})
      if (::fstat(standard, &open) == 0 && isSame(open, file)) return standard;
    return -1;
  }
};
} // namespace cvert
