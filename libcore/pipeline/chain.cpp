// SPDX-License-Identifier: Apache-2.0
#include <toml++/toml.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/chain.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

bool is_stage_name(std::string_view name) {
  if (name.empty() || name.size() > 32 || name[0] < 'a' || name[0] > 'z') return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

// Labels become parts of file names and of thresholds: LABEL.SCORE=VALUE.
const char* const kLabelRule = "a label is made of letters, digits, '-' and '_'";
bool is_label(std::string_view label) {
  return !label.empty() && label.size() <= 64 && std::all_of(label.begin(), label.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

// The position of the last `mark` outside quotes, or npos.
size_t find_unquoted(std::string_view text, char mark) {
  size_t found = std::string_view::npos;
  char quote = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && quote != '\'') {
      ++i;
    } else if (quote) {
      if (text[i] == quote) quote = 0;
    } else if (text[i] == '"' || text[i] == '\'') {
      quote = text[i];
    } else if (text[i] == mark) {
      found = i;
    }
  }
  return found;
}

void parse_params(ChainItem& item, std::string_view text, const std::string& whole) {
  for (const std::string& part : split_quoted(text, ',')) {
    const size_t equals = part.find('=');
    const std::string key = unquote(part.substr(0, equals));
    if (equals == std::string::npos || key.empty())
      throw_usage("'" + whole + "': '" + part + "' is not key=value; a stage is written name:key=value,key=value");
    if (!item.params.emplace(key, unquote(part.substr(equals + 1))).second)
      throw_usage("'" + whole + "': parameter '" + key + "' is given twice");
  }
}

ChainItem parse_item(std::string_view text, const std::string& whole) {
  ChainItem item;
  const size_t colon = text.find(':');
  item.id = std::string(text.substr(0, colon));
  if (!is_stage_name(item.id))
    throw_usage("'" + whole + "' is not a stage; a stage is written name or name:key=value,key=value");
  item.label = item.id;
  if (colon != std::string_view::npos) parse_params(item, text.substr(colon + 1), whole);
  return item;
}

std::string toml_text(const toml::node& node, const std::string& where) {
  if (const auto text = node.value_exact<std::string>()) return *text;
  if (const auto integer = node.value_exact<int64_t>()) return std::to_string(*integer);
  if (const auto real = node.value_exact<double>()) return format_double(*real);
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  if (const auto* list = node.as_array()) {
    std::vector<std::string> parts;
    for (const auto& element : *list) {
      if (!element.is_number()) throw_input(where + ": a list may hold numbers only");
      parts.push_back(toml_text(element, where));
    }
    return join(parts, ",");
  }
  throw_input(where + ": the value must be a string, a number, a boolean or a list of numbers");
}

ChainItem item_from_toml(const toml::table& table, const std::string& where, bool metric) {
  ChainItem item;
  if (!metric && table.contains("write")) {
    const auto path = table["write"].value<std::string>();
    if (!path || table.size() != 1) throw_input(where + ": 'write' takes a path and stands alone");
    item.is_write = true;
    item.path = *path;
    return item;
  }
  const auto name = table["name"].value<std::string>();
  if (!name || !is_stage_name(*name)) throw_input(where + ": 'name' must be the name of a stage");
  item.id = *name;
  item.label = table["label"].value_or(*name);
  if (!is_label(item.label)) throw_input(where + ": label '" + item.label + "': " + kLabelRule);
  for (const auto& [key, value] : table) {
    if (key == "name" || (metric && key == "label")) continue;
    item.params.emplace(std::string(key.str()), toml_text(value, where + ": '" + std::string(key.str()) + "'"));
  }
  return item;
}

}  // namespace

ChainItem parse_stage(const std::string& text) {
  if (text.rfind("write:", 0) == 0) {
    ChainItem item;
    item.is_write = true;
    item.path = text.substr(6);
    if (item.path.size() > 1 && (item.path[0] == '"' || item.path[0] == '\'')) item.path = unquote(item.path);
    if (item.path.empty()) throw_usage("'write:' needs a path, as in write:mid.exr");
    return item;
  }
  return parse_item(text, text);
}

ChainItem parse_metric(const std::string& text) {
  const size_t at = find_unquoted(text, '@');
  ChainItem item = parse_item(std::string_view(text).substr(0, at), text);
  if (at != std::string::npos) {
    item.label = unquote(text.substr(at + 1));
    if (!is_label(item.label)) throw_usage("'" + text + "': " + kLabelRule);
  }
  return item;
}

Chain load_chain(const std::string& path) {
  const std::string text = read_text_file(path);
  Chain chain;
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw_input("'" + path + "' line " + std::to_string(error.source().begin.line) + ": " +
                std::string(error.description()));
  }
  for (const auto& [key, value] : root) {
    if (key != "stage" && key != "metric")
      throw_input("'" + path + "': unknown table '" + std::string(key.str()) +
                  "'; a chain has [[stage]] and [[metric]]");
    const auto* list = value.as_array();
    if (!list) throw_input("'" + path + "': write [[" + std::string(key.str()) + "]], with two brackets");
    for (const auto& node : *list) {
      const auto* table = node.as_table();
      const std::string where = "'" + path + "' line " + std::to_string(node.source().begin.line);
      if (!table) throw_input(where + ": a stage is a table");
      auto& items = key == "stage" ? chain.stages : chain.metrics;
      items.push_back(item_from_toml(*table, where, key == "metric"));
    }
  }
  return chain;
}

void make_labels_unique(std::vector<ChainItem>& metrics) {
  std::set<std::string> taken;
  for (ChainItem& metric : metrics) {
    std::string label = metric.label;
    for (int n = 2; !taken.insert(label).second; ++n) label = metric.label + "-" + std::to_string(n);
    metric.label = label;
  }
}

bool is_sequence(const std::string& pattern) { return pattern.find('#') != std::string::npos; }

namespace {
// Where the run of '#' is, within the file name.
struct Hashes {
  std::string folder, before, after;
  size_t width = 0;
};

Hashes split_pattern(const std::string& pattern) {
  Hashes parts;
  const fs::path path(pattern);
  parts.folder = path.parent_path().string();
  const std::string name = path.filename().string();
  if (parts.folder.find('#') != std::string::npos)
    throw_usage("'" + pattern + "': '#' stands for a frame number in the file's name, not in a folder's");
  const size_t first = name.find('#');
  const size_t last = name.find_first_not_of('#', first);
  if (last != std::string::npos && name.find('#', last) != std::string::npos)
    throw_usage("'" + pattern + "': only one run of '#' can stand for the frame number");
  parts.before = name.substr(0, first);
  parts.after = last == std::string::npos ? "" : name.substr(last);
  parts.width = (last == std::string::npos ? name.size() : last) - first;
  return parts;
}
}  // namespace

std::vector<int> find_frames(const std::string& pattern) {
  const Hashes parts = split_pattern(pattern);
  const std::string folder = parts.folder.empty() ? "." : parts.folder;
  std::error_code error;
  std::vector<int> frames;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < parts.before.size() + parts.after.size() + parts.width) continue;
    if (name.rfind(parts.before, 0) != 0 || !name.ends_with(parts.after)) continue;
    const std::string digits =
        name.substr(parts.before.size(), name.size() - parts.before.size() - parts.after.size());
    if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
    // "0012345" has more than its padding: another sequence's frame.
    if (digits.size() > parts.width && digits[0] == '0') continue;
    if (const auto number = parse_int(digits); number && *number <= 2'000'000'000)
      frames.push_back(static_cast<int>(*number));
  }
  if (error) throw_input("cannot read '" + pattern + "': folder '" + folder + "': " + error.message());
  if (frames.empty()) throw_input("'" + pattern + "': no frame of that name exists");
  std::sort(frames.begin(), frames.end());
  return frames;
}

std::string frame_path(const std::string& pattern, int frame) {
  if (!is_sequence(pattern)) return pattern;
  const Hashes parts = split_pattern(pattern);
  std::string digits = std::to_string(frame);
  if (digits.size() < parts.width) digits.insert(0, parts.width - digits.size(), '0');
  return (fs::path(parts.folder) / (parts.before + digits + parts.after)).string();
}

}  // namespace triad
