#include <earpoint/audio/convolution.h>

#include <algorithm>
#include <complex>
#include <cstddef>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Up to this many taps the direct sum is faster than the transforms.
constexpr std::ptrdiff_t kDirectTaps = 32;

using Spectrum = std::vector<std::complex<float>>;

/// target += a * b, element by element; written out because std::complex's product checks for NaN.
void add_product(std::span<const std::complex<float>> a, std::span<const std::complex<float>> b,
                 std::span<std::complex<float>> target) {
  for (std::size_t k = 0; k < target.size(); ++k) {
    const float real = a[k].real() * b[k].real() - a[k].imag() * b[k].imag();
    const float imaginary = a[k].real() * b[k].imag() + a[k].imag() * b[k].real();
    target[k] = {target[k].real() + real, target[k].imag() + imaginary};
  }
}

std::vector<float> convolve_direct(std::span<const float> signal, std::span<const float> taps) {
  std::vector<float> result(signal.size() + taps.size() - 1);
  for (std::size_t k = 0; k < taps.size(); ++k) {
    for (std::size_t n = 0; n < signal.size(); ++n) result[n + k] += taps[k] * signal[n];
  }
  return result;
}

/// Overlap and add.
std::vector<float> convolve_by_blocks(std::span<const float> signal, std::span<const float> taps) {
  const auto tail = static_cast<int>(taps.size()) - 1;
  // Blocks of about three times the taps waste least, but none longer than the signal.
  const auto wanted =
      static_cast<int>(std::min<std::size_t>(signal.size() + tail, 4 * taps.size()));
  RealFft<float> fft(fast_fft_size(wanted));
  const std::ptrdiff_t block = fft.size() - tail;

  std::vector<float> samples(fft.size());
  Spectrum taps_spectrum(fft.bins());
  Spectrum spectrum(fft.bins());
  Spectrum product(fft.bins());
  std::ranges::copy(taps, samples.begin());
  fft.forward(samples, taps_spectrum);

  std::vector<float> result(signal.size() + taps.size() - 1);
  for (std::ptrdiff_t start = 0; start < std::ssize(signal); start += block) {
    const std::ptrdiff_t count = std::min(block, std::ssize(signal) - start);
    std::ranges::fill(samples, 0.0F);
    std::ranges::copy(signal.subspan(start, count), samples.begin());
    fft.forward(samples, spectrum);
    std::ranges::fill(product, std::complex<float>{});
    add_product(spectrum, taps_spectrum, product);
    fft.inverse(product, samples);
    for (std::ptrdiff_t n = 0; n < count + tail; ++n) result[start + n] += samples[n];
  }
  return result;
}

}  // namespace

std::vector<float> convolve(std::span<const float> a, std::span<const float> b) {
  if (a.empty() || b.empty()) return {};
  const std::span<const float> signal = a.size() >= b.size() ? a : b;
  const std::span<const float> taps = a.size() >= b.size() ? b : a;
  return std::ssize(taps) <= kDirectTaps ? convolve_direct(signal, taps)
                                         : convolve_by_blocks(signal, taps);
}

struct PartitionedConvolver::State {
  State(std::span<const float> impulse_response, int block)
      : block_size(block), fft(2 * block), window(2 * static_cast<std::size_t>(block)) {
    for (std::size_t start = 0; start < impulse_response.size();
         start += static_cast<std::size_t>(block)) {
      const std::size_t taps =
          std::min(static_cast<std::size_t>(block), impulse_response.size() - start);
      std::ranges::fill(window, 0.0F);
      std::ranges::copy(impulse_response.subspan(start, taps), window.begin());
      partitions.emplace_back(fft.bins());
      fft.forward(window, partitions.back());
    }
    history.assign(partitions.size(), Spectrum(fft.bins()));
    sum.resize(fft.bins());
    output.resize(window.size());
    std::ranges::fill(window, 0.0F);
  }

  int block_size;
  RealFft<float> fft;
  std::vector<float> window;  ///< the last two blocks of input
  std::vector<float> output;
  std::vector<Spectrum> partitions;  ///< of the impulse response
  std::vector<Spectrum> history;     ///< of the windows, as a ring
  std::size_t newest = 0;
  Spectrum sum;
};

PartitionedConvolver::PartitionedConvolver(std::span<const float> impulse_response,
                                           int block_size) {
  EARPOINT_CHECK(!impulse_response.empty() && block_size > 0);
  state_ = std::make_unique<State>(impulse_response, block_size);
}
PartitionedConvolver::~PartitionedConvolver() = default;
PartitionedConvolver::PartitionedConvolver(PartitionedConvolver&&) noexcept = default;
PartitionedConvolver& PartitionedConvolver::operator=(PartitionedConvolver&&) noexcept = default;

int PartitionedConvolver::block_size() const { return state_->block_size; }

void PartitionedConvolver::process(std::span<const float> in, std::span<float> out) {
  State& s = *state_;
  EARPOINT_CHECK(std::ssize(in) == s.block_size && std::ssize(out) == s.block_size);
  // Overlap and save: the second half of each circular convolution is the linear one.
  std::copy(s.window.begin() + s.block_size, s.window.end(), s.window.begin());
  std::ranges::copy(in, s.window.begin() + s.block_size);
  s.newest = (s.newest + s.history.size() - 1) % s.history.size();
  s.fft.forward(s.window, s.history[s.newest]);
  std::ranges::fill(s.sum, std::complex<float>{});
  for (std::size_t p = 0; p < s.partitions.size(); ++p) {
    add_product(s.history[(s.newest + p) % s.history.size()], s.partitions[p], s.sum);
  }
  s.fft.inverse(s.sum, s.output);
  std::copy(s.output.begin() + s.block_size, s.output.end(), out.begin());
}

void PartitionedConvolver::reset() {
  State& s = *state_;
  std::ranges::fill(s.window, 0.0F);
  for (Spectrum& spectrum : s.history) std::ranges::fill(spectrum, std::complex<float>{});
}

}  // namespace earpoint
