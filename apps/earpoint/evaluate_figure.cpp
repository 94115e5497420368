#include "evaluate_figure.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/view_figure.h>
#include <earpoint/evaluate/viewed_clip.h>
#include <earpoint/network/model_names.h>
#include <earpoint/render/make_synthesizer.h>
#include <earpoint/render_files/render.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnhancer = "enhance";

/// The speech of the clip's speaker; nothing where no model for that is shipped.
std::optional<fs::path> enhanced(const EarpointClip& clip, const fs::path& folder, int threads,
                                 ProgressSink& progress) {
  const auto model = shipped_model(kEnhancer);
  if (!model) return std::nullopt;
  RenderInput source;
  source.sound.path = clip.clip;
  if (clip.speaker_box) source.speaker_track = SpeakerTrack(*clip.speaker_box);
  SynthesizerOptions how;
  how.threads = threads;
  how.enhances = true;
  if (clip.fov_deg) how.horizontal_fov_rad = radians_from_degrees(*clip.fov_deg);
  ClipRenderOptions options;
  options.answer = RenderAnswer::voice;
  options.threads = threads;
  const fs::path output = folder / "enhanced.flac";
  const RenderTarget target{EarpointPath(Pose{}), output};
  (void)render(source, *make_synthesizer(model->string(), how), {&target, 1}, options, progress);
  return output;
}

}  // namespace

void check_figure_path(const fs::path& path) {
  if (path.extension() != ".svg") {
    throw InputError("--figure " + path.string(), "figures are written as .svg",
                     "convert it afterwards, or name a file that ends in .svg");
  }
  const AtomicFile probe(path);
}

void draw_figure(const FigureRequest& request, ProgressSink& progress) {
  check_figure_path(request.output);
  const std::vector<ViewedClip> clips = read_viewed_clips({.data = request.methods.data,
                                                           .layout = request.methods.layout,
                                                           .split = request.split,
                                                           .names = request.clips,
                                                           .count = request.count});
  std::set<std::string> scenes;
  MethodRequest wanted = request.methods;
  for (const ViewedClip& clip : clips) {
    scenes.insert(clip.scene);
    wanted.knows_speaker = wanted.knows_speaker && clip.knows_speaker;
  }
  const std::vector<MethodEntry> methods = methods_of(wanted, scenes);
  for (const MethodEntry& method : methods) {
    if (method.is_oracle) {
      throw InputError("--methods " + method.name, "oracles cannot be drawn in a figure",
                       "leave it out");
    }
    if (method.needs_speaker && !wanted.knows_speaker) {
      throw InputError("--methods " + method.name,
                       "needs the speaker's position, which these clips do not have",
                       "leave it out");
    }
  }
  std::vector<MethodEntry> enhancers;
  if (shipped_model(kEnhancer)) {
    wanted.words = {kEnhancer};
    wanted.enhance = true;
    enhancers = methods_of(wanted, scenes);
  }
  std::vector<FigureRow> rows;
  progress.begin("rendering", static_cast<double>(clips.size()), "clips");
  for (const ViewedClip& clip : clips) {
    rows.push_back(figure_row(clip, methods, enhancers.empty() ? nullptr : &enhancers.front()));
    progress.advance(1.0);
  }
  progress.finish();
  write_file(request.output, view_figure_svg(rows));
}

void draw_figure(const fs::path& output, const EarpointComparison& comparison,
                 const fs::path& folder, int threads, ProgressSink& progress) {
  const FigureRow row =
      figure_row(comparison, enhanced(comparison.clip, folder, threads, progress));
  write_file(output, view_figure_svg({&row, 1}));
}

}  // namespace earpoint
