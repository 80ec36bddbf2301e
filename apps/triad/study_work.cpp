// SPDX-License-Identifier: Apache-2.0
#include "study_work.hpp"

#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>
#include <triad/image/writer.hpp>

namespace triad::app {
namespace {

// {name} in a text: each name, in order.
std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (size_t open = text.find('{'); open != std::string::npos; open = text.find('{', open + 1)) {
    const size_t close = text.find('}', open);
    if (close == std::string::npos) break;
    names.push_back(text.substr(open + 1, close - open - 1));
  }
  return names;
}

}  // namespace

std::unique_ptr<StudyWork> make_study_work(const StudyPlan& plan, const std::string& references) {
  if (plan.work == "render") return make_render_work(plan);
  if (plan.work == "filter") return make_filter_work(plan);
  if (plan.work == "strategy") return make_strategy_work(plan, references);
  throw_input("'" + plan.file + "': work '" + plan.work + "' is unknown" +
              did_you_mean(plan.work, {"render", "filter", "strategy"}) +
              "; a study can vary 'render', 'filter' and 'strategy'");
}

const std::string* SettingValues::find(const std::string& name) const {
  for (const auto& [key, text] : settings_)
    if (key == name) return &text;
  return nullptr;
}

std::string SettingValues::text_or(const std::string& name, const std::string& other) const {
  const std::string* found = find(name);
  return found ? *found : other;
}

std::string SettingValues::text(const std::string& name) const {
  const std::string* found = find(name);
  if (!found || found->empty()) throw_input(where() + ": the setting '" + name + "' is missing");
  return *found;
}

std::string SettingValues::filled(std::string text, const std::map<std::string, std::string>& known) const {
  for (const std::string& name : names_in(text)) {
    const auto found = known.find(name);
    const std::string value = found == known.end() ? this->text(name) : found->second;
    const std::string hole = "{" + name + "}";
    for (size_t at = text.find(hole); at != std::string::npos; at = text.find(hole, at + value.size()))
      text.replace(at, hole.size(), value);
  }
  return text;
}

std::map<std::string, std::string> SettingValues::layout_cells() const {
  const std::string layout = text_or("layout", "");
  return layout.empty() ? std::map<std::string, std::string>{} : layout_values(layout);
}

PictureSize SettingValues::size() const {
  constexpr int kMost = 65536;  // far beyond what a study is for
  const PictureSize size = parse_size(text("size"), where());
  if (size.width > kMost || size.height > kMost)
    throw_input(where() + ": size '" + text("size") + "' has a side of more than " + std::to_string(kMost) +
                " pixels");
  return size;
}

uint64_t SettingValues::seed() const {
  const std::string seed = text_or("seed", "0");
  const auto number = parse_int(seed);
  if (!number || *number < 0) throw_input(where() + ": seed '" + seed + "' is not a whole number from 0");
  return static_cast<uint64_t>(*number);
}

std::unique_ptr<Strategy> SettingValues::strategy() const {
  const std::string spp = text_or("spp", ""), strategy = text_or("strategy", "");
  if (spp.empty() == strategy.empty()) throw_input(where() + ": a render takes either 'spp' or 'strategy'");
  return make_strategy(spp.empty() ? strategy : "sobol-owen:spp=" + spp, where());
}

void check_settings(const StudyPlan& plan, const std::vector<std::string>& known, const std::string& what,
                    const std::vector<std::string>& filled) {
  const auto given = plan.given();
  std::vector<std::string> allowed = known;
  for (const std::string& name : filled) {
    const auto found = given.find(name);
    if (found == given.end()) continue;
    for (const std::string& value : found->second)
      for (const std::string& used : names_in(value)) allowed.push_back(used);
  }
  for (const auto& [name, values] : given)
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
      throw_input("'" + plan.file + "': " + what +
                  (filled.empty() ? "" : ", beside what {NAME} in '" + join(filled, "', '") + "' stands for,") +
                  " has no setting '" + name + "'" + did_you_mean(name, known) + "; it has '" + join(known, "', '") +
                  "'");
}

std::vector<std::string> study_words(const std::string& text) {
  std::vector<std::string> found = split_quoted(text, ' ');
  std::erase(found, "");
  return found;
}

std::map<std::string, std::string> layout_values(const std::string& layout) {
  const Layout panel = load_layout(layout);
  return {{"cells_x", std::to_string(panel.cells_x)}, {"cells_y", std::to_string(panel.cells_y)}};
}

std::vector<ChainItem> study_stages(const std::string& text, const std::string& where) {
  std::vector<ChainItem> stages;
  for (const std::string& stage : study_words(text)) stages.push_back(parse_stage(stage));
  if (stages.empty()) throw_input(where + ": a 'filter' without stages");
  for (const ChainItem& stage : stages)
    if (stage.is_write) throw_input(where + ": filter '" + text + "' writes a file; a study does not");
  return stages;
}

Measurements judge_picture(std::shared_ptr<const Image> picture, const std::vector<Judge>& judges, PluginHost& host,
                           const ColourConfig& colours) {
  RunRequest request;
  request.input = {"what comes out", {}, std::move(picture)};
  for (const Judge& judge : judges)
    request.metrics.push_back({judge.metric, {judge.reference.name, {}, judge.reference.image}, ""});
  const RunResult result = Run(request, host, colours).execute();
  Measurements scores;
  for (size_t m = 0; m < result.metrics.size(); ++m) {
    const MetricResult& metric = result.metrics[m];
    if (metric.nonfinite_failed) throw_input("what comes out, or the picture, holds values that are not finite");
    for (const auto& score : metric.scores)
      scores.emplace_back(m == 0 ? score.name : metric.label + "." + score.name, score.value);
  }
  return scores;
}

RenderResult render_whole(const Strategy& strategy, const Source& source, RenderOptions options) {
  options.stop = [] { return cancel_requested(); };
  RenderResult result = strategy.render(source, options);
  check_cancel();
  return result;
}

void write_float_picture(const std::string& path, const Image& image) {
  WriteOptions options;
  options.depth = Depth::kFloat;
  write_image(path, image, options);
}

Measurements work_since(const Source& source, const std::vector<WorkCount>& before) {
  Measurements done;
  double all = 0;
  const auto after = source.work();
  for (size_t i = 0; i < after.size(); ++i) {
    const auto count = static_cast<double>(after[i].count - before[i].count);
    done.emplace_back(after[i].kind, count);
    all += count;
  }
  done.emplace_back("all rays", all);
  return done;
}

}  // namespace triad::app
