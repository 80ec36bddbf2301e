// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/picture_library.hpp>

namespace triad::image {
namespace {

// A symbol is looked up in all libraries of the tree that is being loaded, in their order, and the largest of those
// behind OpenImageIO come late in it. Loaded by themselves, their symbols are found in their own small trees, which
// halves the time (Debian 12: .20 s together, .13 s so). Which ones there are the build has found out; one that is
// missing here changes nothing but the time.
void load_large_ones_first() {
  for (const auto& name : split_quoted(TRIAD_LOAD_FIRST, ':'))
    if (!name.empty()) dlopen(name.c_str(), RTLD_LAZY | RTLD_LOCAL);
}

const PictureLibrary& load() {
  load_large_ones_first();
  const std::string path = library_folder() + "/triad/openimageio.so";
  void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL | RTLD_NODELETE);
  if (!library) {
    const char* reason = dlerror();
    throw_input("cannot load '" + path +
                "', which reads and writes pictures: " + (reason ? reason : "unknown reason"));
  }
  const auto entry = reinterpret_cast<decltype(&triad_picture_library)>(dlsym(library, "triad_picture_library"));
  if (!entry)
    throw_input("'" + path + "' is not the library of this version of Triad that reads and writes pictures");
  return *entry();
}

}  // namespace

const PictureLibrary& picture_library() {
  static const PictureLibrary& library = load();
  return library;
}

}  // namespace triad::image
