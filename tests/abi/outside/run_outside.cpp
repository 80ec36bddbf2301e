// SPDX-License-Identifier: Apache-2.0
// Runs gain:factor=3 and then invert over two pixels, through the installed library.
#include <cstdio>
#include <triad/base/error.hpp>
#include <triad/pipeline/plugin_check.hpp>
#include <triad/pipeline/plugin_host.hpp>

namespace {

void run(triad::PluginHost& host, const char* id, const triad::ParamTexts& params, float (&pixels)[6]) {
  triad::StageInstance stage(host.find(id), params);
  const triad_image image{sizeof(triad_image), 2, 1, 3, -1, 1, 1, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, 0};
  stage.plan({&image}, {nullptr});
  float result[6];
  const triad_rect r{0, 0, 2, 1};
  const triad_strip in{sizeof(triad_strip), 3, stage.need(0, r)[0], pixels, sizeof pixels};
  const triad_strip out{sizeof(triad_strip), 3, r, result, sizeof result};
  stage.strip(0, r, {&in}, &out, nullptr);
  for (int i = 0; i < 6; ++i) pixels[i] = result[i];
}

}  // namespace

int main(int count, char** arguments) {
  try {
    // The folder of the plugins, by its path. Checks come first: they want a process with one thread.
    if (count != 2) return 2;
    const std::string folder = arguments[1];
    for (const char* name : {"/gain.triad.so", "/invert.triad.so"})
      for (const triad::CheckResult& result : triad::check_plugin(folder + name))
        if (!result.passed) {
          std::fprintf(stderr, "%s: %s: %s\n", name, result.rule.c_str(), result.message.c_str());
          return 1;
        }
    triad::PluginHost host({folder});
    float pixels[6] = {0, .125f, .25f, .5f, 1, 2};
    run(host, "gain", {{"factor", "3"}}, pixels);
    run(host, "invert", {}, pixels);
    const float expected[6] = {1, .625f, .25f, -.5f, -2, -5};
    for (int i = 0; i < 6; ++i)
      if (pixels[i] != expected[i]) {
        std::fprintf(stderr, "value %d is %g, not %g\n", i, static_cast<double>(pixels[i]),
                     static_cast<double>(expected[i]));
        return 1;
      }
    return 0;
  } catch (const triad::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
