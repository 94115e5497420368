#include <earpoint/study/make_study.h>

#include "headphone_tones.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/loudness.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/atomic_folder.h>
#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr double kFade_s = 0.01;
constexpr double kHighestPeak = 0.89;  // 1 dB below full scale
// In a control, listeners must be able to tell exchanged ears from the reference.
constexpr double kLeastControlDifference_db = 3.0;

double gain_of_db(double db) { return std::pow(10.0, db / 20.0); }

/// The order in which pairs are taken: first one of every conversation, starting with one of every
/// scene; otherwise random by the seed.
std::vector<std::size_t> drawn_order(const StudyMaterial& material, std::uint64_t seed) {
  std::vector<std::size_t> order(material.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  RandomStream random(seed, {0});
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);

  std::map<int, int> of_conversation;
  std::map<std::string, int> of_scene;
  std::vector<std::pair<int, int>> rank(order.size());
  for (const std::size_t pair : order) {
    const int earlier = of_conversation[material.conversation(pair)]++;
    rank[pair] = {earlier, earlier == 0 ? of_scene[material.scene(pair)]++ : 0};
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t pair) { return rank[pair]; });
  return order;
}

struct DrawnClip {
  std::size_t pair = 0;
  StudyClip clip;  ///< its name and kind
};

double ear_difference_db(const Waveform& sound) {
  double energy[2] = {1e-12, 1e-12};
  for (int ear = 0; ear < 2; ++ear) {
    for (const float x : sound.channel(ear)) energy[ear] += static_cast<double>(x) * x;
  }
  return std::abs(10.0 * std::log10(energy[0] / energy[1]));
}

/// Draws clips, controls and the training clip.
class Draw {
 public:
  Draw(const StudyMaterial& material, const StudyRequest& request)
      : material_(material), request_(request), order_(drawn_order(material, request.seed)) {}

  [[nodiscard]] std::vector<DrawnClip> clips() {
    std::vector<DrawnClip> drawn;
    for (std::size_t i = 1; i <= request_.count; ++i) {
      drawn.push_back(take(fmt::format("{:02}", i), 0.0));
    }
    if (request_.design == StudyDesign::choice) {
      for (std::size_t i = 1; i <= request_.controls; ++i) {
        drawn.push_back(take(fmt::format("control-{}", i), kLeastControlDifference_db));
        drawn.back().clip.is_control = true;
      }
    }
    drawn.push_back(take("training", 0.0));
    return drawn;
  }

 private:
  /// The next pair that is long enough, not silent, and differs enough between the ears.
  DrawnClip take(const std::string& id, double least_difference_db) {
    for (auto at = order_.begin(); at != order_.end(); ++at) {
      const std::optional<PairSample> sample = material_.sample(*at);
      if (!sample || !loudness_lkfs(sample->target)) continue;
      if (ear_difference_db(sample->target) < least_difference_db) continue;
      DrawnClip drawn{.pair = *at, .clip = {}};
      drawn.clip.id = id;
      drawn.clip.pair = material_.name(*at);
      drawn.clip.scene = material_.scene(*at);
      order_.erase(at);
      return drawn;
    }
    throw InputError(material_.pairs(),
                     fmt::format("has too few pairs of {:g} s for {} clips, controls and training",
                                 request_.duration_s, request_.count),
                     "use fewer clips, fewer controls or shorter clips");
  }

  const StudyMaterial& material_;
  const StudyRequest& request_;
  std::vector<std::size_t> order_;
};

/// A sound before it is written to the study.
struct Candidate {
  std::string condition;
  Waveform sound;
};

Waveform mono(const Waveform& sound) {
  Waveform result = sound;
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const float mean = 0.5F * (sound.channel(0)[i] + sound.channel(1)[i]);
    result.channel(0)[i] = mean;
    result.channel(1)[i] = mean;
  }
  return result;
}

Waveform swapped(const Waveform& sound) {
  Waveform result = sound;
  std::ranges::copy(sound.channel(0), result.channel(1).begin());
  std::ranges::copy(sound.channel(1), result.channel(0).begin());
  return result;
}

void fade_ends(Waveform& sound) {
  const std::ptrdiff_t fade =
      std::min<std::ptrdiff_t>(std::lround(kFade_s * sound.sample_rate_hz()), sound.samples() / 2);
  for (int c = 0; c < sound.channels(); ++c) {
    for (std::ptrdiff_t i = 0; i < fade; ++i) {
      const double place = (static_cast<double>(i) + 0.5) / static_cast<double>(fade);
      const auto weight = static_cast<float>(0.5 * (1.0 - std::cos(std::numbers::pi * place)));
      sound.channel(c)[i] *= weight;
      sound.channel(c)[sound.samples() - 1 - i] *= weight;
    }
  }
}

double peak_of(const Waveform& sound) {
  double peak = 0.0;
  for (const float x : sound.planar()) peak = std::max(peak, std::abs(static_cast<double>(x)));
  return peak;
}

void scale(Waveform& sound, double gain_db) {
  const auto gain = static_cast<float>(gain_of_db(gain_db));
  for (float& x : sound.planar()) x *= gain;
}

/// The condition as a file name that is valid on any file system.
std::string file_name_of(const std::string& condition) {
  std::string name = condition;
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
    if (!is_plain) c = '-';
  }
  return name;
}

class StudyMaker {
 public:
  StudyMaker(const StudyMaterial& material, std::span<const MethodEntry> methods,
             const StudyRequest& request, fs::path folder)
      : material_(material), methods_(methods), request_(request), folder_(std::move(folder)) {}

  /// @param askers  one of every method
  void finish(DrawnClip& drawn, std::span<const std::unique_ptr<Method>> askers) const {
    const PairSample sample = material_.sample(drawn.pair).value();
    std::vector<Candidate> candidates = candidates_of(drawn, sample, askers);
    Candidate reference{"", sample.target};
    fade_ends(reference.sound);
    for (Candidate& candidate : candidates) fade_ends(candidate.sound);
    const std::vector<double> gains_db = gains(reference.sound, candidates);
    scale(reference.sound, gains_db.back());

    StudyClip& clip = drawn.clip;
    const std::string place = "clips/" + clip.id;
    create_folder(folder_ / place);
    clip.picture = place + "/picture.png";
    write_image(folder_ / clip.picture, *material_.target_picture(drawn.pair));
    clip.reference = place + "/reference.wav";
    write_sound(folder_ / clip.reference, reference.sound, SampleFormat::pcm16);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Candidate& candidate = candidates[i];
      scale(candidate.sound, gains_db[i]);
      const std::string file = fmt::format("{}/{}.wav", place, file_name_of(candidate.condition));
      write_sound(folder_ / file, candidate.sound, SampleFormat::pcm16);
      clip.sounds.push_back({.condition = candidate.condition,
                             .file = file,
                             .gain_db = gains_db[i],
                             .mag = binaural_metrics(reference.sound, candidate.sound).mag});
    }
  }

 private:
  [[nodiscard]] std::vector<Candidate> candidates_of(
      const DrawnClip& drawn, const PairSample& sample,
      std::span<const std::unique_ptr<Method>> askers) const {
    std::vector<Candidate> candidates;
    if (request_.design == StudyDesign::mushra || drawn.clip.is_control) {
      candidates.push_back({std::string(kTruthCondition), sample.target});
      candidates.push_back({std::string(kSwappedCondition), swapped(sample.target)});
      candidates.push_back({std::string(kMonoCondition), mono(sample.target)});
    }
    // A control has as many sounds as the other clips, so that it looks like them.
    if (drawn.clip.is_control) candidates.resize(std::min(candidates.size(), methods_.size()));
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      if (drawn.clip.is_control && candidates.size() == methods_.size()) break;
      candidates.push_back(
          {methods_[m].name, ask(*askers[m], methods_[m], sample, drawn.clip.scene, nullptr)});
    }
    return candidates;
  }

  /// Gains in dB: of every candidate, and last of the reference.
  [[nodiscard]] std::vector<double> gains(const Waveform& reference,
                                          const std::vector<Candidate>& candidates) const {
    const double aim_lkfs = loudness_lkfs(reference).value_or(kStudyLoudnessLkfs);
    std::vector<double> gains_db;
    double peak = peak_of(reference);
    for (const Candidate& candidate : candidates) {
      const std::optional<double> loudness = loudness_lkfs(candidate.sound);
      const bool is_matched = request_.match_loudness && loudness;
      gains_db.push_back(is_matched ? aim_lkfs - *loudness : 0.0);
      peak = std::max(peak, gain_of_db(gains_db.back()) * peak_of(candidate.sound));
    }
    gains_db.push_back(0.0);
    const double common_db =
        std::min(kStudyLoudnessLkfs - aim_lkfs, 20.0 * std::log10(kHighestPeak / peak));
    for (double& gain_db : gains_db) gain_db += common_db;
    return gains_db;
  }

  const StudyMaterial& material_;
  std::span<const MethodEntry> methods_;
  const StudyRequest& request_;
  fs::path folder_;
};

void check_methods(const StudyMaterial& material, std::span<const MethodEntry> methods) {
  if (methods.size() < 2) {
    throw InputError("methods", "a study compares two or more", "name more");
  }
  for (const MethodEntry& method : methods) {
    const std::string where = "methods " + method.name;
    if (method.is_oracle) {
      throw InputError(where, "is an oracle, which is given the target", "leave it out");
    }
    if (method.needs_speaker && !material.knows_speaker()) {
      throw InputError(where, "needs the speaker's position, which these data do not have",
                       "leave it out");
    }
    for (const std::string_view taken : {kTruthCondition, kMonoCondition, kSwappedCondition}) {
      if (method.name == taken) throw InputError(where, "is a reserved name in studies");
    }
  }
}

}  // namespace

Study make_study(const StudyMaterial& material, std::span<const MethodEntry> methods,
                 const StudyRequest& request, const fs::path& folder, ProgressSink& progress) {
  EARPOINT_CHECK(request.count > 0 && request.jobs > 0);
  check_methods(material, methods);
  std::error_code ignored;
  if (fs::exists(folder) && !fs::is_empty(folder, ignored)) {
    throw InputError(folder.string(), "exists and is not empty",
                     "choose another folder: a study with answers must not change");
  }
  std::vector<DrawnClip> drawn = Draw(material, request).clips();

  AtomicFolder made((folder / ".").lexically_normal().parent_path());
  const StudyMaker maker(material, methods, request, made.aside());
  std::vector<std::vector<std::unique_ptr<Method>>> askers(request.jobs);
  for (auto& of_thread : askers) {
    for (const MethodEntry& method : methods) of_thread.push_back(method.make());
  }
  progress.begin("rendering", static_cast<double>(drawn.size()), "clips");
  ThreadPool pool(request.jobs);
  pool.run(std::ssize(drawn), [&](std::ptrdiff_t i, int worker) {
    maker.finish(drawn[i], askers[worker]);
    progress.advance(1.0);
  });
  progress.finish();

  Study study{.design = request.design,
              .title = request.title,
              .data = request.data,
              .split = request.split,
              .pairs = material.pairs(),
              .seed = request.seed,
              .duration_s = request.duration_s,
              .loudness_matched = request.match_loudness,
              .methods = {},
              .clips = {},
              .training = std::move(drawn.back().clip),
              .headphones = write_headphone_trials(made.aside())};
  for (const MethodEntry& method : methods) {
    study.methods.push_back({method.name, method.what, request.baselines.contains(method.name)});
  }
  drawn.pop_back();
  for (DrawnClip& clip : drawn) study.clips.push_back(std::move(clip.clip));
  write_file(made.aside() / "study.json", text_of(study));
  made.commit();
  return study;
}

}  // namespace earpoint
