#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/reverberant_speech.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(NoiseResponse, DecaysAsAsked) {
  for (const double t60_s : {0.15, 0.4, 0.9, 1.3}) {
    RandomStream random(3);
    const std::optional<double> found = middle_t60_s(noise_response(t60_s, 32000, random));
    ASSERT_TRUE(found.has_value()) << t60_s;
    // The decay of the middle octaves is varied by up to 15 %; a single noise response adds a few
    // percent.
    EXPECT_NEAR(*found, t60_s, 0.25 * t60_s);
  }
}

TEST(ChangeDecay, GivesTheDecayAskedFor) {
  RandomStream random(4);
  std::vector<float> original = noise_response(0.6, 32000, random);
  original[0] = 0.0F;  // without the direct sound, whose step is not part of the decay
  const double from_s = middle_t60_s(original).value();
  for (const double to_s : {0.3, 0.6, 1.0}) {
    std::vector<float> changed = original;
    change_decay(changed, from_s, to_s);
    // The regression over the curve weighs the early part differently once it is steeper.
    EXPECT_NEAR(middle_t60_s(changed).value(), to_s, 0.07 * to_s);
  }
}

TEST(MiddleT60, HasNoValueWhereTheDecayIsCutOff) {
  RandomStream random(5);
  std::vector<float> response = noise_response(1.2, 32000, random);
  response[0] = 0.0F;
  EXPECT_TRUE(middle_t60_s(response).has_value());
  response.resize(2000);
  EXPECT_FALSE(middle_t60_s(response).has_value());
  EXPECT_FALSE(middle_t60_s(std::vector<float>(20)).has_value());
}

class ReverberantSpeechTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("reverberant_speech." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_, {.response_s = 0.3});
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] SoundSpacesDataset dataset() const {
    return SoundSpacesDataset(soundspaces_options(folder_, "train"));
  }

  fs::path folder_;
};

TEST_F(ReverberantSpeechTest, KnowsTheTimesOfItsResponses) {
  const SoundSpacesDataset data = dataset();
  const ReverberantSpeech speech(data);
  ASSERT_EQ(speech.responses(), 2U * 3U * 2U * 2U);  // clips, viewpoints, speakers, ears
  std::size_t index = 0;
  for (const SoundSpacesClip& clip : data.clips()) {
    for (const SoundSpacesViewpoint& viewpoint : clip.viewpoints) {
      for (const auto& [speaker, name] : viewpoint.rir) {
        const Waveform response = data.read_response(name).sound;
        for (int ear = 0; ear < 2; ++ear) {
          RandomStream random(1, {index});
          const ReverberantSecond second = speech.measured(index++, random);
          EXPECT_EQ(second.sound.size(), 16000U);
          EXPECT_EQ(second.t60_s, middle_t60_s(response.channel(ear)));
          EXPECT_LT(second.t60_s, 0.13);  // the tails decay in 0.1 s
        }
      }
    }
  }
}

TEST_F(ReverberantSpeechTest, KeepsAsManyResponsesAsAskedFor) {
  EXPECT_EQ(ReverberantSpeech(dataset(), 5).responses(), 10U);
}

TEST_F(ReverberantSpeechTest, DrawsTheSameFromTheSameStreamAndCoversManyTimes) {
  const ReverberantSpeech speech(dataset());
  double shortest_s = 10.0;
  double longest_s = 0.0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    RandomStream random(7, {i});
    RandomStream again(7, {i});
    const ReverberantSecond second = speech.draw(random);
    EXPECT_EQ(second.sound, speech.draw(again).sound);
    EXPECT_TRUE(std::ranges::all_of(second.sound, [](float x) { return std::isfinite(x); }));
    shortest_s = std::min(shortest_s, second.t60_s);
    longest_s = std::max(longest_s, second.t60_s);
  }
  EXPECT_LT(shortest_s, 0.15);
  EXPECT_GT(longest_s, 0.2);  // longer decays are cut off by the length of the responses
}

TEST_F(ReverberantSpeechTest, RefusesResponsesThatDoNotDecay) {
  Waveform click(2, 20, 16000);
  for (int ear = 0; ear < 2; ++ear) click.channel(ear)[0] = 1.0F;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "train")) {
    if (entry.path().extension() == ".wav") write_sound(entry.path(), click);
  }
  EXPECT_THROW(ReverberantSpeech{dataset()}, InputError);
}

}  // namespace
}  // namespace earpoint
