// SPDX-License-Identifier: Apache-2.0
// The folder in which a study keeps its runs, so that what was interrupted goes on where it was.
//
//   plan.json           what is studied, from which files, and on how many threads: a folder serves one plan only
//   runs/3-0017.json    turn 3 of the settings number 17, written at once or not at all
//   references/         what the work keeps to judge by
//   pictures/           what came out, one for each setting
//   results.json, table.txt   at the end
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <triad/evaluation/study.hpp>

namespace triad {

class StudyFolder {
 public:
  // Makes the folder, or goes on with it. `facts`: what else the runs depend on ("threads", "2"). `files`: the files
  // that they read, and what tells when one of them has changed. Throws Error(kInput): a folder that cannot be made
  // or written to, that holds other things than a study, or a study of other settings, seeds, repeats, facts or
  // files: then it says what differs. Titles, columns and comparisons may differ. Also one that another process works
  // in. What a process that was killed has left half-written in a study's folder is removed.
  StudyFolder(const std::string& path, const StudyPlan& plan, const std::vector<StudySettings>& settings,
              const StudySettings& facts, const StudySettings& files);
  ~StudyFolder();

  // A run that is there. One whose file cannot be read, is of another run or lacks measures counts as not there.
  std::optional<Measurements> find(const StudyTurn& turn) const;
  void keep(const StudyTurn& turn, const Measurements& measured) const;

  // Where what the work keeps lies in the folder `path`.
  static std::string references(const std::string& path);
  // The path of a picture for these settings, numbered, and named after them.
  std::string picture(size_t setting) const;
  // results.json and table.txt
  void finish(const std::string& json, const std::string& table) const;

 private:
  std::string run_path(const StudyTurn& turn) const;

  class Lock;
  std::string path_;
  std::unique_ptr<Lock> lock_;
  std::vector<StudySettings> settings_;
};

}  // namespace triad
