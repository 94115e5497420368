#include "propagation.h"

#include <cmath>

#include <earpoint/spatial/air_absorption.h>

namespace earpoint {

Propagation make_propagation(const TraceOptions& options) {
  Propagation propagation{.speed_m_per_s = speed_of_sound_m_per_s(options.air)};
  if (options.air_absorbs) propagation.absorption_db_per_m = air_absorption_db_per_m(options.air);
  return propagation;
}

Arrival make_arrival(const Propagation& propagation, const Vector3& listener, const Vector3& image,
                     const Vector3& departure, const BandArray& energy) {
  const Vector3 way = image - listener;
  const double distance_m = norm(way);
  Arrival arrival{.delay_s = distance_m / propagation.speed_m_per_s,
                  .direction = way / distance_m,
                  .departure = departure};
  arrival.gain = air_gain(propagation.absorption_db_per_m, distance_m);
  for (int band = 0; band < kOctaveBands; ++band) {
    arrival.gain[band] *= std::sqrt(energy[band]) / static_cast<float>(distance_m);
  }
  return arrival;
}

BandArray sent_energy(const Source& source, const Vector3& departure) {
  const Quaternion source_from_world = conjugate(source.world_from_source.orientation);
  return source.directivity.energy(rotate(source_from_world, departure));
}

}  // namespace earpoint
