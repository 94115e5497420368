#include <earpoint/render_files/sound_input.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <earpoint/media/media.h>
#include <earpoint/spatial/hrtf.h>

namespace earpoint {
namespace {

AudioReader reader_of(const SoundInput& source) {
  return AudioReader(source.path, source.binaural_channels, source.audio_stream);
}

}  // namespace

SoundSurvey survey_sound(const SoundInput& source) {
  AudioReader reader = reader_of(source);
  SoundSurvey survey =
      survey_blocks([&reader](std::ptrdiff_t samples) { return reader.read(samples); },
                    reader.sample_rate_hz(), source.path.string());
  const auto& channels = source.binaural_channels;
  const bool is_one_by_request = channels && (*channels)[0] == (*channels)[1];
  if (is_one_by_request) survey.stereo = StereoKind::plausible;
  survey.warnings = reader.warnings();
  std::string warning = warning_of(survey.stereo);
  if (!warning.empty() && !source.placement) survey.warnings.push_back(std::move(warning));
  return survey;
}

BlockReader read_blocks(const SoundInput& source) {
  struct Reading {
    AudioReader reader;
    std::optional<VoicePlacer> placer;
    bool ended = false;
  };
  auto reading = std::make_shared<Reading>(Reading{reader_of(source), {}});
  if (source.placement) {
    reading->placer.emplace(*source.placement, HrtfSet::load(reading->reader.sample_rate_hz()));
  }
  return [reading](std::ptrdiff_t samples) {
    Waveform block = reading->reader.read(samples);
    // The placer may return nothing at first; at the end it returns what it has held back.
    while (reading->placer && !reading->ended) {
      reading->ended = block.samples() == 0;
      block = reading->ended ? reading->placer->finish() : reading->placer->process(block);
      if (block.samples() > 0 || reading->ended) break;
      block = reading->reader.read(samples);
    }
    return block;
  };
}

}  // namespace earpoint
