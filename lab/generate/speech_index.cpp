#include "speech_index.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <earpoint/core/csv.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The lines of a text with their numbers; empty ones are left out.
std::vector<std::pair<int, std::string_view>> lines_of(std::string_view text) {
  std::vector<std::pair<int, std::string_view>> lines;
  int number = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (!line.empty()) lines.emplace_back(number, line);
  }
  return lines;
}

/// The cells of a line; a separator within "..." is part of a cell, "" there is one quote.
std::vector<std::string> csv_cells(std::string_view line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += c;
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = std::string(trimmed(cell));
  return cells;
}

/// Parts of ids have only letters, digits and '_'; '-' separates them.
std::string id_part(std::string_view name) {
  std::string part;
  for (const char c : name) {
    part += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ? c : '_';
  }
  return part;
}

std::optional<Gender> gender_of(std::string_view text) {
  if (text == "F" || text == "f") return Gender::female;
  if (text == "M" || text == "m") return Gender::male;
  return gender_named(text);
}

/// Collects recordings under their speakers.
class SpeakerTable {
 public:
  explicit SpeakerTable(const fs::path& index) : index_(index) {}

  [[nodiscard]] std::string where(int line) const {
    return fmt::format("{}, line {}", index_.string(), line);
  }

  SpeechSpeaker& speaker(int line, const std::string& name, Gender gender, DataSplit split) {
    const auto [entry, is_new] = speakers_.try_emplace(name);
    SpeechSpeaker& speaker = entry->second;
    if (is_new) {
      speaker.name = name;
      speaker.gender = gender;
      speaker.split = split;
      const auto [taken, is_free] = by_part_.try_emplace(id_part(name), name);
      if (!is_free) {
        throw InputError(where(line),
                         fmt::format("the speakers '{}' and '{}' differ only in punctuation",
                                     taken->second, name),
                         "rename one of them");
      }
    }
    if (speaker.gender != gender || speaker.split != split) {
      throw InputError(where(line),
                       "the speaker '" + name + "' had another gender or split before");
    }
    return speaker;
  }

  [[nodiscard]] std::vector<SpeechSpeaker> take() {
    std::vector<SpeechSpeaker> result;
    for (auto& [name, speaker] : speakers_) {
      if (speaker.recordings.empty()) continue;
      std::sort(speaker.recordings.begin(), speaker.recordings.end(),
                [](const auto& a, const auto& b) { return a.id < b.id; });
      result.push_back(std::move(speaker));
    }
    return result;
  }

 private:
  fs::path index_;
  std::map<std::string, SpeechSpeaker> speakers_;
  std::map<std::string, std::string> by_part_;
};

void add_csv_row(SpeakerTable& table, int line, const fs::path& folder,
                 const std::vector<std::string>& cells) {
  const std::optional<Gender> gender = gender_of(cells[2]);
  if (!gender) {
    throw InputError(table.where(line), "expected female or male, found '" + cells[2] + "'");
  }
  const auto split = cells.size() < 4 ? DataSplit::train : data_split_named(cells[3]);
  if (!split) {
    throw InputError(table.where(line), "expected train, val or test, found '" + cells[3] + "'");
  }
  if (cells[1].empty()) throw InputError(table.where(line), "the speaker has no name");
  const fs::path path = folder / cells[0];
  if (!fs::is_regular_file(path)) {
    throw InputError(table.where(line), "'" + cells[0] + "' does not exist");
  }
  SpeechSpeaker& speaker = table.speaker(line, cells[1], *gender, *split);
  speaker.recordings.push_back(
      {fmt::format("{}-0-{:05}", id_part(cells[1]), speaker.recordings.size()), path});
}

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    entries.push_back(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

void add_reader(SpeechSpeaker& speaker, const fs::path& folder) {
  for (const fs::path& chapter : sorted_entries(folder)) {
    if (!fs::is_directory(chapter)) continue;
    for (const fs::path& file : sorted_entries(chapter)) {
      if (file.extension() != ".flac" && file.extension() != ".wav") continue;
      speaker.recordings.push_back({file.stem().string(), file});
    }
  }
}

}  // namespace

SpeechIndex read_speech_csv(const fs::path& path) {
  const std::string text = read_text_file(path);
  SpeakerTable table(path);
  std::size_t columns = 0;
  char separator = ',';
  for (const auto& [line, content] : lines_of(without_byte_order_mark(text, path.string()))) {
    if (content.starts_with('#')) continue;
    if (columns == 0) separator = csv_separator(content);
    const std::vector<std::string> cells = csv_cells(content, separator);
    if (columns == 0) {
      columns = cells.size();
      const std::vector<std::string> names = {"file", "speaker", "gender", "split"};
      if (columns < 3 || columns > 4 || !std::equal(cells.begin(), cells.end(), names.begin())) {
        throw InputError(table.where(line), "expected the columns file,speaker,gender[,split]");
      }
      continue;
    }
    if (cells.size() != columns) {
      throw InputError(table.where(line),
                       fmt::format("expected {} cells, found {}", columns, cells.size()));
    }
    add_csv_row(table, line, path.parent_path(), cells);
  }
  return {.speakers = table.take(), .has_splits = columns == 4};
}

SpeechIndex read_librispeech(const fs::path& folder) {
  const fs::path index = folder / "SPEAKERS.TXT";
  const std::string text = read_text_file(index);
  SpeakerTable table(index);
  for (const auto& [line, content] : lines_of(text)) {
    if (content.starts_with(';')) continue;
    // ID | SEX | SUBSET | MINUTES | NAME
    std::vector<std::string> cells;
    std::string_view rest = content;
    for (int cell = 0; cell < 3; ++cell) {
      const auto end = rest.find('|');
      if (end == std::string_view::npos) {
        throw InputError(table.where(line), "expected reader | sex | subset | minutes | name");
      }
      cells.emplace_back(trimmed(rest.substr(0, end)));
      rest.remove_prefix(end + 1);
    }
    const fs::path reader = folder / cells[2] / cells[0];
    if (!fs::is_directory(reader)) continue;  // a subset that is not installed
    const std::optional<Gender> gender = gender_of(cells[1]);
    if (!gender) throw InputError(table.where(line), "expected F or M, found '" + cells[1] + "'");
    const DataSplit split = cells[2].starts_with("train") ? DataSplit::train
                            : cells[2].starts_with("dev") ? DataSplit::val
                                                          : DataSplit::test;
    add_reader(table.speaker(line, cells[0], *gender, split), reader);
  }
  SpeechIndex result{.speakers = table.take(), .has_splits = false};
  result.has_splits = std::any_of(
      result.speakers.begin(), result.speakers.end(),
      [&](const auto& speaker) { return speaker.split != result.speakers.front().split; });
  return result;
}

}  // namespace earpoint
