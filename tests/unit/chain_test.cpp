// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <triad/base/error.hpp>
#include <triad/pipeline/chain.hpp>
#include <triad/pipeline/edge.hpp>

namespace fs = std::filesystem;
using namespace triad;
using testing::ElementsAre;

TEST(Chain, ReadsStagesAsTyped) {
  const ChainItem item = parse_stage("platt:layout=rgb,ppd=40,note='a,b'");
  EXPECT_EQ(item.id, "platt");
  EXPECT_EQ(item.params, (std::map<std::string, std::string>{{"layout", "rgb"}, {"ppd", "40"}, {"note", "a,b"}}));
  EXPECT_TRUE(parse_stage("write:a:b.exr").is_write);
  EXPECT_EQ(parse_stage("write:a:b.exr").path, "a:b.exr");
  EXPECT_EQ(parse_metric("display:ppd=67@far").label, "far");
  EXPECT_EQ(parse_metric("display:ppd=67@far").params.at("ppd"), "67");
  EXPECT_EQ(parse_metric("display@far").id, "display");
  EXPECT_EQ(parse_metric("x:path='a@b'").label, "x");
  for (const char* bad :
       {"", ":", "Platt", "platt:", "platt:ppd", "platt:=3", "platt:a=1,a=2", "write:", "a b", "platt:a='b"})
    EXPECT_THROW(parse_stage(bad), Error) << bad;
  for (const char* bad : {"display@", "display@a.b", "display@a/b", "display:ppd@x"})
    EXPECT_THROW(parse_metric(bad), Error) << bad;
}

TEST(Chain, LabelsAreUnique) {
  std::vector<ChainItem> metrics{parse_metric("a"), parse_metric("a"), parse_metric("b@a-2"), parse_metric("a")};
  make_labels_unique(metrics);
  EXPECT_EQ(metrics[1].label, "a-2");
  EXPECT_EQ(metrics[2].label, "a-2-2");
  EXPECT_EQ(metrics[3].label, "a-3");
}

class ChainFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-chain-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  fs::path folder_;
};

TEST_F(ChainFiles, ReadToml) {
  const Chain chain =
      load_chain(write("a.toml",
                       "[[stage]]\nname = 'platt'\nppd = 40\nlambda = 0.5\n[[stage]]\nwrite = 'm.exr'\n"
                       "[[metric]]\nname = 'display'\nlabel = 'near'\nflag = true\nlist = [1, 2.5]\n"));
  ASSERT_EQ(chain.stages.size(), 2u);
  EXPECT_EQ(chain.stages[0].params.at("lambda"), "0.5");
  EXPECT_EQ(chain.stages[0].params.at("ppd"), "40");
  EXPECT_EQ(chain.stages[1].path, "m.exr");
  ASSERT_EQ(chain.metrics.size(), 1u);
  EXPECT_EQ(chain.metrics[0].label, "near");
  EXPECT_EQ(chain.metrics[0].params.at("list"), "1,2.5");
  EXPECT_EQ(chain.metrics[0].params.at("flag"), "true");
}

TEST_F(ChainFiles, RefuseTomlThatIsNoChain) {
  for (const char* bad :
       {"[[stage]\n", "[[stages]]\nname='a'\n", "[[stage]]\nppd=4\n", "stage='x'\n", "[stage]\nname='a'\n",
        "[[stage]]\nname='A b'\n", "[[stage]]\nwrite='x'\nppd=3\n", "[[stage]]\nname='a'\nx={y=1}\n",
        "[[stage]]\nname='a'\nx=['y']\n", "[[metric]]\nname='a'\nlabel='../x'\n"}) {
    try {
      load_chain(write("bad.toml", bad));
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("bad.toml")) << bad;
      EXPECT_EQ(error.exit_status(), 2);
    }
  }
}

TEST_F(ChainFiles, FramesOfASequence) {
  for (const char* name :
       {"a.0001.exr", "a.0012.exr", "a.12345.exr", "a.012.exr", "a.00012.exr", "a.000x.exr", "b.0001.exr"})
    write(name, "");
  const std::string pattern = folder_ / "a.####.exr";
  EXPECT_THAT(find_frames(pattern), ElementsAre(1, 12, 12345));
  EXPECT_EQ(frame_path("x/a.####.exr", 12), "x/a.0012.exr");
  EXPECT_EQ(frame_path("a.#.png", 7), "a.7.png");
  EXPECT_EQ(frame_path("a.png", 7), "a.png");
  EXPECT_THROW(find_frames(folder_ / "c.####.exr"), Error);
  EXPECT_THROW(find_frames(folder_ / "c.##.##.exr"), Error);
  EXPECT_THROW(find_frames("no##/a.exr"), Error);
}

TEST(Edges, ContinueALineAsNamed) {
  const auto line = [](int edge) {
    std::vector<int> places;
    for (int i = -7; i < 10; ++i) places.push_back(static_cast<int>(edge_index(edge, i, 3)));
    return places;
  };
  EXPECT_THAT(line(TRIAD_EDGE_CLAMP), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2, 2, 2));
  EXPECT_THAT(line(TRIAD_EDGE_MIRROR), ElementsAre(0, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2));
  EXPECT_THAT(line(TRIAD_EDGE_WRAP), ElementsAre(2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0));
  EXPECT_THAT(line(TRIAD_EDGE_ZERO), ElementsAre(-1, -1, -1, -1, -1, -1, -1, 0, 1, 2, -1, -1, -1, -1, -1, -1, -1));
  EXPECT_EQ(edge_index(TRIAD_EDGE_MIRROR, -5, 1), 0);
}
