// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>

#include "verbs.hpp"

namespace triad::app {
int g_exit_status = 0;
}

namespace {

void on_interrupt(int) {
  // A second Ctrl-C ends the process at once, should something not look at the flag.
  std::signal(SIGINT, SIG_DFL);
  triad::request_cancel();
}

int fail(const std::string& message, int status) {
  std::cerr << "triad: " << triad::printable(message) << std::endl;
  return status;
}

// What CLI11 says of a wrong command line, as one line that says what would be right.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    verbs.push_back(verb->get_name());
  const CLI::App* verb = nullptr;
  for (const CLI::App* used : app.get_subcommands()) verb = used;
  if (!verb && argc > 1 && argv[1][0] != '-')
    return "unknown verb '" + std::string(argv[1]) + "'" + triad::did_you_mean(argv[1], verbs) + "; there are '" +
           triad::join(verbs, "', '") + "'";
  std::string text = error.what();
  for (char& c : text)
    if (c == '\n') c = ' ';
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && verb) {
    std::vector<std::string> names;
    for (const CLI::Option* option : verb->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    const std::vector<std::string> extras = verb->remaining();
    if (!extras.empty()) text = "unknown option '" + extras[0] + "'" + triad::did_you_mean(extras[0], names);
  }
  return text + "; see triad " + (verb ? verb->get_name() + " " : "") + "--help";
}

int run_main(int argc, char** argv) {
  CLI::App app("Triad: filter renders for real displays, and measure the result", "triad");
  app.set_version_flag("--version", "triad " TRIAD_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Exit status: 0 done, 1 a comparison failed, 2 usage or input error, 3 internal error, 130 interrupted.\n"
      "Each verb has its own --help with examples.");
  triad::app::setup_run(app);
  triad::app::setup_compare(app);
  triad::app::setup_convergence(app);
  triad::app::setup_study(app);
  triad::app::setup_report(app);
  triad::app::setup_render(app);
  triad::app::setup_info(app);
  triad::app::setup_list(app);
  triad::app::setup_help(app);
  triad::app::setup_plugin(app);
  if (argc == 1) {
    std::cerr << "triad: name a verb: "
              << "run, compare, convergence, render, study, report, info, list, help or plugin; see triad --help"
              << std::endl;
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    return app.exit(request);  // --help and --version
  } catch (const CLI::ParseError& error) {
    return fail(usage_message(app, error, argc, argv), 2);
  }
  return triad::app::g_exit_status;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  std::signal(SIGHUP, on_interrupt);
  try {
    const int status = run_main(argc, argv);
    std::cout.flush();
    if (!std::cout) return fail("cannot write to standard output", 2);
    return status;
  } catch (const triad::Error& error) {
    return fail(error.what(), error.exit_status());
  } catch (const std::bad_alloc&) {
    return fail("out of memory; --max-memory bounds what a chain may use", 2);
  } catch (const std::exception& error) {
    return fail(std::string("internal error: ") + error.what(), 3);
  }
}
