// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <string>
#include <triad/base/error.hpp>
#include <triad/numeric/cpu.hpp>

namespace triad {
namespace {
constexpr CpuPath kWidestFirst[] = {CpuPath::kAvx512, CpuPath::kAvx2, CpuPath::kBaseline};
}  // namespace

const char* cpu_path_name(CpuPath path) {
  switch (path) {
    case CpuPath::kBaseline: return "baseline";
    case CpuPath::kAvx2: return "avx2";
    case CpuPath::kAvx512: return "avx512";
  }
  return "unknown";
}

bool cpu_can_run(CpuPath path) {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  switch (path) {
    case CpuPath::kBaseline: return true;
    case CpuPath::kAvx2: return avx2;
    case CpuPath::kAvx512:
      return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("bmi2");
  }
  return false;
#else
  return path == CpuPath::kBaseline;
#endif
}

CpuPath default_cpu_path() {
  const char* variable = std::getenv("TRIAD_CPU");
  const std::string wanted = variable ? variable : "";
  std::string choices;
  for (const CpuPath path : kWidestFirst) {
    if (!cpu_can_run(path)) continue;
    if (wanted.empty() || wanted == cpu_path_name(path)) return path;
    choices += (choices.empty() ? "" : ", ") + std::string(cpu_path_name(path));
  }
  throw_usage("TRIAD_CPU=" + wanted + " is not something this machine runs; use one of " + choices);
}

}  // namespace triad
