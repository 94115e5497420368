#pragma once

#include <span>
#include <string>

#include <earpoint/study/study.h>
#include <earpoint/study/study_results.h>

namespace earpoint {

/// The report's page, HTML: the table, comparisons, who was left out.
[[nodiscard]] std::string study_page(const Study& study, std::span<const StudyGroup> groups);

}  // namespace earpoint
