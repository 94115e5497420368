#include "early_field.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <earpoint/audio/fft.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {

void add_early_binaural(const ResponseShape& shape, std::span<const Arrival> arrivals,
                        const Quaternion& world_from_listener, const HrtfSet& hrtf,
                        std::span<std::vector<float>> ears) {
  // An arrival's own short frame: the response's taps, and the bank's ringing before and after.
  const int ringing = octave_bank_half_length(shape.sample_rate_hz);
  RealFft<float> fft(fast_fft_size(hrtf.taps() + 2 * ringing + 2));
  const OctaveBank bank(shape.sample_rate_hz, fft.size());
  std::vector<float> frame(fft.size());
  std::vector<float> curve(fft.bins());
  std::vector<std::complex<float>> spectrum(fft.bins());
  std::vector<std::complex<float>> shift(fft.bins());
  const Quaternion listener_from_world = conjugate(world_from_listener);
  for (const Arrival& arrival : arrivals) {
    const double position = arrival.delay_s * shape.sample_rate_hz - hrtf.centre_delay_samples();
    const auto whole = static_cast<std::ptrdiff_t>(std::floor(position));
    if (whole - ringing >= shape.samples) continue;
    bank.gain_curve(arrival.gain, curve);
    const std::complex<double> step =
        std::polar(1.0, -2.0 * kPi * (position - static_cast<double>(whole)) / fft.size());
    std::complex<double> turn = 1.0;
    for (std::size_t bin = 0; bin < shift.size(); ++bin) {
      shift[bin] = curve[bin] * std::complex<float>(turn);
      turn *= step;
    }
    const Hrir hrir = hrtf.interpolated(rotate(listener_from_world, arrival.direction));
    for (int ear = 0; ear < 2; ++ear) {
      std::fill(frame.begin(), frame.end(), 0.0F);
      std::copy(hrir.taps[ear].begin(), hrir.taps[ear].end(), frame.begin());
      fft.forward(frame, spectrum);
      for (std::size_t bin = 0; bin < spectrum.size(); ++bin) spectrum[bin] *= shift[bin];
      fft.inverse(spectrum, frame);
      // What rings ahead of the start lies at the frame's end.
      const auto size = static_cast<std::ptrdiff_t>(frame.size());
      for (std::ptrdiff_t i = -ringing; i < size - ringing; ++i) {
        const std::ptrdiff_t at = whole + i;
        if (at < 0 || at >= std::ssize(ears[ear])) continue;
        ears[ear][at] += frame[i < 0 ? i + size : i];
      }
    }
  }
}

}  // namespace earpoint
