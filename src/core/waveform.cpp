#include <earpoint/waveform.h>

#include <earpoint/error.h>

namespace earpoint {

Waveform::Waveform(int channels, std::ptrdiff_t samples, int sample_rate_hz)
    : channels_(channels), samples_(samples), sample_rate_hz_(sample_rate_hz) {
  EARPOINT_CHECK(channels >= 0 && samples >= 0 && sample_rate_hz > 0);
  data_.resize(static_cast<std::size_t>(channels) * static_cast<std::size_t>(samples));
}

double Waveform::duration_s() const {
  return sample_rate_hz_ > 0 ? static_cast<double>(samples_) / sample_rate_hz_ : 0.0;
}

std::span<float> Waveform::channel(int index) {
  EARPOINT_CHECK(index >= 0 && index < channels_);
  return std::span(data_).subspan(static_cast<std::size_t>(index * samples_),
                                  static_cast<std::size_t>(samples_));
}

std::span<const float> Waveform::channel(int index) const {
  EARPOINT_CHECK(index >= 0 && index < channels_);
  return std::span(data_).subspan(static_cast<std::size_t>(index * samples_),
                                  static_cast<std::size_t>(samples_));
}

}  // namespace earpoint
