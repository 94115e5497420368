#pragma once

#include "wedge_diffraction.h"

#include <array>
#include <complex>
#include <vector>

namespace earpoint {

/// A face between two parallel edges: the end of a wall, the reveal of a door.
struct EdgeFace {
  double width_m = 0.0;                    ///< > 0
  std::array<double, 2> open_angle_rad{};  ///< of either edge's air
  BandArray reflection = all_bands(1.0F);  ///< pressure that the face reflects
  /// The same of the face on the other side of either edge.
  std::array<BandArray, 2> other_reflection{all_bands(1.0F), all_bands(1.0F)};
};

/// A place as one edge of a face has it.
struct FacePoint {
  double radius_m = 0.0;   ///< from the edge, > 0
  double angle_rad = 0.0;  ///< from the face between the edges, in [0, open angle]
  /// Of the edge, what is in sight, in ascending order. If nothing, the rest has no meaning.
  std::vector<EdgeInterval> in_sight{};
};

/// A place as both edges of a face have it; both count z from the same point.
struct FacePlace {
  double z_m = 0.0;
  std::array<FacePoint, 2> points;
};

/// Sound that passes the face between two edges once or more, diffracted at its ends: second and
/// higher orders, so that first-order sound of both edges and this together have no jump where an
/// edge goes out of sight behind the other.
///
/// Sound on the face is a sum of plane waves of complex angle, and each edge turns one such sum
/// into another by the exact wedge solution (Macdonald; Sommerfeld's integral); the orders are
/// added up until they do not matter. Exact for a line source and endless edges. For a point source
/// the spreading of the unfolded path replaces that of the line source; edges of finite length
/// count by the share that their parts in sight have in the first-order sound. Faces that absorb
/// weigh their terms as in `diffract`.
/// @param reference_m  the spectrum's phase is that of a way of this length
/// @return  pressure relative to 1 m in free field
DiffractionSpectrum diffract_over_face(const EdgeFace& face, const FacePlace& source,
                                       const FacePlace& receiver, double reference_m,
                                       double speed_m_per_s);

/// The same orders for a line source that makes H0(2) in free field, and endless edges.
/// @param source, receiver  as both edges have them
/// @param band  of the faces' reflections
std::complex<double> line_sound_over_face(const EdgeFace& face,
                                          const std::array<FacePoint, 2>& source,
                                          const std::array<FacePoint, 2>& receiver, int band,
                                          double wave_number);

}  // namespace earpoint
