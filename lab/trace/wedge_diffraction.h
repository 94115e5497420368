#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include <earpoint/core/octave_bands.h>

namespace earpoint {

/// A straight edge where two faces meet, seen along the edge: the air fills the angle from the
/// first face (0) to the second (`open_angle_rad`).
struct Wedge {
  double open_angle_rad = 0.0;  ///< in (0, 2 pi]; below pi reflections alone are complete
  /// Pressure that each face reflects, per band; 1 for a rigid one.
  std::array<BandArray, 2> reflection{all_bands(1.0F), all_bands(1.0F)};
};

/// A point in the edge's own coordinates.
struct EdgePoint {
  double radius_m = 0.0;   ///< from the edge, > 0
  double angle_rad = 0.0;  ///< from the first face, in [0, open angle]
  double z_m = 0.0;        ///< along the edge
};

/// Angles this close to a shadow boundary lie on it.
constexpr double kOnBoundary_rad = 2e-6;

/// Which sound that does not bend passes between two points. Decides where it touches an edge,
/// within rounding.
struct UnbentSound {
  bool straight = false;
  bool mirrored = false;  ///< off a face of the edge
};

/// A stretch of the edge that both points see.
struct EdgeInterval {
  double begin_m = 0.0;
  double end_m = 0.0;
};

/// Diffracted sound is known at some frequencies of each octave band.
constexpr int kFrequenciesPerBand = 3;
constexpr int kDiffractionFrequencies = kOctaveBands * kFrequenciesPerBand;
using DiffractionSpectrum = std::array<std::complex<double>, kDiffractionFrequencies>;

/// @return  in ascending order, evenly over the octaves
double diffraction_frequency_hz(int index);

/// @param a, b  in ascending order, as the result is
/// @return what is in both
std::vector<EdgeInterval> overlap(const std::vector<EdgeInterval>& a,
                                  const std::vector<EdgeInterval>& b);

/// The shortest way over an edge.
struct EdgeApex {
  double distance_m = 0.0;
  double z_m = 0.0;  ///< where it touches
};

/// @param intervals  in ascending order, not empty
EdgeApex find_apex(const EdgePoint& source, const EdgePoint& receiver,
                   std::span<const EdgeInterval> intervals);

/// First-order diffraction by the parts of a wedge that are in sight, as in Biot, Tolstoy and
/// Medwin: every point of the edge is a secondary source (Svensson, Fred and Vanderkooy, JASA 106,
/// 1999, equations 2 to 5). For faces that are not rigid, the two terms that belong to a reflection
/// are weighed by the face's reflection, as Luebbers (IEEE Trans. Antennas Propag. 32, 1984) does.
/// @param intervals  in ascending order, not empty
/// @return  pressure relative to 1 m in free field; its phase is relative to the shortest way's
DiffractionSpectrum diffract(const Wedge& wedge, const EdgePoint& source, const EdgePoint& receiver,
                             std::span<const EdgeInterval> intervals, const UnbentSound& unbent,
                             double speed_m_per_s);

}  // namespace earpoint
