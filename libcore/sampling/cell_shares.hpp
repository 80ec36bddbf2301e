// SPDX-License-Identifier: Apache-2.0
// Which cells of a display pixel the strata of its samples cover, along one side.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace triad {

// A side of length 1 cut once into `strata` and once into `cells` equal parts. Immutable and thread-safe.
class CellShares {
 public:
  struct Share {
    uint32_t cell = 0;
    double part = 0;  // of the stratum's length, above 0; the parts of a stratum sum to 1
  };

  CellShares(uint32_t strata, uint32_t cells) : strata_(strata) {
    first_.reserve(strata + size_t{1});
    for (uint64_t s = 0; s < strata; ++s) {
      first_.push_back(shares_.size());
      // In units of 1 / (strata * cells), so that nothing is rounded.
      const uint64_t low = s * cells, high = low + cells;
      for (uint64_t cell = low / strata; cell * strata < high; ++cell) {
        const uint64_t covered = std::min(high, (cell + 1) * strata) - std::max(low, cell * strata);
        shares_.push_back({static_cast<uint32_t>(cell), static_cast<double>(covered) / cells});
      }
    }
    first_.push_back(shares_.size());
  }

  // Of the stratum that holds `place`, in [0, 1); places outside count as the nearest inside.
  std::span<const Share> of(double place) const {
    const auto stratum = std::min(static_cast<uint32_t>(std::max(0., place) * strata_), strata_ - 1);
    return std::span(shares_).subspan(first_[stratum], first_[stratum + 1] - first_[stratum]);
  }

 private:
  uint32_t strata_;
  std::vector<size_t> first_;  // of each stratum's shares; one more at the end
  std::vector<Share> shares_;
};

}  // namespace triad
