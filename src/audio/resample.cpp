#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <samplerate.h>

#include <earpoint/audio/resample.h>
#include <earpoint/core/error.h>

namespace earpoint {

/// Holds one converter; interleaved samples, as libsamplerate wants them.
struct StreamResampler::State {
  State(int channels_in, int from, int to) : channels(channels_in), from_hz(from), to_hz(to) {
    int error = 0;
    converter = src_new(SRC_SINC_BEST_QUALITY, channels, &error);
    EARPOINT_CHECK(converter != nullptr);
  }
  ~State() { src_delete(converter); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Runs the converter over `input` and appends what comes out to `output`.
  void convert(const std::vector<float>& input, bool last, std::vector<float>& output) {
    SRC_DATA data{};
    data.data_in = input.data();
    data.input_frames = static_cast<long>(input.size()) / channels;
    data.src_ratio = static_cast<double>(to_hz) / from_hz;
    data.end_of_input = last ? 1 : 0;
    const long room = 4096;
    for (;;) {
      const std::size_t start = output.size();
      output.resize(start + static_cast<std::size_t>(room * channels));
      data.data_out = output.data() + start;
      data.output_frames = room;
      const int error = src_process(converter, &data);
      EARPOINT_CHECK(error == 0);
      output.resize(start + static_cast<std::size_t>(data.output_frames_gen * channels));
      data.data_in += data.input_frames_used * channels;
      data.input_frames -= data.input_frames_used;
      if (data.input_frames == 0 && data.output_frames_gen < room) return;
    }
  }

  /// How many frames must have come out once all of `frames_in` have gone in.
  [[nodiscard]] std::int64_t frames_due() const {
    return (2 * frames_in * to_hz + from_hz) / (2 * std::int64_t{from_hz});
  }

  int channels;
  int from_hz;
  int to_hz;
  SRC_STATE* converter = nullptr;
  std::int64_t frames_in = 0;
  std::int64_t frames_out = 0;
};

StreamResampler::StreamResampler(int channels, int from_hz, int to_hz) {
  EARPOINT_CHECK(channels > 0 && from_hz > 0 && to_hz > 0);
  EARPOINT_CHECK(src_is_valid_ratio(static_cast<double>(to_hz) / from_hz) != 0);
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

  // The converter may hold back the last sample or two at the end; silence behind the sound brings
  // them out, and the count below drops what is too many.
  const std::ptrdiff_t silence = last ? 2 + 2 * (s.from_hz / s.to_hz) : 0;
  std::vector<float> input(static_cast<std::size_t>((samples + silence) * s.channels));
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
