#pragma once

#include <string>
#include <vector>

#include <earpoint/core/parallel.h>

namespace earpoint::gates {

/// One line of the table of gates: what the final impulse response is held against, and how it did.
struct GateRow {
  std::string gate;
  std::string measured;
  std::string limit;
  bool passed = false;
};

/// Free field: level over distance, time of the first arrival.
std::vector<GateRow> free_field_gate(ThreadPool& pool);

/// An empty box without scattering against image sources.
std::vector<GateRow> image_source_gate(ThreadPool& pool);

/// An empty box that scatters by Lambert's law: reverberation time against Eyring's formula, and
/// against particles that bounce between six planes.
std::vector<GateRow> reverberation_gate(ThreadPool& pool);

/// Source and listener change places behind an obstacle.
std::vector<GateRow> reciprocity_gate(ThreadPool& pool);

/// How much is spent: a test is quick, a published table thorough.
enum class Effort { quick, thorough };

/// Mean and spread over the number of rays.
std::vector<GateRow> ray_count_gate(ThreadPool& pool, Effort effort);

/// Rooms whose late sound is that of a few rays: uneven absorption, a smooth corridor.
std::vector<GateRow> uneven_gate(ThreadPool& pool, Effort effort);

/// The default HRTF: left and right, front and back, above and below, turns of the head.
std::vector<GateRow> ear_gate();

/// A lone arrival's ringing, a source near the head, a source that moves.
std::vector<GateRow> motion_gate(ThreadPool& pool);

/// A wall with an open door, a closed one, and none; the level behind it against the uniform theory
/// of diffraction.
std::vector<GateRow> diffraction_gate(ThreadPool& pool);

/// Walls and doorways of real thickness against a wave solver; no jump where a step of 1 mm crosses
/// a shadow line; no place behind a wall louder than free field.
std::vector<GateRow> thick_wall_gate(ThreadPool& pool);

/// Equal bytes for any number of threads; meshes with holes are refused.
std::vector<GateRow> determinism_gate();

}  // namespace earpoint::gates
