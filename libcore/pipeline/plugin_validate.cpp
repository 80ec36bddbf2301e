// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <triad/base/text.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_library.hpp>

namespace triad {
namespace {

// Far above any sensible plugin; a count beyond is a record that was not filled in.
constexpr uint32_t kMaxDescs = 256, kMaxParams = 256, kMaxInputs = 16, kMaxScores = 64, kMaxChoices = 1024;
constexpr uint32_t kMaxFloats = 65536, kMaxRecordBytes = 65536;
constexpr size_t kMaxText = 65536;

class Validator {
 public:
  Validator(const PluginMemory& memory, const std::string& file) : memory_(memory), file_(file) {}

  void library(const triad_library* record, uint64_t symbol_size) {
    need_room(record, TRIAD_LIBRARY_SIZE_1_0, "triad_library_v1");
    if (record->magic != TRIAD_ABI_MAGIC) fail("record.magic", "triad_library_v1.magic is not TRIAD_ABI_MAGIC");
    if (record->abi_major != TRIAD_ABI_MAJOR)
      fail("record.major", "triad_library_v1.abi_major is " + std::to_string(record->abi_major) + ", not " +
                               std::to_string(TRIAD_ABI_MAJOR));
    if (record->struct_size < TRIAD_LIBRARY_SIZE_1_0)
      fail("record.size", "triad_library_v1.struct_size is " + std::to_string(record->struct_size) + ", at least " +
                              std::to_string(TRIAD_LIBRARY_SIZE_1_0) + " is right");
    if (record->struct_size > symbol_size)
      fail("record.size", "triad_library_v1.struct_size is " + std::to_string(record->struct_size) +
                              ", but the symbol has only " + std::to_string(symbol_size) + " bytes");
    newer_ = record->abi_minor > TRIAD_ABI_MINOR;
    text(record->name, "triad_library_v1.name", true);
    text(record->built_with, "triad_library_v1.built_with", false);
    if (record->extension) code(reinterpret_cast<const void*>(record->extension), "triad_library_v1.extension");
    count(record->n_descs, 1, kMaxDescs, "triad_library_v1.n_descs");
    array(record->descs, record->n_descs, "triad_library_v1.descs");
    std::set<std::string> ids;
    for (uint32_t i = 0; i < record->n_descs; ++i) {
      stage_.clear();
      const std::string where = "descs[" + std::to_string(i) + "]";
      sized(record->descs[i], TRIAD_DESC_SIZE_1_0, where);
      name(record->descs[i]->id, where + ".id");
      if (!ids.insert(record->descs[i]->id).second)
        fail("record.duplicate-id", "two of its stages have the id '" + std::string(record->descs[i]->id) + "'");
      stage_ = record->descs[i]->id;
      desc(*record->descs[i]);
    }
  }

 private:
  [[noreturn]] void fail(const char* rule, const std::string& what) const {
    throw PluginError(rule, stage_, file_, what);
  }

  void need_room(const void* p, uint64_t bytes, const std::string& what) const {
    if (!p) fail("record.null", what + " is NULL");
    if (!memory_.holds(p, bytes))
      fail("record.outside-file", what +
                                      " does not lie in the plugin's own file; has another plugin a symbol of "
                                      "that name? Build with -fvisibility=hidden -fno-gnu-unique");
  }
  // A record that begins with its struct_size.
  void sized(const void* p, uint32_t least, const std::string& what) const {
    need_room(p, least, what);
    uint32_t size;
    std::memcpy(&size, p, sizeof size);
    if (size < least || size > kMaxRecordBytes)
      fail("record.size",
           what + ".struct_size is " + std::to_string(size) + ", at least " + std::to_string(least) + " is right");
    need_room(p, size, what);
  }
  void count(uint32_t n, uint32_t least, uint32_t most, const std::string& what) const {
    if (n < least || n > most)
      fail("record.count", what + " is " + std::to_string(n) + ", it must be " + std::to_string(least) + " to " +
                               std::to_string(most));
  }
  template <class T>
  void array(const T* p, uint64_t n, const std::string& what) const {
    if (n) need_room(p, n * sizeof(T), what);
  }
  void code(const void* p, const std::string& what) const {
    if (!p) fail("record.null", what + " is NULL");
    if (!memory_.holds_code(p))
      fail("record.code-outside-file", what + " is not a function in the plugin's own file");
  }
  void text(const char* p, const std::string& what, bool not_empty) const {
    need_room(p, 1, what);
    const auto room = static_cast<size_t>(std::min<uint64_t>(memory_.room(p), kMaxText));
    const size_t length = strnlen(p, room);
    if (length == room) fail("record.text", what + " is not terminated, or longer than 65535 bytes");
    if (!is_valid_utf8({p, length})) fail("record.text", what + " is not valid UTF-8");
    if (not_empty && length == 0) fail("record.text", what + " is empty");
  }
  void name(const char* p, const std::string& what) const {
    text(p, what, false);
    if (!is_plugin_name(p))
      fail("record.name", what + " is '" + std::string(p) +
                              "'; a name is a lower-case letter and up to 31 lower-case letters, digits and hyphens");
  }
  void flags(uint32_t given, uint32_t known, const std::string& what) const {
    if ((given & ~known) && !newer_) fail("record.enum", what + ".flags has bits that mean nothing");
  }

  void desc(const triad_desc& d) {
    if (d.kind != TRIAD_FILTER && d.kind != TRIAD_METRIC)
      fail("record.enum", "kind is " + std::to_string(d.kind) + ", neither TRIAD_FILTER nor TRIAD_METRIC");
    text(d.version, "version", true);
    text(d.summary, "summary", true);
    text(d.doc, "doc", false);
    count(d.n_params, 0, kMaxParams, "n_params");
    array(d.params, d.n_params, "params");
    std::set<std::string> names;
    for (uint32_t i = 0; i < d.n_params; ++i) {
      sized(d.params[i], TRIAD_PARAM_SIZE_1_0, "params[" + std::to_string(i) + "]");
      name(d.params[i]->name, "params[" + std::to_string(i) + "].name");
      if (!names.insert(d.params[i]->name).second)
        fail("record.duplicate-name", "two parameters are called '" + std::string(d.params[i]->name) + "'");
      param(*d.params[i], "parameter '" + std::string(d.params[i]->name) + "'");
    }
    inputs(d);
    scores(d);
    stage(d);
  }

  void param(const triad_param& p, const std::string& what) const {
    if (p.type < TRIAD_BOOL || p.type > TRIAD_FLOATS)
      fail("record.enum",
           what + ": its type is " + std::to_string(p.type) + ", not one of TRIAD_BOOL ... TRIAD_FLOATS");
    text(p.doc, what + ": doc", true);
    if (p.unit) text(p.unit, what + ": unit", false);
    flags(p.flags, TRIAD_PARAM_REQUIRED | TRIAD_PARAM_MIN_EXCLUDED | TRIAD_PARAM_MAX_EXCLUDED, what);
    if (p.type == TRIAD_INT || p.type == TRIAD_FLOAT || p.type == TRIAD_FLOATS) {
      if (std::isnan(p.min) || std::isnan(p.max)) fail("record.range", what + ": its range is not a number");
      if (p.min > p.max) fail("record.range", what + ": its minimum is above its maximum");
      if (p.min == p.max && (p.flags & (TRIAD_PARAM_MIN_EXCLUDED | TRIAD_PARAM_MAX_EXCLUDED)))
        fail("record.range", what + ": its range is empty");
    }
    if (p.type == TRIAD_FLOATS) count(p.max_count, 1, kMaxFloats, what + ": max_count");
    uint32_t choices = 0;
    if (p.type == TRIAD_CHOICE)
      choices = count_choices(p, what);
    else if (p.choices)
      fail("record.choices", what + ": it has choices but is not a TRIAD_CHOICE");
    if (!(p.flags & TRIAD_PARAM_REQUIRED)) default_value(p, choices, what);
  }

  uint32_t count_choices(const triad_param& p, const std::string& what) const {
    if (!p.choices) fail("record.choices", what + ": its choices are NULL");
    std::set<std::string> names;
    for (uint32_t i = 0;; ++i) {
      if (i > kMaxChoices) fail("record.choices", what + ": its choices have no NULL at their end");
      need_room(p.choices + i, sizeof(char*), what + ": its choices");
      if (!p.choices[i]) {
        if (i == 0) fail("record.choices", what + ": it has no choices");
        return i;
      }
      text(p.choices[i], what + ": a choice", true);
      if (!names.insert(p.choices[i]).second)
        fail("record.choices", what + ": the choice '" + std::string(p.choices[i]) + "' comes twice");
    }
  }

  bool in_range(const triad_param& p, double v) const {
    if (!std::isfinite(v)) return false;
    const bool above = (p.flags & TRIAD_PARAM_MIN_EXCLUDED) ? v > p.min : v >= p.min;
    const bool below = (p.flags & TRIAD_PARAM_MAX_EXCLUDED) ? v < p.max : v <= p.max;
    return above && below;
  }

  void default_value(const triad_param& p, uint32_t choices, const std::string& what) const {
    const auto bad = [&](const char* why) { fail("record.default", what + ": its default " + why); };
    if (p.def.type != p.type) bad("is of another type than the parameter");
    switch (p.type) {
      case TRIAD_BOOL:
        if (p.def.u.i != 0 && p.def.u.i != 1) bad("is neither 0 nor 1");
        break;
      case TRIAD_INT:
        if (!in_range(p, static_cast<double>(p.def.u.i))) bad("is out of its range");
        break;
      case TRIAD_FLOAT:
        if (!in_range(p, p.def.u.f)) bad("is out of its range or not finite");
        break;
      case TRIAD_CHOICE:
        if (p.def.u.i < 0 || p.def.u.i >= choices) bad("is not the index of a choice");
        break;
      case TRIAD_FLOATS:
        if (p.def.count < 0 || static_cast<uint32_t>(p.def.count) > p.max_count) bad("is longer than max_count");
        array(p.def.u.v, static_cast<uint64_t>(p.def.count), what + ": its default list");
        for (int32_t i = 0; i < p.def.count; ++i)
          if (!in_range(p, p.def.u.v[i])) bad("has a value out of its range");
        break;
      default: text(p.def.u.s, what + ": its default", false);
    }
  }

  void inputs(const triad_desc& d) const {
    count(d.n_inputs, 1, kMaxInputs, "n_inputs");
    array(d.inputs, d.n_inputs, "inputs");
    std::set<std::string> names;
    for (uint32_t i = 0; i < d.n_inputs; ++i) {
      sized(d.inputs[i], TRIAD_INPUT_SIZE_1_0, "inputs[" + std::to_string(i) + "]");
      const triad_input& input = *d.inputs[i];
      name(input.name, "inputs[" + std::to_string(i) + "].name");
      const std::string what = "input '" + std::string(input.name) + "'";
      if (!names.insert(input.name).second) fail("record.duplicate-name", "two inputs are called " + what.substr(6));
      text(input.doc, what + ": doc", true);
      flags(input.flags, TRIAD_INPUT_OPTIONAL, what);
      text(input.channels, what + ": channels", true);
      if (!one_of(input.channels, {"rgb", "*", "mask", "variance.*"}))
        fail("record.inputs", what + ": channels is '" + std::string(input.channels) +
                                  "', not \"rgb\", \"*\", \"mask\" or \"variance.*\"");
      if (input.space) {
        text(input.space, what + ": space", true);
        if (!one_of(input.space, {"linear", "linear-rec709", "display", "display-or-linear"}))
          fail("record.inputs",
               what + ": space is '" + std::string(input.space) +
                   "', not \"linear\", \"linear-rec709\", \"display\", \"display-or-linear\" or NULL");
      }
      const bool optional = (input.flags & TRIAD_INPUT_OPTIONAL) != 0;
      if (std::strcmp(input.channels, "mask") == 0 && !optional)
        fail("record.inputs", what + ": a mask must be optional");
      if (i == 0 && optional) fail("record.inputs", what + ": the first input must not be optional");
    }
  }

  void scores(const triad_desc& d) const {
    if (d.kind == TRIAD_METRIC)
      count(d.n_scores, 1, kMaxScores, "n_scores of a metric");
    else
      count(d.n_scores, 0, 0, "n_scores of a filter");
    array(d.scores, d.n_scores, "scores");
    std::set<std::string> names;
    for (uint32_t i = 0; i < d.n_scores; ++i) {
      sized(d.scores[i], TRIAD_SCORE_SIZE_1_0, "scores[" + std::to_string(i) + "]");
      const triad_score& score = *d.scores[i];
      name(score.name, "scores[" + std::to_string(i) + "].name");
      const std::string what = "score '" + std::string(score.name) + "'";
      if (!names.insert(score.name).second) fail("record.duplicate-name", "two scores are called " + what.substr(6));
      if (score.better < -1 || score.better > 1) fail("record.scores", what + ": better is not -1, 0 or 1");
      flags(score.flags, TRIAD_SCORE_MAY_BE_INFINITE, what);
      text(score.doc, what + ": doc", true);
      if (score.unit) text(score.unit, what + ": unit", false);
    }
  }

  void stage(const triad_desc& d) const {
    sized(d.stage, TRIAD_STAGE_SIZE_1_0, "stage");
    const triad_stage& s = *d.stage;
    code(reinterpret_cast<const void*>(s.create), "stage.create");
    code(reinterpret_cast<const void*>(s.destroy), "stage.destroy");
    code(reinterpret_cast<const void*>(s.plan), "stage.plan");
    code(reinterpret_cast<const void*>(s.need), "stage.need");
    code(reinterpret_cast<const void*>(s.strip), "stage.strip");
    if (s.merge) code(reinterpret_cast<const void*>(s.merge), "stage.merge");
    if (s.end_pass || d.kind == TRIAD_METRIC) code(reinterpret_cast<const void*>(s.end_pass), "stage.end_pass");
  }

  static bool one_of(const char* text, std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&](const char* n) { return std::strcmp(n, text) == 0; });
  }

  const PluginMemory& memory_;
  const std::string& file_;
  std::string stage_;
  bool newer_ = false;  // built against a newer minor version: bits unknown here may mean something there
};

}  // namespace

bool is_plugin_name(std::string_view name) {
  if (name.empty() || name.size() > 32 || name[0] < 'a' || name[0] > 'z') return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

void validate_library(const triad_library* library, uint64_t symbol_size, const PluginMemory& memory,
                      const std::string& file) {
  Validator(memory, file).library(library, symbol_size);
}

}  // namespace triad
