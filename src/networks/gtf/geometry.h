#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/training_range.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint::gtf {

/// Where a network takes its speaker to be, in the source's frame.
struct GtfPlace {
  Vector3 position_m;
  double heading_x = 0.0;  ///< of any length
  double heading_y = 0.0;
  double log_reverberant = 0.0;  ///< diffuse power over that of the direct sound at 1 m
};

/// Per ear, left first, and band of the head tables.
using GtfEarBands = std::array<float, std::size_t{2} * GtfDescription::kHeadBands>;

/// What a move from the source to the target does to direction, distance, level and delay of the
/// speaker's sound. What the network is shown is limited to the range of its training data; beyond
/// it, correction() gives the difference by the physics of the true move: the direct sound falls
/// with distance, the diffuse field is the same everywhere.
class GtfGeometry {
 public:
  /// Takes the head's tables out of the weights of a network that knows geometry.
  explicit GtfGeometry(const GtfWeights& weights);

  /// Computes everything below. Allocates nothing.
  /// @param is_told  the speaker's position comes from the user: it has no limits
  void move(const GtfPlace& place, bool is_told, const Pose& source_from_target);

  /// What conditions the network.
  [[nodiscard]] std::span<const float> features() const { return features_; }
  /// Log of the amplitude expected at the target's ears over that at the source's, as the network
  /// is shown the move: [2][kHeadBands].
  [[nodiscard]] std::span<const float> expected_log_gain() const;
  /// Of the direct sound at the ears, left first.
  [[nodiscard]] const std::array<float, 2>& source_delay_s() const { return source_delay_s_; }
  [[nodiscard]] const std::array<float, 2>& target_delay_s() const { return target_delay_s_; }

  /// The target where the network is shown it, in the source's frame.
  [[nodiscard]] const Vector3& shown_target_m() const { return shown_target_m_; }
  /// Whether the move leaves the range of the training data.
  [[nodiscard]] bool is_beyond() const { return is_beyond_; }
  /// Amplitude factors that lead from the limited move to the true one; 1 within the range.
  [[nodiscard]] const GtfEarBands& correction() const { return correction_; }

  /// Power at both of the target's ears over that at both of the source's, expected of the true
  /// move.
  /// @param band_power  of the source's sound, both ears together, [kHeadBands]; sum > 0
  [[nodiscard]] double expected_gain(std::span<const double> band_power) const;

 private:
  struct Levels;

  [[nodiscard]] Levels levels_of(const GtfPlace& place, const Pose& source_from_target) const;
  void put_features(const GtfPlace& place, const Pose& source_from_target, const Levels& levels);

  GtfTrainingRange range_;
  std::vector<float> power_, diffuse_power_, delay_s_;  // tables of the head
  std::vector<float> features_;
  std::array<float, 2> source_delay_s_{};
  std::array<float, 2> target_delay_s_{};
  Vector3 shown_target_m_;
  bool is_beyond_ = false;
  GtfEarBands correction_{};
  GtfEarBands power_at_source_{}, power_at_target_{};  // of the true move
};

/// What describes a bare pose: position and turn.
/// @param to  5 values
/// @return behind the last value
float* put_pose(float* to, const Pose& pose);

}  // namespace earpoint::gtf
