// SPDX-License-Identifier: Apache-2.0
// What strategies have in common that sum samples pixel by pixel, in passes over the picture or over some pixels.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/request_members.hpp>
#include <triad/sampling/sample_taker.hpp>
#include <variant>
#include <vector>

namespace triad {

// One render: asks the source in batches, sums the answers, keeps the record. Not for several threads at once.
class Passes {
 public:
  // Sets x and y of requests that share a seed: point number `index` of its pixel. Either they say all else, and
  // `each` is 0; or there are `each` of every pixel, one pixel after the other, and this does what say_all() does,
  // too. Pure, any thread.
  using Place = std::function<void(std::span<SampleRequest>, size_t each)>;
  // Or else where in every pixel its points are, by index, in [0, 1); with a single one, all of them are there.
  using Pattern = std::span<const std::array<double, 2>>;
  using Points = std::variant<Place, Pattern>;

  // `weigh`, if there is one, changes the colours of samples before they are summed; those of one pixel are given to
  // it in the order of their indices, by one thread at a time.
  // The film has halves wherever `strategy` estimates its error and options ask for it in one way or another. All
  // must outlive this. Throws Error(kUsage) for options.until_rmse if the strategy does not estimate its error.
  Passes(const Strategy& strategy, const Source& source, const RenderOptions& options, float footprint_px,
         Points points, SampleTaker::Weigh weigh = {});

  // Requests of one thread, asked whenever there are enough of them.
  class Queue {
   public:
    explicit Queue(Passes& passes);
    // The samples number first .. past - 1 of a pixel, which no other queue of this pass may be given. False: the
    // render was stopped, and what was not asked yet is lost.
    bool add(int x, int y, uint32_t first, uint32_t past) { return add_row(x, x + 1, y, first, past); }
    // The same of the pixels x0 .. x1 - 1 of a row, faster.
    bool add_row(int x0, int x1, int y, uint32_t first, uint32_t past);
    bool flush();

   private:
    void put(int x, int y, size_t n, uint32_t index, size_t each);
    TRIAD_INLINE_BODY void put_pattern(Pattern pattern, SampleRequest* requests, RequestMembers members, size_t n,
                                       size_t each);

    Passes& passes_;
    std::vector<SampleRequest> requests_;  // with the seed that they all share
    std::vector<Sample> samples_;
    size_t size_ = 0, each_ = 0;  // each_ of every pixel, said by the first; or 0, and all say all
    std::vector<FilmRow> rows_;   // of those pixels
  };

  // A pass: fill(group, queue) for each of the groups, in any order, on all threads. The picture depends on the
  // order in which one pixel's samples are added and on nothing else. False: there shall be no further pass, as the
  // render was stopped, or the error that was asked for is reached.
  // Where the film has halves, the error is estimated after each pass, or with estimate = false after the last only.
  bool run(int64_t groups, const std::function<void(int64_t, Queue&)>& fill, bool estimate = true);
  // Each pixel's samples first .. past - 1, in tiles.
  bool run_all(uint32_t first, uint32_t past, bool estimate = true);

  // What the first two passes of these come to; a pixel has its samples to there at once, or the first alone before.
  static constexpr uint32_t kSecondPass = 16;
  // What they need of a film.
  static constexpr Film::Holds film_holds(uint32_t spp) {
    return spp == 1 ? Film::Holds::kOneEach : spp <= kSecondPass ? Film::Holds::kFew : Film::Holds::kMany;
  }
  // All passes of spp samples in each pixel: to 1 of each, 16, 32, 64 and so on, so that there is soon something to
  // see, and no pass is so small that walking through the film costs more than its samples. While options.soon_s have
  // not gone by, a row of a tile takes its samples to 16 at once; if all do, that was the first pass.
  void run_all_in_turn(uint32_t spp);

  const Film& film() const { return taker_.film(); }
  uint64_t samples() const { return taker_.samples(); }
  // As SampleTaker's.
  void expect(double samples) { taker_.expect(samples); }
  // The end; nothing may be called afterwards.
  RenderResult finish() { return taker_.finish(); }

 private:
  class QueueInUse;
  struct Tiles;

  SampleTaker taker_;
  const float footprint_px_;
  const Points points_;
  const SampleTaker::Weigh weigh_;
  std::mutex mutex_;  // of what follows
  std::vector<std::unique_ptr<Queue>> idle_;
};

}  // namespace triad
