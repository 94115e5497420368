#include <cmath>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/view.h>
#include <earpoint/pose.h>
#include <earpoint/train/gtf_learner.h>

namespace earpoint {
namespace {

std::vector<float> floats(std::initializer_list<double> values) {
  std::vector<float> result;
  for (const double value : values) result.push_back(static_cast<float>(value));
  return result;
}

}  // namespace

TrainingExample gtf_example(const GtfDescription& description, const PairSample& sample) {
  TrainingExample example;
  example.source.assign(sample.source.planar().begin(), sample.source.planar().end());
  example.target.assign(sample.target.planar().begin(), sample.target.planar().end());
  example.inputs["dry"].assign(sample.dry.planar().begin(), sample.dry.planar().end());
  const bool looks = description.picture_px > 0;
  GtfView view = gtf_view(looks ? sample.picture.get() : nullptr, sample.speaker_box,
                          sample.horizontal_fov_rad, looks ? description.picture_px : 1);
  if (looks) example.picture = std::move(view.picture);
  const Box box = view.speaker_box.value_or(Box{});
  example.inputs["speaker_box"] =
      floats({view.speaker_box ? 1.0 : 0.0, box.x_min, box.y_min, box.x_max, box.y_max});
  const Pose& target = sample.source_from_target;
  example.inputs["target_m"] =
      floats({target.position_m.x, target.position_m.y, target.position_m.z});
  example.inputs["target_yaw_rad"] = floats({euler_from_quaternion(target.orientation).yaw_rad});
  example.inputs["speaker_m"] =
      floats({sample.speaker_m.x, sample.speaker_m.y, sample.speaker_m.z});
  example.inputs["speaker_heading"] =
      sample.speaker_yaw_rad
          ? floats({std::cos(*sample.speaker_yaw_rad), std::sin(*sample.speaker_yaw_rad)})
          : floats({0.0, 0.0});
  return example;
}

}  // namespace earpoint
