// SPDX-License-Identifier: Apache-2.0
// triad_plugin.hpp turns a struct into the records of triad_plugin.h, as constants.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <triad/abi/triad_plugin.hpp>

extern "C" int triad_header_as_c(void);

namespace {

namespace tp = triad_plugin;

enum class Way { kFast, kSlow };
struct Sample {
  static constexpr tp::Info info{"sample", "2.1", "All kinds of parameters", "Doc"};
  static constexpr double kTaps[] = {.25, .5, .25};
  bool on;
  int8_t small;
  int64_t large;
  float factor;
  std::string title, file;
  Way way;
  std::vector<double> taps;

  static constexpr auto params() {
    return tp::list(
        tp::flag<&Sample::on>("on", "a flag", {.def = true}),
        tp::integer<&Sample::small>("small", "an integer", {.def = 3, .min = -1000, .unit = "px"}),
        tp::integer<&Sample::large>("large", "an integer"),
        tp::number<&Sample::factor>("factor", "a number", {.def = 2, .min = 0, .flags = TRIAD_PARAM_MIN_EXCLUDED}),
        tp::text<&Sample::title>("title", "a text", {.def = "t"}),
        tp::path<&Sample::file>("file", "a path", {.flags = TRIAD_PARAM_REQUIRED}),
        tp::choice<&Sample::way, "fast", "slow">("way", "a choice", {.def = "slow"}),
        tp::numbers<&Sample::taps>("taps", "a list", {.def = kTaps, .max_count = 9}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "a picture", "rgb", "linear"},
                    tp::Input{"mask", "weights", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"mean", "a mean", nullptr, -1}, tp::Score{"psnr", "a ratio", "dB", 1, 1});
  }
  struct State {
    double sum;
  };
  void plan(tp::PlanCall&) {}
  void strip(tp::StripCall& call, State& state) {
    if (call.pass == 1) throw tp::Error(TRIAD_E_INPUT, "no second pass");
    if (call.pass == 2) throw std::runtime_error("broken");
    if (call.pass == 3) throw 5;
    if (call.pass == 4) call.progress(.5);
    if (call.pass == 5) call.scratch<double>(SIZE_MAX / 4);
    state.sum += 1;
  }
  void merge(int, State& into, const State& from) const { into.sum += from.sum; }
  void end_pass(tp::EndCall& call, const State& s) { call.scores[1] = s.sum; }
};

constexpr triad_library kLibrary = tp::library<Sample>("samples");
static_assert(kLibrary.n_descs == 1 && kLibrary.magic == TRIAD_ABI_MAGIC, "known to the compiler: no code runs");

// A host that remembers what it was told.
struct Told {
  triad_status status = TRIAD_OK;
  std::string message;
} g_told;
triad_status remember(triad_call*, triad_status status, const char* text) {
  g_told = {status, text};
  return status;
}
const triad_host kHost{sizeof(triad_host),
                       0,
                       "test",
                       [](triad_call*, int32_t, const char*) {},
                       remember,
                       [](triad_call*, double) -> int32_t { return 1; },
                       [](triad_call*, size_t) -> void* { return nullptr; },
                       nullptr,
                       nullptr,
                       nullptr,
                       nullptr,
                       nullptr,
                       nullptr};

}  // namespace

TEST(PluginHeader, IsC) { EXPECT_EQ(triad_header_as_c(), 1); }

TEST(PluginHeader, DescribesParameters) {
  const triad_desc& d = *kLibrary.descs[0];
  EXPECT_EQ(d.kind, TRIAD_METRIC);
  ASSERT_EQ(d.n_params, 8u);
  const int32_t types[] = {TRIAD_BOOL,   TRIAD_INT,  TRIAD_INT,    TRIAD_FLOAT,
                           TRIAD_STRING, TRIAD_PATH, TRIAD_CHOICE, TRIAD_FLOATS};
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(d.params[i]->type, types[i]) << i;
    EXPECT_EQ(d.params[i]->def.type, types[i]) << i;
    EXPECT_EQ(d.params[i]->struct_size, TRIAD_PARAM_SIZE_1_0) << i;
  }
  EXPECT_EQ(d.params[0]->def.u.i, 1);
  EXPECT_EQ(d.params[1]->min, -128) << "narrowed to what an int8_t holds";
  EXPECT_EQ(d.params[1]->max, 127);
  EXPECT_STREQ(d.params[1]->unit, "px");
  EXPECT_EQ(d.params[2]->min, -HUGE_VAL);
  EXPECT_EQ(d.params[3]->flags, uint32_t{TRIAD_PARAM_MIN_EXCLUDED});
  EXPECT_STREQ(d.params[4]->def.u.s, "t");
  EXPECT_EQ(d.params[6]->def.u.i, 1);
  EXPECT_STREQ(d.params[6]->choices[0], "fast");
  EXPECT_EQ(d.params[6]->choices[2], nullptr);
  EXPECT_EQ(d.params[7]->def.count, 3);
  EXPECT_EQ(d.params[7]->def.u.v[1], .5);
  EXPECT_EQ(d.params[7]->max_count, 9u);
  EXPECT_EQ(d.inputs[1]->flags, uint32_t{TRIAD_INPUT_OPTIONAL});
  EXPECT_EQ(d.scores[1]->better, 1);
  EXPECT_STREQ(d.scores[1]->unit, "dB");
}

TEST(PluginHeader, CarriesErrorsAcrossAsStatuses) {
  const triad_stage& stage = *kLibrary.descs[0]->stage;
  const double taps[] = {1, 2};
  triad_value args[8] = {{TRIAD_BOOL, 1, {.i = 0}},   {TRIAD_INT, 1, {.i = -3}},     {TRIAD_INT, 1, {.i = 1}},
                         {TRIAD_FLOAT, 1, {.f = 1}},  {TRIAD_STRING, 1, {.s = "x"}}, {TRIAD_PATH, 1, {.s = "y"}},
                         {TRIAD_CHOICE, 1, {.i = 0}}, {TRIAD_FLOATS, 2, {.v = taps}}};
  void* inst = nullptr;
  ASSERT_EQ(stage.create(&kHost, nullptr, args, &inst), TRIAD_OK);
  triad_image image{}, out{};
  triad_plan plan{};
  const triad_image* const images[] = {&image, nullptr};
  EXPECT_EQ(stage.plan(inst, nullptr, 2, images, &out, &plan), TRIAD_OK);
  EXPECT_EQ(plan.state_bytes, sizeof(double));
  double state = 0, total = 4, scores[2] = {0, 0};
  const auto strip = [&](int pass) { return stage.strip(inst, nullptr, pass, {}, nullptr, nullptr, &state); };
  EXPECT_EQ(strip(0), TRIAD_OK);
  EXPECT_EQ(state, 1);
  EXPECT_EQ(strip(1), TRIAD_E_INPUT);
  EXPECT_EQ(g_told.message, "no second pass");
  EXPECT_EQ(strip(2), TRIAD_E_INTERNAL);
  EXPECT_EQ(g_told.message, "broken");
  EXPECT_EQ(strip(3), TRIAD_E_INTERNAL);
  EXPECT_EQ(strip(4), TRIAD_CANCELLED);
  EXPECT_EQ(strip(5), TRIAD_E_MEMORY);
  EXPECT_EQ(stage.merge(inst, nullptr, 0, &total, &state), TRIAD_OK);
  EXPECT_EQ(stage.end_pass(inst, nullptr, 0, &total, scores), TRIAD_OK);
  EXPECT_EQ(scores[1], 5);
  stage.destroy(inst);
}

TEST(PluginHeader, GrowsRectanglesWithoutOverflow) {
  const triad_rect r = tp::grown({0, 1, INT32_MAX, INT32_MAX - 1}, 2, 3);
  EXPECT_EQ(r.x0, -2);
  EXPECT_EQ(r.y0, -2);
  EXPECT_EQ(r.x1, INT32_MAX);
  EXPECT_EQ(r.y1, INT32_MAX);
}
