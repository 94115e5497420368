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

/// Consecutive samples that are consecutive in a ring too.
struct Stretch {
  std::ptrdiff_t offset;  ///< of the first one, from the beginning of all
  std::ptrdiff_t at;      ///< of the first one, in the ring
  std::ptrdiff_t count;
};

/// Calls body for each of the stretches that the samples from `first` on take in a ring.
template <typename Body>
void for_stretches(std::ptrdiff_t ring_size, std::ptrdiff_t first, std::ptrdiff_t count,
                   const Body& body) {
  for (std::ptrdiff_t offset = 0; offset < count;) {
    const std::ptrdiff_t at = (first + offset) % ring_size;
    const std::ptrdiff_t part = std::min(count - offset, ring_size - at);
    body(Stretch{offset, at, part});
    offset += part;
  }
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
    float* const ring = ring_.data() + e * size_;
    for_stretches(size_, first + begin, D::kFrameSamples - begin, [&](Stretch part) {
      const float* const window = window_.data() + begin + part.offset;
      const float* const frame = frame_.data() + kPad + begin + part.offset;
      for (std::ptrdiff_t i = 0; i < part.count; ++i) {
        ring[part.at + i] += frame[i] * window[i] * scale;
      }
    });
  }
  for_stretches(size_, first + begin, D::kFrameSamples - begin, [&](Stretch part) {
    const float* const window = window_.data() + begin + part.offset;
    for (std::ptrdiff_t i = 0; i < part.count; ++i) weight_[part.at + i] += window[i] * window[i];
  });
  ++frames_;
}

std::ptrdiff_t GtfFrames::finished_samples() const { return frames_ * D::kHop - kHalf; }

void GtfFrames::drain(std::ptrdiff_t start, std::ptrdiff_t count, float* output,
                      std::ptrdiff_t stride) {
  for_stretches(size_, start, count, [&](Stretch part) {
    float* const weight = weight_.data() + part.at;
    for (int e = 0; e < kEars; ++e) {
      float* const sum = ring_.data() + e * size_ + part.at;
      float* const out = output + e * stride + part.offset;
      // Where there is no weight, there is no sound.
      for (std::ptrdiff_t i = 0; i < part.count; ++i) out[i] = sum[i] / std::max(weight[i], 1e-9F);
      std::fill_n(sum, part.count, 0.0F);
    }
    std::fill_n(weight, part.count, 0.0F);
  });
}

}  // namespace earpoint::gtf
