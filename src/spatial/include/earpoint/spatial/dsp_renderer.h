#pragma once

#include <array>
#include <memory>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The gain of distance that the paper's DSP baseline uses: 0.2 / max(0.2, distance_m), that is
/// 1/r, one at 0.2 m and nearer.
[[nodiscard]] double distance_gain(double distance_m);

/// One filter per ear; the sum of the filtered ears is the estimate of a source's sound.
struct SourceFilter {
  std::array<std::vector<float>, 2> taps;  ///< [ear][taps]
  /// The estimate comes this much after the sound at the head's middle.
  int delay_samples = 0;
};

/// Estimates the sound of a single source, as an omnidirectional microphone in the place of the
/// head's middle would hear it, from both ears: the least-squares solution
///   S = sum_e conj(H_e) X_e / (sum_e |H_e|^2 + w)
/// whose weight falls on whichever ear hears the source better. The regularisation w is a share of
/// the mean of sum |H|^2 over frequency: -30 dB up to 5 kHz, rising to -20 dB at 10 kHz, where
/// both ears may have a notch, and to 0 dB from 14 to 19 kHz. The filters are 80 ms long with half
/// of that as delay, so nothing folds back; -48 dB of their energy would lie beyond.
///
/// The paper's baseline averages the ears' own inverses instead (released_dsp.h). The shadowed ear
/// then counts as much as the near one: with KEMAR and a speaker at 60 degrees the ears' own noise
/// comes out 11 dB stronger than here (100 Hz to 7 kHz). See docs/adr/0006-hrtf-and-dsp.md.
///
/// @param direction  to the source, in the head's frame; not zero
[[nodiscard]] SourceFilter source_filter(const HrtfSet& hrtf, const Vector3& direction);

/// Two ears in, two ears out, as FIR filters: out[t] = sum_s taps[t][s] * in[s].
struct EarFilterMatrix {
  /// [target ear][source ear][tap]; all four have the same length.
  std::array<std::array<std::vector<float>, 2>, 2> taps;
  /// The output comes this much late: drop as many samples from its begin to stay in step.
  int delay_samples = 0;
};

/// The DSP rendering of one speaker for another pair of ears: the speaker's sound estimated as by
/// source_filter, the ratio of the distance gains, and the HRTF towards the target. The room is
/// taken along as if it came from the speaker. The change of travel time is left out: sound stays
/// in step with the picture. Lengths and delay depend on the sampling rate alone, so matrices of
/// successive windows can be cross-faded.
///
/// @param speaker_from_source  the speaker in the frame of the ears that recorded
/// @param speaker_from_target  the speaker in the frame of the ears to render
/// @throws std::logic_error if a distance is not > 0
[[nodiscard]] EarFilterMatrix dsp_filters(const HrtfSet& hrtf, const Spherical& speaker_from_source,
                                          const Spherical& speaker_from_target);

/// The same for a speaker's place; one nearer than a centimetre, whose direction means nothing, is
/// straight ahead.
/// @param speaker_m  in the source's frame
[[nodiscard]] EarFilterMatrix dsp_filters(const HrtfSet& hrtf, const Vector3& speaker_m,
                                          const Pose& source_from_target);

/// dsp_filters() again and again without allocating, for the audio thread: cost 1 to 3 ms at 48
/// kHz. An object holds its own work space: use one per thread.
class DspFilterDesigner {
 public:
  explicit DspFilterDesigner(const HrtfSet& hrtf);
  ~DspFilterDesigner();
  DspFilterDesigner(DspFilterDesigner&&) noexcept;
  DspFilterDesigner& operator=(DspFilterDesigner&&) noexcept;

  /// Length of every filter, and how late they are: EarFilterMatrix.
  [[nodiscard]] int taps() const;
  [[nodiscard]] int delay_samples() const;

  /// @param matrix  gets the filters; allocates only if its taps are not taps() long yet
  /// @throws std::logic_error as dsp_filters()
  void design(const Spherical& speaker_from_source, const Spherical& speaker_from_target,
              EarFilterMatrix& matrix);
  void design(const Vector3& speaker_m, const Pose& source_from_target, EarFilterMatrix& matrix);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Filters a whole sound and takes the delay off.
/// @param binaural  shape [2][samples]
/// @return  the same shape and rate
[[nodiscard]] Waveform apply_filters(const EarFilterMatrix& filters, const Waveform& binaural);

}  // namespace earpoint
