#include <earpoint/spatial/arrival_renderer.h>

#include "impulse_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/spatial/air_absorption.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

using Complex = std::complex<float>;

constexpr int kInterpolatedOrder = 2;

// Builds a response as one spectrum per channel over its whole length.
class Response {
 public:
  // taps: the length of the longest filter that add() is given.
  Response(int channels, int sample_rate_hz, int taps, double length_s)
      : rate_hz_(sample_rate_hz),
        samples_(std::llround(length_s * sample_rate_hz)),
        margin_(octave_bank_half_length(sample_rate_hz)),
        fft_(fast_fft_size(static_cast<int>(samples_) + 2 * margin_ + taps)),
        grid_(sample_rate_hz, fft_.size()),
        impulses_(fft_.bins()),
        filter_(fft_.bins()),
        sums_(channels, std::vector<Complex>(fft_.bins())) {}

  // Adds an impulse to the present group. Impulses within the margin before the start still ring
  // into the response.
  void add_impulse(double start_samples, const BandArray& gain) {
    if (start_samples >= static_cast<double>(samples_) + margin_ / 2.0) return;
    grid_.add(std::max(start_samples, -margin_ / 2.0) + margin_, gain);
  }

  // Ends a group of impulses; then add_filtered sends it through a filter into a channel.
  void end_group() { grid_.take(impulses_); }
  void add_filtered(int channel, std::span<const float> taps) {
    std::vector<float> padded(fft_.size(), 0.0F);
    std::ranges::copy(taps, padded.begin());
    fft_.forward(padded, filter_);
    for (int bin = 0; bin < fft_.bins(); ++bin) {
      const Complex a = impulses_[bin];
      const Complex b = filter_[bin];
      sums_[channel][bin] += Complex(a.real() * b.real() - a.imag() * b.imag(),
                                     a.real() * b.imag() + a.imag() * b.real());
    }
  }

  // The response, silent before `first_s`, with a short fade-in from there.
  Waveform finish(double first_s) {
    Waveform out(static_cast<int>(sums_.size()), samples_, rate_hz_);
    std::vector<float> whole(fft_.size());
    constexpr int kFade = 8;
    const double first_samples = first_s * rate_hz_;
    for (int channel = 0; channel < out.channels(); ++channel) {
      fft_.inverse(sums_[channel], whole);
      const std::span<float> samples = out.channel(channel);
      std::copy_n(whole.begin() + margin_, samples.size(), samples.begin());
      for (std::ptrdiff_t i = 0; i < std::ssize(samples); ++i) {
        const double into = (static_cast<double>(i) - first_samples) / kFade;
        if (into >= 1.0) break;
        samples[i] *= static_cast<float>(std::max(0.0, into));
      }
    }
    return out;
  }

 private:
  int rate_hz_;
  std::ptrdiff_t samples_;
  int margin_;  // room for the bank's ringing before and behind
  RealFft<float> fft_;
  ImpulseGrid grid_;
  std::vector<Complex> impulses_;
  std::vector<Complex> filter_;
  std::vector<std::vector<Complex>> sums_;  // [channel][bin]
};

// The wave front's curvature; the air's temperature does not matter here.
double travelled_m(const Arrival& arrival) {
  return std::max(1e-3, arrival.delay_s * speed_of_sound_m_per_s(Air{}));
}

void check_arrivals(std::span<const Arrival> arrivals, double length_s) {
  EARPOINT_CHECK(length_s > 0.0);
  EARPOINT_CHECK(std::ranges::is_sorted(arrivals, {}, &Arrival::delay_s));
  EARPOINT_CHECK(arrivals.empty() || arrivals.front().delay_s >= 0.0);
}

}  // namespace

Waveform render_arrivals(std::span<const Arrival> arrivals, const HrtfSet& hrtf, double length_s) {
  check_arrivals(arrivals, length_s);
  Response response(2, hrtf.sample_rate_hz(), hrtf.taps(), length_s);
  const auto add = [&](const Arrival& arrival) {
    response.add_impulse(arrival.delay_s * hrtf.sample_rate_hz() - hrtf.centre_delay_samples(),
                         arrival.gain);
  };
  std::vector<std::vector<const Arrival*>> late(hrtf.size());
  for (const Arrival& arrival : arrivals) {
    if (arrival.delay_s > length_s + 0.1) break;
    if (arrival.order > kInterpolatedOrder) {
      late[hrtf.nearest(arrival.direction)].push_back(&arrival);
      continue;
    }
    add(arrival);
    response.end_group();
    const Hrir hrir = hrtf.interpolated(arrival.direction, travelled_m(arrival));
    for (int ear = 0; ear < 2; ++ear) response.add_filtered(ear, hrir.taps[ear]);
  }
  for (std::size_t direction = 0; direction < late.size(); ++direction) {
    if (late[direction].empty()) continue;
    for (const Arrival* arrival : late[direction]) add(*arrival);
    response.end_group();
    for (int ear = 0; ear < 2; ++ear) {
      response.add_filtered(ear, hrtf.response(direction, ear));
    }
  }
  constexpr double kLead_s = 0.003;
  return response.finish(arrivals.empty() ? 0.0 : arrivals.front().delay_s - kLead_s);
}

Waveform render_arrivals_mono(std::span<const Arrival> arrivals, int sample_rate_hz,
                              double length_s) {
  check_arrivals(arrivals, length_s);
  Response response(1, sample_rate_hz, 1, length_s);
  for (const Arrival& arrival : arrivals) {
    response.add_impulse(arrival.delay_s * sample_rate_hz, arrival.gain);
  }
  response.end_group();
  const float unity = 1.0F;
  response.add_filtered(0, {&unity, 1});
  constexpr double kLead_s = 0.004;
  return response.finish(arrivals.empty() ? 0.0 : arrivals.front().delay_s - kLead_s);
}

}  // namespace earpoint
