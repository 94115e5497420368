#include <algorithm>
#include <memory>

#include <earpoint/core/error.h>
#include <earpoint/synth/picture_stream.h>
#include <earpoint/synth/render.h>
#include <earpoint/synth/sound_sink.h>
#include <earpoint/synth/target_stream.h>
#include <earpoint/video/media.h>

namespace earpoint {
namespace {

/// The movie whose picture goes with the sound; empty if there is none.
std::filesystem::path moving_picture(const RenderSource& source) {
  const std::filesystem::path path = source.picture.value_or(source.sound.path);
  return probe_media(path).kind == MediaKind::movie ? path : std::filesystem::path();
}

PictureStream open_picture(const RenderSource& source, const AcousticSynthesizer& synthesizer,
                           const std::filesystem::path& movie) {
  const PictureUse use = synthesizer.picture_use();
  const bool by_box = source.speaker_track && !source.speaker_m;
  if (use == PictureUse::never || (use == PictureUse::with_box && !by_box)) return {};
  if (source.picture) return PictureStream(*source.picture);
  if (!movie.empty()) return PictureStream(movie);
  if (use != PictureUse::always) return {};
  throw InputError(source.sound.path.string(),
                   "this model looks at the scene, and here is no picture",
                   "give a picture before the sound: earpoint render frame.png sound.flac");
}

RenderOutline outline_of(const RenderSource& source, const SoundSurvey& survey,
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

std::ptrdiff_t count_windows(std::ptrdiff_t samples, const WindowShape& shape) {
  const std::ptrdiff_t hop = shape.samples - shape.overlap;
  // The joined windows must reach the end; a tail that the last overlap covers needs no window.
  return std::max<std::ptrdiff_t>(1, (samples - shape.overlap + hop - 1) / hop);
}

Waveform without_context(const Waveform& sound, const WindowShape& shape) {
  Waveform middle(sound.channels(), shape.samples, sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin() + shape.context, shape.samples, middle.channel(c).begin());
  }
  return middle;
}

std::vector<TargetStream> open_targets(std::span<const RenderTarget> targets,
                                       const SoundSurvey& survey, const WindowShape& shape,
                                       const ClipRenderOptions& options,
                                       const std::filesystem::path& movie) {
  std::vector<TargetStream> streams;
  for (const RenderTarget& target : targets) {
    streams.emplace_back(open_sound_sink(target.output, survey.sample_rate_hz, movie), survey,
                         shape, options.extend_band, options.gain_db);
  }
  return streams;
}

/// What the synthesizer makes of the window that it observed last, which starts at sample `start`.
Waveform synthesize(AcousticSynthesizer& synthesizer, const EarpointPath& path,
                    const WindowShape& shape, std::ptrdiff_t start) {
  const auto pose_at = [&](std::ptrdiff_t sample) {
    return path.at(static_cast<double>(start + sample) / shape.sample_rate_hz);
  };
  if (!path.is_moving() || shape.pose_step == 0) {
    return synthesizer.synthesize(pose_at(shape.samples / 2));
  }
  std::vector<Pose> poses;
  for (std::ptrdiff_t sample = 0; sample <= shape.samples; sample += shape.pose_step) {
    poses.push_back(pose_at(sample));
  }
  return synthesizer.synthesize_along(poses);
}

void check_targets(std::span<const RenderTarget> targets, const RenderSource& source,
                   double duration_s) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].path.check_covers(duration_s);
    const std::filesystem::path& output = targets[i].output;
    for (std::size_t j = 0; j < i; ++j) {
      if (std::filesystem::weakly_canonical(output) ==
          std::filesystem::weakly_canonical(targets[j].output)) {
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

}  // namespace

RenderReport render(const RenderSource& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress) {
  EARPOINT_CHECK(!targets.empty());
  const SoundSurvey survey = survey_sound(source.sound);
  check_targets(targets, source, survey.duration_s());

  const std::filesystem::path movie = moving_picture(source);
  PictureStream picture = open_picture(source, synthesizer, movie);
  const WindowShape shape = synthesizer.window_shape(survey.sample_rate_hz);
  SourceStream stream(source.sound, survey, shape.sample_rate_hz,
                      options.ambient_cutoff_hz.value_or(synthesizer.ambient_cutoff_hz()));
  std::vector<TargetStream> outputs = open_targets(targets, survey, shape, options, movie);

  const std::ptrdiff_t windows = count_windows(stream.model_samples(), shape);
  const std::ptrdiff_t hop = shape.samples - shape.overlap;
  bool has_picture = false;
  progress.begin("rendering", survey.duration_s(), "s");
  for (std::ptrdiff_t index = 0; index < windows; ++index) {
    const std::ptrdiff_t start = index * hop;
    const double middle_s = (static_cast<double>(start) + static_cast<double>(shape.samples) / 2) /
                            shape.sample_rate_hz;
    SourceStream::Window window = stream.window(start, shape.samples, shape.context);

    Observation observation;
    observation.sound = std::move(window.primary);
    observation.picture = picture.nearest(middle_s);
    has_picture |= observation.picture != nullptr;
    if (source.speaker_track) observation.speaker_box = source.speaker_track->at(middle_s);
    observation.speaker_m = source.speaker_m;
    synthesizer.observe(observation);

    const Waveform primary = without_context(observation.sound, shape);
    std::ptrdiff_t needed = survey.samples;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const Waveform result = synthesize(synthesizer, targets[i].path, shape, start);
      outputs[i].add_window(primary, result, window.ambient, stream);
      needed = std::min(needed, outputs[i].written());
    }
    stream.drop_high_band_before(needed);
    // The last window takes its overlap along.
    const std::ptrdiff_t rest = stream.model_samples() - start;
    progress.advance(static_cast<double>(index + 1 < windows ? hop : rest) / shape.sample_rate_hz);
  }
  for (TargetStream& output : outputs) output.finish(stream);
  RenderReport report{survey, stream.outline(), {}, static_cast<int>(windows), {}};
  report.doubts = synthesizer.doubts(outline_of(source, survey, targets, has_picture));
  for (TargetStream& output : outputs) {
    output.commit();
    report.targets.push_back(output.outline());
  }
  progress.finish();
  return report;
}

}  // namespace earpoint
