#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights_testing/reference_folders.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The miniature data sets and what the released loaders make of them.
class ReleasedLoaderTest : public ::testing::Test {
 protected:
  /// Runs the check on the first clips, which are in the source tree, and on all clips where they
  /// are available.
  static void for_every_root(const std::function<void(const fs::path&)>& check) {
    for (const fs::path& root :
         reference_folders("lab/dataset/testdata/released_loader", "F_mini")) {
      SCOPED_TRACE(root);
      check(root);
    }
  }

  /// @return how many clips the loader gave in that run; 0 if the run is not among those of the
  /// folder
  std::size_t load(const fs::path& root, const std::string& run) {
    const auto runs = nlohmann::json::parse(read_text_file(root / "expected.json")).at("runs");
    if (!runs.contains(run)) return 0;
    expected_ = read_safetensors(root / ("expected_" + run + ".safetensors"));
    return runs.at(run).at("items").size();
  }

  /// The expected sounds are every nth sample.
  /// @param tolerance  relative to the greatest expected value, at least 1
  void expect_wave(const std::string& name, const Waveform& sound, double tolerance) const {
    const auto values = expected_.tensors.at(name).as<float>();
    ASSERT_EQ(sound.planar().size(), 2 * 16000U) << name;
    const std::size_t step = sound.planar().size() / values.size();
    ASSERT_EQ(values.size() * step, sound.planar().size()) << name;
    double greatest = 1.0;
    double difference = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      greatest = std::max(greatest, std::abs(static_cast<double>(values[i])));
      difference =
          std::max(difference, std::abs(static_cast<double>(values[i]) - sound.planar()[i * step]));
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
          // A float column number near 512 is precise to 3e-5 of a pixel, and neighbours differ by
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

  SafetensorsFile expected_;
};

// Sound passes through float32 between the steps, where the loader keeps double until the end.
constexpr double kFloatSteps = 2e-6;
// Where rates differ, the loader's float32 resampling taps alone are off by up to 3e-6.
constexpr double kFloatTaps = 6e-6;

TEST_F(ReleasedLoaderTest, SoundSpacesSamplesAreTheSame) {
  for_every_root([&](const fs::path& root) {
    for (const std::string split : {"test", "train"}) {
      const std::size_t clips = load(root, "soundspaces_" + split);
      const SoundSpacesDataset dataset({.root = root, .split = split});
      NumpyRandom random(0);
      ASSERT_GT(clips, 0U);
      ASSERT_EQ(dataset.clips().size(), clips);
      for (std::size_t i = 0; i < clips; ++i) {
        const SoundSpacesClip& clip = dataset.clips()[i];
        expect_sample(i, dataset.sample(clip, dataset.draw(clip, random)), kFloatTaps);
      }
    }
  });
}

TEST_F(ReleasedLoaderTest, ReleasedPairsAreTheOnesThatItDraws) {
  // One pair of each clip, the first second: the permutations and speakers that NumPy's generator
  // of seed 0 drew in the released test.
  for_every_root([&](const fs::path& root) {
    const auto expected = nlohmann::json::parse(read_text_file(root / "expected.json"));
    const auto& items = expected.at("runs").at("soundspaces_test").at("items");
    const SoundSpacesDataset dataset({.root = root, .split = "test"});
    const PairList list = draw_pair_list(dataset, PairDraw::released, 1);
    ASSERT_GT(items.size(), 0U);
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
  });
}

TEST_F(ReleasedLoaderTest, ReplaySamplesAreTheSame) {
  for_every_root([&](const fs::path& root) {
    std::size_t all = 0;
    for (const std::string split : {"test", "val"}) {
      const std::size_t clips = load(root, "replay_" + split);
      if (clips == 0) continue;
      // In the whole set, one clip deliberately lacks the sound of a view.
      const ReplayDataset dataset({.root = root, .split = split, .blank_unreadable = true});
      NumpyRandom random(0);
      ASSERT_EQ(dataset.clips().size(), clips);
      for (std::size_t i = 0; i < clips; ++i) {
        const ReplayClip& clip = dataset.clips()[i];
        expect_sample(i, dataset.sample(clip, dataset.draw(clip, random), true), kFloatSteps);
      }
      all += clips;
    }
    EXPECT_GT(all, 0U);
  });
}

}  // namespace
}  // namespace earpoint
