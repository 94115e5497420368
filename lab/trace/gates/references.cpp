#include "references.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint::gates {
namespace {

// The image of a coordinate in the k-th mirror cell of a wall pair.
double image_coordinate(int cell, double length_m, double coordinate_m) {
  return cell % 2 == 0 ? cell * length_m + coordinate_m : (cell + 1) * length_m - coordinate_m;
}

// A particle between the six planes of a box.
struct Particle {
  std::array<double, 3> position{};
  std::array<double, 3> direction{};
  double travelled_m = 0.0;
  double weight = 1.0;
};

std::array<double, 3> random_on_sphere(RandomStream& random) {
  const double z = random.uniform(-1.0, 1.0);
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi);
  const double across = std::sqrt(1.0 - z * z);
  return {across * std::cos(azimuth_rad), across * std::sin(azimuth_rad), z};
}

// Lambert's law about an axis.
std::array<double, 3> random_from_wall(int axis, double inward, RandomStream& random) {
  const double squared = random.uniform();
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi);
  std::array<double, 3> direction{};
  direction[axis] = inward * std::sqrt(1.0 - squared);
  direction[(axis + 1) % 3] = std::sqrt(squared) * std::cos(azimuth_rad);
  direction[(axis + 2) % 3] = std::sqrt(squared) * std::sin(azimuth_rad);
  return direction;
}

// The wall that a particle hits next, and its distance.
struct WallHit {
  int axis = 0;
  double distance_m = 0.0;
};

WallHit next_wall(const std::array<double, 3>& lengths, const Particle& particle) {
  WallHit hit{.axis = 0, .distance_m = 1e30};
  for (int axis = 0; axis < 3; ++axis) {
    const double d = particle.direction[axis];
    if (d == 0.0) continue;
    const double wall = d > 0.0 ? lengths[axis] : 0.0;
    const double distance_m = (wall - particle.position[axis]) / d;
    if (distance_m < hit.distance_m) hit = {axis, distance_m};
  }
  return hit;
}

// The part of the path inside the sphere.
struct Chord {
  double middle_m = 0.0;
  double length_m = 0.0;
};

Chord sphere_chord(const Particle& particle, const std::array<double, 3>& centre, double radius_m,
                   double way_m) {
  double along = 0.0;
  double squared = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double offset = centre[axis] - particle.position[axis];
    along += offset * particle.direction[axis];
    squared += offset * offset;
  }
  const double half_squared = radius_m * radius_m - (squared - along * along);
  if (half_squared <= 0.0) return {};
  const double half = std::sqrt(half_squared);
  const double enter = std::max(0.0, along - half);
  const double leave = std::min(way_m, along + half);
  return {(enter + leave) / 2.0, std::max(0.0, leave - enter)};
}

// Energy lost per metre to the air.
double air_per_m(double db_per_m) { return db_per_m * std::log(10.0) / 10.0; }

// The growth per metre at which the eigenvalue of transport balances the absorption.
template <typename Eigenvalue>
double balance(double absorption, Eigenvalue eigenvalue) {
  double low = 0.0;
  double high = 10.0;
  for (int step = 0; step < 40; ++step) {
    const double middle = (low + high) / 2.0;
    ((1.0 - absorption) * eigenvalue(middle) < 1.0 ? low : high) = middle;
  }
  return (low + high) / 2.0;
}

double time_of_rate(double energy_per_m, double speed_m_per_s) {
  return 6.0 * std::log(10.0) / (energy_per_m * speed_m_per_s);
}

}  // namespace

double Box::surface_m2() const {
  return 2.0 * (lengths_m.x * lengths_m.y + lengths_m.x * lengths_m.z + lengths_m.y * lengths_m.z);
}

std::vector<BoxImage> box_images(const Box& box, const Vector3& source, const Vector3& listener,
                                 double max_distance_m) {
  const auto reach = [&](double length_m) {
    return static_cast<int>(std::ceil(max_distance_m / length_m)) + 1;
  };
  std::vector<BoxImage> images;
  const Vector3& l = box.lengths_m;
  for (int x = -reach(l.x); x <= reach(l.x); ++x) {
    for (int y = -reach(l.y); y <= reach(l.y); ++y) {
      for (int z = -reach(l.z); z <= reach(l.z); ++z) {
        const Vector3 image{image_coordinate(x, l.x, source.x), image_coordinate(y, l.y, source.y),
                            image_coordinate(z, l.z, source.z)};
        const double distance_m = norm(image - listener);
        if (distance_m > max_distance_m) continue;
        images.push_back({distance_m, std::abs(x) + std::abs(y) + std::abs(z)});
      }
    }
  }
  return images;
}

std::vector<float> image_response(const Box& box, const std::vector<BoxImage>& images,
                                  int sample_rate_hz, int samples) {
  const int size = fast_fft_size(2 * samples);
  RealFft<double> fft(size);
  std::vector<std::complex<double>> spectrum(fft.bins());
  std::array<std::vector<double>, kOctaveBands> weights;
  for (int band = 0; band < kOctaveBands; ++band) {
    for (int bin = 0; bin < fft.bins(); ++bin) {
      weights[band].push_back(
          octave_band_weight(band, static_cast<double>(bin) * sample_rate_hz / size));
    }
  }
  std::vector<std::vector<std::complex<double>>> bands(
      kOctaveBands, std::vector<std::complex<double>>(fft.bins()));
  for (const BoxImage& image : images) {
    std::array<double, kOctaveBands> gains;
    for (int band = 0; band < kOctaveBands; ++band) {
      gains[band] =
          std::pow(1.0 - static_cast<double>(box.absorption[band]), image.reflections / 2.0) *
          std::pow(10.0, -static_cast<double>(box.air_db_per_m[band]) * image.distance_m / 20.0) /
          image.distance_m;
    }
    const double step_rad =
        -2.0 * kPi * image.distance_m / box.speed_m_per_s * sample_rate_hz / size;
    const std::complex<double> turn = std::polar(1.0, step_rad);
    std::complex<double> phase = 1.0;
    for (int bin = 0; bin < fft.bins(); ++bin) {
      double gain = 0.0;
      for (int band = 0; band < kOctaveBands; ++band) gain += gains[band] * weights[band][bin];
      spectrum[bin] += gain * phase;
      phase *= turn;
    }
  }
  // The response's documented edge: a raised cosine over the top 8 % of the spectrum.
  for (int bin = 0; bin < fft.bins(); ++bin) {
    const double into = (static_cast<double>(bin) / (fft.bins() - 1) - 0.92) / 0.08;
    if (into > 0.0) spectrum[bin] *= 0.5 * (1.0 + std::cos(kPi * into));
  }
  std::vector<double> signal(size);
  fft.inverse(spectrum, signal);
  return {signal.begin(), signal.begin() + samples};
}

double eyring_time_s(const Box& box, int band) {
  const double absorbed_per_m = -box.surface_m2() *
                                std::log(1.0 - static_cast<double>(box.absorption[band])) /
                                (4.0 * box.volume_m3());
  return time_of_rate(absorbed_per_m + air_per_m(box.air_db_per_m[band]), box.speed_m_per_s);
}

std::vector<double> particle_box_energies(const Box& box, const BoxWalls& walls,
                                          const Vector3& source, const Vector3& listener, int bins,
                                          double bin_s, int particles) {
  constexpr double kRadius_m = 0.5;
  const double per_volume = 3.0 / (4.0 * kPi * kRadius_m * kRadius_m * kRadius_m);
  const std::array<double, 3> lengths = {box.lengths_m.x, box.lengths_m.y, box.lengths_m.z};
  const std::array<double, 3> centre = {listener.x, listener.y, listener.z};
  const double bin_m = bin_s * box.speed_m_per_s;
  const double direct_m = norm(source - listener);
  std::vector<double> energies(bins);
  energies[static_cast<std::size_t>(direct_m / bin_m)] += 1.0 / (direct_m * direct_m);
  RandomStream random(20240501);
  for (int i = 0; i < particles; ++i) {
    Particle particle{.position = {source.x, source.y, source.z},
                      .direction = random_on_sphere(random)};
    particle.weight = 4.0 * kPi / particles;
    for (bool reflected_once = false; particle.travelled_m < bins * bin_m; reflected_once = true) {
      const WallHit hit = next_wall(lengths, particle);
      if (reflected_once) {
        const Chord chord = sphere_chord(particle, centre, kRadius_m, hit.distance_m);
        const auto bin = static_cast<std::size_t>((particle.travelled_m + chord.middle_m) / bin_m);
        if (bin < energies.size()) energies[bin] += particle.weight * chord.length_m * per_volume;
      }
      for (int axis = 0; axis < 3; ++axis) {
        particle.position[axis] += hit.distance_m * particle.direction[axis];
      }
      particle.travelled_m += hit.distance_m;
      const bool high = particle.direction[hit.axis] > 0.0;
      particle.position[hit.axis] = high ? lengths[hit.axis] : 0.0;
      if (random.uniform() < walls.scattering) {
        particle.direction = random_from_wall(hit.axis, high ? -1.0 : 1.0, random);
      } else {
        particle.direction[hit.axis] *= -1.0;
      }
      particle.weight *= 1.0 - walls.absorption[2 * hit.axis + (high ? 1 : 0)];
    }
  }
  return energies;
}

void absorb_in_air(const Box& box, int band, double bin_s, std::vector<double>& energies) {
  const double per_bin = air_per_m(box.air_db_per_m[band]) * bin_s * box.speed_m_per_s;
  for (std::size_t bin = 0; bin < energies.size(); ++bin) {
    energies[bin] *= std::exp(-per_bin * (static_cast<double>(bin) + 0.5));
  }
}

double lambert_sphere_time_s(double radius_m, double absorption, double air_db_per_m,
                             double speed_m_per_s) {
  const double growth_per_m = balance(absorption, [&](double growth) {
    const double a = 2.0 * radius_m * growth;
    return a < 1e-6 ? 1.0 : 2.0 * (std::exp(a) * (a - 1.0) + 1.0) / (a * a);
  });
  return time_of_rate(growth_per_m + air_per_m(air_db_per_m), speed_m_per_s);
}

}  // namespace earpoint::gates
