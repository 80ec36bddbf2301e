/* SPDX-License-Identifier: Apache-2.0 */
/* A filter that copies its input, correct in every way; each definition spoils one thing in its records. */
#include <math.h>
#include <string.h>
#include <triad/abi/triad_plugin.h>

#ifndef STAGE_ID
#define STAGE_ID "victim"
#endif

/* Some definitions leave a function or a record without use. */
#define UNUSED __attribute__((unused))

static int instance;

static triad_status create(const triad_host* host, triad_call* call, const triad_value* args, void** inst) {
  (void)host, (void)call, (void)args;
  *inst = &instance;
  return TRIAD_OK;
}
UNUSED static void destroy(void* inst) { (void)inst; }
UNUSED static triad_status plan(void* inst, triad_call* call, int32_t n, const triad_image* const* in,
                                triad_image* out, triad_plan* p) {
  (void)inst, (void)call, (void)n, (void)in, (void)out;
  p->threads = TRIAD_REENTRANT;
  return TRIAD_OK;
}
static triad_status need(const void* inst, triad_call* call, int32_t pass, triad_rect out, triad_rect* in) {
  (void)inst, (void)call, (void)pass, (void)out, (void)in;
  return TRIAD_OK;
}
static triad_status strip(void* inst, triad_call* call, int32_t pass, triad_rect r, const triad_strip* const* in,
                          const triad_strip* out, void* state) {
  (void)inst, (void)call, (void)pass, (void)state;
  const size_t bytes = sizeof(float) * (size_t)(r.x1 - r.x0) * (size_t)out->channels;
  for (int32_t y = 0; y < r.y1 - r.y0; ++y)
    memcpy((char*)out->data + y * out->row_bytes, (const char*)in[0]->data + y * in[0]->row_bytes, bytes);
  return TRIAD_OK;
}

#ifdef CODE_OUTSIDE
extern void free(void*);
#define DESTROY free
#else
#define DESTROY destroy
#endif
#ifdef NULL_FUNCTION
#define PLAN NULL
#else
#define PLAN plan
#endif
static const triad_stage stage = {sizeof(triad_stage), 0, create, DESTROY, PLAN, need, strip, NULL, NULL};

#ifdef BAD_UTF8
#define DOC "gr\xfcn"
#else
#define DOC "how much"
#endif
#ifdef NAN_RANGE
#define MIN NAN
#else
#define MIN 0
#endif
#ifdef BAD_DEFAULT
#define DEF 7
#else
#define DEF .5
#endif
#ifdef BAD_TYPE
#define TYPE 99
#else
#define TYPE TRIAD_FLOAT
#endif
#ifdef BAD_NAME
#define NAME "Amount!"
#else
#define NAME "amount"
#endif
#ifdef SMALL_PARAM
#define PARAM_SIZE 16
#else
#define PARAM_SIZE sizeof(triad_param)
#endif
static const triad_param amount = {PARAM_SIZE, TYPE, NAME, DOC, NULL, 0, 0, MIN, 1, {TRIAD_FLOAT, 1, {.f = DEF}},
                                   NULL};

UNUSED static const char* const names[] = {"fast", "slow", NULL};
#ifdef NULL_CHOICES
#define CHOICES NULL
#else
#define CHOICES names
#endif
static const triad_param mode = {sizeof(triad_param),         TRIAD_CHOICE, "mode", "which way", NULL, 0, 0, 0, 0,
                                 {TRIAD_CHOICE, 1, {.i = 0}}, CHOICES};
static const triad_param* const params[] = {&amount, &mode};

#ifdef BAD_CHANNELS
#define CHANNELS "cmyk"
#else
#define CHANNELS "*"
#endif
static const triad_input image = {sizeof(triad_input), 0, "image", "the picture", CHANNELS, NULL};
static const triad_input* const inputs[] = {&image};

#ifdef FILTER_SCORES
#define N_SCORES 3
#else
#define N_SCORES 0
#endif
#ifdef HUGE_PARAMS
#define N_PARAMS 4000000000u
#else
#define N_PARAMS 2
#endif
#ifdef BAD_KIND
#define KIND 5
#else
#define KIND TRIAD_FILTER
#endif
#define DESC(id) \
  { sizeof(triad_desc), KIND, id, "1.0", "Copies", "", N_PARAMS, 1, N_SCORES, 0, params, inputs, NULL, &stage }
UNUSED static const triad_desc desc = DESC(STAGE_ID);
#ifdef DUPLICATE_ID
static const triad_desc twin = DESC(STAGE_ID);
#endif

#ifdef DESC_OUTSIDE
extern char** environ; /* the address of the C library's variable: not in this file */
static const triad_desc* const descs[] = {(const triad_desc*)&environ};
#elif defined(NULL_DESC)
static const triad_desc* const descs[] = {NULL};
#elif defined(DUPLICATE_ID)
static const triad_desc* const descs[] = {&desc, &twin};
#else
static const triad_desc* const descs[] = {&desc};
#endif

#ifdef BAD_MAGIC
#define MAGIC 0xdeadbeefu
#else
#define MAGIC TRIAD_ABI_MAGIC
#endif
#ifdef BAD_MAJOR
#define MAJOR 2u
#else
#define MAJOR TRIAD_ABI_MAJOR
#endif
#ifdef SMALL_LIBRARY
#define LIBRARY_SIZE 48
#elif defined(LARGE_LIBRARY)
#define LIBRARY_SIZE 4096
#else
#define LIBRARY_SIZE sizeof(triad_library)
#endif
#ifdef ZERO_DESCS
#define N_DESCS 0
#elif defined(HUGE_DESCS)
#define N_DESCS 1000000
#else
#define N_DESCS (sizeof descs / sizeof *descs)
#endif
#ifdef NULL_DESCS
#define DESCS NULL
#else
#define DESCS descs
#endif
const triad_library triad_library_v1 = {MAGIC,   MAJOR, TRIAD_ABI_MINOR, LIBRARY_SIZE, "offender", "C",
                                        N_DESCS, 0,     DESCS,           NULL};
