#include <earpoint/spatial/shoebox.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kMostArrivals = 20e6;

// A mirror image along one axis.
struct AxisImage {
  double offset_m = 0.0;  // from the listener to the image, along the axis
  bool mirrored = false;
  int order = 0;
  BandArray gain{};
};

void check_inside(const char* what, const Vector3& position_m, const Vector3& lengths_m) {
  const bool inside = position_m.x > 0.0 && position_m.x < lengths_m.x && position_m.y > 0.0 &&
                      position_m.y < lengths_m.y && position_m.z > 0.0 &&
                      position_m.z < lengths_m.z;
  if (!inside) {
    throw InputError(
        fmt::format("room: {}", what),
        fmt::format("expected it inside {} x {} x {} m, found ({}, {}, {})", lengths_m.x,
                    lengths_m.y, lengths_m.z, position_m.x, position_m.y, position_m.z));
  }
}

void check_room(const Shoebox& room) {
  const Vector3& lengths = room.lengths_m;
  if (!(lengths.x > 0.0 && lengths.y > 0.0 && lengths.z > 0.0 && std::isfinite(norm(lengths)))) {
    throw InputError("room: lengths", fmt::format("expected three lengths > 0 m, found {}, {}, {}",
                                                  lengths.x, lengths.y, lengths.z));
  }
  for (int wall = 0; wall < 6; ++wall) {
    for (const float absorption : room.absorption[wall]) {
      if (!(absorption >= 0.0F && absorption <= 1.0F)) {
        throw InputError(fmt::format("room: absorption of wall {}", wall),
                         fmt::format("expected [0, 1], found {}", absorption));
      }
    }
  }
  check_air(room.air);
}

float power(float base, int exponent) {
  float result = 1.0F;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

// All images along one axis within reach. Image (n, mirrored) lies at 2 n L + s or 2 n L - s and
// has met the low wall |n - mirrored| times and the high wall |n| times.
std::vector<AxisImage> axis_images(double length_m, double source_m, double listener_m,
                                   const BandArray& low, const BandArray& high, double reach_m,
                                   int max_order) {
  std::vector<AxisImage> images;
  const int most = static_cast<int>(std::ceil(reach_m / (2.0 * length_m))) + 1;
  for (int n = -most; n <= most; ++n) {
    for (const bool mirrored : {false, true}) {
      AxisImage image;
      image.offset_m = 2.0 * n * length_m + (mirrored ? -source_m : source_m) - listener_m;
      image.mirrored = mirrored;
      const int low_hits = std::abs(n - (mirrored ? 1 : 0));
      const int high_hits = std::abs(n);
      image.order = low_hits + high_hits;
      if (std::abs(image.offset_m) > reach_m) continue;
      if (max_order >= 0 && image.order > max_order) continue;
      for (int band = 0; band < kOctaveBands; ++band) {
        image.gain[band] = power(std::sqrt(1.0F - low[band]), low_hits) *
                           power(std::sqrt(1.0F - high[band]), high_hits);
      }
      images.push_back(image);
    }
  }
  return images;
}

}  // namespace

std::vector<Arrival> shoebox_arrivals(const Shoebox& room, const Vector3& source_m,
                                      const Pose& world_from_listener, double max_time_s,
                                      int max_order) {
  check_room(room);
  const Vector3& listener_m = world_from_listener.position_m;
  check_inside("source", source_m, room.lengths_m);
  check_inside("listener", listener_m, room.lengths_m);
  if (norm(source_m - listener_m) < 1e-3) {
    throw InputError("room: source", "expected it at least 1 mm from the listener");
  }
  EARPOINT_CHECK(max_time_s >= 0.0);
  const double speed = speed_of_sound_m_per_s(room.air);
  const double reach_m = speed * max_time_s;
  const Vector3& lengths = room.lengths_m;
  const double count =
      4.0 / 3.0 * kPi * reach_m * reach_m * reach_m / (lengths.x * lengths.y * lengths.z);
  if (max_order < 0 && count > kMostArrivals) {
    throw InputError("room",
                     fmt::format("{:.0f} million arrivals within {} s", count / 1e6, max_time_s),
                     "ask for a shorter response or limit the order");
  }

  const auto& walls = room.absorption;
  const auto xs =
      axis_images(lengths.x, source_m.x, listener_m.x, walls[0], walls[1], reach_m, max_order);
  const auto ys =
      axis_images(lengths.y, source_m.y, listener_m.y, walls[2], walls[3], reach_m, max_order);
  const auto zs =
      axis_images(lengths.z, source_m.z, listener_m.z, walls[4], walls[5], reach_m, max_order);
  const BandArray air_db_per_m = air_absorption_db_per_m(room.air);
  const Quaternion listener_from_world = conjugate(world_from_listener.orientation);

  std::vector<Arrival> arrivals;
  for (const AxisImage& x : xs) {
    for (const AxisImage& y : ys) {
      if (std::hypot(x.offset_m, y.offset_m) > reach_m) continue;
      for (const AxisImage& z : zs) {
        const Vector3 offset{x.offset_m, y.offset_m, z.offset_m};
        const double distance_m = norm(offset);
        const int order = x.order + y.order + z.order;
        if (distance_m > reach_m || (max_order >= 0 && order > max_order)) continue;
        Arrival& arrival = arrivals.emplace_back();
        arrival.delay_s = distance_m / speed;
        arrival.direction = rotate(listener_from_world, offset / distance_m);
        // Each reflection along an axis reverses the departure along it.
        const Vector3 way = -offset / distance_m;
        arrival.departure = {x.mirrored ? -way.x : way.x, y.mirrored ? -way.y : way.y,
                             z.mirrored ? -way.z : way.z};
        arrival.order = order;
        arrival.gain = air_gain(air_db_per_m, distance_m);
        for (int band = 0; band < kOctaveBands; ++band) {
          arrival.gain[band] *=
              x.gain[band] * y.gain[band] * z.gain[band] / static_cast<float>(distance_m);
        }
      }
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.delay_s < b.delay_s; });
  return arrivals;
}

BandArray eyring_reverberation_time_s(const Shoebox& room) {
  check_room(room);
  const Vector3& l = room.lengths_m;
  const std::array<double, 3> areas = {l.y * l.z, l.x * l.z, l.x * l.y};
  const double area = 2.0 * (areas[0] + areas[1] + areas[2]);
  const double volume = l.x * l.y * l.z;
  const BandArray air_db_per_m = air_absorption_db_per_m(room.air);
  BandArray times_s{};
  for (int band = 0; band < kOctaveBands; ++band) {
    double absorbed = 0.0;
    for (int wall = 0; wall < 6; ++wall) absorbed += areas[wall / 2] * room.absorption[wall][band];
    const double air_per_m = air_db_per_m[band] * std::log(10.0) / 10.0;  // energy, nepers
    const double loss = -area * std::log(1.0 - absorbed / area) + 4.0 * air_per_m * volume;
    times_s[band] = static_cast<float>(24.0 * std::log(10.0) * volume /
                                       (speed_of_sound_m_per_s(room.air) * loss));
  }
  return times_s;
}

}  // namespace earpoint
