#include "view_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace earpoint {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMostMirrors = 3;
// Two places are one surface if they lie within so many footprints of each other's plane.
constexpr float kSampleReach = 1.5F;
// Sharper reflections hit the lamps themselves; for blurred ones lamps are sampled as lights.
constexpr float kSharpAlpha = 0.02F;

// What a random number decides; each draws from a sequence of its own.
enum Purpose : std::uint32_t {
  kPlaceInPixel = 1,
  kChoiceOfLight,
  kPlaceOnLight,
  kIndirectDirection,
  kPatchAside,
  kGlossyDirection,
  kSeeThrough,
};

int split_evenly(int length, int part) { return (length + part - 1) / part; }

// Even bits of a number, moved together: the inverse of the Morton curve, for 6 bits.
int even_bits(int number) { return (number & 1) | (number >> 1 & 2) | (number >> 2 & 4); }

}  // namespace

ViewSampler::ViewSampler(const LitScene& scene, const SolvedLight& solved, const Camera& camera,
                         const PixelRegion& region, int side, std::uint64_t seed)
    : scene_(scene),
      solved_(solved),
      width_(region.width),
      height_(region.height),
      x_(region.x),
      y_(region.y),
      picture_width_(camera.width),
      picture_height_(camera.height),
      side_(side),
      seed_(hash_words(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32))),
      tiles_across_(split_evenly(region.width, kTile)),
      tiles_down_(split_evenly(region.height, kTile)),
      pixel_angle_(static_cast<float>(1.0 / focal_length_pixels(camera))),
      eye_(float3(camera.world_from_camera.position_m)) {
  const Quaternion& turn = camera.world_from_camera.orientation;
  const double step = 1.0 / focal_length_pixels(camera);
  front_ = rotate(turn, {1.0, 0.0, 0.0});
  left_ = rotate(turn, {0.0, 1.0, 0.0}) * step;
  up_ = rotate(turn, {0.0, 0.0, 1.0}) * step;
}

PixelBuffers ViewSampler::make_buffers() const {
  PixelBuffers buffers;
  buffers.width = width_;
  buffers.height = height_;
  buffers.samples = side_ * side_;
  buffers.guides.resize(static_cast<std::size_t>(width_) * height_);
  buffers.sums.resize(buffers.guides.size());
  buffers.strays.resize(static_cast<std::size_t>(tiles()));
  return buffers;
}

ViewSampler::PixelPlace ViewSampler::place_in_tile(int tile, int number) const {
  return {(tile % tiles_across_) * kTile + even_bits(number),
          (tile / tiles_across_) * kTile + even_bits(number >> 1)};
}

Float3 ViewSampler::direction_through(double x, double y) const {
  return float3(front_ + left_ * (0.5 * picture_width_ - (x_ + x)) +
                up_ * (0.5 * picture_height_ - (y_ + y)));
}

std::uint32_t ViewSampler::seed_of(std::uint32_t purpose) const {
  return hash_words(seed_, purpose);
}

void ViewSampler::trace_middles(int tile, PixelBuffers& buffers, View& view) const {
  for (int first = 0; first < kTile * kTile; first += kLanes) {
    Lanes lanes;
    for (int i = 0; i < kLanes; ++i) {
      const PixelPlace place = place_in_tile(tile, first + i);
      if (place.x >= width_ || place.y >= height_) continue;
      Lane& lane = lanes.at[i];
      lane.used = true;
      lane.pixel = static_cast<std::uint32_t>(place.y * width_ + place.x);
      lane.direction = direction_through(place.x + 0.5, place.y + 0.5);
    }
    trace_camera_rays(lanes, SeeThrough::if_mostly_so);
    for (const Lane& lane : lanes.at) {
      if (!lane.used) continue;
      view.depth_m.pixels()[lane.pixel] = lane.path_m;
      view.instance.pixels()[lane.pixel] =
          lane.place.lit ? scene_.surfaces.instance(lane.point.triangle) : View::kNoInstance;
    }
    follow_mirrors(lanes, SeeThrough::if_mostly_so);
    for (const Lane& lane : lanes.at) {
      if (lane.used) buffers.guides[lane.pixel] = lane.place;
    }
  }
}

void ViewSampler::aim(int tile, int first, Lanes& lanes) const {
  const int samples = side_ * side_;
  std::array<PixelPlace, kLanes> places;
  for (int i = 0; i < kLanes; ++i) {
    const int number = first + i;
    places[i] = place_in_tile(tile, number / samples);
    Lane& lane = lanes.at[i];
    lane.used = number < kTile * kTile * samples && places[i].x < width_ && places[i].y < height_;
    lane.pixel = static_cast<std::uint32_t>(places[i].y * width_ + places[i].x);
    lanes.indices[i] = morton_index(static_cast<std::uint32_t>(x_ + places[i].x),
                                    static_cast<std::uint32_t>(y_ + places[i].y)) *
                           static_cast<std::uint32_t>(samples) +
                       static_cast<std::uint32_t>(number % samples);
  }
  const UnitPairs aside = lanes.draw(seed_of(kPlaceInPixel));
  for (int i = 0; i < kLanes; ++i) {
    const int sample = (first + i) % samples;
    const int column = sample % side_;
    const int row = sample / side_;
    const double aside_x = (column + static_cast<double>(aside.u[i])) / side_;
    const double aside_y = (row + static_cast<double>(aside.v[i])) / side_;
    lanes.at[i].direction = direction_through(places[i].x + aside_x, places[i].y + aside_y);
  }
}

void ViewSampler::trace_light(int tile, PixelBuffers& buffers) const {
  std::vector<StraySample>& strays = buffers.strays[static_cast<std::size_t>(tile)];
  for (int first = 0; first < kTile * kTile * side_ * side_; first += kLanes) {
    Lanes lanes;
    aim(tile, first, lanes);
    trace_camera_rays(lanes, SeeThrough::by_turns);
    follow_mirrors(lanes, SeeThrough::by_chance);
    for (Lane& lane : lanes.at) {
      if (lane.used) shade(lane);
    }
    add_direct(lanes);
    add_indirect(lanes);
    add_glossy(lanes);
    for (const Lane& lane : lanes.at) {
      if (lane.used) store(lane, buffers, strays);
    }
  }
}

void ViewSampler::trace_camera_rays(Lanes& lanes, SeeThrough see_through) const {
  RayPacket packet;
  for (int i = 0; i < kLanes; ++i) {
    const Lane& lane = lanes.at[i];
    if (lane.used) packet.set(i, eye_, lane.direction, kInfinity, lanes.indices[i]);
  }
  scene_.tracer.trace(packet, RayTracer::Rays::alike, see_through, seed_of(kSeeThrough),
                      static_cast<std::uint32_t>(side_ * side_));
  for (int i = 0; i < kLanes; ++i) {
    Lane& lane = lanes.at[i];
    if (!lane.used) continue;
    // Directions have a length of one along the optical axis, so that the ray's length is the
    // depth.
    Hit hit;
    const bool met = scene_.tracer.hit(packet, i, hit);
    lane.path_m = met ? hit.distance_m : kInfinity;
    lane.direction = normalized(lane.direction);
    if (met) arrive(lane, hit, lane.direction);
  }
}

void ViewSampler::arrive(Lane& lane, const Hit& hit, const Float3& direction) const {
  lane.point = scene_.surfaces.point(hit.triangle, hit.u, hit.v, -direction);
  lane.place.lit = true;
  lane.place.position = lane.point.position;
  lane.place.normal = lane.point.normal;
  lane.place.footprint_m = lane.path_m * pixel_angle_;
}

void ViewSampler::follow_mirrors(Lanes& lanes, SeeThrough see_through) const {
  for (int bounce = 0; bounce < kMostMirrors; ++bounce) {
    RayPacket packet;
    bool any = false;
    for (int i = 0; i < kLanes; ++i) {
      Lane& lane = lanes.at[i];
      if (!lane.used || !lane.place.lit) continue;
      const SurfaceMaterial& material = scene_.surfaces.material(lane.point.triangle);
      if (!is_mirror(material)) continue;
      const Rgb colour =
          material.base_colour * scene_.surfaces.texture_colour(lane.point, lane.place.footprint_m);
      const float cosine = std::max(0.0F, -dot(lane.direction, lane.point.normal));
      lane.passed = lane.passed * fresnel(colour, cosine);
      lane.direction = normalized(lane.direction + lane.point.normal * (2.0F * cosine));
      packet.set(i, scene_.surfaces.ray_start(lane.point.position, lane.point.face_normal),
                 lane.direction, kInfinity, lanes.indices[i] + static_cast<std::uint32_t>(bounce));
      any = true;
    }
    if (!any) return;
    scene_.tracer.trace(packet, RayTracer::Rays::alike, see_through, seed_of(kSeeThrough));
    for (int i = 0; i < kLanes; ++i) {
      if (!packet.active(i)) continue;
      Hit hit;
      lanes.at[i].place.lit = false;
      if (!scene_.tracer.hit(packet, i, hit)) continue;
      lanes.at[i].path_m += hit.distance_m;
      arrive(lanes.at[i], hit, lanes.at[i].direction);
    }
  }
}

void ViewSampler::shade(Lane& lane) const {
  if (!lane.place.lit) {
    lane.added = lane.passed * scene_.sky;
    return;
  }
  const SurfaceMaterial& material = scene_.surfaces.material(lane.point.triangle);
  const float cosine = std::max(0.05F, -dot(lane.direction, lane.point.normal));
  // At a slant the spot is longer than wide; the mean of both is a compromise between blur and
  // aliasing.
  const float spot_m = lane.place.footprint_m / (static_cast<float>(side_) * std::sqrt(cosine));
  const Rgb texture = scene_.surfaces.texture_colour(lane.point, spot_m);
  const Rgb colour = material.base_colour * texture;
  lane.albedo = colour * lane.passed;
  if (is_glossy(material)) {
    lane.reflection = Reflection(material, colour);
    lane.albedo = lane.reflection.diffuse * lane.passed;
    lane.albedo = lane.albedo * (Rgb{1.0F, 1.0F, 1.0F} - fresnel(lane.reflection.facing, cosine));
  }
  lane.added = lane.passed * material.emission * texture;
  lane.region = scene_.patches.region(
      scene_.patches.at(lane.point.triangle, lane.point.u, lane.point.v, lane.point.front));
}

void ViewSampler::add_direct(Lanes& lanes) const {
  const UnitPairs choices = lanes.draw(seed_of(kChoiceOfLight));
  const UnitPairs places = lanes.draw(seed_of(kPlaceOnLight));
  RayPacket packet;
  std::array<DirectRay, kLanes> rays;
  for (int i = 0; i < kLanes; ++i) {
    const Lane& lane = lanes.at[i];
    if (!lane.used || !lane.place.lit) continue;
    const Float3 start = scene_.surfaces.ray_start(lane.point.position, lane.point.face_normal);
    rays[i] = draw_direct_ray(scene_, start, lane.point.normal, lane.region, choices.u[i],
                              places.at(i), 1.0F);
    if (rays[i].length_m <= 0.0F) continue;
    // A smooth normal may face a light that the flat triangle faces away from.
    if (dot(rays[i].direction, lane.point.face_normal) <= 0.0F) continue;
    packet.set(i, start, rays[i].direction, rays[i].length_m, lanes.indices[i]);
  }
  const auto reached = scene_.tracer.reaches_end(packet, seed_of(kSeeThrough));
  for (int i = 0; i < kLanes; ++i) {
    if (!reached[i]) continue;
    Lane& lane = lanes.at[i];
    lane.light.parts[PlaceLight::direct] = rays[i].irradiance;
    const Reflection& reflection = lane.reflection;
    if (!reflection.glossy || reflection.alpha < kSharpAlpha || !rays[i].from_lamp) continue;
    const Frame frame(lane.point.normal);
    const Float3 towards = frame.to_local(rays[i].direction);
    const Float3 viewer = frame.to_local(-lane.direction);
    if (towards.z <= 0.0F) continue;
    lane.light.parts[PlaceLight::gloss] += lane.passed *
                                           glossy_times_cosine(reflection, viewer, towards) *
                                           rays[i].irradiance * (1.0F / towards.z);
  }
}

void ViewSampler::add_indirect(Lanes& lanes) const {
  const UnitPairs draws = lanes.draw(seed_of(kIndirectDirection));
  const UnitPairs asides = lanes.draw(seed_of(kPatchAside));
  RayPacket packet;
  std::array<Float3, kLanes> directions;
  std::array<float, kLanes> cosines{};
  for (int i = 0; i < kLanes; ++i) {
    const Lane& lane = lanes.at[i];
    if (!lane.used || !lane.place.lit) continue;
    const Float3 local = cosine_direction(draws.at(i));
    directions[i] = Frame(lane.point.normal).to_world(local);
    cosines[i] = local.z;
    if (dot(directions[i], lane.point.face_normal) <= 0.0F) continue;
    packet.set(i, scene_.surfaces.ray_start(lane.point.position, lane.point.face_normal),
               directions[i], kInfinity, lanes.indices[i]);
  }
  scene_.tracer.trace(packet, RayTracer::Rays::mixed, SeeThrough::by_chance,
                      seed_of(kSeeThrough + 1));
  std::array<Hit, kLanes> hits;
  std::array<bool, kLanes> met{};
  std::array<std::size_t, kLanes> bins{};
  for (int i = 0; i < kLanes; ++i) {
    met[i] = packet.active(i) && scene_.tracer.hit(packet, i, hits[i]);
    if (met[i]) solved_.prefetch(hits[i].triangle);
  }
  for (int i = 0; i < kLanes; ++i) {
    if (met[i]) bins[i] = solved_.prefetch_bin(hits[i], directions[i], asides.at(i));
  }
  for (int i = 0; i < kLanes; ++i) {
    if (!packet.active(i)) continue;
    Lane& lane = lanes.at[i];
    if (!met[i]) {
      lane.light.parts[PlaceLight::indirect] = scene_.sky * kPiF;
      continue;
    }
    const Hit& hit = hits[i];
    lane.light.parts[PlaceLight::indirect] = solved_.radiance_of_bin(bins[i]) * kPiF;
    if (!solved_.shines(hit.triangle)) continue;
    const float share = shining_weight(scene_, lane.region, cosines[i], directions[i], hit, 1.0F);
    lane.light.parts[PlaceLight::direct] +=
        scene_.surfaces.material(hit.triangle).mean_emission * (share * kPiF);
  }
}

void ViewSampler::add_glossy(Lanes& lanes) const {
  const bool any = std::any_of(lanes.at.begin(), lanes.at.end(), [](const Lane& lane) {
    return lane.used && lane.place.lit && lane.reflection.glossy;
  });
  if (!any) return;
  const UnitPairs draws = lanes.draw(seed_of(kGlossyDirection));
  const UnitPairs asides = lanes.draw(seed_of(kPatchAside));
  RayPacket packet;
  std::array<Float3, kLanes> directions;
  std::array<Rgb, kLanes> weights;
  for (int i = 0; i < kLanes; ++i) {
    const Lane& lane = lanes.at[i];
    if (!lane.used || !lane.place.lit || !lane.reflection.glossy) continue;
    const Frame frame(lane.point.normal);
    Float3 viewer = frame.to_local(-lane.direction);
    viewer.z = std::max(viewer.z, 0.01F);
    const Float3 local = draw_glossy(lane.reflection, normalized(viewer), draws.at(i), weights[i]);
    directions[i] = frame.to_world(local);
    if (local.z <= 0.0F || dot(directions[i], lane.point.face_normal) <= 0.0F) continue;
    packet.set(i, scene_.surfaces.ray_start(lane.point.position, lane.point.face_normal),
               directions[i], kInfinity, lanes.indices[i]);
  }
  scene_.tracer.trace(packet, RayTracer::Rays::mixed, SeeThrough::by_chance,
                      seed_of(kSeeThrough + 2));
  for (int i = 0; i < kLanes; ++i) {
    if (!packet.active(i)) continue;
    Lane& lane = lanes.at[i];
    Hit hit;
    Rgb seen = scene_.sky;
    float length_m = kInfinity;
    if (scene_.tracer.hit(packet, i, hit)) {
      length_m = hit.distance_m;
      seen = solved_.radiance(hit, directions[i], asides.at(i));
      if (solved_.shines(hit.triangle)) {
        seen += scene_.surfaces.material(hit.triangle).mean_emission;
      }
    }
    const bool sharp = lane.reflection.alpha < kSharpAlpha;
    if (sharp) seen += scene_.lights.lamps_along(lane.point.position, directions[i], length_m);
    (sharp ? lane.added : lane.light.parts[PlaceLight::gloss]) += lane.passed * weights[i] * seen;
  }
}

void ViewSampler::store(const Lane& lane, PixelBuffers& buffers,
                        std::vector<StraySample>& strays) const {
  if (same_surface(buffers.guides[lane.pixel], lane.place, kSampleReach) <= 0.0F) {
    strays.push_back({lane.pixel, lane.place, lane.albedo, lane.added, lane.light});
    return;
  }
  PixelSum& sum = buffers.sums[lane.pixel];
  ++sum.samples;
  sum.albedo += lane.albedo;
  sum.added += lane.added;
  for (std::size_t part = 0; part < PlaceLight::kParts; ++part) {
    sum.light.parts[part] += lane.light.parts[part];
    const float level = luminance(lane.light.parts[part]);
    sum.squares[part] += level * level;
  }
}

}  // namespace earpoint
