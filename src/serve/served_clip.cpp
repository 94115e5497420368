#include <algorithm>

#include <fmt/format.h>

#include <earpoint/core/error.h>
#include <earpoint/serve/served_clip.h>
#include <earpoint/synth/picture_stream.h>
#include <earpoint/video/image_file.h>
#include <earpoint/video/media.h>

namespace earpoint {
namespace {

Waveform read_whole(const SoundSource& source, const SoundSurvey& survey) {
  if (survey.duration_s() > kLongestServed_s) {
    throw InputError(source.path.string(),
                     fmt::format("lasts {:.0f} minutes, at most {:.0f} can be listened to live",
                                 survey.duration_s() / 60.0, kLongestServed_s / 60.0),
                     "cut it, or use earpoint render");
  }
  AudioReader reader(source.path, source.binaural_channels, source.audio_stream);
  Waveform sound(2, survey.samples, survey.sample_rate_hz);
  std::ptrdiff_t filled = 0;
  while (filled < sound.samples()) {
    const Waveform block = reader.read(std::min<std::ptrdiff_t>(65536, sound.samples() - filled));
    if (block.samples() == 0) break;
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(block.channel(ear), sound.channel(ear).begin() + filled);
    }
    filled += block.samples();
  }
  return sound;
}

}  // namespace

ServedClip open_served_clip(const RenderSource& source, const std::filesystem::path& gtf_file,
                            double horizontal_fov_rad, ProgressSink& progress) {
  ServedClip clip;
  clip.weights = read_gtf_weights(gtf_file);
  clip.name = source.sound.path.filename().string();
  clip.horizontal_fov_rad = horizontal_fov_rad;
  clip.located = locate_speaker(source, clip.weights, horizontal_fov_rad, progress);
  clip.warnings = clip.located.survey.warnings;
  clip.sound = read_whole(source.sound, clip.located.survey);
  const double middle_s = 0.5 * clip.located.survey.duration_s();
  PictureStream pictures = open_pictures(source.picture, source.sound.path);
  if (!pictures.empty()) clip.picture = pictures.nearest(middle_s);
  if (clip.picture) {
    clip.picture_png = encode_png(*clip.picture);
  } else {
    clip.warnings.emplace_back("no picture: the speaker is found by sound alone");
  }
  if (source.speaker_track) clip.speaker_box = source.speaker_track->at(middle_s);
  clip.speaker_m = source.speaker_m;
  return clip;
}

}  // namespace earpoint
