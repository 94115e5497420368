#include <earpoint/study/study_desk.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using nlohmann::json;
using Kind = StudyStep::Kind;

constexpr std::size_t kMostLabel = 64;
constexpr std::size_t kMostComment = 2000;
constexpr double kMostSeconds = 1e6;
constexpr std::size_t kMostRevisions = 1000;

DeskReply reply(const json& body, int status = 200) {
  return {status, body.dump(-1, ' ', false, json::error_handler_t::replace)};
}

DeskReply refusal(int status, const std::string& why) { return reply({{"error", why}}, status); }

DeskReply unknown_participant() {
  return refusal(404, "this participant is not known here; start again");
}

/// @throws InputError if it is no object
json parse_object(const std::string& body) {
  json document = body.empty() ? json::object() : json::parse(body, nullptr, false);
  if (!document.is_object()) throw InputError("request", "is not a JSON object");
  return document;
}

/// @throws InputError naming the field
std::string text_of(const json& document, const char* key, std::size_t most) {
  const auto found = document.find(key);
  if (found == document.end()) return {};
  if (!found->is_string()) throw InputError(key, "is not a text");
  std::string text = found->get<std::string>();
  if (text.size() > most) throw InputError(key, fmt::format("is longer than {} bytes", most));
  return text;
}

/// A whole number. @throws InputError naming the field
int index_of(const json& document, const char* key, std::size_t count) {
  const auto found = document.find(key);
  if (found == document.end() || !found->is_number_unsigned() ||
      found->get<std::uint64_t>() >= count) {
    throw InputError(key, fmt::format("is not a whole number from 0 to {}", count - 1));
  }
  return found->get<int>();
}

double seconds_of(const json& document) {
  const auto found = document.find("seconds");
  if (found == document.end()) return 0.0;
  if (!found->is_number() || !(found->get<double>() >= 0.0) ||
      found->get<double>() > kMostSeconds) {
    throw InputError("seconds", "is no such time");
  }
  return found->get<double>();
}

std::vector<double> ratings_of(const json& document, std::size_t count) {
  const auto found = document.find("ratings");
  const bool is_list = found != document.end() && found->is_array() && found->size() == count;
  if (!is_list || !std::ranges::all_of(*found, [](const json& rating) {
        return rating.is_number() && rating.get<double>() >= 0.0 && rating.get<double>() <= 100.0;
      })) {
    throw InputError("ratings", fmt::format("are not {} numbers from 0 to 100", count));
  }
  return found->get<std::vector<double>>();
}

/// An answer, as it is stored.
struct GivenAnswer {
  int revision = 0;
  json content;
  double seconds = 0.0;
};

/// @throws InputError naming the field
GivenAnswer parse_answer(const json& request, const StudyStep& step, StudyDesign design) {
  GivenAnswer given;
  given.revision = index_of(request, "revision", kMostRevisions);
  given.seconds = seconds_of(request);
  if (step.kind == Kind::headphones) {
    given.content["choice"] = index_of(request, "choice", 3);
  } else if (design == StudyDesign::choice) {
    const int choice = index_of(request, "choice", step.order.size());
    given.content["choice"] = choice;
    given.content["condition"] = step.order[choice];
  } else {
    given.content["ratings"] = ratings_of(request, step.order.size());
    given.content["conditions"] = step.order;
  }
  return given;
}

}  // namespace

/// A participant and their progress.
struct StudyDesk::Seat {
  Participant participant;
  std::vector<StudyStep> steps;
  std::vector<Answer> answers;  ///< of the first steps, as many as there are

  [[nodiscard]] std::size_t at() const { return answers.size(); }
};

StudyDesk::StudyDesk(std::filesystem::path folder)
    : folder_(std::move(folder)),
      study_(read_study(folder_)),
      store_(folder_ / kAnswersFile, read_text_file(folder_ / "study.json")) {}

DeskReply StudyDesk::study() const {
  return reply({{"title", study_.title},
                {"design", name_of(study_.design)},
                {"clips", study_.clips.size()},
                {"duration_s", study_.duration_s},
                {"headphone_trials", kHeadphoneTrials}});
}

DeskReply StudyDesk::join(const std::string& body) {
  const std::lock_guard lock(mutex_);
  std::string label;
  std::string simulated;
  try {
    const json request = parse_object(body);
    label = text_of(request, "label", kMostLabel);
    simulated = text_of(request, "simulated", kMostLabel);
  } catch (const InputError& error) {
    return refusal(400, error.what());
  }
  const auto participant =
      store_.add(label, simulated, [&](int number) { return text_of(plan_steps(study_, number)); });
  if (!participant) return refusal(409, fmt::format("{} has taken part already", label));
  return reply({{"participant", participant->id}});
}

std::optional<StudyDesk::Seat> StudyDesk::seat_of(const std::string& participant) {
  std::optional<Participant> found = store_.find(participant);
  if (!found) return std::nullopt;
  Seat seat{.participant = std::move(*found), .steps = {}, .answers = {}};
  seat.steps = parse_steps(seat.participant.plan);
  seat.answers = store_.answers(participant);
  return seat;
}

DeskReply StudyDesk::state(const std::string& participant) {
  const std::lock_guard lock(mutex_);
  const std::optional<Seat> seat = seat_of(participant);
  if (!seat) return unknown_participant();
  json steps = json::array();
  for (std::size_t i = 0; i < seat->steps.size(); ++i) {
    const StudyStep& step = seat->steps[i];
    json shown{{"kind", name_of(step.kind)}, {"scale", step.scale}, {"sounds", step.order.size()}};
    if (i < seat->at()) {
      const json content = json::parse(seat->answers[i].content);
      shown["revision"] = seat->answers[i].revision;
      for (const char* key : {"choice", "ratings"}) {
        if (content.contains(key)) shown[key] = content[key];
      }
    }
    steps.push_back(std::move(shown));
  }
  return reply({{"design", name_of(study_.design)},
                {"title", study_.title},
                {"number", seat->participant.number},
                {"simulated", seat->participant.simulated},
                {"passed_headphones", seat->participant.passed_headphones},
                {"finished", !seat->participant.finished.empty()},
                {"at", seat->at()},
                {"steps", std::move(steps)}});
}

DeskReply StudyDesk::answer(const std::string& participant, std::size_t step_number,
                            const std::string& body) {
  const std::lock_guard lock(mutex_);
  std::optional<Seat> seat = seat_of(participant);
  if (!seat) return unknown_participant();
  if (step_number >= seat->steps.size()) return refusal(404, "there is no such step");
  if (!seat->participant.passed_headphones) return refusal(409, "the headphone check has failed");
  if (!seat->participant.finished.empty()) return refusal(409, "the study is finished");
  if (step_number > seat->at()) return refusal(409, "the step before is not answered yet");
  const StudyStep& step = seat->steps[step_number];
  GivenAnswer given;
  try {
    given = parse_answer(parse_object(body), step, study_.design);
  } catch (const InputError& error) {
    return refusal(400, error.what());
  }
  const bool is_check = step.kind == Kind::headphones;
  if (is_check && given.revision > 0) return refusal(409, "this answer is final");
  const bool is_new = store_.add_answer(participant, static_cast<int>(step_number), given.revision,
                                        given.content.dump(), given.seconds);
  if (!is_new) return refusal(409, "this answer is there already");
  seat = seat_of(participant);
  if (is_check) seat->participant.passed_headphones = judge_headphones(*seat);
  return reply({{"at", seat->at()}, {"passed_headphones", seat->participant.passed_headphones}});
}

bool StudyDesk::judge_headphones(const Seat& seat) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < kHeadphoneTrials; ++i) {
    if (i >= seat.at()) return true;  // not yet decided
    const std::size_t trial = std::stoul(seat.steps[i].item);
    const json content = json::parse(seat.answers[i].content);
    if (content.at("choice") == study_.headphones.at(trial).quietest) ++right;
  }
  if (right >= kHeadphoneRight) return true;
  store_.fail_headphones(seat.participant.id);
  return false;
}

DeskReply StudyDesk::finish(const std::string& participant, const std::string& body) {
  const std::lock_guard lock(mutex_);
  const std::optional<Seat> seat = seat_of(participant);
  if (!seat) return unknown_participant();
  if (seat->at() < seat->steps.size()) return refusal(409, "steps are left");
  std::string comment;
  try {
    comment = text_of(parse_object(body), "comment", kMostComment);
  } catch (const InputError& error) {
    return refusal(400, error.what());
  }
  if (!store_.finish(participant, comment)) return refusal(409, "the study is finished");
  return reply({{"finished", true}});
}

std::optional<std::filesystem::path> StudyDesk::sound_file(const std::string& participant,
                                                           std::size_t step_number,
                                                           const std::string& sound) {
  const std::lock_guard lock(mutex_);
  const std::optional<Seat> seat = seat_of(participant);
  if (!seat || step_number >= seat->steps.size()) return std::nullopt;
  const StudyStep& step = seat->steps[step_number];
  if (step.kind == Kind::headphones) {
    return folder_ / study_.headphones.at(std::stoul(step.item)).file;
  }
  const StudyClip* clip = study_.find_clip(step.item);
  if (clip == nullptr) return std::nullopt;
  if (sound == "reference") return folder_ / clip->reference;
  std::size_t shown = 0;
  const char* end = sound.data() + sound.size();
  const auto [rest, error] = std::from_chars(sound.data(), end, shown);
  if (error != std::errc() || rest != end || shown >= step.order.size()) return std::nullopt;
  const auto found = std::ranges::find(clip->sounds, step.order[shown], &StudySound::condition);
  if (found == clip->sounds.end()) return std::nullopt;
  return folder_ / found->file;
}

std::optional<std::filesystem::path> StudyDesk::picture_file(const std::string& participant,
                                                             std::size_t step_number) {
  const std::lock_guard lock(mutex_);
  const std::optional<Seat> seat = seat_of(participant);
  if (!seat || step_number >= seat->steps.size()) return std::nullopt;
  const StudyClip* clip = study_.find_clip(seat->steps[step_number].item);
  if (clip == nullptr) return std::nullopt;
  return folder_ / clip->picture;
}

}  // namespace earpoint
