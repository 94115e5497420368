#include "geometry.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/atan2.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/stack.h>

#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

/// One coordinate of every clip: [clips][1].
at::Tensor axis(const at::Tensor& points, std::int64_t index) { return points.narrow(1, index, 1); }

/// sqrt(sum of squares + floor): its slope is finite at zero.
at::Tensor length_of(const at::Tensor& vectors, double floor) {
  return (vectors.square().sum(at::IntArrayRef({1}), /*keepdim=*/true) + floor).sqrt();
}

struct Direction {
  at::Tensor azimuth_rad, elevation_rad, distance_m;  // [clips][1]
};

Direction direction_of(const at::Tensor& point_m) {
  const at::Tensor x = axis(point_m, 0);
  const at::Tensor level = length_of(point_m.narrow(1, 0, 2), gtf::kDirectionFloor);
  return {at::atan2(axis(point_m, 1), x + (x == 0).to(at::kFloat) * 1e-6),
          at::atan2(axis(point_m, 2), level),
          length_of(point_m, gtf::kDistanceFloor).clamp_min(GtfDescription::kNearestSpeaker_m)};
}

/// Points in the frame of a listener at the origin who turned by `yaw_rad`.
at::Tensor seen_after_turn(const at::Tensor& point, const at::Tensor& yaw_rad) {
  const at::Tensor c = yaw_rad.cos();
  const at::Tensor s = yaw_rad.sin();
  const at::Tensor x = axis(point, 0);
  const at::Tensor y = axis(point, 1);
  return at::cat({c * x + s * y, c * y - s * x, axis(point, 2)}, 1);
}

/// A table over all azimuths, interpolated between its rows.
at::Tensor read_table(const at::Tensor& table, const at::Tensor& azimuth_rad) {
  const std::int64_t rows = table.size(0);
  const at::Tensor at_row =
      (azimuth_rad.squeeze(1) * (static_cast<double>(rows) / (2.0 * kPi))).remainder(rows);
  const at::Tensor below = at_row.detach().floor();
  const at::Tensor first = below.to(at::kLong).remainder(rows);
  std::vector<std::int64_t> shape(static_cast<std::size_t>(table.dim()), 1);
  shape[0] = -1;
  const at::Tensor fraction = (at_row - below).reshape(shape);
  return table.index_select(0, first) * (1 - fraction) +
         table.index_select(0, (first + 1).remainder(rows)) * fraction;
}

/// Log power at both ears by direct sound and reverberation: [clips][2][bands].
at::Tensor log_power(const HeadTables& head, const Direction& direction,
                     const at::Tensor& reverberant) {
  const at::Tensor nearness = direction.distance_m.square().reciprocal().unsqueeze(2);
  return (read_table(head.power, direction.azimuth_rad) * nearness +
          reverberant.unsqueeze(2) * head.diffuse_power)
      .log();
}

/// Cosine of the angle between where the speaker looks and where the listener is: [clips][1].
at::Tensor facing(const at::Tensor& heading, const at::Tensor& listener_from_speaker) {
  const at::Tensor level = listener_from_speaker.narrow(1, 0, 2);
  return (heading * level).sum(at::IntArrayRef({1}), true) / length_of(level, gtf::kDistanceFloor);
}

at::Tensor between_ears(const at::Tensor& log_powers) {
  return (log_powers.select(1, 0) - log_powers.select(1, 1)) / 2;
}

}  // namespace

at::Tensor pose_features(const at::Tensor& position_m, const at::Tensor& yaw_rad) {
  return at::cat({position_m / gtf::kPositionScale_m, yaw_rad.sin(), yaw_rad.cos()}, 1);
}

MoveGeometry move_geometry(const HeadTables& head, const SpeakerPlace& speaker,
                           const at::Tensor& target_m, const at::Tensor& target_yaw_rad) {
  const at::Tensor& place = speaker.position_m;
  const Direction source = direction_of(place);
  const Direction target = direction_of(seen_after_turn(place - target_m, target_yaw_rad));
  const at::Tensor heading = speaker.heading / length_of(speaker.heading, gtf::kDirectionFloor);
  const at::Tensor reverberant = speaker.log_reverberant.unsqueeze(1);
  const at::Tensor at_source = log_power(head, source, reverberant.exp());
  const at::Tensor at_target = log_power(head, target, reverberant.exp());

  MoveGeometry move;
  move.expected_log_gain = (at_target - at_source) / 2;
  move.features =
      at::cat({pose_features(target_m, target_yaw_rad), place / gtf::kPositionScale_m,
               source.distance_m.log(), source.azimuth_rad.sin(), source.azimuth_rad.cos(),
               target.azimuth_rad.sin(), target.azimuth_rad.cos(), target.distance_m.log(),
               (source.distance_m / target.distance_m).log(), source.elevation_rad,
               target.elevation_rad, facing(heading, -place), facing(heading, target_m - place),
               reverberant / gtf::kReverberationScale, move.expected_log_gain.flatten(1),
               between_ears(at_target), between_ears(at_source)},
              1);
  move.source_delay_s = read_table(head.delay_s, source.azimuth_rad);
  move.target_delay_s = read_table(head.delay_s, target.azimuth_rad);
  return move;
}

}  // namespace earpoint
