#include "phases.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/kernels/phase_step.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;
using Complex = std::complex<float>;

constexpr std::size_t kValues = std::size_t{kEars} * D::kBins;
constexpr std::ptrdiff_t kHalf = D::kFrameSamples / 2;

float power_of(Complex x) { return x.real() * x.real() + x.imag() * x.imag(); }

}  // namespace

GtfPhaseFrame::GtfPhaseFrame() : turned(kValues), heard(kValues), magnitude(kValues) {}

GtfPhaseRound::GtfPhaseRound() = default;

void GtfPhaseRound::reset(std::ptrdiff_t end) {
  frames_.reset();
  recent_.fill(0.0F);
  end_ = end;
  in_ = out_ = read_ = 0;
}

bool GtfPhaseRound::take(GtfPhaseFrame& frame) {
  frames_.add(frame.turned, 1.0F);
  std::swap(frame, waiting_[static_cast<std::size_t>(in_ % std::ssize(waiting_))]);
  ++in_;
  if (in_ - out_ <= kLate) return false;
  turn(frame);
  return true;
}

bool GtfPhaseRound::drain(GtfPhaseFrame& frame) {
  if (out_ == in_) return false;
  turn(frame);
  return true;
}

/// Moves on to the 400 samples before `end`.
void GtfPhaseRound::read_samples(std::ptrdiff_t end) {
  const std::ptrdiff_t count = end - read_;
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    float* const samples = recent_.data() + ear * D::kFrameSamples;
    std::copy(samples + count, samples + D::kFrameSamples, samples);
  }
  float* const fresh = recent_.data() + D::kFrameSamples - count;
  frames_.drain(read_, count, fresh, D::kFrameSamples);
  const std::ptrdiff_t silent = std::clamp<std::ptrdiff_t>(end - end_, 0, count);
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    std::fill_n(fresh + ear * D::kFrameSamples + count - silent, silent, 0.0F);
  }
  read_ = end;
}

void GtfPhaseRound::turn(GtfPhaseFrame& frame) {
  read_samples(out_ * D::kHop + kHalf);
  std::swap(frame, waiting_[static_cast<std::size_t>(out_ % std::ssize(waiting_))]);
  ++out_;
  const std::span<const float> samples(recent_);
  for (std::size_t ear = 0; ear < kEars; ++ear) {
    frames_.transform(samples.subspan(ear * D::kFrameSamples, D::kFrameSamples), kHalf, 1.0F,
                      std::span(frame.turned).subspan(ear * D::kBins, D::kBins));
  }
  kernels::step_phases(frame.turned, frame.heard, frame.magnitude, D::kPhaseMomentum,
                       frame.power_floor);
}

void GtfPhases::reset(int rounds, std::ptrdiff_t end) {
  EARPOINT_CHECK(rounds >= 0 && rounds <= std::ssize(rounds_));
  active_ = static_cast<std::size_t>(rounds);
  for (GtfPhaseRound& round : rounds_) round.reset(end);
}

bool GtfPhases::leave_through(std::size_t first_round, std::span<Complex> spectra) {
  for (std::size_t i = first_round; i < active_; ++i) {
    if (!rounds_[i].take(frame_)) return false;
  }
  std::ranges::copy(frame_.turned, spectra.begin());
  return true;
}

bool GtfPhases::take(std::span<Complex> spectra, float scale) {
  EARPOINT_CHECK(spectra.size() == kValues);
  std::ranges::copy(spectra, frame_.turned.begin());
  std::ranges::copy(spectra, frame_.heard.begin());
  for (std::size_t i = 0; i < kValues; ++i) frame_.magnitude[i] = std::sqrt(power_of(spectra[i]));
  frame_.power_floor = gtf::kPowerFloor * scale * scale;
  return leave_through(0, spectra);
}

bool GtfPhases::drain(std::span<Complex> spectra) {
  for (std::size_t i = 0; i < active_; ++i) {
    while (rounds_[i].drain(frame_)) {
      if (leave_through(i + 1, spectra)) return true;
    }
  }
  return false;
}

}  // namespace earpoint::gtf
