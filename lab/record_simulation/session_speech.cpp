#include <earpoint/record_simulation/session_speech.h>

#include "turn_pieces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include <earpoint/audio/convolution.h>
#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/trace/moving_sound.h>

namespace earpoint {
namespace {

/// The sound of one turn at one device.
struct HeardPart {
  int device = 0;  ///< cameras, then microphones
  std::ptrdiff_t begin = 0;
  Waveform sound;
};

/// Where the devices of a session are over time.
class Devices {
 public:
  explicit Devices(const SessionPlan& plan) : plan_(plan) {}

  [[nodiscard]] int cameras() const { return static_cast<int>(plan_.world_from_camera.size()); }
  [[nodiscard]] int count() const { return cameras() + static_cast<int>(plan_.people.size()); }
  [[nodiscard]] bool is_camera(int device) const { return device < cameras(); }

  [[nodiscard]] Pose pose(int device, double time_s) const {
    if (is_camera(device)) return plan_.world_from_camera[device];
    return {plan_.people[device - cameras()].microphone_at(time_s), {}};
  }

 private:
  const SessionPlan& plan_;
};

void add(const Waveform& part, std::ptrdiff_t begin, Waveform& sum) {
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -begin);
  const std::ptrdiff_t last = std::min(part.samples(), sum.samples() - begin);
  for (int c = 0; c < sum.channels(); ++c) {
    for (std::ptrdiff_t i = first; i < last; ++i) {
      sum.channel(c)[begin + i] += part.channel(c)[i];
    }
  }
}

/// Renders turns at devices; const calls may come from many threads.
class TurnListener {
 public:
  TurnListener(const PreparedScene& scene, const SessionPlan& plan,
               const SessionSoundQuality& quality, const HrtfSet& hrtf, std::uint64_t seed)
      : scene_(scene), plan_(plan), quality_(quality), hrtf_(hrtf), seed_(seed), devices_(plan) {}

  [[nodiscard]] std::vector<HeardPart> hear(std::size_t turn_index) const {
    const Utterance& turn = plan_.turns[turn_index];
    EARPOINT_CHECK(turn.speech.sample_rate_hz() == hrtf_.sample_rate_hz());
    std::vector<HeardPart> parts;
    for (const auto& [pieces, devices] : listeners_of(turn)) {
      for (const TurnPiece& piece : pieces) {
        if (piece.moves) {
          hear_moving(turn_index, piece, devices, parts);
        } else {
          hear_still(turn_index, piece, devices, parts);
        }
      }
    }
    return parts;
  }

 private:
  /// Devices for which the speech is cut at the same times: one trace serves all.
  struct Listeners {
    std::vector<TurnPiece> pieces;
    std::vector<int> devices;
  };

  [[nodiscard]] std::vector<Listeners> listeners_of(const Utterance& turn) const {
    const std::vector<Span> speaker_moves = plan_.people[turn.person].path.moving();
    std::vector<Listeners> groups = {{cut_turn(turn.speech, turn.begin_s, speaker_moves), {}}};
    for (int device = 0; device < devices_.count(); ++device) {
      const int wearer = device - devices_.cameras();
      if (devices_.is_camera(device) || wearer == turn.person) {
        groups.front().devices.push_back(device);
        continue;
      }
      std::vector<Span> moves = plan_.people[wearer].path.moving();
      moves.insert(moves.end(), speaker_moves.begin(), speaker_moves.end());
      std::vector<TurnPiece> pieces = cut_turn(turn.speech, turn.begin_s, std::move(moves));
      const auto same = std::ranges::find_if(groups, [&](const Listeners& group) {
        return std::ranges::equal(group.pieces, pieces, [](const TurnPiece& a, const TurnPiece& b) {
          return a.begin_s == b.begin_s && a.moves == b.moves;
        });
      });
      if (same != groups.end()) {
        same->devices.push_back(device);
      } else {
        groups.push_back({std::move(pieces), {device}});
      }
    }
    return groups;
  }

  // Noise in the late field must not repeat in another ear or turn, or a network could learn it.
  [[nodiscard]] RenderOptions render_options(std::size_t turn, int device) const {
    const auto noise = RandomStream(seed_, {turn, static_cast<std::uint64_t>(device)}).next();
    return {
        .sample_rate_hz = hrtf_.sample_rate_hz(), .duration_s = quality_.response_s, .seed = noise};
  }

  [[nodiscard]] std::vector<PointResponse> trace_at(std::size_t turn_index, double time_s,
                                                    const std::vector<int>& devices) const {
    const int person = plan_.turns[turn_index].person;
    const PeopledScene peopled = scene_with_people(scene_.scene, plan_, time_s);
    Source mouth;
    mouth.world_from_source = plan_.people[person].world_from_mouth(time_s);
    mouth.directivity = speech_directivity();
    mouth.body = peopled.people[person].instance;
    std::vector<Vector3> listeners;
    listeners.reserve(devices.size());
    for (const int device : devices) listeners.push_back(devices_.pose(device, time_s).position_m);
    ThreadPool pool(1);
    TraceResult traced = trace(AcousticScene(peopled.scene), {&mouth, 1}, listeners,
                               {.rays = quality_.rays,
                                .mirror_rays = quality_.mirror_rays,
                                .duration_s = quality_.response_s,
                                .seed = seed_ + turn_index},
                               pool);
    return std::move(traced.responses[0]);
  }

  void hear_still(std::size_t turn_index, const TurnPiece& piece, const std::vector<int>& devices,
                  std::vector<HeardPart>& parts) const {
    const double middle_s =
        piece.begin_s + 0.5 * static_cast<double>(piece.speech.size()) / hrtf_.sample_rate_hz();
    const std::vector<PointResponse> responses = trace_at(turn_index, middle_s, devices);
    for (std::size_t i = 0; i < devices.size(); ++i) {
      const ResponseSynthesizer synthesizer(render_options(turn_index, devices[i]));
      const Waveform response =
          devices_.is_camera(devices[i])
              ? synthesizer.binaural(responses[i], devices_.pose(devices[i], 0.0).orientation,
                                     hrtf_, 0)
              : synthesizer.mono(responses[i], 0);
      HeardPart& part = parts.emplace_back();
      part.device = devices[i];
      part.begin = sample_of(piece.begin_s);
      part.sound = Waveform(response.channels(), std::ssize(piece.speech) + response.samples() - 1,
                            response.sample_rate_hz());
      for (int c = 0; c < response.channels(); ++c) {
        std::ranges::copy(convolve(piece.speech, response.channel(c)),
                          part.sound.channel(c).begin());
      }
    }
  }

  void hear_moving(std::size_t turn_index, const TurnPiece& piece, const std::vector<int>& devices,
                   std::vector<HeardPart>& parts) const {
    const SessionFigure& speaker = plan_.people[plan_.turns[turn_index].person];
    const double begin_s = piece.begin_s;
    std::vector<MovingSound> sounds;
    for (const int device : devices) {
      Microphone microphone;
      if (devices_.is_camera(device)) microphone.ears = hrtf_;
      sounds.emplace_back(piece.speech,
                          Motion{.world_from_source =
                                     [&speaker, begin_s](double time_s) {
                                       return speaker.world_from_mouth(begin_s + time_s);
                                     },
                                 .world_from_listener =
                                     [this, device, begin_s](double time_s) {
                                       return devices_.pose(device, begin_s + time_s);
                                     },
                                 .step_s = quality_.step_s},
                          render_options(turn_index, device), Air{}, std::move(microphone));
    }
    std::vector<PointResponse> responses;
    std::vector<Pose> before;
    for (int step = 0; step < sounds.front().steps(); ++step) {
      const double time_s = begin_s + step * quality_.step_s;
      std::vector<Pose> now = {speaker.world_from_mouth(time_s)};
      for (const int device : devices) now.push_back(devices_.pose(device, time_s));
      if (now != before) responses = trace_at(turn_index, time_s, devices);
      before = std::move(now);
      for (std::size_t i = 0; i < devices.size(); ++i) sounds[i].add(step, responses[i]);
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
      parts.push_back(
          {.device = devices[i], .begin = sample_of(begin_s), .sound = sounds[i].take()});
    }
  }

  [[nodiscard]] std::ptrdiff_t sample_of(double time_s) const {
    return std::lround(time_s * hrtf_.sample_rate_hz());
  }

  const PreparedScene& scene_;
  const SessionPlan& plan_;
  const SessionSoundQuality& quality_;
  const HrtfSet& hrtf_;
  std::uint64_t seed_;
  Devices devices_;
};

SessionSound silence(const SessionPlan& plan, int rate_hz) {
  const auto samples = static_cast<std::ptrdiff_t>(std::ceil(plan.duration_s * rate_hz));
  SessionSound sound;
  sound.cameras.assign(plan.world_from_camera.size(), Waveform(2, samples, rate_hz));
  sound.microphones.assign(plan.people.size(), Waveform(1, samples, rate_hz));
  return sound;
}

Waveform& device_of(SessionSound& sound, int device) {
  const auto cameras = static_cast<int>(sound.cameras.size());
  return device < cameras ? sound.cameras[device] : sound.microphones[device - cameras];
}

/// Two boards that meet: a burst of noise that starts within a sample and dies away within
/// milliseconds, with a peak well above those of speech.
std::vector<float> dry_clap(int rate_hz, std::uint64_t seed) {
  constexpr double kLength_s = 0.08;
  constexpr double kDecay_s = 0.008;
  constexpr float kPeak = 2.5F;  // speech has peaks of up to 0.9, most much lower
  RandomStream random(seed);
  std::vector<float> clap(static_cast<std::size_t>(kLength_s * rate_hz));
  float peak = 0.0F;
  for (std::size_t i = 0; i < clap.size(); ++i) {
    const double since_s = static_cast<double>(i) / rate_hz;
    // The first sample is the loudest: the onset is where the truth says.
    const double value = i == 0 ? 6.0 : std::clamp(random.normal(), -2.5, 2.5);
    clap[i] = static_cast<float>(value * std::exp(-since_s / kDecay_s));
    peak = std::max(peak, std::abs(clap[i]));
  }
  for (float& sample : clap) sample *= kPeak / peak;
  return clap;
}

}  // namespace

PeopledScene scene_with_people(const Scene& scene, const SessionPlan& plan, double time_s) {
  PeopledScene peopled{.scene = scene, .people = {}};
  for (const SessionFigure& person : plan.people) {
    const Stance stance = person.path.at(time_s);
    peopled.people.push_back(
        add_person(*person.figure, stance.at.x, stance.at.y, stance.yaw_rad, peopled.scene));
  }
  return peopled;
}

SessionSound hear_speech(const PreparedScene& scene, const SessionPlan& plan,
                         const SessionSoundQuality& quality, const HrtfSet& hrtf,
                         std::uint64_t seed, int jobs, ProgressSink& progress) {
  SessionSound sound = silence(plan, hrtf.sample_rate_hz());
  const TurnListener listener(scene, plan, quality, hrtf, seed);
  ThreadPool pool(jobs);
  progress.begin("tracing speech", static_cast<double>(plan.turns.size()), "turns");
  // All threads render a few turns, which are then added in order, so that sums do not depend on
  // timing.
  const auto together = 2 * static_cast<std::size_t>(jobs);
  for (std::size_t first = 0; first < plan.turns.size(); first += together) {
    const std::size_t count = std::min(together, plan.turns.size() - first);
    std::vector<std::vector<HeardPart>> heard(count);
    pool.run(static_cast<std::ptrdiff_t>(count), [&](std::ptrdiff_t task, int) {
      heard[task] = listener.hear(first + task);
      progress.advance(1.0);
    });
    for (const std::vector<HeardPart>& parts : heard) {
      for (const HeardPart& part : parts)
        add(part.sound, part.begin, device_of(sound, part.device));
    }
  }
  progress.finish();
  return sound;
}

void add_clap(const PreparedScene& scene, const SessionPlan& plan,
              const SessionSoundQuality& quality, const HrtfSet& hrtf, std::uint64_t seed,
              SessionSound& sound) {
  const int rate_hz = hrtf.sample_rate_hz();
  const Devices devices(plan);
  const PeopledScene peopled = scene_with_people(scene.scene, plan, plan.clap_s);
  std::vector<Vector3> listeners;
  listeners.reserve(static_cast<std::size_t>(devices.count()));
  for (int device = 0; device < devices.count(); ++device) {
    listeners.push_back(devices.pose(device, plan.clap_s).position_m);
  }
  const Source clapper{.world_from_source = {plan.clap_m, {}}};
  ThreadPool pool(1);
  const TraceResult traced = trace(AcousticScene(peopled.scene), {&clapper, 1}, listeners,
                                   {.rays = quality.rays,
                                    .mirror_rays = quality.mirror_rays,
                                    .duration_s = quality.response_s,
                                    .seed = seed},
                                   pool);
  const ResponseSynthesizer synthesizer(
      {.sample_rate_hz = rate_hz, .duration_s = quality.response_s, .seed = seed});
  const std::vector<float> clap = dry_clap(rate_hz, seed);
  for (int device = 0; device < devices.count(); ++device) {
    const PointResponse& response = traced.responses[0][device];
    const auto stream = static_cast<std::uint64_t>(device);
    const Waveform taps =
        devices.is_camera(device)
            ? synthesizer.binaural(response, devices.pose(device, 0.0).orientation, hrtf, stream)
            : synthesizer.mono(response, stream);
    Waveform part(taps.channels(), std::ssize(clap) + taps.samples() - 1, rate_hz);
    for (int c = 0; c < taps.channels(); ++c) {
      std::ranges::copy(convolve(clap, taps.channel(c)), part.channel(c).begin());
    }
    add(part, std::lround(plan.clap_s * rate_hz), device_of(sound, device));
  }
}

}  // namespace earpoint
