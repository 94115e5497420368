#include <earpoint/record/aligned_sound.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <earpoint/audio/resample.h>
#include <earpoint/error.h>
#include <earpoint/media/media.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kHalf = 16;
constexpr int kTaps = 2 * kHalf;
constexpr int kPhases = 512;
constexpr std::ptrdiff_t kBlock = 16384;

using Taps = std::array<float, kTaps>;

/// Taps for every fraction of a sample from 0 to 1, both included.
const std::vector<Taps>& sinc_table() {
  static const std::vector<Taps> table = [] {
    std::vector<Taps> rows(kPhases + 1);
    for (int phase = 0; phase <= kPhases; ++phase) {
      for (int tap = 0; tap < kTaps; ++tap) {
        const double t = tap - (kHalf - 1) - static_cast<double>(phase) / kPhases;
        const double sinc = t == 0.0 ? 1.0 : std::sin(kPi * t) / (kPi * t);
        const double window = 0.5 + 0.5 * std::cos(kPi * t / kHalf);
        rows[phase][tap] = static_cast<float>(sinc * window);
      }
    }
    return rows;
  }();
  return table;
}

float interpolate(const float* x, double fraction) {
  const double place = fraction * kPhases;
  const auto phase = static_cast<std::size_t>(place);
  const auto between = static_cast<float>(place - static_cast<double>(phase));
  const Taps& a = sinc_table()[phase];
  const Taps& b = sinc_table()[phase + 1];
  float low = 0.0F;
  float high = 0.0F;
  for (int tap = 0; tap < kTaps; ++tap) {
    low += a[tap] * x[tap];
    high += b[tap] * x[tap];
  }
  return low + between * (high - low);
}

std::optional<std::array<int, 2>> channels_to_read(int channels) {
  return channels == 2 ? std::nullopt : std::optional(std::array<int, 2>{0, 0});
}

}  // namespace

struct AlignedSound::State {
  State(const std::filesystem::path& path, int channel_count, DeviceClock device_clock,
        double start_s, int rate)
      : reader(path, channels_to_read(channel_count)),
        resampler(channel_count, reader.sample_rate_hz(), rate),
        clock(std::move(device_clock)),
        begin_s(start_s),
        rate_hz(rate),
        held(static_cast<std::size_t>(channel_count)) {}

  /// Reads until the sound up to `end` is held, or to the end of the file.
  void hold_until(std::ptrdiff_t end) {
    while (!ended && first + std::ssize(held.front()) < end) {
      Waveform both;
      try {
        both = reader.read(kBlock);
      } catch (const InputError&) {  // already reported when the sound was read for its clock
        both = Waveform(2, 0, reader.sample_rate_hz());
      }
      ended = both.samples() < kBlock;
      Waveform block(static_cast<int>(held.size()), both.samples(), reader.sample_rate_hz());
      for (std::size_t i = 0; i < block.planar().size(); ++i) {
        const float x = both.planar()[i];
        block.planar()[i] = std::isfinite(x) ? x : 0.0F;
      }
      const Waveform ready = resampler.process(block, ended);
      for (std::size_t c = 0; c < held.size(); ++c) {
        const auto samples = ready.channel(static_cast<int>(c));
        held[c].insert(held[c].end(), samples.begin(), samples.end());
      }
    }
  }

  void forget_before(std::ptrdiff_t begin) {
    const std::ptrdiff_t count =
        std::clamp(begin - first, std::ptrdiff_t{0}, std::ssize(held.front()));
    for (auto& channel : held) channel.erase(channel.begin(), channel.begin() + count);
    first += count;
  }

  AudioReader reader;
  StreamResampler resampler;
  DeviceClock clock;
  double begin_s;
  int rate_hz;
  std::vector<std::vector<float>> held;  ///< by channel, at rate_hz, from sample `first` on
  std::ptrdiff_t first = 0;
  bool ended = false;
  std::ptrdiff_t done = 0;
};

AlignedSound::AlignedSound(const std::filesystem::path& path, int channels,
                           const DeviceClock& clock, double begin_s, int sample_rate_hz)
    : state_(std::make_unique<State>(path, channels, clock, begin_s, sample_rate_hz)) {
  EARPOINT_CHECK(channels == 1 || channels == 2);
}
AlignedSound::~AlignedSound() = default;
AlignedSound::AlignedSound(AlignedSound&&) noexcept = default;
AlignedSound& AlignedSound::operator=(AlignedSound&&) noexcept = default;

Waveform AlignedSound::read(std::ptrdiff_t frames) {
  EARPOINT_CHECK(frames > 0);
  State& s = *state_;
  const double rate = s.rate_hz;
  const auto position = [&](std::ptrdiff_t n) {
    return rate * device_time_s(s.clock, s.begin_s + static_cast<double>(s.done + n) / rate);
  };
  s.forget_before(static_cast<std::ptrdiff_t>(std::floor(position(0))) - kTaps);
  s.hold_until(static_cast<std::ptrdiff_t>(std::floor(position(frames))) + kTaps);

  Waveform sound(static_cast<int>(s.held.size()), frames, s.rate_hz);
  for (std::ptrdiff_t n = 0; n < frames; ++n) {
    const double place = position(n);
    const double whole = std::floor(place);
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(whole) - (kHalf - 1) - s.first;
    if (at < 0 || at + kTaps > std::ssize(s.held.front())) continue;
    for (std::size_t c = 0; c < s.held.size(); ++c) {
      sound.channel(static_cast<int>(c))[n] = interpolate(s.held[c].data() + at, place - whole);
    }
  }
  s.done += frames;
  return sound;
}

}  // namespace earpoint
