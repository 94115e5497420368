#include <earpoint/dataset/speaker_boxes.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/locate/people_detector.h>
#include <earpoint/spatial/speaker_direction.h>

namespace earpoint {
namespace {

constexpr double kUnseenDistance_m = 1.5;

/// Finds the speaker of pairs.
class Finder {
 public:
  Finder(const std::optional<std::filesystem::path>& detector, const HrtfSet& head)
      : detector_(make_people_detector(detector)), head_(head) {}

  void tell(PairSample& sample) {
    std::vector<DetectedPerson> people;
    if (sample.picture != nullptr) people = detector_->detect(*sample.picture);
    const double fov_rad = sample.horizontal_fov_rad;
    auto& speakers = speakers_.try_emplace(fov_rad, head_, fov_rad).first->second;
    const PeopleInPicture found = speakers.find(std::move(people), sample.source);
    sample.speaker_box = found.speaker_box();
    if (sample.speaker_box) {
      sample.speaker_m = cartesian_from_spherical(speaker_direction_from_box(
          *sample.speaker_box, fov_rad, sample.picture->width(), sample.picture->height()));
    } else {
      sample.speaker_m = cartesian_from_spherical(
          {.azimuth_rad = found.heard_azimuth_rad, .distance_m = kUnseenDistance_m});
    }
  }

 private:
  std::unique_ptr<PeopleDetector> detector_;
  HrtfSet head_;
  std::map<double, StillSpeakerFinder> speakers_;  ///< by the picture's field of view
};

}  // namespace

SpeakerBoxes boxes_named(std::string_view name) {
  if (name == "true") return SpeakerBoxes::truth;
  if (name == "detected") return SpeakerBoxes::detected;
  if (name == "none") return SpeakerBoxes::none;
  throw InputError("boxes " + std::string(name), "expected true, detected or none");
}

std::function<SpeakerTelling()> telling_maker(
    SpeakerBoxes boxes, const std::optional<std::filesystem::path>& detector) {
  if (boxes == SpeakerBoxes::truth) return {};
  if (boxes == SpeakerBoxes::none) {
    return []() -> SpeakerTelling {
      return [](PairSample& sample) {
        sample.speaker_box.reset();
        sample.speaker_m = {};
      };
    };
  }
  (void)make_people_detector(detector);
  return [detector, head = HrtfSet::load(VoiceDirection::kSampleRateHz)]() -> SpeakerTelling {
    auto finder = std::make_shared<Finder>(detector, head);
    return [finder](PairSample& sample) { finder->tell(sample); };
  };
}

}  // namespace earpoint
