// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Preloaded into a program on Embree 3: prints how long each commit of a scene takes, by how many bytes it grows what Embree's
 * memory monitor reports, and how many bytes are allocated after it, geometry buffers included. Works with any
 * libembree3.so.3. Supports one device and any number of threads. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>
#include <time.h>

typedef bool (*Monitor)(void* userPtr, ssize_t bytes, bool after);

static atomic_llong live;
static Monitor applications;
static void* applicationsPtr;

static bool count(void* userPtr, ssize_t bytes, bool after)
{
  (void)userPtr;
  atomic_fetch_add(&live, bytes);
  return applications ? applications(applicationsPtr, bytes, after) : true;
}

void rtcSetDeviceMemoryMonitorFunction(void* device, Monitor monitor, void* userPtr)
{
  void (*real)(void*, Monitor, void*) = dlsym(RTLD_NEXT, "rtcSetDeviceMemoryMonitorFunction");
  applications = monitor;
  applicationsPtr = userPtr;
  real(device, count, NULL);
}

void* rtcNewDevice(const char* settings)
{
  void* (*real)(const char*) = dlsym(RTLD_NEXT, "rtcNewDevice");
  void* const device = real(settings);
  if (device) rtcSetDeviceMemoryMonitorFunction(device, NULL, NULL);
  return device;
}

static double seconds(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec + 1e-9*now.tv_nsec;
}

void rtcCommitScene(void* scene)
{
  void (*real)(void*) = dlsym(RTLD_NEXT, "rtcCommitScene");
  const long long before = atomic_load(&live);
  const double begin = seconds();
  real(scene);
  const double took = seconds() - begin;
  const long long after = atomic_load(&live);
  fprintf(stderr, "commit: %.3f s, %lld bytes more, %lld bytes in all\n", took, after - before, after);
}
