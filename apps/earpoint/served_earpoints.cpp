#include "served_earpoints.h"

#include "served_upload.h"
#include "source_arguments.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/earpoint_clip.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

/// A truth at the clip's rate and as long as the clip.
Waveform truth_for(const ServedClip& clip, const std::filesystem::path& file) {
  Waveform truth = read_sound(file);
  if (truth.channels() != 2) throw InputError(file.string(), "is not binaural");
  if (truth.sample_rate_hz() != clip.sound.sample_rate_hz()) {
    truth = resample(truth, clip.sound.sample_rate_hz());
  }
  Waveform fitted(2, clip.sound.samples(), clip.sound.sample_rate_hz());
  const std::ptrdiff_t samples = std::min(truth.samples(), fitted.samples());
  for (int ear = 0; ear < 2; ++ear) {
    std::copy_n(truth.channel(ear).begin(), samples, fitted.channel(ear).begin());
  }
  return fitted;
}

SourceArguments arguments_of(const EarpointClip& known) {
  SourceArguments arguments;
  arguments.inputs = {known.clip.string()};
  if (known.speaker_m) {
    arguments.speaker =
        fmt::format("{},{},{}", known.speaker_m->x, known.speaker_m->y, known.speaker_m->z);
  }
  if (known.speaker_box) {
    const Box& box = *known.speaker_box;
    arguments.speaker_box = fmt::format("{},{},{},{}", box.x_min, box.y_min, box.x_max, box.y_max);
  }
  arguments.fov_deg = known.fov_deg;
  return arguments;
}

}  // namespace

ServedClip open_earpoints(const std::filesystem::path& description, const GtfWeights* finder,
                          const std::string& detector, bool quiet) {
  const EarpointClip known = read_earpoint_clip(description);
  ServedClip clip = open_recording(arguments_of(known), finder, detector, quiet);
  for (const KnownEarpoint& earpoint : known.earpoints) {
    clip.places.push_back(
        {earpoint.name, earpoint.source_from_target, truth_for(clip, earpoint.truth)});
  }
  if (known.map) {
    clip.map = ServedMap{.png = encode_png(read_image(known.map->picture)),
                         .camera_x = known.map->camera_x,
                         .camera_y = known.map->camera_y,
                         .pixels_per_metre = known.map->pixels_per_metre};
  }
  return clip;
}

}  // namespace earpoint
