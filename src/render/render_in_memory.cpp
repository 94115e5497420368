#include <earpoint/render/render_in_memory.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/render/sound_sink.h>

namespace earpoint {
namespace {

/// Keeps what is written.
class MemorySink : public SoundSink {
 public:
  explicit MemorySink(Waveform& sound) : sound_(sound) {}
  void write(const Waveform& block) override {
    EARPOINT_CHECK(written_ + block.samples() <= sound_.samples());
    for (int c = 0; c < block.channels(); ++c) {
      std::ranges::copy(block.channel(c), sound_.channel(c).begin() + written_);
    }
    written_ += block.samples();
  }
  void commit() override {}
  [[nodiscard]] int sample_rate_hz() const override { return sound_.sample_rate_hz(); }

 private:
  Waveform& sound_;
  std::ptrdiff_t written_ = 0;
};

}  // namespace

Waveform render_in_memory(const SoundInMemory& source, AcousticSynthesizer& synthesizer,
                          const EarpointPath& path, const ClipRenderOptions& options) {
  EARPOINT_CHECK(source.sound.channels() == 2 && !source.sound.empty());
  ClipReading reading;
  reading.survey.sample_rate_hz = source.sound.sample_rate_hz();
  reading.survey.samples = source.sound.samples();
  reading.sound = read_blocks(source.sound);
  reading.picture = [&source](double /*time_s*/) { return source.picture; };
  reading.speaker_box = [&source](double /*time_s*/) { return source.speaker_box; };
  reading.speaker_m = source.speaker_m;
  reading.world_from_source = source.world_from_source;
  Waveform result(2, source.sound.samples(), source.sound.sample_rate_hz());
  std::vector<std::unique_ptr<SoundSink>> sinks;
  sinks.push_back(std::make_unique<MemorySink>(result));
  SilentProgress silent;
  (void)ClipRendering(std::move(reading), synthesizer, {&path, 1}, options)
      .run(std::move(sinks), options, silent);
  return result;
}

}  // namespace earpoint
