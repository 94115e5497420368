#include "impulse_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/decay.h>
#include <earpoint/audio/energy.h>
#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/arrival_renderer.h>
#include <earpoint/spatial/shoebox.h>

namespace earpoint {
namespace {

constexpr int kRate = 16000;

const HrtfSet& hrtf() {
  static const HrtfSet set = HrtfSet::load(kRate);
  return set;
}

Arrival arrival_at(double delay_s, const Vector3& direction, float gain) {
  Arrival arrival;
  arrival.delay_s = delay_s;
  arrival.direction = normalized(direction);
  arrival.gain = all_bands(gain);
  return arrival;
}

// Energy per octave band (square-edged) of one channel.
std::vector<double> octave_energies(std::span<const float> samples, int rate_hz) {
  RealFft<double> fft(fast_fft_size(static_cast<int>(samples.size())));
  std::vector<double> padded(fft.size(), 0.0);
  std::ranges::copy(samples, padded.begin());
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(padded, spectrum);
  std::vector<double> energies(kOctaveBands, 0.0);
  for (int bin = 0; bin < fft.bins(); ++bin) {
    const double octave = std::log2(static_cast<double>(rate_hz) * bin / fft.size() / 62.5) + 0.5;
    if (octave >= 0.0 && octave < kOctaveBands) {
      energies[static_cast<std::size_t>(octave)] += std::norm(spectrum[bin]);
    }
  }
  return energies;
}

Shoebox test_room() {
  Shoebox room;
  room.lengths_m = {6.0, 5.0, 3.0};
  room.absorption.fill(all_bands(0.2F));
  return room;
}

TEST(ImpulseGrid, MatchesTheDirectSumAtEveryBin) {
  constexpr int kSize = 600;
  ImpulseGrid grid(kRate, kSize);
  RandomStream random(1);
  std::vector<std::complex<double>> expected(grid.bins(), 0.0);
  double total = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double time = random.uniform(8.0, kSize - 8.0);
    BandArray gain{};
    for (float& value : gain) value = static_cast<float>(random.uniform(-1.0, 1.0));
    grid.add(time, gain);
    total += 1.0;
    for (int bin = 0; bin < grid.bins(); ++bin) {
      double amplitude = 0.0;
      for (int band = 0; band < kOctaveBands; ++band) {
        amplitude +=
            gain[band] * octave_band_weight(band, static_cast<double>(kRate) * bin / kSize);
      }
      expected[bin] += std::polar(amplitude, -2.0 * kPi * bin * time / kSize);
    }
  }
  std::vector<std::complex<float>> found(grid.bins());
  grid.take(found);
  for (int bin = 0; bin < grid.bins(); ++bin) {
    // Aliases of the kernel and float32 rounding, relative to the sum of gains.
    ASSERT_NEAR(std::abs(std::complex<double>(found[bin]) - expected[bin]), 0.0, 3e-6 * total)
        << bin;
  }
  // take() has cleared the grid.
  grid.take(found);
  EXPECT_EQ(std::abs(found[100]), 0.0F);
}

TEST(RenderArrivalsMono, AnImpulseAtAWholeSampleStaysOne) {
  const std::vector<Arrival> arrivals = {arrival_at(0.01, {1, 0, 0}, 0.5F)};
  const Waveform response = render_arrivals_mono(arrivals, kRate, 0.05);
  ASSERT_EQ(response.samples(), 800);
  for (std::ptrdiff_t i = 0; i < response.samples(); ++i) {
    // Float sums over the bins of the whole length, whose impulse is 1.
    EXPECT_NEAR(response.channel(0)[i], i == 160 ? 0.5F : 0.0F, 3e-6F) << i;
  }
}

TEST(RenderArrivalsMono, BetweenSamplesItIsASinc) {
  const double time = 160.3;
  const std::vector<Arrival> arrivals = {arrival_at(time / kRate, {1, 0, 0}, 1.0F)};
  const Waveform response = render_arrivals_mono(arrivals, kRate, 0.05);
  for (int i = 110; i < 210; ++i) {
    const double x = kPi * (i - time);
    // The far ends of the sinc wrap around the transform of about 2000 samples.
    EXPECT_NEAR(response.channel(0)[i], std::sin(x) / x, 1e-3) << i;
  }
  EXPECT_EQ(response.channel(0)[95], 0.0F);  // 4 ms before
  // The silence ahead and the end cut off less than 1 % of the energy of the sinc.
  EXPECT_NEAR(energy(response.channel(0)), 1.0, 0.01);
}

TEST(RenderArrivalsMono, DoublingTheDistanceTakesSixDecibels) {
  Shoebox room = test_room();
  room.lengths_m = {30.0, 30.0, 30.0};
  double last = 0.0;
  for (const double distance_m : {1.0, 2.0, 4.0, 8.0}) {
    const auto arrivals = shoebox_arrivals(room, {15.0 + distance_m, 15.0, 15.0},
                                           Pose{{15.0, 15.0, 15.0}, {}}, 0.03, 0);
    const Waveform response = render_arrivals_mono(arrivals, kRate, 0.06);
    const double level_db = 10.0 * std::log10(octave_energies(response.channel(0), kRate)[4]);
    // The air absorbs 0.005 dB per metre at 1 kHz.
    if (last != 0.0) {
      EXPECT_NEAR(last - level_db, 6.02, 0.03) << distance_m;
    }
    last = level_db;
    // The direct sound comes within a sample of distance over speed of sound.
    const auto peak = std::ranges::max_element(response.channel(0));
    EXPECT_NEAR(static_cast<double>(peak - response.channel(0).begin()), distance_m / 343.2 * kRate,
                1.0);
  }
}

TEST(RenderArrivalsMono, BandGainsShapeTheirBands) {
  Arrival arrival = arrival_at(0.05, {1, 0, 0}, 0.0F);
  arrival.gain[4] = 1.0F;
  const Waveform response = render_arrivals_mono({&arrival, 1}, kRate, 0.1);
  const std::vector<double> energies = octave_energies(response.channel(0), kRate);
  for (int band = 0; band < kOctaveBands; ++band) {
    const double level_db = 10.0 * std::log10(energies[band] / energies[4]);
    if (std::abs(band - 4) == 1) {
      EXPECT_LT(level_db, -6.0);  // the raised cosine extends into the inner half of the neighbours
    } else if (band != 4) {
      EXPECT_LT(level_db, -60.0) << band;
    }
  }
}

TEST(RenderArrivals, ASingleArrivalIsTheHrirAtItsTime) {
  const Vector3 direction{0.3, 0.8, 0.2};
  const Hrir hrir = hrtf().interpolated(direction);
  // A whole number of samples after the set's middle, so that the taps are unchanged.
  const double start = 200.0;
  const std::vector<Arrival> arrivals = {
      arrival_at((start + hrtf().centre_delay_samples()) / kRate, direction, 0.7F)};
  const Waveform response = render_arrivals(arrivals, hrtf(), 0.1);
  for (int ear = 0; ear < 2; ++ear) {
    // From tap 10 on: before it is the fade from silence, 3 ms before the head's centre.
    for (int tap = 10; tap < hrtf().taps(); ++tap) {
      // Float sums over the bins of the whole length.
      EXPECT_NEAR(response.channel(ear)[200 + tap], 0.7F * hrir.taps[ear][tap], 1e-5F) << tap;
    }
  }
  EXPECT_LT(hrir.onset_samples[0], hrir.onset_samples[1]);
}

TEST(RenderArrivals, LateArrivalsTakeTheNearestMeasurement) {
  const std::size_t nearest = hrtf().nearest({-0.4, 0.8, 0.1});
  Arrival arrival =
      arrival_at((300.0 + hrtf().centre_delay_samples()) / kRate, {-0.4, 0.8, 0.1}, 1.0F);
  arrival.order = 5;
  const Waveform response = render_arrivals({&arrival, 1}, hrtf(), 0.1);
  for (int tap = 10; tap < hrtf().taps(); ++tap) {
    // Float sums over the bins of the whole length.
    EXPECT_NEAR(response.channel(0)[300 + tap], hrtf().response(nearest, 0)[tap], 1e-5F);
  }
}

TEST(RenderArrivals, NothingSoundsBeforeTheFirstArrival) {
  const auto arrivals =
      shoebox_arrivals(test_room(), {1.03, 2.011, 1.707}, Pose{{4.2, 3.1, 1.2}, {}}, 0.05);
  const Waveform response = render_arrivals(arrivals, hrtf(), 0.06);
  const auto first = static_cast<int>((arrivals.front().delay_s - 0.003) * kRate);
  double before = 0.0;
  for (int ear = 0; ear < 2; ++ear) before += energy(response.channel(ear).first(first));
  EXPECT_EQ(before, 0.0);
}

TEST(RenderArrivals, ASourceOnTheLeftIsLeftAndTurningRoundMovesItToTheRight) {
  const Vector3 source{3.0, 4.0, 1.5};
  for (const double yaw_deg : {0.0, 180.0}) {
    const Pose listener{{3.0, 2.0, 1.5},
                        quaternion_from_euler({.yaw_rad = radians_from_degrees(yaw_deg)})};
    const auto arrivals = shoebox_arrivals(test_room(), source, listener, 0.03);
    const Waveform response = render_arrivals(arrivals, hrtf(), 0.04);
    const int near = yaw_deg == 0.0 ? 0 : 1;
    // The direct sound alone: the first 3 ms from its arrival, 2 m away.
    const auto window = [&](int ear) { return energy(response.channel(ear).subspan(80, 64)); };
    EXPECT_GT(10.0 * std::log10(window(near) / window(1 - near)), 6.0);
  }
}

TEST(RenderArrivals, AReverberantFieldIsAsLoudAtTheEarsAsAtAMicrophone) {
  const auto arrivals =
      shoebox_arrivals(test_room(), {1.03, 2.011, 1.707}, Pose{{4.2, 3.1, 1.2}, {}}, 0.3);
  const Waveform ears = render_arrivals(arrivals, hrtf(), 0.3);
  const Waveform microphone = render_arrivals_mono(arrivals, kRate, 0.3);
  const auto reference = octave_energies(microphone.channel(0).subspan(800), kRate);
  double difference_db = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    const auto found = octave_energies(ears.channel(ear).subspan(800), kRate);
    for (int band = 3; band <= 6; ++band) {
      difference_db += 10.0 * std::log10(found[band] / reference[band]) / 8.0;
    }
  }
  // Equalized to the diffuse field. Single bands of an empty box are up to 2 dB off; their mean is
  // 0.2 dB.
  EXPECT_NEAR(difference_db, 0.0, 1.0);
}

TEST(RenderArrivalsMono, ASpecularBoxDecaysMoreSlowlyThanEyring) {
  const Shoebox room = test_room();
  std::vector<Arrival> arrivals =
      shoebox_arrivals(room, {1.03, 2.011, 1.707}, Pose{{4.2, 3.1, 1.2}, {}}, 0.5);
  // Only from 500 Hz on: at the lowest frequencies there are few modes, in which images add up in
  // phase.
  for (Arrival& arrival : arrivals) arrival.gain[0] = arrival.gain[1] = arrival.gain[2] = 0.0F;
  const Waveform response = render_arrivals_mono(arrivals, kRate, 0.5);
  const double t20_s = reverberation_time_t20_s(response.channel(0), kRate);
  // Eyring gives 0.5 s; exact image sources of such a box, here and in other programs, 0.58 to 0.65
  // s.
  EXPECT_NEAR(t20_s, 0.62, 0.1);
  EXPECT_GT(t20_s, eyring_reverberation_time_s(room)[4]);
}

TEST(RenderArrivals, RefusesUnsortedArrivals) {
  const std::vector<Arrival> arrivals = {arrival_at(0.02, {1, 0, 0}, 1.0F),
                                         arrival_at(0.01, {1, 0, 0}, 1.0F)};
  EXPECT_THROW(static_cast<void>(render_arrivals(arrivals, hrtf(), 0.1)), std::logic_error);
}

}  // namespace
}  // namespace earpoint
