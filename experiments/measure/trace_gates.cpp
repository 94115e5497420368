// Writes the table of the path tracer's gates, as Markdown, to standard output.

#include "gates/gates.h"

#include <cstdio>
#include <string>

#include <earpoint/core/parallel.h>

int main() {
  using namespace earpoint;
  ThreadPool pool(available_cores());
  std::printf("| Gate | Measured | Limit | |\n|---|---|---|---|\n");
  bool passed = true;
  const auto print = [&](const std::vector<gates::GateRow>& rows) {
    for (const gates::GateRow& row : rows) {
      std::printf("| %s | %s | %s | %s |\n", row.gate.c_str(), row.measured.c_str(),
                  row.limit.c_str(), row.passed ? "ok" : "FAILED");
      std::fflush(stdout);
      passed = passed && row.passed;
    }
  };
  print(gates::free_field_gate(pool));
  print(gates::image_source_gate(pool));
  print(gates::reverberation_gate(pool));
  print(gates::uneven_gate(pool, gates::Effort::thorough));
  print(gates::reciprocity_gate(pool));
  print(gates::ray_count_gate(pool, gates::Effort::thorough));
  print(gates::ear_gate());
  print(gates::motion_gate(pool));
  print(gates::diffraction_gate(pool));
  print(gates::thick_wall_gate(pool));
  print(gates::determinism_gate());
  return passed ? 0 : 1;
}
