// Elementary functions. Included once per instruction set.

#if defined(EARPOINT_KERNELS_ELEMENTARY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_ELEMENTARY_INL_H_
#undef EARPOINT_KERNELS_ELEMENTARY_INL_H_
#else
#define EARPOINT_KERNELS_ELEMENTARY_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// 2^x for x in [-100, 100]; x below and above is clamped. Relative error 2e-7; exactly 1 at 0.
/// A polynomial (minimax, relative error 9e-8) for the fraction, the exponent field for the rest.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V power_of_two(D d, V x, float most = 100.0F) {
  // NaN stays NaN. When one operand is NaN, Min and Max give the second on x86 and the number on
  // ARM.
  const V clamped = hn::Min(hn::Set(d, most), hn::Max(hn::Set(d, -100.0F), x));
#if HWY_ARCH_X86
  x = clamped;
#else
  x = hn::IfThenElse(hn::IsNaN(x), x, clamped);
#endif
  const V round_to_integer = hn::Set(d, 12582912.0F);  // 1.5 * 2^23
  const V shifted = hn::Add(x, round_to_integer);
  const V fraction = hn::Sub(x, hn::Sub(shifted, round_to_integer));

  V power = hn::Set(d, 0.0013264727F);
  power = hn::MulAdd(power, fraction, hn::Set(d, 0.0096715128F));
  power = hn::MulAdd(power, fraction, hn::Set(d, 0.0555073374F));
  power = hn::MulAdd(power, fraction, hn::Set(d, 0.2402224208F));
  power = hn::MulAdd(power, fraction, hn::Set(d, 0.6931469776F));
  power = hn::MulAdd(power, fraction, hn::Set(d, 1.0F));

  const hn::RebindToSigned<D> integers;
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(integers, shifted));
  return hn::BitCast(d, hn::Add(hn::BitCast(integers, power), exponent));
}

/// sin(x) for x in [-1, 1]; error 8e-8. Minimax, odd.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V sine_within_one(D d, V x) {
  const V square = hn::Mul(x, x);
  V factor = hn::Set(d, -0.00019283790F);
  factor = hn::MulAdd(factor, square, hn::Set(d, 0.0083297975F));
  factor = hn::MulAdd(factor, square, hn::Set(d, -0.16666599F));
  return hn::MulAdd(hn::Mul(factor, square), x, x);
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
