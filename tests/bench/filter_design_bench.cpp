// SPDX-License-Identifier: Apache-2.0
// Design of the display filter: how its time grows with the width, and against the dense system that it replaces.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <triad/display/filter_design.hpp>
#include <triad/display/row_filter.hpp>
#include <vector>

namespace {

triad::Observer observer() {
  triad::Observer out;
  out.rgb_to_xyz = {.4124, .3576, .1805, .2126, .7152, .0722, .0193, .1192, .9505};  // IEC 61966-2-1
  return out;
}

const triad::Layout& layout() {
  static const triad::Layout out = triad::load_layout(TRIAD_SOURCE_DIR "/data/layouts/rgb.toml");
  return out;
}

// The drives of a ring of pixels by the normal equations of all of them at once: sums over cells of the light of
// each pair of emitters, and a Cholesky factorisation.
std::vector<double> dense(const std::vector<double>& cells, double lambda) {
  const int N = static_cast<int>(cells.size()) / 3;
  const auto eye = observer();
  const auto C = triad::opponent_matrix(eye);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(N, N);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(N);
  std::vector<double> cosine(static_cast<size_t>(N)), w(static_cast<size_t>(N)), target(static_cast<size_t>(N));
  for (int k = 0; k < N; ++k) cosine[k] = std::cos(2 * M_PI * k / N);
  for (int c = 0; c < 3; ++c) {
    std::fill(w.begin(), w.end(), 0.0);
    for (int n = 0; n < N; ++n) {
      const double transfer = triad::mtf(eye, c, static_cast<double>(std::min(n, N - n)) / N * 3 * eye.ppd);
      for (int k = 0; k < N; ++k) w[k] += transfer * transfer / N * cosine[static_cast<size_t>(1LL * k * n % N)];
    }
    for (int k = 0; k < N; ++k) {
      target[k] = 0;
      for (int d = 0; d < 3; ++d) target[k] += C[3 * c + d] * cells[3 * static_cast<size_t>(k) + d];
    }
    for (int i = 0; i < N; ++i)
      for (int k = 0; k < N; ++k) {
        const double light = 3 * C[3 * c + i % 3] * w[static_cast<size_t>((i - k + N) % N)];
        A(k, i) += light * 3 * C[3 * c + k % 3];
        b[i] += light * target[k];
      }
  }
  for (int i = 0; i < N; ++i) {
    double norm2 = 0, box = 0;
    for (int c = 0; c < 3; ++c) norm2 += C[3 * c + i % 3] * C[3 * c + i % 3];
    for (int k = -1; k <= 1; ++k) box += cells[3 * static_cast<size_t>((i + k + N) % N) + i % 3] / 3;
    A(i, i) += lambda * lambda * 9 * norm2;
    b[i] += lambda * lambda * 9 * norm2 * box;
  }
  const Eigen::VectorXd x = A.llt().solve(b);
  return {x.data(), x.data() + N};
}

std::vector<double> some_cells(int width_px) {
  std::vector<double> cells(static_cast<size_t>(width_px) * 9);
  for (size_t i = 0; i < cells.size(); ++i) cells[i] = .5 + .5 * std::sin(.37 * static_cast<double>(i * i % 1009));
  return cells;
}

void design(benchmark::State& state) {
  for (auto _ : state) {
    const triad::FilterDesign filter(layout(), observer(), static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(filter.condition());
  }
}
BENCHMARK(design)->Arg(400)->Arg(800)->Arg(3840)->Arg(7680)->Unit(benchmark::kMillisecond);

void solve_dense(benchmark::State& state) {
  const auto cells = some_cells(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(dense(cells, .01));
}
BENCHMARK(solve_dense)->Arg(400)->Unit(benchmark::kMillisecond)->Iterations(3);

template <class Real>
void filter_row(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  const triad::RowFilter<Real> filter(triad::FilterDesign(layout(), observer(), 2 * width), width,
                                      triad::Edge::kMirror);
  typename triad::RowFilter<Real>::Workspace workspace(filter);
  const auto cells = some_cells(width);
  const std::vector<float> in(cells.begin(), cells.end());
  std::vector<float> out(static_cast<size_t>(width) * 3);
  for (auto _ : state) filter.apply(in.data(), out.data(), workspace);
}
BENCHMARK(filter_row<float>)->Arg(400)->Arg(3840)->Unit(benchmark::kMicrosecond);
BENCHMARK(filter_row<double>)->Arg(400)->Arg(3840)->Unit(benchmark::kMicrosecond);

// Both give the same drives, or their times say nothing.
bool answers_agree() {
  const int width = 400;
  const auto cells = some_cells(width);
  const triad::FilterDesign filter_design(layout(), observer(), width, {.exact_flat_fields = false});
  const triad::RowFilter<double> filter(filter_design, width, triad::Edge::kWrap);
  triad::RowFilter<double>::Workspace workspace(filter);
  std::vector<double> drives(static_cast<size_t>(width) * 3);
  filter.apply(cells.data(), drives.data(), workspace);
  const auto expected = dense(cells, .01);
  double worst = 0;
  for (size_t i = 0; i < drives.size(); ++i) worst = std::max(worst, std::abs(drives[i] - expected[i]));
  std::printf("largest difference to the dense system at %d px: %.1e\n", width, worst);
  return worst < 1e-9;
}

template <class F>
double fastest_s(int runs, F&& body) {
  double best = HUGE_VAL;
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    body();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  if (!answers_agree()) return 1;
  const auto time_of = [](int tiles) {
    return fastest_s(20, [&] {
      const triad::FilterDesign filter(layout(), observer(), tiles);
      benchmark::DoNotOptimize(filter.condition());
    });
  };
  const double small = time_of(400), large = time_of(3840);
  const auto cells = some_cells(400);
  const double dense_time = fastest_s(3, [&] { benchmark::DoNotOptimize(dense(cells, .01)); });
  std::printf("design at 3840 px / at 400 px: %.2f (at most 12)\n", large / small);
  std::printf("dense system / design, at 400 px: %.0f (at least 100)\n", dense_time / small);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return large <= 12 * small && dense_time >= 100 * small ? 0 : 1;
}
