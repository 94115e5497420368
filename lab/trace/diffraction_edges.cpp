#include "diffraction_edges.h"

#include "mesh_edges.h"
#include "scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Shorter edges count as scattering of the materials; furniture has many of them.
constexpr double kShortestOfStructure_m = 0.4;
constexpr double kShortestOfFurniture_m = 1.0;

// Edges are tested in stretches of about this length.
constexpr double kStretch_m = 0.3;
constexpr double kBorder_m = 2e-3;  // accuracy of their ends

constexpr double kRing_m = 0.02;  // radius of the circles of rays around an edge
constexpr int kRingRays = 24;
constexpr double kOnEdge_m = 0.004;  // a face this close to the circle's middle touches the edge

// Wedges with a smaller open angle cast hardly any shadow.
constexpr double kLeastOpen_rad = kPi + 0.35;

// Faces whose angles around the edge differ by less count as one.
constexpr double kSameAngle_rad = 0.1;

// Thickness of walls whose two edges diffract one after the other.
constexpr double kThinnest_m = 0.01;
constexpr double kThickest_m = 0.7;

// A face that touches an edge.
struct Spoke {
  double angle_rad = 0.0;
  std::uint32_t triangle = 0;
};

// Two directions across an edge.
struct Across {
  Vector3 u;
  Vector3 v;
};

Across across(const Vector3& direction) {
  const Vector3 aside = std::abs(direction.z) < 0.9 ? Vector3{0, 0, 1} : Vector3{1, 0, 0};
  const Vector3 u = normalized(cross(aside, direction));
  return {u, cross(direction, u)};
}

// The faces around a point of an edge, by angle; nothing if another surface is in the way.
std::optional<std::vector<Spoke>> find_spokes(const SceneGeometry& scene, const Vector3& point,
                                              const Vector3& direction) {
  // Named, as clang cannot capture structured bindings in a lambda.
  const Across axes = across(direction);
  const Vector3& u = axes.u;
  const Vector3& v = axes.v;
  const auto on_ring = [&](int i) {
    // Turned off the axes, as faces often lie along them and would pass through a ray's end.
    const double angle_rad = 2.0 * kPi * (i + 0.37) / kRingRays;
    return point + u * (kRing_m * std::cos(angle_rad)) + v * (kRing_m * std::sin(angle_rad));
  };
  std::vector<Spoke> spokes;
  for (int i = 0; i < kRingRays; ++i) {
    const Vector3 from = on_ring(i);
    const Vector3 to = on_ring(i + 1);
    const Vector3 way = normalized(to - from);
    const std::optional<TriangleHit> hit =
        scene.rays().closest(from, way, norm(to - from), scene.still_layers());
    if (!hit) continue;
    const BounceFacet& facet = scene.facet(hit->triangle);
    if (std::abs(dot(facet.exact_normal, point) - facet.offset_m) > kOnEdge_m) return std::nullopt;
    const Vector3 met = from + way * static_cast<double>(hit->distance_m) - point;
    // The exact direction along the face; the hit has a float's rounding.
    Vector3 along = cross(direction, facet.exact_normal);
    if (dot(along, met) < 0.0) along = -along;
    spokes.push_back({std::atan2(dot(along, v), dot(along, u)), hit->triangle});
  }
  std::sort(spokes.begin(), spokes.end(),
            [](const Spoke& a, const Spoke& b) { return a.angle_rad < b.angle_rad; });
  return spokes;
}

BandArray face_reflection(const SceneGeometry& scene, std::uint32_t triangle) {
  const BounceSurface& surface = scene.surface(scene.facet(triangle));
  BandArray reflection;
  for (int band = 0; band < kOctaveBands; ++band) {
    reflection[band] = std::sqrt(surface.diffuse[band] + surface.specular[band]);
  }
  return reflection;
}

// The widest open wedge between neighbouring spokes, if it is wide enough.
std::optional<DiffractionEdge> widest_wedge(const SceneGeometry& scene, const Vector3& direction,
                                            const std::vector<Spoke>& spokes) {
  if (spokes.empty()) return std::nullopt;
  double widest_rad = 0.0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    const bool wraps = i + 1 == spokes.size();
    const double next_rad = spokes[(i + 1) % spokes.size()].angle_rad + (wraps ? 2.0 * kPi : 0.0);
    if (next_rad - spokes[i].angle_rad > widest_rad) {
      widest_rad = next_rad - spokes[i].angle_rad;
      first = i;
    }
  }
  if (widest_rad < kLeastOpen_rad) return std::nullopt;
  const auto [u, v] = across(direction);
  const double angle_rad = spokes[first].angle_rad;
  DiffractionEdge edge;
  edge.direction = direction;
  edge.first_face = u * std::cos(angle_rad) + v * std::sin(angle_rad);
  edge.into_air = v * std::cos(angle_rad) - u * std::sin(angle_rad);
  edge.wedge.open_angle_rad = std::min(widest_rad, 2.0 * kPi);
  edge.face_triangles = {spokes[first].triangle, spokes[(first + 1) % spokes.size()].triangle};
  edge.wedge.reflection = {face_reflection(scene, edge.face_triangles[0]),
                           face_reflection(scene, edge.face_triangles[1])};
  return edge;
}

// Whether the edge is inside a closed room: whether some ray from the wedge's middle hits a
// surface.
bool is_inside(const SceneGeometry& scene, const DiffractionEdge& edge) {
  const Vector3 from = point_on_edge(edge, edge.length_m / 2.0, kRing_m);
  const Vector3 middle =
      normalized(from - (edge.origin_m + edge.direction * (edge.length_m / 2.0)));
  for (const Vector3& direction :
       {middle, normalized(middle + edge.direction), normalized(middle - edge.direction)}) {
    if (scene.rays().closest(from, direction, 1e5, scene.still_layers())) return true;
  }
  return false;
}

bool same_wedge(const DiffractionEdge& a, const DiffractionEdge& b) {
  return std::abs(a.wedge.open_angle_rad - b.wedge.open_angle_rad) < kSameAngle_rad &&
         dot(a.first_face, b.first_face) > std::cos(kSameAngle_rad);
}

// Finds the edges along a crease.
class CreaseLook {
 public:
  CreaseLook(const SceneGeometry& scene, const Crease& crease)
      : scene_(scene),
        begin_(crease.begin_m),
        length_m_(norm(crease.end_m - crease.begin_m)),
        direction_((crease.end_m - crease.begin_m) / length_m_) {}

  // Tests the middles of stretches; equal neighbours are joined to one edge.
  void add_edges(std::vector<DiffractionEdge>& edges) const {
    const int count = std::max(1, static_cast<int>(std::lround(length_m_ / kStretch_m)));
    std::optional<DiffractionEdge> open;
    double begin_z = 0.0;
    double last_z = 0.0;
    for (int i = 0; i <= count; ++i) {
      const double z = (i + 0.5) * length_m_ / count;
      std::optional<DiffractionEdge> wedge;
      if (i < count) wedge = wedge_at(z);
      if (open && wedge && same_wedge(*open, *wedge)) {
        last_z = z;
        continue;
      }
      if (open) add(*open, begin_z, i < count ? border(*open, last_z, z) : length_m_, edges);
      open = wedge;
      if (wedge) begin_z = i > 0 ? border(*wedge, z, z - length_m_ / count) : 0.0;
      last_z = z;
    }
  }

 private:
  [[nodiscard]] std::optional<DiffractionEdge> wedge_at(double z) const {
    const std::optional<std::vector<Spoke>> spokes =
        find_spokes(scene_, begin_ + direction_ * z, direction_);
    if (!spokes) return std::nullopt;
    return widest_wedge(scene_, direction_, *spokes);
  }

  // The end of an edge, between a place on it and one off it.
  [[nodiscard]] double border(const DiffractionEdge& edge, double on_z, double off_z) const {
    while (std::abs(on_z - off_z) > kBorder_m) {
      const double middle = (on_z + off_z) / 2.0;
      const std::optional<DiffractionEdge> wedge = wedge_at(middle);
      (wedge && same_wedge(edge, *wedge) ? on_z : off_z) = middle;
    }
    return (on_z + off_z) / 2.0;
  }

  void add(DiffractionEdge edge, double begin_z, double end_z,
           std::vector<DiffractionEdge>& edges) const {
    edge.origin_m = begin_ + direction_ * begin_z;
    edge.length_m = end_z - begin_z;
    if (edge.length_m > 0.0 && is_inside(scene_, edge)) edges.push_back(edge);
  }

  const SceneGeometry& scene_;
  Vector3 begin_;
  double length_m_;
  Vector3 direction_;
};

// The angle of the face along a direction around an edge, if there is one.
std::optional<double> face_angle(const DiffractionEdge& edge, double angle_rad) {
  const double open_rad = edge.wedge.open_angle_rad;
  for (const double face_rad : {0.0, open_rad}) {
    if (std::abs(wrap_angle(angle_rad - face_rad)) < kSameAngle_rad) return face_rad;
  }
  return std::nullopt;
}

std::optional<EdgePair> pair_up(std::span<const DiffractionEdge> edges, std::size_t i,
                                std::size_t j) {
  constexpr double kParallel = 0.9995;
  const DiffractionEdge& first = edges[i];
  const DiffractionEdge& second = edges[j];
  const double cosine = dot(first.direction, second.direction);
  if (std::abs(cosine) < kParallel) return std::nullopt;
  const EdgePoint over = edge_point(first, point_on_edge(second, second.length_m / 2.0, 0.0));
  if (over.radius_m < kThinnest_m || over.radius_m > kThickest_m) return std::nullopt;
  EdgePair pair;
  pair.edges = {i, j};
  pair.z_sign = cosine > 0.0 ? 1.0 : -1.0;
  pair.z_offset_m = edge_point(first, second.origin_m).z_m;
  const double end_m = pair.opposite_z(1, second.length_m);
  if (std::min(pair.z_offset_m, end_m) >= first.length_m) return std::nullopt;
  if (std::max(pair.z_offset_m, end_m) <= 0.0) return std::nullopt;
  const EdgePoint back = edge_point(second, point_on_edge(first, over.z_m, 0.0));
  const std::optional<double> first_angle = face_angle(first, over.angle_rad);
  const std::optional<double> second_angle = face_angle(second, back.angle_rad);
  if (!first_angle || !second_angle) return std::nullopt;
  pair.face_angle_rad = {*first_angle, *second_angle};
  pair.face.width_m = over.radius_m;
  pair.face.open_angle_rad = {first.wedge.open_angle_rad, second.wedge.open_angle_rad};
  for (int which = 0; which < 2; ++which) {
    const Wedge& wedge = edges[pair.edges[which]].wedge;
    const int face = pair.face_angle_rad[which] == 0.0 ? 0 : 1;
    pair.face.reflection = wedge.reflection[face];
    pair.face_triangle = edges[pair.edges[which]].face_triangles[face];
    pair.face.other_reflection[which] = wedge.reflection[1 - face];
  }
  return pair;
}

}  // namespace

EdgePoint edge_point(const DiffractionEdge& edge, const Vector3& point) {
  const Vector3 offset = point - edge.origin_m;
  EdgePoint result;
  result.z_m = dot(offset, edge.direction);
  const double x = dot(offset, edge.first_face);
  const double y = dot(offset, edge.into_air);
  result.radius_m = std::hypot(x, y);
  result.angle_rad = std::atan2(y, x);
  if (result.angle_rad < 0.0) result.angle_rad += 2.0 * kPi;
  // On the first face, to within rounding.
  const bool on_face = result.angle_rad > 2.0 * kPi - kOnBoundary_rad;
  if (on_face && edge.wedge.open_angle_rad < kPi * 1.9) result.angle_rad = 0.0;
  return result;
}

Vector3 point_on_edge(const DiffractionEdge& edge, double z_m, double clearance_m) {
  const double middle_rad = edge.wedge.open_angle_rad / 2.0;
  return edge.origin_m + edge.direction * z_m +
         edge.first_face * (clearance_m * std::cos(middle_rad)) +
         edge.into_air * (clearance_m * std::sin(middle_rad));
}

std::vector<DiffractionEdge> find_diffraction_edges(const SceneGeometry& scene) {
  std::vector<DiffractionEdge> edges;
  for (const bool structure : {true, false}) {
    std::vector<bool> counts;
    for (const InstanceKind kind : scene.instance_kinds()) {
      counts.push_back(kind == (structure ? InstanceKind::structure : InstanceKind::furniture));
    }
    const double shortest_m = structure ? kShortestOfStructure_m : kShortestOfFurniture_m;
    for (const Crease& crease : find_creases(scene.mesh(), counts, shortest_m)) {
      CreaseLook(scene, crease).add_edges(edges);
    }
  }
  return edges;
}

std::vector<EdgePair> find_edge_pairs(std::span<const DiffractionEdge> edges) {
  std::vector<EdgePair> pairs;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      if (const std::optional<EdgePair> pair = pair_up(edges, i, j)) pairs.push_back(*pair);
    }
  }
  return pairs;
}

std::vector<EdgeGroup> group_edges(std::size_t edge_count, std::span<const EdgePair> pairs) {
  std::vector<std::size_t> leaders(edge_count);
  std::iota(leaders.begin(), leaders.end(), 0);
  for (const EdgePair& pair : pairs) {
    const std::size_t joined = leaders[pair.edges[1]];
    std::replace(leaders.begin(), leaders.end(), joined, leaders[pair.edges[0]]);
  }
  std::vector<EdgeGroup> by_leader(edge_count);
  for (std::size_t i = 0; i < edge_count; ++i) by_leader[leaders[i]].edges.push_back(i);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    by_leader[leaders[pairs[i].edges[0]]].pairs.push_back(i);
  }
  std::erase_if(by_leader, [](const EdgeGroup& group) { return group.edges.empty(); });
  return by_leader;
}

}  // namespace earpoint
