#include <earpoint/study/study_results.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/study/sign_test.h>
#include <earpoint/study/study_plan.h>

namespace earpoint {
namespace {

// BS.1534-3, 4.1.2.
constexpr double kLeastReferenceRating = 90.0;
constexpr double kMostAnchorRating = 90.0;
constexpr double kMostMisses = 0.15;
constexpr double kHardPage = 0.25;

constexpr double kTail = 0.025;

using Values = std::vector<std::optional<double>>;

StudyTrial trial_of(const Study& study, const Participant& participant, const StudyStep& step,
                    Answer answer) {
  const auto clip = std::ranges::find(study.clips, step.item, &StudyClip::id);
  if (clip == study.clips.end()) throw InputError("answers", "are for clips that do not exist");
  StudyTrial trial{.participant = participant.number,
                   .clip = static_cast<std::size_t>(clip - study.clips.begin()),
                   .scale = step.scale,
                   .values = {},
                   .order = step.order,
                   .answer = std::move(answer)};
  const nlohmann::json content = nlohmann::json::parse(trial.answer.content);
  for (std::size_t i = 0; i < step.order.size(); ++i) {
    trial.values[step.order[i]] = study.design == StudyDesign::choice
                                      ? (content.at("choice") == i ? 1.0 : 0.0)
                                      : content.at("ratings").at(i).get<double>();
  }
  return trial;
}

StudyParticipant read_participant(const Study& study, const AnswerStore& store,
                                  Participant participant) {
  StudyParticipant result{.participant = std::move(participant), .trials = {}, .left_out = {}};
  const std::vector<StudyStep> steps = parse_steps(result.participant.plan);
  for (Answer& answer : store.answers(result.participant.id)) {
    const StudyStep& step = steps.at(static_cast<std::size_t>(answer.step));
    if (step.kind != StudyStep::Kind::trial) continue;
    result.trials.push_back(trial_of(study, result.participant, step, std::move(answer)));
  }
  if (!result.participant.passed_headphones) {
    result.left_out = "failed the headphone check";
  } else if (result.participant.finished.empty()) {
    result.left_out = "did not finish";
  }
  return result;
}

bool is_too_many(int misses, int pages) {
  return pages > 0 && static_cast<double>(misses) > kMostMisses * static_cast<double>(pages);
}

/// Screens a participant by the controls of the choice design.
void screen_by_controls(const Study& study, StudyParticipant& participant) {
  int missed = 0;
  int controls = 0;
  for (const StudyTrial& trial : participant.trials) {
    if (!study.clips[trial.clip].is_control) continue;
    ++controls;
    if (trial.values.at(std::string(kTruthCondition)) == 0.0) ++missed;
  }
  if (!is_too_many(missed, controls)) return;
  participant.left_out = fmt::format("missed the reference in {} of {} controls", missed, controls);
}

bool is_above(const StudyTrial& trial, std::string_view condition, double rating) {
  const auto found = trial.values.find(std::string(condition));
  return found != trial.values.end() && found->second > rating;
}

/// Pages of the place scale on which many participants rate the anchor like the reference.
std::set<std::size_t> hard_clips(std::span<const StudyParticipant> participants,
                                 std::string_view anchor) {
  std::map<std::size_t, std::pair<int, int>> counts;  // rated so, rated
  for (const StudyParticipant& participant : participants) {
    if (!participant.left_out.empty()) continue;
    for (const StudyTrial& trial : participant.trials) {
      if (trial.scale != kStudyScales[0]) continue;
      ++counts[trial.clip].second;
      if (is_above(trial, anchor, kMostAnchorRating)) ++counts[trial.clip].first;
    }
  }
  std::set<std::size_t> hard;
  for (const auto& [clip, count] : counts) {
    if (count.first > kHardPage * count.second) hard.insert(clip);
  }
  return hard;
}

void screen_by_ratings(StudyParticipant& participant,
                       const std::array<std::set<std::size_t>, 2>& hard) {
  constexpr std::array<std::string_view, 2> kAnchors{kMonoCondition, kSwappedCondition};
  int low = 0;
  std::array<int, 2> high{};
  std::array<int, 2> pages{};
  for (const StudyTrial& trial : participant.trials) {
    if (trial.values.at(std::string(kTruthCondition)) < kLeastReferenceRating) ++low;
    if (trial.scale != kStudyScales[0]) continue;
    for (std::size_t a = 0; a < kAnchors.size(); ++a) {
      ++pages[a];
      if (!hard[a].contains(trial.clip) && is_above(trial, kAnchors[a], kMostAnchorRating)) {
        ++high[a];
      }
    }
  }
  const auto all = static_cast<int>(participant.trials.size());
  if (is_too_many(low, all)) {
    participant.left_out = fmt::format("rated the hidden reference below {:g} on {} of {} pages",
                                       kLeastReferenceRating, low, all);
  }
  for (std::size_t a = 0; a < kAnchors.size(); ++a) {
    if (!participant.left_out.empty() || !is_too_many(high[a], pages[a])) continue;
    participant.left_out =
        fmt::format("rated the place of the anchor {} above {:g} on {} of {} pages", kAnchors[a],
                    kMostAnchorRating, high[a], pages[a]);
  }
}

void screen(const Study& study, std::vector<StudyParticipant>& participants) {
  const std::array<std::set<std::size_t>, 2> hard{hard_clips(participants, kMonoCondition),
                                                  hard_clips(participants, kSwappedCondition)};
  for (StudyParticipant& participant : participants) {
    if (!participant.left_out.empty()) continue;
    if (study.design == StudyDesign::choice) {
      screen_by_controls(study, participant);
    } else {
      screen_by_ratings(participant, hard);
    }
  }
}

/// Answers that are counted together.
class AnswerSet {
 public:
  AnswerSet(const Study& study, std::span<const StudyParticipant> participants,
            bool after_screening)
      : design_(study.design) {
    for (const StudyParticipant& participant : participants) {
      const bool is_complete =
          participant.participant.passed_headphones && !participant.participant.finished.empty();
      if (!is_complete || (after_screening && !participant.left_out.empty())) continue;
      for (const StudyTrial& trial : participant.trials) {
        if (study.clips[trial.clip].is_control) continue;
        trials_.push_back(&trial);
        participants_.push_back(trial.participant);
        clips_.push_back(static_cast<int>(trial.clip));
      }
    }
  }

  [[nodiscard]] std::span<const StudyTrial* const> trials() const { return trials_; }

  [[nodiscard]] std::optional<Estimate> mean(const std::string& scale,
                                             const std::string& condition) const {
    Values values;
    for (const StudyTrial* trial : trials_) {
      const auto found = trial->values.find(condition);
      const bool counts = trial->scale == scale && found != trial->values.end();
      values.push_back(counts ? std::optional(found->second) : std::nullopt);
    }
    std::optional<Estimate> estimate = CrossedBootstrap(participants_, clips_).mean(values);
    if (design_ == StudyDesign::choice) widen_if_unanimous(values, estimate);
    return estimate;
  }

  [[nodiscard]] StudyComparison compare(const std::string& scale, const std::string& method,
                                        const std::string& baseline) const {
    StudyComparison result{.method = method,
                           .baseline = baseline,
                           .scale = scale,
                           .by_answer = {},
                           .by_participant = {},
                           .by_clip = {},
                           .preference = std::nullopt};
    std::vector<int> answers;
    std::map<int, int> of_participant;
    std::map<int, int> of_clip;
    Values values;
    for (std::size_t i = 0; i < trials_.size(); ++i) {
      const StudyTrial& trial = *trials_[i];
      values.emplace_back();
      if (trial.scale != scale) continue;
      const double difference = trial.values.at(method) - trial.values.at(baseline);
      const int sign = difference > 0.0 ? 1 : difference < 0.0 ? -1 : 0;
      answers.push_back(sign);
      of_participant[participants_[i]] += sign;
      of_clip[clips_[i]] += sign;
      if (sign != 0) values.back() = sign > 0 ? 1.0 : 0.0;
    }
    result.by_answer = votes(answers);
    result.by_participant = votes(totals(of_participant));
    result.by_clip = votes(totals(of_clip));
    result.preference = CrossedBootstrap(participants_, clips_).mean(values);
    widen_if_unanimous(values, result.preference);
    return result;
  }

 private:
  static std::vector<int> totals(const std::map<int, int>& groups) {
    std::vector<int> result;
    result.reserve(groups.size());
    for (const auto& [group, total] : groups) result.push_back(total);
    return result;
  }

  static SignVotes votes(const std::vector<int>& signs) {
    SignVotes result;
    for (const int sign : signs) {
      ++(sign > 0 ? result.wins : sign < 0 ? result.losses : result.ties);
    }
    const int decided = result.wins + result.losses;
    result.p = sign_test_p(result.wins, result.losses);
    result.power = sign_test_power(decided, kPowerShare);
    result.detectable = detectable_share(decided);
    return result;
  }

  /// Clopper and Pearson's interval where all answers agree.
  void widen_if_unanimous(const Values& values, std::optional<Estimate>& estimate) const {
    if (!estimate || !estimate->range) return;
    if (estimate->value > 0.0 && estimate->value < 1.0) return;
    std::set<int> participants;
    std::set<int> clips;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!values[i]) continue;
      participants.insert(participants_[i]);
      clips.insert(clips_[i]);
    }
    const auto independent = static_cast<double>(std::min(participants.size(), clips.size()));
    const double width = 1.0 - std::pow(kTail, 1.0 / independent);
    estimate->range =
        estimate->value == 0.0 ? ConfidenceRange{0.0, width} : ConfidenceRange{1.0 - width, 1.0};
  }

  StudyDesign design_;
  std::vector<const StudyTrial*> trials_;
  std::vector<int> participants_;
  std::vector<int> clips_;
};

std::vector<double> shares_by_place(const Study& study, const AnswerSet& answers) {
  if (study.design != StudyDesign::choice) return {};
  std::vector<double> shares(study.methods.size(), 0.0);
  for (const StudyTrial* trial : answers.trials()) {
    for (std::size_t place = 0; place < trial->order.size(); ++place) {
      if (place < shares.size()) shares[place] += trial->values.at(trial->order[place]);
    }
  }
  for (double& share : shares) {
    share /= static_cast<double>(std::max<std::size_t>(1, answers.trials().size()));
  }
  return shares;
}

void count(const Study& study, StudyGroup& group) {
  screen(study, group.participants);
  group.counted = static_cast<std::size_t>(std::ranges::count_if(
      group.participants, [](const auto& participant) { return participant.left_out.empty(); }));
  const AnswerSet counted(study, group.participants, true);
  const AnswerSet all(study, group.participants, false);
  group.answers = counted.trials().size();
  group.by_place = shares_by_place(study, counted);

  std::vector<std::string> conditions;
  for (const StudyMethod& method : study.methods) conditions.push_back(method.name);
  std::vector<std::string> scales{""};
  if (study.design == StudyDesign::mushra) {
    for (const auto condition : {kMonoCondition, kSwappedCondition, kTruthCondition}) {
      conditions.emplace_back(condition);
    }
    scales.assign(kStudyScales.begin(), kStudyScales.end());
  }
  for (const std::string& scale : scales) {
    for (const std::string& condition : conditions) {
      group.rows.push_back({.condition = condition,
                            .scale = scale,
                            .value = counted.mean(scale, condition),
                            .before_screening = all.mean(scale, condition)});
    }
    for (const StudyMethod& method : study.methods) {
      for (const StudyMethod& baseline : study.methods) {
        if (method.is_baseline || !baseline.is_baseline || group.answers == 0) continue;
        group.comparisons.push_back(counted.compare(scale, method.name, baseline.name));
      }
    }
  }
}

}  // namespace

std::vector<StudyGroup> study_results(const Study& study, const AnswerStore& store) {
  std::map<std::string, StudyGroup> groups;  // by rule; people have none
  for (Participant& participant : store.participants()) {
    const std::string rule = participant.simulated;
    StudyGroup& group = groups[rule];
    group.is_simulated = !rule.empty();
    group.name = group.is_simulated ? "simulated: " + rule : "people";
    group.participants.push_back(read_participant(study, store, std::move(participant)));
  }
  std::vector<StudyGroup> result;
  for (auto& [rule, group] : groups) {
    count(study, group);
    result.push_back(std::move(group));
  }
  return result;
}

}  // namespace earpoint
