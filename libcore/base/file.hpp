// SPDX-License-Identifier: Apache-2.0
// Files that appear whole or not at all, and where the program's data lies.
#pragma once

#include <string>

namespace triad {

struct TemporaryName;

// A name to write to before the rename: in the same folder and with the same extension (of at most 16
// characters). The destructor removes the temporary file unless commit() was called. Ctrl-C ends long loops
// through check_cancel(), an exception, and so leaves nothing half-written. What a process that was killed left is
// removed by the next that writes into the folder (remove_leftovers() in temporaries.hpp).
//
// Symbolic links stay: it is their target that is replaced, and the temporary file lies beside the target. A
// file that is replaced hands on its permissions.
//
// Throws Error(kInput) when the folder is missing or cannot be written to, or when `path` is a folder, a device,
// a pipe or a socket.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& path() const { return path_; }
  const std::string& temporary() const { return temporary_; }
  // Renames the temporary file to path(). Throws Error(kInput) with the system's reason.
  void commit();

 private:
  std::string path_, target_, temporary_;  // target_: path_ with its links followed
  bool committed_ = false;
  int mode_ = -1;                  // permissions of the file that is replaced, or -1
  TemporaryName* slot_ = nullptr;  // where unlink_temporaries() finds the name
};

// Removes the temporary files of all AtomicFiles that are alive; async-signal-safe, for a handler that ends
// the process.
void unlink_temporaries() noexcept;

// Writes text atomically; "-" is standard output. Character devices, pipes and what /proc shows of a process
// (/dev/null, /dev/stdout, a FIFO) are written to as they are. Throws Error(kInput) with the system's reason.
void write_text_file(const std::string& path, const std::string& text);
// Throws what write_text_file would throw over the name of the file, and writes nothing.
void check_text_file(const std::string& path);
// The whole file. Throws Error(kInput).
std::string read_text_file(const std::string& path);

// Where layouts, colour configuration, chains and scenes lie: $TRIAD_DATA, else beside the installed
// library, else the source tree this library was built from. Throws Error(kInput) if there is none.
std::string data_folder();
// Where this library lies, with links resolved; "" if the system does not say.
std::string library_folder();
// Where the bundled plugins lie: beside the installed library, else the build tree.
std::string plugin_folder();

// Asks every long loop to stop; async-signal-safe.
void request_cancel() noexcept;
bool cancel_requested() noexcept;
// Throws Error(kCancelled) once request_cancel() was called.
void check_cancel();

}  // namespace triad
