#include <earpoint/evaluate/transfer_function.h>

#include "filter_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/audio/convolution.h>
#include <earpoint/core/ears.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCacheBytes = std::size_t{256} << 20U;
constexpr std::uint64_t kWindowSeed = 1;
// Delays of responses are removed, so that a target leads its source by the delay between the ears
// at most.
constexpr FilterShape kShape{.before = 64, .after = 4000};
// Recordings keep their delays: a target that is 6 m nearer leads by 280 samples.
constexpr FilterShape kRecordedShape{.before = 320, .after = 4000};

/// Coordinates for the nearest-neighbour search: three points and three directions.
using Features = std::array<double, 18>;

/// Positions of source, target and speaker, all in one frame.
struct Places {
  Pose source;
  Pose target;
  Vector3 speaker_m;
  std::optional<double> speaker_yaw_rad;
};

Features features_of(const Places& places) {
  const Vector3 front{1.0, 0.0, 0.0};
  Vector3 speaker_front;  // zero if unknown, so that it has no effect
  if (places.speaker_yaw_rad) {
    speaker_front = {std::cos(*places.speaker_yaw_rad), std::sin(*places.speaker_yaw_rad), 0.0};
  }
  Features features{};
  auto next = features.begin();
  for (const Vector3& v : {places.source.position_m, places.target.position_m, places.speaker_m,
                           rotate(places.source.orientation, front),
                           rotate(places.target.orientation, front), speaker_front}) {
    for (const double coordinate : {v.x, v.y, v.z}) *next++ = coordinate;
  }
  return features;
}

Features features_of(const PairSample& sample, TransferIndex index) {
  if (index == TransferIndex::relative_pose) {
    return features_of(
        {Pose{}, sample.source_from_target, sample.speaker_m, sample.speaker_yaw_rad});
  }
  const Pose& world = sample.world_from_source;
  std::optional<double> yaw_rad = sample.speaker_yaw_rad;
  if (yaw_rad) *yaw_rad += euler_from_quaternion(world.orientation).yaw_rad;
  return features_of({world, world * sample.source_from_target,
                      transform_point(world, sample.speaker_m), yaw_rad});
}

double squared_distance(const Features& a, const Features& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

Pose world_from(const SoundSpacesViewpoint& viewpoint) {
  return {from_soundspaces(viewpoint.location),
          quaternion_from_euler({.yaw_rad = viewpoint.rotation_rad})};
}

/// The pairs of a training split, and their sounds.
class TrainingPairs {
 public:
  virtual ~TrainingPairs() = default;
  /// The sounds of the pair nearest to the question.
  [[nodiscard]] virtual PairSample nearest(const Question& question) const = 0;
  [[nodiscard]] virtual FilterShape shape() const = 0;
};

/// A pair of viewpoints of a clip, of either kind.
template <typename Clip, typename Choice>
struct TrainingPair {
  const Clip* clip;
  Choice choice;
  Features features;
};

template <typename Clip, typename Choice>
const TrainingPair<Clip, Choice>& nearest_of(const std::vector<TrainingPair<Clip, Choice>>& pairs,
                                             const Question& question, TransferIndex index) {
  const Features wanted = features_of(question.sample, index);
  const TrainingPair<Clip, Choice>* best = nullptr;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const auto& pair : pairs) {
    if (index == TransferIndex::locations && pair.clip->scene != question.scene) continue;
    const double distance = squared_distance(pair.features, wanted);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = &pair;
  }
  if (best == nullptr) {
    throw InputError("scene " + std::string(question.scene), "is not in the training split",
                     "look up by relative pose");
  }
  return *best;
}

class SimulatedTrainingPairs : public TrainingPairs {
 public:
  SimulatedTrainingPairs(const fs::path& folder, TransferIndex index)
      : dataset_(soundspaces_options(folder, "train")),
        sampler_(dataset_, kCacheBytes),
        index_(index) {
    for (const SoundSpacesClip& clip : dataset_.clips()) add(clip);
    if (entries_.empty()) throw InputError(folder.string(), "holds no training pairs");
  }

  [[nodiscard]] PairSample nearest(const Question& question) const override {
    return sample_of(nearest_of(entries_, question, index_));
  }
  [[nodiscard]] FilterShape shape() const override { return kShape; }

 private:
  using Entry = TrainingPair<SoundSpacesClip, SoundSpacesChoice>;

  void add(const SoundSpacesClip& clip) {
    const int viewpoints = static_cast<int>(clip.viewpoints.size());
    for (std::size_t speaker = 0; speaker < clip.speakers.size(); ++speaker) {
      if (!clip.speakers[speaker].speech) continue;
      for (int source = 0; source < viewpoints; ++source) {
        for (int target = 0; target < viewpoints; ++target) {
          if (source == target) continue;
          SoundSpacesChoice choice;
          choice.source = source;
          choice.target = target;
          choice.speaker = static_cast<int>(speaker);
          entries_.push_back({&clip, choice, features_of(places_of(clip, choice))});
        }
      }
    }
  }

  [[nodiscard]] Places places_of(const SoundSpacesClip& clip,
                                 const SoundSpacesChoice& choice) const {
    const SoundSpacesSpeaker& speaker = clip.speakers[choice.speaker];
    Places places{world_from(clip.viewpoints[choice.source]),
                  world_from(clip.viewpoints[choice.target]), from_soundspaces(speaker.location),
                  speaker.rotation_rad};
    if (index_ == TransferIndex::locations) return places;
    const Pose source_from_world = inverse(places.source);
    if (places.speaker_yaw_rad) {
      *places.speaker_yaw_rad -= clip.viewpoints[choice.source].rotation_rad;
    }
    return {Pose{}, source_from_world * places.target,
            transform_point(source_from_world, places.speaker_m), places.speaker_yaw_rad};
  }

  /// A second of speech, the same in every run.
  [[nodiscard]] PairSample sample_of(const Entry& entry) const {
    SoundSpacesChoice choice = entry.choice;
    const std::ptrdiff_t spare =
        sampler_.speech_samples(entry.clip->speakers[choice.speaker]) - kPairSamples;
    if (spare > 0) {
      RandomStream random(kWindowSeed, {static_cast<std::uint64_t>(&entry - entries_.data())});
      choice.window_start =
          static_cast<std::ptrdiff_t>(random.index(static_cast<std::uint64_t>(spare) + 1));
    }
    return sampler_.sample(*entry.clip, choice);
  }

  SoundSpacesDataset dataset_;
  PairSampler sampler_;
  TransferIndex index_;
  std::vector<Entry> entries_;
};

ReplayDataset training_recordings(const fs::path& folder) {
  try {
    return ReplayDataset(replay_options(folder, "train"));
  } catch (const InputError& error) {
    throw InputError("tf", std::string("looks up in the training split: ") + error.what(),
                     "leave it out, or prepare a session for the split train");
  }
}

/// Pairs of recordings in which the speakers' positions are known.
class RecordedTrainingPairs : public TrainingPairs {
 public:
  RecordedTrainingPairs(const fs::path& folder, TransferIndex index)
      : dataset_(training_recordings(folder)), index_(index) {
    for (const ReplayClip& clip : dataset_.clips()) add(clip);
    if (entries_.empty()) {
      throw InputError(folder.string(),
                       "its training clips have no positions of speakers, which tf needs");
    }
  }

  [[nodiscard]] PairSample nearest(const Question& question) const override {
    const Entry& entry = nearest_of(entries_, question, index_);
    return replay_pair(dataset_, *entry.clip, entry.choice, false);
  }
  [[nodiscard]] FilterShape shape() const override { return kRecordedShape; }

 private:
  using Entry = TrainingPair<ReplayClip, ReplayChoice>;

  void add(const ReplayClip& clip) {
    if (!clip.mouth_m) return;
    std::vector<Pose> cameras;
    for (const std::string& image : clip.images) {
      cameras.push_back(world_from_camera(dataset_.camera(clip.scene, image)));
    }
    for (std::size_t source = 0; source < cameras.size(); ++source) {
      for (std::size_t target = 0; target < cameras.size(); ++target) {
        if (source == target) continue;
        PairSample places;
        places.world_from_source = cameras[source];
        const Pose source_from_world = inverse(cameras[source]);
        places.source_from_target = source_from_world * cameras[target];
        places.speaker_m = transform_point(source_from_world, *clip.mouth_m);
        entries_.push_back({&clip,
                            {static_cast<int>(source), static_cast<int>(target)},
                            features_of(places, index_)});
      }
    }
  }

  ReplayDataset dataset_;
  TransferIndex index_;
  std::vector<Entry> entries_;
};

class TransferFunctionMethod : public Method {
 public:
  explicit TransferFunctionMethod(std::shared_ptr<const TrainingPairs> pairs)
      : pairs_(std::move(pairs)),
        shape_(pairs_->shape()),
        fit_(shape_, 0, kPairSamples, {.regularisation = 1e-3, .steps = 60}) {}

  Waveform render(const Question& question) override {
    const Waveform& source = question.sample.source;
    const PairSample nearest = pairs_->nearest(question);
    Waveform result(kEars, source.samples(), source.sample_rate_hz());
    for (int ear = 0; ear < kEars; ++ear) {
      const std::vector<float> filter =
          fit_.fit(nearest.source.channel(ear), nearest.target.channel(ear));
      const std::vector<float> filtered = convolve(source.channel(ear), filter);
      std::copy_n(filtered.begin() + shape_.before, source.samples(), result.channel(ear).begin());
    }
    return result;
  }

 private:
  std::shared_ptr<const TrainingPairs> pairs_;
  FilterShape shape_;
  FilterFit fit_;
};

}  // namespace

TransferIndex transfer_index_for(const fs::path& folder, DatasetLayout layout,
                                 const std::set<std::string>& scenes) {
  std::set<std::string> trained;
  if (layout == DatasetLayout::replay) {
    const ReplayDataset dataset = training_recordings(folder);
    for (const ReplayClip& clip : dataset.clips()) trained.insert(clip.scene);
  } else {
    const SoundSpacesDataset dataset(soundspaces_options(folder, "train"));
    for (const SoundSpacesClip& clip : dataset.clips()) trained.insert(clip.scene);
  }
  return std::ranges::includes(trained, scenes) ? TransferIndex::locations
                                                : TransferIndex::relative_pose;
}

MethodEntry transfer_function_method(const fs::path& folder, DatasetLayout layout,
                                     TransferIndex index) {
  std::shared_ptr<const TrainingPairs> pairs;
  if (layout == DatasetLayout::replay) {
    pairs = std::make_shared<const RecordedTrainingPairs>(folder, index);
  } else {
    pairs = std::make_shared<const SimulatedTrainingPairs>(folder, index);
  }
  return {.name = "tf",
          .what = index == TransferIndex::locations
                      ? "Wiener filters of the nearest training pair by true locations"
                      : "Wiener filters of the nearest training pair by relative pose",
          .is_oracle = false,
          .make = [pairs] { return std::make_unique<TransferFunctionMethod>(pairs); },
          .needs_speaker = true};
}

}  // namespace earpoint
