#include <earpoint/kernels/phase_step.h>

#include <cmath>

#include <earpoint/error.h>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "phase_step.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Real and imaginary parts take turns in `transform` and `heard`.
void step_phases(float* HWY_RESTRICT transform, float* HWY_RESTRICT heard,
                 const float* HWY_RESTRICT magnitude, std::ptrdiff_t bins, float momentum,
                 float power_floor) {
  const hn::ScalableTag<float> d;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const auto push = hn::Set(d, momentum);
  const auto floor = hn::Set(d, power_floor);
  std::ptrdiff_t i = 0;
  for (; i + lanes <= bins; i += lanes) {
    hn::Vec<decltype(d)> real, imaginary, real_before, imaginary_before;
    hn::LoadInterleaved2(d, transform + 2 * i, real, imaginary);
    hn::LoadInterleaved2(d, heard + 2 * i, real_before, imaginary_before);
    hn::StoreInterleaved2(real, imaginary, d, heard + 2 * i);
    real = hn::MulAdd(push, hn::Sub(real, real_before), real);
    imaginary = hn::MulAdd(push, hn::Sub(imaginary, imaginary_before), imaginary);
    const auto power = hn::MulAdd(real, real, hn::MulAdd(imaginary, imaginary, floor));
    const auto gain = hn::Div(hn::LoadU(d, magnitude + i), hn::Sqrt(power));
    hn::StoreInterleaved2(hn::Mul(real, gain), hn::Mul(imaginary, gain), d, transform + 2 * i);
  }
  for (; i < bins; ++i) {
    float* const parts = transform + 2 * i;
    float pushed[2];
    for (int part = 0; part < 2; ++part) {
      pushed[part] = parts[part] + momentum * (parts[part] - heard[2 * i + part]);
      heard[2 * i + part] = parts[part];
    }
    const float power = pushed[0] * pushed[0] + pushed[1] * pushed[1] + power_floor;
    const float gain = magnitude[i] / std::sqrt(power);
    for (int part = 0; part < 2; ++part) parts[part] = pushed[part] * gain;
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::kernels {
namespace {

HWY_EXPORT(step_phases);

}  // namespace

void step_phases(std::span<std::complex<float>> transform, std::span<std::complex<float>> heard,
                 std::span<const float> magnitude, float momentum, float power_floor) {
  EARPOINT_CHECK(transform.size() == magnitude.size() && heard.size() == magnitude.size());
  // A complex number is laid out as its two parts.
  HWY_DYNAMIC_DISPATCH(step_phases)
  (reinterpret_cast<float*>(transform.data()), reinterpret_cast<float*>(heard.data()),
   magnitude.data(), std::ssize(magnitude), momentum, power_floor);
}

}  // namespace earpoint::kernels
#endif
