// SPDX-License-Identifier: Apache-2.0
// JSON as text, whatever the names of files in it.
#pragma once

#include <string>
#include <triad/base/text.hpp>
#include <utility>

namespace triad {

// Replaces the strings of a nlohmann::basic_json, keys as well, by escape_non_utf8() of them, where that differs.
template <class Json>
void escape_strings(Json& value) {
  if (value.is_string()) {
    const auto& text = value.template get_ref<const std::string&>();
    if (!is_valid_utf8(text)) value = escape_non_utf8(text);
  } else if (value.is_object()) {
    Json object = Json::object();
    for (auto& [key, inner] : value.items()) {
      escape_strings(inner);
      object[escape_non_utf8(key)] = std::move(inner);
    }
    value = std::move(object);
  } else if (value.is_array()) {
    for (auto& inner : value) escape_strings(inner);
  }
}

// What dump(indent) gives, with a line break at its end where there is an indent, after escape_strings(): valid
// whatever bytes the strings hold.
template <class Json>
std::string json_text(Json root, int indent) {
  escape_strings(root);
  return root.dump(indent) + (indent < 0 ? "" : "\n");
}

}  // namespace triad
