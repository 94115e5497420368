#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/spatial/sofa_file.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// Responses on their way from a file to a set.
struct HrtfResponses {
  int sample_rate_hz = 0;
  int taps = 0;
  double distance_m = 0.0;          // of the sources
  std::vector<Vector3> directions;  // unit
  std::vector<float> responses;     // [direction][ear][tap]
  // [direction][ear], samples; found in the response as measured, where it rises most steeply.
  std::vector<std::array<double, 2>> onsets;
  std::vector<double> shares;  // [direction]: of the sphere, what is nearest to it; sums to one

  [[nodiscard]] std::span<float> response(std::size_t direction, int ear) {
    return std::span(responses).subspan((direction * 2 + ear) * taps, taps);
  }
};

/// The file's farthest sources, each direction once, with Data.Delay put into the responses.
HrtfResponses farthest_shell(const SofaFile& file);

/// See HrtfEqualization::diffuse_field.
void equalize_diffuse_field(HrtfResponses& set);

/// Resamples; the responses begin earlier by a lead-in, the same for all, in which the steeper
/// low-pass rings. Gains stay what they are at every frequency below the lower Nyquist.
void change_rate(HrtfResponses& set, int sample_rate_hz);

/// Where |response| first exceeds a tenth of its peak, between samples.
double onset_of(std::span<const float> response);

}  // namespace earpoint
