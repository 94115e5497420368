#include "frame_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gtf/frame_planes.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kFrameStep>;
using Vector = hn::Vec<Lanes>;

struct Complex {
  Vector re;
  Vector im;
};
HWY_INLINE Complex plus(Complex a, Complex b) { return {hn::Add(a.re, b.re), hn::Add(a.im, b.im)}; }
HWY_INLINE Complex minus(Complex a, Complex b) {
  return {hn::Sub(a.re, b.re), hn::Sub(a.im, b.im)};
}
HWY_INLINE Complex times(Complex a, Vector re, Vector im) {
  return {hn::NegMulAdd(a.im, im, hn::Mul(a.re, re)), hn::MulAdd(a.re, im, hn::Mul(a.im, re))};
}

HWY_INLINE Complex load(const float* re, const float* im, std::ptrdiff_t at) {
  const Lanes d;
  return {hn::LoadU(d, re + at), hn::LoadU(d, im + at)};
}
HWY_INLINE void store(Complex x, float* re, float* im, std::ptrdiff_t at) {
  const Lanes d;
  hn::StoreU(x.re, d, re + at);
  hn::StoreU(x.im, d, im + at);
}

/// A self-sorting pass of radix 4 over kFrameStep transforms side by side.
/// @param twiddles  [blocks][3][cosine, sine]
void pass_of_four(std::ptrdiff_t blocks, std::ptrdiff_t stride, const float* twiddles,
                  const float* in_re, const float* in_im, float* out_re, float* out_im) {
  const Lanes d;
  const std::ptrdiff_t width = stride * kFrameStep;
  const std::ptrdiff_t step = blocks * width;
  for (std::ptrdiff_t p = 0; p < blocks; ++p, twiddles += 6) {
    Vector turn[6];
    for (int i = 0; i < 6; ++i) turn[i] = hn::Set(d, twiddles[i]);
    for (std::ptrdiff_t q = 0; q < width; q += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
      const std::ptrdiff_t in = p * width + q;
      const std::ptrdiff_t out = 4 * p * width + q;
      const Complex v0 = load(in_re, in_im, in);
      const Complex v1 = load(in_re, in_im, in + step);
      const Complex v2 = load(in_re, in_im, in + 2 * step);
      const Complex v3 = load(in_re, in_im, in + 3 * step);
      const Complex a = plus(v0, v2);
      const Complex b = minus(v0, v2);
      const Complex c = plus(v1, v3);
      const Complex e = minus(v1, v3);
      const Complex back{e.im, hn::Neg(e.re)};  // times -i
      store(plus(a, c), out_re, out_im, out);
      store(times(plus(b, back), turn[0], turn[1]), out_re, out_im, out + width);
      store(times(minus(a, c), turn[2], turn[3]), out_re, out_im, out + 2 * width);
      store(times(minus(b, back), turn[4], turn[5]), out_re, out_im, out + 3 * width);
    }
  }
}

/// The last pass, of radix 2, which needs no twiddles.
void pass_of_two(std::ptrdiff_t stride, const float* in_re, const float* in_im, float* out_re,
                 float* out_im) {
  const Lanes d;
  const std::ptrdiff_t width = stride * kFrameStep;
  for (std::ptrdiff_t q = 0; q < width; q += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    const Complex v0 = load(in_re, in_im, q);
    const Complex v1 = load(in_re, in_im, q + width);
    store(plus(v0, v1), out_re, out_im, q);
    store(minus(v0, v1), out_re, out_im, q + width);
  }
}

/// One bin of both ears from the transform of left + i right, and the inverse.
void split_bin(const float* re, const float* im, std::ptrdiff_t bin, std::ptrdiff_t mirror,
               float scale, float* const* planes, std::ptrdiff_t at) {
  const Lanes d;
  const Vector factor = hn::Set(d, scale);
  for (std::ptrdiff_t q = 0; q < kFrameStep; q += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    const Complex a = load(re, im, bin * kFrameStep + q);
    const Complex b = load(re, im, mirror * kFrameStep + q);
    hn::StoreU(hn::Mul(factor, hn::Add(a.re, b.re)), d, planes[0] + at + q);
    hn::StoreU(hn::Mul(factor, hn::Sub(a.im, b.im)), d, planes[1] + at + q);
    hn::StoreU(hn::Mul(factor, hn::Add(a.im, b.im)), d, planes[2] + at + q);
    hn::StoreU(hn::Mul(factor, hn::Sub(b.re, a.re)), d, planes[3] + at + q);
  }
}

/// With re and im exchanged, the forward transform is the inverse one.
void join_bin(const float* const* planes, std::ptrdiff_t at, std::ptrdiff_t bin,
              std::ptrdiff_t mirror, float scale, float* re, float* im) {
  const Lanes d;
  const Vector factor = hn::Set(d, scale);
  const bool is_real = bin % (GtfDescription::kFftSize / 2) == 0;
  for (std::ptrdiff_t q = 0; q < kFrameStep; q += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
    Vector part[4];
    for (int i = 0; i < 4; ++i) part[i] = hn::Mul(factor, hn::LoadU(d, planes[i] + at + q));
    if (is_real) part[1] = part[3] = hn::Zero(d);
    store({hn::Add(part[0], hn::Neg(part[3])), hn::Add(part[1], part[2])}, re, im,
          bin * kFrameStep + q);
    if (is_real) continue;
    store({hn::Add(part[0], part[3]), hn::Sub(part[2], part[1])}, re, im, mirror * kFrameStep + q);
  }
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {
namespace {

using D = GtfDescription;

HWY_EXPORT(pass_of_four);
HWY_EXPORT(pass_of_two);
HWY_EXPORT(split_bin);
HWY_EXPORT(join_bin);

constexpr std::ptrdiff_t kSize = D::kFftSize;
constexpr std::ptrdiff_t kWindowStart = (D::kFftSize - D::kFrameSamples) / 2;
constexpr int kPasses = 4;  // of radix 4, before the one of radix 2: 4^4 * 2 = 512
static_assert(kSize == 512);

/// The window and the roots of unity.
struct Tables {
  std::vector<float> window;
  std::vector<float> twiddles[kPasses];

  Tables() : window(D::kFrameSamples) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    for (int i = 0; i < D::kFrameSamples; ++i) {
      window[i] = static_cast<float>(0.54 - 0.46 * std::cos(kTurn * i / D::kFrameSamples));
    }
    std::ptrdiff_t blocks = kSize / 4;
    for (std::vector<float>& factors : twiddles) {
      const std::ptrdiff_t stride = kSize / 4 / blocks;
      for (std::ptrdiff_t p = 0; p < blocks; ++p) {
        for (int k = 1; k < 4; ++k) {
          const double angle = -kTurn * static_cast<double>(p * k * stride) / kSize;
          factors.push_back(static_cast<float>(std::cos(angle)));
          factors.push_back(static_cast<float>(std::sin(angle)));
        }
      }
      blocks /= 4;
    }
  }
};

const Tables& tables() {
  static const Tables kTables;
  return kTables;
}

/// kFrameStep frames, interleaved, and the second buffer of the passes.
struct Block {
  std::vector<float> re = std::vector<float>(kSize * kFrameStep);
  std::vector<float> im = re;
  std::vector<float> other_re = re;
  std::vector<float> other_im = re;

  void transform() {
    std::ptrdiff_t blocks = kSize / 4;
    std::ptrdiff_t stride = 1;
    for (const std::vector<float>& twiddles : tables().twiddles) {
      HWY_DYNAMIC_DISPATCH(pass_of_four)
      (blocks, stride, twiddles.data(), re.data(), im.data(), other_re.data(), other_im.data());
      re.swap(other_re);
      im.swap(other_im);
      blocks /= 4;
      stride *= 4;
    }
    HWY_DYNAMIC_DISPATCH(pass_of_two)
    (stride, re.data(), im.data(), other_re.data(), other_im.data());
    re.swap(other_re);
    im.swap(other_im);
  }
};

Block& block() {
  thread_local Block kBlock;
  return kBlock;
}

/// The windowed frames from `first` on, left ear real and right ear imaginary.
void cut(const FrameExtent& extent, const float* sound, std::ptrdiff_t first, Block& to) {
  std::ranges::fill(to.re, 0.0F);
  std::ranges::fill(to.im, 0.0F);
  const std::vector<float>& window = tables().window;
  const std::ptrdiff_t count = std::min(kFrameStep, extent.frames() - first);
  for (std::ptrdiff_t lane = 0; lane < count; ++lane) {
    const std::ptrdiff_t start = (first + lane) * D::kHop - kSize / 2 + kWindowStart;
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -start);
    const std::ptrdiff_t end = std::min<std::ptrdiff_t>(D::kFrameSamples, extent.samples - start);
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      const std::ptrdiff_t at = (kWindowStart + i) * kFrameStep + lane;
      to.re[at] = window[i] * sound[start + i];
      to.im[at] = window[i] * sound[extent.samples + start + i];
    }
  }
}

/// Adds the windowed frames from `first` on to the sound.
void paste(const FrameExtent& extent, const Block& from, std::ptrdiff_t first, float* sound) {
  const std::vector<float>& window = tables().window;
  const std::ptrdiff_t count = std::min(kFrameStep, extent.frames() - first);
  for (std::ptrdiff_t lane = 0; lane < count; ++lane) {
    const std::ptrdiff_t start = (first + lane) * D::kHop - kSize / 2 + kWindowStart;
    const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -start);
    const std::ptrdiff_t end = std::min<std::ptrdiff_t>(D::kFrameSamples, extent.samples - start);
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      const std::ptrdiff_t at = (kWindowStart + i) * kFrameStep + lane;
      sound[start + i] += window[i] * from.re[at];
      sound[extent.samples + start + i] += window[i] * from.im[at];
    }
  }
}

template <typename Float>
std::array<Float*, 4> planes_of(const FrameExtent& extent, Float* spectrum) {
  const std::ptrdiff_t plane = extent.plane();
  return {spectrum, spectrum + plane, spectrum + 2 * plane, spectrum + 3 * plane};
}

/// @param scale  of the transform  @param edge  besides, of the bins that are real
void to_spectrum(const FrameExtent& extent, const float* sound, float scale, float edge,
                 float* spectrum) {
  const auto planes = planes_of(extent, spectrum);
  Block& frames = block();
  for (std::ptrdiff_t first = 0; first < extent.row(); first += kFrameStep) {
    cut(extent, sound, first, frames);
    frames.transform();
    for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
      const float factor = bin % (kSize / 2) == 0 ? edge : 1.0F;
      HWY_DYNAMIC_DISPATCH(split_bin)
      (frames.re.data(), frames.im.data(), bin, (kSize - bin) % kSize, 0.5F * scale * factor,
       planes.data(), bin * extent.row() + first);
    }
  }
}

/// @param scale  of the inverse transform  @param edge  besides, of the bins that are real
void to_sound(const FrameExtent& extent, const float* spectrum, float scale, float edge,
              float* sound) {
  const auto planes = planes_of(extent, spectrum);
  std::fill_n(sound, kEars * extent.samples, 0.0F);
  Block& frames = block();
  for (std::ptrdiff_t first = 0; first < extent.row(); first += kFrameStep) {
    for (std::ptrdiff_t bin = 0; bin < kBins; ++bin) {
      const float factor = bin % (kSize / 2) == 0 ? edge : 1.0F;
      HWY_DYNAMIC_DISPATCH(join_bin)
      (planes.data(), bin * extent.row() + first, bin, (kSize - bin) % kSize, scale * factor,
       frames.im.data(), frames.re.data());
    }
    frames.transform();
    frames.re.swap(frames.im);
    paste(extent, frames, first, sound);
  }
}

/// One over the sum of the squared windows; kept between calls.
const std::vector<float>& window_shares(const FrameExtent& extent) {
  thread_local std::vector<float> sums;
  if (std::ssize(sums) == extent.samples) return sums;
  sums.assign(static_cast<std::size_t>(extent.samples), 0.0F);
  const std::vector<float>& window = tables().window;
  for (std::ptrdiff_t frame = 0; frame < extent.frames(); ++frame) {
    const std::ptrdiff_t start = frame * D::kHop - kSize / 2 + kWindowStart;
    for (std::ptrdiff_t i = 0; i < D::kFrameSamples; ++i) {
      if (start + i < 0 || start + i >= extent.samples) continue;
      sums[start + i] += window[i] * window[i];
    }
  }
  for (float& sum : sums) sum = 1.0F / sum;
  return sums;
}

/// @param from, to  [2][samples]; may be the same
void multiply_by_shares(const FrameExtent& extent, const float* from, float* to) {
  const std::vector<float>& shares = window_shares(extent);
  for (std::ptrdiff_t ear = 0; ear < kEars; ++ear) {
    for (std::ptrdiff_t i = 0; i < extent.samples; ++i) {
      to[ear * extent.samples + i] = from[ear * extent.samples + i] * shares[i];
    }
  }
}

}  // namespace

void analyse(const FrameExtent& extent, const float* sound, float* spectrum) {
  to_spectrum(extent, sound, 1.0F, 1.0F, spectrum);
}

void synthesise(const FrameExtent& extent, const float* spectrum, float* sound) {
  to_sound(extent, spectrum, 1.0F / kSize, 1.0F, sound);
  multiply_by_shares(extent, sound, sound);
}

void analyse_back(const FrameExtent& extent, const float* by_spectrum, float* by_sound) {
  // The real part of the sum over half of the spectrum, which the other half mirrors.
  to_sound(extent, by_spectrum, 0.5F, 2.0F, by_sound);
}

void synthesise_back(const FrameExtent& extent, const float* by_sound, float* by_spectrum) {
  std::vector<float> scaled(static_cast<std::size_t>(kEars * extent.samples));
  multiply_by_shares(extent, by_sound, scaled.data());
  to_spectrum(extent, scaled.data(), 2.0F / kSize, 0.5F, by_spectrum);
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
