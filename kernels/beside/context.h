// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Contexts, and how errors of the kernels become errors of this library. What Embree has (geometries, buffers, scenes,
 * rays) is called through its own API, which is the kernels' own in this library, and which nobody outside sees; its
 * errors go to a device's error function. What Embree does not have is called in kernels/cbvh/core, which throws. */

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

/* An error on its way out of a function. */
struct Failure
{
  CbvhError code;
  std::string text;

  explicit operator bool() const { return code != CBVH_OK; }
};

/* Returns the exception that is being handled: a Failure, or one of the core. If an error of Embree was kept on this
 * thread and not thrown, its text follows: the reason why a block of a file is damaged is such an error. */
Failure caughtFailure();

/* Counts its references; made with one. */
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

/* Keeps a reference. */
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

  /* Returns the error that calls of Embree's API caused on this thread since the last call of this, and forgets it. */
  embree::beside::Failure takeError() const;

  /* Throws that error, if there is one. */
  void check() const;

  /* Keeps an error for cbvhGetErrorText, and tells the application. */
  CbvhError report(const embree::beside::Failure& failure) const;

private:
  ~CbvhContextTy() override;

  const CbvhErrorFunction function;
  void* const userPtr;
};

namespace embree { namespace beside {

/* Decides what happens to errors of Embree's functions on this thread. A function of this library creates one: errors
 * are then kept until CbvhContextTy::check() throws them. Around a callback of the application, areTaken is false:
 * errors of rays that the callback traces are reported at once, and the function that called the callback does not fail
 * because of them. The destructor restores the previous state. */
class OwnErrors
{
public:
  explicit OwnErrors(bool areTaken = true);
  ~OwnErrors();

private:
  const Failure outer;
  const bool wereTaken;
};

/* Stores the text of an error for cbvhGetErrorText and calls an error function, which may be NULL. The function may
 * cause errors itself. */
CbvhError tell(const Failure& failure, CbvhErrorFunction function, void* userPtr);

/* What all functions of the API that may fail are made of: their errors become a code. */
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

/* The same for functions that have no context to tell. */
CbvhError refuse(const char* text);

}} // namespace embree::beside
