#include <earpoint/evaluate/earpoint_comparison.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render_files/render.h>
#include <earpoint/synthesis/dsp_synthesizer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

// Encoders of movies pad and trim by a frame of sound.
constexpr double kLengthTolerance_s = 0.02;
// Far below any noise; keeps the logarithm of silence finite.
constexpr double kSilence = 1e-20;

/// "in the next room" becomes "in-the-next-room".
std::string file_name(std::size_t number, const std::string& name) {
  std::string file = fmt::format("{}-", number + 1);
  for (const char c : name) {
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (is_plain) {
      file += c;
    } else if (file.back() != '-') {
      file += '-';
    }
  }
  return file;
}

SynthesizerOptions synthesizer_options(const EarpointClip& clip, int threads) {
  SynthesizerOptions options;
  options.threads = threads;
  if (clip.fov_deg) options.horizontal_fov_rad = radians_from_degrees(*clip.fov_deg);
  return options;
}

/// Where the speaker is found without being told; nothing where nobody looks.
std::optional<SpeakerTrack> found_speaker(const EarpointClip& clip,
                                          const ComparisonOptions& options,
                                          ProgressSink& progress) {
  if (options.detector == nullptr) return std::nullopt;
  RenderInput source;
  source.sound.path = clip.clip;
  const SoundSurvey survey = survey_sound(source.sound);
  const PeopleSearch search{
      .detector = options.detector,
      .horizontal_fov_rad = synthesizer_options(clip, options.threads).horizontal_fov_rad,
      .hears_direction = survey.stereo == StereoKind::plausible};
  return speaker_track(find_people(source, survey, search, progress));
}

/// What a method is told of the speaker: gtf what was found, dsp all, other networks the box.
void tell_speaker(const EarpointClip& clip, const AcousticSynthesizer& synthesizer,
                  const std::optional<SpeakerTrack>& found, RenderInput& source) {
  if (dynamic_cast<const GtfSynthesizer*>(&synthesizer) != nullptr) {
    source.speaker_track = found;
    return;
  }
  const bool is_dsp = dynamic_cast<const DspSynthesizer*>(&synthesizer) != nullptr;
  if (is_dsp && !clip.speaker_m && !clip.speaker_box) {
    throw InputError(clip.description.string(), "lacks 'speaker', which dsp needs",
                     "add it, or leave out dsp");
  }
  if (is_dsp && clip.speaker_m) {
    source.speaker_m = clip.speaker_m;
  } else if (clip.speaker_box) {
    source.speaker_track = SpeakerTrack(*clip.speaker_box);
  }
}

void render_by(const EarpointClip& clip, const ClipMethod& method,
               const std::optional<SpeakerTrack>& found, std::span<const RenderTarget> targets,
               const ComparisonOptions& options, ProgressSink& progress) {
  RenderInput source;
  source.sound.path = clip.clip;
  const auto synthesizer =
      make_synthesizer(method.model, synthesizer_options(clip, options.threads));
  tell_speaker(clip, *synthesizer, found, source);
  ClipRenderOptions render_options;
  render_options.threads = options.threads;
  render(source, *synthesizer, targets, render_options, progress);
}

std::array<double, 2> energies(const Waveform& sound) {
  std::array<double, 2> sums{};
  for (int ear = 0; ear < 2; ++ear) {
    for (const float sample : sound.channel(ear)) sums[ear] += double{sample} * sample;
  }
  return sums;
}

EarLevels levels_of(const Waveform& sound, const Waveform& source) {
  const auto db = [](double energy) { return 10.0 * std::log10(std::max(energy, kSilence)); };
  const auto [left, right] = energies(sound);
  const auto [source_left, source_right] = energies(source);
  return {.level_db = db(left + right) - db(source_left + source_right),
          .left_right_db = db(left) - db(right)};
}

/// Reads a sound at the rate of the metrics.
Waveform read_for_metrics(const fs::path& path) {
  return resample(read_sound(path), kMetricRateHz);
}

Waveform read_truth(const fs::path& path, const Waveform& source) {
  Waveform truth = read_for_metrics(path);
  if (truth.channels() != 2) {
    throw InputError(path.string(), fmt::format("expected 2 channels, found {}", truth.channels()));
  }
  const double difference_s = truth.duration_s() - source.duration_s();
  if (std::abs(difference_s) > kLengthTolerance_s) {
    throw InputError(path.string(), fmt::format("lasts {:.2f} s, the clip {:.2f} s",
                                                truth.duration_s(), source.duration_s()));
  }
  return window_of(truth, 0, source.samples());
}

nlohmann::ordered_json levels_json(const EarLevels& levels) {
  return {{"level_db", levels.level_db}, {"left_right_db", levels.left_right_db}};
}

double of(const RenderedEarpoint& rendered, Metric metric) {
  return rendered.metrics[metric].value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

EarpointComparison compare_earpoints(const EarpointClip& clip, std::span<const ClipMethod> methods,
                                     const fs::path& folder, const ComparisonOptions& options,
                                     ProgressSink& progress) {
  EarpointComparison comparison{.clip = clip,
                                .methods = {methods.begin(), methods.end()},
                                .earpoints = std::vector<EarpointResult>(clip.earpoints.size()),
                                .source = folder / "source.flac"};
  const RenderTarget as_recorded{EarpointPath(Pose{}), comparison.source};
  const std::optional<SpeakerTrack> found = found_speaker(clip, options, progress);
  render_by(clip, {"input", "input"}, found, {&as_recorded, 1}, options, progress);
  for (const ClipMethod& method : methods) {
    std::vector<RenderTarget> targets;
    for (std::size_t i = 0; i < clip.earpoints.size(); ++i) {
      const KnownEarpoint& earpoint = clip.earpoints[i];
      const fs::path sound =
          folder / fmt::format("{}-{}.flac", file_name(i, earpoint.name), method.name);
      targets.push_back({EarpointPath(earpoint.source_from_target), sound});
      comparison.earpoints[i].renderings.push_back({.sound = sound, .levels = {}, .metrics = {}});
    }
    render_by(clip, method, found, targets, options, progress);
  }
  const Waveform source = read_for_metrics(comparison.source);
  ClipMeasurer measurer(options.estimator);
  for (std::size_t i = 0; i < clip.earpoints.size(); ++i) {
    const Waveform truth = read_truth(clip.earpoints[i].truth, source);
    EarpointResult& result = comparison.earpoints[i];
    result.truth = levels_of(truth, source);
    measurer.set_target(truth, nullptr);
    for (RenderedEarpoint& rendered : result.renderings) {
      const Waveform sound = window_of(read_for_metrics(rendered.sound), 0, source.samples());
      rendered.levels = levels_of(sound, source);
      rendered.metrics = measurer.measure(sound);
    }
  }
  return comparison;
}

std::string text_of(const EarpointComparison& comparison) {
  constexpr int kColumn = 7;
  const int group = kColumn * static_cast<int>(comparison.methods.size());
  std::size_t widest = std::string_view("earpoint").size();
  for (const KnownEarpoint& earpoint : comparison.clip.earpoints) {
    widest = std::max(widest, earpoint.name.size());
  }
  std::string text = fmt::format("{:<{}}  {:>15} {:>{}} {:>{}} {:>{}}\n", "", widest, "truly there",
                                 "error of level, dB", group + 3, "of left-right, dB", group + 3,
                                 "Mag", group + 3);
  text += fmt::format("{:<{}}  {:>6} {:>8}", "earpoint", widest, "level", "lt-rt");
  for (int metric = 0; metric < 3; ++metric) {
    text += "   ";
    for (const ClipMethod& method : comparison.methods) {
      text += fmt::format("{:>{}}", method.name, kColumn);
    }
  }
  text += '\n';
  for (std::size_t i = 0; i < comparison.earpoints.size(); ++i) {
    const EarpointResult& result = comparison.earpoints[i];
    text += fmt::format("{:<{}}  {:>+6.1f} {:>+8.1f}", comparison.clip.earpoints[i].name, widest,
                        result.truth.level_db, result.truth.left_right_db);
    for (const auto& [metric, decimals] :
         {std::pair{Metric::level, 1}, {Metric::lre, 1}, {Metric::mag, 3}}) {
      text += "   ";
      for (const RenderedEarpoint& rendered : result.renderings) {
        text += fmt::format("{:>{}.{}f}", of(rendered, metric), kColumn, decimals);
      }
    }
    text += '\n';
  }
  return text;
}

std::string json_of(const EarpointComparison& comparison) {
  nlohmann::ordered_json json;
  json["clip"] = comparison.clip.clip.string();
  json["earpoints"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < comparison.earpoints.size(); ++i) {
    const KnownEarpoint& known = comparison.clip.earpoints[i];
    const EarpointResult& result = comparison.earpoints[i];
    const Vector3& at = known.source_from_target.position_m;
    nlohmann::ordered_json row{{"name", known.name},
                               {"translate", {at.x, at.y, at.z}},
                               {"yaw_deg", known.yaw_deg},
                               {"truth", levels_json(result.truth)},
                               {"methods", nlohmann::ordered_json::array()}};
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      const RenderedEarpoint& rendered = result.renderings[m];
      nlohmann::ordered_json entry{{"method", comparison.methods[m].name},
                                   {"heard", levels_json(rendered.levels)}};
      for (const Metric metric : all_metrics()) {
        if (rendered.metrics[metric]) {
          entry["errors"][std::string(name_of(metric).key)] = *rendered.metrics[metric];
        }
      }
      row["methods"].push_back(std::move(entry));
    }
    json["earpoints"].push_back(std::move(row));
  }
  return json.dump(2) + "\n";
}

}  // namespace earpoint
