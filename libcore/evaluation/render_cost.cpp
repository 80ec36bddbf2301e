// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/render_cost.hpp>
#include <tuple>

namespace fs = std::filesystem;

namespace triad {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return c >= 'a' && c <= 'z'; }
bool is_separator(char c) { return c == '-' || c == '_' || c == '.' || c == ' ' || c == '='; }

// A number in a name, with the letters beside it, perhaps across one separator.
struct NumberWord {
  size_t begin = 0, end = 0, before_at = 0, after_at = 0;
  std::string text, before, after;
  bool glued_before = false, glued_after = false;  // no separator between
  bool used = false;
};

std::vector<NumberWord> number_words(const std::string& stem) {
  std::vector<NumberWord> words;
  const size_t n = stem.size();
  for (size_t i = 0; i < n;) {
    if (!is_digit(stem[i])) {
      ++i;
      continue;
    }
    NumberWord word;
    word.begin = i;
    while (i < n && is_digit(stem[i])) ++i;
    if (i + 1 < n && stem[i] == '.' && is_digit(stem[i + 1]))
      for (++i; i < n && is_digit(stem[i]);) ++i;
    word.end = i;
    word.text = stem.substr(word.begin, word.end - word.begin);
    word.glued_before = word.begin > 0 && !is_separator(stem[word.begin - 1]);
    word.glued_after = word.end < n && !is_separator(stem[word.end]);
    size_t left = word.begin;
    if (left > 0 && !word.glued_before) --left;
    const size_t left_end = left;
    while (left > 0 && is_letter(stem[left - 1])) --left;
    word.before_at = left;
    word.before = stem.substr(left, left_end - left);
    size_t right = word.end;
    if (right < n && !word.glued_after) ++right;
    const size_t right_begin = right;
    while (right < n && is_letter(stem[right])) ++right;
    word.after_at = right_begin;
    if (right == n || !is_digit(stem[right])) word.after = stem.substr(right_begin, right - right_begin);
    words.push_back(word);
  }
  return words;
}

bool one_of(const std::string& text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

// Seconds that a unit stands for, if it is one.
std::optional<double> unit_seconds(const std::string& unit) {
  if (one_of(unit, {"s", "sec", "secs", "second", "seconds"})) return 1;
  if (unit == "ms") return 1e-3;
  if (one_of(unit, {"min", "mins", "minutes"})) return 60;
  return std::nullopt;
}

void put(std::optional<double>& slot, double value, const std::string& path, const std::string& what) {
  if (slot && *slot != value)
    throw_input(path + ": its name tells two numbers of " + what + ", " + format_double(*slot) + " and " +
                format_double(value) + "; rename it, or take them from elsewhere (--samples-from)");
  if (!(value > 0))
    throw_input(
        path + ": its name tells of " + format_double(value) + " " + what +
        ", which must be above 0; if that number means something else, say --samples-from metadata or a table");
  slot = value;
}

double positive_number(const std::string& path, const std::string& key, const std::string& text) {
  const auto value = parse_double(text);
  if (!value || !std::isfinite(*value) || *value <= 0)
    throw_input(path + ": its metadata '" + key + "' is '" + text +
                "', which is no number above 0; take it from elsewhere (--samples-from name or a table)");
  return *value;
}

// "12.5", "02:03.25", "1:02:03.25".
double clock_seconds(const std::string& path, const std::string& key, const std::string& text) {
  double seconds = 0;
  size_t at = 0;
  for (int parts = 1;; ++parts) {
    const size_t colon = text.find(':', at);
    const auto value =
        parse_double(std::string_view(text).substr(at, colon == std::string::npos ? colon : colon - at));
    if (!value || !std::isfinite(*value) || *value < 0 || parts > 3) break;
    seconds = seconds * 60 + *value;
    if (colon != std::string::npos) {
      at = colon + 1;
      continue;
    }
    if (seconds > 0) return seconds;
    break;
  }
  throw_input(path + ": its metadata '" + key + "' is '" + text +
              "', which is no time above 0; take it from elsewhere (--samples-from name or a table)");
}

double pixels_of(const ImageSpec& spec) { return static_cast<double>(spec.width) * spec.height; }

std::vector<std::vector<std::string>> parse_csv(const std::string& text, const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string field;
  bool quoted = false, any = false;
  const auto end_field = [&] {
    row.push_back(field);
    field.clear();
  };
  const auto end_row = [&] {
    if (any || !row.empty()) {
      end_field();
      rows.push_back(row);
    }
    row.clear();
    any = false;
  };
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"')
        field += c;
      else if (i + 1 < text.size() && text[i + 1] == '"')
        field += text[++i];
      else
        quoted = false;
    } else if (c == '"' && field.empty()) {
      quoted = any = true;
    } else if (c == ',') {
      end_field();
      any = true;
    } else if (c == '\n') {
      end_row();
    } else if (c != '\r') {
      field += c;
      any = true;
    }
  }
  if (quoted) throw_input(path + ": a quoted field does not end");
  end_row();
  return rows;
}

std::string normal(const fs::path& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path.lexically_normal().string() : found.string();
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

RenderCost cost_from_name(const std::string& path) {
  const std::string stem = lower(fs::path(path).stem().string());
  std::vector<NumberWord> words = number_words(stem);
  RenderCost cost;
  size_t taken = std::string::npos;  // where a unit stands that belongs to the number before it: 64spp_2
  for (NumberWord& word : words) {
    const double value = *parse_double(word.text);
    const bool free = word.before_at != taken;
    if (one_of(word.after, {"spp", "sample", "samples"})) {
      put(cost.samples, value, path, "samples");
      word.used = true;
      taken = word.after_at;
    } else if (free && one_of(word.before, {"spp", "samples"})) {
      put(cost.samples, value, path, "samples");
      word.used = true;
    } else if (const auto unit = unit_seconds(word.after); unit && word.glued_after && !word.glued_before) {
      put(cost.seconds, value * *unit, path, "seconds");
      word.used = true;
    } else if (free && one_of(word.before, {"time", "sec", "seconds"}) && word.after.empty()) {
      put(cost.seconds, value, path, "seconds");
      word.used = true;
    }
  }
  if (!cost.samples)
    for (auto word = words.rbegin(); word != words.rend(); ++word) {
      if (word->used) continue;
      const bool at_end = word->end == stem.size() || (word != words.rbegin() && word[-1].used);
      const bool alone = !word->glued_before && !word->glued_after && word->text.find('.') == std::string::npos;
      if (at_end && alone) put(cost.samples, *parse_double(word->text), path, "samples");
      break;
    }
  if (cost.samples) cost.samples_from = "its name";
  if (cost.seconds) cost.seconds_from = "its name";
  return cost;
}

RenderCost cost_from_metadata(const std::string& path, const ImageSpec& spec) {
  RenderCost cost;
  const auto take = [&](std::optional<double>& slot, std::string& from, const std::string& key, double value) {
    if (slot && *slot != value && lower(key).starts_with("cycles.") &&
        lower(from).find("cycles.") != std::string::npos)
      throw_input(path + ": its metadata '" + key + "' says " + format_double(value) + ", and " + from + " " +
                  format_double(*slot) + "; take one from elsewhere (--samples-from name or a table)");
    if (slot) return;
    slot = value;
    from = "its metadata " + key;
  };
  const auto entries = spec.metadata.entries();
  // What renderers write for this purpose goes before names that may mean anything.
  for (const auto& [key, text] : entries)
    if (key == "triad:samples")
      take(cost.samples, cost.samples_from, key, positive_number(path, key, text) / pixels_of(spec));
  const auto ends = [](const std::string& key, std::string_view end) {
    return key.starts_with("cycles.") && key.ends_with(end);
  };
  for (const auto& [key, text] : entries) {
    const std::string name = lower(key);
    if (name == "samplesperpixel" || ends(name, ".samples"))
      take(cost.samples, cost.samples_from, key, positive_number(path, key, text));
    if (name == "rendertimeseconds" || name == "rendertime")
      take(cost.seconds, cost.seconds_from, key, clock_seconds(path, key, text));
  }
  for (const auto& [key, text] : entries) {
    const std::string name = lower(key);
    if (!cost.samples && (name == "spp" || name == "samples"))
      take(cost.samples, cost.samples_from, key, positive_number(path, key, text));
    if (!cost.seconds || cost.seconds_from.find("cycles.") != std::string::npos)
      if (name == "seconds" || name == "render_time" || ends(name, ".render_time"))
        take(cost.seconds, cost.seconds_from, key, clock_seconds(path, key, text));
  }
  return cost;
}

RenderCost cost_from_record(const std::string& text, const ImageSpec& spec) {
  const auto root = nlohmann::json::parse(text, nullptr, false);
  RenderCost cost;
  if (!root.is_object() || !root.contains("strategy") || !root.contains("samples") || !root["samples"].is_number())
    return cost;
  cost.samples = root["samples"].get<double>() / pixels_of(spec);
  cost.samples_from = "the record of its render";
  const auto seconds = root.find("seconds");
  if (seconds != root.end() && seconds->is_object() && seconds->contains("render") &&
      (*seconds)["render"].is_number() && (*seconds)["render"].get<double>() > 0) {
    cost.seconds = (*seconds)["render"].get<double>();
    cost.seconds_from = cost.samples_from;
  }
  if (!(*cost.samples > 0)) cost.samples.reset();
  return cost;
}

CostTable::CostTable(const std::string& path) : path_(path) {
  const auto rows = parse_csv(read_text_file(path), path);
  int file = -1, samples = -1, seconds = -1;
  for (size_t i = 0; !rows.empty() && i < rows[0].size(); ++i) {
    std::string name = lower(trimmed(rows[0][i]));
    if (i == 0 && name.starts_with("\xef\xbb\xbf")) name = name.substr(3);  // a byte order mark
    if (name == "file") file = static_cast<int>(i);
    if (name == "samples" || name == "spp") samples = static_cast<int>(i);
    if (name == "seconds") seconds = static_cast<int>(i);
  }
  if (file < 0 || (samples < 0 && seconds < 0))
    throw_input(path +
                ": its first line must name the columns file and samples, seconds or both, as in "
                "file,samples,seconds");
  for (size_t r = 1; r < rows.size(); ++r) {
    const std::string where = path + ", row " + std::to_string(r + 1);
    if (rows[r].size() != rows[0].size())
      throw_input(where + ": " + std::to_string(rows[r].size()) + " columns, and the first line has " +
                  std::to_string(rows[0].size()));
    const auto number = [&](int column, const std::string& what) -> std::optional<double> {
      if (column < 0) return std::nullopt;
      const std::string text = trimmed(rows[r][static_cast<size_t>(column)]);
      if (text.empty()) return std::nullopt;
      const auto value = parse_double(text);
      if (!value || !std::isfinite(*value) || *value <= 0)
        throw_input(where + ": '" + text + "' is no number of " + what + " above 0");
      return value;
    };
    Row row{trimmed(rows[r][static_cast<size_t>(file)]), {}};
    row.cost.samples = number(samples, "samples");
    row.cost.seconds = number(seconds, "seconds");
    row.cost.samples_from = row.cost.seconds_from = "'" + path + "'";
    for (const Row& other : rows_)
      if (other.file == row.file) throw_input(where + ": '" + row.file + "' is in the table already");
    rows_.push_back(std::move(row));
  }
}

RenderCost CostTable::find(const std::string& picture) const {
  const std::string wanted = normal(picture), name = fs::path(picture).filename().string();
  const Row* by_name = nullptr;
  bool several = false;
  for (const Row& row : rows_) {
    if (normal(row.file) == wanted || normal(fs::path(path_).parent_path() / row.file) == wanted) return row.cost;
    if (fs::path(row.file).filename().string() != name) continue;
    several = by_name != nullptr;
    by_name = &row;
  }
  if (by_name && !several) return by_name->cost;
  throw_input(path_ + ": " + (several ? "several rows are named" : "no row is for") + " '" + picture +
              (several ? "', none with its path" : "'; give each picture one"));
}

RenderCost combined_cost(const std::string& path, const RenderCost& first, const RenderCost& second) {
  const auto combine = [&](const std::optional<double>& a, const std::string& a_from, const std::optional<double>& b,
                           const std::string& b_from, double alike, const std::string& what) {
    if (a && b && std::abs(*a - *b) > alike * std::max(*a, *b))
      throw_input(path + ": " + a_from + " says " + format_double(*a) + " " + what + ", " + b_from + " " +
                  format_double(*b) + "; say which is right: --samples-from name, metadata or a table");
    return std::pair{a ? a : b, a ? a_from : b_from};
  };
  RenderCost cost;
  std::tie(cost.samples, cost.samples_from) =
      combine(first.samples, first.samples_from, second.samples, second.samples_from, .01, "samples per pixel");
  std::tie(cost.seconds, cost.seconds_from) =
      combine(first.seconds, first.seconds_from, second.seconds, second.seconds_from, .05, "seconds");
  return cost;
}

}  // namespace triad
