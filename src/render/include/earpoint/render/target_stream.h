#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <variant>

#include <earpoint/audio/peak_limiter.h>
#include <earpoint/audio/resample.h>
#include <earpoint/plot/plot.h>
#include <earpoint/render/band_extension.h>
#include <earpoint/render/clip_options.h>
#include <earpoint/render/overlap_adder.h>
#include <earpoint/render/sound_sink.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/synthesis/synthesizer.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The way of one target's windows to its file: joined, brought back to the recording's rate, the
/// high band added, measured, written.
class TargetStream {
 public:
  TargetStream(std::unique_ptr<SoundSink> sink, const SoundSurvey& survey, const WindowShape& shape,
               const ClipRenderOptions& options);

  /// @param primary  what the synthesizer was given for this window: 2 ears, [samples]
  /// @param result   what it made of that, before ambient sound is added
  /// @param ambient  2 ears, [samples]
  void add_window(const Waveform& primary, const Waveform& result, const Waveform& ambient,
                  SourceStream& source);

  /// Writes what the last window left, to the recording's length.
  void finish(SourceStream& source);

  /// Lets the file appear under its name; after finish().
  void commit() { sink_->commit(); }

  /// Samples made so far, at the recording's rate.
  [[nodiscard]] std::ptrdiff_t written() const { return written_; }
  [[nodiscard]] const WaveformOutline& outline() const { return outline_; }
  /// By how much peaks exceeded full scale before they were limited, in decibels.
  [[nodiscard]] double limited_db() const { return limiter_ ? limiter_->excess_db() : 0.0; }

 private:
  void write(const Waveform& block, bool last, SourceStream& source);
  void emit(const Waveform& block, SourceStream& source);
  void put(const Waveform& block);

  std::unique_ptr<SoundSink> sink_;
  std::ptrdiff_t samples_;  // the recording's length
  double model_per_native_;
  float gain_;
  RenderAnswer answer_;
  OverlapAdder adder_;
  std::unique_ptr<StreamResampler> up_;          // null if the rates are equal
  std::optional<BandExtension> band_extension_;  // none if the rates are equal or not wished
  std::optional<PeakLimiter> limiter_;           // none if not wished
  WaveformOutline outline_;
  std::ptrdiff_t written_ = 0;
};

}  // namespace earpoint
