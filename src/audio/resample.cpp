#include <earpoint/audio/resample.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <soxr.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kPassBand = 0.96;  // of the lower Nyquist frequency

}  // namespace

/// Holds one converter; interleaved samples.
struct StreamResampler::State {
  State(int channels_in, int from, int to) : channels(channels_in), from_hz(from), to_hz(to) {
    const soxr_io_spec_t interleaved = soxr_io_spec(SOXR_FLOAT32_I, SOXR_FLOAT32_I);
    soxr_quality_spec_t quality = soxr_quality_spec(SOXR_HQ, 0);
    quality.passband_end = kPassBand;
    soxr_error_t error = nullptr;
    converter = soxr_create(from, to, static_cast<unsigned>(channels), &error, &interleaved,
                            &quality, nullptr);
    EARPOINT_CHECK(error == nullptr);
  }
  ~State() { soxr_delete(converter); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Converts `input` and appends the result to `output`; after the `last` input, tells the
  /// converter that the sound ends.
  void convert(const std::vector<float>& input, bool last, std::vector<float>& output) {
    if (input.empty() && !last) return;  // to soxr, no input is the end
    const float* next = input.data();
    std::size_t left = input.size() / static_cast<std::size_t>(channels);
    const std::size_t room = 4096;
    for (;;) {
      const bool ends = last && left == 0;
      const std::size_t start = output.size();
      output.resize(start + room * channels);
      std::size_t used = 0;
      std::size_t made = 0;
      const soxr_error_t error = soxr_process(converter, ends ? nullptr : next, left, &used,
                                              output.data() + start, room, &made);
      EARPOINT_CHECK(error == nullptr);
      output.resize(start + made * channels);
      next += used * channels;
      left -= used;
      if (left == 0 && made < room && (ends || !last)) return;
    }
  }

  /// How many frames must have come out once all of `frames_in` have gone in.
  [[nodiscard]] std::int64_t frames_due() const {
    return (2 * frames_in * to_hz + from_hz) / (2 * std::int64_t{from_hz});
  }

  int channels;
  int from_hz;
  int to_hz;
  soxr_t converter = nullptr;
  std::int64_t frames_in = 0;
  std::int64_t frames_out = 0;
};

StreamResampler::StreamResampler(int channels, int from_hz, int to_hz) {
  EARPOINT_CHECK(channels > 0 && from_hz > 0 && to_hz > 0);
  EARPOINT_CHECK(from_hz <= std::int64_t{256} * to_hz && to_hz <= std::int64_t{256} * from_hz);
  state_ = std::make_unique<State>(channels, from_hz, to_hz);
}
StreamResampler::~StreamResampler() = default;
StreamResampler::StreamResampler(StreamResampler&&) noexcept = default;
StreamResampler& StreamResampler::operator=(StreamResampler&&) noexcept = default;

Waveform StreamResampler::process(const Waveform& block, bool last) {
  State& s = *state_;
  const std::ptrdiff_t samples = block.empty() ? 0 : block.samples();
  EARPOINT_CHECK(samples == 0 ||
                 (block.channels() == s.channels && block.sample_rate_hz() == s.from_hz));
  if (s.from_hz == s.to_hz) return samples > 0 ? block : Waveform(s.channels, 0, s.to_hz);
  s.frames_in += samples;

  std::vector<float> input(static_cast<std::size_t>(samples * s.channels));
  for (int c = 0; samples > 0 && c < s.channels; ++c) {
    const std::span<const float> source = block.channel(c);
    for (std::ptrdiff_t i = 0; i < samples; ++i) input[i * s.channels + c] = source[i];
  }
  std::vector<float> output;
  s.convert(input, last, output);

  std::int64_t frames = static_cast<std::int64_t>(output.size()) / s.channels;
  if (last) {
    const std::int64_t due = s.frames_due() - s.frames_out;
    EARPOINT_CHECK(due <= frames);
    frames = due;
  }
  s.frames_out += frames;
  Waveform result(s.channels, frames, s.to_hz);
  for (int c = 0; c < s.channels; ++c) {
    const std::span<float> target = result.channel(c);
    for (std::ptrdiff_t i = 0; i < frames; ++i) target[i] = output[i * s.channels + c];
  }
  return result;
}

Waveform resample(const Waveform& waveform, int sample_rate_hz) {
  EARPOINT_CHECK(sample_rate_hz > 0);
  if (waveform.sample_rate_hz() == sample_rate_hz) return waveform;
  if (waveform.channels() == 0) return Waveform(0, 0, sample_rate_hz);
  StreamResampler resampler(waveform.channels(), waveform.sample_rate_hz(), sample_rate_hz);
  return resampler.process(waveform, true);
}

}  // namespace earpoint
