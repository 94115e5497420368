#include "filter_kernels.h"

#include <algorithm>
#include <cmath>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gtf/filter_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kFrameStep>;
using Vector = hn::Vec<Lanes>;

using gtf::kMagnitudeFloor;
using gtf::kPowerFloor;

HWY_INLINE std::ptrdiff_t lanes() { return static_cast<std::ptrdiff_t>(hn::Lanes(Lanes())); }

/// sums[bin][t] += over `count` rows weights[i][t] * inputs[bin][i][t]
void weigh(const float* const* weights, const float* const* inputs, std::ptrdiff_t count,
           std::ptrdiff_t bins, std::ptrdiff_t row, float* sums) {
  const Lanes d;
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    for (std::ptrdiff_t bin = 0; bin < bins; ++bin) {
      const float* const* from = inputs + bin * count;
      Vector even = hn::Zero(d);
      Vector odd = hn::Zero(d);
      std::ptrdiff_t i = 0;
      for (; i + 2 <= count; i += 2) {
        even = hn::MulAdd(hn::LoadU(d, weights[i] + t), hn::LoadU(d, from[i] + t), even);
        odd = hn::MulAdd(hn::LoadU(d, weights[i + 1] + t), hn::LoadU(d, from[i + 1] + t), odd);
      }
      if (i < count)
        even = hn::MulAdd(hn::LoadU(d, weights[i] + t), hn::LoadU(d, from[i] + t), even);
      hn::StoreU(hn::Add(even, odd), d, sums + bin * row + t);
    }
  }
}

/// by_weights[i][t] = over the bins slopes[bin][t] * inputs[bin][i][t]
void weigh_back(const float* slopes, const float* const* inputs, std::ptrdiff_t count,
                std::ptrdiff_t bins, std::ptrdiff_t row, float* const* by_weights) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
      Vector sum = hn::Zero(d);
      for (std::ptrdiff_t bin = 0; bin < bins; ++bin) {
        sum = hn::MulAdd(hn::LoadU(d, slopes + bin * row + t),
                         hn::LoadU(d, inputs[bin * count + i] + t), sum);
      }
      hn::StoreU(sum, d, by_weights[i] + t);
    }
  }
}

struct Complex {
  Vector re;
  Vector im;
};
HWY_INLINE Complex plus(Complex a, Complex b) { return {hn::Add(a.re, b.re), hn::Add(a.im, b.im)}; }
HWY_INLINE Complex scaled(Complex a, Vector factor) {
  return {hn::Mul(a.re, factor), hn::Mul(a.im, factor)};
}
/// a * (c + i s)
HWY_INLINE Complex turned(Complex a, float c, float s) {
  const Lanes d;
  const Vector cosine = hn::Set(d, c);
  const Vector sine = hn::Set(d, s);
  return {hn::NegMulAdd(a.im, sine, hn::Mul(a.re, cosine)),
          hn::MulAdd(a.re, sine, hn::Mul(a.im, cosine))};
}
/// The real part of conj(a) b.
HWY_INLINE Vector inner(Complex a, Complex b) {
  return hn::MulAdd(a.re, b.re, hn::Mul(a.im, b.im));
}
/// The real part of conj(i a) b.
HWY_INLINE Vector inner_turned(Complex a, Complex b) {
  return hn::NegMulAdd(a.im, b.re, hn::Mul(a.re, b.im));
}

/// One vector of frames of both ears, before and after the change of phase.
struct Mixed {
  Complex voiced[2];  ///< the source's ears with the delay to the speaker removed
  Complex moved[2];   ///< both of them together, with the target's delays
  Complex rest[2];    ///< of the phase: the source's ears, moved or not
  Complex mixed[2];
  Vector length[2];  ///< of mixed
};

HWY_INLINE Mixed mix(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t t) {
  const Lanes d;
  Mixed m;
  for (int ear = 0; ear < 2; ++ear) {
    m.rest[ear] = {hn::LoadU(d, rows.spectrum[2 * ear] + t),
                   hn::LoadU(d, rows.spectrum[2 * ear + 1] + t)};
    m.voiced[ear] = turned(m.rest[ear], turns.source_cosine[ear], turns.source_sine[ear]);
  }
  const Complex voice = plus(m.voiced[0], m.voiced[1]);
  for (int ear = 0; ear < 2; ++ear) {
    m.moved[ear] = turned(voice, turns.target_cosine[ear], -turns.target_sine[ear]);
    if (turns.moves_ears) {
      m.rest[ear] = turned(m.voiced[ear], turns.target_cosine[ear], -turns.target_sine[ear]);
    }
    m.mixed[ear] = plus(scaled(m.moved[ear], hn::Set(d, 0.5F * turns.share[ear])),
                        scaled(m.rest[ear], hn::Set(d, 1.0F - turns.share[ear])));
    m.length[ear] = hn::Sqrt(hn::Add(inner(m.mixed[ear], m.mixed[ear]), hn::Set(d, kPowerFloor)));
  }
  return m;
}

HWY_INLINE Vector gain_of(const float* gain) {
  const Lanes d;
  return hn::Exp(d, hn::Min(hn::Max(hn::LoadU(d, gain), hn::Set(d, gtf::kLeastLogGain)),
                            hn::Set(d, gtf::kMostLogGain)));
}

void mix_row(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
             float* const* spectrum) {
  const Lanes d;
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Mixed m = mix(rows, turns, t);
    for (int ear = 0; ear < 2; ++ear) {
      const Vector filtered = hn::Max(hn::LoadU(d, rows.filtered[ear] + t), hn::Zero(d));
      const Vector magnitude =
          hn::Mul(hn::Add(filtered, hn::Set(d, kMagnitudeFloor)), gain_of(rows.gain[ear] + t));
      const Complex out = scaled(m.mixed[ear], hn::Div(magnitude, m.length[ear]));
      hn::StoreU(out.re, d, spectrum[2 * ear] + t);
      hn::StoreU(out.im, d, spectrum[2 * ear + 1] + t);
    }
  }
}

HWY_INLINE float total(Vector v) {
  const Lanes d;
  return hn::GetLane(hn::SumOfLanes(d, v));
}

void mix_row_back(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
                  const float* const* by_spectrum, float* const* by_filtered, float* const* by_gain,
                  BinSlopes& slopes) {
  const Lanes d;
  Vector by_share[2] = {hn::Zero(d), hn::Zero(d)};
  Vector by_source[2] = {hn::Zero(d), hn::Zero(d)};
  Vector by_target[2] = {hn::Zero(d), hn::Zero(d)};
  for (std::ptrdiff_t t = 0; t < row; t += lanes()) {
    const Mixed m = mix(rows, turns, t);
    Complex by_voice{hn::Zero(d), hn::Zero(d)};
    Complex by_voiced[2] = {by_voice, by_voice};
    for (int ear = 0; ear < 2; ++ear) {
      const Complex slope{hn::LoadU(d, by_spectrum[2 * ear] + t),
                          hn::LoadU(d, by_spectrum[2 * ear + 1] + t)};
      const Vector near = hn::Div(hn::Set(d, 1.0F), m.length[ear]);
      const Complex phase = scaled(m.mixed[ear], near);
      const Vector by_magnitude = inner(phase, slope);

      const Vector filtered = hn::LoadU(d, rows.filtered[ear] + t);
      const Vector gain = hn::LoadU(d, rows.gain[ear] + t);
      const Vector factor = gain_of(rows.gain[ear] + t);
      const auto is_open = hn::Gt(filtered, hn::Zero(d));
      const Vector magnitude = hn::Mul(
          hn::Add(hn::IfThenElseZero(is_open, filtered), hn::Set(d, kMagnitudeFloor)), factor);
      hn::StoreU(hn::IfThenElseZero(is_open, hn::Mul(by_magnitude, factor)), d,
                 by_filtered[ear] + t);
      const auto is_within = hn::And(hn::Ge(gain, hn::Set(d, gtf::kLeastLogGain)),
                                     hn::Le(gain, hn::Set(d, gtf::kMostLogGain)));
      hn::StoreU(hn::IfThenElseZero(is_within, hn::Mul(by_magnitude, magnitude)), d,
                 by_gain[ear] + t);

      // A phase has a gradient only perpendicular to itself, except for the floor of its length.
      const Complex across = plus(slope, scaled(phase, hn::Neg(by_magnitude)));
      const Complex by_mixed = scaled(across, hn::Mul(magnitude, near));
      const Vector half = hn::Set(d, 0.5F);
      by_share[ear] = hn::Add(by_share[ear], hn::Sub(hn::Mul(half, inner(m.moved[ear], by_mixed)),
                                                     inner(m.rest[ear], by_mixed)));
      const Complex by_moved = scaled(by_mixed, hn::Set(d, 0.5F * turns.share[ear]));
      by_target[ear] = hn::Sub(by_target[ear], inner_turned(m.moved[ear], by_moved));
      by_voice = plus(by_voice, turned(by_moved, turns.target_cosine[ear], turns.target_sine[ear]));
      if (turns.moves_ears) {
        const Complex by_rest = scaled(by_mixed, hn::Set(d, 1.0F - turns.share[ear]));
        by_target[ear] = hn::Sub(by_target[ear], inner_turned(m.rest[ear], by_rest));
        by_voiced[ear] = turned(by_rest, turns.target_cosine[ear], turns.target_sine[ear]);
      }
    }
    for (int ear = 0; ear < 2; ++ear) {
      by_source[ear] =
          hn::Add(by_source[ear], inner_turned(m.voiced[ear], plus(by_voice, by_voiced[ear])));
    }
  }
  for (int ear = 0; ear < 2; ++ear) {
    slopes.by_share[ear] = total(by_share[ear]);
    slopes.by_source_angle[ear] = total(by_source[ear]);
    slopes.by_target_angle[ear] = total(by_target[ear]);
  }
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {

HWY_EXPORT(weigh);
HWY_EXPORT(weigh_back);
HWY_EXPORT(mix_row);
HWY_EXPORT(mix_row_back);

namespace {

/// Calls work(first bin, bins, output ear, rows of its kernels, inputs [bins][kernels]).
template <class Float, class Work>
void for_every_band(const KernelShape& shape, const KernelInputs& inputs, std::ptrdiff_t row,
                    Float* kernels, const Work& work) {
  const std::ptrdiff_t count = kEars * shape.taps();
  std::vector<Float*> rows(static_cast<std::size_t>(count));
  std::vector<const float*> from;
  for (std::ptrdiff_t band = 0; band < shape.bands(); ++band) {
    const std::ptrdiff_t first = shape.edges[band];
    const std::ptrdiff_t bins = shape.edges[band + 1] - first;
    from.clear();
    for (std::ptrdiff_t bin = first; bin < first + bins; ++bin) {
      for (std::ptrdiff_t ear = 0; ear < kEars; ++ear) {
        for (std::ptrdiff_t tap = 0; tap < shape.taps(); ++tap) {
          from.push_back(inputs.at(ear, tap, bin));
        }
      }
    }
    for (std::ptrdiff_t out = 0; out < kEars; ++out) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        rows[i] = kernels + ((out * count + i) * shape.bands() + band) * row;
      }
      work(first, bins, out, rows.data(), from.data());
    }
  }
}

}  // namespace

KernelInputs::KernelInputs(const KernelShape& shape, const FrameExtent& extent,
                           const float* magnitudes)
    : shifts_(shape.shifts()),
      row_(extent.row()),
      padded_row_(extent.row() + shape.past + shape.future),
      shifted_(static_cast<std::size_t>(kEars * kBins * padded_row_)),
      tails_(shape.tails_s.size() * static_cast<std::size_t>(kEars * kBins * row_)) {
  for (std::ptrdiff_t i = 0; i < kEars * kBins; ++i) {
    std::copy_n(magnitudes + i * row_, row_, shifted_.data() + i * padded_row_ + shape.past);
  }
  float* tail = tails_.data();
  for (const double tail_s : shape.tails_s) {
    const auto kept = static_cast<float>(
        std::exp(-double{GtfDescription::kHop} / (GtfDescription::kSampleRateHz * tail_s)));
    // Several rows at a time, as each step needs the last mean of its own row.
    constexpr std::ptrdiff_t kTogether = kBins;
    std::vector<float> means(kTogether);
    for (std::ptrdiff_t first = 0; first < kEars * kBins; first += kTogether) {
      std::ranges::fill(means, 0.0F);
      for (std::ptrdiff_t i = 0; i < kTogether; i += 8) {
        const std::ptrdiff_t last = std::min(kTogether, i + 8);
        for (std::ptrdiff_t t = 0; t < extent.frames(); ++t) {
          for (std::ptrdiff_t j = i; j < last; ++j) {
            const std::ptrdiff_t at = (first + j) * row_ + t;
            means[j] = kept * means[j] + (1.0F - kept) * magnitudes[at];
            tail[at] = means[j];
          }
        }
      }
    }
    tail += kEars * kBins * row_;
  }
}

void apply_kernels(const KernelShape& shape, const KernelInputs& inputs, std::ptrdiff_t row,
                   const float* kernels, float* filtered) {
  for_every_band(shape, inputs, row, kernels,
                 [&](std::ptrdiff_t first, std::ptrdiff_t bins, std::ptrdiff_t out,
                     const float* const* rows, const float* const* from) {
                   HWY_DYNAMIC_DISPATCH(weigh)
                   (rows, from, kEars * shape.taps(), bins, row,
                    filtered + (out * kBins + first) * row);
                 });
}

void apply_kernels_back(const KernelShape& shape, const KernelInputs& inputs, std::ptrdiff_t row,
                        const float* by_filtered, float* by_kernels) {
  for_every_band(shape, inputs, row, by_kernels,
                 [&](std::ptrdiff_t first, std::ptrdiff_t bins, std::ptrdiff_t out,
                     float* const* rows, const float* const* from) {
                   HWY_DYNAMIC_DISPATCH(weigh_back)
                   (by_filtered + (out * kBins + first) * row, from, kEars * shape.taps(), bins,
                    row, rows);
                 });
}

void mix_bin(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
             float* const* spectrum) {
  HWY_DYNAMIC_DISPATCH(mix_row)(rows, turns, row, spectrum);
}

BinSlopes mix_bin_back(const BinRows& rows, const BinTurns& turns, std::ptrdiff_t row,
                       const float* const* by_spectrum, float* const* by_filtered,
                       float* const* by_gain) {
  BinSlopes slopes{};
  HWY_DYNAMIC_DISPATCH(mix_row_back)
  (rows, turns, row, by_spectrum, by_filtered, by_gain, slopes);
  return slopes;
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
