#include "told_boxes.h"

#include <optional>
#include <utility>

namespace earpoint {

ToldBoxes::ToldBoxes(SpeakerBoxes boxes) : make_(telling_maker(boxes, std::nullopt)) {}

void ToldBoxes::tell(PairSample& sample) const {
  if (!make_) return;
  SpeakerTelling telling = taken();
  const Vector3 speaker_m = sample.speaker_m;
  telling(sample);
  sample.speaker_m = speaker_m;
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(telling));
}

SpeakerTelling ToldBoxes::taken() const {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      SpeakerTelling telling = std::move(idle_.back());
      idle_.pop_back();
      return telling;
    }
  }
  return make_();
}

}  // namespace earpoint
