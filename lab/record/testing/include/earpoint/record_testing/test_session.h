#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <earpoint/record/device_sound.h>
#include <earpoint/record/session.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/vector3.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// When and where a test session's clapper claps, session time and the session's frame.
inline constexpr double kTestClap_s = 1.5;
inline constexpr Vector3 kTestClapPlace_m{0.3, -0.4, 1.3};

/// A session made by arithmetic alone: cameras in a circle that look at its middle, people who sit
/// or walk and talk in turns in a room of 6 x 6 x 2.7 m with six reflections and a decaying tail.
struct TestSessionOptions {
  int cameras = 8;
  int people = 2;
  double duration_s = 60.0;
  double snr_db = 10.0;  ///< of speech at the cameras
  double most_drift_ppm = 50.0;
  double reverberation_s = 0.3;  ///< of the tail; 0: none
  bool clap = true;
  bool walking = true;
  std::uint64_t seed = 1;
  std::vector<Waveform> voices{};  ///< [1][any] at 16 kHz, one per person; empty: pulses and noise
};

struct TestSession {
  Session session;
  DeviceSounds sounds;
  SessionTruth truth;
};

[[nodiscard]] TestSession make_test_session(const TestSessionOptions& options);

/// Writes session.json, truth.json, a movie per camera and a sound file per person into the folder.
void write_test_session(const std::filesystem::path& folder, TestSession& session);

}  // namespace earpoint
