// The transforms of lattice.h as vector code. Included once per instruction set.

#if defined(EARPOINT_KERNELS_LATTICE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_LATTICE_INL_H_
#undef EARPOINT_KERNELS_LATTICE_INL_H_
#else
#define EARPOINT_KERNELS_LATTICE_INL_H_
#endif

#include <hwy/highway.h>

#include <earpoint/kernels/lattice.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// from_inputs * x, lane by lane. The polynomials of row i vanish at all points but the i-th.
template <Scheme kScheme, class D, class V = hn::Vec<D>>
HWY_INLINE void transform_inputs(D d, const V* HWY_RESTRICT x, V* HWY_RESTRICT v) {
  const auto number = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  if constexpr (kScheme == Scheme::four) {
    const V near_even = hn::NegMulAdd(number(kFar * kFar), x[2], x[4]);
    const V near_odd = hn::NegMulAdd(number(kFar * kFar), x[1], x[3]);
    const V far_even = hn::NegMulAdd(number(kNear * kNear), x[2], x[4]);
    const V far_odd = hn::NegMulAdd(number(kNear * kNear), x[1], x[3]);
    v[0] = hn::NegMulAdd(number(2.5), x[2], hn::Add(x[0], x[4]));
    v[1] = hn::MulAdd(number(kNear), near_odd, near_even);
    v[2] = hn::NegMulAdd(number(kNear), near_odd, near_even);
    v[3] = hn::MulAdd(number(kFar), far_odd, far_even);
    v[4] = hn::NegMulAdd(number(kFar), far_odd, far_even);
    v[5] = hn::NegMulAdd(number(2.5), x[3], hn::Add(x[1], x[5]));
  } else if constexpr (kScheme == Scheme::three) {
    const V difference = hn::Sub(x[2], x[0]);
    v[0] = hn::NegMulAdd(number(0.5), x[1], difference);
    v[1] = hn::MulAdd(number(0.5), hn::Sub(x[1], x[0]), x[2]);
    v[2] = hn::MulAdd(number(0.5), x[0], hn::NegMulAdd(number(1.5), x[1], x[2]));
    v[3] = difference;
    v[4] = hn::NegMulSub(number(0.5), difference, x[1]);
  } else if constexpr (kScheme == Scheme::two) {
    v[0] = hn::Add(x[0], x[1]);
    v[1] = x[1];
    v[2] = x[0];
  } else {
    v[0] = x[0];
  }
}

/// to_outputs * m + offset, lane by lane.
template <Scheme kScheme, class D, class V = hn::Vec<D>>
HWY_INLINE void transform_products(D d, const V* HWY_RESTRICT m, V offset, V* HWY_RESTRICT y) {
  const auto number = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  if constexpr (kScheme == Scheme::four) {
    const V near_sum = hn::Add(m[1], m[2]);
    const V near_difference = hn::Sub(m[1], m[2]);
    const V far_sum = hn::Add(m[3], m[4]);
    const V far_difference = hn::Sub(m[3], m[4]);
    y[0] = hn::Add(hn::Add(m[0], offset), hn::Add(near_sum, far_sum));
    y[1] = hn::MulAdd(number(kFar), far_difference,
                      hn::MulAdd(number(kNear), near_difference, offset));
    y[2] = hn::MulAdd(number(kFar * kFar), far_sum,
                      hn::MulAdd(number(kNear * kNear), near_sum, offset));
    y[3] = hn::MulAdd(
        number(kFar * kFar * kFar), far_difference,
        hn::MulAdd(number(kNear * kNear * kNear), near_difference, hn::Add(m[5], offset)));
  } else if constexpr (kScheme == Scheme::three) {
    const V sum = hn::Add(m[1], m[2]);
    y[0] = hn::Add(hn::Add(m[0], offset), hn::Add(sum, m[3]));
    y[1] = hn::MulAdd(number(0.5), m[3], hn::Add(offset, hn::Sub(m[1], m[2])));
    y[2] = hn::MulAdd(number(0.25), m[3], hn::Add(hn::Add(m[4], offset), sum));
  } else if constexpr (kScheme == Scheme::two) {
    const V common = hn::Add(m[0], offset);
    y[0] = hn::Add(common, m[1]);
    y[1] = hn::Add(common, m[2]);
  } else {
    y[0] = hn::Add(m[0], offset);
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
