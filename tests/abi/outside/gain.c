/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <triad/abi/triad_plugin.h>

struct gain {
  float factor;
};

static triad_status create(const triad_host* host, triad_call* call, const triad_value* args, void** inst) {
  struct gain* g = malloc(sizeof *g);
  if (!g) return host->fail(call, TRIAD_E_MEMORY, "out of memory");
  g->factor = (float)args[0].u.f;
  *inst = g;
  return TRIAD_OK;
}

static void destroy(void* inst) { free(inst); }

static triad_status plan(void* inst, triad_call* call, int32_t n, const triad_image* const* in, triad_image* out,
                         triad_plan* p) {
  (void)inst, (void)call, (void)n, (void)in, (void)out;
  p->threads = TRIAD_REENTRANT;
  return TRIAD_OK;
}

static triad_status need(const void* inst, triad_call* call, int32_t pass, triad_rect out, triad_rect* in) {
  (void)inst, (void)call, (void)pass;
  in[0] = out;
  return TRIAD_OK;
}

static triad_status strip(void* inst, triad_call* call, int32_t pass, triad_rect r, const triad_strip* const* in,
                          const triad_strip* out, void* state) {
  (void)call, (void)pass, (void)state;
  const struct gain* g = inst;
  for (int32_t y = 0; y < r.y1 - r.y0; ++y) {
    const float* from = (const float*)((const char*)in[0]->data + y * in[0]->row_bytes);
    float* to = (float*)((char*)out->data + y * out->row_bytes);
    for (int32_t i = 0; i < (r.x1 - r.x0) * out->channels; ++i) to[i] = g->factor * from[i];
  }
  return TRIAD_OK;
}

static const triad_stage stage = {sizeof(triad_stage), 0, create, destroy, plan, need, strip, NULL, NULL};
static const triad_param factor = {
    sizeof(triad_param),        TRIAD_FLOAT, "factor", "what to multiply by", NULL, 0, 0, 0, HUGE_VAL,
    {TRIAD_FLOAT, 1, {.f = 2}}, NULL};
static const triad_param* const params[] = {&factor};
static const triad_input image = {sizeof(triad_input), 0, "image", "the picture", "rgb", "linear"};
static const triad_input* const inputs[] = {&image};
static const triad_desc desc = {sizeof(triad_desc),
                                TRIAD_FILTER,
                                "gain",
                                "1.0",
                                "Multiplies colour by a factor",
                                "",
                                1,
                                1,
                                0,
                                0,
                                params,
                                inputs,
                                NULL,
                                &stage};
static const triad_desc* const descs[] = {&desc};
const triad_library triad_library_v1 = {
    TRIAD_ABI_MAGIC, TRIAD_ABI_MAJOR, TRIAD_ABI_MINOR, sizeof(triad_library), "gain", "C", 1, 0, descs, NULL};
