// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the tables of hit_rule.txt with paper/leaf/hit_rule.h: for every combination of state and event, the
 * first matching row must have the outcome of the code. */

#include "kernels/cbvh/paper/leaf/hit_rule.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

typedef std::map<std::string, std::string> Cells; // by the name of the column

std::string trim(const std::string& text) {
  const size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream row(line.substr(1));
  for (std::string cell; std::getline(row, cell, '|');) cells.push_back(trim(cell));
  return cells;
}

struct Table {
  std::vector<std::string> columns;
  size_t conditions = 0; // number of leading columns that are conditions
  std::vector<Cells> rows;
  std::vector<size_t> used; // how often each row applied

  // Reads the only table under a heading. Outcomes begin at the column `first`.
  Table(const std::string& heading, const std::string& first) {
    std::ifstream file(FORMATS "/../../tests/codec/hit_rule.txt");
    bool inside = false;
    for (std::string line; std::getline(file, line);) {
      if (!line.empty() && line[0] == '#') inside = line == "## " + heading;
      if (!inside || line.empty() || line[0] != '|' || line[1] == '-') continue;
      const std::vector<std::string> cells = cellsOf(line);
      if (columns.empty()) {
        columns = cells;
        while (conditions < columns.size() && columns[conditions] != first) conditions++;
        EXPECT_LT(conditions, columns.size()) << heading << " has no column " << first;
        continue;
      }
      EXPECT_EQ(cells.size(), columns.size()) << line;
      Cells row;
      for (size_t i = 0; i < columns.size() && i < cells.size(); i++) row[columns[i]] = cells[i];
      rows.push_back(row);
    }
    EXPECT_FALSE(rows.empty()) << "hit_rule.txt has no table under " << heading;
    used.assign(rows.size(), 0);
  }

  // Returns the first matching row. holds: whether a condition is true.
  const Cells* find(const std::function<bool(const std::string& column, const std::string& cell)>& holds) {
    for (size_t r = 0; r < rows.size(); r++) {
      bool applies = true;
      for (size_t i = 0; i < conditions && applies; i++) {
        const std::string& cell = rows[r][columns[i]];
        applies = cell.empty() || holds(columns[i], cell);
      }
      if (applies) {
        used[r]++;
        return &rows[r];
      }
    }
    return nullptr;
  }

  void expectEveryRowUsed() const {
    for (size_t r = 0; r < rows.size(); r++) EXPECT_GT(used[r], 0u) << "row " << r + 1 << " never applies";
  }
};

// Values that cells may refer to, by their names in hit_rule.txt.
struct Facts {
  std::map<std::string, bool> yes;       // columns of "yes" and "no"
  std::map<std::string, uint32_t> sides; // columns "side", "enter", "leave", "box"

  bool holds(const std::string& column, const std::string& cell) const {
    if (cell == "yes" || cell == "no") return yes.at(column) == (cell == "yes");
    const uint32_t side = sides.at(column);
    if (cell == "unknown") return side == sideUnknown;
    if (cell == "known") return side != sideUnknown;
    if (cell == "other") return side != sideUnknown && side != sides.at("enter");
    return side == sides.at(cell);
  }

  bool flag(const std::string& cell, const std::string& column) const {
    if (cell == "yes" || cell == "no") return cell == "yes";
    return yes.at(cell == "kept" ? column : cell);
  }

  uint32_t side(const std::string& cell) const {
    if (cell == "unknown") return sideUnknown;
    return sides.at(cell == "kept" ? "side" : cell);
  }
};

const std::map<std::string, uint32_t> hits = {{"none", hitNone}, {"box", hitBox}, {"step", hitStep},
                                              {"root", hitRoot}, {"lip", hitLip}, {"exit", hitExit}};

void expectState(const Facts& facts, const Cells& row, const WalkState& next) {
  EXPECT_EQ(next.side, facts.side(row.at("next side")));
  EXPECT_EQ(next.pending, facts.flag(row.at("next pending"), "pending"));
  EXPECT_EQ(next.fromSurface, facts.flag(row.at("next fromSurface"), "fromSurface"));
  EXPECT_EQ(next.found, facts.flag(row.at("next found"), "found"));
}

// Without a hit, `from` has no meaning.
void expectResult(const Facts& facts, const Cells& row, const HitResult& result) {
  EXPECT_EQ(result.hit, hits.at(row.at("hit")));
  if (row.at("hit") != "none") { EXPECT_EQ(result.from, facts.side(row.at("from"))); }
  expectState(facts, row, result.next);
}

std::vector<WalkState> allStates() {
  std::vector<WalkState> states;
  for (uint32_t side : {sideUnknown, sideBelow, sideAbove})
    for (int bits = 0; bits < 8; bits++) {
      WalkState state;
      state.side = side;
      state.pending = bits & 1;
      state.fromSurface = bits & 2;
      state.found = bits & 4;
      states.push_back(state);
    }
  return states;
}

std::vector<LeafEvent> allEvents() {
  std::vector<LeafEvent> events;
  for (uint32_t enter : {sideBelow, sideAbove})
    for (uint32_t leave : {sideBelow, sideAbove})
      for (int bits = 0; bits < 128; bits++) {
        LeafEvent e;
        e.enter = enter;
        e.leave = leave;
        e.changes = bits & 1;
        e.nearEntry = bits & 2;
        e.near = bits & 4;
        e.started = bits & 8;
        e.ended = bits & 16;
        e.solid = bits & 32;
        e.empty = bits & 64;
        events.push_back(e);
      }
  return events;
}

Facts factsOf(const WalkState& state) {
  Facts facts;
  facts.yes = {{"pending", state.pending}, {"fromSurface", state.fromSurface}, {"found", state.found}};
  facts.sides = {{"side", state.side}};
  return facts;
}

Facts factsOf(const WalkState& state, const LeafEvent& e) {
  Facts facts = factsOf(state);
  facts.yes.insert({{"changes", e.changes},
                    {"nearEntry", e.nearEntry},
                    {"near", e.near},
                    {"started", e.started},
                    {"ended", e.ended},
                    {"solid", e.solid},
                    {"empty", e.empty}});
  facts.sides.insert({{"enter", e.enter}, {"leave", e.leave}});
  return facts;
}

std::string describe(const Facts& facts) {
  static const char* const names[] = {"unknown", "below", "above"};
  std::string text;
  for (const auto& [name, side] : facts.sides) text += name + " " + names[side] + ", ";
  for (const auto& [name, yes] : facts.yes) text += name + (yes ? " yes, " : " no, ");
  return text;
}

template<typename Check>
void withRow(Table& table, const Facts& facts, const Check& check) {
  SCOPED_TRACE(describe(facts));
  const Cells* row =
      table.find([&](const std::string& column, const std::string& cell) { return facts.holds(column, cell); });
  ASSERT_NE(row, nullptr) << "no row applies";
  SCOPED_TRACE(testing::Message() << "row " << row - table.rows.data() + 1);
  check(*row);
}

TEST(HitRule, CrossingALeafMatchesTables) {
  Table noPatch("A leaf that is solid or empty", "hit"), before("A leaf with a patch, before a hit was found", "hit"),
      after("A leaf with a patch, after a hit was found", "hit");
  for (const WalkState& state : allStates())
    for (const LeafEvent& event : allEvents()) {
      Table& table = event.solid || event.empty ? noPatch : state.found ? after : before;
      const Facts facts = factsOf(state, event);
      withRow(table, facts, [&](const Cells& row) { expectResult(facts, row, crossLeaf(state, event)); });
      if (HasFailure()) return;
    }
  for (const Table* table : {&noPatch, &before, &after}) table->expectEveryRowUsed();
}

TEST(HitRule, PassedBoxesAreWantedAsInTable) {
  Table table("Is a passed box wanted?", "wanted");
  for (const WalkState& state : allStates()) {
    const Facts facts = factsOf(state);
    withRow(table, facts,
            [&](const Cells& row) { EXPECT_EQ(needsPassedBoxes(state), facts.flag(row.at("wanted"), "")); });
  }
  table.expectEveryRowUsed();
}

TEST(HitRule, PassingABoxMatchesTable) {
  Table table("A box that is passed", "hit");
  for (const WalkState& state : allStates())
    for (bool above : {false, true}) {
      Facts facts = factsOf(state);
      facts.sides["box"] = above ? sideAbove : sideBelow;
      withRow(table, facts, [&](const Cells& row) { expectResult(facts, row, passBox(state, above)); });
    }
  table.expectEveryRowUsed();
}

TEST(HitRule, AcceptedHitsChangeStateAsInTable) {
  Table table("After a hit was accepted", "next side");
  for (const WalkState& state : allStates()) {
    const Facts facts = factsOf(state);
    withRow(table, facts, [&](const Cells& row) { expectState(facts, row, afterHit(state)); });
  }
  table.expectEveryRowUsed();
}

// "at first" in the table of the ray's state.
TEST(HitRule, InitialStateMatchesPage) {
  Table table("What does the ray remember?", "at first");
  const WalkState state = startOfWalk();
  const Facts facts = factsOf(state);
  ASSERT_EQ(table.rows.size(), facts.sides.size() + facts.yes.size());
  for (const Cells& row : table.rows) {
    const std::string name = row.at("name").substr(1, row.at("name").size() - 2); // `name`
    if (name == "side") {
      EXPECT_EQ(state.side, facts.side(row.at("at first")));
    } else {
      EXPECT_EQ(facts.yes.at(name), facts.flag(row.at("at first"), "")) << name;
    }
  }
}

}} // namespace programs::test
