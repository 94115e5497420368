#include "geometry.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;

/// Where the features have the expected gains.
constexpr std::size_t kExpectedLogGain = 20;

struct Direction {
  double azimuth_rad, elevation_rad, distance_m;
};

/// Lengths have a floor, as in training, where their gradient must be finite at zero.
Direction direction_of(const Vector3& v) {
  const double level = std::sqrt(v.x * v.x + v.y * v.y + gtf::kDirectionFloor);
  return {std::atan2(v.y, v.x), std::atan2(v.z, level),
          std::max(std::sqrt(dot(v, v) + gtf::kDistanceFloor), D::kNearestSpeaker_m)};
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

/// Cosine of the angle between the heading and the direction of the listener.
double facing(double x, double y, const Vector3& listener) {
  return (x * listener.x + y * listener.y) /
         std::sqrt(listener.x * listener.x + listener.y * listener.y + gtf::kDistanceFloor);
}

float* put(float* to, std::initializer_list<double> values) {
  for (const double value : values) *to++ = static_cast<float>(value);
  return to;
}

/// Limits the length of a vector, then its height up or down.
Vector3 limited(Vector3 v, double length, double height) {
  const double found = norm(v);
  if (found > length) v = v * (length / found);
  v.z = std::clamp(v.z, -height, height);
  return v;
}

GtfPlace limited(GtfPlace place, const GtfTrainingRange& range) {
  place.position_m = limited(place.position_m, range.farthest_speaker_m, range.highest_speaker_m);
  return place;
}

double azimuth_of(const Vector3& v) { return std::atan2(v.y, v.x); }

/// The nearest pose in the range of the training data at which the speaker is heard from the same
/// direction: `place` as limited, `true_m` as it is.
Pose limited(const Pose& source_from_target, const GtfPlace& place, const Vector3& true_m,
             const GtfTrainingRange& range) {
  const Vector3 position =
      limited(source_from_target.position_m, range.farthest_move_m, range.highest_move_m);
  if (position == source_from_target.position_m && place.position_m == true_m) {
    return source_from_target;
  }
  const double turn =
      azimuth_of(place.position_m - position) - azimuth_of(true_m - source_from_target.position_m);
  return {position, quaternion_from_euler({.yaw_rad = turn}) * source_from_target.orientation};
}

std::vector<float> table_of(const GtfWeights& weights, const char* name) {
  const auto values = weights.at(name).as<float>();
  return {values.begin(), values.end()};
}

}  // namespace

/// Directions and log powers at both places.
struct GtfGeometry::Levels {
  Direction source, target;
  GtfEarBands at_source, at_target;
};

GtfGeometry::GtfGeometry(const GtfWeights& weights)
    : range_(weights.description.training_range),
      power_(table_of(weights, "head.power")),
      diffuse_power_(table_of(weights, "head.diffuse_power")),
      delay_s_(table_of(weights, "head.delay_s")),
      features_(static_cast<std::size_t>(weights.description.geometry_features())) {
  EARPOINT_CHECK(weights.description.geometry);
}

GtfGeometry::Levels GtfGeometry::levels_of(const GtfPlace& place,
                                           const Pose& source_from_target) const {
  Levels levels{direction_of(place.position_m),
                direction_of(transform_point(inverse(source_from_target), place.position_m)),
                {},
                {}};
  const double reverberant = std::exp(place.log_reverberant);
  const auto fill = [&](const Direction& direction, GtfEarBands& log_power) {
    read_table(power_, direction.azimuth_rad, log_power);
    for (std::size_t i = 0; i < log_power.size(); ++i) {
      log_power[i] =
          static_cast<float>(std::log(log_power[i] / (direction.distance_m * direction.distance_m) +
                                      reverberant * diffuse_power_[i]));
    }
  };
  fill(levels.source, levels.at_source);
  fill(levels.target, levels.at_target);
  return levels;
}

void GtfGeometry::put_features(const GtfPlace& place, const Pose& source_from_target,
                               const Levels& levels) {
  const Direction& source = levels.source;
  const Direction& target = levels.target;
  const double length = std::sqrt(place.heading_x * place.heading_x +
                                  place.heading_y * place.heading_y + gtf::kDirectionFloor);
  const double x = place.heading_x / length;
  const double y = place.heading_y / length;
  const Vector3 scaled = place.position_m / gtf::kPositionScale_m;
  float* to = put_pose(features_.data(), source_from_target);
  to = put(
      to, {scaled.x, scaled.y, scaled.z, std::log(source.distance_m), std::sin(source.azimuth_rad),
           std::cos(source.azimuth_rad), std::sin(target.azimuth_rad), std::cos(target.azimuth_rad),
           std::log(target.distance_m), std::log(source.distance_m / target.distance_m),
           source.elevation_rad, target.elevation_rad, facing(x, y, -place.position_m),
           facing(x, y, source_from_target.position_m - place.position_m),
           place.log_reverberant / gtf::kReverberationScale});
  EARPOINT_CHECK(to == features_.data() + kExpectedLogGain);
  for (std::size_t i = 0; i < levels.at_source.size(); ++i) {
    *to++ = (levels.at_target[i] - levels.at_source[i]) / 2;
  }
  for (const GtfEarBands* log_power : {&levels.at_target, &levels.at_source}) {
    for (std::size_t band = 0; band < D::kHeadBands; ++band) {
      *to++ = ((*log_power)[band] - (*log_power)[D::kHeadBands + band]) / 2;
    }
  }
  EARPOINT_CHECK(to == features_.data() + features_.size());
}

std::span<const float> GtfGeometry::expected_log_gain() const {
  return std::span(features_).subspan(kExpectedLogGain, GtfEarBands{}.size());
}

void GtfGeometry::move(const GtfPlace& place, bool is_told, const Pose& source_from_target) {
  const GtfPlace near_place = is_told ? limited(place, range_) : place;
  const Pose near_pose = limited(source_from_target, near_place, place.position_m, range_);
  shown_target_m_ = near_pose.position_m;
  const Levels levels = levels_of(near_place, near_pose);
  put_features(near_place, near_pose, levels);
  read_table(delay_s_, levels.source.azimuth_rad, source_delay_s_);
  read_table(delay_s_, levels.target.azimuth_rad, target_delay_s_);

  is_beyond_ = near_pose != source_from_target || near_place.position_m != place.position_m;
  const Levels true_levels = is_beyond_ ? levels_of(place, source_from_target) : levels;
  for (std::size_t i = 0; i < correction_.size(); ++i) {
    power_at_source_[i] = std::exp(true_levels.at_source[i]);
    power_at_target_[i] = std::exp(true_levels.at_target[i]);
    const float missing = true_levels.at_target[i] - true_levels.at_source[i] -
                          (levels.at_target[i] - levels.at_source[i]);
    correction_[i] = std::exp(missing / 2);
  }
}

double GtfGeometry::expected_gain(std::span<const double> band_power) const {
  EARPOINT_CHECK(band_power.size() == std::size_t{D::kHeadBands});
  double before = 0.0;
  double after = 0.0;
  for (std::size_t band = 0; band < band_power.size(); ++band) {
    const double at_source = power_at_source_[band] + power_at_source_[D::kHeadBands + band];
    const double at_target = power_at_target_[band] + power_at_target_[D::kHeadBands + band];
    before += band_power[band];
    after += band_power[band] * at_target / at_source;
  }
  return after / before;
}

float* put_pose(float* to, const Pose& pose) {
  const Vector3 p = pose.position_m / gtf::kPositionScale_m;
  const double yaw_rad = euler_from_quaternion(pose.orientation).yaw_rad;
  return put(to, {p.x, p.y, p.z, std::sin(yaw_rad), std::cos(yaw_rad)});
}

}  // namespace earpoint::gtf
