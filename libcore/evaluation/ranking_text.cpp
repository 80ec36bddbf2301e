// SPDX-License-Identifier: Apache-2.0
// Rankings as a table, CSV and JSON.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/ranking.hpp>

namespace triad {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

std::string short_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.5g", value);
  return buffer;
}

const MetricResult* find_result(const JudgedPicture& picture, const std::string& label) {
  for (const MetricResult& result : picture.results)
    if (result.label == label) return &result;
  return nullptr;
}

// The columns of one metric's list, in the order in which pictures first have them.
struct Column {
  std::string score, unit;
};

std::vector<Column> columns_of(const std::vector<JudgedPicture>& pictures, const std::string& label,
                               const std::vector<PooledName>* pooled) {
  std::vector<Column> columns;
  const auto add = [&](const MetricResult::Score& score) {
    if (std::none_of(columns.begin(), columns.end(), [&](const Column& c) { return c.score == score.name; }))
      columns.push_back({score.name, score.unit});
  };
  const auto wanted = [&](const std::string& name) {
    return !pooled || std::any_of(pooled->begin(), pooled->end(), [&](const PooledName& p) {
      return (p.label.empty() || p.label == label) && p.score == name;
    });
  };
  for (const JudgedPicture& picture : pictures)
    if (const MetricResult* result = find_result(picture, label))
      for (const auto& score : result->scores) add(score);
  for (const JudgedPicture& picture : pictures) {
    const MetricResult* result = find_result(picture, label);
    if (result && result->pooled && !result->nonfinite_failed)
      for (const auto& score : result->pooled->scores)
        if (wanted(score.name)) add(score);
  }
  return columns;
}

// Cells of text, the first column and the last (remarks) to the left, the others to the right.
class Grid {
 public:
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const {
    std::vector<size_t> widths;
    for (const auto& row : rows_)
      for (size_t c = 0; c < row.size(); ++c) {
        if (widths.size() <= c) widths.push_back(0);
        widths[c] = std::max(widths[c], row[c].size());
      }
    std::string text;
    for (const auto& row : rows_) {
      std::string line;
      for (size_t c = 0; c < row.size(); ++c) {
        const std::string fill(widths[c] - row[c].size(), ' ');
        const bool left = c == 1 || c + 1 == widths.size();
        line += "  " + (left ? row[c] + fill : fill + row[c]);
      }
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
  }

 private:
  std::vector<std::vector<std::string>> rows_;
};

double mean_over(const std::vector<JudgedPicture>& pictures, const std::vector<size_t>& which,
                 const std::string& label, const std::string& score, bool& any) {
  double sum = 0;
  size_t count = 0;
  for (const size_t i : which) {
    const MetricResult* result = find_result(pictures[i], label);
    const MetricResult::Score* found = result ? find_score(*result, score) : nullptr;
    if (!found) continue;
    sum += found->value;
    ++count;
  }
  any = count > 0;
  return any ? sum / static_cast<double>(count) : 0;
}

std::string mean_cell(const std::vector<JudgedPicture>& pictures, const std::vector<size_t>& which,
                      const std::string& label, const std::string& score) {
  bool any = false;
  const double mean = mean_over(pictures, which, label, score, any);
  return any ? short_number(mean) : "-";
}

std::string remark_on(const JudgedPicture& picture, const std::string& label,
                      const std::vector<Threshold>& thresholds) {
  const MetricResult* result = find_result(picture, label);
  if (!result) return "not compared";
  if (result->nonfinite_failed)
    return std::to_string(result->nonfinite.nan) + " NaN, " + std::to_string(result->nonfinite.inf) + " infinite";
  return failed_thresholds(thresholds, {*result}).empty() ? "" : "FAILED";
}

std::vector<std::string> header(const std::string& first, const std::string& name,
                                const std::vector<Column>& columns) {
  std::vector<std::string> row{first, name};
  for (const Column& column : columns) row.push_back(column.score + (column.unit.empty() ? "" : " " + column.unit));
  row.emplace_back();
  return row;
}

std::vector<std::string> picture_row(const std::string& first, const JudgedPicture& picture, const std::string& label,
                                     const std::vector<Column>& columns, const TableOptions& options) {
  std::vector<std::string> row{first, printable(picture.test)};
  const MetricResult* result = find_result(picture, label);
  for (const Column& column : columns) {
    const MetricResult::Score* score = result ? find_score(*result, column.score) : nullptr;
    row.push_back(score ? short_number(score->value) : "-");
  }
  row.push_back(remark_on(picture, label, options.thresholds));
  return row;
}

size_t shown(size_t all, size_t top) { return top == 0 ? all : std::min(all, top); }

std::string left_out(size_t all, size_t top) {
  const size_t more = all - shown(all, top);
  return more == 0 ? "" : "     ... and " + std::to_string(more) + " more; --top 0 lists all\n";
}

std::string failed_frames(const std::vector<JudgedPicture>& pictures, const Ranking::Entry& entry,
                          const std::string& label, const TableOptions& options) {
  size_t failed = 0;
  for (const size_t i : entry.pictures) failed += !remark_on(pictures[i], label, options.thresholds).empty();
  return failed == 0 ? "" : "FAILED in " + std::to_string(failed);
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

}  // namespace

std::string ranking_to_table(const std::vector<JudgedPicture>& pictures, const std::vector<Ranking>& rankings,
                             const TableOptions& options) {
  std::string text;
  for (const Ranking& ranking : rankings) {
    const std::vector<Column> columns = columns_of(pictures, ranking.label, &options.pooled);
    const auto is_sequence_entry = [&](const Ranking::Entry& entry) {
      return !pictures[entry.pictures[0]].sequence.empty();
    };
    if (ranking.entries.size() > 1) {
      text += (text.empty() ? "" : "\n") + ranking.label + ": best first by " + ranking.by_text() + "\n";
      Grid grid;
      grid.add(header("rank", "picture", columns));
      for (size_t e = 0; e < shown(ranking.entries.size(), options.top); ++e) {
        const Ranking::Entry& entry = ranking.entries[e];
        const std::string rank = entry.rank > 0 ? std::to_string(entry.rank) : "-";
        if (!is_sequence_entry(entry)) {
          grid.add(picture_row(rank, pictures[entry.pictures[0]], ranking.label, columns, options));
          continue;
        }
        std::vector<std::string> row{rank, printable(entry.name)};
        for (const Column& column : columns)
          row.push_back(mean_cell(pictures, entry.pictures, ranking.label, column.score));
        row.push_back(failed_frames(pictures, entry, ranking.label, options));
        grid.add(std::move(row));
      }
      text += grid.text() + left_out(ranking.entries.size(), options.top);
    }
    for (const Ranking::Entry& entry : ranking.entries) {
      if (!is_sequence_entry(entry)) continue;
      const size_t frames = entry.pictures.size();
      text += (text.empty() ? "" : "\n") + ranking.label + ", " + printable(entry.name) + ": worst first by " +
              ranking.by_text() + "\n";
      Grid grid;
      grid.add(header("frame", "picture", columns));
      std::vector<std::string> mean{"", "mean of " + std::to_string(frames) + " frames; worst is " +
                                            std::to_string(pictures[entry.pictures[0]].frame)};
      for (const Column& column : columns)
        mean.push_back(mean_cell(pictures, entry.pictures, ranking.label, column.score));
      mean.push_back(failed_frames(pictures, entry, ranking.label, options));
      for (size_t f = 0; f < shown(frames, options.top); ++f) {
        const JudgedPicture& picture = pictures[entry.pictures[f]];
        grid.add(picture_row(std::to_string(picture.frame), picture, ranking.label, columns, options));
      }
      grid.add(std::move(mean));
      text += grid.text() + left_out(frames, options.top);
    }
  }
  return text;
}

std::string pictures_to_csv(const std::vector<JudgedPicture>& pictures) {
  std::vector<std::string> labels;
  for (const JudgedPicture& picture : pictures)
    for (const MetricResult& result : picture.results)
      if (std::find(labels.begin(), labels.end(), result.label) == labels.end()) labels.push_back(result.label);
  std::vector<std::pair<std::string, std::string>> columns;
  for (const std::string& label : labels)
    for (const Column& column : columns_of(pictures, label, nullptr)) columns.emplace_back(label, column.score);
  std::string text = "test,reference,sequence,frame,nan,inf,error";
  for (const auto& [label, score] : columns) text += "," + csv_field(label + "." + score);
  text += "\r\n";
  for (const JudgedPicture& picture : pictures) {
    const bool judged = !picture.results.empty();
    text += csv_field(picture.test) + "," + csv_field(picture.reference) + "," + csv_field(picture.sequence) + "," +
            (picture.sequence.empty() ? "" : std::to_string(picture.frame)) + "," +
            (judged ? std::to_string(picture.results[0].nonfinite.nan) : "") + "," +
            (judged ? std::to_string(picture.results[0].nonfinite.inf) : "") + "," + csv_field(picture.error);
    for (const auto& [label, name] : columns) {
      const MetricResult* result = find_result(picture, label);
      const MetricResult::Score* score = result ? find_score(*result, name) : nullptr;
      text += "," + (score ? format_double(score->value) : std::string());
    }
    text += "\r\n";
  }
  return text;
}

namespace {

Json reading(const ReadOptions& options) {
  Json said = Json::object();
  if (!options.part.empty()) said["part"] = options.part;
  if (!options.layer.empty()) said["layer"] = options.layer;
  if (!options.channels.empty()) said["channels"] = options.channels;
  if (!options.colour_space.empty()) said["space"] = options.colour_space;
  if (options.cells) said["cells"] = std::to_string(options.cells->x) + "x" + std::to_string(options.cells->y);
  return said;
}

}  // namespace

std::string ranking_to_json(const std::vector<JudgedPicture>& pictures, const std::vector<Ranking>& rankings,
                            const std::vector<ShownFile>& files, const HowRead& how) {
  std::vector<MetricResult> results;
  for (const JudgedPicture& picture : pictures)
    results.insert(results.end(), picture.results.begin(), picture.results.end());
  Json root = Json::parse(results_to_json(results));
  const Json test = reading(how.tests), reference = reading(how.references);
  if (!test.empty() || !reference.empty()) root["reading"] = {{"test", test}, {"reference", reference}};
  root["ranking"] = Json::array();
  Json sequences = Json::array(), failed = Json::array(), shown_files = Json::array();
  for (const Ranking& ranking : rankings) {
    Json list;
    list["label"] = ranking.label;
    list["score"] = ranking.by_text();
    list["order"] = Json::array();
    for (const Ranking::Entry& entry : ranking.entries) {
      const JudgedPicture& first = pictures[entry.pictures[0]];
      Json object;
      object["rank"] = entry.rank > 0 ? Json(entry.rank) : Json(nullptr);
      object[first.sequence.empty() ? "test" : "sequence"] = entry.name;
      if (first.sequence.empty()) object["reference"] = first.reference;
      object["value"] = entry.value ? number(*entry.value) : Json(nullptr);
      if (!first.sequence.empty()) {
        object["frames"] = entry.pictures.size();
        object["worst-frame"] = first.frame;
        Json sequence{{"sequence", entry.name}, {"label", ranking.label}, {"score", ranking.by_text()}};
        sequence["frames"] = Json::array();
        for (const size_t i : entry.pictures) {
          const MetricResult* result = find_result(pictures[i], ranking.by.label);
          const MetricResult::Score* score = result ? find_score(*result, ranking.by.score) : nullptr;
          sequence["frames"].push_back({{"frame", pictures[i].frame},
                                        {"test", pictures[i].test},
                                        {"value", score ? number(score->value) : Json(nullptr)}});
        }
        sequence["mean"] = Json::object();
        for (const Column& column : columns_of(pictures, ranking.label, nullptr)) {
          bool any = false;
          const double mean = mean_over(pictures, entry.pictures, ranking.label, column.score, any);
          if (any) sequence["mean"][column.score] = number(mean);
        }
        sequences.push_back(std::move(sequence));
      }
      list["order"].push_back(std::move(object));
    }
    root["ranking"].push_back(std::move(list));
  }
  for (const JudgedPicture& picture : pictures)
    if (!picture.error.empty())
      failed.push_back({{"test", picture.test}, {"reference", picture.reference}, {"error", picture.error}});
  for (const ShownFile& file : files) {
    Json object{{"kind", file.kind}, {"test", file.test}};
    if (!file.label.empty()) object["label"] = file.label;
    object["file"] = file.file;
    if (!file.colour_map.empty()) object["colour-map"] = file.colour_map;
    for (const auto& scale : file.scales) object["scales"][scale.label] = {{"low", scale.low}, {"high", scale.high}};
    shown_files.push_back(std::move(object));
  }
  if (!sequences.empty()) root["sequences"] = std::move(sequences);
  if (!failed.empty()) root["failed"] = std::move(failed);
  if (!shown_files.empty()) root["files"] = std::move(shown_files);
  return json_text(std::move(root), 2);
}

}  // namespace triad
