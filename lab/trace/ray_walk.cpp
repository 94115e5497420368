#include "ray_walk.h"

#include "ray_lane.h"
#include "sphere_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Keys of the random streams.
constexpr std::uint64_t kRayKey = 1;
constexpr std::uint64_t kLatticeKey = 2;

// Below this share of its first energy, one ray in `kThinning` continues with the energy of all.
constexpr float kFaint = 1e-6F;
constexpr float kThinning = 10.0F;

// Energies of rays are kept within this factor of the expected energy.
constexpr float kWindow = 2.0F;
constexpr float kLeastGoingOn = 0.01F;  // of rays with too little energy, at least
constexpr int kMostParts = 16;          // of one ray, at one bounce

// A listener's sphere, for rays after specular reflections.
struct Ear {
  Float3 position{};
  float radius_m = 0.0F;
  float per_volume = 0.0F;
};

// Russian roulette: the energy stays the same on average. The ray counts as fresh afterwards.
void thin_out(Lane& lane) {
  lane.alive = lane.random.uniform() * kThinning < 1.0;
  for (float& band : lane.energy) band *= kThinning;
  lane.first_energy *= kFaint;
}

class Walk {
 public:
  Walk(const WalkSetup& setup, const WalkTask& task);
  WalkTally run();

 private:
  void start(Lane& lane, int ray);
  void step(int alive);
  void advance(int index);
  void listen_along(const Lane& lane, float distance_m);
  void send_diffuse(std::size_t listener);
  [[nodiscard]] Float3 above_surface(const Float3& point, int index) const;
  bool through_walls(int index, std::size_t listener, BandArray& energy) const;
  void note_alive(const Lane& lane, float distance_m);
  [[nodiscard]] float weight(const Lane& lane) const;
  void branch(int index);
  void go_through(Lane& lane, int index);
  void turn(Lane& lane, int index);
  void mirror(Lane& lane, int index);
  void deposit(std::size_t listener, float distance_m, const Float3& towards,
               const BandArray& energy, float scale);

  const WalkSetup& setup_;
  const WalkTask& task_;
  const SceneGeometry& scene_;
  float max_distance_m_;
  float offset_m_;
  float bins_per_m_;
  std::vector<Ear> ears_;
  std::array<Lane, kPacketSize> lanes_;
  std::vector<Lane> waiting_;  // parts of rays that were split
  SoundRayPacket packet_;
  // Where the lanes' rays have just hit, this step:
  std::array<Float3, kPacketSize> normals_;  // on the side that the ray came from
  std::array<const BounceFacet*, kPacketSize> facets_{};
  double lattice_azimuth_rad_ = 0.0;
  int next_ray_;
  WalkTally tally_;
};

// The largest sphere within limits that no surface cuts: larger ones catch more rays.
Ear make_ear(const SceneGeometry& scene, const Vector3& position) {
  constexpr double kSmallest_m = 0.15;
  constexpr double kLargest_m = 0.75;
  constexpr int kProbes = 100;
  double radius_m = kLargest_m;
  for (int i = 0; i < kProbes; ++i) {
    const Vector3 direction = spiral_direction(i, 0.5, kProbes, 0.0);
    const std::optional<TriangleHit> hit =
        scene.rays().closest(position, direction, radius_m, kAllLayers);
    if (hit) radius_m = std::max<double>(hit->distance_m, kSmallest_m);
  }
  return {{static_cast<float>(position.x), static_cast<float>(position.y),
           static_cast<float>(position.z)},
          static_cast<float>(radius_m),
          static_cast<float>(1.0 / (4.0 / 3.0 * kPi * radius_m * radius_m * radius_m))};
}

Walk::Walk(const WalkSetup& setup, const WalkTask& task)
    : setup_(setup),
      task_(task),
      scene_(*setup.scene),
      max_distance_m_(static_cast<float>(setup.bins * setup.bin_m)),
      offset_m_(static_cast<float>(setup.scene->surface_offset_m())),
      bins_per_m_(static_cast<float>(1.0 / setup.bin_m)),
      next_ray_(task.first_ray) {
  for (const Vector3& position : setup.listeners) ears_.push_back(make_ear(scene_, position));
  // The lattice of first directions is turned by the same angle in all tasks of a source.
  RandomStream random(setup.options->seed, {kLatticeKey, task.stream});
  lattice_azimuth_rad_ = random.uniform(0.0, 2.0 * kPi);
  tally_.late.assign(ears_.size(), EnergyHistogram(setup.bins, setup.bin_s));
  if (setup.survey) {
    tally_.alive.resize(1 + static_cast<std::size_t>(setup.bins * setup.bin_m / kAliveStep_m));
    tally_.alive_squares.resize(tally_.alive.size());
  }
}

WalkTally Walk::run() {
  for (;;) {
    int alive = 0;
    for (Lane& lane : lanes_) {
      if (!lane.alive && !waiting_.empty()) {
        lane = waiting_.back();
        waiting_.pop_back();
      }
      while (!lane.alive && next_ray_ < task_.last_ray) start(lane, next_ray_++);
      alive += lane.alive ? 1 : 0;
    }
    if (alive == 0) return std::move(tally_);
    step(alive);
  }
}

// First directions are on a spiral lattice, each random within its own ring: they cover the sphere
// more evenly than independent ones and are still unbiased.
void Walk::start(Lane& lane, int ray) {
  const TraceOptions& options = *setup_.options;
  lane = Lane{};
  lane.random =
      RandomStream(options.seed, {kRayKey, task_.stream, static_cast<std::uint64_t>(ray)});
  const Vector3 direction =
      spiral_direction(ray, lane.random.uniform(), setup_.rays, lattice_azimuth_rad_);
  const Pose& pose = task_.source->world_from_source;
  const BandArray energy =
      task_.source->directivity.energy(rotate(conjugate(pose.orientation), direction));
  for (int band = 0; band < kOctaveBands; ++band) {
    // A source of 1 at 1 m sends 4 pi into the whole sphere.
    lane.energy[band] = static_cast<float>(4.0 * kPi / setup_.rays) * energy[band];
  }
  lane.first_energy = sum(lane.energy);
  lane.origin = {static_cast<float>(pose.position_m.x), static_cast<float>(pose.position_m.y),
                 static_cast<float>(pose.position_m.z)};
  lane.direction = {static_cast<float>(direction.x), static_cast<float>(direction.y),
                    static_cast<float>(direction.z)};
  lane.mask = scene_.mask_without(task_.source->body);
  lane.alive = lane.first_energy > 0.0F;
  tally_.emitted += lane.first_energy;
}

void Walk::step(int alive) {
  for (int i = 0; i < kPacketSize; ++i) {
    packet_.valid[i] = 0;
    const Lane& lane = lanes_[i];
    if (lane.alive) packet_.set(i, lane.origin, lane.direction, kInfinity, lane.mask);
  }
  scene_.rays().closest(packet_);
  tally_.rays_cast += alive;
  for (int i = 0; i < kPacketSize; ++i) {
    if (lanes_[i].alive) advance(i);
  }
  for (std::size_t listener = 0; listener < ears_.size(); ++listener) send_diffuse(listener);
  for (int i = 0; i < kPacketSize; ++i) {
    if (lanes_[i].alive) branch(i);
  }
}

void Walk::advance(int index) {
  Lane& lane = lanes_[index];
  if (!packet_.hit(index)) {
    listen_along(lane, kInfinity);
    tally_.escaped += sum(lane.energy);
    lane.alive = false;
    return;
  }
  const float distance_m = packet_.rays.ray.tfar[index];
  listen_along(lane, distance_m);
  if (!tally_.alive.empty()) note_alive(lane, distance_m);
  lane.travelled_m += distance_m;
  const BounceFacet& facet = scene_.facet(packet_.triangles[index]);
  facets_[index] = &facet;
  const float side = dot(lane.direction, facet.normal) < 0.0F ? 1.0F : -1.0F;
  for (int axis = 0; axis < 3; ++axis) {
    normals_[index][axis] = side * facet.normal[axis];
    lane.origin[axis] += distance_m * lane.direction[axis];
  }
  lane.alive = lane.travelled_m < max_distance_m_;
  const float across_m = distance_m * std::abs(dot(lane.direction, facet.normal));
  lane.passing = lane.entered != nullptr &&
                 SceneGeometry::is_other_side(*lane.entered, facet, static_cast<double>(across_m));
  lane.entered = nullptr;
}

// Counts a specularly reflected ray that passes through the sphere around a listener: the mean
// energy density is the sum of energy times length inside, over the volume.
void Walk::listen_along(const Lane& lane, float distance_m) {
  if (lane.leg == Leg::direct || lane.leg == Leg::diffuse) return;
  for (std::size_t listener = 0; listener < ears_.size(); ++listener) {
    const Ear& ear = ears_[listener];
    const Float3 to_ear = {ear.position[0] - lane.origin[0], ear.position[1] - lane.origin[1],
                           ear.position[2] - lane.origin[2]};
    const float along_m = dot(to_ear, lane.direction);
    const float aside_squared = dot(to_ear, to_ear) - along_m * along_m;
    const float half_squared = ear.radius_m * ear.radius_m - aside_squared;
    if (half_squared <= 0.0F) continue;
    const float half_m = std::sqrt(half_squared);
    const float inside_m =
        std::min(along_m + half_m, distance_m) - std::max(along_m - half_m, 0.0F);
    if (inside_m <= 0.0F) continue;
    // Distance from the image of the source, or of the last diffuse reflection.
    const float straight_m = lane.travelled_m - lane.turned_m + along_m;
    const float image_m = std::sqrt(straight_m * straight_m + std::max(aside_squared, 0.0F));
    const bool is_arrival =
        lane.leg == Leg::mirrored && static_cast<double>(image_m) <= setup_.mirrors.max_distance_m;
    if (is_arrival) continue;
    const Float3 towards = {-lane.direction[0], -lane.direction[1], -lane.direction[2]};
    deposit(listener, lane.turned_m + image_m, towards, lane.energy, inside_m * ear.per_volume);
  }
}

// Next-event estimation: sound from the points that rays have hit straight to a listener.
void Walk::send_diffuse(std::size_t listener) {
  const Ear& ear = ears_[listener];
  std::array<float, kPacketSize> scales;
  std::array<float, kPacketSize> distances_m;
  std::array<Float3, kPacketSize> towards;
  int sent = 0;
  for (int i = 0; i < kPacketSize; ++i) {
    packet_.valid[i] = 0;
    const Lane& lane = lanes_[i];
    if (!lane.alive || lane.passing) continue;
    for (int axis = 0; axis < 3; ++axis) towards[i][axis] = lane.origin[axis] - ear.position[axis];
    const float squared = dot(towards[i], towards[i]);
    distances_m[i] = std::sqrt(squared);
    const float cosine = -dot(towards[i], normals_[i]) / distances_m[i];
    if (!(cosine > 0.0F) || lane.travelled_m + distances_m[i] >= max_distance_m_) continue;
    scales[i] = cosine / (static_cast<float>(kPi) * squared);
    const Float3 from = above_surface(lane.origin, i);
    const Float3 ray = {ear.position[0] - from[0], ear.position[1] - from[1],
                        ear.position[2] - from[2]};
    packet_.set(i, from, ray, 1.0F, kAllLayers & ~kTransmissiveLayer);
    ++sent;
  }
  if (sent == 0) return;
  const std::uint32_t blocked = scene_.rays().occluded(packet_);
  tally_.rays_cast += sent;
  for (int i = 0; i < kPacketSize; ++i) {
    if (packet_.valid[i] == 0 || (blocked >> i & 1U) != 0) continue;
    const Lane& lane = lanes_[i];
    const BounceSurface& surface = scene_.surface(*facets_[i]);
    BandArray energy;
    for (int band = 0; band < kOctaveBands; ++band) {
      energy[band] = lane.energy[band] * surface.diffuse[band];
    }
    if (scene_.transmits() && !through_walls(i, listener, energy)) continue;
    deposit(listener, lane.travelled_m + distances_m[i], towards[i], energy, scales[i]);
  }
}

Float3 Walk::above_surface(const Float3& point, int index) const {
  const Float3& normal = normals_[index];
  return {point[0] + offset_m_ * normal[0], point[1] + offset_m_ * normal[1],
          point[2] + offset_m_ * normal[2]};
}

bool Walk::through_walls(int index, std::size_t listener, BandArray& energy) const {
  const Float3 from = above_surface(lanes_[index].origin, index);
  return scene_.transmit({from[0], from[1], from[2]}, setup_.listeners[listener],
                         kTransmissiveLayer, energy);
}

// A survey counts a ray at every step of its path.
void Walk::note_alive(const Lane& lane, float distance_m) {
  const auto step_m = static_cast<float>(kAliveStep_m);
  const auto first = static_cast<std::size_t>(std::ceil(lane.travelled_m / step_m));
  const auto last = static_cast<std::size_t>((lane.travelled_m + distance_m) / step_m);
  const double energy = static_cast<double>(sum(lane.energy));
  for (std::size_t i = first; i <= last && i < tally_.alive.size(); ++i) {
    tally_.alive_squares[i] += energy * energy;
    for (int band = 0; band < kOctaveBands; ++band) tally_.alive[i][band] += lane.energy[band];
  }
}

// Energy of a ray relative to the survey's expectation, mean over bands. Expectations are limited
// to -60 dB, below which rays become fewer.
float Walk::weight(const Lane& lane) const {
  const EnergyAlive& expected = *task_.expected;
  const auto place = static_cast<std::size_t>(lane.travelled_m / static_cast<float>(kAliveStep_m));
  const BandArray& here = expected[std::min(place, expected.size() - 1)];
  float sum = 0.0F;
  int bands = 0;
  for (int band = 0; band < kOctaveBands; ++band) {
    const float at_first = expected.front()[band];
    if (at_first <= 0.0F) continue;
    sum += lane.energy[band] / std::max(here[band], kFaint * at_first);
    ++bands;
  }
  return bands > 0 ? sum * static_cast<float>(setup_.rays) / static_cast<float>(bands) : 1.0F;
}

// After a bounce the ray continues as one, in several parts, or not at all.
void Walk::branch(int index) {
  Lane& lane = lanes_[index];
  if (lane.passing) {
    go_through(lane, index);
    return;
  }
  int parts = 1;
  if (task_.expected != nullptr) {
    const float before = weight(lane);
    if (before > kWindow) parts = std::min(kMostParts, static_cast<int>(before));
  }
  for (float& band : lane.energy) band /= static_cast<float>(parts);
  for (int part = 1; part < parts; ++part) {
    Lane copy = lane;
    copy.random = RandomStream(lane.random.next());
    turn(copy, index);
    if (copy.alive) waiting_.push_back(copy);
  }
  turn(lane, index);
}

void Walk::go_through(Lane& lane, int index) {
  for (int axis = 0; axis < 3; ++axis) lane.origin[axis] -= offset_m_ * normals_[index][axis];
}

// Draws how the ray continues, with weights that keep the energy of each band on average.
void Walk::turn(Lane& lane, int index) {
  const BounceFacet& facet = *facets_[index];
  const BounceSurface& surface = scene_.surface(facet);
  float diffuse = 0.0F;
  float specular = 0.0F;
  float transmitted = 0.0F;
  for (int band = 0; band < kOctaveBands; ++band) {
    diffuse += lane.energy[band] * surface.diffuse[band];
    specular += lane.energy[band] * surface.specular[band];
    transmitted += lane.energy[band] * surface.transmitted[band];
  }
  const float all = diffuse + specular + transmitted;
  lane.mask = kAllLayers;
  if (!(all > 0.0F) || ++lane.bounces >= setup_.options->max_bounces) {
    lane.alive = false;
    return;
  }
  const float draw = static_cast<float>(lane.random.uniform()) * all;
  if (draw < diffuse) {
    weigh(lane, surface.diffuse, all / diffuse);
    lane.direction = diffuse_direction(normals_[index], lane.random);
    lane.origin = above_surface(lane.origin, index);
    lane.leg = Leg::diffuse;
    lane.chain.leave();
    lane.turned_m = lane.travelled_m;
  } else if (draw < diffuse + specular || transmitted == 0.0F) {
    weigh(lane, surface.specular, all / specular);
    mirror(lane, index);
  } else {
    weigh(lane, surface.transmitted, all / transmitted);
    go_through(lane, index);
    lane.entered = &facet;
    lane.chain.leave();
    if (lane.leg == Leg::mirrored) lane.leg = Leg::specular;
  }
  if (task_.expected == nullptr) {
    if (sum(lane.energy) < kFaint * lane.first_energy) thin_out(lane);
    return;
  }
  const float now = weight(lane);
  if (now * kWindow >= 1.0F) return;
  const float going_on = std::max(now, kLeastGoingOn);
  lane.alive = static_cast<float>(lane.random.uniform()) < going_on;
  for (float& band : lane.energy) band /= going_on;
}

void Walk::mirror(Lane& lane, int index) {
  const BounceFacet& facet = *facets_[index];
  const Float3& normal = normals_[index];
  const float towards = 2.0F * dot(lane.direction, normal);
  for (int axis = 0; axis < 3; ++axis) lane.direction[axis] -= towards * normal[axis];
  const float length = std::sqrt(dot(lane.direction, lane.direction));
  for (float& component : lane.direction) component /= length;
  lane.origin = above_surface(lane.origin, index);
  const bool held = lane.chain.reflect(facet, scene_.surface(facet), setup_.mirrors);
  lane.leg = held ? Leg::mirrored : Leg::specular;
}

void Walk::deposit(std::size_t listener, float distance_m, const Float3& towards,
                   const BandArray& energy, float scale) {
  const int bin = static_cast<int>(distance_m * bins_per_m_);
  if (bin >= setup_.bins) return;
  BandArray& cell = tally_.late[listener].at(bin, sector_of(towards[0], towards[1], towards[2]));
  for (int band = 0; band < kOctaveBands; ++band) cell[band] += scale * energy[band];
}

}  // namespace

WalkTally walk_rays(const WalkSetup& setup, const WalkTask& task) {
  return Walk(setup, task).run();
}

}  // namespace earpoint
