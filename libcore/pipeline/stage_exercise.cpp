// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <triad/colour/colour.hpp>
#include <triad/pipeline/edge.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/stage_exercise.hpp>

namespace triad {
namespace {

// Signalling not-a-numbers: no computation on finite values gives them.
constexpr uint32_t kUnwritten = 0x7fa0dead, kCanary = 0x7fa0beef;
constexpr int kGuardRows = 2, kGuardFloats = 16;
constexpr unsigned char kStateCanary = 0xa5;
constexpr size_t kStateGuardBytes = 64;

struct Watched {
  std::atomic<uintptr_t> begin{0}, end{0}, limit{0};  // input pixels [begin, end), guard page [end, limit)
};
Watched g_watched[256];

// The pixels of an input strip: read-only, and ending where an inaccessible page begins.
class InputPixels {
 public:
  explicit InputPixels(size_t floats) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    body_ = (floats * sizeof(float) + page - 1) / page * page;
    total_ = body_ + page;
    void* memory = mmap(nullptr, total_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    base_ = static_cast<char*>(memory);
    data_ = reinterpret_cast<float*>(base_ + body_ - floats * sizeof(float));
  }
  ~InputPixels() {
    if (slot_) slot_->begin = 0;
    munmap(base_, total_);
  }
  InputPixels(const InputPixels&) = delete;
  InputPixels& operator=(const InputPixels&) = delete;

  float* data() { return data_; }
  void protect() {
    mprotect(base_, body_, PROT_READ);
    mprotect(base_ + body_, total_ - body_, PROT_NONE);
    for (Watched& slot : g_watched) {
      uintptr_t expected = 0;
      if (!slot.begin.compare_exchange_strong(expected, reinterpret_cast<uintptr_t>(base_))) continue;
      slot.end = reinterpret_cast<uintptr_t>(base_) + body_;
      slot.limit = reinterpret_cast<uintptr_t>(base_) + total_;
      slot_ = &slot;
      return;
    }
  }

 private:
  char* base_ = nullptr;
  float* data_ = nullptr;
  size_t body_ = 0, total_ = 0;
  Watched* slot_ = nullptr;
};

triad_strip make_strip(triad_rect r, int channels, float* data, size_t stride_floats) {
  return {sizeof(triad_strip), channels, r, data, static_cast<int64_t>(stride_floats * sizeof(float))};
}

std::unique_ptr<InputPixels> gather(const SyntheticPicture& picture, triad_rect r, int32_t edge, triad_strip& strip) {
  const int channels = picture.image.channels;
  const size_t stride = static_cast<size_t>(r.x1 - r.x0) * channels;
  auto pixels = std::make_unique<InputPixels>(stride * static_cast<size_t>(r.y1 - r.y0));
  float* to = pixels->data();
  for (int y = r.y0; y < r.y1; ++y) {
    const int64_t from_y = edge_index(edge, y, picture.image.height);
    for (int x = r.x0; x < r.x1; ++x, to += channels) {
      const int64_t from_x = edge_index(edge, x, picture.image.width);
      if (from_x < 0 || from_y < 0)
        std::fill_n(to, channels, 0.0f);
      else
        std::copy_n(picture.pixels.data() + (from_y * picture.image.width + from_x) * channels, channels, to);
    }
  }
  pixels->protect();
  strip = make_strip(r, channels, pixels->data(), stride);
  return pixels;
}

// Where the stage writes: each row with canaries behind it, and rows of canaries above and below.
class OutputPixels {
 public:
  OutputPixels(triad_rect r, int channels)
      : rect_(r),
        channels_(channels),
        row_(static_cast<size_t>(r.x1 - r.x0) * channels),
        stride_(row_ + kGuardFloats),
        rows_(static_cast<size_t>(r.y1 - r.y0)),
        pixels_((rows_ + 2 * kGuardRows) * stride_ + kGuardFloats, std::bit_cast<float>(kCanary)) {
    for (size_t y = 0; y < rows_; ++y) std::fill_n(row(y), row_, std::bit_cast<float>(kUnwritten));
  }
  triad_strip strip() { return make_strip(rect_, channels_, row(0), stride_); }

  void check_and_copy(const StageInfo& info, float* to) {
    size_t canaries = 0;
    for (size_t i = 0; i < pixels_.size(); ++i) canaries += !inside(i) && bits(pixels_[i]) != kCanary;
    if (canaries > 0)
      throw PluginError("pixels.writes-past-strip", info.id(), info.file,
                        "strip() wrote " + std::to_string(canaries) + " values outside " + text());
    for (size_t y = 0; y < rows_; ++y)
      for (size_t i = 0; i < row_; ++i)
        if (bits(row(y)[i]) == kUnwritten)
          throw PluginError("pixels.unwritten", info.id(), info.file,
                            "strip() left pixel " + std::to_string(rect_.x0 + static_cast<int>(i) / channels_) + "," +
                                std::to_string(rect_.y0 + static_cast<int>(y)) + " of " + text() + " unwritten");
    for (size_t y = 0; y < rows_; ++y, to += row_) std::memcpy(to, row(y), row_ * sizeof(float));
  }

 private:
  static uint32_t bits(float v) { return std::bit_cast<uint32_t>(v); }
  float* row(size_t y) { return pixels_.data() + kGuardFloats + (y + kGuardRows) * stride_; }
  bool inside(size_t i) const {
    const size_t first = kGuardFloats + kGuardRows * stride_;
    return i >= first && (i - first) / stride_ < rows_ && (i - first) % stride_ < row_;
  }
  std::string text() const {
    return "its strip of rows " + std::to_string(rect_.y0) + " to " + std::to_string(rect_.y1) + ", " +
           std::to_string(rect_.x1 - rect_.x0) + " pixels wide";
  }
  triad_rect rect_;
  int channels_;
  size_t row_, stride_, rows_;
  std::vector<float> pixels_;
};

// The accumulator, aligned as the host aligns it, with a canary behind it.
class StateBytes {
 public:
  explicit StateBytes(size_t bytes) : bytes_(bytes) {
    if (bytes_ == 0) return;
    const size_t total = (bytes_ + kStateGuardBytes + 63) / 64 * 64;
    memory_.reset(std::aligned_alloc(64, total));
    if (!memory_) throw std::bad_alloc();
    std::memset(memory_.get(), 0, bytes_);
    std::memset(static_cast<char*>(memory_.get()) + bytes_, kStateCanary, kStateGuardBytes);
  }
  void* get() { return memory_.get(); }
  void check(const StageInfo& info, const char* function) const {
    const auto* guard = static_cast<const unsigned char*>(memory_.get()) + bytes_;
    if (bytes_ > 0 && std::any_of(guard, guard + kStateGuardBytes, [](unsigned char c) { return c != kStateCanary; }))
      throw PluginError("state.writes-past-end", info.id(), info.file,
                        std::string(function) + " wrote past the " + std::to_string(bytes_) + " bytes of its state");
  }

 private:
  size_t bytes_;
  std::unique_ptr<void, decltype(&std::free)> memory_{nullptr, &std::free};
};

class Runner {
 public:
  Runner(const Exercise& exercise, const ExerciseOptions& options)
      : e_(exercise), options_(options), info_(exercise.stage->info()), image_(exercise.plan.out) {
    // A metric's strips are those of its first input.
    if (info_.is_metric()) {
      image_.width = e_.inputs[0]->image.width;
      image_.height = e_.inputs[0]->image.height;
    }
    has_out_ = e_.plan.out.channels > 0 && (!info_.is_metric() || options.want_map);
    const int rows = e_.plan.plan.strip_rows;
    if (rows > 0)
      for (int y = 0; y < image_.height; y += rows) borders_.push_back(y);
    else
      borders_ = rows == 0 && !options.borders.empty() ? options.borders : std::vector{0};
  }

  ExerciseOutcome run() {
    std::erase_if(borders_, [&](int y) { return y >= image_.height; });
    ExerciseOutcome outcome;
    const triad_plan& plan = e_.plan.plan;
    if (has_out_) outcome.pixels.resize(static_cast<size_t>(image_.width) * image_.height * e_.plan.out.channels);
    for (int pass = 0; pass < plan.passes; ++pass) {
      std::vector<std::unique_ptr<StateBytes>> states;
      for (size_t i = 0; i < borders_.size(); ++i) states.push_back(std::make_unique<StateBytes>(plan.state_bytes));
      strips(pass, states, outcome);
      StateBytes total(plan.state_bytes);
      for (const auto& state : states) {
        e_.stage->merge(pass, total.get(), state->get());
        total.check(info_, "merge()");
      }
      outcome.scores = e_.stage->end_pass(pass, total.get());
    }
    return outcome;
  }

 private:
  void strips(int pass, std::vector<std::unique_ptr<StateBytes>>& states, ExerciseOutcome& outcome) {
    const bool reentrant = e_.plan.plan.threads == TRIAD_REENTRANT;
    const size_t n = borders_.size();
    std::atomic<size_t> next{0};
    std::exception_ptr error;
    std::mutex mutex;
    const auto work = [&] {
      for (size_t k; (k = next++) < n;) {
        const size_t i = reentrant && options_.descending ? n - 1 - k : k;
        try {
          strip(pass, i, *states[i], outcome);
        } catch (...) {
          const std::lock_guard lock(mutex);
          if (!error) error = std::current_exception();
        }
      }
    };
    std::vector<std::thread> threads;
    for (int t = 1; reentrant && t < options_.threads; ++t) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    if (error) std::rethrow_exception(error);
  }

  void strip(int pass, size_t i, StateBytes& state, ExerciseOutcome& outcome) {
    const int y0 = borders_[i], y1 = i + 1 < borders_.size() ? borders_[i + 1] : image_.height;
    const triad_rect r{0, y0, image_.width, y1};
    const std::vector<triad_rect> needs = e_.stage->need(pass, r);
    std::vector<std::unique_ptr<InputPixels>> pixels;
    std::vector<triad_strip> strips(e_.inputs.size());
    std::vector<const triad_strip*> in(e_.inputs.size(), nullptr);
    for (size_t k = 0; k < e_.inputs.size(); ++k) {
      if (!e_.inputs[k]) continue;
      pixels.push_back(gather(*e_.inputs[k], needs[k], e_.plan.plan.edge, strips[k]));
      in[k] = &strips[k];
    }
    if (has_out_ && pass == e_.plan.plan.passes - 1) {
      const int channels = e_.plan.out.channels;
      OutputPixels out(r, channels);
      const triad_strip out_strip = out.strip();
      e_.stage->strip(pass, r, in, &out_strip, state.get());
      out.check_and_copy(info_, outcome.pixels.data() + static_cast<size_t>(y0) * image_.width * channels);
    } else {
      e_.stage->strip(pass, r, in, nullptr, state.get());
    }
    state.check(info_, "strip()");
  }

  const Exercise& e_;
  const ExerciseOptions& options_;
  const StageInfo& info_;
  triad_image image_;
  bool has_out_ = false;
  std::vector<int> borders_;
};

}  // namespace

SyntheticPicture synthetic_picture(int width, int height, int channels, Cells cells, uint32_t seed) {
  SyntheticPicture picture;
  picture.image = {sizeof(triad_image),
                   width,
                   height,
                   channels,
                   channels == 4 ? 3 : -1,
                   cells.x,
                   cells.y,
                   static_cast<double>(cells.y) / cells.x,
                   {},
                   0,
                   0,
                   0};
  std::copy(rec709_to_xyz().begin(), rec709_to_xyz().end(), picture.image.rgb_to_xyz);
  picture.pixels.resize(static_cast<size_t>(width) * height * channels);
  // xorshift32 (G. Marsaglia, J. Stat. Softw. 8 (2003) 14).
  uint32_t x = seed * 2654435761u + 1;
  for (float& value : picture.pixels) {
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    value = static_cast<float>(x >> 8) * 0x1p-24f;
  }
  return picture;
}

bool ExerciseOutcome::operator==(const ExerciseOutcome& o) const {
  return pixels.size() == o.pixels.size() && scores.size() == o.scores.size() &&
         std::equal(pixels.begin(), pixels.end(), o.pixels.begin(),
                    [](float a, float b) { return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b); }) &&
         std::equal(scores.begin(), scores.end(), o.scores.begin(),
                    [](double a, double b) { return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b); });
}

ExerciseOutcome run_exercise(const Exercise& exercise, const ExerciseOptions& options) {
  return Runner(exercise, options).run();
}

WatchedMemory watched_memory(const void* address) {
  const auto at = reinterpret_cast<uintptr_t>(address);
  for (const Watched& slot : g_watched) {
    const uintptr_t begin = slot.begin;
    if (begin == 0 || at < begin || at >= slot.limit) continue;
    return at < slot.end ? WatchedMemory::kInput : WatchedMemory::kBeyondInput;
  }
  return WatchedMemory::kNone;
}

}  // namespace triad
