// SPDX-License-Identifier: Apache-2.0
// Whether what a plugin's plan(), need() and end_pass() gave can be used.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <cstddef>
#include <triad/pipeline/plugin_host.hpp>
#include <vector>

namespace triad {

// Throws PluginError: plan.size, plan.channels, plan.cells, plan.colour, plan.enum, plan.passes,
// plan.strip-rows, plan.state, plan.merge, plan.end-pass, plan.map.
void check_plan(const StageInfo& info, const triad_image& first_input, const triad_image& out,
                const triad_plan& plan);

// Throws PluginError need.empty or need.far (more than one picture's size, and more than 4096
// pixels, beyond the picture on a side).
void check_need(const StageInfo& info, size_t input, const triad_image& image, triad_rect need);

// Throws PluginError score.not-a-number or score.infinite.
void check_scores(const StageInfo& info, const std::vector<double>& scores);

}  // namespace triad
