#include <earpoint/audio/stereo_check.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kBlock_s = 0.5;
constexpr double kFrame_s = 0.04;
// The band in which the phase shows the delay between the ears.
constexpr double kDelayBandLow_hz = 100.0;
constexpr double kDelayBandHigh_hz = 1500.0;
constexpr double kCopyBandHigh_hz = 7000.0;
constexpr double kLargestDelay_s = 0.9e-3;  // the widest head, sound from the side
constexpr double kDelayStep_s = 10e-6;

struct Phase {
  double omega;
  double weight;
  std::complex<double> coherence;
};

/// The mean of cos(phase - omega delay) over bins, by delay: where it is largest, and how small it
/// becomes.
struct Agreement {
  double largest = -1.0;
  double smallest = 1.0;
  double delay_s = 0.0;  ///< of the largest
};

Agreement agreement_of(std::span<const Phase> phases) {
  const int steps = static_cast<int>(std::lround(kLargestDelay_s / kDelayStep_s));
  double weights = 0.0;
  // What every bin adds, turned from delay to delay: a product instead of a sine.
  std::vector<std::complex<double>> turned, turn;
  for (const Phase& phase : phases) {
    weights += phase.weight;
    turned.push_back(phase.weight * phase.coherence *
                     std::polar(1.0, -phase.omega * steps * kDelayStep_s));
    turn.push_back(std::polar(1.0, phase.omega * kDelayStep_s));
  }
  if (weights <= 0.0) return {0.0, 0.0, 0.0};
  Agreement found;
  for (int step = -steps; step <= steps; ++step) {
    double sum = 0.0;
    for (std::size_t i = 0; i < turned.size(); ++i) {
      sum += turned[i].real();
      turned[i] *= turn[i];
    }
    const double value = sum / weights;
    found.smallest = std::min(found.smallest, value);
    if (value > found.largest) {
      found.largest = value;
      found.delay_s = step * kDelayStep_s;
    }
  }
  return found;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::string_view name_of(StereoKind kind) {
  switch (kind) {
    case StereoKind::plausible:
      return "plausible";
    case StereoKind::one_channel:
      return "one_channel";
    case StereoKind::same:
      return "dual_mono";
    case StereoKind::panned:
      return "panned";
    case StereoKind::inverted:
      return "inverted";
  }
  EARPOINT_CHECK(false);
}

StereoCheck::StereoCheck(int sample_rate_hz)
    : rate_hz_(sample_rate_hz),
      frame_(fast_fft_size(static_cast<int>(kFrame_s * sample_rate_hz))),
      fft_(frame_) {
  EARPOINT_CHECK(sample_rate_hz >= 8000);
  window_.resize(static_cast<std::size_t>(frame_));
  for (int i = 0; i < frame_; ++i) {
    window_[i] = static_cast<float>(0.5 - 0.5 * std::cos(2.0 * kPi * (i + 0.5) / frame_));
  }
  const auto bins = static_cast<std::size_t>(fft_.bins());
  for (int c = 0; c < 2; ++c) {
    spectra_[c].resize(bins);
    power_[c].assign(bins, 0.0);
  }
  cross_.assign(bins, {});
}

void StereoCheck::add(const Waveform& block) {
  EARPOINT_CHECK(block.channels() == 2 && block.sample_rate_hz() == rate_hz_);
  for (int c = 0; c < 2; ++c) {
    samples_[c].insert(samples_[c].end(), block.channel(c).begin(), block.channel(c).end());
  }
  const auto hop = static_cast<std::ptrdiff_t>(frame_ / 2);
  const int frames_of_block = static_cast<int>(kBlock_s * rate_hz_ / static_cast<double>(hop));
  std::ptrdiff_t start = 0;
  std::array<std::vector<float>, 2> windowed;
  for (auto& signal : windowed) signal.resize(static_cast<std::size_t>(frame_));
  for (; start + frame_ <= std::ssize(samples_[0]); start += hop) {
    for (int c = 0; c < 2; ++c) {
      std::transform(window_.begin(), window_.end(), samples_[c].begin() + start,
                     windowed[c].begin(), std::multiplies<>());
      fft_.forward(windowed[c], spectra_[c]);
    }
    add_frame();
    if (frames_ == frames_of_block) end_block();
  }
  for (auto& signal : samples_) signal.erase(signal.begin(), signal.begin() + start);
}

void StereoCheck::add_frame() {
  for (std::size_t k = 0; k < cross_.size(); ++k) {
    const std::complex<double> left = spectra_[0][k];
    const std::complex<double> right = spectra_[1][k];
    power_[0][k] += std::norm(left);
    power_[1][k] += std::norm(right);
    cross_[k] += right * std::conj(left);
  }
  ++frames_;
}

void StereoCheck::end_block() {
  const auto bin_of = [&](double hz) {
    const double bin = std::min(hz, 0.45 * rate_hz_) * frame_ / rate_hz_;
    return static_cast<std::size_t>(std::lround(bin));
  };
  const std::size_t low = bin_of(kDelayBandLow_hz);
  const std::size_t high = bin_of(kDelayBandHigh_hz);
  const std::size_t top = bin_of(kCopyBandHigh_hz);
  double loudest = 0.0;
  for (std::size_t k = low; k <= top; ++k) loudest = std::max(loudest, power_[0][k] + power_[1][k]);

  Finding finding;
  double left = 0.0, right = 0.0, product = 0.0, left_power = 0.0, right_power = 0.0;
  std::vector<Phase> phases;
  std::vector<double> levels;
  constexpr double kFaint = 1e-4;  // of the loudest bin: nothing but noise and coding
  for (std::size_t k = low; k <= top; ++k) {
    const double both = power_[0][k] + power_[1][k];
    left_power += power_[0][k];
    right_power += power_[1][k];
    if (both <= kFaint * loudest || both <= 0.0) continue;
    // All bins have equal weight: at low frequencies, the loudest ones, the ears differ least.
    left += power_[0][k] / both;
    right += power_[1][k] / both;
    product += cross_[k].real() / both;
    if (k > high || power_[0][k] <= 0.0 || power_[1][k] <= 0.0) continue;
    const std::complex<double> coherence = cross_[k] / std::sqrt(power_[0][k] * power_[1][k]);
    phases.push_back(
        {2.0 * kPi * static_cast<double>(k) * rate_hz_ / frame_, std::abs(coherence), coherence});
    levels.push_back(10.0 * std::log10(power_[0][k] / power_[1][k]));
  }
  finding.power = left_power + right_power;
  finding.left_share = finding.power > 0.0 ? left_power / finding.power : 0.5;
  if (left > 0.0 && right > 0.0) {
    finding.residual = 1.0 - product * product / (left * right);
    finding.copy_gain = product / left;
  }
  finding.level_db = median(std::move(levels));
  const Agreement agreement = agreement_of(phases);
  finding.delay_s = agreement.delay_s;
  finding.agreement = agreement.largest;
  finding.inverted_agreement = -agreement.smallest;
  findings_.push_back(finding);

  for (auto& power : power_) std::fill(power.begin(), power.end(), 0.0);
  std::fill(cross_.begin(), cross_.end(), std::complex<double>());
  frames_ = 0;
}

StereoKind StereoCheck::kind() {
  if (findings_.empty() && frames_ > 0) end_block();
  double loudest = 0.0;
  double left = 0.0, power = 0.0;
  for (const Finding& f : findings_) {
    loudest = std::max(loudest, f.power);
    left += f.left_share * f.power;
    power += f.power;
  }
  if (power <= 0.0) return StereoKind::plausible;
  constexpr double kSilent = 1e-3;  // 30 dB: more than any head shadows between 0.1 and 7 kHz
  if (std::min(left, power - left) < kSilent * power) return StereoKind::one_channel;

  constexpr double kQuiet = 1e-3;          // of the loudest half second: pauses
  constexpr double kCopyResidual = 0.01;   // -20 dB; a lossy codec leaves about that
  constexpr double kSameResidual = 0.001;  // -30 dB; the driest room leaves more
  constexpr double kSameLevel_db = 0.7;
  constexpr double kPanned_db = 2.5;
  constexpr double kNoDelay_s = 45e-6;  // 5 degrees off the middle
  constexpr double kInvertedBy = 0.25;
  int blocks = 0, same = 0, panned = 0, inverted = 0, heard_delay = 0;
  for (const Finding& f : findings_) {
    if (f.power < kQuiet * loudest) continue;
    ++blocks;
    const double copy_db = 20.0 * std::log10(std::abs(f.copy_gain) + 1e-9);
    const bool is_copy = f.residual < kCopyResidual && std::abs(copy_db) >= kSameLevel_db;
    const bool has_delay = std::abs(f.delay_s) > kNoDelay_s;
    if (f.inverted_agreement > f.agreement + kInvertedBy) {
      ++inverted;
    } else if (f.residual < kSameResidual && std::abs(copy_db) < kSameLevel_db) {
      ++same;
    } else if (is_copy || (!has_delay && std::abs(f.level_db) > kPanned_db)) {
      ++panned;
    } else if (has_delay) {
      ++heard_delay;
    }
  }
  if (2 * inverted > blocks) return StereoKind::inverted;
  if (10 * same >= 9 * blocks) return StereoKind::same;
  // Sound from straight ahead is no evidence either way.
  if (panned + same >= 3 * heard_delay && 10 * panned >= 3 * blocks) return StereoKind::panned;
  return StereoKind::plausible;
}

}  // namespace earpoint
