#include "gates/gates.h"

#include <gtest/gtest.h>

namespace earpoint {
namespace {

void expect_passed(const std::vector<gates::GateRow>& rows) {
  ASSERT_FALSE(rows.empty());
  for (const gates::GateRow& row : rows) {
    EXPECT_TRUE(row.passed) << row.gate << ": " << row.measured << ", limit " << row.limit;
  }
}

// Each gate states its limits and where they come from; `trace_gates` writes
// the same rows as a table.

TEST(TraceGates, FreeFieldFallsByTheInverseSquare) {
  ThreadPool pool(available_cores());
  expect_passed(gates::free_field_gate(pool));
}

TEST(TraceGates, SpecularBoxIsTheSumOfItsImages) {
  ThreadPool pool(available_cores());
  expect_passed(gates::image_source_gate(pool));
}

TEST(TraceGates, DiffuseBoxDecaysAsParticlesDo) {
  ThreadPool pool(available_cores());
  expect_passed(gates::reverberation_gate(pool));
}

TEST(TraceGates, RoomsThatDecayByFewRaysDecayRight) {
  ThreadPool pool(available_cores());
  expect_passed(gates::uneven_gate(pool, gates::Effort::quick));
}

TEST(TraceGates, SourceAndListenerMayBeSwapped) {
  ThreadPool pool(available_cores());
  expect_passed(gates::reciprocity_gate(pool));
}

TEST(TraceGates, EnergyDoesNotDependOnTheNumberOfRays) {
  ThreadPool pool(available_cores());
  expect_passed(gates::ray_count_gate(pool, gates::Effort::quick));
}

TEST(TraceGates, LeftIsLeftFrontIsFrontAndAboveIsAbove) { expect_passed(gates::ear_gate()); }

TEST(TraceGates, SoundsNearByAndOnTheMoveAreRight) {
  ThreadPool pool(available_cores());
  expect_passed(gates::motion_gate(pool));
}

TEST(TraceGates, SoundBendsRoundADoor) {
  ThreadPool pool(available_cores());
  expect_passed(gates::diffraction_gate(pool));
}

TEST(TraceGates, ThickWallsDiffractAsWavesDo) {
  ThreadPool pool(available_cores());
  expect_passed(gates::thick_wall_gate(pool));
}

TEST(TraceGates, ThreadsDoNotChangeAByteAndHolesAreRefused) {
  expect_passed(gates::determinism_gate());
}

}  // namespace
}  // namespace earpoint
