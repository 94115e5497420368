#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/train/gtf_learner.h>

// What tests of gtf's learner share.
namespace earpoint::gtf_test {

inline constexpr std::int64_t kSamples = 4000;

/// The head whose tables the networks have.
inline const HrtfSet& head() {
  static const HrtfSet set = HrtfSet::load(GtfDescription::kSampleRateHz);
  return set;
}

/// A network that is quick to train.
inline GtfDescription small() {
  GtfDescription d;
  d.channels = 12;
  d.layers = 3;
  d.bands = 12;
  d.past_frames = 2;
  d.picture_px = 32;
  d.picture_width = d.locator_width = d.summary_width = d.conditioning_width = 16;
  return d;
}

/// Normal noise. @return [count]
inline std::vector<float> noise(std::int64_t count, double size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

/// Clips of noise; every other one sees its speaker.
inline TrainingBatch batch_for(const GtfDescription& d, std::int64_t clips,
                               std::int64_t samples = kSamples) {
  TrainingBatch batch;
  batch.clips = clips;
  batch.source = noise(clips * 2 * samples, 0.1, 1);
  batch.target = noise(clips * 2 * samples, 0.05, 2);
  batch.inputs["dry"] = noise(clips * samples, 0.1, 7);
  if (d.picture_px > 0) {
    batch.pictures = noise(clips * 3 * d.picture_px * d.picture_px, 0.2, 3);
  }
  for (std::int64_t clip = 0; clip < clips; ++clip) {
    const bool is_seen = clip % 2 == 0;
    const std::vector<float> box =
        is_seen ? std::vector<float>{1, 0.3F, 0.4F, 0.5F, 0.9F} : std::vector<float>(5);
    batch.inputs["speaker_box"].insert(batch.inputs["speaker_box"].end(), box.begin(), box.end());
  }
  batch.inputs["target_m"] = noise(clips * 3, 1.0, 4);
  batch.inputs["target_yaw_rad"] = noise(clips, 1.0, 5);
  batch.inputs["speaker_m"] = noise(clips * 3, 1.0, 6);
  for (std::int64_t clip = 0; clip < clips; ++clip) {
    batch.inputs["speaker_heading"].insert(batch.inputs["speaker_heading"].end(), {0.6F, 0.8F});
  }
  return batch;
}

/// Initial weights leave kernels, gains and phases at constants: here every layer takes part.
inline GtfWeights stirred(const GtfDescription& d) {
  GtfWeights weights = initial_gtf_weights(d, head(), 3);
  std::uint64_t seed = 100;
  for (auto& [name, tensor] : weights.tensors) {
    if (!name.starts_with("kernel") && !name.starts_with("gain") && !name.starts_with("phase")) {
      continue;
    }
    std::vector<float> values = noise(tensor.elements(), 0.05, seed++);
    const auto old = tensor.as<float>();
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += old[i];
    tensor = make_tensor<float>(values, tensor.shape);
  }
  return weights;
}

}  // namespace earpoint::gtf_test
