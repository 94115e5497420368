#include <earpoint/render_files/locate_speaker.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/view.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

/// The standard deviation of an unknown angle.
const double kAnyDirection_rad = kPi / std::sqrt(3.0);

/// The standard deviation of the logarithm of a distance that may be anything from 0.5 to 5 m.
const double kAnyDistance = std::log(10.0) / std::sqrt(12.0);

/// The standard deviation of an angle whose unit vectors have a mean of that length.
double spread_of(double mean_length) {
  return std::sqrt(std::max(0.0, -2.0 * std::log(std::clamp(mean_length, 1e-6, 1.0))));
}

}  // namespace

LocatedSpeaker mean_speaker(std::vector<SpeakerSighting> sightings) {
  double weights = 0.0;
  double front = 0.0, left = 0.0, height_m = 0.0;
  double facing_x = 0.0, facing_y = 0.0;
  double log_m = 0.0, log_squares = 0.0;
  for (const SpeakerSighting& sighting : sightings) {
    const Vector3& p = sighting.speaker.position_m;
    const double weight = sighting.level * sighting.level;
    const double distance_m = std::max(std::hypot(p.x, p.y), 1e-3);
    weights += weight;
    front += weight * p.x / distance_m;
    left += weight * p.y / distance_m;
    height_m += weight * p.z;
    log_m += weight * std::log(distance_m);
    log_squares += weight * std::pow(std::log(distance_m), 2);
    facing_x += weight * sighting.speaker.yaw_certainty * std::cos(sighting.speaker.yaw_rad);
    facing_y += weight * sighting.speaker.yaw_certainty * std::sin(sighting.speaker.yaw_rad);
  }
  EARPOINT_CHECK(weights > 0.0);
  log_m /= weights;
  LocatedSpeaker located;
  const double azimuth_rad = std::atan2(left, front);
  located.speaker.position_m = {std::exp(log_m) * std::cos(azimuth_rad),
                                std::exp(log_m) * std::sin(azimuth_rad), height_m / weights};
  located.speaker.yaw_rad = std::atan2(facing_y, facing_x);
  located.speaker.yaw_certainty = std::hypot(facing_x, facing_y) / weights;
  located.azimuth_spread_rad = spread_of(std::hypot(front, left) / weights);
  located.log_distance_spread = std::sqrt(std::max(0.0, log_squares / weights - log_m * log_m));
  located.sightings = std::move(sightings);
  return located;
}

LocatedSpeaker locate_speaker(const RenderInput& source, const GtfWeights& weights,
                              double horizontal_fov_rad, ProgressSink& progress) {
  Gtf network(weights);
  const GtfDescription& description = network.description();
  EARPOINT_CHECK(description.geometry);
  const SoundSurvey survey = survey_sound(source.sound);
  PictureStream pictures = description.picture_px > 0
                               ? open_pictures(source.picture, source.sound.path)
                               : PictureStream();
  constexpr int kRate_hz = GtfDescription::kSampleRateHz;
  SourceStream stream(read_blocks(source.sound), survey, kRate_hz,
                      {.cutoff_hz = description.highpass_cutoff_hz.value_or(0.0)});
  const std::ptrdiff_t samples = description.window_samples;

  bool has_picture = false, has_box = false;
  std::vector<SpeakerSighting> sightings;
  progress.begin("locating", survey.duration_s(), "s");
  // A remainder of less than half a window is skipped, unless it is the whole sound.
  for (std::ptrdiff_t start = 0; start == 0 || start + samples / 2 <= stream.model_samples();
       start += samples) {
    const SourceStream::Window window = stream.window(start, samples, 0);
    stream.drop_high_band_before(
        static_cast<std::ptrdiff_t>(static_cast<double>(start) / kRate_hz * survey.sample_rate_hz));
    const double middle_s =
        (static_cast<double>(start) + 0.5 * static_cast<double>(samples)) / kRate_hz;
    const std::shared_ptr<const Image> picture = pictures.nearest(middle_s);
    const std::optional<Box> box =
        source.speaker_track ? source.speaker_track->at(middle_s) : std::nullopt;
    const GtfView view =
        gtf_view(picture.get(), box, horizontal_fov_rad, std::max(description.picture_px, 1));
    network.set_picture(view.picture, view.speaker_box);
    const GtfSpeaker found = network.locate(window.primary.planar()).value();
    sightings.push_back({middle_s, found, network.statistics().level});
    has_picture |= picture != nullptr;
    has_box |= view.speaker_box.has_value() && description.box;
    progress.advance(static_cast<double>(samples) / kRate_hz);
  }
  progress.finish();
  LocatedSpeaker located = mean_speaker(std::move(sightings));
  located.has_picture = has_picture;
  located.has_box = has_box;
  located.survey = survey;
  if (survey.stereo != StereoKind::plausible) {
    located.speaker.yaw_certainty = 0.0;
    for (SpeakerSighting& sighting : located.sightings) sighting.speaker.yaw_certainty = 0.0;
    located.log_distance_spread = std::max(located.log_distance_spread, kAnyDistance);
    if (!has_box) located.azimuth_spread_rad = kAnyDirection_rad;
  }
  return located;
}

}  // namespace earpoint
