// SPDX-License-Identifier: Apache-2.0
// How the work of a Run is cut into drives and strips, and what memory that takes.
#include <algorithm>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

// A strip's rows are chosen so that its widest level is about this large: small enough to stay in a
// last-level cache with its neighbours, large enough that reading by blocks pays.
constexpr uint64_t kStripBytes = 2u << 20;
constexpr int kMinStripRows = 16, kMaxStripRows = 1024;
// A stage whose needs make its input's rows come this many times is given them from memory.
constexpr double kRecomputeLimit = 2.0;
// Metrics that have no strips in common below this do not run together: memory is for strips, not for pictures.
constexpr int64_t kMostCommonRows = 4096;
// What the program and its libraries hold, code included; measured as the resident size with a 1 x 1 picture.
constexpr uint64_t kBaseBytes = 144u << 20;
// A picture that is written and then cropped makes its strips longer; past this factor it is written by a drive
// of its own.
constexpr uint64_t kUnevenLimit = 2;

uint64_t picture_bytes(const ImageSpec& spec) {
  return static_cast<uint64_t>(spec.width) * spec.height * spec.channels.size() * sizeof(float);
}

}  // namespace

void Run::Impl::plan_drives() {
  int first = 0;
  bool held = false;  // whether level `first` is in memory
  const auto push = [&](int last, Sink sink, int pass, int sink_height) {
    Drive drive;
    drive.first = first;
    drive.last = last;
    drive.sink = sink;
    drive.pass = pass;
    drive.from_memory = held;
    drive.writes = sink != Sink::kPass && pass == 0;
    drive.sink_height = sink_height;
    drives.push_back(drive);
  };
  const auto hold = [&](int at) {
    push(at, Sink::kHold, 0, level(at).height);
    first = at;
    held = true;
  };
  for (int i = 0; i < levels(); ++i) {
    const FilterNode& filter = *filters[static_cast<size_t>(i)];
    const bool whole = filter.plan().strip_rows < 0;
    // How often each input row would be asked for, and whether the needs only ever move down.
    bool costly = false;
    if (!whole) {
      uint64_t asked = 0;
      RowRange before{0, 0};
      const int height = filter.out().height, step = std::min(height, kMetricStripRows);
      for (int y = 0; y < height && !costly; y += step) {
        const RowRange rows = filter.needs(filter.plan().passes - 1, {y, std::min(height, y + step)}).in;
        asked += static_cast<uint64_t>(rows.y1 - rows.y0);
        costly = rows.y0 < before.y0 || rows.y1 < before.y1;
        before = rows;
      }
      costly = costly || static_cast<double>(asked) > kRecomputeLimit * level(i).height + kMetricStripRows;
    }
    if ((whole || costly) && (i > first || (costly && !held))) {
      hold(i);
    }
    for (int pass = 0; pass + 1 < filter.plan().passes; ++pass) push(i, Sink::kPass, pass, filter.out().height);
    if (whole) {
      hold(i + 1);
    } else if (filter.plan().threads == TRIAD_SERIAL && i + 1 < levels()) {
      // A serial stage sees each of its strips once: the next stage may not ask for rows again, however the
      // picture is cut, down to single rows.
      const FilterNode& next = *filters[static_cast<size_t>(i) + 1];
      uint64_t asked = 0;
      for (int y = 0; y < next.out().height; ++y) {
        const RowRange rows = next.needs(next.plan().passes - 1, {y, y + 1}).in;
        asked += static_cast<uint64_t>(rows.y1 - rows.y0);
      }
      if (asked != static_cast<uint64_t>(level(i + 1).height) || next.plan().passes > 1) {
        hold(i + 1);
      }
    }
  }
  int passes = 1;
  bool whole_metric = false, overlapping = false;
  for (const auto& metric : metrics) {
    passes = std::max(passes, metric->plan.plan.passes);
    whole_metric = whole_metric || metric->plan.plan.strip_rows < 0;
    overlapping = true;
  }
  const bool serial_before =
      levels() > first && std::any_of(filters.begin() + first, filters.end(),
                                      [](const auto& f) { return f->plan().threads == TRIAD_SERIAL; });
  if (levels() > first && (whole_metric || (serial_before && overlapping))) hold(levels());
  const int uneven = uneven_level(first);
  if (uneven >= first && !(held && uneven == first)) {
    // A serial stage runs once only; what it made is then kept.
    if (std::any_of(filters.begin() + first, filters.begin() + uneven,
                    [](const auto& f) { return f->plan().threads == TRIAD_SERIAL; }))
      hold(uneven);
    else
      push(uneven, Sink::kWrite, 0, level(uneven).height);
  }
  for (int pass = 0; pass < passes; ++pass) {
    push(levels(), Sink::kFinal, pass, level(levels()).height);
    drives.back().writes_from = uneven + 1;
  }
}

// Outputs at a level of which later stages look at a part only (a crop): one strip would have to hold all the
// rest. They get a drive of their own, at the price of running the stages before them twice.
int Run::Impl::uneven_level(int first) const {
  int uneven = -1;
  for (int at = first; at < levels(); ++at) {
    if (std::none_of(outputs.begin(), outputs.end(), [&](const PictureOutput& o) { return o.level == at; })) continue;
    RowRange rows{0, level(levels()).height};
    for (int i = levels() - 1; i >= at; --i)
      rows = filters[static_cast<size_t>(i)]->needs(filters[static_cast<size_t>(i)]->plan().passes - 1, rows).in;
    if (level(at).height > static_cast<int64_t>(kUnevenLimit) * (rows.y1 - rows.y0)) uneven = at;
  }
  return uneven;
}

std::string Run::Impl::uneven_strips(const Drive& drive, int64_t* rows) const {
  if (drive.sink != Sink::kFinal) return "";
  const MetricNode *first = nullptr, *second = nullptr;
  int64_t common = 1, highest = 1, worst = 0;
  for (const auto& a : metrics) {
    const int64_t strip = a->strip_rows(drive.sink_height);
    common = std::min<int64_t>(std::lcm(common, strip), drive.sink_height);
    highest = std::max(highest, strip);
    for (const auto& b : metrics) {
      if (&b == &a) break;
      const int64_t pair = std::lcm(strip, static_cast<int64_t>(b->strip_rows(drive.sink_height)));
      if (pair <= worst) continue;
      worst = pair;
      first = b.get();
      second = a.get();
    }
  }
  if (common <= highest || !second) return "";
  if (rows) *rows = common;
  return "metric '" + first->instance.text() + "' works in strips of " +
         std::to_string(first->strip_rows(drive.sink_height)) + " rows, '" + second->instance.text() +
         "' in strips of " + std::to_string(second->strip_rows(drive.sink_height)) +
         ", together they need strips of " + std::to_string(common);
}

void Run::Impl::choose_rows(Drive& drive, int rows) const {
  // Whole strips of everything at the sink: a metric's fixed heights must not straddle two tokens.
  int64_t unit = 1;
  if (drive.sink == Sink::kFinal)
    for (const auto& metric : metrics)
      unit = std::min<int64_t>(std::lcm(unit, static_cast<int64_t>(metric->strip_rows(drive.sink_height))),
                               drive.sink_height);
  if (drive.sink == Sink::kPass) {
    const int strip = filters[static_cast<size_t>(drive.last)]->plan().strip_rows;
    unit = strip < 0 ? drive.sink_height : std::max(1, strip);
  }
  if (drive.sink == Sink::kHold && drive.last > drive.first &&
      filters[static_cast<size_t>(drive.last) - 1]->plan().strip_rows < 0)
    unit = drive.sink_height;
  unit = std::min<int64_t>(unit, drive.sink_height);
  const int64_t rounded = (static_cast<int64_t>(rows) + unit - 1) / unit * unit;
  drive.token_rows = static_cast<int>(std::clamp<int64_t>(rounded, 1, std::max(1, drive.sink_height)));
}

Run::Impl::TokenPlanner::TokenPlanner(const Impl& run, const Drive& drive)
    : run_(run), drive_(drive), covered_(static_cast<size_t>(drive.last - drive.first) + 1, 0) {}

std::optional<TokenPlan> Run::Impl::TokenPlanner::next() {
  if (n_ == drive_.tokens()) return std::nullopt;
  const bool last = n_ + 1 == drive_.tokens();
  TokenPlan token = run_.plan_token(drive_, n_++, last, covered_);
  token.fresh = covered_;
  for (size_t k = 0; k < covered_.size(); ++k) covered_[k] = std::max(covered_[k], token.rows[k].y1);
  token.bytes = run_.estimate(drive_, token);
  return token;
}

TokenPlan Run::Impl::plan_token(const Drive& drive, int64_t n, bool last, const std::vector<int>& covered) const {
  const size_t count = covered.size();
  TokenPlan token;
  const int y0 = static_cast<int>(n * drive.token_rows);
  token.sink = {y0,
                static_cast<int>(std::min<int64_t>(drive.sink_height, static_cast<int64_t>(y0) + drive.token_rows))};
  token.rows.resize(count);
  token.pads.resize(count);
  token.stages.resize(count - 1);
  token.reference_rows.resize(references.size());
  token.reference_pads.resize(references.size());
  RowRange rows = token.sink;
  Pads pads;
  if (drive.sink == Sink::kPass) {
    token.stages.push_back(filters[static_cast<size_t>(drive.last)]->needs(drive.pass, token.sink));
    rows = token.stages.back().in;
    pads = token.stages.back().pads;
  } else if (drive.sink == Sink::kFinal) {
    for (const auto& metric : metrics) {
      std::vector<MetricCall> calls;
      if (drive.pass < metric->plan.plan.passes) {
        const int step = metric->strip_rows(drive.sink_height), edge = metric->plan.plan.edge;
        const int width = level(levels()).width;
        for (int y = token.sink.y0; y < token.sink.y1; y += step) {
          MetricCall call;
          call.out = {y, std::min(token.sink.y1, y + step)};
          call.needs = metric->instance.need(drive.pass, {0, call.out.y0, width, call.out.y1});
          rows.cover(row_hull(call.needs[static_cast<size_t>(metric->test_input)], drive.sink_height, edge));
          token.reference_rows[metric->reference].cover(
              row_hull(call.needs[static_cast<size_t>(metric->reference_input)],
                       references[metric->reference].source->spec().height, edge));
          if (metric->mask_input >= 0 && uses_mask())
            token.mask_rows.cover(
                row_hull(call.needs[static_cast<size_t>(metric->mask_input)], drive.sink_height, edge));
          if (metric->variance_input >= 0)
            token.variance_rows.cover(
                row_hull(call.needs[static_cast<size_t>(metric->variance_input)], drive.sink_height, edge));
          calls.push_back(std::move(call));
        }
        if (metric->pools() && pools_by_weight() && drive.pass + 1 == metric->plan.plan.passes)
          token.mask_rows.cover(token.sink);
      }
      token.metrics.push_back(std::move(calls));
    }
    // The weights of --nan ignore look at the test, its variance and the reference.
    if (!token.mask_rows.empty()) {
      rows.cover(token.mask_rows);
      if (!token.variance_rows.empty()) token.variance_rows.cover(token.mask_rows);
    }
    for (size_t m = 0; m < metrics.size(); ++m)
      for (const MetricCall& call : token.metrics[m]) {
        const auto& metric = *metrics[m];
        const ImageSpec& test = level(levels());
        const ImageSpec& reference = references[metric.reference].source->spec();
        pads.cover(overhang(call.needs[static_cast<size_t>(metric.test_input)], test.width, rows));
        token.reference_pads[metric.reference].cover(overhang(call.needs[static_cast<size_t>(metric.reference_input)],
                                                              reference.width,
                                                              token.reference_rows[metric.reference]));
        if (metric.mask_input >= 0 && uses_mask())
          token.mask_pads.cover(
              overhang(call.needs[static_cast<size_t>(metric.mask_input)], test.width, token.mask_rows));
        if (metric.variance_input >= 0)
          token.variance_pads.cover(
              overhang(call.needs[static_cast<size_t>(metric.variance_input)], test.width, token.variance_rows));
      }
  }
  for (int at = drive.last;; --at) {
    const size_t k = static_cast<size_t>(at - drive.first);
    if (writes_at(drive, at)) {
      // A picture that is written needs each of its rows, in order, whatever the stages after it look at.
      rows.y0 = std::min(rows.y0, covered[k]);
      if (last) rows.y1 = level(at).height;
      rows.y1 = std::max(rows.y1, covered[k]);
    }
    token.rows[k] = rows;
    token.pads[k] = pads;
    if (at == drive.first) break;
    token.stages[k - 1] =
        filters[static_cast<size_t>(at) - 1]->needs(filters[static_cast<size_t>(at) - 1]->plan().passes - 1, rows);
    token.rows[k] = token.stages[k - 1].out;
    rows = token.stages[k - 1].in;
    pads = token.stages[k - 1].pads;
  }
  return token;
}

uint64_t Run::Impl::estimate(const Drive& drive, const TokenPlan& token) const {
  const auto bytes_at = [&](int at) {
    const size_t k = static_cast<size_t>(at - drive.first);
    return StripBuffer::bytes(token.rows[k], level(at).width, level(at).channel_count(), token.pads[k]);
  };
  const auto copies_at = [&](int at) -> uint64_t {
    if (!writes_at(drive, at)) return 0;
    return static_cast<uint64_t>(
        std::count_if(outputs.begin(), outputs.end(), [&](const PictureOutput& o) { return o.level == at; }));
  };
  uint64_t held = 0, peak = 0;  // held: references, mask, and copies that wait to be written
  for (size_t r = 0; r < references.size(); ++r) {
    const ImageSpec& spec = references[r].source->spec();
    if (!token.reference_rows[r].empty())
      held += StripBuffer::bytes(token.reference_rows[r], spec.width, spec.channel_count(), token.reference_pads[r]);
  }
  if (!token.mask_rows.empty())
    held += StripBuffer::bytes(token.mask_rows, level(levels()).width, 1, token.mask_pads);
  if (!token.variance_rows.empty())
    held += StripBuffer::bytes(token.variance_rows, level(levels()).width, 3, token.variance_pads);
  uint64_t current = bytes_at(drive.first);
  peak = held + current;
  for (int at = drive.first; at < drive.last; ++at) {
    held += copies_at(at) * current;
    const FilterNode& filter = *filters[static_cast<size_t>(at)];
    const uint64_t next = bytes_at(at + 1);
    peak = std::max(
        peak, held + current + filter.run_bytes(token.stages[static_cast<size_t>(at - drive.first)], true) + next);
    current = next;
  }
  if (drive.sink == Sink::kPass)
    peak = std::max(peak,
                    held + current + filters[static_cast<size_t>(drive.last)]->run_bytes(token.stages.back(), true));
  if (drive.sink == Sink::kFinal) {
    if (!metrics.empty()) held += copies_at(drive.last) * current;
    uint64_t maps = 0, copies = 0;
    for (const auto& metric : metrics) {
      if (metric->makes_map())
        maps += StripBuffer::bytes(token.sink, metric->map_spec.width, metric->map_spec.channel_count(), {});
      if (metric->pools()) maps += Pooling::block_bytes(pools_by_weight(), metric->pooled_values(token.sink));
      const size_t r = metric->reference;
      const ImageSpec& spec = references[r].source->spec();
      // Each metric has a copy of its own of both, unless it takes them as they are.
      copies = std::max(copies, current + metric->plan.plan.work_bytes +
                                    StripBuffer::bytes(token.reference_rows[r], spec.width,
                                                       std::max(3, spec.channel_count()), token.reference_pads[r]));
    }
    peak = std::max(peak, held + current + maps + copies);
  }
  return peak;
}

void Run::Impl::fit_memory() {
  const uint64_t limit = request.max_memory ? request.max_memory : machine_memory_bytes() / 2;
  uint64_t fixed = kBaseBytes + input->memory_bytes();
  for (const Reference& reference : references) fixed += reference.source->memory_bytes();
  if (variance) fixed += variance->memory_bytes();
  uint64_t finishing = 0;
  for (const auto& metric : metrics) {
    if (!metric->pools()) continue;
    const uint64_t values = metric->pooled_values({0, level(levels()).height});
    fixed += Pooling::held_bytes(pools_by_weight(), pool_keep_bytes(), values);
    finishing = std::max(finishing, Pooling::finish_bytes(values));
  }
  fixed += finishing;
  // Encoders hold some blocks of rows: about three of 64 rows, measured over the formats.
  for (const PictureOutput& out : outputs)
    fixed += out.path.empty()
                 ? picture_bytes(out.spec)
                 : (1u << 20) + uint64_t{3} * 64 * out.spec.width * out.spec.channels.size() * sizeof(float);
  // A held picture lives until the drive after the one that reads it: count the worst pair.
  uint64_t held_before = 0;
  peak_bytes = 0;
  for (Drive& drive : drives) {
    uint64_t widest = 1;
    for (int at = drive.first; at <= drive.last; ++at) {
      // Rows of this level for each row of the sink.
      const double ratio = static_cast<double>(level(at).height) / std::max(1, drive.sink_height);
      const double bytes = static_cast<double>(level(at).width) * level(at).channel_count() * sizeof(float) * ratio;
      widest = std::max(widest, static_cast<uint64_t>(bytes) + 1);
    }
    int64_t common_rows = 0;
    const std::string uneven = uneven_strips(drive, &common_rows);
    if (common_rows > kMostCommonRows)
      throw_input(uneven + ", but at most " + std::to_string(kMostCommonRows) +
                  " will do; compare with one at a time");
    const uint64_t base = fixed + held_before + (drive.sink == Sink::kHold ? picture_bytes(level(drive.last)) : 0);
    int rows = request.strip_rows;
    if (rows == 0) rows = static_cast<int>(std::clamp<uint64_t>(kStripBytes / widest, kMinStripRows, kMaxStripRows));
    const auto measure = [&] {
      drive.token_bytes = 0;
      TokenPlanner planner(*this, drive);
      while (const auto token = planner.next()) drive.token_bytes = std::max(drive.token_bytes, token->bytes);
    };
    choose_rows(drive, rows);
    measure();
    // One more strip than threads, so that reading goes on while all of them compute.
    drive.in_flight = static_cast<int>(std::min<int64_t>(drive.tokens(), thread_limit() + 1));
    while (base + drive.in_flight * drive.token_bytes > limit) {
      const int before = drive.token_rows;
      if (request.strip_rows == 0 && drive.token_rows > 1) {
        choose_rows(drive, std::max(1, drive.token_rows / 2));
        measure();
      }
      if (drive.token_rows == before) {
        if (drive.in_flight == 1) {
          const uint64_t least = base + drive.token_bytes;
          throw_input("this chain needs " + format_bytes(least) + " for '" + request.input.path + "', but only " +
                      format_bytes(limit) + " may be used; --max-memory " + std::to_string((least >> 20) + 1) +
                      "M would do" + (uneven.empty() ? "" : "; " + uneven + ": one at a time needs less"));
        }
        --drive.in_flight;
      }
    }
    peak_bytes = std::max(peak_bytes, base + drive.in_flight * drive.token_bytes);
    if (drive.sink == Sink::kHold) held_before = picture_bytes(level(drive.last));
  }
  if (peak_bytes < fixed) peak_bytes = fixed;
}

}  // namespace triad
