// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <mutex>
#include <string>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_guard.hpp>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace triad {
namespace {

// initial-exec: a signal handler may read it on any thread without allocating.
__attribute__((tls_model("initial-exec"))) thread_local const PluginFrame* t_frame = nullptr;

constexpr int kSignals[] = {SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL};
constexpr const char* kSignalNames[] = {" (SIGSEGV)", " (SIGFPE)", " (SIGABRT)", " (SIGBUS)", " (SIGILL)"};
struct sigaction g_previous[std::size(kSignals)];
std::atomic<bool> g_report{true};
std::atomic<uint64_t> g_float_changes{0};

void print(const char* text) {
  for (size_t left = std::strlen(text); left > 0;) {
    const ssize_t done = write(STDERR_FILENO, text, left);
    if (done <= 0) return;
    text += done;
    left -= static_cast<size_t>(done);
  }
}

[[noreturn]] void end_process(const PluginFrame& frame, const char* what, const char* detail) {
  print("triad: plugin ");
  if (*frame.id) {
    print("'");
    print(frame.id);
    print("' (");
    print(frame.file);
    print(")");
  } else {
    print("file '");
    print(frame.file);
    print("'");
  }
  print(what);
  print(frame.function);
  print(detail);
  print("\n");
  unlink_temporaries();
  _exit(3);
}

void on_crash(int number, siginfo_t*, void*) {
  size_t which = 0;
  while (which + 1 < std::size(kSignals) && kSignals[which] != number) ++which;
  if (t_frame) end_process(*t_frame, " crashed in ", kSignalNames[which]);
  // Not a plugin's: whoever was here before decides. The instruction faults again on return.
  sigaction(number, &g_previous[which], nullptr);
  if (number == SIGABRT) raise(number);
}

void on_exit_of_process() {
  if (t_frame && g_report) end_process(*t_frame, " called exit() in ", "");
}

void install_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    std::atexit(on_exit_of_process);
    struct sigaction action {};
    action.sa_sigaction = on_crash;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &action, &g_previous[i]);
  });
}

// A stack for the handler: a plugin that overflowed its stack has none left.
class AlternateStack {
 public:
  AlternateStack() {
    stack_t present{};
    if (sigaltstack(nullptr, &present) != 0 || !(present.ss_flags & SS_DISABLE)) return;
    memory_ = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) return;
    stack_t stack{};
    stack.ss_sp = memory_;
    stack.ss_size = kBytes;
    sigaltstack(&stack, nullptr);
  }
  ~AlternateStack() {
    if (memory_ == MAP_FAILED) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
    munmap(memory_, kBytes);
  }
  AlternateStack(const AlternateStack&) = delete;
  AlternateStack& operator=(const AlternateStack&) = delete;

 private:
  static constexpr size_t kBytes = 64 * 1024;  // AVX-512 state alone takes 3 kB of a signal frame
  void* memory_ = MAP_FAILED;
};

// Control bits only: the sticky exception flags are nobody's business.
uint32_t control_bits() {
#if defined(__SSE__)
  return _mm_getcsr() & ~0x3fu;
#else
  return static_cast<uint32_t>(fegetround());
#endif
}

void set_default_environment() {
  fesetenv(FE_DFL_ENV);
#if defined(__SSE__)
  _mm_setcsr(0x1f80);  // all exceptions masked, round to nearest, neither FTZ nor DAZ (Intel SDM vol. 1, 10.2.3)
#endif
}

}  // namespace

PluginScope::PluginScope(const PluginFrame& frame) : frame_(frame), outer_(t_frame) {
  install_handlers();
  static thread_local const AlternateStack stack;
  fegetenv(&environment_);
  set_default_environment();
  control_ = control_bits();
  t_frame = &frame_;
}

PluginScope::~PluginScope() {
  t_frame = outer_;
  const bool changed = control_bits() != control_ || fegetround() != FE_TONEAREST;
  fesetenv(&environment_);
  if (!changed) return;
  ++g_float_changes;
  warn(PluginError("float.control-word", frame_.id, frame_.file,
                   std::string(frame_.function) +
                       " changed the floating-point control word or rounding mode (built with -ffast-math?); it was "
                       "restored")
           .what());
}

const PluginFrame* current_plugin_frame() { return t_frame; }

uint64_t float_control_changes() { return g_float_changes; }

void disable_plugin_crash_report() {
  install_handlers();
  g_report = false;
  for (const int number : kSignals) signal(number, SIG_DFL);
}

}  // namespace triad
