# SPDX-License-Identifier: Apache-2.0
# Installs Triad into an empty prefix, builds the projects in outside/ and of `triad plugin new` against it, and
# runs and checks what comes out.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(JOIN " " command ${ARGN})
    message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
set(configure -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_C_COMPILER=${C} -DCMAKE_CXX_COMPILER=${CXX})
if(SANITIZE)
  list(APPEND configure "-DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE}" "-DCMAKE_C_FLAGS=-fsanitize=${SANITIZE}")
endif()

run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build ${configure})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/run_outside ${WORK}/build)

# One line and nothing to link, as the header promises.
if(NOT SANITIZE)
  run(${CXX} -std=c++20 -O2 -shared -fPIC -I${prefix}/include ${SOURCE}/invert.cpp -o ${WORK}/invert.triad.so)
  run(${prefix}/bin/triad plugin check ${WORK}/invert.triad.so)
endif()

run(${CMAKE_COMMAND} -E chdir ${WORK} ${prefix}/bin/triad plugin new soft-glow)
run(${CMAKE_COMMAND} -E env TRIAD=${prefix}/bin/triad ${WORK}/soft-glow/test.sh ${configure})

# What was installed passes its own check.
file(GLOB plugins ${prefix}/lib*/triad/plugins/*.triad.so ${prefix}/lib/*/triad/plugins/*.triad.so)
if(NOT plugins)
  message(FATAL_ERROR "no plugin was installed")
endif()
foreach(plugin ${plugins})
  run(${prefix}/bin/triad plugin check ${plugin})
endforeach()
