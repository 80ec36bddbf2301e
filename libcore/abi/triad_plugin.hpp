// SPDX-License-Identifier: Apache-2.0
// Writing a Triad plugin in C++20: typed parameters, views of strips, and errors by exception.
//
// Read triad_plugin.h first: it says what a stage is, when each function is called and on which thread.
// This header only saves the typing. It needs the standard library and triad_plugin.h, and a plugin that
// uses it links with nothing else:
//
//   g++ -std=c++20 -O2 -shared -fPIC -I$(prefix)/include gain.cpp -o gain.triad.so
//
//   #include <triad/abi/triad_plugin.hpp>
//   namespace {
//   struct Gain {
//     static constexpr triad_plugin::Info info{"gain", "1.0", "Multiplies colour by a factor"};
//     double factor;
//     static constexpr auto params() {
//       return triad_plugin::list(
//           triad_plugin::number<&Gain::factor>("factor", "what to multiply by", {.def = 2, .min = 0}));
//     }
//     static constexpr auto inputs() {
//       return triad_plugin::list(triad_plugin::Input{"image", "the picture", "rgb", "linear"});
//     }
//     void plan(triad_plugin::PlanCall& call) { call.plan.threads = TRIAD_REENTRANT; }
//     void strip(triad_plugin::StripCall& call) const {
//       for (int y = call.r.y0; y < call.r.y1; ++y)
//         for (int i = 0; i < call.out().row_floats(); ++i)
//           call.out().row(y)[i] = static_cast<float>(factor * call.in(0).row(y)[i]);
//     }
//   };
//   }  // namespace
//   TRIAD_PLUGIN("gain", Gain)
//
// A stage is a default-constructible struct with these members:
//
//   static constexpr Info info                          required
//   static constexpr auto inputs()                      required: list(Input{...}, ...)
//   static constexpr auto params()                      list(flag<&T::m>(...), number<&T::m>(...), ...)
//   static constexpr auto scores()                      list(Score{...}, ...); makes the stage a metric
//   void create(Call&)                                  after the parameters are set
//   void plan(PlanCall&)                                call.in(i), call.out, call.plan
//   void need(int pass, triad_rect out, Needs&) const   needs[i] = rect; absent: what `out` is
//   void strip(StripCall&) [const]                      required; or strip(StripCall&, State&)
//   struct State                                        trivially copyable; zero bytes are its first value.
//                                                       plan.state_bytes is set from it
//   void merge(int pass, State& into, const State& from) const       required with State
//   void end_pass(EndCall&) or end_pass(EndCall&, const State&)      a metric fills call.scores here
//
// Any of them may throw: triad_plugin::Error for what the user can mend, anything else is reported as a
// defect of the plugin. Members may be private to the file: put the struct into an unnamed namespace.
#ifndef TRIAD_PLUGIN_HPP
#define TRIAD_PLUGIN_HPP

#include <triad/abi/triad_plugin.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

// Hidden: two plugins that were built with different versions of this header share nothing by accident.
namespace triad_plugin __attribute__((visibility("hidden"))) {

  // What the user can mend: status is TRIAD_E_PARAM, TRIAD_E_INPUT, TRIAD_E_MEMORY or TRIAD_E_UNSUPPORTED. The
  // message is one line that says what was wrong and what would be right; the host puts the stage's name before
  // it.
  struct Error : std::runtime_error {
    Error(triad_status s, const std::string& message) : std::runtime_error(message), status(s) {}
    triad_status status;
  };

  // ---- declarations: parameters, inputs, scores --------------------------------------------------------------

  struct Info {
    const char* id;        // [a-z][a-z0-9-]{0,31}
    const char* version;   // of the plugin, "1.0"
    const char* summary;   // one line
    const char* doc = "";  // as long as it takes
  };

  struct Input {
    const char* name;
    const char* doc;
    const char* channels;         // "rgb", "*", "mask"
    const char* space = nullptr;  // nullptr as it is, "linear", "linear-rec709", "display"
    uint32_t flags = 0;           // TRIAD_INPUT_OPTIONAL
  };

  struct Score {
    const char* name;
    const char* doc;
    const char* unit;    // nullptr none
    int32_t better;      // -1 lower, 0 nearer to zero, 1 higher
    uint32_t flags = 0;  // TRIAD_SCORE_MAY_BE_INFINITE
  };

  // One parameter of stage T: its record, and how a checked value gets into the instance.
  template <class T>
  struct Param {
    triad_param record;
    void (*assign)(T&, const triad_value&);
  };

  template <class... Items>
  constexpr auto list(const Items&... items) {
    return std::array<std::common_type_t<Items...>, sizeof...(Items)>{items...};
  }

  namespace detail {

  constexpr double kInfinity = std::numeric_limits<double>::infinity();

  template <class>
  struct MemberOf;
  template <class T, class M>
  struct MemberOf<M T::*> {
    using Class = T;
    using Type = M;
  };
  template <auto Member>
  using ClassOf = typename MemberOf<decltype(Member)>::Class;
  template <auto Member>
  using TypeOf = typename MemberOf<decltype(Member)>::Type;

  template <size_t N>
  struct Text {  // a string literal as a template argument
    char chars[N]{};
    constexpr Text(const char (&text)[N]) {  // NOLINT(google-explicit-constructor): that is its purpose
      for (size_t i = 0; i < N; ++i) chars[i] = text[i];
    }
  };
  template <Text... Names>
  struct NameList {  // a class, because GCC does not hide variable templates with the namespace
    static constexpr const char* kNames[sizeof...(Names) + 1] = {Names.chars..., nullptr};
  };

  constexpr triad_param record(int32_t type, const char* name, const char* doc, const char* unit, uint32_t flags,
                               double min, double max, triad_value def) {
    return {sizeof(triad_param), type, name, doc, unit, flags, 0, min, max, def, nullptr};
  }
  constexpr triad_value int_value(int32_t type, int64_t i) {
    triad_value v{type, 1, {.i = i}};
    return v;
  }
  constexpr triad_value text_value(int32_t type, const char* s) {
    triad_value v{type, 1, {.s = s}};
    return v;
  }

  }  // namespace detail

  // Options of the declarations below. flags: TRIAD_PARAM_REQUIRED, _MIN_EXCLUDED, _MAX_EXCLUDED.
  struct FlagOptions {
    bool def = false;
    uint32_t flags = 0;
  };
  struct IntegerOptions {
    int64_t def = 0;
    double min = -detail::kInfinity, max = detail::kInfinity;
    const char* unit = nullptr;
    uint32_t flags = 0;
  };
  struct NumberOptions {
    double def = 0;
    double min = -detail::kInfinity, max = detail::kInfinity;
    const char* unit = nullptr;
    uint32_t flags = 0;
  };
  struct TextOptions {
    const char* def = "";
    uint32_t flags = 0;
  };
  struct ChoiceOptions {
    std::string_view def = {};  // empty: the first
    uint32_t flags = 0;
  };
  struct NumbersOptions {
    std::span<const double> def = {};  // of a constant with static storage
    uint32_t max_count = 64;
    double min = -detail::kInfinity, max = detail::kInfinity;
    const char* unit = nullptr;
    uint32_t flags = 0;
  };

  // TRIAD_BOOL into a bool.
  template <auto Member>
  constexpr auto flag(const char* name, const char* doc, FlagOptions o = {}) {
    using T = detail::ClassOf<Member>;
    static_assert(std::same_as<detail::TypeOf<Member>, bool>);
    return Param<T>{
        detail::record(TRIAD_BOOL, name, doc, nullptr, o.flags, 0, 1, detail::int_value(TRIAD_BOOL, o.def)),
        [](T& stage, const triad_value& v) { stage.*Member = v.u.i != 0; }};
  }

  // TRIAD_INT into any integer type; the range is narrowed to what the type holds.
  template <auto Member>
  constexpr auto integer(const char* name, const char* doc, IntegerOptions o = {}) {
    using T = detail::ClassOf<Member>;
    using M = detail::TypeOf<Member>;
    static_assert(std::integral<M> && !std::same_as<M, bool>);
    if constexpr (sizeof(M) < sizeof(int64_t)) {
      constexpr auto kLow = static_cast<double>(std::numeric_limits<M>::min());
      constexpr auto kHigh = static_cast<double>(std::numeric_limits<M>::max());
      if (o.min < kLow) o.min = kLow;
      if (o.max > kHigh) o.max = kHigh;
    } else if (std::is_unsigned_v<M> && o.min < 0) {
      o.min = 0;
    }
    return Param<T>{
        detail::record(TRIAD_INT, name, doc, o.unit, o.flags, o.min, o.max, detail::int_value(TRIAD_INT, o.def)),
        [](T& stage, const triad_value& v) { stage.*Member = static_cast<M>(v.u.i); }};
  }

  // TRIAD_FLOAT into a float or double.
  template <auto Member>
  constexpr auto number(const char* name, const char* doc, NumberOptions o = {}) {
    using T = detail::ClassOf<Member>;
    using M = detail::TypeOf<Member>;
    static_assert(std::floating_point<M>);
    triad_value def{TRIAD_FLOAT, 1, {.f = o.def}};
    return Param<T>{detail::record(TRIAD_FLOAT, name, doc, o.unit, o.flags, o.min, o.max, def),
                    [](T& stage, const triad_value& v) { stage.*Member = static_cast<M>(v.u.f); }};
  }

  // TRIAD_STRING into a std::string.
  template <auto Member>
  constexpr auto text(const char* name, const char* doc, TextOptions o = {}) {
    using T = detail::ClassOf<Member>;
    static_assert(std::same_as<detail::TypeOf<Member>, std::string>);
    return Param<T>{
        detail::record(TRIAD_STRING, name, doc, nullptr, o.flags, 0, 0, detail::text_value(TRIAD_STRING, o.def)),
        [](T& stage, const triad_value& v) { stage.*Member = v.u.s; }};
  }

  // TRIAD_PATH into a std::string.
  template <auto Member>
  constexpr auto path(const char* name, const char* doc, TextOptions o = {}) {
    Param<detail::ClassOf<Member>> p = text<Member>(name, doc, o);
    p.record.type = p.record.def.type = TRIAD_PATH;
    return p;
  }

  // TRIAD_CHOICE into an integer or an enumeration whose values count from 0 in the order of the names:
  //   choice<&Platt::layout, "rgb", "bgr">("layout", "order of the stripes", {.def = "rgb"})
  template <auto Member, detail::Text... Names>
  constexpr auto choice(const char* name, const char* doc, ChoiceOptions o = {}) {
    using T = detail::ClassOf<Member>;
    using M = detail::TypeOf<Member>;
    static_assert(std::integral<M> || std::is_enum_v<M>);
    static_assert(sizeof...(Names) > 0);
    const auto& names = detail::NameList<Names...>::kNames;
    int64_t def = o.def.empty() ? 0 : -1;
    for (size_t i = 0; i < sizeof...(Names); ++i)
      if (!o.def.empty() && o.def == names[i]) def = static_cast<int64_t>(i);
    if (def < 0) throw "the default is not among the choices";  // an error of the compiler, as this is constexpr
    Param<T> p{detail::record(TRIAD_CHOICE, name, doc, nullptr, o.flags, 0, 0, detail::int_value(TRIAD_CHOICE, def)),
               [](T& stage, const triad_value& v) { stage.*Member = static_cast<M>(v.u.i); }};
    p.record.choices = names;
    return p;
  }

  // TRIAD_FLOATS into a std::vector<double>:
  //   static constexpr double kTaps[] = {.25, .5, .25};
  //   numbers<&T::weights>("weights", "the taps", {.def = kTaps, .max_count = 31})
  template <auto Member>
  constexpr auto numbers(const char* name, const char* doc, NumbersOptions o = {}) {
    using T = detail::ClassOf<Member>;
    static_assert(std::same_as<detail::TypeOf<Member>, std::vector<double>>);
    triad_value def{TRIAD_FLOATS, static_cast<int32_t>(o.def.size()), {.v = o.def.data()}};
    Param<T> p{detail::record(TRIAD_FLOATS, name, doc, o.unit, o.flags, o.min, o.max, def),
               [](T& stage, const triad_value& v) { (stage.*Member).assign(v.u.v, v.u.v + v.count); }};
    p.record.max_count = o.max_count;
    return p;
  }

  // ---- what a stage sees while it runs -----------------------------------------------------------------------

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

  // The rectangle with dx columns more on the left and right, and dy rows more above and below.
  constexpr triad_rect grown(triad_rect r, int dx, int dy) { return {r.x0 - dx, r.y0 - dy, r.x1 + dx, r.y1 + dy}; }

  // ---- from a stage to the records and functions of triad_plugin.h --------------------------------------------

  namespace detail {

  template <class F>
  triad_status guarded(const triad_host* host, triad_call* call, F&& f) noexcept {
    try {
      f();
      return TRIAD_OK;
    } catch (const Stop& stop) {
      return stop.status;
    } catch (const Error& error) {
      return host->fail(call, error.status, error.what());
    } catch (const std::bad_alloc&) {
      return host->fail(call, TRIAD_E_MEMORY, "out of memory");
    } catch (const std::exception& error) {
      return host->fail(call, TRIAD_E_INTERNAL, error.what());
    } catch (...) {
      return host->fail(call, TRIAD_E_INTERNAL, "an exception of unknown type");
    }
  }

  template <class T>
  struct Instance {
    const triad_host* host;
    T stage;
  };

  template <class T>
  concept HasParams = requires {
    T::params();
  };
  template <class T>
  concept HasScores = requires {
    T::scores();
  };
  template <class T>
  concept HasState = requires {
    sizeof(typename T::State);
  };
  template <class T>
  concept EndsWithState = HasState<T> && requires(T& t, EndCall& c, const typename T::State& s) {
    t.end_pass(c, s);
  };

  template <class T>
  constexpr auto params_of() {
    if constexpr (HasParams<T>)
      return T::params();
    else
      return std::array<Param<T>, 0>{};
  }
  template <class T>
  constexpr auto scores_of() {
    if constexpr (HasScores<T>)
      return T::scores();
    else
      return std::array<Score, 0>{};
  }

  template <class T>
  struct Functions {
    static Instance<T>& of(void* inst) { return *static_cast<Instance<T>*>(inst); }
    static const Instance<T>& of(const void* inst) { return *static_cast<const Instance<T>*>(inst); }

    static triad_status create(const triad_host* host, triad_call* raw, const triad_value* args, void** inst) {
      return guarded(host, raw, [&] {
        auto* made = new Instance<T>{host, T{}};
        try {
          constexpr auto kParams = params_of<T>();
          for (size_t i = 0; i < kParams.size(); ++i) kParams[i].assign(made->stage, args[i]);
          if constexpr (requires(T & t, Call & c) { t.create(c); }) {
            Call call(host, raw);
            made->stage.create(call);
          }
        } catch (...) {
          delete made;
          throw;
        }
        *inst = made;
      });
    }
    static void destroy(void* inst) { delete static_cast<Instance<T>*>(inst); }

    static triad_status plan(void* inst, triad_call* raw, int32_t n, const triad_image* const* in, triad_image* out,
                             triad_plan* plan) {
      auto& self = of(inst);
      return guarded(self.host, raw, [&] {
        if constexpr (HasState<T>) plan->state_bytes = sizeof(typename T::State);
        if constexpr (requires(T & t, PlanCall & c) { t.plan(c); }) {
          PlanCall call(Call(self.host, raw), n, in, *out, *plan);
          self.stage.plan(call);
        }
      });
    }
    static triad_status need(const void* inst, triad_call* raw, int32_t pass, triad_rect out, triad_rect* in) {
      const auto& self = of(inst);
      return guarded(self.host, raw, [&] {
        if constexpr (requires(const T& t, Needs& n) { t.need(0, out, n); }) {
          Needs needs(in);
          self.stage.need(pass, out, needs);
        } else {
          static_cast<void>(pass), static_cast<void>(out), static_cast<void>(in);
        }
      });
    }
    static triad_status strip(void* inst, triad_call* raw, int32_t pass, triad_rect r, const triad_strip* const* in,
                              const triad_strip* out, void* state) {
      auto& self = of(inst);
      return guarded(self.host, raw, [&] {
        StripCall call(Call(self.host, raw), pass, r, in, out, state);
        if constexpr (HasState<T>)
          self.stage.strip(call, *static_cast<typename T::State*>(state));
        else
          self.stage.strip(call);
      });
    }
    static triad_status merge(const void* inst, triad_call* raw, int32_t pass, void* into, const void* from) {
      const auto& self = of(inst);
      return guarded(self.host, raw, [&] {
        if constexpr (HasState<T>)
          self.stage.merge(pass, *static_cast<typename T::State*>(into),
                           *static_cast<const typename T::State*>(from));
        else if constexpr (requires(const T& t) { t.merge(0, into, from); })
          self.stage.merge(pass, into, from);
        else
          static_cast<void>(pass), static_cast<void>(into), static_cast<void>(from);
      });
    }
    static triad_status end_pass(void* inst, triad_call* raw, int32_t pass, const void* state, double* scores) {
      auto& self = of(inst);
      return guarded(self.host, raw, [&] {
        constexpr size_t kScores = scores_of<T>().size();
        EndCall call(Call(self.host, raw), pass, state, {scores, scores ? kScores : 0});
        if constexpr (EndsWithState<T>)
          self.stage.end_pass(call, *static_cast<const typename T::State*>(state));
        else if constexpr (requires(T & t) { t.end_pass(call); })
          self.stage.end_pass(call);
        else
          static_assert(!HasScores<T>, "a metric needs end_pass(EndCall&) or end_pass(EndCall&, const State&)");
      });
    }
  };

  // All records of one stage, as constants: nothing runs when the plugin is loaded.
  template <class T>
  struct Records {
    template <class Record, size_t N>
    static constexpr std::array<const Record*, N> pointers(const std::array<Record, N>& records) {
      std::array<const Record*, N> out{};
      for (size_t i = 0; i < N; ++i) out[i] = &records[i];
      return out;
    }
    template <size_t... I>
    static constexpr auto make_params(std::index_sequence<I...>) {
      [[maybe_unused]] constexpr auto kDeclared = params_of<T>();
      return std::array<triad_param, sizeof...(I)>{kDeclared[I].record...};
    }
    template <size_t... I>
    static constexpr auto make_inputs(std::index_sequence<I...>) {
      constexpr auto kDeclared = T::inputs();
      return std::array<triad_input, sizeof...(I)>{triad_input{sizeof(triad_input), kDeclared[I].flags,
                                                               kDeclared[I].name, kDeclared[I].doc,
                                                               kDeclared[I].channels, kDeclared[I].space}...};
    }
    template <size_t... I>
    static constexpr auto make_scores(std::index_sequence<I...>) {
      [[maybe_unused]] constexpr auto kDeclared = scores_of<T>();
      return std::array<triad_score, sizeof...(I)>{triad_score{sizeof(triad_score), kDeclared[I].better,
                                                               kDeclared[I].flags, 0, kDeclared[I].name,
                                                               kDeclared[I].doc, kDeclared[I].unit}...};
    }
    static constexpr bool state_is_plain() {
      if constexpr (HasState<T>) return std::is_trivially_copyable_v<typename T::State>;
      return true;
    }
    static_assert(std::is_default_constructible_v<T>, "a stage is created first and given its parameters then");
    static_assert(state_is_plain(), "State must be trivially copyable: the host copies it as bytes");

    static constexpr auto kParams = make_params(std::make_index_sequence<params_of<T>().size()>{});
    static constexpr auto kInputs = make_inputs(std::make_index_sequence<T::inputs().size()>{});
    static constexpr auto kScores = make_scores(std::make_index_sequence<scores_of<T>().size()>{});
    static constexpr auto kParamPointers = pointers(kParams);
    static constexpr auto kInputPointers = pointers(kInputs);
    static constexpr auto kScorePointers = pointers(kScores);
    static constexpr triad_stage kStage{sizeof(triad_stage),    0,
                                        &Functions<T>::create,  &Functions<T>::destroy,
                                        &Functions<T>::plan,    &Functions<T>::need,
                                        &Functions<T>::strip,   &Functions<T>::merge,
                                        &Functions<T>::end_pass};
    static constexpr triad_desc kDesc{sizeof(triad_desc),
                                      HasScores<T> ? TRIAD_METRIC : TRIAD_FILTER,
                                      T::info.id,
                                      T::info.version,
                                      T::info.summary,
                                      T::info.doc,
                                      static_cast<uint32_t>(kParams.size()),
                                      static_cast<uint32_t>(kInputs.size()),
                                      static_cast<uint32_t>(kScores.size()),
                                      0,
                                      kParams.empty() ? nullptr : kParamPointers.data(),
                                      kInputs.empty() ? nullptr : kInputPointers.data(),
                                      kScores.empty() ? nullptr : kScorePointers.data(),
                                      &kStage};
  };

  template <class... Stages>
  struct DescList {
    static constexpr const triad_desc* kDescs[sizeof...(Stages)] = {&Records<Stages>::kDesc...};
  };

  }  // namespace detail

  template <class... Stages>
  constexpr triad_library library(const char* name) {
    return {TRIAD_ABI_MAGIC,
            TRIAD_ABI_MAJOR,
            TRIAD_ABI_MINOR,
            sizeof(triad_library),
            name,
#ifdef __VERSION__
            "C++ " __VERSION__,
#else
            "C++",
#endif
            sizeof...(Stages),
            0,
            detail::DescList<Stages...>::kDescs,
            nullptr};
  }

}  // namespace )

// Once per plugin, at file scope: the library's name, then its stages.
#define TRIAD_PLUGIN(name, ...) \
  constinit const triad_library triad_library_v1 = ::triad_plugin::library<__VA_ARGS__>(name);

#endif
