// SPDX-License-Identifier: Apache-2.0
// What the filters that make a panel's drives of a wide render share: which panel, and its name on what they make.
#pragma once

#include "seeing_parameters.hpp"

namespace driven_panel {

namespace tp = triad_plugin;
namespace sp = seeing_parameters;

// In plan: the panel that `layout` names, or the picture if that is auto. The output becomes a picture for that
// panel, of its size, and names it, so that the stages that follow judge and show it on the same. Throws Error where
// the cells do not fit; warns where the picture was made for another panel whose cells fit too.
inline triad::Layout plan_for(tp::PlanCall& call, const std::string& layout) {
  const auto named = call.get_meta(0, sp::kLayoutKey);
  triad::Layout panel = sp::choose_panel(layout, {named});
  display_parameters::narrow(call.in(0), panel, call.out);
  if (named && *named != panel.name)
    call.warn("layout=" + layout + " is not the layout that the picture was made for, '" + *named +
              "'; layout=auto takes that");
  call.set_meta(sp::kLayoutKey, panel.name);
  return panel;
}

}  // namespace driven_panel
