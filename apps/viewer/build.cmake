# SPDX-License-Identifier: Apache-2.0
# cmake -DSTEP=install|build -DNPM=... -DNODE=... -DSOURCE=apps/viewer -DPAGE=FOLDER -P build.cmake
function(run what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${PAGE} RESULT_VARIABLE status OUTPUT_VARIABLE said
    ERROR_VARIABLE said)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${said}\n${what}\n-DTRIAD_VIEWER=OFF builds a program without `triad report`.")
  endif()
endfunction()

if(STEP STREQUAL install)
  file(REMOVE_RECURSE ${PAGE})
  file(MAKE_DIRECTORY ${PAGE})
  file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${PAGE})
  run("The viewer's packages could not be installed by npm; is there a network?"
    ${NPM} ci --ignore-scripts --no-audit --no-fund --no-update-notifier --loglevel=error)
  file(TOUCH ${PAGE}/installed)
else()
  file(REMOVE_RECURSE ${PAGE}/src ${PAGE}/dist)
  file(COPY ${SOURCE}/src ${SOURCE}/index.html ${SOURCE}/tsconfig.json ${SOURCE}/vite.config.ts DESTINATION ${PAGE})
  run("The report's page could not be built." ${NODE} node_modules/vite/bin/vite.js build)
  if(NOT EXISTS ${PAGE}/dist/index.html)
    message(FATAL_ERROR "The report's page was not built.")
  endif()
endif()
