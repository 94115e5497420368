#include "test_clip.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render/render_in_memory.h>
#include <earpoint/serve/listener.h>
#include <earpoint/serve/listener_registry.h>
#include <earpoint/serve/walk_export.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kPart = 2048;

double level_db(std::span<const float> samples) {
  double sum = 0.0;
  for (const float sample : samples) sum += double{sample} * sample;
  return 10.0 * std::log10(sum / static_cast<double>(samples.size()) + 1e-30);
}

Listener listener_of(const std::shared_ptr<const ServedClip>& clip) {
  return {clip, bundled_methods()};
}

ListenWish wish(const std::string& method, const Pose& pose = {}) {
  return {.source_from_target = pose, .method = method};
}

/// A second of the clip, part by part.
Waveform second_from(Listener& listener, std::ptrdiff_t start, const ListenWish& what) {
  const int rate_hz = listener.clip().sound.sample_rate_hz();
  const std::ptrdiff_t samples = rate_hz / kPart * kPart;
  Waveform sound(2, samples, rate_hz);
  for (std::ptrdiff_t done = 0; done < samples; done += kPart) {
    const Waveform part = listener.listen(start + done, kPart, what);
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(part.channel(ear), sound.channel(ear).begin() + done);
    }
  }
  return sound;
}

double steepest(std::span<const float> samples) {
  double most = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    most = std::max(most, std::abs(double{samples[i]} - samples[i - 1]));
  }
  return most;
}

TEST(Listener, HearsTheRecordingItselfByInput) {
  const Waveform& sound = bundled_clip()->sound;
  Listener listener = listener_of(bundled_clip());
  const Waveform part = listener.listen(10000, kPart, wish("input"));
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_TRUE(std::ranges::equal(part.channel(ear), sound.channel(ear).subspan(10000, kPart)));
  }
}

TEST(Listener, HearsTheSpeakerOnTheSideWhereTheyAreByEveryMethod) {
  const std::ptrdiff_t start = bundled_clip()->sound.sample_rate_hz();
  const Vector3 speaker = *told_clip()->speaker_m;
  const double azimuth_rad = std::atan2(speaker.y, speaker.x);
  for (const char* method : {"gtf", "dsp"}) {
    Listener listener = listener_of(told_clip());
    const auto difference_db = [&](double turn_deg) {
      const Pose pose{
          {}, quaternion_from_euler({.yaw_rad = azimuth_rad + radians_from_degrees(turn_deg)})};
      const Waveform heard = second_from(listener, start, wish(method, pose));
      return level_db(heard.channel(0)) - level_db(heard.channel(1));
    };
    // After a turn to the right the speaker is at the left. How much louder depends on the room; a
    // third of a decibel is more than rounding and drift.
    EXPECT_GT(difference_db(-70.0), 0.3) << method;
    EXPECT_LT(difference_db(70.0), -0.3) << method;
  }
}

TEST(Listener, HearsPartsThatFollowOneAnotherAsOne) {
  Listener parts = listener_of(bundled_clip());
  Listener whole = listener_of(bundled_clip());
  const ListenWish there = wish("gtf", {{0.5, 0.2, 0.0}, {}});
  const std::ptrdiff_t start = 30000;
  const Waveform once = whole.listen(start, 4 * kPart, there);
  for (std::ptrdiff_t done = 0; done < 4 * kPart; done += kPart) {
    const Waveform part = parts.listen(start + done, kPart, there);
    EXPECT_TRUE(std::ranges::equal(part.channel(0), once.channel(0).subspan(done, kPart)));
  }
}

TEST(Listener, ComesNearToTheWholeRenderingStretchByStretch) {
  // Rendering in stretches gives what rendering the whole clip gives, except at the joints: dsp's
  // filters are the same everywhere, but its windows start elsewhere. -20 dB is a tenth of the
  // amplitude.
  const Pose pose{{0.5, 0.5, 0.0}, {}};
  Listener listener = listener_of(told_clip());
  const std::ptrdiff_t start = 48000;
  const Waveform live = second_from(listener, start, wish("dsp", pose));
  SoundInMemory source;
  source.sound = told_clip()->sound;
  source.picture = told_clip()->picture;
  source.speaker_m = told_clip()->speaker_m;
  const auto dsp = make_synthesizer("dsp", {});
  const Waveform whole = render_in_memory(source, *dsp, EarpointPath(pose), {});
  for (int ear = 0; ear < 2; ++ear) {
    std::vector<float> error(live.channel(ear).begin(), live.channel(ear).end());
    for (std::size_t i = 0; i < error.size(); ++i) error[i] -= whole.channel(ear)[start + i];
    EXPECT_LT(level_db(error), level_db(live.channel(ear)) - 20.0);
  }
}

TEST(Listener, WalksWithoutClicksByEveryMethod) {
  for (const char* method : {"gtf", "dsp", "vigas"}) {
    Listener still = listener_of(told_clip());
    Listener walker = listener_of(told_clip());
    const std::ptrdiff_t start = 48000;
    Waveform walked(2, 10 * kPart, 48000);
    for (int i = 0; i < 10; ++i) {
      const Pose pose{{0.0, i % 2 == 0 ? 1.0 : -1.0, 0.0}, {}};
      const Waveform part = walker.listen(start + i * kPart, kPart, wish(method, pose));
      std::ranges::copy(part.channel(0), walked.channel(0).begin() + i * kPart);
    }
    const Waveform usual = second_from(still, start, wish(method, {{0.0, 1.0, 0.0}, {}}));
    // Moving to and fro over two metres changes the level by a few decibels; a click is a step as
    // large as the sound, several times its usual step from sample to sample.
    EXPECT_LT(steepest(walked.channel(0)), 3.0 * steepest(usual.channel(0))) << method;
  }
}

TEST(Listener, FadesBetweenMethods) {
  Listener listener = listener_of(bundled_clip());
  const Pose pose{{-1.0, 0.0, 0.0}, {}};
  const std::ptrdiff_t start = 48000;
  const Waveform before = listener.listen(start, kPart, wish("gtf", pose));
  const Waveform fading = listener.listen(start + kPart, kPart, wish("input", pose));
  const Waveform& sound = bundled_clip()->sound;
  // It ends on the recording and begins on the rendering, within the step of one sample.
  EXPECT_EQ(fading.channel(0)[kPart - 1], sound.channel(0)[start + 2 * kPart - 1]);
  const float step = std::abs(fading.channel(0)[0] - before.channel(0)[kPart - 1]);
  EXPECT_LE(step, 2.0 * steepest(before.channel(0)));
}

TEST(Listener, HearsTheTruthOfTheNearestKnownPlace) {
  ServedClip clip = *bundled_clip();
  for (const double y : {-1.0, 1.0}) {
    Waveform sound(2, clip.sound.samples(), clip.sound.sample_rate_hz());
    std::ranges::fill(sound.channel(0), static_cast<float>(y) / 4.0F);
    clip.places.push_back({"place", {{0.0, y, 0.0}, {}}, std::move(sound)});
  }
  Listener listener = listener_of(std::make_shared<const ServedClip>(std::move(clip)));
  EXPECT_EQ(listener.listen(0, kPart, wish("truth", {{0, -0.2, 0}, {}})).channel(0)[9], -0.25F);
  const Waveform fading = listener.listen(kPart, kPart, wish("truth", {{0, 0.2, 0}, {}}));
  EXPECT_LT(fading.channel(0)[0], -0.2F);
  EXPECT_EQ(fading.channel(0)[kPart - 1], 0.25F);
}

TEST(Listener, IsAsLoudAsTheRecordingOnRequest) {
  const std::ptrdiff_t start = 48000;
  ListenWish far = wish("gtf", {{-4.0, 0.0, 0.0}, {}});
  const auto louder_ear_db = [&] {
    Listener listener = listener_of(told_clip());
    const Waveform heard = second_from(listener, start, far);
    const Waveform recorded = second_from(listener, start, wish("input"));
    return level_db(heard.channel(0)) - level_db(recorded.channel(0));
  };
  const double without_db = louder_ear_db();
  far.matches_level = true;
  // Ears differ a little in level, and the first part is matched on its own: 3 dB.
  EXPECT_NEAR(louder_ear_db(), 0.0, 3.0);
  EXPECT_LT(without_db, -3.0);
}

TEST(Listener, HearsSilenceBeyondTheClip) {
  const std::ptrdiff_t end = bundled_clip()->sound.samples();
  Listener listener = listener_of(bundled_clip());
  const Waveform part = listener.listen(end - 10, kPart, wish("input"));
  EXPECT_EQ(level_db(part.channel(0).subspan(10)), level_db(std::vector<float>(kPart - 10)));
}

TEST(Listener, RefusesWhatItCannotRender) {
  Listener listener = listener_of(bundled_clip());
  const auto hear = [&](const ListenWish& what) {
    static_cast<void>(listener.listen(0, kPart, what));
  };
  EXPECT_THROW(hear(wish("gtf", {{std::nan(""), 0, 0}, {}})), InputError);
  EXPECT_THROW(hear(wish("magic")), InputError);
  EXPECT_THROW(hear(wish("truth")), InputError);
  EXPECT_THROW(hear(wish("dsp")), InputError);  // the speaker's position is not given
}

TEST(ListenMethods, AreNamedOnceAndFound) {
  const auto methods = [](const std::vector<std::string>& words) {
    return static_cast<void>(listen_methods(words));
  };
  EXPECT_THROW(methods({"input", "input"}), InputError);
  EXPECT_THROW(methods({"magic"}), InputError);
  EXPECT_THROW(methods({"mine=missing.safetensors"}), InputError);
  EXPECT_THROW(methods({"truth=" EARPOINT_SOURCE_DIR "/models/gtf.safetensors"}), InputError);
  EXPECT_THROW(methods({"rt60=" EARPOINT_SOURCE_DIR "/models/rt60.safetensors"}), InputError);
  EXPECT_THROW(methods({}), InputError);
}

TEST(WalkExport, RefusesWalksThatDoNotCoverTheClip) {
  const std::string head = "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n";
  const std::filesystem::path output = testing::TempDir() + "walk.wav";
  for (const std::string& walk :
       {std::string("nonsense"), head, head + "0,0,0,0,0,0,0\n1,0,0,0,0,0,0\n"}) {
    EXPECT_THROW(export_walk(*told_clip(), bundled_methods()[0], walk, output), InputError) << walk;
    EXPECT_FALSE(std::filesystem::exists(output));
  }
}

TEST(ListenerRegistry, HasRoomForSoMany) {
  ListenerRegistry listeners(bundled_methods(), 2);
  const std::string first = listeners.add(bundled_clip());
  const std::string second = listeners.add(bundled_clip());
  EXPECT_EQ(first.size(), 32U);
  EXPECT_NE(first, second);
  EXPECT_TRUE(listeners.add(bundled_clip()).empty());
  EXPECT_NE(listeners.find(first), nullptr);
  EXPECT_EQ(listeners.find("nobody"), nullptr);
  listeners.remove(first);
  EXPECT_FALSE(listeners.add(bundled_clip()).empty());
}

}  // namespace
}  // namespace earpoint
