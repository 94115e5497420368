#include <earpoint/serve/walk_export.h>

#include "live_sound.h"

#include <array>

#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/render_files/open_sound_sink.h>

namespace earpoint {

void export_walk(const ServedClip& clip, const ListenMethod& method, const std::string& walk_csv,
                 const std::filesystem::path& output) {
  const EarpointPath path = EarpointPath::parse_csv(walk_csv, "the walk");
  path.check_covers(clip.sound.duration_s());
  const auto synthesizer = make_synthesizer(method.model, seen_with(clip.horizontal_fov_rad));
  if (clip.source) {
    SilentProgress silent;
    RenderInput source = *clip.source;
    // As `earpoint render`: to gtf a moment without a box means a speaker out of sight; others keep
    // the last box.
    if (!method.gtf && source.speaker_track) source.speaker_track = source.speaker_track->held();
    const std::array<RenderTarget, 1> target{RenderTarget{path, output}};
    (void)render(source, *synthesizer, target, {}, silent);
    return;
  }
  const Waveform sound = render_in_memory(in_memory(clip, clip.sound), *synthesizer, path, {});
  const auto sink = open_sound_sink(output, sound.sample_rate_hz(), {}, sound.samples());
  sink->write(sound);
  sink->commit();
}

}  // namespace earpoint
