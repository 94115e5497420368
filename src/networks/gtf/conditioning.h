#pragma once

#include "geometry.h"
#include "picture_encoder.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint::gtf {

/// From what is known of a scene and a sound to what conditions the filter.
class GtfConditions {
 public:
  explicit GtfConditions(const GtfWeights& weights);

  /// What the camera sees; kept until it changes. Allocates nothing.
  void set_picture(std::span<const float> picture, const std::optional<Box>& box);

  /// What the ears heard, and from that and what was seen, where the speaker is. Allocates nothing.
  /// @param summary  [summary features]
  void set_summary(std::span<const float> summary);

  /// @param natural  0 the mean, 1 the natural texture; means nothing to a network with one
  void ask_for_texture(float natural) { texture_ = natural; }

  /// Computes vector() and geometry(), of what was seen and heard. Allocates nothing.
  /// @param speaker_m  the mouth, if it is known
  void set_pose(const std::optional<Vector3>& speaker_m, const Pose& source_from_target);

  [[nodiscard]] std::span<const float> vector() const { return vector_; }
  /// What the move does; null for a network that knows the bare pose.
  [[nodiscard]] const GtfGeometry* geometry() const { return geometry_ ? &*geometry_ : nullptr; }
  /// As set_summary() found it.
  [[nodiscard]] const GtfPlace& located() const { return located_; }
  /// As set_pose() took it.
  [[nodiscard]] const GtfPlace& place() const { return place_; }

 private:
  void locate(std::span<const float> summary);
  void put_box(const std::optional<Box>& box);

  GtfDescription description_;
  std::optional<GtfPictureEncoder> picture_encoder_;
  kernels::Dense locator_[3];
  kernels::Dense summary_, hidden_, output_;
  std::optional<GtfGeometry> geometry_;
  std::vector<float> feature_;  // of the picture
  std::array<float, GtfDescription::kBoxFeatures> box_{};
  std::vector<float> known_, first_, second_, joined_, middle_, vector_;
  std::array<float, gtf::kLocatorOutputs> found_{};
  std::vector<float> heard_;  // of the summary
  float texture_ = 1.0F;
  GtfPlace located_;  // by set_summary()
  GtfPlace place_;
};

}  // namespace earpoint::gtf
