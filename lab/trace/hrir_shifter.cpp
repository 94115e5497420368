#include "hrir_shifter.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {

HrirShifter::HrirShifter(int taps)
    : fft_(fast_fft_size(taps + 2 * kRinging)), spectrum_(fft_.bins()) {}

void HrirShifter::shift(std::span<const float> taps, double fraction, std::span<float> shifted) {
  EARPOINT_CHECK(std::ssize(shifted) == size() && std::ssize(taps) + kRinging + kRinging <= size());
  std::fill(shifted.begin(), shifted.end(), 0.0F);
  std::copy(taps.begin(), taps.end(), shifted.begin() + kRinging);
  fft_.forward(shifted, spectrum_);
  const std::complex<double> step = std::polar(1.0, -2.0 * kPi * fraction / size());
  std::complex<double> turn = 1.0;
  for (std::complex<float>& bin : spectrum_) {
    // By parts, as std::complex tests for infinities.
    const auto c = static_cast<float>(turn.real());
    const auto d = static_cast<float>(turn.imag());
    bin = {bin.real() * c - bin.imag() * d, bin.real() * d + bin.imag() * c};
    turn = {turn.real() * step.real() - turn.imag() * step.imag(),
            turn.real() * step.imag() + turn.imag() * step.real()};
  }
  fft_.inverse(spectrum_, shifted);
}

}  // namespace earpoint
