// SPDX-License-Identifier: Apache-2.0
// triad list [filters|metrics|colours|layouts|strategies|scenes|functions], triad help NAME
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>
#include <triad/sampling/functions.hpp>

#include "bundled_scenes.hpp"
#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct ListOptions {
  HostOptions host;
  std::string what, plugin;
  bool json = false;
};

nlohmann::ordered_json stage_json(const StageInfo& info) {
  const triad_desc& desc = *info.desc;
  nlohmann::ordered_json object;
  object["id"] = desc.id;
  object["kind"] = info.is_metric() ? "metric" : "filter";
  object["version"] = desc.version;
  object["summary"] = desc.summary;
  object["file"] = info.file;
  return object;
}

void list(const ListOptions& options) {
  static const std::vector<std::string> kWhat{"filters",    "metrics", "colours",  "layouts",
                                              "strategies", "scenes",  "functions"};
  if (!options.what.empty() && std::find(kWhat.begin(), kWhat.end(), options.what) == kWhat.end())
    throw_usage("cannot list '" + options.what + "'" + did_you_mean(options.what, kWhat) + "; there are '" +
                join(kWhat, "', '") + "'");
  const auto wanted = [&](const std::string& what) { return options.what.empty() || options.what == what; };
  nlohmann::ordered_json root = nlohmann::ordered_json::object();
  std::string text;
  if (wanted("filters") || wanted("metrics")) {
    PluginHost host(options.host.plugin_path);
    for (const bool metrics : {false, true}) {
      const std::string what = metrics ? "metrics" : "filters";
      if (!wanted(what)) continue;
      root[what] = nlohmann::ordered_json::array();
      text += what + "\n";
      for (const StageInfo* info : host.list()) {
        if (info->is_metric() != metrics) continue;
        root[what].push_back(stage_json(*info));
        text += fmt::format("  {:<16} {}\n", info->desc->id, info->desc->summary);
      }
    }
  }
  if (wanted("colours")) {
    const ColourConfig colours = ColourConfig::load(options.host.ocio);
    root["colours"] = colours.names();
    text += "colours (" + colours.origin() + ")\n";
    for (const std::string& name : colours.names())
      text += fmt::format("  {:<16} {}\n", name,
                          colours.is_data(name)     ? "data"
                          : colours.is_linear(name) ? "linear light"
                                                    : "display-encoded");
  }
  if (wanted("layouts")) {
    root["layouts"] = nlohmann::ordered_json::array();
    text += "layouts\n";
    for (const std::string& name : layout_names()) {
      const Layout layout = load_layout(name);
      root["layouts"].push_back({{"id", name},
                                 {"summary", layout.summary},
                                 {"cells", {layout.cells_x, layout.cells_y}},
                                 {"tile", {layout.tile_x, layout.tile_y}}});
      text += fmt::format("  {:<16} cells {}x{}, repeats after {}x{} px: {}\n", name, layout.cells_x, layout.cells_y,
                          layout.tile_x, layout.tile_y, layout.summary);
    }
  }
  if (wanted("strategies")) {
    root["strategies"] = nlohmann::ordered_json::array();
    text += "strategies\n";
    for (const StrategyInfo* info : strategy_list()) {
      root["strategies"].push_back({{"id", info->name}, {"summary", info->summary}});
      text += fmt::format("  {:<16} {}\n", info->name, info->summary);
    }
  }
  if (wanted("scenes")) {
    root["scenes"] = nlohmann::ordered_json::array();
    text += "scenes\n";
    for (const BundledScene& scene : bundled_scenes()) {
      const std::string about = about_scene(scene.file);
      root["scenes"].push_back({{"id", scene.name}, {"summary", about}, {"file", scene.file}});
      text += fmt::format("  {:<16} {}\n", scene.name, printable(about));
    }
  }
  if (wanted("functions")) {
    root["functions"] = nlohmann::ordered_json::array();
    text += "functions, drawn by triad render where no bundled scene has the name\n";
    for (const FunctionInfo* info : function_list()) {
      root["functions"].push_back({{"id", info->name}, {"summary", info->summary}});
      text += fmt::format("  {:<16} {}\n", info->name, info->summary);
    }
  }
  std::cout << (options.json ? json_text(root, 2) : text);
}

// Of a strategy or a function.
void help_named(const StrategyInfo& info, const std::string& kind, bool as_json) {
  if (!as_json) {
    std::cout << strategy_help(info);
    return;
  }
  nlohmann::ordered_json object{{"id", info.name}, {"kind", kind}, {"summary", info.summary}, {"doc", info.doc}};
  object["parameters"] = nlohmann::ordered_json::array();
  for (const StrategyParam& param : info.params) {
    // null: without end.
    const auto number = [&](double value) -> nlohmann::ordered_json {
      if (!std::isfinite(value)) return nullptr;
      if (param.decimals) return value;
      return static_cast<int64_t>(value);
    };
    nlohmann::ordered_json entry{{"name", param.name}};
    if (!param.choices.empty()) {
      entry.update({{"type", "choice"}, {"doc", param.doc}, {"choices", param.choices}});
      entry["default"] = strategy_value(param, param.usual);
    } else {
      entry.update({{"type", param.decimals ? "float" : "int"}, {"doc", param.doc}});
      entry.update({{"min", number(param.least)}, {"max", number(param.most)}, {"default", number(param.usual)}});
    }
    object["parameters"].push_back(std::move(entry));
  }
  std::cout << json_text(object, 2);
}

const StageInfo& find_stage(PluginHost& host, const std::string& name) {
  try {
    return host.find(name);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kUsage) throw;
  }
  std::vector<std::string> all, stages, strategies, functions;
  for (const StageInfo* info : host.list()) all.push_back(stages.emplace_back(info->id()));
  for (const StrategyInfo* info : strategy_list()) all.push_back(strategies.emplace_back(info->name));
  for (const FunctionInfo* info : function_list()) all.push_back(functions.emplace_back(info->name));
  throw_usage("no plugin, strategy or function is called '" + name + "'" + did_you_mean(name, all) +
              "; there are the plugins " + join(stages, ", ") + ", the strategies " + join(strategies, ", ") +
              " and the functions " + join(functions, ", "));
}

void help(const ListOptions& options) {
  for (const StrategyInfo* strategy : strategy_list())
    if (strategy->name == options.plugin) return help_named(*strategy, "strategy", options.json);
  for (const FunctionInfo* function : function_list())
    if (function->name == options.plugin) return help_named(*function, "function", options.json);
  PluginHost host(options.host.plugin_path);
  const StageInfo& info = find_stage(host, options.plugin);
  if (!options.json) {
    std::cout << stage_help(info);
    return;
  }
  nlohmann::ordered_json object = stage_json(info);
  const triad_desc& desc = *info.desc;
  static const char* const kTypes[] = {"", "bool", "int", "float", "string", "choice", "path", "floats"};
  object["parameters"] = object["scores"] = nlohmann::ordered_json::array();
  // The values in force when nothing is given; a required parameter has none.
  ParamTexts none;
  for (uint32_t i = 0; i < desc.n_params; ++i) {
    const triad_param& param = *desc.params[i];
    nlohmann::ordered_json entry;
    entry["name"] = param.name;
    entry["type"] = kTypes[param.type];
    entry["doc"] = param.doc ? param.doc : "";
    entry["unit"] = param.unit ? param.unit : "";
    entry["required"] = (param.flags & TRIAD_PARAM_REQUIRED) != 0;
    if (param.type == TRIAD_INT || param.type == TRIAD_FLOAT || param.type == TRIAD_FLOATS) {
      entry["min"] = format_double(param.min);
      entry["max"] = format_double(param.max);
    }
    if (param.choices)
      for (const char* const* choice = param.choices; *choice; ++choice) entry["choices"].push_back(*choice);
    object["parameters"].push_back(std::move(entry));
  }
  for (uint32_t i = 0; i < desc.n_scores; ++i)
    object["scores"].push_back({{"name", desc.scores[i]->name},
                                {"doc", desc.scores[i]->doc ? desc.scores[i]->doc : ""},
                                {"unit", desc.scores[i]->unit ? desc.scores[i]->unit : ""},
                                {"better", desc.scores[i]->better < 0   ? "lower"
                                           : desc.scores[i]->better > 0 ? "higher"
                                                                        : "zero"}});
  std::cout << json_text(object, 2);
}

}  // namespace

void setup_list(CLI::App& app) {
  auto options = std::make_shared<ListOptions>();
  CLI::App* verb =
      app.add_subcommand("list", "List filters, metrics, colour spaces, layouts, strategies, scenes and functions");
  verb->add_option("what", options->what,
                   "filters, metrics, colours, layouts, strategies, scenes or functions (default: all)")
      ->type_name("WHAT");
  verb->add_flag("--json", options->json, "As JSON");
  options->host.add_plugin_path(*verb);
  options->host.add_ocio(*verb);
  verb->footer("Example:\n  triad list metrics");
  verb->callback([options] { list(*options); });
}

void setup_help(CLI::App& app) {
  auto options = std::make_shared<ListOptions>();
  CLI::App* verb =
      app.add_subcommand("help", "Explain a plugin, strategy or function: what it does, and its parameters");
  verb->add_option("plugin", options->plugin, "A filter's, metric's, strategy's or function's name")
      ->required()
      ->type_name("NAME");
  verb->add_flag("--json", options->json, "As JSON");
  options->host.add_plugin_path(*verb);
  verb->footer("Example:\n  triad help platt");
  verb->callback([options] { help(*options); });
}

}  // namespace triad::app
