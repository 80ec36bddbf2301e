// SPDX-License-Identifier: Apache-2.0
// A filter and a metric that commit the offence which their parameter names. "none" is a correct blur of
// three rows, and a correct mean.
#include <triad/abi/triad_plugin.h>

#include <cfenv>
#include <chrono>
#include <climits>
#include <clocale>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <thread>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace {

const char* const kOffences[] = {"none",
                                 "null-instance",
                                 "create-throws",
                                 "create-status",
                                 "create-silent",
                                 "plan-throws",
                                 "plan-cancelled",
                                 "plan-negative",
                                 "plan-zero",
                                 "plan-product",
                                 "plan-int-max",
                                 "plan-channels",
                                 "plan-alpha",
                                 "plan-cells",
                                 "plan-aspect",
                                 "plan-threads",
                                 "plan-passes",
                                 "plan-rows",
                                 "plan-state",
                                 "plan-state-without-merge",
                                 "need-inverted",
                                 "need-empty",
                                 "need-int-min",
                                 "need-int-max",
                                 "need-throws",
                                 "strip-throws-int",
                                 "strip-throws-in-parallel",
                                 "strip-segfault",
                                 "strip-abort",
                                 "strip-divides",
                                 "strip-exit",
                                 "strip-hangs",
                                 "strip-rounding",
                                 "strip-flushes",
                                 "strip-stdout",
                                 "strip-locale",
                                 "strip-signal",
                                 "past-strip",
                                 "before-strip",
                                 "unwritten",
                                 "depends-on-split",
                                 "not-repeatable",
                                 "race",
                                 "writes-input",
                                 "reads-past-input",
                                 "stack-overflow",
                                 "destroy-throws",
                                 "scratch-huge",
                                 nullptr};

struct Filter {
  const triad_host* host;
  int64_t offence;
  float shared;
};

int g_instances = 0;

bool is(const void* inst, const char* name) {
  return std::strcmp(kOffences[static_cast<const Filter*>(inst)->offence], name) == 0;
}
const float* row(const triad_strip& s, int y) {
  return reinterpret_cast<const float*>(reinterpret_cast<const char*>(s.data) + (y - s.r.y0) * s.row_bytes);
}

triad_status create(const triad_host* host, triad_call* call, const triad_value* args, void** inst) {
  auto* filter = new Filter{host, args[0].u.i, static_cast<float>(++g_instances)};
  if (is(filter, "null-instance")) {
    delete filter;
    return TRIAD_OK;
  }
  static_cast<void>(call);
  const bool throws = is(filter, "create-throws");
  const triad_status status = is(filter, "create-status")   ? 77
                              : is(filter, "create-silent") ? TRIAD_E_PARAM
                                                            : TRIAD_OK;
  if (throws || status != TRIAD_OK) delete filter;
  if (throws) throw std::runtime_error("out of my hands");
  if (status == TRIAD_OK) *inst = filter;
  return status;
}

void destroy(void* inst) {
  const bool throws = is(inst, "destroy-throws");
  delete static_cast<Filter*>(inst);
  if (throws) throw 1;
}

triad_status plan(void* inst, triad_call*, int32_t, const triad_image* const*, triad_image* out, triad_plan* p) {
  p->threads = TRIAD_REENTRANT;
  if (is(inst, "plan-throws")) throw std::runtime_error("no plan");
  if (is(inst, "plan-cancelled")) return TRIAD_CANCELLED;
  if (is(inst, "plan-negative")) out->width = -5;
  if (is(inst, "plan-zero")) out->height = 0;
  if (is(inst, "plan-product")) out->width = out->height = INT_MAX;
  if (is(inst, "plan-int-max")) out->width = INT_MAX, out->channels = INT_MAX;
  if (is(inst, "plan-channels")) out->channels = 0;
  if (is(inst, "plan-alpha")) out->alpha = 9;
  if (is(inst, "plan-cells")) out->cells_x = 0;
  if (is(inst, "plan-aspect")) out->pixel_aspect = std::numeric_limits<double>::quiet_NaN();
  if (is(inst, "plan-threads")) p->threads = 12;
  if (is(inst, "plan-passes")) p->passes = 0;
  if (is(inst, "plan-rows")) p->strip_rows = -7;
  if (is(inst, "plan-state")) p->state_bytes = uint64_t{1} << 60;
  if (is(inst, "plan-state-without-merge")) p->state_bytes = 8;
  if (is(inst, "not-repeatable") || is(inst, "depends-on-split")) p->threads = TRIAD_SERIAL;
  return TRIAD_OK;
}

triad_status need(const void* inst, triad_call*, int32_t, triad_rect out, triad_rect* in) {
  in[0] = {out.x0, out.y0 - 1, out.x1, out.y1 + 1};
  if (is(inst, "need-inverted")) in[0] = {out.x1, out.y1, out.x0, out.y0};
  if (is(inst, "need-empty")) in[0] = {0, 0, 0, 0};
  if (is(inst, "need-int-min")) in[0] = {INT_MIN, INT_MIN, INT_MAX, INT_MAX};
  if (is(inst, "need-int-max")) in[0] = {INT_MAX - 1, 0, INT_MAX, 1};
  if (is(inst, "need-throws")) throw "a text";
  return TRIAD_OK;
}

volatile bool g_deeper = true;
int deep(volatile char* above) {
  volatile char room[4096];
  if (!g_deeper) return *above;
  room[0] = *above;
  return deep(room) + room[0];
}

void misbehave(Filter& f, triad_rect r, const triad_strip* in) {
  if (is(&f, "strip-throws-int")) throw 42;
  volatile int zero = 0;
  if (is(&f, "strip-segfault")) *reinterpret_cast<volatile int*>(static_cast<uintptr_t>(zero) + 16) = 1;
  if (is(&f, "strip-abort")) std::abort();
  if (is(&f, "strip-divides")) std::raise(SIGFPE);
  if (is(&f, "strip-exit")) std::exit(0);
  if (is(&f, "strip-hangs"))
    for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
  if (is(&f, "strip-rounding")) std::fesetround(FE_UPWARD);
#if defined(__SSE__)
  if (is(&f, "strip-flushes")) _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
  if (is(&f, "strip-stdout")) std::puts("done");
  if (is(&f, "strip-locale")) std::setlocale(LC_ALL, "C.UTF-8");
  if (is(&f, "strip-signal")) std::signal(SIGTERM, SIG_IGN);
  if (is(&f, "writes-input")) in->data[0] = 0;
  if (is(&f, "reads-past-input")) {
    volatile float sum = 0;
    const auto* end = reinterpret_cast<const char*>(row(*in, in->r.y1));
    for (int i = 0; i < 4; ++i) sum = sum + reinterpret_cast<const volatile float*>(end)[i];
  }
  volatile char start = 0;
  if (is(&f, "stack-overflow")) deep(&start);
  if (is(&f, "race")) {
    // The row waits in the instance, where another thread's row replaces it.
    f.shared = row(*in, r.y0)[0];
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

triad_status strip(void* inst, triad_call* call, int32_t, triad_rect r, const triad_strip* const* in,
                   const triad_strip* out, void*) {
  auto& f = *static_cast<Filter*>(inst);
  misbehave(f, r, in[0]);
  if (is(inst, "strip-throws-in-parallel"))
    return f.host->parallel_for(
        call, 8, [](void*, triad_call*, int64_t i) -> triad_status { return i == 5 ? throw 5 : TRIAD_OK; }, nullptr);
  if (is(inst, "scratch-huge") && f.host->scratch(call, SIZE_MAX / 2))
    return f.host->fail(call, TRIAD_E_INTERNAL, "half of all addresses were given");
  const int n = (r.x1 - r.x0) * out->channels;
  const int last = is(inst, "unwritten") ? n - 1 : n;
  for (int y = r.y0; y < r.y1; ++y) {
    auto* to = const_cast<float*>(row(*out, y));
    const float *a = row(*in[0], y - 1), *b = row(*in[0], y), *c = row(*in[0], y + 1);
    for (int i = 0; i < last; ++i) to[i] = (a[i] + b[i] + c[i]) / 3;
    if (is(inst, "past-strip")) to[n] = 1;
    if (is(inst, "before-strip") && y == r.y0) to[-1] = 1;
    if (is(inst, "depends-on-split")) to[0] = static_cast<float>(y - r.y0);
    if (is(inst, "not-repeatable")) to[0] = f.shared;
    if (is(inst, "race") && y == r.y0) to[0] = f.shared;
  }
  return TRIAD_OK;
}

const triad_stage kFilterStage{sizeof(triad_stage), 0, create, destroy, plan, need, strip, nullptr, nullptr};
const triad_param kOffence{sizeof(triad_param),    TRIAD_CHOICE, "offence", "which", nullptr, 0, 0, 0, 0,
                           {TRIAD_CHOICE, 1, {0}}, kOffences};
const triad_param* const kParams[] = {&kOffence};
const triad_input kImage{sizeof(triad_input), 0, "image", "the picture", "rgb", nullptr};
const triad_input* const kInputs[] = {&kImage};
const triad_desc kFilter{sizeof(triad_desc),
                         TRIAD_FILTER,
                         "offender",
                         "1.0",
                         "Commits an offence",
                         "",
                         1,
                         1,
                         0,
                         0,
                         kParams,
                         kInputs,
                         nullptr,
                         &kFilterStage};

// ---- the metric --------------------------------------------------------------------------------------------

const char* const kMetricOffences[] = {"none",     "score-nan", "score-infinite", "state-overrun", "last-strip-only",
                                       "map-size", nullptr};
struct State {
  double sum, count;
};
bool metric_is(const void* inst, const char* name) {
  return std::strcmp(*static_cast<const char* const*>(inst), name) == 0;
}

triad_status metric_create(const triad_host*, triad_call*, const triad_value* args, void** inst) {
  *inst = new const char*(kMetricOffences[args[0].u.i]);
  return TRIAD_OK;
}
void metric_destroy(void* inst) { delete static_cast<const char**>(inst); }
triad_status metric_plan(void* inst, triad_call*, int32_t, const triad_image* const*, triad_image* out,
                         triad_plan* p) {
  p->state_bytes = sizeof(State);
  p->threads = TRIAD_REENTRANT;
  if (metric_is(inst, "map-size")) out->channels = 1, out->width += 1;
  return TRIAD_OK;
}
triad_status metric_need(const void*, triad_call*, int32_t, triad_rect, triad_rect*) { return TRIAD_OK; }
triad_status metric_strip(void* inst, triad_call*, int32_t, triad_rect r, const triad_strip* const* in,
                          const triad_strip*, void* state) {
  auto& s = *static_cast<State*>(state);
  for (int y = r.y0; y < r.y1; ++y)
    for (int i = 0; i < (r.x1 - r.x0) * in[0]->channels; ++i)
      s.sum += static_cast<double>(row(*in[0], y)[i]), ++s.count;
  if (metric_is(inst, "state-overrun")) (&s)[1].sum = 1;
  return TRIAD_OK;
}
triad_status metric_merge(const void* inst, triad_call*, int32_t, void* into, const void* from) {
  auto& a = *static_cast<State*>(into);
  const auto& b = *static_cast<const State*>(from);
  if (metric_is(inst, "last-strip-only")) a = {0, 0};
  a.sum += b.sum;
  a.count += b.count;
  return TRIAD_OK;
}
triad_status metric_end(void* inst, triad_call*, int32_t, const void* state, double* scores) {
  const auto& s = *static_cast<const State*>(state);
  scores[0] = s.sum / s.count;
  if (metric_is(inst, "score-nan")) scores[0] = std::numeric_limits<double>::quiet_NaN();
  if (metric_is(inst, "score-infinite")) scores[0] = HUGE_VAL;
  return TRIAD_OK;
}
const triad_stage kMetricStage{sizeof(triad_stage), 0,           metric_create, metric_destroy,
                               metric_plan,         metric_need, metric_strip,  metric_merge,
                               metric_end};
const triad_param kMetricOffence{
    sizeof(triad_param),    TRIAD_CHOICE,   "metric-offence", "which", nullptr, 0, 0, 0, 0,
    {TRIAD_CHOICE, 1, {0}}, kMetricOffences};
const triad_param* const kMetricParams[] = {&kMetricOffence};
const triad_score kMean{sizeof(triad_score), 0, 0, 0, "mean", "mean value", nullptr};
const triad_score* const kScores[] = {&kMean};
const triad_desc kMetric{sizeof(triad_desc),
                         TRIAD_METRIC,
                         "offending-metric",
                         "1.0",
                         "Commits an offence",
                         "",
                         1,
                         1,
                         1,
                         0,
                         kMetricParams,
                         kInputs,
                         kScores,
                         &kMetricStage};
const triad_desc* const kDescs[] = {&kFilter, &kMetric};

}  // namespace

const triad_library triad_library_v1 = {
    TRIAD_ABI_MAGIC, TRIAD_ABI_MAJOR, TRIAD_ABI_MINOR, sizeof(triad_library), "behaviour", "C++", 2, 0,
    kDescs,          nullptr};
