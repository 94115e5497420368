#include "engine_state.h"

#include <cmath>
#include <numeric>

#include <earpoint/core/ears.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kHalf = GtfDescription::kFrameSamples / 2;

/// Share of a stream's statistics that is kept from hop to hop; their time constant is a second.
double kept_of_stream() {
  constexpr double kMemory_s = 1.0;
  return std::exp(-double{GtfDescription::kHop} / (GtfDescription::kSampleRateHz * kMemory_s));
}

float level_of(double squares, double count) {
  return std::max(static_cast<float>(std::sqrt(squares / std::max(count, 1.0))), gtf::kQuietest);
}

}  // namespace

void Gtf::State::measure_window(std::span<const float> source) {
  double sum = 0.0;
  for (const float x : source) sum += double{x} * x;
  statistics.level = level_of(sum, static_cast<double>(source.size()));
  const std::size_t samples = source.size() / kEars;
  const std::ptrdiff_t count = 1 + static_cast<std::ptrdiff_t>(samples) / D::kHop;
  const auto part = [](auto& rows, std::ptrdiff_t index, std::ptrdiff_t width) {
    return std::span(rows).subspan(static_cast<std::size_t>(index * width),
                                   static_cast<std::size_t>(width));
  };
  for (std::ptrdiff_t t = 0; t < count; ++t) {
    for (std::size_t e = 0; e < kEars; ++e) {
      frames.transform(source.subspan(e * samples, samples), t * D::kHop,
                       gtf::kHeardLevel / statistics.level,
                       part(window_spectra, t, kFrame).subspan(e * D::kBins, D::kBins));
    }
    gtf::GtfSoundEncoder::measure(part(window_spectra, t, kFrame),
                                  part(window_magnitudes, t, kFrame));
    sound_encoder.hear(part(window_spectra, t, kFrame), part(window_magnitudes, t, kFrame),
                       part(window_features, t, description.frame_features()));
  }
  sound_encoder.summarize(statistics.summary);
  measure_power(count);
}

void Gtf::State::measure_power(std::ptrdiff_t frames_of_window) {
  // Gives silence an expected gain too; far below the floor of any sound.
  constexpr double kLeast = 1e-12;
  band_power.fill(kLeast);
  for (std::ptrdiff_t t = 0; t < frames_of_window; ++t) {
    frame_power[t] = kLeast;
    for (std::size_t band = 0; band < band_power.size(); ++band) {
      double sum = 0.0;
      for (std::ptrdiff_t e = 0; e < kEars; ++e) {
        const float* magnitude = window_magnitudes.data() + t * kFrame + e * D::kBins;
        for (int bin = kGtfHeadEdges[band]; bin < kGtfHeadEdges[band + 1]; ++bin) {
          sum += double{magnitude[bin]} * magnitude[bin];
        }
      }
      band_power[band] += sum;
      frame_power[t] += sum;
    }
  }
}

/// @param path  the target's pose at every frame, or one pose for all of them
void Gtf::State::render_window(std::span<const Pose> path, std::span<float> output) {
  const std::ptrdiff_t samples = std::ssize(output) / kEars;
  const std::ptrdiff_t whole = 1 + samples / D::kHop;
  std::ptrdiff_t drained = 0;
  const auto drain_to = [&](std::ptrdiff_t end) {
    const std::ptrdiff_t count = std::min(end, samples) - drained;
    if (count <= 0) return;
    frames.drain(drained, count, output.data() + drained, samples);
    drained += count;
  };
  const auto pose_at = [&](std::ptrdiff_t frame) -> const Pose& {
    return path[std::clamp<std::ptrdiff_t>(frame, 0, std::ssize(path) - 1)];
  };
  // After the last frame all inputs are zeros, which are not the features of silence.
  std::array<Complex, kFrame> no_spectrum{};
  std::array<float, kFrame> no_magnitude{};
  std::fill_n(block_features.begin(), description.frame_features(), 0.0F);
  double expected_power = 0.0;
  for (std::ptrdiff_t t = 0; t < whole + ahead;) {
    // Output frames are `ahead` frames later than input frames; a block has one pose.
    const Pose& pose = pose_at(t - ahead);
    condition(pose);
    std::ptrdiff_t count = 1;
    if (t < whole) {
      while (count < std::min(whole - t, kBlock) && pose_at(t - ahead + count) == pose) ++count;
      take(count, window_features.data() + t * description.frame_features(),
           window_spectra.data() + t * kFrame, window_magnitudes.data() + t * kFrame);
    } else {
      take(1, block_features.data(), no_spectrum.data(), no_magnitude.data());
    }
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(t, ahead); i < t + count; ++i) {
      expected_power += pose_gain * frame_power[i - ahead];
    }
    t += count;
    drain_to(frames.finished_samples());
  }
  while (phases.drain(filtered)) {
    frames.add(filtered, 1.0F);
    drain_to(frames.finished_samples());
  }
  drain_to(samples);
  expected_gain = expected_power / std::reduce(frame_power.begin(), frame_power.end());
}

/// Lets level and summary follow the stream, and keeps them over silence: no training clip is
/// silent, and what the network makes of silence it would make of the first words after it.
void Gtf::State::follow(std::span<const float> hop) {
  double sum = 0.0;
  for (const float x : hop) sum += double{x} * x;
  was_silent = is_silent;
  is_silent = sum < double{gtf::kQuietest} * gtf::kQuietest * static_cast<double>(hop.size());
  if (is_quiet()) return;
  const double kept = kept_of_stream();
  squares = kept * squares + sum;
  square_count = kept * square_count + static_cast<double>(hop.size());
  const float before = statistics.level;
  statistics.level = level_of(squares, square_count);
  sound_encoder.fade(static_cast<float>(kept));
  // What is stored was scaled by the level before; rescale it to the present one.
  const float rescale = before / statistics.level;
  for (float& value : magnitudes) value *= rescale;
  for (Complex& value : spectra) value *= rescale;
  filter.rescale(rescale);
  sound_encoder.rescale(rescale * rescale);
  for (double& power : band_power) power *= double{rescale} * rescale;
}

/// Lets the bands' power follow the stream; in the scale of the present level.
void Gtf::State::follow_power(std::span<const float> magnitude) {
  for (std::size_t band = 0; band < band_power.size(); ++band) {
    double sum = 0.0;
    for (std::size_t e = 0; e < kEars; ++e) {
      for (int bin = kGtfHeadEdges[band]; bin < kGtfHeadEdges[band + 1]; ++bin) {
        const float x = magnitude[e * D::kBins + static_cast<std::size_t>(bin)];
        sum += double{x} * x;
      }
    }
    band_power[band] += (sum - band_power[band]) * (1.0 - kept_of_stream());
  }
}

/// Processes the frame in the middle of the recent samples.
void Gtf::State::take_hop() {
  for (std::size_t e = 0; e < kEars; ++e) {
    frames.transform(recent[e], kHalf, gtf::kHeardLevel / statistics.level,
                     std::span(window_spectra).subspan(e * D::kBins, D::kBins));
  }
  const std::span<const Complex> spectrum(window_spectra.data(), kFrame);
  const std::span<float> magnitude(window_magnitudes.data(), kFrame);
  const std::span<float> features(window_features.data(),
                                  static_cast<std::size_t>(description.frame_features()));
  gtf::GtfSoundEncoder::measure(spectrum, magnitude);
  follow_power(magnitude);
  sound_encoder.hear(spectrum, magnitude, features, !is_quiet());
  // The summary changes slowly, but for that of the first frames.
  constexpr std::ptrdiff_t kRefresh = 10;
  const bool is_new = !is_quiet() && sound_encoder.frames() < kRefresh;
  if (!holds_statistics && (is_new || frames_in % kRefresh == 0)) {
    sound_encoder.summarize(statistics.summary);
    is_heard = false;
  }
  if (!is_heard) update_summary();
  condition(source_from_target);
  take(1, features.data(), spectrum.data(), magnitude.data());
}

}  // namespace earpoint
