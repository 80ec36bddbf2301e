// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

const std::vector<const StrategyEntry*>& entries() {
  static const std::vector<const StrategyEntry*> list{&control_strategy(), &grid_strategy(), &sobol_owen_strategy(),
                                                      &variance_strategy()};
  return list;
}

std::string range(const StrategyParam& param) {
  return strategy_value(param, param.least) + " to " + strategy_value(param, param.most);
}

// Nothing if it is not a number of that kind, or out of range.
std::optional<double> parse_number(const StrategyParam& param, const std::string& text) {
  std::optional<double> number;
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
      throw_usage(option + ": " + info.name + ":" + key + "='" + value + "' cannot be used; it must be a " +
                  (param->decimals ? "" : "whole ") + "number, " + range(*param));
    values[key] = *number;
  }
  return values;
}

}  // namespace

std::string strategy_value(const StrategyParam& param, double value) {
  return param.decimals ? format_double(value) : std::to_string(static_cast<int64_t>(value));
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
