#include "stream_gains.h"

#include <algorithm>
#include <cmath>

namespace earpoint {
namespace {

constexpr double kLevelMemory_s = 1.0;
constexpr double kBandMemory_s = 0.25;
// As BandExtension has them.
constexpr double kMaxGain = 4.0;
constexpr double kBandLow = 0.5;
constexpr double kBandHigh = 0.9;
constexpr double kSilence = 1e-12;  // per sample
constexpr int kBandOrder = 4;

double kept_per_hop(double hop_s, double memory_s) { return std::exp(-hop_s / memory_s); }

SectionFilter top_octave(int sample_rate_hz) {
  return SectionFilter(butterworth_bandpass(kBandLow * sample_rate_hz / 2.0,
                                            kBandHigh * sample_rate_hz / 2.0, sample_rate_hz,
                                            kBandOrder));
}

double power(SectionFilter& filter, std::span<const float> samples) {
  double sum = 0.0;
  for (const float sample : samples) {
    const double filtered = filter.process(sample);
    sum += filtered * filtered;
  }
  return sum;
}

}  // namespace

StreamLevel::StreamLevel(double hop_s) : kept_(kept_per_hop(hop_s, kLevelMemory_s)) {}

void StreamLevel::reset() {
  sum_ = {};
  result_ = 0.0;
}

float StreamLevel::next(double source, const LevelBounds& bounds, double result) {
  sum_ = {kept_ * sum_.least + source * bounds.least, kept_ * sum_.most + source * bounds.most};
  result_ = kept_ * result_ + result;
  if (result_ <= 0.0) return 1.0F;
  return static_cast<float>(std::sqrt(std::clamp(result_, sum_.least, sum_.most) / result_));
}

StreamBandGain::StreamBandGain(int sample_rate_hz, double hop_s)
    : kept_(kept_per_hop(hop_s, kBandMemory_s)),
      floor_(kSilence * kBandMemory_s * sample_rate_hz),
      before_{top_octave(sample_rate_hz), top_octave(sample_rate_hz)},
      after_{top_octave(sample_rate_hz), top_octave(sample_rate_hz)} {}

void StreamBandGain::reset() {
  for (auto* bands : {&before_, &after_}) {
    for (SectionFilter& band : *bands) band.reset();
  }
  source_ = result_ = {};
}

std::array<float, 2> StreamBandGain::next(std::span<const float> source,
                                          std::span<const float> result) {
  const std::size_t samples = source.size() / 2;
  std::array<float, 2> gains{};
  for (std::size_t ear = 0; ear < 2; ++ear) {
    const std::size_t first = ear * samples;
    source_[ear] = kept_ * source_[ear] + power(before_[ear], source.subspan(first, samples));
    result_[ear] = kept_ * result_[ear] + power(after_[ear], result.subspan(first, samples));
    const double gain = source_[ear] <= floor_ ? 1.0 : std::sqrt(result_[ear] / source_[ear]);
    gains[ear] = static_cast<float>(std::min(gain, kMaxGain));
  }
  return gains;
}

}  // namespace earpoint
