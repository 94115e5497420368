#include "sliding_sound.h"

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint {

SlidingSound::SlidingSound(const std::filesystem::path& path, int sample_rate_hz)
    : reader_(path),
      resampler_(reader_.info().channels, reader_.info().sample_rate_hz, sample_rate_hz),
      rate_hz_(sample_rate_hz),
      held_(static_cast<std::size_t>(reader_.info().channels)) {}

Waveform SlidingSound::window(std::ptrdiff_t begin, std::ptrdiff_t samples) {
  EARPOINT_CHECK(begin >= first_ && samples > 0);
  constexpr std::ptrdiff_t kBlock = 16384;
  while (!ended_ && first_ + std::ssize(held_.front()) < begin + samples) {
    const Waveform block = reader_.read(kBlock);
    ended_ = block.samples() < kBlock;
    const Waveform ready = resampler_.process(block, ended_);
    for (std::size_t c = 0; c < held_.size(); ++c) {
      const auto more = ready.channel(static_cast<int>(c));
      held_[c].insert(held_[c].end(), more.begin(), more.end());
    }
  }
  const std::ptrdiff_t passed = std::min(begin - first_, std::ssize(held_.front()));
  for (auto& channel : held_) channel.erase(channel.begin(), channel.begin() + passed);
  first_ += passed;

  Waveform result(static_cast<int>(held_.size()), samples, rate_hz_);
  const std::ptrdiff_t skipped = begin - first_;
  for (std::size_t c = 0; c < held_.size(); ++c) {
    const std::ptrdiff_t there =
        std::clamp(std::ssize(held_[c]) - skipped, std::ptrdiff_t{0}, samples);
    if (there == 0) continue;
    std::copy_n(held_[c].begin() + skipped, there, result.channel(static_cast<int>(c)).begin());
  }
  return result;
}

}  // namespace earpoint
