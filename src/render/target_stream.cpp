#include <earpoint/render/target_stream.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {

TargetStream::TargetStream(std::unique_ptr<SoundSink> sink, const SoundSurvey& survey,
                           const WindowShape& shape, const ClipRenderOptions& options)
    : sink_(std::move(sink)),
      samples_(survey.samples),
      model_per_native_(static_cast<double>(shape.sample_rate_hz) / survey.sample_rate_hz),
      gain_(static_cast<float>(std::pow(10.0, options.gain_db / 20.0))),
      answer_(options.answer),
      adder_(shape.samples, shape.overlap),
      outline_(survey.sample_rate_hz) {
  if (options.limit) limiter_.emplace(2, survey.sample_rate_hz);
  if (shape.sample_rate_hz == survey.sample_rate_hz) return;
  up_ = std::make_unique<StreamResampler>(2, shape.sample_rate_hz, survey.sample_rate_hz);
  if (options.extend_band) band_extension_.emplace(shape.samples, shape.overlap);
}

void TargetStream::add_window(const Waveform& primary, const Waveform& result,
                              const Waveform& ambient, SourceStream& source) {
  if (band_extension_) band_extension_->add_window(primary, result);
  Waveform whole = result;
  if (answer_ == RenderAnswer::place) {
    std::transform(whole.planar().begin(), whole.planar().end(), ambient.planar().begin(),
                   whole.planar().begin(), std::plus<>());
  }
  write(adder_.add(whole), false, source);
}

void TargetStream::finish(SourceStream& source) {
  write(adder_.flush(), true, source);
  // The windows reach the recording's end, so that at most a sample of rounding is missing.
  const std::ptrdiff_t missing = samples_ - written_;
  EARPOINT_CHECK(missing <= 1);
  if (missing > 0) emit(Waveform(2, missing, sink_->sample_rate_hz()), source);
  if (limiter_) put(limiter_->process(Waveform(2, 0, sink_->sample_rate_hz()), true));
}

void TargetStream::write(const Waveform& block, bool last, SourceStream& source) {
  emit(up_ ? up_->process(block, last) : block, source);
}

void TargetStream::emit(const Waveform& block, SourceStream& source) {
  const std::ptrdiff_t count = std::min(block.samples(), samples_ - written_);
  if (count <= 0) return;
  Waveform output(2, count, block.sample_rate_hz());
  const Waveform high =
      band_extension_ ? source.high_band(written_, count) : Waveform(2, 0, block.sample_rate_hz());
  for (int ear = 0; ear < 2; ++ear) {
    const auto samples = output.channel(ear);
    std::copy_n(block.channel(ear).begin(), count, samples.begin());
    if (band_extension_) {
      band_extension_->add(ear, static_cast<double>(written_) * model_per_native_,
                           model_per_native_, high.channel(ear), samples);
    }
    for (float& sample : samples) sample *= gain_;
  }
  if (answer_ == RenderAnswer::voice) {
    const auto left = output.channel(0);
    std::ranges::transform(left, output.channel(1), left.begin(),
                           [](float a, float b) { return 0.5F * (a + b); });
    std::ranges::copy(left, output.channel(1).begin());
  }
  put(limiter_ ? limiter_->process(output, false) : output);
  written_ += count;
}

void TargetStream::put(const Waveform& block) {
  outline_.add(block);
  sink_->write(block);
}

}  // namespace earpoint
