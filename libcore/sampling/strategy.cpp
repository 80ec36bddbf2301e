// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

const std::vector<const StrategyEntry*>& entries() {
  static const std::vector<const StrategyEntry*> list{
      &control_strategy(),         &grid_strategy(),  &sobol_owen_strategy(), &per_subpixel_strategy(),
      &random_subpixel_strategy(), &cells_strategy(), &quad_strategy(),       &tri_strategy(),
      &variance_strategy()};
  return list;
}

std::string range(const StrategyParam& param) {
  if (!param.choices.empty()) return join(param.choices, ", ");
  return strategy_value(param, param.least) + " to " + strategy_value(param, param.most);
}

// Nothing if it is not a number of that kind, or out of range.
std::optional<double> parse_number(const StrategyParam& param, const std::string& text) {
  std::optional<double> number;
  if (!param.choices.empty()) {
    const auto found = std::find(param.choices.begin(), param.choices.end(), text);
    if (found != param.choices.end()) number = static_cast<double>(found - param.choices.begin());
    return number;
  }
  if (param.decimals) {
    number = parse_double(text);
  } else if (const auto whole = parse_int(text)) {
    number = static_cast<double>(*whole);
  }
  if (number && !(*number >= param.least && *number <= param.most)) number.reset();
  return number;
}

StrategyValues parse_values(const StrategyInfo& info, const std::string& text, const std::string& option) {
  StrategyValues values;
  std::vector<std::string> names;
  for (const StrategyParam& param : info.params) {
    values[param.name] = param.usual;
    names.push_back(param.name);
  }
  std::vector<std::string> given;
  for (const std::string& part : split_quoted(text, ',')) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw_usage(option + ": '" + part + "' is not key=value; a strategy is written name:key=value,key=value");
    const std::string key = part.substr(0, equals), value = unquote(part.substr(equals + 1));
    const auto param =
        std::find_if(info.params.begin(), info.params.end(), [&](const auto& p) { return p.name == key; });
    if (param == info.params.end())
      throw_usage(option + ": the strategy '" + info.name + "' has no parameter '" + key + "'" +
                  did_you_mean(key, names) + (names.empty() ? "; it has none" : "; it has " + join(names, ", ")));
    if (std::find(given.begin(), given.end(), key) != given.end())
      throw_usage(option + ": '" + key + "' is given twice");
    given.push_back(key);
    const std::optional<double> number = parse_number(*param, value);
    if (!number)
      throw_usage(option + ": " + info.name + ":" + key + "='" + value + "' cannot be used" +
                  (param->choices.empty()
                       ? std::string("; it must be a ") + (param->decimals ? "" : "whole ") + "number, "
                       : did_you_mean(value, param->choices) + "; it must be one of ") +
                  range(*param));
    values[key] = *number;
  }
  return values;
}

}  // namespace

std::string strategy_value(const StrategyParam& param, double value) {
  if (!param.choices.empty()) return param.choices.at(static_cast<size_t>(value));
  return param.decimals ? format_double(value) : std::to_string(static_cast<int64_t>(value));
}

std::string StrategyBase::text() const {
  std::string text = info_.name;
  char separator = ':';
  for (const StrategyParam& param : info_.params) {
    text += separator + param.name + "=" + strategy_value(param, values_.at(param.name));
    separator = ',';
  }
  return text;
}

Image RenderResult::image(const std::vector<std::string>& reason_channels) const {
  if (reason_channels.size() != reasons.size()) throw_internal("a render has other reasons than were asked for");
  Image image = film.image();
  const size_t before = image.spec.channels.size(), channels = before + reasons.size();
  for (size_t p = 0; p < colour.size(); ++p)
    for (size_t c = 0; c < 3; ++c) image.pixels[p * before + c] = static_cast<float>(colour[p][c]);
  if (reasons.empty()) return image;
  std::vector<float> wider(film.pixels() * channels);
  for (size_t p = 0; p < film.pixels(); ++p) {
    std::copy_n(&image.pixels[p * before], before, &wider[p * channels]);
    for (size_t r = 0; r < reasons.size(); ++r) wider[p * channels + before + r] = reasons[r][p];
  }
  image.pixels = std::move(wider);
  image.spec.channels.insert(image.spec.channels.end(), reason_channels.begin(), reason_channels.end());
  return image;
}

std::vector<const StrategyInfo*> strategy_list() {
  std::vector<const StrategyInfo*> list;
  for (const StrategyEntry* entry : entries()) list.push_back(&entry->info);
  return list;
}

std::unique_ptr<Strategy> make_strategy(const std::string& text, const std::string& option) {
  const size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  std::vector<std::string> names;
  for (const StrategyEntry* entry : entries()) {
    names.push_back(entry->info.name);
    if (entry->info.name != name) continue;
    if (colon == std::string::npos) {
      StrategyValues values;
      for (const StrategyParam& param : entry->info.params) values[param.name] = param.usual;
      return entry->make(values, option);
    }
    return entry->make(parse_values(entry->info, text.substr(colon + 1), option), option);
  }
  throw_usage(option + ": there is no strategy '" + name + "'" + did_you_mean(name, names) + "; there are " +
              join(names, ", "));
}

std::string strategy_help(const StrategyInfo& info) {
  std::string text = info.name + ": " + info.summary + "\n\n" + info.doc + "\n";
  if (!info.params.empty()) text += "\nParameters:\n";
  for (const StrategyParam& param : info.params)
    text +=
        "  " + param.name + "=" + strategy_value(param, param.usual) + "  " + param.doc + " (" + range(param) + ")\n";
  return text;
}

}  // namespace triad
