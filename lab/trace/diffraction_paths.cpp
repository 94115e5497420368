#include "diffraction_paths.h"

#include "band_pulses.h"
#include "face_reflections.h"
#include "passage_ways.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

// If the straight path is free, edges whose path is longer by more than this change the level by
// less than 1 dB above 125 Hz. They are left out, with a fade from half of it on.
constexpr double kLongestDetour_m = 2.0;
// In the shadow the limit grows by this many times the detour of the shortest path.
constexpr double kLongerInShadow = 40.0;

// Arrivals below this are left out: -60 dB of the source at 1 m.
constexpr float kFaint = 1e-3F;

// Sound of one source at one listener.
struct Connection {
  const SceneGeometry& scene;
  const EdgeView& from;
  const EdgeView& to;
  bool straight_is_free = false;
  std::span<const Arrival> mirrored;
  double speed_m_per_s = 0.0;
};

// The path around one edge.
struct EdgeWay {
  const Wedge* wedge = nullptr;
  EdgePoint here;
  EdgePoint there;
  std::vector<EdgeInterval> intervals;
  Way shortest;
};

std::optional<EdgeWay> way_round(const Connection& connection, std::size_t index) {
  const DiffractionEdge& edge = connection.scene.edges()[index];
  std::vector<EdgeInterval> intervals =
      overlap(connection.from.intervals(index), connection.to.intervals(index));
  if (intervals.empty()) return std::nullopt;
  const EdgePoint here = edge_point(edge, connection.from.place());
  const EdgePoint there = edge_point(edge, connection.to.place());
  const EdgeApex apex = find_apex(here, there, intervals);
  const Vector3 point = point_on_edge(edge, apex.z_m, 0.0);
  return EdgeWay{&edge.wedge, here, there, std::move(intervals), {apex.distance_m, point, point}};
}

DiffractionSpectrum sound_along(const Connection& connection, const EdgeWay& way) {
  const UnbentSound unbent{.straight = connection.straight_is_free,
                           .mirrored = is_mirrored(connection.mirrored, way.shortest.distance_m,
                                                   connection.speed_m_per_s)};
  return diffract(*way.wedge, way.here, way.there, way.intervals, unbent, connection.speed_m_per_s);
}

std::optional<FacePlace> place_at(const SceneGeometry& scene, const EdgePair& pair,
                                  const EdgeView& view) {
  if (!view.sees(pair.edges[0]) && !view.sees(pair.edges[1])) return std::nullopt;
  FacePlace place;
  for (int which = 0; which < 2; ++which) {
    const EdgePoint point = edge_point(scene.edges()[pair.edges[which]], view.place());
    if (which == 0) place.z_m = point.z_m;
    FacePoint& seen = place.points[which];
    seen.radius_m = point.radius_m;
    seen.angle_rad = std::abs(point.angle_rad - pair.face_angle_rad[which]);
    seen.in_sight = view.intervals(pair.edges[which]);
    if (which == 0) continue;
    for (EdgeInterval& interval : seen.in_sight) {
      const double a = pair.opposite_z(1, interval.begin_m);
      const double b = pair.opposite_z(1, interval.end_m);
      interval = {std::min(a, b), std::max(a, b)};
    }
    if (pair.z_sign < 0.0) std::reverse(seen.in_sight.begin(), seen.in_sight.end());
  }
  return place;
}

// The paths over the face of a pair.
struct FaceWay {
  const EdgeFace* face = nullptr;
  FacePlace here;
  FacePlace there;
  Way shortest;  // in at one edge and out at the other; at one edge only, forth and back
};

Way shortest_over(const SceneGeometry& scene, const EdgePair& pair, const FacePlace& here,
                  const FacePlace& there) {
  Way way;
  way.distance_m = 1e9;
  for (int in = 0; in < 2; ++in) {
    for (int out = 0; out < 2; ++out) {
      if (here.points[in].in_sight.empty() || there.points[out].in_sight.empty()) continue;
      const double in_m = here.points[in].radius_m;
      const double across_m =
          in_m + there.points[out].radius_m + pair.face.width_m * (in == out ? 2.0 : 1.0);
      const double along_m = there.z_m - here.z_m;
      const double distance_m = std::hypot(across_m, along_m);
      if (distance_m >= way.distance_m) continue;
      const double slope = along_m / across_m;
      const auto point = [&](int which, double first_z) {
        const double z = which == 0 ? first_z : pair.opposite_z(0, first_z);
        return point_on_edge(scene.edges()[pair.edges[which]], z, 0.0);
      };
      way = {distance_m, point(in, here.z_m + slope * in_m),
             point(out, there.z_m - slope * there.points[out].radius_m)};
    }
  }
  return way;
}

std::optional<FaceWay> way_over(const Connection& connection, const EdgePair& pair) {
  const std::optional<FacePlace> here = place_at(connection.scene, pair, connection.from);
  if (!here) return std::nullopt;
  const std::optional<FacePlace> there = place_at(connection.scene, pair, connection.to);
  if (!there) return std::nullopt;
  const Way shortest = shortest_over(connection.scene, pair, *here, *there);
  return FaceWay{&pair.face, *here, *there, shortest};
}

DiffractionSpectrum sound_along(const Connection& connection, const FaceWay& way) {
  return diffract_over_face(*way.face, way.here, way.there, way.shortest.distance_m,
                            connection.speed_m_per_s);
}

DiffractionSpectrum sound_along(const Connection& connection, const PassageWay& way) {
  return sound_of_both_sides(way, connection.speed_m_per_s);
}

// The paths around a group of edges, whose sound adds up to one wave.
struct GroupWays {
  std::vector<EdgeWay> round_edges;
  std::vector<FaceWay> over_faces;
  std::vector<PassageWay> through_passages;
  Way shortest;
};

std::optional<GroupWays> ways_round(const Connection& connection, const EdgeGroup& group) {
  GroupWays ways;
  ways.shortest.distance_m = 1e9;
  const auto keep = [&](auto way, auto& list) {
    if (!way) return;
    if (way->shortest.distance_m < ways.shortest.distance_m) ways.shortest = way->shortest;
    list.push_back(std::move(*way));
  };
  for (const std::size_t edge : group.edges) keep(way_round(connection, edge), ways.round_edges);
  for (const std::size_t pair : group.pairs) {
    keep(way_over(connection, connection.scene.edge_pairs()[pair]), ways.over_faces);
  }
  if (ways.round_edges.empty() && ways.over_faces.empty()) return std::nullopt;
  return ways;
}

// Sums the pressure of all paths; phases are relative to the shortest.
DiffractionSpectrum sum_sound(const Connection& connection, const GroupWays& ways) {
  DiffractionSpectrum sum{};
  const auto add = [&](const auto& way) {
    const DiffractionSpectrum sound = sound_along(connection, way);
    const double longer_m = way.shortest.distance_m - ways.shortest.distance_m;
    for (int i = 0; i < kDiffractionFrequencies; ++i) {
      const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / connection.speed_m_per_s;
      sum[i] += sound[i] * std::polar(1.0, -wave_number * longer_m);
    }
  };
  for (const EdgeWay& way : ways.round_edges) add(way);
  for (const FaceWay& way : ways.over_faces) add(way);
  for (const PassageWay& way : ways.through_passages) add(way);
  return sum;
}

// Weight of a path's pressure.
double share_of_detour(double distance_m, double shortest_m, double straight_m) {
  const double limit_m = kLongestDetour_m + kLongerInShadow * (shortest_m - straight_m);
  return std::clamp(2.0 - 2.0 * (distance_m - shortest_m) / limit_m, 0.0, 1.0);
}

// Adds the sound as arrivals with the source's directivity and air absorption.
void add_arrivals(const Source& source, const Vector3& listener, const Way& way,
                  const DiffractionSpectrum& sound, double share, const Propagation& propagation,
                  std::vector<Arrival>& arrivals) {
  Arrival arrival{.direction = normalized(way.comes_from - listener),
                  .departure = normalized(way.leaves_to - source.world_from_source.position_m),
                  .gain = {}};
  const BandArray sent = sent_energy(source, arrival.departure);
  const BandArray air = air_gain(propagation.absorption_db_per_m, way.distance_m);
  for (const BandPulse& pulse : band_pulses(sound)) {
    arrival.delay_s = way.distance_m / propagation.speed_m_per_s + pulse.later_s;
    float loudest = 0.0F;
    for (int band = 0; band < kOctaveBands; ++band) {
      arrival.gain[band] =
          static_cast<float>(share) * pulse.gain[band] * std::sqrt(sent[band]) * air[band];
      loudest = std::max(loudest, std::abs(arrival.gain[band]));
    }
    if (loudest >= kFaint) arrivals.push_back(arrival);
  }
}

bool is_free(const SceneGeometry& scene, const Source& source, const Vector3& listener) {
  return !scene.rays().occluded(source.world_from_source.position_m, listener,
                                scene.mask_without(source.body));
}

// Rounding of the rays' floats as an angle around an edge.
constexpr double kRounding_rad = 1e-5;

// Whether the listener is within rounding of a shadow boundary.
bool touches_edge(const SceneGeometry& scene, const EdgeView& from, const EdgeView& to) {
  for (std::size_t i = 0; i < scene.edges().size(); ++i) {
    if (!from.sees(i) || !to.sees(i)) continue;
    const DiffractionEdge& edge = scene.edges()[i];
    const double turn_rad =
        std::abs(edge_point(edge, from.place()).angle_rad - edge_point(edge, to.place()).angle_rad);
    if (std::abs(turn_rad - kPi) < kRounding_rad) return true;
  }
  return false;
}

// If rays along a face may be blocked, a view from just behind the boundary replaces the
// listener's.
std::optional<EdgeView> behind_boundary(const SceneGeometry& scene, const Source& source,
                                        const EdgeView& from, const EdgeView& to) {
  constexpr double kAside_m = 2e-4;
  if (!touches_edge(scene, from, to)) return std::nullopt;
  for (const Vector3& aside : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}}) {
    for (const double distance_m : {kAside_m, -kAside_m}) {
      const Vector3 place = to.place() + aside * distance_m;
      if (is_free(scene, source, place)) continue;
      std::int64_t rays_cast = 0;
      EdgeView view(scene, place, kAllLayers, rays_cast);
      if (!touches_edge(scene, from, view)) return view;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Arrival> diffracted_arrivals(const SceneGeometry& scene, const Source& source,
                                         const EdgeView& from, const EdgeView& to,
                                         std::span<const Arrival> mirrored,
                                         const Propagation& propagation) {
  const bool direct = is_free(scene, source, to.place());
  std::optional<EdgeView> moved;
  if (!direct) moved = behind_boundary(scene, source, from, to);
  std::vector<Arrival> arrivals = face_reflections(scene, source, from, to, mirrored, propagation);
  std::vector<Arrival> all_mirrored(mirrored.begin(), mirrored.end());
  all_mirrored.insert(all_mirrored.end(), arrivals.begin(), arrivals.end());
  const Connection connection{.scene = scene,
                              .from = from,
                              .to = moved ? *moved : to,
                              .straight_is_free = direct,
                              .mirrored = all_mirrored,
                              .speed_m_per_s = propagation.speed_m_per_s};
  const double straight_m = norm(connection.to.place() - from.place());
  double shortest_m = direct ? straight_m : 1e9;
  std::vector<GroupWays> groups;
  for (const EdgeGroup& group : scene.edge_groups()) {
    std::optional<GroupWays> ways = ways_round(connection, group);
    if (!ways) continue;
    shortest_m = std::min(shortest_m, ways->shortest.distance_m);
    groups.push_back(std::move(*ways));
  }
  for (const FacingPair& facing : scene.facing_pairs()) {
    std::optional<PassageWay> way = way_through(scene, facing, connection.from, connection.to);
    if (!way) continue;
    const Way shortest = way->shortest;
    groups.push_back({.round_edges = {},
                      .over_faces = {},
                      .through_passages = {*std::move(way)},
                      .shortest = shortest});
  }
  for (const GroupWays& ways : groups) {
    const double share = share_of_detour(ways.shortest.distance_m, shortest_m, straight_m);
    if (share <= 0.0) continue;
    add_arrivals(source, to.place(), ways.shortest, sum_sound(connection, ways), share, propagation,
                 arrivals);
  }
  return arrivals;
}

}  // namespace earpoint
