#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/render_files/open_sound_sink.h>
#include <earpoint/render_files/sound_input.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate = 16000;

class SurveyTest : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove(file_); }
  fs::path file_ = fs::path(testing::TempDir()) / ("survey_" + std::to_string(::getpid()) + ".wav");
};

TEST_F(SurveyTest, WarnsOfStereoThatIsNotBinauralUnlessAskedForOneChannel) {
  Waveform panned(2, 2 * kRate, kRate);
  RandomStream random(5);
  for (std::ptrdiff_t i = 0; i < panned.samples(); ++i) {
    panned.channel(0)[i] = static_cast<float>(0.1 * random.normal());
    panned.channel(1)[i] = 0.5F * panned.channel(0)[i];
  }
  write_sound(file_, panned, SampleFormat::float32);
  SoundInput source{.path = file_, .binaural_channels = {}, .audio_stream = {}};
  const SoundSurvey survey = survey_sound(source);
  EXPECT_EQ(survey.stereo, StereoKind::panned);
  ASSERT_EQ(survey.warnings.size(), 1U);
  EXPECT_NE(survey.warnings[0].find("not binaural"), std::string::npos) << survey.warnings[0];
  source.binaural_channels = {0, 0};
  EXPECT_TRUE(survey_sound(source).warnings.empty());
}

TEST(SoundSink, AWavFileThatWillHoldMoreThanFourGigabytesIsRf64) {
  const fs::path path =
      fs::path(testing::TempDir()) / ("long." + std::to_string(::getpid()) + ".wav");
  const auto mark_with = [&](std::ptrdiff_t samples) {
    const auto sink = open_sound_sink(path, 48000, {}, samples);
    sink->write(Waveform(2, 480, 48000));
    sink->commit();
    const std::string mark = read_text_file(path).substr(0, 4);
    fs::remove(path);
    return mark;
  };
  EXPECT_EQ(mark_with(540'000'000), "RF64");  // 4.32 GB in two channels of 32 bits
  EXPECT_EQ(mark_with(530'000'000), "RIFF");
}

}  // namespace
}  // namespace earpoint
