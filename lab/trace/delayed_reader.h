#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace earpoint {

/// Reads a signal between its samples, where it holds nothing above half of its Nyquist frequency:
/// a sinc over 16 samples under a Kaiser window. Error: below -80 dB.
class DelayedReader {
 public:
  DelayedReader();

  /// @param position  in samples; zero outside of the signal
  [[nodiscard]] float at(std::span<const float> signal, double position) const;

 private:
  std::span<const float> kernel_;  // [phase][tap], the same for all
};

/// A quantity at evenly spaced times, read in between by a cubic through four neighbours
/// (Catmull and Rom): continuous, with a continuous slope.
class SmoothCurve {
 public:
  /// @param values  four or more; the first and the last lie outside of what is read
  SmoothCurve(double first_time_s, double step_s, std::vector<double> values)
      : first_time_s_(first_time_s), step_s_(step_s), values_(std::move(values)) {}

  [[nodiscard]] double at(double time_s) const;
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  double first_time_s_;
  double step_s_;
  std::vector<double> values_;
};

}  // namespace earpoint
