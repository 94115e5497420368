#include "early_field.h"

#include "hrir_shifter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <earpoint/audio/fft.h>
#include <earpoint/spatial/air_absorption.h>

namespace earpoint {
namespace {

constexpr std::size_t kInterpolated = 256;

/// Both ears' sound of one band before the band's filter, as a circular signal.
using BandSound = std::array<std::vector<float>, 2>;

// Adds a response at a place of a circular signal, with a gain per band.
void add_response(std::span<const float> response, std::ptrdiff_t place, const BandArray& gain,
                  int ear, std::span<BandSound> bands) {
  const std::ptrdiff_t size = std::ssize(bands[0][ear]);
  place = (place % size + size) % size;
  for (int band = 0; band < kOctaveBands; ++band) {
    float* const to = bands[band][ear].data();
    const std::ptrdiff_t before_end = std::min(std::ssize(response), size - place);
    for (std::ptrdiff_t i = 0; i < before_end; ++i) to[place + i] += gain[band] * response[i];
    for (std::ptrdiff_t i = before_end; i < std::ssize(response); ++i) {
      to[place + i - size] += gain[band] * response[i];
    }
  }
}

}  // namespace

void add_early_binaural(const ResponseShape& shape, const OctaveBank& bank,
                        std::span<const Arrival> arrivals, const Quaternion& world_from_listener,
                        const HrtfSet& hrtf, std::span<std::vector<float>> ears) {
  // What begins or rings before the response wraps to the end of the circular signal, past its
  // samples.
  std::array<BandSound, kOctaveBands> bands;
  for (BandSound& band : bands) band.fill(std::vector<float>(shape.fft_size));
  HrirShifter shifter(hrtf.taps());
  std::vector<float> shifted(shifter.size());
  const Quaternion listener_from_world = conjugate(world_from_listener);
  const double air_m_per_s = speed_of_sound_m_per_s(Air{});
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const Arrival& arrival = arrivals[i];
    const double position = arrival.delay_s * shape.sample_rate_hz - hrtf.centre_delay_samples();
    const auto whole = static_cast<std::ptrdiff_t>(std::floor(position));
    if (whole >= shape.samples) break;
    const Vector3 direction = rotate(listener_from_world, arrival.direction);
    const double travelled_m = std::max(1e-3, arrival.delay_s * air_m_per_s);
    const std::size_t nearest = i < kInterpolated ? 0 : hrtf.nearest(direction);
    const Hrir hrir = i < kInterpolated ? hrtf.interpolated(direction, travelled_m) : Hrir{};
    for (int ear = 0; ear < 2; ++ear) {
      const std::span<const float> taps =
          i < kInterpolated ? std::span<const float>(hrir.taps[ear]) : hrtf.response(nearest, ear);
      shifter.shift(taps, position - static_cast<double>(whole), shifted);
      add_response(shifted, whole - shifter.lead(), arrival.gain, ear, bands);
    }
  }

  RealFft<float> fft(shape.fft_size);
  std::vector<std::complex<float>> spectrum(fft.bins());
  for (int ear = 0; ear < 2; ++ear) {
    std::vector<std::complex<float>> sum(fft.bins());
    for (int band = 0; band < kOctaveBands; ++band) {
      fft.forward(bands[band][ear], spectrum);
      const std::span<const float> weights = bank.weights(band);
      for (std::size_t bin = 0; bin < sum.size(); ++bin) sum[bin] += weights[bin] * spectrum[bin];
    }
    std::vector<float>& sound = bands[0][ear];
    fft.inverse(sum, sound);
    for (std::size_t i = 0; i < ears[ear].size(); ++i) ears[ear][i] += sound[i];
  }
}

}  // namespace earpoint
