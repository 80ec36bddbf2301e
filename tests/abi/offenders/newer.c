/* SPDX-License-Identifier: Apache-2.0 */
/* A plugin as a later minor version's header would make it: every record has members that 1.0 does not know. */
#define triad_library_v1 triad_library_of_1_0
#include <triad/abi/triad_plugin.h>
#undef triad_library_v1

static int instance;
static triad_status create(const triad_host* host, triad_call* call, const triad_value* args, void** inst) {
  (void)host, (void)call, (void)args;
  *inst = &instance;
  return TRIAD_OK;
}
static void destroy(void* inst) { (void)inst; }
static triad_status plan(void* inst, triad_call* call, int32_t n, const triad_image* const* in, triad_image* out,
                         triad_plan* p) {
  (void)inst, (void)call, (void)n, (void)in, (void)out, (void)p;
  return TRIAD_OK;
}
static triad_status need(const void* inst, triad_call* call, int32_t pass, triad_rect out, triad_rect* in) {
  (void)inst, (void)call, (void)pass, (void)out, (void)in;
  return TRIAD_OK;
}
static triad_status strip(void* inst, triad_call* call, int32_t pass, triad_rect r, const triad_strip* const* in,
                          const triad_strip* out, void* state) {
  (void)inst, (void)call, (void)pass, (void)state, (void)in;
  for (int32_t y = 0; y < r.y1 - r.y0; ++y)
    for (int32_t i = 0; i < (r.x1 - r.x0) * out->channels; ++i)
      ((float*)((char*)out->data + y * out->row_bytes))[i] = 1;
  return TRIAD_OK;
}

static const struct {
  triad_stage old;
  void* extra[2];
} stage = {{sizeof stage, 0, create, destroy, plan, need, strip, 0, 0}, {0, 0}};
static const struct {
  triad_param old;
  double step;
} amount = {{sizeof amount, TRIAD_INT, "amount", "how much", 0, 1u << 20, 0, 0, 9, {TRIAD_INT, 1, {.i = 3}}, 0}, 1};
static const triad_param* const params[] = {&amount.old};
static const struct {
  triad_input old;
  void* extra;
} image = {{sizeof image, 0, "image", "the picture", "rgb", "linear"}, 0};
static const triad_input* const inputs[] = {&image.old};
static const struct {
  triad_desc old;
  void* extra[4];
} desc = {{sizeof desc, TRIAD_FILTER, "newer", "1.0", "White", "", 1, 1, 0, 0, params, inputs, 0, &stage.old}, {0}};
static const triad_desc* const descs[] = {&desc.old};
struct library {
  triad_library old;
  void* extra[3];
};
extern TRIAD_EXPORT const struct library triad_library_v1;
const struct library triad_library_v1 = {
    {TRIAD_ABI_MAGIC, TRIAD_ABI_MAJOR, 7, sizeof(struct library), "newer", "C", 1, 0, descs, 0}, {0}};
