#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/plot/draw.h>
#include <earpoint/record_testing/test_session.h>
#include <earpoint/spatial/rigid_sphere.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr double kRate = kSyncRateHz;
constexpr double kSpeedOfSound_m_per_s = 343.0;
constexpr double kRoom_m = 3.0;  // half of its length and width
constexpr double kHeight_m = 2.7;
constexpr double kReflection = 0.75;
constexpr double kNear_m = 0.2;
constexpr double kPause_s = 0.25;
constexpr double kSpeechRms = 0.02;  // 1 m away

double triangle(double phase) { return std::abs(std::fmod(phase, 2.0) - 1.0); }

/// Position of a person's mouth: on a circle around the middle, some walking to and fro.
Vector3 mouth_at(int person, int people, bool walking, double time_s) {
  const double angle = 2.0 * kPi * (person + 0.3) / people;
  const Vector3 seat{1.1 * std::cos(angle), 1.1 * std::sin(angle), person % 2 == 0 ? 1.2 : 1.55};
  if (!walking || person % 2 == 0) {
    return seat + Vector3{0.03 * std::sin(1.1 * time_s + person), 0.03 * std::sin(0.7 * time_s), 0};
  }
  // Stands for 6 s, walks for 4 s at about 0.4 m/s.
  const double along = std::clamp((triangle(time_s / 10.0) - 0.3) / 0.4, 0.0, 1.0);
  return seat + Vector3{-std::sin(angle), std::cos(angle), 0} * (1.6 * (along - 0.5));
}

/// Values between samples, by a sinc of 16 taps under a Hann window.
class Interpolator {
 public:
  Interpolator() {
    for (int phase = 0; phase <= kPhases; ++phase) {
      for (int tap = 0; tap < kTaps; ++tap) {
        const double t = tap - (kTaps / 2.0 - 1.0) - static_cast<double>(phase) / kPhases;
        const double sinc = t == 0.0 ? 1.0 : std::sin(kPi * t) / (kPi * t);
        const double window = 0.5 + 0.5 * std::cos(kPi * t / (kTaps / 2.0));
        table_[phase][tap] = static_cast<float>(sinc * window);
      }
    }
  }

  [[nodiscard]] float at(const std::vector<float>& x, double position) const {
    const double whole = std::floor(position);
    const auto first = static_cast<std::ptrdiff_t>(whole) - (kTaps / 2 - 1);
    if (first < 0 || first + kTaps > std::ssize(x)) return 0.0F;
    const auto& taps = table_[std::lround((position - whole) * kPhases)];
    float sum = 0.0F;
    for (int tap = 0; tap < kTaps; ++tap) sum += taps[tap] * x[first + tap];
    return sum;
  }

 private:
  static constexpr int kTaps = 16;
  static constexpr int kPhases = 256;
  std::array<std::array<float, kTaps>, kPhases + 1> table_{};
};

/// Pulses of a voice's pitch and noise, in syllables of uneven length.
std::vector<float> make_voice(double duration_s, RandomStream& random, double pitch_hz) {
  std::vector<float> voice(static_cast<std::size_t>(duration_s * kRate));
  double phase = 0.0;
  double low = 0.0;
  double band = 0.0;
  double begin_s = 0.0;  // of the syllable
  double end_s = 0.0;
  for (std::size_t n = 0; n < voice.size(); ++n) {
    const double t = static_cast<double>(n) / kRate;
    if (t >= end_s) {
      begin_s = t + random.uniform(0.0, 0.12);
      end_s = begin_s + random.uniform(0.08, 0.3);
    }
    // A fast rise and a slow fall.
    const double within = (t - begin_s) / (end_s - begin_s);
    const double syllable = within < 0.0 ? 0.0 : std::min(8.0 * within, 1.2 * (1.0 - within));
    phase += pitch_hz * (1.0 + 0.15 * std::sin(2.1 * t)) / kRate;
    double excitation = 0.15 * random.normal();
    if (phase >= 1.0) {
      phase -= 1.0;
      excitation += 6.0;
    }
    // A resonance that moves, as in vowels.
    const double f = 2.0 * std::sin(kPi * (900.0 + 500.0 * std::sin(5.0 * t)) / kRate);
    low += f * band;
    band += f * (excitation - low - 0.3 * band);
    voice[n] = static_cast<float>(syllable * (band + 0.3 * excitation));
  }
  return voice;
}

void scale_to_rms(std::vector<float>& x, double rms) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const float v : x) {
    if (v == 0.0F) continue;
    sum += static_cast<double>(v) * v;
    ++count;
  }
  if (count == 0) return;
  const auto gain = static_cast<float>(rms / std::sqrt(sum / static_cast<double>(count)));
  for (float& v : x) v *= gain;
}

/// The speech of each person, who talk in turns, with zeros while others speak; adds the intervals
/// to the truth.
std::vector<std::vector<float>> talk_in_turns(const TestSessionOptions& options,
                                              RandomStream& random, SessionTruth& truth) {
  std::vector<std::vector<float>> spoken(
      options.people, std::vector<float>(static_cast<std::size_t>(options.duration_s * kRate)));
  for (int p = 0; p < options.people; ++p) {
    std::vector<float> voice;
    if (options.voices.empty()) {
      voice = make_voice(options.duration_s, random, 110.0 + 70.0 * p);
    } else {
      const auto given = options.voices[p].channel(0);
      voice.resize(spoken[p].size());
      for (std::size_t n = 0; n < voice.size(); ++n) voice[n] = given[n % given.size()];
    }
    scale_to_rms(voice, kSpeechRms);
    spoken[p] = std::move(voice);
  }
  std::vector<std::vector<float>> gates(spoken.size(), std::vector<float>(spoken[0].size()));
  double time_s = 3.0;
  for (int turn = 0; time_s < options.duration_s - 1.0; ++turn) {
    const int p = turn % options.people;
    const double end_s = std::min(time_s + random.uniform(2.0, 5.0), options.duration_s);
    truth.people[p].speech.push_back({time_s, end_s});
    for (auto n = static_cast<std::size_t>(time_s * kRate);
         n < static_cast<std::size_t>(end_s * kRate); ++n) {
      gates[p][n] = 1.0F;
    }
    // Every fourth time the next turn begins before this one has ended.
    time_s = turn % 4 == 3 ? end_s - 0.5 : end_s + kPause_s;
  }
  for (std::size_t p = 0; p < spoken.size(); ++p) {
    for (std::size_t n = 0; n < spoken[p].size(); ++n) spoken[p][n] *= gates[p][n];
  }
  return spoken;
}

/// The direct sound and six mirror images of a source.
std::array<Vector3, 7> images_of(const Vector3& s) {
  return {s,
          {2 * kRoom_m - s.x, s.y, s.z},
          {-2 * kRoom_m - s.x, s.y, s.z},
          {s.x, 2 * kRoom_m - s.y, s.z},
          {s.x, -2 * kRoom_m - s.y, s.z},
          {s.x, s.y, 2 * kHeight_m - s.z},
          {s.x, s.y, -s.z}};
}

/// Delay and gain of a path to an ear.
struct Path {
  double delay_s = 0.0;
  double gain = 0.0;
};

Path path_to_ear(const Vector3& source, const Pose& head, int ear) {
  const Vector3 to = source - head.position_m;
  const double distance = norm(to);
  const double left = dot(to, rotate(head.orientation, {0, 1, 0})) / distance;
  const double side = ear == 0 ? left : -left;
  return {distance / kSpeedOfSound_m_per_s + rigid_sphere_delays_s(distance, left)[ear],
          (1.0 + 0.4 * side) / std::max(distance, 0.1)};
}

class Renderer {
 public:
  Renderer(const TestSessionOptions& options, RandomStream& random, SessionTruth& truth)
      : options_(options), spoken_(talk_in_turns(options, random, truth)) {
    clap_.resize(static_cast<std::size_t>(0.2 * kRate));
    for (std::size_t n = 0; n < clap_.size(); ++n) {
      const double fade = std::exp(-static_cast<double>(n) / (0.004 * kRate));
      clap_[n] = static_cast<float>(0.8 * fade * random.normal());
    }
    clap_.insert(clap_.begin(), 16, 0.0F);
  }

  /// The sound at an ear of a camera, on its clock.
  std::vector<float> camera(const DeviceClock& clock, std::size_t samples, const Pose& head,
                            int ear, RandomStream& random) const {
    std::vector<float> sound(samples);
    for (int p = 0; p < options_.people; ++p) {
      add(
          sound, clock, spoken_[p], 0.0,
          [&](double t, std::size_t image) {
            const Vector3 mouth = mouth_at(p, options_.people, options_.walking, t);
            Path path = path_to_ear(images_of(mouth)[image], head, ear);
            if (image > 0) path.gain *= kReflection;
            return path;
          },
          7);
    }
    if (options_.clap) {
      add(
          sound, clock, clap_, kTestClap_s - 16 / kRate,
          [&](double, std::size_t) { return path_to_ear(kTestClapPlace_m, head, ear); }, 1);
    }
    add_tail(sound, random);
    add_noise(sound, kSpeechRms / 2.5 * std::pow(10.0, -options_.snr_db / 20.0), random);
    return sound;
  }

  /// The sound at a near microphone: its wearer, and the others from their positions.
  std::vector<float> microphone(const DeviceClock& clock, std::size_t samples, int wearer,
                                RandomStream& random) const {
    std::vector<float> sound(samples);
    const auto place = [&](int person, double t) {
      return mouth_at(person, options_.people, options_.walking, t);
    };
    for (int p = 0; p < options_.people; ++p) {
      add(
          sound, clock, spoken_[p], 0.0,
          [&](double t, std::size_t) {
            const double distance = p == wearer ? kNear_m : norm(place(p, t) - place(wearer, t));
            return Path{distance / kSpeedOfSound_m_per_s, 0.3 / distance};
          },
          1);
    }
    if (options_.clap) {
      add(
          sound, clock, clap_, kTestClap_s - 16 / kRate,
          [&](double t, std::size_t) {
            const double distance = norm(kTestClapPlace_m - place(wearer, t));
            return Path{distance / kSpeedOfSound_m_per_s, 0.3 / distance};
          },
          1);
    }
    add_noise(sound, 0.3 * kSpeechRms / kNear_m * std::pow(10.0, -25.0 / 20.0), random);
    return sound;
  }

 private:
  /// Adds a sound that begins at `begin_s` by paths that change with time.
  template <typename PathAt>
  void add(std::vector<float>& sound, const DeviceClock& clock, const std::vector<float>& dry,
           double begin_s, const PathAt& path_at, std::size_t images) const {
    constexpr std::size_t kBlock = 160;
    for (std::size_t block = 0; block < sound.size(); block += kBlock) {
      const std::size_t end = std::min(block + kBlock, sound.size());
      const double first_s = session_time_s(clock, static_cast<double>(block) / kRate);
      const double last_s = session_time_s(clock, static_cast<double>(end) / kRate);
      if (last_s < begin_s || is_silent(dry, first_s - begin_s - 0.1, last_s - begin_s)) continue;
      for (std::size_t image = 0; image < images; ++image) {
        const Path from = path_at(first_s, image);
        const Path to = path_at(last_s, image);
        const auto length = static_cast<double>(end - block);
        for (std::size_t n = block; n < end; ++n) {
          const double fraction = static_cast<double>(n - block) / length;
          const double t = first_s + fraction * (last_s - first_s);
          const double delay = from.delay_s + fraction * (to.delay_s - from.delay_s);
          const double gain = from.gain + fraction * (to.gain - from.gain);
          sound[n] +=
              static_cast<float>(gain) * interpolator_.at(dry, (t - delay - begin_s) * kRate);
        }
      }
    }
  }

  static bool is_silent(const std::vector<float>& dry, double from_s, double to_s) {
    const auto size = static_cast<double>(dry.size());
    const auto first = static_cast<std::size_t>(std::clamp(from_s * kRate - 16, 0.0, size));
    const auto last = static_cast<std::size_t>(std::clamp(to_s * kRate + 16, 0.0, size));
    return std::all_of(dry.begin() + first, dry.begin() + last, [](float x) { return x == 0.0F; });
  }

  void add_tail(std::vector<float>& sound, RandomStream& random) const {
    if (options_.reverberation_s <= 0.0) return;
    std::vector<float> tail(static_cast<std::size_t>(options_.reverberation_s * kRate));
    for (std::size_t n = 480; n < tail.size(); ++n) {  // after 30 ms
      const double decay =
          std::pow(10.0, -3.0 * static_cast<double>(n) / static_cast<double>(tail.size()));
      tail[n] = static_cast<float>(0.03 * decay * random.normal());
    }
    const std::vector<float> late = convolve(sound, tail);
    for (std::size_t n = 0; n < sound.size(); ++n) sound[n] += late[n];
  }

  static void add_noise(std::vector<float>& sound, double rms, RandomStream& random) {
    for (float& x : sound) x += static_cast<float>(rms * random.normal());
  }

  const TestSessionOptions& options_;
  Interpolator interpolator_;
  std::vector<std::vector<float>> spoken_;
  std::vector<float> clap_;
};

DeviceClock draw_clock(const std::string& name, const TestSessionOptions& options,
                       RandomStream& random) {
  return {name, random.uniform(-4.0, -1.0),
          random.uniform(-options.most_drift_ppm, options.most_drift_ppm)};
}

void describe(const TestSessionOptions& options, RandomStream& random, TestSession& made) {
  for (int c = 0; c < options.cameras; ++c) {
    const double angle = 2.0 * kPi * c / options.cameras;
    const Vector3 place{2.6 * std::cos(angle), 2.4 * std::sin(angle), 1.4 + 0.1 * (c % 3)};
    const std::string name = fmt::format("{}", c + 1);
    made.session.cameras.push_back({.name = name,
                                    .video = name + ".mp4",
                                    .lens = Lens{64, 36, 40, 40, 32, 18, {}},
                                    .world_from_camera = look_at(place, {0, 0, 1.2})});
    made.truth.cameras.push_back(draw_clock(name, options, random));
  }
  for (int p = 0; p < options.people; ++p) {
    const std::string name = fmt::format("person-{}", p + 1);
    made.session.people.push_back({name, name + ".wav", kNear_m});
    made.truth.microphones.push_back(draw_clock(name, options, random));
    PersonTruth& person = made.truth.people.emplace_back();
    person.name = name;
    for (double t = 0.0; t < options.duration_s; t += 0.1) {
      person.track.push_back({t, mouth_at(p, options.people, options.walking, t), 0.0});
    }
  }
}

}  // namespace

TestSession make_test_session(const TestSessionOptions& options) {
  RandomStream random(options.seed);
  TestSession made;
  made.session.scene = "SC-1";
  describe(options, random, made);
  const Renderer renderer(options, random, made.truth);
  for (int c = 0; c < options.cameras; ++c) {
    const DeviceClock& clock = made.truth.cameras[c];
    const auto samples =
        static_cast<std::size_t>(device_time_s(clock, options.duration_s + 0.2) * kRate);
    const Pose& head = *made.session.cameras[c].world_from_camera;
    Waveform sound(2, static_cast<std::ptrdiff_t>(samples), kSyncRateHz);
    for (int ear = 0; ear < 2; ++ear) {
      RandomStream own(options.seed, {static_cast<std::uint64_t>(2 * c + ear), 1});
      std::ranges::copy(renderer.camera(clock, samples, head, ear, own),
                        sound.channel(ear).begin());
    }
    made.sounds.devices.push_back({clock.name, true, head, 0.0, std::move(sound)});
  }
  for (int p = 0; p < options.people; ++p) {
    const DeviceClock& clock = made.truth.microphones[p];
    const auto samples =
        static_cast<std::size_t>(device_time_s(clock, options.duration_s + 0.2) * kRate);
    RandomStream own(options.seed, {static_cast<std::uint64_t>(p), 2});
    Waveform sound(1, static_cast<std::ptrdiff_t>(samples), kSyncRateHz);
    std::ranges::copy(renderer.microphone(clock, samples, p, own), sound.channel(0).begin());
    made.sounds.devices.push_back({clock.name, false, std::nullopt, kNear_m, std::move(sound)});
  }
  return made;
}

void write_test_session(const fs::path& folder, TestSession& made) {
  constexpr double kFrameRate_hz = 5.0;
  fs::create_directories(folder);
  made.session.file = folder / "session.json";
  std::size_t device = 0;
  for (SessionCamera& camera : made.session.cameras) {
    camera.video = folder / (camera.name + ".mp4");
    const Waveform& sound = made.sounds.devices[device].sound;
    MovieWriter writer(camera.video, 64, 36, kFrameRate_hz, kSyncRateHz);
    writer.write_sound(sound);
    // Each camera has a colour of its own, brighter with time.
    for (int frame = 0; frame < sound.duration_s() * kFrameRate_hz; ++frame) {
      const auto bright = static_cast<std::uint8_t>(40 + 3 * (frame % 70));
      writer.write_picture(
          filled_image(64, 36, {bright, static_cast<std::uint8_t>(25 * (device + 1)), 90}));
    }
    writer.close();
    ++device;
  }
  for (SessionPerson& person : made.session.people) {
    person.near = folder / (person.name + ".wav");
    write_sound(person.near, made.sounds.devices[device++].sound, SampleFormat::float32);
  }
  write_session(made.session.file, made.session);
  write_session_truth(folder / "truth.json", made.truth);
}

}  // namespace earpoint
