#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <earpoint/camera/camera.h>
#include <earpoint/camera/view.h>
#include <earpoint/core/parallel.h>
#include <earpoint/image.h>
#include <earpoint/scene/scene.h>

namespace earpoint {

/// What lights a scene besides its own lamps and shining surfaces.
struct Lighting {
  /// Radiance of the sky, linear red, green, blue: what rays bring that leave the scene through a
  /// window or a hole.
  std::array<float, 3> sky_radiance{1.0F, 1.1F, 1.25F};
  /// Whether a scene with neither lamps nor shining surfaces gets lamps under its ceilings.
  bool light_dark_scenes = true;
};

/// How much work goes into a picture.
struct RenderQuality {
  /// Rays per pixel along each side of a grid: 2 is 4 per pixel. In [1, 32].
  int samples_per_side = 2;
  /// Smooths the noise of the light (not edges or textures). Off, the picture tends to the exact
  /// one with more samples.
  bool denoise = true;
  /// Multiplies the exposure that a picture finds for itself; > 0.
  float exposure = 1.0F;
};

/// Sees a scene by ray tracing. Light is traced in two steps. When the drawer is made, the light
/// that falls on every patch of surface (about 0.25 m wide) is solved once, for every view: direct
/// light, and what surfaces pass on to each other diffusely, to any number of bounces. A picture
/// then samples its direct light (lamps, shining surfaces; soft shadows) and its first bounce
/// exactly and reads the patches only from the second bounce on, so that patches never show.
/// Surfaces are diffuse; smooth ones reflect as well (Schlick's Fresnel term, GGX).
///
/// Immutable once made: any number of threads may draw with one object, each with its own pool.
/// The same scene, camera, quality and seed give the same bytes with any number of threads, on one
/// kind of processor.
class SceneDrawer {
 public:
  /// Copies what it needs; the scene may go.
  /// @param scene  as check_scene leaves it
  explicit SceneDrawer(const Scene& scene, const Lighting& lighting = {});
  SceneDrawer(const Scene& scene, const Lighting& lighting, ThreadPool& pool);
  ~SceneDrawer();
  SceneDrawer(SceneDrawer&&) noexcept;
  SceneDrawer& operator=(SceneDrawer&&) noexcept;

  /// A drawer of this scene with more things in it, for a fraction of the time: the people of
  /// each conversation in one home. The solved light of this scene is kept, and only that of the
  /// added surfaces is solved; what they darken or colour shows in the direct light and in the
  /// first bounce, which a picture traces itself.
  /// @param scene  begins with this drawer's scene: add_person() leaves it so
  /// @throws std::logic_error if it does not, or if something that was added shines
  [[nodiscard]] SceneDrawer extended(const Scene& scene) const;
  [[nodiscard]] SceneDrawer extended(const Scene& scene, ThreadPool& pool) const;

  /// @param seed  of the samples: another seed, another noise
  /// @throws std::logic_error if the camera or the quality is out of range
  [[nodiscard]] View draw(const Camera& camera, const RenderQuality& quality,
                          std::uint64_t seed) const;
  [[nodiscard]] View draw(const Camera& camera, const RenderQuality& quality, std::uint64_t seed,
                          ThreadPool& pool) const;

  /// What draw() multiplies the light of this view by before it is shown, for quality.exposure 1:
  /// the pictures of a film are to keep one.
  [[nodiscard]] float found_exposure(const Camera& camera, const RenderQuality& quality,
                                     std::uint64_t seed, ThreadPool& pool) const;

  /// A part of a picture: where little moves, a film needs no more of most of its pictures. The
  /// samples are those of the whole picture where the region begins at multiples of 8 pixels; only
  /// the smoothing of the light ends at the region's edges.
  /// @param region    inside of the picture, not empty
  /// @param exposure  what the light is multiplied by, quality.exposure beside it; > 0
  /// @return  the region's pixels
  /// @throws std::logic_error if the camera, the quality, the region or the exposure is out of
  ///         range
  [[nodiscard]] View draw_region(const Camera& camera, const PixelRegion& region,
                                 const RenderQuality& quality, float exposure, std::uint64_t seed,
                                 ThreadPool& pool) const;

  /// The light itself, before exposure and tone mapping.
  /// @return radiance, linear red, green, blue; shape [height][width][3]
  [[nodiscard]] FloatImage radiance(const Camera& camera, const RenderQuality& quality,
                                    std::uint64_t seed, ThreadPool& pool) const;

  /// How many patches hold the solved light.
  [[nodiscard]] std::size_t patches() const;

 private:
  struct Parts;
  explicit SceneDrawer(std::unique_ptr<const Parts> parts);

  std::unique_ptr<const Parts> parts_;
};

}  // namespace earpoint
