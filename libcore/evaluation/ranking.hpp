// SPDX-License-Identifier: Apache-2.0
// Many pictures against a reference: which is best, which frames are worst; as a table, CSV and JSON.
#pragma once

#include <optional>
#include <string>
#include <triad/evaluation/results.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad {

// One picture and what its comparison gave.
struct JudgedPicture {
  std::string test, reference;
  std::string sequence;  // the pattern that it is a frame of, or ""
  int frame = 0;
  std::vector<MetricResult> results;  // one per metric, in the metrics' order; empty where there is an error
  std::string error;                  // why there are none
};

// "LABEL.SCORE": what decides about the order.
struct RankKey {
  std::string label, score;
};
// Throws Error(kUsage) naming --sort, and Error(kUsage) as check_threshold_names() does for unknown labels and
// scores.
RankKey parse_rank_key(const std::string& text, const std::vector<ChainItem>& metrics, PluginHost& host);

// The score that pictures are ranked by unless told: the metric's first that has a better side (lower or higher),
// else its first.
std::string main_score(const std::string& metric, PluginHost& host);

// A metric's own score of that name, else the pooled one; null if the result has neither.
const MetricResult::Score* find_score(const MetricResult& result, const std::string& name);
// How bad a score is: smaller is better, whichever way the score runs.
double badness(double value, int better);

// A rank list of one metric. Competition ranking: equal scores share a rank, and the next one counts them all.
// Entries without a score (not finite values, an error) come last and have the rank 0.
struct Ranking {
  struct Entry {
    std::string name;              // the test picture's path, or the sequence's pattern
    std::vector<size_t> pictures;  // indices into the judged pictures: one, or a sequence's frames, worst first
    std::optional<double> value;   // of the score; a sequence's is the mean of its frames'
    int rank = 0;
  };
  std::string label;           // of the metric listed
  RankKey by;                  // what decides about the order, perhaps another metric's score
  std::vector<Entry> entries;  // best first

  // "rmse", or "display.rmse" where another metric decides.
  std::string by_text() const { return by.label == label ? by.score : by.label + "." + by.score; }
};

// One per metric, each by its own main score, or all by `key`. `main_scores`: as main_score() has them, by metric.
std::vector<Ranking> rank_pictures(const std::vector<JudgedPicture>& pictures, const std::vector<ChainItem>& metrics,
                                   const std::vector<std::string>& main_scores, const std::optional<RankKey>& key);

struct TableOptions {
  size_t top = 20;                    // rows of a list; 0 all
  std::vector<PooledName> pooled;     // shown beside the metrics' own scores
  std::vector<Threshold> thresholds;  // rows that cross one are marked
};

// For the terminal: for each metric a list of the pictures and the means of sequences, best first; then each
// sequence's frames, worst first, below the mean of all and the worst one's number. Ends with a line break.
std::string ranking_to_table(const std::vector<JudgedPicture>& pictures, const std::vector<Ranking>& rankings,
                             const TableOptions& options);

// One line per picture, in the order given: test,reference,sequence,frame,nan,inf,error,LABEL.SCORE... with every
// score that any picture has, pooled ones (but for those that have the name of one of the metric's own) after the
// metric's own; RFC 4180. Empty where there is no score.
std::string pictures_to_csv(const std::vector<JudgedPicture>& pictures);

// A file that shows something of a picture.
struct ShownFile {
  std::string kind;  // "map", "sheet"
  std::string test, label, file;
  struct Scale {
    std::string label;
    double low = 0, high = 1;  // what the first and last colour stand for
  };
  std::vector<Scale> scales;  // one for each map in colours
  std::string colour_map;     // "" for a map of floats
};

// What results_to_json() writes, with
// "ranking":[{"label","score","order":[{"rank","test" or "sequence","reference","value","frames","worst-frame"}]}],
// "sequences":[{"sequence","label","score","frames":[{"frame","test","value"}] worst first,"mean":{}}],
// "failed":[{"test","reference","error"}] and
// "files":[{"kind","test","label","file","colour-map","scales":{LABEL:{"low","high"}}}],
// and "reading":{"test":{"part","layer","channels","space","cells"},"reference":{}}, how the pictures were read where
// that was asked for; each of the last four only where there is something to say.
struct HowRead {
  ReadOptions tests{}, references{};
};
std::string ranking_to_json(const std::vector<JudgedPicture>& pictures, const std::vector<Ranking>& rankings,
                            const std::vector<ShownFile>& files, const HowRead& how = {});

}  // namespace triad
