// SPDX-License-Identifier: Apache-2.0
// triad render --chain: the same picture as triad run makes of the render.
#include <chrono>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class RenderChain : public Cli {
 protected:
  // A small wide render of a scene with sharp edges, and more arguments.
  static std::vector<std::string> wide(const std::string& output, const std::vector<std::string>& more,
                                       const std::string& cells = "bgr") {
    std::vector<std::string> arguments{"render", "text",  "-o",         output,
                                       "--size", "48x27", "--strategy", "cells:spp=8"};
    if (!cells.empty()) arguments.insert(arguments.end(), {"--cells", cells});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(RenderChain, IsTriadRunOverTheRender) {
  expect_success(wide("wide.exr", {}));
  for (const std::string chain : {"platt", "platt:ppd=30  crop:w=20,h=12", "displaced-box"}) {
    expect_success(wide("direct.exr", {"--chain", chain}));
    std::vector<std::string> run{"run", "wide.exr", "-o", "after.exr", "--depth", "float"};
    for (size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
      end = chain.find(' ', at);
      if (end != at) run.push_back(chain.substr(at, end - at));
    }
    expect_success(run);
    const Picture direct = load(path("direct.exr")), after = load(path("after.exr"));
    EXPECT_EQ(direct.width, after.width) << chain;
    EXPECT_EQ(direct.values, after.values) << chain;
    EXPECT_EQ(direct.text.at("triad:layout"), "bgr");
    EXPECT_EQ(direct.text.at("triad:samples"), std::to_string(8 * 48 * 27));
    EXPECT_EQ(direct.text.count("triad:cells"), after.text.count("triad:cells"));
  }
}

TEST_F(RenderChain, WritesForDisplaysAndSaysWhatItTook) {
  save_text(path("chain.toml"), "[[stage]]\nname = \"platt\"\n");
  const auto record = expect_success(wide("a.png", {"--chain", "chain.toml", "--json", "-"}, "rgb")).json();
  EXPECT_EQ(record["chain"], "chain.toml");
  EXPECT_GT(record["seconds"]["chain"], 0);
  expect_success(wide("wide.exr", {}, "rgb"));
  expect_success({"run", "wide.exr", "platt", "-o", "b.png"});
  EXPECT_EQ(load(path("a.png")).width, 48);
  EXPECT_EQ(load(path("a.png")).values, load(path("b.png")).values);
  EXPECT_EQ(expect_success(wide("a.exr", {"--json", "-"})).json()["chain"], nullptr);
}

TEST_F(RenderChain, RefusesBeforeAnythingIsDrawn) {
  const auto refuse = [&](const std::vector<std::string>& more, const std::vector<std::string>& words,
                          const std::string& cells = "rgb") { expect_refusal(wide("a.exr", more, cells), words); };
  refuse({"--chain", "platt write:b.exr"}, {"--chain", "b.exr", "triad run"});
  refuse({"--chain", "  "}, {"--chain", "platt:ppd=40"});
  refuse({"--chain", "plat"}, {"plat", "platt"});
  refuse({"--chain", "platt:pdd=40"}, {"pdd", "ppd"});
  refuse({"--chain", "display"}, {"--chain", "'display'", "metric", "triad compare"});
  refuse({"--chain", "platt"}, {"platt", "wide"}, "");
  refuse({"--chain", "platt:layout=vrgb"}, {"vrgb", "1x3"});
  refuse({"--chain", "platt", "--aov", "depth"}, {"--aov", "--chain"});
  save_text(path("judge.toml"), "[[metric]]\nname = \"display\"\n");
  refuse({"--chain", "judge.toml"}, {"judge.toml", "display"});
  save_text(path("chain.toml"), "[[stage]]\nname = \"platt\"\n");
  refuse({"--chain", "chain.toml", "--json", "chain.toml"}, {"--json", "'chain.toml'", "another file"});
}

TEST_F(RenderChain, InterruptedItLeavesNothing) {
  Options options;
  const auto start = std::chrono::steady_clock::now();
  options.interrupt_when = [start] { return std::chrono::steady_clock::now() - start > std::chrono::seconds(1); };
  std::vector<std::string> arguments = wide("a.exr", {"--chain", "platt"}, "rgb");
  arguments[7] = "cells:spp=1000000";
  expect_status(130, arguments, options);
  EXPECT_EQ(files(), std::set<std::string>{});
}

}  // namespace
}  // namespace cli
