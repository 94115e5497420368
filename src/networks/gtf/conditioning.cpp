#include "conditioning.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/kernels/dense.h>

namespace earpoint::gtf {

GtfConditions::GtfConditions(const GtfWeights& weights)
    : description_(weights.description),
      summary_(dense_of(weights, "summary")),
      hidden_(dense_of(weights, "conditioning.0")),
      output_(dense_of(weights, "conditioning.1")),
      feature_(static_cast<std::size_t>(description_.picture_features())),
      joined_(static_cast<std::size_t>(description_.conditioning_inputs())),
      middle_(static_cast<std::size_t>(description_.conditioning_width)),
      vector_(middle_.size()),
      heard_(static_cast<std::size_t>(description_.summary_width)) {
  if (description_.picture_px > 0) picture_encoder_.emplace(weights);
  if (!description_.geometry) return;
  for (int i = 0; i < 3; ++i) locator_[i] = dense_of(weights, fmt::format("locator.{}", i));
  geometry_.emplace(weights);
  known_.resize(static_cast<std::size_t>(description_.locator_inputs()));
  first_.resize(static_cast<std::size_t>(description_.locator_width));
  second_.resize(first_.size());
}

void GtfConditions::put_box(const std::optional<Box>& box) {
  box_.fill(0.0F);
  if (!box) return;
  const double height = box->y_max - box->y_min;
  const double width = box->x_max - box->x_min;
  // The view is 90 degrees across.
  const std::array<double, GtfDescription::kBoxFeatures> seen{
      1.0,
      std::atan(1.0 - (box->x_min + box->x_max)),
      1.0 - 2.0 * box->y_min,
      height,
      width,
      box->y_max > gtf::kLowestEdge ? 1.0 : 0.0,
      std::log(height + gtf::kBoxSizeFloor),
      std::log(width + gtf::kBoxSizeFloor),
      1.0 - 2.0 * box->y_max};
  std::ranges::copy(seen, box_.begin());
}

void GtfConditions::set_picture(std::span<const float> picture, const std::optional<Box>& box) {
  const std::optional<Box> told = description_.box ? box : std::nullopt;
  put_box(told);
  if (picture_encoder_) picture_encoder_->encode(picture, told, feature_);
}

void GtfConditions::locate(std::span<const float> summary) {
  auto to = std::copy(feature_.begin(), feature_.end(), known_.begin());
  if (description_.box) to = std::copy(box_.begin(), box_.end(), to);
  std::copy(summary.begin(), summary.end(), to);
  locator_[0].apply(known_, first_);
  kernels::silu(first_);
  locator_[1].apply(first_, second_);
  kernels::silu(second_);
  locator_[2].apply(second_, found_);

  // The direction starts from the box where there is one.
  const double seen = box_[0];
  const double front = found_[0] + gtf::kTrustInBox * seen * std::cos(box_[1]);
  const double left = found_[1] + gtf::kTrustInBox * seen * std::sin(box_[1]);
  const double distance = std::exp(
      gtf::kLogDistance + std::clamp(double{found_[2]}, gtf::kLeastLogRatio, gtf::kMostLogRatio));
  const double scale = distance / std::sqrt(front * front + left * left + gtf::kDirectionFloor);
  located_ = {{front * scale, left * scale, found_[3] * gtf::kHeightScale_m + gtf::kUsualHeight_m},
              found_[4],
              found_[5],
              found_[6]};
}

void GtfConditions::set_summary(std::span<const float> summary) {
  EARPOINT_CHECK(std::ssize(summary) == description_.summary_features());
  if (description_.geometry) locate(summary);
  summary_.apply(summary, heard_);
  kernels::silu(heard_);
}

void GtfConditions::set_pose(const std::optional<Vector3>& speaker_m,
                             const Pose& source_from_target) {
  float* to = joined_.data();
  Vector3 target_m = source_from_target.position_m;
  if (description_.geometry) {
    place_ = located_;
    if (speaker_m) place_.position_m = *speaker_m;
    geometry_->move(place_, speaker_m.has_value(), source_from_target);
    to = std::copy(geometry_->features().begin(), geometry_->features().end(), to);
    target_m = geometry_->shown_target_m();
  } else {
    to = put_pose(to, source_from_target);
  }
  to = std::copy(feature_.begin(), feature_.end(), to);
  to = std::copy(heard_.begin(), heard_.end(), to);
  if (description_.texture) *to++ = texture_;
  if (description_.sight_points > 0) {
    picture_encoder_->encode_towards(target_m,
                                     {to, static_cast<std::size_t>(description_.sight_features())});
    to += description_.sight_features();
  }
  EARPOINT_CHECK(to == joined_.data() + joined_.size());
  hidden_.apply(joined_, middle_);
  kernels::silu(middle_);
  output_.apply(middle_, vector_);
  kernels::silu(vector_);
}

}  // namespace earpoint::gtf
