// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The speed table of cbvh_render on a clock whose noise is known. */

#include "report.h"
#include "speed.h"

#include "support/message_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

namespace programs::test { namespace {

struct NamedScene : TracedScene {
  RTCScene handle() const override { return nullptr; }
  const SceneTracer& tracer() const override { std::abort(); }
  SurfaceHit surfaceHit(const RTCRayHit&) const override { return {}; }
};

/* GRID, then NAIVE and cVERT, which alternate with GRID. */
struct Table {
  NamedScene grid, naive, cvert;
  RaySets sets;
  Comparison comparison;
  std::vector<const TracedScene*> timed;

  /* `seconds` receives the scene, and how often it was timed before. */
  explicit Table(const std::function<double(const TracedScene*, size_t)>& seconds) {
    for (std::vector<Ray>& set : sets) set.resize(1000000);
    size_t count = 0;
    InterleavedSpeed speed(sets, 5, [&](const TracedScene& scene, const std::vector<Ray>&, const TraceSettings&) {
      timed.push_back(&scene);
      return seconds(&scene, count++);
    });
    comparison.speed = true;
    for (const RepresentationKind kind :
         {RepresentationKind::Grid, RepresentationKind::Naive, RepresentationKind::CVert}) {
      Result result;
      result.representation.kind = kind;
      result.build.quads = 1;
      if (kind != RepresentationKind::Grid)
        result.speed = speed.measure("", kind == RepresentationKind::Naive ? naive : cvert, &grid);
      comparison.results.push_back(result);
    }
    for (Result& result : comparison.results)
      speed.relateToGrid(result.speed, result.representation.kind == RepresentationKind::Grid);
  }

  /* Cells of the columns GRID, NAIVE and cVERT. */
  std::vector<std::string> cells(const std::string& row, bool details = false) const {
    std::string line = lineWith(formatTable(comparison, details), row);
    std::vector<std::string> found;
    for (size_t at = line.find('|', 1); at + 1 < line.size(); at = line.find('|', at + 1)) {
      const std::string cell = line.substr(at + 1, line.find('|', at + 1) - at - 1);
      const size_t begin = cell.find_first_not_of(' '), end = cell.find_last_not_of(' ');
      found.push_back(cell.substr(begin, end + 1 - begin));
    }
    return found;
  }

  /* The quotient of printed rates, if each cell has a ratio. */
  void expectRatiosOfRates() const {
    const std::vector<std::string> found = cells("| coherent rays");
    ASSERT_EQ(found.size(), 3u);
    const double base = std::stod(found[0]);
    for (const std::string& cell : found) {
      ASSERT_NE(cell.find('('), std::string::npos) << cell;
      if (cell.find("differ") == std::string::npos) {
        EXPECT_NEAR(std::stod(cell.substr(cell.find('(') + 1)), std::stod(cell) / base, 0.006) << cell;
      }
    }
  }
};

bool saysNoise(const std::string& cell) {
  return cell.find("rounds differ by ") != std::string::npos && cell.find('%') != std::string::npos;
}

TEST(SpeedTable, QuietRoundsGiveRatios) {
  Table table([&](const TracedScene*, size_t i) { return 1.0 + 0.01 * double(i % 3); }); // all scenes are equally fast
  table.expectRatiosOfRates();
  EXPECT_EQ(table.timed.size(), size_t(2 * 2 * 5 * numRaySets * numQueries)) << "quiet rounds were repeated";
  for (const std::string& cell : table.cells("| coherent rays")) EXPECT_FALSE(saysNoise(cell)) << cell;
}

/* Other load slows GRID down while one representation is measured: its ratio to these rounds is not that to the printed
 * rate, and neither says how fast the representation is. */
TEST(SpeedTable, LoadNextToOneRepresentationIsSaid) {
  const TracedScene* grid = nullptr;
  Table table([&](const TracedScene* scene, size_t i) {
    if (!grid) grid = scene; // is timed first
    return scene == grid ? (i < 40 ? 1.0 : 2.5) : 0.5;
  });
  table.expectRatiosOfRates();
  const std::vector<std::string> cells = table.cells("| coherent rays");
  EXPECT_TRUE(saysNoise(cells[1]) || saysNoise(cells[2]));
  EXPECT_TRUE(saysNoise(cells[0])) << "GRID's own rounds differ";
}

TEST(SpeedTable, NoisyRoundsAreRepeatedUntilTheyAgree) {
  size_t rounds = 0;
  Table table([&](const TracedScene*, size_t) {
    rounds++;
    return rounds <= 10 && rounds % 2 ? 3.0 : 1.0; // the first five rounds of the first cell
  });
  table.expectRatiosOfRates();
  EXPECT_GT(table.comparison.results[1].speed[0][0].rounds.own.size(), 5u);
  EXPECT_EQ(table.comparison.results[2].speed[0][0].rounds.own.size(), 5u);
  EXPECT_FALSE(table.comparison.results[1].speed[0][0].isNoisy()) << "ten further rounds agree";
}

TEST(SpeedTable, RoundsThatNeverAgreeHaveNoRatio) {
  std::mt19937 random(1);
  Table table([&](const TracedScene*, size_t) { return 1.0 + double(random() % 1000) / 300; });
  const size_t most = 2 * 2 * 5 * numRaySets * numQueries * size_t(mostRepetitions);
  EXPECT_GT(table.timed.size(), most / 2);
  EXPECT_LE(table.timed.size(), most);
  for (const char* row : {"| coherent rays", "| incoherent rays"}) {
    const std::vector<std::string> cells = table.cells(row);
    for (size_t i = 1; i < cells.size(); i++) EXPECT_TRUE(saysNoise(cells[i])) << cells[i];
  }
  for (const char* row : {"| - of GRID", "| - of NAIVE"})
    for (const std::string& cell : table.cells(row, true)) EXPECT_TRUE(saysNoise(cell) || cell == "1.00") << cell;
}

}} // namespace programs::test
