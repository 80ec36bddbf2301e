// SPDX-License-Identifier: Apache-2.0
// Messages on stderr. All functions may be called from any thread.
#pragma once

#include <string>

namespace triad {

enum class LogLevel { kDebug, kInfo, kWarning };

// Messages below this level are dropped. Default: kWarning.
void set_log_level(LogLevel level);
LogLevel log_level();

// Prints "triad: warning: message" (or "triad: message" for the lower levels) as one line on stderr.
// A warning already printed in this process is not printed again.
void log_message(LogLevel level, const std::string& message);
inline void warn(const std::string& message) { log_message(LogLevel::kWarning, message); }

// Control characters, which would let a file name or a plugin's message move the cursor, become "\xNN".
std::string printable(const std::string& text);

}  // namespace triad
