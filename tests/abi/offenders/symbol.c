/* SPDX-License-Identifier: Apache-2.0 */
/* Files whose exported symbol is not what a plugin exports, and files that misbehave while they are loaded. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define CONSTRUCTOR __attribute__((constructor)) static void

#if defined(OTHER_SYMBOL)
EXPORT const char some_other_symbol[64] = "no plugin";
#elif defined(OTHER_VERSION)
EXPORT const char triad_library_v2[64] = "from the future";
#elif defined(FUNCTION)
EXPORT int triad_library_v1(void);
int triad_library_v1(void) { return 1; }
#elif defined(SMALL)
EXPORT const char triad_library_v1[16] = "too small";
#else
EXPORT const char triad_library_v1[64] = "no record";
#endif

#if defined(EXIT_ON_LOAD)
CONSTRUCTOR on_load(void) { exit(0); }
#elif defined(HANG_ON_LOAD)
CONSTRUCTOR on_load(void) {
  for (;;) pause();
}
#elif defined(CRASH_ON_LOAD)
CONSTRUCTOR on_load(void) { abort(); }
#elif defined(PRINT_ON_LOAD)
CONSTRUCTOR on_load(void) { puts("hello"); }
#endif
