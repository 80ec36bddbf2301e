// SPDX-License-Identifier: Apache-2.0
// The files that a study reads, and whether one of them has changed since.
#pragma once

#include <string>
#include <triad/evaluation/study.hpp>
#include <vector>

namespace triad::app {

// One for each file: the name it goes by in the plan, and its path.
using StudyFiles = std::vector<std::pair<std::string, std::string>>;

// Pictures, scenes with the files that they name, layouts and what else the values of `settings` (all combinations,
// as whole_settings() has them) name, in chains and parameters too; each once. Bundled scenes are among them,
// whatever else is bundled belongs to the program. Throws Error(kInput) for a file that cannot be read.
StudyFiles study_files(const StudyPlan& plan, const std::vector<StudySettings>& settings);

// Their names with length and a hash of the contents: "1234 bytes, 89abcdef01234567". Times do not count, as a copy
// of a file is as good. Throws Error(kInput).
StudySettings file_contents(const StudyFiles& files);

// Refuses to write the results as JSON over the plan, what it reads, or what the study keeps in `folder` ("": none).
// Throws Error(kUsage).
void check_json_path(const std::string& json, const StudyPlan& plan, const StudyFiles& files,
                     const std::string& folder);

}  // namespace triad::app
