#pragma once

#include "patch_light.h"
#include "pixel_buffers.h"
#include "reflection.h"
#include "solved_light.h"

#include <array>
#include <cstdint>
#include <vector>

#include <earpoint/camera/camera.h>
#include <earpoint/camera/view.h>

namespace earpoint {

/// Traces a picture tile by tile. Tiles do not depend on each other.
class ViewSampler {
 public:
  static constexpr int kTile = 8;  ///< pixels along each side

  /// @param solved  of the same scene; both must outlive the sampler
  /// @param region  the part of the camera's picture to trace; where it begins at multiples of
  ///                kTile, its samples are those of the whole picture
  /// @param side    samples along each side of a pixel
  ViewSampler(const LitScene& scene, const SolvedLight& solved, const Camera& camera,
              const PixelRegion& region, int side, std::uint64_t seed);

  [[nodiscard]] int tiles() const { return tiles_across_ * tiles_down_; }

  /// Buffers of the right size, to be filled tile by tile.
  [[nodiscard]] PixelBuffers make_buffers() const;

  /// Depth, instance and guide of the middle of each pixel.
  void trace_middles(int tile, PixelBuffers& buffers, View& view) const;

  /// The light; after trace_middles().
  void trace_light(int tile, PixelBuffers& buffers) const;

 private:
  static constexpr int kLanes = RayPacket::kRays;

  // One of sixteen samples that go through the steps together.
  struct Lane {
    bool used = false;
    std::uint32_t pixel = 0;
    Float3 direction;              // of the ray that arrived, unit length
    float path_m = 0.0F;           // the first hit's depth and the way behind mirrors
    Rgb passed{1.0F, 1.0F, 1.0F};  // share of light that the mirrors on the way reflect
    Guide place;
    SurfacePoint point;
    std::uint32_t region = 0;
    Reflection reflection;
    Rgb albedo;
    Rgb added;
    PlaceLight light;
  };
  struct Lanes {
    std::array<Lane, kLanes> at;
    std::array<std::uint32_t, kLanes> indices{};  // in the sample sequences

    // Points of the unit square, one for each lane.
    [[nodiscard]] UnitPairs draw(std::uint32_t seed) const {
      UnitPairs pairs;
      sobol_pairs(indices, seed, pairs);
      return pairs;
    }
  };

  struct PixelPlace {
    int x = 0;
    int y = 0;
  };

  // The pixel that is the `number`-th of its tile on the Morton curve; counted in the region.
  [[nodiscard]] PixelPlace place_in_tile(int tile, int number) const;
  [[nodiscard]] Float3 direction_through(double x, double y) const;
  [[nodiscard]] std::uint32_t seed_of(std::uint32_t purpose) const;

  void aim(int tile, int first, Lanes& lanes) const;
  void trace_camera_rays(Lanes& lanes, SeeThrough see_through) const;
  void follow_mirrors(Lanes& lanes, SeeThrough see_through) const;
  void arrive(Lane& lane, const Hit& hit, const Float3& direction) const;
  void shade(Lane& lane) const;
  void add_direct(Lanes& lanes) const;
  void add_indirect(Lanes& lanes) const;
  void add_glossy(Lanes& lanes) const;
  void store(const Lane& lane, PixelBuffers& buffers, std::vector<StraySample>& strays) const;

  const LitScene& scene_;
  const SolvedLight& solved_;
  int width_;  // of the region
  int height_;
  int x_;  // of the region in the picture
  int y_;
  int picture_width_;
  int picture_height_;
  int side_;
  std::uint32_t seed_;
  int tiles_across_;
  int tiles_down_;
  float pixel_angle_;  // width of a pixel at 1 m depth
  Float3 eye_;
  // What a pixel's place adds to the direction: front + left (w/2 - x) + up (h/2 - y).
  Vector3 front_;
  Vector3 left_;
  Vector3 up_;
};

}  // namespace earpoint
