#pragma once

#include <functional>
#include <mutex>
#include <vector>

#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/speaker_boxes.h>

namespace earpoint {

/// Gives examples the box that a method gets when it is used: the true one, that of the person who
/// is detected as the speaker, or none. Where the speaker stands remains the truth, from which the
/// network learns. Any thread may call it.
class ToldBoxes {
 public:
  /// @throws InputError if the people detector is missing or damaged
  explicit ToldBoxes(SpeakerBoxes boxes);

  void tell(PairSample& sample) const;

 private:
  [[nodiscard]] SpeakerTelling taken() const;

  std::function<SpeakerTelling()> make_;
  mutable std::mutex mutex_;
  mutable std::vector<SpeakerTelling> idle_;  // each serves one thread at a time
};

}  // namespace earpoint
