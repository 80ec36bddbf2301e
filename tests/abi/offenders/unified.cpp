// SPDX-License-Identifier: Apache-2.0
// Two files are made of this one, with different ids. Without hidden visibility the records of `struct Plugin`
// become GNU_UNIQUE symbols, and the second file's table points into the first.
#include <triad/abi/triad_plugin.h>

inline int g_instance = 0;

struct Plugin {
  static triad_status create(const triad_host*, triad_call*, const triad_value*, void** inst) {
    *inst = &g_instance;
    return TRIAD_OK;
  }
  static void destroy(void*) {}
  static triad_status plan(void*, triad_call*, int32_t, const triad_image* const*, triad_image*, triad_plan*) {
    return TRIAD_OK;
  }
  static triad_status need(const void*, triad_call*, int32_t, triad_rect, triad_rect*) { return TRIAD_OK; }
  static triad_status strip(void*, triad_call*, int32_t, triad_rect, const triad_strip* const*, const triad_strip*,
                            void*) {
    return TRIAD_OK;
  }
  static inline const triad_stage stage{sizeof(triad_stage), 0, create, destroy, plan, need, strip, nullptr, nullptr};
  static inline const triad_input image{sizeof(triad_input), 0, "image", "the picture", "rgb", nullptr};
  static inline const triad_input* const inputs[] = {&image};
  static inline const triad_desc desc{
      sizeof(triad_desc), TRIAD_FILTER, STAGE_ID, "1.0", "Nothing", "", 0, 1, 0, 0, nullptr, inputs, nullptr, &stage};
  static inline const triad_desc* const descs[] = {&desc};
};

const triad_library triad_library_v1 = {
    TRIAD_ABI_MAGIC, TRIAD_ABI_MAJOR, TRIAD_ABI_MINOR, sizeof(triad_library), "unified", "C++", 1, 0,
    Plugin::descs,   nullptr};
