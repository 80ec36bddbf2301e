/* SPDX-License-Identifier: Apache-2.0 */
/* The contract is C11, and its 1.0 records never change their size or the place of a member. */
#include <triad/abi/triad_plugin.h>

_Static_assert(sizeof(triad_host) == TRIAD_HOST_SIZE_1_0, "triad_host");
_Static_assert(sizeof(triad_param) == TRIAD_PARAM_SIZE_1_0, "triad_param");
_Static_assert(sizeof(triad_input) == TRIAD_INPUT_SIZE_1_0, "triad_input");
_Static_assert(offsetof(triad_image, display_codes) == TRIAD_IMAGE_SIZE_1_0, "triad_image");
_Static_assert(sizeof(triad_strip) == TRIAD_STRIP_SIZE_1_0, "triad_strip");
_Static_assert(offsetof(triad_plan, work_bytes) == TRIAD_PLAN_SIZE_1_0, "triad_plan");
_Static_assert(sizeof(triad_stage) == TRIAD_STAGE_SIZE_1_0, "triad_stage");
_Static_assert(sizeof(triad_score) == TRIAD_SCORE_SIZE_1_0, "triad_score");
_Static_assert(sizeof(triad_desc) == TRIAD_DESC_SIZE_1_0, "triad_desc");
_Static_assert(sizeof(triad_library) == TRIAD_LIBRARY_SIZE_1_0, "triad_library");
_Static_assert(sizeof(triad_rect) == 16 && sizeof(triad_value) == 16, "frozen for ever");
_Static_assert(offsetof(triad_host, extension) == 88, "triad_host.extension");
_Static_assert(offsetof(triad_param, def) == 56, "triad_param.def");
_Static_assert(offsetof(triad_image, rgb_to_xyz) == 40, "triad_image.rgb_to_xyz");
_Static_assert(offsetof(triad_strip, row_bytes) == 32, "triad_strip.row_bytes");
_Static_assert(offsetof(triad_plan, state_bytes) == 24, "triad_plan.state_bytes");
_Static_assert(offsetof(triad_stage, end_pass) == 56, "triad_stage.end_pass");
_Static_assert(offsetof(triad_desc, stage) == 80, "triad_desc.stage");
_Static_assert(offsetof(triad_library, descs) == 40, "triad_library.descs");

int triad_header_as_c(void);
int triad_header_as_c(void) {
  triad_plan plan = {0};
  plan.struct_size = 8;
  return TRIAD_HAS(&plan, triad_plan, threads) && !TRIAD_HAS(&plan, triad_plan, edge);
}
