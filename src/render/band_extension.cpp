#include <earpoint/render/band_extension.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kMaxGain = 4.0;  // 12 dB: more would raise the noise in a near-empty octave
// The last tenth below Nyquist belongs to the resamplers' slopes.
constexpr double kBandLow = 0.5;
constexpr double kBandHigh = 0.9;
// -120 dB re full scale per sample: less than that is no signal.
constexpr double kSilence = 1e-12;

}  // namespace

BandExtension::BandExtension(std::ptrdiff_t window, std::ptrdiff_t overlap)
    : window_(window),
      overlap_(overlap),
      fft_(static_cast<int>(window)),
      taper_(static_cast<std::size_t>(window)),
      tapered_(taper_.size()),
      spectrum_(taper_.size() / 2 + 1) {
  EARPOINT_CHECK(window > 0 && window % 2 == 0 && 0 <= overlap && 2 * overlap <= window);
  for (std::ptrdiff_t i = 0; overlap > 0 && i <= overlap; ++i) {
    const double sine = std::sin(kPi / 2 * static_cast<double>(i) / static_cast<double>(overlap));
    rising_.push_back(static_cast<float>(sine * sine));
  }
  // Without a taper the strong low bands would leak into the weak top octave.
  for (std::size_t i = 0; i < taper_.size(); ++i) {
    const double sine =
        std::sin(kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(window));
    taper_[i] = static_cast<float>(sine * sine);
  }
}

double BandExtension::top_octave_energy(std::span<const float> samples) {
  std::transform(samples.begin(), samples.end(), taper_.begin(), tapered_.begin(),
                 std::multiplies<>());
  fft_.forward(tapered_, spectrum_);
  const auto bins = static_cast<double>(spectrum_.size() - 1);
  double energy = 0.0;
  for (auto k = static_cast<std::size_t>(kBandLow * bins);
       k < static_cast<std::size_t>(kBandHigh * bins); ++k) {
    energy += std::norm(std::complex<double>(spectrum_[k]));
  }
  return energy;
}

void BandExtension::add_window(const Waveform& input, const Waveform& output) {
  EARPOINT_CHECK(input.samples() == window_ && output.samples() == window_);
  std::array<float, 2> gains{};
  for (int ear = 0; ear < 2; ++ear) {
    const double before = top_octave_energy(input.channel(ear));
    const double after = top_octave_energy(output.channel(ear));
    const double floor = kSilence * static_cast<double>(window_) * static_cast<double>(window_);
    gains[ear] =
        before <= floor ? 1.0F : static_cast<float>(std::min(kMaxGain, std::sqrt(after / before)));
  }
  gains_.push_back(gains);
}

BandExtension::Place BandExtension::place_of(double model_samples) const {
  const auto hop = static_cast<double>(window_ - overlap_);
  const auto window = std::min(static_cast<std::ptrdiff_t>(model_samples / hop),
                               static_cast<std::ptrdiff_t>(gains_.size()) - 1);
  return {window, model_samples - static_cast<double>(window) * hop};
}

float BandExtension::gain_at(int ear, Place place) const {
  const float present = gains_[place.window][ear];
  if (place.window == 0 || place.into >= static_cast<double>(overlap_)) return present;
  const auto before = static_cast<std::size_t>(place.into);
  const auto past = static_cast<float>(place.into - static_cast<double>(before));
  const float rising = rising_[before] + past * (rising_[before + 1] - rising_[before]);
  return gains_[place.window - 1][ear] * (1.0F - rising) + present * rising;
}

float BandExtension::gain(int ear, double model_samples) const {
  EARPOINT_DCHECK(!gains_.empty() && model_samples >= 0.0);
  return gain_at(ear, place_of(model_samples));
}

void BandExtension::add(int ear, double model_start, double model_step, std::span<const float> high,
                        std::span<float> samples) const {
  const auto overlap = static_cast<double>(overlap_);
  const auto hop = static_cast<double>(window_ - overlap_);
  for (std::size_t i = 0; i < high.size();) {
    const Place place = place_of(model_start + model_step * static_cast<double>(i));
    // In the overlap the gain fades; after it the gain is constant until the next window begins.
    const bool fades = place.window > 0 && place.into < overlap;
    const bool is_last = place.window + 1 == std::ssize(gains_);
    std::size_t end = high.size();
    if (fades || !is_last) {
      const double left = std::ceil(((fades ? overlap : hop) - place.into) / model_step);
      end = std::min(end, i + static_cast<std::size_t>(std::max(left, 1.0)));
    }
    if (!fades) {
      const float present = gain_at(ear, place);
      for (; i < end; ++i) samples[i] += present * high[i];
      continue;
    }
    for (Place at = place; i < end; ++i, at.into += model_step) {
      samples[i] += gain_at(ear, at) * high[i];
    }
  }
}

}  // namespace earpoint
