#include "late_field.h"

#include "ambisonics.h"
#include "sector_heads.h"

#include <algorithm>
#include <cmath>
#include <complex>

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

// A pulse with a spectrum up to its sharp edge would ring through the whole response and wrap
// around. A roll-off over the top 8 % brings it 100 dB down within 20 ms.
std::vector<float> spectrum_edge(int bins) {
  constexpr double kFallFrom = 0.92;
  std::vector<float> edge(bins);
  for (int bin = 0; bin < bins; ++bin) {
    const double place = static_cast<double>(bin) / (bins - 1);
    const double fall = std::max(0.0, (place - kFallFrom) / (1.0 - kFallFrom));
    edge[bin] = static_cast<float>(0.5 * (1.0 + std::cos(kPi * fall)));
  }
  return edge;
}

void add(std::span<const float> from, std::span<float> to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
}

}  // namespace

LateField::LateField(const ResponseShape& shape, std::uint64_t seed)
    : shape_(shape),
      bank_(shape.sample_rate_hz, shape.fft_size),
      edge_(spectrum_edge(bank_.bins())),
      overlap_(bank_),
      pool_(shape.sample_rate_hz, shape.samples, RandomStream(seed, {kPoolKey}).next()),
      seed_(seed) {}

// Sectors read the pool far apart (a fifth of a stride, 50 ms at 16 kHz, or more), so that the
// common parts of two are not heard together, and at uneven distances, so that no echoes add up.
LateField::SectorOffsets LateField::sector_offsets(std::uint64_t stream) const {
  constexpr double kUneven = 0.8;
  RandomStream random(seed_, {kOffsetKey, stream});
  const auto start = static_cast<double>(random.index(pool_.size()));
  const double stride = static_cast<double>(pool_.size()) / kSectors;
  SectorOffsets offsets;
  for (int sector = 0; sector < kSectors; ++sector) {
    const double place = start + stride * (sector + kUneven * random.uniform());
    offsets[sector] = static_cast<std::ptrdiff_t>(place) % pool_.size();
  }
  return offsets;
}

void LateField::add_noise(const EnergyHistogram& late, int sector, std::ptrdiff_t offset,
                          std::span<float> signal) const {
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  const std::vector<BandArray> power = powers(late, sector, bin_samples);
  for (int band = 0; band < kOctaveBands; ++band) {
    add_shaped_noise(make_envelope(power, bin_samples, band), pool_.band(band), offset, signal);
  }
}

void LateField::add_mono(const EnergyHistogram& late, std::span<const Arrival> arrivals,
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

  if (arrivals.empty()) return;
  PulseTrain train(shape_.fft_size);
  add_pulses(arrivals, std::vector<float>(arrivals.size(), 1.0F), fft, train, signal);
}

// Adds each arrival with its own gain.
void LateField::add_pulses(std::span<const Arrival> arrivals, std::span<const float> gains,
                           RealFft<float>& fft, PulseTrain& train, std::span<float> signal) const {
  train.clear();
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    const double position = arrivals[i].delay_s * shape_.sample_rate_hz;
    if (position >= shape_.samples) continue;
    BandArray gain = arrivals[i].gain;
    for (float& band : gain) band *= gains[i];
    train.add(position, gain);
  }
  std::vector<std::complex<float>> sum(fft.bins());
  train.add_spectrum(bank_, sum);
  for (std::size_t bin = 0; bin < sum.size(); ++bin) sum[bin] *= edge_[bin];
  std::vector<float> pulses(shape_.fft_size);
  fft.inverse(sum, pulses);
  add(std::span(pulses).first(signal.size()), signal);
}

void LateField::add_binaural(const EnergyHistogram& late, const Quaternion& world_from_listener,
                             const HrtfSet& hrtf, std::uint64_t stream,
                             std::span<std::vector<float>> ears) const {
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  const SectorHeads heads(shape_.sample_rate_hz, world_from_listener, hrtf);
  SectorMix mix(heads, shape_.samples);
  const SectorOffsets offsets = sector_offsets(stream);
  std::vector<BandArray> expected(late.bins());
  std::vector<float> signal(shape_.samples);
  for (int sector = 0; sector < kSectors; ++sector) {
    const std::vector<BandArray> power = powers(late, sector, bin_samples);
    for (int bin = 0; bin < late.bins(); ++bin) {
      const BandArray through = overlap_.through(power[bin]);
      for (int band = 0; band < kOctaveBands; ++band) {
        expected[bin][band] += through[band] * heads.energy(sector)[band];
      }
    }
    std::fill(signal.begin(), signal.end(), 0.0F);
    add_noise(late, sector, offsets[sector], signal);
    mix.add(sector, signal);
  }
  std::vector<std::vector<float>> noise = mix.ears();
  RealFft<float> fft(shape_.fft_size);
  level_noise(expected, bin_samples, bank_, shape_.sample_rate_hz, fft, noise);
  for (int ear = 0; ear < 2; ++ear) add(noise[ear], ears[ear]);
}

void LateField::add_ambisonic(const EnergyHistogram& late, std::span<const Arrival> arrivals,
                              const Quaternion& world_from_listener, int order,
                              std::uint64_t stream, std::span<std::vector<float>> channels) const {
  const Quaternion listener_from_world = conjugate(world_from_listener);
  const double bin_samples = late.bin_s() * shape_.sample_rate_hz;
  const SectorOffsets offsets = sector_offsets(stream);
  std::vector<std::vector<float>> noise(channels.size(), std::vector<float>(shape_.samples));
  std::vector<float> signal(shape_.samples);
  std::vector<float> gains(channels.size());
  for (int sector = 0; sector < kSectors; ++sector) {
    std::fill(signal.begin(), signal.end(), 0.0F);
    add_noise(late, sector, offsets[sector], signal);
    encode_ambisonics(rotate(listener_from_world, sector_direction(sector)), order, gains);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (int i = 0; i < shape_.samples; ++i) noise[c][i] += gains[c] * signal[i];
    }
  }
  // The squares of the gains add up to the number of channels in every direction.
  std::vector<BandArray> expected = powers(late, kAllSectors, bin_samples);
  for (BandArray& bands : expected) {
    bands = overlap_.through(bands);
    for (float& band : bands) band *= static_cast<float>(channels.size());
  }
  RealFft<float> fft(shape_.fft_size);
  level_noise(expected, bin_samples, bank_, shape_.sample_rate_hz, fft, noise);

  PulseTrain train(shape_.fft_size);
  std::vector<std::vector<float>> encoded(channels.size(), std::vector<float>(arrivals.size()));
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    encode_ambisonics(rotate(listener_from_world, arrivals[i].direction), order, gains);
    for (std::size_t c = 0; c < channels.size(); ++c) encoded[c][i] = gains[c];
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    add(noise[c], channels[c]);
    if (!arrivals.empty()) add_pulses(arrivals, encoded[c], fft, train, channels[c]);
  }
}

}  // namespace earpoint
