// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/plan_check.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/stage_call.hpp>
#include <triad/pipeline/stage_params.hpp>

namespace triad {
namespace {

// create, plan and destroy: one at a time in the whole process. Recursive, because a plugin that uses libtriad
// may build a chain of its own in them.
std::recursive_mutex& setup_mutex() {
  static auto* mutex = new std::recursive_mutex;
  return *mutex;
}

const char* status_name(triad_status status) {
  switch (status) {
    case TRIAD_E_PARAM: return "TRIAD_E_PARAM";
    case TRIAD_E_INPUT: return "TRIAD_E_INPUT";
    case TRIAD_E_MEMORY: return "TRIAD_E_MEMORY";
    case TRIAD_E_UNSUPPORTED: return "TRIAD_E_UNSUPPORTED";
    case TRIAD_E_INTERNAL: return "TRIAD_E_INTERNAL";
    default: return "TRIAD_CANCELLED";
  }
}

}  // namespace

struct StageInstance::Impl {
  Impl(const StageInfo& i, const ParamTexts& texts) : params(i, texts) { shared.info = &i; }
  ~Impl() {
    if (!inst) return;
    try {
      const std::lock_guard lock(setup_mutex());
      const PluginScope scope({info().desc->id, info().file.c_str(), "destroy()"});
      stage().destroy(inst);
    } catch (...) {
      warn(PluginError("call.exception", info().id(), info().file, "destroy() threw an exception across the boundary")
               .what());
    }
  }

  const StageInfo& info() const { return *shared.info; }
  const triad_stage& stage() const { return *shared.info->desc->stage; }

  [[noreturn]] void refuse(const char* rule, const std::string& what) const {
    throw PluginError(rule, info().id(), info().file, what);
  }

  // Turns a status into what the user reads.
  void check(triad_status status, const triad_call& call) const {
    if (status == TRIAD_OK) return;
    const std::string function = function_name(call.phase);
    if (status == TRIAD_CANCELLED) {
      if (cancel_requested()) throw Error(ErrorKind::kCancelled, "interrupted");
      refuse("call.cancelled", function + " says that it was cancelled, but nobody asked for that");
    }
    if (status < TRIAD_OK || status > TRIAD_CANCELLED)
      refuse("call.status", function + " returned " + std::to_string(status) + ", which is no triad_status");
    if (call.message.empty())
      refuse("call.silent-failure", function + " failed with " + status_name(status) + " and did not say why");
    const std::string text = printable(call.message);
    switch (status) {
      case TRIAD_E_PARAM:
      case TRIAD_E_UNSUPPORTED: throw_usage("stage '" + info().id() + "': " + text);
      case TRIAD_E_INTERNAL: refuse("call.internal", function + " failed: " + text);
      default: throw_input("stage '" + info().id() + "': " + text);
    }
  }

  void need_plan(const char* function) const {
    if (!planned) throw_internal("stage '" + info().id() + "': " + function + " before plan()");
  }

  mutable StageShared shared;
  StageParams params;
  void* inst = nullptr;
  bool planned = false;
  std::vector<triad_image> inputs;  // width 0 where an optional one is absent
  triad_image out{};
  triad_plan plan{};
};

StageInstance::StageInstance(const StageInfo& info, const ParamTexts& texts)
    : impl_(std::make_unique<Impl>(info, texts)) {
  const std::lock_guard lock(setup_mutex());
  triad_call call(impl_->shared, CallPhase::kCreate);
  void* made = nullptr;
  const triad_status status = call_plugin(
      call, [&] { return impl_->stage().create(&plugin_services(), &call, impl_->params.values(), &made); });
  impl_->check(status, call);
  if (!made) impl_->refuse("create.null-instance", "create() returned TRIAD_OK without an instance");
  impl_->inst = made;
}

StageInstance::~StageInstance() = default;
StageInstance::StageInstance(StageInstance&&) noexcept = default;
StageInstance& StageInstance::operator=(StageInstance&&) noexcept = default;

const StageInfo& StageInstance::info() const { return impl_->info(); }
const std::vector<std::pair<std::string, std::string>>& StageInstance::parameters() const {
  return impl_->params.texts();
}
std::string StageInstance::text() const { return impl_->params.summary(); }
const StageReports& StageInstance::reports() const { return impl_->shared.reports; }

StageInstance::Plan StageInstance::plan(const std::vector<const triad_image*>& inputs,
                                        const std::vector<const Metadata*>& metadata) {
  const triad_desc& desc = *info().desc;
  if (inputs.size() != desc.n_inputs || metadata.size() != desc.n_inputs)
    throw_internal("stage '" + info().id() + "': plan() with " + std::to_string(inputs.size()) + " inputs");
  for (uint32_t i = 0; i < desc.n_inputs; ++i)
    if (!inputs[i] && !(desc.inputs[i]->flags & TRIAD_INPUT_OPTIONAL))
      throw_usage("stage '" + info().id() + "' needs the input '" + desc.inputs[i]->name + "' (" +
                  desc.inputs[i]->doc + ")");

  Plan result;
  result.out = *inputs[0];
  result.out.struct_size = sizeof(triad_image);
  if (info().is_metric()) {
    result.out.channels = 0;
    result.out.alpha = -1;
  }
  result.plan = {sizeof(triad_plan),
                 TRIAD_SERIAL,
                 TRIAD_EDGE_CLAMP,
                 1,
                 0,
                 TRIAD_NONFINITE_KEEP,
                 0,
                 0,
                 {0, 0, inputs[0]->width, inputs[0]->height}};
  if (metadata[0]) result.metadata = *metadata[0];
  {
    const std::lock_guard lock(setup_mutex());
    triad_call call(impl_->shared, CallPhase::kPlan);
    call.input_metadata = &metadata;
    call.output_metadata = &result.metadata;
    const triad_status status = call_plugin(call, [&] {
      return impl_->stage().plan(impl_->inst, &call, static_cast<int32_t>(inputs.size()), inputs.data(), &result.out,
                                 &result.plan);
    });
    impl_->check(status, call);
  }
  // A plugin may have cleared the records; what they say of their size is the host's.
  result.out.struct_size = sizeof(triad_image);
  result.plan.struct_size = sizeof(triad_plan);
  check_plan(info(), *inputs[0], result.out, result.plan);
  impl_->inputs.clear();
  for (const triad_image* input : inputs) impl_->inputs.push_back(input ? *input : triad_image{});
  impl_->out = result.out;
  impl_->plan = result.plan;
  impl_->planned = true;
  return result;
}

std::vector<triad_rect> StageInstance::need(int pass, triad_rect out) const {
  impl_->need_plan("need()");
  std::vector<triad_rect> in(impl_->inputs.size(), out);
  triad_call call(impl_->shared, CallPhase::kNeed);
  const triad_status status =
      call_plugin(call, [&] { return impl_->stage().need(impl_->inst, &call, pass, out, in.data()); });
  impl_->check(status, call);
  for (size_t i = 0; i < in.size(); ++i)
    if (impl_->inputs[i].width > 0) check_need(info(), i, impl_->inputs[i], in[i]);
  return in;
}

void StageInstance::strip(int pass, triad_rect r, const std::vector<const triad_strip*>& in, const triad_strip* out,
                          void* state) {
  impl_->need_plan("strip()");
  triad_call call(impl_->shared, CallPhase::kStrip);
  const triad_status status =
      call_plugin(call, [&] { return impl_->stage().strip(impl_->inst, &call, pass, r, in.data(), out, state); });
  impl_->check(status, call);
}

void StageInstance::merge(int pass, void* into, const void* from) const {
  impl_->need_plan("merge()");
  if (!impl_->stage().merge) return;  // check_plan saw to it that there is no state either
  triad_call call(impl_->shared, CallPhase::kMerge);
  const triad_status status =
      call_plugin(call, [&] { return impl_->stage().merge(impl_->inst, &call, pass, into, from); });
  impl_->check(status, call);
}

std::vector<double> StageInstance::end_pass(int pass, const void* state) {
  impl_->need_plan("end_pass()");
  const triad_desc& desc = *info().desc;
  std::vector<double> scores;
  if (info().is_metric() && pass == impl_->plan.passes - 1)
    scores.assign(desc.n_scores, std::numeric_limits<double>::quiet_NaN());
  if (!impl_->stage().end_pass) return scores;
  triad_call call(impl_->shared, CallPhase::kEndPass);
  const triad_status status = call_plugin(call, [&] {
    return impl_->stage().end_pass(impl_->inst, &call, pass, state, scores.empty() ? nullptr : scores.data());
  });
  impl_->check(status, call);
  check_scores(info(), scores);
  return scores;
}

}  // namespace triad
