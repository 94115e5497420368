#pragma once

#include <array>
#include <complex>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/vector3.h>

namespace earpoint::gates {

/// What the gates hold the tracer against: written apart from it, from first principles.

/// An empty box, all walls alike.
struct Box {
  Vector3 lengths_m{};
  BandArray absorption{};
  BandArray air_db_per_m{};
  double speed_m_per_s = 343.2;

  [[nodiscard]] double volume_m3() const { return lengths_m.x * lengths_m.y * lengths_m.z; }
  [[nodiscard]] double surface_m2() const;
};

/// One image source of a box.
struct BoxImage {
  double distance_m = 0.0;
  int reflections = 0;
};

/// All images of a source in a box up to a distance, by mirroring cells (Allen and Berkley, 1979).
std::vector<BoxImage> box_images(const Box& box, const Vector3& source, const Vector3& listener,
                                 double max_distance_m);

/// The impulse response of a set of images, summed in the frequency domain, so that every arrival
/// lies exactly at its time. Gains between the bands' centres as `octave_band_weight` has them; the
/// top 8 % of the spectrum fade out, as the renderer's do.
std::vector<float> image_response(const Box& box, const std::vector<BoxImage>& images,
                                  int sample_rate_hz, int samples);

/// Eyring's reverberation time (1930), with the air's absorption.
double eyring_time_s(const Box& box, int band);

/// What the walls of a box do to energy that meets them.
struct BoxWalls {
  std::array<double, 6> absorption{};  ///< x low, x high, y low, y high, z low, z high
  double scattering = 1.0;             ///< by Lambert's law; the rest is mirrored
};

/// The energy over time at a listener in a box: particles that bounce between the six planes,
/// counted by the length of their way inside a sphere of 0.5 m around the listener, with the direct
/// sound added exactly. No rays against meshes, no next-event estimation; the air takes nothing.
/// @return  energy per bin
std::vector<double> particle_box_energies(const Box& box, const BoxWalls& walls,
                                          const Vector3& source, const Vector3& listener, int bins,
                                          double bin_s, int particles);

/// Lets the air take its share of energies over time.
void absorb_in_air(const Box& box, int band, double bin_s, std::vector<double>& energies);

/// The reverberation time of a sphere whose wall scatters by Lambert's law, in closed form: its
/// free paths l are independent, with density 2 l / (2 r)^2. Eyring's formula takes them all as
/// equally long; in truth they vary, and every decay is slower (Kuttruff, Room Acoustics, chapter
/// 5).
double lambert_sphere_time_s(double radius_m, double absorption, double air_db_per_m,
                             double speed_m_per_s);

/// Pressure that a rigid wedge with an endless edge diffracts, by the uniform theory of diffraction
/// (Kouyoumjian and Pathak, Proc. IEEE 62, 1974): another theory than the tracer's, good where the
/// ways are longer than a wave.
/// @param open_angle_rad  of the air; 2 pi for a half-plane
/// @param source_angle_rad, receiver_angle_rad  from one face
/// @param source_m, receiver_m  distances from the edge, in the plane across it
/// @return  complex pressure relative to 1 m in free field, its phase with the way's
std::complex<double> wedge_pressure(double open_angle_rad, double source_angle_rad, double source_m,
                                    double receiver_angle_rad, double receiver_m,
                                    double wave_number);

}  // namespace earpoint::gates
