// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/ranking.hpp>

namespace triad {
namespace {

constexpr double kNoScore = std::numeric_limits<double>::infinity();

const MetricResult* find_result(const JudgedPicture& picture, const std::string& label) {
  for (const MetricResult& result : picture.results)
    if (result.label == label) return &result;
  return nullptr;
}

const MetricResult::Score* find_score(const JudgedPicture& picture, const RankKey& key) {
  const MetricResult* result = find_result(picture, key.label);
  return result ? find_score(*result, key.score) : nullptr;
}

double badness_of(const MetricResult::Score* score) {
  return score && !std::isnan(score->value) ? badness(score->value, score->better) : kNoScore;
}

// A sequence's mean is of the values themselves, so that a bias may cancel over frames as it does over pixels.
void add_sequence(const std::vector<JudgedPicture>& pictures, const RankKey& key, Ranking::Entry& entry,
                  int& better) {
  double sum = 0;
  size_t count = 0;
  std::vector<double> bad(pictures.size(), kNoScore);
  for (const size_t i : entry.pictures) {
    const MetricResult::Score* score = find_score(pictures[i], key);
    if (!score) continue;
    bad[i] = badness_of(score);
    better = score->better;
    sum += score->value;
    ++count;
  }
  if (count > 0) entry.value = sum / static_cast<double>(count);
  // Frames without a score are the worst of all.
  std::stable_sort(entry.pictures.begin(), entry.pictures.end(), [&](size_t a, size_t b) { return bad[a] > bad[b]; });
}

// A mean over frames is not a number where it is of infinities of both signs. Nothing can be said to be better than
// that, or worse.
bool is_missing(const Ranking::Entry& entry) { return !entry.value || std::isnan(*entry.value); }

Ranking rank_by(const std::vector<JudgedPicture>& pictures, const RankKey& key) {
  Ranking ranking;
  std::map<std::string, size_t> sequences;  // to the entry
  for (size_t i = 0; i < pictures.size(); ++i) {
    const JudgedPicture& picture = pictures[i];
    if (picture.sequence.empty()) {
      ranking.entries.push_back({picture.test, {i}, std::nullopt, 0});
      continue;
    }
    const auto [place, fresh] = sequences.emplace(picture.sequence, ranking.entries.size());
    if (fresh) ranking.entries.push_back({picture.sequence, {}, std::nullopt, 0});
    ranking.entries[place->second].pictures.push_back(i);
  }
  std::vector<std::pair<double, size_t>> order;
  for (size_t e = 0; e < ranking.entries.size(); ++e) {
    Ranking::Entry& entry = ranking.entries[e];
    int better = -1;
    if (pictures[entry.pictures[0]].sequence.empty()) {
      if (const MetricResult::Score* score = find_score(pictures[entry.pictures[0]], key)) {
        entry.value = score->value;
        better = score->better;
      }
    } else {
      add_sequence(pictures, key, entry, better);
    }
    order.emplace_back(is_missing(entry) ? kNoScore : badness(*entry.value, better), e);
  }
  const auto missing = [&](size_t e) { return is_missing(ranking.entries[e]); };
  std::stable_sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    if (missing(a.second) != missing(b.second)) return missing(b.second);
    return a.first < b.first;
  });
  std::vector<Ranking::Entry> sorted;
  for (size_t place = 0; place < order.size(); ++place) {
    Ranking::Entry& entry = ranking.entries[order[place].second];
    if (!is_missing(entry))
      entry.rank = place > 0 && order[place].first == order[place - 1].first ? sorted.back().rank
                                                                             : static_cast<int>(place) + 1;
    sorted.push_back(std::move(entry));
  }
  ranking.entries = std::move(sorted);
  return ranking;
}

}  // namespace

const MetricResult::Score* find_score(const MetricResult& result, const std::string& name) {
  const auto in = [&](const std::vector<MetricResult::Score>& scores) -> const MetricResult::Score* {
    for (const auto& score : scores)
      if (score.name == name) return &score;
    return nullptr;
  };
  if (const MetricResult::Score* own = in(result.scores)) return own;
  return result.pooled && !result.nonfinite_failed ? in(result.pooled->scores) : nullptr;
}

double badness(double value, int better) { return better < 0 ? value : better > 0 ? -value : std::abs(value); }

RankKey parse_rank_key(const std::string& text, const std::vector<ChainItem>& metrics, PluginHost& host) {
  const size_t dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    throw_usage("--sort '" + text + "' is not LABEL.SCORE, as in error.rmse");
  const RankKey key{text.substr(0, dot), text.substr(dot + 1)};
  std::vector<std::string> labels;
  for (const ChainItem& metric : metrics) {
    labels.push_back(metric.label);
    if (metric.label != key.label) continue;
    const triad_desc& desc = *host.find(metric.id).desc;
    std::vector<std::string> names;
    for (uint32_t s = 0; s < desc.n_scores; ++s) names.emplace_back(desc.scores[s]->name);
    const std::string own = join(names, "', '");
    for (const std::string& name : pooled_score_names())
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    if (std::find(names.begin(), names.end(), key.score) == names.end())
      throw_usage("--sort '" + text + "': '" + metric.id + "' has no score '" + key.score + "'" +
                  did_you_mean(key.score, names) + "; it has '" + own + "', and of its error map '" +
                  join(pooled_score_names(), "', '") + "'");
    return key;
  }
  throw_usage("--sort '" + text + "': no metric is labelled '" + key.label + "'" + did_you_mean(key.label, labels) +
              "; there " + (labels.size() == 1 ? "is '" : "are '") + join(labels, "', '") + "'");
}

std::string main_score(const std::string& metric, PluginHost& host) {
  const triad_desc& desc = *host.find(metric).desc;
  for (uint32_t s = 0; s < desc.n_scores; ++s)
    if (desc.scores[s]->better != 0) return desc.scores[s]->name;
  return desc.n_scores > 0 ? desc.scores[0]->name : "";
}

std::vector<Ranking> rank_pictures(const std::vector<JudgedPicture>& pictures, const std::vector<ChainItem>& metrics,
                                   const std::vector<std::string>& main_scores, const std::optional<RankKey>& key) {
  std::vector<Ranking> rankings;
  for (size_t m = 0; m < metrics.size(); ++m) {
    const RankKey by = key.value_or(RankKey{metrics[m].label, main_scores[m]});
    Ranking ranking = rank_by(pictures, by);
    ranking.label = metrics[m].label;
    ranking.by = by;
    rankings.push_back(std::move(ranking));
  }
  return rankings;
}

}  // namespace triad
