// SPDX-License-Identifier: Apache-2.0
#include "compare_pairs.hpp"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/reader.hpp>
#include <triad/pipeline/chain.hpp>

namespace fs = std::filesystem;

namespace triad::app {
namespace {

bool is_folder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool is_pattern(const std::string& path) {
  std::error_code error;
  return path.find_first_of("*?[") != std::string::npos && !fs::exists(path, error);
}

std::vector<std::string> folder_pictures(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    const std::string path = entry.path().string(), name = entry.path().filename().string();
    if (name[0] != '.' && has_picture_extension(path) && entry.is_regular_file(ignored)) found.push_back(path);
  }
  if (error) throw_input("cannot read the folder '" + folder + "': " + error.message());
  std::sort(found.begin(), found.end());
  return found;
}

// Files that match, pictures only if there are any among them: 'renders/*' finds notes and lists too.
std::vector<std::string> expand_pattern(const std::string& pattern) {
  glob_t matches{};
  const int status = glob(pattern.c_str(), 0, nullptr, &matches);
  std::vector<std::string> files, pictures;
  for (size_t i = 0; status == 0 && i < matches.gl_pathc; ++i) {
    const std::string path = matches.gl_pathv[i];
    if (is_folder(path)) continue;
    files.push_back(path);
    if (has_picture_extension(path)) pictures.push_back(path);
  }
  globfree(&matches);
  std::vector<std::string>& found = pictures.empty() ? files : pictures;
  std::sort(found.begin(), found.end());  // whatever the locale
  return found;
}

struct Test {
  std::string path, sequence;
  int frame = 0;
  bool searched = false;  // found by a pattern or in a folder, not named
};

std::vector<Test> expand_tests(const std::vector<std::string>& tests) {
  std::vector<Test> list;
  std::set<std::string> known;
  for (const std::string& text : tests) {
    if (is_sequence(text)) {
      for (const int frame : find_frames(text)) list.push_back({frame_path(text, frame), text, frame, false});
    } else if (is_pattern(text)) {
      const std::vector<std::string> found = expand_pattern(text);
      if (found.empty()) throw_input("'" + text + "' matches no file");
      for (const std::string& path : found) list.push_back({path, "", 0, true});
    } else if (is_folder(text)) {
      const std::vector<std::string> found = folder_pictures(text);
      if (found.empty()) throw_input("the folder '" + text + "' holds no picture");
      for (const std::string& path : found) list.push_back({path, "", 0, true});
    } else {
      list.push_back({text, "", 0, false});
    }
  }
  // What was named and found, or found twice, is there once.
  for (const Test& test : list)
    if (!test.searched) known.insert(test.path);
  std::erase_if(list, [&](const Test& test) { return test.searched && !known.insert(test.path).second; });
  return list;
}

void miss(bool skip, const std::string& what) {
  if (!skip) throw_input(what + "; --skip-missing compares the others");
  warn(what);
}

std::vector<ComparePair> pair_sequences(const std::vector<Test>& tests, const std::string& reference, bool skip) {
  const std::vector<int> frames = find_frames(reference);
  const std::set<int> of_reference(frames.begin(), frames.end());
  std::map<std::string, std::set<int>> of_test;
  for (const Test& test : tests) {
    if (test.sequence.empty())
      throw_usage("--ref '" + reference + "' has a frame number, but the test picture '" + test.path + "' has none");
    of_test[test.sequence].insert(test.frame);
  }
  for (const auto& [sequence, have] : of_test) {
    std::vector<int> without_reference, without_test;
    std::set_difference(have.begin(), have.end(), of_reference.begin(), of_reference.end(),
                        std::back_inserter(without_reference));
    std::set_difference(of_reference.begin(), of_reference.end(), have.begin(), have.end(),
                        std::back_inserter(without_test));
    std::vector<std::string> parts;
    if (!without_reference.empty())
      parts.push_back("--ref '" + reference + "' lacks " + number_ranges(without_reference));
    if (!without_test.empty()) parts.push_back("'" + sequence + "' lacks " + number_ranges(without_test));
    if (!parts.empty()) miss(skip, "frames are missing: " + join(parts, "; "));
  }
  std::vector<ComparePair> pairs;
  for (const Test& test : tests)
    if (of_reference.count(test.frame))
      pairs.push_back({test.path, frame_path(reference, test.frame), test.sequence, test.frame});
  return pairs;
}

std::string quoted_list(const std::vector<std::string>& names) {
  constexpr size_t kMost = 12;
  std::vector<std::string> first = names;
  if (first.size() > kMost) first.resize(kMost);
  return "'" + join(first, "', '") + "'" +
         (names.size() > kMost ? " and " + std::to_string(names.size() - kMost) + " more" : "");
}

std::vector<ComparePair> pair_by_name(const std::vector<Test>& tests, const std::string& folder, bool skip) {
  const std::vector<std::string> pictures = folder_pictures(folder);
  std::map<std::string, std::string> by_name;
  std::map<std::string, std::vector<std::string>> by_stem;
  for (const std::string& path : pictures) {
    by_name[fs::path(path).filename().string()] = path;
    by_stem[fs::path(path).stem().string()].push_back(path);
  }
  std::vector<ComparePair> pairs;
  std::vector<std::string> missing;
  std::set<std::string> used;
  bool searched = true;
  for (const Test& test : tests) {
    searched = searched && test.searched;
    const auto same = by_name.find(fs::path(test.path).filename().string());
    const auto alike = by_stem.find(fs::path(test.path).stem().string());
    std::string reference;
    if (same != by_name.end())
      reference = same->second;
    else if (alike != by_stem.end() && alike->second.size() == 1)
      reference = alike->second[0];
    if (reference.empty()) {
      missing.push_back(test.path);
      continue;
    }
    used.insert(reference);
    pairs.push_back({test.path, reference, test.sequence, test.frame});
  }
  if (!missing.empty()) miss(skip, "--ref '" + folder + "' holds no picture of the name of " + quoted_list(missing));
  // Pictures that somebody named are the ones he wants; of a whole folder or pattern, none should be lost.
  std::vector<std::string> left;
  for (const std::string& path : pictures)
    if (!used.count(path)) left.push_back(path);
  if (searched && !left.empty()) miss(skip, "no test picture has the name of the reference " + quoted_list(left));
  return pairs;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

}  // namespace

std::string number_ranges(const std::vector<int>& numbers, size_t most) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    ranges.push_back(std::to_string(numbers[i]) + (end - i > 1 ? "-" + std::to_string(numbers[end - 1]) : ""));
    i = end;
  }
  const bool cut = ranges.size() > most;
  if (cut) ranges.resize(most);
  return join(ranges, ", ") + (cut ? " ... (" + std::to_string(numbers.size()) + " in all)" : "");
}

std::vector<ComparePair> pair_pictures(const std::vector<std::string>& tests, const std::string& reference,
                                       bool skip_missing) {
  const std::vector<Test> list = expand_tests(tests);
  std::vector<ComparePair> pairs;
  if (is_sequence(reference)) {
    pairs = pair_sequences(list, reference, skip_missing);
  } else if (is_folder(reference)) {
    pairs = pair_by_name(list, reference, skip_missing);
  } else {
    std::string one = reference;
    if (is_pattern(reference)) {
      const std::vector<std::string> found = expand_pattern(reference);
      if (found.empty()) throw_input("--ref '" + reference + "' matches no file");
      if (found.size() > 1)
        throw_usage("--ref '" + reference + "' matches " + std::to_string(found.size()) +
                    " files; name one for all, or their folder to find each picture's by its name");
      one = found[0];
    }
    for (const Test& test : list) {
      if (list.size() > 1 && same_file(test.path, one)) {
        warn("'" + test.path + "' is the reference itself and is left out");
        continue;
      }
      pairs.push_back({test.path, one, test.sequence, test.frame});
    }
  }
  if (pairs.empty()) throw_input("no picture is left to compare with --ref '" + reference + "'");
  return pairs;
}

}  // namespace triad::app
