# SPDX-License-Identifier: Apache-2.0
# cmake -DHTML=FILE -DCPP=FILE -P embed.cmake: the page as a constant of the program; empty without a page.
set(bytes "")
if(HTML)
  file(READ ${HTML} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(REGEX REPLACE "(................................................................................)" "\\1\n"
    bytes "${bytes}")
endif()
file(WRITE ${CPP} "// Made of the page that apps/viewer builds.
#include \"viewer_page.hpp\"

namespace triad::app {
namespace {
constexpr unsigned char kPage[] = {
${bytes}0};
}  // namespace

std::string_view viewer_page() { return {reinterpret_cast<const char*>(kPage), sizeof kPage - 1}; }

}  // namespace triad::app
")
