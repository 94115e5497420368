#include "phase_kernels.h"

#include <cstddef>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gtf/phase_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kFrameStep>;
using Vector = hn::Vec<Lanes>;

using gtf::kPowerFloor;
constexpr float kLeastPower = 1e-12F;  // of the input, for a finite gradient at zero
constexpr float kMomentum = GtfDescription::kPhaseMomentum;

struct Complex {
  Vector re;
  Vector im;
};
HWY_INLINE Complex load(const float* re, const float* im, std::ptrdiff_t at) {
  const Lanes d;
  return {hn::LoadU(d, re + at), hn::LoadU(d, im + at)};
}
HWY_INLINE Complex scaled(Complex a, Vector factor) {
  return {hn::Mul(a.re, factor), hn::Mul(a.im, factor)};
}
HWY_INLINE Vector inner(Complex a, Complex b) {
  return hn::MulAdd(a.re, b.re, hn::Mul(a.im, b.im));
}
HWY_INLINE Vector length(Complex a, float floor) {
  const Lanes d;
  return hn::Sqrt(hn::Add(inner(a, a), hn::Set(d, floor)));
}
HWY_INLINE Complex pushed(Complex heard, Complex before) {
  const Lanes d;
  const Vector momentum = hn::Set(d, kMomentum);
  return {hn::MulAdd(momentum, hn::Sub(heard.re, before.re), heard.re),
          hn::MulAdd(momentum, hn::Sub(heard.im, before.im), heard.im)};
}

/// One ear: `count` real parts, with the imaginary parts `imaginary` floats later.
void turn(const PhaseRound& round, std::ptrdiff_t count, std::ptrdiff_t imaginary, float* turned) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < count; i += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    const Complex z = pushed(load(round.heard, round.heard + imaginary, i),
                             load(round.before, round.before + imaginary, i));
    const Vector magnitude = length(load(round.start, round.start + imaginary, i), kLeastPower);
    const Complex out = scaled(z, hn::Div(magnitude, length(z, kPowerFloor)));
    hn::StoreU(out.re, d, turned + i);
    hn::StoreU(out.im, d, turned + imaginary + i);
  }
}

void turn_back(const PhaseRound& round, std::ptrdiff_t count, std::ptrdiff_t imaginary,
               const float* by_turned, const PhaseSlopes& slopes) {
  const Lanes d;
  const auto add = [&](Complex x, float* to, std::ptrdiff_t i) {
    hn::StoreU(hn::Add(hn::LoadU(d, to + i), x.re), d, to + i);
    hn::StoreU(hn::Add(hn::LoadU(d, to + imaginary + i), x.im), d, to + imaginary + i);
  };
  for (std::ptrdiff_t i = 0; i < count; i += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    const Complex z = pushed(load(round.heard, round.heard + imaginary, i),
                             load(round.before, round.before + imaginary, i));
    const Vector near = hn::Div(hn::Set(d, 1.0F), length(z, kPowerFloor));
    const Complex phase = scaled(z, near);
    const Complex slope = load(by_turned, by_turned + imaginary, i);
    const Complex start = load(round.start, round.start + imaginary, i);
    const Vector magnitude = length(start, kLeastPower);
    const Vector by_magnitude = inner(phase, slope);
    add(scaled(start, hn::Div(by_magnitude, magnitude)), slopes.by_start, i);
    const Vector factor = hn::Mul(magnitude, near);
    const Complex by_z{hn::Mul(hn::NegMulAdd(phase.re, by_magnitude, slope.re), factor),
                       hn::Mul(hn::NegMulAdd(phase.im, by_magnitude, slope.im), factor)};
    add(scaled(by_z, hn::Set(d, 1.0F + kMomentum)), slopes.by_heard, i);
    const Complex by_before = scaled(by_z, hn::Set(d, -kMomentum));
    hn::StoreU(by_before.re, d, slopes.by_before + i);
    hn::StoreU(by_before.im, d, slopes.by_before + imaginary + i);
  }
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {

HWY_EXPORT(turn);
HWY_EXPORT(turn_back);

void turn_to(const FrameExtent& extent, const PhaseRound& round, float* turned) {
  for (std::ptrdiff_t ear = 0; ear < kEars; ++ear) {
    const std::ptrdiff_t at = 2 * ear * extent.plane();
    HWY_DYNAMIC_DISPATCH(turn)
    ({round.start + at, round.heard + at, round.before + at}, extent.plane(), extent.plane(),
     turned + at);
  }
}

void turn_to_back(const FrameExtent& extent, const PhaseRound& round, const float* by_turned,
                  const PhaseSlopes& slopes) {
  for (std::ptrdiff_t ear = 0; ear < kEars; ++ear) {
    const std::ptrdiff_t at = 2 * ear * extent.plane();
    HWY_DYNAMIC_DISPATCH(turn_back)
    ({round.start + at, round.heard + at, round.before + at}, extent.plane(), extent.plane(),
     by_turned + at, {slopes.by_start + at, slopes.by_heard + at, slopes.by_before + at});
  }
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
