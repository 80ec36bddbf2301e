// SPDX-License-Identifier: Apache-2.0
// Which instruction set hand-written loops use. All functions are thread-safe as long as nobody changes the
// environment at the same time.
#pragma once

namespace triad {

// From narrow to wide. kBaseline is whatever the library was compiled for and runs everywhere; kAvx2 means
// AVX2 with FMA, kAvx512 means AVX-512 F, BW, DQ and VL, and BMI2, on top of these.
enum class CpuPath { kBaseline, kAvx2, kAvx512 };

// "baseline", "avx2", "avx512".
const char* cpu_path_name(CpuPath path);

// Whether this processor and operating system can run that path.
bool cpu_can_run(CpuPath path);

// The widest path that this machine runs, or the one named by the environment variable TRIAD_CPU. Throws a
// usage error if TRIAD_CPU is not empty and names no path, or one that this machine lacks.
CpuPath default_cpu_path();

}  // namespace triad
