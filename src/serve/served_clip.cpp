#include <earpoint/serve/served_clip.h>

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/render_files/locate_speaker.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

constexpr std::ptrdiff_t kBlock = 65536;  // samples read at once

Waveform read_whole(const SoundInput& source, const SoundSurvey& survey) {
  if (survey.duration_s() > kLongestServed_s) {
    throw InputError(source.path.string(),
                     fmt::format("lasts {:.0f} minutes, at most {:.0f} can be played live",
                                 survey.duration_s() / 60.0, kLongestServed_s / 60.0),
                     "cut it, or use earpoint render");
  }
  const BlockReader read = read_blocks(source);
  Waveform sound(2, survey.samples, survey.sample_rate_hz);
  std::ptrdiff_t filled = 0;
  while (filled < sound.samples()) {
    const Waveform block = read(std::min(kBlock, sound.samples() - filled));
    if (block.samples() == 0) break;
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(block.channel(ear), sound.channel(ear).begin() + filled);
    }
    filled += block.samples();
  }
  return sound;
}

}  // namespace

ServedClip open_served_clip(const RenderInput& source, const GtfWeights* finder,
                            double horizontal_fov_rad, ProgressSink& progress) {
  ServedClip clip;
  clip.name = source.sound.path.filename().string();
  clip.horizontal_fov_rad = horizontal_fov_rad;
  clip.source = source;
  const SoundSurvey survey = survey_sound(source.sound);
  clip.warnings = survey.warnings;
  clip.sound = read_whole(source.sound, survey);
  const double middle_s = 0.5 * survey.duration_s();
  PictureStream pictures = open_pictures(source.picture, source.sound.path);
  if (!pictures.empty()) clip.picture = pictures.nearest(middle_s);
  if (clip.picture) {
    clip.picture_png = encode_png(*clip.picture);
  } else {
    clip.warnings.emplace_back("no picture: the speaker is located by the sound alone");
  }
  if (source.speaker_track) clip.speaker_box = source.speaker_track->at(middle_s);
  if (clip.speaker_box) clip.people = {{*clip.speaker_box, true}};
  clip.speaker_m = source.speaker_m;
  if (clip.speaker_m) {
    clip.speaker = ServedSpeaker{.position_m = *clip.speaker_m, .is_told = true};
  } else if (finder != nullptr) {
    const LocatedSpeaker found = locate_speaker(source, *finder, horizontal_fov_rad, progress);
    clip.speaker = ServedSpeaker{.position_m = found.speaker.position_m,
                                 .heading_rad = found.speaker.yaw_rad,
                                 .spread_rad = found.azimuth_spread_rad};
  }
  return clip;
}

}  // namespace earpoint
