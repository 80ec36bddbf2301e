// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>

namespace triad {

int Error::exit_status() const noexcept {
  switch (kind_) {
    case ErrorKind::kUsage:
    case ErrorKind::kInput: return 2;
    case ErrorKind::kInternal: return 3;
    case ErrorKind::kCancelled: return 130;  // 128 + SIGINT, as shells report it
  }
  return 3;
}

void throw_usage(const std::string& message) { throw Error(ErrorKind::kUsage, message); }
void throw_input(const std::string& message) { throw Error(ErrorKind::kInput, message); }
void throw_internal(const std::string& message) { throw Error(ErrorKind::kInternal, message); }

}  // namespace triad
