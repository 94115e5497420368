#pragma once

#include <earpoint/spatial/arrival.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {

/// What the way through the air does to sound.
struct Propagation {
  double speed_m_per_s = 0.0;
  BandArray absorption_db_per_m{};
};

Propagation make_propagation(const TraceOptions& options);

/// @param image      where the sound seems to come from
/// @param departure  unit vector along which it leaves the source, in the world's frame
/// @param energy     per band, what surfaces and the source's directivity leave of it
Arrival make_arrival(const Propagation& propagation, const Vector3& listener, const Vector3& image,
                     const Vector3& departure, const BandArray& energy);

/// @return what a source sends along a direction of the world, per band
BandArray sent_energy(const Source& source, const Vector3& departure);

}  // namespace earpoint
