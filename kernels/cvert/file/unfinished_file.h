// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A file that is written next to its final path, and renamed when complete: readers never see a part of it. A lock
 * distinguishes it from files of killed processes. Requires only Linux: programs include it without the codec. */

#include "output_path.h"
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <dirent.h>
#include <fcntl.h>
#include <random>
#include <sys/file.h>

namespace cvert {
/*! While it exists, writes of this thread beyond the limit on file sizes fail with EFBIG and raise no SIGXFSZ. */
class FileSizeSignalMask {
public:
  FileSizeSignalMask() {
    sigemptyset(&signal);
    sigaddset(&signal, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signal, &before);
  }
  ~FileSizeSignalMask() {
    if (sigismember(&before, SIGXFSZ)) return;
    const int error = errno;
    const timespec now = {0, 0};
    while (sigtimedwait(&signal, nullptr, &now) == SIGXFSZ || errno == EINTR) {}
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    errno = error;
  }
  FileSizeSignalMask(const FileSizeSignalMask&) = delete;
  FileSizeSignalMask& operator=(const FileSizeSignalMask&) = delete;

private:
  sigset_t signal, before;
};

/*! Writes all bytes by put(data,bytes,done), which may write fewer; done: bytes written before. Returns 0 or an
 *  errno. */
template<typename Put>
int putAll(const void* data, size_t bytes, const Put& put) {
  const FileSizeSignalMask mask;
  for (size_t done = 0; done < bytes;) {
    const ssize_t n = put((const char*)data + done, std::min(bytes - done, size_t(1) << 30), done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n < 0 ? errno : ENOSPC;
    done += size_t(n);
  }
  return 0;
}
inline int writeAll(int file, const void* data, size_t bytes) {
  return putAll(data, bytes, [&](const char* p, size_t n, size_t) { return ::write(file, p, n); });
}
inline int writeAllAt(int file, const void* data, size_t bytes, uint64_t offset) {
  return putAll(data, bytes,
                [&](const char* p, size_t n, size_t done) { return ::pwrite(file, p, n, off_t(offset + done)); });
}

/*! Reads all bytes by get(data,bytes,done), which may read fewer; done: bytes read before. Returns the number of
 *  bytes, fewer than requested only at the end of the file, or -1 and sets errno. */
template<typename Get>
ssize_t getAll(void* data, size_t bytes, const Get& get) {
  size_t done = 0;
  while (done < bytes) {
    const ssize_t n = get((char*)data + done, std::min(bytes - done, size_t(1) << 30), done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += size_t(n);
  }
  return ssize_t(done);
}
inline ssize_t readAllAt(int file, void* data, size_t bytes, uint64_t offset) {
  return getAll(data, bytes, [&](char* p, size_t n, size_t done) { return ::pread(file, p, n, off_t(offset + done)); });
}

/*! Writes a file to the disk. Returns 0 or an errno, but 0 on file systems that do not support this. */
inline int flushToDisk(int file) { return ::fsync(file) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno; }

class UnfinishedFile {
public:
  /*! Creates a file that is removed unless committed, and removes files of killed writers of the same path. Throws
   *  std::system_error, with EINVAL for a STREAM. */
  explicit UnfinishedFile(const OutputPath& output) : output(output) {
    requireFile();
    const std::string mark = ".cbvh-part-";
    const std::string prefix = shortenedName(mark.size() + 16) + mark, folder = folderOf(output.path);
    for (int tries = 0; !open(folder + "/" + prefix + randomDigits(), O_EXCL); tries++)
      if (tries == 100) throwErrno(EEXIST);
    removeStale(folder, prefix);
  }

  /*! Creates or opens a file that a later process can continue. Its name is the final name plus `suffix`. Throws
   *  std::system_error, with EWOULDBLOCK if another writer locked it, and with EINVAL for a STREAM. */
  UnfinishedFile(const OutputPath& output, const std::string& suffix) : output(output), isPersistent(true) {
    requireFile();
    const std::string path = folderOf(output.path) + "/" + shortenedName(suffix.size()) + suffix;
    for (int tries = 0; !open(path, 0); tries++)
      if (tries == 100) throwErrno(EWOULDBLOCK);
  }

  ~UnfinishedFile() {
    if (file < 0) return;
    if (!isPersistent) ::unlink(name.c_str());
    ::close(file);
  }

  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  int descriptor() const { return file; } //!< -1 after commit
  const std::string& path() const { return name; }

  /*! isPersistent: the destructor does not remove the file. */
  void setPersistent(bool isPersistent) { this->isPersistent = isPersistent; }

  /*! Copies permissions, and the owner if permitted, of the file that this one replaces. Copies the set-user-ID,
   *  set-group-ID and sticky bits (07000) only if it could copy the group. */
  void copyPermissions() {
    if (output.kind != OutputPath::REGULAR) return;
    const struct stat& status = output.status;
    const bool owns =
        ::fchown(file, status.st_uid, status.st_gid) == 0 || ::fchown(file, uid_t(-1), status.st_gid) == 0;
    (void)!::fchmod(file, status.st_mode & (owns ? 07777 : 0777));
  }

  /*! Flushes and renames the file, and then releases the lock. If it throws std::system_error, the file was not
   *  renamed. */
  void commit() {
    if (const int error = flushToDisk(file)) throwErrno(error);
    if (::rename(name.c_str(), output.path.c_str()) != 0) throwErrno(errno);
    ::close(file);
    file = -1;
    const int folder = ::open(folderOf(output.path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
      (void)!::fsync(folder);
      ::close(folder);
    }
  }

private:
  void requireFile() const {
    if (output.kind == OutputPath::STREAM) throwErrno(EINVAL);
  }

  /*! Opens and locks the file. Returns false if the caller must retry: the name exists, or another process renamed,
   *  removed or (with O_EXCL) locked the file. */
  bool open(const std::string& path, int flags) {
    const int opened = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | flags, 0666);
    if (opened < 0) {
      if (errno == EEXIST) return false;
      throwErrno(errno);
    }
    // other errors are ignored: some file systems have no locks
    const int error = ::flock(opened, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if ((error == EWOULDBLOCK && !(flags & O_EXCL)) || !isNamed(opened, path) || error == EWOULDBLOCK) {
      ::close(opened);
      if (error == EWOULDBLOCK && !(flags & O_EXCL)) throwErrno(error);
      return false;
    }
    file = opened;
    name = path;
    return true;
  }

  static bool isNamed(int file, const std::string& path) {
    struct stat open, named;
    return ::fstat(file, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && OutputPath::isSame(open, named);
  }

  /*! Returns the final name, to which the caller appends `more` bytes. Replaces its end by a hash if the result would
   *  be too long. */
  std::string shortenedName(size_t more) const {
    const std::string all = fileNameOf(output.path);
    const long limit = ::pathconf(folderOf(output.path).c_str(), _PC_NAME_MAX);
    const size_t most = limit > 0 ? size_t(limit) : NAME_MAX;
    if (all.size() + more <= most) return all;
    uint64_t sum = 0xcbf29ce484222325; // FNV-1a hash
    for (char c : all) sum = (sum ^ (unsigned char)c) * 0x100000001b3;
    size_t left = most > more + 17 ? std::min(all.size(), most - more - 17) : 0;
    while (left > 0 && (all[left] & 0xC0) == 0x80) left--; // keeps UTF-8 characters whole
    return all.substr(0, left) + "-" + digitsOf(sum);
  }

  static std::string digitsOf(uint64_t number) {
    char text[17];
    std::snprintf(text, sizeof(text), "%016llx", (unsigned long long)number);
    return text;
  }

  static std::string randomDigits() {
    std::random_device random;
    return digitsOf((uint64_t(random()) << 32) | random());
  }

  /*! Removes unlocked files whose names are `prefix` and 16 digits: their writers were killed. */
  void removeStale(const std::string& folder, const std::string& prefix) const {
    DIR* const entries = ::opendir(folder.c_str());
    if (!entries) return;
    while (const dirent* entry = ::readdir(entries)) {
      const std::string found = entry->d_name, path = folder + "/" + found;
      if (found.size() != prefix.size() + 16 || found.compare(0, prefix.size(), prefix) != 0 || path == name) continue;
      if (found.find_first_not_of("0123456789abcdef", prefix.size()) != std::string::npos) continue;
      const int stale = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
      if (stale < 0) continue;
      struct stat status;
      const bool isFile = ::fstat(stale, &status) == 0 && S_ISREG(status.st_mode);
      if (isFile && ::flock(stale, LOCK_EX | LOCK_NB) == 0 && isNamed(stale, path)) ::unlink(path.c_str());
      ::close(stale);
    }
    ::closedir(entries);
  }

  const OutputPath output;
  std::string name;
  int file = -1;
  bool isPersistent = false;
};
} // namespace cvert
