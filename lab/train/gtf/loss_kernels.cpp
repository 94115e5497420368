#include "loss_kernels.h"

#include "frame_planes.h"

#include <cmath>
#include <vector>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gtf/loss_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kFrameStep>;
using Vector = hn::Vec<Lanes>;

constexpr float kPowerFloor = 1e-8F;
// Smaller magnitudes do not count on the logarithmic scale: the noise floor of a quiet room.
constexpr float kQuietMagnitude = 0.02F;
constexpr float kSpreadFloor = 1e-4F;

HWY_INLINE std::ptrdiff_t lanes() { return static_cast<std::ptrdiff_t>(hn::Lanes(Lanes())); }
HWY_INLINE float total(Vector v) {
  const Lanes d;
  return hn::GetLane(hn::SumOfLanes(d, v));
}
/// Mask of the lanes from t on that are frames.
HWY_INLINE auto frames_from(std::ptrdiff_t t, std::ptrdiff_t frames) {
  return hn::FirstN(Lanes(), static_cast<std::size_t>(frames > t ? frames - t : 0));
}

struct Complex {
  Vector re;
  Vector im;
};
HWY_INLINE Complex load(const float* const* planes, int ear, std::ptrdiff_t t) {
  const Lanes d;
  return {hn::LoadU(d, planes[2 * ear] + t), hn::LoadU(d, planes[2 * ear + 1] + t)};
}
HWY_INLINE Vector magnitude(Complex x) {
  const Lanes d;
  return hn::Sqrt(hn::MulAdd(x.re, x.re, hn::MulAdd(x.im, x.im, hn::Set(d, kPowerFloor))));
}
/// left * conj(right)
HWY_INLINE Complex cross(Complex left, Complex right) {
  return {hn::MulAdd(left.re, right.re, hn::Mul(left.im, right.im)),
          hn::MulSub(left.im, right.re, hn::Mul(left.re, right.im))};
}
HWY_INLINE Complex scaled(Complex x, Vector factor) {
  return {hn::Mul(x.re, factor), hn::Mul(x.im, factor)};
}

/// weight times the sign of x, and 0 for 0.
HWY_INLINE Vector signed_weight(float weight, Vector x) {
  const Lanes d;
  return hn::IfThenElseZero(hn::Ne(x, hn::Zero(d)), hn::CopySign(hn::Set(d, weight), x));
}

/// Magnitudes of one ear, and the gradient by the found ones.
struct EarRows {
  float* found;
  float* right;
  float* slope;
};

double magnitude_terms(const BinPair& bin, int ear, const RowWeights& weights, std::ptrdiff_t row,
                       const EarRows& rows) {
  const Lanes d;
  const Vector quiet = hn::Set(d, kQuietMagnitude);
  Vector sum = hn::Zero(d);
  Vector log_sum = hn::Zero(d);
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Vector found = magnitude(load(bin.found, ear, t));
    const Vector right = magnitude(load(bin.right, ear, t));
    const Vector off = hn::Sub(found, right);
    sum = hn::Add(sum, hn::Abs(off));
    Vector slope = signed_weight(weights.magnitude, off);
    if (weights.log_magnitude > 0.0F) {
      const Vector from_quiet = hn::Add(found, quiet);
      const Vector log_off = hn::Sub(hn::Log(d, from_quiet), hn::Log(d, hn::Add(right, quiet)));
      log_sum = hn::Add(log_sum, hn::Abs(log_off));
      slope = hn::Add(slope, hn::Div(signed_weight(weights.log_magnitude, log_off), from_quiet));
    }
    hn::StoreU(found, d, rows.found + t);
    hn::StoreU(right, d, rows.right + t);
    hn::StoreU(slope, d, rows.slope + t);
  }
  return double{weights.magnitude} * total(sum) + double{weights.log_magnitude} * total(log_sum);
}

/// Spread of a row's level over time. @param off  receives the deviation of each frame from the
/// mean
float spread_of(const float* magnitudes, float floor, std::ptrdiff_t frames, std::ptrdiff_t row,
                float* off) {
  const Lanes d;
  Vector sum = hn::Zero(d);
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Vector level = hn::Log(d, hn::Add(hn::LoadU(d, magnitudes + t), hn::Set(d, floor)));
    hn::StoreU(level, d, off + t);
    sum = hn::Add(sum, hn::IfThenElseZero(frames_from(t, frames), level));
  }
  const auto count = static_cast<float>(frames);
  const Vector mean = hn::Set(d, total(sum) / count);
  Vector squares = hn::Zero(d);
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Vector difference =
        hn::IfThenElseZero(frames_from(t, frames), hn::Sub(hn::LoadU(d, off + t), mean));
    hn::StoreU(difference, d, off + t);
    squares = hn::MulAdd(difference, difference, squares);
  }
  return std::sqrt(total(squares) / count + kSpreadFloor);
}

double modulation_term(const RowWeights& weights, std::ptrdiff_t frames, std::ptrdiff_t row,
                       const EarRows& rows, float* off) {
  const Lanes d;
  const float wanted = spread_of(rows.right, weights.modulation_floor, frames, row, off);
  const float spread = spread_of(rows.found, weights.modulation_floor, frames, row, off);
  const float sign = spread > wanted ? 1.0F : spread < wanted ? -1.0F : 0.0F;
  // Deviations from the mean add up to zero, so that the mean does not contribute to the gradient.
  const Vector factor =
      hn::Set(d, sign * weights.modulation / (static_cast<float>(frames) * spread));
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Vector magnitudes = hn::LoadU(d, rows.found + t);
    const Vector slope = hn::Div(hn::Mul(factor, hn::LoadU(d, off + t)),
                                 hn::Add(magnitudes, hn::Set(d, weights.modulation_floor)));
    hn::StoreU(hn::Add(hn::LoadU(d, rows.slope + t), slope), d, rows.slope + t);
  }
  return double{weights.modulation} * std::abs(spread - wanted);
}

/// From gradients by magnitudes to gradients by the spectrum, with those of the interaural phase.
double phase_term(const BinPair& bin, const RowWeights& weights, std::ptrdiff_t frames,
                  std::ptrdiff_t row, const EarRows* ears, float* const* slopes) {
  const Lanes d;
  Vector sum = hn::Zero(d);
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    Complex found[2];
    Complex slope[2];
    for (int ear = 0; ear < 2; ++ear) {
      found[ear] = load(bin.found, ear, t);
      slope[ear] = scaled(found[ear], hn::Div(hn::LoadU(d, ears[ear].slope + t),
                                              hn::LoadU(d, ears[ear].found + t)));
    }
    if (weights.phase_difference > 0.0F) {
      const Vector one = hn::Set(d, 1.0F);
      const Complex ours = cross(found[0], found[1]);
      const Complex theirs = cross(load(bin.right, 0, t), load(bin.right, 1, t));
      const Vector strength = magnitude(theirs);
      const Vector near = hn::Div(one, magnitude(ours));
      const Complex unit = scaled(ours, near);
      const Complex wanted = scaled(theirs, hn::Div(one, strength));
      const Complex off{hn::Sub(unit.re, wanted.re), hn::Sub(unit.im, wanted.im)};
      const Vector distance = magnitude(off);
      const Vector weight =
          hn::IfThenElseZero(frames_from(t, frames),
                             hn::Mul(hn::Set(d, weights.phase_difference), hn::Sqrt(strength)));
      sum = hn::MulAdd(weight, distance, sum);
      const Complex by_unit = scaled(off, hn::Div(weight, distance));
      const Vector along = hn::MulAdd(unit.re, by_unit.re, hn::Mul(unit.im, by_unit.im));
      const Complex by_ours = scaled(
          {hn::NegMulAdd(unit.re, along, by_unit.re), hn::NegMulAdd(unit.im, along, by_unit.im)},
          near);
      // by left: by_ours * right; by right: conj(by_ours) * left
      slope[0].re = hn::Add(
          slope[0].re, hn::NegMulAdd(by_ours.im, found[1].im, hn::Mul(by_ours.re, found[1].re)));
      slope[0].im = hn::Add(slope[0].im,
                            hn::MulAdd(by_ours.re, found[1].im, hn::Mul(by_ours.im, found[1].re)));
      slope[1].re = hn::Add(slope[1].re,
                            hn::MulAdd(by_ours.im, found[0].im, hn::Mul(by_ours.re, found[0].re)));
      slope[1].im = hn::Add(slope[1].im,
                            hn::MulSub(by_ours.re, found[0].im, hn::Mul(by_ours.im, found[0].re)));
    }
    for (int ear = 0; ear < 2; ++ear) {
      hn::StoreU(slope[ear].re, d, slopes[2 * ear] + t);
      hn::StoreU(slope[ear].im, d, slopes[2 * ear + 1] + t);
    }
  }
  return total(sum);
}

void bin_loss(const BinPair& bin, const RowWeights& weights, std::ptrdiff_t frames,
              std::ptrdiff_t row, float* const* slopes, double& loss) {
  thread_local std::vector<float> scratch;
  scratch.resize(static_cast<std::size_t>(7 * row));
  float* const s = scratch.data();
  const EarRows ears[2] = {{s, s + row, s + 2 * row}, {s + 3 * row, s + 4 * row, s + 5 * row}};
  loss = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    loss += magnitude_terms(bin, ear, weights, row, ears[ear]);
    if (weights.modulation > 0.0F) {
      loss += modulation_term(weights, frames, row, ears[ear], s + 6 * row);
    }
  }
  loss += phase_term(bin, weights, frames, row, ears, slopes);
}

void bin_sums(const float* const* planes, std::ptrdiff_t frames, std::ptrdiff_t row,
              double& loudness, double& magnitudes) {
  const Lanes d;
  Vector loud = hn::Zero(d);
  Vector sum = hn::Zero(d);
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const auto mask = frames_from(t, frames);
    const Complex left = load(planes, 0, t);
    const Complex right = load(planes, 1, t);
    loud = hn::Add(loud, hn::IfThenElseZero(mask, hn::Sqrt(magnitude(cross(left, right)))));
    sum = hn::Add(sum, hn::IfThenElseZero(mask, hn::Add(magnitude(left), magnitude(right))));
  }
  loudness = total(loud);
  magnitudes = total(sum);
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {

HWY_EXPORT(bin_loss);
HWY_EXPORT(bin_sums);

double loss_of_bin(const BinPair& bin, const RowWeights& weights, std::ptrdiff_t frames,
                   std::ptrdiff_t row, float* const* slopes) {
  double loss = 0.0;
  HWY_DYNAMIC_DISPATCH(bin_loss)(bin, weights, frames, row, slopes, loss);
  return loss;
}

double loudness_of_bin(const float* const* planes, std::ptrdiff_t frames, std::ptrdiff_t row) {
  double loudness = 0.0;
  double magnitudes = 0.0;
  HWY_DYNAMIC_DISPATCH(bin_sums)(planes, frames, row, loudness, magnitudes);
  return loudness;
}

double magnitude_of_bin(const float* const* planes, std::ptrdiff_t frames, std::ptrdiff_t row) {
  double loudness = 0.0;
  double magnitudes = 0.0;
  HWY_DYNAMIC_DISPATCH(bin_sums)(planes, frames, row, loudness, magnitudes);
  return magnitudes;
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
