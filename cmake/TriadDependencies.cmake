# SPDX-License-Identifier: Apache-2.0
# Everything from outside, found once; the rest of the build names targets only.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)

# By pkg-config: the CMake files of Debian's OpenImageIO refer to tools that only another package installs.
pkg_check_modules(OIIO REQUIRED IMPORTED_TARGET OpenImageIO>=2.4)
# Its metadata lists alone, for what must start without the many libraries behind its formats.
find_library(TRIAD_OIIO_UTIL OpenImageIO_Util HINTS ${OIIO_LIBRARY_DIRS} ${OIIO_LIBDIR} REQUIRED)
mark_as_advanced(TRIAD_OIIO_UTIL)
add_library(triad_oiio_util INTERFACE)
target_include_directories(triad_oiio_util SYSTEM INTERFACE ${OIIO_INCLUDE_DIRS})
target_link_libraries(triad_oiio_util INTERFACE ${TRIAD_OIIO_UTIL})
# The largest of those libraries by the symbols that the loader must look up (libcore/image/picture_library.cpp),
# where OpenImageIO is built with them: their names as the loader knows them, separated by colons, those that others of
# the list need before the others.
set(TRIAD_LOAD_FIRST "")
if(NOT CMAKE_CROSSCOMPILING)
  find_library(TRIAD_OIIO OpenImageIO HINTS ${OIIO_LIBRARY_DIRS} ${OIIO_LIBDIR} REQUIRED)
  mark_as_advanced(TRIAD_OIIO)
  execute_process(COMMAND ldd ${TRIAD_OIIO} OUTPUT_VARIABLE behind_oiio ERROR_QUIET)
  foreach(large openvdb xerces-c geos proj spatialite poppler gdal dcmimage gdcmMSFF avformat)
    if(behind_oiio MATCHES "(lib${large}(-[0-9.]+)?[.]so[.0-9]*)")
      list(APPEND TRIAD_LOAD_FIRST ${CMAKE_MATCH_1})
    endif()
  endforeach()
  list(JOIN TRIAD_LOAD_FIRST ":" TRIAD_LOAD_FIRST)
endif()
pkg_check_modules(OCIO REQUIRED IMPORTED_TARGET OpenColorIO>=2.1)  # Debian's CMake config is broken
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3)
pkg_check_modules(FFTWF REQUIRED IMPORTED_TARGET fftw3f)
find_package(Eigen3 3.4 CONFIG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(TBB 2021 CONFIG REQUIRED)
find_package(fmt 9 CONFIG REQUIRED)
find_package(CLI11 2.1 CONFIG REQUIRED)
find_package(tomlplusplus 3 CONFIG REQUIRED)
find_package(nlohmann_json 3.11 CONFIG REQUIRED)
find_package(embree 3.13 CONFIG REQUIRED)
find_package(TinyGLTF 2.7 CONFIG REQUIRED)  # a header; apps/raytracer compiles it
find_package(TinyGLTF 2.7 CONFIG REQUIRED)
