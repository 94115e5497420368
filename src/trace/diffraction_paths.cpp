#include "diffraction_paths.h"

#include <algorithm>
#include <cmath>

namespace earpoint {
namespace {

constexpr double kStretch_m = 0.25;    // an edge is in sight or not in stretches of this length
constexpr double kClearance_m = 5e-3;  // how far from the edge its stretches are looked at

// Where the direct sound passes, an edge further round than this changes it by less than 1 dB above
// 125 Hz.
constexpr double kShortDetour_m = 1.0;

// Arrivals below this are left out: -60 dB of the source at 1 m.
constexpr float kFaint = 1e-3F;

std::size_t stretch_count(const DiffractionEdge& edge) {
  return static_cast<std::size_t>(std::max(1L, std::lround(edge.length_m / kStretch_m)));
}

bool is_in_air(const DiffractionEdge& edge, const EdgePoint& point) {
  constexpr double kGrazing_rad = 1e-6;
  return point.radius_m > kClearance_m && point.angle_rad > kGrazing_rad &&
         point.angle_rad < edge.wedge.open_angle_rad - kGrazing_rad;
}

// The same sound with the source's directivity and the air's losses.
std::optional<Arrival> finish(const Source& source, const Vector3& listener,
                              const Vector3& leaves_to, const Vector3& comes_from,
                              double distance_m, const BandArray& gain,
                              const Propagation& propagation) {
  Arrival arrival{.delay_s = distance_m / propagation.speed_m_per_s,
                  .direction = normalized(comes_from - listener),
                  .departure = normalized(leaves_to - source.world_from_source.position_m)};
  const BandArray sent = sent_energy(source, arrival.departure);
  const BandArray air = air_gain(propagation.absorption_db_per_m, distance_m);
  float loudest = 0.0F;
  for (int band = 0; band < kOctaveBands; ++band) {
    arrival.gain[band] = gain[band] * std::sqrt(sent[band]) * air[band];
    loudest = std::max(loudest, std::abs(arrival.gain[band]));
  }
  if (loudest < kFaint) return std::nullopt;
  return arrival;
}

std::optional<Arrival> round_one_edge(const DiffractionEdge& edge, const Source& source,
                                      const EdgeView& from, const EdgeView& to,
                                      const std::vector<EdgeInterval>& intervals, double longest_m,
                                      const Propagation& propagation) {
  const EdgePoint here = edge_point(edge, from.place());
  const EdgePoint there = edge_point(edge, to.place());
  if (!is_in_air(edge, here) || !is_in_air(edge, there)) return std::nullopt;
  if (std::hypot(here.radius_m + there.radius_m, here.z_m - there.z_m) > longest_m) {
    return std::nullopt;
  }
  const DiffractedSound sound =
      diffract(edge.wedge, here, there, intervals, propagation.speed_m_per_s);
  if (sound.distance_m > longest_m) return std::nullopt;
  const Vector3 apex = point_on_edge(edge, sound.apex_z_m, 0.0);
  return finish(source, to.place(), apex, apex, sound.distance_m, sound.gain, propagation);
}

// Over the end of a wall that is as thick as `pair.width_m`: the first edge's sound runs along the
// face between the edges and is the second edge's source. On a face the incident and the reflected
// wave are one, and each edge counts both: half the product.
std::optional<Arrival> round_two_edges(const SceneGeometry& scene, const EdgePair& pair,
                                       const Source& source, const EdgeView& from,
                                       const EdgeView& to, const Propagation& propagation) {
  const DiffractionEdge& first = scene.edges()[pair.first];
  const DiffractionEdge& second = scene.edges()[pair.second];
  const EdgePoint here = edge_point(first, from.place());
  const EdgePoint there = edge_point(second, to.place());
  if (!is_in_air(first, here) || !is_in_air(second, there)) return std::nullopt;

  // Both edges' z run the same way from different origins; unfolded, the way is straight.
  const double there_z = pair.first_from_second_z(there.z_m);
  const double across_m = here.radius_m + pair.width_m + there.radius_m;
  const double slope = (there_z - here.z_m) / across_m;
  const double first_z = here.z_m + slope * here.radius_m;
  const double second_z_in_first = here.z_m + slope * (here.radius_m + pair.width_m);
  const double second_z = pair.second_from_first_z(second_z_in_first);
  if (first_z < 0.0 || first_z > first.length_m) return std::nullopt;
  if (second_z < 0.0 || second_z > second.length_m) return std::nullopt;
  // Where one edge is enough, one edge has been counted.
  if (!from.sees(pair.first, first_z) || from.sees(pair.second, second_z)) return std::nullopt;
  if (!to.sees(pair.second, second_z) || to.sees(pair.first, first_z)) return std::nullopt;
  if (scene.rays().occluded(point_on_edge(first, first_z, kClearance_m),
                            point_on_edge(second, second_z, kClearance_m), scene.still_layers())) {
    return std::nullopt;
  }

  const double speed = propagation.speed_m_per_s;
  const std::vector<EdgeInterval> first_in_sight = from.intervals(pair.first);
  const std::vector<EdgeInterval> second_in_sight = to.intervals(pair.second);
  const DiffractedSound onto =
      diffract(first.wedge, here, {pair.width_m, pair.first_angle_rad, second_z_in_first},
               first_in_sight, speed);
  const double source_m = here.radius_m + pair.width_m;
  const double source_z = pair.second_from_first_z(here.z_m);
  const DiffractedSound off = diffract(second.wedge, {source_m, pair.second_angle_rad, source_z},
                                       there, second_in_sight, speed);
  const auto incident_m = static_cast<float>(std::hypot(source_m, second_z_in_first - here.z_m));
  BandArray gain;
  for (int band = 0; band < kOctaveBands; ++band) {
    gain[band] = 0.5F * onto.gain[band] * off.gain[band] * incident_m;
  }
  return finish(source, to.place(), point_on_edge(first, first_z, 0.0),
                point_on_edge(second, second_z, 0.0), std::hypot(across_m, there_z - here.z_m),
                gain, propagation);
}

}  // namespace

EdgeView::EdgeView(const SceneGeometry& scene, const Vector3& place, LayerMask mask,
                   std::int64_t& rays_cast)
    : scene_(&scene), place_(place) {
  for (const DiffractionEdge& edge : scene.edges()) {
    std::vector<bool>& stretches = in_sight_.emplace_back(stretch_count(edge), false);
    // From inside the wedge's solid no stretch is in sight.
    if (!is_in_air(edge, edge_point(edge, place))) continue;
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const double z_m =
          (static_cast<double>(i) + 0.5) * edge.length_m / static_cast<double>(stretches.size());
      ++rays_cast;
      stretches[i] = !scene.rays().occluded(place, point_on_edge(edge, z_m, kClearance_m), mask);
    }
  }
}

bool EdgeView::sees(std::size_t edge, double z_m) const {
  const std::vector<bool>& stretches = in_sight_[edge];
  const double place = z_m / scene_->edges()[edge].length_m * static_cast<double>(stretches.size());
  if (place < 0.0) return false;
  return stretches[std::min(stretches.size() - 1, static_cast<std::size_t>(place))];
}

std::vector<EdgeInterval> EdgeView::join(std::size_t edge,
                                         const std::vector<bool>& in_sight) const {
  const double step_m = scene_->edges()[edge].length_m / static_cast<double>(in_sight.size());
  std::vector<EdgeInterval> intervals;
  for (std::size_t i = 0; i < in_sight.size(); ++i) {
    if (!in_sight[i]) continue;
    const double end_m = static_cast<double>(i + 1) * step_m;
    if (i > 0 && in_sight[i - 1]) {
      intervals.back().end_m = end_m;
    } else {
      intervals.push_back({static_cast<double>(i) * step_m, end_m});
    }
  }
  return intervals;
}

std::vector<EdgeInterval> EdgeView::intervals(std::size_t edge) const {
  return join(edge, in_sight_[edge]);
}

std::vector<EdgeInterval> EdgeView::in_sight_of_both(const EdgeView& a, const EdgeView& b,
                                                     std::size_t edge) {
  std::vector<bool> both = a.in_sight_[edge];
  for (std::size_t i = 0; i < both.size(); ++i) both[i] = both[i] && b.in_sight_[edge][i];
  return a.join(edge, both);
}

std::vector<Arrival> diffracted_arrivals(const SceneGeometry& scene, const Source& source,
                                         const EdgeView& from, const EdgeView& to,
                                         const Propagation& propagation) {
  const bool direct =
      !scene.rays().occluded(from.place(), to.place(), scene.mask_without(source.body));
  const double straight_m = norm(to.place() - from.place());
  const double longest_m = direct ? straight_m + kShortDetour_m : 1e9;
  std::vector<Arrival> arrivals;
  const auto keep = [&](const std::optional<Arrival>& arrival) {
    if (arrival) arrivals.push_back(*arrival);
  };
  for (std::size_t edge = 0; edge < scene.edges().size(); ++edge) {
    const std::vector<EdgeInterval> intervals = EdgeView::in_sight_of_both(from, to, edge);
    if (intervals.empty()) continue;
    keep(round_one_edge(scene.edges()[edge], source, from, to, intervals, longest_m, propagation));
  }
  if (direct) return arrivals;
  for (const EdgePair& pair : scene.edge_pairs()) {
    keep(round_two_edges(scene, pair, source, from, to, propagation));
  }
  return arrivals;
}

}  // namespace earpoint
