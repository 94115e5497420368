#include "gtf_conditions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/core/error.h>

namespace earpoint::infer {
namespace {

using D = GtfDescription;

constexpr int kEars = 2;
constexpr double kNearest_m = 0.25;
constexpr double kPositionScale_m = 3.0;

struct Direction {
  double azimuth_rad, elevation_rad, distance_m;
};

/// Lengths have a floor, as in training, where their slope must be finite at zero.
Direction direction_of(const Vector3& v) {
  const double level = std::sqrt(v.x * v.x + v.y * v.y + 1e-4);
  return {std::atan2(v.y, v.x), std::atan2(v.z, level),
          std::max(std::sqrt(dot(v, v) + 1e-2), kNearest_m)};
}

/// Reads a table over all azimuths between its rows.
/// @param table  [azimuths][out.size()]
void read_table(std::span<const float> table, double azimuth_rad, std::span<float> out) {
  const double at = azimuth_rad / (2.0 * kPi) * D::kHeadAzimuths;
  const double below = std::floor(at);
  const auto fraction = static_cast<float>(at - below);
  const auto row = [](double index) {
    const int wrapped = static_cast<int>(index) % D::kHeadAzimuths;
    return static_cast<std::size_t>(wrapped < 0 ? wrapped + D::kHeadAzimuths : wrapped);
  };
  const std::size_t first = row(below) * out.size();
  const std::size_t second = row(below + 1.0) * out.size();
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = table[first + i] * (1.0F - fraction) + table[second + i] * fraction;
  }
}

using EarBands = std::array<float, std::size_t{kEars} * D::kHeadBands>;

/// Cosine of the angle between the heading and where the listener is.
double facing(double x, double y, const Vector3& listener) {
  return (x * listener.x + y * listener.y) /
         std::sqrt(listener.x * listener.x + listener.y * listener.y + 1e-2);
}

float* put(float* to, std::initializer_list<double> values) {
  for (const double value : values) *to++ = static_cast<float>(value);
  return to;
}

float* put_pose(float* to, const Pose& pose) {
  const Vector3 p = pose.position_m / kPositionScale_m;
  const double yaw_rad = euler_from_quaternion(pose.orientation).yaw_rad;
  return put(to, {p.x, p.y, p.z, std::sin(yaw_rad), std::cos(yaw_rad)});
}

std::vector<float> table_of(const GtfWeights& weights, const char* name) {
  const auto values = weights.at(name).as<float>();
  return {values.begin(), values.end()};
}

}  // namespace

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
  if (description_.picture_px > 0) eye_.emplace(weights);
  if (!description_.geometry) return;
  for (int i = 0; i < 3; ++i) locator_[i] = dense_of(weights, fmt::format("locator.{}", i));
  power_ = table_of(weights, "head.power");
  diffuse_power_ = table_of(weights, "head.diffuse_power");
  delay_s_ = table_of(weights, "head.delay_s");
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
  put(box_.data(), {1.0, std::atan(1.0 - (box->x_min + box->x_max)), 1.0 - 2.0 * box->y_min, height,
                    width, box->y_max > 0.99 ? 1.0 : 0.0, std::log(height + 0.02),
                    std::log(width + 0.02), 1.0 - 2.0 * box->y_max});
}

void GtfConditions::look(std::span<const float> picture, const std::optional<Box>& box) {
  const std::optional<Box> told = description_.box ? box : std::nullopt;
  put_box(told);
  if (eye_) eye_->look(picture, told, feature_);
}

void GtfConditions::locate(std::span<const float> summary) {
  auto to = std::copy(feature_.begin(), feature_.end(), known_.begin());
  if (description_.box) to = std::copy(box_.begin(), box_.end(), to);
  std::copy(summary.begin(), summary.end(), to);
  locator_[0].apply(known_, first_);
  apply_silu(first_);
  locator_[1].apply(first_, second_);
  apply_silu(second_);
  locator_[2].apply(second_, found_);

  // The direction starts from the box where there is one.
  constexpr double kTrustInBox = 3.0;
  const double seen = box_[0];
  const double front = found_[0] + kTrustInBox * seen * std::cos(box_[1]);
  const double left = found_[1] + kTrustInBox * seen * std::sin(box_[1]);
  const double distance = std::exp(0.6 + std::clamp(double{found_[2]}, -2.0, 1.5));
  const double scale = distance / std::sqrt(front * front + left * left + 1e-4);
  located_ = {
      {front * scale, left * scale, found_[3] * 0.3 - 0.1}, found_[4], found_[5], found_[6]};
}

float* GtfConditions::put_geometry(const Pose& source_from_target, float* to) {
  const Vector3& place = place_.position_m;
  const Direction source = direction_of(place);
  const Direction target = direction_of(transform_point(inverse(source_from_target), place));
  read_table(delay_s_, source.azimuth_rad, source_delay_s_);
  read_table(delay_s_, target.azimuth_rad, target_delay_s_);

  const double reverberant = std::exp(place_.log_reverberant);
  const auto levels = [&](const Direction& direction, EarBands& log_power) {
    read_table(power_, direction.azimuth_rad, log_power);
    for (std::size_t i = 0; i < log_power.size(); ++i) {
      log_power[i] =
          static_cast<float>(std::log(log_power[i] / (direction.distance_m * direction.distance_m) +
                                      reverberant * diffuse_power_[i]));
    }
  };
  EarBands at_source{};
  EarBands at_target{};
  levels(source, at_source);
  levels(target, at_target);

  const double length =
      std::sqrt(place_.heading_x * place_.heading_x + place_.heading_y * place_.heading_y + 1e-4);
  const double x = place_.heading_x / length;
  const double y = place_.heading_y / length;
  const Vector3 scaled = place / kPositionScale_m;
  to = put_pose(to, source_from_target);
  to = put(
      to, {scaled.x, scaled.y, scaled.z, std::log(source.distance_m), std::sin(source.azimuth_rad),
           std::cos(source.azimuth_rad), std::sin(target.azimuth_rad), std::cos(target.azimuth_rad),
           std::log(target.distance_m), std::log(source.distance_m / target.distance_m),
           source.elevation_rad, target.elevation_rad, facing(x, y, -place),
           facing(x, y, source_from_target.position_m - place), place_.log_reverberant / 3});
  for (std::size_t i = 0; i < at_source.size(); ++i) *to++ = (at_target[i] - at_source[i]) / 2;
  for (const EarBands& levels_db : {at_target, at_source}) {
    for (int band = 0; band < D::kHeadBands; ++band) {
      *to++ = (levels_db[band] - levels_db[D::kHeadBands + band]) / 2;
    }
  }
  return to;
}

void GtfConditions::hear(std::span<const float> summary) {
  EARPOINT_CHECK(std::ssize(summary) == description_.summary_features());
  if (description_.geometry) locate(summary);
  summary_.apply(summary, heard_);
  apply_silu(heard_);
}

void GtfConditions::aim(const std::optional<Vector3>& speaker_m, const Pose& source_from_target) {
  float* to = joined_.data();
  if (description_.geometry) {
    place_ = located_;
    if (speaker_m) place_.position_m = *speaker_m;
    to = put_geometry(source_from_target, to);
  } else {
    to = put_pose(to, source_from_target);
  }
  to = std::copy(feature_.begin(), feature_.end(), to);
  to = std::copy(heard_.begin(), heard_.end(), to);
  EARPOINT_CHECK(to == joined_.data() + joined_.size());
  hidden_.apply(joined_, middle_);
  apply_silu(middle_);
  output_.apply(middle_, vector_);
  apply_silu(vector_);
}

}  // namespace earpoint::infer
