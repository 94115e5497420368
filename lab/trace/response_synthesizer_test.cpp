#include "gates/measurement.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

PointResponse one_arrival(double delay_s, const Vector3& direction, const BandArray& gain) {
  PointResponse response;
  response.arrivals = {{.delay_s = delay_s, .direction = direction, .departure = {}, .gain = gain}};
  response.late = EnergyHistogram(50, 0.002);
  return response;
}

TEST(ResponseSynthesizer, ArrivalIsTheHeadsResponseAtItsSample) {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.1});
  // At a whole sample after the head's own delay there is no fractional delay.
  const double centre = hrtf.centre_delay_samples();
  const int place = 400;
  const Vector3 direction{0.6, 0.8, 0.0};
  const Waveform ears = synthesizer.binaural(
      one_arrival((place + centre) / kRate_hz, direction, all_bands(0.5F)), {}, hrtf, 0);
  const Hrir hrir = hrtf.interpolated(direction);
  for (int ear = 0; ear < 2; ++ear) {
    double error = 0.0;
    for (int i = 0; i < hrtf.taps(); ++i) {
      const double wanted = 0.5 * static_cast<double>(hrir.taps[ear][i]);
      error += std::pow(static_cast<double>(ears.channel(ear)[place + i]) - wanted, 2);
    }
    // Rounding of the transforms, in float.
    EXPECT_LT(error, 1e-8 * energy(hrir.taps[ear])) << ear;
  }
}

TEST(ResponseSynthesizer, ArrivalsPastTheInterpolatedOnesAreAsLoud) {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.2});
  PointResponse response = one_arrival(0.1, {0.0, 1.0, 0.0}, all_bands(1.0F));
  const Waveform first = synthesizer.binaural(response, {}, hrtf, 0);
  // 256 silent arrivals before it.
  const Arrival arrival = response.arrivals[0];
  response.arrivals.assign(256, arrival);
  for (Arrival& silent : response.arrivals) silent.gain = all_bands(0.0F);
  response.arrivals.push_back(arrival);
  const Waveform last = synthesizer.binaural(response, {}, hrtf, 0);
  for (int ear = 0; ear < 2; ++ear) {
    // The direction is a measured one, where interpolation keeps -60 dB.
    EXPECT_NEAR(gates::decibels(energy(last.channel(ear)) / energy(first.channel(ear))), 0.0, 0.05);
  }
}

TEST(ResponseSynthesizer, WhatStartsBeforeTheResponseDoesNotComeRoundItsEnd) {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.1});
  const Waveform ears =
      synthesizer.binaural(one_arrival(0.0, {1.0, 0.0, 0.0}, all_bands(1.0F)), {}, hrtf, 0);
  EXPECT_LT(energy(ears.channel(0).subspan(1200)), 1e-5 * energy(ears.channel(0)));
}

// The largest sample of a stretch, relative to the largest of all.
double largest_db(const Waveform& waveform, double from_s, double to_s) {
  float all = 0.0F;
  float part = 0.0F;
  for (int c = 0; c < waveform.channels(); ++c) {
    for (std::ptrdiff_t i = 0; i < waveform.samples(); ++i) {
      const float value = std::abs(waveform.channel(c)[i]);
      all = std::max(all, value);
      const double time_s = static_cast<double>(i) / waveform.sample_rate_hz();
      if (time_s >= from_s && time_s < to_s) part = std::max(part, value);
    }
  }
  return gates::decibels(static_cast<double>(part * part) / static_cast<double>(all * all));
}

TEST(ResponseSynthesizer, LoneSoundRingsNeitherAheadNorOn) {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.4});
  // 34 m through air at 20 degrees: 3.6 dB less at 8 kHz. The delay is between two samples.
  const BandArray air = {1.0F, 1.0F, 0.998F, 0.99F, 0.98F, 0.96F, 0.89F, 0.66F};
  const double delay_s = 0.1000213;
  const PointResponse response = one_arrival(delay_s, {0.6, 0.8, 0.0}, air);
  const Waveform responses[] = {synthesizer.mono(response, 0),
                                synthesizer.binaural(response, {}, hrtf, 0),
                                synthesizer.ambisonic(response, {}, 2, 0)};
  for (const Waveform& waveform : responses) {
    EXPECT_EQ(largest_db(waveform, 0.0, delay_s - 0.006), -INFINITY);
    // The flanks of the pulse, where the fade to silence cuts them.
    EXPECT_LT(largest_db(waveform, 0.0, delay_s - 0.004), -80.0) << waveform.channels();
    EXPECT_LT(largest_db(waveform, delay_s + 0.05, 0.4), -100.0) << waveform.channels();
  }
}

}  // namespace
}  // namespace earpoint
