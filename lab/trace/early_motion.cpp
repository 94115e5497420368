#include "early_motion.h"

#include "ambisonics.h"
#include "delayed_reader.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

using Spectrum = std::vector<std::complex<float>>;

constexpr double kControl_s = 0.002;  // between the times at which paths are computed
constexpr int kOversampling = 2;
constexpr int kReach = 16;  // samples that the reader uses on both sides

}  // namespace

float MotionWindow::weight(std::ptrdiff_t sample) const {
  const double away = (static_cast<double>(sample) / sample_rate_hz - time_s) / step_s;
  return static_cast<float>(0.5 + 0.5 * std::cos(kPi * std::clamp(away, -1.0, 1.0)));
}

// The path of an arrival after source and listener have moved from where it was traced. Exact for
// the straight path; to first order, without their product, for others.
struct EarlyMotion::Way {
  Way(const Arrival& traced, const MotionWindow& window, const Motion& motion,
      double speed_m_per_s);

  [[nodiscard]] double length_m(const Vector3& source_moved, const Vector3& listener_moved) const;
  [[nodiscard]] Vector3 to_image(double time_s) const;
  /// The gain at another distance, up to 20 dB, as a distant path says little about a close one.
  [[nodiscard]] float nearer(double delay_s) const {
    return std::min(10.0F, static_cast<float>(arrival->delay_s / delay_s));
  }

  const Arrival* arrival;
  const Motion* motion;
  double speed_m_per_s;
  double traced_m;
  bool straight;
  Vector3 source_m;
  Vector3 listener_m;
  SmoothCurve delays_s;
};

EarlyMotion::Way::Way(const Arrival& traced, const MotionWindow& window, const Motion& along,
                      double speed)
    : arrival(&traced),
      motion(&along),
      speed_m_per_s(speed),
      traced_m(traced.delay_s * speed),
      straight(norm(traced.direction + traced.departure) < 1e-6),
      source_m(along.world_from_source(window.time_s).position_m),
      listener_m(along.world_from_listener(window.time_s).position_m),
      delays_s(0.0, kControl_s, {}) {
  const double rate_hz = window.sample_rate_hz;
  const double first_s = static_cast<double>(window.begin) / rate_hz - kControl_s;
  const double last_s = static_cast<double>(window.end) / rate_hz + 2.0 * kControl_s;
  std::vector<double> values;
  double delay_s = traced.delay_s;
  for (double time_s = first_s; time_s < last_s + kControl_s; time_s += kControl_s) {
    const Vector3 listener_moved = along.world_from_listener(time_s).position_m - listener_m;
    // The sound left the source where it was then, so that the delay depends on itself. Each
    // iteration reduces the error by the ratio of its speed to that of sound.
    constexpr int kTurns = 6;
    for (int turn = 0; turn < kTurns; ++turn) {
      const Vector3 sent_from = along.world_from_source(time_s - delay_s).position_m;
      delay_s = length_m(sent_from - source_m, listener_moved) / speed;
    }
    values.push_back(delay_s);
  }
  delays_s = SmoothCurve(first_s, kControl_s, std::move(values));
}

double EarlyMotion::Way::length_m(const Vector3& source_moved,
                                  const Vector3& listener_moved) const {
  const double moved_squared =
      straight ? dot(listener_moved - source_moved, listener_moved - source_moved)
               : dot(source_moved, source_moved) + dot(listener_moved, listener_moved);
  const double squared =
      traced_m * traced_m + moved_squared -
      2.0 * traced_m *
          (dot(arrival->departure, source_moved) + dot(arrival->direction, listener_moved));
  constexpr double kNearest_m = 1e-3;
  return std::max(kNearest_m, std::sqrt(std::max(0.0, squared)));
}

Vector3 EarlyMotion::Way::to_image(double time_s) const {
  Vector3 way =
      arrival->direction * traced_m - (motion->world_from_listener(time_s).position_m - listener_m);
  if (straight) {
    way = way + motion->world_from_source(time_s - arrival->delay_s).position_m - source_m;
  }
  return way;
}

// The spectrum of the sound that a window needs; its edges are faded, outside the samples that are
// read.
struct EarlyMotion::Segment {
  Segment(std::span<const float> sound, const MotionWindow& window, std::span<const Way> ways,
          int taps);

  // Transforms the product of spectra to a signal of twice the rate.
  std::span<const float> signal();
  [[nodiscard]] double position(double output_sample) const {
    return kOversampling * (output_sample - static_cast<double>(start));
  }

  std::ptrdiff_t start = 0;  // the sample of the sound with which it begins
  RealFft<float> fft;
  RealFft<float> fine_fft;
  OctaveBank bank;
  Spectrum spectrum;
  std::vector<float> curve;  // gains per bin
  Spectrum product;          // zero above the sound's own Nyquist frequency
  std::vector<float> fine;
  DelayedReader reader;

 private:
  static int size(const MotionWindow& window, std::span<const Way> ways, int taps);
};

namespace {

struct DelayRange {
  double least_s;
  double most_s;
};

template <typename Ways>
DelayRange delay_range(const Ways& ways) {
  DelayRange range{1e9, 0.0};
  for (const auto& way : ways) {
    const auto [least, most] = std::ranges::minmax(way.delays_s.values());
    range = {std::min(range.least_s, least), std::max(range.most_s, most)};
  }
  return range;
}

}  // namespace

int EarlyMotion::Segment::size(const MotionWindow& window, std::span<const Way> ways, int taps) {
  const DelayRange range = delay_range(ways);
  const int margin = 2 * octave_bank_half_length(window.sample_rate_hz);
  const auto moved =
      static_cast<int>(std::ceil((range.most_s - range.least_s) * window.sample_rate_hz));
  const int length = static_cast<int>(window.end - window.begin) + moved + 2 * (margin + kReach);
  return fast_fft_size(length + margin + taps);
}

EarlyMotion::Segment::Segment(std::span<const float> sound, const MotionWindow& window,
                              std::span<const Way> ways, int taps)
    : fft(size(window, ways, taps)),
      fine_fft(kOversampling * fft.size()),
      bank(window.sample_rate_hz, fft.size()),
      spectrum(fft.bins()),
      curve(fft.bins()),
      product(fine_fft.bins()),
      fine(fine_fft.size()) {
  const DelayRange range = delay_range(ways);
  const int rate_hz = window.sample_rate_hz;
  const int margin = 2 * octave_bank_half_length(rate_hz);
  const auto first = window.begin - static_cast<std::ptrdiff_t>(range.most_s * rate_hz) - kReach;
  const auto last = window.end - static_cast<std::ptrdiff_t>(range.least_s * rate_hz) + kReach;
  start = first - margin;
  std::vector<float> samples(fft.size());
  const int fade = margin / 2;
  for (std::ptrdiff_t i = start; i < last + margin; ++i) {
    if (i < 0 || i >= std::ssize(sound)) continue;
    const auto inside = static_cast<double>(std::min(i - start, last + margin - 1 - i)) / fade;
    const double weight = inside >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(kPi * inside);
    samples[i - start] = static_cast<float>(weight) * sound[i];
  }
  fft.forward(samples, spectrum);
}

std::span<const float> EarlyMotion::Segment::signal() {
  // Zeros above the spectrum interpolate; the transform scales by its own size.
  fine_fft.inverse(product, fine);
  for (float& sample : fine) sample *= kOversampling;
  return fine;
}

EarlyMotion::EarlyMotion(std::span<const float> sound, const Motion& motion,
                         const Microphone& microphone, double speed_m_per_s)
    : sound_(sound), motion_(motion), microphone_(microphone), speed_m_per_s_(speed_m_per_s) {}

void EarlyMotion::add(const MotionWindow& window, std::span<const Arrival> arrivals,
                      std::span<std::vector<float>> channels) const {
  if (arrivals.empty() || window.begin >= window.end) return;
  std::vector<Way> ways;
  ways.reserve(arrivals.size());
  for (const Arrival& arrival : arrivals)
    ways.emplace_back(arrival, window, motion_, speed_m_per_s_);
  Segment segment(sound_, window, ways, microphone_.ears ? microphone_.ears->taps() : 0);
  for (const Way& way : ways) {
    segment.bank.gain_curve(way.arrival->gain, segment.curve);
    if (microphone_.ears) {
      play_ears(window, way, segment, channels);
    } else {
      play(window, way, segment, channels);
    }
  }
}

// For a microphone at one place: one channel, or those of spherical harmonics.
void EarlyMotion::play(const MotionWindow& window, const Way& way, Segment& segment,
                       std::span<std::vector<float>> channels) const {
  for (std::size_t bin = 0; bin < segment.spectrum.size(); ++bin) {
    segment.product[bin] = segment.spectrum[bin] * segment.curve[bin];
  }
  const std::span<const float> signal = segment.signal();
  std::vector<float> gains(channels.size(), 1.0F);
  if (microphone_.ambisonic_order) {
    const Quaternion turn = motion_.world_from_listener(window.time_s).orientation;
    encode_ambisonics(rotate(conjugate(turn), way.arrival->direction), *microphone_.ambisonic_order,
                      gains);
  }
  const double rate_hz = window.sample_rate_hz;
  for (std::ptrdiff_t i = window.begin; i < window.end; ++i) {
    const auto n = static_cast<double>(i);
    const double delay_s = way.delays_s.at(n / rate_hz);
    const float value = segment.reader.at(signal, segment.position(n - delay_s * rate_hz));
    const float nearer = way.nearer(delay_s);
    const float weighed = window.weight(i) * nearer * value;
    for (std::size_t c = 0; c < channels.size(); ++c) channels[c][i] += gains[c] * weighed;
  }
}

// For two ears. The delay of each ear is removed from its response and added again as it changes
// with the head, so that responses of neighbouring steps cross-fade in phase.
void EarlyMotion::play_ears(const MotionWindow& window, const Way& way, Segment& segment,
                            std::span<std::vector<float>> channels) const {
  const HrtfSet& ears = *microphone_.ears;
  const auto response_at = [&](double time_s) {
    const Vector3 to_image = way.to_image(time_s);
    const Quaternion turn = motion_.world_from_listener(time_s).orientation;
    return ears.interpolated(rotate(conjugate(turn), to_image), std::max(1e-3, norm(to_image)));
  };
  const Hrir before = response_at(window.time_s - window.step_s);
  const Hrir now = response_at(window.time_s);
  const Hrir behind = response_at(window.time_s + window.step_s);
  const double rate_hz = window.sample_rate_hz;
  std::vector<float> padded(segment.fft.size());
  Spectrum filter(segment.fft.bins());
  for (int ear = 0; ear < 2; ++ear) {
    std::ranges::fill(padded, 0.0F);
    std::ranges::copy(now.taps[ear], padded.begin());
    segment.fft.forward(padded, filter);
    const std::complex<double> step =
        std::polar(1.0, 2.0 * kPi * now.onset_samples[ear] / segment.fft.size());
    std::complex<double> turn = 1.0;
    for (std::size_t bin = 0; bin < filter.size(); ++bin) {
      segment.product[bin] =
          segment.spectrum[bin] * filter[bin] * segment.curve[bin] * std::complex<float>(turn);
      turn *= step;
    }
    const std::span<const float> signal = segment.signal();
    // A parabola through the onsets at the three steps.
    const double middle = now.onset_samples[ear] - ears.centre_delay_samples();
    const double slope = 0.5 * (behind.onset_samples[ear] - before.onset_samples[ear]);
    const double bend =
        0.5 * (behind.onset_samples[ear] + before.onset_samples[ear]) - now.onset_samples[ear];
    for (std::ptrdiff_t i = window.begin; i < window.end; ++i) {
      const auto n = static_cast<double>(i);
      const double delay_s = way.delays_s.at(n / rate_hz);
      const double away = (n / rate_hz - window.time_s) / window.step_s;
      const double onset = middle + away * (slope + away * bend);
      const float value =
          segment.reader.at(signal, segment.position(n - delay_s * rate_hz - onset));
      const float nearer = way.nearer(delay_s);
      channels[ear][i] += window.weight(i) * nearer * value;
    }
  }
}

}  // namespace earpoint
