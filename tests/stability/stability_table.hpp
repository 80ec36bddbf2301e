// SPDX-License-Identifier: Apache-2.0
// Rows of the table of hard cases that `./run test` prints: each check below is an expectation of the running test,
// and writes what was measured and what must hold to the build folder, a file for each test and area.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace triad::stability {

// area: "geometry"; what: the case, in a few words; neither holds tabs.
inline void record(const std::string& area, const std::string& what, const std::string& measured,
                   const std::string& must_hold, bool holds) {
  EXPECT_TRUE(holds) << area << ", " << what << ": " << measured << "; must hold: " << must_hold;
  const auto& test = *::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = TRIAD_BINARY_DIR "/stability";
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / fmt::format("{}-{}.{}.tsv", area, test.test_suite_name(), test.name());
  static std::set<std::filesystem::path> begun;
  std::ofstream out(file, begun.insert(file).second ? std::ios::trunc : std::ios::app);
  out << area << '\t' << what << '\t' << measured << '\t' << must_hold << (holds ? "" : "  FAILED") << '\n';
  EXPECT_TRUE(out.flush().good()) << file;
}

inline void at_most(const std::string& area, const std::string& what, double measured, double bound) {
  record(area, what, fmt::format("{:.3g}", measured), fmt::format("<= {:.3g}", bound), measured <= bound);
}
// What a naive method gets wrong, which is why the row above it exists.
inline void naive_fails(const std::string& area, const std::string& what, double measured, double at_least) {
  record(area, what, fmt::format("{:.3g}", measured), fmt::format("naive: >= {:.3g}", at_least),
         measured >= at_least);
}
inline void equal(const std::string& area, const std::string& what, double measured, double expected) {
  record(area, what, fmt::format("{:.10g}", measured), fmt::format("= {:.10g}", expected), measured == expected);
}
// How often something happened that must never happen.
inline void never(const std::string& area, const std::string& what, uint64_t count, uint64_t of) {
  record(area, what, fmt::format("{} of {}", count, of), "none", count == 0 && of > 0);
}

}  // namespace triad::stability
