#include "references.h"

#include <cmath>
#include <complex>

#include <earpoint/pose.h>

namespace earpoint::gates {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

// The integral of e^(-i t^2) from x on, x >= 0. Below 3 a Taylor series of the complement, above it
// the asymptotic series.
Complex fresnel_tail(double x) {
  const Complex whole = 0.5 * std::sqrt(kPi) * std::exp(-kI * kPi / 4.0);
  if (x < 3.0) {
    // Term k of the integral from 0 to x: (-i)^k x^(2k+1) / (k! (2k+1)).
    Complex term = x;
    Complex sum = 0.0;
    for (int k = 0; k < 60; ++k) {
      sum += term / (2.0 * k + 1.0);
      term *= -kI * x * x / (k + 1.0);
    }
    return whole - sum;
  }
  const Complex z = kI * x * x;
  Complex term = 1.0;
  Complex sum = 0.0;
  for (int k = 0; k < 8; ++k) {
    sum += term;
    term *= -(2.0 * k + 1.0) / (2.0 * z);
  }
  return std::exp(-z) * sum / (2.0 * kI * x);
}

Complex transition(double x) {
  const double root = std::sqrt(x);
  return 2.0 * kI * root * std::exp(kI * x) * fresnel_tail(root);
}

// One of the four terms: cotangent times transition function.
Complex term(double index, double sign, double angle, double wave_number, double length_m) {
  const double turns = std::round((angle + sign * kPi) / (2.0 * kPi * index));
  const double cosine = std::cos((2.0 * index * kPi * turns - angle) / 2.0);
  const double argument = wave_number * length_m * 2.0 * cosine * cosine;
  return transition(argument) / std::tan((kPi + sign * angle) / (2.0 * index));
}

}  // namespace

Complex wedge_pressure(double open_angle_rad, double source_angle_rad, double source_m,
                       double receiver_angle_rad, double receiver_m, double wave_number) {
  const double index = open_angle_rad / kPi;
  const double length_m = source_m * receiver_m / (source_m + receiver_m);
  const double difference = receiver_angle_rad - source_angle_rad;
  const double sum = receiver_angle_rad + source_angle_rad;
  const Complex bracket = term(index, 1.0, difference, wave_number, length_m) +
                          term(index, -1.0, difference, wave_number, length_m) +
                          term(index, 1.0, sum, wave_number, length_m) +
                          term(index, -1.0, sum, wave_number, length_m);
  const Complex coefficient =
      -std::exp(-kI * kPi / 4.0) / (2.0 * index * std::sqrt(2.0 * kPi * wave_number)) * bracket;
  const double spreading = std::sqrt(source_m / (receiver_m * (source_m + receiver_m))) / source_m;
  return coefficient * spreading * std::exp(-kI * wave_number * (source_m + receiver_m));
}

}  // namespace earpoint::gates
