// Finds who speaks by picture and sound in single seconds of a simulated data set. Measures how
// often that is right, by the angle between the two people and for speakers outside the picture;
// the errors of gtf with this answer; and the error of the interaural level difference at the
// target if the source is made mono and its voice is placed at the speaker. Writes one JSON object
// to standard output.
//
// usage: active_speaker DATA SPLIT DETECTOR [SECONDS]
//
// DETECTOR is a detector's file; "shipped"; "true", the boxes of the data set as they are; or
// "jittered", the same moved by 5 % of their height, one in twenty missing. SECONDS: length of
// sound, 1 by default.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/random.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/clip_metrics.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/gtf/synthesizer.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/locate/box_overlap.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/locate/people_detector.h>
#include <earpoint/network/shipped_model.h>
#include <earpoint/render/voice_placer.h>

namespace {

using namespace earpoint;

constexpr std::uint64_t kSeed = 1;
constexpr int kRateHz = 16000;
constexpr int kWindows = 4;  // of every speaker at every viewpoint
constexpr double kFovRad = kPi / 2;
constexpr double kSamePerson = 0.3;  // least overlap (IoU) of a box that shows a person
constexpr double kWellApartDegrees = 15.0;
constexpr double kLevelTolerance_db = 2.0;
constexpr std::array<double, 7> kAngles{0.0, 5.0, 10.0, 15.0, 30.0, 60.0, 181.0};

enum class Answer { right, other, nobody };

/// What gtf gets of the speaker; `input` stands for the unchanged source.
enum class Told { input, nothing, found, truth };
constexpr std::array<const char*, 4> kToldNames{"input", "none", "found", "true"};

/// One second of one speaker at one viewpoint.
struct Case {
  Answer answer = Answer::right;
  int in_sight = 0;
  bool speaker_in_sight = false;
  double angle_deg = 0.0;  // between the two, as seen from the camera
  double certainty = 0.0;
  // Errors of the interaural level difference at the target: from mono placed at the person that
  // was found, from mono placed at the one that truly speaks, and from the binaural source.
  std::optional<double> found_level_error_db;
  std::optional<double> given_level_error_db;
  std::optional<double> binaural_level_error_db;
  std::array<ClipMetrics, 4> told;  // by Told
};

struct Bench {
  std::string word;
  std::unique_ptr<PeopleDetector> detector;
  StillSpeakerFinder speakers{HrtfSet::load(kRateHz), kFovRad};
  HrtfSet head = HrtfSet::load(kRateHz);
  std::unique_ptr<GtfSynthesizer> gtf;
  ClipMeasurer measurer{ReverberationEstimator()};
  std::ptrdiff_t samples = kRateHz;
};

std::vector<std::optional<Box>> true_boxes(const SoundSpacesClip& clip, int viewpoint) {
  std::vector<std::optional<Box>> boxes;
  for (const SoundSpacesSpeaker& speaker : clip.speakers) {
    boxes.push_back(from_soundspaces_box(clip.viewpoints[viewpoint].bboxes.at(speaker.id)));
  }
  return boxes;
}

std::vector<DetectedPerson> people_of(Bench& bench, const Image& picture,
                                      const std::vector<std::optional<Box>>& truth,
                                      RandomStream& random) {
  if (bench.detector) return bench.detector->detect(picture);
  std::vector<DetectedPerson> people;
  for (const std::optional<Box>& box : truth) {
    if (!box) continue;
    Box found = *box;
    if (bench.word == "jittered") {
      if (random.uniform() < 0.05) continue;
      const double step = 0.05 * (box->y_max - box->y_min);
      for (double* edge : {&found.x_min, &found.x_max, &found.y_min, &found.y_max}) {
        *edge = std::clamp(*edge + step * random.normal(), 0.0, 1.0);
      }
      if (found.x_max - found.x_min < 0.01 || found.y_max - found.y_min < 0.01) continue;
    }
    people.push_back({found, 1.0});
  }
  return people;
}

Answer judge(const std::optional<Box>& chosen, const std::vector<std::optional<Box>>& truth,
             int speaker) {
  if (!chosen) return truth[speaker] ? Answer::nobody : Answer::right;
  if (!truth[speaker]) return Answer::other;
  const double overlap = intersection_over_union(*chosen, *truth[speaker]);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool is_nearer = truth[i] && intersection_over_union(*chosen, *truth[i]) > overlap;
    if (static_cast<int>(i) != speaker && is_nearer) return Answer::other;
  }
  return overlap >= kSamePerson ? Answer::right : Answer::other;
}

Waveform through_gtf(Bench& bench, const PairSample& sample, const Waveform& source,
                     const std::optional<Box>& box) {
  bench.gtf->observe({.sound = source,
                      .picture = sample.picture,
                      .speaker_box = box,
                      .speaker_m = std::nullopt,
                      .world_from_source = sample.world_from_source});
  return bench.gtf->synthesize(sample.source_from_target);
}

std::optional<double> level_error(const PairSample& sample, const Waveform& rendered) {
  return binaural_metrics(sample.target, rendered).lre_db;
}

/// Makes the source mono, places its voice at the box, and renders it at the target.
std::optional<double> mono_level_error(Bench& bench, const PairSample& sample, const Box& box) {
  Waveform mono(2, sample.source.samples(), kRateHz);
  for (std::ptrdiff_t i = 0; i < mono.samples(); ++i) {
    const float mean = 0.5F * (sample.source.channel(0)[i] + sample.source.channel(1)[i]);
    mono.channel(0)[i] = mean;
    mono.channel(1)[i] = mean;
  }
  const std::array<int, 2> size{sample.picture->width(), sample.picture->height()};
  VoicePlacer placer(*placed_at(SpeakerTrack(box), StereoKind::same, kFovRad, size), bench.head);
  const std::array<Waveform, 2> parts{placer.process(mono), placer.finish()};
  Waveform placed(2, mono.samples(), kRateHz);
  std::ptrdiff_t at = 0;
  for (const Waveform& part : parts) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(part.channel(ear), placed.channel(ear).begin() + at);
    }
    at += part.samples();
  }
  return level_error(sample, through_gtf(bench, sample, placed, box));
}

double azimuth_of(const SoundSpacesViewpoint& view, const SoundSpacesSpeaker& speaker) {
  const Vector3 way = from_soundspaces(speaker.location) - from_soundspaces(view.location);
  return wrap_angle(std::atan2(way.y, way.x) - view.rotation_rad);
}

Case measure(Bench& bench, const PairSampler& sampler, const SoundSpacesClip& clip, int viewpoint,
             int speaker, RandomStream& random) {
  SoundSpacesChoice choice{.source = viewpoint,
                           .target = (viewpoint + 1) % static_cast<int>(clip.viewpoints.size()),
                           .speaker = speaker};
  const std::ptrdiff_t spoken = sampler.speech_samples(clip.speakers[speaker]);
  if (spoken > bench.samples) {
    choice.window_start = static_cast<std::ptrdiff_t>(random.index(spoken - bench.samples));
  }
  const PairSample sample = sampler.sample(clip, choice, bench.samples);
  const auto truth = true_boxes(clip, viewpoint);
  const PeopleInPicture found =
      bench.speakers.find(people_of(bench, *sample.picture, truth, random), sample.source);
  const std::optional<Box> chosen = found.speaker_box();
  Case result;
  result.answer = judge(chosen, truth, speaker);
  for (const auto& box : truth) result.in_sight += box ? 1 : 0;
  result.speaker_in_sight = truth[speaker].has_value();
  const SoundSpacesViewpoint& view = clip.viewpoints[viewpoint];
  result.angle_deg = degrees_from_radians(std::abs(
      wrap_angle(azimuth_of(view, clip.speakers[0]) - azimuth_of(view, clip.speakers[1]))));
  result.certainty = found.belief.outside;
  for (const double value : found.belief.people)
    result.certainty = std::max(result.certainty, value);
  if (!bench.gtf || bench.samples != kRateHz) return result;
  if (chosen) result.found_level_error_db = mono_level_error(bench, sample, *chosen);
  if (truth[speaker]) {
    result.given_level_error_db = mono_level_error(bench, sample, *truth[speaker]);
  }
  bench.measurer.set_target(sample.target, nullptr);
  const auto told = [&](Told what, const Waveform& sound) {
    result.told[static_cast<std::size_t>(what)] = bench.measurer.measure(sound);
  };
  told(Told::input, sample.source);
  told(Told::nothing, through_gtf(bench, sample, sample.source, std::nullopt));
  told(Told::found, through_gtf(bench, sample, sample.source, chosen));
  told(Told::truth, through_gtf(bench, sample, sample.source, truth[speaker]));
  result.binaural_level_error_db = result.told[static_cast<std::size_t>(Told::truth)][Metric::lre];
  return result;
}

std::vector<Case> measure_all(Bench& bench, const SoundSpacesDataset& dataset) {
  const PairSampler sampler(dataset, std::size_t{256} << 20U);
  std::vector<Case> cases;
  std::uint64_t number = 0;
  for (const SoundSpacesClip& clip : dataset.clips()) {
    for (int viewpoint = 0; viewpoint < static_cast<int>(clip.viewpoints.size()); ++viewpoint) {
      for (int speaker = 0; speaker < static_cast<int>(clip.speakers.size()); ++speaker) {
        if (!clip.speakers[speaker].speech || clip.speakers.size() != 2) continue;
        for (int window = 0; window < kWindows; ++window) {
          RandomStream random(kSeed, {number++});
          cases.push_back(measure(bench, sampler, clip, viewpoint, speaker, random));
        }
      }
    }
  }
  if (cases.empty()) throw InputError("the data set", "has no conversations of two");
  return cases;
}

template <typename Filter>
nlohmann::json shares(const std::vector<Case>& cases, Filter filter) {
  std::array<int, 3> counts{};
  for (const Case& one : cases) {
    if (filter(one)) ++counts[static_cast<std::size_t>(one.answer)];
  }
  const int all = counts[0] + counts[1] + counts[2];
  const double whole = std::max(all, 1);
  return {{"cases", all},
          {"right", counts[0] / whole},
          {"other", counts[1] / whole},
          {"nobody", counts[2] / whole}};
}

/// Of the cases that have a value: how many are within the tolerance, and the median.
nlohmann::json level_json(const std::vector<Case>& cases, std::optional<double> Case::*error) {
  std::vector<double> errors;
  for (const Case& one : cases) {
    if (one.*error) errors.push_back(*(one.*error));
  }
  if (errors.empty()) return nullptr;
  std::ranges::sort(errors);
  const auto within = std::ranges::upper_bound(errors, kLevelTolerance_db) - errors.begin();
  return {{"cases", errors.size()},
          {"within_2_db", static_cast<double>(within) / static_cast<double>(errors.size())},
          {"median_db", errors[errors.size() / 2]}};
}

double mean_of(const std::vector<Case>& cases, Told told, Metric metric) {
  double sum = 0.0;
  int count = 0;
  for (const Case& one : cases) {
    const std::optional<double>& value = one.told[static_cast<std::size_t>(told)][metric];
    if (!value) continue;
    sum += *value;
    ++count;
  }
  return sum / std::max(count, 1);
}

/// Errors of gtf by what it gets of the speaker, divided by those of the unchanged source.
nlohmann::json told_json(const std::vector<Case>& cases) {
  nlohmann::json json = nlohmann::json::object();
  for (const Told told : {Told::nothing, Told::found, Told::truth}) {
    nlohmann::json& row = json[kToldNames[static_cast<std::size_t>(told)]];
    for (const Metric metric : {Metric::mag, Metric::lre, Metric::interaural_delay}) {
      row[std::string(name_of(metric).key)] =
          mean_of(cases, told, metric) / mean_of(cases, Told::input, metric);
    }
  }
  return json;
}

nlohmann::json report(const Bench& bench, const std::vector<Case>& cases) {
  const auto both = [](const Case& one) { return one.in_sight == 2; };
  nlohmann::json json{
      {"detector", bench.detector ? bench.detector->name() : bench.word + " boxes"},
      {"seconds", static_cast<double>(bench.samples) / kRateHz},
      {"all", shares(cases, [](const Case&) { return true; })},
      {"both_in_sight", shares(cases, both)},
      {"well_apart",
       shares(cases,
              [&](const Case& one) { return both(one) && one.angle_deg >= kWellApartDegrees; })},
      {"one_in_sight",
       shares(cases, [](const Case& one) { return one.in_sight == 1 && one.speaker_in_sight; })},
      {"speaker_outside", shares(cases, [](const Case& one) { return !one.speaker_in_sight; })},
      {"by_angle", nlohmann::json::array()},
      {"by_certainty", nlohmann::json::array()}};
  for (std::size_t i = 0; i + 1 < kAngles.size(); ++i) {
    nlohmann::json row = shares(cases, [&](const Case& one) {
      return both(one) && one.angle_deg >= kAngles[i] && one.angle_deg < kAngles[i + 1];
    });
    row["from_deg"] = kAngles[i];
    row["to_deg"] = kAngles[i + 1];
    json["by_angle"].push_back(row);
  }
  for (const auto& step :
       {std::pair{0.0, 0.7}, std::pair{0.7, 0.9}, std::pair{0.9, 0.99}, std::pair{0.99, 1.01}}) {
    const double from = step.first;  // clang takes no structured bindings into lambdas
    const double to = step.second;
    nlohmann::json row =
        shares(cases, [&](const Case& one) { return one.certainty >= from && one.certainty < to; });
    row["from"] = from;
    row["to"] = to;
    json["by_certainty"].push_back(row);
  }
  json["mono_found"] = level_json(cases, &Case::found_level_error_db);
  json["mono_given"] = level_json(cases, &Case::given_level_error_db);
  json["gtf_told"] = told_json(cases);
  json["binaural"] = level_json(cases, &Case::binaural_level_error_db);
  return json;
}

int run(int count, char** words) {
  if (count < 4 || count > 5) {
    fmt::print(stderr, "usage: active_speaker DATA SPLIT DETECTOR [SECONDS]\n");
    return 2;
  }
  Bench bench;
  bench.word = words[3];
  if (bench.word != "true" && bench.word != "jittered") {
    bench.detector = bench.word == "shipped"
                         ? make_people_detector()
                         : make_people_detector(std::filesystem::path(bench.word));
  }
  if (count == 5) bench.samples = static_cast<std::ptrdiff_t>(std::stod(words[4]) * kRateHz);
  if (const auto gtf = shipped_model_path("gtf.safetensors")) {
    bench.gtf = std::make_unique<GtfSynthesizer>(read_gtf_weights(gtf->string()), kFovRad);
  }
  const SoundSpacesDataset dataset(soundspaces_options(words[1], words[2]));
  fmt::print("{}\n", report(bench, measure_all(bench, dataset)).dump(1));
  return 0;
}

}  // namespace

int main(int count, char** words) {
  try {
    return run(count, words);
  } catch (const std::exception& error) {
    fmt::print(stderr, "active_speaker: {}\n", error.what());
    return 1;
  }
}
