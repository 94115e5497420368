#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// What participants are asked.
enum class StudyDesign {
  choice,  ///< which of three or more unnamed sounds is closest to the reference, as in the paper
  mushra,  ///< ratings of place and of timbre against the reference, after ITU-R BS.1534
};

/// @return "choice" or "mushra"
[[nodiscard]] std::string_view name_of(StudyDesign design);
/// @throws InputError naming design if there is no such design
[[nodiscard]] StudyDesign study_design_named(std::string_view name);

// Sounds that no method made. They are no names of methods.
inline constexpr std::string_view kTruthCondition = "truth";  ///< the reference, hidden
inline constexpr std::string_view kMonoCondition = "mono";    ///< both ears hear the mean of both
inline constexpr std::string_view kSwappedCondition = "swapped";  ///< ears exchanged

/// What is rated of a sound in the design mushra.
inline constexpr std::array<std::string_view, 2> kStudyScales{"place", "timbre"};

struct StudyMethod {
  std::string name;
  std::string what;          ///< for people: the weight file, or a few words
  bool is_baseline = false;  ///< the others are tested against it
};

/// One of the sounds that are compared with the reference.
struct StudySound {
  std::string condition;  ///< a method's name, or one of the three above
  std::string file{};     ///< relative to the study's folder, as all files below
  double gain_db = 0.0;   ///< that it got, loudness matching included
  double mag = 0.0;       ///< BinauralMetrics::mag against the reference, as both are played
};

struct StudyClip {
  std::string id;         ///< within the study
  std::string pair{};     ///< what the evaluation calls it
  std::string scene{};    ///< where it is
  std::string picture{};  ///< PNG: what the target viewpoint sees
  std::string reference{};
  std::vector<StudySound> sounds{};
  /// One of the sounds is the reference: who does not find it did not listen. Counted for
  /// screening alone.
  bool is_control = false;
};

/// Three tones, one of them quieter; of the two others one is in opposite phase at the ears, so
/// that it seems the quietest through loudspeakers.
struct HeadphoneTrial {
  std::string file;
  int quietest = 0;  ///< 0, 1 or 2
};

/// Trials of the headphone check, and how many have to be right.
inline constexpr std::size_t kHeadphoneTrials = 6;
inline constexpr std::size_t kHeadphoneRight = 5;

/// All of a listening study: study.json in its folder. docs/formats.md describes it.
struct Study {
  StudyDesign design = StudyDesign::choice;
  std::string title;
  std::string data;   ///< name of the data set
  std::string split;  ///< of the data set
  std::string pairs;  ///< where the pairs are from
  std::uint64_t seed = 0;
  double duration_s = 0.0;  ///< of every sound
  bool loudness_matched = true;
  std::vector<StudyMethod> methods;
  std::vector<StudyClip> clips;
  StudyClip training;
  std::vector<HeadphoneTrial> headphones;

  /// @return null if there is none; the training clip included
  [[nodiscard]] const StudyClip* find_clip(std::string_view id) const;
};

/// @return the text of study.json
[[nodiscard]] std::string text_of(const Study& study);

/// @param folder  that holds study.json
/// @throws InputError naming file and field if it is missing, malformed, of another version, or
///         names a file that is not there or lies outside of the folder
[[nodiscard]] Study read_study(const std::filesystem::path& folder);

}  // namespace earpoint
