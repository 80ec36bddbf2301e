// SPDX-License-Identifier: Apache-2.0
// The verbs of the command line, one file each. A setup function adds its sub-command; its callback does the
// work and returns through exit_status.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace triad::app {

// Set by a verb that ran; becomes the process's exit status.
extern int g_exit_status;

void setup_run(CLI::App& app);
void setup_compare(CLI::App& app);
void setup_convergence(CLI::App& app);
void setup_render(CLI::App& app);
void setup_info(CLI::App& app);
void setup_list(CLI::App& app);
void setup_help(CLI::App& app);
void setup_plugin(CLI::App& app);
void setup_study(CLI::App& app);
void setup_report(CLI::App& app);

}  // namespace triad::app
