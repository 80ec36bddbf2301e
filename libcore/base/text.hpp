// SPDX-License-Identifier: Apache-2.0
// Small text helpers: parsing numbers without the locale, splitting with quotes, suggesting names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace triad {

// Splits at `separator` outside single or double quotes; backslash escapes a character within double quotes
// and outside quotes. Quotes stay in the parts, see unquote(). Throws Error(kUsage) on an unclosed quote.
std::vector<std::string> split_quoted(std::string_view text, char separator);
// Removes the quotes that split_quoted left and resolves escapes.
std::string unquote(std::string_view text);

// The whole text must be a number: no blanks around, no trailing characters, "." as the decimal point in
// any locale. parse_double accepts "inf", "-inf" and "nan".
std::optional<double> parse_double(std::string_view text);
std::optional<int64_t> parse_int(std::string_view text);
// "64", "400M", "2G", "512K", "1.5G"; powers of 1024. At least 1.
std::optional<uint64_t> parse_bytes(std::string_view text);

// The candidate with the fewest edits (insert, delete, replace, swap neighbours), if it is near enough to be
// a likely misspelling: at most a third of the longer word, at least one edit.
std::optional<std::string> nearest_name(std::string_view name, const std::vector<std::string>& candidates);
// " (did you mean 'platt'?)" or "".
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

std::string join(const std::vector<std::string>& parts, std::string_view separator);
std::string lower(std::string_view text);
// The shortest decimal text that reads back as the same double; "inf", "-inf", "nan".
std::string format_double(double value);
// "412.3 MB"; for people, powers of 1000.
std::string format_bytes(uint64_t bytes);
bool is_valid_utf8(std::string_view text);
// Bytes that are no UTF-8, as in names of files of other encodings, become "\xNN" (lower-case hexadecimal); the rest
// stays. For what must be UTF-8.
std::string escape_non_utf8(std::string_view text);
// "\x80" ... "\xff" become bytes again.
std::string unescape_non_utf8(std::string_view text);

}  // namespace triad
