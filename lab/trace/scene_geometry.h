#pragma once

#include "diffraction_edges.h"
#include "passages.h"
#include "triangle_tree.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// What one bounce does to the energy of each band: shares of the incident energy.
struct BounceSurface {
  BandArray diffuse{};
  BandArray specular{};
  BandArray transmitted{};
  bool transmits = false;
  float most_specular = 0.0F;  ///< the largest of `specular`
  float purity = 0.0F;         ///< the largest share of the reflected energy that is not scattered
};

/// A triangle as the tracer needs it.
struct BounceFacet {
  std::array<float, 3> normal{};  ///< unit length
  std::uint32_t surface = 0;
  Vector3 exact_normal;   ///< the same in double precision
  double offset_m = 0.0;  ///< of the plane: dot(exact_normal, point)
  /// Large enough, with what lies in the same plane, to mirror sound as a wall does. Smaller ones
  /// are still traced, but no image source is sought behind them.
  bool mirror = false;
};

/// The tracer's view of a scene.
class SceneGeometry {
 public:
  explicit SceneGeometry(const Scene& scene);

  [[nodiscard]] const TriangleTree& rays() const { return rays_; }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const BounceFacet& facet(std::uint32_t triangle) const { return facets_[triangle]; }
  [[nodiscard]] const BounceSurface& surface(const BounceFacet& facet) const {
    return surfaces_[facet.surface];
  }
  [[nodiscard]] bool transmits() const { return transmits_; }

  /// @return the layers that a ray sees which does not notice one person's body
  [[nodiscard]] LayerMask mask_without(std::optional<std::uint32_t> body) const;

  /// Multiplies `energy` by what the surfaces between two points let through.
  /// @return whether anything arrives
  bool transmit(const Vector3& from, const Vector3& to, LayerMask mask, BandArray& energy) const;

  /// Walls that let sound through are modelled by one face or by two. Of two faces of one material,
  /// parallel and at most 0.4 m apart, the first one that sound meets takes the whole wall's loss.
  /// @param across_m  from the face that was passed to the next one, along their normal
  /// @return whether the next one is the same wall's other side
  [[nodiscard]] static bool is_other_side(const BounceFacet& passed, const BounceFacet& next,
                                          double across_m);

  /// @return the layers of everything but people
  [[nodiscard]] static LayerMask still_layers() { return kOpaqueLayer | kTransmissiveLayer; }

  [[nodiscard]] const std::vector<InstanceKind>& instance_kinds() const { return instance_kinds_; }
  [[nodiscard]] const std::vector<DiffractionEdge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<EdgePair>& edge_pairs() const { return edge_pairs_; }
  [[nodiscard]] const std::vector<EdgeGroup>& edge_groups() const { return edge_groups_; }

  [[nodiscard]] const std::vector<FacingPair>& facing_pairs() const { return facing_pairs_; }

  /// How far a ray starts above the surface that it leaves, so that it does not hit it again.
  [[nodiscard]] double surface_offset_m() const { return surface_offset_m_; }

 private:
  Mesh mesh_;
  std::vector<BounceSurface> surfaces_;
  std::vector<BounceFacet> facets_;
  std::vector<InstanceKind> instance_kinds_;
  std::vector<LayerMask> instance_layers_;
  bool transmits_ = false;
  double surface_offset_m_;
  TriangleTree rays_;
  std::vector<DiffractionEdge> edges_;
  std::vector<EdgePair> edge_pairs_;
  std::vector<EdgeGroup> edge_groups_;
  std::vector<FacingPair> facing_pairs_;
};

}  // namespace earpoint
