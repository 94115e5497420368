#include "earpoint_map.h"
#include "report_sounds.h"

#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/evaluate/earpoint_comparison.h>

namespace earpoint {

FigureRow figure_row(const EarpointComparison& comparison,
                     const std::optional<std::filesystem::path>& enhanced) {
  const EarpointClip& clip = comparison.clip;
  // Boxes are drawn over the picture, not into it.
  EarpointClip bare = clip;
  bare.speaker_box.reset();
  FigureView source;
  source.title = "Source";
  source.picture = clip_picture(bare);
  if (clip.speaker_box) source.boxes.push_back({*clip.speaker_box, true});
  source.sounds.push_back({"recorded", read_sound(comparison.source)});
  FigureRow row;
  row.views.push_back(std::move(source));
  for (std::size_t i = 0; i < clip.earpoints.size(); ++i) {
    const KnownEarpoint& earpoint = clip.earpoints[i];
    FigureView view;
    view.title = fmt::format("{}  {}", i + 1, earpoint.name);
    view.caption = words_of(earpoint.source_from_target);
    view.source_from_target = earpoint.source_from_target;
    view.speaker_m = clip.speaker_m;
    if (clip.map) view.picture = drawn_map(clip, i);
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      view.sounds.push_back(
          {comparison.methods[m].name, read_sound(comparison.earpoints[i].renderings[m].sound)});
    }
    view.sounds.push_back({"truth", read_sound(earpoint.truth)});
    row.views.push_back(std::move(view));
  }
  if (!enhanced) return row;
  FigureView voice;
  voice.title = "Enhancement";
  voice.has_own_scale = true;
  if (clip.speaker_box && !row.views.front().picture.empty()) {
    voice.picture = cut_out(row.views.front().picture, *clip.speaker_box);
  }
  voice.sounds.push_back({"enhanced from the source", read_sound(*enhanced)});
  row.views.push_back(std::move(voice));
  return row;
}

}  // namespace earpoint
