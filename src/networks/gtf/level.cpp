#include <earpoint/gtf/level.h>

#include <algorithm>
#include <cmath>

#include <earpoint/audio/energy.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kAtRest_db = 0.3;
// When the speaker comes into sight around the edge of a wall, the level rises by 10 dB or more.
constexpr double kPerMetre_db = 4.5;
constexpr double kFull_m = 2.0;
// Tables of one head, over all of which a turn of the same sound varies by about that.
constexpr double kTurned_db = 1.5;
// The strength of the diffuse field is an estimate. For a listener who walks away, nothing may get
// louder.
constexpr LevelTolerance kBeyond{.louder_db = 1.0, .quieter_db = 3.0};
constexpr double kLoudest_db = 12.0;
/// Trust in the network fades over this many doublings of the farthest trained move.
constexpr double kFadeOctaves = 1.0;

void bring_within(const LevelBounds& bounds, const Waveform& source, Waveform& result) {
  EARPOINT_CHECK(source.planar().size() == result.planar().size());
  const double found = energy(result.planar());
  if (found <= 0.0) return;
  const double ratio = found / energy(source.planar());  // infinite for silence, which stays silent
  const double allowed = std::clamp(ratio, bounds.least, bounds.most);
  if (allowed == ratio) return;
  const auto gain = static_cast<float>(std::sqrt(allowed / ratio));
  for (float& sample : result.planar()) sample *= gain;
}

}  // namespace

LevelTolerance gtf_level_tolerance(const Pose& source_from_target, const GtfTrainingRange& range) {
  const double distance_m = norm(source_from_target.position_m);
  const Vector3 front = rotate(source_from_target.orientation, {1, 0, 0});
  const double within_db = kAtRest_db + kPerMetre_db * std::min(distance_m, kFull_m) +
                           kTurned_db * (1.0 - front.x) / 2.0;
  const double octaves = std::log2(std::max(distance_m / range.farthest_move_m, 1.0));
  const double beyond = std::min(octaves / kFadeOctaves, 1.0);
  return {.louder_db = std::lerp(within_db, kBeyond.louder_db, beyond),
          .quieter_db = std::lerp(within_db, kBeyond.quieter_db, beyond)};
}

LevelTolerance gtf_level_tolerance(std::span<const Pose> path, const GtfTrainingRange& range) {
  EARPOINT_CHECK(!path.empty());
  LevelTolerance sum;
  for (const Pose& pose : path) {
    const LevelTolerance tolerance = gtf_level_tolerance(pose, range);
    sum.louder_db += tolerance.louder_db;
    sum.quieter_db += tolerance.quieter_db;
  }
  const auto count = static_cast<double>(path.size());
  return {sum.louder_db / count, sum.quieter_db / count};
}

LevelBounds gtf_level_bounds(double expected_gain, const LevelTolerance& tolerance,
                             bool knows_place) {
  const double expected_db = 10.0 * std::log10(expected_gain);
  const double most_db = std::min(expected_db + tolerance.louder_db,
                                  knows_place ? std::max(kLoudest_db, expected_db) : kLoudest_db);
  const double least_db = std::min(expected_db - tolerance.quieter_db, most_db);
  return {.least = std::pow(10.0, least_db / 10.0), .most = std::pow(10.0, most_db / 10.0)};
}

void limit_level(const Waveform& source, double expected_gain, const LevelTolerance& tolerance,
                 bool knows_place, Waveform& result) {
  bring_within(gtf_level_bounds(expected_gain, tolerance, knows_place), source, result);
}

void limit_loudness(const Waveform& source, Waveform& result) {
  bring_within({.least = 0.0, .most = std::pow(10.0, kLoudest_db / 10.0)}, source, result);
}

}  // namespace earpoint
