# SPDX-License-Identifier: Apache-2.0
# triad_add_plugin(NAME source... [LIBRARIES target...]): builds NAME.triad.so, a Triad plugin.
#
# Hidden visibility and -fno-gnu-unique keep two plugins from sharing their symbols by accident; -z defs makes
# a forgotten library an error of the linker and not of the user's first run.
function(triad_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LIBRARIES")
  add_library(${name} MODULE ${arg_UNPARSED_ARGUMENTS})
  set_target_properties(${name} PROPERTIES
    PREFIX "" OUTPUT_NAME ${name} SUFFIX ".triad.so"
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(TRIAD_PLUGIN_OUTPUT_DIRECTORY)
    set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${TRIAD_PLUGIN_OUTPUT_DIRECTORY})
  endif()
  target_compile_features(${name} PRIVATE cxx_std_20)
  target_compile_options(${name} PRIVATE $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CXX_COMPILER_ID:GNU>>:-fno-gnu-unique>)
  if(NOT TRIAD_SANITIZE)  # a sanitizer's run-time functions are found at load time
    target_link_options(${name} PRIVATE -Wl,-z,defs)
  endif()
  target_link_libraries(${name} PRIVATE triad::abi ${arg_LIBRARIES})
endfunction()
