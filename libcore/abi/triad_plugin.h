/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The contract between a Triad plugin and the program that hosts it, version 1.
 *
 * A plugin is a shared object named `<id>.triad.so` that exports one symbol, the constant
 * `triad_library_v1`. It describes one or more STAGES: a stage takes pictures and gives a picture
 * (a filter), scores (a metric), or both (a metric with an error map).
 *
 * How a stage is used, in this order:
 *
 *   create    once: check what cannot be said in the parameter table, allocate an instance
 *   plan      once: the shapes of the inputs are known; give the shape of the output
 *   need      many times, before a pixel is read: which input rows and columns a piece of the output
 *             requires. The host learns the peak memory from it.
 *   strip     per pass, once for each strip of the output: the work
 *   merge     per pass, metrics and multi-pass filters: fold a strip's state into the running one
 *   end_pass  per pass: all strips are merged
 *   destroy   once, if create returned TRIAD_OK with an instance; also after errors
 *
 * Threads: create, plan and destroy are called by one thread at a time in the whole process. `need`
 * and `merge` may be called on any thread, `need` on several at once. `strip` is called on one thread
 * at a time with ascending y, unless the plan says TRIAD_REENTRANT: then on many at once, in any order.
 * The result must not depend on how the picture was cut into strips.
 *
 * Memory: whatever the host passes is the host's and valid until the function returns. Whatever an
 * instance allocates, `destroy` frees. Constant data (descriptors) lives as long as the process:
 * plugins are never unloaded.
 *
 * Errors: return `host->fail(call, status, "what was wrong and what would be right")`. Nothing may be
 * thrown across this boundary, and a plugin does not print, exit or change the locale, the floating
 * point control word or the signal handlers.
 *
 * Growth: records only grow at their end, within a major version. `struct_size` says how much of a
 * record its maker knew; ask TRIAD_HAS before reading a member newer than 1.0. Pass `sizeof` of your
 * own header's record as your struct_size, and never compare somebody else's with `sizeof`: use the
 * TRIAD_SIZE_1_0 constants of this header, which are frozen.
 */
#ifndef TRIAD_PLUGIN_H
#define TRIAD_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TRIAD_ABI_MAGIC 0x31444954u /* "TID1" read as little-endian bytes */
#define TRIAD_ABI_MAJOR 1u          /* repeated in the exported symbol's name */
#define TRIAD_ABI_MINOR 2u

/* Whether the maker of the record *p knew its member f. */
#define TRIAD_HAS(p, T, f) ((p)->struct_size >= offsetof(T, f) + sizeof((p)->f))

#if defined(__GNUC__)
#define TRIAD_EXPORT __attribute__((visibility("default")))
#else
#define TRIAD_EXPORT
#endif

typedef int32_t triad_status; /* int32_t throughout: the width of a C enum is not ABI */
enum {
  TRIAD_OK = 0,
  TRIAD_E_PARAM = 1,       /* a parameter's value cannot be used */
  TRIAD_E_INPUT = 2,       /* an input picture cannot be used */
  TRIAD_E_MEMORY = 3,      /* an allocation failed */
  TRIAD_E_UNSUPPORTED = 4, /* a combination that this plugin does not do */
  TRIAD_E_INTERNAL = 5,    /* a defect of the plugin */
  TRIAD_CANCELLED = 6      /* progress() asked to stop */
};
enum { TRIAD_FILTER = 1, TRIAD_METRIC = 2 };
enum {
  TRIAD_BOOL = 1, /* u.i, 0 or 1 */
  TRIAD_INT,      /* u.i */
  TRIAD_FLOAT,    /* u.f */
  TRIAD_STRING,   /* u.s, UTF-8 */
  TRIAD_CHOICE,   /* u.i, the index into `choices`; u.s its text */
  TRIAD_PATH,     /* u.s, UTF-8 */
  TRIAD_FLOATS    /* u.v, `count` doubles */
};
enum { TRIAD_SERIAL = 0, TRIAD_REENTRANT = 1 };
/* How the host fills what a need overhangs the picture. MIRROR repeats the border sample: c b a | a b c */
enum { TRIAD_EDGE_CLAMP = 0, TRIAD_EDGE_MIRROR = 1, TRIAD_EDGE_WRAP = 2, TRIAD_EDGE_ZERO = 3 };
enum { TRIAD_LOG_DEBUG = 0, TRIAD_LOG_INFO = 1, TRIAD_LOG_WARNING = 2 };

typedef struct triad_call triad_call; /* the host's, opaque, one per call; never keep it */

/* What the host does for a plugin. Usable on any thread on which the host called the plugin. */
typedef struct triad_host {
  uint32_t struct_size, abi_minor;
  const char* version; /* of the host program, for the log */
  void (*log)(triad_call*, int32_t level, const char* utf8);
  /* Keeps the message for the user and returns its second argument. */
  triad_status (*fail)(triad_call*, triad_status, const char* utf8);
  /* done is in [0, 1] within this call. Nonzero: stop, return TRIAD_CANCELLED. */
  int32_t (*progress)(triad_call*, double done);
  /* 64-byte aligned, uninitialised, freed by the host when the call returns. NULL when out of budget. */
  void* (*scratch)(triad_call*, size_t bytes);
  /* Runs body(ctx, call of that thread, i) for i in [0, n) on the host's threads; the first failure ends it. */
  triad_status (*parallel_for)(triad_call*, int64_t n, triad_status (*body)(void* ctx, triad_call*, int64_t i),
                               void* ctx);
  /* A metadata value of an input as text, or NULL. Valid until the call returns. In plan only. */
  const char* (*get_meta)(triad_call*, int32_t input, const char* key);
  /* Sets metadata of the output. In plan only: headers precede pixels. value NULL removes the key. */
  triad_status (*set_meta)(triad_call*, const char* key, const char* value);
  /* A number for the log and the JSON results, e.g. a condition number. In plan and end_pass. */
  void (*report)(triad_call*, const char* key, double value);
  /* A curve for the JSON results, e.g. a histogram or a spectrum. In plan and end_pass. */
  void (*series)(triad_call*, const char* name, int64_t n, const double* x, const double* y);
  const void* (*extension)(const char* id);
} triad_host;

typedef struct {
  int32_t x0, y0, x1, y1; /* half open */
} triad_rect;             /* frozen */

typedef struct {
  int32_t type, count; /* count: values in u.v, else 1 */
  union {
    int64_t i;
    double f;
    const char* s;
    const double* v;
  } u;
} triad_value; /* frozen */

enum { TRIAD_PARAM_REQUIRED = 1, TRIAD_PARAM_MIN_EXCLUDED = 2, TRIAD_PARAM_MAX_EXCLUDED = 4 };
typedef struct {
  uint32_t struct_size;
  int32_t type;
  const char* name;           /* [a-z][a-z0-9-]{0,31} */
  const char* doc;            /* one sentence */
  const char* unit;           /* "px", "ppd", ...; NULL none */
  uint32_t flags;             /* TRIAD_PARAM_... */
  uint32_t max_count;         /* FLOATS: the longest list; else 0 */
  double min, max;            /* INT, FLOAT and each of FLOATS; -HUGE_VAL and HUGE_VAL for none; never NaN.
                                 Values themselves are always finite */
  triad_value def;            /* must itself validate, unless the parameter is required */
  const char* const* choices; /* CHOICE: stable names, NULL-terminated; else NULL */
} triad_param;

enum { TRIAD_INPUT_OPTIONAL = 1 };
typedef struct {
  uint32_t struct_size, flags;
  const char* name; /* "image" (a filter's first); "test", "reference", "mask", "variance" (a metric's) */
  const char* doc;
  /* Which channels the stage reads, in this order:
   *   "rgb"   three colour channels (a grey picture is spread over them); alpha and others pass it by
   *   "*"     whatever there is, as it is
   *   "mask"  one weight in [0, 1] per pixel of the first input: 0 where --crop, --mask or --nan leave a
   *           pixel out of the pooling. NULL when every weight is 1. Only as an optional input.
   *   "variance.*"  since 1.2, a metric's third picture: the channels variance.R, variance.G and variance.B of the
   *           test picture's file, never converted. Missing ones are an error, unless the input is optional. */
  const char* channels;
  /* NULL as it is (a metric: both pictures in the space the user chose, linear light by default); "linear" light with
   * the picture's own primaries; "linear-rec709"; "display": sRGB code values in [0, 1]. Since 1.2, for a metric:
   * "display-or-linear": "display" where both test and reference are stored as display codes (PNG, JPEG), else
   * "linear-rec709"; triad_image.display_codes tells which. The host converts first, and not at all where nothing
   * changes. */
  const char* space;
} triad_input;

typedef struct {
  uint32_t struct_size;
  int32_t width, height, channels;
  int32_t alpha;            /* index of the alpha channel, or -1 */
  int32_t cells_x, cells_y; /* fine cells per display pixel: 1,1 a standard picture; 3,1 a wide one for RGB stripes */
  double pixel_aspect;      /* width of a pixel over its height */
  double rgb_to_xyz[9];     /* of the linear space, row-major, CIE 1931 2 degrees, white at Y = 1 */
  double white_nits;        /* luminance of (1,1,1), or 0 when unknown */
  /* Since 1.2. 1: the values that the stage sees are display codes (a space that is not linear), 0: linear light, or
   * no colour at all. */
  int32_t display_codes, reserved;
} triad_image;

typedef struct {
  uint32_t struct_size;
  int32_t channels;
  triad_rect r;      /* what data covers; an input's may overhang the picture, as need() asked */
  float* data;       /* pixel (r.x0, r.y0), channel 0; interleaved, top row first. Inputs are read-only */
  int64_t row_bytes; /* from a row to the next */
} triad_strip;

enum { TRIAD_NONFINITE_KEEP = 0, TRIAD_NONFINITE_ZERO = 1 };
typedef struct {
  uint32_t struct_size;
  int32_t threads;    /* TRIAD_SERIAL or TRIAD_REENTRANT */
  int32_t edge;       /* TRIAD_EDGE_... */
  int32_t passes;     /* at least 1; a filter writes its picture in the last */
  int32_t strip_rows; /* output rows per strip: 0 any, n exactly n (the last may be shorter), -1 the whole
                         picture in one call. For a metric 0 means a fixed height that the host chooses, the
                         same whatever the threads: scores stay bitwise reproducible */
  /* ZERO: a not-a-number or an infinity would spread over a whole row or picture here; the host replaces
   * such input values by 0, counts them and warns. KEEP: they reach only the pixels within need(). */
  int32_t nonfinite;
  uint64_t state_bytes; /* an accumulator of the host's, zeroed for each strip; 0 none */
  /* Since 1.1. What one call of strip allocates beside its pictures, scratch included, and what the instance keeps
   * from plan on; 0 where that is little. The host adds it to the memory it plans with, and refuses the run where
   * --max-memory is below. */
  uint64_t work_bytes;
  /* Since 1.2, a metric's. Where the host pools the map into percentiles, a histogram, minimum and maximum: pixels of
   * the map outside are not judged (the border of a window, say). Comes filled with the whole picture; an empty one
   * means that the map holds no errors, and is not pooled. */
  triad_rect pool;
} triad_plan;

typedef struct {
  uint32_t struct_size, reserved;
  /* args: one value per parameter, in the table's order, checked against type, range and choices. */
  triad_status (*create)(const triad_host*, triad_call*, const triad_value* args, void** inst);
  void (*destroy)(void* inst);
  /* in: one per input, NULL where an optional one is absent. `out` comes filled as a copy of in[0] (for a
   * metric: with its channels set to 0, which means no map; set channels to 1 or 3 to offer one). `plan`
   * comes filled with SERIAL, CLAMP, 1 pass, 0 rows, KEEP, 0 bytes. */
  triad_status (*plan)(void* inst, triad_call*, int32_t n_in, const triad_image* const* in, triad_image* out,
                       triad_plan* plan);
  /* in[n_in]: what the strip `out` requires of each input; comes filled with `out` itself. Must be a pure
   * function, monotone in y: a strip further down never needs rows further up. One that is not gets the
   * whole input. A metric's `out` is a strip of its first input. */
  triad_status (*need)(const void* inst, triad_call*, int32_t pass, triad_rect out, triad_rect* in);
  /* out is NULL before the last pass, and where no map is wanted. Every pixel of out must be written. */
  triad_status (*strip)(void* inst, triad_call*, int32_t pass, triad_rect r, const triad_strip* const* in,
                        const triad_strip* out, void* state);
  /* into += from, called with ascending y. May be NULL when state_bytes is 0. In a filter's last pass the states of
   * rows that are made a second time, for another strip, are left out (since 1.1; 1.0 merged none of that pass). */
  triad_status (*merge)(const void* inst, triad_call*, int32_t pass, void* into, const void* from);
  /* Once a pass, after its last strip. scores: n_scores doubles, in the last pass of a metric; else NULL. May be NULL
   * for a one-pass filter. */
  triad_status (*end_pass)(void* inst, triad_call*, int32_t pass, const void* state, double* scores);
} triad_stage;

enum { TRIAD_SCORE_MAY_BE_INFINITE = 1 };
typedef struct {
  uint32_t struct_size;
  int32_t better; /* -1 lower, 0 nearer to zero, 1 higher */
  uint32_t flags, reserved;
  const char *name, *doc, *unit;
} triad_score;

typedef struct {
  uint32_t struct_size;
  int32_t kind;   /* TRIAD_FILTER or TRIAD_METRIC */
  const char* id; /* [a-z][a-z0-9-]{0,31} */
  const char *version, *summary, *doc;
  uint32_t n_params, n_inputs, n_scores, reserved;
  const triad_param* const* params; /* arrays of pointers, so that the records can grow */
  const triad_input* const* inputs;
  const triad_score* const* scores;
  const triad_stage* stage;
} triad_desc;

typedef struct {
  uint32_t magic, abi_major, abi_minor, struct_size; /* frozen for ever */
  const char *name, *built_with;
  uint32_t n_descs, reserved;
  const triad_desc* const* descs;
  const void* (*extension)(const char* id); /* may be NULL */
} triad_library;

/* The size of each record in version 1.0, on a machine with 8-byte pointers. Frozen. */
#define TRIAD_HOST_SIZE_1_0 96u
#define TRIAD_PARAM_SIZE_1_0 80u
#define TRIAD_INPUT_SIZE_1_0 40u
#define TRIAD_IMAGE_SIZE_1_0 120u
#define TRIAD_STRIP_SIZE_1_0 40u
#define TRIAD_PLAN_SIZE_1_0 32u
#define TRIAD_STAGE_SIZE_1_0 64u
#define TRIAD_SCORE_SIZE_1_0 40u
#define TRIAD_DESC_SIZE_1_0 88u
#define TRIAD_LIBRARY_SIZE_1_0 56u

extern TRIAD_EXPORT const triad_library triad_library_v1; /* data; the only symbol a plugin exports */

#ifdef __cplusplus
}
#endif
#endif
