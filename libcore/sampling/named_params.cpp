// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/named_params.hpp>

namespace triad {
namespace {

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

StrategyValues usual_values(const StrategyInfo& info) {
  StrategyValues values;
  for (const StrategyParam& param : info.params) values[param.name] = param.usual;
  return values;
}

StrategyValues parse_values(const std::string& kind, const StrategyInfo& info, const std::string& text,
                            const std::string& option) {
  StrategyValues values = usual_values(info);
  std::vector<std::string> names;
  for (const StrategyParam& param : info.params) names.push_back(param.name);
  std::vector<std::string> given;
  for (const std::string& part : split_quoted(text, ',')) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw_usage(option + ": '" + part + "' is not key=value; a " + kind + " is written name:key=value,key=value");
    const std::string key = part.substr(0, equals), value = unquote(part.substr(equals + 1));
    const auto param =
        std::find_if(info.params.begin(), info.params.end(), [&](const auto& p) { return p.name == key; });
    if (param == info.params.end())
      throw_usage(option + ": the " + kind + " '" + info.name + "' has no parameter '" + key + "'" +
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

std::string named_text(const StrategyInfo& info, const StrategyValues& values) {
  std::string text = info.name;
  char separator = ':';
  for (const StrategyParam& param : info.params) {
    text += separator + param.name + "=" + strategy_value(param, values.at(param.name));
    separator = ',';
  }
  return text;
}

Chosen choose_named(const std::string& kind, const std::vector<const StrategyInfo*>& list, const std::string& text,
                    const std::string& option) {
  const size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  std::vector<std::string> names;
  for (size_t place = 0; place < list.size(); ++place) {
    const StrategyInfo& info = *list[place];
    if (info.name == name)
      return {place, colon == std::string::npos ? usual_values(info)
                                                : parse_values(kind, info, text.substr(colon + 1), option)};
    names.push_back(info.name);
  }
  throw_usage(option + ": there is no " + kind + " '" + name + "'" + did_you_mean(name, names) + "; there are " +
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
