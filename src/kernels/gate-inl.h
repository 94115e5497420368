// The gate of the gated stack. Included once per instruction set.

#if defined(EARPOINT_KERNELS_GATE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_GATE_INL_H_
#undef EARPOINT_KERNELS_GATE_INL_H_
#else
#define EARPOINT_KERNELS_GATE_INL_H_
#endif

#include "gate_scale.h"

#include <hwy/highway.h>

#include <earpoint/kernels/elementary-inl.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// sin(tanh(f) * sigmoid(g)), error 3e-7, of scaled rows: `filter` = kFilterScale * f and
/// `gate` = kGateScale * g. With powers of two F and G of these two,
/// tanh(f) * sigmoid(g) = (1 - F) / ((1 + F) (1 + G)).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V gated(D d, V filter, V gate) {
  const V one = hn::Set(d, 1.0F);
  // Up to 2^60: the product below stays finite, and its reciprocal normal.
  const V filter_power = power_of_two(d, filter, 60.0F);
  const V gate_power = power_of_two(d, gate, 60.0F);
  const V denominator_of_tanh = hn::Add(one, filter_power);
  const V denominator = hn::MulAdd(denominator_of_tanh, gate_power, denominator_of_tanh);
  const V numerator = hn::Sub(one, filter_power);
#if HWY_ARCH_X86
  // 12 or 14 good bits, doubled by one step of Newton's method.
  const V guess = hn::ApproximateReciprocal(denominator);
  const V reciprocal = hn::Mul(guess, hn::NegMulAdd(denominator, guess, hn::Set(d, 2.0F)));
  return sine_within_one(d, hn::Mul(numerator, reciprocal));
#else
  return sine_within_one(d, hn::Div(numerator, denominator));
#endif
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
