#include <earpoint/render_files/render.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/media.h>
#include <earpoint/render/clip_rendering.h>
#include <earpoint/render_files/open_sound_sink.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

/// The movie whose picture goes with the sound; empty if there is none.
std::filesystem::path moving_picture(const RenderInput& source) {
  const std::filesystem::path path = source.picture.value_or(source.sound.path);
  return probe_media(path).kind == MediaKind::movie ? path : std::filesystem::path();
}

PictureStream pictures_for(const RenderInput& source, const AcousticSynthesizer& synthesizer) {
  const PictureUse use = synthesizer.picture_use();
  const bool by_box = source.speaker_track && !source.speaker_m;
  if (use == PictureUse::never || (use == PictureUse::with_box && !by_box)) return {};
  PictureStream pictures = open_pictures(source.picture, source.sound.path);
  if (use == PictureUse::always && pictures.empty()) {
    throw InputError(source.sound.path.string(), "this model needs a picture, and there is none",
                     "give a picture as well");
  }
  return pictures;
}

RenderOutline outline_of(const RenderInput& source, const SoundSurvey& survey,
                         std::span<const RenderTarget> targets, bool has_picture) {
  RenderOutline outline{.duration_s = survey.duration_s(),
                        .level_db = std::max(survey.level_db[0], survey.level_db[1]),
                        .has_picture = has_picture,
                        .speaker_track = source.speaker_track,
                        .speaker_m = source.speaker_m,
                        .targets = {}};
  for (const RenderTarget& target : targets) outline.targets.push_back(target.path);
  return outline;
}

std::vector<std::unique_ptr<SoundSink>> open_sinks(std::span<const RenderTarget> targets,
                                                   const RenderInput& source,
                                                   const SoundSurvey& survey, RenderAnswer answer) {
  const int channels = answer == RenderAnswer::voice ? 1 : 2;
  const std::filesystem::path movie = moving_picture(source);
  std::vector<std::unique_ptr<SoundSink>> sinks;
  for (const RenderTarget& target : targets) {
    sinks.push_back(
        open_sound_sink(target.output, survey.sample_rate_hz, movie, survey.samples, channels));
  }
  return sinks;
}

void check_outputs(std::span<const RenderTarget> targets, const RenderInput& source) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::filesystem::path& output = targets[i].output;
    for (std::size_t j = 0; j < i; ++j) {
      if (written_place(output) == written_place(targets[j].output)) {
        throw InputError(output.string(), "two earpoints would write this file",
                         "give each its own");
      }
    }
    std::error_code ignored;
    if (std::filesystem::equivalent(output, source.sound.path, ignored)) {
      throw InputError(output.string(), "is the recording itself", "write to another file");
    }
  }
}

ClipReading reading_of(const RenderInput& source, const AcousticSynthesizer& synthesizer) {
  if (synthesizer.needs_speaker_track() && !source.speaker_track) {
    throw InputError(source.sound.path.string(), "the network needs the speaker's box",
                     "give the speaker's box or a table of boxes");
  }
  ClipReading reading{.survey = source.survey ? *source.survey : survey_sound(source.sound),
                      .sound = read_blocks(source.sound),
                      .picture = {},
                      .speaker_box = {},
                      .speaker_m = source.speaker_m,
                      .world_from_source = std::nullopt};
  reading.picture = [pictures = std::make_shared<PictureStream>(pictures_for(source, synthesizer))](
                        double time_s) { return pictures->nearest(time_s); };
  reading.speaker_box = [track = source.speaker_track](double time_s) {
    return track ? std::optional<Box>(track->at(time_s)) : std::nullopt;
  };
  return reading;
}

}  // namespace

RenderReport render(const RenderInput& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress) {
  EARPOINT_CHECK(!targets.empty());
  check_outputs(targets, source);
  std::vector<EarpointPath> paths;
  for (const RenderTarget& target : targets) paths.push_back(target.path);
  ClipRendering rendering(reading_of(source, synthesizer), synthesizer, paths, options);
  std::vector<TargetStream> outputs = rendering.run(
      open_sinks(targets, source, rendering.survey(), options.answer), options, progress);
  RenderReport report{.survey = rendering.survey(),
                      .source = rendering.source_outline(),
                      .targets = {},
                      .limited_db = {},
                      .windows = static_cast<int>(rendering.windows()),
                      .model_rate_hz = rendering.model_rate_hz(),
                      .has_picture = rendering.has_picture(),
                      .warnings = {}};
  report.warnings =
      synthesizer.warnings(outline_of(source, report.survey, targets, rendering.has_picture()));
  for (TargetStream& output : outputs) {
    output.commit();
    report.targets.push_back(output.outline());
    report.limited_db.push_back(output.limited_db());
  }
  progress.finish();
  return report;
}

}  // namespace earpoint
