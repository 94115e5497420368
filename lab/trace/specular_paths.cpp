#include "specular_paths.h"

#include "sphere_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kShares = 16;  // of the work, whatever the number of threads

// Closer images are one, mirrored at triangles of one wall that differ by rounding.
constexpr double kSameImage_m = 5e-3;

Vector3 mirror_point(const BounceFacet& facet, const Vector3& point) {
  return point - facet.exact_normal * (2.0 * (dot(facet.exact_normal, point) - facet.offset_m));
}

// Where the line from a point in a direction meets a facet's plane, a little in front of it.
Vector3 meet(const BounceFacet& facet, const Vector3& point, const Vector3& direction,
             double surface_offset_m) {
  const double towards = dot(facet.exact_normal, direction);
  const double distance_m = (facet.offset_m - dot(facet.exact_normal, point)) / towards;
  const double side = towards < 0.0 ? 1.0 : -1.0;
  return point + direction * distance_m + facet.exact_normal * (side * surface_offset_m);
}

using ImageKey = std::array<std::int64_t, 4>;
ImageKey image_key(const ImageSource& image) {
  const auto cell = [](double coordinate_m) {
    return static_cast<std::int64_t>(std::floor(coordinate_m / kSameImage_m));
  };
  return {cell(image.position_m.x), cell(image.position_m.y), cell(image.position_m.z),
          image.reflections};
}

// Keeps one of the images in each small cell.
void drop_duplicates(std::vector<ImageSource>& images) {
  const auto before = [](const ImageSource& a, const ImageSource& b) {
    return image_key(a) < image_key(b);
  };
  std::stable_sort(images.begin(), images.end(), before);
  const auto same = [](const ImageSource& a, const ImageSource& b) {
    return image_key(a) == image_key(b);
  };
  images.erase(std::unique(images.begin(), images.end(), same), images.end());
}

void follow_ray(const SceneGeometry& scene, const Source& source, const MirrorLimits& limits,
                Vector3 direction, std::vector<ImageSource>& images, std::int64_t& rays_cast) {
  Vector3 point = source.world_from_source.position_m;
  Vector3 image = point;
  LayerMask mask = scene.mask_without(source.body);
  double travelled_m = 0.0;
  MirrorChain chain;
  for (;;) {
    ++rays_cast;
    const std::optional<TriangleHit> hit =
        scene.rays().closest(point, direction, limits.max_distance_m - travelled_m, mask);
    if (!hit) return;
    const BounceFacet& facet = scene.facet(hit->triangle);
    if (!chain.reflect(facet, scene.surface(facet), limits)) return;
    travelled_m += hit->distance_m;
    point = meet(facet, point, direction, scene.surface_offset_m());
    direction =
        normalized(direction - facet.exact_normal * (2.0 * dot(facet.exact_normal, direction)));
    image = mirror_point(facet, image);
    images.push_back({image, chain.reflections()});
    mask = kAllLayers;
  }
}

// Shorter paths have no direction: the mirror is between source and listener, so that there is no
// sound.
constexpr double kNoWay_m = 1e-6;

// The path from the listener back to the source.
class BackwardPath {
 public:
  BackwardPath(const SceneGeometry& scene, const Source& source, const MirrorLimits& limits)
      : scene_(scene), source_(source), limits_(limits) {}

  // @param first_hit  of the ray from the listener to the image
  // @return whether the listener sees the image
  bool follow(const Vector3& listener, const ImageSource& image,
              std::optional<TriangleHit> first_hit, std::int64_t& rays_cast);

  [[nodiscard]] const BandArray& energy() const { return energy_; }
  [[nodiscard]] const Vector3& last_mirror() const { return point_; }

 private:
  const SceneGeometry& scene_;
  const Source& source_;
  const MirrorLimits& limits_;
  Vector3 point_;
  BandArray energy_{};
};

bool BackwardPath::follow(const Vector3& listener, const ImageSource& image,
                          std::optional<TriangleHit> hit, std::int64_t& rays_cast) {
  const Vector3& source_m = source_.world_from_source.position_m;
  point_ = listener;
  energy_ = all_bands(1.0F);
  Vector3 target = image.position_m;
  MirrorChain chain;
  while (chain.reflections() < image.reflections) {
    const double remaining_m = norm(target - point_);
    if (remaining_m < kNoWay_m) return false;
    const Vector3 direction = (target - point_) / remaining_m;
    if (chain.reflections() > 0) {
      ++rays_cast;
      hit = scene_.rays().closest(point_, direction, remaining_m, kAllLayers);
    }
    if (!hit) return false;
    const BounceFacet& facet = scene_.facet(hit->triangle);
    const BounceSurface& surface = scene_.surface(facet);
    if (!chain.reflect(facet, surface, limits_)) return false;
    for (int band = 0; band < kOctaveBands; ++band) energy_[band] *= surface.specular[band];
    point_ = meet(facet, point_, direction, scene_.surface_offset_m());
    target = mirror_point(facet, target);
  }
  if (norm(target - source_m) > kSameImage_m || norm(point_ - source_m) < kNoWay_m) return false;
  ++rays_cast;
  return !scene_.rays().occluded(point_, source_m, scene_.mask_without(source_.body));
}

using Hits = std::array<std::optional<TriangleHit>, kPacketSize>;

// First hits of the listener's rays to some images, in packets: neighbours in the list have similar
// directions.
Hits first_hits(const SceneGeometry& scene, const Vector3& listener,
                std::span<const ImageSource> images) {
  SoundRayPacket packet;
  const std::array<float, 3> origin = {static_cast<float>(listener.x),
                                       static_cast<float>(listener.y),
                                       static_cast<float>(listener.z)};
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Vector3 way = images[i].position_m - listener;
    const double distance_m = norm(way);
    const Vector3 direction = way / distance_m;
    packet.set(static_cast<int>(i), origin,
               {static_cast<float>(direction.x), static_cast<float>(direction.y),
                static_cast<float>(direction.z)},
               static_cast<float>(distance_m), kAllLayers);
  }
  scene.rays().closest(packet);
  Hits hits;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const int lane = static_cast<int>(i);
    if (!packet.hit(lane)) continue;
    hits[i] = TriangleHit{packet.rays.ray.tfar[lane], packet.triangles[lane]};
  }
  return hits;
}

bool same_path(const Arrival& a, const Arrival& b, double speed_m_per_s) {
  return a.order == b.order && std::abs(a.delay_s - b.delay_s) * speed_m_per_s < kSameImage_m &&
         norm(a.direction - b.direction) * a.delay_s * speed_m_per_s < 4.0 * kSameImage_m;
}

// Sorted by delay, without duplicates: an image on the border of two cells may be there twice.
std::vector<Arrival> sorted_once(std::vector<Arrival> arrivals, double speed_m_per_s) {
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.delay_s < b.delay_s; });
  std::vector<Arrival> kept;
  for (const Arrival& arrival : arrivals) {
    bool known = false;
    for (auto other = kept.rbegin(); other != kept.rend() && !known; ++other) {
      if ((arrival.delay_s - other->delay_s) * speed_m_per_s > kSameImage_m) break;
      known = same_path(arrival, *other, speed_m_per_s);
    }
    if (!known) kept.push_back(arrival);
  }
  return kept;
}

}  // namespace

std::vector<ImageSource> find_image_sources(const SceneGeometry& scene, const Source& source,
                                            const MirrorLimits& limits, int rays, ThreadPool& pool,
                                            std::int64_t& rays_cast) {
  if (limits.max_reflections == 0) return {};
  std::array<std::vector<ImageSource>, kShares> found;
  std::array<std::int64_t, kShares> cast{};
  pool.run(kShares, [&](std::ptrdiff_t share, int) {
    const auto first = static_cast<int>(static_cast<std::int64_t>(share) * rays / kShares);
    const auto last = static_cast<int>(static_cast<std::int64_t>(share + 1) * rays / kShares);
    for (int ray = first; ray < last; ++ray) {
      const Vector3 direction = spiral_direction(ray, 0.5, rays, 0.0);
      follow_ray(scene, source, limits, direction, found[share], cast[share]);
    }
    drop_duplicates(found[share]);
  });
  std::vector<ImageSource> images;
  for (int share = 0; share < kShares; ++share) {
    rays_cast += cast[share];
    images.insert(images.end(), found[share].begin(), found[share].end());
  }
  drop_duplicates(images);
  return images;
}

std::vector<Arrival> specular_arrivals(const SceneGeometry& scene, const Source& source,
                                       const Vector3& listener, std::span<const ImageSource> images,
                                       const MirrorLimits& limits, const Propagation& propagation,
                                       ThreadPool& pool, std::int64_t& rays_cast) {
  std::vector<ImageSource> near;
  std::copy_if(images.begin(), images.end(), std::back_inserter(near),
               [&](const ImageSource& image) {
                 const double distance_m = norm(image.position_m - listener);
                 return distance_m >= kNoWay_m && distance_m <= limits.max_distance_m;
               });
  std::array<std::vector<Arrival>, kShares> found;
  std::array<std::int64_t, kShares> cast{};
  pool.run(kShares, [&](std::ptrdiff_t share, int) {
    BackwardPath path(scene, source, limits);
    const std::size_t last = near.size() * (share + 1) / kShares;
    for (std::size_t begin = near.size() * share / kShares; begin < last; begin += kPacketSize) {
      const std::size_t count = std::min<std::size_t>(kPacketSize, last - begin);
      const std::span<const ImageSource> pack = std::span(near).subspan(begin, count);
      const Hits hits = first_hits(scene, listener, pack);
      cast[share] += static_cast<std::int64_t>(count);
      for (std::size_t i = 0; i < count; ++i) {
        if (!path.follow(listener, pack[i], hits[i], cast[share])) continue;
        const Vector3 departure =
            normalized(path.last_mirror() - source.world_from_source.position_m);
        BandArray energy = sent_energy(source, departure);
        for (int band = 0; band < kOctaveBands; ++band) energy[band] *= path.energy()[band];
        found[share].push_back(
            make_arrival(propagation, listener, pack[i].position_m, departure, energy));
        found[share].back().order = pack[i].reflections;
      }
    }
  });

  std::vector<Arrival> arrivals;
  for (int share = 0; share < kShares; ++share) {
    rays_cast += cast[share];
    arrivals.insert(arrivals.end(), found[share].begin(), found[share].end());
  }
  return sorted_once(std::move(arrivals), propagation.speed_m_per_s);
}

}  // namespace earpoint
