#include "late_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr std::uint64_t kPoolKey = 3;
constexpr std::uint64_t kOffsetKey = 4;
constexpr int kAllSectors = -1;

std::vector<BandArray> powers(const EnergyHistogram& late, int sector, double bin_samples) {
  std::vector<BandArray> result(late.bins());
  for (int bin = 0; bin < late.bins(); ++bin) {
    result[bin] = sector == kAllSectors ? late.bin_energy(bin) : late.at(bin, sector);
    for (float& band : result[bin]) band /= static_cast<float>(bin_samples);
  }
  return result;
}

void add(std::span<const float> from, std::span<float> to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
}

}  // namespace

// The HRTFs of the sectors' middles for one turn of the head.
struct LateField::SectorFilters {
  std::vector<std::array<Spectrum, 2>> spectra;  // [sector][ear]
  std::vector<BandArray> energy;                 // [sector], of both ears together
};

LateField::LateField(const ResponseShape& shape, std::uint64_t seed)
    : shape_(shape),
      bank_(shape.sample_rate_hz, shape.fft_size),
      overlap_(bank_),
      pool_(shape.sample_rate_hz, RandomStream(seed, {kPoolKey}).next()),
      seed_(seed) {}

void LateField::add_noise(const EnergyHistogram& late, int sector, std::ptrdiff_t offset,
                          std::span<float> signal) const {
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  const std::vector<BandArray> power = powers(late, sector, bin_samples);
  for (int band = 0; band < kOctaveBands; ++band) {
    add_shaped_noise(make_envelope(power, bin_samples, band), pool_.band(band), offset, signal);
  }
}

void LateField::add_pulses(std::span<const Arrival> arrivals, PulseTrain& train,
                           Spectrum& sum) const {
  train.clear();
  for (const Arrival& arrival : arrivals) {
    const double position = arrival.delay_s * shape_.sample_rate_hz;
    if (position < shape_.samples) train.add(position, arrival.gain);
  }
  train.add_spectrum(bank_, sum);
}

void LateField::add_mono(const EnergyHistogram& late, std::span<const Arrival> dense,
                         std::uint64_t stream, std::span<float> signal) const {
  RandomStream random(seed_, {kOffsetKey, stream});
  std::vector<float> noise(shape_.samples);
  add_noise(late, kAllSectors, static_cast<std::ptrdiff_t>(random.index(pool_.size())), noise);
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  std::vector<BandArray> expected = powers(late, kAllSectors, bin_samples);
  for (BandArray& bands : expected) bands = overlap_.through(bands);
  RealFft<float> fft(shape_.fft_size);
  level_noise(expected, bin_samples, bank_, shape_.sample_rate_hz, fft, {&noise, 1});
  add(noise, signal);

  if (dense.empty()) return;
  Spectrum sum(fft.bins());
  PulseTrain train(shape_.fft_size);
  add_pulses(dense, train, sum);
  std::vector<float> pulses(shape_.fft_size);
  fft.inverse(sum, pulses);
  add(std::span(pulses).first(signal.size()), signal);
}

LateField::SectorFilters LateField::sector_filters(const Quaternion& world_from_listener,
                                                   const HrtfSet& hrtf, RealFft<float>& fft) const {
  const Quaternion listener_from_world = conjugate(world_from_listener);
  SectorFilters filters;
  filters.spectra.resize(kSectors);
  filters.energy.resize(kSectors);
  // The responses start before the sound passes the middle of the head; the histogram's time is
  // that of the middle.
  Spectrum advance(fft.bins());
  for (int bin = 0; bin < fft.bins(); ++bin) {
    const double turn_rad = 2.0 * kPi * bin * hrtf.centre_delay_samples() / fft.size();
    advance[bin] = std::complex<float>(std::polar(1.0, turn_rad));
  }
  std::vector<float> padded(fft.size());
  for (int sector = 0; sector < kSectors; ++sector) {
    const Hrir hrir = hrtf.interpolated(rotate(listener_from_world, sector_direction(sector)));
    for (int ear = 0; ear < 2; ++ear) {
      Spectrum& spectrum = filters.spectra[sector][ear];
      spectrum.resize(fft.bins());
      std::copy(hrir.taps[ear].begin(), hrir.taps[ear].end(), padded.begin());
      fft.forward(padded, spectrum);
      for (std::size_t bin = 0; bin < spectrum.size(); ++bin) spectrum[bin] *= advance[bin];
      for (int band = 0; band < kOctaveBands; ++band) {
        const std::span<const float> weights = bank_.weights(band);
        double passed = 0.0;
        double all = 0.0;
        for (std::size_t bin = 0; bin < spectrum.size(); ++bin) {
          const float weight = weights[bin] * weights[bin];
          passed += weight * std::norm(spectrum[bin]);
          all += weight;
        }
        filters.energy[sector][band] += static_cast<float>(passed / all);
      }
    }
  }
  return filters;
}

void LateField::add_binaural(const EnergyHistogram& late, std::span<const Arrival> dense,
                             const Quaternion& world_from_listener, const HrtfSet& hrtf,
                             std::uint64_t stream, std::span<std::vector<float>> ears) const {
  RealFft<float> fft(shape_.fft_size);
  const SectorFilters filters = sector_filters(world_from_listener, hrtf, fft);
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  const auto room = static_cast<std::size_t>(shape_.fft_size);
  std::array<Spectrum, 2> noise_sum = {Spectrum(fft.bins()), Spectrum(fft.bins())};
  std::array<Spectrum, 2> pulse_sum = {Spectrum(fft.bins()), Spectrum(fft.bins())};
  std::array<std::vector<Arrival>, kSectors> dense_by_sector;
  for (const Arrival& arrival : dense) {
    const Vector3& from = arrival.direction;
    dense_by_sector[sector_of(static_cast<float>(from.x), static_cast<float>(from.y),
                              static_cast<float>(from.z))]
        .push_back(arrival);
  }

  // Every sector has its own stretch of the pool, so that the sectors' noises are independent.
  RandomStream random(seed_, {kOffsetKey, stream});
  const auto start = static_cast<std::ptrdiff_t>(random.index(pool_.size()));
  std::vector<BandArray> expected(late.bins());
  std::vector<float> signal(room);
  Spectrum spectrum(fft.bins());
  PulseTrain train(shape_.fft_size);
  for (int sector = 0; sector < kSectors; ++sector) {
    const std::vector<BandArray> power = powers(late, sector, bin_samples);
    for (int bin = 0; bin < late.bins(); ++bin) {
      const BandArray through = overlap_.through(power[bin]);
      for (int band = 0; band < kOctaveBands; ++band) {
        expected[bin][band] += through[band] * filters.energy[sector][band];
      }
    }
    std::fill(signal.begin(), signal.end(), 0.0F);
    const std::ptrdiff_t offset = (start + sector * (pool_.size() / kSectors)) % pool_.size();
    add_noise(late, sector, offset, std::span(signal).first(shape_.samples));
    fft.forward(signal, spectrum);
    for (int ear = 0; ear < 2; ++ear) {
      const Spectrum& filter = filters.spectra[sector][ear];
      for (std::size_t i = 0; i < spectrum.size(); ++i)
        noise_sum[ear][i] += spectrum[i] * filter[i];
    }
    if (dense_by_sector[sector].empty()) continue;
    std::fill(spectrum.begin(), spectrum.end(), 0.0F);
    add_pulses(dense_by_sector[sector], train, spectrum);
    for (int ear = 0; ear < 2; ++ear) {
      const Spectrum& filter = filters.spectra[sector][ear];
      for (std::size_t i = 0; i < spectrum.size(); ++i)
        pulse_sum[ear][i] += spectrum[i] * filter[i];
    }
  }

  std::array<std::vector<float>, 2> noise;
  for (int ear = 0; ear < 2; ++ear) {
    fft.inverse(noise_sum[ear], signal);
    noise[ear].assign(signal.begin(), signal.begin() + shape_.samples);
  }
  level_noise(expected, bin_samples, bank_, shape_.sample_rate_hz, fft, noise);
  for (int ear = 0; ear < 2; ++ear) {
    add(noise[ear], ears[ear]);
    if (dense.empty()) continue;
    fft.inverse(pulse_sum[ear], signal);
    add(std::span(signal).first(ears[ear].size()), ears[ear]);
  }
}

}  // namespace earpoint
