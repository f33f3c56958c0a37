// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Renders subdivision geometry with OSPRay 3, for tests of the interposer. Does not depend on our code.
 *
 *   ospray RENDERER LEVEL PICTURE.ppm [colors|faces|texcoords|boxes|instances] */

#include <ospray/ospray.h>
#include <ospray/ospray_util.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void tell(void* user, OSPError error, const char* text) {
  (void)user;
  fprintf(stderr, "OSPRay: error %d: %s\n", (int)error, text);
  exit(2);
}

static void setData(OSPObject object, const char* name, const void* data, OSPDataType type, uint64_t count) {
  OSPData shared = ospNewSharedData(data, type, count, 0, 1, 0, 1, 0, NULL, NULL);
  OSPData copy = ospNewData(type, count, 1, 1);
  ospCopyData(shared, copy, 0, 0, 0);
  ospCommit(copy);
  ospSetObject(object, name, copy);
  ospRelease(shared);
  ospRelease(copy);
}

static OSPLight light(const char* type, float intensity, float x, float y, float z) {
  const float direction[3] = {x, y, z};
  OSPLight made = ospNewLight(type);
  ospSetFloat(made, "intensity", intensity);
  if (strcmp(type, "ambient") != 0) ospSetParam(made, "direction", OSP_VEC3F, direction);
  ospCommit(made);
  return made;
}

static OSPGeometry cube(float level, const char* with) {
  float vertices[8][3], colors[24][4], texcoords[8][2], levels[24];
  const uint32_t indices[24] = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
  const uint32_t faces[6] = {4, 4, 4, 4, 4, 4}, creases[4] = {0, 1, 1, 3};
  const float sharpness[2] = {3.5f, 3.5f};
  OSPGeometry geometry = ospNewGeometry("subdivision");
  for (int i = 0; i < 8; i++) {
    for (int k = 0; k < 3; k++) vertices[i][k] = i & (1 << k) ? 1 : -1;
    texcoords[i][0] = i & 1 ? 4 : 0;
    texcoords[i][1] = i & 2 ? 4 : 0;
  }
  for (int i = 0; i < 24; i++) {
    levels[i] = level;
    colors[i][0] = i % 3 == 0;
    colors[i][1] = i % 5 < 3;
    colors[i][2] = i % 7 < 4;
    colors[i][3] = 1;
  }
  setData(geometry, "vertex.position", vertices, OSP_VEC3F, 8);
  setData(geometry, "index", indices, OSP_UINT, 24);
  setData(geometry, "face", faces, OSP_UINT, 6);
  setData(geometry, "index.level", levels, OSP_FLOAT, 24);
  setData(geometry, "edgeCrease.index", creases, OSP_VEC2UI, 2);
  setData(geometry, "edgeCrease.weight", sharpness, OSP_FLOAT, 2);
  if (strcmp(with, "colors") == 0) setData(geometry, "vertex.color", colors, OSP_VEC4F, 8);
  if (strcmp(with, "faces") == 0) setData(geometry, "color", colors, OSP_VEC4F, 24);
  if (strcmp(with, "texcoords") == 0) setData(geometry, "vertex.texcoord", texcoords, OSP_VEC2F, 8);
  ospCommit(geometry);
  return geometry;
}

/* A board of 2 x 2 squares for texture coordinates. */
static OSPTexture board(void) {
  const uint8_t texels[12] = {230, 60, 40, 240, 240, 240, 240, 240, 240, 30, 80, 200};
  OSPTexture texture = ospNewTexture("texture2d");
  ospSetUInt(texture, "format", OSP_TEXTURE_RGB8);
  ospSetUInt(texture, "filter", OSP_TEXTURE_FILTER_NEAREST);
  OSPData shared = ospNewSharedData(texels, OSP_VEC3UC, 2, 0, 2, 0, 1, 0, NULL, NULL),
          copy = ospNewData(OSP_VEC3UC, 2, 2, 1);
  ospCopyData(shared, copy, 0, 0, 0);
  ospCommit(copy);
  ospSetObject(texture, "data", copy);
  ospRelease(shared);
  ospRelease(copy);
  ospCommit(texture);
  return texture;
}

static OSPGeometricModel model(OSPGeometry geometry, OSPMaterial material) {
  OSPGeometricModel made = ospNewGeometricModel(geometry);
  ospSetObject(made, "material", material);
  ospCommit(made);
  return made;
}

int main(int argc, const char** argv) {
  const int width = 640, height = 480;
  const float position[3] = {2.2f, 1.9f, 3}, direction[3] = {-2.2f, -1.9f, -3}, up[3] = {0, 1, 0},
              background[4] = {0.2f, 0.25f, 0.3f, 1};
  int n = 0;
  if (ospInit(&argc, argv) != OSP_NO_ERROR || argc < 4) return 2;
  ospDeviceSetErrorCallback(ospGetCurrentDevice(), tell, NULL);
  const char* const with = argc > 4 ? argv[4] : "";

  OSPMaterial material = ospNewMaterial("obj");
  if (strcmp(with, "texcoords") == 0) {
    OSPTexture texture = board();
    ospSetObject(material, "map_kd", texture);
    ospRelease(texture);
  }
  ospCommit(material);

  OSPGroup group = ospNewGroup();
  OSPGeometry geometry = cube((float)atof(argv[2]), with);
  OSPGeometricModel models[2] = {model(geometry, material)};
  int numModels = 1;
  if (strcmp(with, "boxes") == 0) { /* user geometry inside OSPRay */
    const float box[6] = {-0.9f, 0.3f, -0.9f, 0.9f, 0.9f, 0.9f};
    OSPGeometry boxes = ospNewGeometry("box");
    setData(boxes, "box", box, OSP_BOX3F, 1);
    ospCommit(boxes);
    models[numModels++] = model(boxes, material);
    ospRelease(boxes);
  }
  ospRelease(geometry);
  setData(group, "geometry", models, OSP_GEOMETRIC_MODEL, (uint64_t)numModels);
  ospCommit(group);

  OSPInstance instances[3];
  const int numInstances = strcmp(with, "instances") == 0 ? 3 : 1;
  for (int i = 0; i < numInstances; i++) {
    const float scale = i ? 0.4f : 1,
                xfm[12] = {scale, 0, 0, 0, scale, 0, 0, 0, scale, i == 1 ? 1.2f : i == 2 ? -1.2f : 0, i ? 0.5f : 0, 0};
    instances[i] = ospNewInstance(group);
    ospSetParam(instances[i], "transform", OSP_AFFINE3F, xfm);
    ospCommit(instances[i]);
  }
  OSPLight lights[3] = {light("ambient", 0.4f, 0, 0, 0), light("distant", 2.0f, -1, -2, -1),
                        light("distant", 1.0f, 1, -0.5f, -0.3f)};
  OSPWorld world = ospNewWorld();
  setData(world, "instance", instances, OSP_INSTANCE, (uint64_t)numInstances);
  setData(world, "light", lights, OSP_LIGHT, 3);
  ospCommit(world);

  OSPCamera camera = ospNewCamera("perspective");
  ospSetFloat(camera, "aspect", (float)width / (float)height);
  ospSetFloat(camera, "fovy", 32);
  ospSetParam(camera, "position", OSP_VEC3F, position);
  ospSetParam(camera, "direction", OSP_VEC3F, direction);
  ospSetParam(camera, "up", OSP_VEC3F, up);
  ospCommit(camera);

  OSPRenderer renderer = ospNewRenderer(argv[1]);
  ospSetParam(renderer, "backgroundColor", OSP_VEC4F, background);
  ospSetInt(renderer, "pixelSamples", 4);
  if (strcmp(argv[1], "scivis") == 0) {
    ospSetBool(renderer, "shadows", 1);
    ospSetInt(renderer, "aoSamples", 2);
  }
  ospCommit(renderer);

  OSPFrameBuffer frame = ospNewFrameBuffer(width, height, OSP_FB_SRGBA, OSP_FB_COLOR);
  ospCommit(frame);
  OSPFuture future = ospRenderFrame(frame, renderer, camera, world);
  ospWait(future, OSP_TASK_FINISHED);
  const uint8_t* const pixels = (const uint8_t*)ospMapFrameBuffer(frame, OSP_FB_COLOR);
  FILE* const file = fopen(argv[3], "wb");
  if (!file || !pixels) return 2;
  fprintf(file, "P6\n%d %d\n255\n", width, height);
  for (int y = height; y-- > 0;)
    for (int x = 0; x < width; x++) n += fwrite(pixels + 4 * (y * width + x), 3, 1, file) == 1;
  if (fclose(file) != 0 || n != width * height) return 2;
  ospUnmapFrameBuffer(pixels, frame);

  ospRelease(future);
  ospRelease(frame);
  ospRelease(renderer);
  ospRelease(camera);
  ospRelease(world);
  ospRelease(material);
  ospRelease(group);
  for (int i = 0; i < 3; i++) ospRelease(lights[i]);
  for (int i = 0; i < numInstances; i++) ospRelease(instances[i]);
  for (int i = 0; i < numModels; i++) ospRelease(models[i]);
  ospShutdown();
  return 0;
}
