// SPDX-License-Identifier: Apache-2.0
// triad plugin check FILE, triad plugin new NAME
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include <iostream>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/pipeline/plugin_check.hpp>
#include <triad/pipeline/plugin_new.hpp>

#include "verbs.hpp"

namespace triad::app {
namespace {

struct PluginOptions {
  std::string file, name, params;
  double seconds = 20;
  bool json = false;
};

void check(const PluginOptions& options) {
  if (access(options.file.c_str(), F_OK) != 0)
    throw_input("cannot check '" + options.file + "': " + std::strerror(errno));
  const std::vector<CheckResult> results = check_plugin(options.file, options.params, options.seconds);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  size_t failed = 0, skipped = 0;
  for (const CheckResult& result : results) {
    failed += !result.passed && !result.skipped;
    skipped += result.skipped;
    list.push_back({{"rule", result.rule},
                    {"stage", result.stage},
                    {"passed", result.passed},
                    {"skipped", result.skipped},
                    {"message", result.message}});
    if (options.json) continue;
    std::cout << fmt::format("{}  {}{}{}\n",
                             result.skipped  ? "skip"
                             : result.passed ? " ok "
                                             : "FAIL",
                             result.rule, result.stage.empty() ? "" : " (" + printable(result.stage) + ")",
                             result.message.empty() ? "" : ": " + printable(result.message));
  }
  if (options.json) std::cout << json_text(nlohmann::ordered_json{{"file", options.file}, {"checks", list}}, 2);
  std::cout << std::flush;
  if (!options.json)
    std::cout << fmt::format("{} checks, {} failed, {} skipped\n", results.size(), failed, skipped) << std::flush;
  if (failed) {
    std::cerr << fmt::format("triad: '{}' breaks {} rule{} of the plugin interface\n", printable(options.file),
                             failed, failed == 1 ? "" : "s");
    g_exit_status = 1;
  }
}

void create(const PluginOptions& options) {
  for (const std::string& file : new_plugin(options.name, ".")) std::cout << file << "\n";
}

}  // namespace

void setup_plugin(CLI::App& app) {
  auto options = std::make_shared<PluginOptions>();
  CLI::App* verb = app.add_subcommand("plugin", "Check a plugin, or start a new one");
  verb->require_subcommand(1);
  CLI::App* checking = verb->add_subcommand("check", "Does a plugin keep the rules of the interface?");
  checking->add_option("file", options->file, "NAME.triad.so")->required()->type_name("FILE");
  checking->add_option("--params", options->params, "key=value,... for stages that need them")->type_name("PARAMS");
  checking->add_option("--time-limit", options->seconds, "Seconds before a plugin counts as hanging")
      ->type_name("S")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  checking->add_flag("--json", options->json, "As JSON");
  checking->footer("Example:\n  triad plugin check ./box.triad.so\nExit status: 0 keeps them, 1 breaks one");
  checking->callback([options] { check(*options); });
  CLI::App* creating = verb->add_subcommand("new", "Write a plugin to start from, into a new folder");
  creating->add_option("name", options->name, "Lower-case letters, digits and -")->required()->type_name("NAME");
  creating->footer("Example:\n  triad plugin new sharpen");
  creating->callback([options] { create(*options); });
  verb->footer("Example:\n  triad plugin new sharpen && triad plugin check sharpen/build/sharpen.triad.so");
}

}  // namespace triad::app
