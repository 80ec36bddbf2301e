// SPDX-License-Identifier: Apache-2.0
// What a request says besides its place, as one vector: it is stored for every sample of a render.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <triad/sampling/source.hpp>
#include <type_traits>

namespace triad {

// footprint_px, its bits; pixel_x; pixel_y; index.
typedef int32_t RequestMembers __attribute__((vector_size(16)));
static_assert(offsetof(SampleRequest, footprint_px) + sizeof(RequestMembers) == offsetof(SampleRequest, seed));
static_assert(offsetof(SampleRequest, pixel_x) == offsetof(SampleRequest, footprint_px) + 4);
static_assert(offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, footprint_px) + 8);
static_assert(std::is_trivially_copyable_v<SampleRequest>);

constexpr RequestMembers kNextPixel{0, 1, 0, 0}, kNextIndex{0, 0, 0, 1};

inline RequestMembers request_members(float footprint_px, int32_t pixel_x, int32_t pixel_y, uint32_t index) {
  return RequestMembers{std::bit_cast<int32_t>(footprint_px), pixel_x, pixel_y, static_cast<int32_t>(index)};
}
inline RequestMembers members_of(const SampleRequest& request) {
  RequestMembers members;
  std::memcpy(&members, &request.footprint_px, sizeof(members));
  return members;
}
inline void put_members(SampleRequest& request, const RequestMembers& members) {
  std::memcpy(static_cast<void*>(&request.footprint_px), &members, sizeof(members));
}

}  // namespace triad
