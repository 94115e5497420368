#pragma once

#include <memory>
#include <span>

#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Puts mono sound at a place around the head, which may move: block by block, without clicks.
///
/// Each block is filtered by the interpolated HRTF of the place where it began and of the one
/// where it ends, each with its distance gain, and faded from one to the other along the block. The
/// output comes `delay_samples()` after the sound would pass the middle of the head.
/// One object per stream.
class BinauralPanner {
 public:
  /// @param block_size  > 0; a moving source's filters are renewed once per block: 5 to 20 ms
  BinauralPanner(const HrtfSet& hrtf, int block_size);
  ~BinauralPanner();
  BinauralPanner(BinauralPanner&&) noexcept;
  BinauralPanner& operator=(BinauralPanner&&) noexcept;

  [[nodiscard]] int block_size() const;
  /// The set's centre delay, rounded to samples.
  [[nodiscard]] int delay_samples() const;

  /// @param mono    the next samples, shape [block_size]
  /// @param source  where the source is at the block's end, in the head's frame; distance > 0.
  ///                The first block stays there throughout.
  /// @param left    output, shape [block_size]; as `right`
  void process(std::span<const float> mono, const Spherical& source, std::span<float> left,
               std::span<float> right);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A whole mono sound at one place.
/// @param mono  shape [samples], at the set's rate
/// @return  shape [2][samples]; in step with the sound at the head's middle, to half a sample
[[nodiscard]] Waveform pan_binaural(std::span<const float> mono, const HrtfSet& hrtf,
                                    const Spherical& source);

}  // namespace earpoint
