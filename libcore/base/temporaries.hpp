// SPDX-License-Identifier: Apache-2.0
// Names of temporary files, and what processes that were killed left of them; for file.cpp.
#pragma once

#include <string>

namespace triad {

// ".triad-MACHINE-PID-NUMBER" and the extension. MACHINE is eight hexadecimal digits, a hash of the machine's name,
// its /etc/machine-id and the process's PID namespace: who has the same one sees the same processes. NUMBER is
// another one for each call. Thread-safe.
std::string temporary_name(const std::string& extension);

// Removes from `folder` the regular files of exactly such names that this user owns, that were last written to 10 s
// ago or earlier, and whose process this machine does not have any more. Of each folder once in a process, as it
// reads all of the folder's names. Thread-safe; ignores errors.
//
// Safe beside other processes: a file of that name was made with O_EXCL, so none can take the name of one that is
// there, not even a process that gets the same PID after the check.
void remove_leftovers(const std::string& folder);

}  // namespace triad
