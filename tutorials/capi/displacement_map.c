/* Copyright 2026 The Embree CBVH authors
 * SPDX-License-Identifier: Apache-2.0 */

/* A subdivision surface displaced by a height map, in C, without Embree. The displacement function interpolates the
 * texture coordinates of its points and reads the map there. Writes a picture.
 *
 *   cc -std=c99 displacement_map.c $(pkg-config --cflags --libs embree_cbvh) -lm
 *   ./a.out picture.pgm heights.pgm
 *
 * heights.pgm is a binary 8-bit PGM; without it, the heights are waves. */

#include <cbvh/cbvh.h>

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(enum CbvhError error) {
  if (error == CBVH_OK) return;
  fprintf(stderr, "displacement_map: %s\n", cbvhGetErrorText());
  exit(1);
}

/* --- the map ---------------------------------------------------------------------------- */

struct HeightMap {
  int width, height;
  float* heights;      /* 0 to 1, by rows */
  float amplitude;     /* of the displacement, in world units */
  CbvhSurface surface; /* its attribute 0 holds texture coordinates */
};

/* Returns the next number of a header, or 0. Skips comments: GIMP writes one. */
static int readNumber(FILE* file) {
  int c, number = 0;
  do {
    c = fgetc(file);
    if (c == '#')
      while (c != '\n' && c != EOF) c = fgetc(file);
  } while (isspace(c));
  ungetc(c, file);
  return fscanf(file, "%d", &number) == 1 ? number : 0;
}

/* Returns 1 if the file is at the first height. */
static int readHeader(struct HeightMap* map, FILE* file) {
  if (fgetc(file) != 'P' || fgetc(file) != '5') return 0;
  map->width = readNumber(file);
  map->height = readNumber(file);
  return map->width >= 1 && map->width <= 32768 && map->height >= 1 && map->height <= 32768 &&
         readNumber(file) == 255 && isspace(fgetc(file));
}

static void loadMap(struct HeightMap* map, const char* path) {
  int i, size;
  if (path) {
    FILE* file = fopen(path, "rb");
    unsigned char* bytes;
    if (!file || !readHeader(map, file)) {
      fprintf(stderr, "displacement_map: cannot read %s: expected a binary 8-bit PGM of at most 32768 x 32768 pixels\n",
              path);
      exit(1);
    }
    size = map->width * map->height;
    bytes = malloc((size_t)size);
    map->heights = malloc(sizeof(float) * (size_t)size);
    if (!bytes || !map->heights || fread(bytes, 1, (size_t)size, file) != (size_t)size) {
      fprintf(stderr, "displacement_map: %s ends early: expected %d bytes of heights\n", path, size);
      exit(1);
    }
    for (i = 0; i < size; i++) map->heights[i] = (float)bytes[i] / 255;
    free(bytes);
    fclose(file);
    return;
  }
  map->width = map->height = 256;
  size = map->width * map->height;
  map->heights = malloc(sizeof(float) * (size_t)size);
  if (!map->heights) exit(1);
  /* the same along all edges, so that neighboring faces agree */
  for (i = 0; i < size; i++) {
    const float x = ((float)(i % 256) + 0.5f) * 0.196350f, y = ((float)(i / 256) + 0.5f) * 0.196350f;
    map->heights[i] = 0.5f + 0.25f * cosf(x) + 0.25f * cosf(y);
  }
}

/* Bilinear; the map repeats outside of 0 to 1. */
static float heightAt(const struct HeightMap* map, float u, float v) {
  const float x = (u - floorf(u)) * (float)map->width - 0.5f, y = (v - floorf(v)) * (float)map->height - 0.5f;
  const float fx = x - floorf(x), fy = y - floorf(y);
  const int x0 = ((int)floorf(x) + map->width) % map->width, y0 = ((int)floorf(y) + map->height) % map->height;
  const int x1 = (x0 + 1) % map->width, y1 = (y0 + 1) % map->height;
  const float* const row0 = map->heights + (size_t)y0 * (size_t)map->width;
  const float* const row1 = map->heights + (size_t)y1 * (size_t)map->width;
  return (1 - fy) * ((1 - fx) * row0[x0] + fx * row0[x1]) + fy * ((1 - fx) * row1[x0] + fx * row1[x1]);
}

/* Called by several threads, for points of one face. */
static void displace(const struct CbvhDisplacementArguments* args) {
  const struct HeightMap* const map = args->userPtr;
  float uv[64][2];
  unsigned int first, i;
  for (first = 0; first < args->count; first += 64) {
    struct CbvhInterpolationPoints points;
    memset(&points, 0, sizeof(points));
    points.structSize = sizeof(points);
    points.primID = args->primID;
    points.count = args->count - first < 64 ? args->count - first : 64;
    points.u = args->u + first;
    points.v = args->v + first;
    points.P = uv[0];
    check(cbvhInterpolateAttributeAtPoints(map->surface, &points));
    for (i = 0; i < points.count; i++) {
      const float height = map->amplitude * (heightAt(map, uv[i][0], uv[i][1]) - 0.5f);
      args->P_x[first + i] += height * args->Ng_x[first + i];
      args->P_y[first + i] += height * args->Ng_y[first + i];
      args->P_z[first + i] += height * args->Ng_z[first + i];
    }
  }
}

/* --- the surface and its picture ---------------------------------------------------------- */

/* Shades by the normal, seen from a corner of the cube. Returns the number of hits. */
static unsigned int writePicture(CbvhGroup group, const char* path, int size) {
  FILE* const file = fopen(path, "wb");
  unsigned int hits = 0;
  int x, y;
  if (!file) {
    fprintf(stderr, "displacement_map: cannot write %s: expected a writable path\n", path);
    exit(1);
  }
  fprintf(file, "P5 %d %d 255\n", size, size);
  for (y = 0; y < size; y++)
    for (x = 0; x < size; x++) {
      const float a = 2 * ((float)x + 0.5f) / (float)size - 1, b = 1 - 2 * ((float)y + 0.5f) / (float)size;
      struct CbvhRayHit ray;
      int gray = 0;
      memset(&ray, 0, sizeof(ray));
      ray.ray.org_x = 2;
      ray.ray.org_y = -3;
      ray.ray.org_z = 2;
      ray.ray.dir_x = -2 + 1.25f * a - 0.40f * b;
      ray.ray.dir_y = 3 + 0.83f * a + 0.61f * b;
      ray.ray.dir_z = -2 + 1.31f * b;
      ray.ray.tfar = INFINITY;
      ray.ray.mask = ~0u;
      if (cbvhIntersect1(group, &ray, NULL)) {
        const float nx = ray.hit.Ng_x, ny = ray.hit.Ng_y, nz = ray.hit.Ng_z;
        gray = 55 + (int)(200 * fabsf(0.4f * nx - 0.5f * ny + 0.77f * nz) / sqrtf(nx * nx + ny * ny + nz * nz));
        if (gray > 255) gray = 255;
        hits++;
      }
      fputc(gray, file);
    }
  if (ferror(file) || fclose(file) != 0) {
    fprintf(stderr, "displacement_map: %s cannot be written\n", path);
    exit(1);
  }
  return hits;
}

int main(int argc, char** argv) {
  /* a cube; each face shows the whole map */
  static const float positions[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                        {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
  static const float corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  static const unsigned int faceVertexCounts[6] = {4, 4, 4, 4, 4, 4};
  static const unsigned int indices[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  static const unsigned int uvIndices[24] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
  const float* const steps[1] = {positions[0]};
  struct CbvhAttribute uv;
  struct CbvhCage cage;
  struct CbvhGroupStatistics statistics;
  struct HeightMap map;
  CbvhContext context;
  CbvhGroup group;
  unsigned int hits;

  loadMap(&map, argc > 2 ? argv[2] : NULL);
  map.amplitude = 0.15f;
  check(cbvhNewContext(NULL, NULL, NULL, &context));
  check(cbvhNewSurface(context, &map.surface));

  memset(&uv, 0, sizeof(uv));
  uv.values = corners[0];
  uv.numValues = 4;
  uv.stride = sizeof(corners[0]);
  uv.width = 2;
  uv.indices = uvIndices;
  uv.boundary = CBVH_BOUNDARY_PIN_ALL;

  memset(&cage, 0, sizeof(cage));
  cage.structSize = sizeof(cage);
  cage.numFaces = 6;
  cage.faceVertexCounts = faceVertexCounts;
  cage.numIndices = 24;
  cage.indices = indices;
  cage.vertices.numVertices = 8;
  cage.vertices.stride = sizeof(positions[0]);
  cage.vertices.steps = steps;
  cage.vertices.numSteps = 1;
  cage.rate = 256;
  cage.displacement = displace;
  cage.displacementUserPtr = &map;
  cage.numAttributes = 1;
  cage.attributes = &uv;
  check(cbvhSetSurfaceCage(map.surface, &cage));
  check(cbvhCommitSurface(map.surface, NULL, NULL));
  check(cbvhNewGroup(context, &map.surface, 1, &group));
  check(cbvhCommitGroup(group));

  statistics.structSize = sizeof(statistics);
  check(cbvhGetGroupStatistics(group, &statistics));
  hits = writePicture(group, argc > 1 ? argv[1] : "displacement_map.pgm", 512);
  printf("%.2f million quads in %.2f MiB; %u rays hit\n", (double)statistics.numQuads * 1e-6,
         (double)statistics.bytes / (1 << 20), hits);

  cbvhReleaseGroup(group);
  cbvhReleaseSurface(map.surface);
  cbvhReleaseContext(context);
  free(map.heights);
  return hits > 0 ? 0 : 1;
}
