// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Contexts, and conversion of errors of the kernels. Features of Embree (geometries, buffers, scenes, rays) are called
 * through Embree's API, which this library contains but does not export; their errors go to the device's error
 * function. Other features are called in kernels/cbvh/core, which throws. */

#include "cbvh/cbvh.h"
#include "cbvh/core/errors.h"

#include <embree3/rtcore.h>

#include <atomic>
#include <exception>
#include <new>
#include <string>

namespace embree {

class Device;

namespace beside {

struct Failure
{
  CbvhError code;
  std::string text;

  explicit operator bool() const { return code != CBVH_OK; }
};

/* Returns the exception of the enclosing catch block: a Failure, or an exception of the core. Appends an error of
 * Embree that was stored on this thread but not thrown, such as the reason why a block of a file is damaged. */
Failure caughtFailure();

/* Reference-counted, from 1. */
class Counted
{
public:
  Counted() : references(1) {}
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  void retain() { references++; }
  void release() { if (--references == 0) delete this; }

protected:
  virtual ~Counted() = default;

private:
  std::atomic<size_t> references;
};

template<typename T>
class Held
{
public:
  Held() : object(nullptr) {}
  explicit Held(T* object) : object(object) { if (object) object->retain(); }
  Held(const Held& other) : Held(other.object) {}
  Held(Held&& other) : object(other.object) { other.object = nullptr; }
  ~Held() { if (object) object->release(); }
  Held& operator=(Held other) { std::swap(object, other.object); return *this; }

  T* get() const { return object; }
  T* operator->() const { return object; }

private:
  T* object;
};

}} // namespace embree::beside

struct CbvhContextTy : embree::beside::Counted
{
  CbvhContextTy(const char* settings, CbvhErrorFunction function, void* userPtr);

  embree::Device* inner() const { return (embree::Device*)device; }

  RTCDevice device;

  /* Returns and clears this thread's last error of Embree's API. */
  embree::beside::Failure takeError() const;

  /* Throws the error that takeError() returns, if there is one. */
  void check() const;

  /* Stores an error for cbvhGetErrorText, and notifies the application. */
  CbvhError report(const embree::beside::Failure& failure) const;

private:
  ~CbvhContextTy() override;

  const CbvhErrorFunction function;
  void* const userPtr;
};

namespace embree { namespace beside {

/* Selects how this thread handles errors of Embree's functions. Functions of this library create one, which stores
 * errors until CbvhContextTy::check() throws them. During callbacks of the application, areTaken is false: errors of
 * rays that the callback traces are reported at once, without failing the function that called it. The destructor
 * restores the previous state. */
class OwnErrors
{
public:
  explicit OwnErrors(bool areTaken = true);
  ~OwnErrors();

private:
  Failure outer;
  const bool wereTaken;
};

/* Stores an error's text for cbvhGetErrorText, and calls an error function, which may be NULL and may cause errors. */
CbvhError callErrorFunction(const Failure& failure, CbvhErrorFunction function, void* userPtr);

/* Runs an API function, and converts its errors to a code. */
template<typename Closure>
CbvhError guarded(CbvhContextTy* context, const Closure& closure)
{
  const Held<CbvhContextTy> held(context); // callbacks may release the application's references
  const OwnErrors errors;
  Failure failure;
  try {
    closure();
    return CBVH_OK;
  }
  catch (...) { failure = caughtFailure(); }
  return context ? context->report(failure) : failure.code;
}

inline void require(bool holds, const char* text) { if (!holds) throw Failure{CBVH_ERROR_INVALID_ARGUMENT, text}; }

/* As callErrorFunction(), for functions without a context. */
CbvhError rejectArgument(const char* text);

}} // namespace embree::beside
