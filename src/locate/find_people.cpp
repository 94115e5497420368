#include <earpoint/locate/find_people.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/render_files/picture_stream.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = VoiceDirection::kSampleRateHz;
constexpr std::ptrdiff_t kStep = kRate_hz / 5;
// A recording's ambient sound lies below it, where directions cannot be heard.
constexpr double kAmbientCutoff_hz = 80.0;

double seconds(std::ptrdiff_t samples) { return static_cast<double>(samples) / kRate_hz; }

double mean_power(const Waveform& sound) {
  double sum = 0.0;
  for (const float sample : sound.planar()) sum += static_cast<double>(sample) * sample;
  return sum / static_cast<double>(std::max<std::size_t>(sound.planar().size(), 1));
}

/// Detects people in every new picture; a still picture is searched once.
class People {
 public:
  People(const RenderInput& source, PeopleDetector* detector)
      : source_(source), detector_(detector) {
    if (detector != nullptr && !source.speaker_track) {
      pictures_ = open_pictures(source.picture, source.sound.path);
    }
  }

  std::vector<TrackedPerson> at(double time_s) {
    if (source_.speaker_track) {
      const std::optional<Box> box = source_.speaker_track->at(time_s);
      if (!box) return {};
      return {{.track = 0, .box = *box, .score = 1.0, .is_seen = true}};
    }
    const std::shared_ptr<const Image> picture = pictures_.nearest(time_s);
    if (picture == nullptr) return {};
    if (picture != seen_) found_ = detector_->detect(*picture);
    seen_ = picture;
    return tracker_.update(time_s, found_);
  }

  [[nodiscard]] bool has_picture() const { return seen_ != nullptr; }

 private:
  const RenderInput& source_;
  PeopleDetector* detector_;
  PictureStream pictures_;
  PersonTracker tracker_;
  std::shared_ptr<const Image> seen_;
  std::vector<DetectedPerson> found_;
};

/// The state that is most probable: an index of people, or nothing.
std::optional<std::size_t> likeliest(const SpeakerBelief& belief) {
  const auto best = std::ranges::max_element(belief.people);
  if (best == belief.people.end() || *best < belief.outside) return std::nullopt;
  return static_cast<std::size_t>(best - belief.people.begin());
}

}  // namespace

PeopleInClip find_people(const RenderInput& source, const SoundSurvey& survey,
                         const PeopleSearch& search, ProgressSink& progress) {
  PeopleInClip found;
  found.hears_direction = search.hears_direction && !source.speaker_track;
  found.detector = source.speaker_track         ? "given boxes"
                   : search.detector == nullptr ? "none"
                                                : search.detector->name();
  People people(source, search.detector);
  SourceStream stream(read_blocks(source.sound), survey, kRate_hz,
                      {.cutoff_hz = kAmbientCutoff_hz});
  std::optional<VoiceDirection> direction;
  if (found.hears_direction && search.detector != nullptr) {
    direction.emplace(HrtfSet::load(kRate_hz));
  }
  std::vector<SpeakerMoment> moments;
  progress.begin("finding people", survey.duration_s(), "s");
  // A remainder of less than half a step is skipped, unless it is the whole sound.
  for (std::ptrdiff_t start = 0; start == 0 || start + kStep / 2 <= stream.model_samples();
       start += kStep) {
    const SourceStream::Window window = stream.window(start, kStep, 0);
    stream.drop_high_band_before(
        static_cast<std::ptrdiff_t>(seconds(start) * survey.sample_rate_hz));
    PeopleFrame frame;
    frame.time_s = seconds(start + kStep / 2);
    frame.people = people.at(frame.time_s);
    DirectionEvidence evidence{.log_likelihood = {}, .power = mean_power(window.primary)};
    if (direction) evidence = direction->listen(window.primary);
    moments.push_back(speaker_moment(frame.people, evidence, search.horizontal_fov_rad));
    // If the speaker is given, nobody outside the picture speaks.
    if (source.speaker_track) moments.back().outside = 0.0;
    found.frames.push_back(std::move(frame));
    progress.advance(seconds(kStep));
  }
  progress.finish();
  found.has_picture = people.has_picture();
  std::vector<SpeakerBelief> beliefs = active_speakers(moments);
  for (std::size_t i = 0; i < beliefs.size(); ++i) found.frames[i].belief = std::move(beliefs[i]);
  return found;
}

std::optional<SpeakerTrack> speaker_track(const PeopleInClip& people) {
  std::vector<SpeakerTrack::Row> rows;
  bool is_ever_seen = false;
  for (const PeopleFrame& frame : people.frames) {
    const auto speaker = likeliest(frame.belief);
    rows.push_back({frame.time_s, std::nullopt});
    if (speaker) rows.back().box = frame.people[*speaker].box;
    is_ever_seen |= speaker.has_value();
  }
  if (!is_ever_seen) return std::nullopt;
  return SpeakerTrack(std::move(rows));
}

SpeakerSummary summary_of(const PeopleInClip& people) {
  SpeakerSummary summary;
  std::set<int> tracks;
  std::map<int, double> shares;
  double voice = 0.0;
  for (const PeopleFrame& frame : people.frames) {
    const SpeakerBelief& belief = frame.belief;
    voice += belief.voice;
    summary.outside_share += belief.voice * belief.outside;
    double most = belief.outside;
    for (std::size_t i = 0; i < frame.people.size(); ++i) {
      tracks.insert(frame.people[i].track);
      shares[frame.people[i].track] += frame.speaking(i);
      most = std::max(most, belief.people[i]);
    }
    summary.certainty += belief.voice * most;
  }
  summary.people = static_cast<int>(tracks.size());
  double largest = summary.outside_share;
  for (const auto& [track, share] : shares) {
    if (share < largest) continue;
    summary.speaker = track;
    largest = share;
  }
  if (voice > 0.0) {
    summary.outside_share /= voice;
    summary.certainty /= voice;
  }
  return summary;
}

std::string csv_of(const PeopleInClip& people) {
  std::string text = "time_s,track,x0,y0,x1,y1,speaking,voice\n";
  for (const PeopleFrame& frame : people.frames) {
    for (std::size_t i = 0; i < frame.people.size(); ++i) {
      const TrackedPerson& person = frame.people[i];
      text += fmt::format("{:.3f},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}\n", frame.time_s,
                          person.track, person.box.x_min, person.box.y_min, person.box.x_max,
                          person.box.y_max, frame.speaking(i), frame.belief.voice);
    }
  }
  return text;
}

std::optional<Box> PeopleInPicture::speaker_box() const {
  const auto speaker = likeliest(belief);
  return speaker ? std::optional(people[*speaker].box) : std::nullopt;
}

StillSpeakerFinder::StillSpeakerFinder(const HrtfSet& head, double horizontal_fov_rad)
    : horizontal_fov_rad_(horizontal_fov_rad), direction_(head) {}

PeopleInPicture StillSpeakerFinder::find(std::vector<DetectedPerson> people,
                                         const Waveform& sound) {
  EARPOINT_CHECK(sound.samples() > 0);
  PeopleInPicture found;
  std::vector<TrackedPerson> tracked;
  tracked.reserve(people.size());
  for (const DetectedPerson& person : people) {
    tracked.push_back({.track = static_cast<int>(tracked.size()), .box = person.box});
  }
  direction_.start();
  const DirectionEvidence evidence = direction_.listen(sound);
  const SpeakerMoment moment = speaker_moment(tracked, evidence, horizontal_fov_rad_);
  found.belief = active_speakers(std::span(&moment, 1)).front();
  found.heard_azimuth_rad = evidence.azimuth_rad();
  found.people = std::move(people);
  return found;
}

}  // namespace earpoint
