// SPDX-License-Identifier: Apache-2.0
// One stage in its place in a chain: what it is given, what comes out, and how its strips are run.
#pragma once

#include <triad/colour/colour.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/strip_buffer.hpp>

namespace triad {

// A stage's accumulator: zeroed, 64-byte aligned as plugins may expect of the host's memory.
class StageState {
 public:
  explicit StageState(uint64_t bytes = 0) : blocks_((bytes + sizeof(Block) - 1) / sizeof(Block)) {}
  void* data() { return blocks_.empty() ? nullptr : blocks_.data(); }
  const void* data() const { return blocks_.empty() ? nullptr : blocks_.data(); }

 private:
  struct alignas(64) Block {
    std::byte bytes[64]{};
  };
  std::vector<Block> blocks_;
};

// How one input of a stage is made from a picture.
struct InputBinding {
  bool rgb = false;           // three colour channels; else all channels as they are
  int channels = 0;           // that the stage sees
  ColourTransform transform;  // applied first, unless it is the identity
  std::string space;          // what the values are then
};

// `space`: a space of the configuration to use instead of what the input declares; "" none. Throws
// Error(kInput) naming `who` if the picture has no colour and the stage needs it.
InputBinding bind_input(const triad_input& input, const ImageSpec& picture, const ColourConfig& config,
                        const std::string& who, const std::string& space = "");

// What the ABI says about a picture as this binding shows it.
triad_image describe_picture(const ImageSpec& picture, const InputBinding& binding, const ColourConfig& config);

// The rows of `in` as the binding wants them. The result shares the memory of `in` when nothing changes, and
// is made in place when `in` is not shared and has the right channels already.
StripBuffer prepare_input(BufferPool& pool, const StripBuffer& in, bool may_modify, const ImageSpec& picture,
                          const InputBinding& binding);
// Bytes that prepare_input allocates.
uint64_t prepare_bytes(RowRange rows, const Pads& pads, bool may_modify, const ImageSpec& picture,
                       const InputBinding& binding);

// Colour-converts rows in place: three colour channels, or grey taken as three equal ones.
void convert_rows(const StripBuffer& buffer, RowRange rows, const ImageSpec& picture,
                  const ColourTransform& transform);

// What one strip of a stage's output requires.
struct StripNeeds {
  struct Call {
    RowRange out;
    triad_rect need;
  };
  RowRange out;             // rows that will be computed: those asked for, widened to whole strips
  std::vector<Call> calls;  // of the stage's strip(), ascending
  RowRange in;              // rows of the input
  Pads pads;                // what the calls overhang it by
};

// A filter between two pictures. Channels that the stage does not read pass it by: alpha is averaged over the
// block of input pixels that an output pixel stands for, others need an unchanged size.
class FilterNode {
 public:
  // Warns about channels that are dropped. Throws Error.
  FilterNode(StageInstance instance, const ImageSpec& in, const ColourConfig& config);

  const ImageSpec& in() const { return in_; }
  const ImageSpec& out() const { return out_; }
  const triad_plan& plan() const { return plan_.plan; }
  StageInstance& instance() { return instance_; }
  const StageInstance& instance() const { return instance_; }
  const InputBinding& binding() const { return binding_; }

  StripNeeds needs(int pass, RowRange out) const;
  // The strips of `needs` in the last pass. `in` has the rows and pads that needs() asked for; the result
  // has needs.out and `out_pads`. Values that are not finite are replaced where the plan says so, and those
  // in rows from `fresh_y` on (which no earlier strip saw) are counted. `may_modify`: nobody reads `in` after.
  // Rows of the result from `fresh_out_y` on leave their states in `states`, one for each call, in order; rows that
  // an earlier strip made already are made again without a trace.
  StripBuffer run(BufferPool& pool, const StripBuffer& in, const StripNeeds& needs, const Pads& out_pads, int fresh_y,
                  int fresh_out_y, bool may_modify, NonFinite& replaced, std::vector<StageState>& states);
  // The same for an earlier pass, which writes state only: one state for each call, in order.
  void run_pass(BufferPool& pool, int pass, const StripBuffer& in, const StripNeeds& needs, bool may_modify,
                std::vector<StageState>& states);
  // Bytes allocated by run() on top of its input and its result.
  uint64_t run_bytes(const StripNeeds& needs, bool may_modify) const;

 private:
  StripBuffer view_of(BufferPool& pool, const StripBuffer& in, const StripNeeds& needs, bool may_modify) const;
  void pass_by(const StripBuffer& in, const StripBuffer& made, const StripBuffer& out, RowRange rows) const;

  StageInstance instance_;
  ImageSpec in_, out_;
  InputBinding binding_;
  StageInstance::Plan plan_;
  std::vector<int> bypass_;  // channels of in_ that pass by, in their order
  int scale_x_ = 1, scale_y_ = 1;
};

}  // namespace triad
