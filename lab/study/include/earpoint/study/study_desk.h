#pragma once

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/study/answer_store.h>
#include <earpoint/study/study.h>
#include <earpoint/study/study_plan.h>

namespace earpoint {

/// The file of a study's folder that holds its answers.
inline constexpr const char* kAnswersFile = "answers.sqlite";

/// An answer to a participant's page: an HTTP status and JSON. Refusals are {"error": why}.
struct DeskReply {
  int status = 200;
  std::string body;
};

/// Takes participants through a study and stores what they answer. No reply tells which sound is
/// of which method, or what is right in the headphone check. Any thread may call it.
class StudyDesk {
 public:
  /// @throws InputError as read_study() and AnswerStore
  explicit StudyDesk(std::filesystem::path folder);

  /// What the study is about.
  [[nodiscard]] DeskReply study() const;

  /// Takes somebody in: {"label", "simulated"}, both optional texts. Replies {"participant": id};
  /// 409 if the label has taken part.
  DeskReply join(const std::string& body);

  /// The steps, what was answered, and at which step the participant is.
  DeskReply state(const std::string& participant);

  /// An answer: {"revision", "choice" or "ratings", "seconds"}. Choices and ratings are by the
  /// order in which sounds are shown. Answers come in the order of steps; those of the headphone
  /// check are final, the others may be changed, each change by the next revision. 409 if the
  /// answer is there already, as when it is sent twice.
  DeskReply answer(const std::string& participant, std::size_t step, const std::string& body);

  /// After the last step: {"comment"}, optional. 409 the second time.
  DeskReply finish(const std::string& participant, const std::string& body);

  /// @param sound  "reference", or a number by the order shown
  /// @return nothing if there is no such participant, step or sound
  [[nodiscard]] std::optional<std::filesystem::path> sound_file(const std::string& participant,
                                                                std::size_t step,
                                                                const std::string& sound);
  [[nodiscard]] std::optional<std::filesystem::path> picture_file(const std::string& participant,
                                                                  std::size_t step);

 private:
  struct Seat;
  /// @return nothing if there is no such participant
  std::optional<Seat> seat_of(const std::string& participant);
  /// @return false if the participant has failed, which is stored then
  bool judge_headphones(const Seat& seat);

  std::filesystem::path folder_;
  Study study_;
  std::mutex mutex_;
  AnswerStore store_;
};

}  // namespace earpoint
