#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/evaluate/bootstrap.h>
#include <earpoint/study/answer_store.h>
#include <earpoint/study/study.h>

namespace earpoint {

/// What one participant answered about one clip.
struct StudyTrial {
  int participant = 0;   ///< number
  std::size_t clip = 0;  ///< in Study::clips
  std::string scale;     ///< in the design mushra
  /// By condition: 1 for the one that was chosen and 0 for the others, or the rating.
  std::map<std::string, double> values;
  std::vector<std::string> order;  ///< in which the sounds were shown
  Answer answer;
};

/// A participant, and whether their answers count.
struct StudyParticipant {
  Participant participant;
  std::vector<StudyTrial> trials;
  std::string left_out;  ///< why; empty if they count
};

/// Votes between two sides, and the sign test on them.
struct SignVotes {
  int wins = 0;
  int losses = 0;
  int ties = 0;
  double p = 1.0;
  double power = 0.0;                ///< to find a true share of kPowerShare
  std::optional<double> detectable;  ///< the smallest share found with a power of 0.8
};
inline constexpr double kPowerShare = 0.65;

/// A method against a baseline. A vote over answers takes them all as independent, which they are
/// not; one over participants or clips takes each by what most of its answers say.
struct StudyComparison {
  std::string method;
  std::string baseline;
  std::string scale;
  SignVotes by_answer;
  SignVotes by_participant;
  SignVotes by_clip;
  /// Share of answers for the method among those for either (ties left out), by CrossedBootstrap.
  std::optional<Estimate> preference;
};

/// Share of choices, or mean rating.
struct StudyRow {
  std::string condition;
  std::string scale;
  std::optional<Estimate> value;
  std::optional<Estimate> before_screening;  ///< of all who finished
};

/// People, or the simulated participants of one rule: never both in one number.
struct StudyGroup {
  std::string name;  ///< "people", or "simulated: mag"
  bool is_simulated = false;
  std::vector<StudyParticipant> participants;
  std::size_t counted = 0;  ///< participants
  std::size_t answers = 0;  ///< that count, without controls
  std::vector<StudyRow> rows;
  std::vector<StudyComparison> comparisons;
  /// Share of choices by the place of the sound on the page, from the first on.
  std::vector<double> by_place;
};

/// What a study comes to, people first.
///
/// Answers count of participants who passed the headphone check, finished, and are not left out by
/// the rules of post-screening. After BS.1534-3, 4.1.2, of ratings: who rates the hidden reference
/// below 90 on more than 15 % of the pages, or an anchor's place above 90 on more than 15 % of its
/// pages; pages where more than a quarter of the participants do so are not held against anyone,
/// since the anchor then is hard to tell. Of choices: who misses the reference in more than 15 %
/// of the controls.
///
/// Intervals are those of CrossedBootstrap. Where no answer, or every one, is for a method, draws
/// cannot tell: the interval is then the exact one of as many independent answers as there are
/// participants or clips, whichever are fewer.
[[nodiscard]] std::vector<StudyGroup> study_results(const Study& study, const AnswerStore& store);

}  // namespace earpoint
