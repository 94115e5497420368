#include "test_clip.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/error.h>
#include <earpoint/serve/listener.h>
#include <earpoint/serve/listener_registry.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kPart = 2048;

double level_db(std::span<const float> samples) {
  double sum = 0.0;
  for (const float sample : samples) sum += double{sample} * sample;
  return 10.0 * std::log10(sum / static_cast<double>(samples.size()) + 1e-30);
}

/// A second of the clip, part by part.
Waveform second_from(Listener& listener, std::ptrdiff_t start, const Pose& pose,
                     ListenMethod method) {
  const int rate_hz = bundled_clip().sound.sample_rate_hz();
  const std::ptrdiff_t samples = rate_hz / kPart * kPart;
  Waveform sound(2, samples, rate_hz);
  for (std::ptrdiff_t done = 0; done < samples; done += kPart) {
    const Waveform part = listener.listen(start + done, kPart, pose, method);
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(part.channel(ear), sound.channel(ear).begin() + done);
    }
  }
  return sound;
}

TEST(Listener, HearsTheRecordingItselfByInput) {
  const Waveform& sound = bundled_clip().sound;
  Listener listener(bundled_clip());
  const Waveform part = listener.listen(10000, kPart, {}, ListenMethod::input);
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_TRUE(std::ranges::equal(part.channel(ear), sound.channel(ear).subspan(10000, kPart)));
  }
}

TEST(Listener, HearsTheSpeakerOnTheSideWhereTheyAreAfterTurning) {
  const std::ptrdiff_t start = bundled_clip().sound.sample_rate_hz();
  const Vector3 speaker = bundled_clip().located.speaker.position_m;
  const double azimuth_rad = std::atan2(speaker.y, speaker.x);
  Listener listener(bundled_clip());
  const auto difference_db = [&](double turn_deg) {
    const Pose pose{
        {}, quaternion_from_euler({.yaw_rad = azimuth_rad + radians_from_degrees(turn_deg)})};
    const Waveform heard = second_from(listener, start, pose, ListenMethod::gtf);
    return level_db(heard.channel(0)) - level_db(heard.channel(1));
  };
  // Who turns right has the speaker at the left. How much it is depends on the room; a third of a
  // decibel is beyond rounding and drift.
  EXPECT_GT(difference_db(-70.0), 0.3);
  EXPECT_LT(difference_db(70.0), -0.3);
}

TEST(Listener, HearsPartsThatFollowOneAnotherAsOne) {
  Listener parts(bundled_clip());
  Listener whole(bundled_clip());
  const Pose pose{{0.5, 0.2, 0.0}, {}};
  const std::ptrdiff_t start = 30000;
  const Waveform once = whole.listen(start, 4 * kPart, pose, ListenMethod::gtf);
  for (std::ptrdiff_t done = 0; done < 4 * kPart; done += kPart) {
    const Waveform part = parts.listen(start + done, kPart, pose, ListenMethod::gtf);
    EXPECT_TRUE(std::ranges::equal(part.channel(0), once.channel(0).subspan(done, kPart)));
  }
}

TEST(Listener, FadesBetweenMethods) {
  Listener listener(bundled_clip());
  const Pose pose{{-1.0, 0.0, 0.0}, {}};
  const std::ptrdiff_t start = 48000;
  const Waveform before = listener.listen(start, kPart, pose, ListenMethod::gtf);
  const Waveform fading = listener.listen(start + kPart, kPart, pose, ListenMethod::input);
  const Waveform& sound = bundled_clip().sound;
  // It ends where the recording is, and begins where the rendering was: within a sample's step.
  EXPECT_EQ(fading.channel(0)[kPart - 1], sound.channel(0)[start + 2 * kPart - 1]);
  const float step = std::abs(fading.channel(0)[0] - before.channel(0)[kPart - 1]);
  float usual = 0.0F;
  for (std::ptrdiff_t i = 1; i < kPart; ++i) {
    usual = std::max(usual, std::abs(before.channel(0)[i] - before.channel(0)[i - 1]));
  }
  EXPECT_LE(step, 2.0F * usual);
}

TEST(Listener, HearsSilenceBeyondTheClip) {
  const std::ptrdiff_t end = bundled_clip().sound.samples();
  Listener listener(bundled_clip());
  const Waveform part = listener.listen(end - 10, kPart, {}, ListenMethod::input);
  EXPECT_EQ(level_db(part.channel(0).subspan(10)), level_db(std::vector<float>(kPart - 10)));
}

TEST(Listener, RefusesAPlaceThatIsNoNumber) {
  Listener listener(bundled_clip());
  EXPECT_THROW(
      static_cast<void>(listener.listen(0, kPart, {{std::nan(""), 0, 0}, {}}, ListenMethod::gtf)),
      InputError);
}

TEST(ListenerRegistry, HasRoomForSoMany) {
  ListenerRegistry listeners(bundled_clip(), 2);
  const std::string first = listeners.add();
  const std::string second = listeners.add();
  EXPECT_EQ(first.size(), 32U);
  EXPECT_NE(first, second);
  EXPECT_TRUE(listeners.add().empty());
  EXPECT_NE(listeners.find(first), nullptr);
  EXPECT_EQ(listeners.find("nobody"), nullptr);
}

}  // namespace
}  // namespace earpoint
