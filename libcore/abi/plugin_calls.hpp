// SPDX-License-Identifier: Apache-2.0
// What a stage sees while it runs: the host's services and views of strips. Part of triad_plugin.hpp; include that.
#ifndef TRIAD_PLUGIN_CALLS_HPP
#define TRIAD_PLUGIN_CALLS_HPP

#include <triad/abi/triad_plugin.h>
#include <triad/abi/plugin_params.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#pragma GCC visibility push(hidden)
namespace triad_plugin {

namespace detail {
struct Stop {  // the host has the message already; carries the status through the plugin's frames
  triad_status status;
};
template <class F>
triad_status guarded(const triad_host* host, triad_call* call, F&& f) noexcept;
}  // namespace detail

// The host's services, for the length of one call. Pass it down, never keep it.
class Call {
 public:
  Call(const triad_host* host, triad_call* call) : host_(host), call_(call) {}

  void log(int32_t level, const std::string& text) { host_->log(call_, level, text.c_str()); }
  void info(const std::string& text) { log(TRIAD_LOG_INFO, text); }
  void warn(const std::string& text) { log(TRIAD_LOG_WARNING, text); }

  // done in [0, 1]. Leaves the function (by an exception) when the user asked to stop.
  void progress(double done) {
    if (host_->progress(call_, done)) throw detail::Stop{TRIAD_CANCELLED};
  }

  // n elements, 64-byte aligned, uninitialised, freed when the call returns.
  template <class T>
  std::span<T> scratch(size_t n) {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> && alignof(T) <= 64);
    void* memory = n <= SIZE_MAX / sizeof(T) ? host_->scratch(call_, n * sizeof(T)) : nullptr;
    if (!memory && n) throw Error(TRIAD_E_MEMORY, "no room for " + std::to_string(n) + " scratch elements");
    return {static_cast<T*>(memory), n};
  }

  // body(Call&, int64_t i) for i in [0, n) on the host's threads; each has a Call of its own. The first
  // exception leaves parallel_for.
  template <class F>
  void parallel_for(int64_t n, F&& body) {
    struct Context {
      const triad_host* host;
      std::remove_reference_t<F>* body;
    } context{host_, &body};
    const triad_status status = host_->parallel_for(
        call_, n,
        [](void* c, triad_call* call, int64_t i) -> triad_status {
          auto& ctx = *static_cast<Context*>(c);
          return detail::guarded(ctx.host, call, [&] {
            Call own(ctx.host, call);
            (*ctx.body)(own, i);
          });
        },
        &context);
    if (status != TRIAD_OK) throw detail::Stop{status};
  }

  // Metadata of input i. In plan only.
  std::optional<std::string> get_meta(int i, const char* key) {
    const char* value = host_->get_meta(call_, i, key);
    return value ? std::optional<std::string>(value) : std::nullopt;
  }
  // Metadata of the output. In plan only.
  void set_meta(const char* key, const std::string& value) { check(host_->set_meta(call_, key, value.c_str())); }
  void erase_meta(const char* key) { check(host_->set_meta(call_, key, nullptr)); }

  // A number, or a curve, for the log and the JSON results. In plan and end_pass.
  void report(const char* key, double value) { host_->report(call_, key, value); }
  void series(const char* name, std::span<const double> x, std::span<const double> y) {
    const size_t n = x.size() < y.size() ? x.size() : y.size();
    host_->series(call_, name, static_cast<int64_t>(n), x.data(), y.data());
  }

  const triad_host* host() const { return host_; }
  triad_call* raw() const { return call_; }

 private:
  static void check(triad_status status) {
    if (status != TRIAD_OK) throw detail::Stop{status};
  }
  const triad_host* host_;
  triad_call* call_;
};

// A strip as rows of pixels. F is const float for inputs and float for the output. Coordinates are the
// picture's own, so the same x, y mean the same pixel in every view.
template <class F>
class View {
 public:
  View() = default;
  explicit View(const triad_strip& s)
      : r(s.r), channels(s.channels), data_(s.data), stride_(s.row_bytes / static_cast<int64_t>(sizeof(float))) {}

  triad_rect r{};
  int channels = 0;

  int width() const { return r.x1 - r.x0; }
  int height() const { return r.y1 - r.y0; }
  int row_floats() const { return width() * channels; }
  // Pixel (r.x0, y), channel 0; the pixels of the row follow, `channels` floats each.
  F* row(int y) const { return data_ + (int64_t{y} - r.y0) * stride_; }
  // Pixel (x, y), channel 0.
  F* at(int x, int y) const { return row(y) + (int64_t{x} - r.x0) * channels; }

 private:
  F* data_ = nullptr;
  int64_t stride_ = 0;
};

class PlanCall : public Call {
 public:
  PlanCall(const Call& call, int32_t n, const triad_image* const* in, triad_image& o, triad_plan& p)
      : Call(call), inputs(n), out(o), plan(p), in_(in) {}
  bool has(int i) const { return i < inputs && in_[i]; }
  const triad_image& in(int i) const { return *in_[i]; }
  // What one call of strip() allocates and the instance keeps, for the host's memory plan. Hosts before 1.1 do
  // not ask.
  void work_bytes(uint64_t bytes) {
    if (TRIAD_HAS(&plan, triad_plan, work_bytes)) plan.work_bytes = bytes;
  }

  // Where the map is pooled; {} nowhere. Hosts before 1.2 pool no maps.
  void pool(triad_rect where) {
    if (TRIAD_HAS(&plan, triad_plan, pool)) plan.pool = where;
  }

  // Whether input i is display codes rather than linear light. Hosts before 1.2 do not say: then no.
  bool display_codes(int i) const {
    return TRIAD_HAS(&in(i), triad_image, display_codes) && in(i).display_codes != 0;
  }
  const int inputs;
  triad_image& out;
  triad_plan& plan;

 private:
  const triad_image* const* in_;
};

// needs[i]: what is required of input i; filled with the output's rectangle.
class Needs {
 public:
  explicit Needs(triad_rect* in) : in_(in) {}
  triad_rect& operator[](int i) const { return in_[i]; }

 private:
  triad_rect* in_;
};

class StripCall : public Call {
 public:
  StripCall(const Call& call, int32_t p, triad_rect rect, const triad_strip* const* in, const triad_strip* out,
            void* s)
      : Call(call), pass(p), r(rect), state(s), in_(in), out_(out) {}
  const int pass;
  const triad_rect r;  // the strip: rows and columns of the output (a metric's: of its first input)
  void* const state;   // the host's accumulator, or nullptr

  // Optional inputs may be absent; in(i) of an absent one must not be asked for.
  bool has(int i) const { return in_[i] != nullptr; }
  View<const float> in(int i) const { return View<const float>(*in_[i]); }
  // False before the last pass, and where no map is wanted.
  bool has_out() const { return out_ != nullptr; }
  View<float> out() const { return View<float>(*out_); }

 private:
  const triad_strip* const* in_;
  const triad_strip* out_;
};

class EndCall : public Call {
 public:
  EndCall(const Call& call, int32_t p, const void* s, std::span<double> sc)
      : Call(call), pass(p), state(s), scores(sc) {}
  const int pass;
  const void* const state;
  const std::span<double> scores;  // in the order of scores(); empty but in the last pass of a metric
};

// The rectangle with dx columns more on the left and right, and dy rows more above and below; it stops at the
// limits of int32_t, where no picture reaches.
constexpr triad_rect grown(triad_rect r, int32_t dx, int32_t dy) {
  const auto at = [](int64_t v) {
    constexpr int64_t kLow = INT32_MIN, kHigh = INT32_MAX;
    return static_cast<int32_t>(v < kLow ? kLow : v > kHigh ? kHigh : v);
  };
  return {at(int64_t{r.x0} - dx), at(int64_t{r.y0} - dy), at(int64_t{r.x1} + dx), at(int64_t{r.y1} + dy)};
}

}  // namespace triad_plugin
#pragma GCC visibility pop

#endif
