// SPDX-License-Identifier: Apache-2.0
// What studies of strategies judge by, drawn once and kept.
#pragma once

#include <deque>
#include <map>
#include <triad/colour/colour.hpp>

#include "study_source.hpp"

namespace triad::app {

struct StudyReference {
  JudgePicture picture;
  double rmse = 0;  // the estimated error of a pixel's value; 0: exact, a file, or points that are not random
};

// Not thread-safe. References for the same source and text are the same picture, in memory once.
class StudyReferences {
 public:
  // `folder`: where they are kept as EXR, with what they are of as JSON beside, and found again; "" nowhere.
  StudyReferences(std::string folder, const ColourConfig& colours) : folder_(std::move(folder)), colours_(colours) {}

  // No seed that a plan counts up to: the samples of a truth shall not be those that it judges.
  static constexpr uint64_t kTruthSeed = 0x7265666572656e63;  // "referenc"
  // The picture of `source`, which was made as `wanted` says. `text`: a strategy, or a picture's file. Throws
  // Error(kInput), `where` first: a file that is not there or of another size; and what the strategy throws. Ctrl-C
  // ends it with Error(kCancelled).
  // What it returns lasts until the next call, truths for good: of the references with other seeds only the last few
  // hundred megabytes are kept in memory.
  const StudyReference& get(const SourceRequest& wanted, const Source& source, const std::string& text, uint64_t seed,
                            const std::string& where);
  // Throws what get() would throw of a file, by its header.
  void check_file(const std::string& path, const SourceRequest& wanted, const std::string& where) const;
  // The means of the pixels' cells.
  const StudyReference& averaged(const StudyReference& wide);

  // Whether a text names a file.
  static bool is_file(const std::string& text);

 private:
  void drop_oldest(const SourceRequest& wanted);
  StudyReference load(const std::string& path, const SourceRequest& wanted, const std::string& where) const;
  StudyReference draw(const SourceRequest& wanted, const Source& source, const std::string& text, uint64_t seed,
                      const std::string& where) const;

  const std::string folder_;
  const ColourConfig& colours_;
  std::map<std::string, StudyReference> known_;
  std::deque<std::string> seeded_;  // the keys of those with other seeds than a truth's, the oldest first
};

// A picture's first three channels.
Image colour_only(const Image& image);

}  // namespace triad::app
