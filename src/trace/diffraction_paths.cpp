#include "diffraction_paths.h"

#include "band_pulses.h"

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
  return point.radius_m > kClearance_m &&
         point.angle_rad < edge.wedge.open_angle_rad + kOnBoundary_rad;
}

// One way round edges.
struct Way {
  double distance_m = 0.0;
  Vector3 leaves_to;
  Vector3 comes_from;
  DiffractionSpectrum spectrum{};  // its phase is relative to that of a way of `distance_m`
};

// Sound of one source at one listener.
struct Connection {
  const SceneGeometry& scene;
  const EdgeView& from;
  const EdgeView& to;
  bool straight_is_free = false;
  std::span<const Arrival> others;
  double longest_m = 0.0;  // of a way that matters
  double speed_m_per_s = 0.0;
};

bool is_mirrored(const Connection& connection, double distance_m) {
  constexpr double kSameWay_m = 1e-3;
  return std::any_of(connection.others.begin(), connection.others.end(), [&](const Arrival& other) {
    return other.order > 0 &&
           std::abs(other.delay_s * connection.speed_m_per_s - distance_m) < kSameWay_m;
  });
}

std::optional<Way> round_one_edge(const Connection& connection, std::size_t index) {
  const std::vector<EdgeInterval> intervals =
      EdgeView::in_sight_of_both(connection.from, connection.to, index);
  if (intervals.empty()) return std::nullopt;
  const DiffractionEdge& edge = connection.scene.edges()[index];
  const EdgePoint here = edge_point(edge, connection.from.place());
  const EdgePoint there = edge_point(edge, connection.to.place());
  const double distance_m = std::hypot(here.radius_m + there.radius_m, here.z_m - there.z_m);
  if (distance_m > connection.longest_m) return std::nullopt;
  const UnbentSound unbent{.straight = connection.straight_is_free,
                           .mirrored = is_mirrored(connection, distance_m)};
  const DiffractedSound sound =
      diffract(edge.wedge, here, there, intervals, unbent, connection.speed_m_per_s);
  const Vector3 apex = point_on_edge(edge, sound.apex_z_m, 0.0);
  return Way{sound.distance_m, apex, apex, sound.spectrum};
}

// A place as a pair of edges has it.
struct PairPlace {
  std::array<FacePoint, 2> points;
  std::array<double, 2> z_m{};          // along either edge
  std::vector<EdgeInterval> intervals;  // in sight, of the nearer edge, along the first one
};

std::optional<PairPlace> place_at(const SceneGeometry& scene, const EdgePair& pair,
                                  const EdgeView& view) {
  PairPlace place;
  int nearest = -1;
  for (int which = 0; which < 2; ++which) {
    const DiffractionEdge& edge = scene.edges()[pair.edges[which]];
    const EdgePoint point = edge_point(edge, view.place());
    place.z_m[which] = point.z_m;
    if (!view.sees(pair.edges[which])) continue;
    place.points[which] = {.in_sight = true,
                           .radius_m = point.radius_m,
                           .angle_rad = std::abs(point.angle_rad - pair.face_angle_rad[which])};
    if (nearest < 0 || point.radius_m < place.points[nearest].radius_m) nearest = which;
  }
  if (nearest < 0) return std::nullopt;
  for (const EdgeInterval& interval : view.intervals(pair.edges[nearest])) {
    const double a = pair.first_z(nearest, interval.begin_m);
    const double b = pair.first_z(nearest, interval.end_m);
    place.intervals.push_back({std::min(a, b), std::max(a, b)});
  }
  if (nearest == 1 && pair.z_sign < 0.0) {
    std::reverse(place.intervals.begin(), place.intervals.end());
  }
  return place;
}

std::vector<EdgeInterval> overlap(const std::vector<EdgeInterval>& a,
                                  const std::vector<EdgeInterval>& b) {
  std::vector<EdgeInterval> both;
  for (const EdgeInterval& x : a) {
    for (const EdgeInterval& y : b) {
      const EdgeInterval shared{std::max(x.begin_m, y.begin_m), std::min(x.end_m, y.end_m)};
      if (shared.begin_m < shared.end_m) both.push_back(shared);
    }
  }
  return both;
}

std::optional<Way> over_face(const Connection& connection, const EdgePair& pair) {
  const SceneGeometry& scene = connection.scene;
  const std::optional<PairPlace> here = place_at(scene, pair, connection.from);
  if (!here) return std::nullopt;
  const std::optional<PairPlace> there = place_at(scene, pair, connection.to);
  if (!there) return std::nullopt;
  const std::vector<EdgeInterval> intervals = overlap(here->intervals, there->intervals);
  if (intervals.empty()) return std::nullopt;

  // The shortest way: in by one edge, out by the other; round one and back where no other is seen.
  Way way;
  way.distance_m = 1e9;
  for (int in = 0; in < 2; ++in) {
    for (int out = 0; out < 2; ++out) {
      if (!here->points[in].in_sight || !there->points[out].in_sight) continue;
      const double in_m = here->points[in].radius_m;
      const double across_m =
          in_m + there->points[out].radius_m + pair.face.width_m * (in == out ? 2.0 : 1.0);
      const double along_m = there->z_m[0] - here->z_m[0];
      const double distance_m = std::hypot(across_m, along_m);
      if (distance_m >= way.distance_m) continue;
      way.distance_m = distance_m;
      const double slope = along_m / across_m;
      const auto point = [&](int which, double first_z) {
        const double z =
            which == 0 ? first_z : pair.z_sign * (first_z - pair.z_offset_m);
        return point_on_edge(scene.edges()[pair.edges[which]], z, 0.0);
      };
      way.leaves_to = point(in, here->z_m[0] + slope * in_m);
      way.comes_from = point(out, there->z_m[0] - slope * there->points[out].radius_m);
    }
  }
  if (way.distance_m > connection.longest_m) return std::nullopt;
  way.spectrum = diffract_over_face(
      pair.face, here->points, there->points,
      {.source_z_m = here->z_m[0], .receiver_z_m = there->z_m[0], .intervals = intervals},
      way.distance_m, connection.speed_m_per_s);
  return way;
}

// All ways round the edges of a group, as one wave by the shortest.
std::optional<Way> round_group(const Connection& connection, const EdgeGroup& group) {
  std::vector<Way> ways;
  for (const std::size_t edge : group.edges) {
    if (const auto way = round_one_edge(connection, edge)) ways.push_back(*way);
  }
  for (const std::size_t pair : group.pairs) {
    if (const auto way = over_face(connection, connection.scene.edge_pairs()[pair])) {
      ways.push_back(*way);
    }
  }
  if (ways.empty()) return std::nullopt;
  Way sum = *std::min_element(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return a.distance_m < b.distance_m;
  });
  sum.spectrum = {};
  for (const Way& way : ways) {
    for (int i = 0; i < kDiffractionFrequencies; ++i) {
      const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / connection.speed_m_per_s;
      sum.spectrum[i] +=
          way.spectrum[i] * std::polar(1.0, -wave_number * (way.distance_m - sum.distance_m));
    }
  }
  return sum;
}

// The same sound with the source's directivity and the air's losses.
void add_arrivals(const Source& source, const Vector3& listener, const Way& way,
                  const Propagation& propagation, std::vector<Arrival>& arrivals) {
  Arrival arrival{.direction = normalized(way.comes_from - listener),
                  .departure = normalized(way.leaves_to - source.world_from_source.position_m),
                  .gain = {}};
  const BandArray sent = sent_energy(source, arrival.departure);
  const BandArray air = air_gain(propagation.absorption_db_per_m, way.distance_m);
  for (const BandPulse& pulse : band_pulses(way.spectrum)) {
    arrival.delay_s = way.distance_m / propagation.speed_m_per_s + pulse.later_s;
    float loudest = 0.0F;
    for (int band = 0; band < kOctaveBands; ++band) {
      arrival.gain[band] = pulse.gain[band] * std::sqrt(sent[band]) * air[band];
      loudest = std::max(loudest, std::abs(arrival.gain[band]));
    }
    if (loudest >= kFaint) arrivals.push_back(arrival);
  }
}

bool is_free(const SceneGeometry& scene, const Source& source, const Vector3& listener) {
  return !scene.rays().occluded(source.world_from_source.position_m, listener,
                                scene.mask_without(source.body));
}

// The rays' floats are this rough, seen from an edge.
constexpr double kRounding_rad = 1e-5;

// Within rounding of a shadow boundary.
bool touches_edge(const SceneGeometry& scene, const EdgeView& from, const EdgeView& to) {
  for (std::size_t i = 0; i < scene.edges().size(); ++i) {
    if (!from.sees(i) || !to.sees(i)) continue;
    const DiffractionEdge& edge = scene.edges()[i];
    const double turn_rad = std::abs(edge_point(edge, from.place()).angle_rad -
                                     edge_point(edge, to.place()).angle_rad);
    if (std::abs(turn_rad - kPi) < kRounding_rad) return true;
  }
  return false;
}

// Where rays along a face are blocked, the listener is heard from just behind the boundary.
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
  for (const EdgePair& pair : scene.edge_pairs()) {
    hide_behind(pair, 0);
    hide_behind(pair, 1);
  }
}

// The rays end a little off the edge, and see it from a little behind the face that hides it.
void EdgeView::hide_behind(const EdgePair& pair, int nearer) {
  const DiffractionEdge& hiding = scene_->edges()[pair.edges[nearer]];
  const EdgePoint point = edge_point(hiding, place_);
  if (!is_in_air(hiding, point)) return;
  const double from_face_rad = std::abs(point.angle_rad - pair.face_angle_rad[nearer]);
  if (from_face_rad <= kPi + kOnBoundary_rad) return;
  const std::size_t edge = pair.edges[1 - nearer];
  std::vector<bool>& stretches = in_sight_[edge];
  const double step_m = scene_->edges()[edge].length_m / static_cast<double>(stretches.size());
  const double a = pair.first_z(nearer, 0.0);
  const double b = pair.first_z(nearer, hiding.length_m);
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const double z = pair.first_z(1 - nearer, (static_cast<double>(i) + 0.5) * step_m);
    if (z > std::min(a, b) && z < std::max(a, b)) stretches[i] = false;
  }
}

bool EdgeView::sees(std::size_t edge) const {
  const std::vector<bool>& stretches = in_sight_[edge];
  return std::find(stretches.begin(), stretches.end(), true) != stretches.end();
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
                                         std::span<const Arrival> others,
                                         const Propagation& propagation) {
  const bool direct = is_free(scene, source, to.place());
  std::optional<EdgeView> moved;
  if (!direct) moved = behind_boundary(scene, source, from, to);
  const EdgeView& listener = moved ? *moved : to;
  const double straight_m = norm(to.place() - from.place());
  std::vector<Arrival> arrivals;
  const Connection connection{.scene = scene,
                              .from = from,
                              .to = listener,
                              .straight_is_free = direct,
                              .others = others,
                              .longest_m = direct ? straight_m + kShortDetour_m : 1e9,
                              .speed_m_per_s = propagation.speed_m_per_s};
  for (const EdgeGroup& group : scene.edge_groups()) {
    const std::optional<Way> way = round_group(connection, group);
    if (!way || way->distance_m > connection.longest_m) continue;
    add_arrivals(source, to.place(), *way, propagation, arrivals);
  }
  return arrivals;
}

}  // namespace earpoint
