#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// Somebody who takes part in a study.
struct Participant {
  std::string id;     ///< 32 hexadecimal digits that nobody can guess
  int number = 0;     ///< from 1, in the order of arrival
  std::string label;  ///< that the study's maker gave; may be empty
  /// How a simulated participant answers, e.g. "mag"; empty for people.
  std::string simulated;
  std::string plan;               ///< JSON: the steps and the order of the sounds
  std::string begun;              ///< UTC, e.g. 2026-01-31T12:00:00Z
  std::string finished;           ///< the same; empty until then
  bool passed_headphones = true;  ///< false once the check has failed
  std::string comment;
};

/// What a participant answered at a step, in one revision.
struct Answer {
  int step = 0;          ///< in the participant's plan
  int revision = 0;      ///< 0, and one more for every change
  std::string content;   ///< JSON
  double seconds = 0.0;  ///< that the participant spent on it
  std::string received;  ///< UTC
};

/// All that participants answer, in a SQLite file. Every call that changes something is on disk
/// when it returns. One object for one thread at a time; other processes may use the file too.
class AnswerStore {
 public:
  /// Opens the file for answers to a study, or makes it.
  /// @param study  the text of its study.json: answers to another study are refused
  /// @throws InputError if it cannot be opened, is no such file, or belongs to another study
  AnswerStore(const std::filesystem::path& file, const std::string& study);
  ~AnswerStore();
  AnswerStore(AnswerStore&&) noexcept;
  AnswerStore& operator=(AnswerStore&&) noexcept;

  /// Only to read; nothing is made.
  /// @throws InputError as above, and if the file is not there
  [[nodiscard]] static AnswerStore open_to_read(const std::filesystem::path& file,
                                                const std::string& study);

  /// Takes somebody in.
  /// @param plan  makes the plan of the participant with that number
  /// @return nothing if somebody of that label, which is not empty, takes part already and has not
  ///         failed the headphone check
  std::optional<Participant> add(const std::string& label, const std::string& simulated,
                                 const std::function<std::string(int number)>& plan);

  [[nodiscard]] std::optional<Participant> find(std::string_view id) const;

  /// In the order of their numbers.
  [[nodiscard]] std::vector<Participant> participants() const;

  /// Stores a revision that is not there yet.
  /// @return false if it is, or if the one before it is not
  bool add_answer(const std::string& participant, int step, int revision,
                  const std::string& content, double seconds);

  /// The last revision of every answer, by step; or all of them.
  [[nodiscard]] std::vector<Answer> answers(const std::string& participant,
                                            bool all_revisions = false) const;

  void fail_headphones(const std::string& participant);
  /// @return false if the participant has finished before
  bool finish(const std::string& participant, const std::string& comment);

 private:
  struct State;
  explicit AnswerStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
