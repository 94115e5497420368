#include <earpoint/renderer.h>

#include "stream_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/network/model_names.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render/render_in_memory.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/render/stream_rates.h>
#include <earpoint/render/voice_placer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {
namespace {

constexpr double kNarrowestView_rad = radians_from_degrees(10.0);
constexpr double kWidestView_rad = radians_from_degrees(170.0);
constexpr double kMostGain_db = 100.0;

/// What a caller's sound is called in messages.
constexpr const char* kSound = "sound";

EarpointPath path_of(const RenderRequest& request) {
  if (request.path.empty()) {
    check_pose(request.target, "target");
    return EarpointPath(request.target);
  }
  std::vector<EarpointPath::Row> rows;
  for (const PathPoint& point : request.path) {
    rows.push_back({point.time_s, point.source_from_target});
  }
  return EarpointPath(std::move(rows));
}

SpeakerTrack::PictureSize picture_size(const RenderRequest& request) {
  if (request.picture == nullptr) return {};
  return std::array{request.picture->width(), request.picture->height()};
}

std::optional<SpeakerTrack> track_of(const RenderRequest& request) {
  if (!request.speaker_box) return std::nullopt;
  return SpeakerTrack(*request.speaker_box, picture_size(request));
}

/// Duplicates a single channel; two channels stay as they are.
Waveform both_ears(const Waveform& sound) {
  EARPOINT_CHECK(sound.channels() == 1 || sound.channels() == 2);
  if (sound.channels() == 2) return sound;
  Waveform ears(2, sound.samples(), sound.sample_rate_hz());
  for (int ear = 0; ear < 2; ++ear) std::ranges::copy(sound.channel(0), ears.channel(ear).begin());
  return ears;
}

/// Pans a mono voice to the speaker's position, if that is known.
Waveform place_voice(Waveform ears, const RenderRequest& request, double horizontal_fov_rad) {
  std::optional<VoicePlacement> placement;
  if (request.speaker_m) {
    placement = placed_at(*request.speaker_m, StereoKind::same);
  } else if (const auto track = track_of(request)) {
    placement = placed_at(*track, StereoKind::same, horizontal_fov_rad, picture_size(request));
  }
  if (!placement) return ears;
  VoicePlacer placer(std::move(*placement), HrtfSet::load(ears.sample_rate_hz()));
  Waveform placed(2, ears.samples(), ears.sample_rate_hz());
  std::ptrdiff_t done = 0;
  for (const Waveform& part : {placer.process(ears), placer.finish()}) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(part.channel(ear), placed.channel(ear).begin() + done);
    }
    done += part.samples();
  }
  EARPOINT_CHECK(done == placed.samples());
  return placed;
}

SoundSurvey survey_of(const Waveform& ears) {
  return survey_blocks(read_blocks(ears), ears.sample_rate_hz(), kSound);
}

void check_options(const RendererOptions& options) {
  EARPOINT_CHECK(options.threads > 0);
  if (options.texture && !(*options.texture >= 0.0 && *options.texture <= 1.0)) {
    throw InputError("texture", fmt::format("expected 0 to 1, found {:g}", *options.texture));
  }
  if (options.horizontal_fov_rad >= kNarrowestView_rad &&
      options.horizontal_fov_rad <= kWidestView_rad) {
    return;
  }
  throw InputError("field of view",
                   fmt::format("expected 10 to 170 degrees, found {:.3g}",
                               degrees_from_radians(options.horizontal_fov_rad)),
                   "give it in radians");
}

void check_rounds(const std::optional<int>& rounds, int most) {
  if (!rounds || (*rounds >= 0 && *rounds <= most)) return;
  throw InputError("phase rounds", fmt::format("expected 0 to {}, found {}", most, *rounds));
}

RenderStream gtf_stream(const GtfWeights& weights, const RendererOptions& renderer,
                        const StreamOptions& options) {
  check_rounds(options.phase_rounds, weights.description.phase_rounds);
  RenderStream::Options how;
  how.sample_rate_hz = options.sample_rate_hz;
  how.horizontal_fov_rad = renderer.horizontal_fov_rad;
  how.extend_band = options.extend_band;
  how.limit = options.limit;
  how.phase_rounds = options.phase_rounds;
  how.texture = renderer.texture;
  return RenderStream(weights, how);
}

DspStream dsp_stream(const RendererOptions& renderer, const StreamOptions& options) {
  check_stream_rate(options.sample_rate_hz);
  check_rounds(options.phase_rounds, 0);
  const HrtfSet head = renderer.hrtf ? HrtfSet::load(*renderer.hrtf, options.sample_rate_hz)
                                     : HrtfSet::load(options.sample_rate_hz);
  return DspStream(head,
                   {.horizontal_fov_rad = renderer.horizontal_fov_rad, .limit = options.limit});
}

}  // namespace

struct Renderer::State {
  std::string model;
  RendererOptions options;
  OpenedModel opened;
};

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Renderer Renderer::open(const std::string& model, const RendererOptions& options) {
  check_options(options);
  SynthesizerOptions how;
  how.hrtf = options.hrtf;
  how.horizontal_fov_rad = options.horizontal_fov_rad;
  how.threads = options.threads;
  how.texture = options.texture;
  const std::string word = model.empty() ? std::string(kDefaultModel) : model;
  std::string resolved = resolve_model(word);
  OpenedModel opened = open_model(resolved, how);
  return Renderer(std::make_unique<State>(State{std::move(resolved), options, std::move(opened)}));
}

Waveform Renderer::render(const Waveform& sound, const RenderRequest& request) {
  const RendererOptions& how = state_->options;
  if (!(std::abs(request.gain_db) <= kMostGain_db)) {
    throw InputError("gain", fmt::format("expected -{0:g} to {0:g} dB, found {1:g}", kMostGain_db,
                                         request.gain_db));
  }
  SoundInMemory source{.sound = both_ears(sound),
                       .picture = nullptr,
                       .speaker_box = {},
                       .speaker_m = request.speaker_m,
                       .world_from_source = {}};
  (void)survey_of(source.sound);
  const EarpointPath path = path_of(request);
  if (request.picture != nullptr) {
    EARPOINT_CHECK(!request.picture->empty() && request.picture->channels() == 3);
    // A copy: the synthesizer tells pictures apart by their address.
    source.picture = std::make_shared<const Image>(*request.picture);
  }
  if (const auto track = track_of(request)) source.speaker_box = track->at(0.0);
  if (request.speaker_m) check_place(*request.speaker_m, "speaker");
  if (sound.channels() == 1) {
    source.sound = place_voice(std::move(source.sound), request, how.horizontal_fov_rad);
  }
  ClipRenderOptions options;
  options.extend_band = request.extend_band;
  options.gain_db = request.gain_db;
  options.limit = request.limit;
  options.threads = how.threads;
  return render_in_memory(source, *state_->opened.synthesizer, path, options);
}

std::vector<std::string> Renderer::warnings(const Waveform& sound,
                                            const RenderRequest& request) const {
  const SoundSurvey survey = survey_of(both_ears(sound));
  return state_->opened.synthesizer->warnings(
      {.duration_s = survey.duration_s(),
       .level_db = std::max(survey.level_db[0], survey.level_db[1]),
       .has_picture = request.picture != nullptr,
       .speaker_track = track_of(request),
       .speaker_m = request.speaker_m,
       .targets = {path_of(request)}});
}

Stream Renderer::stream(const StreamOptions& options) const {
  const State& state = *state_;
  if (state.model == "dsp") {
    return Stream(
        std::make_unique<Stream::State>(Stream::State{dsp_stream(state.options, options)}));
  }
  if (state.opened.gtf == nullptr) {
    throw InputError(state.model, "renders whole clips only",
                     "open a gtf network or dsp for streams");
  }
  return Stream(std::make_unique<Stream::State>(
      Stream::State{gtf_stream(*state.opened.gtf, state.options, options)}));
}

const std::string& Renderer::model() const { return state_->model; }

}  // namespace earpoint
