#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace earpoint::kernels {

/// How a convolution with taps at t-d, t, t+d computes outputs that lie d apart. The outputs
/// t, t+d, t+2d, ... share inputs, so that some of them together need fewer multiplications than
/// each alone: a short convolution along the lattice of step d, by the Toom-Cook (Winograd) way.
///
/// A scheme is three matrices: with x the inputs, w the taps and y the outputs,
///   y = to_outputs * ((from_taps * w) .* (from_inputs * x)).
/// from_taps is in lattice.cpp, the other two are in lattice-inl.h, as vector code.
/// Source: Winograd, Arithmetic Complexity of Computations (1980); Lavin and Gray, Fast Algorithms
/// for Convolutional Neural Networks (2015).
enum class Scheme {
  taps,   ///< every tap for itself; any number of taps, one output at a time
  four,   ///< F(4,3): 4 outputs of 6 inputs with 6 multiplications instead of 12
  three,  ///< a whole lattice of 3 points, zeros around it: 5 multiplications instead of 7
  two,    ///< a whole lattice of 2 points, zeros around it: 3 multiplications instead of 4
};

/// What a scheme works on at a time.
struct SchemeShape {
  std::ptrdiff_t positions;    ///< multiplications
  std::ptrdiff_t inputs;       ///< points of the lattice that are read
  std::ptrdiff_t first_input;  ///< the first of them, counted from the first output
  std::ptrdiff_t outputs;      ///< points of the lattice that are made
};

constexpr SchemeShape shape_of(Scheme scheme) {
  switch (scheme) {
    case Scheme::four:
      return {.positions = 6, .inputs = 6, .first_input = -1, .outputs = 4};
    case Scheme::three:
      return {.positions = 5, .inputs = 3, .first_input = 0, .outputs = 3};
    case Scheme::two:
      return {.positions = 3, .inputs = 2, .first_input = 0, .outputs = 2};
    case Scheme::taps:
      break;
  }
  return {.positions = 1, .inputs = 1, .first_input = 0, .outputs = 1};
}

inline constexpr std::ptrdiff_t kMostPositions = 6;
inline constexpr std::ptrdiff_t kMostOutputs = 4;

/// F(4,3) evaluates its polynomials at 0, +-kNear, +-kFar and infinity. With sqrt(1/2) and sqrt(2)
/// its rounding error is 1.4 times that of the direct sum; with 1 and 2 it would be twice.
inline constexpr double kNear = 0.70710678118654752440;
inline constexpr double kFar = 1.41421356237309504880;

/// from_taps * taps: the factors that stand for three taps.
/// @param scheme  not Scheme::taps
/// @return  the first shape_of(scheme).positions are set
[[nodiscard]] std::array<double, kMostPositions> factors_of_taps(Scheme scheme,
                                                                 std::span<const double, 3> taps);

}  // namespace earpoint::kernels
