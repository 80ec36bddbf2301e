// SPDX-License-Identifier: Apache-2.0
// What a stage declares: its id, inputs, scores and typed parameters. Part of triad_plugin.hpp; include that.
#ifndef TRIAD_PLUGIN_PARAMS_HPP
#define TRIAD_PLUGIN_PARAMS_HPP

#include <triad/abi/triad_plugin.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

// Hidden: two plugins that were built with different versions of this header share nothing by accident.
#pragma GCC visibility push(hidden)
namespace triad_plugin {

// What the user can mend: status is TRIAD_E_PARAM, TRIAD_E_INPUT, TRIAD_E_MEMORY or TRIAD_E_UNSUPPORTED. The
// message is one line that says what was wrong and what would be right; the host puts the stage's name before
// it.
struct Error : std::runtime_error {
  Error(triad_status s, const std::string& message) : std::runtime_error(message), status(s) {}
  triad_status status;
};

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
  return Param<T>{detail::record(TRIAD_BOOL, name, doc, nullptr, o.flags, 0, 1, detail::int_value(TRIAD_BOOL, o.def)),
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

}  // namespace triad_plugin
#pragma GCC visibility pop

#endif
