#pragma once

#include <cstddef>
#include <memory>

#include <earpoint/waveform.h>

namespace earpoint {

/// Resamples with soxr in high quality (pass band 96 %, aliases below -120 dB), without delay:
/// sample i of the input lies at i * to / from in the output.
/// @return  round(samples * to / from) samples; the input itself if the rates are equal
[[nodiscard]] Waveform resample(const Waveform& waveform, int sample_rate_hz);

/// The same for sound that arrives in blocks: the blocks that come out, joined, are what
/// resample() makes of the blocks that went in, joined.
class StreamResampler {
 public:
  /// @param channels  > 0; rates > 0, with a ratio between 1/256 and 256
  StreamResampler(int channels, int from_hz, int to_hz);
  ~StreamResampler();
  StreamResampler(StreamResampler&&) noexcept;
  StreamResampler& operator=(StreamResampler&&) noexcept;

  /// @param block  the next samples at from_hz; may be empty
  /// @param last   nothing follows: what the filter still holds comes out too
  /// @return  what is ready at to_hz; may hold 0 samples
  [[nodiscard]] Waveform process(const Waveform& block, bool last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The resampling that the published data sets were prepared with: a sinc over 24 zero crossings
/// with a squared-cosine window, cut off at 0.945 of the lower Nyquist frequency, edges repeated.
/// Use it where numbers must equal published ones; resample() is cleaner.
/// @return  floor(samples * to / from) samples
/// Source: the definition of julius.resample_frac (MIT). Taps are in double here; julius rounds
/// them to float, so its output differs by up to 3e-6.
[[nodiscard]] Waveform resample_sinc(const Waveform& waveform, int sample_rate_hz);

}  // namespace earpoint
