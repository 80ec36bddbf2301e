// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/stage_params.hpp>

namespace triad {
namespace {

bool in_range(const triad_param& p, double v) {
  if (!std::isfinite(v)) return false;
  return ((p.flags & TRIAD_PARAM_MIN_EXCLUDED) ? v > p.min : v >= p.min) &&
         ((p.flags & TRIAD_PARAM_MAX_EXCLUDED) ? v < p.max : v <= p.max);
}

std::vector<std::string> choice_names(const triad_param& p) {
  std::vector<std::string> names;
  for (const char* const* name = p.choices; *name; ++name) names.emplace_back(*name);
  return names;
}

std::string type_text(const triad_param& p) {
  switch (p.type) {
    case TRIAD_BOOL: return "true or false";
    case TRIAD_INT: return "a whole number";
    case TRIAD_FLOAT: return "a number";
    case TRIAD_CHOICE: return "one of " + join(choice_names(p), ", ");
    case TRIAD_FLOATS: return "up to " + std::to_string(p.max_count) + " numbers, separated by commas";
    default: return "UTF-8 text";
  }
}

[[noreturn]] void bad_value(const StageInfo& info, const triad_param& p, const std::string& text,
                            const std::string& hint = "") {
  const std::string range = range_text(p);
  throw_usage("stage '" + info.id() + "': " + p.name + "='" + text + "' cannot be used" + hint + "; it must be " +
              type_text(p) + (range.empty() ? "" : ", " + range));
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",'\" :\\") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace

std::string range_text(const triad_param& p) {
  if (p.type != TRIAD_INT && p.type != TRIAD_FLOAT && p.type != TRIAD_FLOATS) return "";
  const bool low = std::isfinite(p.min), high = std::isfinite(p.max);
  const bool above = (p.flags & TRIAD_PARAM_MIN_EXCLUDED) != 0, below = (p.flags & TRIAD_PARAM_MAX_EXCLUDED) != 0;
  std::string out;
  if (low && high && !above && !below) {
    out = format_double(p.min) + " to " + format_double(p.max);
  } else {
    if (low) out = (above ? "above " : "at least ") + format_double(p.min);
    if (low && high) out += " and ";
    if (high) out += (below ? "below " : "at most ") + format_double(p.max);
  }
  if (!out.empty() && p.unit && *p.unit) out += std::string(" ") + p.unit;
  return out;
}

std::string value_text(const triad_param& p, const triad_value& v) {
  switch (p.type) {
    case TRIAD_BOOL: return v.u.i ? "true" : "false";
    case TRIAD_INT: return std::to_string(v.u.i);
    case TRIAD_FLOAT: return format_double(v.u.f);
    case TRIAD_CHOICE: return p.choices[v.u.i];
    case TRIAD_FLOATS: {
      std::vector<std::string> parts;
      for (int32_t i = 0; i < v.count; ++i) parts.push_back(format_double(v.u.v[i]));
      return join(parts, ",");
    }
    default: return v.u.s;
  }
}

StageParams::StageParams(const StageInfo& info, const ParamTexts& texts) : summary_(info.id()) {
  const triad_desc& desc = *info.desc;
  std::vector<std::string> names;
  for (uint32_t i = 0; i < desc.n_params; ++i) names.emplace_back(desc.params[i]->name);
  for (const auto& [name, text] : texts) {
    bool known = false;
    for (const std::string& n : names) known = known || n == name;
    if (!known)
      throw_usage("stage '" + info.id() + "' has no parameter '" + name + "'" + did_you_mean(name, names) + "; " +
                  (names.empty() ? "it takes none" : "it takes " + join(names, ", ")));
  }
  char separator = ':';
  for (uint32_t i = 0; i < desc.n_params; ++i) {
    const triad_param& p = *desc.params[i];
    const auto given = texts.find(p.name);
    if (given == texts.end() && (p.flags & TRIAD_PARAM_REQUIRED))
      throw_usage("stage '" + info.id() + "' needs the parameter '" + p.name + "' (" + p.doc + "); it must be " +
                  type_text(p));
    const triad_value value = given == texts.end() ? p.def : parse(info, p, given->second);
    values_.push_back(value);
    texts_.emplace_back(p.name, value_text(p, value));
    if (given != texts.end()) {
      summary_ += separator + std::string(p.name) + "=" + quoted(texts_.back().second);
      separator = ',';
    }
  }
}

triad_value StageParams::parse(const StageInfo& info, const triad_param& p, const std::string& text) {
  triad_value value{};
  value.type = p.type;
  value.count = 1;
  switch (p.type) {
    case TRIAD_BOOL: {
      const std::string word = lower(text);
      if (word == "true" || word == "yes" || word == "on" || word == "1")
        value.u.i = 1;
      else if (word == "false" || word == "no" || word == "off" || word == "0")
        value.u.i = 0;
      else
        bad_value(info, p, text);
      break;
    }
    case TRIAD_INT: {
      const auto number = parse_int(text);
      if (!number || !in_range(p, static_cast<double>(*number))) bad_value(info, p, text);
      value.u.i = *number;
      break;
    }
    case TRIAD_FLOAT: {
      const auto number = parse_double(text);
      if (!number || !in_range(p, *number)) bad_value(info, p, text);
      value.u.f = *number;
      break;
    }
    case TRIAD_CHOICE: {
      value.u.i = -1;
      for (int64_t i = 0; p.choices[i]; ++i)
        if (text == p.choices[i]) value.u.i = i;
      if (value.u.i < 0) bad_value(info, p, text, did_you_mean(text, choice_names(p)));
      break;
    }
    case TRIAD_FLOATS: {
      std::vector<double>& list = lists_.emplace_back();
      for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find_first_of(", ", at), text.size());
        if (end > at || text[at] == ',') {
          const auto number = parse_double(std::string_view(text).substr(at, end - at));
          if (!number || !in_range(p, *number)) bad_value(info, p, text);
          list.push_back(*number);
        }
        at = end + 1;
      }
      if (list.size() > p.max_count) bad_value(info, p, text);
      value.count = static_cast<int32_t>(list.size());
      value.u.v = list.data();
      break;
    }
    default:
      if (!is_valid_utf8(text) || text.find('\0') != std::string::npos) bad_value(info, p, text);
      value.u.s = strings_.emplace_back(text).c_str();
  }
  return value;
}

}  // namespace triad
