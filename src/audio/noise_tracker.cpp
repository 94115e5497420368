#include <earpoint/audio/noise_tracker.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// The paper's constants, for its hop of 8 ms; for_hop() converts them to other hops.
constexpr double kPaperHop_s = 0.008;
constexpr double kSmoothing = 0.8;
constexpr double kAveraging = 0.95;
constexpr double kPresenceSmoothing = 0.2;
constexpr float kPresenceRatio = 5.0F;
constexpr double kMinimum_s = 1.0;
constexpr std::size_t kWindows = 8;
// The mean of noise over the minimum of its smoothed power in a second: the estimate starts there.
constexpr float kMinimumBias = 1.5F;

double for_hop(double per_paper_frame, double hop_s) {
  return std::pow(per_paper_frame, hop_s / kPaperHop_s);
}

}  // namespace

NoiseTracker::NoiseTracker(int bins, double hop_s)
    : window_frames_(std::max(1, static_cast<int>(std::lround(kMinimum_s / kWindows / hop_s)))),
      smoothing_(for_hop(kSmoothing, hop_s)),
      averaging_(for_hop(kAveraging, hop_s)),
      presence_smoothing_(for_hop(kPresenceSmoothing, hop_s)),
      smoothed_(static_cast<std::size_t>(bins)),
      minimum_(smoothed_.size()),
      present_(smoothed_.size()),
      presence_(smoothed_.size()),
      noise_(smoothed_.size()) {
  EARPOINT_CHECK(bins > 1 && hop_s > 0.0);
}

/// Smooths over three neighbouring bins, weighted 1:2:1, and over time.
void NoiseTracker::smooth(std::span<const float> power, bool first) {
  const std::size_t last = power.size() - 1;
  const auto keep = static_cast<float>(first ? 0.0 : smoothing_);
  for (std::size_t k = 0; k <= last; ++k) {
    const float below = power[k == 0 ? 1 : k - 1];
    const float above = power[k == last ? last - 1 : k + 1];
    const float local = 0.25F * below + 0.5F * power[k] + 0.25F * above;
    smoothed_[k] = keep * smoothed_[k] + (1.0F - keep) * local;
  }
}

void NoiseTracker::start(std::span<const float> frames) {
  const std::size_t bins = noise_.size();
  EARPOINT_CHECK(!frames.empty() && frames.size() % bins == 0);
  const std::size_t count = frames.size() / bins;
  // Backwards, so that the estimate at the first frame comes from the frames that follow it.
  const auto frame = [&](std::size_t i) { return frames.subspan((count - 1 - i) * bins, bins); };
  smooth(frame(0), true);
  minimum_ = smoothed_;
  for (std::size_t i = 1; i < count; ++i) {
    smooth(frame(i), false);
    for (std::size_t k = 0; k < bins; ++k) minimum_[k] = std::min(minimum_[k], smoothed_[k]);
  }
  for (std::size_t k = 0; k < bins; ++k) noise_[k] = kMinimumBias * minimum_[k];
  present_ = minimum_;
  windows_.assign(kWindows, minimum_);
  frame_ = 0;
  smooth(frame(0), true);
  for (std::size_t i = 0; i < count; ++i) update(frame(i));
}

void NoiseTracker::update(std::span<const float> power) {
  const std::size_t bins = noise_.size();
  EARPOINT_CHECK(power.size() == bins && !windows_.empty());
  smooth(power, false);
  if (++frame_ % window_frames_ == 0) {
    windows_[next_window_] = present_;
    next_window_ = (next_window_ + 1) % kWindows;
    present_ = smoothed_;
    minimum_ = smoothed_;
    for (const std::vector<float>& window : windows_) {
      for (std::size_t k = 0; k < bins; ++k) minimum_[k] = std::min(minimum_[k], window[k]);
    }
  }
  const auto averaging = static_cast<float>(averaging_);
  const auto presence_smoothing = static_cast<float>(presence_smoothing_);
  for (std::size_t k = 0; k < bins; ++k) {
    present_[k] = std::min(present_[k], smoothed_[k]);
    minimum_[k] = std::min(minimum_[k], smoothed_[k]);
    const float speaks = smoothed_[k] > kPresenceRatio * minimum_[k] ? 1.0F : 0.0F;
    const float fading = presence_smoothing * presence_[k];
    presence_[k] = std::max(speaks, fading);
    const float keep = averaging + (1.0F - averaging) * presence_[k];
    noise_[k] = keep * noise_[k] + (1.0F - keep) * power[k];
  }
}

}  // namespace earpoint
