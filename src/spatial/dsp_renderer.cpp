#include <earpoint/spatial/dsp_renderer.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;
using EarSpectra = std::array<std::vector<Complex>, 2>;

constexpr double kFilterLength_s = 0.08;
// Nearer than this a direction means nothing; the distance gain is clamped at 0.2 m anyway.
constexpr double kNearest_m = 0.01;

Spherical seen_from(const Vector3& point_m) {
  Spherical spherical = spherical_from_cartesian(point_m);
  if (spherical.distance_m < kNearest_m) spherical = {.distance_m = kNearest_m};
  return spherical;
}

// Designs filters in the frequency domain at twice their length, then cuts and fades them.
class FilterDesign {
 public:
  explicit FilterDesign(const HrtfSet& hrtf)
      : rate_hz_(hrtf.sample_rate_hz()),
        taps_(2 * static_cast<int>(0.5 * kFilterLength_s * rate_hz_)),
        fft_(fast_fft_size(2 * std::max(taps_, hrtf.taps()))),
        circular_(fft_.size()) {}

  [[nodiscard]] int bins() const { return fft_.bins(); }
  [[nodiscard]] int taps() const { return taps_; }
  [[nodiscard]] int delay_samples() const { return taps_ / 2; }

  void transform(const Hrir& hrir, EarSpectra& spectra) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::fill(circular_, 0.0);
      std::ranges::copy(hrir.taps[ear], circular_.begin());
      spectra[ear].resize(bins());
      fft_.forward(circular_, spectra[ear]);
    }
  }

  // conj(H_e) / (sum |H|^2 + w), in place of H.
  void invert(EarSpectra& ears) const {
    double mean = 0.0;
    for (int bin = 0; bin < bins(); ++bin) {
      mean += (std::norm(ears[0][bin]) + std::norm(ears[1][bin])) / bins();
    }
    for (int bin = 0; bin < bins(); ++bin) {
      const double frequency_hz = static_cast<double>(rate_hz_) * bin / fft_.size();
      const double power = std::norm(ears[0][bin]) + std::norm(ears[1][bin]);
      const double denominator = power + regularisation(frequency_hz) * mean;
      for (int ear = 0; ear < 2; ++ear) {
        ears[ear][bin] = denominator > 0.0 ? std::conj(ears[ear][bin]) / denominator : 0.0;
      }
    }
  }

  // The filter of a spectrum, made causal by the delay, its ends faded over an eighth each.
  void taps_of(std::span<const Complex> spectrum, std::vector<float>& taps) {
    fft_.inverse(spectrum, circular_);
    taps.resize(taps_);
    const int fade = taps_ / 8;
    for (int tap = 0; tap < taps_; ++tap) {
      const int time = tap - delay_samples();
      const double inside = std::min(1.0, (std::min(tap, taps_ - 1 - tap) + 0.5) / fade);
      taps[tap] = static_cast<float>(circular_[time < 0 ? time + fft_.size() : time] * 0.5 *
                                     (1.0 - std::cos(kPi * inside)));
    }
  }

 private:
  static double regularisation(double frequency_hz) {
    const auto rise = [&](double from_hz, double to_hz) {
      return std::clamp((frequency_hz - from_hz) / (to_hz - from_hz), 0.0, 1.0);
    };
    return std::pow(10.0, -3.0 + rise(5000.0, 10000.0) + 2.0 * rise(14000.0, 19000.0));
  }

  int rate_hz_;
  int taps_;
  RealFft<double> fft_;
  std::vector<double> circular_;  // a signal of the transform's size
};

}  // namespace

double distance_gain(double distance_m) { return 0.2 / std::max(0.2, distance_m); }

SourceFilter source_filter(const HrtfSet& hrtf, const Vector3& direction) {
  FilterDesign design(hrtf);
  EarSpectra inverse;
  design.transform(hrtf.interpolated(direction), inverse);
  design.invert(inverse);
  // A response contains the delay to the head's centre, so its inverse makes the sound earlier.
  SourceFilter filter;
  filter.delay_samples =
      design.delay_samples() - static_cast<int>(std::lround(hrtf.centre_delay_samples()));
  for (int ear = 0; ear < 2; ++ear) design.taps_of(inverse[ear], filter.taps[ear]);
  return filter;
}

struct DspFilterDesigner::State {
  explicit State(const HrtfSet& hrtf)
      : heads(hrtf), filters(hrtf), hrir(hrtf.measured(0)), product(filters.bins()) {
    for (EarSpectra* spectra : {&inverse, &forward}) {
      for (std::vector<Complex>& spectrum : *spectra) spectrum.resize(filters.bins());
    }
  }

  void transform_head(Spherical place, EarSpectra& spectra) {
    const double distance_m = std::exchange(place.distance_m, 1.0);
    heads.interpolate(cartesian_from_spherical(place), distance_m, hrir);
    filters.transform(hrir, spectra);
  }

  HrirInterpolator heads;
  FilterDesign filters;
  // Work space.
  Hrir hrir;
  EarSpectra inverse;
  EarSpectra forward;
  std::vector<Complex> product;
};

DspFilterDesigner::DspFilterDesigner(const HrtfSet& hrtf) : state_(std::make_unique<State>(hrtf)) {}
DspFilterDesigner::~DspFilterDesigner() = default;
DspFilterDesigner::DspFilterDesigner(DspFilterDesigner&&) noexcept = default;
DspFilterDesigner& DspFilterDesigner::operator=(DspFilterDesigner&&) noexcept = default;

int DspFilterDesigner::taps() const { return state_->filters.taps(); }
int DspFilterDesigner::delay_samples() const { return state_->filters.delay_samples(); }

void DspFilterDesigner::design(const Spherical& speaker_from_source,
                               const Spherical& speaker_from_target, EarFilterMatrix& matrix) {
  EARPOINT_CHECK(speaker_from_source.distance_m > 0.0 && speaker_from_target.distance_m > 0.0);
  State& s = *state_;
  s.transform_head(speaker_from_source, s.inverse);
  s.filters.invert(s.inverse);
  s.transform_head(speaker_from_target, s.forward);
  const double gain =
      distance_gain(speaker_from_target.distance_m) / distance_gain(speaker_from_source.distance_m);

  matrix.delay_samples = delay_samples();
  for (int target = 0; target < 2; ++target) {
    for (int source = 0; source < 2; ++source) {
      for (int bin = 0; bin < s.filters.bins(); ++bin) {
        s.product[bin] = gain * s.forward[target][bin] * s.inverse[source][bin];
      }
      s.filters.taps_of(s.product, matrix.taps[target][source]);
    }
  }
}

void DspFilterDesigner::design(const Vector3& speaker_m, const Pose& source_from_target,
                               EarFilterMatrix& matrix) {
  const Vector3 from_target = transform_point(inverse(source_from_target), speaker_m);
  design(seen_from(speaker_m), seen_from(from_target), matrix);
}

EarFilterMatrix dsp_filters(const HrtfSet& hrtf, const Spherical& speaker_from_source,
                            const Spherical& speaker_from_target) {
  EarFilterMatrix matrix;
  DspFilterDesigner(hrtf).design(speaker_from_source, speaker_from_target, matrix);
  return matrix;
}

EarFilterMatrix dsp_filters(const HrtfSet& hrtf, const Vector3& speaker_m,
                            const Pose& source_from_target) {
  EarFilterMatrix matrix;
  DspFilterDesigner(hrtf).design(speaker_m, source_from_target, matrix);
  return matrix;
}

Waveform apply_filters(const EarFilterMatrix& filters, const Waveform& binaural) {
  EARPOINT_CHECK(binaural.channels() == 2);
  Waveform out(2, binaural.samples(), binaural.sample_rate_hz());
  for (int target = 0; target < 2; ++target) {
    for (int source = 0; source < 2; ++source) {
      const std::vector<float> part =
          convolve(filters.taps[target][source], binaural.channel(source));
      const std::span<float> sum = out.channel(target);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i + filters.delay_samples];
    }
  }
  return out;
}

}  // namespace earpoint
