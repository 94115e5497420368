#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <variant>

#include <earpoint/audio/resample.h>
#include <earpoint/core/waveform.h>
#include <earpoint/synth/band_extension.h>
#include <earpoint/synth/overlap_adder.h>
#include <earpoint/synth/sound_sink.h>
#include <earpoint/synth/source_stream.h>
#include <earpoint/synth/synthesizer.h>
#include <earpoint/video/plot.h>

namespace earpoint {

/// The way of one target's windows to its file: joined, brought back to the recording's rate, the
/// high band added, measured, written.
class TargetStream {
 public:
  /// @param extend_band  add the source's high band, scaled by the model's top octave
  TargetStream(std::unique_ptr<SoundSink> sink, const SoundSurvey& survey, const WindowShape& shape,
               bool extend_band, double gain_db);

  /// @param primary  what the synthesizer was given for this window: 2 ears, [samples]
  /// @param result   what it made of that, before ambient sound is added
  /// @param ambient  2 ears, [samples]
  void add_window(const Waveform& primary, const Waveform& result, const Waveform& ambient,
                  SourceStream& source);

  /// Writes what the last window left, to the recording's length.
  void finish(SourceStream& source);

  /// Lets the file appear under its name; after finish().
  void commit() { sink_->commit(); }

  /// Samples written so far, at the recording's rate.
  [[nodiscard]] std::ptrdiff_t written() const { return written_; }
  [[nodiscard]] const WaveformOutline& outline() const { return outline_; }

 private:
  void write(const Waveform& block, bool last, SourceStream& source);
  void emit(const Waveform& block, SourceStream& source);

  std::unique_ptr<SoundSink> sink_;
  std::ptrdiff_t samples_;  // the recording's length
  double model_per_native_;
  float gain_;
  OverlapAdder adder_;
  std::unique_ptr<StreamResampler> up_;          // null if the rates are equal
  std::optional<BandExtension> band_extension_;  // none if the rates are equal or not wished
  WaveformOutline outline_;
  std::ptrdiff_t written_ = 0;
};

}  // namespace earpoint
