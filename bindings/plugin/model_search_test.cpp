#include "model_search.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/temporary_folder.h>
#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint::plugin {
namespace {

namespace fs = std::filesystem;

class ModelSearchTest : public ::testing::Test {
 protected:
  ModelSearchTest() {
    ::unsetenv("EARPOINT_MODELS_DIR");
    GtfDescription description;
    description.channels = 8;
    description.layers = 1;
    description.bands = 10;
    description.picture_px = 0;
    weights_ = to_weight_file(random_gtf_weights(description));
  }

  void put(const std::string& file) const {
    const fs::path path = folder_.path() / file;
    fs::create_directories(path.parent_path());
    write_safetensors(path, weights_);
  }
  [[nodiscard]] std::vector<StreamingModel> found(const std::string& binary) const {
    return find_streaming_models(folder_.path() / binary);
  }

  TemporaryFolder folder_;
  SafetensorsFile weights_;
};

std::vector<std::string> names(const std::vector<StreamingModel>& models) {
  std::vector<std::string> result;
  for (const StreamingModel& model : models) result.push_back(model.name);
  return result;
}

fs::path file_of(const std::vector<StreamingModel>& models, const std::string& name) {
  const auto found = std::ranges::find(models, name, &StreamingModel::name);
  return found == models.end() ? fs::path() : found->file;
}

TEST_F(ModelSearchTest, FindsThemBesideTheBinaryInTheBundleAndUnderThePrefix) {
  put("lib/lv2/earpoint.lv2/models/beside.safetensors");
  put("lib/vst3/earpoint.vst3/Contents/Resources/models/resource.safetensors");
  put("share/earpoint/models/shared.safetensors");
  const auto lv2 = found("lib/lv2/earpoint.lv2/earpoint.so");
  EXPECT_EQ(file_of(lv2, "beside"),
            folder_.path() / "lib/lv2/earpoint.lv2/models/beside.safetensors");
  EXPECT_NE(file_of(lv2, "shared"), "");
  EXPECT_EQ(file_of(lv2, "resource"), "");
  EXPECT_NE(file_of(found("lib/vst3/earpoint.vst3/Contents/x86_64-linux/earpoint.so"), "resource"),
            "");
}

TEST_F(ModelSearchTest, TakesTheNearestOfTwoWithOneName) {
  put("share/earpoint/models/gtf.safetensors");
  put("lib/lv2/earpoint.lv2/models/gtf.safetensors");
  EXPECT_EQ(file_of(found("lib/lv2/earpoint.lv2/earpoint.so"), "gtf"),
            folder_.path() / "lib/lv2/earpoint.lv2/models/gtf.safetensors");
}

TEST_F(ModelSearchTest, KeepsTheNumbersOfTheShippedOnesAndSortsTheRest) {
  for (const char* name : {"zebra", "gtf", "alpha", "enhance"}) {
    put(std::string("models/") + name + ".safetensors");
  }
  std::ofstream(folder_.path() / "models/broken.safetensors") << "no weights";
  ::setenv("EARPOINT_MODELS_DIR", (folder_.path() / "models").c_str(), 1);
  EXPECT_EQ(names(found("earpoint.so")),
            (std::vector<std::string>{"gtf", "enhance", "alpha", "zebra"}));
  ::unsetenv("EARPOINT_MODELS_DIR");
}

TEST_F(ModelSearchTest, SurvivesWhatIsNoNetworkNearTheHostsProgram) {
  // Where the library searches too: a folder beside the program, here the test.
  const fs::path models = fs::read_symlink("/proc/self/exe").parent_path() / "models";
  const bool was_there = fs::exists(models);
  fs::create_directories(models);
  const fs::path broken = models / "aaa_broken_network.safetensors";
  const fs::path dangling = models / "aaa_dangling_link.safetensors";
  const fs::path folder = models / "aaa_folder.safetensors";
  std::ofstream(broken) << "no weights";
  fs::create_symlink("/nowhere", dangling);
  fs::create_directories(folder);
  const auto models_found = found("earpoint.so");
  for (const fs::path& file : {broken, dangling, folder}) {
    EXPECT_EQ(file_of(models_found, file.stem().string()), "");
    fs::remove(file);
  }
  if (!was_there) fs::remove(models);
}

TEST_F(ModelSearchTest, ANamedFolderIsTheOnlyOne) {
  put("models/beside.safetensors");
  fs::create_directories(folder_.path() / "empty");
  ::setenv("EARPOINT_MODELS_DIR", (folder_.path() / "empty").c_str(), 1);
  EXPECT_EQ(names(found("earpoint.so")), std::vector<std::string>{});
  ::unsetenv("EARPOINT_MODELS_DIR");
}

TEST_F(ModelSearchTest, OffersNoMoreThanTheParameterHasNumbersFor) {
  for (int i = 0; i < kMostModels + 3; ++i) {
    put("models/m" + std::to_string(i) + ".safetensors");
  }
  ::setenv("EARPOINT_MODELS_DIR", (folder_.path() / "models").c_str(), 1);
  EXPECT_EQ(found("earpoint.so").size(), std::size_t{kMostModels});
  ::unsetenv("EARPOINT_MODELS_DIR");
}

}  // namespace
}  // namespace earpoint::plugin
