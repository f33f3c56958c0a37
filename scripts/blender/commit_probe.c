// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A library to preload into a program that uses Embree 3 or 4. After each commit of a scene it prints the duration of
 * all commits of geometries and scenes so far, the bytes that Embree's memory monitor reports, and the bytes of all
 * geometry buffers that Embree allocated, including released ones. Works with any libembree3.so.3 or libembree4.so.4.
 * Supports one device and any number of threads. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>
#include <time.h>

typedef bool (*Monitor)(void* userPtr, ssize_t bytes, bool after);

static atomic_llong live, buffers, nanoseconds;
static _Thread_local bool allocatesBuffer;
static Monitor applications;
static void* applicationsPtr;

static bool count(void* userPtr, ssize_t bytes, bool after) {
  (void)userPtr;
  atomic_fetch_add(&live, bytes);
  if (allocatesBuffer) atomic_fetch_add(&buffers, bytes);
  return applications ? applications(applicationsPtr, bytes, after) : true;
}

void rtcSetDeviceMemoryMonitorFunction(void* device, Monitor monitor, void* userPtr) {
  void (*real)(void*, Monitor, void*) = dlsym(RTLD_NEXT, "rtcSetDeviceMemoryMonitorFunction");
  applications = monitor;
  applicationsPtr = userPtr;
  real(device, count, NULL);
}

void* rtcNewDevice(const char* settings) {
  void* (*real)(const char*) = dlsym(RTLD_NEXT, "rtcNewDevice");
  void* const device = real(settings);
  if (device) rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
  return device;
}

void* rtcSetNewGeometryBuffer(void* geometry, int type, unsigned int slot, int format, size_t stride, size_t count) {
  void* (*real)(void*, int, unsigned int, int, size_t, size_t) = dlsym(RTLD_NEXT, "rtcSetNewGeometryBuffer");
  allocatesBuffer = true;
  void* const buffer = real(geometry, type, slot, format, stride, count);
  allocatesBuffer = false;
  return buffer;
}

static void commit(const char* name, void* object) {
  void (*real)(void*) = dlsym(RTLD_NEXT, name);
  struct timespec begin, end;
  clock_gettime(CLOCK_MONOTONIC, &begin);
  real(object);
  clock_gettime(CLOCK_MONOTONIC, &end);
  atomic_fetch_add(&nanoseconds, 1000000000ll * (end.tv_sec - begin.tv_sec) + (end.tv_nsec - begin.tv_nsec));
}

void rtcCommitGeometry(void* geometry) { commit("rtcCommitGeometry", geometry); }

void rtcCommitScene(void* scene) {
  commit("rtcCommitScene", scene);
  fprintf(stderr, "commit: %.3f s, %lld bytes, %lld of them buffers\n", 1e-9 * atomic_load(&nanoseconds),
          atomic_load(&live), atomic_load(&buffers));
}
