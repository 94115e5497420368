#include "decay_error.h"

#include <cstdint>

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/cumsum.h>
#include <ATen/ops/fft_irfft.h>
#include <ATen/ops/fft_rfft.h>
#include <ATen/ops/log10.h>
#include <ATen/ops/view_as_real.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// At 16 kHz.
constexpr std::int64_t kAhead = 64;       // 4 ms: a network may render an ear too early
constexpr std::int64_t kLength = 4800;    // 300 ms are summed
constexpr std::int64_t kCompared = 2400;  // 150 ms are compared
constexpr std::int64_t kStep = 80;        // every 5 ms
constexpr double kRegularisation = 0.01;  // of the speech's mean power
constexpr double kFloor = 0.01;           // of the whole energy: 20 dB down

at::Tensor power(const at::Tensor& spectrum) {
  return at::view_as_real(spectrum).square().sum(at::IntArrayRef({-1}));
}

/// Energy of the response after each step, in dB re the whole: [clips][2][kCompared / kStep].
at::Tensor decay_db(const at::Tensor& dry_spectrum, const at::Tensor& sound, std::int64_t size) {
  const at::Tensor strength = power(dry_spectrum);
  const at::Tensor floor = strength.mean(at::IntArrayRef({2}), true) * kRegularisation + 1e-12;
  const at::Tensor response =
      at::fft_irfft(at::fft_rfft(sound, size) * dry_spectrum.conj() / (strength + floor), size);
  const at::Tensor energy =
      at::cat({response.narrow(2, size - kAhead, kAhead), response.narrow(2, 0, kLength)}, 2)
          .square();
  const at::Tensor whole = energy.sum(at::IntArrayRef({2}), true) + 1e-12;
  const at::Tensor rest = whole - at::cumsum(energy, 2);
  const at::Tensor wanted = rest.slice(2, 0, kCompared, kStep);
  return (wanted.clamp_min(0) / whole + kFloor).log10() * 10;
}

}  // namespace

at::Tensor decay_error_db(const at::Tensor& dry, const at::Tensor& found, const at::Tensor& right) {
  const std::int64_t size = 2 * dry.size(1);
  EARPOINT_CHECK(size >= kAhead + kLength);
  const at::Tensor spectrum = at::fft_rfft(dry.unsqueeze(1), size);
  return (decay_db(spectrum, found, size) - decay_db(spectrum, right, size)).abs().mean();
}

}  // namespace earpoint
