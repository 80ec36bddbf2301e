// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_params.hpp>

namespace triad {
namespace {

std::string value_pattern(const triad_param& p) {
  switch (p.type) {
    case TRIAD_BOOL: return "true|false";
    case TRIAD_INT: return "INTEGER";
    case TRIAD_FLOAT: return "NUMBER";
    case TRIAD_PATH: return "PATH";
    case TRIAD_FLOATS: return "NUMBER,...";
    case TRIAD_CHOICE: {
      std::string all;
      for (const char* const* name = p.choices; *name; ++name) all += (all.empty() ? "" : "|") + std::string(*name);
      return all;
    }
    default: return "TEXT";
  }
}

std::string limits(const triad_param& p) {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
  if (p.flags & TRIAD_PARAM_REQUIRED) add("required");
  if (const std::string range = range_text(p); !range.empty())
    add(range);
  else if (p.unit && *p.unit)
    add(p.unit);
  if (p.type == TRIAD_FLOATS) add("at most " + std::to_string(p.max_count));
  if (!(p.flags & TRIAD_PARAM_REQUIRED)) {
    const std::string text = value_text(p, p.def);
    add("default " + (text.empty() ? "none" : text));
  }
  return out;
}

std::string padded(std::string text, size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

const char* better_text(int32_t better) {
  return better < 0 ? "lower is better" : better > 0 ? "higher is better" : "nearer to zero is better";
}

std::string space_text(const triad_input& input) {
  if (!input.space) return "";
  if (std::strcmp(input.space, "linear") == 0) return ", in linear light";
  if (std::strcmp(input.space, "linear-rec709") == 0) return ", in linear light with Rec.709 primaries";
  if (std::strcmp(input.space, "display-or-linear") == 0)
    return ", as sRGB code values where both are stored so, else in linear light with Rec.709 primaries";
  return ", as sRGB code values";
}

std::string channels_text(const triad_input& input) {
  if (std::strcmp(input.channels, "rgb") == 0) return "colour channels";
  if (std::strcmp(input.channels, "mask") == 0) return "one weight per pixel";
  if (std::strcmp(input.channels, "variance.*") == 0) return "variance.R, variance.G and variance.B of the test file";
  return "all channels";
}

}  // namespace

std::string stage_help(const StageInfo& info) {
  const triad_desc& d = *info.desc;
  std::string out =
      info.id() + " " + d.version + " (" + (info.is_metric() ? "metric" : "filter") + "): " + d.summary + "\n";
  if (*d.doc) out += "\n" + std::string(d.doc) + "\n";
  out += "\nInputs:\n";
  size_t width = 0;
  for (uint32_t i = 0; i < d.n_inputs; ++i) width = std::max(width, std::strlen(d.inputs[i]->name));
  for (uint32_t i = 0; i < d.n_inputs; ++i) {
    const triad_input& input = *d.inputs[i];
    out += "  " + padded(input.name, width) + "  " + input.doc + " (" + channels_text(input) + space_text(input) +
           ((input.flags & TRIAD_INPUT_OPTIONAL) ? ", optional" : "") + ")\n";
  }
  if (d.n_params) out += "\nParameters:\n";
  for (uint32_t i = 0; i < d.n_params; ++i) {
    const triad_param& p = *d.params[i];
    out += "  " + std::string(p.name) + "=" + value_pattern(p) + "\n      " + p.doc + " (" + limits(p) + ")\n";
  }
  if (d.n_scores) out += "\nScores:\n";
  width = 0;
  for (uint32_t i = 0; i < d.n_scores; ++i) width = std::max(width, std::strlen(d.scores[i]->name));
  for (uint32_t i = 0; i < d.n_scores; ++i) {
    const triad_score& s = *d.scores[i];
    out += "  " + padded(s.name, width) + "  " + s.doc + " (" +
           (s.unit && *s.unit ? std::string(s.unit) + ", " : "") + better_text(s.better) + ")\n";
  }
  return out + "\nFrom " + info.file + "\n";
}

}  // namespace triad
