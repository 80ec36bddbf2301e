// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

std::string describe(const ImageSpec& spec) {
  std::string text = spec.size_text();
  if (spec.cells != Cells{}) text += fmt::format(", cells {}x{}", spec.cells.x, spec.cells.y);
  if (!spec.colour_space.empty()) text += ", " + spec.colour_space;
  return text;
}

std::string colour_line(const ColourTransform& transform) {
  return transform.identity() ? "" : fmt::format("            colour {} -> {}\n", transform.from(), transform.to());
}

}  // namespace

std::string Run::Impl::explain() const {
  std::string text = fmt::format("read        {}: {}\n", request.input.path, describe(level(0)));
  const auto outputs_at = [&](int at) {
    for (const PictureOutput& out : outputs) {
      if (out.level != at || out.path.empty()) continue;
      text += colour_line(out.transform);
      text += fmt::format("write       {}: {}\n", out.path, describe(out.spec));
    }
  };
  outputs_at(0);
  for (int i = 0; i < levels(); ++i) {
    const FilterNode& filter = *filters[static_cast<size_t>(i)];
    text += colour_line(filter.binding().transform);
    const triad_plan& plan = filter.plan();
    std::vector<std::string> notes;
    if (plan.strip_rows > 0) notes.push_back(fmt::format("strips of {} rows", plan.strip_rows));
    if (plan.strip_rows < 0) notes.push_back("whole picture");
    if (plan.passes > 1) notes.push_back(fmt::format("{} passes", plan.passes));
    if (plan.threads == TRIAD_SERIAL) notes.push_back("one strip at a time");
    text += fmt::format("filter      {}: {}{}\n", filter_texts[static_cast<size_t>(i)], describe(filter.out()),
                        notes.empty() ? "" : " (" + join(notes, ", ") + ")");
    for (const auto& [name, value] : filter.instance().parameters())
      text += fmt::format("              {} = {}\n", name, value);
    for (const auto& [name, value] : filter.instance().reports().values)
      text += fmt::format("              {}: {}\n", name, format_double(value));
    outputs_at(i + 1);
  }
  for (const Reference& reference : references)
    text += fmt::format("reference   {}: {}\n", reference.path, describe(reference.source->spec()));
  if (variance)
    text += fmt::format("variance    {}: {}\n", request.input.path, join(variance->spec().channels, ", "));
  if (mask) text += fmt::format("mask        {}: {}\n", request.mask, describe(mask->spec()));
  if (request.crop)
    text += fmt::format("pooling     inside {} x {} at ({}, {})\n", request.crop->width, request.crop->height,
                        request.crop->x, request.crop->y);
  for (const auto& metric : metrics) {
    text += colour_line(metric->test_binding.transform);
    text += fmt::format("metric      {} as {}, strips of {} rows\n", metric->instance.text(), metric->label,
                        metric->strip_rows(level(levels()).height));
    for (const auto& [name, value] : metric->instance.parameters())
      text += fmt::format("              {} = {}\n", name, value);
    if (!metric->map_path.empty())
      text += fmt::format("map         {}: {}\n", metric->map_path, describe(metric->map_spec));
    if (metric->pools()) {
      const triad_rect& r = metric->pool;
      const uint64_t bytes = metric->pooled_values({0, metric->map_spec.height}) * (pools_by_weight() ? 6 : 4);
      text += fmt::format("pool        {} x {} of the map at ({}, {}), {} of values {}\n", r.x1 - r.x0, r.y1 - r.y0,
                          r.x0, r.y0, format_bytes(bytes),
                          bytes <= pool_keep_bytes() ? "in memory" : "in a temporary file (TMPDIR)");
    }
  }
  for (const Drive& drive : drives) {
    const std::string from = drive.from_memory ? "memory" : "file";
    const std::string work = drive.sink == Sink::kHold    ? "hold the picture in memory"
                             : drive.sink == Sink::kPass  ? fmt::format("pass {} of {}", drive.pass + 1,
                                                                        filter_texts[static_cast<size_t>(drive.last)])
                             : drive.sink == Sink::kWrite ? "write what a later stage cuts off"
                             : metrics.empty()            ? "write"
                                                          : fmt::format("write and judge, pass {}", drive.pass + 1);
    text += fmt::format("pass over   {}: {} strip{} of {} row{}, {} in flight of {} each: {}\n", from, drive.tokens(),
                        drive.tokens() == 1 ? "" : "s", drive.token_rows, drive.token_rows == 1 ? "" : "s",
                        drive.in_flight, format_bytes(drive.token_bytes), work);
  }
  text += fmt::format("threads     {}\n", thread_limit());
  text += fmt::format("colours     {}\n", colours.origin());
  text += fmt::format("peak memory {} (estimated)\n", format_bytes(peak_bytes));
  return text;
}

}  // namespace triad
