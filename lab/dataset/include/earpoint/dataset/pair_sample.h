#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/dataset/soundspaces.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// Samples of a window at 16 kHz, where none is named: one second, as the released loaders cut it.
inline constexpr std::ptrdiff_t kPairSamples = 16000;

/// One moment at two viewpoints, with all that a method may know of it.
struct PairSample {
  Waveform source;  ///< 2 ears, 16 kHz: the high-passed speech as the source view hears it, the
                    ///< response's delay dropped as the released loader does
  Waveform target;  ///< the same at the target
  Waveform dry;     ///< 1 channel: the high-passed speech in the same window, for supervision
  std::optional<Waveform> ambient;  ///< taken out of the source: both together are what it heard;
                                    ///< nothing where nothing was. See ambient.h
  std::optional<Waveform> clean;  ///< the source without ambient sound, where the source's own was
                                  ///< found by separation; methods do not see it
  std::shared_ptr<const Image> picture;   ///< of the source view, RGB; shared
  double horizontal_fov_rad = 0.5 * kPi;  ///< of the picture; the published layouts do not have it
  std::optional<Box> speaker_box;         ///< in the picture; nothing when out of sight
  Pose source_from_target;                ///< our frame
  Vector3 speaker_m;                      ///< mouth, source view's frame
  std::optional<double> speaker_yaw_rad;  ///< where the speaker looks, about z, in the source
                                          ///< view's frame: 0 looks as the source does
  Pose world_from_source;  ///< where the source stands in the scene, for methods that know it
  /// Samples of source, clean source and ambient before the window that target and dry are of.
  std::ptrdiff_t context = 0;
};

/// The sample without what its source holds before the window.
[[nodiscard]] PairSample without_context(PairSample sample);

/// What only the simulator knows; for oracles and supervision. The samples that
/// PairSampler::sample() gives are those of convolve(dry, response) from `lead` on.
struct PairTruth {
  Waveform dry;              ///< 1 channel, [lead + window]: the high-passed speech up to the
                             ///< window's end, zeros before its beginning and after its end
  std::ptrdiff_t lead = 0;   ///< samples before the window: the longer response's, less one
  Waveform source_response;  ///< 2 ears, 16 kHz, its delay dropped
  Waveform target_response;
};

/// What becomes of the time that sound travels to the two viewpoints.
enum class ResponseDelays {
  dropped,   ///< both begin with the sound, as the released loader has it
  relative,  ///< the nearer one does, the other as much later as it is farther
};

/// Whose sound is the target.
enum class PairTarget {
  viewpoint,  ///< what the target viewpoint's ears hear
  /// What a microphone close before the mouth records, for enhancement of speech: the dry speech,
  /// alike in both channels. It is as loud as speech without a room is 1 m in front of the mouth
  /// (0.3 m before it speech is 10.5 dB louder, and the microphone turned down by as much), and
  /// begins when the source hears it first: at the first sample of the source's response within
  /// 20 dB of the largest. Samples have the source's own pose for the target's, which tells nothing
  /// of where the speaker is. Delays are those of the source's response, always dropped.
  near_microphone,
};

/// Makes samples of a data set fast: it keeps filtered speech, responses and decoded pictures, and
/// convolves only what the window hears. Any thread may call it.
/// Cost: about 4 ms a sample with responses of a second, once its files are kept.
class PairSampler {
 public:
  /// @param dataset      must outlive this
  /// @param cache_bytes  how much it may keep
  PairSampler(const SoundSpacesDataset& dataset, std::size_t cache_bytes,
              ResponseDelays delays = ResponseDelays::dropped,
              PairTarget target = PairTarget::viewpoint);
  ~PairSampler();
  PairSampler(PairSampler&&) noexcept;
  PairSampler& operator=(PairSampler&&) noexcept;

  /// With delays dropped, source and target are those of SoundSpacesDataset::sample() for the same
  /// choice, but for rounding.
  /// @param samples  length of the window, > 0
  /// @param context  how much sound before the window the source holds too (PairSample::context);
  ///                 silence where it reaches before the speech
  /// @throws InputError naming the file if one is missing, malformed, empty, holds NaN, has another
  ///         number of channels or a rate below 16 kHz; or the clip, if it lacks what the choice
  ///         asks for
  [[nodiscard]] PairSample sample(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                                  std::ptrdiff_t samples = kPairSamples,
                                  std::ptrdiff_t context = 0) const;

  /// @throws InputError as sample()
  [[nodiscard]] PairTruth truth(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                                std::ptrdiff_t samples = kPairSamples) const;

  /// The picture of one of the clip's viewpoints. @throws InputError as sample()
  [[nodiscard]] std::shared_ptr<const Image> picture(const SoundSpacesClip& clip,
                                                     int viewpoint) const;

  /// How long a speaker's speech is, at 16 kHz. @throws InputError as sample()
  [[nodiscard]] std::ptrdiff_t speech_samples(const SoundSpacesSpeaker& speaker) const;

 private:
  /// From sample `start` of the speech, which may be negative.
  [[nodiscard]] PairTruth truth(const SoundSpacesClip& clip, const SoundSpacesChoice& choice,
                                std::ptrdiff_t start, std::ptrdiff_t samples) const;

  struct State;
  std::unique_ptr<State> state_;
};

/// The sample as a mirror shows it: left and right change places in sounds, picture and poses.
/// Heads are nearly symmetric, so it could have been heard.
PairSample mirrored(const PairSample& sample);

}  // namespace earpoint
