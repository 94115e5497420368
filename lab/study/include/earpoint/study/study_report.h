#pragma once

#include <filesystem>
#include <span>
#include <string>

#include <earpoint/study/study.h>
#include <earpoint/study/study_results.h>

namespace earpoint {

/// Tables for people.
[[nodiscard]] std::string text_of(const Study& study, std::span<const StudyGroup> groups);

/// One JSON object; docs/formats.md describes it.
[[nodiscard]] std::string json_of(const Study& study, std::span<const StudyGroup> groups);

/// All answers to clips, one sound a line, those that do not count included.
[[nodiscard]] std::string answers_csv(const Study& study, std::span<const StudyGroup> groups);

/// Writes index.html, with a table like the paper's table 4, answers.csv and results.json.
/// @param folder  is made if it is not there
/// @throws InputError if it cannot be written
void write_study_report(const std::filesystem::path& folder, const Study& study,
                        std::span<const StudyGroup> groups);

}  // namespace earpoint
