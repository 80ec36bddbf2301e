// SPDX-License-Identifier: Apache-2.0
// Asks a source on behalf of one render, and keeps the books: what was taken, what was dropped, what each pass took
// in time, whether it is to be stopped.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <triad/sampling/strategy.hpp>

namespace triad {

// Whether it is valid, and its colour finite: if not, it is left out of all sums.
bool usable(const Sample& sample);

// ask(), take() and add() may be called from several threads, as said there; all else from the one that renders.
class SampleTaker {
 public:
  // All must outlive it. The film has the halves of samples (planes.error) wherever `strategy` estimates its error
  // and options ask for it in one way or another. Throws Error(kUsage) for options.until_rmse if it does not.
  SampleTaker(const Strategy& strategy, const Source& source, const RenderOptions& options)
      : SampleTaker(strategy, source, options, strategy.film_holds()) {}
  // For a strategy that gives a pixel as many samples as the options make of it.
  SampleTaker(const Strategy& strategy, const Source& source, const RenderOptions& options, Film::Holds holds);

  // Asks for all of them on all threads; samples[i] answers requests[i], and `valid` is false, too, where a colour is
  // not finite. Then each is added to the film's pixel (pixel_x, pixel_y), which must be inside, in their order. Not
  // for several threads at once. False: the render was stopped, and nothing of this is in the film.
  bool ask(std::span<const SampleRequest> requests, std::span<Sample> samples);
  // The same for a few hundred, on the calling thread. Several threads at once may take samples of different pixels.
  // For requests of pixels outside, and with `keep` false for all, nothing is added to the film, but they count.
  bool take(std::span<const SampleRequest> requests, std::span<Sample> samples, bool keep = true);

  // The same for samples inside the film that all are to be added, faster: what cannot be used is left out and
  // counted, and only the film knows. `rows` is Film::add()'s. `weigh` may change their colours before that.
  using Weigh = std::function<void(std::span<const SampleRequest>, std::span<Sample>)>;
  bool add(std::span<const SampleRequest> requests, std::span<Sample> samples, const FilmRows& rows = {},
           const Weigh& weigh = {});
  // Asks for them, and calls use() on the same thread, whose it is to add them to the film or to drop() them.
  template <class Use>
  bool ask_once(std::span<const SampleRequest> requests, std::span<Sample> samples, const Use& use) {
    if (stop()) return false;
    source_.eval(requests, samples);
    use();
    tell_progress();
    return true;
  }
  // Counts one of this pixel of the film as left out.
  void drop(int32_t pixel_x, int32_t pixel_y);

  // What was taken since the last one was a pass.
  PassRecord& end_pass();

  Film& film() { return result_.film; }
  const Film& film() const { return result_.film; }
  RenderResult& result() { return result_; }
  const RenderOptions& options() const { return options_; }
  uint64_t samples() const { return source_.samples(); }
  bool stopped() const { return stopped_; }
  // Asks options.stop.
  bool stop();
  // For progress: the samples that the whole render will take at most, if that is fewer than was said before.
  void expect(double samples);
  // The end: counts, the estimated error after the last pass, progress 1. Nothing may be called afterwards.
  RenderResult finish();

 private:
  void keep(std::span<const SampleRequest> requests, std::span<const Sample> samples, const FilmRows& rows);
  void drop(const SampleRequest& request) { drop(request.pixel_x, request.pixel_y); }
  void tell_progress();

  const CountingSource source_;
  const RenderOptions& options_;
  RenderResult result_;
  double expected_;  // samples, for progress; falls when it turns out that fewer will do
  std::chrono::steady_clock::time_point pass_start_;
  uint64_t pass_samples_ = 0;  // taken when it started
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;                 // guards what follows, result_.dropped, and calls of options_.progress
  size_t first_dropped_ = SIZE_MAX;  // pixel
};

}  // namespace triad
