#include <earpoint/spatial/binaural.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/spatial/dsp_renderer.h>

namespace earpoint {
namespace {

using Complex = std::complex<float>;
using EarSpectra = std::array<std::vector<Complex>, 2>;

Vector3 direction_of(const Spherical& source) {
  return cartesian_from_spherical({source.azimuth_rad, source.elevation_rad, 1.0});
}

int rounded_centre_delay(const HrtfSet& hrtf) {
  return static_cast<int>(std::lround(hrtf.centre_delay_samples()));
}

}  // namespace

struct BinauralPanner::State {
  State(const HrtfSet& hrtf_set, int block)
      : hrtf(hrtf_set),
        block_size(block),
        fft(fast_fft_size(block + hrtf_set.taps())),
        window(fft.size(), 0.0F),
        input(fft.bins()),
        product(fft.bins()),
        wave(fft.size()) {}

  void set_filters(EarSpectra& filters, const Spherical& source) {
    const Hrir hrir = hrtf.interpolated(direction_of(source), source.distance_m);
    const auto gain = static_cast<float>(distance_gain(source.distance_m));
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::fill(wave, 0.0F);
      std::ranges::transform(hrir.taps[ear], wave.begin(), [&](float tap) { return gain * tap; });
      filters[ear].resize(fft.bins());
      fft.forward(wave, filters[ear]);
    }
  }

  // The block's sound through one ear's filter; valid until the next call.
  std::span<const float> filtered(const std::vector<Complex>& filter) {
    for (int bin = 0; bin < fft.bins(); ++bin) product[bin] = input[bin] * filter[bin];
    fft.inverse(product, wave);
    return std::span<const float>(wave).last(block_size);
  }

  HrtfSet hrtf;
  int block_size;
  RealFft<float> fft;
  std::vector<float> window;  // the latest samples, the new block last: overlap-save
  std::vector<Complex> input;
  std::vector<Complex> product;
  std::vector<float> wave;
  EarSpectra from;
  EarSpectra to;
  Spherical place;
  bool started = false;
};

BinauralPanner::BinauralPanner(const HrtfSet& hrtf, int block_size) {
  EARPOINT_CHECK(block_size > 0);
  state_ = std::make_unique<State>(hrtf, block_size);
}

BinauralPanner::~BinauralPanner() = default;
BinauralPanner::BinauralPanner(BinauralPanner&&) noexcept = default;
BinauralPanner& BinauralPanner::operator=(BinauralPanner&&) noexcept = default;

int BinauralPanner::block_size() const { return state_->block_size; }
int BinauralPanner::delay_samples() const { return rounded_centre_delay(state_->hrtf); }

void BinauralPanner::process(std::span<const float> mono, const Spherical& source,
                             std::span<float> left, std::span<float> right) {
  State& state = *state_;
  EARPOINT_CHECK(std::ssize(mono) == state.block_size && source.distance_m > 0.0);
  EARPOINT_CHECK(left.size() == mono.size() && right.size() == mono.size());
  std::shift_left(state.window.begin(), state.window.end(), state.block_size);
  std::ranges::copy(mono, state.window.end() - state.block_size);
  state.fft.forward(state.window, state.input);

  const bool moved = !state.started || source.azimuth_rad != state.place.azimuth_rad ||
                     source.elevation_rad != state.place.elevation_rad ||
                     source.distance_m != state.place.distance_m;
  if (moved) state.set_filters(state.to, source);
  const bool fade = moved && state.started;
  for (int ear = 0; ear < 2; ++ear) {
    const std::span<float> out = ear == 0 ? left : right;
    std::ranges::copy(state.filtered(state.to[ear]), out.begin());
    if (!fade) continue;
    const std::span<const float> before = state.filtered(state.from[ear]);
    for (int i = 0; i < state.block_size; ++i) {
      const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(state.block_size);
      out[i] = before[i] + share * (out[i] - before[i]);
    }
  }
  if (moved) state.from = state.to;
  state.place = source;
  state.started = true;
}

Waveform pan_binaural(std::span<const float> mono, const HrtfSet& hrtf, const Spherical& source) {
  EARPOINT_CHECK(source.distance_m > 0.0);
  Waveform ears(2, std::ssize(mono), hrtf.sample_rate_hz());
  if (mono.empty()) return ears;
  const Hrir hrir = hrtf.interpolated(direction_of(source), source.distance_m);
  const auto gain = static_cast<float>(distance_gain(source.distance_m));
  const int delay = rounded_centre_delay(hrtf);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> sound = convolve(mono, hrir.taps[ear]);
    for (std::ptrdiff_t i = 0; i < ears.samples(); ++i) {
      const std::ptrdiff_t from = i + delay;
      if (from < std::ssize(sound)) ears.channel(ear)[i] = gain * sound[from];
    }
  }
  return ears;
}

}  // namespace earpoint
