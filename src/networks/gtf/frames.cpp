#include "frames.h"

#include <algorithm>
#include <cmath>

#include <earpoint/core/ears.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;
using Complex = std::complex<float>;

constexpr std::ptrdiff_t kHalf = D::kFrameSamples / 2;
constexpr std::ptrdiff_t kPad = (D::kFftSize - D::kFrameSamples) / 2;

std::array<float, D::kFrameSamples> hamming() {
  std::array<float, D::kFrameSamples> window{};
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double turn = static_cast<double>(i) / static_cast<double>(window.size());
    window[i] = static_cast<float>(0.54 - 0.46 * std::cos(2.0 * kPi * turn));
  }
  return window;
}

}  // namespace

GtfFrames::GtfFrames(std::ptrdiff_t most_frames)
    : window_(hamming()),
      size_((most_frames + 1) * D::kHop + D::kFrameSamples),
      ring_(static_cast<std::size_t>(kEars * size_)),
      weight_(static_cast<std::size_t>(size_)) {}

void GtfFrames::reset() {
  frames_ = 0;
  std::ranges::fill(ring_, 0.0F);
  std::ranges::fill(weight_, 0.0F);
}

void GtfFrames::transform(std::span<const float> sound, std::ptrdiff_t centre, float scale,
                          std::span<Complex> spectrum) {
  std::ranges::fill(frame_, 0.0F);
  const std::ptrdiff_t first = centre - kHalf;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -first);
  const std::ptrdiff_t end = std::min<std::ptrdiff_t>(D::kFrameSamples, std::ssize(sound) - first);
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    frame_[kPad + i] = sound[first + i] * scale * window_[i];
  }
  fft_.forward(frame_, spectrum);
}

void GtfFrames::add(std::span<const Complex> spectra, float scale) {
  EARPOINT_CHECK(spectra.size() == std::size_t{kEars} * D::kBins);
  const std::ptrdiff_t first = frames_ * D::kHop - kHalf;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -first);
  for (int e = 0; e < kEars; ++e) {
    fft_.inverse(spectra.subspan(static_cast<std::size_t>(e) * D::kBins, D::kBins), frame_);
    for (std::ptrdiff_t i = begin; i < D::kFrameSamples; ++i) {
      ring_[e * size_ + (first + i) % size_] += frame_[kPad + i] * window_[i] * scale;
    }
  }
  for (std::ptrdiff_t i = begin; i < D::kFrameSamples; ++i) {
    weight_[(first + i) % size_] += window_[i] * window_[i];
  }
  ++frames_;
}

std::ptrdiff_t GtfFrames::finished_samples() const { return frames_ * D::kHop - kHalf; }

void GtfFrames::drain(std::ptrdiff_t start, std::ptrdiff_t count, float* output,
                      std::ptrdiff_t stride) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t at = (start + i) % size_;
    const float weight = weight_[at];
    for (int e = 0; e < kEars; ++e) {
      float& sum = ring_[e * size_ + at];
      output[e * stride + i] = weight > 0.0F ? sum / weight : 0.0F;
      sum = 0.0F;
    }
    weight_[at] = 0.0F;
  }
}

}  // namespace earpoint::gtf
