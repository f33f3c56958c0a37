// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A library to preload into a program that uses Embree 3 or 4. After each commit of a scene it prints the time so far
 * in which at least one geometry or scene was committed, the CPU time of the process meanwhile, the bytes that Embree's
 * memory monitor reports, and the bytes of all geometry buffers that Embree allocated, including released ones. Works
 * with any libembree3.so.3 or libembree4.so.4. Supports one device and any number of threads. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>
#include <time.h>

typedef bool (*Monitor)(void* userPtr, ssize_t bytes, bool after);

static atomic_llong live, buffers;
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

/* Embree 4.4 */
void rtcSetNewGeometryBufferHostDevice(void* geometry, int type, unsigned int slot, int format, size_t stride,
                                       size_t number, void** ptr, void** ofDevice) {
  void (*real)(void*, int, unsigned int, int, size_t, size_t, void**, void**) =
      dlsym(RTLD_NEXT, "rtcSetNewGeometryBufferHostDevice");
  allocatesBuffer = true;
  real(geometry, type, slot, format, stride, number, ptr, ofDevice);
  allocatesBuffer = false;
}

void* rtcSetNewGeometryBuffer(void* geometry, int type, unsigned int slot, int format, size_t stride, size_t count) {
  void* (*real)(void*, int, unsigned int, int, size_t, size_t) = dlsym(RTLD_NEXT, "rtcSetNewGeometryBuffer");
  allocatesBuffer = true;
  void* const buffer = real(geometry, type, slot, format, stride, count);
  allocatesBuffer = false;
  return buffer;
}

/* Commits that run now, and the seconds so far in which one ran: by the clock, and of all threads. */
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static unsigned running;
static double elapsed, ofThreads;

static double secondsOf(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Adds sign times the current times, at the begin of the first and the end of the last of the commits that overlap. */
static void addTimes(double sign) {
  elapsed += sign * secondsOf(CLOCK_MONOTONIC);
  ofThreads += sign * secondsOf(CLOCK_PROCESS_CPUTIME_ID);
}

static void commit(const char* name, void* object) {
  void (*real)(void*) = dlsym(RTLD_NEXT, name);
  pthread_mutex_lock(&mutex);
  if (running++ == 0) addTimes(-1);
  pthread_mutex_unlock(&mutex);
  real(object);
  pthread_mutex_lock(&mutex);
  if (--running == 0) addTimes(1);
  pthread_mutex_unlock(&mutex);
}

void rtcCommitGeometry(void* geometry) { commit("rtcCommitGeometry", geometry); }

void rtcCommitScene(void* scene) {
  commit("rtcCommitScene", scene);
  pthread_mutex_lock(&mutex);
  if (running == 0) /* otherwise, a later commit prints */
    fprintf(stderr, "commit: %.3f s, %.3f CPU s, %lld bytes, %lld of them buffers\n", elapsed, ofThreads,
            atomic_load(&live), atomic_load(&buffers));
  pthread_mutex_unlock(&mutex);
}
