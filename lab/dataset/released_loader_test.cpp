#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The miniature data sets and what the released loaders make of them.
class ReleasedLoaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("EARPOINT_ORACLE_DIR");
    if (folder == nullptr) GTEST_SKIP() << "EARPOINT_ORACLE_DIR is not set";
    root_ = fs::path(folder) / "F_mini";
  }

  void load(const std::string& run) {
    expected_ = read_safetensors(root_ / ("expected_" + run + ".safetensors"));
  }

  /// @param tolerance  relative to the greatest expected value, at least 1
  void expect_wave(const std::string& name, const Waveform& sound, double tolerance) const {
    const auto values = expected_.tensors.at(name).as<float>();
    ASSERT_EQ(values.size(), sound.planar().size()) << name;
    double greatest = 1.0;
    double difference = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      greatest = std::max(greatest, std::abs(static_cast<double>(values[i])));
      difference =
          std::max(difference, std::abs(static_cast<double>(values[i]) - sound.planar()[i]));
    }
    EXPECT_LE(difference, tolerance * greatest) << name << ", greatest " << greatest;
  }

  /// The expected pictures are every 8th row and column.
  void expect_rgb(const std::string& name, const ImagePlanes& planes) const {
    const auto values = expected_.tensors.at(name).as<float>();
    std::size_t i = 0;
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < planes.height; y += 8) {
        for (int x = 0; x < planes.width; x += 8) {
          const auto at = (static_cast<std::size_t>(c) * planes.height + y) * planes.width + x;
          // A float column number near 512 is good to 3e-5 of a pixel, and neighbours differ by
          // up to 1.
          ASSERT_NEAR(planes.values[at], values[i++], 3e-5) << name << " " << c << y << x;
        }
      }
    }
    EXPECT_EQ(i, values.size());
  }

  void expect_numbers(const std::string& name, const std::vector<double>& numbers) const {
    const Tensor& tensor = expected_.tensors.at(name);
    ASSERT_EQ(tensor.elements(), static_cast<std::int64_t>(numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double value = tensor.dtype == DType::f64 ? tensor.as<double>()[i]
                                                      : static_cast<double>(tensor.as<float>()[i]);
      // The loader rounds some of them to float.
      EXPECT_NEAR(numbers[i], value, 1e-6 * std::max(1.0, std::abs(value))) << name << " " << i;
    }
  }

  void expect_sample(std::size_t item, const NvasSample& sample, double tolerance) const {
    const std::string prefix = std::to_string(item) + "/";
    expect_wave(prefix + "src_wav", sample.source, tolerance);
    expect_wave(prefix + "tgt_wav", sample.target, tolerance);
    expect_rgb(prefix + "src_rgb", sample.source_rgb);
    expect_rgb(prefix + "tgt_rgb", sample.target_rgb);
    expect_numbers(prefix + "bboxes", sample.bboxes);
    expect_numbers(prefix + "tgt_pose", sample.tgt_pose);
    expect_numbers(prefix + "tgt_rotation", sample.tgt_rotation);
  }

  fs::path root_;
  SafetensorsFile expected_;
};

// Sound passes through float32 between the steps, where the loader keeps double until the end.
constexpr double kFloatSteps = 2e-6;
// Where rates differ, the loader's float32 resampling taps alone are off by up to 3e-6.
constexpr double kFloatTaps = 6e-6;

TEST_F(ReleasedLoaderTest, SoundSpacesSamplesAreTheSame) {
  for (const std::string split : {"test", "train"}) {
    load("soundspaces_" + split);
    const SoundSpacesDataset dataset({.root = root_, .split = split});
    NumpyRandom random(0);
    ASSERT_EQ(dataset.clips().size(), split == "test" ? 4U : 2U);
    for (std::size_t i = 0; i < dataset.clips().size(); ++i) {
      const SoundSpacesClip& clip = dataset.clips()[i];
      expect_sample(i, dataset.sample(clip, dataset.draw(clip, random)), kFloatTaps);
    }
  }
}

TEST_F(ReleasedLoaderTest, ReleasedPairsAreTheOnesThatItDraws) {
  // One pair of each clip, the first second: the permutations and speakers that NumPy's generator
  // of seed 0 drew in the released test.
  const auto expected = nlohmann::json::parse(read_text_file(root_ / "expected.json"));
  const auto& items = expected.at("runs").at("soundspaces_test").at("items");
  const SoundSpacesDataset dataset({.root = root_, .split = "test"});
  const PairList list = draw_pair_list(dataset, PairDraw::released, 1);
  ASSERT_EQ(list.pairs.size(), items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const SoundSpacesChoice& choice = list.pairs[i].choice;
    const auto& draws = items[i].at("draws");
    EXPECT_EQ(choice.source, draws[0][1][0].get<int>()) << i;
    EXPECT_EQ(choice.target, draws[0][1][1].get<int>()) << i;
    std::vector<int> speaking;
    const auto& speakers = clip_of(list.pairs[i], dataset.clips(), "list").speakers;
    for (std::size_t k = 0; k < speakers.size(); ++k) {
      if (speakers[k].speech) speaking.push_back(static_cast<int>(k));
    }
    EXPECT_EQ(choice.speaker, speaking.at(draws[1][1].get<std::size_t>())) << i;
    EXPECT_EQ(choice.window_start, 0) << i;
  }
}

TEST_F(ReleasedLoaderTest, ReplaySamplesAreTheSame) {
  for (const std::string split : {"test", "val"}) {
    load("replay_" + split);
    // One clip lacks a view's sound, on purpose.
    const ReplayDataset dataset({.root = root_, .split = split, .blank_unreadable = true});
    NumpyRandom random(0);
    ASSERT_EQ(dataset.clips().size(), split == "test" ? 4U : 1U);
    for (std::size_t i = 0; i < dataset.clips().size(); ++i) {
      const ReplayClip& clip = dataset.clips()[i];
      expect_sample(i, dataset.sample(clip, dataset.draw(clip, random), true), kFloatSteps);
    }
  }
}

}  // namespace
}  // namespace earpoint
