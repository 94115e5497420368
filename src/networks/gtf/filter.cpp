#include "filter.h"

#include <algorithm>
#include <cmath>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/pose.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;
using Complex = std::complex<float>;

std::vector<float> values_of(const GtfWeights& weights, const char* name) {
  const auto values = weights.at(name).as<float>();
  return {values.begin(), values.end()};
}

/// sum[i] += weight * x[i]
void add_scaled(float* __restrict sum, const float* __restrict x, float weight, int count) {
  for (int i = 0; i < count; ++i) sum[i] += weight * x[i];
}

// Written out because std::complex's product checks for NaN.
Complex product(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// e^(i omega delay) of every bin.
void fill_phasors(double delay_s, std::span<Complex> phasors) {
  for (std::size_t bin = 0; bin < phasors.size(); ++bin) {
    const double angle =
        2.0 * kPi * D::kSampleRateHz / D::kFftSize * static_cast<double>(bin) * delay_s;
    phasors[bin] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }
}

/// Gives every bin the value of its band of the head tables.
/// @param bands  [2][bands of the head]
/// @param bins  [2][bins]
void spread_over_bins(std::span<const float> bands, std::span<float> bins) {
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    for (std::size_t band = 0; band < D::kHeadBands; ++band) {
      std::fill(bins.begin() + ear * D::kBins + kGtfHeadEdges[band],
                bins.begin() + ear * D::kBins + kGtfHeadEdges[band + 1],
                bands[ear * D::kHeadBands + band]);
    }
  }
}

}  // namespace

GtfFilter::GtfFilter(const GtfWeights& weights, std::ptrdiff_t most_frames)
    : description_(weights.description),
      edges_(gtf_band_edges(description_.bands).value()),
      kernel_(weights.at("kernel.weight").as<float>(), weights.at("kernel.bias").elements()),
      gain_(weights.at("gain.weight").as<float>(), weights.at("gain.bias").elements()),
      static_kernel_(dense_of(weights, "kernel.static")),
      static_gain_(dense_of(weights, "gain.static")),
      kernel_bias_own_(values_of(weights, "kernel.bias")),
      gain_bias_own_(values_of(weights, "gain.bias")),
      kernel_bias_(kernel_.row()),
      gain_bias_(gain_.row()),
      kernels_(most_frames * kernel_.row()),
      gains_(most_frames * gain_.row()),
      tails_(description_.tails_s.size() * kEars * D::kBins),
      magnitude_(static_cast<std::size_t>(kEars) * D::kBins),
      share_(static_cast<std::size_t>(kEars) * description_.bands),
      correction_(magnitude_.size()),
      gather_(magnitude_.size()),
      spread_(magnitude_.size()) {
  if (description_.delays) phase_ = dense_of(weights, "phase");
  if (description_.dry_voice) {
    dry_ = kernels::FrameMatrix(weights.at("dry.weight").as<float>(), D::kBins);
    static_dry_ = dense_of(weights, "dry.static");
    dry_bias_own_ = values_of(weights, "dry.bias");
    dry_bias_ = AlignedFloats(dry_.row());
    dry_gains_ = AlignedFloats(most_frames * dry_.row());
  }
  for (const double tail_s : description_.tails_s) {
    tail_share_.push_back(
        static_cast<float>(std::exp(-double{D::kHop} / (D::kSampleRateHz * tail_s))));
  }
}

void GtfFilter::reset() { std::ranges::fill(tails_, 0.0F); }

void GtfFilter::rescale(float factor) {
  for (float& value : tails_) value *= factor;
}

void GtfFilter::condition(const GtfConditions& conditions) {
  const auto add = [&](const kernels::Dense& layer, const std::vector<float>& own,
                       AlignedFloats& bias) {
    const std::span<float> sum(bias.data(), own.size());
    layer.apply(conditions.vector(), sum);
    for (std::size_t i = 0; i < own.size(); ++i) sum[i] += own[i];
  };
  add(static_kernel_, kernel_bias_own_, kernel_bias_);
  add(static_gain_, gain_bias_own_, gain_bias_);
  if (description_.dry_voice) add(static_dry_, dry_bias_own_, dry_bias_);
  const GtfGeometry* geometry = conditions.geometry();
  if (description_.expected_level) {
    // The correction has not been computed yet.
    spread_over_bins(geometry->expected_log_gain(), correction_);
    for (std::size_t i = 0; i < correction_.size(); ++i) gain_bias_.data()[i] += correction_[i];
  }
  is_corrected_ = geometry != nullptr && geometry->is_beyond();
  if (is_corrected_) spread_over_bins(geometry->correction(), correction_);
  if (!description_.delays) return;
  phase_.apply(conditions.vector(), share_);
  for (float& share : share_) share = 1.0F / (1.0F + std::exp(-share));
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    fill_phasors(geometry->source_delay_s()[ear],
                 std::span(gather_).subspan(ear * D::kBins, D::kBins));
    fill_phasors(-geometry->target_delay_s()[ear],
                 std::span(spread_).subspan(ear * D::kBins, D::kBins));
  }
}

void GtfFilter::read(const float* states, std::ptrdiff_t state_row, std::ptrdiff_t frames) {
  kernel_.multiply(states, state_row, frames, kernel_bias_.data(), kernels_.data(), false);
  gain_.multiply(states, state_row, frames, gain_bias_.data(), gains_.data(), false);
}

void GtfFilter::filter_magnitudes(std::ptrdiff_t index, std::span<const float> magnitudes) {
  constexpr std::size_t kFrame = static_cast<std::size_t>(kEars) * D::kBins;
  const int frames = description_.past_frames + description_.future_frames + 1;
  const int bands = description_.bands;
  EARPOINT_CHECK(magnitudes.size() == frames * kFrame);
  const float* now = magnitudes.data() + description_.past_frames * kFrame;
  for (std::size_t tail = 0; tail < tail_share_.size(); ++tail) {
    const float kept = tail_share_[tail];
    float* mean = tails_.data() + tail * kFrame;
    for (std::size_t i = 0; i < kFrame; ++i) mean[i] = kept * mean[i] + (1.0F - kept) * now[i];
  }
  std::ranges::fill(magnitude_, 0.0F);
  const float* weight = kernels_.data() + index * kernel_.row();
  for (int out = 0; out < kEars; ++out) {
    float* sum = magnitude_.data() + std::ptrdiff_t{out} * D::kBins;
    for (int in = 0; in < kEars; ++in) {
      for (int tap = 0; tap < description_.taps(); ++tap, weight += bands) {
        const float* x = (tap < frames ? magnitudes.data() + std::ptrdiff_t{tap} * kFrame
                                       : tails_.data() + std::ptrdiff_t{tap - frames} * kFrame) +
                         std::ptrdiff_t{in} * D::kBins;
        for (int band = 0; band < bands; ++band) {
          const int first = edges_[band];
          add_scaled(sum + first, x + first, weight[band], edges_[band + 1] - first);
        }
      }
    }
  }
  const float* gain = gains_.data() + index * gain_.row();
  for (std::size_t i = 0; i < magnitude_.size(); ++i) {
    magnitude_[i] = (std::max(magnitude_[i], 0.0F) + gtf::kMagnitudeFloor) *
                    std::exp(std::clamp(gain[i], gtf::kLeastLogGain, gtf::kMostLogGain));
  }
  if (!is_corrected_) return;
  for (std::size_t i = 0; i < magnitude_.size(); ++i) magnitude_[i] *= correction_[i];
}

void GtfFilter::turn_phases(std::span<const Complex> spectrum, std::span<Complex> filtered) const {
  for (int band = 0; band < description_.bands; ++band) {
    for (int bin = edges_[band]; bin < edges_[band + 1]; ++bin) {
      const Complex left = spectrum[bin];
      const Complex right = spectrum[D::kBins + bin];
      const Complex voiced[kEars] = {product(left, gather_[bin]),
                                     product(right, gather_[D::kBins + bin])};
      const Complex voice = voiced[0] + voiced[1];
      for (int ear = 0; ear < kEars; ++ear) {
        const int at = ear * D::kBins + bin;
        const float share = share_[ear * description_.bands + band];
        const Complex rest =
            description_.ear_delays ? product(voiced[ear], spread_[at]) : spectrum[at];
        filtered[at] = product(voice, spread_[at]) * (0.5F * share) + rest * (1.0F - share);
      }
    }
  }
}

void GtfFilter::filter(std::ptrdiff_t index, std::span<const float> magnitudes,
                       std::span<const Complex> spectrum, std::span<Complex> filtered) {
  EARPOINT_CHECK(spectrum.size() == magnitude_.size() && filtered.size() == magnitude_.size());
  filter_magnitudes(index, magnitudes);
  if (description_.delays) {
    turn_phases(spectrum, filtered);
  } else {
    std::ranges::copy(spectrum, filtered.begin());
  }
  for (std::size_t i = 0; i < filtered.size(); ++i) {
    const Complex x = filtered[i];
    filtered[i] *=
        magnitude_[i] / std::sqrt(x.real() * x.real() + x.imag() * x.imag() + gtf::kPowerFloor);
  }
}

void GtfFilter::read_voice(const float* states, std::ptrdiff_t state_row, std::ptrdiff_t frames) {
  dry_.multiply(states, state_row, frames, dry_bias_.data(), dry_gains_.data(), false);
}

void GtfFilter::tell_voice(std::ptrdiff_t index, std::span<const float> magnitudes,
                           std::span<const Complex> spectrum, std::span<Complex> voice) const {
  const float* gain = dry_gains_.data() + index * dry_.row();
  for (std::size_t bin = 0; bin < D::kBins; ++bin) {
    Complex sum = spectrum[bin] + spectrum[D::kBins + bin];
    if (description_.delays) {
      sum = product(spectrum[bin], gather_[bin]) +
            product(spectrum[D::kBins + bin], gather_[D::kBins + bin]);
    }
    const float magnitude =
        (0.5F * (magnitudes[bin] + magnitudes[D::kBins + bin]) + gtf::kMagnitudeFloor) *
        std::exp(std::clamp(gain[bin], gtf::kLeastDryLogGain, gtf::kMostDryLogGain));
    const float length =
        std::sqrt(sum.real() * sum.real() + sum.imag() * sum.imag() + gtf::kPowerFloor);
    voice[bin] = voice[D::kBins + bin] = sum * (magnitude / length);
  }
}

}  // namespace earpoint::gtf
