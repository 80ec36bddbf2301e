// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/text.hpp>
#include <triad/pipeline/plan_check.hpp>
#include <triad/pipeline/plugin_error.hpp>

namespace triad {
namespace {

constexpr int64_t kMaxSamples = int64_t{1} << 40;  // 4 TiB of floats; the reader's limit too
constexpr int kMaxChannels = 1024, kMaxCells = 64, kMaxPasses = 64;
// A reconstruction filter's radius has nothing to do with how small a picture is.
constexpr int64_t kAlwaysAllowedReach_px = 4096;
constexpr uint64_t kMaxStateBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxWorkBytes = uint64_t{1} << 48;  // so that sums of such plans do not overflow

std::string rect_text(triad_rect r) {
  return "x " + std::to_string(r.x0) + " to " + std::to_string(r.x1) + ", y " + std::to_string(r.y0) + " to " +
         std::to_string(r.y1);
}

}  // namespace

void check_plan(const StageInfo& info, const triad_image& first, const triad_image& out, const triad_plan& plan) {
  const auto refuse = [&](const char* rule, const std::string& what) {
    throw PluginError(rule, info.id(), info.file, "plan() gave " + what);
  };
  const std::string size = std::to_string(out.width) + "x" + std::to_string(out.height);
  if (out.width < 1 || out.height < 1) refuse("plan.size", "a picture of " + size + " pixels");
  if (out.channels < (info.is_metric() ? 0 : 1) || out.channels > kMaxChannels)
    refuse("plan.channels", std::to_string(out.channels) + " channels; 1 to 1024 are right");
  if (out.channels > 0 && int64_t{out.width} * out.height > kMaxSamples / out.channels)
    refuse("plan.size", "a picture of " + size + " pixels with " + std::to_string(out.channels) +
                            " channels, more than 2^40 samples");
  if (out.alpha < -1 || (out.alpha >= 0 && out.alpha >= out.channels))
    refuse("plan.channels", "channel " + std::to_string(out.alpha) + " as alpha, of " + std::to_string(out.channels));
  if (info.is_metric() && out.channels > 0) {
    if (out.channels != 1 && out.channels != 3)
      refuse("plan.map", "a map with " + std::to_string(out.channels) + " channels; 1 or 3 are right");
    if (out.width != first.width || out.height != first.height)
      refuse("plan.map", "a map of " + size + "; it must be as large as the first input, " +
                             std::to_string(first.width) + "x" + std::to_string(first.height));
  }
  if (out.cells_x < 1 || out.cells_y < 1 || out.cells_x > kMaxCells || out.cells_y > kMaxCells)
    refuse("plan.cells",
           std::to_string(out.cells_x) + "x" + std::to_string(out.cells_y) + " cells; 1 to 64 are right");
  if (!(out.pixel_aspect > 0) || !std::isfinite(out.pixel_aspect))
    refuse("plan.colour", "the pixel aspect " + format_double(out.pixel_aspect));
  for (const double value : out.rgb_to_xyz)
    if (!std::isfinite(value)) refuse("plan.colour", "an rgb_to_xyz that is not finite");
  if (!(out.white_nits >= 0) || !std::isfinite(out.white_nits))
    refuse("plan.colour", "the white level " + format_double(out.white_nits) + " nits");
  if (plan.threads != TRIAD_SERIAL && plan.threads != TRIAD_REENTRANT)
    refuse("plan.enum", "threads = " + std::to_string(plan.threads));
  if (plan.edge < TRIAD_EDGE_CLAMP || plan.edge > TRIAD_EDGE_ZERO)
    refuse("plan.enum", "edge = " + std::to_string(plan.edge));
  if (plan.nonfinite != TRIAD_NONFINITE_KEEP && plan.nonfinite != TRIAD_NONFINITE_ZERO)
    refuse("plan.enum", "nonfinite = " + std::to_string(plan.nonfinite));
  if (plan.passes < 1 || plan.passes > kMaxPasses)
    refuse("plan.passes", std::to_string(plan.passes) + " passes; 1 to 64 are right");
  if (plan.strip_rows < -1)
    refuse("plan.strip-rows", "strip_rows = " + std::to_string(plan.strip_rows) + "; -1, 0 or more is right");
  if (plan.state_bytes >= kMaxStateBytes)
    refuse("plan.state", "a state of " + std::to_string(plan.state_bytes) + " bytes; less than 1 GiB is right");
  if (plan.work_bytes > kMaxWorkBytes)
    refuse("plan.work", std::to_string(plan.work_bytes) + " bytes to work with; at most 2^48 is right");
  const triad_rect& pool = plan.pool;
  const bool pools = pool.x0 < pool.x1 && pool.y0 < pool.y1;
  if (pools && (pool.x0 < 0 || pool.y0 < 0 || pool.x1 > first.width || pool.y1 > first.height))
    refuse("plan.pool", rect_text(pool) + " to pool; it must lie within the first input");
  if (plan.state_bytes > 0 && !info.desc->stage->merge) refuse("plan.merge", "a state, but the stage has no merge()");
  if (plan.passes > 1 && !info.desc->stage->end_pass)
    refuse("plan.end-pass", std::to_string(plan.passes) + " passes, but the stage has no end_pass()");
}

void check_need(const StageInfo& info, size_t input, const triad_image& image, triad_rect r) {
  const auto refuse = [&](const char* rule, const std::string& what) {
    throw PluginError(
        rule, info.id(), info.file,
        "need() asked input '" + std::string(info.desc->inputs[input]->name) + "' for " + rect_text(r) + ", " + what);
  };
  if (r.x0 >= r.x1 || r.y0 >= r.y1) refuse("need.empty", "which is empty or inverted");
  const int64_t reach_x = std::max<int64_t>(image.width, kAlwaysAllowedReach_px);
  const int64_t reach_y = std::max<int64_t>(image.height, kAlwaysAllowedReach_px);
  if (r.x0 < -reach_x || r.x1 > image.width + reach_x || r.y0 < -reach_y || r.y1 > image.height + reach_y)
    refuse("need.far", "more than its own size beyond the picture of " + std::to_string(image.width) + "x" +
                           std::to_string(image.height));
}

void check_scores(const StageInfo& info, const std::vector<double>& scores) {
  for (size_t i = 0; i < scores.size(); ++i) {
    const triad_score& score = *info.desc->scores[i];
    const std::string name = "score '" + std::string(score.name) + "'";
    if (std::isnan(scores[i]))
      throw PluginError("score.not-a-number", info.id(), info.file, "end_pass() left " + name + " not a number");
    if (std::isinf(scores[i]) && !(score.flags & TRIAD_SCORE_MAY_BE_INFINITE))
      throw PluginError("score.infinite", info.id(), info.file,
                        "end_pass() gave an infinite " + name + ", which its table does not allow");
  }
}

}  // namespace triad
