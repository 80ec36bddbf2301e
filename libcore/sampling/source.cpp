// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/request_members.hpp>

namespace triad {

void say_all(std::span<SampleRequest> requests, size_t each) {
  if (each <= 1) return;
  for (size_t first = 0; first < requests.size(); first += each) {
    RequestMembers members = members_of(requests[first]);
    for (size_t i = first + 1; i < first + each; ++i) {
      members += kNextIndex;
      put_members(requests[i], members);
    }
  }
}

}  // namespace triad
