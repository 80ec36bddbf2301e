// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/image/internal/carried.hpp>

namespace triad::image {
namespace {

constexpr const char* kSpace = "triad:colour_space=\"";
constexpr const char* kCells = "triad:cells=\"";

void put(std::string& out, const char* key, std::string value) {
  if (value.empty()) return;
  std::replace(value.begin(), value.end(), '"', '\'');
  out += (out.empty() ? "" : " ") + (key + value) + '"';
}

std::string take(std::string& text, const std::string& key) {
  const size_t at = text.find(key);
  if (at == std::string::npos) return "";
  const size_t begin = at + key.size(), end = text.find('"', begin);
  if (end == std::string::npos) return "";
  const std::string value = text.substr(begin, end - begin);
  const size_t blank = end + 1 < text.size() && text[end + 1] == ' ' ? 1 : 0;
  text.erase(at, end + 1 + blank - at);
  return value;
}

}  // namespace

std::string with_carried(const std::string& description, const Carried& carried) {
  std::string out;
  put(out, kSpace, carried.colour_space);
  put(out, kCells, carried.cells);
  if (!out.empty() && !description.empty()) out += ' ';
  return out + description;
}

Carried take_carried(std::string& description) {
  Carried carried;
  carried.colour_space = take(description, kSpace);
  carried.cells = take(description, kCells);
  return carried;
}

}  // namespace triad::image
