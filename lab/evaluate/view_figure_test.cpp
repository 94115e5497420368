#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/oracles.h>
#include <earpoint/evaluate/view_figure.h>
#include <earpoint/evaluate/viewed_clip.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

Waveform square(float left, float right) {
  Waveform sound(2, 1000, 16000);
  for (int i = 0; i < 1000; ++i) {
    sound.channel(0)[i] = i % 2 == 0 ? left : -left;
    sound.channel(1)[i] = i % 2 == 0 ? right : -right;
  }
  return sound;
}

TEST(ViewFigure, SaysAPoseInWords) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(words_of({}), Words{"the same place"});
  const Pose pose{{1.52, -0.24, 0.0},
                  quaternion_from_euler({.yaw_rad = radians_from_degrees(-45)})};
  EXPECT_EQ(words_of(pose), (Words{"1.5 m ahead, 0.2 m right", "turned 45° right"}));
}

TEST(ViewFigure, DrawsBoxesWherePeopleAreAndWaveformsByTheRowsPeak) {
  FigureView source{.title = "Source", .picture = Image(100, 50, 3)};
  source.boxes = {{Box{.x_min = 0.5, .y_min = 0.0, .x_max = 0.75, .y_max = 1.0}, true}};
  source.sounds = {{"as recorded", square(0.5F, 0.25F)}};
  FigureView target{.title = "a < b", .source_from_target = Pose{{2.0, 0.0, 0.0}, {}}};
  target.sounds = {{"gtf", square(1.0F, 0.0F)}};
  const FigureRow row{.title = "", .views = {source, target}};
  const std::string svg = view_figure_svg({&row, 1});
  EXPECT_EQ(count(svg, "data:image/jpeg;base64,"), 1U);
  // Half of the column of 236 that begins at 14; as high as the picture, 118.
  EXPECT_NE(svg.find("<rect x=\"132.0\" y=\"95.0\" width=\"59.0\" height=\"118.0\" fill=\"none\" "
                     "stroke=\"#ffc400\""),
            std::string::npos)
      << svg.substr(svg.find("stroke=\"#ffc400\"") - 100, 120);
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  // The target has a map instead of a picture.
  EXPECT_NE(svg.find("aria-label=\"map from above\""), std::string::npos);
  // 20 log10 of the amplitudes; the target's right ear is silent.
  EXPECT_NE(svg.find(">-6 dB<"), std::string::npos);
  EXPECT_NE(svg.find(">-12 dB<"), std::string::npos);
  EXPECT_NE(svg.find(">0 dB<"), std::string::npos);
  EXPECT_NE(svg.find(">silent<"), std::string::npos);
  // Plots are 50 high with margins of 2; half the row's peak is 11.5 above the middle. Numbers have
  // one decimal: two roundings of 0.05.
  const std::size_t plot = svg.find("<path d=\"M14.0 ");
  ASSERT_NE(plot, std::string::npos);
  const double top = std::stod(svg.substr(plot + 15, 6));
  const std::size_t frame = svg.rfind("<rect x=\"14.0\" y=\"", plot);
  EXPECT_NEAR(top, std::stod(svg.substr(frame + 18, 6)) + 25.0 - 11.5, 0.11);
}

class ViewedClips : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("viewed_clips." + std::to_string(::getpid()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(ViewedClips, ShowOneSourceAndTheOtherViewpoints) {
  write_tiny_dataset(folder_);
  const auto clips = read_viewed_clips({.data = folder_});
  ASSERT_EQ(clips.size(), 1U);
  EXPECT_EQ(clips[0].targets.size(), 2U);
  ASSERT_TRUE(clips[0].near_microphone);
  ASSERT_FALSE(clips[0].source.people.empty());
  const MethodEntry input = input_method();
  const FigureRow row = figure_row(clips[0], {&input, 1}, &input);
  ASSERT_EQ(row.views.size(), 4U);
  EXPECT_EQ(row.views[1].sounds.size(), 2U);
  // The copy at the target is the source's sound; the truth is the target's own.
  const Waveform& source = row.views[0].sounds[0].sound;
  const Waveform& truth = clips[0].targets[0].sample.target;
  EXPECT_GT(energy(source.planar()), 0.0);
  EXPECT_FALSE(std::ranges::equal(source.planar(), truth.planar()));
  EXPECT_TRUE(std::ranges::equal(row.views[1].sounds[0].sound.planar(), source.planar()));
  EXPECT_TRUE(std::ranges::equal(row.views[1].sounds[1].sound.planar(), truth.planar()));
  EXPECT_EQ(row.views[3].sounds[1].sound.channels(), 1);
  EXPECT_FALSE(row.views[3].picture.empty());
}

TEST_F(ViewedClips, OfRecordingsAreFoundByNameAndCamera) {
  write_tiny_replay_dataset(folder_, {"SC-1027/3", "SC-1044/5"});
  Waveform near(1, 16000, 16000);
  RandomStream random(3);
  for (float& sample : near.planar()) sample = static_cast<float>(0.1 * random.normal());
  write_sound(folder_ / "data/appen_dataset/v3/SC-1044/5/near.wav", near);
  const auto clips = read_viewed_clips(
      {.data = folder_, .layout = DatasetLayout::replay, .names = {"SC-1044/5:2", "SC-1027/3:1"}});
  ASSERT_EQ(clips.size(), 2U);
  EXPECT_EQ(clips[0].name, "SC-1044/5");
  ASSERT_EQ(clips[0].targets.size(), 1U);
  EXPECT_EQ(clips[0].targets[0].name, "1");
  EXPECT_EQ(clips[1].targets[0].name, "2");
  // As the data set reads it, high-passed like the views.
  const ReplayDataset dataset(replay_options(folder_, "test"));
  const auto clip = std::ranges::find(dataset.clips(), std::string("SC-1044"), &ReplayClip::scene);
  ASSERT_NE(clip, dataset.clips().end());
  ASSERT_TRUE(clips[0].near_microphone);
  EXPECT_GT(energy(clips[0].near_microphone->planar()), 0.0);
  EXPECT_TRUE(
      std::ranges::equal(clips[0].near_microphone->planar(), dataset.near_sound(*clip)->planar()));
  EXPECT_FALSE(clips[1].near_microphone);
  EXPECT_FALSE(clips[0].knows_speaker);
  for (const std::string bad : {"SC-1044/4", "5", "SC-1044/5:3"}) {
    EXPECT_THROW(
        read_viewed_clips({.data = folder_, .layout = DatasetLayout::replay, .names = {bad}}),
        InputError)
        << bad;
  }
}

TEST_F(ViewedClips, OfRecordingsHaveTheSourcesThatTheReleasedTestDraws) {
  write_tiny_replay_dataset(folder_, {"SC-1027/3", "SC-1027/4", "SC-1044/5", "SC-1044/6"});
  const ReplayDataset dataset(replay_options(folder_, "test"));
  const std::vector<ReplayChoice> choices = dataset.released_choices();
  ASSERT_EQ(choices.size(), 4U);
  std::set<int> sources;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    sources.insert(choices[i].source);
    const auto clips = read_viewed_clips(
        {.data = folder_, .layout = DatasetLayout::replay, .names = {name_of(dataset.clips()[i])}});
    const int other = 1 - choices[i].source;
    EXPECT_EQ(clips[0].targets[0].name, camera_of(dataset.clips()[i], other)) << i;
  }
  EXPECT_EQ(sources.size(), 2U) << "one source for all would not tell";
}

TEST_F(ViewedClips, AreFoundByName) {
  write_tiny_dataset(folder_);
  const auto first = read_viewed_clips({.data = folder_});
  const std::string scene = first[0].scene;
  const auto named = read_viewed_clips({.data = folder_, .names = {scene + "/0:1", scene + "/0"}});
  ASSERT_EQ(named.size(), 2U);
  EXPECT_EQ(named[0].targets[0].name, "0");
  EXPECT_EQ(named[0].targets[1].name, "2");
  for (const std::string bad : {"nowhere/0", "", "/", "0:", ":"}) {
    EXPECT_THROW(read_viewed_clips({.data = folder_, .names = {bad}}), InputError) << bad;
  }
  for (const std::string source : {"9", "-1", "x", ""}) {
    const std::string words = scene + "/0:" + source;
    EXPECT_THROW(read_viewed_clips({.data = folder_, .names = {words}}), InputError) << words;
  }
}

}  // namespace
}  // namespace earpoint
