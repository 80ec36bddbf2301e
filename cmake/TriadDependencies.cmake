# SPDX-License-Identifier: Apache-2.0
# Everything from outside, found once; the rest of the build names targets only.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)

# By pkg-config: the CMake files of Debian's OpenImageIO refer to tools that only another package installs.
pkg_check_modules(OIIO REQUIRED IMPORTED_TARGET OpenImageIO>=2.4)
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
