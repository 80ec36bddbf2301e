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
#include <triad/abi/plugin_calls.hpp>
#include <triad/abi/plugin_params.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>

#pragma GCC visibility push(hidden)
namespace triad_plugin {

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
        self.stage.merge(pass, *static_cast<typename T::State*>(into), *static_cast<const typename T::State*>(from));
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

}  // namespace triad_plugin
#pragma GCC visibility pop

// Once per plugin, at file scope: the library's name, then its stages.
#define TRIAD_PLUGIN(name, ...) \
  constinit const triad_library triad_library_v1 = ::triad_plugin::library<__VA_ARGS__>(name);

#endif
