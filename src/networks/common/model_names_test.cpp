#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/network/model_names.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ModelNames : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(EARPOINT_BINARY_DIR) / "model_names_test" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "shipped");
    ::setenv("EARPOINT_MODELS_DIR", (folder_ / "shipped").c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_MODELS_DIR");
    fs::remove_all(folder_);
  }

  fs::path make(const fs::path& below) const {
    write_file(folder_ / below, "");
    return folder_ / below;
  }

  fs::path folder_;
};

TEST_F(ModelNames, AFileComesBeforeAShippedModelOfThatName) {
  const fs::path shipped = make("shipped/a.safetensors");
  const fs::path mine = make("a");
  EXPECT_EQ(find_model("a"), shipped);
  EXPECT_EQ(find_model(mine.string()), mine);
  EXPECT_EQ(find_model("b"), std::nullopt);
  EXPECT_EQ(shipped_model(mine.string()), std::nullopt);
}

TEST_F(ModelNames, AllThatAreShippedAreNamedWithoutTheDefaultModelToo) {
  EXPECT_TRUE(shipped_model_names().empty());
  make("shipped/enhance.safetensors");
  make("shipped/enhance.md");
  EXPECT_EQ(shipped_model_names(), std::vector<std::string>{"enhance"});
}

TEST_F(ModelNames, NoWordMeansTheDefaultModelOrDspWhereNoneIsShipped) {
  EXPECT_EQ(resolve_model(""), "dsp");
  const fs::path gtf = make("shipped/gtf.safetensors");
  EXPECT_EQ(resolve_model(""), gtf);
  EXPECT_EQ(resolve_model("gtf"), gtf);
}

TEST_F(ModelNames, WordsThatNeedNoFileAndThoseThatMeanNothingStayAsTheyAre) {
  make("shipped/dsp.safetensors");
  for (const char* word : {"input", "dsp", "nothing"}) EXPECT_EQ(resolve_model(word), word);
}

TEST_F(ModelNames, AFamilyIsItsNameAndThoseWithAHyphen) {
  for (const char* name : {"vigas", "gtf-small", "gtf", "gtfx", "rt60"}) {
    make(std::string("shipped/") + name + ".safetensors");
  }
  make("shipped/gtf.md");
  EXPECT_EQ(shipped_model_names({"gtf", "vam", "vigas"}),
            (std::vector<std::string>{"gtf", "gtf-small", "vigas"}));
  EXPECT_EQ(shipped_model_names(),
            (std::vector<std::string>{"gtf", "gtf-small", "gtfx", "rt60", "vigas"}));
}

}  // namespace
}  // namespace earpoint
