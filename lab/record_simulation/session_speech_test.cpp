#include "session_test_data.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/fft.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/record_simulation/device_sound.h>
#include <earpoint/record_simulation/session_speech.h>
#include <earpoint/spatial/air_absorption.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;
constexpr SessionSoundQuality kQuick{.rays = 100, .mirror_rays = 200, .response_s = 0.1};

/// A turn of one second of noise that begins at 1 s.
Utterance noise_turn(int person) {
  Utterance turn{.person = person, .begin_s = 1.0, .speech = Waveform(1, kRate_hz, kRate_hz)};
  RandomStream random(7);
  for (float& sample : turn.speech.channel(0)) sample = static_cast<float>(0.1 * random.normal());
  return turn;
}

/// In a nearly anechoic room, from the first person and from the second.
class SessionSpeech : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    room_ = test_room(0.99);
    figures_ = std::make_unique<FigureLibrary>();
    plan_ = plan_of_two(*figures_);
    ears_ = std::make_unique<HrtfSet>(HrtfSet::load(kRate_hz));
    for (int person = 0; person < 2; ++person) {
      plan_.turns = {noise_turn(person)};
      SilentProgress silent;
      heard_.push_back(hear_speech(*room_, plan_, kQuick, *ears_, 1, 1, silent));
    }
  }
  static void TearDownTestSuite() {
    heard_.clear();
    ears_.reset();
    figures_.reset();
    room_.reset();
  }

  static double distance(int person, const Vector3& to) {
    return norm(plan_.people[person].world_from_mouth(0.0).position_m - to);
  }

  static inline std::shared_ptr<const PreparedScene> room_;
  static inline std::unique_ptr<FigureLibrary> figures_;
  static inline std::unique_ptr<HrtfSet> ears_;
  static inline SessionPlan plan_;
  static inline std::vector<SessionSound> heard_;  // by speaker
};

TEST_F(SessionSpeech, ArrivesAfterTheWayFromTheMouth) {
  for (int person = 0; person < 2; ++person) {
    const Utterance turn = noise_turn(person);
    for (int other = 0; other < 2; ++other) {
      Waveform sent(1, heard_[person].microphones[other].samples(), kRate_hz);
      std::ranges::copy(turn.speech.channel(0), sent.channel(0).begin() + kRate_hz);
      const double way_s =
          distance(person, plan_.people[other].microphone_at(0.0)) / speed_of_sound_m_per_s(Air{});
      const double lag = gcc_phat_delay_samples(heard_[person].microphones[other].channel(0),
                                                sent.channel(0), 400.0);
      // To half a sample: band-limited pulses are found to about a tenth. A sample is 2 cm.
      EXPECT_NEAR(lag / kRate_hz, way_s, 0.5 / kRate_hz) << person << " to " << other;
    }
  }
}

TEST_F(SessionSpeech, TheOwnMicrophoneHearsItByTheRatioOfDistances) {
  for (int person = 0; person < 2; ++person) {
    const int other = 1 - person;
    const double near_m = distance(person, plan_.people[person].microphone_at(0.0));
    const double far_m = distance(person, plan_.people[other].microphone_at(0.0));
    const double level_db = 10.0 * std::log10(energy(heard_[person].microphones[person].planar()) /
                                              energy(heard_[person].microphones[other].planar()));
    // The near microphone is 53 degrees below the front, where speech is up to 3 dB weaker than
    // ahead. Air, walls that reflect 1 % and the bodies change the far level by 1 dB.
    EXPECT_NEAR(level_db, 20.0 * std::log10(far_m / near_m), 4.0);
    EXPECT_GT(level_db, 12.0);
  }
}

TEST_F(SessionSpeech, IsHeardFirstByTheEarOnItsSide) {
  for (int person = 0; person < 2; ++person) {
    for (std::size_t camera = 0; camera < 2; ++camera) {
      const Vector3 mouth = transform_point(inverse(plan_.world_from_camera[camera]),
                                            plan_.people[person].world_from_mouth(0.0).position_m);
      const double azimuth_rad = spherical_from_cartesian(mouth).azimuth_rad;
      const Waveform& sound = heard_[person].cameras[camera];
      const double right_later = gcc_phat_delay_samples(sound.channel(1), sound.channel(0), 16.0);
      if (std::abs(azimuth_rad) < 0.05) continue;
      EXPECT_GT(right_later * azimuth_rad, 0.0) << person << " at " << camera;
      // A sphere's delay, 3/2 of which a head has at low frequencies: a (phi + sin phi) / c.
      const double sphere = 0.0875 / 343.2 * (azimuth_rad + std::sin(azimuth_rad)) * kRate_hz;
      EXPECT_NEAR(right_later, sphere, 3.0);
    }
  }
}

TEST_F(SessionSpeech, DoesNotDependOnThreads) {
  plan_.turns = {noise_turn(0), noise_turn(1)};
  SilentProgress silent;
  const SessionSound one = hear_speech(*room_, plan_, kQuick, *ears_, 1, 1, silent);
  const SessionSound two = hear_speech(*room_, plan_, kQuick, *ears_, 1, 2, silent);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(std::ranges::equal(one.cameras[i].planar(), two.cameras[i].planar()));
    EXPECT_TRUE(std::ranges::equal(one.microphones[i].planar(), two.microphones[i].planar()));
  }
}

TEST_F(SessionSpeech, DoesNotClickWhereSomebodyStartsToWalk) {
  // A tone of 300 Hz through two cuts and five traces: anything above 2 kHz would be clicks.
  SessionPlan plan = plan_of_two(*figures_);
  const Stance from = plan.people[0].path.last();
  plan.people[0].path.add({.begin_s = 2.0,
                           .from = from.at,
                           .to = {4.0, 1.5},
                           .yaw_before_rad = from.yaw_rad,
                           .yaw_after_rad = 2.0});
  Utterance turn{.person = 0, .begin_s = 0.5, .speech = Waveform(1, 5 * kRate_hz, kRate_hz)};
  for (std::ptrdiff_t i = 0; i < turn.speech.samples(); ++i) {
    const double time_s = static_cast<double>(i) / kRate_hz;
    const double fade = std::min({1.0, time_s / 0.3, (5.0 - time_s) / 0.3});
    turn.speech.channel(0)[i] = static_cast<float>((0.5 - 0.5 * std::cos(kPi * fade)) *
                                                   std::sin(2.0 * kPi * 300.0 * time_s));
  }
  plan.turns = {turn};
  SilentProgress silent;
  const SessionSound heard = hear_speech(*room_, plan, kQuick, *ears_, 1, 1, silent);
  const auto check = [](std::span<const float> samples, const char* what) {
    RealFft<float> fft(static_cast<int>(samples.size()));
    std::vector<std::complex<float>> spectrum(fft.bins());
    fft.forward(samples, spectrum);
    const auto first_high = static_cast<std::size_t>(2000.0 * fft.size() / kRate_hz);
    double low = 0.0;
    double high = 0.0;
    for (std::size_t bin = 0; bin < spectrum.size(); ++bin) {
      (bin < first_high ? low : high) += std::norm(spectrum[bin]);
    }
    EXPECT_LT(10.0 * std::log10(high / low), -60.0) << what;
  };
  check(heard.cameras[0].channel(0), "camera 1, left");
  check(heard.cameras[0].channel(1), "camera 1, right");
  check(heard.cameras[1].channel(0), "camera 2, left");
  check(heard.microphones[0].channel(0), "own microphone");
  check(heard.microphones[1].channel(0), "other microphone");
}

TEST_F(SessionSpeech, TheClapIsAtItsTimeOnEveryClock) {
  SessionPlan plan = plan_of_two(*figures_);
  const HrtfSet ears = HrtfSet::load(kDeviceRate_hz);
  SessionSound heard;
  heard.cameras.assign(2, Waveform(2, 2 * kDeviceRate_hz, kDeviceRate_hz));
  heard.microphones.assign(2, Waveform(1, 2 * kDeviceRate_hz, kDeviceRate_hz));
  add_clap(*room_, plan, kQuick, ears, 1, heard);
  const double speed = speed_of_sound_m_per_s(Air{});
  for (int person = 0; person < 2; ++person) {
    const DeviceClock clock{.name = "near", .offset_s = 0.1 + 0.2 * person, .drift_ppm = 300.0};
    const Waveform recorded = recorded_by(clock, heard.microphones[person], 1.5);
    const std::span<const float> samples = recorded.channel(0);
    const auto peak =
        std::ranges::max_element(samples, {}, [](float sample) { return std::abs(sample); });
    const double time_s =
        session_time_s(clock, static_cast<double>(peak - samples.begin()) / kDeviceRate_hz);
    const double way_s = norm(plan.people[person].microphone_at(0.0) - plan.clap_m) / speed;
    // Half a sample of rounding, and one more because the pulse lies between two samples.
    EXPECT_NEAR(time_s, plan.clap_s + way_s, 1.5 / kDeviceRate_hz);
  }
}

}  // namespace
}  // namespace earpoint
