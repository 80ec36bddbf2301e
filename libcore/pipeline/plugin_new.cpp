// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/pipeline/plugin_library.hpp>
#include <triad/pipeline/plugin_new.hpp>

namespace triad {
namespace {

// Names that CMake's generators keep for targets of their own (policy CMP0037).
constexpr const char* kReservedNames[] = {"all", "clean", "help", "install", "package", "preinstall", "test"};

constexpr char kSource[] = R"(#include <triad/abi/triad_plugin.hpp>

namespace {

namespace tp = triad_plugin;

struct @TYPE@ {
  static constexpr tp::Info info{"@NAME@", "1.0", "Multiplies colour by a factor",
                                 "Say here what the user should know."};
  double factor;

  static constexpr auto params() {
    return tp::list(tp::number<&@TYPE@::factor>("factor", "what to multiply by", {.def = 1, .min = 0, .max = 1000}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "the picture", "rgb", "linear"}); }

  // Pixels depend on nothing but themselves, so any number of threads may work at once.
  void plan(tp::PlanCall& call) { call.plan.threads = TRIAD_REENTRANT; }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int i = 0; i < out.row_floats(); ++i) out.row(y)[i] = static_cast<float>(factor * in.row(y)[i]);
  }
};

}  // namespace

TRIAD_PLUGIN("@NAME@", @TYPE@)
)";

constexpr char kCMake[] = R"(cmake_minimum_required(VERSION 3.25)
project(@NAME@ LANGUAGES CXX)
find_package(triad REQUIRED)
triad_add_plugin(@NAME@ @NAME@.cpp)
)";

constexpr char kTest[] = R"sh(#!/bin/sh
# Builds the plugin and checks that it keeps the rules. TRIAD names the program, if it is not on the PATH;
# further arguments go to cmake, e.g. -DCMAKE_PREFIX_PATH=/opt/triad
set -e
cd "$(dirname "$0")"
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release "$@"
cmake --build build
"${TRIAD:-triad}" plugin check build/@NAME@.triad.so
)sh";

std::string filled_in(std::string text, const std::string& name) {
  std::string type;
  bool upper = true;
  for (const char c : name) {
    if (c != '-') type += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    upper = c == '-';
  }
  for (const auto& [key, value] : {std::pair{std::string("@NAME@"), name}, {"@TYPE@", type}})
    for (size_t at = 0; (at = text.find(key, at)) != std::string::npos; at += value.size())
      text.replace(at, key.size(), value);
  return text;
}

}  // namespace

std::vector<std::string> new_plugin(const std::string& name, const std::string& parent) {
  if (!is_plugin_name(name))
    throw_usage("'" + name +
                "' cannot be a plugin's name; it must be a lower-case letter and up to 31 lower-case letters, "
                "digits and hyphens");
  if (std::any_of(std::begin(kReservedNames), std::end(kReservedNames), [&](const char* n) { return name == n; }))
    throw_usage("'" + name + "' cannot be a plugin's name, because CMake keeps it for itself; use another");
  const std::filesystem::path folder = std::filesystem::path(parent) / name;
  if (mkdir(folder.c_str(), 0777) != 0)
    throw_input("cannot make the folder '" + folder.string() + "': " + std::strerror(errno));
  const std::string source = folder / (name + ".cpp"), cmake = folder / "CMakeLists.txt", test = folder / "test.sh";
  write_text_file(source, filled_in(kSource, name));
  write_text_file(cmake, filled_in(kCMake, name));
  write_text_file(test, filled_in(kTest, name));
  std::filesystem::permissions(
      test,
      std::filesystem::perms::owner_exec | std::filesystem::perms::group_exec | std::filesystem::perms::others_exec,
      std::filesystem::perm_options::add);
  return {source, cmake, test};
}

}  // namespace triad
