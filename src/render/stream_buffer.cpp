#include <earpoint/render/stream_buffer.h>

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint {

StreamBuffer::StreamBuffer(int channels, int sample_rate_hz)
    : sample_rate_hz_(sample_rate_hz), channels_(static_cast<std::size_t>(channels)) {
  EARPOINT_CHECK(channels > 0 && sample_rate_hz > 0);
}

void StreamBuffer::append(const Waveform& block) {
  if (block.samples() == 0) return;
  EARPOINT_CHECK(block.channels() == static_cast<int>(channels_.size()));
  for (int c = 0; c < block.channels(); ++c) {
    const std::span<const float> samples = block.channel(c);
    channels_[c].insert(channels_[c].end(), samples.begin(), samples.end());
  }
}

void StreamBuffer::drop_before(std::ptrdiff_t start) {
  const std::ptrdiff_t count = std::clamp(start - begin_, std::ptrdiff_t{0}, held());
  for (std::vector<float>& samples : channels_) {
    samples.erase(samples.begin(), samples.begin() + count);
  }
  begin_ += count;
}

Waveform StreamBuffer::copy(std::ptrdiff_t start, std::ptrdiff_t count) const {
  EARPOINT_CHECK(start >= begin_ || begin_ == 0);
  Waveform window(static_cast<int>(channels_.size()), count, sample_rate_hz_);
  const std::ptrdiff_t first = std::clamp(start, begin_, end());
  const std::ptrdiff_t last = std::clamp(start + count, first, end());
  if (first == last) return window;
  for (int c = 0; c < window.channels(); ++c) {
    std::copy(channels_[c].begin() + (first - begin_), channels_[c].begin() + (last - begin_),
              window.channel(c).begin() + (first - start));
  }
  return window;
}

}  // namespace earpoint
