#include <earpoint/audio/envelope.h>

#include <cmath>
#include <complex>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {

std::vector<double> hilbert_envelope(std::span<const float> signal) {
  EARPOINT_CHECK(!signal.empty());
  const auto size = static_cast<int>(signal.size());
  RealFft<double> fft(size);
  std::vector<double> samples(signal.begin(), signal.end());
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(samples, spectrum);
  // The imaginary part of the analytic signal is the signal turned by -90 degrees. The constant
  // part and, at an even size, the highest frequency have none: they turn into the imaginary parts
  // that the inverse ignores.
  for (auto& value : spectrum) value = {value.imag(), -value.real()};
  std::vector<double> turned(signal.size());
  fft.inverse(spectrum, turned);
  for (std::size_t n = 0; n < samples.size(); ++n) samples[n] = std::hypot(samples[n], turned[n]);
  return samples;
}

}  // namespace earpoint
