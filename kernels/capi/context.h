// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Contexts of the C API (include/cbvh/cbvh.h), and conversion of errors. Geometries, buffers, scenes and rays are
 * Embree's, called through its API, which libembree_cbvh contains but does not export; ErrorScope collects their
 * errors. Other features are called in kernels/cbvh/operations, which throws. In comments of this folder, "core" is
 * kernels/cbvh/operations, and "kernels" is Embree with compression. */

#include "cbvh/cbvh.h"
#include "cbvh/operations/errors.h"

#include <embree3/rtcore.h>

#include <atomic>
#include <exception>
#include <memory>
#include <new>
#include <string>

namespace embree {

class Device;

namespace capi {

/* An error of the API, thrown as an exception or returned. */
struct Failure {
  CbvhError code;
  std::string text;

  explicit operator bool() const { return code != CBVH_OK; }
};

/* Converts the exception of the enclosing catch block. Appends an error of Embree that was stored on this thread but
 * not thrown, such as why a block of a file is damaged. */
Failure caughtFailure();

/* Base of objects with a reference count, which starts at 1. Thread-safe. A process may contain this code twice, in
 * libembree3 and in libembree_cbvh: isOurs() is false for objects of the other one. */
class RefCounted {
public:
  RefCounted() : library(&thisLibrary), references(1) {}
  RefCounted(const RefCounted&) = delete;
  RefCounted& operator=(const RefCounted&) = delete;

  bool isOurs() const { return library == &thisLibrary; }
  void retain() { references++; }
  void release() {
    if (--references == 0) delete this;
  }

protected:
  virtual ~RefCounted() = default;

private:
  static const char thisLibrary;

  const char* const library; // first, so that all versions have it in the same place
  std::atomic<size_t> references;
};

/* Owns a reference to a RefCounted object, or is NULL. */
template<typename T>
class RefPtr {
public:
  RefPtr() : object(nullptr) {}
  explicit RefPtr(T* object) : object(object) {
    if (object) object->retain();
  }
  RefPtr(const RefPtr& other) : RefPtr(other.object) {}
  RefPtr(RefPtr&& other) : object(other.object) { other.object = nullptr; }
  ~RefPtr() {
    if (object) object->release();
  }
  RefPtr& operator=(RefPtr other) {
    std::swap(object, other.object);
    return *this;
  }

  T* get() const { return object; }
  T* operator->() const { return object; }

private:
  T* object;
};

struct Releaser {
  template<typename T>
  void operator()(T* object) const {
    object->release();
  }
};

/* Owns the first reference to a new RefCounted object. */
template<typename T> using NewPtr = std::unique_ptr<T, Releaser>;

} // namespace capi
} // namespace embree

/* A device of the kernels, and where errors go: to a function of the application or, if the application made the
 * device, to the device. */
struct CbvhContextTy : embree::capi::RefCounted {
  CbvhContextTy(const char* settings, CbvhErrorFunction function, void* userPtr);
  explicit CbvhContextTy(RTCDevice device); // retains it

  embree::Device* embreeDevice() const { return (embree::Device*)device; }

  const RTCDevice device;

  /* Returns and clears the error of Embree's API that the current ErrorScope collected last. */
  embree::capi::Failure takeError() const;

  /* Throws the error of takeError(), if there is one. */
  void check() const;

  /* Stores an error for cbvhGetErrorText, and notifies the application. */
  CbvhError report(const embree::capi::Failure& failure) const;

private:
  ~CbvhContextTy() override;

  const bool ownsDevice;
  const CbvhErrorFunction function;
  void* const userPtr;
};

namespace embree::capi {

/* Selects how this thread handles errors of Embree, until the destructor restores the previous state. Functions of this
 * library collect errors of their context, which CbvhContextTy::check() throws. During callbacks of the application,
 * there is no context: errors of rays that the callback traces are reported at once, and the function that called it
 * does not fail. */
class ErrorScope {
public:
  explicit ErrorScope(const CbvhContextTy* context = nullptr);
  ~ErrorScope();

private:
  core::ErrorCollector collector;
  core::ErrorCollector* const outer;
};

/* Reports an error to a device, or to this thread if it is NULL, as functions of rtcore.h do. */
void raise(RTCDevice device, const Failure& failure);

/* Stores an error's text for cbvhGetErrorText, and calls an error function, which may be NULL and may cause further
 * errors. Returns failure.code. */
CbvhError callErrorFunction(const Failure& failure, CbvhErrorFunction function, void* userPtr);

/* Runs an API function. Reports its exceptions to the application, and returns their code. */
template<typename Closure>
CbvhError guarded(CbvhContextTy* context, const Closure& closure) {
  const RefPtr<CbvhContextTy> held(context); // callbacks may release the application's references
  Failure failure;
  {
    const ErrorScope errors(context);
    try {
      closure();
      return CBVH_OK;
    } catch (...) { failure = caughtFailure(); }
  }
  return context->report(failure);
}

/* Throws CBVH_ERROR_INVALID_ARGUMENT if a condition is false. */
inline void require(bool condition, const char* text) {
  if (!condition) throw Failure{CBVH_ERROR_INVALID_ARGUMENT, text};
}

[[noreturn]] inline void throwInvalidArgument(const std::string& text) {
  throw Failure{CBVH_ERROR_INVALID_ARGUMENT, text};
}

/* Throws CBVH_ERROR_INVALID_ARGUMENT if bits other than the known ones are set. of: what has the flags. */
void checkFlags(unsigned int flags, unsigned int known, const char* of);

/* Stores a text for cbvhGetErrorText, without calling the error function. Returns CBVH_ERROR_INVALID_ARGUMENT. */
CbvhError rejectArgument(const char* text);

} // namespace embree::capi
