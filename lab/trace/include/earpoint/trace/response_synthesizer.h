#pragma once

#include <cstdint>
#include <memory>

#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/tracer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// What a response is rendered into.
struct RenderOptions {
  int sample_rate_hz = 16000;  ///< > 0
  double duration_s = 1.0;     ///< > 0; later sound is cut off
  std::uint64_t seed = 1;      ///< of the late field's noise
};

/// Makes impulse responses of traced sound. The delay of the way is kept: a source 3.43 m away
/// starts after 10 ms. A level of 1 is that of the source at 1 m in free field.
///
/// Arrivals are band-limited pulses at their exact (fractional) sample; the top 8 % below the
/// Nyquist frequency fade out, so that they do not ring on. The late field is noise whose energy
/// follows the histogram in every band. Up to 6 ms before the first sound all samples are zero.
/// Holds tables for one rate and duration: make one and keep it. Const calls may be made from many
/// threads at once.
class ResponseSynthesizer {
 public:
  /// @throws std::logic_error if an option is out of range
  explicit ResponseSynthesizer(const RenderOptions& options);
  ~ResponseSynthesizer();
  ResponseSynthesizer(ResponseSynthesizer&&) noexcept;
  ResponseSynthesizer& operator=(ResponseSynthesizer&&) noexcept;

  /// The response of an omnidirectional microphone at the listener.
  /// @param stream  names the noise: other numbers give other noise of the same energy
  /// @return  one channel
  [[nodiscard]] Waveform mono(const PointResponse& response, std::uint64_t stream) const;

  /// The response at two ears: the binaural room impulse response (BRIR).
  /// @param world_from_listener  the head's turn
  /// @param hrtf                 at the synthesizer's sampling rate
  /// @param stream               as for mono()
  /// @return  two channels, left first
  [[nodiscard]] Waveform binaural(const PointResponse& response,
                                  const Quaternion& world_from_listener, const HrtfSet& hrtf,
                                  std::uint64_t stream) const;

  /// The response of an ambisonic microphone, in the channel order ACN and the norm N3D: arrivals
  /// from their exact directions, the late field from the middles of its sectors.
  /// @param world_from_listener  how the microphone is turned
  /// @param order                0 to 7
  /// @param stream               as for mono()
  /// @return  (order + 1)^2 channels
  /// @throws std::logic_error if the order is out of range
  [[nodiscard]] Waveform ambisonic(const PointResponse& response,
                                   const Quaternion& world_from_listener, int order,
                                   std::uint64_t stream) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace earpoint
