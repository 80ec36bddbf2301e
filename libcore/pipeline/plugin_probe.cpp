// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <set>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_guard.hpp>
#include <triad/pipeline/plugin_library.hpp>
#include <triad/pipeline/plugin_probe.hpp>
#include <triad/pipeline/stage_exercise.hpp>

namespace triad {
namespace {

constexpr int kWatchedSignals[] = {SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL};
int g_report_descriptor = -1;

// ---- what the process dies of ------------------------------------------------------------------------------

// Only async-signal-safe calls from here on.
void put(const char* text) {
  if (write(g_report_descriptor, text, std::strlen(text)) < 0) _exit(4);
}
void put_finding(const char* rule, const char* what, const char* detail) {
  const PluginFrame* frame = current_plugin_frame();
  put("F\t");
  put(rule);
  put("\t");
  put(frame ? frame->id : "");
  put("\t");
  put(frame ? frame->function : "the check itself");
  put(what);
  put(detail);
  put("\n");
}
void on_signal(int number, siginfo_t* info, void*) {
  const WatchedMemory memory =
      number == SIGSEGV || number == SIGBUS ? watched_memory(info->si_addr) : WatchedMemory::kNone;
  if (memory == WatchedMemory::kInput)
    put_finding("pixels.writes-input", " wrote to an input, which is read-only", "");
  else if (memory == WatchedMemory::kBeyondInput)
    put_finding("pixels.reads-past-input", " read or wrote past the end of an input strip", "");
  else
    put_finding("call.crash", " crashed: ", sigdescr_np(number));
  _exit(4);
}
void on_exit_call() {
  if (!current_plugin_frame()) return;
  put_finding("call.exit", " called exit(); a plugin returns a status instead", "");
  _exit(4);
}

void watch_signals() {
  disable_plugin_crash_report();
  struct sigaction action {};
  action.sa_sigaction = on_signal;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (const int number : kWatchedSignals) sigaction(number, &action, nullptr);
  std::atexit(on_exit_call);
}

void limit_memory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which map terabytes of shadow
  const rlimit limit{rlim_t{16} << 30, rlim_t{16} << 30};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

// ---- what a plugin must leave alone ------------------------------------------------------------------------

class Surroundings {
 public:
  Surroundings() : locale_(std::setlocale(LC_ALL, nullptr)), float_changes_(float_control_changes()) {
    for (size_t i = 0; i < std::size(kHandlers); ++i) sigaction(kHandlers[i], nullptr, &actions_[i]);
    std::fflush(stdout);
    output_bytes_ = bytes_on_stdout();
  }

  // Calls fail(rule, what) for each thing that changed, and puts it back.
  template <class F>
  void compare(const F& fail) {
    if (locale_ != std::setlocale(LC_ALL, nullptr)) {
      fail("call.locale", "changed the locale to " + std::string(std::setlocale(LC_ALL, nullptr)));
      std::setlocale(LC_ALL, locale_.c_str());
    }
    std::fflush(stdout);
    if (bytes_on_stdout() != output_bytes_) fail("call.stdout", "wrote to standard output; use log() instead");
    if (float_control_changes() != float_changes_)
      fail("float.control-word", "changed the floating-point control word or rounding mode (-ffast-math?)");
    for (size_t i = 0; i < std::size(kHandlers); ++i) {
      struct sigaction now {};
      sigaction(kHandlers[i], nullptr, &now);
      if (now.sa_sigaction == actions_[i].sa_sigaction) continue;
      fail("call.signal-handlers", std::string("changed the handler of SIG") + sigabbrev_np(kHandlers[i]));
      sigaction(kHandlers[i], &actions_[i], nullptr);
    }
  }

 private:
  static constexpr int kHandlers[] = {SIGINT, SIGTERM, SIGPIPE, SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL};
  static off_t bytes_on_stdout() {
    struct stat info {};
    return fstat(STDOUT_FILENO, &info) == 0 ? info.st_size : 0;
  }
  std::string locale_;
  uint64_t float_changes_;
  struct sigaction actions_[std::size(kHandlers)];
  off_t output_bytes_ = 0;
};

// ---- one stage ---------------------------------------------------------------------------------------------

struct Shape {
  int width, height;
  Cells cells;
};
// One pixel, one row, one column, odd sizes, more than one SIMD vector, wide renders.
constexpr Shape kShapes[] = {{1, 1, {1, 1}},  {7, 5, {1, 1}},   {64, 33, {1, 1}}, {257, 3, {1, 1}},
                             {1, 40, {1, 1}}, {96, 17, {3, 1}}, {21, 8, {3, 1}},  {6, 12, {1, 3}}};
// For stages that took none of these, such as those that look at a picture at several scales.
constexpr Shape kLarger{181, 300, {1, 1}};
// Near the largest int32_t, with room for what a careful need() adds to it.
constexpr int kTallest = 2'000'000'000;
constexpr int kThreads = 4, kRaceRuns = 4;
// How far scores may move with the height of the strips: float accumulators are allowed, wrong borders not.
constexpr double kScoreTolerance = 1e-5;

class StageProbe {
 public:
  StageProbe(const StageInfo& info, const ParamTexts& given, ProbeReport& report)
      : info_(info), desc_(*info.desc), report_(report) {
    for (uint32_t i = 0; i < desc_.n_params; ++i) {
      const triad_param& p = *desc_.params[i];
      if (const auto it = given.find(p.name); it != given.end())
        params_[p.name] = it->second;
      else if (p.flags & TRIAD_PARAM_REQUIRED)
        guess(p);
    }
  }

  void run() {
    if (!unguessable_.empty()) {
      report_.send('S', "stage.accepts", info_.id(),
                   "needs the parameter '" + unguessable_ + "'; give it with the check's parameters");
      return;
    }
    Surroundings before;
    mark("creating an instance");
    bool created = false;
    guarded([&] {
      StageInstance instance(info_, params_);
      created = true;
    });
    if (created) {
      for (const Shape& shape : kShapes)
        for (const int channels : {4, 1}) shape_with(shape, channels);
      if (accepted_ == 0) shape_with(kLarger, 4);
      for (const Shape& shape : {Shape{1, kTallest, {1, 1}}, Shape{100003, 1, {1, 1}}}) extreme(shape);
    }
    before.compare([&](const char* rule, const std::string& what) { fail(rule, what); });
    if (failed_.empty() && accepted_ == 0)
      report_.send('S', "stage.accepts", info_.id(), "it took none of the pictures offered: " + declined_);
    else
      passed();
  }

 private:
  void mark(const std::string& what) { report_.send('M', "", info_.id(), what); }
  void fail(const std::string& rule, const std::string& what) {
    if (failed_.insert(rule).second) report_.send('F', rule, info_.id(), what);
  }
  void passed() {
    struct Group {
      const char *rule, *message;
      std::initializer_list<const char*> prefixes;
    };
    const Group groups[] = {
        {"call", "create() to destroy() return a status and leave the process alone", {"call.", "float.", "create."}},
        {"plan", "sizes from 1x1 to 1x2000000000 give usable plans and needs", {"plan.", "need."}},
        {"pixels", "every pixel is written, nothing else is, and the split does not matter", {"pixels.", "state."}},
        {"threads", "several threads give the bits that one gives", {"threads."}},
        {"score", "scores are numbers", {"score."}}};
    for (const Group& group : groups) {
      if (accepted_ == 0 && std::strcmp(group.rule, "call") != 0) continue;
      if (std::strcmp(group.rule, "score") == 0 && !info_.is_metric()) continue;
      if (std::strcmp(group.rule, "threads") == 0 && !reentrant_) continue;
      bool broken = false;
      for (const std::string& rule : failed_)
        for (const char* prefix : group.prefixes) broken = broken || rule.starts_with(prefix);
      if (!broken) report_.send('P', group.rule, info_.id(), group.message);
    }
  }

  // Runs f; a rule that is broken is a finding, a picture or parameter that is refused politely is not.
  template <class F>
  void guarded(const F& f) {
    try {
      f();
    } catch (const PluginError& error) {
      fail(error.rule(), error.finding());
    } catch (const Error& error) {
      declined_ = error.what();
    } catch (const std::bad_alloc&) {
      declined_ = "out of memory";
    }
  }

  void guess(const triad_param& p) {
    const double low = std::isfinite(p.min) ? p.min : std::min(1.0, p.max),
                 high = std::isfinite(p.max) ? p.max : low + 2;
    switch (p.type) {
      case TRIAD_BOOL: params_[p.name] = "false"; break;
      case TRIAD_CHOICE: params_[p.name] = p.choices[0]; break;
      case TRIAD_INT:
        params_[p.name] =
            std::to_string(static_cast<int64_t>(std::ceil(low)) + ((p.flags & TRIAD_PARAM_MIN_EXCLUDED) ? 1 : 0));
        break;
      case TRIAD_FLOAT:
      case TRIAD_FLOATS:
        params_[p.name] = format_double((p.flags & TRIAD_PARAM_MIN_EXCLUDED) ? low + (high - low) / 2 : low);
        break;
      default: unguessable_ = p.name;
    }
  }

  void shape_with(const Shape& shape, int channels) {
    const std::string text = std::to_string(shape.width) + "x" + std::to_string(shape.height) + " with " +
                             std::to_string(shape.cells.x) + "x" + std::to_string(shape.cells.y) + " cells";
    // A metric may want a test picture that is as large as the reference in display pixels.
    const bool mixed = desc_.n_inputs > 1 && shape.cells.x > 1 && shape.width % shape.cells.x == 0;
    for (const bool standard_first : {false, true}) {
      if (standard_first && !mixed) continue;
      for (const bool with_optional : {false, true}) {
        mark("working on " + text);
        std::vector<SyntheticPicture> pictures;
        for (uint32_t i = 0; i < desc_.n_inputs; ++i) {
          const std::string kind = desc_.inputs[i]->channels;
          const bool small = standard_first && i == 0;
          pictures.push_back(synthetic_picture(small ? shape.width / shape.cells.x : shape.width, shape.height,
                                               kind == "rgb" || kind == "variance.*" ? 3
                                               : kind == "mask"                      ? 1
                                                                                     : channels,
                                               small ? Cells{} : shape.cells, i + 1));
        }
        std::vector<const SyntheticPicture*> inputs;
        bool any_optional = false, any_free = false;
        for (uint32_t i = 0; i < desc_.n_inputs; ++i) {
          const bool optional = (desc_.inputs[i]->flags & TRIAD_INPUT_OPTIONAL) != 0;
          any_optional = any_optional || optional;
          any_free = any_free || std::strcmp(desc_.inputs[i]->channels, "*") == 0;
          inputs.push_back(optional && !with_optional ? nullptr : &pictures[i]);
        }
        if ((with_optional && !any_optional) || (channels == 1 && !any_free)) continue;
        guarded([&] { exercise(inputs, text); });
      }
    }
  }

  Exercise prepare(StageInstance& instance, const std::vector<const SyntheticPicture*>& inputs) const {
    std::vector<const triad_image*> images;
    for (const SyntheticPicture* picture : inputs) images.push_back(picture ? &picture->image : nullptr);
    static const Metadata kNone;
    std::vector<const Metadata*> metadata(inputs.size(), &kNone);
    return {&instance, instance.plan(images, metadata), inputs};
  }

  void exercise(const std::vector<const SyntheticPicture*>& inputs, const std::string& text) {
    StageInstance instance(info_, params_);
    const Exercise whole = prepare(instance, inputs);
    ++accepted_;
    reentrant_ = reentrant_ || whole.plan.plan.threads == TRIAD_REENTRANT;
    const ExerciseOutcome expected = run_exercise(whole, {});

    StageInstance second(info_, params_);
    if (!(run_exercise(prepare(second, inputs), {}) == expected))
      fail("pixels.not-repeatable", "two instances give different results for the same picture of " + text);
    if (info_.is_metric()) {
      StageInstance without_map(info_, params_);
      same_scores(run_exercise(prepare(without_map, inputs), {.want_map = false}), expected, 0,
                  "pixels.not-repeatable", "the scores depend on whether a map is wanted, at " + text);
    }
    const int height = info_.is_metric() ? inputs[0]->image.height : whole.plan.out.height;
    for (const uint32_t seed : {0u, 1u, 2u}) {
      StageInstance split(info_, params_);
      const ExerciseOutcome outcome =
          run_exercise(prepare(split, inputs), {.borders = cuts(height, seed), .descending = seed == 2});
      compare_split(outcome, expected,
                    seed == 0 ? "one-row strips of " + text : "strips of uneven height of " + text);
    }
    if (whole.plan.plan.threads == TRIAD_REENTRANT) race(inputs, height, text);
  }

  void race(const std::vector<const SyntheticPicture*>& inputs, int height, const std::string& text) {
    mark("working on " + text + " with " + std::to_string(kThreads) + " threads");
    StageInstance instance(info_, params_);
    const Exercise one = prepare(instance, inputs);
    const ExerciseOutcome expected = run_exercise(one, {.borders = cuts(height, 0)});
    for (int run = 0; run < kRaceRuns; ++run) {
      StageInstance shared(info_, params_);
      const Exercise many = prepare(shared, inputs);
      if (!(run_exercise(many, {.borders = cuts(height, 0), .threads = kThreads}) == expected))
        fail("threads.race", "it says TRIAD_REENTRANT, but " + std::to_string(kThreads) +
                                 " threads give another result than one, at " + text);
    }
  }

  // seed 0: every row a strip.
  static std::vector<int> cuts(int height, uint32_t seed) {
    std::vector<int> borders;
    uint32_t x = seed * 2654435761u;
    for (int y = 0; y < height;) {
      borders.push_back(y);
      x = x * 1664525u + 1013904223u;  // Numerical Recipes, 2nd ed., ranqd1
      y += seed == 0 ? 1 : 1 + static_cast<int>(x >> 29);
    }
    return borders;
  }

  void compare_split(const ExerciseOutcome& got, const ExerciseOutcome& expected, const std::string& text) {
    if (!(ExerciseOutcome{got.pixels, {}} == ExerciseOutcome{expected.pixels, {}}))
      fail("pixels.depends-on-split", "the pixels of " + text + " are not those of the whole picture in one strip");
    same_scores(got, expected, kScoreTolerance, "pixels.depends-on-split",
                "the scores of " + text + " are not those of the whole picture in one strip");
  }
  void same_scores(const ExerciseOutcome& got, const ExerciseOutcome& expected, double tolerance, const char* rule,
                   const std::string& what) {
    for (size_t i = 0; i < got.scores.size(); ++i) {
      const double a = got.scores[i], b = expected.scores[i];
      if (a != b && !(std::abs(a - b) <= tolerance * std::max({1.0, std::abs(a), std::abs(b)}))) fail(rule, what);
    }
  }

  // Plans and needs only: no memory holds these pictures.
  void extreme(const Shape& shape) {
    mark("planning for " + std::to_string(shape.width) + "x" + std::to_string(shape.height));
    guarded([&] {
      StageInstance instance(info_, params_);
      std::vector<SyntheticPicture> pictures;
      for (uint32_t i = 0; i < desc_.n_inputs; ++i) {
        pictures.push_back(
            synthetic_picture(1, 1, std::strcmp(desc_.inputs[i]->channels, "mask") == 0 ? 1 : 3, {}, i));
        pictures.back().image.width = shape.width;
        pictures.back().image.height = shape.height;
      }
      std::vector<const SyntheticPicture*> inputs;
      for (const SyntheticPicture& picture : pictures) inputs.push_back(&picture);
      const Exercise planned = prepare(instance, inputs);
      const int width = info_.is_metric() ? shape.width : planned.plan.out.width;
      const int height = info_.is_metric() ? shape.height : planned.plan.out.height;
      const int rows = planned.plan.plan.strip_rows;
      if (rows < 0) {
        instance.need(0, {0, 0, width, height});
        return;
      }
      const int step = rows > 0 ? rows : 1, last = (height - 1) / step * step;
      instance.need(0, {0, 0, width, std::min(step, height)});
      instance.need(0, {0, last / step / 2 * step, width, std::min(last / step / 2 * step + step, height)});
      instance.need(0, {0, last, width, height});
    });
  }

  const StageInfo& info_;
  const triad_desc& desc_;
  ProbeReport& report_;
  ParamTexts params_;
  std::string unguessable_, declined_;
  std::set<std::string> failed_;
  int accepted_ = 0;
  bool reentrant_ = false;
};

}  // namespace

void ProbeReport::send(char kind, const std::string& rule, const std::string& stage, const std::string& message) {
  const std::string line =
      std::string(1, kind) + "\t" + rule + "\t" + printable(stage) + "\t" + printable(message) + "\n";
  if (write(descriptor_, line.data(), line.size()) < 0) _exit(4);
}

void probe_plugin(const std::string& path, const ParamTexts& params, int report_descriptor) {
  g_report_descriptor = report_descriptor;
  ProbeReport report(report_descriptor);
  // What plugins print must not mix with the caller's output, and its size tells that they printed.
  if (const int sink = memfd_create("stdout", 0); sink >= 0) dup2(sink, STDOUT_FILENO);
  set_log_level(LogLevel::kWarning);
  watch_signals();
  limit_memory();
  report.send('M', "", "", "loading it");
  try {
    Surroundings before;
    const std::vector<StageInfo>& stages = load_plugin_file(path, PathTrust::kNamed);
    report.send('P', "record", "", std::to_string(stages.size()) + " stage(s) with sound tables");
    bool quiet = true;
    before.compare([&](const char* rule, const std::string& what) {
      quiet = false;
      report.send('F', rule, "", "loading it " + what);
    });
    if (quiet) report.send('P', "load", "", "loading it leaves the process alone");
    for (const StageInfo& stage : stages) StageProbe(stage, params, report).run();
  } catch (const PluginError& error) {
    report.send('F', error.rule(), "", error.finding());
  } catch (const std::exception& error) {
    report.send('F', "call.crash", "", std::string("the check itself failed: ") + error.what());
  }
  report.send('D', "", "", "");
  _exit(0);
}

}  // namespace triad
