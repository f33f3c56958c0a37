// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "surface/obj_reader.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "support/message_parts.h"
#include "support/obj_dialects.h"
#include "surface/cage_validation.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace programs::test { namespace {

Cage read(const std::string& text) {
  std::istringstream stream(text);
  std::string warnings;
  return readObj(stream, "test.obj", warnings);
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

std::string errorOf(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "one line: " << e.what();
    return e.what();
  }
  return "";
}

TEST(ObjReader, PolygonsAreNotSplit) {
  const Cage cage = read(square + "v 2 2 2\nf 1 2 3 4 5\nf 1 2 3\n");
  EXPECT_EQ(cage.faceSizes, (std::vector<unsigned>{5, 3}));
  EXPECT_EQ(cage.faceIndices, (std::vector<unsigned>{0, 1, 2, 3, 4, 0, 1, 2}));
  EXPECT_FALSE(cage.hasUVs());
}

TEST(ObjReader, ReadsAllCornerForms) {
  const std::string uvs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n";
  for (const char* face : {"f 1/4 2/3 3/2 4/1\n", "f 1/4/1 2/3/1 3/2/1 4/1/1\n", "f -4/-1 -3/-2 -2/-3 -1/-4\n"}) {
    const Cage cage = read(square + uvs + face);
    EXPECT_EQ(cage.faceIndices, (std::vector<unsigned>{0, 1, 2, 3})) << face;
    EXPECT_EQ(cage.uvIndices, (std::vector<unsigned>{3, 2, 1, 0})) << face;
  }
  EXPECT_FALSE(read(square + "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n").hasUVs());
}

TEST(ObjReader, NegativeIndicesCountFromTheCurrentEnd) {
  const Cage cage = read(square + "f -4 -3 -2 -1\nv 9 9 9\nf -1 1 2\n");
  EXPECT_EQ(cage.faceIndices, (std::vector<unsigned>{0, 1, 2, 3, 4, 0, 1}));
}

TEST(ObjReader, OneVertexMayHaveSeveralUVs) {
  const Cage cage = read(square + "vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
  EXPECT_EQ(cage.uvIndices, (std::vector<unsigned>{0, 0, 0, 1, 1, 1}));
}

TEST(ObjReader, SomeFacesMayHaveNoTextureCoordinates) {
  constexpr unsigned none = Cage::noUV;
  const std::string with = "f 1/1 2/1 3/1\n", without = "f 1 3 4\n", uv = "vt 0.5 0.5\nvn 0 0 1\n";
  const Cage last = read(square + uv + with + without);
  const Cage first = read(square + uv + without + "f 1//1 3//1 4//1\n" + with);
  EXPECT_EQ(last.uvIndices, (std::vector<unsigned>{0, 0, 0, none, none, none}));
  EXPECT_EQ(last.numFacesWithoutUVs(), 1u);
  EXPECT_EQ(last.lineWithoutUVs, 8u);
  EXPECT_EQ(first.uvIndices, (std::vector<unsigned>{none, none, none, none, none, none, 0, 0, 0}));
  EXPECT_EQ(first.numFacesWithoutUVs(), 2u);
  EXPECT_EQ(first.lineWithoutUVs, 7u);
  EXPECT_TRUE(last.hasUVs() && first.hasUVs());
  const Cage all = read(square + uv + with), no = read(square + uv + without);
  EXPECT_EQ(all.numFacesWithoutUVs(), 0u);
  EXPECT_EQ(no.numFacesWithoutUVs(), 1u);
  EXPECT_FALSE(no.hasUVs());
  EXPECT_EQ(no.lineWithoutUVs, 0u);
}

TEST(ObjReader, CagesWithSomeTextureCoordinatesAreValid) {
  Cage cage = read(square + "v 2 0 0\nv 2 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\nf 2 5 6 3\n");
  std::string warnings;
  validateCage(cage, warnings);
  EXPECT_EQ(warnings, "");
  EXPECT_TRUE(cage.holes.empty());
}

/* A named pipe in a folder that is removed at the end. */
struct NamedPipe {
  NamedPipe() : folder(std::filesystem::temp_directory_path() / ("cbvh_obj_pipe_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder);
    path = (folder / "cage.obj").string();
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
  }
  ~NamedPipe() { std::filesystem::remove_all(folder); }

  std::filesystem::path folder;
  std::string path;
};

TEST(ObjReader, ReadsPipesWithLateAndSlowWriters) {
  const NamedPipe pipe;
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    std::ofstream stream(pipe.path);
    stream << square << std::flush;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    for (int i = 0; i < 20000; i++) // more than the capacity of a pipe
      stream << "f 1 2 3 4\n";
  });
  std::string warnings;
  const Cage cage = readObj(pipe.path, warnings);
  writer.join();
  EXPECT_EQ(cage.numFaces(), 20000u);
}

TEST(ObjReader, PipesWithoutAWriterAreReported) {
  const NamedPipe pipe;
  std::string warnings, error;
  try {
    readObj(pipe.path, warnings);
  } catch (const Error& e) { error = e.what(); }
  EXPECT_EQ(error.rfind(pipe.path + ": ", 0), 0u) << error;
  EXPECT_TRUE(containsInOrder(error, {"pipe", "10 seconds"}));
}

TEST(ObjReader, CancellationEndsTheWaitForAWriter) {
  const NamedPipe pipe;
  std::string warnings;
  requestCancel();
  EXPECT_THROW(readObj(pipe.path, warnings), Canceled);
  clearCancel();
}

TEST(ObjReader, DevicesAreRejected) {
  std::string warnings;
  for (const char* path : {"/dev/zero", "/dev/null"}) try {
      readObj(std::string(path), warnings);
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(std::string(path) + ": ", 0), 0u) << error.what();
      EXPECT_TRUE(containsInOrder(error.what(), {"device", "pipe"}));
    }
}

TEST(ObjReader, ReadsTags) {
  const Cage cage =
      read("t interpolateboundary 1/0/0 1\n" + square +
           "f 1 2 3 4\nt crease 2/1/0 0 1 2.5\nt crease 4/2/0 1 2 2 3 10 1\nt corner 1/1/0 3 4\nt hole 1/0/0 0\n");
  EXPECT_EQ(cage.boundary, BoundaryRule::EdgeAndCorner);
  ASSERT_EQ(cage.creaseEdges.size(), 3u);
  EXPECT_EQ(cage.creaseEdges[1], (std::pair<unsigned, unsigned>{1, 2}));
  EXPECT_EQ(cage.creaseSharpness[0], 2.5f);
  EXPECT_EQ(cage.creaseSharpness[1], INFINITY) << "10 is infinitely sharp in OpenSubdiv";
  EXPECT_EQ(cage.creaseSharpness[2], 1.0f);
  EXPECT_EQ(cage.cornerVertices, (std::vector<unsigned>{3}));
  EXPECT_EQ(cage.holes, (std::vector<unsigned>{0}));
}

TEST(ObjReader, WindowsLineEndsCommentsAndContinuations) {
  const Cage cage = read("# cage\r\nv 0 0 0\r\nv 1 0 0 # corner\r\nv 1 1 0\r\nf 1 \\\n2 3\r\n");
  EXPECT_EQ(cage.faceSizes, (std::vector<unsigned>{3}));
}

// Each of them is the square with one face, in the style of some program.
TEST(ObjReader, DialectsOfPrograms) {
  const std::string face = "f 1 2 3 4\n";
  const std::pair<const char*, std::string> dialects[] = {
      {"byte order mark", "\xEF\xBB\xBF" + square + face},
      {"byte order mark before a comment", "\xEF\xBB\xBF# exported\n" + square + face},
      {"comment that ends in a backslash", square + "# C:\\models\\\n" + face},
      {"comment after a statement that ends in a backslash", "v 0 0 0 # C:\\\n" + square.substr(8) + face},
      {"material that ends in a backslash", square + "usemtl C:\\skin\\\n" + face},
      {"object that ends in a backslash", square + "o C:\\body\\\n" + face},
      {"group and library that end in a backslash", "mtllib C:\\\n" + square + "g a\\\n" + face},
      {"continuation with blanks after the backslash", square + "f 1 2 \\ \t\n3 4\n"},
      {"continuation with CR LF", square + "f 1 2 \\\r\n3 4\r\n"},
      {"continuation of a normal", square + "vn 0 \\\n0 1\n" + face},
      {"continuation over three lines", square + "f 1 \\\n2 \\\n3 4\n"},
      {"continuation at the end of the file", square + "f 1 2 3 4 \\"},
      {"no line end at the end of the file", square + "f 1 2 3 4"},
      {"CR line ends", "# square\rv 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3 4\r"},
      {"one texture coordinate", square + "vt 0.5\nf 1/1 2/1 3/1 4/1\n"},
      {"comment without a blank before it", "v 0 0 0#.I\n" + square.substr(8) + "f 1 2 3 4#INFO\n"},
      {"blanks and empty lines", "\n \t\n" + square + "  f  1\t2 3 4  \n\n"},
  };
  for (const auto& [name, text] : dialects) {
    SCOPED_TRACE(name);
    const Cage cage = read(text);
    EXPECT_EQ(cage.positions.size(), 4u);
    EXPECT_EQ(cage.faceIndices, (std::vector<unsigned>{0, 1, 2, 3}));
  }
  EXPECT_EQ(read(square + "vt 0.5\nf 1/1 2/1 3/1 4/1\n").uvs[0].y, 0.0f);
  EXPECT_TRUE(containsInOrder(errorOf(square + "# a\\\n# b\\\r\nf 1 2 9\n"), {"test.obj:7: vertex index 9 ", " 4 "}));
}

TEST(ObjReader, FilesOfManyProgramsHaveTheirFaces) {
  for (const ObjDialect& dialect : objDialects()) {
    SCOPED_TRACE(dialect.name);
    std::istringstream stream(dialect.text);
    std::string warnings;
    Cage cage;
    EXPECT_NO_THROW(cage = readObj(stream, "test.obj", warnings)) << errorOf(dialect.text);
    EXPECT_EQ(warnings, "");
    EXPECT_EQ(cage.positions.size(), dialect.vertices);
    EXPECT_EQ(cage.numFaces(), dialect.faces);
    EXPECT_EQ(cage.numFacesWithoutUVs(), dialect.facesWithoutUVs);
    ASSERT_GT(cage.positions.size(), 2u);
    EXPECT_EQ(cage.positions[2].x + cage.positions[2].y - cage.positions[2].z, 2.0f);
  }
}

TEST(ObjReader, DenormalCoordinatesAreZero) {
  const Cage cage = read("v 0 1e-60 -4e-320\nv 1 1e-999 0\nv 1 1 0\nf 1 2 3\n");
  EXPECT_EQ(cage.positions[0].y, 0.0f);
  EXPECT_EQ(cage.positions[0].z, 0.0f);
  EXPECT_EQ(cage.positions[1].y, 0.0f);
}

TEST(ObjReader, RejectsBadInputWithItsLine) {
  struct Case {
    const char* text;
    const char* place;
    std::vector<std::string> parts;
  };
  const Case cases[] = {
      {"f 1 2\n", "test.obj:5: ", {"face", "three", " 2"}},
      {"f 1 2 5\n", "test.obj:5: ", {"vertex index 5", " 4 "}},
      {"f 1 2 0\n", "test.obj:5: ", {"vertex index 0", " 4 "}},
      {"f 1 2 -5\n", "test.obj:5: ", {"vertex index -5", " 4 "}},
      {"f 1/1 2/1 3/1\n", "test.obj:5: ", {"texture coordinate index 1", " 0 "}},
      {"f 1 2 x\n", "test.obj:5: ", {"number", "'x'"}},
      {"f 1 2 3.5\n", "test.obj:5: ", {"number", "'3.5'"}},
      {"v 1 2\n", "test.obj:5: ", {"vertex", "three", " 2"}},
      {"v 1 2 nan\n", "test.obj:5: ", {"'nan'", "finite"}},
      {"v 0 0 1.#QNAN\n", "test.obj:5: ", {"number", "'1.#QNAN'"}},
      {"v 0 0 -1.#IND00\n", "test.obj:5: ", {"number", "'-1.#IND00'"}},
      {"vt 1.#INF\n", "test.obj:5: ", {"number", "'1.#INF'"}},
      {"v 1 2 -1.#IND\n", "test.obj:5: ", {"number", "'-1.#IND'"}},
      {"v 1 2 1e99\n", "test.obj:5: ", {"'1e99'", "large"}},
      {"f 1 2 99999999999999999999\n", "test.obj:5: ", {"'99999999999999999999'", "large"}},
      {"vt 0 0\nf 1/1 2/1 3\n", "test.obj:6: ", {"texture coordinates", " 2 ", " 3"}},
      {"surf 1\n", "test.obj:5: ", {"statement 'surf'"}},
      {"curv 0 1 1 2\n", "test.obj:5: ", {"statement 'curv'"}},
      {"v 0,5 1 2\n", "test.obj:5: ", {"number", "'0,5'"}},
      {"v 1 2 3d0\n", "test.obj:5: ", {"number", "'3d0'"}},
      {"t crease 2/1/0 0 1\n", "test.obj:5: ", {"tag 'crease'", " 2/1/0 ", " 2"}},
      {"f 1 2 3\nt crease 2/1/0 0 4 1\n", "test.obj: ", {"tag", "vertex 4", " 4"}},
      {"f 1 2 3\nt hole 1/0/0 1\n", "test.obj: ", {"tag", "face 1", " 1"}},
      {"t corner 1/1/0 0 -1\nf 1 2 3\n", "test.obj:5: ", {"sharpness -1 ", "negative"}},
      {"t corner 1/1/0 0 nan\nf 1 2 3\n", "test.obj:5: ", {"sharpness nan ", "number"}},
      {"t interpolateboundary 1/0/0 3\n", "test.obj:5: ", {"tag 'interpolateboundary'", " 3", "0, 1 or 2"}},
      {"t corn\x84 0/0/0\n", "test.obj:5: ", {"tag 'corn?'"}},
      {"t \x84 1/0/0/\x84\n", "test.obj:5: ", {"tag '?'", " 1/0/0/? ", " 0"}},
      {"", "test.obj: ", {"no faces"}},
  };
  for (const Case& c : cases) {
    const std::string error = errorOf(square + c.text);
    EXPECT_EQ(error.rfind(c.place, 0), 0u) << c.text << error;
    EXPECT_TRUE(containsInOrder(error, c.parts)) << c.text;
  }
  const std::string utf16("\xFF\xFEv\0 \0", 6);
  EXPECT_TRUE(containsInOrder(errorOf(utf16), {"test.obj:1: ", "'" + std::string(2, '?') + "v?'", "OBJ"}));
  const std::string binary = "\x89PNG" + std::string(40, '\x01');
  EXPECT_TRUE(containsInOrder(errorOf(binary), {"test.obj:1: ", "'?PNG" + std::string(28, '?') + "...'", "OBJ"}));
  std::string warnings;
  EXPECT_THROW(readObj("/nonexistent/cage.obj", warnings), Error);
  EXPECT_THROW(readObj("/", warnings), Error);
}

TEST(ObjReader, SubdivisionRulesAreReadOrCauseWarnings) {
  EXPECT_EQ(read(square + "f 1 2 3 4\n").creaseRule, CreaseRule::Uniform);
  EXPECT_EQ(read(square + "f 1 2 3 4\nt creasemethod 0/0/1 chaikin\n").creaseRule, CreaseRule::Chaikin);
  const std::string error = errorOf(square + "t creasemethod 0/0/1 blunt\n");
  EXPECT_TRUE(containsInOrder(error, {"test.obj:5: ", "'blunt'", "'creasemethod'", "normal", "chaikin"}));
  std::istringstream stream(square + "f 1 2 3\nt smoothtriangles 0/0/1 smooth\n");
  std::string warnings;
  readObj(stream, "test.obj", warnings);
  EXPECT_TRUE(containsInOrder(warnings, {"test.obj:6: ", "'smoothtriangles smooth'", "\n"}));
  EXPECT_EQ(warnings.find('\n'), warnings.size() - 1) << "one line: " << warnings;
}

}} // namespace programs::test
