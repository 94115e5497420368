#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

class ByteCache;

/// Where a camera stands in the recorded room, in metres; z is up and the axes are the recording's.
[[nodiscard]] Pose world_from_camera(const ReplayCamera& camera);

/// Makes samples of Replay-NVAS in the form that methods and networks take. It keeps decoded
/// pictures, resampled sounds and boxes. Any thread may call it.
class ReplaySampler {
 public:
  /// @param dataset      must outlive this
  /// @param cache_bytes  how much it may keep: 0.4 MB for each view of one second
  ReplaySampler(const ReplayDataset& dataset, std::size_t cache_bytes);
  ~ReplaySampler();
  ReplaySampler(ReplaySampler&&) noexcept;
  ReplaySampler& operator=(ReplaySampler&&) noexcept;

  /// PairSample::dry is empty; see near_voice(). Where the speaker stands is known of clips with
  /// ReplayClip::mouth_m alone; else speaker_m is the origin.
  /// @param align  as ReplayDataset::sample()
  /// @throws InputError as ReplayDataset::sample()
  [[nodiscard]] PairSample sample(const ReplayClip& clip, const ReplayChoice& choice,
                                  bool align) const;

  /// What there is to learn and judge enhancement of speech by: a view, and near_voice() for the
  /// target, the same in both channels. The target's pose is the source's.
  /// @param view  index of the source
  /// @throws InputError as sample() and near_voice()
  [[nodiscard]] PairSample enhancement_sample(const ReplayClip& clip, int view) const;

  /// The near microphone's sound in the place of dry speech, which recordings do not tell: moved
  /// such that the source hears it at once, by GCC-PHAT, and as loud as the source, for nothing is
  /// known of the microphone's gain.
  /// @param source  of a sample of that clip, aligned or not
  /// @return        1 channel, as long as the source; silence where either is silent
  /// @throws InputError if the clip has no near.wav, or it is malformed
  [[nodiscard]] Waveform near_voice(const ReplayClip& clip, const Waveform& source) const;

 private:
  struct View;
  /// All of a sample but the target.
  [[nodiscard]] PairSample source_sample(const ReplayClip& clip, int index) const;
  [[nodiscard]] std::shared_ptr<const View> view(const ReplayClip& clip, int index) const;
  [[nodiscard]] std::vector<double> speaker_box(const ReplayClip& clip, int index) const;

  const ReplayDataset* dataset_;
  std::unique_ptr<ByteCache> cache_;
};

/// ReplaySampler::sample() of one pair, without anything kept.
[[nodiscard]] PairSample replay_pair(const ReplayDataset& dataset, const ReplayClip& clip,
                                     const ReplayChoice& choice, bool align);

}  // namespace earpoint
