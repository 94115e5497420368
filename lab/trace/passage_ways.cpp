#include "passage_ways.h"

#include "line_source_wedge.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

// Bands with passages; above them, sound that meets both sides changes no octave by more than 0.3
// dB.
constexpr int kPassageBands = 5;

// Closer to the wall's plane the sum fades out, as it is not known inside the passage.
constexpr double kNear_m = 0.2;

// The integral of exp(-i pi t^2 / 2) from x on, within 2e-3.
// Source: Abramowitz and Stegun, 7.3.9, 7.3.10, 7.3.32 and 7.3.33.
Complex fresnel_tail(double x) {
  if (x < 0.0) return Complex(1.0, -1.0) - fresnel_tail(-x);
  const double f = (1.0 + 0.926 * x) / (2.0 + 1.792 * x + 3.104 * x * x);
  const double g = 1.0 / (2.0 + 4.142 * x + 3.492 * x * x + 6.670 * x * x * x);
  return Complex(g, -f) * std::polar(1.0, -kPi / 2.0 * x * x);
}

// The visible parts of an edge, in the coordinate along the passage.
std::vector<EdgeInterval> in_sight(const SceneGeometry& scene, const FacingPair& facing,
                                   const EdgeView& view, std::size_t index) {
  const DiffractionEdge& edge = scene.edges()[index];
  const double offset_m = dot(edge.origin_m - facing.origin_m, facing.along);
  const double sign = dot(edge.direction, facing.along) > 0.0 ? 1.0 : -1.0;
  std::vector<EdgeInterval> intervals;
  for (const EdgeInterval& seen : view.intervals(index)) {
    const double a = offset_m + sign * seen.begin_m;
    const double b = offset_m + sign * seen.end_m;
    intervals.push_back({std::min(a, b), std::max(a, b)});
  }
  if (sign < 0.0) std::reverse(intervals.begin(), intervals.end());
  return intervals;
}

// Sound by the visible stretches, relative to the endless edge.
Complex share_in_sight(const PassageWay::Crossing& crossing, double wave_number) {
  const double scale = std::sqrt(wave_number * (crossing.in_m + crossing.out_m) /
                                 (kPi * crossing.in_m * crossing.out_m));
  Complex sum = 0.0;
  for (const auto& [begin_m, end_m] : crossing.in_sight) {
    sum += fresnel_tail(scale * (begin_m - crossing.apex_z_m)) -
           fresnel_tail(scale * (end_m - crossing.apex_z_m));
  }
  return sum / Complex(1.0, -1.0);
}

}  // namespace

std::optional<PassageWay> way_through(const SceneGeometry& scene, const FacingPair& facing,
                                      const EdgeView& from, const EdgeView& to) {
  const PassagePlace source = facing.place(from.place());
  const PassagePlace receiver = facing.place(to.place());
  const bool is_forward = source.x_m < receiver.x_m;
  PassageWay way;
  way.passage = facing.passage;
  way.before = is_forward ? source : receiver;
  way.behind = is_forward ? receiver : source;
  const double depth_m = way.passage.depth_m;
  const double nearest_m = std::min(-way.before.x_m, way.behind.x_m - depth_m);
  if (nearest_m <= 0.0) return std::nullopt;
  way.counts = all_bands(static_cast<float>(std::min(1.0, nearest_m / kNear_m)));
  for (const std::size_t face : facing.faces) {
    const BandArray& reflection = scene.edge_pairs()[face].face.reflection;
    for (int band = 0; band < kOctaveBands; ++band) way.counts[band] *= reflection[band];
  }

  const EdgeView& front = is_forward ? from : to;
  const EdgeView& back = is_forward ? to : from;
  const double front_z_m = dot(front.place() - facing.origin_m, facing.along);
  const double along_m = dot(back.place() - front.place(), facing.along);
  bool is_seen = false;
  way.across_m = 1e9;
  for (int side = 0; side < 2; ++side) {
    PassageWay::Crossing& crossing = way.crossings[side];
    const double in_y_m = side == 0 ? 0.0 : way.passage.width_m;
    const double out_y_m = way.passage.width_m - in_y_m;
    crossing.in_m = std::hypot(way.before.x_m, way.before.y_m - in_y_m);
    const double rest_m = std::hypot(way.behind.x_m - depth_m, way.behind.y_m - out_y_m);
    crossing.out_m = rest_m + way.passage.width_m;
    const double across_m = crossing.in_m + crossing.out_m;
    crossing.apex_z_m = front_z_m + along_m * crossing.in_m / across_m;
    const std::size_t in_edge = facing.edges[side][0];
    const std::size_t out_edge = facing.edges[1 - side][1];
    crossing.in_sight =
        overlap(in_sight(scene, facing, front, in_edge), in_sight(scene, facing, back, out_edge));
    is_seen = is_seen || !crossing.in_sight.empty();
    if (across_m >= way.across_m) continue;
    way.across_m = across_m;
    const double out_z_m = front_z_m + along_m * (1.0 - rest_m / across_m);
    const auto point = [&](double x_m, double y_m, double z_m) {
      return facing.origin_m + facing.through * x_m + facing.over * y_m + facing.along * z_m;
    };
    way.shortest = {std::hypot(across_m, along_m), point(0.0, in_y_m, crossing.apex_z_m),
                    point(depth_m, out_y_m, out_z_m)};
  }
  if (!is_seen) return std::nullopt;
  if (!is_forward) std::swap(way.shortest.leaves_to, way.shortest.comes_from);
  return way;
}

DiffractionSpectrum sound_of_both_sides(const PassageWay& way, double speed_m_per_s) {
  DiffractionSpectrum spectrum{};
  for (int i = 0; i < kPassageBands * kFrequenciesPerBand; ++i) {
    // Endless edges keep the wave number along them; the rest is across.
    const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / speed_m_per_s *
                               way.across_m / way.shortest.distance_m;
    const Complex both = sound_through_passage(way.passage, way.before, way.behind, wave_number) -
                         sound_past_single_sides(way.passage, way.before, way.behind, wave_number);
    const Complex share = (share_in_sight(way.crossings[0], wave_number) +
                           share_in_sight(way.crossings[1], wave_number)) /
                          2.0;
    spectrum[i] = static_cast<double>(way.counts[i / kFrequenciesPerBand]) * share * both /
                  hankel(wave_number * way.across_m) / way.shortest.distance_m;
  }
  return spectrum;
}

}  // namespace earpoint
