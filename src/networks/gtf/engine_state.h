#pragma once

#include "conditioning.h"
#include "filter.h"
#include "frames.h"
#include "phases.h"
#include "sound_encoder.h"
#include "trunk.h"

#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/core/ears.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// A network at work: what it is given, what it remembers of the frames before, and its parts.
struct Gtf::State {
  using D = GtfDescription;
  using Complex = std::complex<float>;

  static constexpr std::ptrdiff_t kFrame = std::ptrdiff_t{kEars} * D::kBins;
  static constexpr std::ptrdiff_t kBlock = 16;  ///< frames that share one reading of the weights

  explicit State(const GtfWeights& weights)
      : description(weights.description),
        past(description.past_frames),
        ahead(description.needed_ahead()),
        conditions(weights),
        sound_encoder(description),
        trunk(weights, kBlock),
        filter(weights, kBlock),
        phases(description.phase_rounds),
        frames(kBlock),
        states(static_cast<std::size_t>((late_states() + kBlock) * trunk.row())),
        block_features(static_cast<std::size_t>(kBlock * description.frame_features())),
        magnitudes(static_cast<std::size_t>((past + ahead + kBlock) * kFrame)),
        spectra(static_cast<std::size_t>((ahead + kBlock) * kFrame)),
        filtered(static_cast<std::size_t>(kFrame)) {
    statistics.summary.resize(static_cast<std::size_t>(description.summary_features()));
    reserve(description.window_samples);
    stream_rounds = description.phase_rounds;
    start_over();
  }

  /// Frames by which the trunk is ahead of the output.
  [[nodiscard]] std::ptrdiff_t late_states() const { return ahead - description.look_ahead_frames; }

  void reserve(std::ptrdiff_t samples) {
    const auto count = static_cast<std::size_t>(1 + samples / D::kHop);
    if (window_spectra.size() == count * kFrame) return;
    window_spectra.resize(count * kFrame);
    window_magnitudes.resize(count * kFrame);
    window_features.resize(count * static_cast<std::size_t>(description.frame_features()));
    frame_power.resize(count);
  }

  void start_over() {
    trunk.reset();
    filter.reset();
    sound_encoder.forget();
    std::ranges::fill(states, 0.0F);
    std::ranges::fill(magnitudes, 0.0F);
    std::ranges::fill(spectra, Complex{});
    phases.reset(description.phase_rounds);
    frames.reset();
    frames_in = 0;
  }

  /// Takes in what was heard and seen.
  void update_summary() {
    conditions.set_summary(statistics.summary);
    is_heard = true;
    is_aimed = false;
  }

  /// What the next frames are filtered by. Costs nothing where nothing has changed.
  void condition(const Pose& pose) {
    if (is_aimed && pose == conditioned) return;
    conditioned = pose;
    conditions.set_pose(speaker_m, pose);
    trunk.condition(conditions.vector());
    filter.condition(conditions);
    const gtf::GtfGeometry* geometry = conditions.geometry();
    pose_gain = geometry != nullptr ? geometry->expected_gain(band_power) : 1.0;
    is_aimed = true;
  }

  /// Fills `filtered` with what the frame of the block becomes.
  void filter_frame(std::ptrdiff_t index) {
    const auto rows = [&](const auto& values, std::ptrdiff_t first, std::ptrdiff_t count) {
      return std::span(values).subspan(static_cast<std::size_t>(first * kFrame),
                                       static_cast<std::size_t>(count * kFrame));
    };
    if (tells_voice) {
      filter.tell_voice(index, rows(magnitudes, index + past, 1), rows(spectra, index, 1),
                        filtered);
    } else {
      filter.filter(index, rows(magnitudes, index, past + 1 + description.future_frames),
                    rows(spectra, index, 1), filtered);
    }
  }

  /// Lets the frame in `filtered` sound, or the one that it pushes out of the phase rounds.
  void sound_frame() {
    const float scale = statistics.level / gtf::kHeardLevel;
    if (phases.rounds() == 0) {
      frames.add(filtered, scale);
      return;
    }
    for (Complex& value : filtered) value *= scale;
    if (phases.take(filtered, scale)) frames.add(filtered, 1.0F);
  }

  /// Takes a block of frames and filters those that have all they need.
  /// @param features    [count][frame features]
  /// @param new_spectra, new_magnitudes  [count][2][bins]
  void take(std::ptrdiff_t count, const float* features, const Complex* new_spectra,
            const float* new_magnitudes) {
    std::copy_n(new_magnitudes, count * kFrame, magnitudes.data() + (past + ahead) * kFrame);
    std::copy_n(new_spectra, count * kFrame, spectra.data() + ahead * kFrame);
    float* new_states = states.data() + late_states() * trunk.row();
    // The trunk's first frame stands for the output's first: it begins with what lies ahead. A
    // stream's begins with the first sound: silence would stay in its memory.
    const bool waits = is_stream && !holds_statistics && sound_encoder.frames() == 0.0;
    const std::ptrdiff_t skipped =
        waits ? count
              : std::clamp<std::ptrdiff_t>(description.look_ahead_frames - frames_in, 0, count);
    std::fill_n(new_states, skipped * trunk.row(), 0.0F);
    if (skipped < count) {
      trunk.run(features + skipped * description.frame_features(), count - skipped,
                new_states + skipped * trunk.row());
    }
    frames_in += count;
    if (tells_voice) {
      filter.read_voice(states.data(), trunk.row(), count);
    } else {
      filter.read(states.data(), trunk.row(), count);
    }
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (frames_in - count + i < ahead) continue;
      filter_frame(i);
      sound_frame();
    }
    const auto keep = [&](auto& rows, std::ptrdiff_t kept, std::ptrdiff_t width) {
      std::copy_n(rows.data() + count * width, kept * width, rows.data());
    };
    keep(states, late_states(), trunk.row());
    keep(magnitudes, past + ahead, kFrame);
    keep(spectra, ahead, kFrame);
  }

  /// Whether the latest frame, which has samples of two hops, is silence.
  [[nodiscard]] bool is_quiet() const { return is_silent && was_silent; }

  void measure_window(std::span<const float> source);
  void measure_power(std::ptrdiff_t frames_of_window);
  void render_window(std::span<const Pose> path, std::span<float> output);
  void follow(std::span<const float> hop);
  void follow_power(std::span<const float> magnitude);
  void take_hop();

  D description;
  std::ptrdiff_t past;
  std::ptrdiff_t ahead;
  gtf::GtfConditions conditions;
  gtf::GtfSoundEncoder sound_encoder;
  gtf::GtfTrunk trunk;
  gtf::GtfFilter filter;
  gtf::GtfPhases phases;
  gtf::GtfFrames frames;

  Pose source_from_target;
  std::optional<Vector3> speaker_m;
  GtfStatistics statistics;
  bool is_heard = false;     ///< `conditions` has heard these statistics, and seen what is seen
  bool tells_voice = false;  ///< in place of the sound at the target
  std::vector<float> voice;  ///< [2][samples]
  bool is_aimed = false;     ///< trunk and filter are conditioned by `conditioned`
  Pose conditioned;

  // What the next frames need of those before, oldest first.
  std::vector<float> states;
  std::vector<float> block_features;
  std::vector<float> magnitudes;
  std::vector<Complex> spectra;
  std::vector<Complex> filtered;
  std::ptrdiff_t frames_in = 0;

  std::vector<Complex> window_spectra;
  std::vector<float> window_magnitudes;
  std::vector<float> window_features;

  // Of the window: power in the head's bands, both ears together, and of every frame.
  std::array<double, D::kHeadBands> band_power{};
  std::vector<double> frame_power;
  double pose_gain = 1.0;      ///< expected of the pose that was conditioned last
  double expected_gain = 1.0;  ///< of the window, over its poses

  // Of a stream.
  bool is_stream = false;
  int stream_rounds = 0;  ///< of phases
  bool holds_statistics = false;
  bool is_silent = true;   ///< the latest hop, below gtf::kQuietest
  bool was_silent = true;  ///< the one before
  std::array<std::array<float, D::kFrameSamples>, kEars> recent{};
  std::ptrdiff_t hops = 0;
  double squares = 0.0;
  double square_count = 0.0;
};

}  // namespace earpoint
