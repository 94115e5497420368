#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPlenty = 100'000'000;
// Both convolve in float32 by transforms of different sizes: 1e-6 of the largest sample in each,
// which is at least the level of the speech.
constexpr double kRounding = 2e-6;
constexpr double kSpeechLevel = 0.2;

class PairSamplerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("pair_sample." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] SoundSpacesDataset dataset(const std::string& split = "train") const {
    return SoundSpacesDataset(soundspaces_options(folder_, split));
  }

  fs::path folder_;
};

void expect_same(const Waveform& found, const Waveform& expected) {
  ASSERT_EQ(found.channels(), expected.channels());
  ASSERT_EQ(found.samples(), expected.samples());
  double greatest = 0.0;
  for (const float sample : expected.planar()) {
    greatest = std::max(greatest, std::abs(static_cast<double>(sample)));
  }
  EXPECT_GT(greatest, 0.0);
  const double tolerance = kRounding * std::max(greatest, kSpeechLevel);
  for (std::size_t i = 0; i < found.planar().size(); ++i) {
    ASSERT_NEAR(found.planar()[i], expected.planar()[i], tolerance) << i;
  }
}

TEST_F(PairSamplerTest, SoundsAreThoseOfTheReleasedLoader) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const SoundSpacesClip& clip = data.clips()[1];
  const std::ptrdiff_t speech = sampler.speech_samples(clip.speakers[0]);
  EXPECT_EQ(speech, 24000);
  // At the beginning, within, across the end, and where only the tail is left.
  for (const std::ptrdiff_t start :
       {std::ptrdiff_t{0}, std::ptrdiff_t{3210}, speech - 8000, speech + 100}) {
    const SoundSpacesChoice choice{.source = 2, .target = 1, .speaker = 0, .window_start = start};
    const PairSample sample = sampler.sample(clip, choice);
    const NvasSample released = data.sample(clip, choice);
    expect_same(sample.source, released.source);
    expect_same(sample.target, released.target);
  }
}

TEST_F(PairSamplerTest, ContextIsTheSoundBeforeTheSameWindow) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const SoundSpacesClip& clip = data.clips()[0];
  // Context within the speech, and from before its beginning.
  for (const std::ptrdiff_t start : {std::ptrdiff_t{7000}, std::ptrdiff_t{2000}}) {
    constexpr std::ptrdiff_t kContext = 4000;
    const SoundSpacesChoice choice{.source = 0, .target = 1, .speaker = 1, .window_start = start};
    const PairSample alone = sampler.sample(clip, choice, 6000);
    const PairSample more = sampler.sample(clip, choice, 6000, kContext);
    EXPECT_EQ(more.context, kContext);
    ASSERT_EQ(more.source.samples(), kContext + 6000);
    expect_same(more.target, alone.target);
    expect_same(more.dry, alone.dry);
    expect_same(without_context(more).source, alone.source);
    const auto before = more.source.channel(0).first(kContext);
    const auto silent = std::max(kContext - start, std::ptrdiff_t{0});
    // Before the speech there is only the transform's rounding.
    for (std::ptrdiff_t i = 0; i < silent; ++i) ASSERT_NEAR(before[i], 0.0F, kRounding);
    EXPECT_TRUE(
        std::ranges::any_of(before.subspan(silent), [](float x) { return std::abs(x) > 1e-3F; }));
  }
}

TEST_F(PairSamplerTest, AShorterWindowIsTheBeginningOfTheLongerOne) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const SoundSpacesChoice choice{.source = 0, .target = 1, .speaker = 1, .window_start = 5000};
  const PairSample longer = sampler.sample(data.clips()[0], choice);
  const PairSample shorter = sampler.sample(data.clips()[0], choice, 4000);
  expect_same(shorter.target, window_of(longer.target, 0, 4000));
}

TEST_F(PairSamplerTest, KnowsWherePeopleAreAndWhatIsInSight) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const SoundSpacesClip& clip = data.clips()[0];
  const PairSample sample = sampler.sample(clip, {.source = 1, .target = 2, .speaker = 0});
  // Speaker 0 stands at y = 0.6 m and looks along -y.
  const Vector3 speaker = transform_point(sample.world_from_source, sample.speaker_m);
  EXPECT_NEAR(norm(speaker - Vector3{0.0, 0.6, 1.5}), 0.0, 1e-9);
  const double world_yaw_rad =
      euler_from_quaternion(sample.world_from_source.orientation).yaw_rad + *sample.speaker_yaw_rad;
  EXPECT_NEAR(std::abs(wrap_angle(world_yaw_rad + kPi / 2)), 0.0, 1e-9);
  const Pose world_from_target = sample.world_from_source * sample.source_from_target;
  EXPECT_NEAR(norm(world_from_target.position_m - from_soundspaces(clip.viewpoints[2].location)),
              0.0, 1e-9);
  ASSERT_TRUE(sample.speaker_box.has_value());
  // Boxes are stored in whole pixels of 256.
  EXPECT_NEAR(sample.speaker_box->y_min, 0.25, 1.0 / 256);
  EXPECT_EQ(sample.picture->width(), 64);
  EXPECT_FALSE(
      sampler.sample(clip, {.source = 0, .target = 1, .speaker = 1}).speaker_box.has_value());
}

TEST_F(PairSamplerTest, TruthConvolvesToTheSample) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const SoundSpacesChoice choice{.source = 0, .target = 1, .speaker = 0, .window_start = 700};
  const PairTruth truth = sampler.truth(data.clips()[0], choice);
  const PairSample sample = sampler.sample(data.clips()[0], choice);
  Waveform heard(2, kPairSamples, 16000);
  for (int ear = 0; ear < 2; ++ear) {
    const auto all = convolve(truth.dry.channel(0), truth.target_response.channel(ear));
    std::copy_n(all.begin() + truth.lead, kPairSamples, heard.channel(ear).begin());
  }
  expect_same(sample.target, heard);
  expect_same(sample.dry, window_of(truth.dry, truth.lead, kPairSamples));
}

TEST_F(PairSamplerTest, RelativeDelaysAreTheWaysDifference) {
  const SoundSpacesDataset data = dataset();
  const SoundSpacesClip& clip = data.clips()[0];
  const SoundSpacesChoice choice{.source = 0, .target = 1, .speaker = 0, .window_start = 2000};
  const PairTruth dropped = PairSampler(data, kPlenty).truth(clip, choice);
  const PairTruth relative =
      PairSampler(data, kPlenty, ResponseDelays::relative).truth(clip, choice);
  const Vector3 speaker = clip.speakers[0].location;
  const double farther_m =
      norm(clip.viewpoints[1].location - speaker) - norm(clip.viewpoints[0].location - speaker);
  // The set's responses begin at distance / 343 m/s, in whole samples.
  const std::ptrdiff_t source =
      relative.source_response.samples() - dropped.source_response.samples();
  const std::ptrdiff_t target =
      relative.target_response.samples() - dropped.target_response.samples();
  EXPECT_NEAR(static_cast<double>(target - source), farther_m / 343.0 * 16000.0, 1.0);
  EXPECT_EQ(std::min(source, target), 0);
  EXPECT_GT(std::max(source, target), 0);
}

TEST_F(PairSamplerTest, ANearMicrophoneHearsDrySpeechWhenTheSourceHearsItFirst) {
  const SoundSpacesDataset data = dataset();
  const SoundSpacesClip& clip = data.clips()[0];
  const SoundSpacesChoice choice{.source = 0, .target = 1, .speaker = 0, .window_start = 2000};
  const PairSampler sampler(data, kPlenty, ResponseDelays::dropped, PairTarget::near_microphone);
  const PairSample sample = sampler.sample(clip, choice);
  const PairSample usual = PairSampler(data, kPlenty).sample(clip, choice);
  expect_same(sample.source, usual.source);
  EXPECT_TRUE(std::ranges::equal(sample.target.channel(0), sample.target.channel(1)));
  // Without their delay the set's responses begin with the direct sound.
  const Waveform speech = data.read_speech(*clip.speakers[0].speech);
  const Waveform dry = window_of(speech, 2000, kPairSamples);
  Waveform both(2, kPairSamples, 16000);
  for (int ear = 0; ear < 2; ++ear) std::ranges::copy(dry.channel(0), both.channel(ear).begin());
  expect_same(sample.target, both);
  // The pose says nothing about the microphone; only the truth for oracles does.
  EXPECT_EQ(norm(sample.source_from_target.position_m), 0.0);
  EXPECT_EQ(euler_from_quaternion(sample.source_from_target.orientation).yaw_rad, 0.0);
  EXPECT_EQ(norm(sample.speaker_m - usual.speaker_m), 0.0);
  const PairTruth truth = sampler.truth(clip, choice);
  EXPECT_EQ(truth.dry.samples() - truth.lead, kPairSamples);
  EXPECT_EQ(truth.target_response.samples(), 1);
}

TEST_F(PairSamplerTest, ANearMicrophoneWaitsForASourceThatHearsLater) {
  // 50 samples 30 dB down before the direct sound.
  const SoundSpacesDataset data = dataset();
  const SoundSpacesClip& clip = data.clips()[0];
  Waveform response(2, 2000, 16000);
  for (std::ptrdiff_t i = 0; i < 50; ++i) response.channel(0)[i] = 0.03F;
  response.channel(1)[50] = 1.0F;
  response.channel(0)[60] = 0.5F;
  write_sound(folder_ / clip.viewpoints[0].rir.at(0), response, SampleFormat::float32);
  const PairSampler sampler(data, kPlenty, ResponseDelays::dropped, PairTarget::near_microphone);
  const PairTruth truth = sampler.truth(clip, {.source = 0, .target = 1, .speaker = 0});
  ASSERT_EQ(truth.target_response.samples(), 51);
  EXPECT_EQ(truth.target_response.channel(0)[50], 1.0F);
  EXPECT_EQ(truth.target_response.channel(0)[49], 0.0F);
}

TEST_F(PairSamplerTest, AMirrorSwapsLeftAndRight) {
  const SoundSpacesDataset data = dataset();
  const PairSampler sampler(data, kPlenty);
  const PairSample sample =
      sampler.sample(data.clips()[0], {.source = 1, .target = 2, .speaker = 0});
  const PairSample mirror = mirrored(sample);
  EXPECT_TRUE(std::ranges::equal(mirror.source.channel(0), sample.source.channel(1)));
  EXPECT_TRUE(std::ranges::equal(mirror.target.channel(1), sample.target.channel(0)));
  EXPECT_EQ(mirror.picture->at(0, 20, 1), sample.picture->at(63, 20, 1));
  EXPECT_DOUBLE_EQ(mirror.speaker_box->x_min, 1.0 - sample.speaker_box->x_max);
  const EulerAngles turn = euler_from_quaternion(sample.source_from_target.orientation);
  const EulerAngles mirrored_turn = euler_from_quaternion(mirror.source_from_target.orientation);
  EXPECT_NEAR(mirrored_turn.yaw_rad, -turn.yaw_rad, 1e-12);
  EXPECT_EQ(mirror.speaker_m.y, -sample.speaker_m.y);
  // Seen from the target, the speaker is as far to the other side.
  const auto seen_by_target = [](const PairSample& pair) {
    return transform_point(inverse(pair.source_from_target), pair.speaker_m);
  };
  EXPECT_NEAR(seen_by_target(mirror).y, -seen_by_target(sample).y, 1e-12);
  EXPECT_NEAR(seen_by_target(mirror).x, seen_by_target(sample).x, 1e-12);
}

TEST_F(PairSamplerTest, ManyThreadsAndATinyCacheGetTheSameSamples) {
  const SoundSpacesDataset data = dataset();
  const PairSampler patient(data, kPlenty);
  const PairSampler forgetful(data, 150'000);
  const SoundSpacesChoice choice{.source = 0, .target = 2, .speaker = 1, .window_start = 10};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const SoundSpacesClip& clip = data.clips()[i % 2];
      for (int turn = 0; turn < 5; ++turn) {
        const PairSample one = patient.sample(clip, choice);
        const PairSample two = forgetful.sample(clip, choice);
        EXPECT_TRUE(std::ranges::equal(one.target.planar(), two.target.planar()));
        EXPECT_TRUE(std::ranges::equal(one.picture->pixels(), two.picture->pixels()));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(PairSamplerTest, ErrorsNameTheFile) {
  const SoundSpacesDataset data = dataset();
  const SoundSpacesClip& clip = data.clips()[0];
  const fs::path response = folder_ / "train/room/0/rir_1_0.wav";
  const auto error_after = [&](const std::function<void()>& spoil) {
    spoil();
    try {
      static_cast<void>(
          PairSampler(data, kPlenty).sample(clip, {.source = 1, .target = 2, .speaker = 0}));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto expect_named = [&](const fs::path& path, const std::string& problem,
                                const std::function<void()>& spoil) {
    const std::string kept = read_text_file(path);
    const std::string error = error_after(spoil);
    EXPECT_NE(error.find(path.filename().string()), std::string::npos) << error;
    EXPECT_NE(error.find(problem), std::string::npos) << error;
    write_file(path, kept);
  };
  expect_named(response, "no such file", [&] { fs::remove(response); });
  expect_named(response, "expected 16000 Hz or more, found 8000 Hz",
               [&] { write_sound(response, Waveform(2, 100, 8000)); });
  expect_named(response, "no samples", [&] { write_sound(response, Waveform(2, 0, 16000)); });
  expect_named(response, "expected 2 channels, found 1",
               [&] { write_sound(response, Waveform(1, 100, 16000)); });
  const fs::path picture = folder_ / "train/room/0/view_1.png";
  expect_named(picture, "PNG", [&] { write_file(picture, std::string("no picture")); });
  const fs::path speech = data.speech_path(*clip.speakers[0].speech);
  expect_named(speech, "34 samples", [&] { write_sound(speech, Waveform(1, 20, 16000)); });
  expect_named(response, "finite", [&] {
    // The last sample of a 32-bit float WAV becomes NaN.
    std::string bytes = read_text_file(response);
    bytes.replace(bytes.size() - 4, 4, std::string("\x00\x00\xC0\x7F", 4));
    write_file(response, bytes);
  });
  EXPECT_EQ(error_after([] {}), "no error");
}

TEST_F(PairSamplerTest, AFolderThatIsNoDataSetIsRefused) {
  EXPECT_THROW(soundspaces_options(folder_ / "train", "train"), InputError);
  EXPECT_EQ(read_pair_list(folder_ / "pairs-val.json").pairs.size(), 6U);
}

}  // namespace
}  // namespace earpoint
