// SPDX-License-Identifier: Apache-2.0
// What went wrong, in one line for the user, and whose turn it is to do something about it.
#pragma once

#include <stdexcept>
#include <string>

namespace triad {

enum class ErrorKind {
  kUsage,     // an option, a stage name or a parameter: exit status 2
  kInput,     // a file, a picture, a plugin: exit status 2
  kInternal,  // a defect of ours: exit status 3
  kCancelled  // Ctrl-C: exit status 130
};

// The message is complete: it names the file, option or plugin, says what was wrong and what would be
// right, and has neither a trailing full stop nor a line break.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const noexcept { return kind_; }
  // The process's exit status for this error.
  int exit_status() const noexcept;

 private:
  ErrorKind kind_;
};

[[noreturn]] void throw_usage(const std::string& message);
[[noreturn]] void throw_input(const std::string& message);
[[noreturn]] void throw_internal(const std::string& message);

}  // namespace triad
